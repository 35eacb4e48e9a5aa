//! Drawings by path costs as sources of layers.

use super::{
    Setting,
    ground::{Ground, Heights, Raised},
    source::{Completed, Drawing as NoFeatures, made},
};
use crate::{
    geometry::Stop,
    noise,
    paths::{Drawing, DrawingError, Endless, EndlessDrawing, Plan, ShadowDrawing, ShadowPlan, ShadowTerrain},
    world::{
        problem::{Checks, whole_numbers},
        revision::Revision,
    },
};
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::Arc;

/// Most nodes that the searches of a layer's drawing may settle, as far as is known beforehand: a few seconds.
const MOST_SETTLED: u64 = 200_000_000;

/// Terrain by path costs as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenPaths {
    drawing: Option<Drawing>,
    endless: Option<EndlessDrawing>,
    shadow: Option<ShadowDrawing>,
}

/// Checks and completes a drawing; makes its heights unless they are there already or something is wrong.
pub(super) fn complete(written: WrittenPaths, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    match (written.drawing, written.endless, written.shadow) {
        (Some(drawing), None, None) => finite(&drawing, &format!("{at}/drawing"), setting, checks),
        (None, Some(drawing), None) => endless(drawing, &format!("{at}/endless"), setting, checks),
        (None, None, Some(drawing)) => shadow(&drawing, &format!("{at}/shadow"), setting, checks),
        _ => {
            checks.add(at, "paths are either a drawing, endless or a shadow");
            None
        }
    }
}

fn refused(error: DrawingError, at: &str, checks: &mut Checks) {
    checks.add(&format!("{at}{}", error.pointer), error.detail);
}

fn raised(heights: Heights, source: &Value) -> Ground {
    Ground::Raised(Arc::new(Raised { heights, form: format!("paths 1 {}", Revision::of(source)) }), None)
}

fn endless(drawing: EndlessDrawing, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let source = whole_numbers(json!({"paths": {"endless": drawing}}));
    let ground = made(&source, setting, || {
        let seed = noise::key(setting.seed, drawing.seed);
        let endless = Endless::new(drawing, seed).map_err(|error| refused(error, at, checks)).ok()?;
        Some(raised(Heights::Endless(Box::new(endless)), &source))
    })?;
    Some(Completed { source, ground, features: NoFeatures::default() })
}

fn finite(drawing: &Drawing, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let source = whole_numbers(json!({"paths": {"drawing": drawing}}));
    let ground = made(&source, setting, || {
        let plan = Plan::unbounded(drawing).map_err(|error| refused(error, at, checks)).ok()?;
        if plan.most_settled() > MOST_SETTLED {
            checks.add(
                at,
                format!(
                    "its searches may settle {} nodes, more than {MOST_SETTLED}: use fewer strokes, a greater spacing or narrower profiles",
                    plan.most_settled()
                ),
            );
            return None;
        }
        let heights = plan.heights(&Stop::never(), &|_| {});
        Some(raised(Heights::Finite(Arc::new(heights.raster(drawing))), &source))
    })?;
    Some(Completed { source, ground, features: NoFeatures::default() })
}

fn shadow(drawing: &ShadowDrawing, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let source = whole_numbers(json!({"paths": {"shadow": drawing}}));
    let ground = made(&source, setting, || {
        let plan = ShadowPlan::new(drawing).map_err(|error| refused(error, at, checks)).ok()?;
        let terrain = ShadowTerrain::new(drawing, &plan.heights(&Stop::never()));
        Some(raised(Heights::Shadow(terrain), &source))
    })?;
    Some(Completed { source, ground, features: NoFeatures::default() })
}
