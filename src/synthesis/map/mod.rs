//! Maps of regions, each of one type of terrain, and the edges that they share.

mod bends;
mod envelope;
mod geojson;
mod refine;
#[cfg(test)]
mod tests;
mod topology;

use super::library::LibraryProblem;
pub use refine::{Refined, Refinement, refine};
use serde::{Deserialize, Serialize};

/// A part of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRegion {
    /// The type's name in the library.
    #[serde(rename = "type")]
    pub kind: String,
    /// Rings of `[x, y]` in metres, x east and y north: the first is the outline, others are holes. The last vertex may repeat the first.
    pub rings: Vec<Vec<[f64; 2]>>,
}

/// A map as it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// Regions that meet along edges and do not overlap.
    pub regions: Vec<MapRegion>,
    /// Vertices nearer than this are one, metres.
    #[serde(default = "usual_snap")]
    pub snap: f64,
}

fn usual_snap() -> f64 {
    1.0
}

/// Something wrong with a map: a pointer and what is wrong.
pub type MapProblem = LibraryProblem;

/// A straight edge of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapEdge {
    /// The lexicographically first end.
    pub start: [f64; 2],
    /// The other end.
    pub end: [f64; 2],
    /// Regions to the left and to the right on the way from the first end; none outside of the map.
    pub regions: [Option<usize>; 2],
}

/// A map whose regions are joined.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// Where regions meet, each edge once, in lexicographical order.
    pub edges: Vec<MapEdge>,
    /// The region that each region is one with: of those of one type that share an edge the first.
    pub merged: Vec<usize>,
}

impl Map {
    /// Joins vertices, splits edges at vertices that lie on them, and finds which regions meet where.
    ///
    /// # Errors
    /// If there are no regions, a ring has fewer than three places, edges cross or overlap, or a gap between regions is no wider than vertices are joined over; with the region's pointer and the place.
    pub fn topology(&self) -> Result<Topology, MapProblem> {
        topology::of(self)
    }
}
