//! Drawings as users write them.

use super::{lattice::Diagonal, profile::Stepping};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Something wrong with a drawing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {detail}", if .pointer.is_empty() { "/" } else { .pointer })]
pub struct DrawingError {
    /// A JSON pointer (RFC 6901) into the drawing.
    pub pointer: String,
    /// What is wrong and what would be right.
    pub detail: String,
}

impl DrawingError {
    pub(super) fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }
}

/// A finite drawing: strokes and what makes terrain of them. Lengths are metres, heights units of cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drawing {
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The south-western node.
    #[serde(default)]
    pub origin: [f64; 2],
    /// Metres between nodes.
    #[serde(default = "one")]
    pub spacing: f64,
    /// Nodes from west to east and from south to north.
    pub size: [usize; 2],
    /// What its weights, programmes and places are drawn from.
    #[serde(default)]
    pub seed: u64,
    /// The weights of edges.
    pub edges: Edges,
    /// How long diagonal steps are.
    #[serde(default)]
    pub diagonal: Diagonal,
    /// The cost of sea level.
    pub sea_level: SeaLevel,
    /// How much the higher of two strokes counts.
    #[serde(default = "usual_bias")]
    pub bias: Quantity,
    /// A stroke ends where it is no higher than this …
    #[serde(default = "usual_sea_threshold")]
    pub sea_threshold: f64,
    /// … or than this share of the approximate height.
    #[serde(default = "usual_approximate_threshold")]
    pub approximate_threshold: f64,
    /// Scales of weights below this are filled from those around.
    #[serde(default = "usual_least_scale")]
    pub least_scale: f64,
    /// Metres a unit of cost.
    #[serde(default = "one")]
    pub vertical_scale: f64,
    /// Profiles by name.
    #[serde(default)]
    pub profiles: BTreeMap<String, WrittenProfile>,
    /// What is drawn, in the order of blending.
    pub strokes: Vec<Group>,
    /// Ridges that grow from what is drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ridges: Vec<Ridges>,
    /// Where other profiles rule.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub masks: Vec<Mask>,
}

pub(super) fn one() -> f64 {
    1.0
}

fn usual_bias() -> Quantity {
    Quantity::Number(3.0)
}

fn usual_sea_threshold() -> f64 {
    0.5
}

pub(super) fn usual_approximate_threshold() -> f64 {
    0.05
}

pub(super) fn usual_least_scale() -> f64 {
    0.001
}

/// The weights of edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Edges {
    /// Uniform in mean ± deviation, costs a metre: with a profile the mean only says how much the deviation counts.
    Random {
        /// Above 0.
        mean: f64,
        /// 0 up to less than the mean.
        deviation: f64,
    },
    /// The greys of a picture, each for the steps out of its node.
    Picture {
        /// The picture.
        picture: Picture,
        /// What black and white stand for, costs a metre above 0.
        range: [f64; 2],
    },
}

/// The cost of sea level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SeaLevel {
    /// Times the greatest cost of a generator (Rusnell 2009, Eq. 3.1).
    Scale(f64),
    /// Outright.
    Cost(f64),
}

/// A number, or one a node.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Quantity {
    /// The same everywhere.
    Number(f64),
    /// Of every node.
    Programme(Ramp),
}

/// A terrain programme over the plane, and what its values become.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Programme text.
    pub programme: String,
    /// Metres per programme unit.
    #[serde(default = "one")]
    pub scale: f64,
    /// Metres from the drawing's origin to the programme's.
    #[serde(default)]
    pub origin: [f64; 2],
    /// Hashed with the drawing's seed.
    #[serde(default)]
    pub seed: u64,
    /// What the least and the greatest value in the drawing become, in this order or the other; the values as they are without it (Rusnell 2009, Eq. 4.1).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[f64; 2]>,
}

/// A profile.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WrittenProfile {
    /// (distance from the crest, height), in any units: both are scaled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 2]>>,
    /// The height as an expression in the distance `d`, 0 … 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expression: Option<String>,
    /// A curve as a picture: of each column the uppermost dark pixel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// Metres from the crest to sea level of a feature whose crest costs nothing.
    pub width: f64,
    /// By slope where that keeps to the profile within 1 %, else by distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stepping: Option<Stepping>,
}

/// A picture of the drawing's size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Picture {
    /// A file as a `data:` address: PNG, JPEG or WebP.
    File(PictureFile),
    /// Greys from a programme, its least value in the drawing black and its greatest white.
    Programme(Ramp),
}

/// A picture as a `data:` address.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureFile {
    /// `data:image/png;base64,…`
    pub data: String,
}

/// Strokes that share profile and cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// What ridges and masks call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Where they lie.
    pub shape: Shape,
    /// The names of profiles, taken in turn, one a stroke; none: edges weigh what they weigh.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<String>,
    /// The cost of a node.
    pub cost: Quantity,
    /// What rules inside outlines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<Inside>,
}

/// What rules inside an outline.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inside {
    /// The name of the profile.
    pub profile: String,
    /// Whether the outline's stroke is the only one that counts there.
    #[serde(default)]
    pub only: bool,
}

/// Where strokes lie. Coordinates are metres from the drawing's origin, x east, y north.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Shape {
    /// A `GeoJSON` geometry: every point, line or polygon is a stroke, polygons are filled.
    Geometry(Geometry),
    /// Like it, polygons by their outlines.
    Outline(Geometry),
    /// Circles `[x, y, radius]`, by their outlines.
    Circles(Vec<[f64; 3]>),
    /// In places by chance.
    Scatter(Scatter),
    /// Where a picture's brightness changes most (Sobel, threshold halfway between the least and the greatest gradient; Rusnell 2009, Eq. 4.3), by connected parts.
    Edges(Picture),
    /// Pixels of one colour of a picture, by connected parts.
    Sketch(Sketch),
    /// Nodes by their path's cost from a line, a stroke a band.
    Bands(Bands),
}

/// Pixels of one colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sketch {
    /// The picture.
    pub picture: PictureFile,
    /// `#rrggbb`.
    pub colour: String,
}

/// Strokes in places by chance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// How many.
    pub count: usize,
    /// Of circles, least and greatest; single nodes without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<[f64; 2]>,
    /// Where they may lie.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Geometry>,
    /// Groups that they keep from, and how far.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub away: BTreeMap<String, f64>,
}

/// Nodes by their path's cost from a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bands {
    /// Where paths begin, at cost 0.
    pub from: Geometry,
    /// Ranges of costs; a node belongs to one from just above its first to its second.
    pub ranges: Vec<[f64; 2]>,
    /// Whether ranges are shares of the greatest cost.
    #[serde(default)]
    pub shares: bool,
    /// The cost of each range in the place of the group's.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub costs: Vec<f64>,
}

/// A `GeoJSON` geometry.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", content = "coordinates", deny_unknown_fields)]
pub enum Geometry {
    /// One node.
    Point([f64; 2]),
    /// Nodes, each a stroke.
    MultiPoint(Vec<[f64; 2]>),
    /// A line.
    LineString(Vec<[f64; 2]>),
    /// Lines, each a stroke.
    MultiLineString(Vec<Vec<[f64; 2]>>),
    /// Rings: the first is the outline, others are holes.
    Polygon(Vec<Vec<[f64; 2]>>),
    /// Polygons, each a stroke.
    MultiPolygon(Vec<Vec<Vec<[f64; 2]>>>),
}

/// Ridges that grow from strokes: random nodes' least-cost paths back to them join them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ridges {
    /// How many.
    pub count: usize,
    /// Of the cost found, what a node of a ridge costs.
    pub share: f64,
    /// Groups whose strokes they grow from; all without it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// Metres from the strokes that they grow from within which they begin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<f64>,
}

/// Where another profile rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mask {
    /// Polygons.
    pub geometry: Geometry,
    /// The name of the profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<String>,
    /// The groups that count there; all without it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub only: Vec<String>,
    /// A body of water: the greatest depth of its floor, which goes down from its shore by the profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
}

impl Drawing {
    /// Reads a drawing. What it means is checked when it is [made ready](super::Plan).
    ///
    /// # Errors
    /// If it is not JSON, or a field is missing, unknown or of the wrong type.
    pub fn parse(json: &[u8]) -> Result<Self, DrawingError> {
        parse(json)
    }
}

/// Reads a document; errors name their place.
pub(super) fn parse<T: serde::de::DeserializeOwned>(json: &[u8]) -> Result<T, DrawingError> {
    let mut deserializer = serde_json::Deserializer::from_slice(json);
    let document = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let path: String = error
            .path()
            .iter()
            .filter_map(|segment| match segment {
                serde_path_to_error::Segment::Seq { index } => Some(format!("/{index}")),
                serde_path_to_error::Segment::Map { key } => Some(format!("/{key}")),
                _ => None,
            })
            .collect();
        DrawingError::new(path, error.inner().to_string())
    })?;
    deserializer.end().map_err(|error| DrawingError::new("", error.to_string()))?;
    Ok(document)
}
