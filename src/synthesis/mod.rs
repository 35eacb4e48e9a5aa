//! Terrain by example (Saunders, "Terrainosaurus: realistic terrain synthesis using genetic algorithms", 2006): samples of elevations, what they are like, and how much terrain looks like them.
//!
//! [`read`] makes a [`Sample`] of a file's bytes, [`Voids`] choose its part without voids, and an [`Analysis`] finds its distributions at a [`Level`]. A [`Model`] of several types of terrain says how
//! [similar](Similarity) other terrain is to each, how far that can be trusted, and why. A [`Library`] is the document that names types and samples; a [`Map`] says
//! which type lies where, and [`refine`] bends the edges that its regions share.
//!
//! ```
//! use terrane::synthesis::{Hints, read};
//! let grid = b"ncols 8\nnrows 8\ncellsize 30\n1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8
//!     1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8 1 2 3 4 5 6 7 8";
//! let sample = read("ramp.asc", grid, &Hints::default())?;
//! assert_eq!((sample.grid.columns, sample.grid.spacing), (8, [30.0, 30.0]));
//! let error = read("ramp.asc", &grid[..grid.len() - 2], &Hints::default()).expect_err("a number is missing");
//! assert_eq!(error.to_string(), "ramp.asc: line 5: 8 × 8 numbers are 64, the file ends after 63");
//! # Ok::<(), terrane::synthesis::SampleError>(())
//! ```

mod analysis;
mod edges;
mod field;
mod gaussian;
mod grid;
mod level;
mod library;
mod map;
mod read;
mod sample;
mod similarity;
mod statistics;
#[cfg(test)]
mod tests;
mod voids;
mod water;
mod windows;

pub use analysis::{Analysis, Measure, Profile};
pub use edges::{Edge, EdgePoint, Linking, link};
pub use field::{
    FieldCheckpoint, FieldGeneration, FieldLevel, FieldOptions, FieldProgress, FieldStep, Frame, Gene, MAX_FIELD_CELLS, RegionRaster, Synthesis, Turn,
};
pub use grid::{Crop, ELEVATIONS, MAX_CELLS, MIN_SIDE, SPACINGS, SampleGrid};
pub use level::{GENE_SIDE, LEAST_GENE_SIDE, Level, gene_side};
pub use library::{Library, LibraryError, LibraryProblem, LibrarySample, ReadyLibrary, ReadySample, Seam, TerrainType};
pub use map::{Map, MapEdge, MapProblem, MapRegion, Refined, Refinement, Topology, refine};
pub use read::read;
pub use sample::{Format, Hints, Number, Place, Sample, SampleError, Unit};
pub use similarity::{AGREED, Addition, DIFFERED, Model, Part, Projection, Samples, Similarity, Statistic, StatisticPart, TypeModel, addition, region_profile};
pub use statistics::{Histogram, Statistics};
pub use voids::{Voids, largest_rectangle, trimmed};
pub use water::{MIN_WATER_CELLS, Water, find_water};
pub use windows::Windows;
