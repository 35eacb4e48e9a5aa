//! Which points of a part of a block lie inside a polygon.

use super::runs::{Found, Runs};
use crate::geometry::{Curve, EdgeDetail, Rectangle, crosses};

/// The path of an edge with detail, or of a segment of one.
#[derive(Clone, Copy, Debug)]
struct Node {
    ends: [[f64; 2]; 2],
    /// A rectangle that holds the path.
    bounds: Rectangle,
    detail: u32,
    index: u32,
    level: u8,
}

impl Node {
    fn new(of: &EdgeDetail, detail: u32, [level, index]: [u32; 2], ends: [[f64; 2]; 2]) -> Self {
        let bounds = Rectangle::around(&ends).grown(of.reach(level as u8, ends[0], ends[1]));
        Self { ends, bounds, detail, index, level: level as u8 }
    }

    fn halves(&self, of: &EdgeDetail) -> [Self; 2] {
        let ([a, b], level) = (self.ends, u32::from(self.level) + 1);
        let middle = of.midpoint(self.level, self.index, a, b);
        [([a, middle], 2 * self.index), ([middle, b], 2 * self.index + 1)].map(|(ends, index)| Self::new(of, self.detail, [level, index], ends))
    }
}

/// Edges and paths that rays from a block eastwards can cross.
#[derive(Clone, Debug, Default)]
pub(super) struct Parity {
    details: Vec<EdgeDetail>,
    /// Paths with detail.
    nodes: Vec<Node>,
    /// Edges, and ends of paths that lie wholly in the east.
    pairs: Vec<[[f64; 2]; 2]>,
    stack: Vec<Node>,
    part: Vec<[[f64; 2]; 2]>,
}

impl Parity {
    /// Goes to a polygon and a block.
    pub(super) fn begin(&mut self, curve: &Curve, runs: Option<&Runs>, area: &Rectangle, spacing: f64) {
        self.details.clear();
        self.nodes.clear();
        self.pairs.clear();
        match runs {
            None => self.edges(curve, 0..curve.chord_count() * curve.stride(), area, spacing),
            Some(runs) => runs.east(area, |found| match found {
                Found::Edges([first, end]) => self.edges(curve, first as usize..end as usize, area, spacing),
                Found::Path([first, end]) => self.pairs.push([curve.edge(first as usize)[0], curve.edge(end as usize - 1)[1]]),
            }),
        }
    }

    fn edges(&mut self, curve: &Curve, edges: std::ops::Range<usize>, area: &Rectangle, spacing: f64) {
        for ends in edges.map(|i| curve.edge(i)) {
            let Some(detail) = curve.detail() else {
                if matters(&Rectangle::around(&ends), area) {
                    self.pairs.push(ends);
                }
                continue;
            };
            if matters(&Rectangle::around(&ends).grown(detail.reach(ends[0], ends[1])), area) {
                let detail = detail.of_edge(ends[0], ends[1], spacing);
                self.nodes.push(Node::new(&detail, self.details.len() as u32, [0; 2], detail.ends));
                self.details.push(detail);
            }
        }
    }

    /// Collects what rays from a part of the block can cross.
    fn collect(&mut self, area: &Rectangle) {
        self.part.clear();
        self.part.extend(self.pairs.iter().filter(|ends| matters(&Rectangle::around(*ends), area)));
        self.stack.clear();
        self.stack.extend_from_slice(&self.nodes);
        while let Some(node) = self.stack.pop() {
            if !matters(&node.bounds, area) {
                continue;
            }
            let detail = &self.details[node.detail as usize];
            if node.level == detail.levels || node.bounds.min[0] > area.max[0] {
                self.part.push(node.ends);
            } else {
                self.stack.extend(node.halves(detail));
            }
        }
    }

    /// Writes 1 for points outside and -1 for points inside; `together` says that they are all on one side.
    pub(super) fn fill(&mut self, xs: &[f64], ys: &[f64], together: bool, signs: &mut [f64]) {
        let asked = if together { 1 } else { xs.len() };
        let points = || xs.iter().zip(ys).take(asked).map(|(&x, &y)| [x, y]);
        let area = points().fold(Rectangle::EMPTY, |area, p| area.union(Rectangle { min: p, max: p }));
        self.collect(&area);
        for (sign, p) in signs.iter_mut().zip(points()) {
            let inside = self.part.iter().fold(false, |inside, ends| inside ^ crosses(p, ends[0], ends[1]));
            *sign = if inside { -1.0 } else { 1.0 };
        }
        let first = signs[0];
        signs[asked..].fill(first);
    }
}

/// Whether rays from an area eastwards can meet what a rectangle holds.
fn matters(bounds: &Rectangle, area: &Rectangle) -> bool {
    bounds.min[1] <= area.max[1] && bounds.max[1] >= area.min[1] && bounds.max[0] >= area.min[0]
}
