//! Gradient noise: the two noises of K. Perlin, "An image synthesizer" (1985) and "Improving noise" (2002), on the plane (third coordinate 0).
//!
//! A corner's gradient (gx, gy) contributes gx·dx + gy·dy. Along a row of samples, dy and the row's fade v are the same everywhere, so the two corners on the
//! left of a cell blend into a line A + B·fx and the two on the right into A' + B'·(fx - 1) = (A' - B') + B'·fx. A sample then mixes its two lines by the
//! column's fade. Gradients are multiplied by the octave's factor beforehand. These lines are the definition: the form for a single point computes just the same.

use super::{
    cells::{Fade, Lattice},
    hash,
};

/// Which gradients the corners choose from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gradients {
    /// 16 unit vectors at odd multiples of 11.25°.
    Unit,
    /// The 12 edge directions of a cube seen from above: the diagonals once, the axes twice. Twice their length, which leaves one byte of them that is not zero.
    Edges,
}

/// Cosine and sine of 11.25° and 33.75°.
const UNIT: [f32; 4] = [0.980_785_25, 0.195_090_32, 0.831_469_6, 0.555_570_24];

pub(super) const UNIT_GRADIENTS: [[f32; 2]; 16] = {
    let [c1, s1, c3, s3] = UNIT;
    [
        [c1, s1],
        [c3, s3],
        [s3, c3],
        [s1, c1],
        [-s1, c1],
        [-s3, c3],
        [-c3, s3],
        [-c1, s1],
        [-c1, -s1],
        [-c3, -s3],
        [-s3, -c3],
        [-s1, -c1],
        [s1, -c1],
        [s3, -c3],
        [c3, -s3],
        [c1, -s1],
    ]
};

pub(super) const EDGE_GRADIENTS: [[f32; 2]; 12] =
    [[2.0, 2.0], [-2.0, 2.0], [2.0, -2.0], [-2.0, -2.0], [2.0, 0.0], [-2.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 2.0], [0.0, -2.0], [0.0, 2.0], [0.0, -2.0]];

impl Gradients {
    /// The gradient of a corner, times `scale`.
    #[inline(always)]
    fn of(self, hash: u32, scale: f32) -> [f32; 2] {
        let gradient = match self {
            Gradients::Unit => UNIT_GRADIENTS[(hash >> 28) as usize],
            Gradients::Edges => EDGE_GRADIENTS[(((hash >> 16) * 12) >> 16) as usize],
        };
        gradient.map(|component| component * scale)
    }

    /// What brings the greatest value to 1: four gradients pointing at a cell's centre give 1/√2 and 2.
    #[inline(always)]
    pub(super) fn scale(self) -> f32 {
        match self {
            Gradients::Unit => core::f32::consts::SQRT_2,
            Gradients::Edges => 0.5,
        }
    }

    #[inline(always)]
    pub(super) fn fade(self) -> Fade {
        match self {
            Gradients::Unit => Fade::Cubic,
            Gradients::Edges => Fade::Quintic,
        }
    }
}

/// A sample row's place in its lattice row.
#[derive(Clone, Copy)]
struct Across {
    fraction: f32,
    fade: f32,
}

impl Across {
    /// A and B of one lattice column, from its gradients below (south) and above (north) the sample row.
    #[inline(always)]
    fn line(self, south: [f32; 2], north: [f32; 2]) -> [f32; 2] {
        let below = south[1] * self.fraction;
        let above = north[1] * (self.fraction - 1.0);
        [below + self.fade * (above - below), south[0] + self.fade * (north[0] - south[0])]
    }
}

/// The value between the line of the lattice column on the left and that on the right.
#[inline(always)]
fn between(left: [f32; 2], right: [f32; 2], fraction: f32, fade: f32) -> f32 {
    let l = left[0] + left[1] * fraction;
    let r = (right[0] - right[1]) + right[1] * fraction;
    l + fade * (r - l)
}

/// The noise at a point, times `amplitude`.
pub(super) fn at(gradients: Gradients, lattice: &Lattice, amplitude: f32, u: f64, v: f64) -> f32 {
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    let (fade, scale) = (gradients.fade(), gradients.scale() * amplitude);
    let (fx, fy) = (column.fraction as f32, row.fraction as f32);
    let across = Across { fraction: fy, fade: fade.weight(fy) };
    let gradient = |i: i64, j: i64| gradients.of(hash::corner(hash::column_key(i), hash::row_key(j, lattice.seed)), scale);
    let line = |i: i64| across.line(gradient(i, row.cell), gradient(i, row.cell + 1));
    between(line(column.cell), line(column.cell + 1), fx, fade.weight(fx))
}

/// The noise of Blender at a point, times `amplitude`: each corner of the cell adds its gradient's value times the radial kernel 1 - 3 r² + 2 r³ of its
/// distance r < 1, computed as (1 - r)² (1 + 2 r).
pub(super) fn blender_at(lattice: &Lattice, amplitude: f32, u: f64, v: f64) -> f32 {
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    let (fx, fy) = (column.fraction as f32, row.fraction as f32);
    let mut sum = 0.0;
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let hash = hash::corner(hash::column_key(column.cell + i), hash::row_key(row.cell + j, lattice.seed));
        let [gx, gy] = Gradients::Unit.of(hash, BLENDER_SCALE * amplitude);
        let (dx, dy) = (fx - i as f32, fy - j as f32);
        let square = dx * dx + dy * dy;
        let (radius, rest) = (square.sqrt(), 1.0 - square.sqrt());
        let kernel = if square < 1.0 { rest * rest * (1.0 + (radius + radius)) } else { 0.0 };
        sum += kernel * (gx * dx + gy * dy);
    }
    sum
}

/// What brings the greatest value of Blender's noise to 1: without it, that is 0.576 227, where the four best of the 16 gradients meet at (0.470, 0.5).
pub(super) const BLENDER_SCALE: f32 = 1.735_427;
