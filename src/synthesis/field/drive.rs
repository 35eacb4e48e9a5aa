//! From a library and a map to ground at every level.

use super::{
    base::Base,
    gene::{Gene, Layout},
    ground::Ground,
    options::FieldOptions,
    pattern::HeightGrid,
    raster::{Frame, RegionRaster},
    report::{FieldCheckpoint, FieldGeneration, FieldLevel, FieldProgress, FieldStep, MAX_FIELD_CELLS},
    source::TypeSources,
    tally::BLOCK,
};
use crate::{
    genetic::{Evolution, Individual, Problem, Shared, State},
    geometry::Stop,
    noise::{key, mix},
    synthesis::{
        Analysis, Level, Library, LibraryProblem, Linking, Map, Model, Profile, ReadyLibrary, Refinement, SampleGrid, Topology, TypeModel, gene_side, refine,
    },
};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// New ground by example: a genetic algorithm blends pieces of the samples of every region's type, level by level from the coarsest to the finest that all types have in common.
///
/// The same library, map and options give the same bits at any number of threads, also when it was stopped and goes on from a checkpoint.
#[derive(Clone, Debug)]
pub struct Synthesis<'a> {
    ready: &'a ReadyLibrary,
    topology: Topology,
    map: Map,
    /// Of every region of the map its type.
    kinds: Vec<usize>,
    /// By two types.
    smoothness: Vec<Vec<f64>>,
    options: FieldOptions,
    levels: Vec<Level>,
    checkpoint: FieldCheckpoint,
}

/// What samples give at a level.
struct Material {
    types: Vec<TypeSources>,
    /// By which whole regions are compared.
    whole: Vec<TypeModel>,
    /// By which grounds are compared whose edges are linked within blocks.
    blocks: Vec<TypeModel>,
    gene: usize,
}

/// Models of types whose edges are linked within blocks.
fn block_models(analyses: &[Vec<Analysis>], side: usize) -> Vec<TypeModel> {
    let linked = |analysis: &Analysis| analysis.profile_in(|_| true, Linking::Blocks(side));
    let profiles: Vec<Vec<Profile>> = analyses.par_iter().map(|samples| samples.iter().map(linked).collect()).collect();
    let alone = profiles.iter().all(|profiles| profiles.len() < 2);
    let quarters = |analysis: &Analysis| {
        let crops = analysis.grid.quarters().into_iter().filter(|crop| crop.columns > 0 && crop.rows > 0);
        crops.filter_map(|crop| analysis.grid.crop(crop)).map(|part| linked(&Analysis::new(part, None))).collect::<Vec<_>>()
    };
    let parts: Vec<Vec<Profile>> = analyses.iter().map(|samples| if alone { samples.iter().flat_map(quarters).collect() } else { Vec::new() }).collect();
    Model::of_profiles(&profiles, &parts).types
}

impl<'a> Synthesis<'a> {
    /// Of a library whose samples are read, and a map.
    ///
    /// # Errors
    /// If the map is wrong, names a type that the library does not have, its types have no level in common, or an option is out of its range; with a pointer into the map, or `/options` and on.
    pub fn new(library: &Library, ready: &'a ReadyLibrary, map: &Map, options: FieldOptions) -> Result<Self, LibraryProblem> {
        options.check().map_err(|error| LibraryProblem { pointer: format!("/options{}", error.at), detail: error.message })?;
        let topology = map.topology()?;
        let names: Vec<&str> = library.types.iter().map(|kind| kind.name.as_str()).collect();
        let mut kinds = Vec::with_capacity(map.regions.len());
        for (number, region) in map.regions.iter().enumerate() {
            let kind = names.iter().position(|name| *name == region.kind);
            kinds.push(kind.ok_or_else(|| LibraryProblem {
                pointer: format!("/regions/{number}/type"),
                detail: format!("there is no type {:?} in the library, which has {}", region.kind, names.join(", ")),
            })?);
        }
        let mut levels = ready.common_levels(&kinds);
        levels.reverse();
        if let Some(finest) = options.finest {
            levels.retain(|level| *level >= finest);
        }
        if levels.is_empty() {
            let named = |kind: &usize| format!("{} at {:?}", names[*kind], ready.levels(*kind).into_iter().map(Level::spacing).collect::<Vec<_>>());
            let mut used = kinds.clone();
            used.sort_unstable();
            used.dedup();
            let which = used.iter().map(named).collect::<Vec<_>>().join(", ");
            return Err(LibraryProblem {
                pointer: "/regions".to_owned(),
                detail: format!("its types have no level in common that is not finer than asked for: {which}"),
            });
        }
        check_size(map, levels.last().map_or(1.0, |level| level.spacing()))?;
        let smoothness = names.iter().map(|one| names.iter().map(|other| library.smoothness_between(one, other)).collect()).collect();
        let checkpoint = FieldCheckpoint { inputs: inputs(library, ready, map, &options), done: Vec::new(), current: None };
        Ok(Self { ready, topology, map: map.clone(), kinds, smoothness, options, levels, checkpoint })
    }

    /// Goes on from a checkpoint.
    ///
    /// # Errors
    /// As [`new`](Self::new), or if the checkpoint is of something else or does not fit together.
    pub fn resume(library: &Library, ready: &'a ReadyLibrary, map: &Map, options: FieldOptions, checkpoint: FieldCheckpoint) -> Result<Self, LibraryProblem> {
        let mut new = Self::new(library, ready, map, options)?;
        let problem = |pointer: &str, detail: &str| LibraryProblem { pointer: format!("/checkpoint{pointer}"), detail: detail.to_owned() };
        if checkpoint.inputs != new.checkpoint.inputs {
            return Err(problem("/inputs", "is that of another library, map or options"));
        }
        let sound = |(level, done): (&Level, &FieldLevel)| {
            let frame = Frame::around(map, level.spacing());
            done.level == *level && [done.columns, done.rows] == [frame.columns, frame.rows] && done.heights.len() == frame.cells()
        };
        if checkpoint.done.len() > new.levels.len() || !new.levels.iter().zip(&checkpoint.done).all(sound) {
            return Err(problem("/done", "are not levels of this map from the coarsest on"));
        }
        if checkpoint.current.is_some() && (checkpoint.done.is_empty() || checkpoint.done.len() == new.levels.len()) {
            return Err(problem("/current", "is of no level"));
        }
        new.checkpoint = checkpoint;
        Ok(new)
    }

    /// Levels that are made, from the coarsest.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// What it goes on from.
    #[must_use]
    pub fn checkpoint(&self) -> &FieldCheckpoint {
        &self.checkpoint
    }

    /// SHA-256 of all that the ground depends on, in hexadecimal: its name.
    #[must_use]
    pub fn inputs(&self) -> &str {
        &self.checkpoint.inputs
    }

    /// Whether all levels are done.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.checkpoint.done.len() == self.levels.len()
    }

    /// Levels that are done, from the coarsest: the pyramid.
    #[must_use]
    pub fn pyramid(&self) -> &[FieldLevel] {
        &self.checkpoint.done
    }

    /// The map at a level, its boundaries refined.
    #[must_use]
    pub fn raster(&self, level: Level) -> RegionRaster {
        let smoothness = |a: usize, b: usize| self.smoothness[self.kinds[a]][self.kinds[b]];
        // Curves are refined for the finest level and drawn at all, so that regions are the same ground at every level.
        let spacing = self.levels.last().map_or(level.spacing(), |finest| finest.spacing());
        let refined = refine(&self.topology, &smoothness, Refinement { spacing, seed: self.options.seed });
        RegionRaster::new(&self.topology, &refined, Frame::around(&self.map, level.spacing()))
    }

    /// Makes what is left to be made, on the pool that it is called on. `each` is told after every generation and says whether to go on. Answers whether all is done; if not, it goes on where it stopped.
    pub fn run(&mut self, stop: &Stop, each: &mut dyn FnMut(&FieldStep) -> bool) -> bool {
        while !self.is_done() {
            if stop.is_set() || !self.level(stop, each) {
                return false;
            }
        }
        true
    }

    fn material(&self, level: Level) -> Material {
        let analyses = self.ready.analyse(level);
        let side = |samples: &Vec<Analysis>| samples.iter().filter_map(|analysis| gene_side(&analysis.grid)).max();
        let sides = self.kinds.iter().filter_map(|kind| analyses.get(*kind).and_then(side));
        let gene = sides.min().unwrap_or(crate::synthesis::LEAST_GENE_SIDE).min(self.options.gene);
        let layout = Layout::new([1, 1], gene);
        let types = analyses.par_iter().map(|samples| TypeSources::new(samples, &layout)).collect();
        let whole = Model::new(&analyses.iter().map(|samples| samples.iter().collect()).collect::<Vec<_>>()).types;
        Material { types, whole, blocks: block_models(&analyses, BLOCK * layout.pitch), gene }
    }

    /// Makes the next level.
    fn level(&mut self, stop: &Stop, each: &mut dyn FnMut(&FieldStep) -> bool) -> bool {
        let number = self.checkpoint.done.len();
        let level = self.levels[number];
        let (material, raster) = (self.material(level), self.raster(level));
        let kinds = self.kinds.clone();
        let kind = |region: u32| kinds[region as usize];
        let made = match self.checkpoint.done.last() {
            None => {
                let seed = key(mix(self.options.seed), 0xba5e);
                let base = Base { raster: &raster, types: &material.types, models: &material.whole, kind: &kind, seed };
                let Some(heights) = base.ground(stop) else { return false };
                let similarity = whole_similarity(&heights, &raster, &kind, &material.whole);
                done(level, heights, [similarity, 1.0, similarity, similarity], 0)
            }
            Some(before) => {
                let pattern = HeightGrid { columns: before.columns, rows: before.rows, heights: before.heights.clone() };
                let options = self.options;
                let ground = Ground::new(&raster, &pattern, material.gene, &kind, (&material.types, &material.blocks), &options);
                let Some(made) = self.bred(&ground, number, stop, each) else { return false };
                let (evaluation, evaluations) = made;
                let whole = whole_similarity(&evaluation.ground, &raster, &kind, &material.whole);
                done(level, evaluation.ground, [evaluation.fitness, evaluation.compatibility, evaluation.similarity, whole], evaluations)
            }
        };
        self.checkpoint.done.push(made);
        self.checkpoint.current = None;
        let made = &self.checkpoint.done[number];
        let progress = self.progress(number, self.options.generations, made.fitness);
        each(&FieldStep { progress, checkpoint: &self.checkpoint, columns: made.columns, heights: &made.heights })
    }

    /// The best ground of a level; `None` if it was stopped or is not to go on.
    fn bred(&mut self, ground: &Ground, number: usize, stop: &Stop, each: &mut dyn FnMut(&FieldStep) -> bool) -> Option<(super::ground::Evaluation, u64)> {
        let settings = self.options.settings();
        let seed = key(mix(self.options.seed), number as u64);
        let mut evolution = match self.checkpoint.current.take() {
            Some(current) if current.genomes.len() == settings.population && current.genomes.iter().all(|genome| ground.takes(genome)) => {
                let individual = |genome: &Vec<Gene>| {
                    let evaluation = ground.evaluate(genome, None, stop);
                    Shared::new(Individual { genome: genome.clone(), fitness: evaluation.fitness, evaluation })
                };
                let island = current.genomes.par_iter().map(individual).collect();
                let state = State { seed, settings, generation: current.generation, evaluations: current.evaluations, islands: vec![island] };
                self.checkpoint.current = Some(current);
                Evolution::resume(ground, state).ok()?
            }
            // Begun again the level comes to the same bits.
            _ => Evolution::new(ground, settings, seed, stop).ok()??,
        };
        let mut wanted = !stop.is_set();
        let mut first = self.checkpoint.current.is_none();
        while wanted {
            if !first {
                if evolution.state().generation >= settings.generations {
                    break;
                }
                if !evolution.step(stop) {
                    return None;
                }
            }
            first = false;
            let state = evolution.state();
            let genomes = state.individuals().map(|individual| individual.genome.clone()).collect();
            self.checkpoint.current = Some(FieldGeneration { generation: state.generation, evaluations: state.evaluations, genomes });
            let best = state.best()?;
            let progress = self.progress(number, state.generation, best.fitness);
            let [columns, _] = ground.layout.cells;
            wanted = each(&FieldStep { progress, checkpoint: &self.checkpoint, columns, heights: &best.evaluation.ground.heights });
        }
        if !wanted {
            return None;
        }
        let evaluations = evolution.state().evaluations;
        let best = evolution.state().best()?;
        let mut genome = best.genome.clone();
        let changed = ground.conform(&mut genome, &best.evaluation.fits);
        let conformed = ground.evaluate(&genome, Some((&best.evaluation, &changed)), &Stop::never());
        Some((if conformed.fitness >= best.fitness { conformed } else { best.evaluation.clone() }, evaluations + 1))
    }

    fn progress(&self, number: usize, generation: usize, best: f64) -> FieldProgress {
        let generations = self.options.generations;
        let weight = |level: usize| (0..level).fold(1.0, |weight, _| weight * 9.0);
        let all: f64 = (0..self.levels.len()).map(weight).sum();
        let before: f64 = (0..number).map(weight).sum();
        let part = if number == 0 { 1.0 } else { (generation as f64 + 1.0) / (generations as f64 + 1.0) };
        FieldProgress {
            level: self.levels[number],
            number,
            levels: self.levels.len(),
            generation,
            generations,
            best,
            share: (before + part * weight(number)) / all,
        }
    }
}

impl Ground<'_> {
    /// Whether a genome is one of this ground.
    fn takes(&self, genome: &[Gene]) -> bool {
        let sound = |(number, gene): (usize, &Gene)| {
            let sources = &self.kind(number).sources;
            let inside = |grid: &SampleGrid| (0..grid.columns as i32).contains(&gene.column) && (0..grid.rows as i32).contains(&gene.row);
            gene.turn.0 < 8 && sources.get(gene.sample as usize).is_some_and(|source| inside(&source.grid))
        };
        genome.len() == self.layout.count() && genome.iter().enumerate().all(sound)
    }
}

/// Refuses maps with too many cells.
fn check_size(map: &Map, spacing: f64) -> Result<(), LibraryProblem> {
    let [columns, rows] = Frame::sides(map, spacing);
    if columns * rows <= MAX_FIELD_CELLS as f64 {
        return Ok(());
    }
    let detail =
        format!("the map has {columns} × {rows} cells at {spacing} m, and a field at most {MAX_FIELD_CELLS}: make it smaller or its finest level coarser");
    Err(LibraryProblem { pointer: "/regions".to_owned(), detail })
}

fn done(level: Level, heights: HeightGrid, [fitness, compatibility, similarity, whole_similarity]: [f64; 4], evaluations: u64) -> FieldLevel {
    let HeightGrid { columns, rows, heights } = heights;
    FieldLevel { level, columns, rows, heights, fitness, compatibility, similarity, whole_similarity, evaluations }
}

/// How similar regions are with edges linked over all of them, weighted by area.
fn whole_similarity(ground: &HeightGrid, raster: &RegionRaster, kind: &dyn Fn(u32) -> usize, models: &[TypeModel]) -> f64 {
    let grid = SampleGrid { columns: ground.columns, rows: ground.rows, spacing: [raster.frame.spacing; 2], heights: ground.heights.clone() };
    let analysis = Analysis::new(grid, None);
    let (mut sum, mut cells) = (0.0, 0);
    for region in raster.present() {
        let own = |cell: usize| raster.regions[cell] == region && raster.inside[cell];
        let area = (0..raster.regions.len()).filter(|cell| own(*cell)).count();
        if area > 0 {
            sum += area as f64 * models[kind(region)].value(&analysis.profile_in(own, Linking::Whole));
            cells += area;
        }
    }
    if cells > 0 { sum / cells as f64 } else { 0.0 }
}

/// SHA-256 of all that a ground depends on.
fn inputs(library: &Library, ready: &ReadyLibrary, map: &Map, options: &FieldOptions) -> String {
    let mut hash = Sha256::new();
    // Documents without a number that JSON cannot write; one that had one would still differ by its samples.
    for document in [serde_json::to_vec(library), serde_json::to_vec(map), serde_json::to_vec(options)] {
        let document = document.unwrap_or_default();
        hash.update((document.len() as u64).to_le_bytes());
        hash.update(document);
    }
    for sample in ready.types.iter().flatten() {
        hash.update(sample.grid.content_hash());
        if let Some(mask) = &sample.mask {
            hash.update(mask.iter().map(|counts| u8::from(*counts)).collect::<Vec<u8>>());
        }
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
