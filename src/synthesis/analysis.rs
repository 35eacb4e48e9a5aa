//! What a sample is like at a level, found once.

use super::{
    edges::{self, Edge, EdgePoint, Linking},
    grid::{Crop, SampleGrid},
    level::Level,
    statistics::{Histogram, Statistics},
};
use serde::Serialize;
use sha2::{Digest, Sha256};

/// The distributions by which terrain is compared (Saunders 2006, Eq. IV.11).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Metres.
    Elevation,
    /// Degrees.
    Slope,
    /// Metres.
    EdgeScale,
    /// Metres.
    EdgeLength,
    /// What the detector answers.
    EdgeStrength,
}

impl Measure {
    /// In their order.
    pub const ALL: [Measure; 5] = [Measure::Elevation, Measure::Slope, Measure::EdgeScale, Measure::EdgeLength, Measure::EdgeStrength];
}

/// The distributions of some ground, in the order of [`Measure::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Profile(pub [Statistics; 5]);

/// A sample, or other terrain without voids, at one spacing.
#[derive(Clone, Debug, PartialEq)]
pub struct Analysis {
    /// Elevations in square cells.
    pub grid: SampleGrid,
    /// dz/dx to the east and dz/dy to the north.
    pub gradient: Vec<[f32; 2]>,
    /// Degrees.
    pub slope: Vec<f32>,
    /// Which cells count; all without it.
    pub mask: Option<Vec<bool>>,
    /// Points of edges where cells count.
    pub points: Vec<EdgePoint>,
    /// Edges over the whole area.
    pub edges: Vec<Edge>,
}

/// Third-order finite differences of the eight cells around (Horn 1981); over the border the ground goes on as it came.
pub(super) fn gradients(grid: &SampleGrid) -> Vec<[f32; 2]> {
    let (columns, rows) = (grid.columns, grid.rows);
    let on = |i: usize| f64::from(grid.heights[i]);
    // A row with a cell more at either end; a grid of one column or row is flat across.
    let wide = |row: usize| -> Vec<f64> {
        let (first, last) = (row * columns, (row + 1) * columns - 1);
        let ends = if columns > 1 { [2.0 * on(first) - on(first + 1), 2.0 * on(last) - on(last - 1)] } else { [on(first); 2] };
        std::iter::once(ends[0]).chain((first..=last).map(on)).chain(std::iter::once(ends[1])).collect()
    };
    let beyond = |edge: &[f64], inner: &[f64]| edge.iter().zip(inner).map(|(edge, inner)| 2.0 * edge - inner).collect::<Vec<f64>>();
    let [x, y] = grid.spacing.map(|spacing| 1.0 / (8.0 * spacing));
    let mut gradients = Vec::with_capacity(columns * rows);
    let mut middle = wide(0);
    let mut south = if rows > 1 { wide(1) } else { middle.clone() };
    let mut north = beyond(&middle, &south);
    for row in 0..rows {
        gradients.extend((1..=columns).map(|c| {
            let east = (north[c + 1] + south[c + 1]) + 2.0 * middle[c + 1];
            let west = (north[c - 1] + south[c - 1]) + 2.0 * middle[c - 1];
            let up = (north[c - 1] + north[c + 1]) + 2.0 * north[c];
            let down = (south[c - 1] + south[c + 1]) + 2.0 * south[c];
            [((east - west) * x) as f32, ((up - down) * y) as f32]
        }));
        let next = if row + 2 < rows { wide(row + 2) } else { beyond(&south, &middle) };
        (north, middle, south) = (middle, south, next);
    }
    gradients
}

/// Degrees of a gradient.
pub(super) fn degrees([east, north]: [f32; 2]) -> f32 {
    let (east, north) = (f64::from(east), f64::from(north));
    libm::atan((east * east + north * north).sqrt()).to_degrees() as f32
}

impl SampleGrid {
    /// SHA-256 of all that an analysis depends on, in hexadecimal: analyses can be kept under it and the level.
    #[must_use]
    pub fn content_hash(&self) -> String {
        let mut hash = Sha256::new();
        for number in [self.columns as u64, self.rows as u64, self.spacing[0].to_bits(), self.spacing[1].to_bits()] {
            hash.update(number.to_le_bytes());
        }
        for height in &self.heights {
            hash.update(height.to_le_bytes());
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl Analysis {
    /// Of a sample at a level, with a mask of the sample's cells that count; `None` if the sample does not reach the level (see [`SampleGrid::at`]).
    #[must_use]
    pub fn at(sample: &SampleGrid, mask: Option<&[bool]>, level: Level) -> Option<Self> {
        let grid = sample.at(level)?;
        let mask = mask.map(|mask| sample.mask_at(mask, level));
        Some(Self::new(grid, mask))
    }

    /// Of terrain without voids in square cells, and of which cells count.
    #[must_use]
    pub fn new(grid: SampleGrid, mask: Option<Vec<bool>>) -> Self {
        let gradient = gradients(&grid);
        let slope = gradient.iter().map(|gradient| degrees(*gradient)).collect();
        let mut points = edges::detect(&grid.heights, grid.columns, grid.rows, grid.spacing[0]);
        if let Some(mask) = &mask {
            points.retain(|point| mask[point.row * grid.columns + point.column]);
        }
        let edges = edges::link(&points, grid.spacing[0], Linking::Whole);
        Self { grid, gradient, slope, mask, points, edges }
    }

    /// The distributions over all cells that count.
    #[must_use]
    pub fn profile(&self) -> Profile {
        match &self.mask {
            None => profile(self.grid.heights.iter(), self.slope.iter(), &self.edges),
            Some(mask) => {
                let counts = |values: &[f32]| values.iter().zip(mask).filter(|(_, counts)| **counts).map(|(value, _)| *value).collect::<Vec<f32>>();
                profile(counts(&self.grid.heights).iter(), counts(&self.slope).iter(), &self.edges)
            }
        }
    }

    /// The distributions over a region of any shape: the cells, row by row, that belong to it and count. Edges are linked anew inside of it.
    #[must_use]
    pub fn profile_in(&self, region: impl Fn(usize) -> bool, linking: Linking) -> Profile {
        let counts = |cell: usize| region(cell) && self.mask.as_ref().is_none_or(|mask| mask[cell]);
        let cells: Vec<usize> = (0..self.grid.heights.len()).filter(|cell| counts(*cell)).collect();
        let points: Vec<EdgePoint> = self.points.iter().filter(|point| counts(point.row * self.grid.columns + point.column)).copied().collect();
        let edges = edges::link(&points, self.grid.spacing[0], linking);
        profile(cells.iter().map(|cell| &self.grid.heights[*cell]), cells.iter().map(|cell| &self.slope[*cell]), &edges)
    }

    /// The distributions over a rectangle.
    #[must_use]
    pub fn profile_of(&self, crop: Crop) -> Profile {
        let columns = self.grid.columns;
        let inside =
            |cell: usize| (crop.column..crop.column + crop.columns).contains(&(cell % columns)) && (crop.row..crop.row + crop.rows).contains(&(cell / columns));
        self.profile_in(inside, Linking::Whole)
    }

    /// How elevations and slopes are spread, for people: elevations in ranges between the least and the greatest, slopes in ranges of 0 … 90 degrees.
    #[must_use]
    pub fn histograms(&self, ranges: usize) -> [Histogram; 2] {
        let counts = |values: &[f32]| {
            values.iter().enumerate().filter(|(cell, _)| self.mask.as_ref().is_none_or(|mask| mask[*cell])).map(|(_, value)| *value).collect::<Vec<f32>>()
        };
        let heights = counts(&self.grid.heights);
        let (low, high) = heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| (low.min(*height), high.max(*height)));
        // Ground of one elevation, and none at all.
        let (low, high) = match (f64::from(low), f64::from(high)) {
            (low, high) if low < high => (low, high),
            (low, _) if low.is_finite() => (low, low + 1.0),
            _ => (0.0, 1.0),
        };
        [Histogram::of(heights.into_iter(), low, high, ranges), Histogram::of(counts(&self.slope).into_iter(), 0.0, 90.0, ranges)]
    }
}

fn profile<'a>(heights: impl Iterator<Item = &'a f32> + Clone, slopes: impl Iterator<Item = &'a f32> + Clone, edges: &[Edge]) -> Profile {
    Profile([
        Statistics::of(heights.map(|height| f64::from(*height))),
        Statistics::of(slopes.map(|slope| f64::from(*slope))),
        Statistics::of(edges.iter().map(|edge| edge.scale)),
        Statistics::of(edges.iter().map(|edge| edge.length)),
        Statistics::of(edges.iter().map(|edge| edge.strength)),
    ])
}
