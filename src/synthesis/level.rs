//! Levels of detail by powers of three, and how a sample is brought to one.

use super::grid::SampleGrid;
use core::f64::consts::PI;
use serde::{Deserialize, Serialize};

/// Cells of a gene a side where there is room.
pub const GENE_SIDE: usize = 16;

/// Cells of a gene a side at least.
pub const LEAST_GENE_SIDE: usize = 8;

/// Genes that a sample holds a side at least.
const GENES: usize = 3;

/// Lobes of the low-pass on either side.
const LOBES: f64 = 3.0;

/// How much finer than its own spacing a sample may be brought: 92.6 m (3″) become 90 m.
const FINEST: f64 = 0.8;

/// A level of detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "f64", into = "f64")]
pub struct Level(u8);

impl Level {
    /// From the finest (10 m) to the coarsest (810 m).
    pub const ALL: [Level; 5] = [Level(0), Level(1), Level(2), Level(3), Level(4)];

    /// Metres between cells.
    #[must_use]
    pub fn spacing(self) -> f64 {
        [10.0, 30.0, 90.0, 270.0, 810.0][usize::from(self.0)]
    }
}

impl TryFrom<f64> for Level {
    type Error = String;

    fn try_from(spacing: f64) -> Result<Self, String> {
        Self::ALL.into_iter().find(|level| level.spacing() == spacing).ok_or_else(|| format!("must be 10, 30, 90, 270 or 810 metres, is {spacing}"))
    }
}

impl From<Level> for f64 {
    fn from(level: Level) -> Self {
        level.spacing()
    }
}

/// Cells a side of the genes that a grid holds three times three of; `None` if these would be smaller than [`LEAST_GENE_SIDE`].
#[must_use]
pub fn gene_side(grid: &SampleGrid) -> Option<usize> {
    let side = (grid.columns.min(grid.rows) / GENES).min(GENE_SIDE);
    (side >= LEAST_GENE_SIDE).then_some(side)
}

/// One cell of a level along an axis: the first cell of the sample that it takes from, and what each counts.
struct Taps {
    first: usize,
    weights: Vec<f64>,
}

/// sin(πx) / πx.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

/// The low-pass (a sinc in a window of three lobes, after Lanczos) for `count` cells `ratio` cells of the sample apart, in its middle. What reaches over an end is left out and the rest
/// counts more.
fn taps(cells: usize, count: usize, ratio: f64) -> Vec<Taps> {
    // Going finer, the sample's own band is the narrower.
    let width = ratio.max(1.0);
    let start = (cells as f64 - count as f64 * ratio) / 2.0;
    let taps = |i: usize| {
        let middle = start + (i as f64 + 0.5) * ratio - 0.5;
        let first = libm::ceil(middle - LOBES * width).max(0.0) as usize;
        let last = (libm::floor(middle + LOBES * width) as usize).min(cells - 1);
        let mut weights: Vec<f64> =
            (first..=last).map(|cell| (cell as f64 - middle) / width).map(|x| if x.abs() < LOBES { sinc(x) * sinc(x / LOBES) } else { 0.0 }).collect();
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        Taps { first, weights }
    };
    (0..count).map(taps).collect()
}

impl SampleGrid {
    /// The same ground with square cells of a level, as many as fit, in the middle; `None` if the level is finer than the sample, or no cell fits. There must be no voids.
    #[must_use]
    pub fn at(&self, level: Level) -> Option<SampleGrid> {
        let spacing = level.spacing();
        let [x, y] = self.spacing.map(|own| spacing / own);
        // As many as fit, but for rounding.
        let fit = |cells: usize, ratio: f64| (cells as f64 / ratio + 1e-9) as usize;
        let (columns, rows) = (fit(self.columns, x), fit(self.rows, y));
        if x.min(y) < FINEST || columns == 0 || rows == 0 {
            return None;
        }
        let across = taps(self.columns, columns, x);
        let narrow: Vec<f64> = (0..self.rows)
            .flat_map(|row| {
                let row = self.row(row);
                across.iter().map(|taps| row[taps.first..].iter().zip(&taps.weights).map(|(height, weight)| f64::from(*height) * weight).sum())
            })
            .collect();
        let mut heights = Vec::with_capacity(columns * rows);
        let mut sums = vec![0.0; columns];
        for taps in taps(self.rows, rows, y) {
            sums.fill(0.0);
            for (row, weight) in narrow[taps.first * columns..].chunks_exact(columns).zip(&taps.weights) {
                sums.iter_mut().zip(row).for_each(|(sum, height)| *sum += height * weight);
            }
            heights.extend(sums.iter().map(|sum| *sum as f32));
        }
        Some(SampleGrid { columns, rows, spacing: [spacing; 2], heights })
    }

    /// A mask of this grid's cells for the cells of [`at`](Self::at): of each the cell that its middle lies in.
    #[must_use]
    pub fn mask_at(&self, mask: &[bool], level: Level) -> Vec<bool> {
        let [(columns, x), (rows, y)] = [(self.columns, self.spacing[0]), (self.rows, self.spacing[1])].map(|(cells, own)| {
            let ratio = level.spacing() / own;
            let count = (cells as f64 / ratio + 1e-9) as usize;
            let start = (cells as f64 - count as f64 * ratio) / 2.0;
            (cells, (0..count).map(|i| (start + (i as f64 + 0.5) * ratio) as usize).collect::<Vec<_>>())
        });
        y.iter().flat_map(|row| x.iter().map(move |column| mask[(*row).min(rows - 1) * columns + (*column).min(columns - 1)])).collect()
    }
}
