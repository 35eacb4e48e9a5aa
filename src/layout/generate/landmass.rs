//! The outline of a land.

use super::{
    error::{GenerateError, check},
    plane::{Near, Point, along, crossing, minus},
    random::Stream,
    style::Style,
};
use crate::layout::Feature;
use serde::{Deserialize, Serialize};

/// A land round a centre: a polygon of few corners, each moved along its radius, then refined by midpoint displacement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Landmass {
    /// The centre in metres, within 2^40 of the origin.
    pub centre: [f64; 2],
    /// The mean distance of the corners from the centre, 1 … 10,000,000 m.
    pub radius: f64,
    /// Corners of the low polygon, 3 … 1024.
    pub corners: usize,
    /// How far a corner moves along its radius, as a share 0 … 0.9 of the radius.
    pub variation: f64,
    /// How often every edge is halved, 0 … 10.
    pub iterations: u32,
    /// How far a midpoint moves, as a share 0 … 0.35 of its edge. It is halved until the outline does not cross itself.
    pub displacement: f64,
    /// The shore's elevation in metres, -10,000 … 32,767: the level of the sea.
    pub elevation: f64,
}

impl Default for Landmass {
    fn default() -> Self {
        Landmass { centre: [0.0, 0.0], radius: 14_000.0, corners: 14, variation: 0.2, iterations: 3, displacement: 0.2, elevation: 0.0 }
    }
}

/// Vertices of an outline at most.
const MOST_VERTICES: usize = 65_536;

impl Landmass {
    fn check(&self) -> Result<(), GenerateError> {
        let plane = -crate::geometry::PLANE_LIMIT..=crate::geometry::PLANE_LIMIT;
        check("landmass.centre[0]", self.centre[0], plane.clone())?;
        check("landmass.centre[1]", self.centre[1], plane)?;
        check("landmass.radius", self.radius, 1.0..=1e7)?;
        check("landmass.corners", self.corners as f64, 3.0..=1024.0)?;
        check("landmass.variation", self.variation, 0.0..=0.9)?;
        check("landmass.iterations", f64::from(self.iterations), 0.0..=10.0)?;
        check("landmass.displacement", self.displacement, 0.0..=0.35)?;
        check("landmass.elevation", self.elevation, -10_000.0..=32_767.0)?;
        let vertices = self.corners << self.iterations;
        if vertices > MOST_VERTICES {
            return Err(GenerateError::TooMany { place: "landmass.iterations", expected: vertices as f64, limit: MOST_VERTICES });
        }
        Ok(())
    }

    /// The land as one feature; its vertices are the outline's, which fractal detail of the style leaves where they are.
    ///
    /// # Errors
    /// A parameter outside its range, or attributes that do not fit a polygon with elevations.
    pub fn features(&self, seed: u64, style: &Style) -> Result<Vec<Feature>, GenerateError> {
        let ring: Vec<[f64; 3]> = self.outline(seed)?.iter().map(|p| [p[0], p[1], self.elevation]).collect();
        Ok(vec![style.feature(&ring, true, &style.attributes, style.detail)?])
    }

    /// The corners of the low polygon, counter-clockwise, and what its refinement is hashed with.
    fn corners(&self, seed: u64) -> (Vec<Point>, u64) {
        let mut stream = Stream::new(seed, "landmass");
        let corners = (0..self.corners).map(|corner| {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * corner as f64 / self.corners as f64);
            along(self.centre, self.radius * (1.0 + self.variation * stream.between(-1.0, 1.0)), [cosine, sine])
        });
        (corners.collect(), stream.bits())
    }

    /// The outline with its edges halved once at most: what is seen of it from afar.
    pub(in crate::layout) fn coarse(&self, seed: u64) -> Vec<[f64; 2]> {
        let (corners, seed) = self.corners(seed);
        if self.iterations > 0 { halve(&corners, self.displacement, seed, 0) } else { corners }
    }

    /// The outline, counter-clockwise, without repeating its first vertex; it never crosses itself.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn outline(&self, seed: u64) -> Result<Vec<[f64; 2]>, GenerateError> {
        self.check()?;
        let (corners, seed) = self.corners(seed);
        let mut displacement = self.displacement;
        loop {
            let ring = (0..self.iterations).fold(corners.clone(), |ring, level| halve(&ring, displacement, seed, level));
            // Without displacement the polygon is star-shaped round its centre, so this ends.
            if displacement < 1e-3 || is_simple(&ring) {
                return Ok(if displacement < 1e-3 { corners } else { ring });
            }
            displacement /= 2.0;
        }
    }
}

/// Every edge halved, its midpoint moved along the normal.
fn halve(ring: &[Point], displacement: f64, seed: u64, level: u32) -> Vec<Point> {
    let mut stream = Stream::new(crate::noise::key(seed, u64::from(level)), "halve");
    let mut finer = Vec::with_capacity(2 * ring.len());
    for (i, &a) in ring.iter().enumerate() {
        let edge = minus(ring[(i + 1) % ring.len()], a);
        finer.extend([a, along(along(a, 0.5, edge), displacement * stream.between(-1.0, 1.0), [-edge[1], edge[0]])]);
    }
    finer
}

/// Whether no two edges of a ring meet but where they follow each other.
pub(super) fn is_simple(ring: &[Point]) -> bool {
    let n = ring.len();
    let longest = (0..n).map(|i| super::plane::distance(ring[i], ring[(i + 1) % n])).fold(0.0, f64::max);
    let near = Near::of((0..n).map(|i| [ring[i], ring[(i + 1) % n]]), longest);
    (0..n).all(|i| {
        let edge = near.segments()[i];
        near.around(edge, 0.0).into_iter().all(|j| j <= i || j == i + 1 || (i == 0 && j == n - 1) || crossing(edge, near.segments()[j]).is_none())
    })
}
