//! How the heights of a mesh are rounded.

/// The greatest number a height can have in a mesh.
pub(super) const LAST: f64 = 32_767.0;

/// The finest step in metres: multiples of it within ±32,768 m, and their sums with 32,767 of it, are whole in 24 bits, as the header holds them.
const FINEST: f64 = 1.0 / 256.0;

/// The step that the edges of all tiles of a world are rounded to: the least power of two of which 32,767 span its vertical range (metres).
///
/// It follows from the world alone, so that neighbours round the heights of their edge to the same numbers.
pub(super) fn edge_step(range: [f64; 2]) -> f64 {
    // Rounding takes half a step at both ends, aligning the least height one more.
    finest_step(|step| (range[1] - range[0]) / step + 3.0)
}

/// The heights of a tile as header and numbers have them: `least + number · step`, exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertical {
    /// Metres, a multiple of the step.
    pub least: f64,
    /// Metres, a power of two no greater than that of edges.
    pub step: f64,
}

impl Vertical {
    /// The finest steps that hold all heights (metres); edges must be rounded already.
    pub(super) fn of(heights: impl Iterator<Item = f64> + Clone) -> Self {
        let (low, high) = (heights.clone().fold(f64::INFINITY, f64::min), heights.fold(f64::NEG_INFINITY, f64::max));
        let step = finest_step(|step| (high / step).ceil() - (low / step).floor());
        Self { least: (low / step).floor() * step, step }
    }

    /// The number of a height in metres.
    pub(super) fn number(&self, height: f64) -> u16 {
        ((height - self.least) / self.step + 0.5) as u16
    }

    /// The height of a number in metres.
    pub(super) fn height(&self, number: u16) -> f64 {
        self.least + f64::from(number) * self.step
    }

    /// The height of the greatest number in metres, as the header says it.
    pub(super) fn most(&self) -> f64 {
        self.least + LAST * self.step
    }
}

/// A height in metres rounded to a multiple of a step.
pub(super) fn round_to(step: f64, height: f64) -> f64 {
    (height / step + 0.5).floor() * step
}

/// The least power of two from [`FINEST`] on of which no more than 32,767 are needed.
fn finest_step(needed: impl Fn(f64) -> f64) -> f64 {
    let mut step = FINEST;
    while needed(step) > LAST {
        step *= 2.0;
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_two_that_hold_the_range() {
        assert_eq!((edge_step([-10_000.0, 9_000.0]), edge_step([-500.0, 4_500.0]), edge_step([-10_000.0, 32_767.0])), (1.0, 0.25, 2.0));
        assert_eq!(edge_step([0.0, 10.0]), FINEST);
    }

    /// Whatever way a client computes it, numbers of tiles with other steps come to the same bits.
    #[test]
    fn decoded_heights_are_exact() {
        for (low, high) in [(-10_000.0, 32_767.0), (-500.0, 4_500.0), (812.3, 815.9), (32_766.0, 32_767.0)] {
            let vertical = Vertical::of([low, high].into_iter());
            let (least, most) = (vertical.least as f32, vertical.most() as f32);
            assert_eq!((f64::from(least), f64::from(most)), (vertical.least, vertical.most()), "the header holds them");
            let (least, span) = (f64::from(least), f64::from(most) - f64::from(least));
            for number in 0..=32_767_u16 {
                let want = vertical.height(number);
                assert_eq!(want, least + f64::from(number) / LAST * span);
                assert_eq!(want, least + f64::from(number) * span / LAST);
                assert_eq!(want, least + f64::from(number) * (span / LAST));
                assert_eq!(vertical.number(want), number);
            }
        }
    }

    #[test]
    fn a_tile_never_needs_coarser_steps_than_its_edges() {
        for range in [[-10_000.0, 9_000.0], [-500.0, 4_500.0], [-1.0, 8_190.7], [0.0, 127.9]] {
            let edge = edge_step(range);
            let heights = range.map(|height| round_to(edge, height));
            assert!(Vertical::of(heights.into_iter()).step <= edge, "{range:?}");
        }
    }
}
