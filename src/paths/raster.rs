//! Heights of nodes as terrain: what lies between them, and how they look from afar.

use super::{document::Drawing, lattice::Node, plan::Heights};
use crate::geometry::{Filter, Legend, Rectangle, Source, Stop, Surface, Window};

/// Nanoseconds to evaluate a sample between nodes, in one level and in two.
const SAMPLE_NS: [f64; 2] = [60.0, 110.0];

/// A lattice of heights. Beyond it there is nothing: 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    first: Node,
    columns: usize,
    rows: usize,
    /// Row by row from the south.
    values: Vec<f32>,
}

impl Level {
    /// A lattice's values, row by row from the south.
    pub(super) fn new(first: Node, columns: usize, rows: usize, values: Vec<f32>) -> Self {
        Self { first, columns, rows, values }
    }

    /// The node west or south of a coordinate, in metres from where nodes are counted, and how far beyond it that lies.
    pub(super) fn place(coordinate: f64, spacing: f64) -> (i64, f32) {
        let at = coordinate / spacing;
        let node = at.floor();
        (node as i64, (at - node) as f32)
    }

    /// The values between nodes along a row of places.
    pub(super) fn row(&self, (row, t): (i64, f32), places: &[(i64, f32)], values: &mut Vec<f32>) {
        values.clear();
        if row < self.first.row - 1 || row >= self.first.row + self.rows as i64 {
            values.resize(places.len(), 0.0);
            return;
        }
        values.extend(places.iter().map(|(column, s)| {
            let along = |row: i64| cubic(core::array::from_fn(|i| self.at(column - 1 + i as i64, row)), *s);
            cubic(core::array::from_fn(|j| along(row - 1 + j as i64)), t)
        }));
    }

    fn at(&self, column: i64, row: i64) -> f32 {
        let (i, j) = (column - self.first.column, row - self.first.row);
        let inside = (0..self.columns as i64).contains(&i) && (0..self.rows as i64).contains(&j);
        if inside { self.values[j as usize * self.columns + i as usize] } else { 0.0 }
    }

    /// Every second node, each with its neighbours by 1 : 2 : 1 along both axes.
    pub(super) fn halved(&self) -> Self {
        let first = Node { row: self.first.row.div_euclid(2), column: self.first.column.div_euclid(2) };
        let count = |first: i64, count: usize, from: i64| ((first + count as i64).div_euclid(2) + 1 - from) as usize;
        let (columns, rows) = (count(self.first.column, self.columns, first.column), count(self.first.row, self.rows, first.row));
        let mut values = Vec::with_capacity(columns * rows);
        for j in 0..rows as i64 {
            for i in 0..columns as i64 {
                let (column, row) = (2 * (first.column + i), 2 * (first.row + j));
                let three = |row: i64| self.at(column - 1, row) + 2.0 * self.at(column, row) + self.at(column + 1, row);
                values.push((three(row - 1) + 2.0 * three(row) + three(row + 1)) * (1.0 / 16.0));
            }
        }
        Self { first, columns, rows, values }
    }
}

/// How much farther apart the nodes of a level are than those of the first.
pub(super) fn coarseness(level: usize) -> f64 {
    (1_u64 << level) as f64
}

/// Slope of a monotone cubic at the middle of three points a step apart (Fritsch and Butland 1984): the harmonic mean of the slopes around, 0 at extremes.
#[inline]
fn slope(before: f32, here: f32, after: f32) -> f32 {
    let (a, b) = (here - before, after - here);
    if a * b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
}

/// Between the middle two of four points a step apart, never beyond them.
#[inline]
fn cubic([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    let (m, n, u) = (slope(a, b, c), slope(b, c, d), 1.0 - t);
    u * u * (b * (1.0 + 2.0 * t) + m * t) + t * t * (c * (1.0 + 2.0 * u) - n * u)
}

/// The heights of a finite drawing as terrain over the plane: metres above sea level, 0 beyond what strokes reach.
///
/// Between nodes they are monotone cubics along x, then along y, so a lattice's own values are kept. Samples farther apart than nodes see lattices of doubled spacing, each the filtered
/// form of the one before, fading from one to the next by spacing alone; `filter=exact` sees the nodes themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    origin: [f64; 2],
    spacing: f64,
    levels: Vec<Level>,
    range: [f32; 2],
}

impl Raster {
    /// Puts a drawing's heights in their place.
    #[must_use]
    pub fn new(drawing: &Drawing, heights: Heights) -> Self {
        Self::at(drawing.origin, drawing.spacing, heights)
    }

    /// Puts heights of nodes `spacing` metres apart in their place; the drawing's own south-western node lies at `origin`.
    #[must_use]
    pub fn at(origin: [f64; 2], spacing: f64, heights: Heights) -> Self {
        let Heights { first, columns, rows, metres, .. } = heights;
        let values: Vec<f32> = metres.chunks(columns).rev().flatten().copied().collect();
        let range = values.iter().fold([0.0, 0.0], |[low, high]: [f32; 2], value| [low.min(*value), high.max(*value)]);
        let mut levels = vec![Level { first, columns, rows, values }];
        while let Some(last) = levels.last().filter(|level| level.columns.max(level.rows) > 4) {
            levels.push(last.halved());
        }
        Self { origin, spacing, levels, range }
    }

    /// Beyond this there is nothing at any spacing.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        let of = |(number, level): (usize, &Level)| {
            let step = self.spacing * coarseness(number);
            let end = |axis: usize, node: i64| self.origin[axis] + node as f64 * step;
            let (columns, rows) = (level.columns as i64, level.rows as i64);
            Rectangle {
                min: [end(0, level.first.column - 1), end(1, level.first.row - 1)],
                max: [end(0, level.first.column + columns), end(1, level.first.row + rows)],
            }
        };
        self.levels.iter().enumerate().map(of).fold(Rectangle::EMPTY, Rectangle::union)
    }

    /// Least and greatest height.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Which two levels samples so far apart see, and how much of the second.
    fn levels_at(&self, spacing: f64, filter: Filter) -> (usize, usize, f32) {
        let ratio = if filter == Filter::Exact { 1.0 } else { (spacing / self.spacing).max(1.0) };
        let last = self.levels.len() - 1;
        let Some(level) = (0..last).find(|level| ratio < coarseness(level + 1)) else { return (last, last, 0.0) };
        // From one lattice to the next as the ratio doubles.
        let share = ratio / coarseness(level) - 1.0;
        if share == 0.0 { (level, level, 0.0) } else { (level, level + 1, share as f32) }
    }

    /// Adds the heights over a window to `out`, row by row from the north. Stopped, it is not whole.
    pub fn add(&self, window: &Window, stop: &Stop, out: &mut [f32]) {
        let (near, far, share) = self.levels_at(window.spacing(), window.filter);
        let place = |axis: usize, c: f64, level: usize| Level::place(c - self.origin[axis], self.spacing * coarseness(level));
        let columns = |level: usize| -> Vec<(i64, f32)> { window.columns.coordinates().map(|x| place(0, x, level)).collect() };
        let places = [columns(near), columns(far)];
        let mut row_values = [Vec::new(), Vec::new()];
        for (y, out) in window.rows.coordinates().zip(out.chunks_mut(window.columns.len())) {
            if stop.is_set() {
                return;
            }
            self.levels[near].row(place(1, y, near), &places[0], &mut row_values[0]);
            if share == 0.0 {
                for (out, value) in out.iter_mut().zip(&row_values[0]) {
                    *out += value;
                }
                continue;
            }
            self.levels[far].row(place(1, y, far), &places[1], &mut row_values[1]);
            for ((out, a), b) in out.iter_mut().zip(&row_values[0]).zip(&row_values[1]) {
                *out += a + (b - a) * share;
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

impl Source for Raster {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        surface.elevation.fill(0.0);
        let stop = surface.stop.clone();
        self.add(window, &stop, &mut surface.elevation);
    }

    fn legend(&self) -> Legend {
        Legend { sea_level: 0.0, range: self.range.map(f64::from), materials: Vec::new() }
    }
}
