//! Evolutions as work.

use super::{Checkpoint, DocumentError, Problem};
use crate::{
    evolve::{RecordError, Search, Stage},
    geometry::Stop,
    world::problem::{Checks, read_value},
};
use serde::Deserialize;
use serde_json::Value;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSearch {
    aim: Value,
    #[serde(default)]
    settings: Option<Value>,
    #[serde(default)]
    seed: Option<u64>,
    #[serde(default)]
    goal: Option<f64>,
}

pub(super) fn refused(RecordError { at, message }: RecordError) -> DocumentError {
    DocumentError::Invalid(vec![Problem::new(format!("/evolution{at}"), message)])
}

/// A search with all that was left out.
pub(super) fn read_search(written: WrittenSearch) -> Result<Search, DocumentError> {
    let mut checks = Checks(Vec::new());
    let aim = read_value(written.aim, "/evolution/aim", &mut checks);
    let settings = written.settings.map_or(Some(crate::genetic::Settings::default()), |settings| read_value(settings, "/evolution/settings", &mut checks));
    match (aim, settings) {
        (Some(aim), Some(settings)) => Ok(Search { aim, settings, seed: written.seed.unwrap_or_default(), goal: written.goal }),
        _ => Err(DocumentError::Invalid(checks.0)),
    }
}

/// The stage that a checkpoint's state is.
pub(super) fn read_stage(search: &Search, state: &[u8]) -> Result<Box<Stage>, DocumentError> {
    let stage: Box<Stage> = serde_json::from_slice(state).map_err(|error| DocumentError::Syntax(error.to_string()))?;
    search.check_stage(&stage).map_err(refused)?;
    Ok(stage)
}

/// The first generation, or the next.
pub(super) fn advance(search: &Search, stage: Option<Box<Stage>>, stop: &Stop) -> Result<Option<Box<Stage>>, DocumentError> {
    let next = match stage {
        None => search.begin(stop),
        Some(stage) => search.advance(*stage, stop),
    };
    Ok(next.map_err(refused)?.map(Box::new))
}

pub(super) fn checkpoint(search: &Search, stage: &Stage) -> Result<Checkpoint, DocumentError> {
    let state = serde_json::to_vec(stage).map_err(|error| DocumentError::Syntax(error.to_string()))?;
    Ok(Checkpoint { step: stage.progress().generation, steps: search.settings.generations, line: stage.progress(), found: stage.best().clone(), state })
}
