//! How the weight of an attribute falls with distance.

use super::Expression;

/// A weight as a function of distance; zero beyond the attribute's range a (Benjaminsen 2021, equations 4.4 to 4.6).
#[derive(Clone, Debug, PartialEq)]
pub enum Weight {
    /// max(0, 1 - d/a).
    Linear,
    /// width · max(0, 1 - d/a) / max(d, nearest): ridges.
    Sharp {
        /// Metres at which the weight of an infinite range is 1; 1 by default.
        width: f64,
        /// Metres below which the weight grows no more; 0.001 by default.
        nearest: f64,
    },
    /// max(0, (1 - (d/a)^4) / ((d/width)^2 + 1)): valleys, V-shaped for a small width, U-shaped for a large one.
    Smooth {
        /// Metres at which the weight of an infinite range is one half.
        width: f64,
    },
    /// An expression in the distance; negative values and what is not a number are 0.
    Custom(Expression),
}

impl Weight {
    /// The weight of ridges with its default sizes.
    #[must_use]
    pub fn sharp() -> Self {
        Self::Sharp { width: 1.0, nearest: 0.001 }
    }
}
