//! Valleys cut into samples, around one corner of cells at a time.

use super::{
    HALF_WIDTH, KERNEL,
    network::{Around, Link},
};
use crate::noise::{Kernel, Lanes, SIDE};
use std::ops::Range;

/// Carves samples around one corner.
pub(super) struct Carve<'a> {
    pub around: &'a Around,
    pub xs: &'a [f32],
    pub ys: &'a [f32],
    pub heights: &'a mut [f32],
    pub lowering: &'a mut [f32],
    pub cut: f32,
    pub part: f32,
    pub faded: f32,
}

/// Samples are carved in groups of these, the last filled up: loops of whole vectors.
const GROUP: usize = 16;

/// Where no more are left than these, in one of these.
const FEW: usize = 8;

impl Kernel for Carve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, _: L) {
        let count = self.xs.len();
        for start in (0..count).step_by(GROUP) {
            let end = (start + GROUP).min(count);
            if end - start <= FEW {
                self.group::<FEW>(start..end);
            } else {
                self.group::<GROUP>(start..end);
            }
        }
    }
}

impl Carve<'_> {
    #[inline(always)]
    fn group<const N: usize>(&mut self, samples: Range<usize>) {
        let count = samples.len();
        let (xs, ys, heights) = (&self.xs[samples.clone()], &self.ys[samples.clone()], &mut self.heights[samples.clone()]);
        let (mut x, mut y, mut height) = ([xs[0]; N], [ys[0]; N], [heights[0]; N]);
        x[..count].copy_from_slice(xs);
        y[..count].copy_from_slice(ys);
        height[..count].copy_from_slice(heights);
        let slope = self.around.slopes(&x, &y);
        let lowest = self.around.lowest(&x, &y, &height, &slope.map(|slope| self.cut * slope));
        for i in 0..N {
            height[i] += self.part * (lowest[i] - height[i]);
        }
        for (lowering, slope) in self.lowering[samples].iter_mut().zip(slope) {
            *lowering += self.faded * slope;
        }
        heights.copy_from_slice(&height[..count]);
    }
}

/// Lowers what was carved, as far as the erosion is strong, by what stands for valleys that are left out.
pub(super) struct Lower<'a> {
    pub before: &'a [f32],
    pub lowering: &'a [f32],
    pub strength: f32,
    /// For samples in turn.
    pub swings: [f32; SIDE],
    pub floor: f32,
    pub heights: &'a mut [f32],
}

impl Kernel for Lower<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { before, lowering, strength, swings, floor, heights } = self;
        let swings: [f32; GROUP] = core::array::from_fn(|i| swings[i % SIDE]);
        let lower = |height: f32, before: f32, lowering: f32, swing: f32| {
            let carved = before + strength * (height - before);
            let lowered = carved - strength * swing * lowering;
            // Never up, where the floor is above what is carved by a rounding.
            let floor = if floor < carved { floor } else { carved };
            let lowered = if lowered < floor { floor } else { lowered };
            if lowering == 0.0 { carved } else { lowered }
        };
        for ((heights, before), lowering) in heights.chunks_mut(GROUP).zip(before.chunks(GROUP)).zip(lowering.chunks(GROUP)) {
            for (((height, &before), &lowering), swing) in heights.iter_mut().zip(before).zip(lowering).zip(swings) {
                *height = lower(*height, before, lowering, swing);
            }
        }
    }
}

impl Around {
    /// How steep the network is around samples, a pitch.
    #[inline(always)]
    fn slopes<const N: usize>(&self, x: &[f32; N], y: &[f32; N]) -> [f32; N] {
        let (mut sum, mut weights) = ([0.0; N], [0.0; N]);
        for &[node_x, node_y, slope] in &self.nodes {
            for i in 0..N {
                let (dx, dy) = (x[i] - node_x, y[i] - node_y);
                let near = at_least_0(1.0 - (dx * dx + dy * dy) * (1.0 / KERNEL));
                let weight = near * near;
                sum[i] += weight * slope;
                weights[i] += weight;
            }
        }
        core::array::from_fn(|i| sum[i] / weights[i])
    }

    /// The lowest that any valley leaves of samples; their beds lie `incision` below their links.
    #[inline(always)]
    fn lowest<const N: usize>(&self, x: &[f32; N], y: &[f32; N], height: &[f32; N], incision: &[f32; N]) -> [f32; N] {
        let mut lowest = *height;
        for link in &self.links {
            let Link { from, to: [ex, ey, ez], inverse_square, bend } = *link;
            for i in 0..N {
                let (px, py) = (x[i] - from.x, y[i] - from.y);
                let along = at_least_0((px * ex + py * ey) * inverse_square);
                let t = if along > 1.0 { 1.0 } else { along };
                let bow = bend * (t * (1.0 - t));
                let (dx, dy) = ((px - t * ex) + bow * ey, (py - t * ey) - bow * ex);
                let weight = at_least_0(1.0 - (dx * dx + dy * dy).sqrt() * (1.0 / HALF_WIDTH));
                let bed = (from.z + t * ez) - incision[i];
                let carved = height[i] - weight * at_least_0(height[i] - bed);
                lowest[i] = if carved < lowest[i] { carved } else { lowest[i] };
            }
        }
        lowest
    }
}

#[inline(always)]
fn at_least_0(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}
