//! Heights of nodes as terrain: what lies between them, and how they look from afar.

use super::{Filter, Legend, Rectangle, Source, Stop, Surface, Window};
use serde::{Deserialize, Serialize};

/// Nanoseconds to evaluate a sample between nodes, in one level and in two.
const SAMPLE_NS: [f64; 2] = [60.0, 110.0];

/// A lattice of heights. Beyond it there is nothing: 0.
#[derive(Clone, Debug, PartialEq)]
pub struct RasterLevel {
    /// Column and row of the south-western node.
    first: [i64; 2],
    columns: usize,
    rows: usize,
    /// Row by row from the south.
    values: Vec<f32>,
}

impl RasterLevel {
    /// A lattice's values, row by row from the south.
    #[must_use]
    pub fn new(first: [i64; 2], columns: usize, rows: usize, values: Vec<f32>) -> Self {
        Self { first, columns, rows, values }
    }

    /// The node west or south of a coordinate, in metres from where nodes are counted, and how far beyond it that lies.
    #[must_use]
    pub fn place(coordinate: f64, spacing: f64) -> (i64, f32) {
        let at = coordinate / spacing;
        let node = at.floor();
        (node as i64, (at - node) as f32)
    }

    /// The values between nodes along a row of places.
    pub fn row(&self, (row, t): (i64, f32), places: &[(i64, f32)], values: &mut Vec<f32>) {
        values.clear();
        if row < self.first[1] - 1 || row >= self.first[1] + self.rows as i64 {
            values.resize(places.len(), 0.0);
            return;
        }
        values.extend(places.iter().map(|(column, s)| {
            let along = |row: i64| cubic(core::array::from_fn(|i| self.at(column - 1 + i as i64, row)), *s);
            cubic(core::array::from_fn(|j| along(row - 1 + j as i64)), t)
        }));
    }

    fn at(&self, column: i64, row: i64) -> f32 {
        let (i, j) = (column - self.first[0], row - self.first[1]);
        let inside = (0..self.columns as i64).contains(&i) && (0..self.rows as i64).contains(&j);
        if inside { self.values[j as usize * self.columns + i as usize] } else { 0.0 }
    }

    /// Every second node, each with its neighbours by 1 : 2 : 1 along both axes.
    #[must_use]
    pub fn halved(&self) -> Self {
        let first = self.first.map(|first| first.div_euclid(2));
        let count = |first: i64, count: usize, from: i64| ((first + count as i64).div_euclid(2) + 1 - from) as usize;
        let (columns, rows) = (count(self.first[0], self.columns, first[0]), count(self.first[1], self.rows, first[1]));
        let mut values = Vec::with_capacity(columns * rows);
        for j in 0..rows as i64 {
            for i in 0..columns as i64 {
                let (column, row) = (2 * (first[0] + i), 2 * (first[1] + j));
                let three = |row: i64| self.at(column - 1, row) + 2.0 * self.at(column, row) + self.at(column + 1, row);
                values.push((three(row - 1) + 2.0 * three(row) + three(row + 1)) * (1.0 / 16.0));
            }
        }
        Self { first, columns, rows, values }
    }
}

/// How much farther apart the nodes of a level are than those of the first.
#[must_use]
pub fn coarseness(level: usize) -> f64 {
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

/// Where the nodes of a lattice lie, in metres: node (i, j) at origin + (first + (i, j)) · spacing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lattice {
    /// Node (0, 0).
    pub origin: [f64; 2],
    /// Column and row of the south-western node.
    pub first: [i64; 2],
    /// Between nodes.
    pub spacing: f64,
}

/// Heights of a lattice as terrain over the plane: metres, 0 beyond the lattice.
///
/// Between nodes they are monotone cubics along x, then along y, so a lattice's own values are kept. Samples farther apart than nodes see lattices of doubled spacing, each the filtered
/// form of the one before, fading from one to the next by spacing alone; `filter=exact` sees the nodes themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    place: Lattice,
    levels: Vec<RasterLevel>,
    range: [f32; 2],
}

impl Raster {
    /// Puts heights, row by row from the south, on the nodes (first + (i, j)) · spacing + origin.
    #[must_use]
    pub fn new(place: Lattice, columns: usize, values: Vec<f32>) -> Self {
        let range = values.iter().fold([0.0, 0.0], |[low, high]: [f32; 2], value| [low.min(*value), high.max(*value)]);
        let rows = values.len() / columns.max(1);
        let mut levels = vec![RasterLevel { first: place.first, columns, rows, values }];
        while let Some(last) = levels.last().filter(|level| level.columns.max(level.rows) > 4) {
            levels.push(last.halved());
        }
        Self { place, levels, range }
    }

    /// Where its nodes lie.
    #[must_use]
    pub fn place(&self) -> Lattice {
        self.place
    }

    /// Nodes from west to east and from south to north.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.levels.first().map_or([0, 0], |level| [level.columns, level.rows])
    }

    /// The heights, row by row from the south.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        self.levels.first().map_or(&[], |level| &level.values)
    }

    /// Beyond this there is nothing at any spacing.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        let of = |(number, level): (usize, &RasterLevel)| {
            let step = self.place.spacing * coarseness(number);
            let end = |axis: usize, node: i64| self.place.origin[axis] + node as f64 * step;
            let (columns, rows) = (level.columns as i64, level.rows as i64);
            Rectangle { min: [end(0, level.first[0] - 1), end(1, level.first[1] - 1)], max: [end(0, level.first[0] + columns), end(1, level.first[1] + rows)] }
        };
        self.levels.iter().enumerate().map(of).fold(Rectangle::EMPTY, Rectangle::union)
    }

    /// Least and greatest height, 0 among them.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Which two levels samples so far apart see, and how much of the second.
    fn levels_at(&self, spacing: f64, filter: Filter) -> (usize, usize, f32) {
        let ratio = if filter == Filter::Exact { 1.0 } else { (spacing / self.place.spacing).max(1.0) };
        let last = self.levels.len() - 1;
        let Some(level) = (0..last).find(|level| ratio < coarseness(level + 1)) else { return (last, last, 0.0) };
        // From one lattice to the next as the ratio doubles.
        let share = ratio / coarseness(level) - 1.0;
        if share == 0.0 { (level, level, 0.0) } else { (level, level + 1, share as f32) }
    }

    /// Adds the heights over a window to `out`, row by row from the north. Stopped, it is not whole.
    pub fn add(&self, window: &Window, stop: &Stop, out: &mut [f32]) {
        let (near, far, share) = self.levels_at(window.spacing(), window.filter);
        let place = |axis: usize, c: f64, level: usize| RasterLevel::place(c - self.place.origin[axis], self.place.spacing * coarseness(level));
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
