//! Meshes decoded by a reader of their own, which shares nothing with what writes them.

use crate::client::Client;
use axum::http::{Method, StatusCode};
use serde_json::json;
use std::collections::BTreeMap;
use terrane::{
    geometry::{DEGREE, Filter, Grid, Samples, Source, Tile, to_lon_lat},
    tile::{Height, MeshExtensions, Options, TileRequest, Tileset, mesh_step, mesh_tolerance, render},
    world::{Document, EXAMPLES, World},
};

const ALL: MeshExtensions = MeshExtensions { normals: true, water_mask: true, metadata: true };

/// A decoded mesh.
struct Decoded {
    centre: [f64; 3],
    heights: [f32; 2],
    sphere: [f64; 4],
    /// u, v and height in metres.
    vertices: Vec<(u16, u16, f64)>,
    triangles: Vec<[usize; 3]>,
    /// West, south, east, north.
    edges: [Vec<usize>; 4],
    extensions: BTreeMap<u8, Vec<u8>>,
    has_long_indices: bool,
}

struct Reader<'a>(&'a [u8], usize);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let bytes = self.0[self.1..self.1 + N].try_into().unwrap();
        self.1 += N;
        bytes
    }

    fn double(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn count(&mut self) -> usize {
        u32::from_le_bytes(self.take()) as usize
    }

    fn deltas(&mut self, count: usize) -> Vec<u16> {
        let mut value = 0_i32;
        let next = |_| {
            let code = i32::from(u16::from_le_bytes(self.take()));
            value += (code >> 1) ^ -(code & 1);
            u16::try_from(value).unwrap()
        };
        (0..count).map(next).collect()
    }

    fn index(&mut self, long: bool) -> usize {
        if long { u32::from_le_bytes(self.take()) as usize } else { u16::from_le_bytes(self.take()).into() }
    }
}

/// As the specification says: CesiumGS/quantized-mesh, README.md.
fn decode(bytes: &[u8]) -> Decoded {
    let mut read = Reader(bytes, 0);
    let centre = [0; 3].map(|_| read.double());
    let heights = [0; 2].map(|_| f32::from_le_bytes(read.take()));
    let sphere = [0; 4].map(|_| read.double());
    let _occlusion = [0; 3].map(|_| read.double());
    let count = read.count();
    let (u, v, h) = (read.deltas(count), read.deltas(count), read.deltas(count));
    let (low, high) = (f64::from(heights[0]), f64::from(heights[1]));
    let vertices: Vec<_> = (0..count).map(|i| (u[i], v[i], low + f64::from(h[i]) / 32_767.0 * (high - low))).collect();
    let long = count > 65_536;
    read.1 = read.1.next_multiple_of(if long { 4 } else { 2 });
    let mut highest = 0;
    let triangles = (0..read.count()).map(|_| {
        [0; 3].map(|_| {
            let code = read.index(long);
            let index = highest - code;
            highest += usize::from(code == 0);
            index
        })
    });
    let triangles = triangles.collect::<Vec<_>>();
    assert_eq!(highest, count, "every vertex is used, in order");
    let edges = [0; 4].map(|_| (0..read.count()).map(|_| read.index(long)).collect());
    let mut extensions = BTreeMap::new();
    while read.1 < bytes.len() {
        let [number] = read.take();
        let length = read.count();
        extensions.insert(number, bytes[read.1..read.1 + length].to_vec());
        read.1 += length;
    }
    Decoded { centre, heights, sphere, vertices, triangles, edges, extensions, has_long_indices: long }
}

fn world(name: &str) -> World {
    let example = EXAMPLES.iter().find(|example| example.name == name).unwrap();
    World::new(Document::parse(example.json.as_bytes()).unwrap())
}

fn request(grid: Grid, tile: Tile, side: usize) -> TileRequest {
    let options = Options { mesh: ALL, ..Options::default() };
    TileRequest { grid, tile, samples: Samples::Vertices(side), filter: Filter::Band, tileset: Tileset::QuantizedMesh, height: Height::Ground, options }
}

fn mesh(world: &World, grid: Grid, tile: Tile, side: usize) -> Decoded {
    decode(&render(world, &request(grid, tile, side)).unwrap())
}

/// Place along an edge, bits of the height, and bytes of the normal of its vertices, which must all lie on it.
fn edge(mesh: &Decoded, which: usize) -> Vec<(u16, u64, [u8; 2])> {
    let on = |vertex: &usize| {
        let (u, v, height) = mesh.vertices[*vertex];
        let (fixed, along) = if which.is_multiple_of(2) { (u, v) } else { (v, u) };
        assert_eq!(fixed, if which < 2 { 0 } else { 32_767 }, "edge {which}");
        (along, height.to_bits(), mesh.extensions[&1][2 * vertex..][..2].try_into().unwrap())
    };
    let mut found: Vec<_> = mesh.edges[which].iter().map(on).collect();
    found.sort_unstable();
    let expected = mesh.vertices.iter().filter(|(u, v, _)| (if which.is_multiple_of(2) { *u } else { *v }) == if which < 2 { 0 } else { 32_767 }).count();
    assert_eq!(found.len(), expected, "edge {which} lists all of its vertices");
    found
}

fn places() -> Vec<(Grid, Tile, usize)> {
    vec![
        (Grid::Geo, Tile { z: 2, x: 3, y: 1 }, 65),
        (Grid::Geo, Tile { z: 9, x: 513, y: 255 }, 65),
        (Grid::Geo, Tile { z: 13, x: 8200, y: 4090 }, 129),
        (Grid::Geo, Tile { z: 20, x: 1_048_600, y: 524_280 }, 65),
        (Grid::Web, Tile { z: 3, x: 3, y: 1 }, 65),
        (Grid::Web, Tile { z: 11, x: 1025, y: 1020 }, 65),
        (Grid::Web, Tile { z: 17, x: 65_540, y: 65_530 }, 33),
    ]
}

#[test]
fn edges_and_their_normals_are_the_neighbours_to_the_bit() {
    for name in ["alps", "mesas", "ridges-rivers-and-lakes"] {
        let world = world(name);
        for (grid, tile, side) in places() {
            let Tile { z, x, y } = tile;
            let here = mesh(&world, grid, tile, side);
            for (own, other, x, y) in [(0, 2, x - 1, y), (1, 3, x, y + 1), (2, 0, x + 1, y), (3, 1, x, y - 1)] {
                let there = mesh(&world, grid, Tile { z, x, y }, side);
                assert_eq!(edge(&here, own), edge(&there, other), "{name} {} {tile:?} edge {own}", grid.name());
            }
        }
    }
}

fn area([a, b, c]: [(f64, f64); 3]) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// Every sample lies in a triangle that stays within the tolerance and the rounding of heights of it; together the triangles cover the tile once.
#[test]
fn no_sample_is_missed_by_more_than_is_stated() {
    for name in ["alps", "mesas", "ridges-rivers-and-lakes"] {
        let world = world(name);
        for (grid, tile, side) in places() {
            let mesh = mesh(&world, grid, tile, side);
            let bound = mesh_tolerance(grid, tile.z) + mesh_step(&world.legend(), Height::Ground) / 2.0;
            let window = grid.window(tile, Samples::Vertices(side), Filter::Band).unwrap();
            let ground = world.evaluate(&window);
            let latitude = |y: f64| if grid == Grid::Geo { y / DEGREE } else { to_lon_lat(0.0, y).1 };
            let latitudes: Vec<f64> = window.rows.coordinates().map(latitude).collect();
            let (north, south) = (latitudes[0], latitudes[side - 1]);
            let v = |row: usize| ((latitudes[row] - south) / (north - south) * 32_767.0).round();
            let u = |column: usize| (column as f64 / (side - 1) as f64 * 32_767.0).round();
            let (mut covered, mut total) = (vec![false; side * side], 0.0);
            for triangle in &mesh.triangles {
                let corners = triangle.map(|i| (f64::from(mesh.vertices[i].0), f64::from(mesh.vertices[i].1)));
                let heights = triangle.map(|i| mesh.vertices[i].2);
                let whole = area(corners);
                assert!(whole > 0.0, "counter-clockwise");
                total += whole;
                for row in 0..side {
                    for column in 0..side {
                        let [a, b, c] = corners;
                        let p = (u(column), v(row));
                        let weights = [area([p, b, c]), area([a, p, c]), area([a, b, p])];
                        if weights.iter().all(|&weight| weight >= 0.0) {
                            covered[row * side + column] = true;
                            let height: f64 = weights.iter().zip(heights).map(|(weight, height)| weight / whole * height).sum();
                            let missed = (height - f64::from(ground.at(row, column))).abs();
                            assert!(missed <= bound + 1e-6, "{name} {} {tile:?}: {missed} is more than {bound}", grid.name());
                        }
                    }
                }
            }
            assert_eq!((total, covered.iter().all(|&covered| covered)), (2.0 * 32_767.0 * 32_767.0, true));
            assert!(mesh.vertices.len() < side * side, "{name} {tile:?}: {} vertices", mesh.vertices.len());
        }
    }
}

/// By the textbook, with the platform's functions.
fn place(longitude: f64, latitude: f64, height: f64) -> [f64; 3] {
    let (a, f) = (6_378_137.0, 1.0 / 298.257_223_563);
    let e2 = f * (2.0 - f);
    let (lon, lat) = (longitude.to_radians(), latitude.to_radians());
    let n = a / (1.0 - e2 * lat.sin().powi(2)).sqrt();
    [(n + height) * lat.cos() * lon.cos(), (n + height) * lat.cos() * lon.sin(), (n * (1.0 - e2) + height) * lat.sin()]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn normal(bytes: &[u8]) -> [f64; 3] {
    let [u, v] = [bytes[0], bytes[1]].map(|byte| f64::from(byte) / 255.0 * 2.0 - 1.0);
    let z = 1.0 - u.abs() - v.abs();
    let (x, y) = if z < 0.0 { ((1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)) } else { (u, v) };
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[test]
fn the_sphere_holds_all_vertices_and_normals_point_outward() {
    let world = world("alps");
    for (grid, tile, side) in places() {
        let mesh = mesh(&world, grid, tile, side);
        let window = grid.window(tile, Samples::Vertices(2), Filter::Band).unwrap();
        let degrees = |x: f64, y: f64| if grid == Grid::Geo { (x / DEGREE, y / DEGREE) } else { to_lon_lat(x, y) };
        let (west, north) = degrees(window.columns.coordinate(0), window.rows.coordinate(0));
        let (east, south) = degrees(window.columns.coordinate(1), window.rows.coordinate(1));
        let [x, y, z, radius] = mesh.sphere;
        assert_eq!(mesh.centre, [x, y, z]);
        let mut farthest = 0.0_f64;
        for (i, &(u, v, height)) in mesh.vertices.iter().enumerate() {
            assert!((f64::from(mesh.heights[0])..=f64::from(mesh.heights[1])).contains(&height));
            let at = place(west + (east - west) * f64::from(u) / 32_767.0, south + (north - south) * f64::from(v) / 32_767.0, height);
            farthest = farthest.max(distance(at, mesh.centre));
            let normal = normal(&mesh.extensions[&1][2 * i..]);
            let length = distance(at, [0.0; 3]);
            let up: f64 = (0..3).map(|axis| normal[axis] * at[axis] / length).sum();
            assert!(up > 0.0, "{} {tile:?}: {normal:?} at {at:?}", grid.name());
        }
        assert!((radius - farthest).abs() < 1e-6 * radius.max(1.0), "{} {tile:?}: {radius} is not {farthest}", grid.name());
    }
}

/// Normals are those of the ground: a plane that rises to the east by 1 m for 2 m.
#[test]
fn normals_are_those_of_a_known_slope() {
    let json = r#"{"seed":1,"elevation":{"min":-10000,"max":10000},"base":{"programme":"x","scale":2,"amplitude":1}}"#;
    let world = World::new(Document::parse(json.as_bytes()).unwrap());
    let mesh = mesh(&world, Grid::Geo, Tile { z: 14, x: 16_384, y: 8_191 }, 65);
    // At longitude 0, latitude 0 the axes are up, east and north.
    let want = [2.0 / 5.0_f64.sqrt(), -1.0 / 5.0_f64.sqrt(), 0.0];
    for bytes in mesh.extensions[&1].chunks_exact(2) {
        assert!(distance(normal(bytes), want) < 0.02, "{:?}", normal(bytes));
    }
}

#[test]
fn water_and_what_lies_below_are_said_when_asked() {
    let world = world("archipelago");
    let with = |tile| mesh(&world, Grid::Web, tile, 65);
    let shore = with(Tile { z: 9, x: 257, y: 254 });
    let mask = &shore.extensions[&2];
    assert_eq!(mask.len(), 256 * 256);
    // Near the equator rows of latitude and of the plane are the same: the ground of their middles tells.
    let window = Grid::Web.window(Tile { z: 9, x: 257, y: 254 }, Samples::Centres(256), Filter::Band).unwrap();
    let ground = world.evaluate(&window).elevation;
    let agree = mask.iter().zip(&ground).filter(|&(&mask, &ground)| (mask > 127) == (ground < 0.0)).count();
    assert!(agree > 65_000, "{agree}");
    let json: serde_json::Value = serde_json::from_slice(&shore.extensions[&4][4..]).unwrap();
    // Row 254 of 512 from the north is row 257 from the south.
    assert_eq!(json["available"][0], json!([{"startX": 514, "startY": 514, "endX": 515, "endY": 515}]));
    let none = Options::default();
    let plain = decode(&render(&world, &TileRequest { options: none, ..request(Grid::Web, Tile { z: 9, x: 257, y: 254 }, 65) }).unwrap());
    assert!(plain.extensions.is_empty());
    let json = r#"{"seed":1,"base":{"programme":"x","scale":1,"amplitude":0,"datum":5}}"#;
    let dry = mesh(&World::new(Document::parse(json.as_bytes()).unwrap()), Grid::Geo, Tile { z: 5, x: 3, y: 9 }, 65);
    assert_eq!(dry.extensions[&2], [0], "one byte tells that all is land");
}

/// Cliffs everywhere: 66,049 samples of which none can be left out.
#[test]
fn many_vertices_have_long_indices() {
    let json = r#"{"seed":1,"elevation":{"min":-9000,"max":9000},"base":{"programme":"o_perlin","scale":0.7,"amplitude":9000}}"#;
    let world = World::new(Document::parse(json.as_bytes()).unwrap());
    let request = TileRequest { filter: Filter::Exact, ..request(Grid::Geo, Tile { z: 18, x: 300_000, y: 100_000 }, 257) };
    let mesh = decode(&render(&world, &request).unwrap());
    assert!(mesh.has_long_indices, "{} vertices", mesh.vertices.len());
    assert!(mesh.vertices.len() > 65_536 && mesh.triangles.len() > 130_000);
}

#[tokio::test]
async fn cesium_finds_meshes_through_layer_json() {
    let client = Client::new().await;
    for (grid, projection, columns) in [("geo", "EPSG:4326", 2), ("web", "EPSG:3857", 1)] {
        let layer = client.get(&format!("/worlds/alps/{grid}/quantized-mesh/layer.json")).await.json();
        assert_eq!((&layer["format"], &layer["scheme"], &layer["projection"]), (&json!("quantized-mesh-1.0"), &json!("tms"), &json!(projection)));
        assert_eq!(layer["extensions"], json!(["octvertexnormals", "watermask"]));
        let available = layer["available"].as_array().unwrap();
        assert_eq!(available.len(), 25);
        assert_eq!(available[3], json!([{"startX": 0, "startY": 0, "endX": 8 * columns - 1, "endY": 7}]));
        let template = layer["tiles"][0].as_str().unwrap().strip_prefix("http://localhost:8080").unwrap();
        let path = template.replace("{z}", "3").replace("{x}", "4").replace("{y}", "5");
        let plain = client.get(&path).await;
        assert_eq!((plain.status, plain.header("content-type")), (StatusCode::OK, "application/vnd.quantized-mesh"));
        assert_eq!(plain.header("cache-control"), "public, max-age=31536000, immutable");
        let world = world("alps");
        let grid = Grid::from_name(grid).unwrap();
        let from_the_north = TileRequest { options: Options::default(), ..request(grid, Tile { z: 3, x: 4, y: 2 }, 65) };
        assert_eq!(plain.body, render(&world, &from_the_north).unwrap(), "row 5 of 8 from the south is row 2 from the north");
    }
}

#[tokio::test]
async fn extensions_come_through_accept_and_through_the_query() {
    let client = Client::new().await;
    let path = "/worlds/archipelago/geo/quantized-mesh/9/514/257.terrain";
    let cesium = "application/vnd.quantized-mesh;extensions=octvertexnormals-watermask-metadata,application/octet-stream;q=0.9,*/*;q=0.01";
    let accepted = client.send(Method::GET, path, &[("accept", cesium)], "").await;
    let asked = client.get(&format!("{path}?extensions=octvertexnormals-watermask-metadata")).await;
    let want = "application/vnd.quantized-mesh;extensions=octvertexnormals-watermask-metadata";
    assert_eq!((accepted.header("content-type"), asked.header("content-type")), (want, want));
    assert_eq!((accepted.header("etag"), &accepted.body), (asked.header("etag"), &asked.body));
    assert!(accepted.headers.get_all("vary").iter().any(|vary| vary == "accept"));
    assert_eq!(decode(&asked.body).extensions.keys().copied().collect::<Vec<_>>(), [1, 2, 4]);
    let one = client.get(&format!("{path}?extensions=octvertexnormals-unknown")).await;
    assert_eq!(decode(&one.body).extensions.keys().copied().collect::<Vec<_>>(), [1]);
    assert_ne!(one.header("etag"), asked.header("etag"));
}

#[tokio::test]
async fn wrong_meshes_are_told_what_would_be_right() {
    let client = Client::new().await;
    for (path, expected) in [
        ("/worlds/alps/metric/quantized-mesh", "404 tileset: quantized-mesh lies on the globe: the grids web, geo have it, metric does not"),
        ("/worlds/alps/metric/quantized-mesh/layer.json", "404 tileset: quantized-mesh lies on the globe: the grids web, geo have it, metric does not"),
        ("/worlds/alps/geo/quantized-mesh/1/4/0.terrain", "404 tile: meshes end with the globe: at zoom 1, x must be 0 … 3 and y, from the south, 0 … 1"),
        ("/worlds/alps/web/quantized-mesh/1/0/-1.terrain", "404 tile: meshes end with the globe: at zoom 1, x must be 0 … 1 and y, from the south, 0 … 1"),
        ("/worlds/alps/geo/quantized-mesh/1/0/0@64.terrain", "404 y: meshes are drawn from one of [17, 33, 65, 129, 257] samples a side; got 64"),
        ("/worlds/alps/geo/quantized-mesh/1/0/0.png", "404 y: tiles of quantized-mesh end in .terrain, got \"0.png\""),
        ("/worlds/alps/geo/terrarium/1/0/0.png?extensions=metadata", "400 extensions: terrarium has no extensions: leave it out"),
        ("/worlds/alps/geo/quantized-mesh/layer.json?surface=sky", "400 surface: must be ground or water, got \"sky\""),
    ] {
        assert_eq!(client.get(path).await.problem(), expected, "{path}");
    }
}
