//! What the programme library keeps: a terrain programme, and how it is best shown as terrain.

use super::{
    GENERATOR,
    base::{Base, ElevationRange, WrittenBase, WrittenRange, programme, vertical},
    document::{Document, MAX_DESCRIPTION, MAX_TITLE},
    name::check_name,
    number::{optional_whole_number, whole},
    object::Object,
    problem::{Checks, DocumentError, check_cost, read},
    revision::Revision,
};
use crate::programme::Programme;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use std::collections::BTreeSet;

/// Most tags of a programme.
const MAX_TAGS: usize = 16;

/// Most characters of what is said about a programme's origin.
const MAX_ORIGIN: usize = 200;

/// Metres per programme unit where the document does not say.
const SCALE: f64 = 20_000.0;

/// A completed document of the programme library.
///
/// ```
/// use terrane::world::{Preset, World};
/// let preset = Preset::parse(br#"{"programme": "ridged_multifractal(1, 2, 8, 1, 2)", "tags": ["mountains"]}"#)?;
/// assert_eq!((preset.scale, preset.amplitude), (20_000.0, 1_000.0));
/// let world = World::new(preset.document());
/// assert_eq!(world.document().base.scale, 20_000.0);
/// let error = Preset::parse(br#"{"programme": "x", "tags": ["High Alps"]}"#).unwrap_err();
/// assert_eq!(error.to_string(), r#"/tags/0: a tag is 1 to 63 of a … z, 0 … 9 and -, the first not -; got "High Alps""#);
/// # Ok::<(), terrane::world::DocumentError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preset {
    /// A name for people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// What terrain the programme makes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// What it can be found by; each a name, none twice.
    pub tags: Vec<String>,
    /// Where it came from, such as "shipped with Terrane".
    pub origin: String,
    /// The terrain programme.
    #[serde(serialize_with = "programme")]
    pub programme: Programme,
    /// Metres per programme unit.
    #[serde(serialize_with = "whole")]
    pub scale: f64,
    /// Metres of elevation per unit of the programme's value.
    #[serde(serialize_with = "whole")]
    pub amplitude: f64,
    /// Metres of elevation where the programme is 0.
    #[serde(serialize_with = "whole")]
    pub datum: f64,
    /// Elevation of the sea's surface, in metres.
    #[serde(serialize_with = "whole")]
    pub sea_level: f64,
    /// The seed that it is shown with, 0 … 2^53 - 1.
    pub seed: u64,
    /// The vertical range that elevations are clamped to.
    pub elevation: ElevationRange,
}

impl Preset {
    /// Reads, checks and completes a document.
    ///
    /// # Errors
    /// If the bytes are not JSON, or with every problem of the document that could be found.
    pub fn parse(json: &[u8]) -> Result<Self, DocumentError> {
        let preset = Self::parse_stored(json)?;
        check_cost(&preset.programme, "/programme")?;
        Ok(preset)
    }

    /// Reads a document that was accepted before: as [`Preset::parse`], but whatever it costs, since budgets are for what is new.
    ///
    /// # Errors
    /// As [`Preset::parse`].
    pub fn parse_stored(json: &[u8]) -> Result<Self, DocumentError> {
        read::<Written>(json)?.complete()
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
        Revision::of(self)
    }

    /// The world that shows the programme.
    #[must_use]
    pub fn document(&self) -> Document {
        let Self { title, description, programme, scale, amplitude, datum, sea_level, seed, elevation, .. } = self.clone();
        let base = Base { programme, scale, origin: [0.0, 0.0], amplitude, datum };
        Document { title, description, attribution: None, seed, generator: GENERATOR, elevation, sea_level, base, layers: Vec::new() }
    }
}

/// A document as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written<'a> {
    title: Option<String>,
    description: Option<String>,
    tags: Option<Vec<String>>,
    origin: Option<String>,
    #[serde(borrow)]
    programme: &'a RawValue,
    scale: Option<f64>,
    amplitude: Option<f64>,
    datum: Option<f64>,
    sea_level: Option<f64>,
    #[serde(default, deserialize_with = "optional_whole_number")]
    seed: Option<u64>,
    elevation: Option<Object<WrittenRange>>,
}

impl Written<'_> {
    fn complete(self) -> Result<Preset, DocumentError> {
        let mut checks = Checks(Vec::new());
        let seed = self.seed.unwrap_or(0);
        checks.seed(seed);
        let (elevation, sea_level) = vertical(self.elevation, self.sea_level, &mut checks);
        checks.length("/title", self.title.as_deref().unwrap_or_default(), MAX_TITLE);
        checks.length("/description", self.description.as_deref().unwrap_or_default(), MAX_DESCRIPTION);
        let (tags, origin) = (self.tags.unwrap_or_default(), self.origin.unwrap_or_default());
        checks.length("/origin", &origin, MAX_ORIGIN);
        check_tags(&tags, &mut checks);
        let base = WrittenBase { programme: self.programme, scale: self.scale.unwrap_or(SCALE), origin: None, amplitude: self.amplitude, datum: self.datum };
        let base = base.complete("", &mut checks);
        let Some(Base { programme, scale, amplitude, datum, .. }) = base.filter(|_| checks.0.is_empty()) else { return Err(DocumentError::Invalid(checks.0)) };
        let (title, description) = (self.title, self.description);
        Ok(Preset { title, description, tags, origin, programme, scale, amplitude, datum, sea_level, seed, elevation })
    }
}

fn check_tags(tags: &[String], checks: &mut Checks) {
    if tags.len() > MAX_TAGS {
        checks.add("/tags", format!("must be at most {MAX_TAGS} tags, got {}", tags.len()));
        return;
    }
    let mut seen = BTreeSet::new();
    for (i, tag) in tags.iter().enumerate() {
        match check_name("a tag", tag) {
            Err(detail) => checks.add(&format!("/tags/{i}"), detail),
            Ok(()) if !seen.insert(tag) => checks.add(&format!("/tags/{i}"), format!("{tag:?} is given twice")),
            Ok(()) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The problems of a document, or its completed form.
    fn check(json: &str, expected: &str) {
        let got = match Preset::parse(json.as_bytes()) {
            Ok(preset) => serde_json::to_string(&preset).expect("JSON"),
            Err(error) => error.to_string(),
        };
        assert_eq!(got, expected, "{json}");
    }

    #[test]
    fn defaults_are_completed() {
        let completed =
            r#"{"tags":[],"origin":"","programme":"x","scale":20000,"amplitude":1000,"datum":0,"sea_level":0,"seed":0,"elevation":{"min":-10000,"max":9000}}"#;
        check(r#"{"programme":"x"}"#, completed);
        check(completed, completed);
        check(r#"{"programme":"x","seed":0.0,"scale":2e4,"elevation":{"max":9e3}}"#, completed);
        let preset = Preset::parse(br#"{"programme":{"op":"sin","args":["x"]},"title":"Waves"}"#).expect("valid");
        assert_eq!(Preset::parse(preset.to_json().as_bytes()).expect("valid").revision(), preset.revision());
        let document = preset.document();
        assert_eq!(Document::parse(document.to_json().as_bytes()).as_ref(), Ok(&document), "what shows a programme is a world");
    }

    #[test]
    fn every_problem_is_named_with_its_place() {
        check(
            r#"{"programme":"x","base":{}}"#,
            "/base: unknown field `base`, expected one of `title`, `description`, `tags`, `origin`, `programme`, `scale`, `amplitude`, `datum`, `sea_level`, `seed`, `elevation`",
        );
        check("{}", "/programme: missing field `programme`");
        check(r#"{"programme":"fmb(1)"}"#, "/programme: character 1: unknown function \"fmb\" (did you mean \"fbm\"?)");
        check(r#"{"programme":{"op":"sin","args":["z"]}}"#, "/programme/args/0: unknown name \"z\" (did you mean \"x\"?)");
        check(r#"{"programme":"x","tags":["a","b",7]}"#, "/tags/2: invalid type: integer `7`, expected a string");
        check(
            r#"{"programme":"x","seed":9007199254740992,"scale":0,"sea_level":1e9,"tags":["a","","a","-"]}"#,
            "/seed: must be 0 … 2^53 - 1 = 9007199254740991, got 9007199254740992\n/sea_level: must be -10000 … 32767 metres, got 1000000000\n\
             /tags/1: a tag is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"\"\n/tags/2: \"a\" is given twice\n\
             /tags/3: a tag is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"-\"\n\
             /scale: must be more than 0 and at most 2^40 metres per programme unit, got 0",
        );
        let many: Vec<_> = (0..17).map(|i| format!("t{i}")).collect();
        check(&format!(r#"{{"programme":"x","tags":{many:?}}}"#), "/tags: must be at most 16 tags, got 17");
        check(&format!(r#"{{"programme":"x","origin":"{}"}}"#, "é".repeat(201)), "/origin: must be at most 200 characters, got 201");
        let costly = format!(r#"{{"programme":"{}x{}"}}"#, "plus(fbm(1, 2, 32), ".repeat(200), ")".repeat(200));
        assert!(Preset::parse(costly.as_bytes()).expect_err("too dear").to_string().starts_with("/programme: "));
        assert!(Preset::parse_stored(costly.as_bytes()).is_ok());
    }
}
