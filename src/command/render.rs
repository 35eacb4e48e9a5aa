//! `terrane render`.

use super::{Detail, Drawn, parse_bbox, world};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::PathBuf,
};
use terrane::{
    geometry::{Filter, Source, Wanted, Window},
    tile::{Height, Options, Tileset, write_geotiff},
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
    /// Metres a pixel
    #[arg(long)]
    spacing: f64,
    /// The file to write: .png, .tif or .r32
    #[arg(short, long)]
    output: PathBuf,
    /// How a .png is drawn
    #[arg(long, value_enum, default_value_t = Picture::Hillshade)]
    tileset: Picture,
    /// Which height is drawn
    #[arg(long, value_enum, default_value_t = Drawn::Ground)]
    surface: Drawn,
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
}

/// Evaluates a window of a world into a file.
pub(crate) fn render(arguments: &RenderArguments) -> anyhow::Result<()> {
    let extension = arguments.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    let tileset = match (extension, arguments.tileset) {
        ("png", picture) => Some(match picture {
            Picture::Hillshade => Tileset::Hillshade,
            Picture::Terrarium => Tileset::Terrarium,
            Picture::TerrainRgb => Tileset::TerrainRgb,
            Picture::Water => Tileset::Water,
            Picture::Materials => Tileset::Materials,
            Picture::Relief => Tileset::Relief,
        }),
        ("r32", Picture::Hillshade) => Some(Tileset::R32),
        ("tif" | "tiff", Picture::Hillshade) => None,
        ("r32" | "tif" | "tiff", _) => bail!("--tileset is for .png files: .{extension} holds the elevations themselves"),
        _ => bail!("{} must end in .png, .tif or .r32", arguments.output.display()),
    };
    let height = if arguments.surface == Drawn::Water { Height::Water } else { Height::Ground };
    if let Some(tileset) = tileset.filter(|tileset| height == Height::Water && !tileset.has_height()) {
        bail!("--surface water is for heights: {} draws none", tileset.name());
    }
    let filter = match arguments.filter {
        Detail::Band => Filter::Band,
        Detail::Exact => Filter::Exact,
    };
    let window = Window::area(arguments.bbox, arguments.spacing, filter, RENDER_SAMPLES)?;
    let world = world(&arguments.world, arguments.data.as_deref())?;
    let writing = || format!("writing {}", arguments.output.display());
    let evaluate = |window: &Window, wanted: Wanted| world.evaluate_parallel_with(window, Wanted { water: wanted.water || height == Height::Water, ..wanted });
    if let Some(tileset) = tileset {
        let surface = evaluate(&window.with_apron(tileset.apron()), tileset.wanted());
        fs::write(&arguments.output, tileset.encode_height(surface, window.spacing(), &world.legend(), height, Options::default())?).with_context(writing)?;
    } else {
        let mut file = BufWriter::new(File::create(&arguments.output).with_context(writing)?);
        let mut surface = evaluate(&window, Wanted::default());
        surface.raise_to_water();
        write_geotiff(&surface, &window, &mut file).with_context(writing)?;
        file.flush().with_context(writing)?;
    }
    let mut out = std::io::stdout();
    let (columns, rows) = (window.columns.len(), window.rows.len());
    let (west, north, s) = (arguments.bbox[0], arguments.bbox[3], window.spacing());
    // The area is a whole number of samples from the north-west corner, which may be a little more or less than was asked for.
    let (south, east) = (north - rows as f64 * s, west + columns as f64 * s);
    writeln!(out, "{}: {columns} × {rows} samples of {s} m over {west},{south},{east},{north}", arguments.output.display()).context("writing")
}
