//! Terrain programmes: expressions over the plane (Frade, Fernández de Vega, Cotta, "Adding zoom feature to terrain programmes", 2009).
//!
//! A [`Programme`] is parsed from text or JSON and compiled to a [`Tape`], which evaluates windows block by block. [`Reference`] is the plain
//! meaning of a programme at a point; both agree to the bit.
//!
//! ```
//! use terrane::programme::Programme;
//! let programme = Programme::parse("plus(fbm(1.0, 1.97, 2, basis=o_perlin), multiply(0.3, x))")?;
//! assert_eq!(programme.to_string(), "plus(fbm(1, 1.97, 2), multiply(0.3, x))");
//! let wrong = Programme::parse("plus(x, fmb(1, 2, 8))").unwrap_err();
//! assert_eq!(wrong.to_string(), "at /args/1: unknown function \"fmb\" (did you mean \"fbm\"?)");
//! # Ok::<(), terrane::programme::ParseError>(())
//! ```

mod bounds;
mod cost;
mod derivative;
mod error;
mod evaluate;
mod export;
mod graph;
mod json;
mod kernels;
mod lower;
mod motion;
mod node;
mod operation;
#[cfg(test)]
mod precision;
mod print;
mod reference;
mod resolve;
mod sampling;
mod shape;
mod simplify;
#[cfg(test)]
mod suite;
mod syntax;
mod tape;
mod terrace;
mod text;
mod waves;

pub use cost::COST_LIMIT_NS;
pub use error::ParseError;
pub use export::{Ground, MAX_SHADER_STEPS, SHADER_FORM, ShaderError, ShaderLanguage};
pub use node::{Node, Value};
pub use operation::{Binary, Operation, Parameter, Signature, Unary};
pub use reference::Reference;
pub use tape::{PointTape, Tape};

use std::fmt;

/// Most nodes of a programme.
pub const MAX_NODES: usize = 4_096;

/// Most nodes on a way from the root to a leaf.
pub const MAX_DEPTH: usize = 256;

/// Greatest amplitude and datum of a programme's terrain, in metres.
pub const MAX_METRES: f64 = 1_000_000.0;

/// How programme coordinates lie in the plane: `u = (x - origin[0]) / scale`, `v = (y - origin[1]) / scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Hashed into every noise lattice.
    pub seed: u64,
    /// Metres per programme unit.
    pub scale: f64,
    /// Plane metres of the programme's origin.
    pub origin: [f64; 2],
}

/// A terrain programme as it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Programme {
    root: Node,
    text: Option<String>,
}

impl Programme {
    /// Reads programme text.
    ///
    /// # Errors
    /// If the text is not a programme or breaks a limit; the error names the place.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        Self::new(&text::parse(text)?, Some(text.to_owned()))
    }

    /// Reads a programme in JSON: a tree, or a string that holds programme text.
    ///
    /// # Errors
    /// If the JSON is malformed, is not a programme or breaks a limit; the error names the place.
    pub fn parse_json(json: &str) -> Result<Self, ParseError> {
        match json::parse(json)? {
            json::Document::Text(text) => Self::parse(&text),
            json::Document::Tree(tree) => Self::new(&tree, None),
        }
    }

    fn new(syntax: &syntax::Syntax, text: Option<String>) -> Result<Self, ParseError> {
        let root = resolve::resolve(syntax)?;
        graph::Graph::plain(&root).map_err(|graph::TooLarge| {
            let message = format!("with smooth, slope and gradients written out the programme has more than {} steps: nest them less deeply", graph::MAX_STEPS);
            ParseError::new("", syntax.span.clone(), message)
        })?;
        Ok(Self { root, text })
    }

    /// The expression.
    #[must_use]
    pub fn root(&self) -> &Node {
        &self.root
    }

    /// The text as it was written, `None` if the programme came as a JSON tree.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        self.text.as_deref()
    }

    /// Checks the predicted cost, as is done when a programme is saved.
    ///
    /// # Errors
    /// If the cost is above [`COST_LIMIT_NS`].
    pub fn check_cost(&self) -> Result<(), ParseError> {
        let cost = Tape::compile(&self.root).peak_cost_ns();
        if cost <= COST_LIMIT_NS {
            return Ok(());
        }
        let message =
            format!("the programme costs up to {cost:.0} ns a sample, more than the {COST_LIMIT_NS} ns allowed: use fewer or simpler nodes or octaves");
        Err(ParseError::new("", None, message))
    }

    /// The canonical JSON tree.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        json::to_value(&self.root)
    }
}

/// Writes the canonical text.
impl fmt::Display for Programme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.root.fmt(f)
    }
}
