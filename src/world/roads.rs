//! Roads over a finished world.

use super::{
    World,
    layer::{find_feature, generated, generator_problem, known_sets},
    problem::{Checks, DocumentError, drop_nulls, read_value, whole_numbers},
};
use crate::{
    geometry::{Elevation, Shape},
    layout::{
        AttributeSet, Feature,
        generate::{GenerateError, Place, Road, Roads},
        geojson::{Collection, Drawn},
    },
};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::{collections::BTreeMap, sync::Arc};

/// Nanoseconds that sampling the terrain for roads may take on one thread, as predicted.
const MOST_COST_NS: f64 = 20e9;

/// What has a style of its own.
const STYLE: &str = "roads";

/// A place as it is written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPlace {
    name: String,
    at: [f64; 2],
}

/// Whether an item of a request asks for roads.
pub(super) fn is_roads(item: &Value) -> bool {
    item.get("generate").and_then(Value::as_str) == Some("roads")
}

/// Roads as `{"generate": "roads", …}` asks for them, written at a pointer; problems are added to the checks.
pub(super) fn roads(world: &World, item: Value, at: &str, checks: &mut Checks) -> Option<Collection> {
    let before = checks.0.len();
    let Value::Object(mut members) = whole_numbers(item) else { return None };
    drop_nulls(&mut members);
    members.remove("generate");
    if members.remove("seed").is_some() {
        checks.add(&format!("{at}/seed"), "roads follow from the terrain and have no seed: leave it out");
    }
    let places = places(world, members.remove("places"), &format!("{at}/places"), checks);
    let style = style(world, members.remove("styles"), &format!("{at}/styles"), checks);
    let roads: Option<Roads> = read_value(Value::Object(members), at, checks);
    let (places, roads) = (places?, roads?);
    if checks.0.len() > before {
        return None;
    }
    let built = build(world, &roads, &places, style);
    built.map_err(|error| generator_problem(&error, at, checks)).ok()
}

/// The places to be joined: objects with a name and coordinates, or ids of point features of the world.
fn places(world: &World, written: Option<Value>, at: &str, checks: &mut Checks) -> Option<Vec<Place>> {
    let Some(Value::Array(items)) = written else {
        checks.add(at, "must be a list of {\"name\": …, \"at\": [x, y]} or of ids of point features of the world");
        return None;
    };
    let before = checks.0.len();
    let mut places: Vec<Place> = Vec::new();
    for (i, item) in items.into_iter().enumerate() {
        let at = format!("{at}/{i}");
        let place = match item {
            Value::String(id) => match find_feature(world.document(), &id).map(Drawn::shape) {
                Some(Shape::Point { at, .. } | Shape::Circle { centre: at, .. }) => Some(Place { name: id, at: *at }),
                Some(_) => {
                    checks.add(&at, format!("feature {id:?} is no Point"));
                    None
                }
                None => {
                    checks.add(&at, format!("no feature of the world has the id {id:?}"));
                    None
                }
            },
            item => read_value(item, &at, checks).map(|WrittenPlace { name, at }| Place { name, at }),
        };
        if let Some(place) = &place
            && places.iter().any(|other| other.name == place.name)
        {
            checks.add(&at, format!("{:?} is the name of another place", place.name));
        }
        places.extend(place);
    }
    (checks.0.len() == before).then_some(places)
}

/// The set of attributes that the request names for roads, if it names one.
fn style(world: &World, written: Option<Value>, at: &str, checks: &mut Checks) -> Option<Arc<AttributeSet>> {
    let names: BTreeMap<String, String> = read_value(written?, at, checks)?;
    if let Some(unknown) = names.keys().find(|key| *key != STYLE) {
        checks.add(&format!("{at}/{unknown}"), format!("unknown field `{unknown}`, expected `{STYLE}`"));
        return None;
    }
    let name = names.get(STYLE)?;
    let found = known_sets(world.document()).get(name).cloned();
    if found.is_none() {
        checks.add(&format!("{at}/{STYLE}"), format!("no set of attributes of the world is named {name:?}"));
    }
    found
}

fn build(world: &World, roads: &Roads, places: &[Place], style: Option<Arc<AttributeSet>>) -> Result<Collection, GenerateError> {
    let window = roads.window(places)?;
    let cost = world.cost_ns(&window);
    if cost > MOST_COST_NS {
        let reason = format!("sampling the terrain would take about {:.0} s, {:.0} s are allowed: choose a wider spacing", cost * 1e-9, MOST_COST_NS * 1e-9);
        return Err(GenerateError::Unfit { place: "roads.spacing".to_owned(), reason });
    }
    let built = roads.build(world, places)?;
    let style = match style {
        Some(style) => style,
        None => Arc::new(roads.attributes()?),
    };
    let nothing = Arc::new(AttributeSet::new(Vec::new())?);
    let feature = |road: &Road| -> Result<Feature, GenerateError> {
        let elevation = Elevation::Vertices(road.line.iter().map(|p| p[2]).collect());
        let shape = Shape::line(road.line.iter().map(|p| [p[0], p[1]]).collect(), elevation)?;
        Ok(Feature::new(shape, Arc::clone(if road.is_bridge { &nothing } else { &style }))?)
    };
    let features: Vec<Feature> = built.iter().map(feature).collect::<Result<_, _>>()?;
    let mut collection = Collection::of(&features).unwrap_or_default();
    for (drawn, road) in collection.features.iter_mut().zip(&built) {
        drawn.describe(&properties(road, places));
    }
    Ok(collection)
}

/// What is told of a road beside its course.
fn properties(road: &Road, places: &[Place]) -> Map<String, Value> {
    let rounded = |value: f64, digits: f64| json!((value * digits).round() / digits);
    let routes: Vec<String> = road.routes.iter().map(|[a, b]| format!("{} – {}", places[*a].name, places[*b].name)).collect();
    let kind = if road.is_bridge { "bridge" } else { "road" };
    let mut all = Map::from_iter([
        ("kind".to_owned(), json!(kind)),
        ("name".to_owned(), json!(routes.join(", "))),
        ("length".to_owned(), rounded(road.length, 10.0)),
        ("grade".to_owned(), rounded(road.grade, 1e4)),
    ]);
    if road.is_bridge {
        all.insert("clearance".to_owned(), rounded(road.fill, 10.0));
    } else {
        all.insert("cut".to_owned(), rounded(road.cut, 10.0));
        all.insert("fill".to_owned(), rounded(road.fill, 10.0));
    }
    all
}

impl World {
    /// The features that generators make in this world, `{"generate": …}` or a list of such items, as they would be drawn. Roads run over the world as it is,
    /// without the other items of the list.
    ///
    /// # Errors
    /// If the bytes are not JSON, or with every problem that could be found.
    pub fn generate(&self, json: &[u8]) -> Result<Collection, DocumentError> {
        let value: Value = serde_json::from_slice(json).map_err(|error| DocumentError::Syntax(error.to_string()))?;
        let (items, list) = if let Value::Array(items) = value { (items, true) } else { (vec![value], false) };
        let at = |i: usize| if list { format!("/{i}") } else { String::new() };
        let mut checks = Checks(Vec::new());
        let (ways, others): (Vec<_>, Vec<_>) = items.into_iter().enumerate().partition(|(_, item)| is_roads(item));
        let mut made = if others.is_empty() { Some(Collection::default()) } else { generated(self.document(), others, &at, &mut checks) };
        for (i, item) in ways {
            let roads = roads(self, item, &at(i), &mut checks);
            if let (Some(made), Some(roads)) = (&mut made, roads) {
                made.append(roads);
            }
        }
        made.filter(|_| checks.0.is_empty()).ok_or(DocumentError::Invalid(checks.0))
    }
}
