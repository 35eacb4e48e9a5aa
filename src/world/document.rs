//! World documents: reading, checking, completing, naming.

use crate::{
    geometry::PLANE_LIMIT,
    programme::{ParseError, Programme},
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::IgnoredAny};
use serde_json::value::RawValue;
use sha2::{Digest, Sha256};
use std::{fmt, ops::Range};

/// The newest generator version: the code that turns documents into elevations.
pub const GENERATOR: u32 = 1;

/// The greatest seed: 2^53 - 1, what every JSON reader keeps exactly.
const MAX_SEED: u64 = (1 << 53) - 1;

/// What both RGB encodings can hold, in metres.
const ELEVATIONS: Range<f64> = -10_000.0..32_767.0;

/// Greatest amplitude and datum, in metres.
const MAX_METRES: f64 = 1_000_000.0;

/// Most characters of a title or attribution, and of a description.
const MAX_TITLE: usize = 200;
const MAX_DESCRIPTION: usize = 4_000;

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
    fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into(), at: None, start: None, end: None }
    }

    /// A problem of a programme that stands at `pointer`, as text or as a tree.
    fn of_programme(pointer: &str, text: bool, error: ParseError) -> Self {
        if !text {
            return Self::new(format!("{pointer}{}", error.at), error.message);
        }
        let (start, end) = error.span.map_or((None, None), |span| (Some(span.start), Some(span.end)));
        Self { pointer: pointer.to_owned(), detail: error.message, at: Some(error.at), start, end }
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

/// Why something is not a world document.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DocumentError {
    /// Not JSON at all.
    #[error("not JSON: {0}")]
    Syntax(String),
    /// JSON, but not a world; every problem found.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

/// The name of a document's content: the first 32 hex digits of SHA-256 of its canonical form (RFC 8785).
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct Revision(String);

impl Revision {
    /// The 32 hex digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Reads 32 lower-case hex digits.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let hex = text.len() == 32 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        hex.then(|| Self(text.to_owned()))
    }
}

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The vertical range of a world, in metres.
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

/// A completed world document.
///
/// ```
/// use terrane::world::Document;
/// let document = Document::parse(br#"{"seed": 7, "base": {"programme": "fbm(1, 2, 8)", "scale": 20000}}"#)?;
/// assert_eq!((document.generator, document.base.amplitude), (1, 1000.0));
/// let error = Document::parse(br#"{"seed": 7, "base": {"programme": "fmb(1, 2, 8)", "scale": 20000}}"#).unwrap_err();
/// assert_eq!(error.to_string(), r#"/base/programme: character 1: unknown function "fmb" (did you mean "fbm"?)"#);
/// # Ok::<(), terrane::world::DocumentError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Document {
    /// A name for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// What the world is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Whom maps should name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attribution: Option<String>,
    /// 0 … 2^53 - 1.
    pub seed: u64,
    /// The generator version that the world is pinned to.
    pub generator: u32,
    /// The vertical range that elevations are clamped to.
    pub elevation: ElevationRange,
    /// Elevation of the sea's surface, in metres.
    #[serde(serialize_with = "whole")]
    pub sea_level: f64,
    /// The terrain beneath all layers.
    pub base: Base,
    /// What lies above the base; no layer source is built yet.
    pub layers: [(); 0],
}

impl Document {
    /// Reads, checks and completes a document.
    ///
    /// # Errors
    /// If the bytes are not JSON, or with every problem of the document that could be found.
    pub fn parse(json: &[u8]) -> Result<Self, DocumentError> {
        let document = Self::parse_stored(json)?;
        let problem = |error| DocumentError::Invalid(vec![Problem::of_programme("/base/programme", document.base.programme.text().is_some(), error)]);
        document.base.programme.check_cost().map_err(problem)?;
        Ok(document)
    }

    /// Reads a document that was accepted before: as [`Document::parse`], but whatever it costs, since budgets are for what is new.
    ///
    /// # Errors
    /// As [`Document::parse`].
    pub fn parse_stored(json: &[u8]) -> Result<Self, DocumentError> {
        let mut deserializer = serde_json::Deserializer::from_slice(json);
        let written: Written = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| structural_error(&error))?;
        deserializer.end().map_err(|error| DocumentError::Syntax(error.to_string()))?;
        written.complete()
    }

    /// The document as indented JSON.
    ///
    /// # Panics
    /// Never: a document is always JSON.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a document has only string keys and finite numbers")
    }

    /// The name of the content.
    ///
    /// # Panics
    /// Never: a document is always JSON.
    #[must_use]
    pub fn revision(&self) -> Revision {
        let canonical = serde_json_canonicalizer::to_vec(self).expect("a document has only string keys and finite numbers");
        Revision(Sha256::digest(canonical).iter().take(16).map(|byte| format!("{byte:02x}")).collect())
    }
}

/// A document as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written<'a> {
    title: Option<String>,
    description: Option<String>,
    attribution: Option<String>,
    #[serde(deserialize_with = "whole_number")]
    seed: u64,
    #[serde(default, deserialize_with = "optional_whole_number")]
    generator: Option<u64>,
    elevation: Option<WrittenRange>,
    sea_level: Option<f64>,
    #[serde(borrow)]
    base: WrittenBase<'a>,
    layers: Option<Vec<IgnoredAny>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRange {
    min: Option<f64>,
    max: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenBase<'a> {
    #[serde(borrow)]
    programme: &'a RawValue,
    scale: f64,
    origin: Option<[f64; 2]>,
    amplitude: Option<f64>,
    datum: Option<f64>,
}

impl Written<'_> {
    fn complete(self) -> Result<Document, DocumentError> {
        let mut checks = Checks(Vec::new());
        let elevation = self.elevation.unwrap_or_default();
        let elevation = ElevationRange { min: elevation.min.unwrap_or(-10_000.0), max: elevation.max.unwrap_or(9_000.0) };
        let sea_level = self.sea_level.unwrap_or(0.0);
        let generator = self.generator.unwrap_or(GENERATOR.into());
        if self.seed > MAX_SEED {
            checks.add("/seed", format!("must be 0 … 2^53 - 1 = {MAX_SEED}, got {}", self.seed));
        }
        if generator != u64::from(GENERATOR) {
            checks.add("/generator", format!("must be {GENERATOR}, the only generator version there is, got {generator}"));
        }
        for (pointer, value) in [("/elevation/min", elevation.min), ("/elevation/max", elevation.max), ("/sea_level", sea_level)] {
            checks.range(pointer, value, ELEVATIONS.start, ELEVATIONS.end);
        }
        if elevation.min >= elevation.max {
            checks.add("/elevation", format!("min must be less than max, got {} and {}", elevation.min, elevation.max));
        }
        for (pointer, text, most) in
            [("/title", &self.title, MAX_TITLE), ("/attribution", &self.attribution, MAX_TITLE), ("/description", &self.description, MAX_DESCRIPTION)]
        {
            if let Some(count) = text.as_ref().map(|text| text.chars().count()).filter(|count| *count > most) {
                checks.add(pointer, format!("must be at most {most} characters, got {count}"));
            }
        }
        if self.layers.is_some_and(|layers| !layers.is_empty()) {
            checks.add("/layers/0", "no layer source is built into this version: leave layers empty");
        }
        let base = self.base.complete(&mut checks);
        let Some(base) = base.filter(|_| checks.0.is_empty()) else { return Err(DocumentError::Invalid(checks.0)) };
        let (title, description, attribution) = (self.title, self.description, self.attribution);
        Ok(Document { title, description, attribution, seed: self.seed, generator: GENERATOR, elevation, sea_level, base, layers: [] })
    }
}

impl WrittenBase<'_> {
    fn complete(self, checks: &mut Checks) -> Option<Base> {
        let (origin, amplitude, datum) = (self.origin.unwrap_or_default(), self.amplitude.unwrap_or(1_000.0), self.datum.unwrap_or(0.0));
        if !(self.scale > 0.0 && self.scale <= PLANE_LIMIT) {
            checks.add("/base/scale", format!("must be more than 0 and at most 2^40 metres per programme unit, got {}", self.scale));
        }
        for (i, value) in origin.into_iter().enumerate() {
            checks.range(&format!("/base/origin/{i}"), value, -PLANE_LIMIT, PLANE_LIMIT);
        }
        checks.range("/base/amplitude", amplitude, -MAX_METRES, MAX_METRES);
        checks.range("/base/datum", datum, -MAX_METRES, MAX_METRES);
        let json = self.programme.get();
        match Programme::parse_json(json) {
            Ok(programme) => Some(Base { programme, scale: self.scale, origin, amplitude, datum }),
            Err(error) => {
                checks.0.push(Problem::of_programme("/base/programme", json.starts_with('"'), error));
                None
            }
        }
    }
}

/// Problems found so far.
struct Checks(Vec<Problem>);

impl Checks {
    fn add(&mut self, pointer: &str, detail: impl Into<String>) {
        self.0.push(Problem::new(pointer, detail));
    }

    fn range(&mut self, pointer: &str, value: f64, min: f64, max: f64) {
        if !(min..=max).contains(&value) {
            self.add(pointer, format!("must be {min} … {max} metres, got {value}"));
        }
    }
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

/// A whole number, also where it is written as 7.0 or 1e3.
fn whole_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    let expected = || serde::de::Error::custom(format!("expected a whole number 0 … {MAX_SEED}"));
    let Ok(number) = serde_json::Number::deserialize(deserializer) else { return Err(expected()) };
    let float = number.as_f64().filter(|f| f.fract() == 0.0 && (0.0..18_446_744_073_709_551_616.0).contains(f));
    number.as_u64().or(float.map(|f| f as u64)).ok_or_else(expected)
}

fn optional_whole_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    whole_number(deserializer).map(Some)
}

/// Numbers without a fraction are written without a point.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands fields over by reference")]
fn whole<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if number.fract() == 0.0 && number.abs() < 9_007_199_254_740_992.0 { serializer.serialize_i64(*number as i64) } else { serializer.serialize_f64(*number) }
}

fn whole_pair<S: Serializer>(pair: &[f64; 2], serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Whole(#[serde(serialize_with = "whole")] f64);
    pair.map(Whole).serialize(serializer)
}

/// Text as it was written; a tree in canonical JSON.
fn programme<S: Serializer>(programme: &Programme, serializer: S) -> Result<S::Ok, S::Error> {
    match programme.text() {
        Some(text) => serializer.serialize_str(text),
        None => programme.to_json().serialize(serializer),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problems of a document, or its completed canonical form.
    fn check(json: &str, expected: &str) {
        let got = match Document::parse(json.as_bytes()) {
            Ok(document) => serde_json::to_string(&document).expect("JSON"),
            Err(error) => error.to_string(),
        };
        assert_eq!(got, expected, "{json}");
    }

    const BASE: &str = r#""base":{"programme":"x","scale":10}"#;

    #[test]
    fn defaults_are_completed() {
        let completed = r#"{"seed":7,"generator":1,"elevation":{"min":-10000,"max":9000},"sea_level":0,"base":{"programme":"x","scale":10,"origin":[0,0],"amplitude":1000,"datum":0},"layers":[]}"#;
        check(&format!(r#"{{"seed":7,{BASE}}}"#), completed);
        check(completed, completed);
        check(&format!(r#"{{"seed":7.0,"generator":1,"layers":[],"elevation":{{"max":9e3}},{BASE}}}"#), completed);
        let tree = r#"{"seed":0,"base":{"programme":{"op":"sin","args":["x"]},"scale":0.5}}"#;
        let document = Document::parse(tree.as_bytes()).expect("valid");
        assert_eq!(Document::parse(document.to_json().as_bytes()).expect("valid").revision(), document.revision());
    }

    #[test]
    fn every_problem_is_named_with_its_place() {
        check(
            &format!(r#"{{"seed":7,"sea":1,{BASE}}}"#),
            "/sea: unknown field `sea`, expected one of `title`, `description`, `attribution`, `seed`, `generator`, `elevation`, `sea_level`, `base`, `layers`",
        );
        check(
            r#"{"seed":7,"base":{"programme":"x","scale":10,"zoom":1}}"#,
            "/base/zoom: unknown field `zoom`, expected one of `programme`, `scale`, `origin`, `amplitude`, `datum`",
        );
        check(
            r#"{"seed":7,"base":{"program":"x","scale":10}}"#,
            "/base/program: unknown field `program`, expected one of `programme`, `scale`, `origin`, `amplitude`, `datum` (did you mean `programme`?)",
        );
        check(&format!("{{{BASE}}}"), "/seed: missing field `seed`");
        check(r#"{"seed":7,"base":{"scale":10}}"#, "/base/programme: missing field `programme`");
        check(&format!(r#"{{"seed":9007199254740992,{BASE}}}"#), "/seed: must be 0 … 2^53 - 1 = 9007199254740991, got 9007199254740992");
        check(&format!(r#"{{"seed":-1,{BASE}}}"#), "/seed: expected a whole number 0 … 9007199254740991");
        check(&format!(r#"{{"seed":"7",{BASE}}}"#), "/seed: expected a whole number 0 … 9007199254740991");
        check(r#"{"seed":7,"base":{"programme":"x","scale":"wide"}}"#, "/base/scale: invalid type: string \"wide\", expected a number");
        check(r#"{"seed":7,"base":{"programme":"x","scale":10,"origin":[0,"a"]}}"#, "/base/origin/1: invalid type: string \"a\", expected a number");
        check(
            r#"{"seed":7,"base":{"programme":"plus(x, fmb(1))","scale":10}}"#,
            "/base/programme: at /args/1: character 9: unknown function \"fmb\" (did you mean \"fbm\"?)",
        );
        check(
            r#"{"seed":7,"base":{"programme":{"op":"plus","args":["x","z"]},"scale":10}}"#,
            "/base/programme/args/1: unknown name \"z\" (did you mean \"x\"?)",
        );
        check(
            r#"{"seed":7,"base":{"programme":null,"scale":10}}"#,
            "/base/programme: invalid type: null, expected a number, the name of a terminal, or {\"op\": …, \"args\": […]}",
        );
        check(&format!(r#"{{"seed":7,"layers":[{{"name":"a"}}],{BASE}}}"#), "/layers/0: no layer source is built into this version: leave layers empty");
        check(&format!(r#"{{"seed":7,"seed":8,{BASE}}}"#), "/: duplicate field `seed`");
        check(
            r#"{"seed":7,"generator":2,"elevation":{"min":10,"max":5},"sea_level":1e9,"base":{"programme":"x(","scale":0}}"#,
            "/generator: must be 1, the only generator version there is, got 2\n/sea_level: must be -10000 … 32767 metres, got 1000000000\n\
             /elevation: min must be less than max, got 10 and 5\n/base/scale: must be more than 0 and at most 2^40 metres per programme unit, got 0\n\
             /base/programme: at /args/0: character 3: expected a number, a name or a call such as fbm(1, 2, 8), found the end of the programme",
        );
    }

    #[test]
    fn what_is_not_json_is_said_to_be_so() {
        for json in ["", "{", "nonsense", "{\"seed\":7,}", "[1]x"] {
            assert!(matches!(Document::parse(json.as_bytes()), Err(DocumentError::Syntax(_))) || json.starts_with('['), "{json}");
        }
        assert!(Document::parse("[".repeat(1 << 20).as_bytes()).is_err());
    }

    #[test]
    fn a_revision_depends_on_content_and_not_on_spelling() {
        let revision = |json: &str| Document::parse(json.as_bytes()).expect("valid").revision();
        let one = revision(r#"{"seed":7,"base":{"programme":"x","scale":10}}"#);
        assert_eq!(one, revision(r#"{ "base": {"scale": 1e1, "programme": "x"}, "seed": 7, "generator": 1 }"#));
        assert_ne!(one, revision(r#"{"seed":8,"base":{"programme":"x","scale":10}}"#));
        assert_eq!(one.as_str().len(), 32);
        assert_eq!(Revision::parse(one.as_str()), Some(one));
    }
}
