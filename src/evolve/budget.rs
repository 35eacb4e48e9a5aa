//! What a programme may cost that is bred.

use super::Genome;
use crate::programme::{COST_LIMIT_NS, MAX_DEPTH, MAX_NODES, Tape};
use serde::{Deserialize, Serialize};

/// Limits of every programme that is bred; by default those of programmes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Budget {
    /// Most nodes.
    pub nodes: usize,
    /// Most nodes on a way from the root to a leaf.
    pub depth: usize,
    /// Greatest predicted cost in nanoseconds a sample.
    pub cost_ns: f64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { nodes: MAX_NODES, depth: MAX_DEPTH, cost_ns: COST_LIMIT_NS }
    }
}

impl Budget {
    /// For evolution without a designer: whole populations are evaluated, and programmes are to be read.
    #[must_use]
    pub fn small() -> Self {
        Self { nodes: 64, depth: 16, cost_ns: 800.0 }
    }

    /// The name of a limit that is above that of programmes, or below what a single noise needs, and what it may be.
    #[must_use]
    pub fn wrong(&self) -> Option<(&'static str, String)> {
        if !(1..=MAX_NODES).contains(&self.nodes) {
            return Some(("nodes", format!("must be 1 … {MAX_NODES}, got {}", self.nodes)));
        }
        if !(1..=MAX_DEPTH).contains(&self.depth) {
            return Some(("depth", format!("must be 1 … {MAX_DEPTH}, got {}", self.depth)));
        }
        if !(50.0..=COST_LIMIT_NS).contains(&self.cost_ns) {
            return Some(("cost_ns", format!("must be 50 … {COST_LIMIT_NS} ns a sample, got {}", self.cost_ns)));
        }
        None
    }

    /// The compiled programme of a genome, if it is within the limits.
    #[must_use]
    pub fn admit(&self, genome: &Genome) -> Option<Tape> {
        if genome.size() > self.nodes || genome.depth() > self.depth {
            return None;
        }
        let tape = Tape::compile(genome.programme().ok()?.root());
        (tape.peak_cost_ns() <= self.cost_ns).then_some(tape)
    }
}
