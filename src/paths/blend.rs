//! The blend of strokes: from their heights at a node to the terrain's (Rusnell 2009, Eq. 3.7, with fades where searches end; they reach 0 just there, so that no step is left).

use super::{
    search::{Generator, Label, Search, Terrain, limits},
    stroke_search::StrokeSearch,
};
use crate::{geometry::Stop, noise::elementary};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Strokes that are searched before they are blended.
const BATCH: usize = 64;

/// How much the higher of two strokes counts: 0 gives their mean, much their maximum.
#[derive(Clone, Copy, Debug)]
pub enum Bias<'a> {
    /// The same everywhere.
    Constant(f32),
    /// Of every slot.
    Slots(&'a [f32]),
}

impl Bias<'_> {
    #[inline]
    pub(super) fn of(&self, slot: usize) -> f32 {
        match self {
            Self::Constant(bias) => *bias,
            Self::Slots(biases) => biases[slot],
        }
    }
}

/// When searches end, and how strokes are blended.
#[derive(Clone, Copy, Debug)]
pub struct Blending<'a> {
    /// The cost of sea level.
    pub sea_level_cost: f32,
    /// A stroke's search ends where it is no higher than this …
    pub sea_threshold: f32,
    /// … or than this share of the approximate height there.
    pub approximate_threshold: f32,
    /// How much the higher counts.
    pub bias: Bias<'a>,
}

/// A connected feature: what its search starts from, and where it counts.
#[derive(Clone, Debug, Default)]
pub struct Stroke {
    /// In the order of their slots.
    pub generators: Vec<Generator>,
    /// Regions, by number, that count it although others are shut out; in ascending order.
    pub member_of: Vec<u16>,
}

/// How many nodes the strokes' searches settled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Settled {
    /// Of all strokes together.
    pub nodes: u64,
    /// Of the widest one.
    pub most: u64,
}

/// Of every slot the height above sea level of the one search from all generators, 0 where none arrives (the approximate field).
#[must_use]
pub fn approximate(terrain: &Terrain, generators: &[Generator], sea_level_cost: f32) -> Vec<f32> {
    let mut search = Search::new(terrain, limits(&terrain.weights.frame, |_| sea_level_cost));
    let mut heights = vec![0.0; terrain.weights.frame.slots()];
    for label in search.run(terrain, generators, sea_level_cost) {
        heights[label.slot as usize] = sea_level_cost - label.cost;
    }
    heights
}

/// Rises from 0 at `a` to 1 at `b`, level at both.
#[inline]
pub(super) fn smoothstep(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Whole powers by multiplication, others by the elementary functions.
#[inline]
fn power(x: f32, exponent: f32) -> f32 {
    let whole = exponent as u32;
    if whole as f32 == exponent && whole < 32 {
        let (mut result, mut base, mut left) = (1.0, x, whole);
        while left > 0 {
            if left & 1 == 1 {
                result *= base;
            }
            base *= base;
            left >>= 1;
        }
        result
    } else {
        elementary::pow(x, exponent)
    }
}

/// Sums at a slot, relative to the highest stroke so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    most: f32,
    upper: f32,
    lower: f32,
}

impl Sums {
    #[inline]
    pub(super) fn add(&mut self, height: f32, share: f32, bias: f32) {
        if height > self.most {
            let ratio = self.most / height;
            let power = power(ratio, bias);
            *self = Self { most: height, upper: self.upper * (power * ratio) + share, lower: self.lower * power + share };
        } else {
            let ratio = height / self.most;
            let power = power(ratio, bias) * share;
            self.upper += power * ratio;
            self.lower += power;
        }
    }

    pub(super) fn height(&self, sea_threshold: f32) -> f32 {
        if self.lower > 0.0 { self.most * (self.upper / self.lower) * smoothstep(sea_threshold, 2.0 * sea_threshold, self.most) } else { 0.0 }
    }
}

/// What a frame's strokes are blended with: the approximate heights, and regions that shut strokes out.
#[derive(Debug)]
pub struct Blender<'a> {
    terrain: Terrain<'a>,
    blending: Blending<'a>,
    /// Of every slot the height up to which a stroke does not count.
    ends: Vec<f32>,
    limits: Vec<f32>,
    /// Least cost of a step.
    step: f32,
    /// Of every slot the number of the region that counts its members only, or 0; empty without such.
    shut: &'a [u16],
}

impl<'a> Blender<'a> {
    /// With the approximate heights of the slots; `shut` tells which slots count only the members of a region.
    #[must_use]
    pub fn new(terrain: Terrain<'a>, blending: Blending<'a>, approximate: &[f32], shut: &'a [u16]) -> Self {
        let ends: Vec<f32> = approximate.iter().map(|height| blending.sea_threshold.max(blending.approximate_threshold * height)).collect();
        let limits = limits(&terrain.weights.frame, |slot| blending.sea_level_cost - ends[slot]);
        Self { step: terrain.least_step(), terrain, blending, ends, limits, shut }
    }

    /// Up to which height a stroke does not count in a slot.
    #[cfg(test)]
    pub(super) fn end(&self, slot: usize) -> f32 {
        self.ends[slot]
    }

    /// What a stroke's search finds.
    #[cfg(test)]
    pub(super) fn labels(&self, stroke: &Stroke) -> Vec<Label> {
        self.search(stroke, &Mutex::default())
    }

    /// Of every slot the height above sea level, strokes blended in their order; `done` hears after every batch how many are.
    ///
    /// Stopped, it is not whole.
    #[must_use]
    pub fn heights(&self, strokes: &[Stroke], stop: &Stop, done: &(dyn Fn(usize) + Sync)) -> (Vec<f32>, Settled) {
        let frame = &self.terrain.weights.frame;
        // Every thread blends a band of slots.
        let band = frame.slots().div_ceil(rayon::current_num_threads());
        let mut sums = vec![Sums::default(); frame.slots()];
        let mut settled = Settled::default();
        let idle: Mutex<Vec<StrokeSearch>> = Mutex::default();
        for (number, batch) in strokes.chunks(BATCH).enumerate() {
            let search = |stroke: &Stroke| if stop.is_set() { Vec::new() } else { self.search(stroke, &idle) };
            let found: Vec<Vec<Label>> = batch.par_iter().map(search).collect();
            for labels in &found {
                settled.nodes += labels.len() as u64;
                settled.most = settled.most.max(labels.len() as u64);
            }
            sums.par_chunks_mut(band).enumerate().for_each(|(number, sums)| {
                for (labels, stroke) in found.iter().zip(batch) {
                    self.add(sums, number * band, labels, stroke);
                }
            });
            done((number * BATCH + batch.len()).min(strokes.len()));
            if stop.is_set() {
                break;
            }
        }
        (sums.iter().map(|sums| sums.height(self.blending.sea_threshold)).collect(), settled)
    }

    /// The labels of a stroke.
    fn search(&self, stroke: &Stroke, idle: &Mutex<Vec<StrokeSearch>>) -> Vec<Label> {
        let taken = idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut search = taken.unwrap_or_else(|| StrokeSearch::new(self.step));
        let labels = search.labels(&self.terrain, &self.limits, &stroke.generators, self.blending.sea_level_cost);
        idle.lock().unwrap_or_else(PoisonError::into_inner).push(search);
        labels
    }

    /// Adds a stroke's labels to the sums of a band that starts at a slot; others are not its own.
    fn add(&self, sums: &mut [Sums], first: usize, labels: &[Label], stroke: &Stroke) {
        let blending = &self.blending;
        for label in labels {
            let slot = label.slot as usize;
            let Some(sums) = slot.checked_sub(first).and_then(|own| sums.get_mut(own)) else { continue };
            if let Some(&region @ 1..) = self.shut.get(slot)
                && stroke.member_of.binary_search(&region).is_err()
            {
                continue;
            }
            let (height, end) = (blending.sea_level_cost - label.cost, self.ends[slot]);
            let share = smoothstep(end, 2.0 * end, height);
            if share > 0.0 {
                sums.add(height, share, blending.bias.of(slot));
            }
        }
    }
}
