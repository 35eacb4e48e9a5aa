//! What can be said of a programme's values without evaluating it: their range by interval arithmetic, a bound on their slopes, and how finely they must be sampled.

use super::{
    graph::{Graph, Place, PlaceId, Step},
    operation::{Binary, Unary},
};
use crate::noise::Field;
use core::f64::consts::{FRAC_PI_2, PI, TAU};

/// The least and the greatest value.
pub(super) type Range = [f64; 2];

const MAX: f64 = f32::MAX as f64;

/// The programme's noises in a world of that seed, as samples `spacing` programme units apart can carry them; as they are for a spacing of 0.
pub(super) fn fields(graph: &Graph, seed: u64, spacing: f64) -> Vec<Field> {
    let field = |noise: &super::graph::Noise| {
        let key = noise.key(seed);
        if spacing > 0.0 { Field::banded(noise.shape, noise.basis, key, spacing) } else { Field::exact(noise.shape, noise.basis, key) }
    };
    graph.noises.iter().map(field).collect()
}

/// The range of every step's values: none lies outside, wherever it is evaluated.
pub(super) fn ranges(graph: &Graph, fields: &[Field]) -> Vec<Range> {
    let mut ranges: Vec<Range> = Vec::with_capacity(graph.steps.len());
    for &step in &graph.steps {
        let range = match step {
            Step::Number(bits) => [f64::from(f32::from_bits(bits)); 2],
            Step::Coordinate(..) => [-MAX, MAX],
            Step::Shape(shape, _) => graph.shapes[shape].range(),
            Step::Noise(noise, _) => fields[noise].range().map(f64::from),
            Step::ShapeSlope(shape, ..) => symmetric(graph.shapes[shape].max_slope()),
            Step::NoiseSlope(noise, ..) => symmetric(f64::from(fields[noise].max_slope())),
            Step::Unary(operation, a) => unary(operation, ranges[a]),
            Step::Binary(operation, a, b) => binary(operation, ranges[a], ranges[b]),
            Step::Select(mask, a, b) => match ranges[mask] {
                [low, _] if low > 0.0 => ranges[a],
                [_, high] if high <= 0.0 => ranges[b],
                _ => hull(ranges[a], ranges[b]),
            },
            Step::Terrace(terrace, a) => ranges[a].map(|h| f64::from(terrace.apply(h as f32))),
            Step::TerraceSlope(terrace, _) => [0.0, terrace.max_slope()],
            // A valley's bed lies between two nodes, less the incision.
            Step::Erosion(erosion, of, _) => {
                let [low, high] = ranges[of];
                [low - (high - low) * graph.erosions[erosion].erosion.greatest_cut(), high]
            }
        };
        ranges.push(match step {
            Step::Number(_) | Step::Select(..) => range,
            _ => outward(range),
        });
    }
    ranges
}

/// Bounds the values of an erosion of the exact programme from below, wherever it is evaluated; upwards to twelve bits, so that it is the same with and without
/// simplification, whose ranges differ by roundings.
pub(super) fn erosion_floor(graph: &Graph, number: usize) -> f32 {
    let [low, high] = ranges(graph, &fields(graph, 0, 0.0))[graph.erosions[number].of];
    let floor = (low - (high - low) * graph.erosions[number].erosion.greatest_cut()).max(-MAX) as f32;
    let towards_0 = f32::from_bits(floor.to_bits() & !0xfff);
    if towards_0 < floor { f32::from_bits(towards_0.to_bits() + 0x1000) } else { towards_0 }
}

/// A range with room for the rounding of f32; with 0 in it where a result may not be finite, for that becomes 0.
fn outward([low, high]: Range) -> Range {
    // One operation errs by 2^-24 of the result and by 2^-149; pow and the like by little more.
    let room = |bound: f64| bound.abs() * (1.0 / 4_194_304.0) + 1e-44;
    let (low, high) = (low - room(low), high + room(high));
    if low >= -MAX && high <= MAX {
        return [low, high];
    }
    // Also where a bound is not a number.
    [if low.is_nan() { -MAX } else { low.clamp(-MAX, 0.0) }, if high.is_nan() { MAX } else { high.clamp(0.0, MAX) }]
}

/// The range of means of a few values of a range, with room for the rounding of their sums: 15 additions err by 2^-24 each.
pub(super) fn averaged([low, high]: Range) -> Range {
    let room = |bound: f64| bound.abs() * (1.0 / 1_048_576.0) + 1e-43;
    [(low - room(low)).max(-MAX), (high + room(high)).min(MAX)]
}

fn symmetric(bound: f64) -> Range {
    [-bound, bound]
}

pub(super) fn hull(a: Range, b: Range) -> Range {
    [a[0].min(b[0]), a[1].max(b[1])]
}

pub(super) fn contains(range: Range, value: f64) -> bool {
    range[0] <= value && value <= range[1]
}

/// The hull of a function's values at the corners of two ranges.
pub(super) fn corners(a: Range, b: Range, function: impl Fn(f64, f64) -> f64) -> Range {
    let values = [function(a[0], b[0]), function(a[0], b[1]), function(a[1], b[0]), function(a[1], b[1])];
    [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

/// The range of |a|.
fn magnitude(a: Range) -> Range {
    let high = a[0].abs().max(a[1].abs());
    [if contains(a, 0.0) { 0.0 } else { a[0].abs().min(a[1].abs()) }, high]
}

pub(super) fn unary(operation: Unary, a: Range) -> Range {
    match operation {
        Unary::Sin => periodic(a, FRAC_PI_2, libm::sin),
        Unary::Cos => periodic(a, 0.0, libm::cos),
        // A pole, unless both ends lie in one branch.
        Unary::Tan if (a[1] - a[0]) < PI && ((a[0] / PI + 0.5).floor() == (a[1] / PI + 0.5).floor()) && a[0].abs().max(a[1].abs()) < 1e6 => {
            let ends = a.map(libm::tan);
            if ends[0] <= ends[1] && magnitude(ends)[1] < 1e5 { ends } else { [-MAX, MAX] }
        }
        Unary::Tan => [-MAX, MAX],
        Unary::Atan => a.map(libm::atan),
        Unary::Negative => [-a[1], -a[0]],
        Unary::Abs => magnitude(a),
        Unary::Sqrt => magnitude(a).map(f64::sqrt),
        Unary::Log => {
            let [low, high] = magnitude(a);
            // The least positive f32 is 2^-149.
            let least = if low > 0.0 { libm::log(low) } else { -103.3 };
            let most = if high > 0.0 { libm::log(high) } else { 0.0 };
            if low > 0.0 { [least, most] } else { [least.min(0.0), most.max(0.0)] }
        }
    }
}

/// The range of a function of period 2π whose greatest value lies at `crest` and whose least half a period later.
fn periodic(a: Range, crest: f64, function: impl Fn(f64) -> f64) -> Range {
    if a[1] - a[0] >= TAU || magnitude(a)[1] > 1e6 {
        return [-1.0, 1.0];
    }
    let reaches = |extreme: f64| ((a[0] - extreme) / TAU).ceil() * TAU + extreme <= a[1];
    let (first, last) = (function(a[0]), function(a[1]));
    [if reaches(crest + PI) { -1.0 } else { first.min(last) }, if reaches(crest) { 1.0 } else { first.max(last) }]
}

pub(super) fn binary(operation: Binary, a: Range, b: Range) -> Range {
    match operation {
        Binary::Plus => [a[0] + b[0], a[1] + b[1]],
        Binary::Minus => [a[0] - b[1], a[1] - b[0]],
        Binary::Multiply => corners(a, b, |a, b| a * b),
        Binary::Divide if !contains(b, 0.0) => corners(a, b, |a, b| a / b),
        Binary::Power if a[0] > 0.0 => hull(corners(a, b, libm::pow), corners(a, b, libm::pow)),
        Binary::Divide | Binary::Power => [-MAX, MAX],
        Binary::Mod => modulo(a, b),
        Binary::Min => [a[0].min(b[0]), a[1].min(b[1])],
        Binary::Max => [a[0].max(b[0]), a[1].max(b[1])],
    }
}

/// a - b ⌊a / b⌋ lies between 0 and b, but for what rounding of the quotient does to a large a.
fn modulo(a: Range, b: Range) -> Range {
    let [_, a_high] = magnitude(a);
    let [b_low, b_high] = magnitude(b);
    if a_high / b_low.max(1e-300) > 1e38 {
        return [-MAX, MAX];
    }
    let slip = a_high * 5e-7 + b_high * 5e-7;
    [b[0].min(0.0) - slip, b[1].max(0.0) + slip]
}

/// A bound on the slopes of every step along both axes, in its values a programme unit.
fn slopes(graph: &Graph, fields: &[Field], ranges: &[Range]) -> Vec<f64> {
    let mut slopes: Vec<f64> = Vec::with_capacity(graph.steps.len());
    for (id, &step) in graph.steps.iter().enumerate() {
        let slope = match step {
            Step::Number(_) => 0.0,
            Step::Coordinate(_, place) => stretch(graph, place, &slopes),
            Step::Shape(shape, place) => graph.shapes[shape].max_slope() * stretch(graph, place, &slopes),
            Step::Noise(noise, place) => f64::from(fields[noise].max_slope()) * stretch(graph, place, &slopes),
            Step::ShapeSlope(..) | Step::NoiseSlope(..) | Step::TerraceSlope(..) => f64::INFINITY,
            Step::Unary(operation, a) => unary_slope(operation, slopes[a], ranges[a], ranges[id]),
            Step::Binary(operation, a, b) => binary_slope(operation, [slopes[a], slopes[b]], [ranges[a], ranges[b]]),
            Step::Select(_, a, b) => slopes[a].max(slopes[b]),
            Step::Terrace(terrace, a) => terrace.max_slope() * slopes[a],
            // Across a valley's side the terrain falls to its bed.
            Step::Erosion(erosion, of, _) => slopes[of] + graph.erosions[erosion].erosion.greatest_slope() * (ranges[id][1] - ranges[id][0]),
        };
        slopes.push(if slope.is_nan() { f64::INFINITY } else { slope });
    }
    slopes
}

/// How much closer a place's points can lie than the samples: a bound on the derivatives of its coordinates.
fn stretch(graph: &Graph, place: PlaceId, slopes: &[f64]) -> f64 {
    match graph.places[place] {
        Place::Grid { .. } => 1.0,
        Place::Shifted { base, .. } => stretch(graph, base, slopes),
        Place::Moved { base, dx, dy } => stretch(graph, base, slopes) + slopes[dx] + slopes[dy],
    }
}

fn times(slope: f64, factor: f64) -> f64 {
    if slope == 0.0 { 0.0 } else { slope * factor }
}

fn unary_slope(operation: Unary, slope: f64, a: Range, value: Range) -> f64 {
    match operation {
        Unary::Sin | Unary::Cos | Unary::Atan | Unary::Negative | Unary::Abs => slope,
        Unary::Tan => times(slope, 1.0 + magnitude(value)[1] * magnitude(value)[1]),
        Unary::Log => times(slope, 1.0 / magnitude(a)[0]),
        Unary::Sqrt => times(slope, 0.5 / magnitude(value)[0]),
    }
}

fn binary_slope(operation: Binary, [da, db]: [f64; 2], [a, b]: [Range; 2]) -> f64 {
    match operation {
        Binary::Plus | Binary::Minus => da + db,
        Binary::Multiply => times(da, magnitude(b)[1]) + times(db, magnitude(a)[1]),
        Binary::Divide => {
            let least = magnitude(b)[0];
            times(da, 1.0 / least) + times(db, magnitude(a)[1] / (least * least))
        }
        Binary::Min | Binary::Max => da.max(db),
        Binary::Power if da == 0.0 && db == 0.0 => 0.0,
        Binary::Power => f64::INFINITY,
        Binary::Mod => da + times(db, magnitude(a)[1] / magnitude(b)[0]),
    }
}

/// Samples a side that every sample is the mean of, 1, 2 or 4, so that no function turns faster than one period from one to the next, as far as that many help.
pub(super) fn subsamples(graph: &Graph, fields: &[Field], spacing: f64) -> usize {
    if spacing <= 0.0 {
        return 1;
    }
    let ranges = ranges(graph, fields);
    let slopes = slopes(graph, fields, &ranges);
    let turns = graph.reachable(graph.root).into_iter().map(|id| turns(graph, id, &ranges, &slopes) * spacing).fold(0.0, f64::max);
    match turns {
        turns if turns <= 1.0 => 1,
        turns if turns <= 2.0 => 2,
        _ => 4,
    }
}

/// Periods a programme unit that a step can turn through.
fn turns(graph: &Graph, id: usize, ranges: &[Range], slopes: &[f64]) -> f64 {
    // The argument's slope, over what it may change by before the function is where it was.
    let through = |a: usize, period: f64| times(slopes[a], 1.0 / period);
    match graph.steps[id] {
        Step::Unary(Unary::Sin | Unary::Cos, a) => through(a, TAU),
        Step::Unary(Unary::Tan, a) => through(a, PI),
        // A spike where the argument passes 0.
        Step::Unary(Unary::Log, a) if contains(ranges[a], 0.0) => through(a, magnitude(ranges[a])[1]),
        Step::Binary(Binary::Divide, _, b) if contains(ranges[b], 0.0) => through(b, magnitude(ranges[b])[1]),
        Step::Binary(Binary::Mod, a, b) => through(a, magnitude(ranges[b])[1]),
        Step::Terrace(terrace, a) => through(a, 1.0 / terrace.steps()),
        Step::Select(mask, ..) if contains(ranges[mask], 0.0) => through(mask, magnitude(ranges[mask])[1]),
        // A filtered noise turns once in four samples at most.
        Step::Noise(_, place) | Step::Shape(_, place) => (stretch(graph, place, slopes) - 1.0) / 4.0,
        _ => 0.0,
    }
}
