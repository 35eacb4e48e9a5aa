//! Steps whose value another step has already. No rule changes a bit: values are finite, and -0 is told from 0.

use super::{
    graph::{Graph, Id, Step},
    operation::{Binary, Unary},
};

/// What became of a step.
pub(super) enum Simple {
    /// Its value is that of another.
    Same(Id),
    Step(Step),
}

/// Exchanges a step whose operands are in the graph.
pub(super) fn simplify(graph: &Graph, step: Step) -> Simple {
    if let Some(number) = folded(graph, step) {
        return Simple::Step(Step::Number(number.to_bits()));
    }
    match step {
        Step::Unary(Unary::Negative, a) => match graph.steps[a] {
            Step::Unary(Unary::Negative, inner) => Simple::Same(inner),
            _ => Simple::Step(step),
        },
        // These see |a| alone.
        Step::Unary(operation @ (Unary::Abs | Unary::Sqrt | Unary::Log), a) => match graph.steps[a] {
            Step::Unary(Unary::Negative | Unary::Abs, inner) => simplify(graph, Step::Unary(operation, inner)),
            _ => Simple::Step(step),
        },
        Step::Binary(operation, a, b) => binary(graph, operation, a, b).map_or(Simple::Step(step), Simple::Same),
        Step::Select(mask, a, b) => match graph.number(mask) {
            _ if a == b => Simple::Same(a),
            Some(number) => Simple::Same(if number > 0.0 { a } else { b }),
            None => Simple::Step(step),
        },
        _ => Simple::Step(step),
    }
}

/// The value of a step whose operands are numbers, if it is finite: what is not is left to be counted where it arises.
fn folded(graph: &Graph, step: Step) -> Option<f32> {
    let value = match step {
        Step::Unary(operation, a) => operation.apply(graph.number(a)?),
        Step::Binary(operation, a, b) => operation.apply(graph.number(a)?, graph.number(b)?),
        Step::Terrace(terrace, a) => terrace.apply(graph.number(a)?),
        Step::TerraceSlope(terrace, a) => terrace.slope(graph.number(a)?),
        _ => return None,
    };
    value.is_finite().then_some(value)
}

/// The operand that a function of two values comes to.
fn binary(graph: &Graph, operation: Binary, a: Id, b: Id) -> Option<Id> {
    // a + 0 is not among these: it turns -0 into 0.
    let is = |id: Id, number: f32| graph.number(id).is_some_and(|n| n.to_bits() == number.to_bits());
    match operation {
        Binary::Plus if is(b, -0.0) => Some(a),
        Binary::Plus if is(a, -0.0) => Some(b),
        Binary::Minus if is(b, 0.0) => Some(a),
        Binary::Multiply | Binary::Divide if is(b, 1.0) => Some(a),
        Binary::Multiply if is(a, 1.0) => Some(b),
        Binary::Min | Binary::Max if a == b => Some(a),
        _ => None,
    }
}
