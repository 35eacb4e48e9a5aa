//! What Cesium needs to know of meshes.

use crate::{
    geometry::{Grid, MAX_LATITUDE, Source},
    server::{
        address::GlobePath,
        error::ApiError,
        extract::{Known, Links, WorldAt},
        headers::{Freshness, json},
        schema::ProblemDetails,
        shelf::Shelved,
        vocabulary::{GlobeGridName, SurfaceName},
    },
    tile::{Height, Image, MAX_MESH_ZOOM, MeshExtensions, Rounding, Tileset, mesh_step, mesh_tolerance},
};
use axum::{http::HeaderMap, response::Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

/// Which meshes are described.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct LayerQuery {
    /// Present, with any value or none: plain URLs whose tiles change with the world, for editing.
    #[param(value_type = Option<String>, allow_reserved = false)]
    live: Option<String>,
    /// `ground` (default) or `water`: the surface that the meshes show.
    #[param(value_type = Option<SurfaceName>, inline)]
    surface: Option<String>,
}

/// A rectangle of tiles, rows counted from the south.
#[derive(Serialize, ToSchema)]
#[serde(rename_all = "camelCase")]
struct TileRange {
    start_x: i64,
    start_y: i64,
    end_x: i64,
    end_y: i64,
}

/// `layer.json` of a quantized-mesh tileset.
#[derive(Serialize, ToSchema)]
#[serde(rename_all = "camelCase")]
#[schema(as = Layers)]
struct LayerSchema {
    tilejson: &'static str,
    name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    description: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    attribution: Option<String>,
    version: &'static str,
    format: &'static str,
    /// `tms`: rows count from the south.
    scheme: &'static str,
    /// `EPSG:4326` of `geo`, `EPSG:3857` of `web`.
    projection: &'static str,
    /// One absolute URL template.
    tiles: [String; 1],
    /// What meshes hold when it is asked for. `metadata`, which they hold too, is left out: it would only say again what `available` does, and with it clients look for
    /// `metadataAvailability` instead.
    extensions: [&'static str; 2],
    minzoom: u8,
    maxzoom: u8,
    /// Degrees: west, south, east, north.
    bounds: [f64; 4],
    /// By level: everything.
    available: Vec<[TileRange; 1]>,
    /// Metres that a mesh of level 0 may miss samples by, before its heights are rounded; half of it at each level further.
    level_zero_tolerance: f64,
    /// Metres that heights on edges are rounded to, in all tiles of the world; inside they are rounded to as much or less.
    edge_step: f64,
}

/// The meshes of a world for Cesium and the engines that read its formats.
#[utoipa::path(get, path = "/worlds/{world}/{grid}/quantized-mesh/layer.json", tag = "tiles", params(
    ("world" = String, Path, description = "`name` or `name@revision`"),
    ("grid" = inline(GlobeGridName), Path, description = "`geo` or `web`"),
    LayerQuery,
), responses(
    (status = 200, description = "What Cesium's terrain provider reads", body = LayerSchema),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world, or a grid that is not on the globe", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_layer(
    WorldAt { live, .. }: WorldAt,
    GlobePath(grid): GlobePath,
    Known(query): Known<LayerQuery>,
    links: Links,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (surface, height) = match query.surface.as_deref() {
        None | Some("ground") => ("", Height::Ground),
        Some("water") => ("?surface=water", Height::Water),
        Some(other) => return Err(ApiError::parameter("surface", format!("must be ground or water, got {other:?}"))),
    };
    let [normals, water_mask, _] = MeshExtensions::NAMES;
    let (document, is_geo) = (live.world.document(), grid == Grid::Geo);
    let template = super::tile::template(&live, grid.name(), Tileset::QuantizedMesh, (Image::Png, Rounding::Steps), query.live.is_some());
    let all = |z| grid.size(z).map(|size| size - 1);
    let available = (0..=MAX_MESH_ZOOM).map(|z| [TileRange { start_x: 0, start_y: 0, end_x: all(z)[0], end_y: all(z)[1] }]).collect();
    let north = if is_geo { 90.0 } else { MAX_LATITUDE };
    let body = LayerSchema {
        tilejson: "2.1.0",
        name: live.title().to_owned(),
        description: document.description.clone(),
        attribution: document.attribution.clone(),
        version: "1.0.0",
        format: "quantized-mesh-1.0",
        scheme: "tms",
        projection: if is_geo { "EPSG:4326" } else { "EPSG:3857" },
        tiles: [links.to(&(template + surface))],
        extensions: [normals, water_mask],
        minzoom: 0,
        maxzoom: MAX_MESH_ZOOM,
        bounds: [-180.0, -north, 180.0, north],
        available,
        level_zero_tolerance: mesh_tolerance(grid, 0),
        edge_step: mesh_step(&live.world.legend(), height),
    };
    json(&headers, &body, Freshness::Revalidate)
}
