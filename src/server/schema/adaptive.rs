//! Ground that evolves: feedback, generations, players.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What somebody says of the ground by being there, 1 to 100 points and heights together: more of this.
#[derive(Deserialize, ToSchema)]
#[schema(as = Feedback)]
#[serde(deny_unknown_fields)]
pub(in crate::server) struct FeedbackSchema {
    /// The name of the layer; needed if several are adaptive.
    pub layer: Option<String>,
    /// Plane metres of points of the ground, whose heights are meant.
    #[schema(max_items = 100)]
    #[serde(default)]
    pub points: Vec<[f64; 2]>,
    /// Heights in metres.
    #[schema(max_items = 100)]
    #[serde(default)]
    pub heights: Vec<f64>,
    /// Metres around the points in which the ground changes; everywhere without it.
    #[schema(exclusive_minimum = 0)]
    pub radius: Option<f64>,
    /// Whether the places of all players on the ground count as points, too.
    #[schema(default = false)]
    #[serde(default)]
    pub players: bool,
}

/// A generation by name and number.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct GenerationName {
    /// The name of all that it follows from.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub hash: String,
    /// How many came before it.
    pub number: usize,
}

/// The ground is another generation.
#[derive(Serialize, ToSchema)]
#[schema(as = Fed)]
pub(in crate::server) struct FedSchema {
    pub layer: String,
    #[schema(inline)]
    pub generation: GenerationName,
    /// The world's revision that shows it.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub revision: String,
    /// Least x, least y, greatest x, greatest y of what changed, in metres; `null` if nothing did.
    #[schema(min_items = 4, max_items = 4)]
    pub changed: Option<[f64; 4]>,
    /// The root mean square of what its heights are off the mean of those asked for, in metres; `null` where nothing was.
    pub deviation: Option<f64>,
}

/// Which generation a layer is to show.
#[derive(Deserialize, ToSchema)]
#[schema(as = Return)]
#[serde(deny_unknown_fields)]
pub(in crate::server) struct ReturnSchema {
    /// The name of the layer; needed if several are adaptive.
    pub layer: Option<String>,
    /// The hash of a generation of the same ground, or the number of one on the way to that which is shown.
    pub generation: HashOrNumber,
}

#[derive(Deserialize, ToSchema)]
#[serde(untagged)]
pub(in crate::server) enum HashOrNumber {
    Number(usize),
    Hash(String),
}

/// A generation on the way to the one that is shown.
#[derive(Serialize, ToSchema)]
pub(in crate::server) struct GrownGeneration {
    /// How many came before it.
    pub number: usize,
    /// The name of all that it follows from.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub hash: String,
    /// When it was bred, RFC 3339, UTC; not of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// What it was bred by, without the ways of players; not of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub feedback: Option<serde_json::Value>,
    /// The root mean square of what its heights are off the mean of those asked for, in metres; not of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
}

/// The generations of a layer.
#[derive(Serialize, ToSchema)]
#[schema(as = Generations)]
pub(in crate::server) struct GenerationsSchema {
    pub layer: String,
    /// The hash of the one that is shown.
    #[schema(pattern = "^[0-9a-f]{32}$")]
    pub current: String,
    /// From the first to the one that is shown.
    pub generations: Vec<GrownGeneration>,
    /// Ground and feedback, all that they follow from, if it is asked for: see docs/evolving.md.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Object>)]
    pub history: Option<crate::evolve::History>,
}

/// The way of a player since it was last told.
#[derive(Deserialize, ToSchema)]
#[schema(as = Way)]
#[serde(deny_unknown_fields)]
pub(in crate::server) struct WaySchema {
    /// Plane metres, the last where it is now.
    #[schema(min_items = 1, max_items = 1024)]
    pub positions: Vec<[f64; 2]>,
}

/// What a player is promised.
#[derive(Serialize, ToSchema)]
#[schema(as = Promise)]
pub(in crate::server) struct PromiseSchema {
    /// Metres around its way in which nothing changes, the least of all adaptive layers; `null` in a world without such.
    pub promise: Option<f64>,
}

/// A player of a world.
#[derive(Serialize, ToSchema)]
#[schema(as = Player)]
pub(in crate::server) struct PlayerSchema {
    pub name: String,
    /// Plane metres.
    pub position: [f64; 2],
    /// How many seconds ago it was heard of.
    pub seen: f64,
}

/// The players of a world, by name.
#[derive(Serialize, ToSchema)]
#[schema(as = Players)]
pub(in crate::server) struct PlayersSchema {
    pub players: Vec<PlayerSchema>,
}
