//! A terrain programme with its measures: the base of a world, and what the library keeps.

use super::{
    number::{whole, whole_pair},
    object::Object,
    problem::{Checks, Problem},
};
use crate::{
    geometry::PLANE_LIMIT,
    programme::{MAX_METRES, Programme},
};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::value::RawValue;
use std::ops::Range;

/// What both RGB encodings can hold, in metres.
const ELEVATIONS: Range<f64> = -10_000.0..32_767.0;

/// The vertical range that elevations are clamped to, in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ElevationRange {
    /// Least elevation.
    #[serde(serialize_with = "whole")]
    pub min: f64,
    /// Greatest elevation.
    #[serde(serialize_with = "whole")]
    pub max: f64,
}

/// The terrain beneath all layers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Base {
    /// The terrain programme.
    #[serde(serialize_with = "programme")]
    pub programme: Programme,
    /// Metres per programme unit.
    #[serde(serialize_with = "whole")]
    pub scale: f64,
    /// Plane metres of the programme's origin.
    #[serde(serialize_with = "whole_pair")]
    pub origin: [f64; 2],
    /// Metres of elevation per unit of the programme's value.
    #[serde(serialize_with = "whole")]
    pub amplitude: f64,
    /// Metres of elevation where the programme is 0.
    #[serde(serialize_with = "whole")]
    pub datum: f64,
}

/// A vertical range as users write it.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenRange {
    min: Option<f64>,
    max: Option<f64>,
}

/// The base as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenBase<'a> {
    #[serde(borrow)]
    pub programme: &'a RawValue,
    pub scale: f64,
    pub origin: Option<[f64; 2]>,
    pub amplitude: Option<f64>,
    pub datum: Option<f64>,
}

/// Checks and completes a vertical range and the elevation of the sea's surface.
pub(super) fn vertical(range: Option<Object<WrittenRange>>, sea_level: Option<f64>, checks: &mut Checks) -> (ElevationRange, f64) {
    let Object(range) = range.unwrap_or_default();
    let elevation = ElevationRange { min: range.min.unwrap_or(-10_000.0), max: range.max.unwrap_or(9_000.0) };
    let sea_level = sea_level.unwrap_or(0.0);
    for (pointer, value) in [("/elevation/min", elevation.min), ("/elevation/max", elevation.max), ("/sea_level", sea_level)] {
        checks.range(pointer, value, ELEVATIONS.start, ELEVATIONS.end);
    }
    if elevation.min >= elevation.max {
        checks.add("/elevation", format!("min must be less than max, got {} and {}", elevation.min, elevation.max));
    }
    (elevation, sea_level)
}

impl WrittenBase<'_> {
    /// Checks and completes what stands at the pointer `at` of a document.
    pub(super) fn complete(self, at: &str, checks: &mut Checks) -> Option<Base> {
        let (origin, amplitude, datum) = (self.origin.unwrap_or_default(), self.amplitude.unwrap_or(1_000.0), self.datum.unwrap_or(0.0));
        if !(self.scale > 0.0 && self.scale <= PLANE_LIMIT) {
            checks.add(&format!("{at}/scale"), format!("must be more than 0 and at most 2^40 metres per programme unit, got {}", self.scale));
        }
        for (i, value) in origin.into_iter().enumerate() {
            checks.range(&format!("{at}/origin/{i}"), value, -PLANE_LIMIT, PLANE_LIMIT);
        }
        checks.range(&format!("{at}/amplitude"), amplitude, -MAX_METRES, MAX_METRES);
        checks.range(&format!("{at}/datum"), datum, -MAX_METRES, MAX_METRES);
        let json = self.programme.get();
        match Programme::parse_json(json) {
            Ok(programme) => Some(Base { programme, scale: self.scale, origin, amplitude, datum }),
            Err(error) => {
                checks.0.push(Problem::of_programme(&format!("{at}/programme"), json.starts_with('"'), error));
                None
            }
        }
    }
}

/// Text as it was written; a tree in canonical JSON.
pub(super) fn programme<S: Serializer>(programme: &Programme, serializer: S) -> Result<S::Ok, S::Error> {
    match programme.text() {
        Some(text) => serializer.serialize_str(text),
        None => programme.to_json().serialize(serializer),
    }
}
