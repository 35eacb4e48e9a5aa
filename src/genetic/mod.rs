//! Genetic algorithms, whatever is bred.
//!
//! A [`Problem`] says how genomes are made, crossed, mutated and evaluated; an [`Evolution`] breeds generations of them on [islands](Settings::islands), each step on
//! all threads. Evaluations are kept with their genomes and handed to their children's, so that a changed gene need not cost more than its own part. A [`State`] is
//! all that an evolution goes on from.
//!
//! ```
//! use terrane::{genetic::{Draws, Evolution, Problem, Settings}, geometry::Stop};
//! /// Ten numbers that should be small: the sum of their squares, of which a child's is its parent's but for the genes that changed.
//! struct Sphere;
//! impl Problem for Sphere {
//!     type Genome = Vec<f64>;
//!     type Evaluation = Vec<f64>;
//!     type Change = Vec<usize>;
//!     fn initialise(&self, _: usize, draws: &mut Draws) -> Vec<f64> {
//!         (0..10).map(|_| draws.between(-1.0, 1.0)).collect()
//!     }
//!     fn cross(&self, child: &mut Vec<f64>, mate: &Vec<f64>, change: &mut Vec<usize>, draws: &mut Draws) {
//!         let from = draws.below(10);
//!         child[from..].copy_from_slice(&mate[from..]);
//!         change.extend(from..10);
//!     }
//!     fn mutate(&self, child: &mut Vec<f64>, _: &Vec<f64>, change: &mut Vec<usize>, draws: &mut Draws) {
//!         let gene = draws.below(10);
//!         child[gene] += 0.1 * draws.normal();
//!         change.push(gene);
//!     }
//!     fn evaluate(&self, genome: &Vec<f64>, from: Option<(&Vec<f64>, &Vec<usize>)>, _: &Stop) -> Vec<f64> {
//!         let Some((parent, change)) = from else { return genome.iter().map(|gene| gene * gene).collect() };
//!         let mut squares = parent.clone();
//!         for &gene in change {
//!             squares[gene] = genome[gene] * genome[gene];
//!         }
//!         squares
//!     }
//!     fn fitness(&self, squares: &Vec<f64>) -> f64 {
//!         -squares.iter().sum::<f64>()
//!     }
//! }
//! let mut evolution = Evolution::new(&Sphere, Settings { generations: 60, ..Settings::default() }, 7, &Stop::never())?.expect("nobody stops it");
//! evolution.run(&Stop::never(), &mut |_| true);
//! assert!(evolution.state().progress().best > -0.05);
//! # Ok::<(), terrane::genetic::SettingsError>(())
//! ```

mod criterion;
mod draws;
mod evolution;
mod select;
mod settings;
#[cfg(test)]
mod tests;

pub use criterion::{Criterion, Term, Weighted};
pub use draws::{Draws, Purpose};
pub use evolution::{Evolution, Individual, Island, Problem, Progress, Shared, State};
pub use select::{Selection, ranking};
pub use settings::{MAX_GENERATIONS, MAX_INDIVIDUALS, Migration, Settings, SettingsError, Variation};
