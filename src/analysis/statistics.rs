//! A surface's slopes, heights and roughness in a few numbers.

use super::slope::gradient;
use crate::geometry::Surface;
use serde::{Deserialize, Serialize};

/// Quantiles of a distribution, at equal shares from the least to the greatest value.
pub const QUANTILES: usize = 33;

/// A distribution by its quantiles: at least two, ascending.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Quantiles(pub Vec<f64>);

impl Quantiles {
    /// [`QUANTILES`] of values.
    #[must_use]
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_unstable_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        Self((0..QUANTILES).map(|i| values.get(i * last / (QUANTILES - 1)).copied().unwrap_or_default()).collect())
    }

    /// The value that a share of the distribution lies below; linear between quantiles.
    #[must_use]
    pub fn at(&self, share: f64) -> f64 {
        let place = share.clamp(0.0, 1.0) * self.0.len().saturating_sub(1) as f64;
        let below = place.floor();
        let value = |i: usize| self.0.get(i.min(self.0.len().saturating_sub(1))).copied().unwrap_or_default();
        let (a, b) = (value(below as usize), value(below as usize + 1));
        a + (b - a) * (place - below)
    }

    /// How far values must be moved on average to make one distribution the other (the first Wasserstein distance), as far as quantiles tell.
    #[must_use]
    pub fn distance(&self, other: &Self) -> f64 {
        let steps = 2 * (QUANTILES - 1);
        let middle = |i: usize| (i as f64 + 0.5) / steps as f64;
        (0..steps).map(|i| (self.at(middle(i)) - other.at(middle(i))).abs()).sum::<f64>() / steps as f64
    }
}

/// What a surface is like, measured on samples of one spacing: to be compared with what is measured on samples of the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Statistics {
    /// Slopes in degrees.
    pub slopes: Quantiles,
    /// Heights as shares of the relief, from 0, the least, to 1.
    pub heights: Quantiles,
    /// Metres between the least and the greatest elevation.
    pub relief: f64,
    /// Root mean square of what samples differ by from the mean of their eight neighbours, a metre of spacing: 0 for planes, however steep.
    pub roughness: f64,
}

impl Statistics {
    /// Measures the samples of a surface within an apron of one.
    #[must_use]
    pub fn of(surface: &Surface, spacing: f64) -> Self {
        let (mut slopes, mut heights, mut squares) = (Vec::new(), Vec::new(), 0.0);
        for row in 1..surface.rows.saturating_sub(1) {
            for column in 1..surface.columns.saturating_sub(1) {
                let [east, north] = gradient(surface, row, column, spacing).map(f64::from);
                slopes.push(libm::atan((east * east + north * north).sqrt()).to_degrees());
                let height = f64::from(surface.at(row, column));
                heights.push(height);
                let around: f64 = (row - 1..=row + 1).flat_map(|row| &surface.row(row)[column - 1..=column + 1]).map(|&h| f64::from(h)).sum();
                let bump = height - (around - height) / 8.0;
                squares += bump * bump;
            }
        }
        let (low, high) = heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &h| (low.min(h), high.max(h)));
        let relief = if high > low { high - low } else { 0.0 };
        let roughness = (squares / heights.len().max(1) as f64).sqrt() / spacing;
        let relative = heights.iter().map(|h| if relief > 0.0 { (h - low) / relief } else { 0.0 }).collect();
        Self { slopes: Quantiles::of(slopes), heights: Quantiles::of(relative), relief, roughness }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_has_one_slope_even_heights_and_no_roughness() {
        let elevation = (0..40 * 30).map(|i| 5.0 * (i % 40) as f32).collect();
        let ramp = Statistics::of(&Surface { columns: 40, rows: 30, elevation, ..Surface::default() }, 5.0);
        assert!(ramp.slopes.0.iter().all(|slope| (slope - 45.0).abs() < 1e-5));
        assert!((ramp.heights.at(0.5) - 0.5).abs() < 0.02 && ramp.relief == 37.0 * 5.0 && ramp.roughness < 1e-9);
    }

    #[test]
    fn distributions_are_as_far_apart_as_they_are_moved() {
        let uniform = |from: f64| Quantiles::of((0..1000).map(|i| from + f64::from(i) / 1000.0).collect());
        assert!((uniform(0.0).distance(&uniform(3.0)) - 3.0).abs() < 1e-12);
        assert_eq!(uniform(1.0).distance(&uniform(1.0)), 0.0);
        assert!((uniform(0.0).distance(&Quantiles(vec![0.0, 2.0])) - 0.5).abs() < 0.01);
        assert_eq!(Quantiles::of(Vec::new()).at(0.3), 0.0);
    }
}
