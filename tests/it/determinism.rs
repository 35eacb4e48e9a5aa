//! Same bytes whatever the threads and the order; shared edges and shared points equal to the bit.

use crate::client::Client;
use terrane::{
    geometry::{Filter, Grid, Samples, Tile},
    noise::mix,
    tile::{Height, Options, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};

fn worlds() -> Vec<World> {
    EXAMPLES.iter().map(|example| World::new(Document::parse(example.json.as_bytes()).unwrap())).collect()
}

fn vertices(world: &World, grid: Grid, tile: Tile, n: usize, filter: Filter) -> Vec<f32> {
    let request = TileRequest { grid, tile, samples: Samples::Vertices(n), filter, tileset: Tileset::R32, height: Height::Ground, options: Options::default() };
    let bytes = render(world, &request).unwrap();
    bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// The filter, but for tiles whose exact samples would take too long: they would see every island of an endless layout.
fn affordable(world: &World, grid: Grid, tile: Tile, filter: Filter) -> Filter {
    let window = grid.window(tile, Samples::Vertices(257), filter).unwrap();
    if world.cost_ns(&window) > 3e9 { Filter::Band } else { filter }
}

/// Random tiles, negative and beyond 2^z too.
fn places(count: u64) -> impl Iterator<Item = (usize, Grid, Tile)> {
    (0..count).map(|i| {
        let random = |salt: u64, below: u64| mix(i * 16 + salt) % below;
        let z = random(1, 25) as u8;
        // Up to eight times the grid's own range, within 2^40 m.
        let reach = 1_i64 << (z + 3).min(40);
        let at = |salt| (random(salt, 2 * reach as u64) as i64 - reach).clamp(-reach, reach);
        (random(2, EXAMPLES.len() as u64) as usize, if i % 2 == 0 { Grid::Web } else { Grid::Metric }, Tile { z, x: at(3), y: at(4) })
    })
}

#[test]
fn neighbours_share_their_edge_bit_for_bit() {
    let (worlds, n) = (worlds(), 257);
    for (i, (which, grid, tile)) in places(200).enumerate() {
        let filter = affordable(&worlds[which], grid, tile, if i % 4 < 2 { Filter::Band } else { Filter::Exact });
        let here = vertices(&worlds[which], grid, tile, n, filter);
        let east = vertices(&worlds[which], grid, Tile { x: tile.x + 1, ..tile }, n, filter);
        let south = vertices(&worlds[which], grid, Tile { y: tile.y + 1, ..tile }, n, filter);
        for i in 0..n {
            assert_eq!(here[i * n + n - 1].to_bits(), east[i * n].to_bits(), "{grid:?} {tile:?} east, row {i}");
            assert_eq!(here[(n - 1) * n + i].to_bits(), south[i].to_bits(), "{grid:?} {tile:?} south, column {i}");
        }
    }
}

#[test]
fn levels_agree_bit_for_bit_on_shared_points() {
    let (worlds, n) = (worlds(), 257);
    for (which, grid, tile) in places(200) {
        if affordable(&worlds[which], grid, tile, Filter::Exact) == Filter::Band {
            continue;
        }
        let parent = vertices(&worlds[which], grid, tile, n, Filter::Exact);
        for (down, right) in [(tile.x & 1, tile.y & 1)] {
            let child = vertices(&worlds[which], grid, Tile { z: tile.z + 1, x: 2 * tile.x + right, y: 2 * tile.y + down }, n, Filter::Exact);
            let (row, column) = (down as usize * 128, right as usize * 128);
            for i in 0..=128 {
                for j in 0..=128 {
                    let (parent, child) = (parent[(row + i) * n + column + j], child[2 * i * n + 2 * j]);
                    assert_eq!(parent.to_bits(), child.to_bits(), "{grid:?} {tile:?} at {i} {j}");
                }
            }
        }
    }
}

#[test]
fn edges_of_all_tilesets_are_alike_at_pixel_centres() {
    // Hillshade of one 512-pixel tile and of its four 256-pixel quarters one level deeper are samples of the same lattice: they must be equal, edges included.
    let world = &worlds()[0];
    let shade = |z, x, y, side| {
        let request = TileRequest {
            grid: Grid::Web,
            tile: Tile { z, x, y },
            samples: Samples::Centres(side),
            filter: Filter::Band,
            tileset: Tileset::Hillshade,
            height: Height::Ground,
            options: Options::default(),
        };
        image::load_from_memory(&render(world, &request).unwrap()).unwrap().into_luma8()
    };
    let whole = shade(9, 255, 255, 512);
    for (right, down) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let quarter = shade(10, 510 + i64::from(right), 510 + i64::from(down), 256);
        for (column, row, grey) in quarter.enumerate_pixels() {
            assert_eq!(grey, whole.get_pixel(right * 256 + column, down * 256 + row), "at {column} {row} of quarter {right} {down}");
        }
    }
}

#[tokio::test]
async fn threads_and_order_do_not_change_a_byte() {
    let mut paths: Vec<_> = [
        "alps/web/terrarium/9/260/251.png",
        "eq2/metric/r32/13/-1/2@257.bin",
        "mesas/web/hillshade/10/511/510@2x.png",
        "dunes/web/terrain-rgb/12/2048/2047.png",
        "hills/metric/r32/9/5/5.bin?filter=exact",
        "archipelago-endless/web/relief/11/1025/1022.png",
        "ridges-rivers-and-lakes/metric/water/12/0/-1.png",
        "ridges-and-rivers/metric/materials/13/1/0@2x.png",
    ]
    .map(|path| format!("/worlds/{path}"))
    .to_vec();
    let first = Client::with(|config| config.server.threads = 1).await;
    let mut want = Vec::new();
    for path in &paths {
        want.push(first.get(path).await.body);
    }
    for threads in [1, 2, 7] {
        paths.reverse();
        want.reverse();
        let client = Client::with(|config| config.server.threads = threads).await;
        let answers = futures_util::future::join_all(paths.iter().map(|path| client.get(path))).await;
        for ((path, answer), want) in paths.iter().zip(answers).zip(&want) {
            assert_eq!(&answer.body, want, "{path} with {threads} threads");
        }
    }
}
