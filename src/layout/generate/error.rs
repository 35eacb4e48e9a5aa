//! What a generator refuses.

use std::ops::RangeInclusive;

/// Why a layout cannot be generated. Every message begins with the place of what is wrong, such as `rivers.spacing`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GenerateError {
    /// A parameter outside its range.
    #[error("{place}: must be a number from {low} to {high}, got {value}")]
    Range {
        /// The generator and its parameter.
        place: &'static str,
        /// The least value allowed.
        low: f64,
        /// The greatest value allowed.
        high: f64,
        /// The value given.
        value: f64,
    },
    /// A feature that a generator cannot start from.
    #[error("{place}[{index}]: {reason}")]
    Seed {
        /// The list the feature is in.
        place: &'static str,
        /// Its index in the list.
        index: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Something that is wrong only together with the terrain or with other features.
    #[error("{place}: {reason}")]
    Unfit {
        /// The generator and its parameter.
        place: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// More features than a layout may have.
    #[error("{place}: about {expected:.0} points would be needed, {limit} are allowed; choose a wider spacing or a smaller land")]
    TooMany {
        /// The generator and its parameter.
        place: &'static str,
        /// The number of points expected.
        expected: f64,
        /// The limit.
        limit: usize,
    },
    /// A generated shape is none, such as one too far from the origin.
    #[error("shape: {0}")]
    Shape(#[from] crate::geometry::ShapeError),
    /// A style's attributes do not fit.
    #[error("style: {0}")]
    Attribute(#[from] crate::layout::AttributeError),
    /// A style's attributes do not fit the shapes.
    #[error("style: {0}")]
    Feature(#[from] crate::layout::FeatureError),
}

/// Checks that a parameter lies in its range; NaN never does.
pub(in crate::layout) fn check(place: &'static str, value: f64, range: RangeInclusive<f64>) -> Result<(), GenerateError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(GenerateError::Range { place, low: *range.start(), high: *range.end(), value })
}
