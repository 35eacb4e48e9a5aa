//! Terrane streams endless, deterministic, generated terrain.
//!
//! A [`world::World`] is compiled from a document and evaluated over windows of the plane; [`tile::render`] draws any tile of it; `server` (feature `server`,
//! on by default) does that over HTTP.
//!
//! ```
//! use terrane::{
//!     geometry::{Filter, Grid, Samples, Tile},
//!     tile::{Height, Options, TileRequest, Tileset, render},
//!     world::{Document, World},
//! };
//! let document = Document::parse(br#"{"seed": 7, "base": {"programme": "ridged_multifractal(1, 2, 8, 1, 2)", "scale": 20000}}"#)?;
//! let request = TileRequest {
//!     grid: Grid::Metric,
//!     tile: Tile { z: 12, x: 3, y: -5 },
//!     samples: Samples::Vertices(257),
//!     filter: Filter::Band,
//!     tileset: Tileset::R32,
//!     height: Height::Ground,
//!     options: Options::default(),
//! };
//! let heights = render(&World::new(document), &request)?;
//! assert_eq!(heights.len(), 257 * 257 * 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Modules may use only those listed before them: [`geometry`], [`noise`], [`genetic`], [`analysis`], [`programme`], [`layout`], [`paths`], [`synthesis`], [`evolve`], [`world`], [`tile`], [`query`], `store`, `jobs`, `server`.

pub mod analysis;
pub mod evolve;
pub mod genetic;
pub mod geometry;
#[cfg(feature = "server")]
pub mod jobs;
pub mod layout;
pub mod noise;
pub mod paths;
pub mod programme;
pub mod query;
#[cfg(feature = "server")]
pub mod server;
#[cfg(feature = "server")]
pub mod store;
pub mod synthesis;
pub mod tile;
pub mod world;
