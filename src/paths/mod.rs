//! Terrain by path costs: ridges where somebody draws them, flanks shaped by profiles, roughness from random weights of edges (Rusnell, "Distance-based synthesis of terrain", 2009).
//!
//! A [`Drawing`] is read from JSON and made a [`Plan`]: a [lattice](Weights), strokes of [generators](Generator) that paths start from, and [profiles](Profile) that say what a step
//! costs. One [`Search`] a stroke gives its heights, and the [blend](Blending) of all of them the terrain, which a [`Raster`](crate::geometry::Raster) puts in the plane.
//!
//! ```
//! use terrane::{geometry::Stop, paths::{Drawing, Plan}};
//! let drawing = Drawing::parse(br#"{
//!     "size": [96, 64], "spacing": 10, "edges": {"random": {"mean": 0.5, "deviation": 0.3}}, "sea_level": {"cost": 100},
//!     "profiles": {"flank": {"points": [[0, 1], [0.3, 0.5], [1, 0]], "width": 300}},
//!     "strokes": [{"shape": {"geometry": {"type": "LineString", "coordinates": [[200, 300], [700, 350]]}}, "profiles": ["flank"], "cost": 20}]
//! }"#)?;
//! let heights = Plan::new(&drawing)?.heights(&Stop::never(), &|_| {});
//! assert_eq!(heights.metres.len(), 96 * 64);
//! assert!(heights.metres.iter().all(|height| (0.0..=80.0).contains(height)));
//! # Ok::<(), terrane::paths::DrawingError>(())
//! ```

mod blend;
mod canvas;
mod check;
mod document;
mod endless;
mod lattice;
mod picture;
mod plan;
mod preset;
mod profile;
mod profiles;
mod queue;
#[cfg(test)]
mod reference;
mod regions;
mod ridges;
mod search;
mod shadow;
mod stroke;
mod stroke_search;
#[cfg(test)]
mod tests;

pub use blend::{Bias, Blender, Blending, Settled, Stroke, approximate};
pub use document::{
    Bands, Drawing, DrawingError, Edges, Geometry, Group, Inside, Mask, Picture, PictureFile, Quantity, Ramp, Ridges, Scatter, SeaLevel, Shape, Sketch,
    WrittenProfile,
};
pub use endless::{CellStrokes, Chains, Endless, EndlessDrawing, Rings};
pub use lattice::{Diagonal, Frame, Node, Random, STEPS, Weights};
pub use plan::{Heights, MAX_NODES, MAX_REACH, MAX_STROKES, Plan};
pub use preset::{PRESET_DRAWINGS, PRESET_SHADOWS, PresetDrawing};
pub use profile::{Crest, Profile, ProfileError, Scaling, Stepping};
pub use search::{Generator, Label, Search, Terrain, limits};
pub use shadow::{Light, MAX_SHADOW_NODES, PathsDocument, Secondary, ShadowBase, ShadowDrawing, ShadowPlan, ShadowTerrain, cast};
