//! The level before as what the next one follows: brought to its cells, and put back where the genes left it.

/// Cells of a level for one of the level before, a side.
pub(super) const STEP: usize = 3;

/// Heights row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Heights {
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

impl Heights {
    /// Cells three times as near, columns × rows of them from the north-western corner.
    pub(super) fn finer(&self, columns: usize, rows: usize) -> Self {
        let mut heights = vec![0.0; columns * rows];
        self.add_finer(&mut heights, columns, [0, columns], [0, rows]);
        Self { columns, rows, heights }
    }

    /// Adds the finer cells of a rectangle to those of a grid so wide.
    pub(super) fn add_finer(&self, onto: &mut [f32], columns: usize, [west, east]: [usize; 2], [north, south]: [usize; 2]) {
        let across: Vec<_> = (west..east).map(|column| among(column, self.columns)).collect();
        let mut line = vec![0.0_f32; self.columns];
        let needed = across.first().map_or(0, |(cells, _)| cells[0])..across.last().map_or(0, |(cells, _)| cells[3] + 1);
        for row in north..south {
            let (cells, weights) = among(row, self.rows);
            let rows = cells.map(|cell| &self.heights[cell * self.columns..][..self.columns]);
            for column in needed.clone() {
                line[column] =
                    weights[0] * rows[0][column] + weights[1] * rows[1][column] + weights[2] * rows[2][column] + weights[3] * rows[3][column];
            }
            for (height, (cells, weights)) in onto[row * columns + west..row * columns + east].iter_mut().zip(&across) {
                *height += weights[0] * line[cells[0]] + weights[1] * line[cells[1]] + weights[2] * line[cells[2]] + weights[3] * line[cells[3]];
            }
        }
    }

    /// What is left of it when the mean of the fine cells of every cell is taken away, for a rectangle of its cells; elsewhere it is as `onto` was.
    pub(super) fn residual(&self, fine: &Heights, onto: &mut Heights, [west, east]: [usize; 2], [north, south]: [usize; 2]) {
        for row in north..south {
            for column in west..east {
                let (x, y) = (STEP * column, STEP * row);
                let (to_x, to_y) = ((x + STEP).min(fine.columns), (y + STEP).min(fine.rows));
                let sum: f32 = (y..to_y).map(|y| fine.heights[y * fine.columns + x..y * fine.columns + to_x].iter().sum::<f32>()).sum();
                let count = ((to_x - x) * (to_y - y)) as f32;
                onto.heights[row * self.columns + column] = self.heights[row * self.columns + column] - sum / count;
            }
        }
    }
}
