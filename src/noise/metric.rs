//! How far apart two points of the plane are.
//!
//! Nearest points are found by a *measure* that grows with the distance and is cheap to compare: Euclidean distances are compared by their squares, Minkowski's
//! by the sum of powers. Each metric has a measure type of its own, so that loops over samples are compiled for it without a branch.

use core::f32::consts::LN_2;

/// How far apart two points are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Metric {
    /// Euclidean distance.
    #[default]
    Distance,
    /// Euclidean distance squared.
    Squared,
    /// |dx| + |dy|.
    Manhattan,
    /// max(|dx|, |dy|).
    Chebychev,
    /// (|dx|^e + |dy|^e)^(1/e).
    Minkowski {
        /// e, at least 0.5; less counts as 0.5.
        exponent: f32,
    },
}

impl Metric {
    /// Every metric without a parameter.
    pub const ALL: [Metric; 4] = [Metric::Distance, Metric::Squared, Metric::Manhattan, Metric::Chebychev];

    /// The name in programmes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Metric::Distance => "distance",
            Metric::Squared => "squared",
            Metric::Manhattan => "manhattan",
            Metric::Chebychev => "chebychev",
            Metric::Minkowski { .. } => "minkowski",
        }
    }

    /// The distance between points (dx, dy) apart.
    #[must_use]
    pub fn length(self, dx: f32, dy: f32) -> f32 {
        struct Length(f32, f32);
        impl Measured for Length {
            type Output = f32;

            fn run<M: Measure>(self, measure: M) -> f32 {
                measure.distance(measure.join(measure.axis(self.0), measure.axis(self.1)))
            }
        }
        self.measured(Length(dx, dy))
    }

    /// 1/e of the Minkowski metric that this is or, for [`Metric::Squared`], is compared by.
    pub(super) fn inverse_exponent(self) -> f32 {
        match self {
            Metric::Distance | Metric::Squared => 0.5,
            Metric::Manhattan => 1.0,
            Metric::Chebychev => 0.0,
            Metric::Minkowski { exponent } if exponent > MIN_EXPONENT => 1.0 / exponent,
            Metric::Minkowski { .. } => 1.0 / MIN_EXPONENT,
        }
    }

    /// Runs a task with this metric's measure.
    #[inline(always)]
    pub(super) fn measured<T: Measured>(self, task: T) -> T::Output {
        match self {
            Metric::Distance | Metric::Minkowski { exponent: 2.0 } => task.run(Square { rooted: true }),
            Metric::Squared => task.run(Square { rooted: false }),
            Metric::Manhattan | Metric::Minkowski { exponent: 1.0 } => task.run(Sum),
            Metric::Chebychev => task.run(Greatest),
            Metric::Minkowski { exponent } if exponent > MIN_EXPONENT => task.run(if exponent > STEEP { Power::steep(exponent) } else { Power::new(exponent) }),
            Metric::Minkowski { .. } => task.run(Roots),
        }
    }
}

/// Minkowski's least exponent.
pub(super) const MIN_EXPONENT: f32 = 0.5;

/// A computation that is compiled once for every measure.
pub(super) trait Measured {
    /// What it answers.
    type Output;

    /// The computation. `#[inline(always)]` where it is part of a kernel.
    fn run<M: Measure>(self, measure: M) -> Self::Output;
}

/// A measure m(dx, dy) = join(axis(dx), axis(dy)), each part growing with what it is made of.
pub(super) trait Measure: Copy {
    /// The share of an offset along one axis.
    fn axis(self, d: f32) -> f32;

    /// The measure of two shares.
    fn join(self, x: f32, y: f32) -> f32;

    /// The distance of a measure.
    fn distance(self, measure: f32) -> f32;

    /// How much the distance grows a unit, there where the measure is this.
    #[inline(always)]
    fn growth(self, _measure: f32) -> f32 {
        1.0
    }
}

#[inline(always)]
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Compares Euclidean distances by their squares.
#[derive(Clone, Copy)]
pub(super) struct Square {
    rooted: bool,
}

impl Measure for Square {
    #[inline(always)]
    fn axis(self, d: f32) -> f32 {
        d * d
    }

    #[inline(always)]
    fn join(self, x: f32, y: f32) -> f32 {
        x + y
    }

    #[inline(always)]
    fn distance(self, measure: f32) -> f32 {
        if self.rooted { measure.sqrt() } else { measure }
    }

    #[inline(always)]
    fn growth(self, measure: f32) -> f32 {
        if self.rooted { 1.0 } else { 2.0 * measure.sqrt() }
    }
}

/// |dx| + |dy|.
#[derive(Clone, Copy)]
pub(super) struct Sum;

impl Measure for Sum {
    #[inline(always)]
    fn axis(self, d: f32) -> f32 {
        d.abs()
    }

    #[inline(always)]
    fn join(self, x: f32, y: f32) -> f32 {
        x + y
    }

    #[inline(always)]
    fn distance(self, measure: f32) -> f32 {
        measure
    }
}

/// max(|dx|, |dy|).
#[derive(Clone, Copy)]
pub(super) struct Greatest;

impl Measure for Greatest {
    #[inline(always)]
    fn axis(self, d: f32) -> f32 {
        d.abs()
    }

    #[inline(always)]
    fn join(self, x: f32, y: f32) -> f32 {
        larger(x, y)
    }

    #[inline(always)]
    fn distance(self, measure: f32) -> f32 {
        measure
    }
}

/// Minkowski's exponent ½: (√|dx| + √|dy|)².
#[derive(Clone, Copy)]
pub(super) struct Roots;

impl Measure for Roots {
    #[inline(always)]
    fn axis(self, d: f32) -> f32 {
        d.abs().sqrt()
    }

    #[inline(always)]
    fn join(self, x: f32, y: f32) -> f32 {
        x + y
    }

    #[inline(always)]
    fn distance(self, measure: f32) -> f32 {
        measure * measure
    }
}

/// From this exponent on, the sum of powers would leave the range of f32 within a cell: |d|^16 is a normal number down to 0.004.
const STEEP: f32 = 16.0;

/// Minkowski's other exponents: |dx|^e + |dy|^e, or its root where e is steep.
#[derive(Clone, Copy)]
pub(super) struct Power {
    exponent: f32,
    inverse: f32,
    steep: bool,
}

impl Power {
    #[inline(always)]
    fn new(exponent: f32) -> Self {
        Self { exponent, inverse: 1.0 / exponent, steep: false }
    }

    #[inline(always)]
    fn steep(exponent: f32) -> Self {
        // An infinite exponent would make 0 · ∞ of equal offsets; a million already is Chebychev's to the last bit.
        Self { steep: true, ..Self::new(smaller(exponent, 1e6)) }
    }
}

impl Measure for Power {
    #[inline(always)]
    fn axis(self, d: f32) -> f32 {
        if self.steep { d.abs() } else { power(d.abs(), self.exponent) }
    }

    /// Steep: with the larger offset taken out, h (1 + (l/h)^e)^(1/e), nothing overflows.
    #[inline(always)]
    fn join(self, x: f32, y: f32) -> f32 {
        if !self.steep {
            return x + y;
        }
        let (low, high) = (smaller(x, y), larger(larger(x, y), f32::MIN_POSITIVE));
        high * power(1.0 + power(low / high, self.exponent), self.inverse)
    }

    #[inline(always)]
    fn distance(self, measure: f32) -> f32 {
        if self.steep { measure } else { power(measure, self.inverse) }
    }
}

/// x^e for x >= 0 and e > 0, as 2^(e log₂ x) in f32 without a branch, so that loops over it become vector code.
///
/// With |log₂ x| < 8 the error is below (3 + 5 e) · 2^-23 of the result, and that of a distance (powers, then their root) below 2 · 10^-6; tests measure both.
/// `elementary::pow` is exact to f32 and takes ten times as long. 0 becomes at most 2^-63, and what is beyond 2^127 becomes that.
#[inline(always)]
pub(super) fn power(x: f32, e: f32) -> f32 {
    // 1.5 · 2^23: a number added to it is rounded to an integer that stands in the low bits.
    const SHIFT: f32 = 12_582_912.0;
    let y = smaller(larger(e * log2(x), -126.0), 127.0);
    let shifted = y + SHIFT;
    let rest = y - (shifted - SHIFT);
    let scale = f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23));
    exp2_series(rest) * scale
}

/// log₂ of a positive number: exponent and mantissa m in [√½, √2) taken apart, log₂ m = (2/ln 2) atanh s for s = (m - 1)/(m + 1).
#[inline(always)]
fn log2(x: f32) -> f32 {
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let bits = x.to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF) as i32) >> 23;
    let m = f32::from_bits(bits.wrapping_sub((exponent as u32) << 23));
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    // 2/ln 2 over 1, 3, 5, 7; the next term is below 2^-25.
    let series = 2.885_39 + z * (0.961_796_7 + z * (0.577_078 + z * 0.412_198_6));
    exponent as f32 + s * series
}

/// 2^r for |r| <= ½: Σ (r ln 2)^k / k! to k = 6.
#[inline(always)]
fn exp2_series(r: f32) -> f32 {
    1.0 + r * (LN_2 + r * (0.240_226_5 + r * (0.055_504_11 + r * (0.009_618_129 + r * (0.001_333_355_8 + r * 0.000_154_035_3)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_near_the_true_ones() {
        for e in [0.51_f32, 0.7, 1.0, 1.0 / 3.0, 2.5, 3.0, 4.0, 7.7, 16.0] {
            for x in (0..200_000).map(|i| f32::from_bits(0x3b80_0000 + i * 335)) {
                let (got, want) = (f64::from(power(x, e)), libm::pow(x.into(), e.into()));
                if (1e-37..1e37).contains(&want) {
                    let within = f64::from(3.0 + 5.0 * e) / 8_388_608.0;
                    assert!((got / want - 1.0).abs() < within, "{x}^{e} is {got:e}, not {want:e}: {:e} {within:e}", got / want - 1.0);
                }
            }
            assert!(power(0.0, e) < 1e-11, "0^{e} is {}", power(0.0, e));
            assert!(power(f32::INFINITY, e) >= 1e11 && power(f32::NAN, e).is_finite());
        }
    }

    #[test]
    fn lengths_are_near_the_true_ones() {
        for exponent in [0.5_f32, 0.7, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 15.9, 16.1, 100.0, f32::INFINITY] {
            for (dx, dy) in [(0.3_f32, -0.4_f32), (1.0, 1.0), (-2.5, 0.01), (0.7, 0.7), (0.0, 1.25), (0.02, 0.013)] {
                let (x, y) = (f64::from(dx.abs()), f64::from(dy.abs()));
                let e = f64::from(exponent).min(1e6);
                let want = x.max(y) * libm::pow(1.0 + libm::pow(x.min(y) / x.max(y), e), 1.0 / e);
                let got = f64::from(Metric::Minkowski { exponent }.length(dx, dy));
                assert!((got / want - 1.0).abs() < 2e-6, "Minkowski {exponent} of {dx} {dy} is {got}, not {want}");
            }
        }
        assert_eq!(Metric::Distance.length(3.0, -4.0), 5.0);
        assert_eq!(Metric::Squared.length(3.0, -4.0), 25.0);
        assert_eq!(Metric::Manhattan.length(3.0, -4.0), 7.0);
        assert_eq!(Metric::Chebychev.length(3.0, -4.0), 4.0);
    }
}
