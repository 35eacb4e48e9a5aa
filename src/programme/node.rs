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

    /// Whether the node has lattices of its own.
    pub(super) fn is_noise(&self) -> bool {
        Signature::of(self.operation).is_some_and(|signature| signature.noise)
    }

    /// The value of a choice by name.
    pub(super) fn choice(&self, name: &str) -> Option<&'static str> {
        let signature = Signature::of(self.operation)?;
        let at = signature.choices.iter().position(|choice| choice.name == name)?;
        Some(signature.choices[at].values[self.value.choices[at]])
    }

    /// The fractal or single noise that the node is, as shape and basis; `None` for other nodes.
    pub(super) fn field(&self) -> Option<(FieldShape, Basis)> {
        let p = &self.value.parameters;
        let single = |basis| Some((FieldShape::Single, basis));
        let shape = match self.operation {
            Operation::BlenderNoise => return single(Basis::Blender),
            Operation::OPerlin => return single(Basis::OPerlin),
            Operation::IPerlin => return single(Basis::IPerlin),
            Operation::CellNoise => return single(Basis::CellNoise),
            Operation::Voronoi(feature) => return single(Basis::Voronoi { feature, metric: self.metric() }),
            Operation::VoronoiDistance => return single(Basis::Voronoi { feature: Feature::F1, metric: self.metric() }),
            Operation::Fbm => FieldShape::Fbm { h: p[0], lacunarity: p[1], octaves: p[2] },
            Operation::Multifractal => FieldShape::Multifractal { h: p[0], lacunarity: p[1], octaves: p[2] },
            Operation::HeteroTerrain => FieldShape::Hetero { h: p[0], lacunarity: p[1], octaves: p[2], offset: p[3] },
            Operation::HybridMultifractal => FieldShape::Hybrid { h: p[0], lacunarity: p[1], octaves: p[2], offset: p[3], gain: p[4] },
            Operation::RidgedMultifractal => FieldShape::Ridged { h: p[0], lacunarity: p[1], octaves: p[2], offset: p[3], gain: p[4] },
            Operation::Turbulence => {
                let hard = self.choice("hard") == Some("true");
                FieldShape::Turbulence { octaves: p[0], amplitude: p[1], frequency: p[2], hard }
            }
            Operation::Spectral => FieldShape::Spectral { beta: p[0], octaves: p[1] },
            _ => return None,
        };
        Some((shape, self.basis("basis")))
    }

    fn metric(&self) -> Metric {
        match self.choice("metric") {
            Some("minkowski") => Metric::Minkowski { exponent: self.value.parameters[0] as f32 },
            chosen => Metric::ALL.into_iter().find(|metric| Some(metric.name()) == chosen).unwrap_or_default(),
        }
    }

    /// The basis that a choice names.
    pub(super) fn basis(&self, choice: &str) -> Basis {
        let voronoi = |feature| Basis::Voronoi { feature, metric: Metric::Distance };
        match self.choice(choice) {
            Some("i_perlin") => Basis::IPerlin,
            Some("blender_noise") => Basis::Blender,
            Some("cell_noise") => Basis::CellNoise,
            Some("voronoi_f1") => voronoi(Feature::F1),
            Some("voronoi_f2") => voronoi(Feature::F2),
            Some("voronoi_f3") => voronoi(Feature::F3),
            Some("voronoi_f4") => voronoi(Feature::F4),
            Some("voronoi_f2f1") => voronoi(Feature::F2F1),
            Some("voronoi_crackle") => voronoi(Feature::Crackle),
            _ => Basis::OPerlin,
        }
    }
}

/// Which lattices a noise node has, whatever the world's seed.
///
/// A node with a seed of its own shares them with all nodes of that seed; any other is told apart by its operation and its ordinal among the nodes of that
/// operation in the order of the text. So an edit elsewhere in the programme, or a function put around it, leaves a noise as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Lattices {
    Named(u32),
    Ordinal { family: u64, ordinal: u64 },
}

impl Lattices {
    /// The key to hash them with in a world of that seed.
    pub(super) fn key(self, seed: u64) -> u64 {
        match self {
            Lattices::Named(own) => key(key(seed, tag("seed")), own.into()),
            Lattices::Ordinal { family, ordinal } => key(key(seed, family), ordinal),
        }
    }
}

/// Gives the noise nodes of a programme their lattices, in the order of the text.
#[derive(Debug, Default)]
pub(super) struct Ordinals(Vec<(Operation, u64)>);

impl Ordinals {
    pub(super) fn next(&mut self, node: &Node) -> Lattices {
        let at = self.0.iter().position(|(operation, _)| *operation == node.operation).unwrap_or_else(|| {
            self.0.push((node.operation, 0));
            self.0.len() - 1
        });
        let ordinal = self.0[at].1;
        self.0[at].1 += 1;
        match node.value.seed {
            Some(seed) => Lattices::Named(seed),
            None => Lattices::Ordinal { family: Signature::of(node.operation).map_or(0, |signature| tag(signature.name)), ordinal },
        }
    }
}

/// A number for a name, for keys: it must not change when operations are added.
fn tag(name: &str) -> u64 {
    name.bytes().fold(0, |tag, byte| key(tag, byte.into()))
}
