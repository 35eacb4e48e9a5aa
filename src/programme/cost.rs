//! What a programme costs to evaluate, predicted so that every machine accepts the same worlds.

use super::{
    error::ParseError,
    node::Node,
    operation::{Binary, Operation, Unary},
};
use crate::noise::Basis;

/// The greatest predicted cost of a programme, in nanoseconds a sample.
pub const COST_LIMIT_NS: f64 = 2_000.0;

/// The predicted cost in nanoseconds a sample, on one thread.
///
/// The constants were measured on the machine of the README's table. Noise costs most where every sample has a cell of its own: there an octave of gradient noise
/// takes up to three times what is predicted, and a seventh where cells are wide.
#[must_use]
pub fn cost_ns(node: &Node) -> f64 {
    let own = match node.operation {
        Operation::Constant | Operation::X | Operation::Y => 0.4,
        Operation::Unary(Unary::Negative | Unary::Abs) => 0.5,
        Operation::Unary(Unary::Sqrt) => 0.8,
        Operation::Unary(_) => 11.0,
        Operation::Binary(Binary::Power) => 30.0,
        Operation::Binary(Binary::Mod) => 4.0,
        Operation::Binary(_) => 0.6,
        _ => node.field().map_or(0.0, |(shape, basis)| shape.octaves() as f64 * octave_ns(basis)),
    };
    own + node.children.iter().map(cost_ns).sum::<f64>()
}

fn octave_ns(basis: Basis) -> f64 {
    match basis {
        Basis::OPerlin | Basis::IPerlin | Basis::Blender => 7.0,
        Basis::CellNoise => 2.0,
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
