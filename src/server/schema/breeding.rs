//! Sessions of breeding.

use serde::Serialize;
use utoipa::ToSchema;

/// A session: all its generations follow from it. Answers hold every field.
#[derive(ToSchema)]
#[schema(as = Session)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "records are read and written by crate::evolve; this describes them")]
pub(in crate::server) struct SessionSchema {
    /// The form of the record, 1.
    #[schema(minimum = 1, maximum = 1)]
    form: u32,
    /// Hashed into every draw.
    #[schema(minimum = 0, maximum = 9_007_199_254_740_991_i64)]
    seed: u64,
    /// Limits of every programme that is bred: `nodes`, `depth`, `cost_ns`; by default those of programmes.
    #[schema(value_type = Option<Object>)]
    budget: Option<serde_json::Value>,
    /// Programmes (text or tree) that the first generation begins with, at most 12; the others are grown.
    #[schema(max_items = 12)]
    programmes: Option<Vec<serde_json::Value>>,
    /// What was chosen, generation by generation: `{"parents": [3]}` or `{"parents": [0, 5], "again": 1}`.
    #[schema(max_items = 10000, value_type = Option<Vec<Object>>)]
    choices: Option<Vec<serde_json::Value>>,
    /// What was kept: `{"name", "generation", "individual", "programme"}`.
    #[schema(max_items = 1000, value_type = Option<Vec<Object>>)]
    kept: Option<Vec<serde_json::Value>>,
}

/// A session in a list.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct SessionEntry {
    pub name: String,
    pub revision: String,
    /// How many generations it has.
    pub generations: usize,
    /// URL of its document.
    pub document: String,
}

/// The sessions of a server.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct SessionList {
    pub sessions: Vec<SessionEntry>,
}

/// One of a generation.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct IndividualSchema {
    /// Programme text.
    pub programme: String,
    /// How it came to be: `"given"`, `"grown"`, `{"chosen": 3}`, `{"copied": 3}`, `{"mutated": {"parent": 3, "mutation": "replace"}}`, `{"crossed": {"parents": [0, 5]}}`, `{"refused": 3}`; numbers are those of the generation before.
    #[schema(value_type = Object)]
    pub origin: serde_json::Value,
    /// Least and greatest value over the square that pictures show: 4 programme units a side about the origin.
    #[schema(min_items = 2, max_items = 2)]
    pub values: [f32; 2],
    /// URL of its picture.
    pub picture: String,
}

/// A generation of a session.
#[derive(Serialize, ToSchema)]
#[schema(as = Generation)]
pub(in crate::server) struct GenerationSchema {
    /// 0 is the first.
    pub generation: usize,
    /// How many there are.
    pub generations: usize,
    /// The seed that a world needs to look as the pictures do.
    pub seed: u64,
    /// Twelve.
    #[schema(min_items = 12, max_items = 12)]
    pub individuals: Vec<IndividualSchema>,
}
