//! How a field is bred.

use crate::{
    genetic::{Migration, Selection, Settings, SettingsError, Variation},
    synthesis::{GENE_SIDE, LEAST_GENE_SIDE, Level},
};
use serde::{Deserialize, Serialize};

/// How a field is bred.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FieldOptions {
    /// Hashed into all that chance decides.
    pub seed: u64,
    /// Grounds of a generation, 2 … 64.
    pub population: usize,
    /// Generations of every level but the coarsest, 0 … 10,000.
    pub generations: usize,
    /// How probably a ground takes over a rectangle of genes of another one, 0 … 1.
    pub crossover: f64,
    /// The most genes of that rectangle a side, as a share of all, 0 … 1.
    pub crossover_width: f64,
    /// How probably a gene changes that fits badly in a region that is not similar (`P_m`), 0 … 1.
    pub mutation: f64,
    /// Places of samples that are looked at for a gene, 1 … 10,000.
    pub looks: usize,
    /// Cells of a gene a side, 8 … 16; where samples are small, fewer.
    pub gene: usize,
    /// The greatest vertical scale, 1 … 10; the least is one over it.
    pub max_scale: f64,
    /// The greatest difference of a gene's mean from the one that fits, as a share of the type's range, 0 … 1.
    pub max_offset: f64,
    /// The finest level that is made; the finest that all types have without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finest: Option<Level>,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            population: 6,
            generations: 24,
            crossover: 0.5,
            crossover_width: 0.5,
            mutation: 0.1,
            looks: 96,
            gene: GENE_SIDE,
            max_scale: 1.5,
            max_offset: 0.02,
            finest: None,
        }
    }
}

impl FieldOptions {
    /// Holds the numbers to their ranges.
    ///
    /// # Errors
    /// If one lies outside, with its pointer.
    pub fn check(&self) -> Result<(), SettingsError> {
        let number = |at: &str, value: usize, least: usize, most: usize| {
            if (least..=most).contains(&value) { Ok(()) } else { Err(SettingsError::new(at, format!("must be {least} … {most}, is {value}"))) }
        };
        let share = |at: &str, value: f64, least: f64, most: f64| {
            if (least..=most).contains(&value) { Ok(()) } else { Err(SettingsError::new(at, format!("must be {least} … {most}, is {value}"))) }
        };
        number("/population", self.population, 2, 64)?;
        number("/generations", self.generations, 0, 10_000)?;
        share("/crossover", self.crossover, 0.0, 1.0)?;
        share("/crossover_width", self.crossover_width, 0.0, 1.0)?;
        share("/mutation", self.mutation, 0.0, 1.0)?;
        number("/looks", self.looks, 1, 10_000)?;
        number("/gene", self.gene, LEAST_GENE_SIDE, GENE_SIDE)?;
        share("/max_scale", self.max_scale, 1.0, 10.0)?;
        share("/max_offset", self.max_offset, 0.0, 1.0)
    }

    /// What the genetic algorithm is told.
    pub(super) fn settings(&self) -> Settings {
        Settings {
            population: self.population,
            islands: 1,
            generations: self.generations,
            elite: 1,
            selection: Selection::Tournament { size: 2 },
            variation: Variation::Both { crossover: self.crossover, mutation: 1.0 },
            migration: Migration { every: 0, count: 0 },
        }
    }
}
