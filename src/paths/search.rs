//! Searches: the least-cost paths from crests to all nodes around (Dijkstra).
//!
//! Costs are counted from the least cost of any generator, so that none is below 0 and their bits are in the order of their values.

use super::{
    lattice::{Frame, Weights},
    profile::{Crest, Scaling},
    queue::Queue,
};

/// Set in the origin of a label that may still get better.
const OPEN: u64 = 1 << 31;

/// A node that a search starts from. Searches take them in the order of their nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generator {
    /// Where it lies in the frame.
    pub slot: u32,
    /// The number of its profile.
    pub profile: u32,
    /// Its own cost, and sea level's beneath it.
    pub crest: Crest,
}

/// What searches of a frame share.
#[derive(Clone, Copy, Debug)]
pub struct Terrain<'a> {
    /// The weights of its edges.
    pub weights: &'a Weights,
    /// Profiles by number.
    pub profiles: &'a [Scaling],
    /// Of every slot one more than the number of the profile that rules in its region, or 0; empty without regions.
    pub regions: &'a [u16],
}

impl Terrain<'_> {
    /// The profile that shapes the steps out of a slot on paths from a generator.
    #[inline]
    pub(super) fn profile(&self, slot: usize, generator: &Generator) -> &Scaling {
        let own = generator.profile as usize;
        let number = if self.regions.is_empty() { own } else { usize::from(self.regions[slot]).checked_sub(1).unwrap_or(own) };
        &self.profiles[number]
    }

    /// The least cost of any step.
    #[must_use]
    pub fn least_step(&self) -> f32 {
        self.profiles.iter().map(Scaling::least).fold(f32::INFINITY, f32::min) * self.weights.least()
    }
}

/// What a search found of a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label {
    /// Where.
    pub slot: u32,
    /// The cost of its path.
    pub cost: f32,
}

/// A slot's label, bits of its cost above its origin, beside what the steps out of it weigh: all that a step needs lies together.
#[derive(Clone, Copy, Debug)]
struct Slot {
    label: u64,
    weights: [u16; 4],
}

/// Labels of the slots of a frame, and the room that searches need; kept from search to search.
#[derive(Debug)]
pub struct Search {
    slots: Vec<Slot>,
    limits: Vec<f32>,
    step: f32,
    queue: Queue,
    /// Slots of the bucket that is worked on.
    bucket: Vec<u32>,
    settled: Vec<Label>,
}

/// A slot and those to its west and east.
#[inline(always)]
fn three(slots: &[Slot], middle: usize) -> &[Slot; 3] {
    slots[middle - 1..].first_chunk().expect("the frame has a border")
}

/// The label that only lower costs replace.
fn limit_label(limit: f32) -> u64 {
    u64::from(limit.max(0.0).to_bits()) << 32
}

impl Search {
    /// For searches that label a slot only below its limit: [`limits`].
    #[must_use]
    pub fn new(terrain: &Terrain, limits: Vec<f32>) -> Self {
        let slots: Vec<Slot> =
            limits.iter().zip(&terrain.weights.values).map(|(limit, weights)| Slot { label: limit_label(*limit), weights: *weights }).collect();
        Self { slots, limits, step: terrain.least_step(), queue: Queue::default(), bucket: Vec::new(), settled: Vec::new() }
    }

    /// Without room for any slot.
    pub(super) fn empty(step: f32) -> Self {
        Self { slots: Vec::new(), limits: Vec::new(), step, queue: Queue::default(), bucket: Vec::new(), settled: Vec::new() }
    }

    /// Makes it ready for a window of a terrain whose south-western slot, of the border around it, is number `origin` of the terrain's. No label may leave the window.
    pub(super) fn fit(&mut self, terrain: &Terrain, limits: &[f32], origin: usize, window: Frame) {
        let stride = terrain.weights.frame.stride();
        self.settled.clear();
        self.slots.clear();
        for row in 0..window.rows + 2 {
            let from = origin + row * stride;
            let weights = &terrain.weights.values[from..from + window.stride()];
            let first = self.slots.len();
            self.slots.extend(
                limits[from..from + window.stride()].iter().zip(weights).map(|(limit, weights)| Slot { label: limit_label(*limit), weights: *weights }),
            );
            let border = if row == 0 || row == window.rows + 1 { first..self.slots.len() } else { first..first + 1 };
            self.slots[border].iter_mut().for_each(|slot| slot.label = 0);
            if let Some(last) = self.slots.last_mut() {
                last.label = 0;
            }
        }
    }

    /// Labels all that paths from the generators reach below the limits, in the order (cost, row, column): only a settled label leads on, and of two equal ones that of the first
    /// generator counts. The labels stay until the next search.
    pub fn run(&mut self, terrain: &Terrain, generators: &[Generator], sea_level_cost: f32) -> &[Label] {
        if self.queue.clear(sea_level_cost, self.step) {
            self.settle::<true>(terrain, generators);
        } else {
            self.settle::<false>(terrain, generators);
        }
        &self.settled
    }

    fn settle<const FINE: bool>(&mut self, terrain: &Terrain, generators: &[Generator]) {
        for (number, generator) in generators.iter().enumerate() {
            self.offer::<FINE>(generator.slot as usize, u64::from(generator.crest.cost.to_bits()) << 32 | OPEN | number as u64);
        }
        if FINE {
            let mut bucket = core::mem::take(&mut self.bucket);
            while self.queue.take(&mut bucket) {
                for (i, slot) in bucket.iter().enumerate() {
                    if let Some(next) = bucket.get(i + 1) {
                        self.touch(*next as usize, terrain.weights.frame.stride());
                    }
                    self.lead_on::<FINE>(terrain, generators, *slot);
                }
            }
            self.bucket = bucket;
        } else {
            while let Some(slot) = self.queue.pop(|slot| f32::from_bits((self.slots[slot as usize].label >> 32) as u32)) {
                self.lead_on::<FINE>(terrain, generators, slot);
            }
        }
    }

    /// Has what a slot's steps need brought near while the one before it is worked on.
    #[inline(always)]
    fn touch(&self, at: usize, stride: usize) {
        for slot in [at - stride, at, at + stride] {
            core::hint::black_box(self.slots[slot].label);
        }
    }

    /// Settles a slot, unless it is, and labels those around it that this betters.
    #[inline(always)]
    fn lead_on<const FINE: bool>(&mut self, terrain: &Terrain, generators: &[Generator], slot: u32) {
        let rule = &terrain.weights.rule;
        let (stride, offsets) = (terrain.weights.frame.stride(), terrain.weights.frame.offsets());
        let at = slot as usize;
        let label = self.slots[at].label;
        if label & OPEN == 0 {
            return;
        }
        self.slots[at].label = label ^ OPEN;
        let [south, here, north] = [at - stride, at, at + stride].map(|middle| three(&self.slots, middle));
        let cost = f32::from_bits((label >> 32) as u32);
        let generator = &generators[(label & (OPEN - 1)) as usize];
        let weights = rule.weights([south[0].weights, south[1].weights, south[2].weights, here[0].weights, here[1].weights]);
        let costs = terrain.profile(at, generator).after(cost, &generator.crest, &weights);
        let labels = costs.map(|cost| u64::from(cost.to_bits()) << 32 | label & 0xffff_ffff);
        let present = [south[0].label, south[1].label, south[2].label, here[0].label, here[2].label, north[0].label, north[1].label, north[2].label];
        let mut better = (0..8).fold(0_u32, |better, k| better | u32::from(labels[k] < present[k]) << k);
        self.settled.push(Label { slot, cost });
        while better != 0 {
            let k = better.trailing_zeros() as usize;
            better &= better - 1;
            let to = at.wrapping_add_signed(offsets[k]);
            self.slots[to].label = labels[k];
            self.queue.push::<FINE>(costs[k], to as u32);
        }
    }

    /// Labels a slot if that betters what it has.
    fn offer<const FINE: bool>(&mut self, slot: usize, label: u64) {
        if label < self.slots[slot].label {
            self.slots[slot].label = label;
            self.queue.push::<FINE>(f32::from_bits((label >> 32) as u32), slot as u32);
        }
    }

    /// The cost of a slot's path and the number of the generator it comes from; `None` where no path arrived.
    #[must_use]
    pub fn label(&self, slot: u32) -> Option<(f32, u32)> {
        let label = self.slots[slot as usize].label;
        let (cost, origin) = (f32::from_bits((label >> 32) as u32), label as u32);
        (cost < self.limits[slot as usize]).then_some((cost, origin))
    }

    /// The slot before a settled one on its path: the first of its neighbours whose step leads to just its label.
    #[must_use]
    pub fn before(&self, terrain: &Terrain, generators: &[Generator], slot: u32) -> Option<u32> {
        let (cost, origin) = self.label(slot)?;
        let generator = &generators[origin as usize];
        terrain.weights.frame.offsets().into_iter().enumerate().find_map(|(step, offset)| {
            let from = (slot as usize).wrapping_add_signed(-offset);
            let (before, same) = self.label(from as u32)?;
            let after = || terrain.profile(from, generator).after(before, &generator.crest, &terrain.weights.of(from))[step];
            (same == origin && after() == cost).then_some(from as u32)
        })
    }
}

/// Of every slot the cost below which it is labelled: 0 on the frame's border.
#[must_use]
pub fn limits(frame: &Frame, limit: impl Fn(usize) -> f32) -> Vec<f32> {
    let mut limits = vec![0.0; frame.slots()];
    for slot in frame.rows_of_slots().flatten() {
        limits[slot] = limit(slot);
    }
    limits
}
