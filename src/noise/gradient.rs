//! Gradient noise: the two noises of K. Perlin, "An image synthesizer" (1985) and "Improving noise" (2002), on the plane (third coordinate 0).
//!
//! A corner's gradient (gx, gy) contributes gx·dx + gy·dy. Along a row of samples, dy and the row's fade v are the same everywhere, so the two corners on the
//! left of a cell blend into a line A + B·fx and the two on the right into A' + B'·(fx - 1) = (A' - B') + B'·fx. A sample then mixes its two lines by the
//! column's fade. These lines are the definition: the form for a single point computes just the same.

use super::{
    Lanes,
    cells::{Axis, Fade, Lattice},
    hash,
    number::Dual,
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

const UNIT_GRADIENTS: [[f32; 2]; 16] = {
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

const EDGE_GRADIENTS: [[f32; 2]; 12] =
    [[2.0, 2.0], [-2.0, 2.0], [2.0, -2.0], [-2.0, -2.0], [2.0, 0.0], [-2.0, 0.0], [2.0, 0.0], [-2.0, 0.0], [0.0, 2.0], [0.0, -2.0], [0.0, 2.0], [0.0, -2.0]];

impl Gradients {
    #[inline(always)]
    fn of(self, hash: u32) -> [f32; 2] {
        match self {
            Gradients::Unit => UNIT_GRADIENTS[(hash >> 28) as usize],
            Gradients::Edges => EDGE_GRADIENTS[(((hash >> 16) * 12) >> 16) as usize],
        }
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
    scale: f32,
}

impl Across {
    /// A and B of one lattice column, from its gradients below (south) and above (north) the sample row.
    #[inline(always)]
    fn line(self, south: [f32; 2], north: [f32; 2]) -> [f32; 2] {
        let below = south[1] * self.fraction;
        let above = north[1] * (self.fraction - 1.0);
        let a = self.scale * (below + self.fade * (above - below));
        let b = self.scale * (south[0] + self.fade * (north[0] - south[0]));
        [a, b]
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
    let fade = gradients.fade();
    let across = Across { fraction: row.fraction as f32, fade: fade.weight(row.fraction) as f32, scale: gradients.scale() * amplitude };
    let gradient = |i: i64, j: i64| gradients.of(hash::corner(hash::column_key(i), hash::row_key(j, lattice.seed)));
    let line = |i: i64| across.line(gradient(i, row.cell), gradient(i, row.cell + 1));
    between(line(column.cell), line(column.cell + 1), column.fraction as f32, fade.weight(column.fraction) as f32)
}

/// The noise of Blender at a point, times `amplitude`: each corner of the cell adds its gradient's value times the radial kernel 1 - 3 r² + 2 r³ of its
/// distance r < 1, computed as (1 - r)² (1 + 2 r).
pub(super) fn blender_at(lattice: &Lattice, amplitude: f32, u: f64, v: f64) -> f32 {
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    let (fx, fy) = (column.fraction as f32, row.fraction as f32);
    let mut sum = 0.0;
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let [gx, gy] = Gradients::Unit.of(hash::corner(hash::column_key(column.cell + i), hash::row_key(row.cell + j, lattice.seed)));
        let (dx, dy) = (fx - i as f32, fy - j as f32);
        let square = dx * dx + dy * dy;
        let (radius, rest) = (square.sqrt(), 1.0 - square.sqrt());
        let kernel = if square < 1.0 { rest * rest * (1.0 + (radius + radius)) } else { 0.0 };
        sum += kernel * (gx * dx + gy * dy);
    }
    sum * (BLENDER_SCALE * amplitude)
}

/// What brings the greatest value of Blender's noise to 1: without it, that is 0.576 227, where the four best of the 16 gradients meet at (0.470, 0.5).
pub(super) const BLENDER_SCALE: f32 = 1.735_427;

/// A gradient noise in vectors, compiled for its own gradients.
pub(super) trait Noise: Copy {
    const FADE: Fade;
    /// Whether the gradients of two corners blend into a line.
    const BLENDS: bool;

    /// What brings the greatest value to 1.
    fn scale() -> f32;
    /// The gradients of the corners whose keys are given.
    fn gradients<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> [L::Floats; 2];
    /// `scale` times the noise.
    fn value<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> L::Floats;
    /// The same with its slopes along both axes, a cell being the unit.
    fn dual<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L>;
}

/// Perlin 1985.
#[derive(Clone, Copy)]
pub(super) struct OPerlin;

/// Perlin 2002.
#[derive(Clone, Copy)]
pub(super) struct IPerlin;

/// Blender's.
#[derive(Clone, Copy)]
pub(super) struct Blender;

impl Noise for OPerlin {
    const FADE: Fade = Fade::Cubic;
    const BLENDS: bool = true;

    #[inline(always)]
    fn scale() -> f32 {
        Gradients::Unit.scale()
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
        unit_gradients(lanes, hash::top_of_corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        blended_value::<L, Self>(lanes, scale, x, y)
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        blended_dual::<L, Self>(lanes, scale, x, y)
    }
}

impl Noise for IPerlin {
    const FADE: Fade = Fade::Quintic;
    const BLENDS: bool = true;

    #[inline(always)]
    fn scale() -> f32 {
        Gradients::Edges.scale()
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
        // The top bytes of 0, 2 and -2.
        const TOP: [[u8; 16]; 2] = {
            let mut tables = [[0; 16]; 2];
            let mut i = 0;
            while i < EDGE_GRADIENTS.len() {
                tables[0][i] = (EDGE_GRADIENTS[i][0].to_bits() >> 24) as u8;
                tables[1][i] = (EDGE_GRADIENTS[i][1].to_bits() >> 24) as u8;
                i += 1;
            }
            tables
        };
        lanes.twelfths(&TOP, hash::corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        blended_value::<L, Self>(lanes, scale, x, y)
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        blended_dual::<L, Self>(lanes, scale, x, y)
    }
}

impl Noise for Blender {
    const FADE: Fade = Fade::None;
    const BLENDS: bool = false;

    #[inline(always)]
    fn scale() -> f32 {
        BLENDER_SCALE
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
        unit_gradients(lanes, hash::top_of_corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        radial_dual(lanes, scale, x, y).value
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        radial_dual(lanes, scale, x, y)
    }
}

/// The first eight unit gradients; the others are their negatives, which the top bit tells.
#[inline(always)]
fn unit_gradients<L: Lanes>(lanes: L, hash: L::Words) -> [L::Floats; 2] {
    const HALF: [[f32; 8]; 2] = {
        let mut tables = [[0.0; 8]; 2];
        let mut i = 0;
        while i < 8 {
            (tables[0][i], tables[1][i]) = (UNIT_GRADIENTS[i][0], UNIT_GRADIENTS[i][1]);
            i += 1;
        }
        tables
    };
    let (index, sign) = (lanes.shr::<28>(hash), hash & lanes.splat_words(0x8000_0000));
    let [gx, gy] = [lanes.lookup8(&HALF[0], index), lanes.lookup8(&HALF[1], index)];
    [lanes.to_floats(lanes.to_words(gx) ^ sign), lanes.to_floats(lanes.to_words(gy) ^ sign)]
}

/// The lines of lattice columns, as [`Across::line`].
#[inline(always)]
pub(super) fn line<L: Lanes>(lanes: L, scale: L::Floats, y: &Axis<L>, south: [L::Floats; 2], north: [L::Floats; 2]) -> [L::Floats; 2] {
    let below = south[1] * y.fraction;
    let above = north[1] * (y.fraction - lanes.splat(1.0));
    let a = scale * (below + y.fade * (above - below));
    let b = scale * (south[0] + y.fade * (north[0] - south[0]));
    [a, b]
}

/// The values between lines, as [`between`]; of the right line, A' - B' and B' are given.
#[inline(always)]
pub(super) fn mixed<F: Copy + core::ops::Add<Output = F> + core::ops::Sub<Output = F> + core::ops::Mul<Output = F>>(lines: [F; 4], fraction: F, fade: F) -> F {
    let l = lines[0] + lines[1] * fraction;
    let r = lines[2] + lines[3] * fraction;
    l + fade * (r - l)
}

/// The gradients south and north of the cells on one of their sides, and so the line there. Not a closure over the sides: those are not compiled for the set.
#[inline(always)]
fn side<L: Lanes, N: Noise>(lanes: L, x: &Axis<L>, y: &Axis<L>, side: usize) -> [[L::Floats; 2]; 2] {
    let south = N::gradients(lanes, x.keys[side], y.keys[0]);
    let north = N::gradients(lanes, x.keys[side], y.keys[1]);
    [south, north]
}

#[inline(always)]
fn blended_value<L: Lanes, N: Noise>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
    let [south_west, north_west] = side::<L, N>(lanes, x, y, 0);
    let [south_east, north_east] = side::<L, N>(lanes, x, y, 1);
    let [a, b] = line(lanes, scale, y, south_west, north_west);
    let [c, d] = line(lanes, scale, y, south_east, north_east);
    mixed([a, b, c - d, d], x.fraction, x.fade)
}

/// The value l + fade (r - l) has the slope B + fade' (r - l) + fade (B' - B) along a row; across it, the slopes of l and r mix as l and r do.
#[inline(always)]
fn blended_dual<L: Lanes, N: Noise>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
    let [south_west, north_west] = side::<L, N>(lanes, x, y, 0);
    let [south_east, north_east] = side::<L, N>(lanes, x, y, 1);
    let [a, b] = line(lanes, scale, y, south_west, north_west);
    let [c, d] = line(lanes, scale, y, south_east, north_east);
    let [turned_a, turned_b] = turned_line(lanes, scale, y, south_west, north_west);
    let [turned_c, turned_d] = turned_line(lanes, scale, y, south_east, north_east);
    let l = a + b * x.fraction;
    let r = (c - d) + d * x.fraction;
    Dual {
        value: l + x.fade * (r - l),
        slopes: [b + (x.turn * (r - l) + x.fade * (d - b)), mixed([turned_a, turned_b, turned_c - turned_d, turned_d], x.fraction, x.fade)],
    }
}

/// The slopes of A and B across the row.
#[inline(always)]
fn turned_line<L: Lanes>(lanes: L, scale: L::Floats, y: &Axis<L>, south: [L::Floats; 2], north: [L::Floats; 2]) -> [L::Floats; 2] {
    let below = south[1] * y.fraction;
    let above = north[1] * (y.fraction - lanes.splat(1.0));
    let a = scale * (south[1] + (y.turn * (above - below) + y.fade * (north[1] - south[1])));
    let b = scale * (y.turn * (north[0] - south[0]));
    [a, b]
}

/// As [`blender_at`]; the kernel's slope is 6 (r - 1) times the offset.
#[inline(always)]
fn radial_dual<L: Lanes>(lanes: L, scale: L::Floats, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
    let number = |value| lanes.splat(value);
    let (zero, one) = (number(0.0), number(1.0));
    let mut sum = [zero; 3];
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let [gx, gy] = Blender::gradients(lanes, x.keys[i], y.keys[j]);
        let (dx, dy) = (x.fraction - number(i as f32), y.fraction - number(j as f32));
        let square = dx * dx + dy * dy;
        let radius = lanes.sqrt(square);
        let rest = one - radius;
        let kernel = rest * rest * (one + (radius + radius));
        let kernel = lanes.where_less(square, one, kernel, zero);
        let turn = lanes.where_less(square, one, number(-6.0) * rest, zero);
        let value = gx * dx + gy * dy;
        sum[0] = sum[0] + kernel * value;
        sum[1] = sum[1] + (turn * dx * value + kernel * gx);
        sum[2] = sum[2] + (turn * dy * value + kernel * gy);
    }
    Dual { value: sum[0] * scale, slopes: [sum[1] * scale, sum[2] * scale] }
}
