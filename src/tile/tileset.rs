//! The ways a surface is drawn as a tile.

use super::{
    ByteOrder, Height, Image, Options, Ramp, Rounding, RowOrder, Steps, contours, hillshade,
    lines::LAYERS,
    materials,
    raster::{Pixels, Raster},
    relief, rgb, slope, steps, water,
};
use crate::geometry::{Grid, Legend, Surface, Wanted};

/// A way to draw a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tileset {
    /// Elevation in 1/256 m as RGB, PNG: R·256 + G + B/256 - 32768.
    Terrarium,
    /// Elevation in 1/10 m as RGB, PNG: -10000 + (R·65536 + G·256 + B)/10.
    TerrainRgb,
    /// Elevation in 2^24 - 1 steps over the world's vertical range as RGB, PNG: `MapLibre`'s `custom` encoding.
    Fit,
    /// Elevation in 65,535 steps over the world's vertical range as grey of 16 bits, PNG.
    Height16,
    /// Elevation in 65,535 steps over the world's vertical range as raw u16, row by row.
    R16,
    /// Elevation in metres as raw f32, row by row.
    R32,
    /// Shaded relief as grey PNG, light from the north-west.
    Hillshade,
    /// How steep the ground is as grey PNG, in half degrees.
    Slope,
    /// Which way the ground faces as RGB PNG: east, north and up, -1 … 1 as 0 … 255.
    Normals,
    /// The share of each sample that lies under water as grey PNG: 0 dry, 255 all of it.
    Water,
    /// Numbers of materials as grey PNG: 0 none, n the one at n - 1 of the legend.
    Materials,
    /// How much of each sample's ground is of each material, four materials a page, as RGBA PNG: over all pages 255 in every pixel.
    Weights(u8),
    /// Land and sea in the colours of their height, water and materials, shaded, as RGB PNG.
    Relief,
    /// Contour lines as a vector tile.
    Contours,
    /// Features of layers as a vector tile.
    Features,
    /// Triangles on the globe, on [`Grid::Geo`] and [`Grid::Web`]: quantized-mesh-1.0.
    QuantizedMesh,
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

/// What every feature may have, beside its own properties.
const FIELDS: &[(&str, &str)] = &[
    ("id", "String: its id"),
    ("layer", "String: the world's layer it belongs to"),
    ("attributes", "String: the name of its set of attributes"),
    ("elevation", "Number: metres, the greatest of its vertices"),
    ("water", "Boolean: a river, a lake or other water"),
];

/// Features as a vector tile names them.
const FEATURES: [VectorLayer; 3] = [
    VectorLayer { id: LAYERS[0], description: "Features that are points", fields: FIELDS },
    VectorLayer { id: LAYERS[1], description: "Features that are lines, with their detail", fields: FIELDS },
    VectorLayer { id: LAYERS[2], description: "Features that are polygons or circles, with their detail", fields: FIELDS },
];

/// Why a surface could not be encoded.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The image encoder refused.
    #[error("encoding the image: {0}")]
    Image(#[from] image::ImageError),
    /// The `WebP` encoder refused.
    #[error("encoding the WebP: {0}")]
    Webp(#[from] image_webp::EncodingError),
    /// The PNG encoder refused.
    #[error("encoding the PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// Text could not be written.
    #[error("writing text: {0}")]
    Text(#[source] std::io::Error),
}

impl Tileset {
    /// Every tileset.
    pub const ALL: [Tileset; 16] = [
        Tileset::Terrarium,
        Tileset::TerrainRgb,
        Tileset::Fit,
        Tileset::Height16,
        Tileset::R16,
        Tileset::R32,
        Tileset::Hillshade,
        Tileset::Slope,
        Tileset::Normals,
        Tileset::Water,
        Tileset::Materials,
        Tileset::Weights(0),
        Tileset::Relief,
        Tileset::Contours,
        Tileset::Features,
        Tileset::QuantizedMesh,
    ];

    /// The name in URLs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Tileset::Terrarium => "terrarium",
            Tileset::TerrainRgb => "terrain-rgb",
            Tileset::Fit => "fit",
            Tileset::Height16 => "height16",
            Tileset::R16 => "r16",
            Tileset::R32 => "r32",
            Tileset::Hillshade => "hillshade",
            Tileset::Slope => "slope",
            Tileset::Normals => "normals",
            Tileset::Water => "water",
            Tileset::Materials => "materials",
            Tileset::Weights(_) => "weights",
            Tileset::Relief => "relief",
            Tileset::Contours => "contours",
            Tileset::Features => "features",
            Tileset::QuantizedMesh => "quantized-mesh",
        }
    }

    /// The tileset of a name; of pages the first.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tileset| tileset.name() == name)
    }

    /// The extension of its files; of pictures that of their packing.
    #[must_use]
    pub fn extension(self, image: Image) -> &'static str {
        match self {
            Tileset::R16 | Tileset::R32 => "bin",
            Tileset::Contours | Tileset::Features => "mvt",
            Tileset::QuantizedMesh => "terrain",
            _ if image == Image::Webp && self.has_webp() => "webp",
            _ => "png",
        }
    }

    /// Its media type; of pictures that of their packing.
    #[must_use]
    pub fn media_type(self, image: Image) -> &'static str {
        match self.extension(image) {
            "bin" => "application/octet-stream",
            "mvt" => "application/vnd.mapbox-vector-tile",
            "webp" => "image/webp",
            "terrain" => "application/vnd.quantized-mesh",
            _ => "image/png",
        }
    }

    /// Whether its tiles are pictures.
    #[must_use]
    pub fn is_picture(self) -> bool {
        !matches!(self, Tileset::R16 | Tileset::R32 | Tileset::Contours | Tileset::Features | Tileset::QuantizedMesh)
    }

    /// Whether its tiles are pictures that there are as `WebP` too.
    #[must_use]
    pub fn has_webp(self) -> bool {
        self.is_picture() && self != Tileset::Height16
    }

    /// Whether a grid has it: meshes lie on the globe, which `metric` knows nothing of.
    #[must_use]
    pub fn is_on(self, grid: Grid) -> bool {
        self != Tileset::QuantizedMesh || grid != Grid::Metric
    }

    /// Whether its tiles are samples without a header.
    #[must_use]
    pub fn is_raw(self) -> bool {
        matches!(self, Tileset::R16 | Tileset::R32)
    }

    /// Whether its tiles say too little of themselves, so that a sidecar says it.
    #[must_use]
    pub fn has_sidecar(self) -> bool {
        self.is_raw() || self == Tileset::Height16
    }

    /// Whether its heights are numbers of 24 bits, which can be rounded to what the spacing justifies.
    #[must_use]
    pub fn has_rounding(self) -> bool {
        matches!(self, Tileset::Terrarium | Tileset::TerrainRgb | Tileset::Fit)
    }

    /// The steps that its numbers count over a vertical range in metres; `None` if they count none.
    #[must_use]
    pub fn steps(self, range: [f64; 2]) -> Option<Steps> {
        match self {
            Tileset::Fit => Some(Steps::of_24_bits(range)),
            Tileset::Height16 | Tileset::R16 => Some(Steps::of_16_bits(range)),
            _ => None,
        }
    }

    /// What `MapLibre` calls its encoding of elevation, or that of its samples; `None` if it is a picture.
    #[must_use]
    pub fn encoding(self) -> Option<&'static str> {
        match self {
            Tileset::Terrarium => Some("terrarium"),
            Tileset::TerrainRgb => Some("mapbox"),
            Tileset::Fit => Some("custom"),
            Tileset::Height16 | Tileset::R16 => Some("u16"),
            Tileset::R32 => Some("f32"),
            _ => None,
        }
    }

    /// Tileset, extension and version of the encoder: what it adds to a tile's fingerprint.
    #[must_use]
    pub fn form(self) -> &'static str {
        match self {
            Tileset::Terrarium => "terrarium.png 1",
            Tileset::TerrainRgb => "terrain-rgb.png 1",
            Tileset::Fit => "fit.png 1",
            Tileset::Height16 => "height16.png 1",
            Tileset::R16 => "r16.bin 1",
            Tileset::R32 => "r32.bin 1",
            Tileset::Hillshade => "hillshade.png 1",
            Tileset::Slope => "slope.png 1",
            Tileset::Normals => "normals.png 1",
            Tileset::Water => "water.png 1",
            Tileset::Materials => "materials.png 1",
            Tileset::Weights(_) => "weights.png 1",
            Tileset::Relief => "relief.png 1",
            Tileset::Contours => "contours.mvt 1",
            Tileset::Features => "features.mvt 1",
            Tileset::QuantizedMesh => "quantized-mesh.terrain 1",
        }
    }

    /// The layers of its vector tiles; none if they are no vector tiles.
    #[must_use]
    pub fn layers(self) -> &'static [VectorLayer] {
        match self {
            Tileset::Contours => &CONTOURS,
            Tileset::Features => &FEATURES,
            _ => &[],
        }
    }

    /// Samples needed beyond each side of what is drawn.
    #[must_use]
    pub fn apron(self) -> usize {
        match self {
            Tileset::Hillshade | Tileset::Slope | Tileset::Normals | Tileset::Water | Tileset::Relief | Tileset::QuantizedMesh => 1,
            Tileset::Contours | Tileset::Features => contours::APRON,
            _ => 0,
        }
    }

    /// What it needs of a surface beside elevations.
    #[must_use]
    pub fn wanted(self) -> Wanted {
        let weights = if let Tileset::Weights(page) = self { Some(page) } else { None };
        Wanted { water: matches!(self, Tileset::Water | Tileset::Relief), materials: matches!(self, Tileset::Materials | Tileset::Relief), weights }
    }

    /// Whether the numbers and names of materials enter its bytes.
    #[must_use]
    pub fn has_materials(self) -> bool {
        matches!(self, Tileset::Materials | Tileset::Weights(_) | Tileset::Relief)
    }

    /// Whether it draws heights, of the ground or of the water's surface.
    #[must_use]
    pub fn has_height(self) -> bool {
        let is_shape = matches!(self, Tileset::Hillshade | Tileset::Slope | Tileset::Normals | Tileset::QuantizedMesh);
        is_shape || matches!(self, Tileset::Terrarium | Tileset::TerrainRgb | Tileset::Fit) || self.has_sidecar()
    }

    /// Encodes a surface that has this tileset's apron around it and what it [wants](Tileset::wanted); `spacing` in metres.
    ///
    /// # Errors
    /// If the image encoder fails, as it does for a surface without samples.
    pub fn encode(self, surface: &Surface, spacing: f64, legend: &Legend, options: Options) -> Result<Vec<u8>, EncodeError> {
        match self {
            Tileset::R16 | Tileset::R32 => Ok(raw(surface, self.steps(legend.range), options)),
            Tileset::Contours => Ok(contours::draw(surface, contours::interval(spacing))),
            // A surface has no features, and knows no place on the globe.
            Tileset::Features | Tileset::QuantizedMesh => Ok(Vec::new()),
            _ => self.picture(surface, spacing, legend, options).encode(options.image),
        }
    }

    /// Draws a surface as pixels.
    fn picture(self, surface: &Surface, spacing: f64, legend: &Legend, options: Options) -> Raster {
        let whole = |pixels, bytes| Raster { size: [surface.columns, surface.rows], pixels, bytes };
        let inner = |pixels, bytes| Raster { size: [surface.columns.saturating_sub(2), surface.rows.saturating_sub(2)], pixels, bytes };
        let needless = |step| if options.rounding == Rounding::Spacing { rgb::needless_bits(step, spacing) } else { 0 };
        match self {
            Tileset::Terrarium => {
                let bits = needless(rgb::TERRARIUM_STEP);
                Raster::rgb(surface, |elevation| rgb::terrarium(elevation, bits))
            }
            Tileset::TerrainRgb => {
                let bits = needless(rgb::TERRAIN_RGB_STEP);
                Raster::rgb(surface, |elevation| rgb::terrain_rgb(elevation, bits))
            }
            Tileset::Fit => {
                let steps = Steps::of_24_bits(legend.range);
                let bits = needless(steps.metres());
                Raster::rgb(surface, |elevation| steps::fit(&steps, elevation, bits))
            }
            Tileset::Height16 => {
                let steps = Steps::of_16_bits(legend.range);
                whole(Pixels::Grey16, rows_of(surface, options.rows).flat_map(|elevation| (steps.number(elevation) as u16).to_ne_bytes()).collect())
            }
            Tileset::Slope => inner(Pixels::Grey, slope::half_degrees(surface, spacing)),
            Tileset::Normals => inner(Pixels::Rgb, slope::normals(surface, spacing)),
            Tileset::Water => inner(Pixels::Grey, water::greys(surface, spacing, legend.sea_level as f32)),
            Tileset::Materials => whole(Pixels::Grey, materials::numbers(surface)),
            Tileset::Weights(_) => whole(Pixels::Channels, surface.weights.as_flattened().to_vec()),
            Tileset::Relief => inner(Pixels::Rgb, relief::draw_with(surface, spacing, &Ramp::of(legend), legend)),
            _ => inner(Pixels::Grey, hillshade::shade(surface, spacing)),
        }
    }

    /// Encodes a surface whose depth of water is known as if the water's surface were the ground, if that is the height asked for.
    ///
    /// # Errors
    /// As [`Tileset::encode`].
    pub fn encode_height(self, mut surface: Surface, spacing: f64, legend: &Legend, height: Height, options: Options) -> Result<Vec<u8>, EncodeError> {
        if height == Height::Water {
            surface.raise_to_water();
        }
        self.encode(&surface, spacing, legend, options)
    }
}

/// The elevations of a surface, the rows in an order.
fn rows_of(surface: &Surface, order: RowOrder) -> impl Iterator<Item = f32> + '_ {
    let row = move |row| match order {
        RowOrder::North => row,
        RowOrder::South => surface.rows - 1 - row,
    };
    (0..surface.rows).flat_map(move |i| surface.row(row(i))).copied()
}

/// Samples without a header: numbers of steps as u16, or metres as f32.
fn raw(surface: &Surface, steps: Option<Steps>, options: Options) -> Vec<u8> {
    let samples = rows_of(surface, options.rows);
    match (steps, options.order) {
        (Some(steps), ByteOrder::Little) => samples.flat_map(|elevation| (steps.number(elevation) as u16).to_le_bytes()).collect(),
        (Some(steps), ByteOrder::Big) => samples.flat_map(|elevation| (steps.number(elevation) as u16).to_be_bytes()).collect(),
        (None, ByteOrder::Little) => samples.flat_map(f32::to_le_bytes).collect(),
        (None, ByteOrder::Big) => samples.flat_map(f32::to_be_bytes).collect(),
    }
}
