//! Worlds as layers of a Web Map Tile Service (OGC 07-057r7, version 1.0.0, tiles by address): what GIS programs list and choose from.

use super::{shelf::Shelved, worlds::Live};
use crate::{
    geometry::{Grid, MAX_LATITUDE},
    tile::Tileset,
};
use quick_xml::escape::escape;
use std::sync::Arc;

/// The tilesets that GIS programs show as they are, or read heights from.
const TILESETS: [Tileset; 5] = [Tileset::Relief, Tileset::Hillshade, Tileset::Slope, Tileset::Terrarium, Tileset::TerrainRgb];

/// Levels of the tile matrix set; GDAL and QGIS count columns in 32 bits.
const LEVELS: u8 = 25;

/// Metres of a pixel on the screen that scales are counted in.
const SCREEN_PIXEL: f64 = 0.00028;

/// Pixels a side of a tile.
const PIXELS: f64 = 256.0;

/// The capabilities of a service whose tiles are found under a URL.
pub(super) fn capabilities<'a>(url: &str, worlds: impl Iterator<Item = &'a Arc<Live>>) -> String {
    let layers: String = worlds.flat_map(|live| TILESETS.map(|tileset| layer(url, live, tileset))).collect();
    let levels: String = (0..LEVELS).map(level).collect();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<Capabilities xmlns="http://www.opengis.net/wmts/1.0" xmlns:ows="http://www.opengis.net/ows/1.1" xmlns:xlink="http://www.w3.org/1999/xlink" version="1.0.0">
<ows:ServiceIdentification><ows:Title>Terrane</ows:Title><ows:ServiceType>OGC WMTS</ows:ServiceType><ows:ServiceTypeVersion>1.0.0</ows:ServiceTypeVersion></ows:ServiceIdentification>
<Contents>
{layers}<TileMatrixSet><ows:Identifier>WebMercatorQuad</ows:Identifier><ows:SupportedCRS>urn:ogc:def:crs:EPSG::3857</ows:SupportedCRS><WellKnownScaleSet>urn:ogc:def:wkss:OGC:1.0:GoogleMapsCompatible</WellKnownScaleSet>
{levels}</TileMatrixSet>
</Contents>
<ServiceMetadataURL xlink:href="{}/wmts"/>
</Capabilities>
"#,
        escape(url)
    )
}

fn layer(url: &str, live: &Live, tileset: Tileset) -> String {
    let (title, what, name) = (escape(live.title()), tileset.name(), live.name());
    let description = live.document().description.as_deref().map(|text| format!("<ows:Abstract>{}</ows:Abstract>", escape(text)));
    format!(
        r#"<Layer><ows:Title>{title}: {what}</ows:Title>{}<ows:WGS84BoundingBox><ows:LowerCorner>-180 -{MAX_LATITUDE}</ows:LowerCorner><ows:UpperCorner>180 {MAX_LATITUDE}</ows:UpperCorner></ows:WGS84BoundingBox><ows:Identifier>{name}-{what}</ows:Identifier><Style isDefault="true"><ows:Identifier>default</ows:Identifier></Style><Format>image/png</Format><TileMatrixSetLink><TileMatrixSet>WebMercatorQuad</TileMatrixSet></TileMatrixSetLink><ResourceURL format="image/png" resourceType="tile" template="{}/worlds/{name}/web/{what}/{{TileMatrix}}/{{TileCol}}/{{TileRow}}.png"/></Layer>
"#,
        description.unwrap_or_default(),
        escape(url)
    )
}

fn level(z: u8) -> String {
    let side = Grid::Web.tile_side(z);
    let (scale, corner, count) = (side / PIXELS / SCREEN_PIXEL, Grid::Web.tile_side(0) / 2.0, 1_u64 << z);
    format!(
        "<TileMatrix><ows:Identifier>{z}</ows:Identifier><ScaleDenominator>{scale}</ScaleDenominator><TopLeftCorner>-{corner} {corner}</TopLeftCorner><TileWidth>{PIXELS}</TileWidth><TileHeight>{PIXELS}</TileHeight><MatrixWidth>{count}</MatrixWidth><MatrixHeight>{count}</MatrixHeight></TileMatrix>\n"
    )
}
