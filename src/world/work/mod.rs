//! Terrain that takes too long to be made while a world is saved: what a job is asked for, and what it makes of that, step by step.

mod drawing;
mod evolution;
#[cfg(test)]
mod tests;

use super::{
    object::Object,
    problem::{DocumentError, Problem, read, whole_numbers},
    revision::Revision,
};
use crate::{
    evolve::{Found, Search, Stage},
    genetic::Progress,
    geometry::{Raster, Stop},
    paths::Drawing,
};
use drawing::WrittenPaths;
use evolution::WrittenSearch;
use serde::{Deserialize, Serialize};
use serde_json::json;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    paths: Option<Object<WrittenPaths>>,
    #[serde(default)]
    evolution: Option<Object<WrittenSearch>>,
}

/// What a job is asked for.
///
/// ```
/// use terrane::{geometry::Stop, world::{Turn, Work}};
/// let work = Work::parse(br#"{"paths": {"drawing": {
///     "size": [64, 64], "edges": {"random": {"mean": 0.5, "deviation": 0.3}}, "sea_level": {"cost": 20},
///     "strokes": [{"shape": {"geometry": {"type": "Point", "coordinates": [32, 32]}}, "cost": 0}]
/// }}}"#)?;
/// let Some(Turn::Raster(raster)) = work.begin(None)?.turn(&Stop::never(), &|_| {})? else { panic!("a drawing is made at once") };
/// assert_eq!(raster.range()[1], 20.0);
/// # Ok::<(), terrane::world::DocumentError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Work {
    /// Terrain by path costs, which becomes a raster.
    Drawing(Box<Drawing>),
    /// A programme that is bred towards what is wanted, generation by generation.
    Evolution(Box<Search>),
}

/// Work under way: between two turns it may be laid aside, and taken up again from the checkpoint of the last.
#[derive(Clone, Debug)]
pub struct Course(At);

#[derive(Clone, Debug)]
enum At {
    Drawing(Box<Drawing>),
    /// A search and its last stage.
    Evolution(Box<Search>, Option<Box<Stage>>),
}

/// What a turn of work comes to.
#[derive(Debug)]
pub enum Turn {
    /// There is more to do.
    On(Course, Checkpoint),
    /// The end: heights.
    Raster(Raster),
    /// The end: the last checkpoint holds what was found.
    Found(Checkpoint),
}

/// What must be kept for work to go on from where it was, to the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Steps done: generations.
    pub step: usize,
    /// Steps there are at most.
    pub steps: usize,
    /// How far it was at this step, a line of the work's history.
    pub line: Progress,
    /// What it would come to if it ended here.
    pub found: Found,
    /// What it goes on from, as JSON.
    pub state: Vec<u8>,
}

/// A share of work that is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Steps done.
    pub done: usize,
    /// Steps there are.
    pub of: usize,
}

/// What kind of work it is: the name of its member.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WorkKind {
    /// [`Work::Drawing`].
    Paths,
    /// [`Work::Evolution`].
    Evolution,
}

impl Work {
    /// Reads what is asked for. What it means is [checked](Work::check) later.
    ///
    /// # Errors
    /// If the bytes are not JSON, or a field is missing, unknown or of the wrong type.
    pub fn parse(json: &[u8]) -> Result<Self, DocumentError> {
        match read(json)? {
            Written { paths: Some(Object(WrittenPaths { drawing })), evolution: None } => Ok(Work::Drawing(Box::new(drawing))),
            Written { paths: None, evolution: Some(Object(written)) } => evolution::read_search(written).map(|search| Work::Evolution(Box::new(search))),
            _ => Err(DocumentError::Invalid(vec![Problem::new("", "must have one member that says what is asked for: `paths` or `evolution`")])),
        }
    }

    /// What is asked for, completed.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        whole_numbers(match self {
            Work::Drawing(drawing) => json!({"paths": {"drawing": drawing}}),
            Work::Evolution(search) => json!({"evolution": search}),
        })
    }

    /// The name of what is asked for: the same for the same.
    #[must_use]
    pub fn id(&self) -> Revision {
        Revision::of(&self.to_json())
    }

    /// What kind of work it is.
    #[must_use]
    pub fn kind(&self) -> WorkKind {
        match self {
            Work::Drawing(_) => WorkKind::Paths,
            Work::Evolution(_) => WorkKind::Evolution,
        }
    }

    /// A name for people.
    #[must_use]
    pub fn title(&self) -> Option<&str> {
        match self {
            Work::Drawing(drawing) => drawing.title.as_deref(),
            Work::Evolution(_) => None,
        }
    }

    /// Checks all of it.
    ///
    /// # Errors
    /// If anything in it is not what it must be, or it would take too long.
    pub fn check(&self) -> Result<(), DocumentError> {
        match self {
            Work::Drawing(drawing) => drawing::plan(drawing).map(|_| ()),
            Work::Evolution(search) => search.check().map_err(evolution::refused),
        }
    }

    /// About what it will make, within a second, and how many steps it will take.
    ///
    /// # Errors
    /// As [`Work::check`], and for evolutions: nobody knows what they will find.
    pub fn preview(&self) -> Result<(Raster, usize), DocumentError> {
        match self {
            Work::Drawing(drawing) => {
                let plan = drawing::plan(drawing)?;
                Ok((plan.preview().raster(drawing), plan.strokes()))
            }
            Work::Evolution(_) => Err(DocumentError::Invalid(vec![Problem::new("/evolution", "has no preview: ask for the job and look at its best")])),
        }
    }

    /// Makes it ready, from its beginning or from the state of a checkpoint.
    ///
    /// # Errors
    /// As [`Work::check`], and if the state is none of this work.
    pub fn begin(&self, state: Option<&[u8]>) -> Result<Course, DocumentError> {
        self.check()?;
        Ok(Course(match self {
            Work::Drawing(drawing) => At::Drawing(drawing.clone()),
            Work::Evolution(search) => At::Evolution(search.clone(), state.map(|state| evolution::read_stage(search, state)).transpose()?),
        }))
    }
}

impl Course {
    /// Does the next part: all of a drawing, a generation of an evolution. `done` hears how much is done within it. `None` if it was stopped; then nothing of the part
    /// is kept.
    ///
    /// # Errors
    /// If the work cannot go on; it never could.
    pub fn turn(self, stop: &Stop, done: &(dyn Fn(Share) + Sync)) -> Result<Option<Turn>, DocumentError> {
        match self.0 {
            At::Drawing(drawing) => Ok(drawing::draw(&drawing, stop, done)?.map(Turn::Raster)),
            At::Evolution(search, stage) => {
                let Some(stage) = evolution::advance(&search, stage, stop)? else { return Ok(None) };
                let checkpoint = evolution::checkpoint(&search, &stage)?;
                Ok(Some(if search.is_over(&stage) { Turn::Found(checkpoint) } else { Turn::On(Course(At::Evolution(search, Some(stage))), checkpoint) }))
            }
        }
    }
}
