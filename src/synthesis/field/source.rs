//! Samples of a type at a level, with what genes are chosen by.

use super::{
    gene::{Gene, Layout, Turn},
    pattern::detail,
};
use crate::genetic::Draws;
use crate::synthesis::{analysis::Analysis, grid::SampleGrid, windows::Windows};

/// Means over the squares around every cell.
#[derive(Clone, Debug)]
pub(super) struct Means {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Metres.
    pub(super) mean: Vec<f32>,
    /// Rise to the east and to the south.
    pub(super) gradient: Vec<[f32; 2]>,
}

impl Means {
    /// Of a grid and its gradients (to the east and to the north).
    pub(super) fn new(grid: &SampleGrid, gradient: &[[f32; 2]], reach: usize) -> Self {
        let Windows { mean, gradient, .. } = Windows::new(grid, gradient, reach);
        Self { columns: grid.columns, rows: grid.rows, mean, gradient: gradient.into_iter().map(|[east, north]| [east, -north]).collect() }
    }

    /// The cell nearest to a place.
    pub(super) fn cell(&self, column: isize, row: isize) -> usize {
        let clamp = |at: isize, cells: usize| at.clamp(0, cells as isize - 1) as usize;
        clamp(row, self.rows) * self.columns + clamp(column, self.columns)
    }
}

/// Means over whole genes, over thirds of them and over the cells of the level before.
#[derive(Clone, Debug)]
pub(super) struct Scales {
    pub(super) gene: Means,
    pub(super) part: Means,
    pub(super) cell: Means,
}

impl Scales {
    pub(super) fn new(grid: &SampleGrid, gradient: &[[f32; 2]], layout: &Layout) -> Self {
        let means = |reach| Means::new(grid, gradient, reach);
        Self { gene: means(layout.reach), part: means((layout.reach / 3).max(1)), cell: means(1) }
    }
}

/// A sample at a level.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) grid: SampleGrid,
    pub(super) scales: Scales,
    /// What the level before does not hold, metres.
    pub(super) detail: Vec<f32>,
    /// Sums of cells that do not count from the north-western corner; nothing where all count.
    masked: Vec<u32>,
}

impl Source {
    fn new(analysis: &Analysis, layout: &Layout) -> Self {
        let (columns, rows) = (analysis.grid.columns, analysis.grid.rows);
        let masked = analysis.mask.as_ref().map_or_else(Vec::new, |mask| {
            let mut sums = vec![0; (columns + 1) * (rows + 1)];
            for row in 0..rows {
                let mut line = 0;
                for column in 0..columns {
                    line += u32::from(!mask[row * columns + column]);
                    sums[(row + 1) * (columns + 1) + column + 1] = sums[row * (columns + 1) + column + 1] + line;
                }
            }
            sums
        });
        Self { scales: Scales::new(&analysis.grid, &analysis.gradient, layout), detail: detail(&analysis.grid), grid: analysis.grid.clone(), masked }
    }

    /// Whether a square of cells lies inside of it and all of it counts.
    pub(super) fn holds(&self, column: i32, row: i32, reach: usize) -> bool {
        let (reach, side) = (reach as i32, 2 * reach as i32 + 1);
        self.counts([column - reach, row - reach], [side, side])
    }

    /// Whether a rectangle of cells lies inside of it and all of it counts.
    pub(super) fn counts(&self, [west, north]: [i32; 2], [columns, rows]: [i32; 2]) -> bool {
        let (east, south) = (west + columns, north + rows);
        if west < 0 || north < 0 || east > self.grid.columns as i32 || south > self.grid.rows as i32 {
            return false;
        }
        if self.masked.is_empty() {
            return true;
        }
        let at = |column: i32, row: i32| self.masked[row as usize * (self.grid.columns + 1) + column as usize];
        at(east, south) + at(west, north) == at(west, south) + at(east, north)
    }
}

/// The samples of a type at a level that genes can point into.
#[derive(Clone, Debug)]
pub(super) struct TypeSources {
    pub(super) sources: Vec<Source>,
    /// Greatest less least elevation, metres.
    pub(super) range: f64,
    /// The greatest slope of a mean over a gene.
    pub(super) steepest: f64,
    /// Shares of slopes below every quarter of a degree.
    pub(super) slopes: Vec<f64>,
    /// Where a gene can point to in each, as a weight.
    places: Vec<f64>,
}

/// Slopes in a degree that are told apart.
const FINE: f64 = 4.0;

/// Shares of slopes, degrees, that are below every quarter of a degree.
pub(super) fn shares(slopes: impl Iterator<Item = f32>) -> Vec<f64> {
    let mut counts = vec![0_usize; (90.0 * FINE) as usize];
    let last = counts.len() - 1;
    slopes.for_each(|slope| counts[((f64::from(slope) * FINE) as usize).min(last)] += 1);
    let all = counts.iter().sum::<usize>().max(1) as f64;
    let mut below = 0;
    let share = |count: &usize| {
        below += count;
        below as f64 / all
    };
    counts.iter().map(share).collect()
}

/// How far slopes lie apart in the mean, degrees: the Wasserstein distance of distributions.
pub(super) fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).sum::<f64>() / FINE
}

/// How often a place is drawn before one that does not count will do.
const TRIES: usize = 64;

impl TypeSources {
    /// Of all that are large enough.
    pub(super) fn new(analyses: &[Analysis], layout: &Layout) -> Self {
        let large = |analysis: &&Analysis| analysis.grid.columns.min(analysis.grid.rows) >= layout.side();
        let sources: Vec<Source> = analyses.iter().filter(large).map(|analysis| Source::new(analysis, layout)).collect();
        let heights = || sources.iter().flat_map(|source| &source.grid.heights);
        let [low, high] = heights().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], height| [low.min(*height), high.max(*height)]);
        let slope = |[x, y]: &[f32; 2]| f64::from(*x) * f64::from(*x) + f64::from(*y) * f64::from(*y);
        let steepest = sources.iter().flat_map(|source| source.scales.gene.gradient.iter().map(slope)).fold(0.0, f64::max).sqrt();
        let counts = |analysis: &Analysis, cell: usize| analysis.mask.as_ref().is_none_or(|mask| mask[cell]);
        let all =
            analyses.iter().flat_map(|analysis| analysis.slope.iter().enumerate().filter(move |(cell, _)| counts(analysis, *cell)).map(|(_, slope)| *slope));
        let slopes = shares(all);
        let free = |cells: usize| (cells - layout.side() + 1) as f64;
        let places = sources.iter().map(|source| free(source.grid.columns) * free(source.grid.rows)).collect();
        Self { range: f64::from(high - low).max(1e-3), steepest: steepest.max(1e-6), slopes, places, sources }
    }

    /// A place by chance, turned by quarters and mirrored by chance.
    pub(super) fn draw(&self, layout: &Layout, draws: &mut Draws) -> Gene {
        let mut gene = Gene::default();
        for _ in 0..TRIES {
            let sample = draws.weighted(&self.places);
            let grid = &self.sources[sample].grid;
            let place = |cells: usize, draws: &mut Draws| (layout.reach + draws.below(cells - layout.side() + 1)) as i32;
            let (column, row) = (place(grid.columns, draws), place(grid.rows, draws));
            gene = Gene { sample: sample as u32, column, row, turn: Turn(draws.below(8) as u8), ..Gene::default() };
            if self.sources[sample].holds(column, row, layout.reach) {
                break;
            }
        }
        gene
    }
}
