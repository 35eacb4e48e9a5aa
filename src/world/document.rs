//! World documents: reading, checking, completing, naming.

use super::{
    base::{Base, ElevationRange, WrittenBase, WrittenRange, vertical},
    layer::{Layer, Setting, WrittenLayer, layers},
    number::{optional_whole_number, whole, whole_number},
    object::Object,
    parts::Parts,
    problem::{Checks, DocumentError, check_cost, read},
    revision::Revision,
};
use serde::{Deserialize, Serialize};

/// The newest generator version: the code that turns documents into elevations.
pub const GENERATOR: u32 = 1;

/// Most characters of a title or attribution, and of a description.
pub(super) const MAX_TITLE: usize = 200;
pub(super) const MAX_DESCRIPTION: usize = 4_000;

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
    /// What lies above the base.
    pub layers: Vec<Layer>,
}

impl Document {
    /// Reads, checks and completes a document.
    ///
    /// # Errors
    /// If the bytes are not JSON, or with every problem of the document that could be found.
    pub fn parse(json: &[u8]) -> Result<Self, DocumentError> {
        Self::parse_with(json, &Parts::default())
    }

    /// As [`Document::parse`], with the stored parts that the document may name.
    ///
    /// # Errors
    /// As [`Document::parse`].
    pub fn parse_with(json: &[u8], parts: &Parts) -> Result<Self, DocumentError> {
        let document = Self::parse_stored(json, parts)?;
        check_cost(&document.base.programme, "/base/programme")?;
        for (i, layer) in document.layers.iter().enumerate() {
            layer.detail().map_or(Ok(()), |programme| check_cost(programme, &format!("/layers/{i}/source/detail/programme")))?;
        }
        Ok(document)
    }

    /// Reads a document that was accepted before: as [`Document::parse`], but whatever it costs, since budgets are for what is new.
    ///
    /// # Errors
    /// As [`Document::parse`].
    pub fn parse_stored(json: &[u8], parts: &Parts) -> Result<Self, DocumentError> {
        read::<Written>(json)?.complete(parts)
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
    elevation: Option<Object<WrittenRange>>,
    sea_level: Option<f64>,
    #[serde(borrow)]
    base: Object<WrittenBase<'a>>,
    #[serde(borrow)]
    layers: Option<Vec<Object<WrittenLayer<'a>>>>,
}

impl Written<'_> {
    fn complete(self, parts: &Parts) -> Result<Document, DocumentError> {
        let mut checks = Checks(Vec::new());
        checks.seed(self.seed);
        let generator = self.generator.unwrap_or(GENERATOR.into());
        if generator != u64::from(GENERATOR) {
            checks.add("/generator", format!("must be {GENERATOR}, the only generator version there is, got {generator}"));
        }
        let (elevation, sea_level) = vertical(self.elevation, self.sea_level, &mut checks);
        for (pointer, text, most) in
            [("/title", &self.title, MAX_TITLE), ("/attribution", &self.attribution, MAX_TITLE), ("/description", &self.description, MAX_DESCRIPTION)]
        {
            checks.length(pointer, text.as_deref().unwrap_or_default(), most);
        }
        let base = self.base.0.complete("/base", &mut checks);
        // Layers may take long to make, so what else is wrong is said first.
        let setting = Setting { seed: self.seed, sea_level, parts };
        let layers = if checks.0.is_empty() { layers(self.layers.unwrap_or_default(), &setting, &mut checks) } else { Vec::new() };
        let Some(base) = base.filter(|_| checks.0.is_empty()) else { return Err(DocumentError::Invalid(checks.0)) };
        let (title, description, attribution) = (self.title, self.description, self.attribution);
        Ok(Document { title, description, attribution, seed: self.seed, generator: GENERATOR, elevation, sea_level, base, layers })
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
        // Readers that are derived would take the fields in the order of their declaration.
        check(r#"{"seed":7,"base":["x",10,null,null,null]}"#, "/base: invalid type: sequence, expected an object");
        check(r#"[null,null,null,7,1,null,null,{"programme":"x","scale":10},null]"#, "/: invalid type: sequence, expected an object");
        check(&format!(r#"{{"seed":7,"elevation":[null,9],{BASE}}}"#), "/elevation: invalid type: sequence, expected an object");
        check(&format!(r#"{{"seed":7,{BASE},"layers":[["a"]]}}"#), "/layers/0: invalid type: sequence, expected an object");
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
        check(&format!(r#"{{"seed":7,"layers":[{{"name":"a"}}],{BASE}}}"#), "/layers/0/source: missing field `source`");
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
