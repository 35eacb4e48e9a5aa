//! How an area is cut into parts that are evaluated one by one.

use crate::geometry::Window;

/// Samples of a band of rows, for windows that are not wider.
const BAND_SAMPLES: usize = 1 << 20;

/// Most rows of a band, and most columns of a part: some hundred a side is where sources are quickest, and a part lasts no longer than a tile.
const BAND_ROWS: usize = 256;
const PART_COLUMNS: usize = 512;

/// A window as bands of rows, each as parts from west to east.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cut {
    pub window: Window,
    /// Rows of a band, but for the last.
    rows: usize,
    /// Columns of a part, but for the easternmost.
    columns: usize,
}

impl Cut {
    pub(super) fn of(window: Window) -> Self {
        Self::into(window, (BAND_SAMPLES / window.columns.len().max(1)).clamp(1, BAND_ROWS), PART_COLUMNS)
    }

    pub(super) fn into(window: Window, rows: usize, columns: usize) -> Self {
        Self { window, rows, columns }
    }

    pub(super) fn parts_a_band(&self) -> usize {
        self.window.columns.len().div_ceil(self.columns)
    }

    pub(super) fn parts(&self) -> usize {
        self.parts_a_band() * self.window.rows.len().div_ceil(self.rows)
    }

    pub(super) fn part_samples(&self) -> usize {
        self.rows.min(self.window.rows.len()) * self.columns.min(self.window.columns.len())
    }

    /// First row and number of rows, first column and number of columns of a part.
    pub(super) fn place(&self, part: usize) -> [[usize; 2]; 2] {
        let [row, column] = [part / self.parts_a_band() * self.rows, part % self.parts_a_band() * self.columns];
        let (rows, columns) = (self.window.rows.len(), self.window.columns.len());
        [[row, self.rows.min(rows - row)], [column, self.columns.min(columns - column)]]
    }

    pub(super) fn part(&self, part: usize) -> Window {
        let [rows, columns] = self.place(part);
        self.window.part(rows, columns)
    }
}
