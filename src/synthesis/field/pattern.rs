//! The level before as what the next one follows, and what of a sample it does not hold.

use crate::synthesis::{gaussian::mirrored, grid::SampleGrid};

/// Cells of a level for one of the level before, a side.
pub(super) const STEP: usize = 3;

/// Heights row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HeightGrid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) heights: Vec<f32>,
}

/// Weights of the four cells around a place `t` beyond the second of them (Catmull and Rom 1974).
pub(super) fn cubic(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (2.0 * t2 - t - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}

/// The cells that a fine cell lies among and what each counts: of three fine cells one lies west of the middle of its coarse cell, one on it and one east of it.
fn among(fine: usize, cells: usize) -> ([usize; 4], [f32; 4]) {
    let (coarse, third) = (fine / STEP, fine % STEP);
    let (first, t) = match third {
        0 => (coarse as isize - 2, 2.0 / 3.0),
        1 => (coarse as isize - 1, 0.0),
        _ => (coarse as isize - 1, 1.0 / 3.0),
    };
    (core::array::from_fn(|i| (first + i as isize).clamp(0, cells as isize - 1) as usize), cubic(t))
}

impl HeightGrid {
    /// Cells three times as near, columns × rows of them from the north-western corner.
    pub(super) fn finer(&self, columns: usize, rows: usize) -> Self {
        let mut heights = Vec::with_capacity(columns * rows);
        let across: Vec<_> = (0..columns).map(|column| among(column, self.columns)).collect();
        let mut line = vec![0.0_f32; self.columns];
        for row in 0..rows {
            let (cells, weights) = among(row, self.rows);
            let rows = cells.map(|cell| &self.heights[cell * self.columns..][..self.columns]);
            for (column, height) in line.iter_mut().enumerate() {
                *height = weights[0] * rows[0][column] + weights[1] * rows[1][column] + weights[2] * rows[2][column] + weights[3] * rows[3][column];
            }
            let height = |(cells, weights): &([usize; 4], [f32; 4])| {
                weights[0] * line[cells[0]] + weights[1] * line[cells[1]] + weights[2] * line[cells[2]] + weights[3] * line[cells[3]]
            };
            heights.extend(across.iter().map(height));
        }
        Self { columns, rows, heights }
    }
}

/// What a level holds of the one three times as fine, as a kernel: the low-pass that brings samples to a level (three lobes), then cubic interpolation, over all ways in which coarse cells lie among fine ones.
fn passed() -> Vec<f32> {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { libm::sin(core::f64::consts::PI * x) / (core::f64::consts::PI * x) };
    let reduced: Vec<f64> = (-8_i32..=8).map(|i| f64::from(i) / 3.0).map(|x| sinc(x) * sinc(x / 3.0)).collect();
    let weight = |distance: i32| {
        let cubic = cubic((distance % 3) as f32 / 3.0);
        f64::from(cubic[1 - (distance / 3) as usize])
    };
    let raised: Vec<f64> = (-5_i32..=5).map(|i| weight(i.abs())).collect();
    let mut kernel = vec![0.0; reduced.len() + raised.len() - 1];
    for (i, a) in reduced.iter().enumerate() {
        for (j, b) in raised.iter().enumerate() {
            kernel[i + j] += a * b;
        }
    }
    let sum: f64 = kernel.iter().sum();
    kernel.iter().map(|weight| (weight / sum) as f32).collect()
}

/// What of a sample the level before does not hold, metres.
pub(super) fn detail(grid: &SampleGrid) -> Vec<f32> {
    let (kernel, columns, rows) = (passed(), grid.columns, grid.rows);
    let half = (kernel.len() / 2) as isize;
    let middle = grid.heights[grid.heights.len() / 2];
    let mut across = Vec::with_capacity(columns * rows);
    for row in grid.heights.chunks_exact(columns) {
        let at =
            |x: usize| kernel.iter().enumerate().map(|(i, weight)| weight * (row[mirrored(x as isize + i as isize - half, columns)] - middle)).sum::<f32>();
        across.extend((0..columns).map(at));
    }
    let mut passed = vec![0.0_f32; columns * rows];
    for (y, out) in passed.chunks_exact_mut(columns).enumerate() {
        for (i, weight) in kernel.iter().enumerate() {
            let line = &across[mirrored(y as isize + i as isize - half, rows) * columns..][..columns];
            out.iter_mut().zip(line).for_each(|(sum, height)| *sum += weight * height);
        }
    }
    grid.heights.iter().zip(&passed).map(|(height, passed)| (height - middle) - passed).collect()
}
