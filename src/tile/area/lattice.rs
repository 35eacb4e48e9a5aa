//! The vertices and triangles of a mesh of samples, as model formats turn them: x to the east, y up, z to the south, a right-handed frame in metres.

use super::Area;
use crate::{analysis, geometry::Surface};

/// Where vertices stand and what joins them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub columns: usize,
    pub rows: usize,
    pub spacing: f64,
    /// The plane point that positions count from, so that single precision is enough: the middle of the area.
    pub origin: [f64; 2],
}

impl Lattice {
    pub(super) fn of(area: &Area) -> Self {
        let window = area.window();
        let bounds = window.bounds();
        let origin = [0, 1].map(|axis| f64::midpoint(bounds.min[axis], bounds.max[axis]));
        Self { columns: window.columns.len(), rows: window.rows.len(), spacing: window.spacing(), origin }
    }

    pub(super) fn x(&self, column: usize) -> f32 {
        ((column as f64 - (self.columns - 1) as f64 / 2.0) * self.spacing) as f32
    }

    pub(super) fn z(&self, row: usize) -> f32 {
        ((row as f64 - (self.rows - 1) as f64 / 2.0) * self.spacing) as f32
    }

    /// The unit normal at a sample that has all neighbours.
    pub(super) fn normal(&self, surface: &Surface, row: usize, column: usize) -> [f32; 3] {
        let [east, north] = analysis::gradient(surface, row, column, self.spacing);
        let length = (1.0 + east * east + north * north).sqrt();
        // Adding 0 makes -0 of level ground 0.
        [-east / length + 0.0, 1.0 / length, north / length + 0.0]
    }

    /// The triangles between a row and the next, which all turn anticlockwise seen from above; numbers of vertices row by row from 0.
    pub(super) fn triangles(&self, row: usize) -> impl Iterator<Item = [u32; 3]> + '_ {
        (0..self.columns - 1).flat_map(move |column| {
            let north_west = (row * self.columns + column) as u32;
            let south_west = north_west + self.columns as u32;
            [[north_west, south_west, north_west + 1], [north_west + 1, south_west, south_west + 1]]
        })
    }
}
