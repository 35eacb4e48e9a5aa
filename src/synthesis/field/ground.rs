//! The genetic algorithm of one level: what is bred and how fit it is (Saunders 2006, IV.3.2).

use super::{
    fit::{Fit, Target},
    gene::{Gene, Layout, Reading, Stock},
    options::FieldOptions,
    pattern::HeightGrid,
    raster::RegionRaster,
    source::{Scales, TypeSources},
    tally::{BLOCK, Block, Blocks, NOWHERE},
};
use crate::{
    genetic::{Draws, Problem},
    geometry::Stop,
    synthesis::{Measure, TypeModel, analysis::gradients, edges, grid::SampleGrid},
};

/// A region whose similarity counts.
pub(super) struct Region {
    /// Its type.
    pub(super) kind: usize,
    /// Cells.
    pub(super) area: usize,
}

/// All that the genes of a level are judged by.
pub(super) struct Ground<'a> {
    pub(super) layout: Layout,
    pub(super) types: &'a [TypeSources],
    /// Of every gene its type.
    pub(super) kinds: Vec<usize>,
    /// Of every gene its region, if it lies in one.
    pub(super) gene_regions: Vec<u16>,
    pub(super) targets: Vec<Target>,
    pub(super) options: &'a FieldOptions,
    models: &'a [TypeModel],
    pub(super) regions: Vec<Region>,
    cell_regions: Vec<u16>,
    /// The level before at this level's cells.
    pattern: Vec<f32>,
    spacing: f64,
    reach: usize,
    middle: f32,
}

/// What is known of a genome.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Evaluation {
    /// The level before, and the details that the genes blend to.
    pub(super) ground: HeightGrid,
    blocks: Vec<Block>,
    /// Of every gene.
    pub(super) fits: Vec<Fit>,
    /// Of every region.
    pub(super) similarities: Vec<f64>,
    /// Of every region the mean slope that its type has, over its own.
    pub(super) flatness: Vec<f64>,
    /// Mean over genes.
    pub(super) compatibility: f64,
    /// Mean over regions by area.
    pub(super) similarity: f64,
    /// Half of each.
    pub(super) fitness: f64,
}

/// Rectangles of set places: runs along rows.
fn runs(set: &[bool], columns: usize) -> impl Iterator<Item = ([usize; 2], usize)> {
    set.chunks(columns).enumerate().flat_map(move |(row, line)| {
        let begins = (0..columns).filter(move |x| line[*x] && (*x == 0 || !line[*x - 1]));
        begins.map(move |x| ([x, (x..columns).find(|x| !line[*x]).unwrap_or(columns)], row))
    })
}

/// Sets the places around those that are set.
fn dilated(set: &[bool], [columns, rows]: [usize; 2], by: usize) -> Vec<bool> {
    let mut out = vec![false; set.len()];
    for ([from, to], row) in runs(set, columns) {
        for row in row.saturating_sub(by)..(row + by + 1).min(rows) {
            out[row * columns + from.saturating_sub(by)..row * columns + (to + by).min(columns)].fill(true);
        }
    }
    out
}

impl<'a> Ground<'a> {
    /// Of a level that follows a `pattern`, three times as coarse. `kind` gives a region's type.
    pub(super) fn new(
        raster: &RegionRaster,
        pattern: &HeightGrid,
        gene: usize,
        kind: &dyn Fn(u32) -> usize,
        (types, models): (&'a [TypeSources], &'a [TypeModel]),
        options: &'a FieldOptions,
    ) -> Self {
        let cells = [raster.frame.columns, raster.frame.rows];
        let layout = Layout::new(cells, gene);
        let finer = pattern.finer(cells[0], cells[1]);
        let grid = SampleGrid { columns: cells[0], rows: cells[1], spacing: [raster.frame.spacing; 2], heights: finer.heights };
        let scales = Scales::new(&grid, &gradients(&grid), &layout);
        let targets = (0..layout.count()).map(|gene| Target::new(&scales, &layout, gene)).collect();
        let present = raster.present();
        let number = |region: u32| present.partition_point(|known| *known < region) as u16;
        let at = |gene: usize| {
            let [x, y] = layout.middle(gene);
            y.min(cells[1] - 1) * cells[0] + x.min(cells[0] - 1)
        };
        let kinds = (0..layout.count()).map(|gene| kind(raster.regions[at(gene)])).collect();
        let gene_regions = (0..layout.count()).map(|gene| number(raster.regions[at(gene)])).collect();
        let cell_regions: Vec<u16> =
            raster.regions.iter().zip(&raster.inside).map(|(region, inside)| if *inside { number(*region) } else { NOWHERE }).collect();
        let area = |number: usize| cell_regions.iter().filter(|region| usize::from(**region) == number).count();
        let regions = present.iter().enumerate().map(|(number, region)| Region { kind: kind(*region), area: area(number) }).collect();
        let middle = grid.heights[grid.heights.len() / 2];
        Self {
            layout,
            types,
            kinds,
            gene_regions,
            targets,
            options,
            models,
            regions,
            cell_regions,
            spacing: raster.frame.spacing,
            reach: edges::reach(),
            middle,
            pattern: grid.heights,
        }
    }

    fn blocks(&self) -> Blocks<'_> {
        let side = BLOCK * self.layout.pitch;
        let reference = |region: &Region| self.models[region.kind].projections.map(|statistics| statistics[0].mean);
        Blocks {
            regions: &self.cell_regions,
            references: self.regions.iter().map(reference).collect(),
            spacing: self.spacing,
            side,
            count: self.layout.cells.map(|cells| cells.div_ceil(side)),
            middle: self.middle,
            reach: self.reach,
        }
    }

    /// The distributions of every region.
    #[cfg(test)]
    pub(super) fn profiles(&self, known: &Evaluation) -> Vec<crate::synthesis::Profile> {
        self.blocks().profiles(&known.blocks)
    }

    /// The region of a cell.
    #[cfg(test)]
    pub(super) fn region_of(&self, cell: usize) -> Option<usize> {
        (self.cell_regions[cell] != NOWHERE).then(|| usize::from(self.cell_regions[cell]))
    }

    /// The type of a gene.
    pub(super) fn kind(&self, gene: usize) -> &'a TypeSources {
        &self.types[self.kinds[gene]]
    }

    /// What is not yet known of any genome.
    fn empty(&self) -> Evaluation {
        let [columns, rows] = self.layout.cells;
        let flat = HeightGrid { columns, rows, heights: vec![0.0; columns * rows] };
        let blocks = self.blocks().count;
        Evaluation {
            ground: flat,
            blocks: vec![Vec::new(); blocks[0] * blocks[1]],
            fits: vec![Fit::default(); self.layout.count()],
            similarities: Vec::new(),
            flatness: Vec::new(),
            compatibility: 0.0,
            similarity: 0.0,
            fitness: 0.0,
        }
    }

    /// Brings up to date what changed genes change.
    fn update(&self, genome: &[Gene], changed: &[bool], known: &mut Evaluation) {
        let Layout { pitch, genes, cells, .. } = self.layout;
        for gene in (0..changed.len()).filter(|gene| changed[*gene]) {
            known.fits[gene] = Fit::new(&genome[gene], self.kind(gene), &self.targets[gene], &self.layout);
        }
        let rectangle = |[from, to]: [usize; 2], row: usize| ([from * pitch, (to * pitch).min(cells[0])], [row * pitch, ((row + 1) * pitch).min(cells[1])]);
        let stock = Stock { types: self.types, kinds: &self.kinds, reading: Reading::Detail };
        let near = dilated(changed, genes, 1);
        for (run, row) in runs(&near, genes[0]) {
            let (across, down) = rectangle(run, row);
            self.layout.decode(genome, &stock, &mut known.ground, across, down);
            for row in down[0]..down[1] {
                let cells = row * cells[0] + across[0]..row * cells[0] + across[1];
                known.ground.heights[cells.clone()].iter_mut().zip(&self.pattern[cells]).for_each(|(detail, pattern)| *detail += pattern);
            }
        }
        let blocks = self.blocks();
        let mut dirty = vec![false; blocks.count[0] * blocks.count[1]];
        for (run, row) in runs(&near, genes[0]) {
            let (across, down) = rectangle(run, row);
            let reached =
                |[from, to]: [usize; 2], axis: usize| from.saturating_sub(self.reach) / blocks.side..((to + self.reach).min(cells[axis])).div_ceil(blocks.side);
            for row in reached(down, 1) {
                reached(across, 0).for_each(|column| dirty[row * blocks.count[0] + column] = true);
            }
        }
        blocks.update(&known.ground, &dirty, &mut known.blocks);
        self.judge(&blocks, known);
    }

    /// The numbers that follow from parts.
    fn judge(&self, blocks: &Blocks, known: &mut Evaluation) {
        let profiles = blocks.profiles(&known.blocks);
        known.similarities = profiles.iter().zip(&self.regions).map(|(profile, region)| self.models[region.kind].value(profile)).collect();
        let slope = Measure::Slope as usize;
        let flatness = profiles.iter().zip(&self.regions).map(|(profile, region)| {
            let wanted = self.models[region.kind].projections[slope][0].mean;
            if profile.0[slope].mean > 0.0 { (wanted / profile.0[slope].mean).clamp(0.5, 2.0) } else { 1.0 }
        });
        known.flatness = flatness.collect();
        let area: usize = self.regions.iter().map(|region| region.area).sum();
        let similar: f64 = known.similarities.iter().zip(&self.regions).map(|(similarity, region)| similarity * region.area as f64).sum();
        known.similarity = similar / area.max(1) as f64;
        known.compatibility = known.fits.iter().map(|fit| fit.value).sum::<f64>() / known.fits.len().max(1) as f64;
        known.fitness = 0.5 * known.compatibility + 0.5 * known.similarity;
    }
}

impl Problem for Ground<'_> {
    type Genome = Vec<Gene>;
    type Evaluation = Evaluation;
    /// Genes, in no order and perhaps twice.
    type Change = Vec<usize>;

    fn initialise(&self, _: usize, draws: &mut Draws) -> Vec<Gene> {
        self.first(draws)
    }

    fn cross(&self, child: &mut Vec<Gene>, mate: &Vec<Gene>, change: &mut Vec<usize>, draws: &mut Draws) {
        self.swap(child, mate, change, draws);
    }

    fn mutate(&self, child: &mut Vec<Gene>, parent: &Evaluation, change: &mut Vec<usize>, draws: &mut Draws) {
        self.mutated(child, parent, change, draws);
    }

    fn evaluate(&self, genome: &Vec<Gene>, from: Option<(&Evaluation, &Vec<usize>)>, stop: &Stop) -> Evaluation {
        let (mut known, changed) = match from {
            None => (self.empty(), vec![true; genome.len()]),
            Some((parent, change)) => {
                let mut changed = vec![false; genome.len()];
                for gene in change {
                    changed[*gene] = true;
                }
                (parent.clone(), changed)
            }
        };
        if !stop.is_set() {
            self.update(genome, &changed, &mut known);
        }
        known
    }

    fn fitness(&self, evaluation: &Evaluation) -> f64 {
        evaluation.fitness
    }
}
