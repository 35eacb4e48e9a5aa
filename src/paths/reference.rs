//! What a drawing means, plainly: textbook searches over the whole frame, one stroke after the other.

use super::{
    blend::{Sums, smoothstep},
    plan::Plan,
    search::{Generator, Terrain},
};
use std::{cmp::Reverse, collections::BinaryHeap};

/// Cost and origin of every slot that a path reached (Dijkstra, Rusnell 2009, Algorithm 2). Labels settle in the order of (cost, slot); of equal ones the first origin's counts. A
/// slot from `ends` on is labelled, but leads nowhere.
fn search(terrain: &Terrain, generators: &[Generator], ends: &[f32]) -> Vec<Option<(f32, usize)>> {
    let frame = &terrain.weights.frame;
    let mut labels: Vec<Option<(f32, usize)>> = vec![None; frame.slots()];
    let mut settled = vec![false; frame.slots()];
    let mut open = BinaryHeap::new();
    let offer = |labels: &mut Vec<Option<(f32, usize)>>, open: &mut BinaryHeap<_>, slot: usize, cost: f32, origin: usize| {
        if labels[slot].is_none_or(|label| (cost, origin) < label) {
            labels[slot] = Some((cost, origin));
            open.push(Reverse((cost.to_bits(), slot)));
        }
    };
    for (origin, generator) in generators.iter().enumerate() {
        offer(&mut labels, &mut open, generator.slot as usize, generator.crest.cost, origin);
    }
    while let Some(Reverse((_, slot))) = open.pop() {
        let Some((cost, origin)) = labels[slot].filter(|_| !settled[slot]) else { continue };
        settled[slot] = true;
        if cost >= ends[slot] {
            continue;
        }
        let generator = &generators[origin];
        let costs = terrain.profile(slot, generator).after(cost, &generator.crest, &terrain.weights.of(slot));
        for (offset, cost) in frame.offsets().into_iter().zip(costs) {
            let to = slot.wrapping_add_signed(offset);
            if frame.slot(frame.node(to)).is_some() && !settled[to] {
                offer(&mut labels, &mut open, to, cost, origin);
            }
        }
    }
    labels
}

impl Plan {
    /// The heights that [`Plan::heights`] is held to, to the bit; of every slot, before waters are dug.
    #[must_use]
    pub(super) fn reference(&self) -> Vec<f32> {
        let (terrain, blending) = (self.terrain(), self.blending());
        let sea_level_cost = blending.sea_level_cost;
        let everywhere = vec![sea_level_cost; terrain.weights.frame.slots()];
        let heights = |member: Option<u16>| {
            let labels = search(&terrain, &self.generators(member), &everywhere);
            labels.into_iter().map(|label| label.map_or(0.0, |(cost, _)| (sea_level_cost - cost).max(0.0))).collect::<Vec<f32>>()
        };
        let mut approximate = heights(None);
        for region in self.shut_regions() {
            for (slot, height) in heights(Some(region)).into_iter().enumerate().filter(|(slot, _)| self.shut[*slot] == region) {
                approximate[slot] = height;
            }
        }
        let thresholds: Vec<f32> = approximate.iter().map(|height| blending.sea_threshold.max(blending.approximate_threshold * height)).collect();
        let ends: Vec<f32> = thresholds.iter().map(|threshold| sea_level_cost - threshold).collect();
        let mut sums = vec![Sums::default(); ends.len()];
        for stroke in &self.strokes {
            for (slot, label) in search(&terrain, &stroke.generators, &ends).into_iter().enumerate() {
                let counts = self.shut.get(slot).is_none_or(|region| *region == 0 || stroke.member_of.contains(region));
                let Some((cost, _)) = label.filter(|(cost, _)| counts && *cost < ends[slot]) else { continue };
                let height = sea_level_cost - cost;
                let share = smoothstep(thresholds[slot], 2.0 * thresholds[slot], height);
                if share > 0.0 {
                    sums[slot].add(height, share, blending.bias.of(slot));
                }
            }
        }
        sums.iter().map(|sums| sums.height(blending.sea_threshold)).collect()
    }
}
