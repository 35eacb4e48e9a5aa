//! The noises of [`super::gradient`] in vectors, step by step as there, and with their slopes.

use super::{
    Lanes,
    cells::{Axis, Fade},
    gradient::{BLENDER_SCALE, EDGE_GRADIENTS, Gradients, UNIT_GRADIENTS},
    hash,
    number::Dual,
};

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

/// The lines of lattice columns, as [`super::gradient`] has them.
#[inline(always)]
pub(super) fn line<L: Lanes>(lanes: L, scale: L::Floats, y: &Axis<L>, south: [L::Floats; 2], north: [L::Floats; 2]) -> [L::Floats; 2] {
    let below = south[1] * y.fraction;
    let above = north[1] * (y.fraction - lanes.splat(1.0));
    let a = scale * (below + y.fade * (above - below));
    let b = scale * (south[0] + y.fade * (north[0] - south[0]));
    [a, b]
}

/// The values between lines; of the right line, A' - B' and B' are given.
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

/// As [`super::gradient::blender_at`]; the kernel's slope is 6 (r - 1) times the offset.
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
