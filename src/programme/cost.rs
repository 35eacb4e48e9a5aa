//! What a programme costs to evaluate, predicted so that every machine accepts the same worlds.

use super::{
    error::ParseError,
    node::Node,
    operation::{Binary, Operation, Unary},
};
use crate::noise::Basis;

/// The greatest predicted cost of a programme, in nanoseconds a sample.
pub const COST_LIMIT_NS: f64 = 2_000.0;

/// The predicted cost in nanoseconds a sample, on one thread of the machine in the README's table.
#[must_use]
pub fn cost_ns(node: &Node) -> f64 {
    let own = match node.operation {
        Operation::Constant | Operation::X | Operation::Y => 0.1,
        Operation::Unary(Unary::Negative | Unary::Abs) => 0.3,
        Operation::Unary(Unary::Sqrt) => 1.0,
        Operation::Unary(_) => 8.0,
        Operation::Binary(Binary::Power) => 16.0,
        Operation::Binary(Binary::Mod | Binary::Divide) => 1.5,
        Operation::Binary(_) => 0.4,
        _ => node.field().map_or(0.0, |(shape, basis)| shape.octaves() as f64 * octave_ns(basis)),
    };
    own + node.children.iter().map(cost_ns).sum::<f64>()
}

fn octave_ns(basis: Basis) -> f64 {
    match basis {
        Basis::OPerlin | Basis::IPerlin => 3.0,
        Basis::CellNoise => 1.5,
        Basis::Voronoi { .. } => 25.0,
    }
}

pub(super) fn check(root: &Node) -> Result<(), ParseError> {
    let cost = cost_ns(root);
    if cost <= COST_LIMIT_NS {
        return Ok(());
    }
    let message = format!("the programme costs about {cost:.0} ns a sample, more than the {COST_LIMIT_NS} ns allowed: use fewer or simpler nodes or octaves");
    Err(ParseError::new("", None, message))
}
