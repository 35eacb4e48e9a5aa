//! `terrane export` and `terrane merge`.

use super::{Detail, Drawn, parse_bbox, progress::Progress, runtime, world};
use anyhow::{Context, bail};
use clap::Args;
use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};
use terrane::{
    geometry::{Grid, Rectangle, Samples, Tile},
    jobs::{Archive, Outcome, Part, Pyramid, Shard, merge as join, run},
    tile::{Image, Options, Rounding, TileRequest, Tileset},
};

/// What a program that was interrupted ends with.
const INTERRUPTED: u8 = 130;

#[derive(Args)]
pub(crate) struct ExportArguments {
    /// A world document, or the name of a stored world
    world: String,
    /// The area in metres: minx,miny,maxx,maxy [default: all of the web's map]
    #[arg(long, value_parser = parse_bbox, allow_hyphen_values = true)]
    bbox: Option<[f64; 4]>,
    /// First and last zoom level, MIN-MAX
    #[arg(long, value_parser = parse_levels)]
    zoom: [u8; 2],
    /// How the plane is cut; archives know web alone
    #[arg(long, default_value = "web", value_parser = |name: &str| Grid::from_name(name).ok_or("there are web, geo and metric"))]
    grid: Grid,
    /// How tiles are drawn: any tileset of pictures or vector tiles
    #[arg(long, default_value = "terrarium", value_parser = parse_tileset)]
    tileset: Tileset,
    /// Samples a side of a tile, or what lines are drawn from: 256 or 512
    #[arg(long, default_value = "256", value_parser = parse_size)]
    size: usize,
    /// Pack pictures as lossless WebP instead of PNG
    #[arg(long)]
    webp: bool,
    /// Round heights to what the spacing of samples justifies, for fewer bytes
    #[arg(long)]
    rounded: bool,
    /// Which height is drawn
    #[arg(long, value_enum, default_value_t = Drawn::Ground)]
    surface: Drawn,
    /// Which detail samples carry
    #[arg(long, value_enum, default_value_t = Detail::Band)]
    filter: Detail,
    /// The archive to write: .pmtiles or .mbtiles
    #[arg(short, long)]
    output: PathBuf,
    /// Write only part I of N, to be joined with `terrane merge`
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<Shard>,
    /// Threads; 0 takes one a processor
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
    /// Folder of stored worlds [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct MergeArguments {
    /// The archive to write: .pmtiles or .mbtiles
    output: PathBuf,
    /// All parts of an export, in any order
    #[arg(required = true)]
    parts: Vec<PathBuf>,
}

fn parse_levels(text: &str) -> Result<[u8; 2], String> {
    let levels = text.split_once('-').unwrap_or((text, text));
    match (levels.0.trim().parse(), levels.1.trim().parse()) {
        (Ok(min), Ok(max)) => Ok([min, max]),
        _ => Err("two levels are needed: MIN-MAX".to_owned()),
    }
}

fn parse_tileset(name: &str) -> Result<Tileset, String> {
    let is_kept = |tileset: &Tileset| tileset.is_picture() || !tileset.layers().is_empty();
    let names: Vec<_> = Tileset::ALL.into_iter().filter(is_kept).map(Tileset::name).collect();
    Tileset::from_name(name).ok_or_else(|| format!("there are {}", names.join(", ")))
}

fn parse_size(text: &str) -> Result<usize, &'static str> {
    text.parse().ok().filter(|size| [256, 512].contains(size)).ok_or("256 and 512 are what maps know")
}

fn parse_shard(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(number, of)| Some((number.trim().parse().ok()?, of.trim().parse().ok()?)));
    let (number, of) = numbers.ok_or("a shard is I/N, such as 1/3")?;
    Shard::new(number, of).map_err(|error| error.to_string())
}

impl ExportArguments {
    fn pyramid(&self) -> anyhow::Result<Pyramid> {
        let image = if self.webp { Image::Webp } else { Image::Png };
        if self.webp && !self.tileset.has_webp() {
            bail!("{} is no WebP: leave --webp out", self.tileset.name());
        }
        if self.surface == Drawn::Water && !self.tileset.has_height() {
            bail!("--surface water is for heights: {} draws none", self.tileset.name());
        }
        if self.rounded && !self.tileset.has_rounding() {
            bail!("{} is not rounded: leave --rounded out", self.tileset.name());
        }
        let rounding = if self.rounded { Rounding::Spacing } else { Rounding::Steps };
        let request = TileRequest {
            grid: self.grid,
            tile: Tile { z: 0, x: 0, y: 0 },
            // Vector tiles are drawn from vertices, which neighbours share.
            samples: if self.tileset.layers().is_empty() { Samples::Centres(self.size) } else { Samples::Vertices(self.size + 1) },
            filter: self.filter.filter(),
            tileset: self.tileset,
            height: self.surface.height(),
            options: Options { image, rounding, ..Options::default() },
        };
        let area = self.bbox.map(|[west, south, east, north]| Rectangle { min: [west, south], max: [east, north] });
        Ok(Pyramid::new(request, area, self.zoom)?)
    }
}

/// The kind of an archive by its name.
fn archive(output: &Path) -> anyhow::Result<Archive> {
    Archive::of(output).with_context(|| format!("{} must end in .pmtiles or .mbtiles", output.display()))
}

/// Where a shard grows.
fn place(output: &Path, shard: Shard) -> PathBuf {
    let mut place = output.as_os_str().to_owned();
    place.push(format!(".part-{}-of-{}", shard.number, shard.of));
    PathBuf::from(place)
}

/// Writes a pyramid of tiles, or a part of it, going on where an earlier run ended.
pub(crate) fn export(arguments: &ExportArguments) -> anyhow::Result<ExitCode> {
    let (output, shard) = (&arguments.output, arguments.shard.unwrap_or(Shard::WHOLE));
    let kind = archive(output)?;
    let pyramid = arguments.pyramid()?;
    let place = place(output, shard);
    if output.exists() && !place.exists() {
        bail!("{} is there already: delete it, or choose another output", output.display());
    }
    let world = world(&arguments.world, arguments.data.as_deref())?;
    let mut part = Part::resume(&place, &pyramid.plan(&world), shard)?;
    let mut out = std::io::stdout();
    if part.done() > 0 {
        writeln!(out, "{}: {} of {} tiles are there", place.display(), part.done(), part.tiles()).context("writing")?;
    }
    let stop = stop_flag()?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build().context("starting threads")?;
    let mut progress = Progress::new(&output.display().to_string(), part.done(), part.tiles());
    let outcome = pool.install(|| run(&world, &pyramid, &mut part, &stop, &mut |done| progress.at(done))).with_context(|| kept(&place))?;
    drop(progress);
    if outcome == Outcome::Stopped {
        let (done, tiles) = (part.done(), part.tiles());
        writeln!(out, "stopped: {done} of {tiles} tiles are kept in {}; the same command goes on from there", place.display()).context("writing")?;
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if shard != Shard::WHOLE {
        let (tiles, place, of) = (part.tiles(), place.display(), shard.of);
        writeln!(out, "{place}: {tiles} tiles; join all {of} parts with terrane merge {} PARTS", output.display()).context("writing")?;
        return Ok(ExitCode::SUCCESS);
    }
    join_parts(vec![part], kind, output).with_context(|| kept(&place))?;
    fs::remove_file(&place).with_context(|| format!("deleting {}", place.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// Joins the parts of a pyramid.
pub(crate) fn merge(arguments: &MergeArguments) -> anyhow::Result<()> {
    let kind = archive(&arguments.output)?;
    if arguments.output.exists() {
        bail!("{} is there already: delete it, or choose another output", arguments.output.display());
    }
    let parts: Result<Vec<_>, _> = arguments.parts.iter().map(|path| Part::open(path)).collect();
    join_parts(parts?, kind, &arguments.output)
}

fn join_parts(parts: Vec<Part>, kind: Archive, output: &Path) -> anyhow::Result<()> {
    let tiles = parts.first().map_or(0, |part| part.plan().tiles);
    let mut progress = Progress::new(&format!("writing {}", output.display()), 0, tiles);
    let tiles = join(parts, kind, output, &mut |done| progress.at(done))?;
    drop(progress);
    let size = fs::metadata(output).with_context(|| format!("reading {}", output.display()))?.len();
    writeln!(std::io::stdout(), "{}: {tiles} tiles, {size} bytes", output.display()).context("writing")
}

/// What to say of an export that failed.
fn kept(place: &Path) -> String {
    format!("the finished tiles are kept in {}; the same command goes on from there", place.display())
}

/// A flag that SIGINT and SIGTERM raise; asked a second time, the program ends at once, which costs the tiles of the present batch.
fn stop_flag() -> anyhow::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let runtime = runtime()?;
    std::thread::spawn(move || {
        runtime.block_on(async {
            terrane::server::stop_signal().await;
            raised.store(true, Ordering::Relaxed);
            terrane::server::stop_signal().await;
        });
        std::process::exit(i32::from(INTERRUPTED));
    });
    Ok(flag)
}
