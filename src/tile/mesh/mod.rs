//! Terrain as triangles on the globe: quantized-mesh tiles for Cesium and the engines that read its formats.

mod bytes;
mod globe;
mod simplify;
mod vertical;

use super::{Height, TileError, TileRequest, water};
use crate::{
    analysis,
    geometry::{Filter, Grid, GridError, Legend, Samples, Source, Surface, Tile, Wanted, Window},
};
use bytes::{Bytes, METADATA, NORMALS, WATER_MASK, octahedral};
use core::f64::consts::PI;
use simplify::{Lattice, Mesh, Place};
use vertical::{LAST, Vertical, edge_step, round_to};

/// Samples a side of the lattices that meshes are drawn from: 2^n + 1.
pub const MESH_SIDES: [usize; 5] = [17, 33, 65, 129, 257];

/// The deepest level that meshes say there is.
pub const MAX_MESH_ZOOM: u8 = 24;

/// Samples a side of a mask of water.
const MASK_SIDE: usize = 256;

/// By how many metres a mesh of a level may miss a sample, before its heights are rounded: a quarter of the error that Cesium expects of the level.
///
/// Cesium expects of level 0 a quarter of the equator's length over 65 samples of all its tiles, and half of it at each level further (`TerrainProvider`,
/// `getEstimatedLevelZeroGeometricErrorForAHeightmap`).
#[must_use]
pub fn mesh_tolerance(grid: Grid, z: u8) -> f64 {
    let samples = 65.0 * grid.size(0)[0] as f64;
    globe::RADII[0] * 2.0 * PI * 0.25 / samples / 4.0 / (1_u64 << z) as f64
}

/// The metres that heights on the edges of a world's meshes are multiples of; those inside are multiples of as much or less.
#[must_use]
pub fn mesh_step(legend: &Legend, height: Height) -> f64 {
    edge_step(vertical_range(legend, height))
}

/// Least and greatest height of a mesh in metres: water may stand higher than any ground.
fn vertical_range(legend: &Legend, height: Height) -> [f64; 2] {
    let [low, high] = legend.range;
    [low, if height == Height::Water { high.max(legend.sea_level) } else { high }]
}

/// The samples of a mask of water with an apron of one.
pub(super) fn mask_window(request: &TileRequest) -> Result<Window, GridError> {
    Ok(request.grid.window(request.tile, Samples::Centres(MASK_SIDE), request.filter)?.with_apron(1))
}

/// Samples between vertices that are kept for the earth's roundness: chords of this many miss the sphere by the level's tolerance at most.
fn stride(grid: Grid, tile: Tile, side: usize) -> usize {
    let angle = 2.0 * PI / grid.size(tile.z)[0] as f64 / (side - 1) as f64;
    let mut stride = side - 1;
    let sagitta = |stride: usize| globe::RADII[0] * (stride as f64 * angle) * (stride as f64 * angle) / 8.0;
    while stride > 1 && sagitta(stride) > mesh_tolerance(grid, tile.z) {
        stride /= 2;
    }
    stride
}

/// The samples of a tile on the globe.
struct Ground {
    lattice: Lattice,
    /// Radians, by column and by row.
    longitudes: Vec<f64>,
    latitudes: Vec<f64>,
    /// Metres that heights on edges are multiples of.
    edge_step: f64,
}

impl Ground {
    /// Of a surface with an apron of one.
    fn of(request: &TileRequest, surface: &Surface, legend: &Legend) -> Result<Self, GridError> {
        let window = request.grid.window(request.tile, request.samples, request.filter)?;
        let (longitudes, latitudes) = (globe::longitudes(request.grid, &window.columns), globe::latitudes(request.grid, &window.rows));
        let range = vertical_range(legend, request.height);
        let inner = (1..surface.rows - 1).flat_map(|row| &surface.row(row)[1..surface.columns - 1]);
        let heights = inner.map(|&height| f64::from(height).clamp(range[0], range[1])).collect();
        let lattice = Lattice { across: spread(&longitudes), along: spread(&latitudes), heights };
        Ok(Self { lattice, longitudes, latitudes, edge_step: edge_step(range) })
    }

    /// The height of a vertex in metres: those on edges are rounded as the neighbour rounds them.
    fn height(&self, place: Place) -> f64 {
        let last = self.lattice.side() - 1;
        let is_edge = place.iter().any(|&at| at == 0 || at == last);
        let height = self.lattice.height(place);
        if is_edge { round_to(self.edge_step, height) } else { height }
    }

    /// Where clients will see a vertex whose height has a number.
    fn decoded(&self, [row, column]: Place, height: f64) -> globe::Vector {
        let between = |ends: [f64; 2], at: u16| ends[0] + (ends[1] - ends[0]) * (f64::from(at) / LAST);
        let last = self.lattice.side() - 1;
        let longitude = between([self.longitudes[0], self.longitudes[last]], self.lattice.across[column]);
        globe::place(longitude, between([self.latitudes[last], self.latitudes[0]], self.lattice.along[row]), height)
    }
}

/// Coordinates as numbers from 0, of the least, to 32767, of the greatest.
fn spread(coordinates: &[f64]) -> Vec<u16> {
    let ends = [coordinates.first(), coordinates.last()].map(|end| end.copied().unwrap_or_default());
    let (least, span) = (ends[0].min(ends[1]), (ends[1] - ends[0]).abs());
    coordinates.iter().map(|coordinate| ((coordinate - least) / span * LAST + 0.5) as u16).collect()
}

/// Draws a tile of `geo` or `web`.
pub(super) fn draw(source: &impl Source, request: &TileRequest) -> Result<Vec<u8>, TileError> {
    let window = request.window()?;
    let mut surface = Surface::with(&window, Wanted { water: request.height == Height::Water, ..Wanted::default() });
    source.sample(&window, &mut surface);
    if surface.stop.is_set() {
        return Err(TileError::Stopped);
    }
    if request.height == Height::Water {
        surface.raise_to_water();
    }
    let ground = Ground::of(request, &surface, &source.legend())?;
    let side = ground.lattice.side();
    let mesh = ground.lattice.simplify(mesh_tolerance(request.grid, request.tile.z), stride(request.grid, request.tile, side));
    let mut bytes = Bytes::default();
    write(&mut bytes, &ground, &mesh);
    let extensions = request.options.mesh;
    if extensions.normals {
        bytes.extension(NORMALS, &normals(request.grid, &ground, &mesh, &surface, window.spacing()));
    }
    if extensions.water_mask {
        bytes.extension(WATER_MASK, &water_mask(source, request)?);
    }
    if extensions.metadata {
        let json = metadata(request);
        bytes.extension(METADATA, &[&(json.len() as u32).to_le_bytes(), json.as_bytes()].concat());
    }
    Ok(bytes.0)
}

/// Header, vertices, triangles and edges.
fn write(bytes: &mut Bytes, ground: &Ground, mesh: &Mesh) {
    let heights = mesh.vertices.iter().map(|&place| ground.height(place));
    let vertical = Vertical::of(heights.clone());
    let numbers: Vec<u16> = heights.map(|height| vertical.number(height)).collect();
    let places: Vec<_> = mesh.vertices.iter().zip(&numbers).map(|(&place, &number)| ground.decoded(place, vertical.height(number))).collect();
    let (centre, radius) = globe::sphere(&places);
    bytes.doubles(&centre);
    bytes.float(vertical.least as f32);
    bytes.float(vertical.most() as f32);
    bytes.doubles(&centre);
    bytes.doubles(&[radius]);
    bytes.doubles(&globe::occlusion_point(centre, &places));
    let count = mesh.vertices.len();
    bytes.count(count);
    bytes.deltas(mesh.vertices.iter().map(|place| ground.lattice.across[place[1]]));
    bytes.deltas(mesh.vertices.iter().map(|place| ground.lattice.along[place[0]]));
    bytes.deltas(numbers.into_iter());
    bytes.triangles(&mesh.triangles, count);
    let last = ground.lattice.side() - 1;
    // West, south, east and north: which coordinate is fixed, and where.
    for (axis, at) in [(1, 0), (0, last), (1, last), (0, 0)] {
        let mut edge: Vec<u32> = (0..count as u32).filter(|&vertex| mesh.vertices[vertex as usize][axis] == at).collect();
        edge.sort_unstable_by_key(|&vertex| mesh.vertices[vertex as usize][1 - axis]);
        bytes.edge(&edge, count);
    }
}

/// The normals of the ground at the vertices, from the samples round each, so that neighbours have the same.
fn normals(grid: Grid, ground: &Ground, mesh: &Mesh, surface: &Surface, spacing: f64) -> Vec<u8> {
    let normal = |&[row, column]: &Place| {
        let gradient = analysis::gradient(surface, row + 1, column + 1, spacing);
        octahedral(globe::normal(grid, ground.longitudes[column], ground.latitudes[row], gradient))
    };
    mesh.vertices.iter().flat_map(normal).collect()
}

/// One byte if all is land (0) or water (255), else 256 × 256 of them from the north-west, equal steps of latitude apart.
fn water_mask(source: &impl Source, request: &TileRequest) -> Result<Vec<u8>, GridError> {
    let window = mask_window(request)?;
    let mut surface = Surface::with(&window, Wanted { water: true, ..Wanted::default() });
    source.sample(&window, &mut surface);
    let greys = water::greys(&surface, window.spacing(), source.legend().sea_level as f32);
    if let Some(&first) = greys.first()
        && matches!(first, 0 | 255)
        && greys.iter().all(|&grey| grey == first)
    {
        return Ok(vec![first]);
    }
    let edges = request.grid.window(request.tile, Samples::Vertices(MASK_SIDE + 1), Filter::Exact)?;
    let latitudes = globe::latitudes(request.grid, &edges.rows);
    let rows = (0..MASK_SIDE).map(|row| {
        let latitude = latitudes[0] + (latitudes[MASK_SIDE] - latitudes[0]) * ((row as f64 + 0.5) / MASK_SIDE as f64);
        // The row of samples whose edges the latitude lies between.
        latitudes.partition_point(|&edge| edge >= latitude).clamp(1, MASK_SIDE) - 1
    });
    Ok(rows.flat_map(|row| &greys[row * MASK_SIDE..][..MASK_SIDE]).copied().collect())
}

/// Which tiles there are below a tile: all. Rows count from the south.
fn metadata(request: &TileRequest) -> String {
    let Tile { z, x, y } = request.tile;
    let south = request.grid.size(z)[1] - 1 - y;
    let below = |level: u8| {
        let tiles = 1_i64 << (level - z);
        let (start_x, start_y) = (x * tiles, south * tiles);
        format!(r#"[{{"startX":{start_x},"startY":{start_y},"endX":{},"endY":{}}}]"#, start_x + tiles - 1, start_y + tiles - 1)
    };
    let levels: Vec<String> = (z + 1..=MAX_MESH_ZOOM).map(below).collect();
    format!(r#"{{"available":[{}]}}"#, levels.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tolerance_is_a_quarter_of_what_cesium_expects() {
        let equator = 40_075_016.685_578_49;
        assert!((mesh_tolerance(Grid::Geo, 0) - equator / 4.0 / 130.0 / 4.0).abs() < 1e-6);
        assert!((mesh_tolerance(Grid::Web, 3) - equator / 4.0 / 65.0 / 4.0 / 8.0).abs() < 1e-6);
    }

    #[test]
    fn the_earth_is_round_from_afar_and_flat_from_near() {
        let strides: Vec<usize> = (0..12).map(|z| stride(Grid::Geo, Tile { z, x: 0, y: 0 }, 65)).collect();
        assert_eq!(strides, [2, 4, 4, 8, 8, 16, 16, 32, 32, 64, 64, 64]);
    }

    #[test]
    fn metadata_lists_all_that_lies_below() {
        let request = TileRequest {
            grid: Grid::Geo,
            tile: Tile { z: 22, x: 5, y: (1 << 22) - 8 },
            samples: Samples::Vertices(65),
            filter: Filter::Band,
            tileset: crate::tile::Tileset::QuantizedMesh,
            height: Height::Ground,
            options: crate::tile::Options::default(),
        };
        let want = r#"{"available":[[{"startX":10,"startY":14,"endX":11,"endY":15}],[{"startX":20,"startY":28,"endX":23,"endY":31}]]}"#;
        assert_eq!(metadata(&request), want);
    }
}
