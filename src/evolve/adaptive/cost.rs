//! What breeding takes, predicted.

use super::settings::{Feedback, Ground};

/// Nanoseconds a node of the lattice takes: its displacement, its levels, its name.
const NODE_NS: f64 = 160.0;

/// Nanoseconds a node of a tree takes.
const TREE_NS: f64 = 12.0;

/// Nanoseconds that the distance of a node from a point takes, and that from a part of a way.
const POINT_NS: f64 = 3.0;
const PART_NS: f64 = 40.0;

impl Ground {
    /// The predicted time to breed a generation without bounds on where it changes, on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self) -> f64 {
        NODE_NS * self.nodes_of_lattice() + TREE_NS * (self.populations * self.lines * self.nodes) as f64
    }

    /// The predicted time that a part of a way from a point to another adds to that.
    #[must_use]
    pub fn part_ns(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let far = 2.0 * (self.promise / self.cell + 2.0 + self.fade as f64) + 2.0;
        let [dx, dy] = [0, 1].map(|axis| (to[axis] - from[axis]).abs() / self.cell);
        let [columns, rows] = self.size().map(|count| count as f64);
        // Row by row as many nodes as the part crosses there, and those around.
        let (up, across) = ((dy + far).min(rows), (dx + far).min(columns));
        PART_NS * (up * across).min(across * far + up * far)
    }

    fn nodes_of_lattice(&self) -> f64 {
        let [columns, rows] = self.size();
        (columns * rows) as f64
    }
}

impl Feedback {
    /// The predicted time to breed by it on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, ground: &Ground) -> f64 {
        let points = if self.radius.is_some() { POINT_NS * self.points.len() as f64 * ground.nodes_of_lattice() } else { 0.0 };
        let way = |way: &Vec<[f64; 2]>| match way[..] {
            [alone] => ground.part_ns(alone, alone),
            _ => way.windows(2).map(|pair| ground.part_ns(pair[0], pair[1])).sum(),
        };
        ground.cost_ns() + points + self.ways.iter().map(way).sum::<f64>()
    }
}
