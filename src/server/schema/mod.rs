//! The JSON that goes over the wire, as `OpenAPI` describes it.

mod adaptive;
mod breeding;
mod evolution;
mod job;

pub(super) use adaptive::{
    FedSchema, FeedbackSchema, GenerationName, GenerationsSchema, GrownGeneration, HashOrNumber, PlayerSchema, PlayersSchema, PromiseSchema, ReturnSchema,
    WaySchema,
};
pub(super) use breeding::{GenerationSchema, IndividualSchema, SessionEntry, SessionList, SessionSchema};
pub(super) use evolution::{BestSchema, CriterionSchema, EvolutionSchema, GenerationPoint};
pub(super) use job::{JobList, JobPreviewSchema, JobSchema, JobStateName, RasterList, RasterSchema, WorkSchema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// A world document. Requests may leave out what has a default, or give `null` for it; responses hold every field.
#[derive(ToSchema)]
#[schema(as = World)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "documents are read and written by crate::world; this describes them")]
pub(super) struct WorldSchema {
    /// A name for people, at most 200 characters.
    #[schema(max_length = 200)]
    title: Option<String>,
    /// What the world is, at most 4000 characters.
    #[schema(max_length = 4000)]
    description: Option<String>,
    /// Whom maps should name, at most 200 characters.
    #[schema(max_length = 200)]
    attribution: Option<String>,
    /// Hashed into every noise lattice.
    #[schema(minimum = 0, maximum = 9_007_199_254_740_991_i64, example = 7)]
    seed: u64,
    /// The generator version that the world is pinned to; the newest by default.
    #[schema(minimum = 1, maximum = 1, default = 1)]
    generator: Option<u32>,
    /// The vertical range that elevations are clamped to.
    #[schema(inline)]
    elevation: Option<RangeSchema>,
    /// Elevation of the sea's surface in metres.
    #[schema(default = 0, minimum = -10000, maximum = 32767)]
    sea_level: Option<f64>,
    #[schema(inline)]
    base: BaseSchema,
    /// What lies above the base, at most 64 layers.
    #[schema(max_items = 64)]
    layers: Option<Vec<LayerSchema>>,
}

/// Something that lies above the base.
#[derive(ToSchema)]
#[schema(as = Layer)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "as above")]
pub(super) struct LayerSchema {
    /// 1 to 63 of a … z, 0 … 9 and -; like none of the others.
    #[schema(pattern = "^[a-z0-9][a-z0-9-]{0,62}$")]
    name: String,
    /// Where its terrain comes from: `{"layout": …}`, see docs/layouts.md; `{"paths": …}` or `{"raster": {"hash": …}}`, see docs/paths.md; `{"adaptive": …}`, see docs/evolving.md.
    #[schema(value_type = Object)]
    source: serde_json::Value,
    /// `replace`, `add`, `max` or `min`.
    #[schema(default = "replace", pattern = "^(replace|add|max|min)$")]
    blend: Option<String>,
    /// Layers are laid in ascending priority, of equal priority in their order.
    #[schema(default = 0)]
    priority: Option<i32>,
    /// Where it shows: `{"polygon": [[x, y], …]}` in metres, 3 to 512 corners; everywhere without one.
    #[schema(value_type = Option<Object>)]
    mask: Option<serde_json::Value>,
    /// Metres inside the mask's border over which the layer comes up to its full strength.
    #[schema(default = 0, minimum = 0)]
    fade: Option<f64>,
}

/// The vertical range, in metres.
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "as above")]
pub(super) struct RangeSchema {
    #[schema(default = -10000, minimum = -10000, maximum = 32767)]
    min: Option<f64>,
    #[schema(default = 9000, minimum = -10000, maximum = 32767)]
    max: Option<f64>,
}

/// The terrain beneath all layers: elevation = datum + amplitude · programme((x - origin\[0\]) / scale, (y - origin\[1\]) / scale).
#[derive(ToSchema)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "as above")]
pub(super) struct BaseSchema {
    /// A terrain programme, as text or as a JSON tree.
    programme: TermSchema,
    /// Metres per programme unit, more than 0 and at most 2^40.
    #[schema(exclusive_minimum = 0, maximum = 1_099_511_627_776_i64, example = 20000)]
    scale: f64,
    /// Plane metres of the programme's origin, x and y.
    #[schema(min_items = 2, max_items = 2)]
    origin: Option<[f64; 2]>,
    /// Metres of elevation per unit of the programme's value.
    #[schema(default = 1000, minimum = -1_000_000, maximum = 1_000_000)]
    amplitude: Option<f64>,
    /// Metres of elevation where the programme is 0.
    #[schema(default = 0, minimum = -1_000_000, maximum = 1_000_000)]
    datum: Option<f64>,
}

/// A terrain programme: its text, a constant, or an object with `op`.
#[derive(ToSchema)]
#[schema(as = Term, example = "fbm(1, 2, 8)")]
#[serde(untagged)]
#[expect(dead_code, reason = "as above")]
pub(super) enum TermSchema {
    Text(String),
    Constant(f64),
    Tree(BTreeMap<String, serde_json::Value>),
}

/// A programme of the library, with what shows it best as terrain. Requests may leave out what has a default, or give `null` for it; responses hold every field.
#[derive(ToSchema)]
#[schema(as = Programme)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "as above")]
pub(super) struct ProgrammeSchema {
    /// A name for people, at most 200 characters.
    #[schema(max_length = 200)]
    title: Option<String>,
    /// What terrain it makes, at most 4000 characters.
    #[schema(max_length = 4000)]
    description: Option<String>,
    /// What it can be found by; each 1 to 63 of a … z, 0 … 9 and -, none twice.
    #[schema(max_items = 16)]
    tags: Option<Vec<String>>,
    /// Where it came from, at most 200 characters.
    #[schema(default = "", max_length = 200, example = "shipped with Terrane")]
    origin: Option<String>,
    /// A terrain programme, as text or as a JSON tree.
    programme: TermSchema,
    /// Metres per programme unit, more than 0 and at most 2^40.
    #[schema(default = 20000, exclusive_minimum = 0, maximum = 1_099_511_627_776_i64)]
    scale: Option<f64>,
    /// Metres of elevation per unit of the programme's value.
    #[schema(default = 1000, minimum = -1_000_000, maximum = 1_000_000)]
    amplitude: Option<f64>,
    /// Metres of elevation where the programme is 0.
    #[schema(default = 0, minimum = -1_000_000, maximum = 1_000_000)]
    datum: Option<f64>,
    /// Elevation of the sea's surface in metres.
    #[schema(default = 0, minimum = -10000, maximum = 32767)]
    sea_level: Option<f64>,
    /// The seed that it is shown with.
    #[schema(default = 0, minimum = 0, maximum = 9_007_199_254_740_991_i64)]
    seed: Option<u64>,
    /// The vertical range that elevations are clamped to.
    #[schema(inline)]
    elevation: Option<RangeSchema>,
}

/// A programme in a list.
#[derive(Serialize, ToSchema)]
pub(super) struct ProgrammeEntry {
    pub name: String,
    /// The programme's title; its name where it has none.
    pub title: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    pub tags: Vec<String>,
    /// Where it came from.
    pub origin: String,
    pub revision: String,
    /// URL of its document.
    pub document: String,
    /// URL of its picture.
    pub preview: String,
}

/// What was found in the library.
#[derive(Serialize, ToSchema)]
pub(super) struct ProgrammeList {
    /// How many programmes were found.
    pub found: usize,
    /// The first 1000 of them, by name.
    #[schema(max_items = 1000)]
    pub programmes: Vec<ProgrammeEntry>,
}

/// A world in a list.
#[derive(Serialize, ToSchema)]
pub(super) struct WorldEntry {
    pub name: String,
    /// The world's title; its name where it has none.
    pub title: String,
    pub revision: String,
}

/// The worlds of a server.
#[derive(Serialize, ToSchema)]
pub(super) struct WorldList {
    pub worlds: Vec<WorldEntry>,
}

/// A way to draw a world as tiles.
#[derive(Serialize, ToSchema)]
pub(super) struct TilesetEntry {
    pub grid: &'static str,
    pub tileset: &'static str,
    /// URL of its `TileJSON`.
    pub tilejson: String,
}

/// A world with its tilesets.
#[derive(Serialize, ToSchema)]
pub(super) struct CatalogEntry {
    #[serde(flatten)]
    pub world: WorldEntry,
    pub tilesets: Vec<TilesetEntry>,
}

/// The worlds of a server with their tilesets.
#[derive(Serialize, ToSchema)]
pub(super) struct Catalog {
    pub worlds: Vec<CatalogEntry>,
}

/// One save of a world.
#[derive(Serialize, ToSchema)]
pub(super) struct RevisionSchema {
    /// Counts the saves and deletions of a name from 1.
    pub number: i64,
    /// When it was saved, RFC 3339, UTC.
    pub time: String,
    /// First 32 hex digits of SHA-256 of the document in canonical form (RFC 8785).
    pub revision: String,
}

/// The ground at a point, in metres.
#[derive(Serialize, ToSchema)]
pub(super) struct ElevationSchema {
    pub x: f64,
    pub y: f64,
    /// Only where the point was given by longitude and latitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub longitude: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub latitude: Option<f64>,
    /// Elevation of the ground, also under water.
    pub elevation: f32,
    /// Depth of the water above it, 0 on land.
    pub water_depth: f32,
}

/// Two numbers.
#[derive(ToSchema)]
#[schema(as = Position, min_items = 2, max_items = 2)]
#[expect(dead_code, reason = "as above")]
pub(super) struct PositionSchema([f64; 2]);

/// Points that are asked for: one of `points` and `lonlats`.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BatchSchema {
    /// `[x, y]` in metres, at most 10,000.
    #[schema(value_type = Option<Vec<PositionSchema>>, max_items = 10000)]
    pub points: Option<Vec<[f64; 2]>>,
    /// `[longitude, latitude]` in degrees, on the plane as Web Mercator has them, at most 10,000.
    #[schema(value_type = Option<Vec<PositionSchema>>, max_items = 10000)]
    pub lonlats: Option<Vec<[f64; 2]>>,
    /// Metres a pixel: the elevations as tiles of this spacing see them. Without it, the function as it is.
    #[schema(exclusive_minimum = 0)]
    pub spacing: Option<f64>,
}

/// The ground at points, in their order.
#[derive(Serialize, ToSchema)]
pub(super) struct ElevationsSchema {
    /// Elevation of the ground in metres, also under water.
    pub elevation: Vec<f32>,
    /// Depth of the water above it in metres, 0 on land.
    pub water_depth: Vec<f32>,
}

/// An area whose ways are asked for.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct AccessibilityQuestion {
    /// `[minx, miny, maxx, maxy]` in metres.
    #[schema(min_items = 4, max_items = 4)]
    pub bbox: [f64; 4],
    /// Metres between cells.
    #[schema(exclusive_minimum = 0)]
    pub spacing: f64,
    /// The steepest slope that can be gone, in degrees: above 0, below 90.
    #[schema(default = 15, exclusive_minimum = 0, exclusive_maximum = 90)]
    pub slope: Option<f64>,
}

/// What of an area can be reached.
#[derive(Serialize, ToSchema)]
#[schema(as = Accessibility)]
pub(super) struct AccessibilitySchema {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from south to north.
    pub rows: usize,
    /// The share of cells that are not too steep, 0 … 1.
    pub accessible: f64,
    /// The share of cells that lie in the largest connected area of these, 0 … 1.
    pub largest: f64,
    /// Connected areas of cells that are not too steep.
    pub areas: usize,
    /// Connected areas of cells that are.
    pub obstacles: usize,
    /// Length of the sides between the two in metres.
    pub edge: f64,
}

/// An area whose ground is asked about.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StatisticsQuestion {
    /// `[minx, miny, maxx, maxy]` in metres.
    #[schema(min_items = 4, max_items = 4)]
    pub bbox: [f64; 4],
    /// Metres between samples.
    #[schema(exclusive_minimum = 0)]
    pub spacing: f64,
}

/// What the ground of an area is like.
#[derive(Serialize, ToSchema)]
#[schema(as = Statistics)]
pub(super) struct StatisticsSchema {
    /// Slopes in degrees at equal shares of the ground, ascending.
    #[schema(min_items = 33, max_items = 33)]
    pub slopes: Vec<f64>,
    /// Heights as shares of the relief at equal shares of the ground, ascending from 0 to 1.
    #[schema(min_items = 33, max_items = 33)]
    pub heights: Vec<f64>,
    /// Metres between the least and the greatest elevation.
    pub relief: f64,
    /// Root mean square of what samples differ by from the mean of their eight neighbours, a metre of spacing.
    pub roughness: f64,
}

/// The ground along a line, in metres.
#[derive(Serialize, ToSchema)]
pub(super) struct ProfileSchema {
    /// Of the line on the plane.
    pub length: f64,
    /// The sum of all rises between neighbours, and that of all falls.
    pub ascent: f64,
    pub descent: f64,
    /// Of each point from the first, along the line.
    pub distance: Vec<f64>,
    /// `[x, y]`.
    pub points: Vec<[f64; 2]>,
    /// Of the ground, also under water.
    pub elevation: Vec<f32>,
    /// Depth of the water above it, 0 on land.
    pub water_depth: Vec<f32>,
}

/// A feature (RFC 7946), in world metres; the third coordinate is the elevation.
#[derive(ToSchema)]
#[schema(as = Feature)]
#[expect(dead_code, reason = "read and written by crate::layout::geojson; this describes it")]
pub(super) struct FeatureSchema {
    /// `Feature`.
    #[serde(rename = "type")]
    #[schema(rename = "type", pattern = "^Feature$", example = "Feature")]
    kind: String,
    /// Text of 1 to 200 characters or a whole number; made where it is missing.
    #[schema(required = false)]
    id: serde_json::Value,
    geometry: GeometrySchema,
    /// `attributes` (the name of a set, or a list), and as needed `elevation`, `radius`, `detail`, `along`, `precedence`. All others are kept and have no influence.
    #[schema(value_type = Object)]
    properties: serde_json::Value,
}

/// Where a feature lies (RFC 7946).
#[derive(ToSchema)]
#[schema(as = Geometry)]
#[expect(dead_code, reason = "as above")]
pub(super) struct GeometrySchema {
    /// `Point`, `LineString` or `Polygon`.
    #[serde(rename = "type")]
    #[schema(rename = "type", pattern = "^(Point|LineString|Polygon)$", example = "Point")]
    kind: String,
    /// Of a point a position, of a line its positions, of a polygon its rings; a position is x, y and, where it is known, the elevation.
    coordinates: Vec<serde_json::Value>,
}

/// Features with the sets of attributes that they share.
#[derive(ToSchema)]
#[schema(as = FeatureCollection)]
#[expect(dead_code, reason = "as above")]
pub(super) struct FeatureCollectionSchema {
    /// `FeatureCollection`.
    #[serde(rename = "type")]
    #[schema(rename = "type", pattern = "^FeatureCollection$", example = "FeatureCollection")]
    kind: String,
    /// Lists of attributes by name.
    #[schema(required = false)]
    attributes: serde_json::Value,
    features: Vec<FeatureSchema>,
    /// How many features were found.
    #[schema(required = false, rename = "numberMatched")]
    number_matched: usize,
    /// How many are here.
    #[schema(required = false, rename = "numberReturned")]
    number_returned: usize,
    /// `self`, and `next` where there are more.
    #[schema(required = false)]
    links: Vec<serde_json::Value>,
}

/// What was added to a world's features.
#[derive(Serialize, ToSchema)]
pub(super) struct AddedSchema {
    /// How many features.
    pub added: usize,
    /// Their ids, of many the first 1000.
    pub ids: Vec<String>,
    /// The world's new revision.
    pub revision: String,
}

/// Whether the server lives or takes requests.
#[derive(Serialize, ToSchema)]
pub(super) struct Health {
    pub status: &'static str,
}

/// What is wrong with a request (RFC 9457).
#[derive(Serialize, ToSchema)]
pub(super) struct ProblemDetails {
    /// A stable name of the kind of problem.
    #[serde(rename = "type")]
    pub kind: String,
    pub title: String,
    pub status: u16,
    pub detail: String,
    /// Each wrong part.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    pub errors: Vec<ProblemEntry>,
}

/// One wrong part of a request.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct ProblemEntry {
    /// A JSON pointer into the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// A path or query parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<String>,
    /// What is wrong and what would be right.
    pub detail: String,
    /// In programme text: the pointer of the wrong node in the programme's tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
    /// In programme text: the first wrong character.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<usize>,
    /// In programme text: the character after the last wrong one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end: Option<usize>,
}

impl ProblemEntry {
    pub(super) fn pointer(pointer: String, detail: impl Into<String>) -> Self {
        Self { pointer: Some(pointer), parameter: None, detail: detail.into(), at: None, start: None, end: None }
    }

    pub(super) fn parameter(name: &str, detail: impl Into<String>) -> Self {
        Self { pointer: None, parameter: Some(name.to_owned()), detail: detail.into(), at: None, start: None, end: None }
    }
}
