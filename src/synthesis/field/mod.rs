//! New ground by example: pieces of samples, blended by a genetic algorithm, follow a map level by level (Saunders 2006, IV.3.2).
//!
//! A [`Synthesis`] begins with chunks of samples at the coarsest level that the map's types have in common, and goes on by threes: at every finer level [`Gene`]s on a grid point to pieces of samples that fit what the
//! level before says. What their blend leaves of that is put back, so coarse features stay where they are.

mod base;
mod chunks;
mod drive;
mod fit;
mod gene;
mod ground;
mod operators;
mod options;
mod pattern;
mod raster;
mod relax;
mod report;
mod source;
mod tally;
#[cfg(test)]
mod tests;

pub use drive::Synthesis;
pub use gene::{Gene, Turn};
pub use options::FieldOptions;
pub use raster::{Frame, RegionRaster};
pub use report::{FieldCheckpoint, FieldGeneration, FieldLevel, FieldProgress, FieldStep, MAX_FIELD_CELLS};
