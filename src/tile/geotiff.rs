//! `GeoTIFF`: elevations as 32-bit floats with their place on the plane.

use super::EncodeError;
use crate::geometry::{Surface, Window};
use std::io::{Seek, Write};
use tiff::{
    encoder::{TiffEncoder, colortype::Gray32Float},
    tags::Tag,
};

/// `GeoKeys` (OGC 19-008r4): a projected model, pixels as areas, EPSG:3857, vertical units of metres (EPSG:9001).
const GEO_KEYS: [u16; 20] = [1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 3857, 4099, 0, 1, 9001];

/// Writes the surface of a window of pixel centres; plane metres are Web Mercator metres, so GIS tools lay it over the tiles of the `web` grid.
///
/// # Errors
/// If writing fails.
pub fn write_geotiff(surface: &Surface, window: &Window, to: impl Write + Seek) -> Result<(), EncodeError> {
    let spacing = window.spacing();
    let (west, north) = (window.columns.coordinate(0) - spacing / 2.0, window.rows.coordinate(0) + spacing / 2.0);
    let mut tiff = TiffEncoder::new(to)?;
    let mut image = tiff.new_image::<Gray32Float>(surface.columns as u32, surface.rows as u32)?;
    let directory = image.encoder();
    directory.write_tag(Tag::ModelPixelScaleTag, &[spacing, spacing, 0.0][..])?;
    directory.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, west, north, 0.0][..])?;
    directory.write_tag(Tag::GeoKeyDirectoryTag, &GEO_KEYS[..])?;
    image.write_data(&surface.elevation)?;
    Ok(())
}
