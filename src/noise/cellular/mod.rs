//! Cellular noise: distances to the nearest of one random point a cell (S. Worley, "A cellular texture basis function", 1996), and one random value a cell.

#![expect(clippy::needless_range_loop, reason = "lanes are counted: loops over several arrays at once read best so, and become vector code")]

mod crease;
mod nearest;
mod points;
mod rows;
mod value;

pub use super::metric::Metric;
pub(super) use points::feature_points;
pub(super) use points::{Query, feature_at};
pub(super) use rows::DistanceRows;
pub(super) use value::value_points;
pub(super) use value::{ValueRows, Values};

/// Which measure of the distances to the nearest points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// The distance to the nearest point.
    F1,
    /// To the second nearest.
    F2,
    /// To the third nearest.
    F3,
    /// To the fourth nearest.
    F4,
    /// F2 - F1.
    F2F1,
    /// min(1, 10 (F2 - F1)).
    Crackle,
}

impl Feature {
    /// Every feature.
    pub const ALL: [Feature; 6] = [Feature::F1, Feature::F2, Feature::F3, Feature::F4, Feature::F2F1, Feature::Crackle];

    /// How many of the nearest points must be known.
    #[inline(always)]
    fn order(self) -> usize {
        match self {
            Feature::F1 => 1,
            Feature::F2 | Feature::F2F1 | Feature::Crackle => 2,
            Feature::F3 => 3,
            Feature::F4 => 4,
        }
    }

    /// Least and greatest value with a metric.
    ///
    /// Every cell has a point, so Fk is at most the k-th least of the distances to the farthest places of cells. With the sample x and y (x <= y <= ½) from the
    /// nearest sides of its own cell, the farthest places of its own cell, of those across these sides and of that across their corner are (1 - x, 1 - y),
    /// (1 + x, 1 - y), (1 - x, 1 + y) and (1 + x, 1 + y) away. The first is at most (1, 1); the second (1 + y, 1 - y), at most (3/2, ½) where distances are convex
    /// and (1, 1) where they are not; the third (1, 3/2). The fourth point lies within (4/3, 4/3) for y <= ⅓; else the cell across the side opposite y takes its
    /// place, whose farthest is (1 - x, 2 - y), within (1, 5/3).
    #[must_use]
    pub fn range(self, metric: Metric) -> [f32; 2] {
        let most = |places: &[[f32; 2]]| places.iter().map(|&[dx, dy]| metric.length(dx, dy)).fold(0.0, f32::max);
        let high = match self {
            Feature::F1 => most(&[[1.0, 1.0]]),
            Feature::F2 | Feature::F2F1 => most(&[[1.5, 0.5], [1.0, 1.0]]),
            Feature::F3 => most(&[[1.0, 1.5]]),
            Feature::F4 => most(&[[4.0 / 3.0, 4.0 / 3.0], [1.0, 5.0 / 3.0], [1.5, 2.0 / 3.0]]),
            Feature::Crackle => return [0.0, 1.0],
        };
        // A hair for rounding and inexact powers.
        [0.0, high * (1.0 + 1.0 / 262_144.0)]
    }

    /// The most that the value changes a cell along an axis. Infinite for Minkowski's exponents below 1, whose distances rise infinitely fast off the axes.
    #[must_use]
    pub fn slope(self, metric: Metric) -> f32 {
        let of_distance = |feature: Feature| match metric {
            Metric::Squared => 2.0 * feature.range(Metric::Distance)[1],
            Metric::Minkowski { exponent } if exponent < 1.0 => f32::INFINITY,
            _ => 1.0,
        };
        match self {
            Feature::F2F1 => of_distance(Feature::F1) + of_distance(Feature::F2),
            Feature::Crackle => 10.0 * (of_distance(Feature::F1) + of_distance(Feature::F2)),
            feature => of_distance(feature),
        }
    }
}

#[cfg(test)]
mod tests;
