//! Generators of feature layouts (Benjaminsen 2021, section 2.6.1, and his layouts "ridges and rivers" and "ridges, rivers and lakes", section 6.1).
//!
//! [`Landmass`] makes land, [`Rivers`] grows rivers inland from its shore, [`Lakes`] widens some of them, [`Ridges`] stand between all these waters, and
//! [`resolve`] cuts what is in conflict. Each takes features, which may be drawn by hand, and a [`Style`] with attributes, and gives features. [`Island`] is all of
//! them in a row. Everything follows from the seed: random numbers are hashes, arithmetic is IEEE's alone, and nothing depends on threads or the machine.
//!
//! [`Roads`] join places over terrain that is finished.
//!
//! Why the water finds its way: rivers keep a regular distance, ridges lie on the Voronoi diagram of the waters, halfway between them, and rise above the highest
//! of the waters near them by their distance. So on every line from a ridge to its river all that is merged falls.
//!
//! The Voronoi diagram comes from the crate `delaunator` 1.1 (ISC): the port of the reference implementation by its author, 700 lines without hash maps or threads,
//! on exact orientation tests (`robust`).
//!
//! ```
//! use terrane::layout::{Layout, Options, generate::{Island, Styles}};
//! let island = Island::ridges_rivers_and_lakes();
//! let styles = Styles::for_spacing(island.rivers.spacing, 7)?;
//! let layout = Layout::new(island.features(7, &styles)?, Options { sea_level: Some(0.0), ..Options::default() })?;
//! assert!(layout.features().len() > 500);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod conflict;
mod error;
mod island;
mod lakes;
mod landmass;
mod network;
mod plane;
mod random;
mod read;
mod ridges;
mod rivers;
mod roads;
mod style;
mod untangle;
mod voronoi;
mod water;

pub use conflict::{Conflict, resolve};
pub use error::GenerateError;
pub use island::{Ground, Island};
pub use lakes::Lakes;
pub use landmass::Landmass;
pub use ridges::Ridges;
pub use rivers::Rivers;
pub use roads::{Place, Road, Roads};
pub use style::{Style, Styles};

pub(super) use error::check;
pub(super) use random::Stream;

#[cfg(test)]
mod tests;
