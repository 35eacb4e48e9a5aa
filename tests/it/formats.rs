//! Formats of heights: what they hold, what their sidecars and descriptions say of them, and that neighbours agree.

use crate::client::Client;
use axum::http::StatusCode;
use serde_json::json;
use terrane::{
    geometry::{Filter, Grid, Samples, Tile},
    tile::{ByteOrder, Height, Image, Options, RowOrder, Steps, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};
use zune_png::{
    PngDecoder,
    zune_core::{bytestream::ZCursor, result::DecodingResult},
};

fn world(name: &str) -> World {
    let example = EXAMPLES.iter().find(|example| example.name == name).unwrap();
    World::new(Document::parse(example.json.as_bytes()).unwrap())
}

fn request(grid: Grid, tile: Tile, samples: Samples, tileset: Tileset) -> TileRequest {
    TileRequest { grid, tile, samples, filter: Filter::Band, tileset, height: Height::Ground, options: Options::default() }
}

fn metres(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

fn numbers(bytes: &[u8]) -> Vec<u16> {
    bytes.chunks_exact(2).map(|bytes| u16::from_le_bytes(bytes.try_into().unwrap())).collect()
}

#[test]
fn heights_over_the_range_come_back_within_half_a_step() {
    for name in ["alps", "dunes", "archipelago"] {
        let world = world(name);
        let range = [world.document().elevation.min, world.document().elevation.max];
        for (grid, tile) in
            [(Grid::Web, Tile { z: 9, x: 257, y: 254 }), (Grid::Geo, Tile { z: 9, x: 514, y: 254 }), (Grid::Metric, Tile { z: 12, x: 3, y: -2 })]
        {
            let of = |tileset| render(&world, &request(grid, tile, Samples::Vertices(257), tileset)).unwrap();
            let want = metres(&of(Tileset::R32));
            let step = (range[1] - range[0]) / 65_535.0;
            let sixteen = numbers(&of(Tileset::R16));
            for (number, want) in sixteen.iter().zip(&want) {
                let got = range[0] + f64::from(*number) * step;
                assert!((got - f64::from(*want)).abs() <= step * 0.500_001, "{name}: {got} is not {want}");
            }
            let DecodingResult::U16(picture) = PngDecoder::new(ZCursor::new(of(Tileset::Height16))).decode().unwrap() else { panic!("not 16 bits") };
            assert_eq!(picture, sixteen, "the picture holds the same numbers");
            let step = (range[1] - range[0]) / 16_777_215.0;
            let pixels = PngDecoder::new(ZCursor::new(of(Tileset::Fit))).decode_raw().unwrap();
            for (pixel, want) in pixels.chunks_exact(3).zip(&want) {
                let number = f64::from(pixel[0]) * 65_536.0 + f64::from(pixel[1]) * 256.0 + f64::from(pixel[2]);
                assert!((range[0] + number * step - f64::from(*want)).abs() <= step * 0.500_001, "{name}");
            }
        }
    }
}

/// What engines ask for: 2^n + 1 samples a side, whose outermost are the neighbours' too.
#[test]
fn vertex_tiles_of_engines_share_their_edges_to_the_bit() {
    let world = world("ridges-and-rivers");
    for (side, z) in [(257, 14), (513, 12), (1025, 11)] {
        for tileset in [Tileset::R16, Tileset::R32] {
            let of = |x, y| render(&world, &request(Grid::Metric, Tile { z, x, y }, Samples::Vertices(side), tileset)).unwrap();
            let size = if tileset == Tileset::R16 { 2 } else { 4 };
            let (here, east, south) = (of(0, -1), of(1, -1), of(0, 0));
            assert_eq!(here.len(), side * side * size);
            assert_eq!(here[(side - 1) * side * size..], south[..side * size], "{tileset:?} {side}: south");
            for row in 0..side {
                let at = |column: usize| (row * side + column) * size..(row * side + column + 1) * size;
                assert_eq!(here[at(side - 1)], east[at(0)], "{tileset:?} {side}: east, row {row}");
            }
        }
    }
}

/// Slopes and normals at the edge come from samples beyond it, which are the neighbour's own.
#[test]
fn slopes_and_normals_of_neighbours_agree_on_their_edge() {
    let world = world("ridges-rivers-and-lakes");
    for (tileset, channels) in [(Tileset::Slope, 1), (Tileset::Normals, 3), (Tileset::Hillshade, 1)] {
        for (grid, tile) in
            [(Grid::Metric, Tile { z: 15, x: 3, y: -2 }), (Grid::Web, Tile { z: 12, x: 2050, y: 2040 }), (Grid::Geo, Tile { z: 11, x: 2050, y: 1020 })]
        {
            let of = |x, y| {
                let bytes = render(&world, &request(grid, Tile { z: tile.z, x, y }, Samples::Vertices(129), tileset)).unwrap();
                PngDecoder::new(ZCursor::new(bytes)).decode_raw().unwrap()
            };
            let (here, east, south) = (of(tile.x, tile.y), of(tile.x + 1, tile.y), of(tile.x, tile.y + 1));
            assert_eq!(here.len(), 129 * 129 * channels);
            assert_eq!(here[128 * 129 * channels..], south[..129 * channels], "{tileset:?} south");
            for row in 0..129 {
                let at = |column: usize| (row * 129 + column) * channels..(row * 129 + column + 1) * channels;
                assert_eq!(here[at(128)], east[at(0)], "{tileset:?} east, row {row}");
            }
        }
    }
}

#[test]
fn webp_holds_the_pixels_of_png() {
    let world = world("ridges-rivers-and-lakes");
    for tileset in Tileset::ALL.into_iter().filter(|tileset| tileset.has_webp()) {
        let png = request(Grid::Web, Tile { z: 11, x: 1024, y: 1023 }, Samples::Centres(256), tileset);
        let webp = TileRequest { options: Options { image: Image::Webp, ..Options::default() }, ..png };
        let mut decoder = PngDecoder::new(ZCursor::new(render(&world, &png).unwrap()));
        let want = decoder.decode_raw().unwrap();
        let channels = decoder.colorspace().unwrap().num_components();
        let bytes = render(&world, &webp).unwrap();
        let mut decoder = image_webp::WebPDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
        assert_eq!((decoder.dimensions(), decoder.is_lossy(), decoder.has_alpha()), ((256, 256), false, channels == 4), "{tileset:?}");
        let mut got = vec![0; decoder.output_buffer_size().unwrap()];
        decoder.read_image(&mut got).unwrap();
        let step = if channels == 4 { 4 } else { 3 };
        for (got, want) in got.chunks_exact(step).zip(want.chunks_exact(channels)) {
            assert!((0..step).all(|i| got[i] == want[i.min(channels - 1)]), "{tileset:?}: {got:?} is not {want:?}");
        }
    }
}

#[test]
fn bytes_and_rows_come_in_the_order_asked_for() {
    let world = world("hills");
    let of = |tileset, order, rows| {
        let plain = request(Grid::Metric, Tile { z: 16, x: 1, y: 1 }, Samples::Vertices(33), tileset);
        render(&world, &TileRequest { options: Options { order, rows, ..Options::default() }, ..plain }).unwrap()
    };
    for (tileset, size) in [(Tileset::R16, 2), (Tileset::R32, 4)] {
        let mut swapped = of(tileset, ByteOrder::Big, RowOrder::South);
        swapped.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        let flipped: Vec<u8> = swapped.chunks_exact(33 * size).rev().flatten().copied().collect();
        assert_eq!(flipped, of(tileset, ByteOrder::Little, RowOrder::North));
        assert_ne!(flipped, swapped);
    }
}

#[tokio::test]
async fn sidecars_say_what_samples_mean() {
    let client = Client::new().await;
    let document = client.get("/worlds/alps").await.json();
    let range = ["min", "max"].map(|end| document["elevation"][end].as_f64().unwrap());
    let sidecar = client.get("/worlds/alps/metric/r16/17/4/-3@257.json?order=be").await;
    assert_eq!((sidecar.status, sidecar.header("content-type"), client.app.evaluations()), (StatusCode::OK, "application/json", 0));
    let steps = Steps::of_16_bits(range);
    let want = json!({
        "file": "-3@257.bin", "type": "uint16", "byte_order": "big", "columns": 257, "rows": 257, "first_row": "north", "registration": "vertices",
        "spacing": 1.0, "samples": [1024.0, 512.0, 1280.0, 768.0], "minimum": range[0], "maximum": range[1], "step": steps.metres(),
    });
    assert_eq!(sidecar.json(), want);
    let floats = client.get("/worlds/alps/web/r32/9/257/254.json?rows=south").await.json();
    let of = |key: &str| floats[key].clone();
    assert_eq!((of("type"), of("byte_order"), of("first_row")), (json!("float32"), json!("little"), json!("south")));
    assert_eq!((of("registration"), of("columns"), of("step")), (json!("centres"), json!(256), json!(null)));
    assert_eq!(client.get("/worlds/alps/web/height16/9/257/254.json").await.json()["byte_order"], "big", "as PNG has it");
    let tile = client.get("/worlds/alps/metric/r16/17/4/-3@257.bin?order=be").await;
    assert_eq!((tile.header("content-type"), tile.body.len()), ("application/octet-stream", 257 * 257 * 2));
}

#[tokio::test]
async fn fit_tells_maplibre_its_factors() {
    let client = Client::new().await;
    let tilejson = client.get("/worlds/alps/web/fit?format=webp").await.json();
    let style = client.get("/worlds/alps/style.json?heights=fit&format=webp").await.json();
    for source in [&tilejson, &style["sources"]["terrain"], &style["sources"]["hillshade"]] {
        assert_eq!((&source["encoding"], &source["tileSize"]), (&json!("custom"), &json!(512)));
        assert!(source["tiles"][0].as_str().unwrap().ends_with("/web/fit/{z}/{x}/{y}@2x.webp"));
        let factor = |key: &str| source[key].as_f64().unwrap();
        let path = source["tiles"][0].as_str().unwrap().strip_prefix("http://localhost:8080").unwrap();
        let tile = client.get(&path.replace("{z}", "11").replace("{x}", "1024").replace("{y}", "1023")).await;
        assert_eq!((tile.status, tile.header("content-type")), (StatusCode::OK, "image/webp"));
        let mut pixels = vec![0; 512 * 512 * 3];
        image_webp::WebPDecoder::new(std::io::Cursor::new(&tile.body[..])).unwrap().read_image(&mut pixels).unwrap();
        let heights = metres(&client.get("/worlds/alps/web/r32/11/1024/1023@2x.bin").await.body);
        for (pixel, height) in pixels.chunks_exact(3).zip(heights) {
            let [red, green, blue] = [0, 1, 2].map(|i| f64::from(pixel[i]));
            let got = red * factor("redFactor") + green * factor("greenFactor") + blue * factor("blueFactor") - factor("baseShift");
            assert!((got - f64::from(height)).abs() < 0.001, "{got} is not {height}");
        }
    }
    let plain = client.get("/worlds/alps/web/terrarium").await.json();
    assert!(plain.get("redFactor").is_none() && plain.get("elevation").is_none());
    assert_eq!(client.get("/worlds/alps/geo/r16").await.json()["elevation"], tilejson["elevation"]);
}

#[tokio::test]
async fn rounded_heights_take_fewer_bytes_and_are_as_near_as_the_spacing_justifies() {
    let client = Client::new().await;
    for (tileset, step) in [("terrarium", 1.0 / 256.0), ("terrain-rgb", 0.1)] {
        let style = client.get(&format!("/worlds/alps/style.json?heights={tileset}&rounding=spacing")).await.json();
        let template = client.get(&format!("/worlds/alps/web/{tileset}?rounding=spacing")).await.json()["tiles"][0].as_str().unwrap().to_owned();
        assert!(template.contains("@2x.png?rounding=spacing") && style["sources"]["terrain"]["tiles"][0] == template, "{template}");
        assert!(!style["sources"]["contours"]["tiles"][0].as_str().unwrap().contains("rounding"));
        for z in [8, 10, 12] {
            let path = |query: &str| format!("/worlds/alps/web/{tileset}/{z}/{0}/{0}.png{query}", 1 << (z - 1));
            let [exact, rounded] = [client.get(&path("")).await, client.get(&path("?rounding=spacing")).await];
            let numbers = |body: &[u8]| -> Vec<u32> {
                let image = image::load_from_memory(body).unwrap().into_rgb8();
                image.pixels().map(|pixel| u32::from_be_bytes([0, pixel[0], pixel[1], pixel[2]])).collect()
            };
            let coarse = 156_543.03 / f64::from(1 << z) / 64.0;
            let bits = (coarse.min(16.0) / step).log2().floor() as u32;
            for (was, is) in numbers(&exact.body).into_iter().zip(numbers(&rounded.body)) {
                assert!(is % (1 << bits) == 0 && is.abs_diff(was) <= 1 << (bits - 1), "{was} became {is} at level {z}");
            }
            // Steps of a tenth of a metre have no digits that a power of two of them would leave out.
            let most = if tileset == "terrarium" { 9 } else { 10 };
            assert!(rounded.body.len() * 10 <= exact.body.len() * most, "{tileset} at level {z}: {} of {} bytes", rounded.body.len(), exact.body.len());
        }
    }
}

#[tokio::test]
async fn wrong_formats_are_told_what_would_be_right() {
    let client = Client::new().await;
    for (path, expected) in [
        ("/worlds/alps/web/terrarium/1/0/0.bin", "404 y: tiles of terrarium end in .png or .webp, got \"0.bin\""),
        ("/worlds/alps/web/r16/1/0/0.png", "404 y: tiles of r16 end in .bin or .json, got \"0.png\""),
        ("/worlds/alps/web/height16/1/0/0.webp", "404 y: tiles of height16 end in .png or .json, got \"0.webp\""),
        ("/worlds/alps/web/contours/1/0/0.webp", "404 y: tiles of contours end in .mvt, got \"0.webp\""),
        ("/worlds/alps/web/terrarium/1/0/0.json", "404 y: tiles of terrarium end in .png or .webp, got \"0.json\""),
        ("/worlds/alps/web/terrarium/1/0/0.png?order=be", "400 order: terrarium has an order of bytes of its own: leave it out"),
        ("/worlds/alps/web/terrarium/1/0/0.png?rows=south", "400 rows: rows of terrarium run from the north: leave it out"),
        ("/worlds/alps/web/r16/1/0/0.bin?order=middle", "400 order: must be le or be, got \"middle\""),
        ("/worlds/alps/web/r16/1/0/0.bin?rounding=spacing", "400 rounding: r16 is not rounded: leave it out"),
        ("/worlds/alps/web/terrarium?rounding=2", "400 rounding: must be steps or spacing, got \"2\""),
        ("/worlds/alps/web/r16?format=webp", "400 format: r16 is no WebP: leave it out"),
        ("/worlds/alps/style.json?heights=r16", "400 heights: must be terrarium, terrain-rgb or fit, got \"r16\""),
    ] {
        assert_eq!(client.get(path).await.problem(), expected, "{path}");
    }
    assert_eq!(client.app.evaluations(), 0);
}
