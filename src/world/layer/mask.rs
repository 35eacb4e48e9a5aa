//! Where a layer shows.

use crate::{
    geometry::{Elevation, Rectangle, Shape, Window},
    world::number::whole_pair,
};
use serde::{Deserialize, Serialize, Serializer};

/// Most vertices of a mask: every sample near its border asks all of them.
const MAX_VERTICES: usize = 512;

/// Samples a side of the parts of a window that lie wholly inside or outside without asking every sample.
const SIDE: usize = 32;

/// The part of the plane that a layer shows in.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Mask {
    /// The corners of a polygon in metres, in either direction, the first not repeated.
    #[serde(serialize_with = "whole_pairs")]
    pub polygon: Vec<[f64; 2]>,
}

fn whole_pairs<S: Serializer>(pairs: &[[f64; 2]], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Whole(#[serde(serialize_with = "whole_pair")] [f64; 2]);
    serializer.collect_seq(pairs.iter().copied().map(Whole))
}

impl Mask {
    fn shape(&self) -> Result<Shape, crate::geometry::ShapeError> {
        let ring = self.polygon.iter().chain(self.polygon.first()).copied().collect();
        Shape::polygon(vec![ring], Elevation::Absent)
    }

    /// Says what is wrong with the polygon.
    pub(super) fn check(&self) -> Result<(), String> {
        if self.polygon.len() > MAX_VERTICES {
            return Err(format!("must have at most {MAX_VERTICES} corners, got {}", self.polygon.len()));
        }
        self.shape().map_err(|error| error.to_string())?;
        Ok(())
    }

    /// The least rectangle that holds the polygon.
    pub(super) fn bounds(&self) -> Rectangle {
        Rectangle::around(&self.polygon)
    }

    /// How much of the layer shows at every sample, 0 … 1: nothing outside, all of it `fade` metres inside the border.
    pub(super) fn shares(&self, window: &Window, fade: f64) -> Vec<f32> {
        let mut shares = vec![0.0; window.samples()];
        let Ok(shape) = self.shape() else { return shares };
        let share = |distance: f64| match fade {
            _ if distance >= 0.0 => 0.0,
            fade if fade > 0.0 => {
                let t = (-distance / fade).min(1.0);
                (t * t * (3.0 - 2.0 * t)) as f32
            }
            _ => 1.0,
        };
        let (rows, columns) = (window.rows.len(), window.columns.len());
        for row in (0..rows).step_by(SIDE) {
            for column in (0..columns).step_by(SIDE) {
                let (height, width) = (SIDE.min(rows - row), SIDE.min(columns - column));
                let part = window.part([row, height], [column, width]);
                let Rectangle { min, max } = part.bounds();
                let middle = [f64::midpoint(min[0], max[0]), f64::midpoint(min[1], max[1])];
                let reach = libm::hypot(max[0] - min[0], max[1] - min[1]) * 0.500_001;
                let distance = shape.nearest(middle, 0.0).distance;
                let whole = if distance > reach {
                    Some(0.0)
                } else if distance < -(reach + fade) {
                    Some(1.0)
                } else {
                    None
                };
                for (i, y) in part.rows.coordinates().enumerate() {
                    let line = &mut shares[(row + i) * columns + column..][..width];
                    for (out, x) in line.iter_mut().zip(part.columns.coordinates()) {
                        *out = whole.unwrap_or_else(|| share(shape.nearest([x, y], 0.0).distance));
                    }
                }
            }
        }
        shares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Filter;

    #[test]
    fn shares_of_parts_are_those_of_every_sample() {
        let mask = Mask { polygon: vec![[0.0, 0.0], [900.0, 100.0], [500.0, 400.0], [700.0, 900.0], [-100.0, 700.0]] };
        assert_eq!(mask.check(), Ok(()));
        let window = Window::area([-400.0, -300.0, 1200.0, 1100.0], 9.0, Filter::Band, 1 << 20).expect("valid");
        let shape = mask.shape().expect("valid");
        for fade in [0.0, 60.0, 5_000.0] {
            let shares = mask.shares(&window, fade);
            let points = window.rows.coordinates().flat_map(|y| window.columns.coordinates().map(move |x| [x, y]));
            for (p, share) in points.zip(shares) {
                let inside = -shape.nearest(p, 0.0).distance;
                let t = if fade > 0.0 { (inside / fade).clamp(0.0, 1.0) } else { f64::from(inside > 0.0) };
                assert_eq!(share, (t * t * (3.0 - 2.0 * t)) as f32, "{p:?}");
            }
        }
    }

    #[test]
    fn what_is_no_polygon_is_refused() {
        let check = |polygon: &[[f64; 2]]| Mask { polygon: polygon.to_vec() }.check().is_err();
        assert!(check(&[]) && check(&[[0.0, 0.0], [1.0, 0.0]]));
        assert!(check(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), "it crosses itself");
        assert!(check(&[[0.0, 0.0], [1e13, 0.0], [0.0, 1.0]]));
        assert!(check(&vec![[0.0, 0.0]; 600]));
    }
}
