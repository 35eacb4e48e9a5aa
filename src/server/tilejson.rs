//! What describes tilesets on the wire.

use crate::tile::Steps;
use serde::Serialize;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// `TileJSON` 3.0 with the keys that `MapLibre` reads beside the standard's.
#[derive(Serialize, ToSchema)]
pub(super) struct TileJson {
    pub tilejson: &'static str,
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attribution: Option<String>,
    pub scheme: &'static str,
    /// One absolute URL template.
    #[schema(min_items = 1, max_items = 1)]
    pub tiles: [String; 1],
    pub minzoom: u8,
    pub maxzoom: u8,
    /// Longitude, latitude and zoom of a view with relief (`web`, `geo`); x, y and zoom in metres on `metric`.
    #[schema(min_items = 3, max_items = 3)]
    pub center: [f64; 3],
    /// Pixels a side; not there for vector tiles.
    #[serde(rename = "tileSize", skip_serializing_if = "Option::is_none")]
    pub tile_size: Option<u32>,
    /// The layers of vector tiles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vector_layers: Option<Vec<VectorLayerSchema>>,
    /// How elevation is packed; not there for pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<&'static str>,
    /// Of `fit`: what `MapLibre` needs of the encoding `custom`.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Factors)]
    pub factors: Option<Factors>,
    /// Of `fit`, `height16` and `r16`: metres of the least number and of the greatest.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub elevation: Option<[f64; 2]>,
    /// What the numbers of `materials` mean, the channels of `weights`, and the colours of `relief`; 0 is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub materials: Option<Vec<MaterialSchema>>,
    /// How many pages `weights` has; the tiles here are those of one page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pages: Option<usize>,
}

/// `MapLibre`'s encoding `custom`: metres are red · `redFactor` + green · `greenFactor` + blue · `blueFactor` - `baseShift`.
#[derive(Clone, Copy, Serialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub(super) struct Factors {
    #[schema(required = false)]
    pub red_factor: f64,
    #[schema(required = false)]
    pub green_factor: f64,
    #[schema(required = false)]
    pub blue_factor: f64,
    #[schema(required = false)]
    pub base_shift: f64,
}

impl Factors {
    /// Of numbers of 24 bits, red the greatest.
    pub(super) fn of(steps: &Steps) -> Self {
        let step = steps.metres();
        Self { red_factor: 65_536.0 * step, green_factor: 256.0 * step, blue_factor: step, base_shift: -steps.elevation(0) }
    }
}

/// A material of the ground.
#[derive(Serialize, ToSchema)]
#[schema(as = Material)]
pub(super) struct MaterialSchema {
    /// Its number in tiles, 1 … 255; 0 in `weights` is ground of no material.
    pub id: usize,
    pub name: String,
    /// `#rrggbb`.
    pub colour: String,
    /// The page of `weights` that has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub page: Option<usize>,
    /// The channel of that page: `r`, `g`, `b` or `a`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<&'static str>,
}

/// A layer of vector tiles.
#[derive(Serialize, ToSchema)]
pub(super) struct VectorLayerSchema {
    pub id: &'static str,
    pub description: &'static str,
    /// The properties of its features: what they are, by name.
    pub fields: BTreeMap<String, &'static str>,
}
