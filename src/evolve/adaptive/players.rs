//! Who is on the ground, and where nothing may change for it.

use super::settings::{Ground, MAX_POSITIONS};
use crate::{
    evolve::record::RecordError,
    geometry::{PLANE_LIMIT, Rectangle},
};
use std::collections::BTreeMap;

/// Players with the ways they went since the last generation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Players {
    ways: BTreeMap<String, Vec<[f64; 2]>>,
}

impl Players {
    /// Somebody arrives, or goes on in a straight line to a point in plane metres.
    ///
    /// # Errors
    /// If the point is not in the plane, or there are as many positions since the last generation as a feedback may hold.
    pub fn go(&mut self, player: &str, to: [f64; 2]) -> Result<(), RecordError> {
        if to.iter().any(|c| c.is_nan() || c.abs() > PLANE_LIMIT) {
            return Err(RecordError::new("/position", format!("must be plane metres within 2^40 of the origin, got {to:?}")));
        }
        if self.ways.values().map(Vec::len).sum::<usize>() >= MAX_POSITIONS {
            return Err(RecordError::new("/position", format!("more than {MAX_POSITIONS} positions since the last generation: breed one first")));
        }
        let way = self.ways.entry(player.to_owned()).or_default();
        if way.last() != Some(&to) {
            way.push(to);
        }
        Ok(())
    }

    /// Somebody leaves: nothing is promised to whoever is not there. Whether there was such a player.
    pub fn leave(&mut self, player: &str) -> bool {
        self.ways.remove(player).is_some()
    }

    /// The ways of all players, each ending where one is: for [`Feedback::ways`](super::Feedback::ways).
    #[must_use]
    pub fn ways(&self) -> Vec<Vec<[f64; 2]>> {
        self.ways.values().cloned().collect()
    }

    /// A generation was bred with these ways: from now on only where players are counts, and where they go.
    pub fn rest(&mut self) {
        for way in self.ways.values_mut() {
            way.drain(..way.len() - 1);
        }
    }

    /// A player who is within so many metres of a rectangle.
    #[must_use]
    pub fn within(&self, area: &Rectangle, distance: f64) -> Option<&str> {
        let grown = area.grown(distance);
        self.ways.iter().find(|(_, way)| way.last().is_some_and(|&position| grown.holds(position))).map(|(name, _)| name.as_str())
    }
}

/// Cells around a node that samples see it in.
const SEEN: f64 = 2.0;

/// How far terrain goes on beyond the nodes of its border, in metres: farther than anything in the plane.
const BEYOND: f64 = 1e13;

/// How much of a new height each node takes, row by row from the south: nothing in the frozen zone around ways, which is the promise and two cells more, and more and
/// more beyond it. Samples see nodes in squares, so the two cells are those of a square; and nodes of the border are seen from all that lies beyond it.
pub(super) fn thaw(ground: &Ground, ways: &[Vec<[f64; 2]>], promise: f64, weights: &mut [f32]) {
    let size = ground.size();
    let (seen, fade) = (SEEN * ground.cell, ground.fade as f64 * ground.cell);
    let far = promise + seen + fade;
    for [from, to] in ways.iter().flat_map(|way| parts(way)) {
        let between = |axis: usize, low: f64, high: f64| {
            let node = |c: f64| ((c - ground.origin[axis]) / ground.cell).clamp(0.0, (size[axis] - 1) as f64);
            node(low).floor() as usize..=node(high).ceil() as usize
        };
        let columns_between = |west: f64, east: f64| between(0, west, east);
        let nodes = |axis: usize| between(axis, from[axis].min(to[axis]) - far, from[axis].max(to[axis]) + far);
        for row in nodes(1) {
            // Of the part only what is so near to the row matters to its nodes; those of a border are seen from all that lies beyond it.
            let y = ground.origin[1] + row as f64 * ground.cell;
            let low = if row == 0 { f64::NEG_INFINITY } else { y - far - ground.cell };
            let high = if row + 1 == size[1] { f64::INFINITY } else { y + far + ground.cell };
            let Some([west, east]) = clipped(from, to, [low, high]) else { continue };
            for column in columns_between(west - far - ground.cell, east + far + ground.cell) {
                let weight = &mut weights[row * size[0] + column];
                if *weight <= 0.0 {
                    continue;
                }
                let beyond = to_box(from, to, &seen_from(ground, [column, row], seen)) - promise;
                // A whisker more than the promise: distances are rounded.
                if beyond <= 1e-6 * ground.cell {
                    *weight = 0.0;
                } else if beyond < fade {
                    *weight = weight.min(smooth(beyond / fade));
                }
            }
        }
    }
}

/// The least and greatest x of what a straight way has between two y; `None` if it has nothing there.
fn clipped(from: [f64; 2], to: [f64; 2], [low, high]: [f64; 2]) -> Option<[f64; 2]> {
    let step = to[1] - from[1];
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    if step == 0.0 {
        if !(low..=high).contains(&from[1]) {
            return None;
        }
    } else {
        let [a, b] = [(low - from[1]) / step, (high - from[1]) / step];
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    let ends = [first, last].map(|t| from[0] + t * (to[0] - from[0]));
    (first <= last).then(|| [ends[0].min(ends[1]), ends[0].max(ends[1])])
}

/// Where samples see a node from.
pub(super) fn seen_from(ground: &Ground, node: [usize; 2], seen: f64) -> Rectangle {
    let size = ground.size();
    let place = |axis: usize| ground.origin[axis] + node[axis] as f64 * ground.cell;
    let min = [0, 1].map(|axis| if node[axis] == 0 { -BEYOND } else { place(axis) - seen });
    let max = [0, 1].map(|axis| if node[axis] + 1 == size[axis] { BEYOND } else { place(axis) + seen });
    Rectangle { min, max }
}

/// The straight parts of a way; one without length where it does not move.
pub(super) fn parts(way: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    let alone = (way.len() == 1).then(|| [way[0], way[0]]);
    way.windows(2).map(|pair| [pair[0], pair[1]]).chain(alone)
}

/// From 0 to 1, t in between.
pub(super) fn smooth(t: f64) -> f32 {
    let t = t.clamp(0.0, 1.0);
    (t * t * (3.0 - 2.0 * t)) as f32
}

/// The distance between a straight way and a rectangle.
pub(super) fn to_box(from: [f64; 2], to: [f64; 2], area: &Rectangle) -> f64 {
    if enters(from, to, area) {
        return 0.0;
    }
    // Else a corner of the rectangle or an end of the way is nearest.
    let corners = area.corners().map(|corner| to_way(from, to, corner));
    let outside = |c: f64, axis: usize| (area.min[axis] - c).max(c - area.max[axis]).max(0.0);
    let ends = [from, to].map(|[x, y]| length([outside(x, 0), outside(y, 1)]));
    corners.into_iter().chain(ends).fold(f64::INFINITY, f64::min)
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

fn to_way(from: [f64; 2], to: [f64; 2], point: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    let along = (point[0] - from[0]) * way[0] + (point[1] - from[1]) * way[1];
    let t = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    length([point[0] - from[0] - t * way[0], point[1] - from[1] - t * way[1]])
}

/// Whether a way has a point in a rectangle (Liang and Barsky 1984).
fn enters(from: [f64; 2], to: [f64; 2], area: &Rectangle) -> bool {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        if step == 0.0 {
            if from[axis] < area.min[axis] || from[axis] > area.max[axis] {
                return false;
            }
            continue;
        }
        let [a, b] = [(area.min[axis] - from[axis]) / step, (area.max[axis] - from[axis]) / step];
        (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
    }
    first <= last
}
