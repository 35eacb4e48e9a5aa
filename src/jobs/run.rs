//! The tiles of a shard that are not there yet, evaluated on all threads.

use super::{Part, PartError, Pyramid};
use crate::{
    tile::{self, TileError, Tileset},
    world::World,
};
use flate2::{Compression, write::GzEncoder};
use rayon::prelude::*;
use std::{
    io::Write,
    sync::atomic::{AtomicBool, Ordering},
};

/// What a batch of tiles is meant to take, in nanoseconds: as much is lost when the program is killed.
const BATCH_NS: f64 = 2.5e8;

/// What a tile takes beside its evaluation: drawing and packing 65,536 samples.
const DRAWING_NS: f64 = 2e6;

/// Most and fewest tiles of a batch, a thread.
const MOST: usize = 64;
const FEWEST: usize = 2;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All tiles are there.
    Done,
    /// It was asked to stop; what is done is kept.
    Stopped,
}

/// Why a run could not go on; what is done is kept.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The part failed.
    #[error(transparent)]
    Part(#[from] PartError),
    /// A tile failed.
    #[error("tile {z}/{x}/{y}: {source}")]
    Tile {
        /// Level.
        z: u8,
        /// Column.
        x: i64,
        /// Row.
        y: i64,
        /// What was wrong.
        source: TileError,
    },
}

/// Adds to a part of a pyramid what it lacks, on all threads of the present rayon pool, until it is whole or `stop` is true. `progress` gets the number of tiles
/// that are there.
///
/// # Errors
/// If a tile cannot be drawn or the part cannot be written.
pub fn run(world: &World, pyramid: &Pyramid, part: &mut Part, stop: &AtomicBool, progress: &mut dyn FnMut(u64)) -> Result<Outcome, RunError> {
    let first = part.shard().range(pyramid.tiles()).start;
    while part.done() < part.tiles() {
        if stop.load(Ordering::Relaxed) {
            return Ok(Outcome::Stopped);
        }
        let from = first + part.done();
        let count = batch(world, pyramid, from).min(part.tiles() - part.done());
        let tiles: Result<Vec<_>, _> = (from..from + count).into_par_iter().map(|place| draw(world, pyramid, place)).collect();
        part.append(&tiles?)?;
        progress(part.done());
    }
    Ok(Outcome::Done)
}

/// How many tiles from a place on are evaluated together.
fn batch(world: &World, pyramid: &Pyramid, place: u64) -> u64 {
    let threads = rayon::current_num_threads();
    let cost_ns = pyramid.request(place).window().map_or(0.0, |window| world.cost_ns(&window)) + DRAWING_NS;
    let a_thread = (BATCH_NS / cost_ns) as usize;
    (a_thread.clamp(FEWEST, MOST) * threads) as u64
}

fn draw(world: &World, pyramid: &Pyramid, place: u64) -> Result<Vec<u8>, RunError> {
    let request = pyramid.request(place);
    let (z, x, y) = (request.tile.z, request.tile.x, request.tile.y);
    let drawn = if request.tileset == Tileset::Features { tile::render_features(world, &request) } else { tile::render(world, &request) };
    let bytes = drawn.map_err(|source| RunError::Tile { z, x, y, source })?;
    Ok(if request.tileset.layers().is_empty() || bytes.is_empty() { bytes } else { zipped(&bytes) })
}

/// Bytes as archives hold vector tiles.
fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("a vector takes everything")
}
