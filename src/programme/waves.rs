//! The waves of a programme: sines and cosines of what rises evenly over the plane.

use super::{
    graph::{Axis, Graph, Id, Place, PlaceId, Step},
    operation::{Binary, Unary},
};
use core::f64::consts::TAU;

/// What is known of a step for waves.
#[derive(Clone, Copy)]
enum Trend {
    /// A number, as it is evaluated.
    Number(f32),
    /// It rises by so much a unit along both axes; what is left is bounded or unknown, but has no trend.
    Even([f64; 2]),
    /// It may rise differently from place to place.
    Uneven,
}

impl Trend {
    fn rise(self) -> Option<[f64; 2]> {
        match self {
            Trend::Number(_) => Some([0.0; 2]),
            Trend::Even(rise) => Some(rise),
            Trend::Uneven => None,
        }
    }
}

/// The length of the waves that a sine or cosine of each step makes, in programme units; `None` where it makes none, or none of one length.
///
/// It is the same for a programme as it was written and simplified: no rule of simplification changes a bit, and here numbers are taken as they are evaluated.
pub(super) fn lengths(graph: &Graph) -> Vec<Option<f64>> {
    let mut trends: Vec<Trend> = Vec::with_capacity(graph.steps.len());
    for &step in &graph.steps {
        trends.push(trend(graph, step, &trends));
    }
    let length = |trend: &Trend| match *trend {
        Trend::Even([u, v]) if u != 0.0 || v != 0.0 => Some(TAU / (u * u + v * v).sqrt()),
        _ => None,
    };
    trends.iter().map(length).collect()
}

/// The steps that sines and cosines are taken of, among those that the programme's value depends on.
pub(super) fn arguments(graph: &Graph) -> impl Iterator<Item = Id> {
    graph.reachable(graph.root).into_iter().filter_map(|id| if let Step::Unary(Unary::Sin | Unary::Cos, a) = graph.steps[id] { Some(a) } else { None })
}

fn trend(graph: &Graph, step: Step, trends: &[Trend]) -> Trend {
    let even = |rise: Option<[f64; 2]>| rise.map_or(Trend::Uneven, Trend::Even);
    match step {
        Step::Number(bits) => Trend::Number(f32::from_bits(bits)),
        Step::Coordinate(axis, place) => even(along(graph, place, axis, trends)),
        Step::Unary(operation, a) => match trends[a] {
            Trend::Number(a) if operation.apply(a).is_finite() => Trend::Number(operation.apply(a)),
            Trend::Even(rise) if operation == Unary::Negative => Trend::Even(rise.map(|rise| 0.0 - rise)),
            _ if matches!(operation, Unary::Sin | Unary::Cos | Unary::Atan) => Trend::Even([0.0; 2]),
            of => without(&[of]),
        },
        Step::Binary(operation, a, b) => binary(operation, trends[a], trends[b]),
        Step::Shape(..) | Step::ShapeSlope(..) | Step::Noise(..) | Step::NoiseSlope(..) | Step::TerraceSlope(..) => Trend::Even([0.0; 2]),
        Step::Select(mask, a, b) => without(&[trends[mask], trends[a], trends[b]]),
        Step::Terrace(_, a) | Step::Erosion(_, a, _) => without(&[trends[a]]),
    }
}

/// What follows from steps without a trend has none.
fn without(operands: &[Trend]) -> Trend {
    let flat = operands.iter().all(|trend| trend.rise().is_some_and(|rise| rise == [0.0; 2]));
    if flat { Trend::Even([0.0; 2]) } else { Trend::Uneven }
}

fn binary(operation: Binary, a: Trend, b: Trend) -> Trend {
    if let (Trend::Number(a), Trend::Number(b)) = (a, b)
        && operation.apply(a, b).is_finite()
    {
        return Trend::Number(operation.apply(a, b));
    }
    let scaled = |rise: [f64; 2], by: f64| Trend::Even(rise.map(|rise| rise * by + 0.0));
    match (operation, a, b) {
        (Binary::Multiply, Trend::Number(number), Trend::Even(rise)) | (Binary::Multiply, Trend::Even(rise), Trend::Number(number)) => {
            scaled(rise, f64::from(number))
        }
        (Binary::Divide, Trend::Even(rise), Trend::Number(number)) if number != 0.0 => scaled(rise, 1.0 / f64::from(number)),
        (Binary::Plus | Binary::Minus, a, b) => match (a.rise(), b.rise()) {
            (Some([au, av]), Some([bu, bv])) if operation == Binary::Plus => Trend::Even([au + bu, av + bv]),
            (Some([au, av]), Some([bu, bv])) => Trend::Even([au - bu, av - bv]),
            _ => Trend::Uneven,
        },
        _ => without(&[a, b]),
    }
}

/// How a place's coordinate rises along the sample's axes.
fn along(graph: &Graph, place: PlaceId, axis: Axis, trends: &[Trend]) -> Option<[f64; 2]> {
    match graph.places[place] {
        Place::Grid { .. } => Some(if axis == Axis::U { [1.0, 0.0] } else { [0.0, 1.0] }),
        Place::Shifted { base, .. } => along(graph, base, axis, trends),
        Place::Moved { base, dx, dy } => {
            let (base, by) = (along(graph, base, axis, trends)?, trends[if axis == Axis::U { dx } else { dy }].rise()?);
            Some([base[0] + by[0], base[1] + by[1]])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::programme::Programme;

    fn check(text: &str, expected: &[Option<f64>]) {
        let programme = Programme::parse(text).expect("valid");
        for graph in [Graph::plain(programme.root()), Graph::simplified(programme.root())] {
            let graph = graph.expect("small");
            let lengths = lengths(&graph);
            let found: Vec<Option<f64>> = arguments(&graph).map(|argument| lengths[argument].map(|length| (length * 1e6).round() / 1e6)).collect();
            assert_eq!(found, expected, "{text}");
        }
    }

    #[test]
    fn what_rises_evenly_makes_waves_of_one_length() {
        let fifth = Some((TAU / 5.0 * 1e6).round() / 1e6);
        check("sin(plus(multiply(3, x), multiply(y, 4)))", &[fifth]);
        check("cos(minus(negative(multiply(3, x)), plus(fbm(1, 2, 4), multiply(divide(y, 2), plus(3, 5)))))", &[fifth]);
        check("sin(plus(multiply(5, x), sin(y)))", &[Some((TAU * 1e6).round() / 1e6), fifth]);
        check("warp(sin(multiply(5, x)), multiply(4, x), 0)", &[Some((TAU / 25.0 * 1e6).round() / 1e6)]);
        check("sin(multiply(x, y))", &[None]);
        check("sin(fbm(1, 2, 4))", &[None]);
        check("sin(abs(x))", &[None]);
    }
}
