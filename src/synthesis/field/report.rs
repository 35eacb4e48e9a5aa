//! What a synthesis tells, and what it goes on from.

use super::gene::Gene;
use crate::synthesis::Level;
use serde::{Deserialize, Serialize};

/// Most cells of a field at its finest level: 2^23, at 10 m a square of 28 km.
pub const MAX_FIELD_CELLS: usize = 1 << 23;

/// Ground at a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldLevel {
    /// Metres between cells.
    pub level: Level,
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// Metres, row by row from the north-west.
    pub heights: Vec<f32>,
    /// How fit it is, 0 … 1; of the coarsest level how similar.
    pub fitness: f64,
    /// How well its genes fit the level before, 0 … 1; of the coarsest level 1.
    pub compatibility: f64,
    /// How similar its regions are to their types, 0 … 1, weighted by area; edges are linked within blocks.
    pub similarity: f64,
    /// The same with edges linked over whole regions.
    pub whole_similarity: f64,
    /// How many grounds were evaluated.
    pub evaluations: u64,
}

/// Where the genetic algorithm of a level is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldGeneration {
    /// Generations bred.
    pub generation: usize,
    /// How many grounds were evaluated.
    pub evaluations: u64,
    /// The genes of every ground.
    pub genomes: Vec<Vec<Gene>>,
}

/// All that a synthesis goes on from: written down after a generation and read again, it goes on to the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldCheckpoint {
    /// SHA-256 of all that the ground depends on, in hexadecimal.
    pub inputs: String,
    /// Levels that are done, from the coarsest.
    pub done: Vec<FieldLevel>,
    /// The level under way.
    pub current: Option<FieldGeneration>,
}

/// How far a synthesis is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FieldProgress {
    /// The level under way, or just done.
    pub level: Level,
    /// Its number, from 0 for the coarsest.
    pub number: usize,
    /// How many levels there are.
    pub levels: usize,
    /// Generations bred of this level.
    pub generation: usize,
    /// Generations of a level.
    pub generations: usize,
    /// The greatest fitness.
    pub best: f64,
    /// From 0 to 1: every level counts nine times as much as the one before.
    pub share: f64,
}

/// What is told after every generation.
#[derive(Clone, Copy, Debug)]
pub struct FieldStep<'a> {
    /// How far it is.
    pub progress: FieldProgress,
    /// What it goes on from.
    pub checkpoint: &'a FieldCheckpoint,
    /// Columns of the best ground so far.
    pub columns: usize,
    /// Its heights, row by row from the north-west.
    pub heights: &'a [f32],
}
