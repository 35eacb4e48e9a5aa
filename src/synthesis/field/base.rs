//! The coarsest level: chunks of samples, region by region, joined over boundaries.

use super::{
    chunks::Quilt,
    pattern::HeightGrid,
    raster::{RegionRaster, squared_distances},
    relax::Slopes,
    source::{TypeSources, distance, shares},
};
use crate::{
    genetic::Draws,
    geometry::Stop,
    synthesis::{Analysis, Linking, SampleGrid, TypeModel},
};
use rayon::prelude::*;

/// Cells over which regions fade into each other (Saunders 2006, IV.3.2).
pub(super) const FALLOFF: f64 = 5.0;

/// Cells of grounds that are tried for a region, all together, and how many grounds at least and at most.
const TRIED_CELLS: usize = 3_000_000;
const TRIED: [usize; 2] = [4, 48];

/// Degrees between the slopes of a ground and those of its type's samples that count as much as all similarity.
const APART: f64 = 10.0;

/// A region of the base.
struct Part {
    region: u32,
    kind: usize,
    /// The cell in the north-west of what it reaches.
    corner: [usize; 2],
    size: [usize; 2],
    /// What each cell counts.
    alpha: Vec<f64>,
}

/// How much a region counts: 1 inside and 0 outside, with a linear falloff over its boundary.
fn part(raster: &RegionRaster, region: u32, kind: usize) -> Part {
    let (columns, rows) = (raster.frame.columns, raster.frame.rows);
    let (mut low, mut high) = ([columns, rows], [0, 0]);
    for cell in (0..columns * rows).filter(|cell| raster.regions[*cell] == region) {
        let at = [cell % columns, cell / columns];
        (low, high) = ([low[0].min(at[0]), low[1].min(at[1])], [high[0].max(at[0] + 1), high[1].max(at[1] + 1)]);
    }
    let reach = libm::ceil(FALLOFF / 2.0) as usize;
    let corner = low.map(|c| c.saturating_sub(reach));
    let size = [(high[0] + reach).min(columns) - corner[0], (high[1] + reach).min(rows) - corner[1]];
    let own = |cell: usize| raster.regions[(corner[1] + cell / size[0]) * columns + corner[0] + cell % size[0]] == region;
    let inside = squared_distances(size[0], size[1], |cell| !own(cell));
    let outside = squared_distances(size[0], size[1], own);
    // A boundary lies half a cell before the first cell beyond it.
    let alpha = (0..size[0] * size[1]).map(|cell| {
        let distance = if own(cell) { (inside[cell] as f64).sqrt() - 0.5 } else { 0.5 - (outside[cell] as f64).sqrt() };
        (0.5 + distance / FALLOFF).clamp(0.0, 1.0)
    });
    Part { region, kind, corner, size, alpha: alpha.collect() }
}

/// What a base is made of.
pub(super) struct Base<'a> {
    pub(super) raster: &'a RegionRaster,
    /// Samples by type.
    pub(super) types: &'a [TypeSources],
    /// What types are known by.
    pub(super) models: &'a [TypeModel],
    /// The type of a region.
    pub(super) kind: &'a (dyn Fn(u32) -> usize + Sync),
    pub(super) seed: u64,
}

impl Base<'_> {
    /// The ground; `None` if it was stopped.
    pub(super) fn ground(&self, stop: &Stop) -> Option<HeightGrid> {
        let (columns, rows) = (self.raster.frame.columns, self.raster.frame.rows);
        let (mut whole, mut weights) = (Slopes::new(columns, rows), vec![0.0; columns * rows]);
        let mut steps = [vec![0.0; columns * rows], vec![0.0; columns * rows]];
        let parts: Vec<Part> = self.raster.present().into_iter().map(|region| part(self.raster, region, (self.kind)(region))).collect();
        for part in &parts {
            let ground = self.region(part, stop)?;
            let slopes = Slopes::of(part.size[0], part.size[1], &ground);
            for (cell, alpha) in part.alpha.iter().enumerate() {
                let (x, y) = (cell % part.size[0], cell / part.size[0]);
                let to = (part.corner[1] + y) * columns + part.corner[0] + x;
                whole.heights[to] += alpha * slopes.heights[cell];
                weights[to] += alpha;
                if x + 1 < part.size[0] {
                    let share = alpha.min(part.alpha[cell + 1]);
                    whole.east[to] += share * slopes.east[cell];
                    steps[0][to] += share;
                }
                if y + 1 < part.size[1] {
                    let share = alpha.min(part.alpha[cell + part.size[0]]);
                    whole.south[to] += share * slopes.south[cell];
                    steps[1][to] += share;
                }
            }
        }
        let divide = |values: &mut [f64], weights: &[f64]| {
            values.iter_mut().zip(weights).filter(|(_, weight)| **weight > 0.0).for_each(|(value, weight)| *value /= weight);
        };
        divide(&mut whole.heights, &weights);
        divide(&mut whole.east, &steps[0]);
        divide(&mut whole.south, &steps[1]);
        let heights = if parts.len() > 1 { whole.relaxed(FALLOFF) } else { whole.heights.iter().map(|height| *height as f32).collect() };
        Some(HeightGrid { columns, rows, heights })
    }

    /// The ground of a region: of several that chance gives, the one that is the most similar to its type.
    fn region(&self, part: &Part, stop: &Stop) -> Option<Vec<f32>> {
        let cells = part.size[0] * part.size[1];
        let tried = (TRIED_CELLS / cells).clamp(TRIED[0], TRIED[1]);
        let grounds: Vec<Option<(f64, Vec<f32>)>> =
            (0..tried).into_par_iter().map(|number| if stop.is_set() { None } else { self.attempt(part, number) }).collect();
        if stop.is_set() {
            return None;
        }
        grounds.into_iter().flatten().reduce(|best, other| if other.0 > best.0 { other } else { best }).map(|(_, ground)| ground)
    }

    /// One ground and how similar it is.
    fn attempt(&self, part: &Part, number: usize) -> Option<(f64, Vec<f32>)> {
        let (stock, mut draws) = (&self.types[part.kind], Draws::of(self.seed, &[u64::from(part.region), number as u64]));
        let side = stock.sources.iter().map(|source| source.grid.columns.min(source.grid.rows)).max()?;
        // Whole, or of chunks of three sizes.
        let (chunk, length) = match number % 4 {
            0 => (part.size, FALLOFF),
            size => {
                let chunk = (side * (size + 1) / 5).max(6).min(side);
                ([chunk; 2], chunk as f64 / 3.0)
            }
        };
        let quilt = Quilt::new(stock, part.size, chunk, &mut draws).or_else(|| Quilt::new(stock, part.size, [side / 2 + 1; 2], &mut draws))?;
        let heights = quilt.slopes().relaxed(length.clamp(FALLOFF, 32.0));
        let grid = SampleGrid { columns: part.size[0], rows: part.size[1], spacing: [self.raster.frame.spacing; 2], heights };
        let analysis = Analysis::new(grid, None);
        let profile = analysis.profile_in(|cell| part.alpha[cell] >= 0.5, Linking::Whole);
        let slopes = shares(analysis.slope.iter().zip(&part.alpha).filter(|(_, alpha)| **alpha >= 0.5).map(|(slope, _)| *slope));
        let distance = distance(&slopes, &stock.slopes);
        Some((self.models[part.kind].value(&profile) - distance / APART, analysis.grid.heights))
    }
}
