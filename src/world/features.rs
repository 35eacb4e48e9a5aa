//! The features of a world's layers, by place.

use super::World;
use crate::{
    geometry::Rectangle,
    layout::{
        Layout,
        geojson::{Drawn, FeatureSet, Sets, name_of_feature},
    },
};
use std::sync::Arc;

/// Features whose contents a fingerprint takes in one by one; for more it takes the whole world's revision.
const MOST_NAMED: usize = 4096;

/// Features of a layer that an area may meet.
#[derive(Debug)]
pub struct LayerFeatures<'a> {
    /// The name of the layer.
    pub layer: &'a str,
    /// The features' attributes by name, beside those of the set itself.
    pub attributes: &'a Sets,
    /// The features of the layer, or some of them.
    pub set: &'a FeatureSet,
    /// Their places in the set's collection, ascending.
    pub found: Vec<u32>,
}

impl LayerFeatures<'_> {
    /// The features that were found.
    pub fn drawn(&self) -> impl Iterator<Item = &Drawn> + '_ {
        self.found.iter().map(|&number| &self.set.collection().features[number as usize])
    }
}

impl World {
    /// The features, drawn or generated, whose shapes may meet an area. Those of layers without end are not among them.
    #[must_use]
    pub fn features_in(&self, area: &Rectangle) -> Vec<LayerFeatures<'_>> {
        let sets = self.layers().flat_map(|layer| layer.drawn().map(move |set| (layer, set)));
        let found = sets.map(|(layer, set)| LayerFeatures { layer: &layer.name, attributes: layer.attributes(), set, found: set.find(area) });
        found.filter(|features| !features.found.is_empty()).collect()
    }

    /// The islands of layers without end that samples so far apart show in an area; none where they would be many.
    #[must_use]
    pub fn islands_in(&self, area: &Rectangle, spacing: f64) -> Vec<(&str, Arc<Layout>)> {
        self.layers().flat_map(|layer| layer.islands(area, spacing).into_iter().map(|island| (&*layer.name, island))).collect()
    }

    /// What a fingerprint of something drawn from the features in an area takes in beside the terrain there: their ids, properties and names, after `form`.
    #[must_use]
    pub fn features_form(&self, form: &str, area: &Rectangle) -> String {
        let found = self.features_in(area);
        if found.iter().map(|features| features.found.len()).sum::<usize>() > MOST_NAMED {
            return format!("{form}\nrevision {}", self.revision());
        }
        let mut all = format!("{form}\nfeatures");
        for features in &found {
            let names: Vec<String> = features.drawn().map(name_of_feature).collect();
            all = format!("{all}\n{} {}", features.layer, names.join(" "));
        }
        // What their sets of attributes say, and islands without end, are among what can change the terrain.
        all
    }
}
