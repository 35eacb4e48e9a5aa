//! Surfaces as tiles and images: encodings, shading, files.

mod contours;
mod geotiff;
mod hillshade;
mod mvt;
mod png;
mod preview;
mod relief;
mod rgb;
mod tileset;

pub use contours::contour_interval;
pub use geotiff::write_geotiff;
pub use preview::{PREVIEW_FORM, preview};
pub use relief::Ramp;
pub use tileset::{EncodeError, Tileset, VectorLayer};

use crate::geometry::{Filter, Grid, GridError, Samples, Source, Surface, Tile, Window};

/// What a request for a tile asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TileRequest {
    /// How the plane is cut.
    pub grid: Grid,
    /// Which tile.
    pub tile: Tile,
    /// Where its samples stand.
    pub samples: Samples,
    /// Which detail they carry.
    pub filter: Filter,
    /// How they are drawn.
    pub tileset: Tileset,
}

impl TileRequest {
    /// The samples that the tile is made from: its own, and those around it that its tileset needs.
    ///
    /// # Errors
    /// If the grid has no such tile.
    pub fn window(&self) -> Result<Window, GridError> {
        Ok(self.grid.window(self.tile, self.samples, self.filter)?.with_apron(self.tileset.apron()))
    }
}

/// Why a tile could not be made.
#[derive(Debug, thiserror::Error)]
pub enum TileError {
    /// There is no such tile.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// It could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// Evaluates and encodes a tile on the calling thread.
///
/// Tilesets that need neighbours get true samples around the tile.
///
/// # Errors
/// If the grid has no such tile, or encoding fails.
pub fn render(source: &impl Source, request: &TileRequest) -> Result<Vec<u8>, TileError> {
    let window = request.window()?;
    let mut surface = Surface::of(&window);
    source.sample(&window, &mut surface);
    if request.tileset == Tileset::Contours {
        return Ok(contours::draw(&surface, contour_interval(request.grid, request.tile.z)));
    }
    Ok(request.tileset.encode(&surface, window.spacing())?)
}
