//! How much of each sample lies under water.

use crate::{analysis, geometry::Surface};

/// The share of a sample within an apron of one that lies under water, 0 … 1.
///
/// Where the ground meets the sea's level within the sample and its source knows no better, elevation over slope is the distance to the shore.
pub(super) fn share(surface: &Surface, [row, column]: [usize; 2], spacing: f32, sea_level: f32) -> f32 {
    let cover = surface.water_cover[row * surface.columns + column];
    if cover > 0.0 && cover < 1.0 {
        return cover;
    }
    let [east, north] = analysis::gradient(surface, row, column, f64::from(spacing));
    let rise = (east * east + north * north).sqrt() * spacing;
    let above = surface.at(row, column) - sea_level;
    // A river on the land beside the shore stays a river.
    if above.abs() < 0.5 * rise && (cover == 0.0 || above < 0.0) { 0.5 - above / rise } else { cover }
}

/// Shares as greys: 0 dry, 255 all under water.
pub(super) fn greys(surface: &Surface, spacing: f64, sea_level: f32) -> Vec<u8> {
    let places = (1..surface.rows - 1).flat_map(|row| (1..surface.columns - 1).map(move |column| [row, column]));
    places.map(|place| (share(surface, place, spacing as f32, sea_level) * 255.0 + 0.5) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(elevation: f32, slope: f32, cover: f32) -> u8 {
        let elevation = (0..9_u8).map(|i| elevation + slope * (f32::from(i % 3) - 1.0)).collect();
        greys(&Surface { columns: 3, rows: 3, elevation, water_cover: vec![cover; 9], ..Surface::default() }, 1.0, 0.0)[0]
    }

    #[test]
    fn the_shore_divides_samples() {
        assert_eq!([grey(5.0, 1.0, 0.0), grey(-5.0, 1.0, 1.0)], [0, 255]);
        assert_eq!([grey(0.25, 1.0, 0.0), grey(0.0, 1.0, 0.0), grey(-0.25, 1.0, 1.0)], [64, 128, 191]);
        assert_eq!([grey(9.0, 1.0, 0.2), grey(0.1, 1.0, 1.0)], [51, 255], "rivers keep their share");
        assert_eq!(grey(0.0, 0.0, 0.0), 0, "a flat beach at the sea's very level is dry");
    }
}
