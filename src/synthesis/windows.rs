//! What surrounds every cell of a grid: means and ranges over squares.

use super::grid::SampleGrid;

/// Steps of a metre (or of a slope of 1) that sums count in: sums of whole numbers are exact, whatever their order.
const STEPS: f64 = (1_u64 << 20) as f64;

/// Means and ranges over the square around every cell, as far as it lies in the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Cells on either side of the middle: the square has `2 · reach + 1` a side.
    pub reach: usize,
    /// Mean elevation, metres.
    pub mean: Vec<f32>,
    /// Mean gradient, dz/dx to the east and dz/dy to the north.
    pub gradient: Vec<[f32; 2]>,
    /// Least and greatest elevation, metres.
    pub range: Vec<[f32; 2]>,
}

/// Sums from the north-western corner: of the cells north and west of each corner of a cell.
struct Sums {
    stride: usize,
    sums: Vec<i64>,
}

impl Sums {
    fn new(columns: usize, values: impl Iterator<Item = f32>) -> Self {
        let stride = columns + 1;
        let mut sums = vec![0; stride];
        let mut row = 0;
        for (cell, value) in values.enumerate() {
            if cell % columns == 0 {
                sums.push(0);
                row = 0;
            }
            row += steps(value);
            sums.push(row + sums[sums.len() - stride]);
        }
        Self { stride, sums }
    }

    /// Over columns and rows up to those that end them.
    fn over(&self, [west, east]: [usize; 2], [north, south]: [usize; 2]) -> i64 {
        let at = |column: usize, row: usize| self.sums[row * self.stride + column];
        at(east, south) - at(west, south) - at(east, north) + at(west, north)
    }
}

/// A value in whole steps.
fn steps(value: f32) -> i64 {
    libm::round(f64::from(value) * STEPS) as i64
}

/// A sum of steps over cells as a mean.
fn mean(steps: i64, cells: usize) -> f32 {
    (steps as f64 / (cells as f64 * STEPS)) as f32
}

/// The least of every window along a line, by blocks as long as the window: what begins in a block and what ends in the next (van Herk 1992; Gil and Werman 1993).
fn least_along(values: &[f32], reach: usize, out: &mut Vec<f32>) {
    let side = 2 * reach + 1;
    let at = |i: usize| if (reach..reach + values.len()).contains(&i) { values[i - reach] } else { f32::INFINITY };
    let length = values.len() + 2 * reach;
    let (mut ahead, mut behind) = (vec![f32::INFINITY; length], vec![f32::INFINITY; length]);
    for i in 0..length {
        ahead[i] = if i % side == 0 { at(i) } else { at(i).min(ahead[i - 1]) };
    }
    for i in (0..length).rev() {
        behind[i] = if i % side == side - 1 || i + 1 == length { at(i) } else { at(i).min(behind[i + 1]) };
    }
    out.extend((0..values.len()).map(|i| behind[i].min(ahead[i + side - 1])));
}

/// The least over the square around every cell.
fn least(values: &[f32], columns: usize, rows: usize, reach: usize) -> Vec<f32> {
    let mut across = Vec::with_capacity(values.len());
    values.chunks_exact(columns).for_each(|row| least_along(row, reach, &mut across));
    let mut squares = vec![0.0; values.len()];
    let (mut column, mut down) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
    for x in 0..columns {
        column.clear();
        column.extend(across[x..].iter().step_by(columns));
        down.clear();
        least_along(&column, reach, &mut down);
        squares[x..].iter_mut().step_by(columns).zip(&down).for_each(|(square, least)| *square = *least);
    }
    squares
}

impl Windows {
    /// Of a grid without voids and its gradients.
    #[must_use]
    pub fn new(grid: &SampleGrid, gradient: &[[f32; 2]], reach: usize) -> Self {
        let (columns, rows) = (grid.columns, grid.rows);
        let heights = Sums::new(columns, grid.heights.iter().copied());
        let slopes = [0, 1].map(|axis| Sums::new(columns, gradient.iter().map(|gradient| gradient[axis])));
        let mut windows = Self { reach, mean: Vec::with_capacity(columns * rows), gradient: Vec::with_capacity(columns * rows), range: Vec::new() };
        let span = |at: usize, cells: usize| [at.saturating_sub(reach), (at + reach + 1).min(cells)];
        for row in 0..rows {
            for column in 0..columns {
                let (x, y) = (span(column, columns), span(row, rows));
                let cells = (x[1] - x[0]) * (y[1] - y[0]);
                windows.mean.push(mean(heights.over(x, y), cells));
                windows.gradient.push([0, 1].map(|axis: usize| mean(slopes[axis].over(x, y), cells)));
            }
        }
        let low = least(&grid.heights, columns, rows, reach);
        let negative: Vec<f32> = grid.heights.iter().map(|height| -height).collect();
        let high = least(&negative, columns, rows, reach);
        windows.range = low.iter().zip(&high).map(|(low, high)| [*low, -high]).collect();
        windows
    }
}
