//! The power spectrum of profiles.

use crate::noise::{Basis, Field, FieldShape};
use core::f64::consts::TAU;

/// Samples of a profile.
const SAMPLES: usize = 4_096;

/// The squared magnitudes of the Fourier coefficients 0 … n/2 of real samples (J. W. Cooley and J. W. Tukey, radix 2).
fn power(samples: &[f64]) -> Vec<f64> {
    fn transform(values: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let n = values.len();
        if n == 1 {
            return values.to_vec();
        }
        let half = |first: usize| transform(&values.iter().skip(first).step_by(2).copied().collect::<Vec<_>>());
        let (even, odd) = (half(0), half(1));
        let mut out = vec![[0.0; 2]; n];
        for k in 0..n / 2 {
            let angle = -TAU * k as f64 / n as f64;
            let (c, s) = (libm::cos(angle), libm::sin(angle));
            let turned = [odd[k][0] * c - odd[k][1] * s, odd[k][0] * s + odd[k][1] * c];
            out[k] = [even[k][0] + turned[0], even[k][1] + turned[1]];
            out[k + n / 2] = [even[k][0] - turned[0], even[k][1] - turned[1]];
        }
        out
    }
    let values: Vec<[f64; 2]> = samples.iter().map(|&sample| [sample, 0.0]).collect();
    transform(&values)[..=samples.len() / 2].iter().map(|[re, im]| re * re + im * im).collect()
}

/// The exponent of the spectrum of profiles along u: the slope of a line through the logarithms of means over sixths of an octave.
fn exponent(field: &Field, base: f64) -> f64 {
    let columns: Vec<f64> = (0..SAMPLES).map(|i| i as f64 / base).collect();
    let mut rows = field.rows(&columns);
    let (mut line, mut mean) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES / 2 + 1]);
    for row in 0..96 {
        rows.begin(f64::from(row) * 3.713);
        rows.fill(0, &mut line);
        // Hann's window, or the jump between both ends would have a spectrum of its own.
        let windowed: Vec<f64> = line.iter().enumerate().map(|(i, &n)| f64::from(n) * (1.0 - libm::cos(TAU * i as f64 / SAMPLES as f64))).collect();
        mean.iter_mut().zip(power(&windowed)).for_each(|(mean, power)| *mean += power);
    }
    // Five octaves, from a cell of the second octave on: the first and the last octaves have neighbours on one side only.
    let first = 2.0 * SAMPLES as f64 / base;
    let points: Vec<[f64; 2]> = (0..30)
        .map(|sixth| {
            let bounds = [0, 1].map(|end| (first * libm::exp2(f64::from(sixth + end) / 6.0)) as usize);
            let band = &mean[bounds[0]..bounds[1].max(bounds[0] + 1)];
            [(f64::from(sixth) + 0.5) / 6.0, libm::log2(band.iter().sum::<f64>() / band.len() as f64)]
        })
        .collect();
    let centre = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64);
    let product = |a: usize, b: usize| points.iter().map(|point| (point[a] - centre[a]) * (point[b] - centre[b])).sum::<f64>();
    -product(0, 1) / product(0, 0)
}

#[test]
fn profiles_of_spectral_noise_have_its_spectrum() {
    for basis in [Basis::OPerlin, Basis::IPerlin] {
        for beta in [1.6, 1.8, 2.0, 2.2, 2.4] {
            let got = exponent(&Field::exact(FieldShape::Spectral { beta, octaves: 10.0 }, basis, 5), 256.0);
            assert!((got - beta).abs() < 0.1, "{basis:?}: the profiles' spectrum falls with {got}, not {beta}");
        }
    }
}
