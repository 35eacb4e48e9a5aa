//! Jobs and rasters.

use crate::world::WorkKind;
use serde::Serialize;
use utoipa::ToSchema;

/// What a job is asked for: one of the members.
#[derive(ToSchema)]
#[schema(as = Work)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "work is read by crate::world; this describes it")]
pub(in crate::server) struct WorkSchema {
    /// `{"drawing": …}`, as a layer's source: see docs/paths.md. It becomes a raster.
    #[schema(value_type = Option<Object>)]
    paths: Option<serde_json::Value>,
    /// `{"aim": …, "settings": …, "seed": …, "goal": …}`: a programme that is bred towards what is wanted, see docs/evolving.md.
    #[schema(value_type = Option<Object>)]
    evolution: Option<serde_json::Value>,
}

/// Long work.
#[derive(Serialize, ToSchema)]
#[schema(as = Job)]
pub(in crate::server) struct JobSchema {
    /// The name of what is asked for: asking for the same gives the same job.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub id: String,
    /// The member of what is asked for.
    #[schema(inline, value_type = WorkKindName)]
    pub kind: WorkKind,
    /// The title of what is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// When it was asked for, RFC 3339, UTC.
    pub time: String,
    #[schema(inline)]
    pub state: JobStateName,
    /// The share that is done, 0 … 1.
    #[schema(minimum = 0, maximum = 1)]
    pub progress: f64,
    /// URL of the raster that it made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub raster: Option<String>,
    /// URL of how an evolution goes, and of what it found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evolution: Option<String>,
    /// Why it failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failure: Option<String>,
    /// What it is asked for; not in lists.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub work: Option<serde_json::Value>,
}

/// How far a job is.
#[derive(Serialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::server) enum JobStateName {
    Waiting,
    Running,
    /// Until it is resumed or asked for again.
    Stopped,
    Done,
    Failed,
}

/// What kind of work a job does.
#[derive(ToSchema)]
#[schema(rename_all = "lowercase")]
#[expect(dead_code, reason = "the kind is that of crate::world; this describes it")]
pub(in crate::server) enum WorkKindName {
    Paths,
    Evolution,
}

/// The jobs of a server.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct JobList {
    /// The 1000 that were asked for last, newest first.
    #[schema(max_items = 1000)]
    pub jobs: Vec<JobSchema>,
}

/// About what a job will make.
#[derive(Serialize, ToSchema)]
#[schema(as = JobPreview)]
pub(in crate::server) struct JobPreviewSchema {
    /// Least x, least y, greatest x, greatest y of the picture in metres.
    #[schema(min_items = 4, max_items = 4)]
    pub bbox: [f64; 4],
    /// Least and greatest height in metres.
    #[schema(min_items = 2, max_items = 2)]
    pub elevation: [f32; 2],
    /// Steps that the job will take: strokes.
    pub steps: usize,
    /// A relief picture, transparent where there is nothing: `data:image/png;base64,…`
    pub picture: String,
}

/// Heights that are kept.
#[derive(Serialize, ToSchema)]
#[schema(as = Raster)]
pub(in crate::server) struct RasterSchema {
    /// The name of the content; a layer of a world shows it by `{"raster": {"hash": …}}`.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub hash: String,
    /// When it was stored, RFC 3339, UTC.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Least x, least y, greatest x, greatest y of the nodes in metres.
    #[schema(min_items = 4, max_items = 4)]
    pub bbox: [f64; 4],
    /// Metres between nodes.
    pub spacing: f64,
    /// Nodes from west to east.
    pub columns: usize,
    /// Nodes from south to north.
    pub rows: usize,
    /// Least and greatest height in metres, 0 among them.
    #[schema(min_items = 2, max_items = 2)]
    pub elevation: [f32; 2],
    /// URL of the heights: f32 little-endian, row by row from the north.
    pub heights: String,
    /// URL of its picture.
    pub preview: String,
}

/// The rasters of a server.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct RasterList {
    /// The newest 1000, newest first.
    #[schema(max_items = 1000)]
    pub rasters: Vec<RasterSchema>,
}
