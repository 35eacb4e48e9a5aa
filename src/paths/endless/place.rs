//! Where the strokes of a cell lie.

use super::{Chains, Mesh, Rings};
use crate::{
    geometry::{Axis, Filter, Window},
    noise,
    paths::{
        canvas::circle,
        lattice::{Frame, Node},
    },
    programme::{self, Tape},
};

/// Vertices of a chain.
const VERTICES: usize = 24;

/// How far a spur turns from its chain, in radians.
const SPUR: [f64; 2] = [0.7, 1.2];

/// What strokes of a cell are.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Chains(Chains),
    Rings(Rings),
}

/// What every cell has, checked.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    pub shape: Shape,
    pub profiles: Vec<u16>,
    pub inside: Option<u16>,
    pub only: bool,
    pub tape: Option<Tape>,
    pub frame: Option<programme::Frame>,
    /// Slope and start of what a programme's values become.
    pub line: [f32; 2],
    /// Least and greatest cost.
    pub costs: [f32; 2],
}

/// A stroke in its place.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub rule: usize,
    pub cell: [i64; 2],
    /// Among the strokes of its cell.
    pub number: u32,
    pub profile: u16,
    /// Lines in metres.
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// A series of numbers 0 … 1 by chance.
struct Chance {
    key: u64,
    drawn: u64,
}

impl Chance {
    fn next(&mut self) -> f64 {
        self.drawn += 1;
        (noise::key(self.key, self.drawn) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.next()
    }

    fn count(&mut self, [low, high]: [u32; 2]) -> u32 {
        low + (self.next() * f64::from(high - low + 1)) as u32
    }
}

impl Rule {
    /// Strokes a cell on average.
    pub(super) fn expected(&self) -> f64 {
        let (Shape::Chains(Chains { count, .. }) | Shape::Rings(Rings { count, .. })) = &self.shape;
        f64::midpoint(f64::from(count[0]), f64::from(count[1]))
    }

    /// Metres beyond its cell that a stroke can lie.
    pub(super) fn beyond(&self) -> f64 {
        match &self.shape {
            Shape::Chains(chains) => chains.length[1],
            Shape::Rings(rings) => rings.radius[1],
        }
    }

    /// Adds the strokes of a cell.
    pub(super) fn place(&self, rule: usize, cell: [i64; 2], side: f64, key: u64, places: &mut Vec<Place>) {
        let mut chance = Chance { key, drawn: 0 };
        let (Shape::Chains(Chains { count, .. }) | Shape::Rings(Rings { count, .. })) = &self.shape;
        for _ in 0..chance.count(*count) {
            let at = cell.map(|i| (i as f64 + chance.next()) * side);
            let profile = if self.profiles.is_empty() { 0 } else { self.profiles[(chance.next() * self.profiles.len() as f64) as usize] };
            let lines = match &self.shape {
                Shape::Chains(chains) => chain(chains, at, &mut chance),
                Shape::Rings(rings) => {
                    let t = chance.next();
                    // As many of each size as there is room for: the logarithm is uniform.
                    let radius = rings.radius[0] * libm::pow(rings.radius[1] / rings.radius[0], t * t);
                    vec![circle(at, radius)]
                }
            };
            places.push(Place { rule, cell, number: 0, profile, lines });
        }
    }

    /// The costs of nodes along a row of a lattice.
    pub(super) fn costs(&self, node: Node, spacing: f64) -> f32 {
        let (Some(tape), Some(frame)) = (&self.tape, &self.frame) else { return self.line[1] };
        let axis = |i: i64| Axis::new(i, 1, spacing, 0.0, 1);
        let mut value = [0.0];
        tape.evaluate(frame, &Window { columns: axis(node.column), rows: axis(node.row), filter: Filter::Exact }, &mut value);
        (self.line[0] * value[0] + self.line[1]).clamp(self.costs[0], self.costs[1])
    }
}

/// A wandering line around its middle, and its spurs.
fn chain(chains: &Chains, middle: [f64; 2], chance: &mut Chance) -> Vec<Vec<[f64; 2]>> {
    let length = chance.between(chains.length);
    let angle = chance.between([0.0, core::f64::consts::TAU]);
    let start = [middle[0] - libm::cos(angle) * length / 2.0, middle[1] - libm::sin(angle) * length / 2.0];
    let main = wander(start, angle, length, chains.wander, chance);
    let mut lines = Vec::new();
    for _ in 0..chains.spurs {
        let at = 1 + (chance.next() * (VERTICES - 2) as f64) as usize;
        let along = libm::atan2(main[at + 1][1] - main[at - 1][1], main[at + 1][0] - main[at - 1][0]);
        let side = if chance.next() < 0.5 { -1.0 } else { 1.0 };
        let angle = along + side * chance.between(SPUR);
        let length = length * chance.between([0.1, 1.0 / 3.0]);
        lines.push(wander(main[at], angle, length, chains.wander, chance));
    }
    lines.insert(0, main);
    lines
}

fn wander(start: [f64; 2], angle: f64, length: f64, wander: f64, chance: &mut Chance) -> Vec<[f64; 2]> {
    let step = length / (VERTICES - 1) as f64;
    let (mut at, mut turn, mut points) = (start, 0.0, vec![start]);
    for _ in 1..VERTICES {
        // Turns that come back: the line keeps its direction on the whole.
        turn = 0.85 * turn + wander * chance.between([-0.6, 0.6]);
        at = [at[0] + libm::cos(angle + turn) * step, at[1] + libm::sin(angle + turn) * step];
        points.push(at);
    }
    points
}

impl Place {
    /// The least frame of a lattice that holds its nodes.
    pub(super) fn frame(&self, spacing: f64) -> Frame {
        let range = |axis: usize| {
            let ends =
                self.lines.iter().flatten().map(|point| point[axis]).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
            ends.map(|c| (c / spacing).round() as i64)
        };
        let ([west, east], [south, north]) = (range(0), range(1));
        Frame { first: Node { row: south, column: west }, columns: (east - west + 1) as usize, rows: (north - south + 1) as usize }
    }

    /// Whether its paths can reach a frame.
    pub(super) fn meets(&self, frame: &Frame, mesh: &Mesh) -> bool {
        let own = self.frame(mesh.spacing).grown(mesh.reach);
        let meet = |a: i64, n: usize, b: i64, m: usize| a < b + m as i64 && b < a + n as i64;
        meet(own.first.column, own.columns, frame.first.column, frame.columns) && meet(own.first.row, own.rows, frame.first.row, frame.rows)
    }
}
