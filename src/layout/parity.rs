//! Which points of a part of a block lie inside a polygon.

use super::{
    runs::{Found, Runs},
    search::{Node, halves, node},
};
use crate::geometry::{Curve, EdgeDetail, Rectangle, crosses};

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
                self.nodes.push(node(&detail, self.details.len() as u32, 0, 0, detail.ends[0], detail.ends[1]));
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
            let bounds = node.bounds();
            if !matters(&bounds, area) {
                continue;
            }
            if node.straight || bounds.min[0] > area.max[0] {
                self.part.push([node.a, node.b]);
            } else {
                self.stack.extend(halves(&self.details[node.chord as usize], &node));
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
