//! Terraces: flat treads with steep risers.

use super::graph::Exact;

/// What turns a height into steps: n a unit; the riser takes the last 1 - sharpness of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Terrace {
    pub(super) n: Exact,
    pub(super) sharpness: Exact,
}

impl Terrace {
    pub(super) fn new(n: f64, sharpness: f64) -> Self {
        Self { n: Exact::new(n), sharpness: Exact::new(sharpness) }
    }

    /// Steps a unit of height.
    pub(super) fn steps(self) -> f64 {
        self.n.get()
    }

    /// The greatest ratio of the terraces' slope to that of what they are made of.
    pub(super) fn max_slope(self) -> f64 {
        1.5 / (1.0 - self.sharpness.get())
    }

    /// With t = n h: (⌊t⌋ + r² (3 - 2 r)) / n, r = clamp((t - ⌊t⌋ - sharpness) / (1 - sharpness), 0, 1).
    #[inline(always)]
    pub(super) fn apply(self, h: f32) -> f32 {
        let (n, sharpness) = (self.n.get() as f32, self.sharpness.get() as f32);
        let t = n * h;
        let below = t.floor();
        let r = ((t - below - sharpness) / (1.0 - sharpness)).clamp(0.0, 1.0);
        (below + r * r * (3.0 - 2.0 * r)) / n
    }

    /// The derivative by h.
    #[inline(always)]
    pub(super) fn slope(self, h: f32) -> f32 {
        let (n, sharpness) = (self.n.get() as f32, self.sharpness.get() as f32);
        let t = n * h;
        let r = ((t - t.floor() - sharpness) / (1.0 - sharpness)).clamp(0.0, 1.0);
        6.0 * r * (1.0 - r) / (1.0 - sharpness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn treads_are_flat_and_risers_join_them() {
        let terrace = Terrace::new(4.0, 0.5);
        assert_eq!([0.0, 0.1, 0.125].map(|h| terrace.apply(h)), [0.0; 3]);
        assert_eq!(terrace.apply(0.1875), 0.125);
        assert_eq!([0.25, 0.3, -0.25].map(|h| terrace.apply(h)), [0.25, 0.25, -0.25]);
        for i in -4_000..4_000 {
            let h = i as f32 / 1_000.0;
            let (lower, upper) = (f64::from(terrace.apply(h - 0.0005)), f64::from(terrace.apply(h + 0.0005)));
            assert!((upper - lower) / 0.001 <= terrace.max_slope() + 1e-2, "{h}");
            assert!(((upper - lower) / 0.001 - f64::from(terrace.slope(h))).abs() < 0.05, "{h}");
        }
    }
}
