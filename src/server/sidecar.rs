//! What a tile's samples mean, for those who read them without knowing the world.

use crate::{
    geometry::{GridError, Samples},
    tile::{ByteOrder, Image, TileRequest, Tileset},
};
use serde::Serialize;
use utoipa::ToSchema;

/// What the samples of a tile of `height16`, `r16` or `r32` are: `elevation = minimum + sample · step` of whole numbers, `elevation = sample` of floats.
#[derive(Serialize, ToSchema)]
#[schema(as = Sidecar)]
pub(super) struct SidecarSchema {
    /// The file of samples that lies beside this one.
    pub file: String,
    /// `uint16` or `float32`.
    #[serde(rename = "type")]
    #[schema(rename = "type")]
    pub kind: &'static str,
    /// `little` or `big`.
    pub byte_order: &'static str,
    /// Samples a row, and rows.
    pub columns: usize,
    pub rows: usize,
    /// Which row comes first, `north` or `south`; columns run from west to east.
    pub first_row: &'static str,
    /// `vertices`: the outermost samples stand on the tile's edges, where neighbours have the same; `centres`: in the middle of pixels.
    pub registration: &'static str,
    /// Metres of the plane between neighbouring samples.
    pub spacing: f64,
    /// Plane metres of the first and last columns and rows of samples: least x, least y, greatest x, greatest y.
    pub samples: [f64; 4],
    /// Metres: the least elevation there can be, that of number 0.
    pub minimum: f64,
    /// Metres: the greatest elevation there can be, that of number 65535.
    pub maximum: f64,
    /// Metres from a number to the next; not there for floats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
}

/// The sidecar of a tile of a world with a vertical range in metres, whose file has a name without its extension.
///
/// # Errors
/// If the grid has no such tile.
pub(super) fn sidecar(request: &TileRequest, range: [f64; 2], stem: &str) -> Result<SidecarSchema, GridError> {
    let TileRequest { tileset, samples, options, .. } = *request;
    let window = request.window()?;
    let bounds = window.bounds();
    Ok(SidecarSchema {
        file: format!("{stem}.{}", tileset.extension(Image::Png)),
        kind: if tileset == Tileset::R32 { "float32" } else { "uint16" },
        // As PNG has it.
        byte_order: if tileset.is_picture() { ByteOrder::Big } else { options.order }.name(),
        columns: samples.side(),
        rows: samples.side(),
        first_row: options.rows.name(),
        registration: if matches!(samples, Samples::Vertices(_)) { "vertices" } else { "centres" },
        spacing: window.spacing(),
        samples: [bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]],
        minimum: range[0],
        maximum: range[1],
        step: tileset.steps(range).map(|steps| steps.metres()),
    })
}
