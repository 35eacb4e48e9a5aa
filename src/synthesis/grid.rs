//! Elevations of a rectangle of ground.

use super::sample::{Place, SampleError};

/// Most cells of a sample: 2^26, which are 256 MiB of heights.
pub const MAX_CELLS: usize = 1 << 26;

/// Fewest columns and rows of a sample: one gene of the least size.
pub const MIN_SIDE: usize = 8;

/// Elevations that ground can have, metres; what lies outside is refused.
pub const ELEVATIONS: [f64; 2] = [-12_000.0, 32_767.0];

/// Spacings that samples can have, metres.
pub const SPACINGS: [f64; 2] = [0.01, 10_000.0];

/// Elevations of a rectangle of ground, row by row from north to south and from west to east in a row. Cells are areas: the rectangle is `columns · spacing[0]` metres wide.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleGrid {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// Metres between cells, from west to east and from north to south.
    pub spacing: [f64; 2],
    /// Metres; not a number where nothing is known (a void).
    pub heights: Vec<f32>,
}

/// Cells of a grid: columns and rows from the north-western corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crop {
    /// The western column.
    pub column: usize,
    /// The northern row.
    pub row: usize,
    /// How many columns.
    pub columns: usize,
    /// How many rows.
    pub rows: usize,
}

impl SampleGrid {
    /// A row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[f32] {
        &self.heights[row * self.columns..][..self.columns]
    }

    /// How many cells are void.
    #[must_use]
    pub fn voids(&self) -> usize {
        self.heights.iter().filter(|height| height.is_nan()).count()
    }

    /// A part of it; `None` if it is not all inside or has no cell.
    #[must_use]
    pub fn crop(&self, crop: Crop) -> Option<Self> {
        let fits = |from: usize, count: usize, of: usize| count > 0 && from.checked_add(count).is_some_and(|end| end <= of);
        if !fits(crop.column, crop.columns, self.columns) || !fits(crop.row, crop.rows, self.rows) {
            return None;
        }
        let heights = (crop.row..crop.row + crop.rows).flat_map(|row| &self.row(row)[crop.column..crop.column + crop.columns]).copied().collect();
        Some(Self { columns: crop.columns, rows: crop.rows, spacing: self.spacing, heights })
    }

    /// Its four quarters: north-west, north-east, south-west, south-east. A middle column or row of an odd number belongs to the south-east.
    #[must_use]
    pub fn quarters(&self) -> [Crop; 4] {
        let (west, north) = (self.columns / 2, self.rows / 2);
        let crop = |column, row, columns, rows| Crop { column, row, columns, rows };
        [
            crop(0, 0, west, north),
            crop(west, 0, self.columns - west, north),
            crop(0, north, west, self.rows - north),
            crop(west, north, self.columns - west, self.rows - north),
        ]
    }

    /// The same ground seen in a mirror that stands from north to south.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let heights = (0..self.rows).flat_map(|row| self.row(row).iter().rev().copied()).collect();
        Self { heights, ..*self }
    }

    /// Checks what no format can promise: sides, spacing and elevations. `name` is that of the file.
    ///
    /// # Errors
    /// If there are fewer than [`MIN_SIDE`] columns or rows, spacing or a height is absurd, or all is void.
    pub fn check(&self, name: &str) -> Result<(), SampleError> {
        let error = |place, detail: String| Err(SampleError::new(name, place, detail));
        if self.columns < MIN_SIDE || self.rows < MIN_SIDE {
            return error(Place::File, format!("must have at least {MIN_SIDE} × {MIN_SIDE} cells, has {} × {}", self.columns, self.rows));
        }
        if let Some(spacing) = self.spacing.iter().find(|spacing| !(SPACINGS[0]..=SPACINGS[1]).contains(spacing)) {
            return error(Place::File, format!("cells must be {} … {} metres apart, are {spacing}", SPACINGS[0], SPACINGS[1]));
        }
        let absurd = |height: &f32| !height.is_nan() && !(ELEVATIONS[0]..=ELEVATIONS[1]).contains(&f64::from(*height));
        if let Some(cell) = self.heights.iter().position(absurd) {
            let place = Place::Cell { column: cell % self.columns, row: cell / self.columns };
            let [least, greatest] = ELEVATIONS;
            return error(
                place,
                format!(
                    "elevations must be {least} … {greatest} metres, got {}: say which unit they have, and which number stands for a void",
                    self.heights[cell]
                ),
            );
        }
        if self.heights.iter().all(|height| height.is_nan()) {
            return error(Place::File, "every cell is void".to_owned());
        }
        Ok(())
    }
}
