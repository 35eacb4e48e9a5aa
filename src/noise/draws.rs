//! What stands for the detail of a noise that samples cannot carry, where a function of the noise is averaged.
//!
//! The mean of a function of a noise is not the function of the noise's mean. Where a sample is the mean of 4 × 4 parts, every octave that is left out is
//! therefore drawn from its distribution: its sixteen sixteenths, one a part, in an order of its own. The draws are the same for every sample, so they add no
//! grain, and their mean is zero, so that sums stay as they are; but masks, ridges and terraces see how far the noise would have swung. (Quadrature over Latin
//! hypercubes: `McKay` and others, 1979; with orders that are nearly uncorrelated: B. Tang, 1993.)

use super::{
    Basis, Field, FieldShape,
    field::carried,
    fractal::{Step, with_step},
    lanes::{Lanes, Plain},
    moments::PARTS,
    number::Real,
};
use core::f64::consts::PI;

/// Parts a side of a sample whose noises are drawn.
pub(crate) const SIDE: usize = 4;

/// Values that stand for what is left out of a noise: those of the parts of a sample, row by row.
pub type Draws = [f32; SIDE * SIDE];

impl Field {
    /// What the parts of a sample add to [`Field::banded`] of the same shape, basis and spacing; `None` where nothing is left out. Octave k is drawn in the order of
    /// number `order(k)`: octaves of one order swing together.
    pub(crate) fn draws(shape: FieldShape, basis: Basis, spacing: f64, order: impl Fn(usize) -> usize) -> Option<Draws> {
        // What is left of a variance: of an octave that counts with c, what is drawn counts with √(1 - c²).
        let kept = |frequency: f64| {
            let carried = carried(1.0 / frequency, spacing);
            1.0 - (1.0 - carried * carried).sqrt()
        };
        let (whole, kept) = (Self::exact(shape, basis, 0), Self::new(shape, basis, 0, spacing, kept));
        let finest = whole.octaves.last()?.lattice.frequency;
        if carried(1.0 / finest, spacing) >= 1.0 {
            return None;
        }
        let sixteenths = sixteenths(basis);
        let values: [f64; PARTS] = core::array::from_fn(|part| {
            let noises: Vec<f32> = (0..whole.octaves.len()).map(|k| sixteenths[usize::from(ORDERS[order(k) % ORDERS.len()][part])]).collect();
            f64::from(whole.folded(&noises)) - f64::from(kept.folded(&noises))
        });
        let mean = values.iter().sum::<f64>() / PARTS as f64;
        Some(values.map(|value| (value - mean) as f32))
    }

    /// The value where the noises of the octaves are these.
    fn folded(&self, noises: &[f32]) -> f32 {
        let one = Plain::<1>;
        let mut state = self.before(one);
        for (octave, noise) in self.octaves.iter().zip(noises) {
            let noise = Real(one.splat(octave.amplitude * noise));
            state = with_step!(&octave.step, step => step.after(one, noise, state));
        }
        let Real(value) = self.after(one, state);
        value.0[0]
    }
}

/// How much of waves of some length is carried by parts of samples `spacing` apart, and what stands for the rest of a sine, in the order of that number; `None` where
/// it is carried whole. Waves are taken for octaves with cells of their length.
pub(crate) fn wave_draws(length: f64, spacing: f64, order: usize) -> Option<(f32, Draws)> {
    let carried = carried(length, spacing);
    if carried >= 1.0 {
        return None;
    }
    let left = (1.0 - carried * carried).sqrt();
    // The mean of a sine over a sixteenth of its rise.
    let end = |i: usize| libm::cos(PI * (i as f64 / PARTS as f64 - 0.5));
    let sixteenth = |i: usize| (end(i) - end(i + 1)) * PARTS as f64 / PI;
    Some((carried as f32, core::array::from_fn(|part| (left * sixteenth(usize::from(ORDERS[order % ORDERS.len()][part]))) as f32)))
}

/// Sixteenths in the order of a number.
pub(super) fn ordered(sixteenths: &Draws, order: usize) -> Draws {
    ORDERS[order % ORDERS.len()].map(|i| sixteenths[usize::from(i)])
}

/// The means of the sixteenths of a noise's distribution, ascending.
fn sixteenths(basis: Basis) -> [f32; PARTS] {
    let magnitudes = basis.parts();
    if !basis.is_signed() {
        return magnitudes;
    }
    let eighth = |i: usize| f32::midpoint(magnitudes[2 * i], magnitudes[2 * i + 1]);
    core::array::from_fn(|i| if i < PARTS / 2 { -eighth(PARTS / 2 - 1 - i) } else { eighth(i - PARTS / 2) })
}

/// Orders of sixteen, hardly correlated with the columns and rows of a sample's parts and, the first ten above all, with each other; nor are their squares.
/// Found by simulated annealing.
#[rustfmt::skip]
const ORDERS: [[u8; PARTS]; 32] = [
    [0, 7, 13, 10, 12, 8, 9, 2, 11, 3, 1, 14, 6, 15, 4, 5],
    [7, 1, 12, 11, 15, 4, 6, 0, 10, 8, 13, 5, 3, 2, 14, 9],
    [2, 3, 14, 9, 11, 5, 6, 13, 4, 15, 7, 0, 12, 10, 1, 8],
    [9, 2, 14, 3, 6, 11, 5, 13, 15, 7, 0, 4, 1, 8, 12, 10],
    [9, 5, 13, 0, 8, 15, 7, 6, 2, 1, 10, 12, 14, 4, 3, 11],
    [9, 0, 4, 10, 13, 8, 15, 11, 2, 3, 5, 6, 12, 7, 14, 1],
    [6, 12, 1, 10, 14, 13, 0, 7, 3, 11, 4, 5, 2, 9, 8, 15],
    [13, 7, 9, 1, 10, 0, 15, 6, 2, 12, 5, 8, 4, 11, 3, 14],
    [3, 13, 10, 2, 14, 4, 6, 8, 5, 11, 1, 15, 9, 0, 12, 7],
    [12, 1, 8, 13, 6, 10, 3, 4, 0, 15, 5, 14, 11, 7, 9, 2],
    [11, 5, 8, 2, 12, 13, 0, 15, 4, 3, 9, 7, 1, 14, 10, 6],
    [1, 6, 13, 10, 14, 9, 2, 5, 4, 8, 15, 3, 11, 7, 0, 12],
    [2, 13, 11, 7, 8, 0, 4, 15, 9, 3, 10, 5, 14, 6, 12, 1],
    [10, 6, 15, 5, 2, 0, 3, 8, 13, 11, 9, 14, 7, 12, 1, 4],
    [10, 7, 13, 1, 2, 9, 3, 14, 4, 15, 6, 5, 12, 0, 11, 8],
    [14, 2, 6, 10, 7, 1, 5, 9, 11, 13, 15, 0, 3, 4, 8, 12],
    [6, 1, 11, 12, 7, 15, 8, 2, 14, 9, 0, 4, 3, 5, 13, 10],
    [11, 3, 14, 4, 2, 10, 15, 5, 8, 0, 6, 7, 12, 9, 1, 13],
    [10, 14, 4, 3, 7, 15, 5, 2, 1, 6, 11, 12, 9, 0, 8, 13],
    [4, 9, 1, 11, 6, 14, 10, 12, 2, 15, 0, 3, 13, 7, 5, 8],
    [2, 14, 10, 4, 7, 8, 3, 15, 13, 5, 0, 6, 12, 1, 9, 11],
    [8, 10, 6, 0, 15, 2, 14, 11, 5, 9, 3, 7, 1, 12, 4, 13],
    [15, 6, 1, 7, 2, 11, 3, 12, 9, 13, 10, 5, 4, 8, 0, 14],
    [12, 9, 1, 8, 6, 3, 15, 11, 5, 0, 14, 2, 13, 4, 10, 7],
    [10, 0, 13, 4, 7, 12, 8, 14, 5, 1, 2, 9, 11, 15, 3, 6],
    [8, 14, 4, 12, 10, 1, 2, 6, 0, 9, 5, 15, 11, 13, 7, 3],
    [10, 8, 9, 0, 15, 12, 3, 5, 1, 4, 14, 11, 6, 2, 7, 13],
    [2, 6, 7, 4, 14, 1, 8, 15, 11, 13, 10, 12, 9, 3, 0, 5],
    [10, 0, 6, 7, 8, 13, 15, 4, 3, 12, 2, 14, 11, 1, 9, 5],
    [0, 10, 4, 7, 14, 12, 11, 13, 3, 5, 8, 1, 6, 9, 15, 2],
    [9, 8, 15, 1, 0, 5, 7, 11, 4, 14, 10, 6, 12, 3, 13, 2],
    [8, 2, 5, 12, 6, 15, 1, 11, 10, 0, 14, 9, 13, 4, 7, 3],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn correlation(a: &[f64; PARTS], b: &[f64; PARTS]) -> f64 {
        let centred = |x: &[f64; PARTS]| x.map(|value| value - x.iter().sum::<f64>() / PARTS as f64);
        let (a, b) = (centred(a), centred(b));
        let product = |a: &[f64; PARTS], b: &[f64; PARTS]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
    }

    #[test]
    fn orders_have_each_sixteenth_once_and_hardly_correlate() {
        let (columns, rows) = (core::array::from_fn(|i| (i % SIDE) as f64), core::array::from_fn(|i| (i / SIDE) as f64));
        let orders = ORDERS.map(|order| order.map(f64::from));
        for (number, order) in orders.iter().enumerate() {
            let mut sorted = ORDERS[number];
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..PARTS as u8), "{number}");
            assert!(correlation(order, &columns).abs() < 0.03 && correlation(order, &rows).abs() < 0.03, "{number}");
            for (other, before) in orders[..number.min(10)].iter().enumerate().filter(|_| number < 10) {
                assert!(correlation(order, before).abs() < 0.25, "{number} and {other}");
            }
        }
    }

    /// Where nothing is left of a noise, draws have its mean and nearly its variance; where all is, there are none.
    #[test]
    fn draws_have_the_noise_s_mean_and_variance() {
        for basis in Basis::all() {
            let moments = basis.moments();
            let variance = moments.square - moments.mean * moments.mean;
            let draws = Field::draws(FieldShape::Single, basis, 10.0, |octave| octave).expect("nothing is left");
            let mean = |power: i32| draws.iter().map(|&draw| f64::from(draw).powi(power)).sum::<f64>() / PARTS as f64;
            assert!(mean(1).abs() < 1e-6, "{basis:?}: {}", mean(1));
            assert!((mean(2) / variance - 1.0).abs() < 0.06, "{basis:?}: {} of {variance}", mean(2));
            assert_eq!(Field::draws(FieldShape::Single, basis, 0.2, |octave| octave), None);
        }
    }

    /// Octaves that draw in the same order cancel where they are subtracted.
    #[test]
    fn equal_octaves_swing_together() {
        let draws = |octaves| {
            let shape = FieldShape::Turbulence { octaves, amplitude: 1.0, frequency: 3.0, hard: false };
            Field::draws(shape, Basis::OPerlin, 10.0, |octave| octave).expect("nothing is left")
        };
        let third = Field::draws(FieldShape::Single, Basis::OPerlin, 10.0, |_| 2).expect("nothing is left");
        for ((three, two), third) in draws(3.0).iter().zip(draws(2.0)).zip(third) {
            assert!((three - two - third).abs() < 1e-6);
        }
    }

    #[test]
    fn waves_fade_to_sixteenths_of_a_sine() {
        assert_eq!(wave_draws(4.0, 1.0, 0), None);
        let (carried, draws) = wave_draws(2.0, 1.0, 0).expect("gone");
        assert_eq!(carried, 0.0);
        let square = draws.iter().map(|&draw| f64::from(draw) * f64::from(draw)).sum::<f64>() / PARTS as f64;
        assert!((square - 0.5).abs() < 0.01 && draws.iter().sum::<f32>().abs() < 1e-6, "{square}");
    }
}
