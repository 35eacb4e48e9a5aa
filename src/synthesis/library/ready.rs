//! Libraries whose samples are read.

use super::{Library, LibraryError, LibraryProblem, LibrarySample};
use crate::synthesis::{
    analysis::Analysis,
    grid::{Crop, MIN_SIDE, SampleGrid},
    level::{Level, gene_side},
    read,
    sample::{Place, SampleError},
    similarity::Model,
    water::{Water, find_water},
};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// A sample without voids.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadySample {
    /// Its elevations.
    pub grid: SampleGrid,
    /// Which of its cells count; all without it.
    pub mask: Option<Vec<bool>>,
    /// What was left out.
    pub water: Vec<Water>,
    /// The part of the file that it is.
    pub part: Crop,
    /// What was taken for granted, in sentences for people.
    pub notes: Vec<String>,
}

impl LibrarySample {
    /// Reads the file's bytes and keeps what counts.
    ///
    /// # Errors
    /// If they are not those of the hash, cannot be [read], or nothing is left without voids and outside of the crop.
    pub fn ready(&self, bytes: &[u8]) -> Result<ReadySample, SampleError> {
        let name = self.name();
        let error = |detail: String| SampleError::new(name, Place::File, detail);
        if let Some(expected) = &self.sha256 {
            let hash: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            if hash != *expected {
                return Err(error(format!("its SHA-256 is {hash}, not {expected}")));
            }
        }
        let sample = read(name, bytes, &self.hints())?;
        let (whole, mut notes) = (sample.grid, sample.notes);
        let crop = self.crop.unwrap_or(Crop { column: 0, row: 0, columns: whole.columns, rows: whole.rows });
        let size = || format!("the crop is not inside of the file, which has {} × {} cells", whole.columns, whole.rows);
        let cut = whole.crop(crop).ok_or_else(|| error(size()))?;
        let part = self.voids.part(&cut).ok_or_else(|| error("every cell of the part that counts is void".to_owned()))?;
        let grid = cut.crop(part).unwrap_or(cut);
        let part = Crop { column: crop.column + part.column, row: crop.row + part.row, ..part };
        if (part.columns, part.rows) != (crop.columns, crop.rows) {
            notes.push(format!("voids: {} × {} cells of {} × {} are left", part.columns, part.rows, crop.columns, crop.rows));
        }
        grid.check(name)?;
        let (mask, water) = if self.without_water { find_water(&grid) } else { (Vec::new(), Vec::new()) };
        let mask = (!water.is_empty()).then_some(mask);
        if mask.as_ref().is_some_and(|mask| !mask.contains(&true)) {
            return Err(error("all of it is water".to_owned()));
        }
        Ok(ReadySample { grid, mask, water, part, notes })
    }
}

/// A library whose samples are read: of every type its samples, in the library's order.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadyLibrary {
    /// By type.
    pub types: Vec<Vec<ReadySample>>,
}

impl Library {
    /// Reads all samples, on the pool that it is called on. `bytes` gives a sample's file, or says why there is none.
    ///
    /// # Errors
    /// Every sample that there is no file of or that cannot be [read](LibrarySample::ready), by its pointer.
    pub fn ready(&self, bytes: &(dyn Fn(&LibrarySample) -> Result<Vec<u8>, String> + Sync)) -> Result<ReadyLibrary, LibraryError> {
        let one = |(place, sample): ([usize; 2], &LibrarySample)| {
            let problem = |detail| LibraryProblem { pointer: format!("/types/{}/samples/{}", place[0], place[1]), detail };
            let bytes = bytes(sample).map_err(problem)?;
            sample.ready(&bytes).map_err(|error| problem(error.to_string()))
        };
        let all: Vec<([usize; 2], &LibrarySample)> =
            self.types.iter().enumerate().flat_map(|(i, kind)| kind.samples.iter().enumerate().map(move |(j, sample)| ([i, j], sample))).collect();
        let read: Vec<Result<ReadySample, LibraryProblem>> = all.par_iter().map(|sample| one(*sample)).collect();
        let mut types: Vec<Vec<ReadySample>> = self.types.iter().map(|_| Vec::new()).collect();
        let mut problems = Vec::new();
        for (([kind, _], _), read) in all.iter().zip(read) {
            match read {
                Ok(sample) => types[*kind].push(sample),
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() { Ok(ReadyLibrary { types }) } else { Err(LibraryError(problems)) }
    }
}

impl ReadyLibrary {
    /// The levels at which a type exists, the finest first: those where one of its samples holds three times three genes.
    #[must_use]
    pub fn levels(&self, number: usize) -> Vec<Level> {
        let holds = |level: &Level| self.types.get(number).is_some_and(|samples| samples.iter().any(|sample| holds_genes(&sample.grid, *level)));
        Level::ALL.into_iter().filter(holds).collect()
    }

    /// The levels at which all of some types exist, the finest first. Detail finer than the first is nothing that samples can give.
    #[must_use]
    pub fn common_levels(&self, numbers: &[usize]) -> Vec<Level> {
        let all: Vec<Vec<Level>> = numbers.iter().map(|number| self.levels(*number)).collect();
        Level::ALL.into_iter().filter(|level| all.iter().all(|levels| levels.contains(level))).collect()
    }

    /// Analyses of all samples that reach a level with [`MIN_SIDE`] cells a side, by type, on the pool that it is called on.
    #[must_use]
    pub fn analyse(&self, level: Level) -> Vec<Vec<Analysis>> {
        let large = |analysis: &Analysis| analysis.grid.columns.min(analysis.grid.rows) >= MIN_SIDE;
        let one = |sample: &ReadySample| Analysis::at(&sample.grid, sample.mask.as_deref(), level).filter(large);
        self.types.iter().map(|samples| samples.par_iter().filter_map(one).collect()).collect()
    }

    /// What all types are known by at a level. Types of which no sample reaches it have none and are similar to nothing.
    #[must_use]
    pub fn model(&self, level: Level) -> Model {
        let analyses = self.analyse(level);
        Model::new(&analyses.iter().map(|samples| samples.iter().collect()).collect::<Vec<_>>())
    }
}

/// Whether a sample holds three times three genes at a level.
fn holds_genes(grid: &SampleGrid, level: Level) -> bool {
    let [columns, rows] = [(grid.columns, grid.spacing[0]), (grid.rows, grid.spacing[1])].map(|(cells, own)| cells as f64 * own / level.spacing());
    // Levels are only made where they can be large enough.
    columns.min(rows) >= 1.0 && grid.at(level).is_some_and(|grid| gene_side(&grid).is_some())
}
