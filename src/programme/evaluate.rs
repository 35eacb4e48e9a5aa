//! Running a tape over the blocks of a window.

use super::{
    Frame,
    node::Keys,
    operation::{Binary, Unary},
    reference,
    tape::{Instruction, Tape},
};
use crate::{
    geometry::Window,
    noise::{Isa, Kernel, Lanes, Rows, elementary},
};

/// Samples a block: registers of a typical programme stay within the first-level cache.
const BLOCK: usize = 256;

/// A tape prepared for a window.
pub(super) struct Evaluation<'a> {
    isa: Isa,
    tape: &'a Tape,
    frame: &'a Frame,
    /// Programme coordinates of the columns.
    columns: Vec<f64>,
    noises: Vec<Rows>,
    registers: Vec<f32>,
    non_finite: u64,
}

impl<'a> Evaluation<'a> {
    pub(super) fn new(isa: Isa, tape: &'a Tape, frame: &'a Frame, window: &Window) -> Self {
        let columns: Vec<f64> = window.columns.coordinates().map(|x| (x - frame.origin[0]) / frame.scale).collect();
        let mut keys = Keys::new(frame.seed);
        let fields = tape.noises.iter().filter_map(|node| reference::field(node, &mut keys, frame, window.spacing(), window.filter));
        let noises = fields.map(|field| field.rows_on(isa, &columns)).collect();
        Self { isa, tape, frame, columns, noises, registers: vec![0.0; tape.registers * BLOCK], non_finite: 0 }
    }

    pub(super) fn run(mut self, window: &Window, out: &mut [f32]) -> u64 {
        for (y, row) in window.rows.coordinates().zip(out.chunks_mut(window.columns.len().max(1))) {
            let v = (y - self.frame.origin[1]) / self.frame.scale;
            for noise in &mut self.noises {
                noise.begin(v);
            }
            for (block, out) in row.chunks_mut(BLOCK).enumerate() {
                self.block(block * BLOCK, v, out.len());
                out.copy_from_slice(&self.registers[..out.len()]);
            }
        }
        self.non_finite + self.tape.folded_non_finite * window.samples() as u64
    }

    /// Runs all instructions over `count` columns from `start` on.
    fn block(&mut self, start: usize, v: f64, count: usize) {
        for instruction in &self.tape.instructions {
            let (Instruction::Constant { to, .. }
            | Instruction::X { to }
            | Instruction::Y { to }
            | Instruction::Noise { to, .. }
            | Instruction::Unary { at: to, .. }
            | Instruction::Binary { at: to, .. }
            | Instruction::BinaryRight { at: to, .. }
            | Instruction::BinaryLeft { at: to, .. }) = *instruction;
            let (at, rest) = self.registers[to * BLOCK..].split_at_mut(BLOCK);
            let at = &mut at[..count];
            self.non_finite += match *instruction {
                Instruction::Constant { value, .. } => {
                    at.fill(value);
                    0
                }
                Instruction::X { .. } => {
                    at.iter_mut().zip(&self.columns[start..]).for_each(|(at, &u)| *at = u as f32);
                    keep_finite(self.isa, at)
                }
                Instruction::Y { .. } => {
                    at.fill(v as f32);
                    keep_finite(self.isa, at)
                }
                Instruction::Noise { noise, .. } => {
                    self.noises[noise].fill(start, at);
                    keep_finite(self.isa, at)
                }
                Instruction::Unary { operation, .. } => unary(self.isa, operation, at),
                Instruction::Binary { operation, .. } => binary(self.isa, operation, at, Right::Register(&rest[..count])),
                Instruction::BinaryRight { operation, right, .. } => binary(self.isa, operation, at, Right::Number(right)),
                Instruction::BinaryLeft { operation, left, .. } => binary_left(self.isa, operation, left, at),
            };
        }
    }
}

/// Replaces what is not finite by 0 and counts it.
fn keep_finite(isa: Isa, values: &mut [f32]) -> u64 {
    map(isa, values, |a| a)
}

/// Applies `function` to every value, replaces what is not finite by 0 and counts it.
fn map(isa: Isa, values: &mut [f32], function: impl Fn(f32) -> f32) -> u64 {
    isa.run(Map { values, function })
}

struct Map<'a, F> {
    values: &'a mut [f32],
    function: F,
}

impl<F: Fn(f32) -> f32> Kernel for Map<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        // As locals, what the function holds is known to stay as it is while values are written.
        let Self { values, function } = self;
        let mut count = 0_u32;
        for value in values {
            let result = function(*value);
            let finite = result.is_finite();
            *value = if finite { result } else { 0.0 };
            count += u32::from(!finite);
        }
        count.into()
    }
}

/// As [`map`], with a second operand for every value.
fn zip(isa: Isa, values: &mut [f32], others: &[f32], function: impl Fn(f32, f32) -> f32) -> u64 {
    isa.run(Zip { values, others, function })
}

struct Zip<'a, F> {
    values: &'a mut [f32],
    others: &'a [f32],
    function: F,
}

impl<F: Fn(f32, f32) -> f32> Kernel for Zip<'_, F> {
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> u64 {
        let Self { values, others, function } = self;
        let mut count = 0_u32;
        for (value, &other) in values.iter_mut().zip(others) {
            let result = function(*value, other);
            let finite = result.is_finite();
            *value = if finite { result } else { 0.0 };
            count += u32::from(!finite);
        }
        count.into()
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

fn unary(isa: Isa, operation: Unary, at: &mut [f32]) -> u64 {
    // Nearly all angles are small, and those need no branch.
    let small = at.iter().all(|a| a.abs() <= elementary::SMALL);
    match operation {
        Unary::Sin if small => return map(isa, at, elementary::sin_small),
        Unary::Cos if small => return map(isa, at, elementary::cos_small),
        Unary::Tan if small => return map(isa, at, elementary::tan_small),
        _ => {}
    }
    specialise!(Unary, [Sin, Cos, Tan, Atan, Negative, Abs, Log, Sqrt], operation, OPERATION => map(isa, at, |a| OPERATION.apply(a)))
}

#[derive(Clone, Copy)]
enum Right<'a> {
    Register(&'a [f32]),
    Number(f32),
}

fn binary(isa: Isa, operation: Binary, at: &mut [f32], right: Right<'_>) -> u64 {
    specialise!(Binary, [Plus, Minus, Multiply, Divide, Power, Mod, Min, Max], operation, OPERATION => match right {
        Right::Register(right) => zip(isa, at, right, |a, b| OPERATION.apply(a, b)),
        Right::Number(right) => map(isa, at, |a| OPERATION.apply(a, right)),
    })
}

fn binary_left(isa: Isa, operation: Binary, left: f32, at: &mut [f32]) -> u64 {
    specialise!(Binary, [Plus, Minus, Multiply, Divide, Power, Mod, Min, Max], operation, OPERATION => map(isa, at, |b| OPERATION.apply(left, b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::Filter,
        programme::{Programme, Tape},
    };

    const FRAME: Frame = Frame { seed: 42, scale: 1_000.0, origin: [-300.0, 77.0] };

    /// Every sample of the tape equals the reference, and so does the count of what was not finite.
    fn check(text: &str) {
        let programme = Programme::parse(text).expect(text);
        let tape = Tape::compile(programme.root());
        for (bbox, spacing) in [([-4_000.0, -900.0, 3_900.0, 500.0], 13.7), ([0.0, 0.0, 9e7, 1e6], 3e5), ([1e12, -1e12, 1e12 + 3.0, 0.5 - 1e12], 0.01)] {
            for filter in [Filter::Band, Filter::Exact] {
                let window = Window::area(bbox, spacing, filter, 1 << 20).expect("valid");
                let window = window.band(0, window.rows.len().min(5));
                let mut out = vec![0.0; window.samples()];
                let non_finite = tape.evaluate(&FRAME, &window, &mut out);
                for isa in Isa::ALL {
                    let mut other = vec![0.0; window.samples()];
                    assert_eq!(tape.evaluate_on(isa, &FRAME, &window, &mut other), non_finite);
                    assert!(out.iter().zip(&other).all(|(a, b)| a.to_bits() == b.to_bits()), "{text} on {isa:?}");
                }
                let mut counted = 0;
                for (row, y) in out.chunks(window.columns.len()).zip(window.rows.coordinates()) {
                    for (got, x) in row.iter().zip(window.columns.coordinates()) {
                        let (want, count) = reference::evaluate(programme.root(), &FRAME, x, y, spacing, filter);
                        assert_eq!(got.to_bits(), want.to_bits(), "{text} at {x} {y} {filter:?}: {got} is not {want}");
                        counted += count;
                    }
                }
                assert_eq!(non_finite, counted, "{text}");
            }
        }
    }

    #[test]
    fn the_tape_equals_the_reference_bit_for_bit() {
        for text in [
            "3",
            "x",
            "minus(y, x)",
            "log(log(log(log(log(log(log(fbm(1.0, 1.97, 2))))))))",
            "plus(fbm(1, 1.97, 2), multiply(0.3, x))",
            "max(multiply(ridged_multifractal(1, 2, 5, 1, 2), i_perlin), minus(0.2, abs(turbulence(3.5, 0.5, 2, hard=true, basis=i_perlin))))",
            "plus(divide(cell_noise, voronoi_f1(metric=manhattan)), mod(voronoi_f2, minus(x, x)))",
            "power(minus(o_perlin, 0.5), plus(fbm(0.5, 2.1, 3, basis=voronoi_f1), fbm(0.5, 2.1, 3)))",
            "plus(sin(multiply(x, 1e7)), plus(cos(y), plus(tan(x), atan(divide(y, x)))))",
            "plus(log(0), sqrt(negative(y)))",
            "min(power(x, 30), multiply(multiply(x, 1e30), multiply(y, 1e30)))",
            "divide(1, 0)",
            "multiply(multiply(1e30, 1e30), x)",
            "plus(o_perlin(seed=3), minus(fbm(1, 2, 1, seed=3), o_perlin))",
        ] {
            check(text);
        }
    }

    #[test]
    fn what_is_not_finite_is_zero_and_counted_at_its_node() {
        let tape = Tape::compile(Programme::parse("plus(1, multiply(multiply(1e30, 1e30), x))").expect("valid").root());
        let window = Window::area([0.0, 0.0, 10.0, 10.0], 1.0, Filter::Band, 1_000).expect("valid");
        let mut out = vec![0.0; 100];
        assert_eq!(tape.evaluate(&FRAME, &window, &mut out), 100);
        assert_eq!(out, vec![1.0; 100]);
    }

    #[test]
    fn a_noise_stays_as_it_is_when_the_programme_changes_around_it() {
        let value = |text: &str| reference::evaluate(Programme::parse(text).expect("valid").root(), &FRAME, 123.0, 456.0, 1.0, Filter::Exact).0;
        let alone = value("fbm(1, 2, 4)");
        assert_eq!(value("plus(multiply(0, ridged_multifractal(1, 2, 4, 1, 2)), fbm(1, 2, 4))"), alone);
        assert_eq!(value("plus(fbm(1, 2, 4), multiply(0, fbm(1, 2, 4)))"), alone);
        assert_ne!(value("minus(fbm(1, 2, 4), fbm(1, 2, 4))"), 0.0, "two noises of one kind are two noises");
        assert_eq!(value("minus(fbm(1, 2, 4, seed=9), fbm(1, 2, 4, seed=9))"), 0.0, "noises of one seed are one");
    }
}
