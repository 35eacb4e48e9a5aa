//! Which tiles a pyramid has, and in which order.

use super::hilbert::{Block, coordinate};
use crate::{
    geometry::{Grid, Rectangle, Source, Tile, to_lon_lat},
    tile::{TileRequest, VectorLayer},
    world::World,
};
use pmtiles::TileCoord;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::{collections::BTreeMap, ops::Range};

/// The deepest level of archives here.
const MAX_ZOOM: u8 = 24;

/// Why there is no such pyramid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PyramidError {
    /// Levels that are none.
    #[error("levels must be MIN-MAX with 0 ≤ MIN ≤ MAX ≤ {MAX_ZOOM}, got {0}-{1}")]
    Levels(u8, u8),
    /// A tileset whose tiles are no pictures.
    #[error("archives hold pictures and vector tiles here: {0} is neither")]
    Tileset(&'static str),
    /// Another grid than the web's.
    #[error("archives know the grid web alone, not {0}")]
    Grid(&'static str),
    /// An area that no tile covers.
    #[error("the area must have its least corner first and meet the grid's own range, ±20037508 m (minx,miny,maxx,maxy)")]
    Area,
    /// A shard that is none.
    #[error("a shard is I/N with 1 ≤ I ≤ N ≤ 10000, got {0}/{1}")]
    Shard(u32, u32),
}

/// One of several parts of a pyramid, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which.
    pub number: u32,
    /// Of how many.
    pub of: u32,
}

impl Shard {
    /// All of it.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Part `number` of `of`.
    ///
    /// # Errors
    /// If there is no such part.
    pub fn new(number: u32, of: u32) -> Result<Self, PyramidError> {
        if (1..=of).contains(&number) && of <= 10_000 { Ok(Self { number, of }) } else { Err(PyramidError::Shard(number, of)) }
    }

    /// The tiles of it among all, by their places in the order.
    #[must_use]
    pub fn range(&self, tiles: u64) -> Range<u64> {
        let at = |number: u32| (u128::from(tiles) * u128::from(number) / u128::from(self.of)) as u64;
        at(self.number - 1)..at(self.number)
    }
}

/// The tiles of some levels over an area, in the order of archives: level by level, along a Hilbert curve.
#[derive(Clone, Debug)]
pub struct Pyramid {
    /// First and last level.
    pub levels: [u8; 2],
    /// What is drawn: all of it but the tile.
    request: TileRequest,
    blocks: Vec<Block>,
    order: Order,
    /// Degrees: west, south, east, north.
    bounds: [f64; 4],
}

impl Pyramid {
    /// The tiles that an area in metres meets (all without one) on levels, drawn as the request says.
    ///
    /// # Errors
    /// If there are no such tiles or archives cannot hold them.
    pub fn new(request: TileRequest, area: Option<Rectangle>, levels: [u8; 2]) -> Result<Self, PyramidError> {
        let TileRequest { grid, tileset, .. } = request;
        if grid != Grid::Web {
            return Err(PyramidError::Grid(grid.name()));
        }
        if !tileset.is_picture() && tileset.layers().is_empty() {
            return Err(PyramidError::Tileset(tileset.name()));
        }
        if levels[0] > levels[1] || levels[1] > MAX_ZOOM {
            return Err(PyramidError::Levels(levels[0], levels[1]));
        }
        let half = grid.tile_side(0) / 2.0;
        let own = Rectangle { min: [-half; 2], max: [half; 2] };
        let area = area.unwrap_or(own);
        let clipped = Rectangle { min: area.min.map(|c| c.max(-half)), max: area.max.map(|c| c.min(half)) };
        if !(0..2).all(|axis| area.min[axis] < area.max[axis] && clipped.min[axis] < clipped.max[axis]) {
            return Err(PyramidError::Area);
        }
        let blocks: Vec<Block> = (levels[0]..=levels[1]).map(|z| block(grid, z, &clipped)).collect();
        let ((west, south), (east, north)) = (to_lon_lat(clipped.min[0], clipped.min[1]), to_lon_lat(clipped.max[0], clipped.max[1]));
        Ok(Self { levels, request, order: Order::of(&blocks), blocks, bounds: [west, south, east, north] })
    }

    /// How many tiles it has.
    #[must_use]
    pub fn tiles(&self) -> u64 {
        self.order.tiles()
    }

    /// The request for the tile at a place of the order.
    ///
    /// # Panics
    /// If there are not so many.
    #[must_use]
    pub fn request(&self, place: u64) -> TileRequest {
        let tile = self.order.tile(place);
        TileRequest { tile: Tile { z: tile.z(), x: tile.x().into(), y: tile.y().into() }, ..self.request }
    }

    /// What it is of a world: all that decides about the bytes of its archive.
    #[must_use]
    pub fn plan(&self, world: &World) -> Plan {
        let (document, tileset) = (world.document(), self.request.tileset);
        let side = self.request.samples.side();
        let [west, south, east, north] = self.bounds.map(|degrees| (degrees * 1e7).round() / 1e7);
        Plan {
            revision: world.revision().to_string(),
            drawn: format!("{}\n{side} {}", self.request.form(&world.legend()), self.request.filter.name()),
            levels: self.levels,
            blocks: self.blocks.clone(),
            tiles: self.tiles(),
            extension: tileset.extension(self.request.options.image).to_owned(),
            vector_layers: (!tileset.layers().is_empty()).then(|| tileset.layers().iter().map(described).collect()),
            title: document.title.clone().unwrap_or_else(|| "Terrane".to_owned()),
            description: document.description.clone(),
            attribution: document.attribution.clone(),
            encoding: tileset.encoding().map(str::to_owned),
            range: tileset.steps(world.legend().range).map(|_| world.legend().range),
            side: tileset.layers().is_empty().then_some(side),
            bounds: [west, south, east, north],
        }
    }
}

/// A layer of vector tiles as `TileJSON` describes it.
fn described(layer: &VectorLayer) -> Value {
    let fields: BTreeMap<&str, &str> = layer.fields.iter().copied().collect();
    json!({"id": layer.id, "description": layer.description, "fields": fields})
}

/// What a pyramid is, as its parts and archives say it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The world's.
    pub revision: String,
    /// Tileset, version of the encoder, options, samples, filter.
    pub drawn: String,
    /// First and last level.
    pub levels: [u8; 2],
    /// The tiles of every level.
    pub blocks: Vec<Block>,
    /// Tiles of all shards.
    pub tiles: u64,
    /// `png`, `webp` or `mvt`.
    pub extension: String,
    /// The layers of vector tiles, as `TileJSON` describes them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vector_layers: Option<Value>,
    /// Of the world.
    pub title: String,
    /// Of the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Of the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attribution: Option<String>,
    /// Of elevations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub encoding: Option<String>,
    /// Metres that the least and the greatest number stand for, where they are the world's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Pixels a side of a tile; a vector tile has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub side: Option<usize>,
    /// Degrees: west, south, east, north.
    pub bounds: [f64; 4],
}

impl Plan {
    /// Whether it is one of a pyramid: a block a level, and as many tiles as they hold.
    pub(super) fn is_sound(&self) -> bool {
        let [first, last] = self.levels;
        let tiles = self.blocks.iter().try_fold(0_u64, |tiles, block| tiles.checked_add(block.tiles()?));
        last <= MAX_ZOOM && self.blocks.iter().map(|block| block.z).eq(first..=last) && tiles == Some(self.tiles)
    }
}

/// The tiles of blocks in the order of archives.
#[derive(Clone, Debug)]
pub(super) struct Order {
    /// Runs of tiles' numbers, ascending, each with the place of its first tile in the order.
    runs: Vec<(u64, Range<u64>)>,
}

impl Order {
    pub(super) fn of(blocks: &[Block]) -> Self {
        let places = |place: &mut u64, run: Range<u64>| Some((std::mem::replace(place, *place + (run.end - run.start)), run));
        Self { runs: blocks.iter().flat_map(Block::runs).scan(0, places).collect() }
    }

    fn tiles(&self) -> u64 {
        self.runs.last().map_or(0, |(place, run)| place + run.end - run.start)
    }

    /// The tile at a place.
    fn tile(&self, place: u64) -> TileCoord {
        let (first, run) = &self.runs[self.runs.partition_point(|(first, _)| *first <= place) - 1];
        assert!(place - first < run.end - run.start, "tile {place} of {}", self.tiles());
        coordinate(run.start + place - first)
    }

    /// All tiles.
    pub(super) fn all(&self) -> impl Iterator<Item = TileCoord> + '_ {
        self.runs.iter().flat_map(|(_, run)| run.clone()).map(coordinate)
    }
}

/// The tiles of a level that meet an area, which lies in the grid's own range.
fn block(grid: Grid, z: u8, area: &Rectangle) -> Block {
    let (side, half, last) = (grid.tile_side(z), grid.tile_side(0) / 2.0, (1_u64 << z) as f64 - 1.0);
    // An edge between tiles belongs to the tiles inside the area alone.
    let span = |from: f64, to: f64| [(from / side).floor().clamp(0.0, last) as u32, ((to / side).ceil() - 1.0).clamp(0.0, last) as u32];
    Block { z, columns: span(area.min[0] + half, area.max[0] + half), rows: span(half - area.max[1], half - area.min[1]) }
}
