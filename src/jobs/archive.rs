//! Parts of a pyramid joined to one archive: `PMTiles` or `MBTiles`.
//!
//! Tiles are written in their order whatever shards they come from, so the archive's bytes follow from world and pyramid alone.

use super::{Part, PartError, Plan, pyramid::Order};
use crate::store::{MbTiles, StoreError};
use pmtiles::{Compression, PmTilesWriter, PmtError, TileCoord, TileType};
use serde_json::json;
use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};

/// A kind of archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Archive {
    /// `PMTiles`, version 3.
    PmTiles,
    /// `MBTiles` 1.3.
    MbTiles,
}

/// Why parts could not be joined; they stay as they are.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    /// There are none.
    #[error("no parts are given")]
    None,
    /// They are of different pyramids, or of other shards.
    #[error("{} and {} are parts of different exports", one.display(), other.display())]
    Different {
        /// One of them.
        one: PathBuf,
        /// Another.
        other: PathBuf,
    },
    /// Some are missing, or there more than once.
    #[error("of {of} parts each is needed once; given are {}", .given.iter().map(u32::to_string).collect::<Vec<_>>().join(", "))]
    Missing {
        /// How many there are.
        of: u32,
        /// Those given.
        given: Vec<u32>,
    },
    /// One is not done.
    #[error("{}: {done} of {tiles} tiles are done; run its export again to go on", path.display())]
    Incomplete {
        /// The part.
        path: PathBuf,
        /// Tiles that are there.
        done: u64,
        /// Tiles of the shard.
        tiles: u64,
    },
    /// A part cannot be read.
    #[error(transparent)]
    Part(#[from] PartError),
    /// The archive cannot be written.
    #[error("writing {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The `PMTiles` archive cannot be written.
    #[error("writing {}: {source}", path.display())]
    PmTiles {
        /// The file.
        path: PathBuf,
        /// What was wrong.
        source: PmtError,
    },
    /// The `MBTiles` archive cannot be written.
    #[error("writing {}: {source}", path.display())]
    MbTiles {
        /// The file.
        path: PathBuf,
        /// What the database said.
        source: StoreError,
    },
}

impl Archive {
    /// The kind of a file by its extension: `.pmtiles` or `.mbtiles`.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "pmtiles" => Some(Archive::PmTiles),
            "mbtiles" => Some(Archive::MbTiles),
            _ => None,
        }
    }
}

/// Joins all parts of a pyramid to an archive, which is there when it is whole and not before. `progress` gets the number of tiles that are written. Answers how many.
///
/// # Errors
/// If a part is missing, not done, or of something else, or if writing fails.
pub fn merge(mut parts: Vec<Part>, archive: Archive, to: &Path, progress: &mut dyn FnMut(u64)) -> Result<u64, ArchiveError> {
    parts.sort_by_key(|part| part.shard().number);
    check(&parts)?;
    let plan = parts[0].plan().clone();
    let mut new = to.as_os_str().to_owned();
    new.push(".new");
    let new = PathBuf::from(new);
    let failed = |source| ArchiveError::Io { path: to.to_owned(), source };
    match archive {
        Archive::PmTiles => write_pmtiles(&parts, &plan, &new, progress)?,
        Archive::MbTiles => write_mbtiles(&parts, &plan, &new, progress)?,
    }
    File::open(&new).and_then(|file| file.sync_all()).map_err(failed)?;
    fs::rename(&new, to).map_err(failed)?;
    Ok(plan.tiles)
}

/// All parts of one pyramid, each once and whole.
fn check(parts: &[Part]) -> Result<(), ArchiveError> {
    let first = parts.first().ok_or(ArchiveError::None)?;
    let of = first.shard().of;
    if let Some(other) = parts.iter().find(|part| part.plan() != first.plan() || part.shard().of != of) {
        return Err(ArchiveError::Different { one: first.path().to_owned(), other: other.path().to_owned() });
    }
    let given: Vec<u32> = parts.iter().map(|part| part.shard().number).collect();
    if given.iter().copied().ne(1..=of) {
        return Err(ArchiveError::Missing { of, given });
    }
    match parts.iter().find(|part| part.done() < part.tiles()) {
        Some(part) => Err(ArchiveError::Incomplete { path: part.path().to_owned(), done: part.done(), tiles: part.tiles() }),
        None => Ok(()),
    }
}

/// Hands all tiles over in their order.
fn each(
    parts: &[Part],
    plan: &Plan,
    progress: &mut dyn FnMut(u64),
    mut take: impl FnMut(TileCoord, &[u8]) -> Result<(), ArchiveError>,
) -> Result<(), ArchiveError> {
    /// Tiles between two reports.
    const STEP: u64 = 256;
    let order = Order::of(&plan.blocks);
    let (mut tiles, mut written) = (order.all(), 0);
    for part in parts {
        part.each(|bytes| {
            let tile = tiles.next().ok_or_else(|| PartError::Strange(part.path().to_owned()))?;
            written += 1;
            if written % STEP == 0 || written == plan.tiles {
                progress(written);
            }
            // A vector tile without content is none.
            if bytes.is_empty() { Ok(()) } else { take(tile, bytes) }
        })?;
    }
    Ok(())
}

/// Where the view that shows the area begins: longitude, latitude, level.
fn centre(plan: &Plan) -> (f64, f64, u8) {
    let [west, south, east, north] = plan.bounds;
    (f64::midpoint(west, east), f64::midpoint(south, north), plan.levels[0])
}

/// Whether maps lie on it or it lies on maps.
fn kind(plan: &Plan) -> &'static str {
    if plan.vector_layers.is_some() { "overlay" } else { "baselayer" }
}

fn write_pmtiles(parts: &[Part], plan: &Plan, to: &Path, progress: &mut dyn FnMut(u64)) -> Result<(), ArchiveError> {
    let failed = |source| ArchiveError::PmTiles { path: to.to_owned(), source };
    let [west, south, east, north] = plan.bounds;
    let (longitude, latitude, zoom) = centre(plan);
    let metadata = json!({
        "name": plan.title, "description": plan.description, "attribution": plan.attribution, "type": kind(plan), "version": plan.revision,
        "encoding": plan.encoding, "range": plan.range, "tileSize": plan.side, "vector_layers": plan.vector_layers,
    });
    let metadata = metadata.as_object().into_iter().flatten().filter(|(_, value)| !value.is_null()).map(|(key, value)| (key.clone(), value.clone()));
    let file = File::create(to).map_err(PmtError::from).map_err(failed)?;
    let writer = match plan.extension.as_str() {
        "webp" => PmTilesWriter::new(TileType::Webp),
        "mvt" => PmTilesWriter::new(TileType::Mvt).precompressed(Compression::Gzip),
        _ => PmTilesWriter::new(TileType::Png),
    };
    let mut writer = writer
        .min_zoom(plan.levels[0])
        .max_zoom(plan.levels[1])
        .bounds(west, south, east, north)
        .center(longitude, latitude)
        .center_zoom(zoom)
        .metadata(metadata.collect::<serde_json::Map<_, _>>().into_iter().collect::<serde_json::Value>().to_string())
        .create(file)
        .map_err(failed)?;
    each(parts, plan, progress, |tile, bytes| writer.add_tile(tile, bytes).map_err(failed))?;
    writer.finalize().map_err(failed)
}

fn write_mbtiles(parts: &[Part], plan: &Plan, to: &Path, progress: &mut dyn FnMut(u64)) -> Result<(), ArchiveError> {
    let failed = |source| ArchiveError::MbTiles { path: to.to_owned(), source };
    match fs::remove_file(to) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => return Err(ArchiveError::Io { path: to.to_owned(), source }),
        _ => {}
    }
    let (longitude, latitude, zoom) = centre(plan);
    let some = |name: &'static str, value: Option<String>| value.map(|value| (name, value));
    let metadata = [
        some("name", Some(plan.title.clone())),
        some("format", Some(if plan.extension == "mvt" { "pbf" } else { &plan.extension }.to_owned())),
        some("bounds", Some(plan.bounds.map(|degrees| degrees.to_string()).join(","))),
        some("center", Some(format!("{longitude},{latitude},{zoom}"))),
        some("minzoom", Some(plan.levels[0].to_string())),
        some("maxzoom", Some(plan.levels[1].to_string())),
        some("type", Some(kind(plan).to_owned())),
        some("version", Some(plan.revision.clone())),
        some("description", plan.description.clone()),
        some("attribution", plan.attribution.clone()),
        some("encoding", plan.encoding.clone()),
        some("tilesize", plan.side.map(|side| side.to_string())),
        some("json", plan.vector_layers.as_ref().map(|layers| json!({"vector_layers": layers}).to_string())),
        some("range", plan.range.map(|[low, high]| format!("{low},{high}"))),
    ];
    let metadata: Vec<_> = metadata.into_iter().flatten().collect();
    let mut file = MbTiles::create(to, &metadata).map_err(failed)?;
    each(parts, plan, progress, |tile, bytes| file.put(tile.z(), tile.x(), tile.y(), bytes).map_err(failed))?;
    file.finish().map_err(failed)
}
