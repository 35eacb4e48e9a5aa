//! A feature as it was drawn.

use super::{
    attribute,
    geometry::{self, Geometry},
    number::Plain,
    problem::Problems,
    properties::{self, Properties},
    read::Shared,
    sets::Sets,
};
use crate::{
    geometry::{Along, Curve, Detail, Elevation, Rectangle, Shape, ShapeError},
    layout::{AttributeSet, DetailMode, Feature, FeatureError, Role},
};
use serde::{Serialize, Serializer, ser::SerializeMap};
use serde_json::{Value, value::RawValue};
use std::{borrow::Cow, collections::BTreeMap, fmt, sync::Arc};

/// The name of a feature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Id {
    /// Text of 1 to 200 characters.
    Text(Box<str>),
    /// A whole number.
    Number(i64),
}

/// Most characters of an id.
const LONGEST_ID: usize = 200;

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

impl Id {
    /// How it is written.
    pub(super) fn text(&self) -> Cow<'_, str> {
        match self {
            Self::Text(text) => Cow::Borrowed(text),
            Self::Number(number) => Cow::Owned(number.to_string()),
        }
    }

    /// Whether it is written so.
    #[must_use]
    pub fn is(&self, text: &str) -> bool {
        match self {
            Self::Text(own) => **own == *text,
            Self::Number(number) => number.to_string() == text,
        }
    }
}

impl Serialize for Id {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Number(number) => serializer.serialize_i64(*number),
        }
    }
}

/// The attributes of a feature: a set that has a name, or its own.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Attributes {
    Named(Arc<str>),
    Inline(Arc<AttributeSet>),
}

/// Detail as it was asked for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mpd {
    pub detail: Detail,
    pub fine: Fine,
}

/// How a feature gets its detail.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Fine {
    Dynamic,
    Static,
    Split,
    Overlap(Attributes),
}

/// A feature as it was drawn: with the names of its attributes, the detail that it asks for, and the properties that have no influence on the terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Its name.
    pub id: Option<Id>,
    shape: Shape,
    attributes: Attributes,
    detail: Option<Mpd>,
    precedence: i32,
    rest: Option<Box<str>>,
}

/// The members of a feature as they were read.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub kind: Option<Value>,
    pub id: Option<Value>,
    pub geometry: Option<Geometry>,
    pub properties: Option<Value>,
}

impl Parts {
    /// The feature, taken out; what is wrong is added to the problems, with pointers below the feature.
    pub(super) fn drawn(&mut self, shared: &mut Shared, problems: &mut Problems) -> Option<Drawn> {
        if self.kind.as_ref().is_none_or(|kind| kind != "Feature") {
            problems.add("/type", "must be \"Feature\"");
        }
        let id = self.id.as_ref().filter(|id| !id.is_null()).and_then(|id| read_id(id, problems));
        let properties = properties::read(self.properties.take().unwrap_or_default(), shared, problems);
        let Some(geometry) = self.geometry.take() else {
            problems.add("/geometry", "is missing: a Point, LineString or Polygon");
            return None;
        };
        let measures = properties.as_ref().map(|properties| properties.measures).unwrap_or_default();
        let shape = geometry.shape(measures, problems);
        let Properties { attributes, detail, precedence, rest, .. } = properties?;
        let (shape, attributes) = (shape?, attributes?);
        if detail.is_some() && shape.curve().is_none() {
            problems.add("/properties/detail", ShapeError::NoEdges.to_string());
        }
        Some(Drawn { id, shape, attributes, detail, precedence, rest })
    }

    /// What a problem calls the feature.
    pub(super) fn label(&self, number: usize) -> String {
        match &self.id {
            Some(Value::String(id)) => format!("feature {:?}", id.chars().take(LONGEST_ID).collect::<String>()),
            Some(Value::Number(id)) => format!("feature {id}"),
            _ => format!("feature number {number}"),
        }
    }
}

fn read_id(id: &Value, problems: &mut Problems) -> Option<Id> {
    let read = match id {
        Value::String(text) if !text.is_empty() && text.chars().count() <= LONGEST_ID && !text.chars().any(char::is_control) => {
            Some(Id::Text(text.as_str().into()))
        }
        Value::Number(number) => number.as_i64().map(Id::Number),
        _ => None,
    };
    if read.is_none() {
        problems.add("/id", format!("must be text of 1 to {LONGEST_ID} characters or a whole number"));
    }
    read
}

impl Drawn {
    /// A feature as it would be drawn; `None` if its detail is expanded already, so that nobody could have drawn it. Its attributes get the name given.
    #[must_use]
    pub fn of(feature: &Feature, name: Option<Arc<str>>) -> Option<Self> {
        let shape = feature.shape();
        let curve = shape.curve();
        if curve.is_some_and(|curve| curve.stride() != 1) {
            return None;
        }
        let detail = curve.and_then(Curve::detail).map(|detail| Mpd { detail: *detail, fine: Fine::Dynamic });
        let shape = match shape {
            Shape::Line(curve) => Shape::Line(curve.plain()),
            Shape::Polygon(curve) => Shape::Polygon(curve.plain()),
            other => other.clone(),
        };
        let attributes = name.map_or_else(|| Attributes::Inline(Arc::clone(feature.attributes())), Attributes::Named);
        Some(Self { id: feature.id.clone().map(Id::Text), shape, attributes, detail, precedence: feature.precedence, rest: None })
    }

    /// The shape without detail.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// A rectangle that holds the shape with its detail.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        match &self.detail {
            Some(mpd) => self.shape.clone().detailed(mpd.detail).map_or_else(|_| self.shape.bounds(0.0), |shape| shape.bounds(0.0)),
            None => self.shape.bounds(0.0),
        }
    }

    /// The detail of its shape, and whether it fades with the spacing of samples.
    #[must_use]
    pub fn detail(&self) -> Option<(&Detail, bool)> {
        self.detail.as_ref().map(|mpd| (&mpd.detail, mpd.fine == Fine::Dynamic))
    }

    /// Its attributes, if they are known by name here or there.
    #[must_use]
    pub fn attributes<'a>(&'a self, sets: [&'a Sets; 2]) -> Option<&'a Arc<AttributeSet>> {
        match &self.attributes {
            Attributes::Inline(set) => Some(set),
            Attributes::Named(name) => sets.into_iter().find_map(|sets| sets.get(name)),
        }
    }

    /// The name of its attributes, if they have one.
    #[must_use]
    pub fn set(&self) -> Option<&str> {
        match &self.attributes {
            Attributes::Named(name) => Some(name),
            Attributes::Inline(_) => None,
        }
    }

    /// The names of all sets that it needs.
    pub fn sets(&self) -> impl Iterator<Item = &str> + '_ {
        let fine = match self.detail.as_ref().map(|mpd| &mpd.fine) {
            Some(Fine::Overlap(Attributes::Named(name))) => Some(&**name),
            _ => None,
        };
        self.set().into_iter().chain(fine)
    }

    /// Gives the set of a name another.
    pub(super) fn rename(&mut self, names: &BTreeMap<Box<str>, Arc<str>>) {
        let change = |attributes: &mut Attributes| {
            if let Attributes::Named(name) = attributes
                && let Some(new) = names.get(&**name)
            {
                *name = Arc::clone(new);
            }
        };
        change(&mut self.attributes);
        if let Some(Mpd { fine: Fine::Overlap(attributes), .. }) = &mut self.detail {
            change(attributes);
        }
    }

    /// The properties that have no influence on the terrain, as a JSON object.
    #[must_use]
    pub fn properties(&self) -> Option<&str> {
        self.rest.as_deref()
    }

    /// Gives it properties that have no influence on the terrain, in the place of those that it had. Names that features have otherwise are left out.
    pub fn describe(&mut self, properties: &serde_json::Map<String, Value>) {
        let own = |name: &str| matches!(name, "attributes" | "radius" | "elevation" | "along" | "detail" | "precedence");
        let rest: serde_json::Map<String, Value> =
            properties.iter().filter(|(name, _)| !own(name)).map(|(name, value)| (name.clone(), value.clone())).collect();
        self.rest = (!rest.is_empty()).then(|| Value::Object(rest).to_string().into());
    }

    /// The features of a layout that it stands for: one, or several by its detail. A problem is a place below the feature and what is wrong there.
    pub(super) fn features(&self, sets: [&Sets; 2]) -> Result<Vec<Feature>, (&'static str, String)> {
        let find = |attributes: &Attributes, place: &'static str| match attributes {
            Attributes::Inline(set) => Ok(Arc::clone(set)),
            Attributes::Named(name) => {
                let found = sets.into_iter().find_map(|sets| sets.get(name));
                found.cloned().ok_or_else(|| (place, sets[0].unknown(sets[1], name)))
            }
        };
        let set = find(&self.attributes, "/properties/attributes")?;
        let is_river = matches!(self.shape, Shape::Line(_)) && set.iter().any(|attribute| matches!(attribute.role, Role::Channel { .. }));
        let mut feature = Feature::new(self.shape.clone(), set).map_err(|error| match error {
            FeatureError::NoElevation(_) => ("/geometry/coordinates", format!("vertex 0: {error}, or property elevation")),
            FeatureError::Shape(_) => ("/geometry", error.to_string()),
        })?;
        feature.id = self.id.as_ref().map(|id| id.to_string().into());
        feature.precedence = self.precedence;
        let Some(Mpd { detail, fine }) = &self.detail else { return Ok(vec![feature]) };
        if is_river {
            let sound = Detail::river(detail.iterations(), detail.displacement(), detail.seed());
            sound.map_err(|error| ("/properties/detail/displacement", error.to_string()))?;
        }
        let mode = match fine {
            Fine::Dynamic => DetailMode::Dynamic,
            Fine::Static => DetailMode::Static,
            Fine::Split => DetailMode::Split,
            Fine::Overlap(fine) => DetailMode::Overlap(find(fine, "/properties/detail/attributes")?),
        };
        feature.detailed(*detail, &mode).map_err(|error| match error {
            FeatureError::NoElevation(_) => ("/geometry/coordinates", format!("vertex 0: {error}, or property elevation")),
            FeatureError::Shape(_) => ("/properties/detail", error.to_string()),
        })
    }
}

impl Serialize for Drawn {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("type", "Feature")?;
        if let Some(id) = &self.id {
            map.serialize_entry("id", id)?;
        }
        map.serialize_entry("geometry", &geometry::Written(&self.shape))?;
        map.serialize_entry("properties", &WrittenProperties(self))?;
        map.end()
    }
}

/// Attributes as they are written.
struct WrittenAttributes<'a>(&'a Attributes);

impl Serialize for WrittenAttributes<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Attributes::Named(name) => serializer.serialize_str(name),
            Attributes::Inline(set) => serializer.collect_seq(set.iter().map(attribute::Written)),
        }
    }
}

/// Properties as they are written.
struct WrittenProperties<'a>(&'a Drawn);

impl Serialize for WrittenProperties<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Drawn { shape, attributes, detail, precedence, rest, .. } = self.0;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("attributes", &WrittenAttributes(attributes))?;
        if let Shape::Circle { radius, .. } = shape {
            map.serialize_entry("radius", &Plain(*radius))?;
        }
        if let Some(Elevation::Constant(elevation)) = shape.curve().map(Curve::elevation) {
            map.serialize_entry("elevation", &Plain(*elevation))?;
        }
        if shape.curve().is_some_and(|curve| curve.way() == Along::Arc) {
            map.serialize_entry("along", "arc")?;
        }
        if let Some(detail) = detail {
            map.serialize_entry("detail", detail)?;
        }
        if *precedence != 0 {
            map.serialize_entry("precedence", precedence)?;
        }
        if let Some(rest) = rest {
            let rest: BTreeMap<String, Box<RawValue>> = serde_json::from_str(rest).map_err(serde::ser::Error::custom)?;
            for (name, value) in &rest {
                map.serialize_entry(name, value)?;
            }
        }
        map.end()
    }
}

impl Serialize for Mpd {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("iterations", &self.detail.iterations())?;
        map.serialize_entry("displacement", &Plain(self.detail.displacement()))?;
        map.serialize_entry("seed", &self.detail.seed())?;
        let mode = match &self.fine {
            Fine::Dynamic => "dynamic",
            Fine::Static => "static",
            Fine::Split => "split",
            Fine::Overlap(_) => "overlap",
        };
        map.serialize_entry("mode", mode)?;
        if let Fine::Overlap(attributes) = &self.fine {
            map.serialize_entry("attributes", &WrittenAttributes(attributes))?;
        }
        map.end()
    }
}
