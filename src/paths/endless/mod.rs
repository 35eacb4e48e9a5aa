//! Endless drawings: the plane divided into cells, each with strokes of its own out of a hash.
//!
//! A stroke's costs follow from itself alone: its search covers all that its paths can reach ([`Endless::reach`]), whoever asks for what part of it. What is approximate height in a finite
//! drawing is here the height of the highest stroke, and a stroke fades out under it without its search being cut. So a chunk needs the strokes that reach it and nothing else, and
//! chunks of any size, in any order, on any number of threads have the same bits. Strokes and chunks are kept in bounded maps, which decide about time alone.
//!
//! Samples farther apart than [`NEAR`] nodes see lattices of doubled spacing with weights and profiles as many a metre, fading from one to the next by spacing alone; where a sample takes
//! in a good part of a cell there is the layer's mean height and no stroke is asked.

mod document;
mod patch;
mod place;
#[cfg(test)]
mod tests;

use super::{
    blend::{Sums, smoothstep},
    document::DrawingError,
    lattice::{Frame, Node},
    profile::Scaling,
};
use crate::{
    geometry::{Filter, RasterLevel, Stop, Window, coarseness},
    noise,
};
pub use document::{CellStrokes, Chains, EndlessDrawing, Rings};
use lru::LruCache;
use patch::Patch;
use place::{Place, Rule};
use std::{
    num::NonZeroUsize,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

/// Nodes of a chunk along each axis.
const CHUNK: usize = 64;

/// Bytes of strokes that are kept, about, and most of them.
const KEPT_BYTES: f64 = 128e6;
const KEPT_PATCHES: f64 = 1024.0;

/// Most nodes that a stroke's search may have to go over.
const MOST_SEARCHED: f64 = 4_194_304.0;

/// Chunks that are kept.
const KEPT_CHUNKS: NonZeroUsize = NonZeroUsize::new(2048).expect("not 0");

/// Halvings by which samples see a lattice before they see the next one.
const NEAR: usize = 1;

/// Halvings of the last lattice, at which nothing but the mean is left.
const MOST_HALVINGS: usize = 5;

/// Cells a sample at which strokes begin to fade into the layer's mean, and at which nothing else is left.
const CONSTANT: [f64; 2] = [0.06, 0.24];

/// Cells along each axis that the mean is taken over, and nodes a cell.
const MEAN_CELLS: i64 = 6;
const MEAN_NODES: f64 = 24.0;

/// Nanoseconds to settle a node, to blend one, and to evaluate a sample.
const NODE_NS: f64 = 110.0;
const BLEND_NS: f64 = 25.0;
const SAMPLE_NS: f64 = 110.0;

/// A lattice of an endless drawing: how its strokes look on nodes so far apart.
#[derive(Debug)]
struct Mesh {
    spacing: f64,
    mean: f32,
    deviation: f32,
    key: u64,
    scalings: Vec<Scaling>,
    reach: usize,
}

/// Heights by lattice and place.
type Chunks = LruCache<(usize, [i64; 2]), Arc<[f32]>>;

type Kept<K, V> = Mutex<LruCache<K, Arc<OnceLock<V>>>>;

/// What was kept under a key, or is made now. Whoever asks for what another makes waits for it.
fn kept<K: core::hash::Hash + Eq, V: Clone>(map: &Kept<K, V>, key: K, make: impl FnOnce() -> V) -> V {
    let once = Arc::clone(map.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(key, Arc::default));
    once.get_or_init(make).clone()
}

/// Terrain by path costs without end: metres above what is beneath.
#[derive(Debug)]
pub struct Endless {
    drawing: EndlessDrawing,
    rules: Vec<Rule>,
    meshes: Vec<Mesh>,
    mean: f32,
    /// Metres beyond its cell that a stroke can lie, and metres that its paths can reach.
    beyond: f64,
    reach: f64,
    /// Nodes that a stroke's search settles on the finest lattice, about, and strokes a cell.
    settled: f64,
    strokes: f64,
    patches: Kept<(usize, [i64; 2], u32), Arc<Patch>>,
    chunks: Mutex<Chunks>,
}

impl Endless {
    /// Checks a drawing and measures it; `seed` takes the place of its own.
    ///
    /// # Errors
    /// If a number, programme or name in it is not what it must be, its strokes may reach more than [`super::MAX_REACH`] nodes, or there would be too many of them.
    pub fn new(drawing: EndlessDrawing, seed: u64) -> Result<Self, DrawingError> {
        drawing.check()?;
        let drawing = EndlessDrawing { seed, ..drawing };
        let rules = drawing.rules()?;
        let meshes = drawing.meshes(&rules)?;
        let beyond = rules.iter().map(Rule::beyond).fold(0.0, f64::max);
        let across = (1.5 * beyond.max(drawing.spacing) / drawing.spacing) + 2.0 * meshes[0].reach as f64;
        if across * across > MOST_SEARCHED {
            let detail = format!(
                "a stroke with all that it may reach is {across:.0} nodes across, {:.0} are the most: make strokes shorter, profiles less wide or the spacing greater",
                libm::sqrt(MOST_SEARCHED)
            );
            return Err(DrawingError::new("/strokes", detail));
        }
        let reach = meshes.iter().map(|mesh| mesh.reach as f64 * mesh.spacing).fold(0.0, f64::max);
        let mut endless = Self {
            strokes: rules.iter().map(Rule::expected).sum(),
            drawing,
            rules,
            meshes,
            mean: 0.0,
            beyond,
            reach,
            settled: 0.0,
            patches: Mutex::new(LruCache::new(NonZeroUsize::MIN)),
            chunks: Mutex::new(LruCache::new(KEPT_CHUNKS)),
        };
        endless.measure();
        Ok(endless)
    }

    /// Finds the mean height, and how far searches go.
    fn measure(&mut self) {
        let cell = self.drawing.cell;
        let level = (0..self.meshes.len()).find(|level| self.meshes[*level].spacing * MEAN_NODES >= cell).unwrap_or(self.meshes.len() - 1);
        let nodes = (cell / self.meshes[level].spacing * MEAN_CELLS as f64) as usize;
        let heights = self.heights(level, &Frame { first: Node { row: 0, column: 0 }, columns: nodes, rows: nodes }, &Stop::never());
        let sum: f64 = heights.iter().map(|height| f64::from(*height)).sum();
        self.mean = (sum / heights.len().max(1) as f64) as f32;
        let (mut settled, mut strokes) = (0, 0);
        for i in 0..4 {
            for place in self.places([i, 0]) {
                settled += self.patch(level, &place).settled();
                strokes += 1;
            }
        }
        let ratio = self.meshes[level].spacing / self.meshes[0].spacing;
        self.settled = settled as f64 / f64::from(strokes.max(1)) * ratio * ratio;
        // What is kept of a stroke is the rectangle around the nodes that it settled.
        let kept = (KEPT_BYTES / (self.settled * 6.0).max(1.0)).clamp(8.0, KEPT_PATCHES);
        self.patches = Mutex::new(LruCache::new(NonZeroUsize::new(kept as usize).unwrap_or(NonZeroUsize::MIN)));
    }

    /// Most steps of a path on the finest lattice.
    #[must_use]
    pub fn reach(&self) -> usize {
        self.meshes[0].reach
    }

    /// The greatest height there can be.
    #[must_use]
    pub fn highest(&self) -> f32 {
        self.rules.iter().map(|rule| self.drawing.sea_level_cost as f32 - rule.costs[0]).fold(0.0, f32::max)
    }

    /// The strokes of a cell.
    fn places(&self, cell: [i64; 2]) -> Vec<Place> {
        let key = cell.into_iter().fold(noise::key(self.drawing.seed, 4), |key, i| noise::key(key, i as u64));
        let mut places = Vec::new();
        for (number, rule) in self.rules.iter().enumerate() {
            rule.place(number, cell, self.drawing.cell, noise::key(key, number as u64), &mut places);
        }
        for (number, place) in places.iter_mut().enumerate() {
            place.number = number as u32;
        }
        places
    }

    fn patch(&self, level: usize, place: &Place) -> Arc<Patch> {
        kept(&self.patches, (level, place.cell, place.number), || {
            let rule = &self.rules[place.rule];
            Arc::new(Patch::new(&self.meshes[level], self.drawing.diagonal, self.drawing.sea_level_cost as f32, place, rule))
        })
    }

    /// The heights of a frame of a lattice, row by row from the south. Stopped, they are not whole.
    fn heights(&self, level: usize, frame: &Frame, stop: &Stop) -> Vec<f32> {
        let mesh = &self.meshes[level];
        let halo = self.beyond + mesh.reach as f64 * mesh.spacing;
        let cells = |first: i64, count: usize| {
            let at = |node: i64, halo: f64| ((node as f64 * mesh.spacing + halo) / self.drawing.cell).floor() as i64;
            at(first, -halo)..=at(first + count as i64 - 1, halo)
        };
        let mut patches = Vec::new();
        for row in cells(frame.first.row, frame.rows) {
            for column in cells(frame.first.column, frame.columns) {
                for place in self.places([column, row]) {
                    if place.meets(frame, mesh) && !stop.is_set() {
                        patches.push(self.patch(level, &place));
                    }
                }
            }
        }
        self.blend(&patches, frame)
    }

    /// The blend of strokes, in their order, over a frame.
    fn blend(&self, patches: &[Arc<Patch>], frame: &Frame) -> Vec<f32> {
        let (drawing, nodes) = (&self.drawing, frame.columns * frame.rows);
        let sea_level_cost = drawing.sea_level_cost as f32;
        // Which stroke's outline a node lies inside, the last one's that shuts others out; 0 for none.
        let mut inside = vec![0_u32; nodes];
        for (number, patch) in patches.iter().enumerate() {
            patch.inside(frame, |node| inside[node] = number as u32 + 1);
        }
        let counts = |number: usize, node: usize| inside[node] == 0 || inside[node] == number as u32 + 1;
        let mut highest = vec![0.0_f32; nodes];
        for (number, patch) in patches.iter().enumerate() {
            patch.costs(frame, |node, cost| {
                if counts(number, node) {
                    highest[node] = highest[node].max(sea_level_cost - cost);
                }
            });
        }
        let (sea_threshold, share) = (drawing.sea_threshold as f32, drawing.approximate_threshold as f32);
        let mut sums = vec![Sums::default(); nodes];
        for (number, patch) in patches.iter().enumerate() {
            patch.costs(frame, |node, cost| {
                if counts(number, node) {
                    let end = sea_threshold.max(share * highest[node]);
                    let (height, bias) = (sea_level_cost - cost, drawing.bias as f32);
                    let share = smoothstep(end, 2.0 * end, height);
                    if share > 0.0 {
                        sums[node].add(height, share, bias);
                    }
                }
            });
        }
        sums.iter().map(|sums| sums.height(sea_threshold) * drawing.vertical_scale as f32).collect()
    }

    fn chunk(&self, level: usize, [i, j]: [i64; 2], stop: &Stop) -> Arc<[f32]> {
        let chunks = || self.chunks.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(chunk) = chunks().get(&(level, [i, j])) {
            return Arc::clone(chunk);
        }
        let first = Node { row: j * CHUNK as i64, column: i * CHUNK as i64 };
        let chunk: Arc<[f32]> = self.heights(level, &Frame { first, columns: CHUNK, rows: CHUNK }, stop).into();
        // What was stopped is not whole and must not be kept.
        if !stop.is_set() {
            chunks().put((level, [i, j]), Arc::clone(&chunk));
        }
        chunk
    }

    /// Which nodes of a lattice interpolation between `from` and `to` (metres) touches after so many halvings.
    fn touched(&self, level: usize, halvings: usize, from: [f64; 2], to: [f64; 2]) -> Frame {
        let step = self.meshes[level].spacing;
        let margin = 3 << halvings;
        let node = |c: f64| (c / step).floor() as i64;
        let (first, last) = (from.map(|c| node(c) - margin), to.map(|c| node(c) + margin + 1));
        Frame { first: Node { row: first[1], column: first[0] }, columns: (last[0] - first[0] + 1) as usize, rows: (last[1] - first[1] + 1) as usize }
    }

    /// The nodes of a lattice that interpolation between `from` and `to` (metres) touches, out of chunks, halved so many times.
    fn nodes(&self, level: usize, halvings: usize, from: [f64; 2], to: [f64; 2], stop: &Stop) -> RasterLevel {
        let frame = self.touched(level, halvings, from, to);
        let first = [frame.first.column, frame.first.row];
        let last = [first[0] + frame.columns as i64 - 1, first[1] + frame.rows as i64 - 1];
        let mut values = vec![0.0; frame.columns * frame.rows];
        let chunk = CHUNK as i64;
        for j in first[1].div_euclid(chunk)..=last[1].div_euclid(chunk) {
            for i in first[0].div_euclid(chunk)..=last[0].div_euclid(chunk) {
                if stop.is_set() {
                    break;
                }
                let heights = self.chunk(level, [i, j], stop);
                for row in (j * chunk).max(first[1])..=((j + 1) * chunk - 1).min(last[1]) {
                    let (west, east) = ((i * chunk).max(first[0]), ((i + 1) * chunk - 1).min(last[0]));
                    let source = &heights[((row - j * chunk) * chunk + west - i * chunk) as usize..][..(east - west + 1) as usize];
                    let to = (row - first[1]) as usize * frame.columns + (west - first[0]) as usize;
                    values[to..to + source.len()].copy_from_slice(source);
                }
            }
        }
        let mut nodes = RasterLevel::new([frame.first.column, frame.first.row], frame.columns, frame.rows, values);
        for _ in 0..halvings {
            nodes = nodes.halved();
        }
        nodes
    }

    /// The lattice that a step of detail is made from.
    fn level(&self, step: usize) -> usize {
        step.saturating_sub(NEAR).min(self.meshes.len() - 1)
    }

    /// Which steps of detail samples so far apart see, how much of the second, and how much of the mean.
    fn detail(&self, spacing: f64, filter: Filter) -> ([usize; 2], f32, f32) {
        if filter == Filter::Exact {
            return ([0, 0], 0.0, 0.0);
        }
        let cells = spacing / self.drawing.cell;
        let constant = smoothstep(CONSTANT[0] as f32, CONSTANT[1] as f32, cells as f32);
        let ratio = (spacing / self.meshes[0].spacing).max(1.0);
        let last = self.meshes.len() + MOST_HALVINGS;
        match (0..last).find(|step| ratio < coarseness(step + 1)) {
            Some(step) => ([step, step + 1], (ratio / coarseness(step) - 1.0) as f32, constant),
            None => ([last, last], 0.0, constant),
        }
    }

    /// Adds the heights over a window to `out`, row by row from the north. Stopped, it is not whole.
    pub fn add(&self, window: &Window, stop: &Stop, out: &mut [f32]) {
        let (steps, share, constant) = self.detail(window.spacing(), window.filter);
        if constant >= 1.0 {
            for out in out {
                *out += self.mean;
            }
            return;
        }
        let bounds = window.bounds();
        let used = &steps[..if share > 0.0 { 2 } else { 1 }];
        let seen = |step: &usize| {
            let level = self.level(*step);
            let halvings = step - level;
            let spacing = self.meshes[level].spacing * coarseness(halvings);
            let columns: Vec<(i64, f32)> = window.columns.coordinates().map(|x| RasterLevel::place(x, spacing)).collect();
            (spacing, columns, self.nodes(level, halvings, bounds.min, bounds.max, stop))
        };
        let levels: Vec<_> = used.iter().map(seen).collect();
        let mut rows = [Vec::new(), Vec::new()];
        for (y, out) in window.rows.coordinates().zip(out.chunks_mut(window.columns.len())) {
            if stop.is_set() {
                return;
            }
            for ((spacing, columns, nodes), row) in levels.iter().zip(&mut rows) {
                nodes.row(RasterLevel::place(y, *spacing), columns, row);
            }
            for (i, out) in out.iter_mut().enumerate() {
                let mut height = rows[0][i];
                if share > 0.0 {
                    height += (rows[1][i] - height) * share;
                }
                *out += height + (self.mean - height) * constant;
            }
        }
    }

    /// The predicted time to evaluate a window on one thread when nothing of it is known yet, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        let (steps, share, constant) = self.detail(window.spacing(), window.filter);
        let samples = SAMPLE_NS * window.samples() as f64;
        if constant >= 1.0 {
            return samples;
        }
        let bounds = window.bounds();
        let used = if share > 0.0 { 2 } else { 1 };
        let of = |step: &usize| {
            let mesh = &self.meshes[self.level(*step)];
            let sides = [0, 1].map(|axis| bounds.max[axis] - bounds.min[axis] + 2.0 * CHUNK as f64 * mesh.spacing);
            let strokes = sides.map(|side| (side + self.reach) / self.drawing.cell).iter().product::<f64>() * self.strokes;
            let finer = self.meshes[0].spacing / mesh.spacing;
            let nodes_of_cell = (self.drawing.cell / self.meshes[0].spacing) * (self.drawing.cell / self.meshes[0].spacing);
            let overlap = self.settled * self.strokes / nodes_of_cell;
            let nodes = sides.map(|side| side / mesh.spacing).iter().product::<f64>();
            strokes * self.settled * finer * finer * NODE_NS + nodes * (1.0 + overlap) * BLEND_NS
        };
        samples + steps[..used].iter().map(of).sum::<f64>()
    }
}
