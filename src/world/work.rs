//! Terrain that takes too long to be made while a world is saved: what a job is asked for, and what it makes of that.

use super::{
    object::Object,
    problem::{DocumentError, Problem, read, whole_numbers},
    revision::Revision,
};
use crate::{
    geometry::{Raster, Stop},
    paths::{Drawing, DrawingError, Plan},
};
use serde::Deserialize;
use serde_json::json;

/// Most nodes that the searches of a job may settle, as far as is known beforehand: some minutes on two processors.
const MOST_SETTLED: u64 = 1 << 32;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    paths: Object<WrittenPaths>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPaths {
    drawing: Drawing,
}

/// What a job is asked for.
///
/// ```
/// use terrane::{geometry::Stop, world::Work};
/// let work = Work::parse(br#"{"paths": {"drawing": {
///     "size": [64, 64], "edges": {"random": {"mean": 0.5, "deviation": 0.3}}, "sea_level": {"cost": 20},
///     "strokes": [{"shape": {"geometry": {"type": "Point", "coordinates": [32, 32]}}, "cost": 0}]
/// }}}"#)?;
/// let raster = work.prepare()?.run(&Stop::never(), &|_| {}).expect("nobody stops it");
/// assert_eq!(raster.range()[1], 20.0);
/// # Ok::<(), terrane::world::DocumentError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Work {
    drawing: Drawing,
}

/// Work that was looked through and can begin.
#[derive(Debug)]
pub struct Prepared<'a> {
    drawing: &'a Drawing,
    plan: Plan,
}

impl Work {
    /// Reads what is asked for. What it means is checked when it is [prepared](Work::prepare).
    ///
    /// # Errors
    /// If the bytes are not JSON, or a field is missing, unknown or of the wrong type.
    pub fn parse(json: &[u8]) -> Result<Self, DocumentError> {
        let Written { paths: Object(WrittenPaths { drawing }) } = read(json)?;
        Ok(Self { drawing })
    }

    /// What is asked for, completed.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        whole_numbers(json!({"paths": {"drawing": self.drawing}}))
    }

    /// The name of what is asked for: the same for the same.
    #[must_use]
    pub fn id(&self) -> Revision {
        Revision::of(&self.to_json())
    }

    /// A name for people.
    #[must_use]
    pub fn title(&self) -> Option<&str> {
        self.drawing.title.as_deref()
    }

    /// Checks all of it and makes it ready.
    ///
    /// # Errors
    /// If anything in it is not what it must be, or it would take too long.
    pub fn prepare(&self) -> Result<Prepared<'_>, DocumentError> {
        let refused = |DrawingError { pointer, detail }| DocumentError::Invalid(vec![Problem::new(format!("/paths/drawing{pointer}"), detail)]);
        let plan = Plan::unbounded(&self.drawing).map_err(refused)?;
        let settled = plan.most_settled();
        if settled > MOST_SETTLED {
            let detail =
                format!("its searches may settle {settled} nodes, more than {MOST_SETTLED}: use fewer strokes, a greater spacing or narrower profiles");
            return Err(refused(DrawingError { pointer: String::new(), detail }));
        }
        Ok(Prepared { drawing: &self.drawing, plan })
    }
}

impl Prepared<'_> {
    /// How many steps it takes.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.plan.strokes()
    }

    /// About what it will make, within a second.
    #[must_use]
    pub fn preview(&self) -> Raster {
        self.plan.preview().raster(self.drawing)
    }

    /// Does it; `done` hears how many steps are done. `None` if it was stopped, which is looked at before every step.
    #[must_use]
    pub fn run(&self, stop: &Stop, done: &(dyn Fn(usize) + Sync)) -> Option<Raster> {
        let heights = self.plan.heights(stop, done);
        (!stop.is_set()).then(|| heights.raster(self.drawing))
    }
}
