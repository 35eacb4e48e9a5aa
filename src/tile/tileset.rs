//! The ways a surface is drawn as a tile.

use super::{contours, hillshade, png, rgb};
use crate::geometry::Surface;

/// A way to draw a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tileset {
    /// Elevation in 1/256 m as RGB, PNG: R·256 + G + B/256 - 32768.
    Terrarium,
    /// Elevation in 1/10 m as RGB, PNG: -10000 + (R·65536 + G·256 + B)/10.
    TerrainRgb,
    /// Elevation in metres as little-endian f32, row by row from the north.
    R32,
    /// Shaded relief as grey PNG, light from the north-west.
    Hillshade,
    /// Contour lines as a vector tile.
    Contours,
}

/// A layer of vector tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VectorLayer {
    /// Its name.
    pub id: &'static str,
    /// What it shows.
    pub description: &'static str,
    /// The properties of its features: name, and kind or meaning.
    pub fields: &'static [(&'static str, &'static str)],
}

/// Contours as a vector tile names them.
const CONTOURS: [VectorLayer; 1] = [VectorLayer {
    id: "contours",
    description: "Lines of equal elevation of the ground",
    fields: &[("elevation", "Number: metres"), ("index", "Boolean: every fifth line")],
}];

/// Why a surface could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The image encoder refused.
    #[error("encoding the image: {0}")]
    Image(#[from] image::ImageError),
    /// The TIFF encoder refused.
    #[error("encoding the TIFF: {0}")]
    Tiff(#[from] tiff::TiffError),
}

impl Tileset {
    /// Every tileset.
    pub const ALL: [Tileset; 5] = [Tileset::Terrarium, Tileset::TerrainRgb, Tileset::R32, Tileset::Hillshade, Tileset::Contours];

    /// The name in URLs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Tileset::Terrarium => "terrarium",
            Tileset::TerrainRgb => "terrain-rgb",
            Tileset::R32 => "r32",
            Tileset::Hillshade => "hillshade",
            Tileset::Contours => "contours",
        }
    }

    /// The tileset of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tileset| tileset.name() == name)
    }

    /// The extension of its files.
    #[must_use]
    pub fn extension(self) -> &'static str {
        match self {
            Tileset::R32 => "bin",
            Tileset::Contours => "mvt",
            _ => "png",
        }
    }

    /// Its media type.
    #[must_use]
    pub fn media_type(self) -> &'static str {
        match self {
            Tileset::R32 => "application/octet-stream",
            Tileset::Contours => "application/vnd.mapbox-vector-tile",
            _ => "image/png",
        }
    }

    /// What `MapLibre` calls its encoding of elevation; `None` if it is a picture.
    #[must_use]
    pub fn encoding(self) -> Option<&'static str> {
        match self {
            Tileset::Terrarium => Some("terrarium"),
            Tileset::TerrainRgb => Some("mapbox"),
            Tileset::R32 => Some("f32"),
            Tileset::Hillshade | Tileset::Contours => None,
        }
    }

    /// Tileset, extension and version of the encoder: what it adds to a tile's fingerprint.
    #[must_use]
    pub fn form(self) -> &'static str {
        match self {
            Tileset::Terrarium => "terrarium.png 1",
            Tileset::TerrainRgb => "terrain-rgb.png 1",
            Tileset::R32 => "r32.bin 1",
            Tileset::Hillshade => "hillshade.png 1",
            Tileset::Contours => "contours.mvt 1",
        }
    }

    /// The layers of its vector tiles; none if they are no vector tiles.
    #[must_use]
    pub fn layers(self) -> &'static [VectorLayer] {
        match self {
            Tileset::Contours => &CONTOURS,
            _ => &[],
        }
    }

    /// Samples needed beyond each side of what is drawn.
    #[must_use]
    pub fn apron(self) -> usize {
        match self {
            Tileset::Hillshade => 1,
            Tileset::Contours => contours::APRON,
            _ => 0,
        }
    }

    /// Encodes a surface that has this tileset's apron around it; `spacing` in metres.
    ///
    /// # Errors
    /// If the image encoder fails, as it does for a surface without samples.
    pub fn encode(self, surface: &Surface, spacing: f64) -> Result<Vec<u8>, EncodeError> {
        match self {
            Tileset::Terrarium => png::rgb(surface, rgb::terrarium),
            Tileset::TerrainRgb => png::rgb(surface, rgb::terrain_rgb),
            Tileset::R32 => Ok(surface.elevation.iter().flat_map(|elevation| elevation.to_le_bytes()).collect()),
            Tileset::Hillshade => png::grey(surface.columns - 2, surface.rows - 2, &hillshade::shade(surface, spacing)),
            Tileset::Contours => Ok(contours::draw(surface, contours::interval(spacing))),
        }
    }
}
