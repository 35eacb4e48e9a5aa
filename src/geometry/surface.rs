//! What a window evaluates to, and the trait that evaluates it.

use super::Window;

/// The terrain over a window: one value a sample, row by row from north to south.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Samples a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Elevation of the ground in metres.
    pub elevation: Vec<f32>,
    /// How many node results were not finite and became 0.
    pub non_finite: u64,
}

impl Surface {
    /// A flat surface at elevation 0 of the window's size.
    #[must_use]
    pub fn of(window: &Window) -> Self {
        Self { columns: window.columns.len(), rows: window.rows.len(), elevation: vec![0.0; window.samples()], non_finite: 0 }
    }

    /// The elevation at a row and column.
    ///
    /// # Panics
    /// If there is no such row or column.
    #[must_use]
    pub fn at(&self, row: usize, column: usize) -> f32 {
        assert!(column < self.columns, "column {column} of {}", self.columns);
        self.elevation[row * self.columns + column]
    }

    /// One row of elevations.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.elevation[row * self.columns..][..self.columns]
    }

    /// The least and the greatest elevation, `None` if there are no samples.
    #[must_use]
    pub fn range(&self) -> Option<(f32, f32)> {
        let first = *self.elevation.first()?;
        Some(self.elevation.iter().fold((first, first), |(low, high), &e| (low.min(e), high.max(e))))
    }
}

/// Something that gives terrain over a window of the plane.
pub trait Source {
    /// Fills `surface`, which has the window's size, with the terrain at the window's samples.
    ///
    /// The result at a sample depends on its coordinates, the spacing and the filter alone.
    fn sample(&self, window: &Window, surface: &mut Surface);
}
