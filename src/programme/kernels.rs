//! Steps over blocks of samples: every loop is compiled for every instruction set, with the operation known.

use super::{
    evaluate::Prepared,
    graph::{Axis, Step},
    operation::{Binary, Unary},
    sampling::{Drawn, Wave},
};
use crate::noise::{Draws, Isa, Kernel, Lanes, SIDE, elementary};

/// An operand of a block: one number for all samples, or one a sample.
#[derive(Clone, Copy, Debug)]
pub(super) enum Input<'a> {
    Number(f32),
    Samples(&'a [f32]),
}

/// The value of a step at a point, in a part of a sample, from the values of its operands: the meaning that the blocks are held to. Erosion is found elsewhere.
pub(super) fn value(step: Step, [a, b, c]: [f32; 3], [u, v]: [f64; 2], part: usize, prepared: &Prepared) -> f32 {
    match step {
        Step::Number(bits) => f32::from_bits(bits),
        Step::Coordinate(Axis::U, _) => u as f32,
        Step::Coordinate(Axis::V, _) => v as f32,
        Step::Shape(shape, _) => prepared.shapes[shape].at(u, v),
        Step::ShapeSlope(shape, axis, _) => prepared.shapes[shape].slope(axis, u, v),
        Step::Noise(noise, _) => {
            let value = prepared.fields[noise].at(u, v);
            prepared.draws[noise].as_ref().map_or(value, |drawn| drawn.apply(value, drawn.values[part]))
        }
        Step::NoiseSlope(noise, axis, _) => prepared.fields[noise].slopes_at(u, v)[axis as usize],
        Step::Erosion(..) => a,
        Step::Unary(operation @ (Unary::Sin | Unary::Cos), of) => {
            let value = operation.apply(a);
            prepared.waves[of].as_ref().map_or(value, |wave| wave.apply(value, wave.draws()[part]))
        }
        Step::Unary(operation, _) => operation.apply(a),
        Step::Binary(operation, ..) => operation.apply(a, b),
        Step::Select(..) => chosen(a, b, c),
        Step::Terrace(terrace, _) => terrace.apply(a),
        Step::TerraceSlope(terrace, _) => terrace.slope(a),
    }
}

#[inline(always)]
pub(super) fn chosen(mask: f32, a: f32, b: f32) -> f32 {
    if mask > 0.0 { a } else { b }
}

/// A value, or 0 and one more in the count if it is not finite.
#[inline(always)]
fn finite(value: f32, count: &mut u32) -> f32 {
    let is_finite = value.is_finite();
    *count += u32::from(!is_finite);
    if is_finite { value } else { 0.0 }
}

/// Replaces what is not finite by 0 and counts it.
pub(super) fn keep_finite(isa: Isa, values: &mut [f32]) -> u64 {
    isa.run(KeepFinite { values })
}

struct KeepFinite<'a> {
    values: &'a mut [f32],
}

impl Kernel for KeepFinite<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        // Reading is cheap, and there is hardly ever anything to write.
        let all_finite = self.values.iter().fold(true, |all, value| all & value.is_finite());
        if all_finite {
            return 0;
        }
        let mut count = 0;
        for value in self.values {
            *value = finite(*value, &mut count);
        }
        count.into()
    }
}

/// Adds what stands for a noise's detail to its values in a row of the parts of samples.
pub(super) fn draw(isa: Isa, drawn: Option<&Drawn>, part_row: usize, values: &mut [f32]) {
    if let Some(drawn) = drawn {
        isa.run(InParts { draws: repeated(&drawn.values, part_row), values, function: |value, draw| drawn.apply(value, draw) });
    }
}

/// Fades the values of a wave in a row of the parts of samples.
pub(super) fn fade(isa: Isa, wave: &Wave, part_row: usize, values: &mut [f32]) {
    isa.run(InParts { draws: repeated(wave.draws(), part_row), values, function: |value, draw| wave.apply(value, draw) });
}

/// Values that are taken at a time: whole vectors of parts of samples.
const PARTS: usize = 16;

/// The draws of a row of parts, again and again.
fn repeated(draws: &Draws, part_row: usize) -> [f32; PARTS] {
    core::array::from_fn(|i| draws[part_row * SIDE + i % SIDE])
}

struct InParts<'a, F> {
    draws: [f32; PARTS],
    values: &'a mut [f32],
    function: F,
}

impl<F: Fn(f32, f32) -> f32> Kernel for InParts<'_, F> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { draws, values, function } = self;
        let (groups, rest) = values.as_chunks_mut::<PARTS>();
        for group in groups {
            for (value, draw) in group.iter_mut().zip(draws) {
                *value = function(*value, draw);
            }
        }
        for (value, draw) in rest.iter_mut().zip(draws) {
            *value = function(*value, draw);
        }
    }
}

/// Applies `function` to every value.
pub(super) fn map(isa: Isa, a: Input<'_>, out: &mut [f32], function: impl Fn(f32) -> f32) -> u64 {
    match a {
        Input::Samples(a) => isa.run(Map { a, out, function }),
        Input::Number(a) => {
            let mut count = 0;
            out.fill(finite(function(a), &mut count));
            u64::from(count) * out.len() as u64
        }
    }
}

struct Map<'a, F> {
    a: &'a [f32],
    out: &'a mut [f32],
    function: F,
}

impl<F: Fn(f32) -> f32> Kernel for Map<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        // As locals, what the function holds is known to stay as it is while values are written.
        let Self { a, out, function } = self;
        let mut count = 0;
        for (out, &a) in out.iter_mut().zip(a) {
            *out = finite(function(a), &mut count);
        }
        count.into()
    }
}

/// Applies `function` to every pair of values.
fn zip(isa: Isa, a: &[f32], b: &[f32], out: &mut [f32], function: impl Fn(f32, f32) -> f32) -> u64 {
    isa.run(Zip { a, b, out, function })
}

struct Zip<'a, F> {
    a: &'a [f32],
    b: &'a [f32],
    out: &'a mut [f32],
    function: F,
}

impl<F: Fn(f32, f32) -> f32> Kernel for Zip<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { a, b, out, function } = self;
        let mut count = 0;
        for (out, (&a, &b)) in out.iter_mut().zip(a.iter().zip(b)) {
            *out = finite(function(a, b), &mut count);
        }
        count.into()
    }
}

/// Applies `function` to positions.
pub(super) fn at_points(isa: Isa, us: &[f64], vs: &[f64], out: &mut [f32], function: impl Fn(f64, f64) -> f32) -> u64 {
    isa.run(AtPoints { us, vs, out, function })
}

struct AtPoints<'a, F> {
    us: &'a [f64],
    vs: &'a [f64],
    out: &'a mut [f32],
    function: F,
}

impl<F: Fn(f64, f64) -> f32> Kernel for AtPoints<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { us, vs, out, function } = self;
        let mut count = 0;
        for (out, (&u, &v)) in out.iter_mut().zip(us.iter().zip(vs)) {
            *out = finite(function(u, v), &mut count);
        }
        count.into()
    }
}

/// Applies `function` to the positions of a row.
pub(super) fn along_row(isa: Isa, us: &[f64], v: f64, out: &mut [f32], function: impl Fn(f64, f64) -> f32) -> u64 {
    isa.run(AlongRow { us, v, out, function })
}

struct AlongRow<'a, F> {
    us: &'a [f64],
    v: f64,
    out: &'a mut [f32],
    function: F,
}

impl<F: Fn(f64, f64) -> f32> Kernel for AlongRow<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { us, v, out, function } = self;
        let mut count = 0;
        for (out, &u) in out.iter_mut().zip(us) {
            *out = finite(function(u, v), &mut count);
        }
        count.into()
    }
}

/// `a` where the mask is above 0, else `b`.
pub(super) fn select(isa: Isa, [mask, a, b]: [Input<'_>; 3], out: &mut [f32]) -> u64 {
    match (mask, a, b) {
        (Input::Samples(mask), Input::Number(a), Input::Number(b)) => map(isa, Input::Samples(mask), out, |mask| chosen(mask, a, b)),
        (Input::Samples(mask), Input::Samples(a), Input::Number(b)) => zip(isa, mask, a, out, |mask, a| chosen(mask, a, b)),
        (Input::Samples(mask), Input::Number(a), Input::Samples(b)) => zip(isa, mask, b, out, |mask, b| chosen(mask, a, b)),
        (Input::Samples(mask), Input::Samples(a), Input::Samples(b)) => isa.run(Select { mask, a, b, out }),
        (Input::Number(mask), ..) => map(isa, if mask > 0.0 { a } else { b }, out, |value| value),
    }
}

struct Select<'a> {
    mask: &'a [f32],
    a: &'a [f32],
    b: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Select<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { mask, a, b, out } = self;
        for (out, (&mask, (&a, &b))) in out.iter_mut().zip(mask.iter().zip(a.iter().zip(b))) {
            *out = chosen(mask, a, b);
        }
        0
    }
}

/// A match over operations whose arms name the operation as a constant, also within closures: so every loop is compiled for its own operation.
macro_rules! specialise {
    ($kind:ident, [$($variant:ident),*], $operation:expr, $constant:ident => $body:expr) => {
        match $operation {
            $($kind::$variant => {
                const $constant: $kind = $kind::$variant;
                $body
            })*
        }
    };
}

/// A function of one value over a block.
pub(super) fn unary(isa: Isa, operation: Unary, a: Input<'_>, out: &mut [f32]) -> u64 {
    // Nearly all angles are small, and those need no branch.
    let small = matches!(a, Input::Samples(a) if a.iter().all(|a| a.abs() <= elementary::SMALL));
    match operation {
        Unary::Sin if small => return map(isa, a, out, elementary::sin_small),
        Unary::Cos if small => return map(isa, a, out, elementary::cos_small),
        Unary::Tan if small => return map(isa, a, out, elementary::tan_small),
        _ => {}
    }
    specialise!(Unary, [Sin, Cos, Tan, Atan, Negative, Abs, Log, Sqrt], operation, OPERATION => map(isa, a, out, |a| OPERATION.apply(a)))
}

/// A function of two values over a block.
pub(super) fn binary(isa: Isa, operation: Binary, a: Input<'_>, b: Input<'_>, out: &mut [f32]) -> u64 {
    specialise!(Binary, [Plus, Minus, Multiply, Divide, Power, Mod, Min, Max], operation, OPERATION => match (a, b) {
        (Input::Samples(a), Input::Samples(b)) => zip(isa, a, b, out, |a, b| OPERATION.apply(a, b)),
        (Input::Samples(_), Input::Number(b)) => map(isa, a, out, |a| OPERATION.apply(a, b)),
        (Input::Number(a), _) => map(isa, b, out, |b| OPERATION.apply(a, b)),
    })
}
