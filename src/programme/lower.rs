//! From the tree of a programme to its graph of steps.

use super::{
    graph::{Axis, Builder, Graph, HERE, Id, Noise, Step, TooLarge},
    motion::Motion,
    node::{Lattices, Node, Ordinals},
    operation::{Binary, Operation, Unary},
    shape::{Direction, Shape},
    terrace::Terrace,
};
use crate::noise::{Erosion, FieldShape};

impl Graph {
    /// The programme as it was written.
    ///
    /// # Errors
    /// If the steps are too many once averages and derivatives are written out.
    pub(super) fn plain(root: &Node) -> Result<Self, TooLarge> {
        Self::lower(root, false)
    }

    /// The programme with fewer steps and the same bits.
    ///
    /// # Errors
    /// As [`Graph::plain`].
    pub(super) fn simplified(root: &Node) -> Result<Self, TooLarge> {
        Self::lower(root, true)
    }

    fn lower(root: &Node, simplify: bool) -> Result<Self, TooLarge> {
        let mut lowering = Lowering { builder: Builder::new(simplify), ordinals: Ordinals::default() };
        let root = lowering.node(root);
        lowering.builder.finish(root)
    }
}

/// Steps of the rings that [`Operation::Smooth`] takes its 19 values from: the disc is cut into a middle and two rings of 1, 6 and 12 equal areas, and each area is
/// seen from its mean squared radius.
const RINGS: [(u32, f64); 3] = [(1, 0.0), (6, 4.0 / 19.0), (12, 13.0 / 19.0)];

struct Lowering {
    builder: Builder,
    ordinals: Ordinals,
}

impl Lowering {
    /// The step that a node's value is, at the sample itself. Children come in the order of the text, and so do the lattices of noises.
    fn node(&mut self, node: &Node) -> Id {
        if self.builder.is_full() {
            return 0;
        }
        let own = node.is_noise().then(|| self.ordinals.next(node));
        let children: Vec<Id> = node.children.iter().map(|child| self.node(child)).collect();
        let builder = &mut self.builder;
        if let Some((lattices, (shape, basis))) = own.zip(node.field()) {
            let noise = builder.noise(Noise { shape, basis, lattices, part: 0 });
            return builder.push(Step::Noise(noise, HERE));
        }
        let p = &node.value.parameters;
        match (own, &children[..]) {
            (Some(lattices), &[h]) => {
                let erosion = Erosion { strength: p[0], scale: p[1], octaves: p[2], depth: p[3] };
                return builder.erode(erosion, lattices, h);
            }
            (Some(lattices), _) => return distorted_noise(builder, node, lattices),
            _ => {}
        }
        match (node.operation, &children[..]) {
            (Operation::X, _) => builder.push(Step::Coordinate(Axis::U, HERE)),
            (Operation::Y, _) => builder.push(Step::Coordinate(Axis::V, HERE)),
            (Operation::Unary(operation), &[a]) => builder.unary(operation, a),
            (Operation::Binary(operation), &[a, b]) => builder.binary(operation, a, b),
            (Operation::Clamp, &[a, low, high]) => {
                let above = builder.binary(Binary::Max, a, low);
                builder.binary(Binary::Min, above, high)
            }
            (Operation::Mix, &[a, b, t]) => {
                let difference = builder.binary(Binary::Minus, b, a);
                let part = builder.binary(Binary::Multiply, difference, t);
                builder.binary(Binary::Plus, a, part)
            }
            (Operation::Select, &[mask, a, b]) => builder.push(Step::Select(mask, a, b)),
            (Operation::Terrace, &[h]) => builder.push(Step::Terrace(Terrace::new(p[0], p[1]), h)),
            (Operation::Warp, &[h, dx, dy]) => builder.warp(h, dx, dy),
            (Operation::GradientX, &[h]) => builder.derivative(h, Axis::U),
            (Operation::GradientY, &[h]) => builder.derivative(h, Axis::V),
            (Operation::Slope, &[h]) => {
                let squares = [Axis::U, Axis::V].map(|axis| {
                    let derivative = builder.derivative(h, axis);
                    builder.binary(Binary::Multiply, derivative, derivative)
                });
                let sum = builder.binary(Binary::Plus, squares[0], squares[1]);
                builder.unary(Unary::Sqrt, sum)
            }
            (Operation::Smooth, &[h]) => smooth(builder, h, p[0]),
            _ => match shape(node) {
                Some(shape) => {
                    let shape = builder.shape(shape);
                    builder.push(Step::Shape(shape, HERE))
                }
                None => builder.number(p[0] as f32),
            },
        }
    }
}

/// basis2(p + d (basis1(p), basis1(p + 13.5))).
fn distorted_noise(builder: &mut Builder, node: &Node, lattices: Lattices) -> Id {
    let [first, second] = [("basis1", 0), ("basis2", 1)].map(|(choice, part)| {
        let noise = builder.noise(Noise { shape: FieldShape::Single, basis: node.basis(choice), lattices, part });
        builder.push(Step::Noise(noise, HERE))
    });
    let distortion = builder.number(node.value.parameters[0] as f32);
    let elsewhere = builder.relocate(first, Motion::Shift(13.5, 13.5));
    let [dx, dy] = [first, elsewhere].map(|noise| builder.binary(Binary::Multiply, distortion, noise));
    builder.warp(second, dx, dy)
}

/// The mean of the disc's 19 places.
fn smooth(builder: &mut Builder, of: Id, radius: f64) -> Id {
    let mut sum = None;
    for (ring, &(count, square)) in RINGS.iter().enumerate() {
        for k in 0..count {
            // The outer ring is turned by half a step.
            let turn = (f64::from(k) + if ring == 2 { 0.5 } else { 0.0 }) * core::f64::consts::TAU / f64::from(count);
            let (distance, (sin, cos)) = (radius * square.sqrt(), (libm::sin(turn), libm::cos(turn)));
            let value = builder.relocate(of, Motion::Shift(distance * cos, distance * sin));
            sum = Some(sum.map_or(value, |sum| builder.binary(Binary::Plus, sum, value)));
        }
    }
    let part = builder.number(1.0 / 19.0);
    builder.binary(Binary::Multiply, sum.unwrap_or(of), part)
}

/// The shape that a node is.
fn shape(node: &Node) -> Option<Shape> {
    let p = &node.value.parameters;
    let direction = || Direction::named(node.choice("direction").unwrap_or("n"));
    Some(match node.operation {
        Operation::Gauss => Shape::Gauss { width: p[0], centre: [p[1], p[2]], repeat: p[3] },
        Operation::Sphere => Shape::Sphere { radius: p[0], centre: [p[1], p[2]], repeat: p[3] },
        Operation::Plane => Shape::Plane { direction: direction() },
        Operation::Step => Shape::Step { direction: direction(), softness: p[0], repeat: p[1] },
        _ => return None,
    })
}
