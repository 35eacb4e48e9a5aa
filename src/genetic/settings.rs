//! How a population is bred.

use super::Selection;
use serde::{Deserialize, Serialize};

/// Most individuals of all islands together.
pub const MAX_INDIVIDUALS: usize = 1 << 16;

/// Most generations of one evolution.
pub const MAX_GENERATIONS: usize = 1 << 20;

/// How children come to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Variation {
    /// A child is crossed, or mutated, or a copy of its parent: the two probabilities are at most 1 together (genetic programming).
    Either {
        /// Probability of a crossover.
        crossover: f64,
        /// Probability of a mutation.
        mutation: f64,
    },
    /// A child is crossed with one probability and mutated with another, whether it was crossed or not (genetic algorithms).
    Both {
        /// Probability of a crossover.
        crossover: f64,
        /// Probability of a mutation.
        mutation: f64,
    },
}

/// Exchange between islands, which stand in a ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Migration {
    /// Generations between two exchanges; 0 for none.
    pub every: usize,
    /// How many of the fittest of an island replace the least fit of the next; they stay where they were, too.
    pub count: usize,
}

impl Default for Migration {
    fn default() -> Self {
        Self { every: 5, count: 1 }
    }
}

/// The numbers of an evolution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Individuals an island, at least 2.
    pub population: usize,
    /// Islands, at least 1.
    pub islands: usize,
    /// How many generations are bred from the first.
    pub generations: usize,
    /// The fittest of an island that live on as they are; fewer than the population.
    pub elite: usize,
    /// How parents are found.
    pub selection: Selection,
    /// What is done with them.
    pub variation: Variation,
    /// Exchange between islands.
    pub migration: Migration,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            population: 64,
            islands: 1,
            generations: 40,
            elite: 2,
            selection: Selection::Tournament { size: 3 },
            variation: Variation::Either { crossover: 0.8, mutation: 0.2 },
            migration: Migration::default(),
        }
    }
}

/// A setting that is not what it must be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("at {at}: {message}")]
pub struct SettingsError {
    /// A JSON pointer into the settings or the state.
    pub at: String,
    /// What would be right.
    pub message: String,
}

impl SettingsError {
    pub(crate) fn new(at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { at: at.into(), message: message.into() }
    }
}

impl Settings {
    /// Holds the numbers to their ranges.
    ///
    /// # Errors
    /// If one lies outside; the error names it.
    pub fn check(&self) -> Result<(), SettingsError> {
        let error = |at: &str, message: String| Err(SettingsError::new(at, message));
        let Self { population, islands, generations, elite, selection, variation, migration } = *self;
        if population < 2 {
            return error("/population", format!("must be at least 2 individuals, got {population}"));
        }
        if islands < 1 || islands.saturating_mul(population) > MAX_INDIVIDUALS {
            return error("/islands", format!("must be at least 1, and all individuals at most {MAX_INDIVIDUALS}: got {islands} islands of {population}"));
        }
        if generations > MAX_GENERATIONS {
            return error("/generations", format!("must be at most {MAX_GENERATIONS}, got {generations}"));
        }
        if elite >= population {
            return error("/elite", format!("must be less than the {population} individuals of an island, got {elite}"));
        }
        if migration.count > population / 2 {
            return error("/migration/count", format!("must be at most half the {population} individuals of an island, got {}", migration.count));
        }
        if let Selection::Tournament { size } = selection
            && !(1..=population).contains(&size)
        {
            return error("/selection/tournament/size", format!("must be 1 … {population}, got {size}"));
        }
        variation.check()
    }
}

impl Variation {
    fn check(self) -> Result<(), SettingsError> {
        let (name, [crossover, mutation], sum) = match self {
            Variation::Either { crossover, mutation } => ("either", [crossover, mutation], crossover + mutation),
            Variation::Both { crossover, mutation } => ("both", [crossover, mutation], 1.0),
        };
        for (field, probability) in [("crossover", crossover), ("mutation", mutation)] {
            if !(0.0..=1.0).contains(&probability) {
                return Err(SettingsError::new(format!("/variation/{name}/{field}"), format!("must be a probability, 0 … 1, got {probability}")));
            }
        }
        // 0.9 + 0.1 and the like may be rounded upwards.
        if sum > 1.0 + 1e-9 {
            return Err(SettingsError::new("/variation/either", format!("crossover and mutation must be at most 1 together, got {sum}")));
        }
        Ok(())
    }
}
