//! Expressions in the distance from a feature, in the language of terrain programmes.

use crate::{
    geometry::Filter,
    noise::Isa,
    programme::{Frame, ParseError, PointTape, Programme, Reference},
};
use std::{fmt, sync::Arc};

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
    tape: Arc<PointTape>,
}

/// An expression's coordinates are metres.
const FRAME: Frame = Frame { seed: 0, scale: 1.0, origin: [0.0, 0.0] };

impl Expression {
    /// Reads an expression such as `max(0, minus(1, divide(d, 50)))`.
    ///
    /// # Errors
    /// If it is not programme text with the variable `d` in the place of `x` and `y`.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let programme = Programme::parse(&in_x(text)?)?;
        let tape = Arc::new(PointTape::compile(programme.root()));
        Ok(Self { text: text.into(), programme, tape })
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

    /// The value at a distance, plainly.
    #[must_use]
    pub fn at(&self, d: f64) -> f64 {
        Reference::new(self.programme.root(), &FRAME, 1.0, Filter::Exact).at(d, 0.0).into()
    }

    /// The values at distances; the same bits as [`Expression::at`].
    pub(super) fn fill(&self, isa: Isa, distances: &[f64], out: &mut [f32]) {
        for (distances, out) in distances.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            self.tape.evaluate(isa, &FRAME, distances, &[0.0; CHUNK][..distances.len()], out);
        }
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

/// Distances at a time.
const CHUNK: usize = 256;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_the_only_variable() {
        let expression = Expression::parse("max(0, minus(1, divide(d, 50)))").expect("valid");
        assert_eq!([0.0, 25.0, 80.0].map(|d| expression.at(d)), [1.0, 0.5, 0.0]);
        assert_eq!(expression.text(), "max(0, minus(1, divide(d, 50)))");
        assert_eq!(Expression::parse("plus(d, y)"), Err(ExpressionError::Coordinate("y".to_owned())));
        let error = Expression::parse("minus(1, dd)").expect_err("dd is no name").to_string();
        assert!(error.contains("dd"), "{error}");
        let distances: Vec<f64> = (-700..700).map(|i| f64::from(i) * 0.37).collect();
        let mut values = vec![0.0; distances.len()];
        let wild = Expression::parse("divide(sin(d), minus(d, 3.7))").expect("valid");
        for isa in Isa::ALL {
            wild.fill(isa, &distances, &mut values);
            assert!(distances.iter().zip(&values).all(|(&d, &value)| wild.at(d).to_bits() == f64::from(value).to_bits()), "{}", isa.name());
        }
    }
}
