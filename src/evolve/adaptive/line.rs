//! A line of the terrain: a tree of nodes with heights (Yao 2008, section 3.2).

use super::settings::Ground;
use crate::genetic::Draws;

/// A node: how many subtrees follow it, and its height above the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub arity: u8,
    pub height: f32,
}

/// How often nodes have no, one and two subtrees: so often that most trees fill their line before they end.
const ARITIES: [f64; 3] = [0.2, 0.35, 0.45];

/// How often a tree is drawn that would be too large, or too small for its line. Small trees are near any height more easily than large ones: where nothing kept
/// trees large, lines would become a few heights at one border and the mean everywhere else.
const TRIES: usize = 12;

/// A tree, its nodes in preorder: that is the order of its heights from south to north.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line(pub Vec<Node>);

impl Line {
    /// Grows a tree with two subtrees at its root; of some the first that fills its line, or the largest.
    pub(super) fn grown(ground: &Ground, deviation: f64, draws: &mut Draws) -> Self {
        let mut largest = Vec::new();
        for _ in 0..TRIES {
            let nodes = grow(ground, ground.levels, ground.nodes, true, deviation, draws);
            if nodes.len() > largest.len() {
                largest = nodes;
            }
            if largest.len() >= ground.length {
                break;
            }
        }
        Self(largest)
    }

    /// A tree of nodes in preorder; `None` if they are not one whole tree.
    pub(super) fn read(nodes: Vec<Node>) -> Option<Self> {
        let mut open = 1_usize;
        for node in &nodes {
            if open == 0 || node.arity > 2 || !node.height.is_finite() {
                return None;
            }
            open = open + usize::from(node.arity) - 1;
        }
        (open == 0 && nodes.len() > 1).then_some(Self(nodes))
    }

    /// Its heights above the mean, as many as the line is long; those that the tree has not are at the mean.
    pub(super) fn heights(&self, length: usize) -> impl Iterator<Item = f32> + '_ {
        self.0.iter().map(|node| node.height).chain(core::iter::repeat(0.0)).take(length)
    }

    /// The root of the mean square of what its own heights on the line are off the nearest of those wanted, which are above the mean, too.
    pub(super) fn fitness(&self, length: usize, wanted: &[f64]) -> f64 {
        let own = self.0.len().min(length);
        let off = |node: &Node| wanted.iter().map(|y| (f64::from(node.height) - y) * (f64::from(node.height) - y)).fold(f64::INFINITY, f64::min);
        (self.0[..own].iter().map(off).sum::<f64>() / own as f64).sqrt()
    }

    /// The nodes of the subtree that begins at one.
    pub(super) fn subtree(&self, at: usize) -> core::ops::Range<usize> {
        let (mut end, mut open) = (at, 1);
        while open > 0 {
            open += usize::from(self.0[end].arity);
            open -= 1;
            end += 1;
        }
        at..end
    }

    /// Levels above a node.
    pub(super) fn level(&self, at: usize) -> usize {
        // Of the nodes above, how many of their subtrees are still to come.
        let mut open: Vec<u8> = Vec::new();
        for i in 0..=at {
            while open.last() == Some(&0) {
                open.pop();
            }
            if let Some(left) = open.last_mut() {
                *left -= 1;
            }
            if i < at {
                open.push(self.0[i].arity);
            }
        }
        open.len()
    }

    fn with(&self, place: core::ops::Range<usize>, nodes: &[Node]) -> Self {
        Self([&self.0[..place.start], nodes, &self.0[place.end..]].concat())
    }

    /// Whether a tree with so many nodes can take its place: not too large, and no shorter on the line.
    fn makes_way(&self, nodes: usize, ground: &Ground) -> bool {
        (self.0.len().min(ground.length)..=ground.nodes).contains(&nodes)
    }

    /// A copy with a subtree of another in the place of one of its own, neither of them whole; a copy if no such tree has the right size.
    pub(super) fn crossed(&self, other: &Self, ground: &Ground, draws: &mut Draws) -> Self {
        for _ in 0..TRIES {
            let place = self.subtree(1 + draws.below(self.0.len() - 1));
            let taken = other.subtree(1 + draws.below(other.0.len() - 1));
            if self.makes_way(self.0.len() - place.len() + taken.len(), ground) {
                return self.with(place, &other.0[taken]);
            }
        }
        self.clone()
    }

    /// A copy with a grown subtree in the place of one; a copy if no such tree has the right size.
    pub(super) fn mutated(&self, ground: &Ground, deviation: f64, draws: &mut Draws) -> Self {
        for _ in 0..TRIES {
            let place = self.subtree(draws.below(self.0.len()));
            let levels = ground.levels.saturating_sub(self.level(place.start)).max(1);
            let room = ground.nodes - (self.0.len() - place.len());
            let mutated = self.with(place.clone(), &grow(ground, levels, room, place.start == 0, deviation, draws));
            if self.makes_way(mutated.0.len(), ground) {
                return mutated;
            }
        }
        self.clone()
    }
}

fn grow(ground: &Ground, levels: usize, most: usize, root_branches: bool, deviation: f64, draws: &mut Draws) -> Vec<Node> {
    let lowest = ground.range.map(|bound| bound - ground.mean);
    let mut nodes: Vec<Node> = Vec::new();
    // Levels that are left for every subtree to come, the next last.
    let mut open = vec![levels];
    while let Some(left) = open.pop() {
        let room = most.saturating_sub(nodes.len() + open.len() + 1).min(2) as u8;
        let drawn = if root_branches && nodes.is_empty() { 2 } else { draws.weighted(&ARITIES) as u8 };
        let arity = if left <= 1 { 0 } else { drawn.min(room) };
        let height = (deviation * draws.normal()).clamp(lowest[0], lowest[1]) as f32;
        open.extend(core::iter::repeat_n(left - 1, usize::from(arity)));
        nodes.push(Node { arity, height });
    }
    nodes
}
