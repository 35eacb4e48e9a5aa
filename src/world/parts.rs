//! What documents name by hash and is kept apart from them.

use crate::{evolve::Generation, geometry::Raster, layout::geojson::FeatureSet};
use serde_json::Value;
use std::{collections::BTreeMap, sync::Arc};

/// Stored sets of features, rasters and generations of adaptive terrain by name: what a document that names them is read with.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    sets: BTreeMap<String, Arc<FeatureSet>>,
    rasters: BTreeMap<String, Arc<Raster>>,
    generations: BTreeMap<String, Arc<Generation>>,
}

/// The names of parts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartNames {
    /// Of sets of features.
    pub sets: Vec<String>,
    /// Of rasters.
    pub rasters: Vec<String>,
    /// Of generations of adaptive terrain.
    pub generations: Vec<String>,
}

impl PartNames {
    /// All that a world's document names, whether or not it is one otherwise.
    #[must_use]
    pub fn in_world(json: &[u8]) -> Self {
        let document: Value = serde_json::from_slice(json).unwrap_or_default();
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let mut names = Self::default();
        for layer in list(&document["layers"]) {
            let source = &layer["source"];
            names.sets.extend(list(&source["layout"]["features"]).iter().filter_map(|item| item["set"].as_str().map(str::to_owned)));
            names.rasters.extend(source["raster"]["hash"].as_str().map(str::to_owned));
            names.generations.extend(source["adaptive"]["generation"].as_str().map(str::to_owned));
        }
        names
    }
}

impl Parts {
    /// Adds a set of features.
    pub fn insert_set(&mut self, name: String, set: Arc<FeatureSet>) {
        self.sets.insert(name, set);
    }

    /// Adds a raster.
    pub fn insert_raster(&mut self, name: String, raster: Arc<Raster>) {
        self.rasters.insert(name, raster);
    }

    /// Adds a generation of adaptive terrain.
    pub fn insert_generation(&mut self, generation: Arc<Generation>) {
        self.generations.insert(generation.hash().to_owned(), generation);
    }

    pub(super) fn set(&self, name: &str) -> Option<&Arc<FeatureSet>> {
        self.sets.get(name)
    }

    pub(super) fn raster(&self, name: &str) -> Option<&Arc<Raster>> {
        self.rasters.get(name)
    }

    pub(super) fn generation(&self, hash: &str) -> Option<&Arc<Generation>> {
        self.generations.get(hash)
    }
}
