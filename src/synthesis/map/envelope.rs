//! Where an edge may bend to: places that are nearer to it than to any other edge of the unrefined map.

use super::MapEdge;
use crate::geometry::Edge;
use rstar::{AABB, RTree, RTreeObject};

/// Envelopes keep this share of what is theirs, so that they do not touch.
const SHARE: f64 = 0.95;

/// Steps an edge in which the distance of others is found, at most.
const STEPS: usize = 256;

/// An edge with its number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbered {
    pub(super) ends: [[f64; 2]; 2],
    pub(super) number: usize,
}

impl RTreeObject for Numbered {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.ends[0], self.ends[1])
    }
}

/// All edges of a map by place.
pub(super) fn index(edges: &[MapEdge]) -> RTree<Numbered> {
    RTree::bulk_load(edges.iter().enumerate().map(|(number, edge)| Numbered { ends: [edge.start, edge.end], number }).collect())
}

/// How far from an edge a curve may go, along the edge. With q the place of the edge beside a place p, p is nearer to the edge than to another one if it is nearer to q than half the distance of q and that
/// other edge; edges that share an end are kept apart by the line halfway between them.
pub(super) struct Envelope {
    pub(super) length: f64,
    /// Across over along from either end.
    wedges: [f64; 2],
    /// Half the distance of edges that share no end, at least, in equal steps.
    halves: Vec<f64>,
}

impl Envelope {
    /// Of an edge, which bends in `segments` steps.
    pub(super) fn new(edge: &MapEdge, number: usize, index: &RTree<Numbered>, segments: usize) -> Self {
        let along = [edge.end[0] - edge.start[0], edge.end[1] - edge.start[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let shares = |other: &Numbered, end: [f64; 2]| other.number != number && other.ends.contains(&end);
        let wedge = |end: [f64; 2], direction: [f64; 2]| {
            let point = AABB::from_point(end);
            let others = index.locate_in_envelope_intersecting(point).filter(|other| shares(other, end));
            let tangents = others.map(|other| {
                let far = if other.ends[0] == end { other.ends[1] } else { other.ends[0] };
                half_angle_tangent(direction, [far[0] - end[0], far[1] - end[1]])
            });
            SHARE * tangents.fold(f64::INFINITY, f64::min)
        };
        let wedges = [wedge(edge.start, along), wedge(edge.end, along.map(|c| -c))];
        let steps = segments.min(STEPS);
        let step = length / steps as f64;
        // Nothing bends further than half its length: others further away than its length do not matter.
        let low = [0, 1].map(|axis| edge.start[axis].min(edge.end[axis]) - length);
        let high = [0, 1].map(|axis| edge.start[axis].max(edge.end[axis]) + length);
        let apart = |other: &&Numbered| other.number != number && !other.ends.iter().any(|end| *end == edge.start || *end == edge.end);
        let others: Vec<Edge> =
            index.locate_in_envelope_intersecting(AABB::from_corners(low, high)).filter(apart).map(|other| Edge::new(other.ends[0], other.ends[1])).collect();
        let halves = (0..steps).map(|i| {
            let t = (i as f64 + 0.5) / steps as f64;
            let q = [edge.start[0] + along[0] * t, edge.start[1] + along[1] * t];
            let nearest = others.iter().map(|other| other.nearest(q).0).fold(length * length, f64::min).sqrt();
            // Half a step away the distance is less by half a step at most.
            SHARE * (nearest - step / 2.0).max(0.0) / 2.0
        });
        Self { length, wedges, halves: halves.collect() }
    }

    /// How far from the edge a curve may go at a place along it.
    fn half(&self, x: f64) -> f64 {
        (self.wedges[0] * x).min(self.wedges[1] * (self.length - x))
    }

    /// Whether a step of a curve lies inside: along and across the edge from its first end.
    pub(super) fn holds(&self, a: [f64; 2], b: [f64; 2]) -> bool {
        // Wedges are convex: their ends decide.
        for [x, y] in [a, b] {
            if !(0.0..=self.length).contains(&x) || y.abs() > self.half(x) {
                return false;
            }
        }
        let count = self.halves.len();
        let step = |x: f64| ((x / self.length * count as f64) as usize).min(count - 1);
        let (low, high) = (step(a[0].min(b[0])), step(a[0].max(b[0])));
        let reach = a[1].abs().max(b[1].abs());
        self.halves[low..=high].iter().all(|half| reach <= *half)
    }
}

/// The tangent of half the angle between two directions: |u × v| / (|u| |v| + u · v).
fn half_angle_tangent(u: [f64; 2], v: [f64; 2]) -> f64 {
    let (cross, dot) = (u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
    let lengths = ((u[0] * u[0] + u[1] * u[1]) * (v[0] * v[0] + v[1] * v[1])).sqrt();
    // Of a flat angle infinite.
    cross.abs() / (lengths + dot).max(0.0)
}
