//! Crossover and mutation of programmes (Frade, Fernández de Vega, Cotta 2009, table I; Koza 1992).

use super::{
    genome::Genome,
    vocabulary::{self, Method},
};
use crate::genetic::Draws;
use serde::{Deserialize, Serialize};

/// Levels of the trees that replace a node.
const REPLACEMENT_DEPTH: usize = 4;

/// Pairs that are drawn to find two disjoint subtrees, before they are looked for.
const PAIRS: usize = 8;

/// What was mutated. Each is drawn as often; where a programme has nothing to shrink or to swap, a node is replaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mutation {
    /// A node, with all below it, made way for a grown tree.
    Replace,
    /// A subtree made way for one of its own subtrees.
    Shrink,
    /// Two subtrees were exchanged, disjoint where there are such; in a chain of functions of one value two functions.
    Swap,
}

/// Puts a random subtree of `giver` in the place of a random subtree of `taker`.
#[must_use]
pub fn cross(taker: &Genome, giver: &Genome, draws: &mut Draws) -> Genome {
    let place = taker.subtree(draws.below(taker.size()));
    let taken = giver.subtree(draws.below(giver.size()));
    taker.with(place, &giver.genes()[taken])
}

/// Mutates a programme, and some of its numbers and choices, one on average.
#[must_use]
pub fn mutate(genome: &Genome, draws: &mut Draws) -> (Genome, Mutation) {
    let (mut child, mutation) = match draws.below(3) {
        0 => (replace(genome, draws), Mutation::Replace),
        1 => shrink(genome, draws).map_or_else(|| (replace(genome, draws), Mutation::Replace), |child| (child, Mutation::Shrink)),
        _ => swap(genome, draws).map_or_else(|| (replace(genome, draws), Mutation::Replace), |child| (child, Mutation::Swap)),
    };
    vocabulary::vary(child.genes_mut(), draws);
    (child, mutation)
}

fn replace(genome: &Genome, draws: &mut Draws) -> Genome {
    let place = genome.subtree(draws.below(genome.size()));
    genome.with(place, &vocabulary::grow(1 + draws.below(REPLACEMENT_DEPTH), Method::Grow, draws))
}

fn shrink(genome: &Genome, draws: &mut Draws) -> Option<Genome> {
    let functions: Vec<usize> = (0..genome.size()).filter(|&i| genome.genes()[i].arity() > 0).collect();
    let whole = genome.subtree(*functions.get(draws.below(functions.len()))?);
    let part = genome.subtree(whole.start + 1 + draws.below(whole.len() - 1));
    Some(genome.with(whole, &genome.genes()[part]))
}

fn swap(genome: &Genome, draws: &mut Draws) -> Option<Genome> {
    let Some([first, second]) = disjoint(genome, draws) else { return swap_in_chain(genome, draws) };
    let [a, b] = [first, second].map(|at| genome.subtree(at));
    let genes = genome.genes();
    Some(Genome::new([&genes[..a.start], &genes[b.clone()], &genes[a.end..b.start], &genes[a], &genes[b.end..]].concat()))
}

/// Two disjoint subtrees in their order; none in a chain.
fn disjoint(genome: &Genome, draws: &mut Draws) -> Option<[usize; 2]> {
    for _ in 0..PAIRS {
        let (a, b) = (draws.below(genome.size()), draws.below(genome.size()));
        let (first, second) = (a.min(b), a.max(b));
        if second >= genome.subtree(first).end {
            return Some([first, second]);
        }
    }
    // Below a node that branches, one in the first and one in the last of its subtrees.
    let branching: Vec<usize> = (0..genome.size()).filter(|&i| genome.genes()[i].arity() > 1).collect();
    let node = *branching.get(draws.below(branching.len()))?;
    let first = genome.subtree(node + 1);
    let mut last = genome.subtree(first.end);
    for _ in 2..genome.genes()[node].arity() {
        last = genome.subtree(last.end);
    }
    Some([first.start + draws.below(first.len()), last.start + draws.below(last.len())])
}

/// Exchanges two functions of a chain; none if it has fewer.
fn swap_in_chain(genome: &Genome, draws: &mut Draws) -> Option<Genome> {
    let functions = genome.size() - 1;
    if functions < 2 {
        return None;
    }
    let first = draws.below(functions);
    let second = (first + 1 + draws.below(functions - 1)) % functions;
    let mut genes = genome.genes().to_vec();
    genes.swap(first, second);
    Some(Genome::new(genes))
}
