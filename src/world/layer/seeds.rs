//! Features drawn by hand that generators start from: lands, rivers and other waters.

use super::{Setting, find_feature};
use crate::{
    geometry::{Curve, Elevation, Shape},
    layout::{
        AttributeSet, Feature,
        geojson::{Collection, Drawn, Sets},
    },
    world::{Document, problem::Checks},
};
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// The lists of features that each generator takes.
const LISTS: [(&str, &[&str]); 2] = [("rivers", &["land", "drawn"]), ("ridges", &["land", "waters"])];

/// Most features of a list.
const MOST: usize = 10_000;

/// Features that a generator starts from, without attributes: their shapes alone count.
#[derive(Clone, Debug, Default)]
pub(super) struct Seeds {
    /// Lands to grow on, in the place of those that generators made before.
    pub land: Vec<Feature>,
    /// Rivers that keep their course.
    pub drawn: Vec<Feature>,
    /// Waters that ridges stand between, beside those that generators made before.
    pub waters: Vec<Feature>,
    /// The lists as they are written in the completed document.
    written: Map<String, Value>,
}

/// The lists of a generator.
fn lists(generator: &str) -> &'static [&'static str] {
    LISTS.iter().find(|known| known.0 == generator).map_or(&[], |known| known.1)
}

/// Puts the world's features in the place of their ids, in the lists of a generator that stands at a pointer; whether all are there.
pub(super) fn resolve(item: &mut Value, at: &str, world: &Document, checks: &mut Checks) -> bool {
    let before = checks.0.len();
    let generator = item["generate"].as_str().unwrap_or_default().to_owned();
    for list in lists(&generator) {
        for (i, entry) in item.get_mut(*list).and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
            let Some(id) = entry.as_str() else { continue };
            match find_feature(world, id) {
                Some(drawn) => *entry = shape_of(drawn),
                None => checks.add(&format!("{at}/{list}/{i}"), format!("no feature of the world has the id {id:?}")),
            }
        }
    }
    checks.0.len() == before
}

/// A feature with nothing but its id and its shape.
fn shape_of(drawn: &Drawn) -> Value {
    let mut written = json!(drawn);
    let properties = written.get_mut("properties").and_then(Value::as_object_mut);
    if let Some(properties) = properties {
        properties.retain(|name, _| matches!(name.as_str(), "elevation" | "radius"));
        properties.insert("attributes".to_owned(), json!([]));
    }
    written
}

impl Seeds {
    /// Takes the lists out of a generator that stands at a pointer; problems, with feature and vertex, are added to the checks.
    pub(super) fn take(generator: &str, object: &mut Map<String, Value>, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Self> {
        let before = checks.0.len();
        let mut seeds = Seeds::default();
        for list in lists(generator) {
            let Some(value) = object.remove(*list) else { continue };
            let at = format!("{at}/{list}");
            let Value::Array(items) = value else {
                checks.add(&at, "must be a list of GeoJSON Features, or in POST /worlds/{world}/generate of ids of the world's features");
                continue;
            };
            if items.len() > MOST {
                checks.add(&at, format!("must be at most {MOST} features, got {}", items.len()));
                continue;
            }
            let (mut features, mut written) = (Vec::new(), Vec::new());
            for (i, item) in items.into_iter().enumerate() {
                if let Some((feature, json)) = read(item, list, &format!("{at}/{i}"), setting, checks) {
                    features.push(feature);
                    written.push(json);
                }
            }
            seeds.written.insert((*list).to_owned(), Value::Array(written));
            match *list {
                "land" => seeds.land = features,
                "drawn" => seeds.drawn = features,
                _ => seeds.waters = features,
            }
        }
        (checks.0.len() == before).then_some(seeds)
    }

    /// The lists of the completed document.
    pub(super) fn to_json(&self) -> Map<String, Value> {
        self.written.clone()
    }
}

/// Reads one feature of a list, and gives it as it is written in the completed document.
fn read(mut item: Value, list: &str, at: &str, setting: &Setting, checks: &mut Checks) -> Option<(Feature, Value)> {
    if item.is_string() {
        checks.add(at, "must be a GeoJSON Feature: ids of the world's features are for POST /worlds/{world}/generate");
        return None;
    }
    if let Some(properties) = item.get_mut("properties").and_then(Value::as_object_mut) {
        properties.insert("attributes".to_owned(), json!([]));
    } else if let Some(object) = item.as_object_mut() {
        object.insert("properties".to_owned(), json!({"attributes": []}));
    }
    let read = Collection::parse(&item.to_string()).and_then(|collection| collection.check(&Sets::default()).map(|()| collection));
    let collection = read.map_err(|error| checks.geojson(at, error)).ok()?;
    let [drawn] = &collection.features[..] else {
        checks.add(at, "must be one Feature");
        return None;
    };
    let (name, shape) = (drawn.id.as_ref().map_or_else(|| "the feature".to_owned(), |id| format!("feature {:?}", id.to_string())), drawn.shape());
    let wanted = match (list, shape) {
        ("land", Shape::Polygon(_)) | ("drawn", Shape::Line(_)) | ("waters", Shape::Line(_) | Shape::Polygon(_)) => None,
        ("land", _) => Some("must be a Polygon, the coast"),
        ("drawn", _) => Some("must be a LineString, a river"),
        _ => Some("must be a LineString or a Polygon, a river or a lake"),
    };
    if let Some(wanted) = wanted {
        checks.add(&format!("{at}/geometry"), format!("{name}: {wanted}"));
        return None;
    }
    let shape = match shape {
        Shape::Polygon(curve) if list == "land" && !shape.has_elevation() => at_sea(curve, setting.sea_level).unwrap_or_else(|| shape.clone()),
        _ => shape.clone(),
    };
    if list == "waters" && !shape.has_elevation() {
        checks.add(
            &format!("{at}/geometry/coordinates"),
            format!("{name}: vertex 0: has no elevation, above which ridges rise: give every vertex a third coordinate"),
        );
        return None;
    }
    let feature = Feature::new(shape, Arc::new(AttributeSet::new(Vec::new()).ok()?)).ok()?;
    Some((feature, shape_of(drawn)))
}

/// A coast that was drawn without elevations lies at the level of the sea.
fn at_sea(curve: &Curve, sea_level: f64) -> Option<Shape> {
    let mut rings: Vec<Vec<[f64; 2]>> = curve.parts().map(|_| Vec::new()).collect();
    for (number, chord) in curve.chords().enumerate() {
        let ring = &mut rings[curve.part_of(number)];
        if ring.is_empty() {
            ring.push(chord.ends[0]);
        }
        ring.push(chord.ends[1]);
    }
    Shape::polygon(rings, Elevation::Constant(sea_level)).ok()
}
