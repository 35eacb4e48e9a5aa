//! Evolutions.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How an evolution goes.
#[derive(Serialize, ToSchema)]
#[schema(as = Evolution)]
pub(in crate::server) struct EvolutionSchema {
    /// Generations bred from the first, as far as they are kept; without it none is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generation: Option<i64>,
    /// Generations that are bred, unless the goal is reached before.
    pub of: usize,
    /// The score that is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<f64>,
    /// Every generation from `from` on.
    #[schema(max_items = 10001)]
    pub curve: Vec<GenerationPoint>,
    /// The best programme of all generations so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub best: Option<BestSchema>,
}

/// A generation.
#[derive(Serialize, Deserialize, ToSchema)]
#[schema(as = GenerationPoint)]
pub(in crate::server) struct GenerationPoint {
    /// 0 is the first.
    pub generation: usize,
    /// The best score of its individuals, 0 … 1.
    pub best: f64,
    /// Their mean score.
    pub mean: f64,
    /// Programmes judged until then.
    pub evaluations: u64,
}

/// What an evolution found: `seed`, `programme`, `scale`, `amplitude` and `datum` are those of a world, or of a programme of the library, that shows it.
#[derive(Serialize, ToSchema)]
#[schema(as = Best)]
pub(in crate::server) struct BestSchema {
    /// The generation that it first was in.
    pub generation: usize,
    /// Programme text.
    pub programme: String,
    /// The weighted mean of what follows, 0 … 1.
    pub score: f64,
    /// How near it comes to everything that is wanted, in that order.
    pub criteria: Vec<CriterionSchema>,
    /// The seed of the world that it is for.
    pub seed: u64,
    /// Metres a programme unit.
    pub scale: f64,
    /// The amplitude that gives it the relief that is wanted, in metres.
    pub amplitude: f64,
    /// The datum that puts its least sample at 0 m.
    pub datum: f64,
    /// Metres a side of the square about the origin that it is judged over, and that its picture shows.
    pub side: f64,
    /// URL of its picture.
    pub picture: String,
}

/// How near a programme comes to something that is wanted.
#[derive(Serialize, ToSchema)]
#[schema(as = CriterionScore)]
pub(in crate::server) struct CriterionSchema {
    /// What is wanted: `accessibility`, `edges`, `slopes`, `elevations`, `roughness` or `likeness`.
    pub criterion: &'static str,
    /// How much it counts.
    pub weight: f64,
    /// 0, as far as can be, to 1, just that.
    pub score: f64,
}
