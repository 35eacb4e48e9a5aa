//! The one search of a shadow picture: from all generators down their flanks, never above what light allows.

use super::super::lattice::Weights;
use crate::geometry::Stop;
use std::{cmp::Reverse, collections::BinaryHeap};

/// Labels that are settled between two looks at the stop.
const STRIDE: u64 = 4096;

/// What a generator is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Casts a wanted shadow, or holds a hole up into the light.
    Primary,
    /// Makes a landscape of it, and casts none.
    Secondary,
}

/// A generator: where paths begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Source {
    pub slot: u32,
    /// Metres.
    pub height: f32,
    /// Its profile, which is constant: what weights of edges count on paths from it.
    pub scale: f32,
    pub kind: Kind,
}

/// Bits of a cost, slot, kind, bits of a scale.
type Entry = (u32, u32, Kind, u32);

/// Of every slot the height of the least-cost path that arrives there, -∞ where none does above `floor`; and how many labels were settled. A label is never higher than the bound of its
/// slot and kind, and goes on from there. Labels settle from the highest down, of equal ones in the order of slots, kinds and scales. Stopped, it is not whole.
pub(super) fn climb(weights: &Weights, sources: &[Source], upper: impl Fn(usize, Kind) -> f32, floor: f32, stop: &Stop) -> (Vec<f32>, u64) {
    let top = sources.iter().map(|source| source.height).fold(f32::NEG_INFINITY, f32::max);
    let mut costs = vec![f32::INFINITY; weights.frame.slots()];
    let mut open: BinaryHeap<Reverse<Entry>> = BinaryHeap::new();
    let most = top - floor;
    let offer = |open: &mut BinaryHeap<_>, costs: &mut [f32], cost: f32, slot: usize, kind: Kind, scale: u32| {
        let cost = cost.max(top - upper(slot, kind));
        if cost < costs[slot] && cost < most {
            costs[slot] = cost;
            // Costs and scales are not below 0: their bits are in the order of their values.
            open.push(Reverse((cost.to_bits(), slot as u32, kind, scale)));
        }
    };
    for source in sources {
        offer(&mut open, &mut costs, (top - source.height).max(0.0), source.slot as usize, source.kind, source.scale.to_bits());
    }
    let offsets = weights.frame.offsets();
    let mut settled = 0;
    while let Some(Reverse((bits, slot, kind, scale))) = open.pop() {
        let (cost, at) = (f32::from_bits(bits), slot as usize);
        if cost > costs[at] {
            continue;
        }
        settled += 1;
        if settled % STRIDE == 0 && stop.is_set() {
            break;
        }
        for (offset, weight) in offsets.into_iter().zip(weights.of(at)) {
            offer(&mut open, &mut costs, cost + weight * f32::from_bits(scale), at.wrapping_add_signed(offset), kind, scale);
        }
    }
    (costs.into_iter().map(|cost| top - cost).collect(), settled)
}
