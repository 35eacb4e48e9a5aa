//! The meaning of a programme at a point, plainly.

use super::{
    Frame,
    node::{Keys, Node},
    operation::Operation,
};
use crate::{geometry::Filter, noise::Field};

/// The value at plane coordinates (x, y) as samples `spacing` metres apart see it, and how many node results were not finite and became 0.
///
/// Slow: every call prepares every noise. It is what [`super::Tape`] is held to.
#[must_use]
pub fn evaluate(root: &Node, frame: &Frame, x: f64, y: f64, spacing: f64, filter: Filter) -> (f32, u64) {
    let mut point = Point { frame, x, y, spacing, filter, keys: Keys::new(frame.seed), non_finite: 0 };
    let value = point.evaluate(root);
    (value, point.non_finite)
}

/// The noise of a node as a window's samples see it; `None` for other nodes.
pub(super) fn field(node: &Node, keys: &mut Keys, frame: &Frame, spacing: f64, filter: Filter) -> Option<Field> {
    let (shape, basis) = node.field()?;
    let key = keys.next(node);
    Some(match filter {
        Filter::Exact => Field::exact(shape, basis, key),
        Filter::Band => Field::banded(shape, basis, key, spacing / frame.scale),
    })
}

struct Point<'a> {
    frame: &'a Frame,
    x: f64,
    y: f64,
    spacing: f64,
    filter: Filter,
    keys: Keys,
    non_finite: u64,
}

impl Point<'_> {
    fn evaluate(&mut self, node: &Node) -> f32 {
        let (u, v) = ((self.x - self.frame.origin[0]) / self.frame.scale, (self.y - self.frame.origin[1]) / self.frame.scale);
        let value = match node.operation {
            Operation::Constant => node.value.parameters[0] as f32,
            Operation::X => u as f32,
            Operation::Y => v as f32,
            Operation::Unary(operation) => operation.apply(self.evaluate(&node.children[0])),
            Operation::Binary(operation) => {
                let a = self.evaluate(&node.children[0]);
                operation.apply(a, self.evaluate(&node.children[1]))
            }
            _ => field(node, &mut self.keys, self.frame, self.spacing, self.filter).map_or(0.0, |field| field.at(u, v)),
        };
        if value.is_finite() {
            return value;
        }
        self.non_finite += 1;
        0.0
    }
}
