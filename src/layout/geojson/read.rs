//! Features as they come, one after the other.

use super::{
    collection::MOST_FEATURES,
    coordinates::MOST_VERTICES,
    drawn::{Drawn, Parts},
    geometry::{Geometry, GeometrySeed},
    members::{escaped, near, shown},
    problem::Problems,
    sets::Sets,
};
use crate::layout::{AttributeSet, ContentHash};
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fmt,
    sync::Arc,
};

/// What features share: names, and sets of equal content.
#[derive(Debug, Default)]
pub(super) struct Shared {
    names: BTreeSet<Arc<str>>,
    sets: BTreeMap<ContentHash, Arc<AttributeSet>>,
    /// Lists of attributes that were read last, and their sets.
    lists: VecDeque<(Value, Arc<AttributeSet>)>,
}

/// Lists of attributes that are remembered: neighbours mostly have the same few.
const LISTS: usize = 8;

impl Shared {
    pub(super) fn name(&mut self, name: &str) -> Arc<str> {
        if let Some(known) = self.names.get(name) {
            return Arc::clone(known);
        }
        let name: Arc<str> = name.into();
        self.names.insert(Arc::clone(&name));
        name
    }

    /// The set that a list of attributes stands for, read by `read` unless it is known.
    pub(super) fn list(&mut self, list: Value, read: impl FnOnce(Value) -> Option<AttributeSet>) -> Option<Arc<AttributeSet>> {
        if let Some((_, known)) = self.lists.iter().find(|(known, _)| *known == list) {
            return Some(Arc::clone(known));
        }
        let set = read(list.clone())?;
        let set = Arc::clone(self.sets.entry(set.hash()).or_insert_with(|| Arc::new(set)));
        self.lists.truncate(LISTS - 1);
        self.lists.push_front((list, Arc::clone(&set)));
        Some(set)
    }
}

/// How the features stand in what is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Form {
    /// A Feature, or one a line.
    #[default]
    Features,
    /// In a `FeatureCollection`.
    Collection,
}

/// What was read so far.
#[derive(Debug, Default)]
pub(super) struct Reader {
    pub features: Vec<Drawn>,
    pub sets: Sets,
    pub problems: Problems,
    pub form: Option<Form>,
    /// Features, also those that are wrong.
    pub count: usize,
    shared: Shared,
    vertices: usize,
    /// The vertex at which reading stands.
    vertex: Option<usize>,
}

impl Reader {
    /// Where a feature stands.
    pub(super) fn pointer(form: Option<Form>, alone: bool, number: usize) -> String {
        match form {
            Some(Form::Collection) => format!("/features/{number}"),
            _ if alone => String::new(),
            _ => format!("/{number}"),
        }
    }

    /// Takes in what another read of features alone; `false` if it is anything else, or too much.
    pub(super) fn absorb(&mut self, other: Self) -> bool {
        let alone = other.problems.count() == 0 && other.sets.is_empty() && other.form.is_none_or(|form| form == Form::Features);
        let fits = self.count + other.count <= MOST_FEATURES && self.vertices + other.vertices <= MOST_VERTICES[1];
        if alone && fits {
            self.form = self.form.or(other.form);
            self.count += other.count;
            self.vertices += other.vertices;
            self.features.extend(other.features);
        }
        alone && fits
    }

    /// Says that reading had to stop, and where.
    pub(super) fn stop(&mut self, what: &str) {
        let vertex = self.vertex.map_or_else(String::new, |vertex| format!("vertex {vertex}: "));
        let pointer = Self::pointer(self.form, self.count == 0, self.count);
        self.problems.add(pointer, format!("feature number {}: {vertex}{what}", self.count));
    }

    /// Takes in a feature, which may be `alone`; `first` is the number of its first problem.
    fn end_feature(&mut self, mut parts: Parts, first: usize, alone: bool) {
        let number = self.count;
        self.count += 1;
        self.vertices += parts.geometry.as_ref().map_or(0, |geometry| geometry.coordinates.positions.len());
        let drawn = parts.drawn(&mut self.shared, &mut self.problems);
        if self.count == MOST_FEATURES + 1 {
            self.problems.add("", format!("is the first beyond the {MOST_FEATURES} features that there may be"));
        }
        if self.vertices > MOST_VERTICES[1] && self.problems.count() == first {
            self.problems.add("", format!("with it there are more than the {} vertices that all features may have", MOST_VERTICES[1]));
        }
        if self.problems.count() > first {
            let pointer = Self::pointer(self.form, alone, number);
            self.problems.place(first, &pointer, &format!("{}: ", parts.label(number)));
        }
        // What cannot be stored any more need not be kept.
        if self.problems.count() == 0 {
            self.features.extend(drawn);
        } else {
            self.features = Vec::new();
        }
    }
}

/// Reads one value of the document: a Feature or a `FeatureCollection`.
pub(super) struct TopSeed<'a>(pub &'a mut Reader);

impl<'de> DeserializeSeed<'de> for TopSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for TopSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a GeoJSON Feature or FeatureCollection")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let reader = self.0;
        let (mut parts, mut has_features, first) = (Parts::default(), false, reader.problems.count());
        while let Some(name) = map.next_key::<String>()? {
            match &*name {
                "features" if reader.form.is_none() => {
                    has_features = true;
                    reader.form = Some(Form::Collection);
                    map.next_value_seed(FeaturesSeed(reader))?;
                }
                "attributes" => {
                    let value: Value = map.next_value()?;
                    let sets = Sets::read(value, "/attributes", &mut reader.problems);
                    sets.iter().for_each(|(name, set)| drop(reader.sets.insert(name, Arc::clone(set))));
                }
                // Members of the standard, of OGC API Features and of GDAL that say nothing about terrain.
                "bbox" | "links" | "name" | "crs" | "timeStamp" | "numberMatched" | "numberReturned" => {
                    map.next_value::<IgnoredAny>()?;
                }
                other => feature_member(&mut parts, other, reader, &mut map)?,
            }
        }
        let Some(kind) = parts.kind.as_ref().and_then(Value::as_str) else {
            reader.problems.add("/type", "must be \"Feature\" or \"FeatureCollection\"");
            return Ok(());
        };
        match (kind, has_features) {
            ("FeatureCollection", true) => {}
            ("FeatureCollection", false) => reader.problems.add("/features", "must be there once: a list of features"),
            _ if has_features => reader.problems.add("/type", "must be \"FeatureCollection\", since there are features"),
            (other, false) if other != "Feature" => {
                let pointer = Reader::pointer(Some(Form::Features), reader.count == 0, reader.count);
                reader.problems.add(format!("{pointer}/type"), format!("must be \"FeatureCollection\" or \"Feature\", got {}", shown(&Value::from(other))));
            }
            _ => {
                reader.form = Some(Form::Features);
                reader.end_feature(parts, first, reader.count == 0);
            }
        }
        Ok(())
    }
}

/// Reads a member of a feature.
fn feature_member<'de, A: MapAccess<'de>>(parts: &mut Parts, name: &str, reader: &mut Reader, map: &mut A) -> Result<(), A::Error> {
    match name {
        "type" => parts.kind = Some(map.next_value()?),
        "id" => parts.id = Some(map.next_value()?),
        "properties" => parts.properties = Some(map.next_value()?),
        "geometry" => {
            let mut geometry = Geometry::default();
            let read = map.next_value_seed(GeometrySeed { problems: &mut reader.problems, into: &mut geometry });
            reader.vertex = read.is_err().then_some(geometry.coordinates.vertices);
            read?;
            parts.geometry = Some(geometry);
        }
        "bbox" => {
            map.next_value::<IgnoredAny>()?;
        }
        other => {
            map.next_value::<IgnoredAny>()?;
            let near = near(other, &["type", "id", "geometry", "properties", "features", "attributes"]).unwrap_or_default();
            reader
                .problems
                .add(format!("/{}", escaped(other)), format!("is no member of a feature or a collection; what is your own goes into properties{near}"));
        }
    }
    Ok(())
}

/// Reads the list of features.
struct FeaturesSeed<'a>(&'a mut Reader);

impl<'de> DeserializeSeed<'de> for FeaturesSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for FeaturesSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of features")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        while list.next_element_seed(FeatureSeed(self.0))?.is_some() {}
        Ok(())
    }
}

/// Reads one feature of a list.
struct FeatureSeed<'a>(&'a mut Reader);

impl<'de> DeserializeSeed<'de> for FeatureSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for FeatureSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a GeoJSON Feature")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let reader = self.0;
        let (mut parts, first) = (Parts::default(), reader.problems.count());
        // When no more problems are told and no more features are kept, the rest is passed over.
        if reader.problems.is_full() || reader.count > MOST_FEATURES {
            while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
            return Ok(());
        }
        while let Some(name) = map.next_key::<String>()? {
            feature_member(&mut parts, &name, reader, &mut map)?;
        }
        reader.end_feature(parts, first, false);
        Ok(())
    }
}
