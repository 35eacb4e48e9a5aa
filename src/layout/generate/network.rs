//! Rivers as trees: where their nodes lie, what flows through them, how high they are.

use super::{
    lakes::Lake,
    plane::{Point, along, distance, minus},
};

/// A place that water passes.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) at: Point,
    /// The node that the water flows to; a mouth has none.
    pub(super) parent: Option<usize>,
    /// How many nodes' water passes here, this one's included.
    pub(super) upstream: f64,
    /// Elevation of the water in metres.
    pub(super) elevation: f64,
    /// The lake that lies on this node.
    pub(super) lake: Option<usize>,
}

/// Trees of rivers and the lakes on them. Once sorted, a parent comes before its children.
#[derive(Clone, Debug, Default)]
pub(super) struct Network {
    pub(super) nodes: Vec<Node>,
    pub(super) lakes: Vec<Lake>,
}

/// Rivers' slopes: `source_slope · upstream^-concavity`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    pub(super) source_slope: f64,
    pub(super) concavity: f64,
}

/// A river between two places where waters meet, from its upper to its lower end.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    pub(super) line: Vec<[f64; 3]>,
    /// How many nodes' water passes its lower end.
    pub(super) upstream: f64,
}

impl Network {
    /// Adds a node that flows to `parent` and gives its index.
    pub(super) fn add(&mut self, at: Point, parent: Option<usize>, elevation: f64) -> usize {
        self.nodes.push(Node { at, parent, upstream: 0.0, elevation, lake: None });
        self.nodes.len() - 1
    }

    /// The children of every node.
    pub(super) fn children(&self) -> Vec<Vec<usize>> {
        let mut children = vec![Vec::new(); self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate() {
            if let Some(parent) = node.parent {
                children[parent].push(index);
            }
        }
        children
    }

    /// Removes mouths that no river came to; says of every node whether it stayed.
    pub(super) fn drop_dry_mouths(&mut self) -> Vec<bool> {
        let children = self.children();
        let keep: Vec<bool> = self.nodes.iter().zip(&children).map(|(node, children)| node.parent.is_some() || !children.is_empty()).collect();
        let order: Vec<usize> = (0..keep.len()).filter(|&index| keep[index]).collect();
        self.arrange(&order);
        keep
    }

    /// Puts every parent before its children: mouths first, then by the number of steps from the mouth.
    pub(super) fn sort(&mut self) {
        let children = self.children();
        let mut order: Vec<usize> = (0..self.nodes.len()).filter(|&index| self.nodes[index].parent.is_none()).collect();
        let mut next = 0;
        while let Some(&index) = order.get(next) {
            order.extend(&children[index]);
            next += 1;
        }
        self.arrange(&order);
    }

    /// Keeps the nodes in `order`, in that order.
    fn arrange(&mut self, order: &[usize]) {
        let mut places = vec![0; self.nodes.len()];
        for (place, &index) in order.iter().enumerate() {
            places[index] = place;
        }
        self.nodes = order.iter().map(|&index| self.nodes[index].clone()).collect();
        for node in &mut self.nodes {
            node.parent = node.parent.map(|parent| places[parent]);
        }
    }

    /// Counts what flows through every node.
    pub(super) fn accumulate(&mut self) {
        for node in &mut self.nodes {
            node.upstream = 1.0;
        }
        for index in (0..self.nodes.len()).rev() {
            if let Some(parent) = self.nodes[index].parent {
                self.nodes[parent].upstream += self.nodes[index].upstream;
            }
        }
    }

    /// The ends of the river from a node to its parent, lower end first: the nodes, or the rims of the lakes that lie on them.
    pub(super) fn segment(&self, index: usize) -> Option<[Point; 2]> {
        let upper = &self.nodes[index];
        let parent = upper.parent?;
        let lower = &self.nodes[parent];
        let down = minus(lower.at, upper.at);
        let arm = |lake: Option<usize>, branch: usize| lake.map_or(0.0, |lake| self.lakes[lake].arm(branch));
        // An arm of a lake is a share of the distance between the two nodes and is kept under the name of the segment's upper node.
        Some([along(lower.at, -arm(lower.lake, index), down), along(upper.at, arm(upper.lake, index), down)])
    }

    /// Gives every node its elevation, from the mouths up, and every lake its level.
    pub(super) fn rise(&mut self, profile: Profile) {
        for index in 0..self.nodes.len() {
            let (Some(parent), Some([lower, upper])) = (self.nodes[index].parent, self.segment(index)) else { continue };
            let slope = profile.source_slope * libm::pow(self.nodes[index].upstream, -profile.concavity);
            self.nodes[index].elevation = self.nodes[parent].elevation + slope * distance(lower, upper);
            if let Some(lake) = self.nodes[index].lake {
                self.lakes[lake].level = self.nodes[index].elevation;
            }
        }
    }

    /// The rivers cut where waters meet: at confluences and at the rims of lakes. Mouths come first, every reach after what it flows to.
    pub(super) fn reaches(&self) -> Vec<Reach> {
        let children = self.children();
        let mut reaches = Vec::new();
        for start in 0..self.nodes.len() {
            let Some(parent) = self.nodes[start].parent else { continue };
            // A reach begins, at its lower end, where its lower node is a mouth, a confluence or a lake.
            if self.nodes[parent].parent.is_some() && children[parent].len() == 1 && self.nodes[parent].lake.is_none() {
                continue;
            }
            let (mut line, mut index) = (Vec::new(), start);
            let height = |p: Point, elevation: f64| [p[0], p[1], elevation];
            while let Some([lower, upper]) = self.segment(index) {
                if line.is_empty() {
                    line.push(height(lower, self.nodes[parent].elevation));
                }
                line.push(height(upper, self.nodes[index].elevation));
                let [next] = children[index][..] else { break };
                if self.nodes[index].lake.is_some() {
                    break;
                }
                index = next;
            }
            line.reverse();
            reaches.push(Reach { line, upstream: self.nodes[start].upstream });
        }
        reaches
    }
}
