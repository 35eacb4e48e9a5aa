//! The heights of a generation in the plane.

use super::{blocks::Blocks, settings::Ground};
use crate::geometry::{Filter, Legend, Rectangle, Source, Stop, Surface, Window};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// Nanoseconds to evaluate a sample between nodes, in one level and in two.
const SAMPLE_NS: [f64; 2] = [60.0, 110.0];

/// A lattice of heights, row by row from the south. Beyond its borders it goes on as it is there.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    columns: usize,
    rows: usize,
    heights: Arc<[f32]>,
    blocks: Arc<Blocks>,
}

impl Level {
    fn new(columns: usize, rows: usize, heights: Arc<[f32]>) -> Self {
        Self { columns, rows, blocks: Arc::new(Blocks::of(columns, &heights)), heights }
    }

    fn at(&self, column: i64, row: i64) -> f32 {
        let inside = |i: i64, count: usize| i.clamp(0, count as i64 - 1) as usize;
        self.heights[inside(row, self.rows) * self.columns + inside(column, self.columns)]
    }

    /// Every second node, each with its neighbours by 1 : 2 : 1 along both axes.
    fn halved(&self) -> Self {
        let (columns, rows) = (self.columns.div_ceil(2), self.rows.div_ceil(2));
        let node = |i: usize| {
            let (column, row) = (2 * (i % columns) as i64, 2 * (i / columns) as i64);
            let three = |row: i64| self.at(column - 1, row) + 2.0 * self.at(column, row) + self.at(column + 1, row);
            (three(row - 1) + 2.0 * three(row) + three(row + 1)) * (1.0 / 16.0)
        };
        Self::new(columns, rows, (0..columns * rows).map(node).collect())
    }

    fn between(&self, (column, s): (i64, f32), (row, t): (i64, f32)) -> f32 {
        let along = |row: i64| cubic(core::array::from_fn(|i| self.at(column - 1 + i as i64, row)), s);
        cubic(core::array::from_fn(|j| along(row - 1 + j as i64)), t)
    }
}

/// Slope of a monotone cubic at the middle of three points a step apart (Fritsch and Butland 1984): the harmonic mean of the slopes around, 0 at extremes.
fn slope(before: f32, here: f32, after: f32) -> f32 {
    let (a, b) = (here - before, after - here);
    if a * b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
}

/// Between the middle two of four points a step apart, never beyond them.
fn cubic([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    let (m, n, u) = (slope(a, b, c), slope(b, c, d), 1.0 - t);
    u * u * (b * (1.0 + 2.0 * t) + m * t) + t * t * (c * (1.0 + 2.0 * u) - n * u)
}

/// How much farther apart the nodes of a level are than those of the first.
fn coarseness(level: usize) -> f64 {
    (1_u64 << level) as f64
}

/// A generation's heights as terrain over the plane, in metres; beyond its area it goes on as at the border.
///
/// Between nodes they are monotone cubics along x, then along y. Samples farther apart than nodes see lattices of doubled spacing, each the filtered form of the one
/// before, fading from one to the next by spacing alone; `filter=exact`, and samples as close as nodes, see the nodes themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveTerrain {
    origin: [f64; 2],
    cell: f64,
    levels: Vec<Level>,
    range: [f32; 2],
}

impl AdaptiveTerrain {
    pub(super) fn new(ground: &Ground, heights: Arc<[f32]>) -> Self {
        let range = heights.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &height| [low.min(height), high.max(height)]);
        let [columns, rows] = ground.size();
        let mut levels = vec![Level::new(columns, rows, heights)];
        while let Some(last) = levels.last().filter(|level| level.columns.max(level.rows) > 4) {
            levels.push(last.halved());
        }
        Self { origin: ground.origin, cell: ground.cell, levels, range }
    }

    /// The area of its nodes.
    #[must_use]
    pub fn area(&self) -> Rectangle {
        let [width, height] = [self.levels[0].columns, self.levels[0].rows].map(|n| (n - 1) as f64 * self.cell);
        Rectangle { min: self.origin, max: [self.origin[0] + width, self.origin[1] + height] }
    }

    /// Least and greatest height.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Heights of the nodes, row by row from the south.
    #[must_use]
    pub fn nodes(&self) -> &[f32] {
        &self.levels[0].heights
    }

    /// Nodes from west to east and from south to north.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.levels[0].columns, self.levels[0].rows]
    }

    /// The height at a point, `None` beyond the area.
    #[must_use]
    pub fn height(&self, point: [f64; 2]) -> Option<f32> {
        let [x, y] = [0, 1].map(|axis| self.place(axis, point[axis], 0));
        self.area().holds(point).then(|| self.levels[0].between(x, y))
    }

    /// The root mean square of what heights are off one.
    #[must_use]
    pub fn deviation(&self, about: f64) -> f64 {
        let nodes = self.nodes();
        (nodes.iter().map(|&height| (f64::from(height) - about) * (f64::from(height) - about)).sum::<f64>() / nodes.len() as f64).sqrt()
    }

    /// The least rectangle beyond which samples so far apart are the same of two generations of one terrain to the bit; empty if all are. A tile's fingerprint takes in
    /// the generation only if the tile's samples meet it. Beyond the area it has no end on a side where the border changed.
    ///
    /// # Panics
    /// If the two are not of one terrain.
    #[must_use]
    pub fn changed(&self, other: &Self, spacing: f64, filter: Filter) -> Rectangle {
        assert_eq!((self.size(), self.origin, self.cell), (other.size(), other.origin, other.cell), "generations of one terrain");
        let [columns, rows] = self.size();
        let (_, far, _) = self.levels_at(spacing, filter);
        // Two nodes of the coarsest level that is seen, each of which knows of so many of the first around it.
        let reach = 3.0 * coarseness(far) - 1.0;
        let differ = self.nodes().iter().zip(other.nodes()).enumerate().filter(|(_, (a, b))| a.to_bits() != b.to_bits());
        differ.fold(Rectangle::EMPTY, |all, (i, _)| {
            let end = |axis: usize, node: usize, count: usize| {
                let place = |nodes: f64| self.origin[axis] + (node as f64 + nodes) * self.cell;
                [if node == 0 { f64::NEG_INFINITY } else { place(-reach) }, if node + 1 == count { f64::INFINITY } else { place(reach) }]
            };
            let ([x0, x1], [y0, y1]) = (end(0, i % columns, columns), end(1, i / columns, rows));
            all.union(Rectangle { min: [x0, y0], max: [x1, y1] })
        })
    }

    /// The name of all heights that samples so far apart see in an area: as long as it is the same, so are the samples, to the bit.
    #[must_use]
    pub fn seen(&self, area: &Rectangle, spacing: f64, filter: Filter) -> [u8; 16] {
        let (near, far, share) = self.levels_at(spacing, filter);
        let mut hash = Sha256::new();
        for level in if share == 0.0 { near..=near } else { near..=far } {
            let Level { columns, rows, heights, blocks } = &self.levels[level];
            // Two nodes to either side of a sample.
            let nodes = |axis: usize, count: usize| {
                let node = |coordinate: f64, more: i64| self.place(axis, coordinate, level).0.saturating_add(more).clamp(0, count as i64 - 1) as usize;
                node(area.min[axis], -1)..node(area.max[axis], 2) + 1
            };
            blocks.hash_part(*columns, heights, nodes(0, *columns), nodes(1, *rows), &mut hash);
        }
        let digest = hash.finalize();
        core::array::from_fn(|i| digest[i])
    }

    /// The node west or south of a coordinate, and how far beyond it that lies, in steps of a level.
    fn place(&self, axis: usize, coordinate: f64, level: usize) -> (i64, f32) {
        let at = (coordinate - self.origin[axis]) / (self.cell * coarseness(level));
        let node = at.floor();
        (node as i64, (at - node) as f32)
    }

    /// Which two levels samples so far apart see, and how much of the second.
    fn levels_at(&self, spacing: f64, filter: Filter) -> (usize, usize, f32) {
        let ratio = if filter == Filter::Exact { 1.0 } else { (spacing / self.cell).max(1.0) };
        let last = self.levels.len() - 1;
        let Some(level) = (0..last).find(|level| ratio < coarseness(level + 1)) else { return (last, last, 0.0) };
        // From one lattice to the next as the ratio doubles.
        let share = ratio / coarseness(level) - 1.0;
        if share == 0.0 { (level, level, 0.0) } else { (level, level + 1, share as f32) }
    }

    /// Writes the heights over a window, row by row from the north. Stopped, it is not whole.
    pub fn write(&self, window: &Window, stop: &Stop, out: &mut [f32]) {
        let (near, far, share) = self.levels_at(window.spacing(), window.filter);
        let columns = |level: usize| -> Vec<(i64, f32)> { window.columns.coordinates().map(|x| self.place(0, x, level)).collect() };
        let places = [columns(near), columns(far)];
        for (y, out) in window.rows.coordinates().zip(out.chunks_mut(window.columns.len().max(1))) {
            if stop.is_set() {
                return;
            }
            let rows = [near, far].map(|level| self.place(1, y, level));
            for (i, out) in out.iter_mut().enumerate() {
                let a = self.levels[near].between(places[0][i], rows[0]);
                *out = if share == 0.0 { a } else { a + (self.levels[far].between(places[1][i], rows[1]) - a) * share };
            }
        }
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        let (_, _, share) = self.levels_at(window.spacing(), window.filter);
        SAMPLE_NS[usize::from(share > 0.0)] * window.samples() as f64
    }
}

impl Source for AdaptiveTerrain {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        let stop = surface.stop.clone();
        self.write(window, &stop, &mut surface.elevation);
    }

    fn legend(&self) -> Legend {
        Legend { range: self.range.map(f64::from), ..Legend::default() }
    }
}
