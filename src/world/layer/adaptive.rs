//! Ground that evolves while it is used, as the source of a layer: its document pins the generation.

use super::{
    Mask, Setting,
    ground::{Ground, Heights, Raised},
    source::{Completed, Drawing, made},
};
use crate::{
    evolve::{self, Generation},
    geometry::Rectangle,
    world::{
        object::Object,
        problem::{Checks, whole_numbers},
    },
};
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;

/// Adaptive terrain as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenAdaptive {
    ground: Object<evolve::Ground>,
    generation: Option<String>,
}

pub(super) fn complete(written: WrittenAdaptive, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let WrittenAdaptive { ground: Object(ground), generation } = written;
    if let Err(error) = ground.check("") {
        checks.add(&format!("{at}/ground{}", error.at), error.message);
        return None;
    }
    let first = ground.hash();
    let hash = generation.unwrap_or_else(|| first.clone());
    let source = whole_numbers(json!({"adaptive": {"ground": ground, "generation": hash}}));
    let raised = |generation: Arc<Generation>| {
        let form = format!("adaptive 1 {:?} {} {:?}", ground.origin, ground.cell, ground.size());
        Ground::Raised(Arc::new(Raised { heights: Heights::Adaptive(generation), form }), None)
    };
    let ground = match setting.parts.generation(&hash) {
        Some(known) if **known.ground() == ground => raised(Arc::clone(known)),
        Some(_) => {
            checks.add(
                &format!("{at}/generation"),
                format!("must be a generation of this ground, {hash:?} is one of another: leave it out to begin with the first"),
            );
            return None;
        }
        None if hash == first => made(&source, setting, || match Generation::first(&ground) {
            Ok(generation) => Some(raised(Arc::new(generation))),
            Err(error) => {
                checks.add(&format!("{at}/ground{}", error.at), error.message);
                None
            }
        })?,
        None => {
            let detail = format!("must be the hash of a stored generation, which feedback breeds, or left out for the first; got {hash:?}");
            checks.add(&format!("{at}/generation"), detail);
            return None;
        }
    };
    Some(Completed { source, ground, features: Drawing::default() })
}

/// Where a generation shows: the area of its nodes, unless the layer's own mask is in that.
pub(super) fn shown(generation: &Generation, mask: Option<&Mask>, at: &str, checks: &mut Checks) -> Mask {
    let area = generation.terrain().area();
    if let Some(mask) = mask {
        if let Some(i) = mask.polygon.iter().position(|&corner| !area.holds(corner)) {
            let detail = format!("must lie on the terrain, {:?} … {:?} m: beyond its area there is none", area.min, area.max);
            checks.add(&format!("{at}/mask/polygon/{i}"), detail);
        }
        return mask.clone();
    }
    let [southwest, southeast, northwest, northeast] = area.corners();
    Mask { polygon: vec![southwest, southeast, northeast, northwest] }
}

/// Metres inside the border over which a generation comes up where its layer does not say so.
pub(super) fn fade(generation: &Generation) -> f64 {
    let Rectangle { min, max } = generation.terrain().area();
    (max[0] - min[0]).min(max[1] - min[1]) / 8.0
}
