//! Terrain that evolves while it is used (Yao, "Dynamic terrain", 2008): the whole population is the terrain, and where one clicks, or is, says what is fit.
//!
//! Every individual is a line of the terrain, a tree whose heights in preorder are those along the line. [`Feedback`] at a height makes the lines near it parents of
//! the next generation. All generations follow from a [`History`], plain data; an [`Adaptive`] breeds them and answers any as an [`AdaptiveTerrain`], which can be
//! sampled like any other source.
//!
//! What differs from the thesis, because of what its rules lead to: children are copies with a subtree exchanged and replace the least fit (exchanging in place keeps all
//! heights and converges nowhere); the deviation of what is grown, |Y - M|, is held between 2 % and 25 % of the range, and heights within it (else all heights
//! become two, or run away); what a short tree lacks is at the mean, not at 0; 5 % of the lines are made unlike, in turn, so that plains have spikes and are
//! not lost for good; and displacements do not change from one generation to the next, so that ground which does not change stays as it is.

mod blocks;
mod cost;
mod generation;
mod history;
mod lattice;
mod line;
mod players;
mod population;
mod settings;
mod state;
mod terrain;
#[cfg(test)]
mod tests;

pub use generation::Generation;
pub use history::Adaptive;
pub use players::Players;
pub use settings::{Feedback, Ground, HISTORY_FORM, History, MAX_HISTORY, MAX_LATTICE, MAX_POSITIONS, MAX_TREES, Step};
pub use terrain::AdaptiveTerrain;
