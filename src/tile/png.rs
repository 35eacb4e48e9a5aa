//! Opaque PNG without colour-management chunks.

use super::EncodeError;
use crate::geometry::Surface;
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// RGB, one colour a sample.
pub(super) fn rgb(surface: &Surface, colour: impl Fn(f32) -> [u8; 3]) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = vec![0; surface.elevation.len() * 3];
    for (pixel, &elevation) in bytes.chunks_exact_mut(3).zip(&surface.elevation) {
        pixel.copy_from_slice(&colour(elevation));
    }
    colours(surface.columns, surface.rows, &bytes)
}

/// Three bytes a pixel.
pub(super) fn colours(columns: usize, rows: usize, bytes: &[u8]) -> Result<Vec<u8>, EncodeError> {
    write(columns, rows, bytes, ExtendedColorType::Rgb8)
}

/// Four bytes a pixel.
pub(super) fn channels(columns: usize, rows: usize, bytes: &[u8]) -> Result<Vec<u8>, EncodeError> {
    write(columns, rows, bytes, ExtendedColorType::Rgba8)
}

/// One grey a pixel.
pub(super) fn grey(columns: usize, rows: usize, greys: &[u8]) -> Result<Vec<u8>, EncodeError> {
    write(columns, rows, greys, ExtendedColorType::L8)
}

fn write(columns: usize, rows: usize, bytes: &[u8], colour: ExtendedColorType) -> Result<Vec<u8>, EncodeError> {
    let mut out = Vec::with_capacity(bytes.len() / 2 + 1024);
    let encoder = PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Paeth);
    encoder.write_image(bytes, columns as u32, rows as u32, colour)?;
    Ok(out)
}
