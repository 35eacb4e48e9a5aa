//! What becomes of distances: the feature's value, with creases no sharper than the samples can carry.
//!
//! F2 - F1 falls to 0 at the edges between the cells of a Voronoi diagram and rises again behind them: across an edge it is |t|, where t grows evenly by the slope
//! g = |∇F2 - ∇F1|, at most 2 a unit (the two gradients are unit vectors, opposite where the edge crosses the line between its points). Over a square of side s,
//! t varies by g s/√12 around its mean (the square's second moment is the same in all directions), as it does over an interval of half-width h = g s/2. So the
//! square's mean of |t| is about that over the interval,
//!
//! S(t) = |t| for |t| >= h, (t² + h²)/(2 h) within,
//!
//! and because min(1, 10 |t|) = 1 + 10 |t| - 5 |t + 0.1| - 5 |t - 0.1|, the crackle's mean is the same sum of S. As h = σ s with one σ a metric, measured as what
//! comes nearest to true means of squares (0.7 for Euclidean distances, of at most 1), this needs nothing but F1 and F2. Squared distances grow 2 F as fast.
//!
//! True means also lower the crests between the edges, so that on average nothing changes. Here that is a factor 1 - κ s², κ measured.

use super::{Feature, Metric};
use crate::noise::metric::{Measure, smaller};

/// How the values of a feature are finished.
#[derive(Clone, Copy)]
pub(super) struct Finish {
    feature: Feature,
    /// h, for distances that grow by one a unit; 0 for creases as they are.
    half: f32,
    /// 1 - κ s².
    level: f32,
}

/// σ and κ for F2 - F1 and for the crackle at 1/e = 0, ½, 1 and 2 of Minkowski's exponent.
const CREASES: [(f32, [f32; 3]); 4] = [(0.0, [0.7, 0.9, 0.27]), (0.5, [0.72, 0.74, 0.2]), (1.0, [1.0, 0.88, 0.2]), (2.0, [1.5, 0.67, 0.12])];

/// The same for squared distances.
const SQUARED: [f32; 3] = [0.7, 0.82, 0.0];

fn creases(metric: Metric) -> [f32; 3] {
    if metric == Metric::Squared {
        return SQUARED;
    }
    let inverse = metric.inverse_exponent();
    let above = CREASES.iter().position(|&(at, _)| inverse <= at).unwrap_or(CREASES.len() - 1).max(1);
    let [(from, low), (to, high)] = [CREASES[above - 1], CREASES[above]];
    let part = (inverse - from) / (to - from);
    core::array::from_fn(|i| low[i] + part * (high[i] - low[i]))
}

impl Finish {
    /// `extent`: side of the square that a sample stands for, in cells; 0 for the value as it is, more than 1 counts as 1.
    pub(super) fn new(feature: Feature, metric: Metric, extent: f32) -> Self {
        if !(extent > 0.0 && matches!(feature, Feature::F2F1 | Feature::Crackle)) {
            return Self { feature, half: 0.0, level: 1.0 };
        }
        let extent = smaller(1.0, extent);
        let [sigma, of_f2f1, of_crackle] = creases(metric);
        let kappa = if feature == Feature::F2F1 { of_f2f1 } else { of_crackle };
        Self { feature, half: sigma * extent, level: 1.0 - kappa * extent * extent }
    }

    /// The value of the nearest measures.
    #[inline(always)]
    pub(super) fn of<M: Measure, const K: usize>(self, measure: M, near: [f32; K]) -> f32 {
        let [value] = self.all(measure, &near.map(|measure| [measure]));
        value
    }

    /// The values of the nearest measures of several samples.
    #[inline(always)]
    pub(super) fn all<M: Measure, const K: usize, const N: usize>(self, measure: M, near: &[[f32; N]; K]) -> [f32; N] {
        let mut values = [0.0; N];
        let slot = match self.feature {
            Feature::F1 => 0,
            Feature::F2 => 1,
            Feature::F3 => 2,
            Feature::F4 => 3,
            Feature::F2F1 | Feature::Crackle => {
                let (first, second) = (&near[0], &near[K.min(2) - 1]);
                for lane in 0..N {
                    values[lane] = measure.distance(second[lane]) - measure.distance(first[lane]);
                }
                self.crease(measure, second, &mut values);
                return values;
            }
        };
        let near = &near[slot.min(K - 1)];
        for lane in 0..N {
            values[lane] = measure.distance(near[lane]);
        }
        values
    }

    /// Makes F2 - F1 the value.
    #[inline(always)]
    fn crease<M: Measure, const N: usize>(self, measure: M, second: &[f32; N], values: &mut [f32; N]) {
        match (self.feature == Feature::Crackle, self.half > 0.0) {
            (false, false) => {}
            (true, false) => {
                for value in values {
                    *value = smaller(1.0, 10.0 * *value);
                }
            }
            (false, true) => {
                for lane in 0..N {
                    values[lane] = self.level * rounded(values[lane], self.half * measure.growth(second[lane]));
                }
            }
            (true, true) => {
                for lane in 0..N {
                    let half = self.half * measure.growth(second[lane]);
                    // Beyond, the crackle is 1, which differences of large numbers would miss by a little.
                    let t = smaller(values[lane], 0.1 + half);
                    let sum = 1.0 + 10.0 * rounded(t, half) - 5.0 * (rounded(t + 0.1, half) + rounded(t - 0.1, half));
                    values[lane] = self.level * smaller(1.0, sum);
                }
            }
        }
    }
}

/// The mean of |t| over t - h … t + h.
#[inline(always)]
fn rounded(t: f32, half: f32) -> f32 {
    let inside = (t * t + half * half) / (half + half);
    if t.abs() < half { inside } else { t.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{cells::Lattice, metric::larger};

    const METRICS: [Metric; 7] = [
        Metric::Distance,
        Metric::Squared,
        Metric::Manhattan,
        Metric::Chebychev,
        Metric::Minkowski { exponent: 0.5 },
        Metric::Minkowski { exponent: 0.7 },
        Metric::Minkowski { exponent: 4.0 },
    ];

    /// Creases fit for a spacing come nearer to the true means of squares than those as they are, and their mean is the same.
    #[test]
    fn creases_come_near_the_means_of_squares() {
        let lattice = Lattice::new(5, 0, 1.0);
        for metric in METRICS {
            for (feature, at_most) in [(Feature::F2F1, 0.8), (Feature::Crackle, 0.6)] {
                for extent in [0.125_f32, 0.25] {
                    let (mut sharp, mut smooth, mut bias) = (0.0_f64, 0.0_f64, 0.0_f64);
                    let count = 2_000;
                    for i in 0..count {
                        let (u, v) = (f64::from(i) * 9.813_432 % 300.0, f64::from(i) * 9.687_44 % 300.0);
                        let at = |extent: f32, du: f64, dv: f64| f64::from(super::super::feature_at(metric, feature, &lattice, extent, u + du, v + dv));
                        let step = |a: i32| (f64::from(a) + 0.5) / 8.0 * f64::from(extent) - 0.5 * f64::from(extent);
                        let truth = (0..64).map(|k| at(0.0, step(k % 8), step(k / 8))).sum::<f64>() / 64.0;
                        let fit = at(extent, 0.0, 0.0) - truth;
                        sharp += (at(0.0, 0.0, 0.0) - truth).powi(2);
                        smooth += fit * fit;
                        bias += fit / f64::from(count);
                    }
                    let ratio = (smooth / sharp).sqrt();
                    // Minkowski's ½ has creases along the axes through each point, too, which stay.
                    let at_most = if metric == (Metric::Minkowski { exponent: 0.5 }) { at_most + 0.2 } else { at_most };
                    assert!(ratio < at_most, "{metric:?} {feature:?} at {extent}: {ratio} of the sharp one's error");
                    assert!(bias.abs() < 0.008, "{metric:?} {feature:?} at {extent}: {bias} too much on average");
                }
            }
        }
    }

    #[test]
    fn values_stay_in_their_range() {
        for metric in METRICS {
            for feature in [Feature::F2F1, Feature::Crackle] {
                for extent in [0.0, 1e-6, 0.1, 0.5, 1.0, 7.0, f32::INFINITY] {
                    let finish = Finish::new(feature, metric, extent);
                    let [low, high] = feature.range(metric);
                    for i in 0..200 {
                        let value = finish.crease_of(larger(0.0, high.min(2.0) * i as f32 / 200.0));
                        assert!(low <= value && value <= high, "{metric:?} {feature:?} {extent}: {value}");
                    }
                }
            }
        }
    }

    impl Finish {
        /// The value of one F2 - F1 with F1 = 0.
        fn crease_of(self, difference: f32) -> f32 {
            self.of(crate::noise::metric::Sum, [0.0, difference])
        }
    }
}
