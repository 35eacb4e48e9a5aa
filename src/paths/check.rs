//! Numbers and names of drawings: what they must be.

use super::{
    document::{Drawing, DrawingError, Edges, Quantity, SeaLevel},
    plan::MAX_NODES,
};
use crate::geometry::PLANE_LIMIT;
use core::ops::RangeInclusive;

/// Most groups of strokes, and most profiles.
const MAX_GROUPS: usize = 256;

/// Most rules of ridges.
const MAX_RULES: usize = 64;

/// Greatest bias: with it the blend is the maximum.
pub(super) const MAX_BIAS: f64 = 1000.0;

/// Refuses a number outside its range.
pub(super) fn range(at: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), DrawingError> {
    if range.contains(&value) { Ok(()) } else { Err(DrawingError::new(at, format!("must be {} … {}, got {value}", range.start(), range.end()))) }
}

/// Refuses a drawing with a number outside its range.
pub(super) fn check(drawing: &Drawing) -> Result<(), DrawingError> {
    let [columns, rows] = drawing.size;
    if columns < 2 || rows < 2 || columns.saturating_mul(rows) > MAX_NODES {
        return Err(DrawingError::new("/size", format!("must be at least 2 × 2 and at most {MAX_NODES} nodes together, got {columns} × {rows}")));
    }
    for (at, count, most) in
        [("/strokes", drawing.strokes.len(), MAX_GROUPS), ("/ridges", drawing.ridges.len(), MAX_RULES), ("/profiles", drawing.profiles.len(), MAX_GROUPS)]
    {
        if count > most {
            return Err(DrawingError::new(at, format!("must be at most {most}, got {count}")));
        }
    }
    range("/spacing", drawing.spacing, 1e-3..=1e6)?;
    for (axis, origin) in drawing.origin.iter().enumerate() {
        range(&format!("/origin/{axis}"), *origin, -PLANE_LIMIT..=PLANE_LIMIT)?;
    }
    range("/vertical_scale", drawing.vertical_scale, 1e-6..=1e6)?;
    range("/sea_threshold", drawing.sea_threshold, 1e-6..=1e6)?;
    range("/approximate_threshold", drawing.approximate_threshold, 0.0..=0.5)?;
    range("/least_scale", drawing.least_scale, 1e-6..=1.0)?;
    if let Quantity::Number(bias) = drawing.bias {
        range("/bias", bias, 0.0..=MAX_BIAS)?;
    }
    match &drawing.edges {
        Edges::Random { mean, deviation } => {
            range("/edges/random/mean", *mean, 1e-6..=1e6)?;
            if !(0.0..*mean).contains(deviation) {
                return Err(DrawingError::new("/edges/random/deviation", format!("must be 0 up to less than the mean {mean}, got {deviation}")));
            }
        }
        Edges::Picture { range: [black, white], .. } => {
            for (i, weight) in [black, white].into_iter().enumerate() {
                range(&format!("/edges/picture/range/{i}"), *weight, 1e-6..=1e6)?;
            }
        }
    }
    match drawing.sea_level {
        SeaLevel::Scale(scale) => range("/sea_level/scale", scale, 0.0..=1e3),
        SeaLevel::Cost(cost) => range("/sea_level/cost", cost, 1e-6..=1e6),
    }
}

/// The numbers of named groups.
pub(super) fn group_numbers(drawing: &Drawing, names: &[String], at: &str) -> Result<Vec<usize>, DrawingError> {
    let mut numbers = Vec::new();
    for name in names {
        let before = numbers.len();
        numbers.extend((0..drawing.strokes.len()).filter(|i| drawing.strokes[*i].name.as_ref() == Some(name)));
        if numbers.len() == before {
            return Err(DrawingError::new(at, format!("no group of strokes is called {name:?}")));
        }
    }
    Ok(numbers)
}
