//! Surfaces as tiles and images: encodings, shading, files.

mod area;
mod clip;
mod contours;
mod hillshade;
mod lines;
mod materials;
mod mesh;
mod mvt;
mod options;
mod preview;
mod raster;
mod relief;
mod rgb;
mod slope;
mod steps;
mod tileset;
mod water;

pub use area::{Area, AreaError, AreaFormat, AreaRequest, AreaWriter, MAX_AREA_SIDE, MAX_AREA_VERTICES, Registration, write_area};
pub use contours::contour_interval;
pub use lines::render_features;
pub use materials::material_colour;
pub use mesh::{MAX_MESH_ZOOM, MESH_SIDES, mesh_step, mesh_tolerance};
pub use options::{ByteOrder, Image, MeshExtensions, Options, Rounding, RowOrder};
pub use preview::{PREVIEW_FORM, overlay, preview};
pub use relief::Ramp;
pub use steps::Steps;
pub use tileset::{EncodeError, Tileset, VectorLayer};

use crate::geometry::{Filter, Grid, GridError, Legend, Samples, Source, Surface, Tile, Wanted, Window};

/// Which height tiles of elevations hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Height {
    /// The ground, also under water.
    #[default]
    Ground,
    /// The surface of the water where there is some.
    Water,
}

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
    /// Which height is drawn; other tilesets than those of heights know only the ground.
    pub height: Height,
    /// What clients choose of its bytes.
    pub options: Options,
}

impl TileRequest {
    /// The samples that the tile is made from: its own, and those around it that its tileset needs.
    ///
    /// # Errors
    /// If the grid has no such tile.
    pub fn window(&self) -> Result<Window, GridError> {
        Ok(self.grid.window(self.tile, self.samples, self.filter)?.with_apron(self.tileset.apron()))
    }

    /// The samples that a mask of water is made from beside them; none if the tile has none.
    ///
    /// # Errors
    /// If the grid has no such tile.
    pub fn mask_window(&self) -> Result<Option<Window>, GridError> {
        let is_wanted = self.tileset == Tileset::QuantizedMesh && self.options.mesh.water_mask;
        is_wanted.then(|| mesh::mask_window(self)).transpose()
    }

    /// The predicted time to draw the tile once it is evaluated, in nanoseconds, where that matters beside the evaluation.
    #[must_use]
    pub fn drawing_ns(&self) -> f64 {
        /// A mesh that keeps most samples triangulates them about ten times.
        const MESH_SAMPLE_NS: f64 = 3_000.0;
        let side = self.samples.side();
        if self.tileset == Tileset::QuantizedMesh { (side * side) as f64 * MESH_SAMPLE_NS } else { 0.0 }
    }

    /// Tileset, extension, options and version of the encoder, with what of the legend enters the bytes: what they add to a tile's fingerprint.
    #[must_use]
    pub fn form(&self, legend: &Legend) -> String {
        let mut form = self.tileset.form().to_owned();
        if self.height == Height::Water {
            form += "\nwater's surface";
        }
        if let Tileset::Weights(page) = self.tileset {
            form.extend(["\npage ", &page.to_string()]);
        }
        if self.tileset.has_materials() {
            form.push_str("\nmaterials");
            legend.materials.iter().for_each(|name| form.extend([" ", &format!("{name:?}")]));
        }
        form + &self.options.form()
    }
}

/// Why a tile could not be made.
#[derive(Debug, thiserror::Error)]
pub enum TileError {
    /// There is no such tile.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// It was no longer wanted.
    #[error("it was stopped")]
    Stopped,
    /// It could not be encoded.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

/// Evaluates and encodes a tile on the calling thread.
///
/// Tilesets that need neighbours get true samples around the tile.
///
/// # Errors
/// If the grid has no such tile, encoding fails, or the source was stopped ([`crate::geometry::Until`]).
pub fn render(source: &impl Source, request: &TileRequest) -> Result<Vec<u8>, TileError> {
    if request.tileset == Tileset::QuantizedMesh {
        return mesh::draw(source, request);
    }
    let window = request.window()?;
    let wanted = request.tileset.wanted();
    let mut surface = Surface::with(&window, Wanted { water: wanted.water || request.height == Height::Water, ..wanted });
    source.sample(&window, &mut surface);
    if surface.stop.is_set() {
        return Err(TileError::Stopped);
    }
    if request.tileset == Tileset::Contours {
        if request.height == Height::Water {
            surface.raise_to_water();
        }
        return Ok(contours::draw(&surface, contour_interval(request.grid, request.tile.z)));
    }
    Ok(request.tileset.encode_height(surface, window.spacing(), &source.legend(), request.height, request.options)?)
}
