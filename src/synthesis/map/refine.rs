//! Edges of a map become curves.

use super::{
    Topology,
    bends::angles,
    envelope::{Envelope, index},
};
use crate::noise::{
    elementary::{cos_small, sin_small},
    mix,
};
use rayon::prelude::*;

/// Most segments of an edge.
const MOST_SEGMENTS: usize = 65_536;

/// Most tries to scale a curve into its envelope, each by this share of the one before.
const TRIES: usize = 40;
const SHRINK: f64 = 0.8;

/// How edges are refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// Metres of a segment: that of the level that is made.
    pub spacing: f64,
    /// Hashed with the ends of every edge.
    pub seed: u64,
}

/// A refined map.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// Of every edge of the topology its vertices from the first end to the other.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// How many edges with different regions on their sides stayed straight though they have segments to bend.
    pub straight: usize,
}

/// What an edge is drawn from: its ends, whichever way it is seen.
fn seed_of(start: [f64; 2], end: [f64; 2], seed: u64) -> u64 {
    [start, end].as_flattened().iter().fold(mix(seed), |hash, c| mix(hash ^ c.to_bits()))
}

/// Places along and across the edge that a curve's angles lead to, turned and scaled onto the edge's ends.
fn decoded(angles: &[f32], length: f64) -> Vec<[f64; 2]> {
    let mut at = [0.0, 0.0];
    let mut places = vec![at];
    for angle in angles {
        at = [at[0] + f64::from(cos_small(*angle)), at[1] + f64::from(sin_small(*angle))];
        places.push(at);
    }
    // Divided by the last place as complex numbers, times the length.
    let [x, y] = at;
    let scale = length / (x * x + y * y);
    places.iter().map(|[u, v]| [(u * x + v * y) * scale, (v * x - u * y) * scale]).collect()
}

/// A curve between the straight edge (0) and itself (1). All its steps lead forward in one direction, which the straight edge does, too, so it never crosses itself.
fn drawn_in(places: &[[f64; 2]], length: f64, share: f64) -> Vec<[f64; 2]> {
    let count = (places.len() - 1) as f64;
    places.iter().enumerate().map(|(i, [x, y])| [length * (i as f64 / count) * (1.0 - share) + x * share, y * share]).collect()
}

/// Refines all edges that different regions share, on the pool that it is called on; others stay straight. `smoothness` says how smooth the boundary of two regions is, 0 … 1.
///
/// An edge has ⌈length / spacing⌉ segments of at most two spacings. It depends on its ends, the seed, and on where other edges of the unrefined map lie.
#[must_use]
pub fn refine(topology: &Topology, smoothness: &(dyn Fn(usize, usize) -> f64 + Sync), refinement: Refinement) -> Refined {
    let index = index(&topology.edges);
    let one = |(number, edge): (usize, &super::MapEdge)| {
        let plain = (vec![edge.start, edge.end], false);
        let [Some(left), Some(right)] = edge.regions else { return plain };
        if topology.merged[left] == topology.merged[right] {
            return plain;
        }
        let along = [edge.end[0] - edge.start[0], edge.end[1] - edge.start[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let segments = (libm::ceil(length / refinement.spacing) as usize).clamp(1, MOST_SEGMENTS);
        if segments < 2 {
            return plain;
        }
        let envelope = Envelope::new(edge, number, &index, segments);
        let angles = angles(segments, smoothness(left, right).clamp(0.0, 1.0), seed_of(edge.start, edge.end, refinement.seed));
        let places = decoded(&angles, length);
        let mut share = 1.0;
        for _ in 0..TRIES {
            let curve = drawn_in(&places, length, share);
            if inside(&envelope, &curve) {
                return (placed(&curve, edge, along, length), false);
            }
            share *= SHRINK;
        }
        (plain.0, true)
    };
    let refined: Vec<(Vec<[f64; 2]>, bool)> = topology.edges.par_iter().enumerate().map(one).collect();
    let straight = refined.iter().filter(|(_, straight)| *straight).count();
    Refined { curves: refined.into_iter().map(|(curve, _)| curve).collect(), straight }
}

/// Whether a curve lies in its envelope; its ends do.
fn inside(envelope: &Envelope, curve: &[[f64; 2]]) -> bool {
    let last = curve.len() - 1;
    let place = |i: usize| match i {
        0 => [0.0, 0.0],
        i if i == last => [envelope.length, 0.0],
        i => curve[i],
    };
    (0..last).all(|i| envelope.holds(place(i), place(i + 1)))
}

/// A curve in the plane, its ends exactly those of the edge.
fn placed(curve: &[[f64; 2]], edge: &super::MapEdge, along: [f64; 2], length: f64) -> Vec<[f64; 2]> {
    let [east, north] = along.map(|c| c / length);
    let mut places: Vec<[f64; 2]> = curve.iter().map(|[x, y]| [edge.start[0] + (x * east - y * north), edge.start[1] + (x * north + y * east)]).collect();
    places[0] = edge.start;
    if let Some(last) = places.last_mut() {
        *last = edge.end;
    }
    places
}
