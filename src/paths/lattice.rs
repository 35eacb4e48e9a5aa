//! The lattice graph: nodes on the whole plane, each joined with its eight neighbours.

use crate::noise;
use core::f32::consts::SQRT_2;

/// Steps from a node to its neighbours, in ascending order of the neighbour's (row, column).
pub const STEPS: [[i64; 2]; 8] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// A node by its column (eastward) and row (northward).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Node {
    /// Nodes are ordered by row first.
    pub row: i64,
    /// From west to east.
    pub column: i64,
}

/// A rectangle of nodes. Values of its nodes lie in slots, row by row from the south, with a border of one slot around that no path enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Frame {
    /// Its first node, in the south-west.
    pub first: Node,
    /// Nodes from west to east.
    pub columns: usize,
    /// Nodes from south to north.
    pub rows: usize,
}

impl Frame {
    /// Slots from a node to the next to the north.
    #[must_use]
    pub fn stride(&self) -> usize {
        self.columns + 2
    }

    /// Slots, those of the border among them.
    #[must_use]
    pub fn slots(&self) -> usize {
        self.stride() * (self.rows + 2)
    }

    /// Where a node's values lie; `None` outside the frame.
    #[must_use]
    pub fn slot(&self, node: Node) -> Option<usize> {
        let (i, j) = (node.column - self.first.column, node.row - self.first.row);
        let inside = (0..self.columns as i64).contains(&i) && (0..self.rows as i64).contains(&j);
        inside.then(|| (j as usize + 1) * self.stride() + i as usize + 1)
    }

    /// The node of a slot; slots of the border have nodes too, outside the frame.
    #[must_use]
    pub fn node(&self, slot: usize) -> Node {
        let (row, column) = (slot / self.stride(), slot % self.stride());
        Node { row: self.first.row + row as i64 - 1, column: self.first.column + column as i64 - 1 }
    }

    /// The slots of its nodes, row by row from the south.
    #[must_use]
    pub fn rows_of_slots(&self) -> impl DoubleEndedIterator<Item = core::ops::Range<usize>> + use<> {
        let (stride, columns) = (self.stride(), self.columns);
        (1..=self.rows).map(move |row| row * stride + 1..row * stride + 1 + columns)
    }

    /// The frame with `n` more nodes on every side.
    #[must_use]
    pub fn grown(&self, n: usize) -> Self {
        let first = Node { row: self.first.row - n as i64, column: self.first.column - n as i64 };
        Self { first, columns: self.columns + 2 * n, rows: self.rows + 2 * n }
    }

    /// From a slot to those of the node's neighbours, as [`STEPS`].
    pub(super) fn offsets(&self) -> [isize; 8] {
        STEPS.map(|[i, j]| j as isize * self.stride() as isize + i as isize)
    }
}

/// How long a diagonal step is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Diagonal {
    /// √2 straight ones.
    #[default]
    Euclidean,
    /// As a straight one (the thesis's rule: smooth cones are square).
    Plain,
}

impl Diagonal {
    fn factor(self) -> f32 {
        match self {
            Self::Euclidean => SQRT_2,
            Self::Plain => 1.0,
        }
    }

    fn factors(self) -> [f32; 8] {
        STEPS.map(|[i, j]| if i != 0 && j != 0 { self.factor() } else { 1.0 })
    }
}

/// Random weights of edges: `mean + deviation · v`, v one of 65,536 even steps from -1 to 1 by a hash of the edge's place (Rusnell 2009, Eq. 3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Random {
    /// Mean weight, above 0.
    pub mean: f32,
    /// Most deviation from it, less than it.
    pub deviation: f32,
    /// What the hash starts from.
    pub key: u64,
}

impl Random {
    /// What the hash of a row's edges starts from.
    #[inline]
    fn row(&self, row: i64) -> u64 {
        noise::mix(self.key ^ noise::mix(row as u64))
    }

    /// The draws of the edges that leave a node eastward, to the north-west, northward and to the north-east.
    #[inline]
    fn draws(row: u64, column: i64) -> [u16; 4] {
        let bits = noise::mix(row ^ column as u64);
        [bits, bits >> 16, bits >> 32, bits >> 48].map(|bits| bits as u16)
    }

    /// The weight that a draw stands for is `first + draw · step`, both for straight and for diagonal edges.
    fn line(&self, diagonal: Diagonal) -> [Line; 2] {
        [1.0, diagonal.factor()].map(|factor| {
            let step = self.deviation / 32_767.5;
            Line { first: (self.mean - self.deviation) * factor, step: step * factor }
        })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    first: f32,
    step: f32,
}

/// The weights of the steps between the nodes of a frame.
#[derive(Clone, Debug)]
pub struct Weights {
    /// What nodes these are.
    pub frame: Frame,
    /// Of every slot: draws, or the bits of its own weight.
    pub(super) values: Vec<[u16; 4]>,
    pub(super) rule: Rule,
}

/// From a slot's values to weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    /// Draws of undirected edges; what weights they stand for, one a step.
    Edges { first: [f32; 8], step: [f32; 8] },
    /// A weight that all steps out of a node share, and how much longer each is.
    Nodes { factors: [f32; 8] },
}

impl Weights {
    /// Undirected weights by the hash of each edge's place.
    #[must_use]
    pub fn random(frame: Frame, random: &Random, diagonal: Diagonal) -> Self {
        let (first, stride) = (frame.node(0), frame.stride());
        let values = (0..frame.rows + 2).flat_map(|row| {
            let row = random.row(first.row + row as i64);
            (0..stride as i64).map(move |column| Random::draws(row, first.column + column))
        });
        let lines = random.line(diagonal);
        let line = STEPS.map(|[i, j]| lines[usize::from(i != 0 && j != 0)]);
        Self { frame, values: values.collect(), rule: Rule::Edges { first: line.map(|line| line.first), step: line.map(|line| line.step) } }
    }

    /// Directed weights: those of all steps out of a node are the node's own.
    #[must_use]
    pub fn of_nodes(frame: Frame, weight: impl Fn(Node) -> f32, diagonal: Diagonal) -> Self {
        let values = (0..frame.slots()).map(|slot| {
            let bits = weight(frame.node(slot)).to_bits();
            [bits as u16, (bits >> 16) as u16, 0, 0]
        });
        Self { frame, values: values.collect(), rule: Rule::Nodes { factors: diagonal.factors() } }
    }

    /// The weights of the eight steps out of a node of the frame, as [`STEPS`].
    #[must_use]
    pub fn of(&self, slot: usize) -> [f32; 8] {
        let south = slot - self.frame.stride();
        self.rule.weights([south - 1, south, south + 1, slot - 1, slot].map(|slot| self.values[slot]))
    }

    /// The least weight that a step can have.
    #[must_use]
    pub fn least(&self) -> f32 {
        match self.rule {
            Rule::Edges { first, .. } => first.into_iter().fold(f32::INFINITY, f32::min),
            Rule::Nodes { .. } => self.frame.rows_of_slots().flatten().map(|slot| own(self.values[slot])).fold(f32::INFINITY, f32::min),
        }
    }
}

impl Weights {
    /// The greatest weight that a step can have.
    #[must_use]
    pub fn greatest(&self) -> f32 {
        match self.rule {
            Rule::Edges { first, step } => first.into_iter().zip(step).map(|(first, step)| first + step * f32::from(u16::MAX)).fold(0.0, f32::max),
            Rule::Nodes { factors } => {
                let most = self.frame.rows_of_slots().flatten().map(|slot| own(self.values[slot])).fold(0.0, f32::max);
                most * factors[0]
            }
        }
    }
}

fn own(values: [u16; 4]) -> f32 {
    f32::from_bits(u32::from(values[0]) | u32::from(values[1]) << 16)
}

impl Rule {
    /// The weights of the eight steps out of a slot, as [`STEPS`], from the values of the slots to its south-west, south, south-east and west, and its own.
    #[inline(always)]
    pub(super) fn weights(&self, [south_west, south, south_east, west, here]: [[u16; 4]; 5]) -> [f32; 8] {
        match self {
            Self::Edges { first, step } => {
                let draws = [south_west[3], south[2], south_east[1], west[0], here[0], here[1], here[2], here[3]];
                core::array::from_fn(|k| first[k] + f32::from(draws[k]) * step[k])
            }
            Self::Nodes { factors } => {
                let own = own(here);
                factors.map(|factor| own * factor)
            }
        }
    }
}
