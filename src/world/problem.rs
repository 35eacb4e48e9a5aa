//! What can be wrong with a document, and how it is told.

use super::{number::MAX_SEED, object::Object};
use crate::{
    layout::geojson::{self, ReadError},
    programme::{ParseError, Programme},
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::fmt;

/// Something wrong with a document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// A JSON pointer (RFC 6901) into the document.
    pub pointer: String,
    /// What is wrong and what would be right.
    pub detail: String,
    /// In programme text: the pointer of the wrong node in the programme's tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
    /// In programme text: the first wrong character (Unicode scalar values from 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<usize>,
    /// In programme text: the character after the last wrong one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end: Option<usize>,
}

impl Problem {
    /// Something wrong at a pointer.
    #[must_use]
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into(), at: None, start: None, end: None }
    }

    /// A problem of a programme that stands at `pointer`, as text or as a tree.
    pub(super) fn of_programme(pointer: &str, text: bool, error: ParseError) -> Self {
        if !text {
            return Self::new(format!("{pointer}{}", error.at), error.message);
        }
        let (start, end) = error.span.map_or((None, None), |span| (Some(span.start), Some(span.end)));
        Self { pointer: pointer.to_owned(), detail: error.message, at: Some(error.at), start, end }
    }
}

impl From<geojson::Problem> for Problem {
    fn from(problem: geojson::Problem) -> Self {
        Self::new(problem.pointer, problem.detail)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", if self.pointer.is_empty() { "/" } else { &self.pointer })?;
        if let Some(at) = self.at.as_ref().filter(|at| !at.is_empty()) {
            write!(f, "at {at}: ")?;
        }
        if let Some(start) = self.start {
            write!(f, "character {}: ", start + 1)?;
        }
        f.write_str(&self.detail)
    }
}

/// Why something is not the document it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DocumentError {
    /// Not JSON at all.
    #[error("not JSON: {0}")]
    Syntax(String),
    /// JSON, but not such a document; every problem found.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

/// Problems found so far.
pub(super) struct Checks(pub(super) Vec<Problem>);

impl Checks {
    pub(super) fn add(&mut self, pointer: &str, detail: impl Into<String>) {
        self.0.push(Problem::new(pointer, detail));
    }

    pub(super) fn range(&mut self, pointer: &str, value: f64, min: f64, max: f64) {
        if !(min..=max).contains(&value) {
            self.add(pointer, format!("must be {min} … {max} metres, got {value}"));
        }
    }

    /// Problems of `GeoJSON` that stands at a pointer.
    pub(super) fn geojson(&mut self, at: &str, error: ReadError) {
        let problems: Vec<geojson::Problem> = error.into();
        self.0.extend(problems.into_iter().map(|problem| Problem::new(format!("{at}{}", problem.pointer), problem.detail)));
    }

    pub(super) fn seed(&mut self, seed: u64) {
        if seed > MAX_SEED {
            self.add("/seed", format!("must be 0 … 2^53 - 1 = {MAX_SEED}, got {seed}"));
        }
    }

    pub(super) fn length(&mut self, pointer: &str, text: &str, most: usize) {
        let count = text.chars().count();
        if count > most {
            self.add(pointer, format!("must be at most {most} characters, got {count}"));
        }
    }
}

/// Reads a document whose fields are all known.
pub(crate) fn read<'a, T: Deserialize<'a>>(json: &'a [u8]) -> Result<T, DocumentError> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let Object(written) = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| structural_error(&error))?;
    deserializer.end().map_err(|error| DocumentError::Syntax(error.to_string()))?;
    Ok(written)
}

/// Reads a part of a document that stands at a pointer; what is wrong is added to the checks.
pub(super) fn read_value<T: DeserializeOwned>(mut value: serde_json::Value, at: &str, checks: &mut Checks) -> Option<T> {
    if let Some(members) = value.as_object_mut() {
        drop_nulls(members);
    }
    let error = match serde_path_to_error::deserialize(value) {
        Ok(Object(read)) => return Some(read),
        Err(error) => structural_error(&error),
    };
    match error {
        DocumentError::Invalid(problems) => {
            checks.0.extend(problems.into_iter().map(|problem| Problem { pointer: format!("{at}{}", problem.pointer), ..problem }));
        }
        DocumentError::Syntax(detail) => checks.add(at, detail),
    }
    None
}

/// Takes out members that are `null`, which counts as not there.
pub(super) fn drop_nulls(members: &mut serde_json::Map<String, serde_json::Value>) {
    members.retain(|_, value| !value.is_null());
}

/// The same JSON with every number that has no fraction written without a point.
pub(super) fn whole_numbers(value: serde_json::Value) -> serde_json::Value {
    use serde_json::Value;
    match value {
        Value::Number(number) => match number.as_f64().filter(|f| number.is_f64() && f.fract() == 0.0 && f.abs() < 9_007_199_254_740_992.0) {
            Some(whole) => (whole as i64).into(),
            None => number.into(),
        },
        Value::Array(items) => items.into_iter().map(whole_numbers).collect(),
        Value::Object(fields) => Value::Object(fields.into_iter().map(|(name, value)| (name, whole_numbers(value))).collect()),
        other => other,
    }
}

/// Refuses a new document whose programme, at `pointer`, costs too much to evaluate.
pub(super) fn check_cost(programme: &Programme, pointer: &str) -> Result<(), DocumentError> {
    let problem = |error| DocumentError::Invalid(vec![Problem::of_programme(pointer, programme.text().is_some(), error)]);
    programme.check_cost().map_err(problem)
}

/// A structural error of the reader as a problem with a pointer, or as a syntax error.
fn structural_error(error: &serde_path_to_error::Error<serde_json::Error>) -> DocumentError {
    let inner = error.inner();
    if !inner.is_data() {
        return DocumentError::Syntax(inner.to_string());
    }
    let message = inner.to_string();
    let detail = message.rsplit_once(" at line ").map_or(message.as_str(), |(detail, _)| detail).replace("expected f64", "expected a number");
    let steps = error.path().iter().filter_map(|segment| match segment {
        serde_path_to_error::Segment::Seq { index } => Some(index.to_string()),
        serde_path_to_error::Segment::Map { key } => Some(key.replace('~', "~0").replace('/', "~1")),
        _ => None,
    });
    let mut pointer: String = steps.map(|step| format!("/{step}")).collect();
    // The reader quotes field names: the wrong one first, then those that would be right.
    let mut names = detail.split('`').skip(1).step_by(2);
    let named = names.next().unwrap_or_default();
    if detail.starts_with("missing field") {
        pointer = format!("{pointer}/{named}");
    }
    let near = if detail.starts_with("unknown field") && named.len() <= 64 {
        names
            .map(|name| (strsim::damerau_levenshtein(named, name), name))
            .min_by_key(|(distance, _)| *distance)
            .filter(|(distance, _)| *distance <= (named.len() / 3).max(1))
    } else {
        None
    };
    let near = near.map_or_else(String::new, |(_, name)| format!(" (did you mean `{name}`?)"));
    DocumentError::Invalid(vec![Problem::new(pointer, format!("{detail}{near}"))])
}
