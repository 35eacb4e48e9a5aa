//! Wavefront OBJ: vertices, normals and triangles as text.

use super::{Area, lattice::Lattice, writer::Encoder};
use crate::{geometry::Surface, tile::EncodeError};
use std::io::Write;

/// Writes vertices row by row, each row followed by the triangles that it closes.
pub(super) struct Obj {
    lattice: Lattice,
    covered: [f64; 4],
    /// The last rows of samples, with the apron: the present vertices' and their neighbours'.
    held: Surface,
    /// Rows of vertices that are written.
    written: usize,
}

impl Obj {
    pub(super) fn of(area: &Area) -> Self {
        let lattice = Lattice::of(area);
        Self { lattice, covered: area.covered(), held: Surface { columns: lattice.columns + 2, ..Surface::default() }, written: 0 }
    }

    /// The row of vertices in the middle of the three that are held.
    fn row(&mut self, out: &mut Vec<u8>) -> std::io::Result<()> {
        let lattice = &self.lattice;
        let z = lattice.z(self.written);
        for column in 0..lattice.columns {
            let (x, y, [east, up, south]) = (lattice.x(column), self.held.at(1, column + 1), lattice.normal(&self.held, 1, column + 1));
            writeln!(out, "v {x} {y} {z}\nvn {east:.4} {up:.4} {south:.4}")?;
        }
        if self.written > 0 {
            for triangle in lattice.triangles(self.written - 1) {
                let [a, b, c] = triangle.map(|vertex| vertex + 1);
                writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
            }
        }
        self.written += 1;
        Ok(())
    }
}

impl Encoder for Obj {
    fn head(&mut self) -> Vec<u8> {
        let ([x, y], [west, south, east, north]) = (self.lattice.origin, self.covered);
        format!("# Terrain over {west},{south},{east},{north}: x to the east, y up, z to the south, metres from {x},{y},0\no terrain\n").into_bytes()
    }

    fn rows(&mut self, heights: &[f32], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        for row in heights.chunks_exact(self.held.columns) {
            self.held.elevation.extend_from_slice(row);
            self.held.rows += 1;
            if self.held.rows == 3 {
                self.row(out).map_err(EncodeError::Text)?;
                self.held.elevation.drain(..self.held.columns);
                self.held.rows = 2;
            }
        }
        Ok(())
    }
}
