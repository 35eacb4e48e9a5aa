//! Water: ground of one elevation.

use super::grid::SampleGrid;

/// Cells of a body of water at least.
pub const MIN_WATER_CELLS: usize = 64;

/// A body of water that was found.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Water {
    /// Metres.
    pub elevation: f32,
    /// How many.
    pub cells: usize,
}

/// Finds water and gives a mask of what is not: connected cells of exactly one elevation, at least [`MIN_WATER_CELLS`] of which have all eight neighbours at it.
///
/// Flat ground whose elevations were rounded to metres looks the same: the inner cells keep its narrow steps apart from lakes.
#[must_use]
pub fn find_water(grid: &SampleGrid) -> (Vec<bool>, Vec<Water>) {
    let (columns, rows) = (grid.columns, grid.rows);
    let mut land = vec![true; columns * rows];
    let mut seen = vec![false; columns * rows];
    let mut bodies = Vec::new();
    let inner: Vec<bool> = (0..columns * rows).map(|cell| is_inner(grid, cell)).collect();
    for start in 0..columns * rows {
        if seen[start] || !inner[start] {
            continue;
        }
        let elevation = grid.heights[start];
        let (mut body, mut next) = (vec![start], 0);
        seen[start] = true;
        while let Some(&cell) = body.get(next) {
            next += 1;
            let (column, row) = (cell % columns, cell / columns);
            let around =
                [(column > 0, cell.wrapping_sub(1)), (column + 1 < columns, cell + 1), (row > 0, cell.wrapping_sub(columns)), (row + 1 < rows, cell + columns)];
            for (_, other) in around.into_iter().filter(|(inside, _)| *inside) {
                if !seen[other] && grid.heights[other] == elevation {
                    seen[other] = true;
                    body.push(other);
                }
            }
        }
        if body.iter().filter(|cell| inner[**cell]).count() >= MIN_WATER_CELLS {
            for cell in &body {
                land[*cell] = false;
            }
            bodies.push(Water { elevation, cells: body.len() });
        }
    }
    (land, bodies)
}

/// Whether all eight neighbours have a cell's elevation.
fn is_inner(grid: &SampleGrid, cell: usize) -> bool {
    let (column, row) = (cell % grid.columns, cell / grid.columns);
    let within = column > 0 && row > 0 && column + 1 < grid.columns && row + 1 < grid.rows;
    within && (row - 1..=row + 1).all(|row| grid.row(row)[column - 1..=column + 1].iter().all(|height| *height == grid.heights[cell]))
}
