//! Parts of a sample without voids.

use super::grid::{Crop, SampleGrid};
use serde::{Deserialize, Serialize};

/// How a sample with voids becomes one without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Voids {
    /// The largest rectangle without voids.
    #[default]
    Rectangle,
    /// The side with the greatest share of voids is taken away until none is left: keeps the middle of a quadrangle whose sides are slanted.
    Trim,
}

impl Voids {
    /// The part of a sample without voids, the whole if there are none; `None` if nothing is left.
    #[must_use]
    pub fn part(self, grid: &SampleGrid) -> Option<Crop> {
        match self {
            Voids::Rectangle => largest_rectangle(grid),
            Voids::Trim => trimmed(grid),
        }
    }
}

/// The largest rectangle without voids, of equals the one that ends first in the order of rows, then of columns.
///
/// Row by row, columns are bars as high as the cells without voids above; a stack holds bars that rise, each with the first column that it reaches back to.
#[must_use]
pub fn largest_rectangle(grid: &SampleGrid) -> Option<Crop> {
    let mut high = vec![0_usize; grid.columns];
    let mut best: Option<Crop> = None;
    let mut stack: Vec<(usize, usize)> = Vec::new();
    for row in 0..grid.rows {
        for (bar, height) in high.iter_mut().zip(grid.row(row)) {
            *bar = if height.is_nan() { 0 } else { *bar + 1 };
        }
        for column in 0..=grid.columns {
            let bar = high.get(column).copied().unwrap_or(0);
            let mut start = column;
            while let Some((from, rows)) = stack.pop_if(|(_, rows)| *rows >= bar) {
                start = from;
                if rows * (column - from) > best.map_or(0, |best| best.columns * best.rows) {
                    best = Some(Crop { column: from, row: row + 1 - rows, columns: column - from, rows });
                }
            }
            if bar > 0 {
                stack.push((start, bar));
            }
        }
        stack.clear();
    }
    best
}

/// What is left when sides with voids are taken away, that with the greatest share first; of equals north, south, west, east.
#[must_use]
pub fn trimmed(grid: &SampleGrid) -> Option<Crop> {
    let void = |row: usize, column: usize| grid.heights[row * grid.columns + column].is_nan();
    let (mut north, mut south, mut west, mut east) = (0, grid.rows, 0, grid.columns);
    while north < south && west < east {
        let in_row = |row: usize| (west..east).filter(|column| void(row, *column)).count() as f64 / (east - west) as f64;
        let in_column = |column: usize| (north..south).filter(|row| void(*row, column)).count() as f64 / (south - north) as f64;
        let shares = [in_row(north), in_row(south - 1), in_column(west), in_column(east - 1)];
        let inside = (north..south).any(|row| (west..east).any(|column| void(row, column)));
        if !inside {
            return Some(Crop { column: west, row: north, columns: east - west, rows: south - north });
        }
        // Voids in the middle alone: every side is without; the shorter way out is taken.
        let most = shares.iter().copied().fold(0.0, f64::max);
        match shares.iter().position(|share| *share == most) {
            Some(0) => north += 1,
            Some(1) => south -= 1,
            Some(2) => west += 1,
            _ => east -= 1,
        }
    }
    None
}
