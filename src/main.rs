//! The command line: arguments, configuration, start.

use anyhow::{Context, bail};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::{
    fs::{self, File},
    io::{BufWriter, IsTerminal, Write},
    net::SocketAddr,
    path::{Path, PathBuf},
    process::ExitCode,
    sync::Arc,
};
use terrane::{
    geometry::{Filter, Source, Wanted, Window},
    layout::geojson::FeatureSet,
    noise::Isa,
    server::{self, Config},
    store::{KeyEntry, Kind, Scope, Store},
    tile::{Height, Options, Tileset, write_geotiff},
    world::{Document, FeatureSets, World},
};
use tracing_subscriber::EnvFilter;

/// Most samples of a rendered window: 2^28.
const RENDER_SAMPLES: u64 = 1 << 28;

/// Streams endless, deterministic, generated terrain.
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Serve worlds over HTTP
    Serve(ServeArguments),
    /// Check a world document and print it completed
    Check {
        /// The document; - for standard input
        file: PathBuf,
    },
    /// Evaluate a window of a world into a file
    Render(RenderArguments),
    /// Make, show and take back the keys of a server; one that runs takes notice
    #[command(subcommand)]
    Key(KeyCommand),
}

#[derive(Subcommand)]
enum KeyCommand {
    /// Make a key and print it; it is kept nowhere
    New {
        /// Whose it is, for people
        name: String,
        /// What it is for: read, write (which reads too) or admin (which does all)
        #[arg(long, default_value_t = Scope::Write)]
        scope: Scope,
        #[command(flatten)]
        folder: Folder,
    },
    /// Show all keys without their secrets
    List {
        #[command(flatten)]
        folder: Folder,
    },
    /// Take a key back
    Revoke {
        /// Its id, as `terrane key list` shows it
        id: String,
        #[command(flatten)]
        folder: Folder,
    },
}

#[derive(Args)]
struct Folder {
    /// Folder of the server's data [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
}

#[derive(Args)]
struct ServeArguments {
    /// Address and port [default: 127.0.0.1:8080]
    #[arg(long, value_name = "ADDR:PORT")]
    listen: Option<SocketAddr>,
    /// Folder for worlds [default: ./data-store]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Threads that evaluate tiles; 0 takes one a processor [default: 0]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// URL that clients reach the server by, base path included
    #[arg(long, value_name = "URL")]
    public_url: Option<String>,
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

#[derive(Args)]
struct RenderArguments {
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

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Drawn {
    Ground,
    Water,
}

#[derive(Clone, Copy, ValueEnum)]
enum Detail {
    Band,
    Exact,
}

fn parse_bbox(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    numbers.ok().and_then(|numbers| numbers.try_into().ok()).ok_or_else(|| "four numbers are needed: minx,miny,maxx,maxy".to_owned())
}

fn main() -> ExitCode {
    let filter = EnvFilter::try_from_env("TERRANE_LOG").unwrap_or_else(|_| EnvFilter::new("info"));
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours);
    if std::env::var("TERRANE_LOG_FORMAT").is_ok_and(|format| format == "json") {
        log.json().init();
    } else {
        log.init();
    }
    let command = Arguments::parse().command;
    let done = Isa::from_environment().map_err(anyhow::Error::msg).and_then(|_| match command {
        Command::Serve(arguments) => serve(arguments),
        Command::Check { file } => check(&file),
        Command::Render(arguments) => render(&arguments),
        Command::Key(command) => key(command),
    });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Standard error may be closed; the exit code still says it.
            let _ = writeln!(std::io::stderr(), "error: {}", with_causes(&error));
            ExitCode::FAILURE
        }
    }
}

/// An error and those of its causes that it does not already repeat.
fn with_causes(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |text, cause| {
        let cause = cause.to_string();
        match text.as_str() {
            "" => cause,
            said if said.contains(&cause) => text,
            said => format!("{said}: {cause}"),
        }
    })
}

fn config(file: Option<&Path>) -> anyhow::Result<Config> {
    let text = match file {
        Some(file) => fs::read_to_string(file).with_context(|| format!("reading {}", file.display()))?,
        None => String::new(),
    };
    let environment = std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)));
    Ok(Config::load(&text, environment)?)
}

fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")
}

fn serve(arguments: ServeArguments) -> anyhow::Result<()> {
    let mut config = config(arguments.config.as_deref())?;
    config.server.listen = arguments.listen.unwrap_or(config.server.listen);
    config.server.data = arguments.data.unwrap_or(config.server.data);
    config.server.threads = arguments.threads.unwrap_or(config.server.threads);
    config.server.public_url = arguments.public_url.unwrap_or(config.server.public_url);
    config.check()?;
    Ok(runtime()?.block_on(server::serve(&config))?)
}

fn check(file: &Path) -> anyhow::Result<()> {
    let bytes = if file == Path::new("-") { std::io::read_to_string(std::io::stdin()).map(String::into_bytes) } else { fs::read(file) };
    let document = parse(&bytes.with_context(|| format!("reading {}", file.display()))?, &file.display().to_string())?;
    writeln!(std::io::stdout(), "{}", document.to_json()).context("writing")
}

fn parse(json: &[u8], name: &str) -> anyhow::Result<Document> {
    Document::parse(json).map_err(|error| anyhow::anyhow!("{name}:\n  {}", error.to_string().replace('\n', "\n  ")))
}

/// The document of a file, or of a stored world.
fn world(name: &str, data: Option<&Path>) -> anyhow::Result<World> {
    if Path::new(name).is_file() {
        let json = fs::read(name).with_context(|| format!("reading {name}"))?;
        return Ok(World::new(parse(&json, name)?));
    }
    let folder = data.map_or_else(|| config(None).map(|config| config.server.data), |data| Ok(data.to_path_buf()))?;
    if !folder.join("terrane.sqlite").is_file() {
        bail!("there is no file {name}, and no worlds are stored in {}", folder.display());
    }
    let runtime = runtime()?;
    let store = runtime.block_on(Store::open_read_only(&folder))?;
    let worlds = runtime.block_on(store.documents(Kind::World))?;
    let names: Vec<_> = worlds.iter().map(|world| world.name.as_str()).collect();
    let Some(stored) = worlds.iter().find(|world| world.name == name) else {
        bail!("{name} is neither a file nor one of the worlds in {}: {}", folder.display(), names.join(", "));
    };
    let mut sets = FeatureSets::default();
    for set in FeatureSets::named_in(stored.body.as_bytes()) {
        if let Some(stored) = runtime.block_on(store.feature_set(&set))? {
            sets.insert(set, Arc::new(FeatureSet::read(&stored)?));
        }
    }
    Ok(World::new(Document::parse_stored(stored.body.as_bytes(), &sets).with_context(|| format!("the stored world {name}"))?))
}

fn key(command: KeyCommand) -> anyhow::Result<()> {
    let open = |folder: Folder| async move {
        let folder = folder.data.map_or_else(|| config(None).map(|config| config.server.data), Ok)?;
        anyhow::Ok(Store::open_beside(&folder).await?)
    };
    let mut out = std::io::stdout();
    runtime()?.block_on(async {
        match command {
            KeyCommand::New { name, scope, folder } => {
                let (_, secret) = open(folder).await?.add_key(&name, scope).await?;
                Ok(writeln!(out, "{secret}")?)
            }
            KeyCommand::List { folder } => {
                for KeyEntry { id, name, scope, time, .. } in open(folder).await?.keys().await? {
                    writeln!(out, "{id}  {scope:<5}  {time}  {name}")?;
                }
                Ok(())
            }
            KeyCommand::Revoke { id, folder } => Ok(open(folder).await?.revoke_key(&id).await?),
        }
    })
}

fn render(arguments: &RenderArguments) -> anyhow::Result<()> {
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
