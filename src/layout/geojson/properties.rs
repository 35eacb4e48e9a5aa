//! The properties of a feature that say how it forms the terrain.

use super::{
    attribute::read_set,
    drawn::{Attributes, Fine, Mpd},
    geometry::Measures,
    members::{Members, shown},
    problem::Problems,
    read::Shared,
};
use crate::geometry::{Along, Detail, MAX_ITERATIONS};
use serde_json::{Map, Value};

const MODES: [(&str, Mode); 4] = [("dynamic", Mode::Dynamic), ("static", Mode::Static), ("split", Mode::Split), ("overlap", Mode::Overlap)];
const WAYS: [(&str, Along); 2] = [("chord", Along::Chord), ("arc", Along::Arc)];

#[derive(Clone, Copy)]
enum Mode {
    Dynamic,
    Static,
    Split,
    Overlap,
}

/// What the properties say, as far as they could be read.
pub(super) struct Properties {
    pub attributes: Option<Attributes>,
    pub measures: Measures,
    pub detail: Option<Mpd>,
    pub precedence: i32,
    /// All other properties, as JSON.
    pub rest: Option<Box<str>>,
}

pub(super) fn read(value: Value, shared: &mut Shared, problems: &mut Problems) -> Option<Properties> {
    let value = if value.is_null() { Value::Object(Map::new()) } else { value };
    let mut members = Members::of(value, "/properties", "an object", problems)?;
    let attributes = members.need("attributes", "the name of a set of attributes, or a list of attributes", problems);
    let attributes = attributes.and_then(|value| read_attributes(value, "/properties/attributes", shared, problems));
    let radius = members.number("radius", problems);
    let elevation = members.number("elevation", problems);
    let along = members.choice("along", &WAYS, problems).unwrap_or_default();
    let detail = members.take("detail").and_then(|detail| read_detail(detail, shared, problems));
    let precedence = members.take("precedence").map_or(Some(0), |value| whole(&value));
    if precedence.is_none() {
        problems.add("/properties/precedence", "must be a whole number from -2147483648 to 2147483647");
    }
    let rest = members.rest();
    let rest = (!rest.is_empty()).then(|| Value::Object(rest).to_string().into());
    Some(Properties { attributes, measures: Measures { radius, elevation, along }, detail, precedence: precedence.unwrap_or_default(), rest })
}

fn whole(value: &Value) -> Option<i32> {
    value.as_f64().filter(|number| number.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(number)).map(|number| number as i32)
}

pub(super) fn read_attributes(value: Value, pointer: &str, shared: &mut Shared, problems: &mut Problems) -> Option<Attributes> {
    match value {
        Value::String(name) => Some(Attributes::Named(shared.name(&name))),
        list @ Value::Array(_) => shared.list(list, |list| read_set(list, pointer, problems)).map(Attributes::Inline),
        other => {
            problems.add(pointer, format!("must be the name of a set of attributes or a list of attributes, got {}", shown(&other)));
            None
        }
    }
}

fn read_detail(value: Value, shared: &mut Shared, problems: &mut Problems) -> Option<Mpd> {
    let at = "/properties/detail";
    let mut members = Members::of(value, at, "an object with iterations, displacement, seed, mode", problems)?;
    let before = problems.count();
    let iterations = members.whole("iterations", u64::from(MAX_ITERATIONS), problems);
    let displacement = members.number("displacement", problems);
    for (name, missing) in [("iterations", iterations.is_none()), ("displacement", displacement.is_none())] {
        if missing && problems.count() == before {
            problems.add(members.at(name), "is missing");
        }
    }
    let seed = members.whole("seed", u64::MAX, problems).unwrap_or_default();
    let mode = members.choice("mode", &MODES, problems).unwrap_or(Mode::Dynamic);
    let fine = match mode {
        Mode::Dynamic => Some(Fine::Dynamic),
        Mode::Static => Some(Fine::Static),
        Mode::Split => Some(Fine::Split),
        Mode::Overlap => {
            let what = "the attributes of the fine features that mode overlap lays over the coarse one: a name or a list";
            let fine = members.need("attributes", what, problems);
            fine.and_then(|value| read_attributes(value, "/properties/detail/attributes", shared, problems)).map(Fine::Overlap)
        }
    };
    members.done(problems);
    match Detail::new(iterations? as u8, displacement?, seed) {
        Ok(detail) => Some(Mpd { detail, fine: fine? }),
        Err(error) => {
            problems.add(format!("{at}/displacement"), error.to_string());
            None
        }
    }
}
