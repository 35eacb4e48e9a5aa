//! `terrane render`.

use super::{Detail, Drawn, parse_bbox, world};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};
use terrane::{
    geometry::{Source, Wanted, Window},
    tile::{Area, AreaFormat, AreaRequest, Height, Options, Registration, Tileset, write_area},
    world::World,
};

/// Most samples of a rendered window: 2^28.
const RENDER_SAMPLES: u64 = 1 << 28;

#[derive(Args)]
pub(crate) struct RenderArguments {
    /// A world document, or the name of a stored world
    world: String,
    /// The area in metres: minx,miny,maxx,maxy
    #[arg(long, value_parser = parse_bbox, allow_hyphen_values = true)]
    bbox: [f64; 4],
    /// Metres between samples
    #[arg(long)]
    spacing: f64,
    /// The file to write: .png, .tif, .r16, .r32, .obj or .glb
    #[arg(short, long)]
    output: PathBuf,
    /// How a .png is drawn
    #[arg(long, value_enum, default_value_t = Picture::Hillshade)]
    tileset: Picture,
    /// Which height is drawn
    #[arg(long, value_enum, default_value_t = Drawn::Ground)]
    surface: Drawn,
    /// Where samples stand; vertices is for all but pictures, and the default of meshes
    #[arg(long, value_enum)]
    registration: Option<Stand>,
    /// Which detail samples carry
    #[arg(long, value_enum, default_value_t = Detail::Band)]
    filter: Detail,
    /// Folder of stored worlds [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Picture {
    Hillshade,
    Terrarium,
    TerrainRgb,
    Water,
    Materials,
    Relief,
    /// Grey of 16 bits over the world's vertical range
    Height16,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Stand {
    Centres,
    Vertices,
}

/// What a file is: a picture, or heights as the server exports them.
#[derive(Clone, Copy)]
enum Kind {
    Picture(Tileset),
    Heights(AreaFormat),
}

impl RenderArguments {
    fn kind(&self) -> anyhow::Result<Kind> {
        let extension = self.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        let heights = AreaFormat::ALL.into_iter().find(|format| format.extension() == extension.replace("tiff", "tif"));
        match (heights, self.tileset) {
            (Some(AreaFormat::Png16), Picture::Height16) => Ok(Kind::Heights(AreaFormat::Png16)),
            (Some(AreaFormat::Png16), picture) => Ok(Kind::Picture(picture.tileset())),
            (Some(format), Picture::Hillshade) => Ok(Kind::Heights(format)),
            (Some(_), _) => bail!("--tileset is for .png files: .{extension} holds the elevations themselves"),
            (None, _) => bail!("{} must end in .png, .tif, .r16, .r32, .obj or .glb", self.output.display()),
        }
    }

    fn request(&self, format: AreaFormat) -> AreaRequest {
        let registration = match self.registration {
            Some(Stand::Centres) => Registration::Centres,
            Some(Stand::Vertices) => Registration::Vertices,
            None => format.registration(),
        };
        AreaRequest { bbox: self.bbox, spacing: self.spacing, filter: self.filter.filter(), registration, height: self.surface.height(), format }
    }
}

impl Picture {
    fn tileset(self) -> Tileset {
        match self {
            Picture::Hillshade => Tileset::Hillshade,
            Picture::Terrarium => Tileset::Terrarium,
            Picture::TerrainRgb => Tileset::TerrainRgb,
            Picture::Water => Tileset::Water,
            Picture::Materials => Tileset::Materials,
            Picture::Relief => Tileset::Relief,
            Picture::Height16 => Tileset::Height16,
        }
    }
}

/// Evaluates a window of a world into a file.
pub(crate) fn render(arguments: &RenderArguments) -> anyhow::Result<()> {
    let kind = arguments.kind()?;
    let height = arguments.surface.height();
    if let Kind::Picture(tileset) = kind {
        if height == Height::Water && !tileset.has_height() {
            bail!("--surface water is for heights: {} draws none", tileset.name());
        }
        if arguments.registration == Some(Stand::Vertices) {
            bail!("--registration vertices is for heights: pictures are made of pixels");
        }
    }
    // What is wrong with the area is said before the world is read. Pictures have the samples of a raster.
    let format = if let Kind::Heights(format) = kind { format } else { AreaFormat::R32 };
    let area = arguments.request(format).area(RENDER_SAMPLES)?;
    let world = world(&arguments.world, arguments.data.as_deref())?;
    match kind {
        Kind::Picture(tileset) => picture(&world, area.window(), (tileset, height), &arguments.output),
        Kind::Heights(_) => heights(&world, &area, &arguments.output),
    }?;
    let (window, [west, south, east, north]) = (area.window(), area.covered());
    let (columns, rows, spacing) = (window.columns.len(), window.rows.len(), window.spacing());
    // The area is a whole number of samples from the north-west corner, which may be a little more or less than was asked for.
    let text = format!("{}: {columns} × {rows} samples of {spacing} m over {west},{south},{east},{north}", arguments.output.display());
    writeln!(std::io::stdout(), "{text}").context("writing")
}

fn picture(world: &World, window: &Window, (tileset, height): (Tileset, Height), output: &Path) -> anyhow::Result<()> {
    let wanted = tileset.wanted();
    let surface = world.evaluate_parallel_with(&window.with_apron(tileset.apron()), Wanted { water: wanted.water || height == Height::Water, ..wanted });
    let bytes = tileset.encode_height(surface, window.spacing(), &world.legend(), height, Options::default())?;
    fs::write(output, bytes).with_context(|| format!("writing {}", output.display()))
}

fn heights(world: &World, area: &Area, output: &Path) -> anyhow::Result<()> {
    let writing = || format!("writing {}", output.display());
    let file = BufWriter::new(File::create(output).with_context(writing)?);
    write_area(world, area, file).with_context(writing)
}
