//! The items of a layout's list of features: generators, features as `GeoJSON`, and stored sets of features.

use super::{
    Setting,
    generator::{Made, Seeded, problem},
};
use crate::{
    layout::{
        Feature,
        geojson::{Collection, FeatureSet, Sets},
    },
    world::problem::{Checks, whole_numbers},
};
use serde_json::{Value, json};
use std::sync::Arc;

/// An item of the list.
pub(super) enum Item {
    Generated(Box<Seeded>),
    Inline(Arc<FeatureSet>),
    Stored(String, Arc<FeatureSet>),
}

impl Item {
    /// Reads what stands at a pointer; problems are added to the checks.
    pub(super) fn read(item: &str, at: &str, sets: &Sets, setting: &Setting, checks: &mut Checks) -> Option<Self> {
        let value: Value = serde_json::from_str(item).ok()?;
        if value.get("generate").is_some() {
            return Seeded::read(whole_numbers(value), at, setting, checks).map(|seeded| Self::Generated(Box::new(seeded)));
        }
        if let Some(set) = value.get("set") {
            return Self::stored(&value, set, at, setting, checks);
        }
        if value.get("type").is_none() {
            checks.add(at, "expected {\"generate\": …}, {\"set\": …}, or a GeoJSON Feature or FeatureCollection");
            return None;
        }
        let read = Collection::parse(item).and_then(|collection| collection.check(sets).map(|()| collection));
        match read {
            Ok(collection) => Some(Self::Inline(Arc::new(collection.into()))),
            Err(error) => {
                checks.geojson(at, error);
                None
            }
        }
    }

    fn stored(value: &Value, set: &Value, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Self> {
        if value.as_object().is_some_and(|members| members.len() > 1) {
            checks.add(at, "beside set there is no other member");
        }
        let name = set.as_str().unwrap_or_default();
        let Some(set) = setting.parts.set(name) else {
            checks.add(&format!("{at}/set"), format!("must be the hash of a stored set of features, which changing a world's features makes; got {name:?}"));
            return None;
        };
        Some(Self::Stored(name.to_owned(), Arc::clone(set)))
    }

    /// The completed document.
    pub(super) fn to_json(&self) -> Value {
        match self {
            Self::Generated(seeded) => seeded.to_json(),
            Self::Inline(set) => json!(set.collection()),
            Self::Stored(name, _) => json!({"set": name}),
        }
    }

    /// The features that somebody drew.
    pub(super) fn drawn(&self) -> Option<&Arc<FeatureSet>> {
        match self {
            Self::Generated(_) => None,
            Self::Inline(set) | Self::Stored(_, set) => Some(set),
        }
    }
}

/// The features of generators in a row, those cut that ridges would cross. What was drawn is left as it is.
pub(super) fn generate(items: &[Item], sets: &Sets, at: &dyn Fn(usize) -> String, setting: &Setting, checks: &mut Checks) -> Option<Vec<Feature>> {
    let mut made = Made::default();
    for (i, item) in items.iter().enumerate() {
        if let Item::Generated(seeded) = item {
            let nested = matches!(seeded.generator, super::generator::Generator::Island(_));
            seeded.make(&mut made, sets, setting).map_err(|error| problem(&error, &at(i), nested, checks)).ok()?;
        }
    }
    made.features().map_err(|error| problem(&error, &at(0), false, checks)).ok()
}
