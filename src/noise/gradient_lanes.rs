//! The noises of [`super::gradient`] in vectors, step by step as there, and with their slopes.

use super::{
    Lanes,
    cells::{Axis, Fade},
    gradient::{BLENDER_SCALE, EDGE_GRADIENTS, Gradients, UNIT_GRADIENTS},
    hash,
    number::Dual,
};

/// The gradients that an octave's corners choose from, times its factor.
pub(super) struct Palette([[f32; 16]; 2]);

/// Gradients at the corners of cells: south-west, south-east, north-west and north-east.
pub(super) type Corners<L> = [[<L as Lanes>::Floats; 2]; 4];

/// A gradient noise in vectors, compiled for its own gradients.
pub(super) trait Noise: Copy {
    const FADE: Fade;
    /// Whether the gradients of two corners blend into a line.
    const BLENDS: bool;

    /// The gradients of an octave whose factor is `amplitude`.
    fn palette(amplitude: f32) -> Palette;
    /// Those of the corners whose keys are given.
    fn gradients<L: Lanes>(lanes: L, palette: &Palette, columns: L::Words, rows: L::Words) -> [L::Floats; 2];
    /// The noise.
    fn value<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> L::Floats;
    /// The same with its slopes along both axes, a cell being the unit.
    fn dual<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L>;

    /// The gradients of cells whose corners' keys are given.
    #[inline(always)]
    fn corners<L: Lanes>(lanes: L, palette: &Palette, columns: [L::Words; 2], rows: [L::Words; 2]) -> Corners<L> {
        [
            Self::gradients(lanes, palette, columns[0], rows[0]),
            Self::gradients(lanes, palette, columns[1], rows[0]),
            Self::gradients(lanes, palette, columns[0], rows[1]),
            Self::gradients(lanes, palette, columns[1], rows[1]),
        ]
    }
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
    fn palette(amplitude: f32) -> Palette {
        Palette::new(&UNIT_GRADIENTS, Gradients::Unit.scale() * amplitude)
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, palette: &Palette, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
        lanes.sixteenths(&palette.0, hash::top_of_corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        blended_value(lanes, corners, x, y)
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        blended_dual(lanes, corners, x, y)
    }
}

impl Noise for IPerlin {
    const FADE: Fade = Fade::Quintic;
    const BLENDS: bool = true;

    #[inline(always)]
    fn palette(amplitude: f32) -> Palette {
        Palette::new(&EDGE_GRADIENTS, Gradients::Edges.scale() * amplitude)
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, palette: &Palette, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
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
        lanes.twelfths(&palette.0, &TOP, hash::corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        blended_value(lanes, corners, x, y)
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        blended_dual(lanes, corners, x, y)
    }
}

impl Noise for Blender {
    const FADE: Fade = Fade::None;
    const BLENDS: bool = false;

    #[inline(always)]
    fn palette(amplitude: f32) -> Palette {
        Palette::new(&UNIT_GRADIENTS, BLENDER_SCALE * amplitude)
    }

    #[inline(always)]
    fn gradients<L: Lanes>(lanes: L, palette: &Palette, columns: L::Words, rows: L::Words) -> [L::Floats; 2] {
        lanes.sixteenths(&palette.0, hash::top_of_corners(lanes, columns, rows))
    }

    #[inline(always)]
    fn value<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
        radial_dual(lanes, corners, x, y).value
    }

    #[inline(always)]
    fn dual<L: Lanes>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
        radial_dual(lanes, corners, x, y)
    }
}

impl Palette {
    #[inline(always)]
    fn new(gradients: &[[f32; 2]], scale: f32) -> Self {
        let mut components = [[0.0; 16]; 2];
        for (i, gradient) in gradients.iter().enumerate() {
            (components[0][i], components[1][i]) = (gradient[0] * scale, gradient[1] * scale);
        }
        Self(components)
    }
}

/// The lines of lattice columns, as [`super::gradient`] has them.
#[inline(always)]
pub(super) fn line<L: Lanes>(lanes: L, y: &Axis<L>, south: [L::Floats; 2], north: [L::Floats; 2]) -> [L::Floats; 2] {
    let below = south[1] * y.fraction;
    let above = north[1] * (y.fraction - lanes.splat(1.0));
    [below + y.fade * (above - below), south[0] + y.fade * (north[0] - south[0])]
}

/// The values between lines; of the right line, A' - B' and B' are given.
#[inline(always)]
pub(super) fn mixed<F: Copy + core::ops::Add<Output = F> + core::ops::Sub<Output = F> + core::ops::Mul<Output = F>>(lines: [F; 4], fraction: F, fade: F) -> F {
    let l = lines[0] + lines[1] * fraction;
    let r = lines[2] + lines[3] * fraction;
    l + fade * (r - l)
}

#[inline(always)]
fn blended_value<L: Lanes>(lanes: L, &[south_west, south_east, north_west, north_east]: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> L::Floats {
    let [a, b] = line(lanes, y, south_west, north_west);
    let [c, d] = line(lanes, y, south_east, north_east);
    mixed([a, b, c - d, d], x.fraction, x.fade)
}

/// The value l + fade (r - l) has the slope B + fade' (r - l) + fade (B' - B) along a row; across it, the slopes of l and r mix as l and r do.
#[inline(always)]
fn blended_dual<L: Lanes>(lanes: L, &[south_west, south_east, north_west, north_east]: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
    let [a, b] = line(lanes, y, south_west, north_west);
    let [c, d] = line(lanes, y, south_east, north_east);
    let [turned_a, turned_b] = turned_line(lanes, y, south_west, north_west);
    let [turned_c, turned_d] = turned_line(lanes, y, south_east, north_east);
    let l = a + b * x.fraction;
    let r = (c - d) + d * x.fraction;
    Dual {
        value: l + x.fade * (r - l),
        slopes: [b + (x.turn * (r - l) + x.fade * (d - b)), mixed([turned_a, turned_b, turned_c - turned_d, turned_d], x.fraction, x.fade)],
    }
}

/// The slopes of A and B across the row.
#[inline(always)]
fn turned_line<L: Lanes>(lanes: L, y: &Axis<L>, south: [L::Floats; 2], north: [L::Floats; 2]) -> [L::Floats; 2] {
    let below = south[1] * y.fraction;
    let above = north[1] * (y.fraction - lanes.splat(1.0));
    [south[1] + (y.turn * (above - below) + y.fade * (north[1] - south[1])), y.turn * (north[0] - south[0])]
}

/// As [`super::gradient::blender_at`]; the kernel's slope is 6 (r - 1) times the offset.
#[inline(always)]
fn radial_dual<L: Lanes>(lanes: L, &[south_west, south_east, north_west, north_east]: &Corners<L>, x: &Axis<L>, y: &Axis<L>) -> Dual<L> {
    let number = |value| lanes.splat(value);
    let (zero, one) = (number(0.0), number(1.0));
    let mut sum = [zero; 3];
    for ([gx, gy], [i, j]) in [(south_west, [0.0, 0.0]), (south_east, [1.0, 0.0]), (north_west, [0.0, 1.0]), (north_east, [1.0, 1.0])] {
        let (dx, dy) = (x.fraction - number(i), y.fraction - number(j));
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
    Dual { value: sum[0], slopes: [sum[1], sum[2]] }
}
