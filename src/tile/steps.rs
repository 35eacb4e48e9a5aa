//! Elevations as whole steps over a vertical range, rounded to nearest.

use super::rgb;

/// The greatest number of 24 bits and of 16 bits.
const LAST_24: f64 = 16_777_215.0;
const LAST_16: f64 = 65_535.0;

/// A vertical range cut into equal steps: step 0 is its least elevation, the last step its greatest.
///
/// ```
/// use terrane::tile::Steps;
/// let steps = Steps::of_16_bits([-500.0, 4_500.0]);
/// assert_eq!((steps.number(-500.0), steps.number(4_500.0), steps.number(9_999.0)), (0, 65_535, 65_535));
/// assert_eq!(steps.elevation(65_535), 4_500.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    low: f64,
    span: f64,
    last: f64,
}

impl Steps {
    /// The steps of `fit`: 24 bits over a range in metres, its least elevation first.
    #[must_use]
    pub fn of_24_bits(range: [f64; 2]) -> Self {
        Self { low: range[0], span: range[1] - range[0], last: LAST_24 }
    }

    /// The steps of `height16` and `r16`: 16 bits over a range in metres, its least elevation first.
    #[must_use]
    pub fn of_16_bits(range: [f64; 2]) -> Self {
        Self { low: range[0], span: range[1] - range[0], last: LAST_16 }
    }

    /// Metres of a step.
    #[must_use]
    pub fn metres(&self) -> f64 {
        self.span / self.last
    }

    /// The step nearest to an elevation in metres; what lies beyond the range is clamped to it.
    #[must_use]
    #[inline]
    pub fn number(&self, elevation: f32) -> u32 {
        // The cast truncates towards zero and saturates at zero; what is no number, as in a range without height, becomes the last step.
        (((f64::from(elevation) - self.low) / self.span * self.last).min(self.last) + 0.5) as u32
    }

    /// The elevation of a step in metres.
    #[must_use]
    pub fn elevation(&self, number: u32) -> f64 {
        self.low + f64::from(number) / self.last * self.span
    }
}

/// R·65536 + G·256 + B steps.
#[inline]
pub(super) fn fit(steps: &Steps, elevation: f32, bits: u32) -> [u8; 3] {
    rgb::bytes(steps.number(elevation), bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elevations_come_back_within_half_a_step() {
        for range in [[-500.0, 4_500.0], [-10_000.0, 32_767.0], [0.0, 0.25]] {
            for steps in [Steps::of_16_bits(range), Steps::of_24_bits(range)] {
                for i in 0..=100_000_u32 {
                    let elevation = (range[0] + (range[1] - range[0]) * f64::from(i) / 100_000.0) as f32;
                    let back = steps.elevation(steps.number(elevation));
                    assert!((back - f64::from(elevation)).abs() <= 0.5 * steps.metres() + 1e-9, "{range:?}: {elevation} came back as {back}");
                }
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_clamped() {
        let steps = Steps::of_24_bits([-100.0, 100.0]);
        assert_eq!((fit(&steps, -1e9, 0), fit(&steps, 1e9, 0), fit(&steps, f32::NAN, 0)), ([0, 0, 0], [255, 255, 255], [255, 255, 255]));
        assert_eq!(fit(&steps, -100.0, 0), [0, 0, 0]);
        let flat = Steps::of_16_bits([7.0, 7.0]);
        assert_eq!((flat.number(7.0), flat.elevation(flat.number(7.0))), (65_535, 7.0), "a range without height");
    }
}
