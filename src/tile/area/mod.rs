//! Files of areas, evaluated in parts and written in bands of rows: memory does not grow with the area.

mod cut;
mod format;
mod geotiff;
mod glb;
mod lattice;
mod obj;
mod png16;
mod raw;
#[cfg(test)]
mod tests;
mod writer;

pub use format::{AreaFormat, Registration};
pub use writer::{AreaWriter, write_area};

use super::Height;
use crate::geometry::{Filter, Source, Surface, Wanted, Window, WindowError};
use cut::Cut;

/// Most columns and most rows of an area: 2^17. A row of it is the least that is kept at a time.
pub const MAX_AREA_SIDE: usize = 1 << 17;

/// Most vertices of a mesh of an area, 2^22: 8 million triangles are what tools still open.
pub const MAX_AREA_VERTICES: u64 = 1 << 22;

/// Why there is no file of an area.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AreaError {
    /// There is no such window.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// More columns or rows than [`MAX_AREA_SIDE`].
    #[error("{columns} × {rows} samples are more than {MAX_AREA_SIDE} a side")]
    Side {
        /// Columns asked for.
        columns: usize,
        /// Rows asked for.
        rows: usize,
    },
    /// More vertices than [`MAX_AREA_VERTICES`].
    #[error("{0} vertices are more than the {MAX_AREA_VERTICES} of a mesh")]
    Vertices(usize),
    /// A mesh without triangles.
    #[error("a mesh has at least 2 × 2 vertices")]
    Thin,
}

/// What a file of an area is asked to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaRequest {
    /// Least x, least y, greatest x, greatest y in metres; the north-west corner is kept.
    pub bbox: [f64; 4],
    /// Metres between neighbouring samples.
    pub spacing: f64,
    /// Which detail they carry.
    pub filter: Filter,
    /// Where they stand.
    pub registration: Registration,
    /// Which height they have.
    pub height: Height,
    /// How they are written.
    pub format: AreaFormat,
}

/// A file of an area: its samples and how they are written.
///
/// ```
/// use terrane::{geometry::Filter, tile::{AreaFormat, AreaRequest, Height, Registration, write_area}, world::{Document, World}};
/// let document = Document::parse(br#"{"seed": 7, "base": {"programme": "fbm(1, 2, 8)", "scale": 20000}}"#)?;
/// let (bbox, registration) = ([0.0, 0.0, 25600.0, 12800.0], Registration::Centres);
/// let request = AreaRequest { bbox, spacing: 100.0, filter: Filter::Band, registration, height: Height::Ground, format: AreaFormat::R32 };
/// let mut file = Vec::new();
/// write_area(&World::new(document), &request.area(1 << 20)?, &mut file)?;
/// assert_eq!(file.len(), 256 * 128 * 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    window: Window,
    registration: Registration,
    height: Height,
    format: AreaFormat,
    cut: Cut,
}

impl AreaRequest {
    /// The file, of at most `limit` samples.
    ///
    /// # Errors
    /// If there is no such window, or it has more samples than the format, the limit or [`MAX_AREA_SIDE`] allows.
    pub fn area(&self, limit: u64) -> Result<Area, AreaError> {
        let Self { bbox, spacing, filter, registration, height, format } = *self;
        let window = match registration {
            Registration::Centres => Window::area(bbox, spacing, filter, limit),
            Registration::Vertices => Window::vertices(bbox, spacing, filter, limit),
        }?;
        let (columns, rows) = (window.columns.len(), window.rows.len());
        if columns.max(rows) > MAX_AREA_SIDE {
            return Err(AreaError::Side { columns, rows });
        }
        if format.is_mesh() && window.samples() as u64 > MAX_AREA_VERTICES {
            return Err(AreaError::Vertices(window.samples()));
        }
        if format.is_mesh() && columns.min(rows) < 2 {
            return Err(AreaError::Thin);
        }
        let cut = Cut::of(window.with_apron(format.apron()));
        Ok(Area { window, registration, height, format, cut })
    }
}

impl Area {
    /// The samples of the file.
    #[must_use]
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The samples that are evaluated: those of the file, and those around it that the format needs.
    #[must_use]
    pub fn evaluated(&self) -> &Window {
        &self.cut.window
    }

    /// How it is written.
    #[must_use]
    pub fn format(&self) -> AreaFormat {
        self.format
    }

    /// The plane metres that the file covers: least x, least y, greatest x, greatest y. Pixels cover half a spacing around their centres, meshes end at their vertices.
    #[must_use]
    pub fn covered(&self) -> [f64; 4] {
        let (bounds, half) = (self.window.bounds(), if self.registration == Registration::Centres { self.window.spacing() / 2.0 } else { 0.0 });
        [bounds.min[0] - half, bounds.min[1] - half, bounds.max[0] + half, bounds.max[1] + half]
    }

    /// Everything but the world that decides about the file's bytes: format, version of the encoder, place, spacing, filter.
    #[must_use]
    pub fn form(&self) -> String {
        let (window, bounds) = (&self.window, self.window.bounds());
        // -0 and 0 are one number.
        let numbers = [window.spacing(), bounds.min[0], bounds.max[1]].map(|number| format!("{:016x}", (number + 0.0).to_bits())).join(" ");
        let (registration, surface) = (self.registration.name(), if self.height == Height::Water { "water's surface" } else { "ground" });
        format!("area {}\n{registration} {} {}\n{numbers}\n{}\n{surface}", self.format.form(), window.columns.len(), window.rows.len(), window.filter.name())
    }

    /// How many parts it is evaluated in.
    #[must_use]
    pub fn parts(&self) -> usize {
        self.cut.parts()
    }

    /// How many parts lie beside each other, which is how many make a band of rows.
    #[must_use]
    pub fn parts_a_band(&self) -> usize {
        self.cut.parts_a_band()
    }

    /// Most samples of a part.
    #[must_use]
    pub fn part_samples(&self) -> usize {
        self.cut.part_samples()
    }

    /// The heights of a part, row by row, on the calling thread. Parts count from west to east, then from north to south.
    ///
    /// # Panics
    /// If there are not so many parts.
    #[must_use]
    pub fn evaluate(&self, source: &impl Source, part: usize) -> Vec<f32> {
        let window = self.cut.part(part);
        let mut surface = Surface::with(&window, Wanted { water: self.height == Height::Water, ..Wanted::default() });
        source.sample(&window, &mut surface);
        surface.raise_to_water();
        surface.elevation
    }
}
