//! A picture of terrain that nobody has seen yet.

use super::{
    Image, TileError,
    raster::{Pixels, Raster},
    relief,
};
use crate::{
    analysis,
    geometry::{Source, Surface, Window},
    tile::Ramp,
};

/// Name and version of the encoder: what it adds to a picture's fingerprint. It goes up with what [`crate::world::Survey`] finds, too.
pub const PREVIEW_FORM: &str = "preview.png 1";

/// Heights are stretched until slopes have this root mean square: what makes a picture of plains and of high mountains alike readable.
const SLOPE: f64 = 0.55;

/// Metres below nothing that count as sea where heights lie over a map: none of it is.
const SHORE: f64 = 1.0;

/// Least and greatest factor that heights are stretched by.
const STRETCH: [f64; 2] = [0.2, 40.0];

/// Draws the terrain over a window as a relief picture (PNG) whose colours and light are spread over what the window shows.
///
/// ```
/// use terrane::{tile::preview, world::{Document, Survey, World}};
/// let world = World::new(Document::parse(br#"{"seed": 7, "base": {"programme": "fbm(1, 2, 8)", "scale": 20000}}"#)?);
/// let png = preview(&world, &Survey::of(&world).window(64), 0.0)?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the image encoder fails, as it does for a window without samples, or the source was stopped.
pub fn preview(source: &impl Source, window: &Window, sea_level: f64) -> Result<Vec<u8>, TileError> {
    let (_, raster) = relief(source, window, sea_level)?;
    raster.encode(Image::Png).map_err(TileError::from)
}

/// The same for heights that are to lie over a map: transparent where there are none, which is where they are 0.
///
/// # Errors
/// As [`preview`].
pub fn overlay(source: &impl Source, window: &Window) -> Result<Vec<u8>, TileError> {
    let (surface, raster) = relief(source, window, -SHORE)?;
    let columns = window.columns.len();
    let inner = surface.elevation.chunks(surface.columns).skip(1).take(window.rows.len()).flat_map(|row| &row[1..=columns]);
    let shown = raster.bytes.chunks_exact(3).zip(inner).flat_map(|(rgb, height)| [rgb[0], rgb[1], rgb[2], if *height == 0.0 { 0 } else { 255 }]);
    Raster { size: raster.size, pixels: Pixels::Channels, bytes: shown.collect() }.encode(Image::Png).map_err(TileError::from)
}

/// The surface with a sample more on every side, and its picture.
fn relief(source: &impl Source, window: &Window, sea_level: f64) -> Result<(Surface, Raster), TileError> {
    let grown = window.with_apron(1);
    let mut surface = Surface::of(&grown);
    source.sample(&grown, &mut surface);
    if surface.stop.is_set() {
        return Err(TileError::Stopped);
    }
    let ramp = Ramp::over(sea_level, bulk(&surface).map(f64::from));
    let spacing = window.spacing() / stretch(&surface, window.spacing(), sea_level as f32);
    let bytes = relief::draw(&surface, spacing, &ramp);
    Ok((surface, Raster { size: [window.columns.len(), window.rows.len()], pixels: Pixels::Rgb, bytes }))
}

/// Elevations that 0.5 % and 99.5 % of the samples lie below: one needle of rock must not take the colours from all the rest.
fn bulk(surface: &Surface) -> [f32; 2] {
    let mut sorted = surface.elevation.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |place: usize| sorted.get(place).copied().unwrap_or_default();
    let cut = sorted.len() / 200;
    [at(cut), at(sorted.len().saturating_sub(1 + cut))]
}

/// The factor that brings the slopes of the land to [`SLOPE`]; of everything, where there is no land.
fn stretch(surface: &Surface, spacing: f64, sea_level: f32) -> f64 {
    let (mut land, mut all) = ([0.0, 0.0], [0.0, 0.0]);
    for row in 1..surface.rows.saturating_sub(1) {
        for column in 1..surface.columns.saturating_sub(1) {
            let [east, north] = analysis::gradient(surface, row, column, spacing).map(f64::from);
            let square = east * east + north * north;
            all = [all[0] + square, all[1] + 1.0];
            if surface.at(row, column) > sea_level {
                land = [land[0] + square, land[1] + 1.0];
            }
        }
    }
    let [sum, count]: [f64; 2] = if land[1] > 0.0 { land } else { all };
    let slope = (sum / count).sqrt();
    // Flat ground, and what is not a number, is drawn as it is.
    if slope > 0.0 && slope.is_finite() { (SLOPE / slope).clamp(STRETCH[0], STRETCH[1]) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Document, Survey, World};

    fn picture(base: &str, pixels: usize) -> Vec<u8> {
        let world = World::new(Document::parse(format!(r#"{{"seed":1,"base":{base}}}"#).as_bytes()).expect("valid"));
        let png = preview(&world, &Survey::of(&world).window(pixels), 0.0).expect("drawn");
        image::load_from_memory(&png).expect("a picture").into_rgb8().into_raw()
    }

    #[test]
    fn every_world_has_a_picture_of_the_size_asked_for() {
        for base in [
            r#"{"programme":"fbm(1, 2, 8)","scale":20000}"#,
            r#"{"programme":"7","scale":20000}"#,
            r#"{"programme":"x","scale":1e-300}"#,
            r#"{"programme":"multiply(x, 1e30)","scale":1e12}"#,
        ] {
            assert_eq!(picture(base, 65).len(), 65 * 65 * 3, "{base}");
        }
    }

    #[test]
    fn plains_and_mountains_are_equally_readable() {
        let contrast = |amplitude: &str| {
            let greys: Vec<f64> = picture(&format!(r#"{{"programme":"fbm(1, 2, 8)","scale":20000,"datum":5000,"amplitude":{amplitude}}}"#), 96)
                .chunks_exact(3)
                .map(|rgb| rgb.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0)
                .collect();
            let mean = greys.iter().sum::<f64>() / greys.len() as f64;
            (greys.iter().map(|grey| (grey - mean) * (grey - mean)).sum::<f64>() / greys.len() as f64).sqrt()
        };
        let (low, high) = (contrast("100"), contrast("3000"));
        assert!(low > 12.0 && high > 12.0 && (low / high) > 0.5 && (low / high) < 2.0, "{low} {high}");
    }
}
