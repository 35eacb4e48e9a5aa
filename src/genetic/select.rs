//! Which individuals become parents.

use super::Draws;
use serde::{Deserialize, Serialize};

/// How a parent is found among the fitnesses of an island.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Selection {
    /// The fittest of some individuals that are drawn, each from all.
    Tournament {
        /// How many are drawn.
        size: usize,
    },
    /// In proportion to fitness. What is not above 0 is never chosen, unless nothing is.
    Proportional,
}

impl Selection {
    /// The index of a parent.
    pub fn choose(self, fitness: &[f64], draws: &mut Draws) -> usize {
        match self {
            Selection::Tournament { size } => {
                let first = draws.below(fitness.len());
                (1..size).fold(first, |best, _| {
                    let other = draws.below(fitness.len());
                    if fitness[other] > fitness[best] { other } else { best }
                })
            }
            Selection::Proportional => draws.weighted(fitness),
        }
    }
}

/// Indices of the fittest first; of equals, the first.
#[must_use]
pub fn ranking(fitness: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..fitness.len()).collect();
    order.sort_by(|&a, &b| fitness[b].total_cmp(&fitness[a]));
    order
}
