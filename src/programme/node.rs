//! The tree of a programme.

use super::operation::{Operation, Signature};
use crate::noise::{Basis, Feature, FieldShape, Metric, key};

/// What distinguishes a node from others of its operation.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// The numbers of the signature's parameters, in its order; the number itself for a constant.
    pub parameters: Vec<f64>,
    /// Indices into the values of the signature's choices, in its order.
    pub choices: Vec<usize>,
    /// The node's own seed; nodes of one seed share their lattices. Without it the node is told apart by its ordinal.
    pub seed: Option<u32>,
}

/// A node with all below it. Nodes are made by parsing, so arity and ranges hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    pub(super) operation: Operation,
    pub(super) value: Value,
    pub(super) children: Vec<Node>,
}

impl Node {
    /// What stands here.
    #[must_use]
    pub fn operation(&self) -> Operation {
        self.operation
    }

    /// Its numbers, choices and seed.
    #[must_use]
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// The subtrees.
    #[must_use]
    pub fn children(&self) -> &[Node] {
        &self.children
    }

    /// Number of nodes.
    #[must_use]
    pub fn size(&self) -> usize {
        1 + self.children.iter().map(Node::size).sum::<usize>()
    }

    /// Nodes on the longest way to a leaf.
    #[must_use]
    pub fn depth(&self) -> usize {
        1 + self.children.iter().map(Node::depth).max().unwrap_or(0)
    }

    /// The value of a choice by name.
    fn choice(&self, name: &str) -> Option<&'static str> {
        let signature = Signature::of(self.operation)?;
        let at = signature.choices.iter().position(|choice| choice.name == name)?;
        Some(signature.choices[at].values[self.value.choices[at]])
    }

    /// The noise of a node that has lattices, as shape and basis.
    pub(super) fn field(&self) -> Option<(FieldShape, Basis)> {
        let p = &self.value.parameters;
        let metric = || Metric::ALL.into_iter().find(|metric| Some(metric.name()) == self.choice("metric")).unwrap_or_default();
        let single = |basis| Some((FieldShape::Single, basis));
        let basis = || self.choice("basis").and_then(basis_named).unwrap_or(Basis::OPerlin);
        match self.operation {
            Operation::OPerlin => single(Basis::OPerlin),
            Operation::IPerlin => single(Basis::IPerlin),
            Operation::CellNoise => single(Basis::CellNoise),
            Operation::VoronoiF1 => single(Basis::Voronoi { feature: Feature::F1, metric: metric() }),
            Operation::VoronoiF2 => single(Basis::Voronoi { feature: Feature::F2, metric: metric() }),
            Operation::Fbm => Some((FieldShape::Fbm { h: p[0], lacunarity: p[1], octaves: p[2] }, basis())),
            Operation::RidgedMultifractal => Some((FieldShape::Ridged { h: p[0], lacunarity: p[1], octaves: p[2], offset: p[3], gain: p[4] }, basis())),
            Operation::Turbulence => {
                let hard = self.choice("hard") == Some("true");
                Some((FieldShape::Turbulence { octaves: p[0], amplitude: p[1], frequency: p[2], hard }, basis()))
            }
            Operation::Constant | Operation::X | Operation::Y | Operation::Unary(_) | Operation::Binary(_) => None,
        }
    }
}

fn basis_named(name: &str) -> Option<Basis> {
    let metric = Metric::default();
    Some(match name {
        "o_perlin" => Basis::OPerlin,
        "i_perlin" => Basis::IPerlin,
        "cell_noise" => Basis::CellNoise,
        "voronoi_f1" => Basis::Voronoi { feature: Feature::F1, metric },
        "voronoi_f2" => Basis::Voronoi { feature: Feature::F2, metric },
        _ => return None,
    })
}

/// Gives every noise node the key of its lattices.
///
/// A node with a seed of its own has the key of (world seed, that seed); any other has the key of (world seed, operation, ordinal among the nodes of its operation
/// in the order of the text). So an edit elsewhere in the programme, or a function put around it, leaves a noise as it is.
#[derive(Debug)]
pub(super) struct Keys {
    seed: u64,
    seen: Vec<(Operation, u64)>,
}

impl Keys {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, seen: Vec::new() }
    }

    /// The key of the next noise node in the order of the text.
    pub(super) fn next(&mut self, node: &Node) -> u64 {
        let family = Signature::all().iter().position(|signature| signature.operation == node.operation).map_or(0, |at| tag(Signature::all()[at].name));
        let at = self.seen.iter().position(|(operation, _)| *operation == node.operation).unwrap_or_else(|| {
            self.seen.push((node.operation, 0));
            self.seen.len() - 1
        });
        let ordinal = self.seen[at].1;
        self.seen[at].1 += 1;
        match node.value.seed {
            Some(seed) => key(key(self.seed, tag("seed")), seed.into()),
            None => key(key(self.seed, family), ordinal),
        }
    }
}

/// A number for a name, for keys: it must not change when operations are added.
fn tag(name: &str) -> u64 {
    name.bytes().fold(0, |tag, byte| key(tag, byte.into()))
}
