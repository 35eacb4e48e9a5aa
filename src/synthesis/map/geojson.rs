//! Maps as JSON: the project's own form, or `GeoJSON` polygons with a type each.

use super::{Map, MapProblem, MapRegion, usual_snap};
use serde::{Deserialize, de::IgnoredAny};

/// A collection of features (RFC 7946) in metres.
#[derive(Deserialize)]
struct Collection {
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    features: Vec<Feature>,
    #[serde(default = "usual_snap")]
    snap: f64,
}

#[derive(Deserialize)]
struct Feature {
    geometry: Geometry,
    #[serde(default)]
    properties: Properties,
}

#[derive(Default, Deserialize)]
struct Properties {
    #[serde(rename = "type")]
    kind: Option<String>,
}

#[derive(Deserialize)]
#[serde(tag = "type", content = "coordinates")]
enum Geometry {
    Polygon(Vec<Vec<[f64; 2]>>),
    MultiPolygon(Vec<Vec<Vec<[f64; 2]>>>),
}

/// What tells the two forms apart.
#[derive(Deserialize)]
struct Form {
    features: Option<IgnoredAny>,
}

/// Reads JSON, with a pointer to what is wrong.
fn read<T: for<'de> Deserialize<'de>>(json: &[u8]) -> Result<T, MapProblem> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let value = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let pointer = error.path().iter().map(|segment| match segment {
            serde_path_to_error::Segment::Seq { index } => format!("/{index}"),
            serde_path_to_error::Segment::Map { key } => format!("/{}", key.replace('~', "~0").replace('/', "~1")),
            _ => String::new(),
        });
        MapProblem { pointer: pointer.collect(), detail: error.inner().to_string() }
    })?;
    deserializer.end().map_err(|error| MapProblem { pointer: String::new(), detail: error.to_string() })?;
    Ok(value)
}

impl Map {
    /// Reads a map: its own form, or a `GeoJSON` collection of polygons and multi-polygons in metres whose property `type` names a type of terrain.
    ///
    /// ```
    /// use terrane::synthesis::Map;
    /// let map = Map::parse(br#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"type": "plains"},
    ///     "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [900, 0], [900, 900], [0, 0]]]}}]}"#).map_err(|problem| problem.detail)?;
    /// assert_eq!(map.regions[0].kind, "plains");
    /// # Ok::<(), String>(())
    /// ```
    ///
    /// # Errors
    /// If it is neither, or a feature has no type; with a pointer.
    pub fn parse(json: &[u8]) -> Result<Self, MapProblem> {
        if read::<Form>(json)?.features.is_none() {
            return read(json);
        }
        let collection: Collection = read(json)?;
        if collection.kind != "FeatureCollection" {
            return Err(MapProblem { pointer: "/type".to_owned(), detail: format!("must be \"FeatureCollection\", is {:?}", collection.kind) });
        }
        let mut regions = Vec::new();
        for (number, feature) in collection.features.into_iter().enumerate() {
            let kind = feature.properties.kind.ok_or_else(|| MapProblem {
                pointer: format!("/features/{number}/properties/type"),
                detail: "must name a type of terrain of the library".to_owned(),
            })?;
            let polygons = match feature.geometry {
                Geometry::Polygon(rings) => vec![rings],
                Geometry::MultiPolygon(polygons) => polygons,
            };
            regions.extend(polygons.into_iter().map(|rings| MapRegion { kind: kind.clone(), rings }));
        }
        Ok(Self { regions, snap: collection.snap })
    }
}
