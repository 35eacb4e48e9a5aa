//! Programmes in f64 with a running error bound, and how far the f32 evaluators are from them.
//!
//! Every step has a value and a bound on how far an f32 evaluation may be from it: what its operands' errors can do to it, by interval arithmetic, and its own
//! rounding. Gradient noises and their fractals are computed by the formulas of `noise::tests::reference`, with the errors that are asked of them there. Cellular
//! noise and slopes of noise are taken as they are, since tests of their own hold them; slopes of shapes may be anything here, and those of terraces anything in
//! their range. Erosion is left out, since it decides between nodes.

use super::{
    Frame, Programme, Reference,
    bounds::{Range, binary, contains, corners, fields, hull, unary},
    graph::{Axis, Graph, HERE, Noise, Place, PlaceId, Step},
    operation::{Binary, Unary},
    shape::Shape,
    terrace::Terrace,
};
use crate::{
    geometry::Filter,
    noise::{Basis, Field, FieldShape, tests::reference},
};

/// Half the spacing of f32 relative to a value, with room for the hundredth that functions miss it by.
const ROUNDING: f64 = 1.01 / 16_777_216.0;

/// Half the spacing of f64.
const DOUBLE: f64 = 1.0 / 9_007_199_254_740_992.0;

/// A value, and a bound on how far f32 may be from it.
#[derive(Clone, Copy, Debug)]
struct Near {
    value: f64,
    error: f64,
}

impl Near {
    fn exactly(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    fn range(self) -> Range {
        [self.value - self.error, self.value + self.error]
    }

    /// A value that may also be anything within `range`, rounded; with 0 where f32 may overflow.
    fn within(value: f64, range: Range) -> Self {
        let overflows = |value: f64| value.is_nan() || value.abs() > f64::from(f32::MAX);
        let [low, high] = if range.into_iter().any(overflows) { hull(range, [0.0; 2]) } else { range };
        let value = if overflows(value) { 0.0 } else { value };
        let error = (high - value).max(value - low) + ROUNDING * low.abs().max(high.abs()) + 1e-44;
        Self { value, error: if error.is_nan() { f64::INFINITY } else { error } }
    }
}

/// A programme without erosion in f64.
struct Precise {
    graph: Graph,
    fields: Vec<Field>,
    keys: Vec<u64>,
    frame: Frame,
}

impl Precise {
    fn new(programme: &Programme, frame: &Frame) -> Option<Self> {
        let graph = Graph::plain(programme.root()).expect("small");
        if !graph.erosions.is_empty() {
            return None;
        }
        let fields = fields(&graph, frame.seed, 0.0);
        let keys = graph.noises.iter().map(|noise| noise.key(frame.seed)).collect();
        Some(Self { graph, fields, keys, frame: *frame })
    }

    /// The value at plane coordinates.
    fn at(&self, x: f64, y: f64) -> Near {
        let here = [(x - self.frame.origin[0]) / self.frame.scale, (y - self.frame.origin[1]) / self.frame.scale];
        let mut values = vec![Near::exactly(0.0); self.graph.steps.len()];
        for id in self.graph.reachable(self.graph.root) {
            let step = self.graph.steps[id];
            let at = self.position(step.place().unwrap_or(HERE), here, &values);
            let mut operands = [Near::exactly(0.0); 3];
            for (value, operand) in operands.iter_mut().zip(step.operands()) {
                *value = values[operand];
            }
            values[id] = self.step(step, operands, at);
        }
        values[self.graph.root]
    }

    fn position(&self, place: PlaceId, here: [f64; 2], values: &[Near]) -> [Near; 2] {
        let plus = |a: Near, b: Near| Near { value: a.value + b.value, error: a.error + b.error + DOUBLE * (a.value + b.value).abs() };
        match self.graph.places[place] {
            Place::Grid { du, dv } => [Near::exactly(here[0] + du.get()), Near::exactly(here[1] + dv.get())],
            Place::Shifted { base, du, dv } => {
                let [u, v] = self.position(base, here, values);
                [plus(u, Near::exactly(du.get())), plus(v, Near::exactly(dv.get()))]
            }
            Place::Moved { base, dx, dy } => {
                let [u, v] = self.position(base, here, values);
                [plus(u, values[dx]), plus(v, values[dy])]
            }
        }
    }

    fn step(&self, step: Step, [a, b, c]: [Near; 3], [u, v]: [Near; 2]) -> Near {
        match step {
            Step::Number(bits) => Near::exactly(f32::from_bits(bits).into()),
            Step::Coordinate(axis, _) => {
                let coordinate = [u, v][axis as usize];
                Near::within(coordinate.value, coordinate.range())
            }
            Step::Shape(shape, _) => shaped(&self.graph.shapes[shape], u, v),
            Step::Noise(noise, _) => self.noise(noise, u, v),
            Step::NoiseSlope(noise, axis, _) => self.slope(noise, axis, u, v),
            Step::ShapeSlope(..) => Near::within(0.0, [f64::NEG_INFINITY, f64::INFINITY]),
            Step::Unary(operation, _) => unary_near(operation, a),
            Step::Binary(operation, ..) => binary_near(operation, a, b),
            Step::Select(..) => match a.range() {
                [low, _] if low > 0.0 => b,
                [_, high] if high <= 0.0 => c,
                _ => Near::within(if a.value > 0.0 { b.value } else { c.value }, hull(b.range(), c.range())),
            },
            Step::Terrace(terrace, _) => terraced(terrace, a),
            Step::TerraceSlope(terrace, _) => Near::within(0.0, [0.0, terrace.max_slope()]),
            Step::Erosion(..) => unreachable!("left out"),
        }
    }

    fn noise(&self, number: usize, u: Near, v: Near) -> Near {
        let (Noise { shape, basis, .. }, field) = (self.graph.noises[number], &self.fields[number]);
        let [low, high] = field.range().map(f64::from);
        let (value, own) = match basis {
            Basis::OPerlin | Basis::IPerlin | Basis::Blender => (reference::evaluate(shape, basis, self.keys[number], u.value, v.value), allowed(shape)),
            _ => (field.at(u.value, v.value).into(), 1e-6),
        };
        // No slope leads out of the range.
        let moved = ((u.error + v.error) * f64::from(field.max_slope())).min(high - low);
        let error = own * (high - low) + if u.error + v.error == 0.0 { 0.0 } else { moved };
        Near::within(value, [value - error, value + error])
    }

    fn slope(&self, number: usize, axis: Axis, u: Near, v: Near) -> Near {
        let (field, exact) = (&self.fields[number], u.error + v.error == 0.0);
        let (value, steepest) = (f64::from(field.slopes_at(u.value, v.value)[axis as usize]), f64::from(field.max_slope()));
        let error = if exact { 1e-6 } else { 2.0 } * steepest;
        Near::within(value, [value - error, value + error])
    }
}

/// The error that is asked of a field, as a part of its range: metres on a relief of 5 km.
fn allowed(shape: FieldShape) -> f64 {
    let metres = match shape {
        FieldShape::Single | FieldShape::Fbm { .. } | FieldShape::Spectral { .. } | FieldShape::Turbulence { hard: false, .. } => 0.001,
        FieldShape::Turbulence { hard: true, .. } => 0.001_5,
        _ => 0.004,
    };
    metres / 5_000.0
}

/// The nearest coordinate to a centre or to one of its repetitions.
fn relative(at: Near, centre: f64, repeat: f64) -> Near {
    let d = at.value - centre;
    let value = if repeat > 0.0 { d - repeat * libm::floor(d / repeat + 0.5) } else { d };
    Near { value, error: at.error + 2.0 * DOUBLE * at.value.abs() }
}

/// Both signs of an interval's square.
fn square(a: Near) -> Range {
    let [low, high] = a.range();
    [if contains([low, high], 0.0) { 0.0 } else { (low * low).min(high * high) }, (low * low).max(high * high)]
}

fn shaped(shape: &Shape, u: Near, v: Near) -> Near {
    let radius = |centre: [f64; 2], repeat: f64| {
        let (x, y) = (relative(u, centre[0], repeat), relative(v, centre[1], repeat));
        let ([xl, xh], [yl, yh]) = (square(x), square(y));
        (x.value * x.value + y.value * y.value, [xl + yl, xh + yh])
    };
    match *shape {
        Shape::Gauss { width, centre, repeat } => {
            let (r, [near, far]) = radius(centre, repeat);
            // The exponent is rounded to f32.
            let bell = |r: f64, side: f64| {
                let exponent = r / (-2.0 * width * width);
                libm::exp(exponent + side * ROUNDING * exponent.abs())
            };
            Near::within(bell(r, 0.0), [bell(far, -1.0), bell(near, 1.0)])
        }
        Shape::Sphere { radius: greatest, centre, repeat } => {
            let (r, [near, far]) = radius(centre, repeat);
            let half = |r: f64| (greatest * greatest - r).max(0.0).sqrt();
            Near::within(half(r), [half(far), half(near)])
        }
        Shape::Plane { direction } => {
            let value = u.value * direction.0[0] + v.value * direction.0[1];
            let error = u.error + v.error + 4.0 * DOUBLE * (u.value.abs() + v.value.abs());
            Near::within(value, [value - error, value + error])
        }
        Shape::Step { .. } => {
            let value = f64::from(shape.filtered(0.0).at(u.value, v.value));
            let error = (shape.max_slope() * (u.error + v.error + 4.0 * DOUBLE * (u.value.abs() + v.value.abs()))).min(1.0);
            Near::within(value, [(value - error).max(0.0), (value + error).min(1.0)])
        }
    }
}

fn unary_near(operation: Unary, a: Near) -> Near {
    let value = match operation {
        Unary::Sin => libm::sin(a.value),
        Unary::Cos => libm::cos(a.value),
        Unary::Tan => libm::tan(a.value),
        Unary::Atan => libm::atan(a.value),
        Unary::Negative => -a.value,
        Unary::Abs => a.value.abs(),
        Unary::Log if a.value == 0.0 => 0.0,
        Unary::Log => libm::log(a.value.abs()),
        Unary::Sqrt => a.value.abs().sqrt(),
    };
    if matches!(operation, Unary::Negative | Unary::Abs) || (a.value == 0.0 && a.error == 0.0) {
        return Near { value, error: a.error };
    }
    Near::within(value, hull([value; 2], unary(operation, a.range())))
}

fn binary_near(operation: Binary, a: Near, b: Near) -> Near {
    let exact = a.error == 0.0 && b.error == 0.0;
    let value = match operation {
        Binary::Plus => a.value + b.value,
        Binary::Minus => a.value - b.value,
        Binary::Multiply => a.value * b.value,
        Binary::Divide if b.value == 0.0 => a.value,
        Binary::Divide => a.value / b.value,
        Binary::Power => libm::pow(a.value, b.value),
        Binary::Mod if b.value == 0.0 => 0.0,
        Binary::Mod => a.value - b.value * libm::floor(a.value / b.value),
        Binary::Min => a.value.min(b.value),
        Binary::Max => a.value.max(b.value),
    };
    let range = match operation {
        Binary::Divide | Binary::Power if exact && (b.value == 0.0 || value.is_nan()) => [value; 2].map(|value| if value.is_nan() { 0.0 } else { value }),
        Binary::Power => power(a.range(), b.range()),
        Binary::Mod => modulo(a, b),
        Binary::Min | Binary::Max => {
            let [low, high] = binary(operation, a.range(), b.range());
            return Near { value, error: (high - value).max(value - low) };
        }
        _ => binary(operation, a.range(), b.range()),
    };
    Near::within(value, hull(range, if value.is_finite() { [value; 2] } else { range }))
}

/// Where the base may be 0 or less: 0 for a power that is complex, and poles.
fn power(a: Range, b: Range) -> Range {
    if a[0] > 0.0 {
        return corners(a, b, libm::pow);
    }
    let whole = b[0] == b[1] && b[0] == libm::floor(b[0]);
    if b[0] > 0.0 && (whole || a[1] >= 0.0 || b[0] != b[1]) {
        let greatest = corners([0.0, a[1].max(-a[0])], b, libm::pow)[1];
        return if whole { [-greatest, greatest] } else { [-greatest, greatest.max(0.0)] };
    }
    [f64::NEG_INFINITY, f64::INFINITY]
}

/// In one period the remainder errs as what it is taken from; where a period may end, it is anything.
fn modulo(a: Near, b: Near) -> Range {
    if b.value == 0.0 && b.error == 0.0 {
        return [0.0; 2];
    }
    let quotient = binary(Binary::Divide, a.range(), b.range());
    let periods = quotient.map(|q| (q - ROUNDING * q.abs(), q + ROUNDING * q.abs()));
    let (first, last) = (libm::floor(periods[0].0), libm::floor(periods[1].1));
    let most = b.value.abs() + b.error;
    if contains(b.range(), 0.0) || first != last {
        // Rounding of the quotient may leave a little more than a period, or less than none.
        let slip = ROUNDING * 4.0 * (a.value.abs() + a.error + most);
        return [-most - slip, most + slip];
    }
    let product = corners([first; 2], b.range(), |n, b| n * b);
    let room = ROUNDING * product[0].abs().max(product[1].abs());
    [a.range()[0] - product[1] - room, a.range()[1] - product[0] + room]
}

fn terraced(terrace: Terrace, a: Near) -> Near {
    let (n, sharpness) = (f64::from(terrace.n.get() as f32), f64::from(terrace.sharpness.get() as f32));
    let t = n * a.value;
    let below = libm::floor(t);
    let r = ((t - below - sharpness) / (1.0 - sharpness)).clamp(0.0, 1.0);
    let value = (below + r * r * (3.0 - 2.0 * r)) / n;
    // t is rounded, and so is its fraction.
    let error = terrace.max_slope() * (a.error + 2.0 * ROUNDING * (a.value.abs() + 1.0 / n)) + 4.0 * ROUNDING * (value.abs() + 1.0 / n);
    Near::within(value, [value - error, value + error])
}

/// Near the origin, as close as samples of zoom level 24 at 20 km a unit, and 2^40 m away.
fn places() -> impl Iterator<Item = [f64; 2]> {
    let far = 1_099_511_627_776.0;
    (0..600_u64).map(move |i| {
        let (a, b) = (reference::unit(2 * i), reference::unit(2 * i + 1));
        match i % 3 {
            0 => [60_000.0 * a - 30_000.0, 60_000.0 * b - 30_000.0],
            1 => [14_000.0 + i as f64 * 0.009_330_692, -4_000.0 + a],
            _ => [far + 60_000.0 * a, 60_000.0 * b - far],
        }
    })
}

/// Holds the evaluator within the bound; what is answered is the median of the bounds near the origin, and the greatest part of a bound that was used.
fn check(text: &str) -> (f64, f64) {
    let frame = Frame { seed: 42, scale: 20_000.0, origin: [0.0, 0.0] };
    let programme = Programme::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let (precise, plain) = (Precise::new(&programme, &frame).expect("no erosion"), Reference::new(programme.root(), &frame, 1.0, Filter::Exact));
    let (mut bounds, mut used) = (Vec::new(), 0.0_f64);
    for (i, [x, y]) in places().enumerate() {
        let (near, got) = (precise.at(x, y), f64::from(plain.at(x, y)));
        assert!((got - near.value).abs() <= near.error, "{text} at {x} {y}: {got} is more than {} from {}", near.error, near.value);
        if i % 3 < 2 {
            bounds.push(near.error);
            used = used.max((got - near.value).abs() / near.error);
        }
    }
    bounds.sort_by(f64::total_cmp);
    (bounds[bounds.len() / 2], used)
}

/// Sums of gradient noise on a relief of 5 km keep to the millimetre, others to a few, in the bound too.
#[test]
fn f32_stays_within_the_running_error_bound() {
    for (text, relief, metres) in [
        ("plus(multiply(0.8, fbm(1, 2, 8)), multiply(0.2, o_perlin))", 2.2, 0.005),
        ("minus(turbulence(6, 0.5, 2), multiply(0.3, i_perlin))", 2.0, 0.006),
        ("multiply(ridged_multifractal(1, 2, 8, 1, 2), plus(0.5, fbm(1, 2, 4)))", 2.5, 0.05),
        ("max(fbm(1, 2, 8), min(0.2, abs(o_perlin)))", 1.5, 0.01),
        ("warp(fbm(1, 2, 6), multiply(0.3, o_perlin), multiply(0.3, i_perlin))", 2.0, 0.05),
        ("terrace(fbm(1, 2, 6), 6, 0.5)", 2.0, 0.05),
        ("select(o_perlin, gauss(0.7, repeat=3), sqrt(plus(1.1, blender_noise)))", 1.0, 0.05),
        ("mod(plus(x, fbm(1, 2, 5)), 0.37)", 0.37, 0.1),
        ("log(plus(2.5, hybrid_multifractal(0.5, 2, 6, 0.7, 1)))", 1.0, 0.1),
        ("sin(multiply(7, fbm(1, 2, 6)))", 2.0, 0.1),
        ("divide(voronoi_f1, plus(2, spectral(2)))", 0.5, 0.1),
        ("power(plus(1.5, o_perlin), 2.5)", 5.0, 0.05),
        ("atan(multiply(3, hetero_terrain(1, 2, 6, 0.7)))", 3.0, 0.3),
    ] {
        let (usual, used) = check(text);
        let usual = usual / relief * 5_000.0;
        assert!(usual <= metres, "{text}: the bound is {usual} m on a relief of 5 km");
        assert!(used > 0.03, "{text}: no more than {used} of the bound is used");
    }
}

#[test]
fn every_shipped_programme_without_erosion_stays_within_the_bound() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/programmes");
    let mut checked = 0;
    for entry in std::fs::read_dir(folder).expect("shipped") {
        let path = entry.expect("readable").path();
        let document: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).expect("readable")).expect("JSON");
        let text = document["programme"].as_str().expect("text");
        if text.contains("erosion(") {
            continue;
        }
        let (usual, _) = check(text);
        assert!(usual < 2e-4, "{}: the bound is {usual}", path.display());
        checked += 1;
    }
    assert!(checked >= 5, "{checked} programmes were checked");
}

/// What jumps, what is protected, and what overflows.
#[test]
fn awkward_programmes_stay_within_the_bound() {
    for text in [
        "log(log(log(log(log(log(log(fbm(1.0, 1.97, 2))))))))",
        "power(minus(o_perlin, 0.5), plus(fbm(0.5, 2.1, 3, basis=voronoi_f1), fbm(0.5, 2.1, 3)))",
        "power(o_perlin, 3)",
        "power(o_perlin, negative(2))",
        "power(fbm(1, 2, 4), 0.5)",
        "plus(sin(multiply(x, 1e7)), plus(cos(y), plus(tan(x), atan(divide(y, x)))))",
        "plus(log(0), sqrt(negative(y)))",
        "min(power(x, 30), multiply(multiply(x, 1e30), multiply(y, 1e30)))",
        "multiply(1e38, plus(3, o_perlin))",
        "divide(1, 0)",
        "divide(o_perlin, minus(fbm(1, 2, 3), 0.1))",
        "mod(multiply(50, x), 0.4)",
        "mod(x, o_perlin)",
        "plus(step(n), plus(step(s, 0.5), multiply(step(w), plane(ne))))",
        "plus(sphere(2, repeat=5), sphere(0.5, centre_x=0.2))",
        "warp(gauss(1), y, x)",
        "distorted_noise(0.5, voronoi_f2f1, cell_noise)",
        "smooth(ridged_multifractal(1, 2, 3, 1, 2), 0.1)",
        "slope(warp(turbulence(4, 0.5, 2, true), multiply(0.3, i_perlin), power(2, x)))",
        "gradient_x(smooth(terrace(mod(plus(abs(o_perlin), max(x, y)), 0.7), 3, 0.5), 0.1))",
    ] {
        check(text);
    }
}
