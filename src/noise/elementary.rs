//! Elementary functions of f32, the same bits on every machine.
//!
//! Each reduces its argument and sums a series in f64, so that one rounding to f32 remains: the error is below 0.501 units in the last place (a test measures it
//! against `libm`'s f64 functions). Only additions, multiplications, divisions and bit operations are used.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, LN_2, LOG2_E};

/// π/2 in two parts: the first has 33 bits, so its product with a quotient below 2^20 is exact.
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;

/// Up to this |x| two parts of π/2 suffice to reduce an argument.
pub const SMALL: f32 = 1_048_576.0;

/// The nearest integer, ties to even, and its low 32 bits, for |x| < 2^51.
#[inline(always)]
fn round(x: f64) -> (f64, u32) {
    // At 3 · 2^51 the spacing of f64 is 1, so the sum is rounded to an integer that stands in the low bits.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    let shifted = x + SHIFT;
    (shifted - SHIFT, shifted.to_bits() as u32)
}

/// Σ `c_i` z^i.
#[inline(always)]
fn polynomial<const N: usize>(z: f64, coefficients: [f64; N]) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// Sine and cosine of r, |r| ≤ π/4.
#[inline(always)]
fn sine_cosine(r: f64) -> (f64, f64) {
    let z = r * r;
    let sine = r * polynomial(z, [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5_040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0]);
    let cosine = polynomial(z, [1.0, -0.5, 1.0 / 24.0, -1.0 / 720.0, 1.0 / 40_320.0, -1.0 / 3_628_800.0, 1.0 / 479_001_600.0]);
    (sine, cosine)
}

/// 2/π after 32 zero bits.
const TWO_OVER_PI: [u32; 9] = [0, 0xa2f9_836e, 0x4e44_1529, 0xfc27_57d1, 0xf534_ddc0, 0xdb62_9599, 0x3c43_9041, 0xfe51_63ab, 0xdebb_c561];

/// x as a multiple of π/2 (mod 4) and the rest, |x| > [`SMALL`] and finite.
///
/// M. H. Payne and R. N. Hanek, "Radian reduction for trigonometric functions" (1983): with x = m · 2^e, the bits of 2/π that make whole turns of m are left
/// out, and of the rest 96 suffice.
fn reduce_large(x: f32) -> (u32, f64) {
    let bits = x.to_bits();
    let (m, e) = ((bits & 0x7f_ffff) | 0x80_0000, ((bits >> 23) & 0xff) as i32 - 150);
    let from = (32 + e - 2) as usize;
    let words = TWO_OVER_PI[from / 32..][..4].iter().fold(0_u128, |bits, word| bits << 32 | u128::from(*word));
    let window = (words << (from % 32)) >> 32;
    let turns = (u128::from(m) * window) >> 32;
    // The two bits above the point count quadrants; what is below, read with its sign, is the nearest quadrant's rest.
    let turns = turns as u64;
    let quadrant = (turns.wrapping_add(1 << 61) >> 62) as u32;
    let rest = ((turns << 2) as i64) as f64 * (FRAC_PI_2 / 18_446_744_073_709_551_616.0);
    if x.is_sign_negative() { (quadrant.wrapping_neg() & 3, -rest) } else { (quadrant, rest) }
}

/// x as a multiple of π/2 (mod 4) and the rest, |x| ≤ [`SMALL`].
#[inline(always)]
fn reduce_small(x: f32) -> (u32, f64) {
    let x = f64::from(x);
    let (quotient, bits) = round(x * FRAC_2_PI);
    let rest = (x - quotient * HALF_PI_HIGH) - quotient * HALF_PI_LOW;
    (bits & 3, rest)
}

/// x as a multiple of π/2 (mod 4) and the rest; x is finite.
#[inline(always)]
fn reduce(x: f32) -> (u32, f64) {
    if x.abs() <= SMALL { reduce_small(x) } else { reduce_large(x) }
}

/// The sine of x radians; not a number if x is not finite.
#[inline(always)]
#[must_use]
pub fn sin(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    sin_of(reduce(x))
}

/// [`sin`] for |x| ≤ [`SMALL`], without a branch.
#[inline(always)]
#[must_use]
pub fn sin_small(x: f32) -> f32 {
    sin_of(reduce_small(x))
}

#[inline(always)]
fn sin_of((quadrant, rest): (u32, f64)) -> f32 {
    let (sine, cosine) = sine_cosine(rest);
    let value = if quadrant & 1 == 0 { sine } else { cosine };
    (if quadrant & 2 == 0 { value } else { -value }) as f32
}

/// The cosine of x radians; not a number if x is not finite.
#[inline(always)]
#[must_use]
pub fn cos(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    cos_of(reduce(x))
}

/// [`cos`] for |x| ≤ [`SMALL`], without a branch.
#[inline(always)]
#[must_use]
pub fn cos_small(x: f32) -> f32 {
    cos_of(reduce_small(x))
}

#[inline(always)]
fn cos_of((quadrant, rest): (u32, f64)) -> f32 {
    let (sine, cosine) = sine_cosine(rest);
    let value = if quadrant & 1 == 0 { cosine } else { sine };
    (if (quadrant + 1) & 2 == 0 { value } else { -value }) as f32
}

/// The tangent of x radians; not a number if x is not finite.
#[inline(always)]
#[must_use]
pub fn tan(x: f32) -> f32 {
    if !x.is_finite() {
        return f32::NAN;
    }
    tan_of(reduce(x))
}

/// [`tan`] for |x| ≤ [`SMALL`], without a branch.
#[inline(always)]
#[must_use]
pub fn tan_small(x: f32) -> f32 {
    tan_of(reduce_small(x))
}

#[inline(always)]
fn tan_of((quadrant, rest): (u32, f64)) -> f32 {
    let (sine, cosine) = sine_cosine(rest);
    (if quadrant & 1 == 0 { sine / cosine } else { -(cosine / sine) }) as f32
}

/// The arc tangent, in [-π/2, π/2].
#[inline(always)]
#[must_use]
pub fn atan(x: f32) -> f32 {
    const TAN_22_5: f64 = 0.414_213_562_373_095_03;
    let magnitude = f64::from(x.abs());
    // atan a = π/2 - atan 1/a, and atan a = π/4 + atan (a - 1)/(a + 1), bring the argument below tan 22.5°.
    let inverted = magnitude > 1.0;
    let a = if inverted { 1.0 / magnitude } else { magnitude };
    let turned = a > TAN_22_5;
    let t = if turned { (a - 1.0) / (a + 1.0) } else { a };
    let z = t * t;
    let series =
        [1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0, -1.0 / 15.0, 1.0 / 17.0, -1.0 / 19.0, 1.0 / 21.0, -1.0 / 23.0, 1.0 / 25.0];
    let angle = t * polynomial(z, series) + if turned { FRAC_PI_4 } else { 0.0 };
    let angle = if inverted { FRAC_PI_2 - angle } else { angle };
    (if x.is_sign_negative() { -angle } else { angle }) as f32
}

/// Exponent e and mantissa m of a = m · 2^e, m in [√½, √2), a > 0 and finite; something finite for other a.
#[inline(always)]
fn split(a: f32) -> (f64, f64) {
    const SQRT_HALF: u32 = 0x3f35_04f3;
    let denormal = a < f32::MIN_POSITIVE;
    let bits = (if denormal { a * 16_777_216.0 } else { a }).to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF) as i32) >> 23;
    let mantissa = f32::from_bits(bits.wrapping_sub((exponent as u32) << 23));
    (f64::from(exponent - if denormal { 24 } else { 0 }), f64::from(mantissa))
}

/// ln m = 2 atanh s for s = (m - 1)/(m + 1), m in [√½, √2).
#[inline(always)]
fn ln_mantissa(m: f64) -> f64 {
    let s = (m - 1.0) / (m + 1.0);
    let series = [2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0, 2.0 / 11.0, 2.0 / 13.0, 2.0 / 15.0, 2.0 / 17.0];
    s * polynomial(s * s, series)
}

/// The natural logarithm; -∞ at 0, not a number below.
#[inline(always)]
#[must_use]
pub fn ln(a: f32) -> f32 {
    // Computed for every a and then replaced, so that a loop has no branch.
    let (exponent, mantissa) = split(a);
    let value = (exponent * LN_2 + ln_mantissa(mantissa)) as f32;
    let value = if a == f32::INFINITY { a } else { value };
    let value = if a == 0.0 { f32::NEG_INFINITY } else { value };
    if a >= 0.0 { value } else { f32::NAN }
}

/// e^y rounded to f32, for any y that is a number.
#[inline(always)]
fn exp_f64(y: f64) -> f32 {
    let y = y.clamp(-200.0, 200.0);
    let (whole, bits) = round(y * LOG2_E);
    let rest = y - whole * LN_2;
    let series =
        [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5_040.0, 1.0 / 40_320.0, 1.0 / 362_880.0, 1.0 / 3_628_800.0, 1.0 / 39_916_800.0];
    let scale = f64::from_bits(((i64::from(bits as i32) + 1023) as u64) << 52);
    (polynomial(rest, series) * scale) as f32
}

/// e^x.
#[inline(always)]
#[must_use]
pub fn exp(x: f32) -> f32 {
    if x.is_nan() { x } else { exp_f64(x.into()) }
}

/// a^b, not a number where it would be complex.
///
/// 1 for b = 0, whatever a; the sign of a for odd b.
#[inline(always)]
#[must_use]
pub fn pow(a: f32, b: f32) -> f32 {
    if b == 0.0 || a == 1.0 {
        return 1.0;
    }
    let magnitude = a.abs();
    if !(magnitude > 0.0 && magnitude < f32::INFINITY && b.abs() < f32::INFINITY) {
        return pow_of_extremes(a, b);
    }
    let (exponent, mantissa) = split(magnitude);
    let power = exp_f64(f64::from(b) * (exponent * LN_2 + ln_mantissa(mantissa)));
    if a > 0.0 {
        power
    } else if b.floor() != b {
        f32::NAN
    } else if is_odd(b) {
        -power
    } else {
        power
    }
}

/// Whether a whole number is odd; from 2^24 on every f32 is even.
#[inline]
fn is_odd(b: f32) -> bool {
    let half = b * 0.5;
    half.floor() != half
}

/// Powers of 0, infinities and what is not a number, as IEEE 754 has them.
#[cold]
fn pow_of_extremes(a: f32, b: f32) -> f32 {
    if a.is_nan() || b.is_nan() {
        return f32::NAN;
    }
    let magnitude = a.abs();
    if b.is_infinite() {
        let grows = (magnitude > 1.0) == (b > 0.0);
        return if magnitude == 1.0 {
            1.0
        } else if grows {
            f32::INFINITY
        } else {
            0.0
        };
    }
    let power = if (magnitude == 0.0) == (b > 0.0) { 0.0 } else { f32::INFINITY };
    if a.is_sign_negative() && b.floor() == b && is_odd(b) { -power } else { power }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Arguments over the whole range of f32: every 4,099th bit pattern and the awkward ones.
    fn arguments() -> impl Iterator<Item = f32> {
        let awkward =
            [0.0, -0.0, 1.0, -1.0, f32::MIN_POSITIVE, f32::MAX, f32::MIN, f32::from_bits(1), 0.5, core::f32::consts::FRAC_PI_2, core::f32::consts::PI];
        (0..=u32::MAX).step_by(4_099).map(f32::from_bits).filter(|x| x.is_finite()).chain(awkward)
    }

    /// Units in the last place between a result and the exact value.
    fn error(got: f32, exact: f64) -> f64 {
        if f64::from(got) == exact || (exact.abs() > f64::from(f32::MAX) && got.is_infinite()) {
            return 0.0;
        }
        let nearest = exact as f32;
        let ulp = f64::from(f32::from_bits(nearest.abs().to_bits() + 1)) - f64::from(nearest.abs());
        (f64::from(got) - exact).abs() / ulp
    }

    fn check(name: &str, function: fn(f32) -> f32, exact: fn(f64) -> f64, domain: impl Fn(f32) -> bool) {
        let worst = arguments().filter(|&x| domain(x)).map(|x| (error(function(x), exact(x.into())), x)).max_by(|a, b| a.0.total_cmp(&b.0)).expect("arguments");
        assert!(worst.0 < 0.501, "{name}({:e}) is off by {} ulp", worst.1, worst.0);
    }

    #[test]
    fn errors_stay_within_half_a_unit_and_a_little() {
        check("sin", sin, libm::sin, |_| true);
        check("cos", cos, libm::cos, |_| true);
        check("tan", tan, libm::tan, |_| true);
        check("atan", atan, libm::atan, |_| true);
        check("ln", ln, libm::log, |x| x > 0.0);
        check("exp", exp, libm::exp, |_| true);
        for b in [-3.0, -1.5, -0.1, 0.3333, 0.5, 2.0, 3.0, 7.7] {
            for a in arguments().filter(|&a| a != 0.0) {
                let exact = libm::pow(a.into(), f64::from(b));
                let got = pow(a, b);
                assert!(exact.is_nan() && got.is_nan() || error(got, exact) < 0.501, "pow({a:e}, {b}) is {got:e}, not {exact:e}");
            }
        }
    }

    #[test]
    fn extremes_are_as_ieee_has_them() {
        for a in [0.0, -0.0, 1.0, -1.0, 0.5, -2.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            for b in [0.0, -0.0, 1.0, -1.0, 2.0, -3.0, 0.5, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 16_777_216.0] {
                let (got, want) = (pow(a, b), libm::powf(a, b));
                assert!(got.to_bits() == want.to_bits() || got.is_nan() && want.is_nan(), "pow({a}, {b}) is {got}, not {want}");
            }
        }
        assert!(sin(f32::INFINITY).is_nan() && cos(f32::NAN).is_nan() && tan(f32::NEG_INFINITY).is_nan() && ln(-1.0).is_nan() && exp(f32::NAN).is_nan());
        assert_eq!((exp(f32::NEG_INFINITY), exp(f32::INFINITY), ln(f32::INFINITY), ln(0.0)), (0.0, f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY));
        assert_eq!((atan(f32::INFINITY), sin(-0.0).to_bits()), (core::f32::consts::FRAC_PI_2, (-0.0_f32).to_bits()));
    }
}
