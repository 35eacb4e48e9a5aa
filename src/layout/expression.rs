//! Expressions in the distance from a feature, in the language of terrain programmes.

use crate::programme::{ParseError, Programme};
use std::fmt;

/// Why text is not an expression in `d`.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpressionError {
    /// A coordinate of the plane, which an expression in the distance does not know.
    #[error("an expression in the distance knows d, not {0}")]
    Coordinate(String),
    /// Not a terrain programme.
    #[error(transparent)]
    Programme(#[from] ParseError),
}

/// A terrain programme of one variable `d`, metres; numbers are f32 as in all programmes.
#[derive(Clone, Debug)]
pub struct Expression {
    text: Box<str>,
    /// With x in the place of d.
    programme: Programme,
}

impl Expression {
    /// Reads an expression such as `max(0, minus(1, divide(d, 50)))`.
    ///
    /// # Errors
    /// If it is not programme text with the variable `d` in the place of `x` and `y`.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let programme = Programme::parse(&in_x(text)?)?;
        Ok(Self { text: text.into(), programme })
    }

    /// The text as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The canonical text, with `x` in the place of `d`.
    #[must_use]
    pub fn canonical(&self) -> String {
        self.programme.to_string()
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.programme == other.programme
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// The text with every name `d` replaced by `x`: as long, so that places in errors stay right.
fn in_x(text: &str) -> Result<String, ExpressionError> {
    let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.');
    let (mut out, mut rest) = (String::with_capacity(text.len()), text);
    while let Some(start) = rest.find(is_word) {
        let (before, from) = rest.split_at(start);
        let (word, after) = from.split_at(from.find(|c| !is_word(c)).unwrap_or(from.len()));
        if matches!(word, "x" | "y") {
            return Err(ExpressionError::Coordinate(word.to_owned()));
        }
        out.push_str(before);
        out.push_str(if word == "d" { "x" } else { word });
        rest = after;
    }
    out.push_str(rest);
    Ok(out)
}
