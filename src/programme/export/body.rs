//! The steps of a programme as the body of a function: one line a step, one a place.

use super::number::{float, place};
use crate::programme::{
    graph::{Axis, Graph, HERE, Id, Place, PlaceId, Step},
    kernels,
    operation::{Binary, Unary},
};
use std::{collections::BTreeSet, fmt::Write};

/// What a programme's function calls.
#[derive(Debug, Default)]
pub(super) struct Calls {
    pub noises: BTreeSet<usize>,
    pub noise_slopes: BTreeSet<usize>,
    pub shapes: BTreeSet<usize>,
    pub shape_slopes: BTreeSet<usize>,
}

struct Body<'a> {
    graph: &'a Graph,
    lines: String,
    calls: Calls,
    /// Numbers are written where they are used.
    numbers: Vec<Option<f32>>,
    places: BTreeSet<PlaceId>,
    noise_slopes: BTreeSet<(usize, PlaceId)>,
}

/// The function of a graph's value and what it calls.
pub(super) fn function(graph: &Graph, order: &[Id]) -> (String, Calls) {
    let numbers = vec![None; graph.steps.len()];
    let mut body = Body { graph, lines: String::new(), calls: Calls::default(), numbers, places: BTreeSet::from([HERE]), noise_slopes: BTreeSet::new() };
    for &id in order {
        body.step(id);
    }
    let value = body.value(graph.root);
    (format!("fn terrane_programme(p{HERE}: TerranePlace) -> f32 {{\n{}    return {value};\n}}\n\n", body.lines), body.calls)
}

/// A number that follows from numbers alone, as the server has it.
fn folded(step: Step, operands: &[f32]) -> Option<f32> {
    let value = match (step, operands) {
        (Step::Number(bits), _) => f32::from_bits(bits),
        (Step::Unary(operation, _), &[a]) => operation.apply(a),
        (Step::Binary(operation, ..), &[a, b]) => operation.apply(a, b),
        (Step::Select(..), &[mask, a, b]) => kernels::chosen(mask, a, b),
        (Step::Terrace(terrace, _), &[h]) => terrace.apply(h),
        (Step::TerraceSlope(terrace, _), &[h]) => terrace.slope(h),
        _ => return None,
    };
    Some(if value.is_finite() { value } else { 0.0 })
}

impl Body<'_> {
    fn value(&self, id: Id) -> String {
        self.numbers[id].map_or_else(|| format!("v{id}"), float)
    }

    fn line(&mut self, text: &str) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.lines, "    {text}");
    }

    fn step(&mut self, id: Id) {
        let step = self.graph.steps[id];
        let numbers: Option<Vec<f32>> = step.operands().map(|operand| self.numbers[operand]).collect();
        if let Some(number) = numbers.and_then(|operands| folded(step, &operands)) {
            self.numbers[id] = Some(number);
            return;
        }
        if let Some(at) = step.place() {
            self.place(at);
        }
        let expression = self.expression(step);
        self.line(&format!("let v{id}: f32 = {expression};"));
    }

    /// Finds a place before it is used.
    fn place(&mut self, id: PlaceId) {
        if !self.places.insert(id) {
            return;
        }
        let expression = match self.graph.places[id] {
            Place::Grid { du, dv } => format!("terrane_joined(p{HERE}, {})", place(du.get(), dv.get())),
            Place::Shifted { base, du, dv } => {
                self.place(base);
                format!("terrane_joined(p{base}, {})", place(du.get(), dv.get()))
            }
            Place::Moved { base, dx, dy } => {
                self.place(base);
                format!("terrane_moved(p{base}, vec2<f32>({}, {}))", self.value(dx), self.value(dy))
            }
        };
        self.line(&format!("let p{id}: TerranePlace = {expression};"));
    }

    fn expression(&mut self, step: Step) -> String {
        let component = |axis: Axis| if axis == Axis::U { "x" } else { "y" };
        match step {
            // Numbers were folded.
            Step::Number(bits) => float(f32::from_bits(bits)),
            Step::Coordinate(axis, at) => format!("terrane_numbers(p{at}).{}", component(axis)),
            Step::Shape(shape, at) => {
                self.calls.shapes.insert(shape);
                format!("terrane_shape_{shape}(p{at})")
            }
            Step::ShapeSlope(shape, axis, at) => {
                self.calls.shape_slopes.insert(shape);
                format!("terrane_shape_{shape}_slopes(p{at}).{}", component(axis))
            }
            Step::Noise(noise, at) => {
                self.calls.noises.insert(noise);
                format!("terrane_noise_{noise}(p{at})")
            }
            Step::NoiseSlope(noise, axis, at) => {
                self.calls.noise_slopes.insert(noise);
                if self.noise_slopes.insert((noise, at)) {
                    self.line(&format!("let s{noise}_{at}: vec3<f32> = terrane_noise_{noise}_slopes(p{at});"));
                }
                format!("terrane_finite(s{noise}_{at}.{})", if axis == Axis::U { "y" } else { "z" })
            }
            // Refused before.
            Step::Erosion(_, of, _) => self.value(of),
            Step::Unary(operation, a) => unary(operation, &self.value(a)),
            Step::Binary(operation, a, b) => binary(operation, &self.value(a), &self.value(b)),
            Step::Select(mask, a, b) => format!("terrane_select({}, {}, {})", self.value(mask), self.value(a), self.value(b)),
            Step::Terrace(terrace, h) => terraced("terrane_terrace", &self.value(h), terrace.n.get(), terrace.sharpness.get()),
            Step::TerraceSlope(terrace, h) => terraced("terrane_terrace_slope", &self.value(h), terrace.n.get(), terrace.sharpness.get()),
        }
    }
}

fn terraced(function: &str, h: &str, n: f64, sharpness: f64) -> String {
    format!("{function}({h}, {}, {})", float(n as f32), float(sharpness as f32))
}

fn unary(operation: Unary, a: &str) -> String {
    match operation {
        Unary::Sin => format!("terrane_sin({a})"),
        Unary::Cos => format!("terrane_cos({a})"),
        Unary::Tan => format!("terrane_tan({a})"),
        Unary::Atan => format!("terrane_atan({a})"),
        Unary::Negative => format!("-{a}"),
        Unary::Abs => format!("abs({a})"),
        Unary::Log => format!("terrane_log({a})"),
        Unary::Sqrt => format!("sqrt(abs({a}))"),
    }
}

fn binary(operation: Binary, a: &str, b: &str) -> String {
    match operation {
        Binary::Plus => format!("terrane_finite({a} + {b})"),
        Binary::Minus => format!("terrane_finite({a} - {b})"),
        Binary::Multiply => format!("terrane_finite({a} * {b})"),
        Binary::Divide => format!("terrane_divide({a}, {b})"),
        Binary::Power => format!("terrane_power({a}, {b})"),
        Binary::Mod => format!("terrane_mod({a}, {b})"),
        Binary::Min => format!("min({a}, {b})"),
        Binary::Max => format!("max({a}, {b})"),
    }
}
