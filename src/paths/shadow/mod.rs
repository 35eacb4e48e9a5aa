//! Shadows that show a picture (Rusnell 2009, Chapter 5).
//!
//! Crests stand before every shadow that a [`ShadowDrawing`] wants, just so high that under one light it ends where it should; holes in shadows are raised into the light, level by level
//! of what lies inside what; all else keeps below what the light allows. One search makes flanks of them.

mod bounds;
mod cast;
mod climb;
mod document;
mod light;
mod plan;
mod regions;
mod secondary;
mod terrain;
#[cfg(test)]
mod tests;

pub use cast::cast;
pub use document::{MAX_SHADOW_NODES, PathsDocument, Secondary, ShadowBase, ShadowDrawing};
pub use light::Light;
pub use plan::ShadowPlan;
pub use terrain::ShadowTerrain;
