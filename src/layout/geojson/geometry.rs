//! Geometries as shapes, and back.

use super::{
    coordinates::{Coordinates, CoordinatesSeed, Position},
    members::{near, shown},
    problem::Problems,
};
use crate::geometry::{Along, Curve, Elevation, Shape, ShapeError};
use serde::{
    Serialize, Serializer,
    de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor},
    ser::SerializeMap,
};
use serde_json::Value;
use std::fmt;

const KINDS: [&str; 3] = ["Point", "LineString", "Polygon"];
const SEVERAL: [&str; 4] = ["MultiPoint", "MultiLineString", "MultiPolygon", "GeometryCollection"];

/// A geometry as it was read.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    kind: Option<&'static str>,
    pub coordinates: Coordinates,
    /// Whether something was wrong with it already.
    pub faulty: bool,
}

/// What the properties say about the shape.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Measures {
    pub radius: Option<f64>,
    pub elevation: Option<f64>,
    pub along: Along,
}

impl Geometry {
    /// The shape; what is wrong is added to the problems.
    pub(super) fn shape(self, measures: Measures, problems: &mut Problems) -> Option<Shape> {
        let before = problems.count();
        let Self { kind, coordinates, faulty } = self;
        let kind = kind.filter(|_| !faulty)?;
        if measures.radius.is_some() && kind != "Point" {
            problems.add("/properties/radius", format!("makes a circle of a Point, not of a {kind}"));
        }
        if measures.elevation.is_some() && !coordinates.elevations.is_empty() {
            problems.add("/properties/elevation", "the vertices have elevations already: give either third coordinates or this");
        }
        let depth = KINDS.iter().position(|known| *known == kind);
        if coordinates.depth.is_some() && coordinates.depth != depth {
            let right = ["[x, y]", "[[x, y], …]", "[[[x, y], …], …]"][depth.unwrap_or_default()];
            problems.add(
                "/geometry/coordinates",
                format!("vertex 0: the coordinates of a {kind} are {right}, here a position stands {} lists deep", coordinates.depth.unwrap_or_default()),
            );
        }
        if let Some(vertex) = coordinates.uneven.filter(|_| problems.count() == before) {
            let at = format!("/geometry/coordinates{}", coordinates.pointer(vertex));
            problems.add(at, format!("vertex {vertex} and vertex 0 are unlike: either every vertex has an elevation as its third coordinate or none has"));
        }
        if problems.count() > before {
            return None;
        }
        match made(kind, &coordinates, measures) {
            Ok(shape) => Some(shape),
            Err(error) => {
                let pointer = match (&error, error.vertex()) {
                    (ShapeError::Radius(_), _) => "/properties/radius".to_owned(),
                    (_, Some(vertex)) => format!("/geometry/coordinates{}", coordinates.pointer(vertex)),
                    (_, None) => "/geometry".to_owned(),
                };
                problems.add(pointer, error.to_string());
                None
            }
        }
    }
}

fn made(kind: &str, coordinates: &Coordinates, measures: Measures) -> Result<Shape, ShapeError> {
    let elevation = match (measures.elevation, &coordinates.elevations) {
        (Some(elevation), _) => Elevation::Constant(elevation),
        (None, elevations) if elevations.is_empty() => Elevation::Absent,
        (None, elevations) => Elevation::Vertices(elevations.as_slice().into()),
    };
    let along = |shape: Shape| match shape {
        Shape::Line(curve) => Shape::Line(curve.along(measures.along)),
        Shape::Polygon(curve) => Shape::Polygon(curve.along(measures.along)),
        other => other,
    };
    match kind {
        "Point" => {
            let at = coordinates.positions.first().copied().unwrap_or([f64::NAN; 2]);
            let elevation = measures.elevation.or(coordinates.elevations.first().copied());
            measures.radius.map_or_else(|| Shape::point(at, elevation), |radius| Shape::circle(at, radius, elevation))
        }
        "LineString" => Shape::line(coordinates.positions.clone(), elevation).map(along),
        _ => {
            let ring = |list: &std::ops::Range<usize>| coordinates.positions[list.clone()].to_vec();
            Shape::polygon(coordinates.lists.iter().map(ring).collect(), elevation).map(along)
        }
    }
}

/// Reads a geometry; what is wrong but can be passed over is added to the problems.
pub(super) struct GeometrySeed<'a> {
    pub problems: &'a mut Problems,
    pub into: &'a mut Geometry,
}

impl GeometrySeed<'_> {
    fn wrong(self, got: &str) {
        self.into.faulty = true;
        self.problems.add("/geometry", format!("must be a Point, LineString or Polygon, got {got}"));
    }

    fn set_kind(&mut self, value: &Value) {
        let written = value.as_str().unwrap_or_default();
        self.into.kind = KINDS.iter().find(|kind| **kind == written).copied();
        if self.into.kind.is_some() {
            return;
        }
        self.into.faulty = true;
        let detail = if SEVERAL.contains(&written) {
            format!("a {written} is several shapes: make each a Feature of its own, a Point, LineString or Polygon")
        } else {
            format!("must be Point, LineString or Polygon, got {}{}", shown(value), near(written, &KINDS).unwrap_or_default())
        };
        self.problems.add("/geometry/type", detail);
    }
}

impl<'de> DeserializeSeed<'de> for GeometrySeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for GeometrySeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a geometry")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        let (mut kinds, mut coordinates) = (0, 0);
        let before = self.problems.count();
        while let Some(name) = map.next_key::<String>()? {
            match &*name {
                "type" => {
                    kinds += 1;
                    let value = map.next_value()?;
                    self.set_kind(&value);
                }
                "coordinates" => {
                    coordinates += 1;
                    let first = self.problems.count();
                    self.into.coordinates = Coordinates::default();
                    map.next_value_seed(CoordinatesSeed { into: &mut self.into.coordinates, problems: self.problems, level: 0 })?;
                    self.problems.place(first, "/geometry/coordinates", "");
                }
                "bbox" | "geometries" => {
                    map.next_value::<IgnoredAny>()?;
                }
                other => {
                    map.next_value::<IgnoredAny>()?;
                    self.problems.add(format!("/geometry/{}", super::members::escaped(other)), "is no member of a geometry; there are type and coordinates");
                }
            }
        }
        if kinds != 1 {
            self.into.faulty = true;
            self.problems.add("/geometry/type", "must be there once: Point, LineString or Polygon");
        }
        if coordinates != 1 && !self.into.faulty {
            self.problems.add("/geometry/coordinates", "must be there once");
        }
        self.into.faulty |= self.problems.count() > before;
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.wrong("null");
        Ok(())
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.wrong(&value.to_string());
        Ok(())
    }

    fn visit_f64<E>(self, number: f64) -> Result<(), E> {
        self.wrong(&number.to_string());
        Ok(())
    }

    fn visit_i64<E>(self, number: i64) -> Result<(), E> {
        self.wrong(&number.to_string());
        Ok(())
    }

    fn visit_u64<E>(self, number: u64) -> Result<(), E> {
        self.wrong(&number.to_string());
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        self.wrong("text");
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        self.wrong("a list");
        Ok(())
    }
}

/// A shape as a geometry.
pub(super) struct Written<'a>(pub &'a Shape);

impl Serialize for Written<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(2))?;
        match self.0 {
            Shape::Point { at, elevation } | Shape::Circle { centre: at, elevation, .. } => {
                map.serialize_entry("type", "Point")?;
                map.serialize_entry("coordinates", &Position(*at, *elevation))?;
            }
            Shape::Line(curve) => {
                map.serialize_entry("type", "LineString")?;
                map.serialize_entry("coordinates", &Ring { curve, first: 0, vertices: curve.vertices() })?;
            }
            Shape::Polygon(curve) => {
                let mut first = 0;
                let ring = |vertices| {
                    let ring = Ring { curve, first, vertices };
                    first += ring.vertices.len();
                    ring
                };
                map.serialize_entry("type", "Polygon")?;
                map.serialize_entry("coordinates", &curve.parts().map(ring).collect::<Vec<_>>())?;
            }
        }
        map.end()
    }
}

/// The positions of a line or a ring.
struct Ring<'a> {
    curve: &'a Curve,
    first: usize,
    vertices: &'a [[f64; 2]],
}

impl Serialize for Ring<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let elevation = |vertex: usize| match self.curve.elevation() {
            Elevation::Vertices(elevations) => elevations.get(vertex).copied(),
            Elevation::Absent | Elevation::Constant(_) => None,
        };
        serializer.collect_seq(self.vertices.iter().enumerate().map(|(i, at)| Position(*at, elevation(self.first + i))))
    }
}
