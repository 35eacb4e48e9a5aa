//! Drawings as work.

use super::{DocumentError, Problem, Share};
use crate::{
    geometry::{Raster, Stop},
    paths::{Drawing, DrawingError, Plan},
};
use serde::Deserialize;

/// Most nodes that the searches of a job may settle, as far as is known beforehand: some minutes on two processors.
const MOST_SETTLED: u64 = 1 << 32;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPaths {
    pub(super) drawing: Drawing,
}

fn refused(DrawingError { pointer, detail }: DrawingError) -> DocumentError {
    DocumentError::Invalid(vec![Problem::new(format!("/paths/drawing{pointer}"), detail)])
}

/// A drawing that was looked through.
pub(super) fn plan(drawing: &Drawing) -> Result<Plan, DocumentError> {
    let plan = Plan::unbounded(drawing).map_err(refused)?;
    let settled = plan.most_settled();
    if settled > MOST_SETTLED {
        let detail = format!("its searches may settle {settled} nodes, more than {MOST_SETTLED}: use fewer strokes, a greater spacing or narrower profiles");
        return Err(refused(DrawingError { pointer: String::new(), detail }));
    }
    Ok(plan)
}

/// Does all of it; `None` if it was stopped, which is looked at before every stroke.
pub(super) fn draw(drawing: &Drawing, stop: &Stop, done: &(dyn Fn(Share) + Sync)) -> Result<Option<Raster>, DocumentError> {
    let plan = plan(drawing)?;
    let of = plan.strokes();
    let heights = plan.heights(stop, &|strokes| done(Share { done: strokes, of }));
    Ok((!stop.is_set()).then(|| heights.raster(drawing)))
}
