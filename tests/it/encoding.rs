//! Tiles decoded by other libraries.

use terrane::{
    geometry::{Filter, Grid, Samples, Tile},
    tile::{Height, Options, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};
use zune_png::{
    PngDecoder,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace},
};

fn world(name: &str) -> World {
    let example = EXAMPLES.iter().find(|example| example.name == name).unwrap();
    World::new(Document::parse(example.json.as_bytes()).unwrap())
}

fn request(tileset: Tileset, samples: Samples) -> TileRequest {
    TileRequest {
        grid: Grid::Web,
        tile: Tile { z: 9, x: 257, y: 254 },
        samples,
        filter: Filter::Band,
        tileset,
        height: Height::Ground,
        options: Options::default(),
    }
}

fn elevations(world: &World, samples: Samples) -> Vec<f32> {
    render(world, &request(Tileset::R32, samples)).unwrap().chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// Decodes with `zune-png`, which shares no code with the encoder, and lists the chunks.
fn decode(bytes: &[u8]) -> (ColorSpace, (usize, usize), Vec<u8>, Vec<String>) {
    let mut decoder = PngDecoder::new(ZCursor::new(bytes));
    let pixels = decoder.decode_raw().unwrap();
    let (mut at, mut chunks) = (8, Vec::new());
    while at < bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        chunks.push(String::from_utf8(bytes[at + 4..at + 8].to_vec()).unwrap());
        at += length + 12;
    }
    chunks.dedup();
    (decoder.colorspace().unwrap(), decoder.dimensions().unwrap(), pixels, chunks)
}

#[test]
fn rgb_tiles_decode_to_the_sampled_elevation_within_half_a_step() {
    for name in ["alps", "eq2", "dunes"] {
        let world = world(name);
        for samples in [Samples::Centres(256), Samples::Centres(512), Samples::Vertices(129), Samples::Vertices(2), Samples::Vertices(505)] {
            let want = elevations(&world, samples);
            for (tileset, decode_pixel, half_step) in [
                (Tileset::Terrarium, (|r, g, b| r * 256.0 + g + b / 256.0 - 32_768.0) as fn(f64, f64, f64) -> f64, 0.5 / 256.0),
                (Tileset::TerrainRgb, |r, g, b| -10_000.0 + (r * 65_536.0 + g * 256.0 + b) * 0.1, 0.05 + 1e-9),
            ] {
                let (colour, (width, height), pixels, chunks) = decode(&render(&world, &request(tileset, samples)).unwrap());
                assert_eq!((colour, width, height), (ColorSpace::RGB, samples.side(), samples.side()));
                assert_eq!(chunks, ["IHDR", "IDAT", "IEND"], "no colour management, no transparency");
                for (pixel, &want) in pixels.chunks_exact(3).zip(&want) {
                    let got = decode_pixel(pixel[0].into(), pixel[1].into(), pixel[2].into());
                    assert!((got - f64::from(want)).abs() <= half_step, "{name} {tileset:?}: {got} is not {want}");
                }
            }
        }
    }
}

/// The ends of what both encodings hold, and beyond them what clamping leaves.
#[test]
fn the_ends_of_the_vertical_range_are_kept() {
    let json = r#"{"seed":1,"elevation":{"min":-10000,"max":32767},"base":{"programme":"x","scale":1,"amplitude":1}}"#;
    let world = World::new(Document::parse(json.as_bytes()).unwrap());
    let request = TileRequest {
        grid: Grid::Metric,
        tile: Tile { z: 8, x: -1, y: 0 },
        samples: Samples::Vertices(33),
        filter: Filter::Band,
        tileset: Tileset::Terrarium,
        height: Height::Ground,
        options: Options::default(),
    };
    for (x, tileset, first, last) in [
        (-1, Tileset::Terrarium, [88, 240, 0], [128, 0, 0]),
        (0, Tileset::Terrarium, [128, 0, 0], [255, 255, 0]),
        (-1, Tileset::TerrainRgb, [0, 0, 0], [1, 134, 160]),
        (0, Tileset::TerrainRgb, [1, 134, 160], [6, 134, 150]),
    ] {
        let (_, _, pixels, _) = decode(&render(&world, &TileRequest { tile: Tile { x, ..request.tile }, tileset, ..request }).unwrap());
        assert_eq!((&pixels[..3], &pixels[96..99]), (&first[..], &last[..]), "{tileset:?} {x}");
    }
}

#[test]
fn hillshade_is_opaque_grey_and_shows_relief() {
    let (colour, size, pixels, _) = decode(&render(&world("alps"), &request(Tileset::Hillshade, Samples::Centres(256))).unwrap());
    assert_eq!((colour, size), (ColorSpace::Luma, (256, 256)));
    let (low, high) = (pixels.iter().min().unwrap(), pixels.iter().max().unwrap());
    assert!(high - low > 100, "{low} … {high}");
}
