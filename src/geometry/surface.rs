//! What a window evaluates to, and the trait that evaluates it.

use super::{Stop, Window};

/// What is wanted of a surface beside the elevation of its ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Depth of water, and the share of each sample that lies under it.
    pub water: bool,
    /// Materials of the ground.
    pub materials: bool,
    /// A page of the weights of materials: page n has those of numbers 4 n to 4 n + 3.
    pub weights: Option<u8>,
}

/// The terrain over a window: one value a sample, row by row from north to south.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Samples a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// Elevation of the ground in metres, also under water.
    pub elevation: Vec<f32>,
    /// Metres of water above the ground, from 0 on; empty if not [`Wanted`].
    pub water_depth: Vec<f32>,
    /// The share 0 … 1 of a sample's square that lies under water as far as its source knows; empty if not [`Wanted`].
    pub water_cover: Vec<f32>,
    /// 0 where the source knows of no material, else one more than the material's number in the source's list; empty if not [`Wanted`].
    pub material: Vec<u16>,
    /// How much of a sample's ground is of each material, the numbers of one page: 0 … 255, over all pages 255 in every sample. Number 0 is what has no material.
    /// Empty if not [`Wanted`].
    pub weights: Vec<[u8; 4]>,
    /// The page that they are of.
    pub page: u8,
    /// How many node results were not finite and became 0.
    pub non_finite: u64,
    /// What ends its evaluation: then it is not whole.
    pub stop: Stop,
}

/// Some rows of a [`Surface`], to be filled.
#[derive(Debug, Default)]
pub struct SurfaceRows<'a> {
    /// As in [`Surface`], like all the others.
    pub elevation: &'a mut [f32],
    /// Empty if not wanted.
    pub water_depth: &'a mut [f32],
    /// Empty if not wanted.
    pub water_cover: &'a mut [f32],
    /// Empty if not wanted.
    pub material: &'a mut [u16],
    /// Empty if not wanted.
    pub weights: &'a mut [[u8; 4]],
    /// The page that the weights are of.
    pub page: u8,
    /// As in [`Surface`].
    pub stop: Stop,
}

impl Surface {
    /// A flat surface at elevation 0 of the window's size, of which nothing else is wanted.
    #[must_use]
    pub fn of(window: &Window) -> Self {
        Self::with(window, Wanted::default())
    }

    /// A flat and dry surface at elevation 0 of the window's size.
    #[must_use]
    pub fn with(window: &Window, wanted: Wanted) -> Self {
        let samples = window.samples();
        let [water, materials, weights] = [wanted.water, wanted.materials, wanted.weights.is_some()].map(|wanted| if wanted { samples } else { 0 });
        Self {
            columns: window.columns.len(),
            rows: window.rows.len(),
            elevation: vec![0.0; samples],
            water_depth: vec![0.0; water],
            water_cover: vec![0.0; water],
            material: vec![0; materials],
            weights: vec![[0; 4]; weights],
            page: wanted.weights.unwrap_or(0),
            non_finite: 0,
            stop: Stop::never(),
        }
    }

    /// All of it, in parts of `rows` rows each, the last one perhaps of fewer.
    pub fn bands_mut(&mut self, rows: usize) -> Vec<SurfaceRows<'_>> {
        let size = (self.columns * rows).max(1);
        let (mut depth, mut cover, mut material) = (self.water_depth.chunks_mut(size), self.water_cover.chunks_mut(size), self.material.chunks_mut(size));
        let mut weights = self.weights.chunks_mut(size);
        let (page, stop) = (self.page, &self.stop);
        let bands = self.elevation.chunks_mut(size).map(|elevation| SurfaceRows {
            elevation,
            water_depth: depth.next().unwrap_or_default(),
            water_cover: cover.next().unwrap_or_default(),
            material: material.next().unwrap_or_default(),
            weights: weights.next().unwrap_or_default(),
            page,
            stop: stop.clone(),
        });
        bands.collect()
    }

    /// Makes the surface of the water the ground, where its depth is known.
    pub fn raise_to_water(&mut self) {
        for (elevation, depth) in self.elevation.iter_mut().zip(&mut self.water_depth) {
            *elevation += std::mem::take(depth);
        }
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

/// What one needs to know to draw the surfaces of a source in colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// Elevation of the sea's surface in metres.
    pub sea_level: f64,
    /// Least and greatest elevation there can be, in metres.
    pub range: [f64; 2],
    /// The material of number n in [`Surface::material`] is the one at n - 1.
    pub materials: Vec<Box<str>>,
}

impl Default for Legend {
    fn default() -> Self {
        Self { sea_level: 0.0, range: [-10_000.0, 9_000.0], materials: Vec::new() }
    }
}

/// Something that gives terrain over a window of the plane.
pub trait Source {
    /// How its surfaces can be drawn.
    fn legend(&self) -> Legend {
        Legend::default()
    }

    /// Fills `surface`, which has the window's size, with the terrain at the window's samples.
    ///
    /// The result at a sample depends on its coordinates, the spacing and the filter alone.
    fn sample(&self, window: &Window, surface: &mut Surface);
}
