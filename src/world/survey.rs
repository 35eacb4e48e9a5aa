//! A first look at a world: where it shows relief, and how high it reaches.

use super::World;
use crate::geometry::{Axis, Filter, Window};

/// Samples a side of the area that is looked at, and of the views compared within it.
const SIDE: usize = 96;
const VIEW: usize = 12;

/// The area looked at keeps this far from the edge of the Web Mercator square, in metres, where it can.
const WEB_REACH: f64 = 18_000_000.0;

/// Where a world is worth looking at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// Plane metres of the middle of the view with the most relief above the sea.
    pub centre: [f64; 2],
    /// Side of that view in metres: three programme units.
    pub side: f64,
    /// Elevations that 2 % and 98 % of the samples lie below, in metres.
    pub elevations: [f32; 2],
}

impl Survey {
    /// The predicted time to look at a world and then to evaluate the view as `pixels` × `pixels` samples, in nanoseconds.
    #[must_use]
    pub fn cost_ns(world: &World, pixels: usize) -> f64 {
        let scale = world.document().base.scale;
        let area = |spacing: f64, side: usize| world.area_cost_ns(spacing, Filter::Band, side * side);
        area(scale / 4.0, SIDE) + area(scale * 3.0 / pixels as f64, pixels)
    }

    /// Looks at 24 × 24 programme units around the base's origin.
    #[must_use]
    pub fn of(world: &World) -> Self {
        let document = world.document();
        let spacing = (document.base.scale / 4.0).min(2.0 * WEB_REACH / SIDE as f64);
        let half = spacing * SIDE as f64 / 2.0;
        let [x, y] = document.base.origin.map(|c| c.clamp(half - WEB_REACH, WEB_REACH - half));
        let Ok(window) = Window::area([x - half, y - half, x + half, y + half], spacing, Filter::Band, 1 << 20) else {
            return Self { centre: [x, y], side: spacing * VIEW as f64, elevations: [0.0, 0.0] };
        };
        let surface = world.evaluate(&window);
        let mut best = (f64::MIN, [0, 0]);
        for row in (0..=SIDE - VIEW).step_by(VIEW / 4) {
            for column in (0..=SIDE - VIEW).step_by(VIEW / 4) {
                let view = (row..row + VIEW).flat_map(|r| surface.row(r)[column..column + VIEW].iter().copied());
                let score = relief(view, document.sea_level as f32);
                if score > best.0 {
                    best = (score, [row, column]);
                }
            }
        }
        let [row, column] = best.1.map(|first| (first + VIEW / 2) as f64 * spacing);
        let mut sorted = surface.elevation;
        sorted.sort_by(f32::total_cmp);
        let elevations = [sorted[sorted.len() / 50], sorted[sorted.len() - 1 - sorted.len() / 50]];
        Self { centre: [x - half + column, y + half - row], side: spacing * VIEW as f64, elevations }
    }

    /// The view as `pixels` × `pixels` pixel centres.
    #[must_use]
    pub fn window(&self, pixels: usize) -> Window {
        let (half_pixel, last) = (self.side / pixels as f64 / 2.0, pixels as i64 - 1);
        let [columns, rows] = [(-last, 2, self.centre[0]), (last, -2, self.centre[1])];
        let axis = |(first, stride, centre): (i64, i64, f64)| Axis::new(first, stride, half_pixel, centre, pixels);
        Window { columns: axis(columns), rows: axis(rows), filter: Filter::Band }
    }
}

/// Standard deviation of what stands above the sea, so that a sea floor does not count as relief.
fn relief(samples: impl Iterator<Item = f32> + Clone, sea_level: f32) -> f64 {
    let above = samples.map(|elevation| f64::from(elevation.max(sea_level)));
    let count = above.clone().count() as f64;
    let mean = above.clone().sum::<f64>() / count;
    above.map(|elevation| (elevation - mean) * (elevation - mean)).sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Document;

    fn survey(base: &str) -> Survey {
        Survey::of(&World::new(Document::parse(format!(r#"{{"seed":1,"base":{base}}}"#).as_bytes()).expect("valid")))
    }

    #[test]
    fn the_view_lies_where_the_relief_is() {
        // Flat but for waves that grow to the north-east.
        let found = survey(r#"{"programme":"multiply(max(plus(x, y), 0), sin(multiply(6, x)))","scale":1000}"#);
        assert!(found.centre[0] > 5_000.0 && found.centre[1] > 5_000.0, "{found:?}");
        assert!(found.elevations[0] < 0.0 && found.elevations[1] > 0.0, "{found:?}");
        assert_eq!(found.side, 3_000.0);
    }

    #[test]
    fn the_view_is_a_window_around_its_centre() {
        let window = Survey { centre: [100.0, -50.0], side: 40.0, elevations: [0.0, 1.0] }.window(4);
        assert_eq!(window.columns.coordinates().collect::<Vec<_>>(), [85.0, 95.0, 105.0, 115.0]);
        assert_eq!(window.rows.coordinates().collect::<Vec<_>>(), [-35.0, -45.0, -55.0, -65.0]);
    }

    #[test]
    fn the_view_lies_on_the_map() {
        for base in [r#"{"programme":"fbm(1,2,8)","scale":1e9}"#, r#"{"programme":"fbm(1,2,8)","scale":10,"origin":[1e12,-1e12]}"#] {
            let found = survey(base);
            assert!(found.centre.iter().all(|c| c.abs() <= 20_000_000.0), "{found:?}");
        }
    }
}
