//! What tiles of heights take as pictures: nanoseconds a sample to encode and bytes of a tile of 512 × 512 samples, by tileset, packing and rounding, beside the
//! usual settings of the `png` crate for the same pixels. Medians of the rounds, over three tiles of an example world with much detail.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark says what is wrong by failing, and prints what it measured")]

use std::time::Instant;
use terrane::{
    geometry::{Filter, Grid, Samples, Source, Surface, Tile, Wanted},
    tile::{Height, Image, Options, Rounding, TileRequest, Tileset},
    world::{Document, EXAMPLES, World},
};

const ROUNDS: usize = 21;
const SIDE: usize = 512;
const WORLD: &str = "alps";
const LEVELS: [u8; 3] = [9, 12, 15];

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Nanoseconds a sample and kilobytes of what is encoded.
fn measure(encode: impl Fn() -> Vec<u8>) -> String {
    let mut length = 0;
    let rounds = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        length = encode().len();
        start.elapsed().as_secs_f64() * 1e9 / (SIDE * SIDE) as f64
    });
    let time = median(rounds.collect());
    format!("{time:6.1} ns {:6.0} kB", length as f64 / 1e3)
}

/// The pixels of a picture, packed as the `png` crate does unless it is told otherwise.
fn usual(picture: &[u8]) -> String {
    let pixels = image::load_from_memory(picture).unwrap().into_rgb8().into_raw();
    measure(|| {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, SIDE as u32, SIDE as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
        out
    })
}

fn main() {
    let example = EXAMPLES.iter().find(|example| example.name == WORLD).unwrap();
    let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
    for z in LEVELS {
        let middle = 1_i64 << (z - 1);
        let request = TileRequest {
            grid: Grid::Web,
            tile: Tile { z, x: middle + 1, y: middle - 2 },
            samples: Samples::Centres(SIDE),
            filter: Filter::Band,
            tileset: Tileset::Terrarium,
            height: Height::Ground,
            options: Options::default(),
        };
        let window = request.window().unwrap();
        let mut surface = Surface::with(&window, Wanted::default());
        world.sample(&window, &mut surface);
        println!("{WORLD}, level {z}, {SIDE} × {SIDE} samples {:.1} m apart", window.spacing());
        for tileset in [Tileset::Terrarium, Tileset::TerrainRgb, Tileset::Fit, Tileset::Height16, Tileset::R16, Tileset::R32] {
            let encode =
                |image, rounding| tileset.encode(&surface, window.spacing(), &world.legend(), Options { image, rounding, ..Options::default() }).unwrap();
            println!("{:12} plain  {}", tileset.name(), measure(|| encode(Image::Png, Rounding::Steps)));
            if !tileset.has_webp() {
                continue;
            }
            println!("{:12} WebP   {}", "", measure(|| encode(Image::Webp, Rounding::Steps)));
            if tileset.has_rounding() {
                println!("{:12} plain  {}, rounded", "", measure(|| encode(Image::Png, Rounding::Spacing)));
                println!("{:12} WebP   {}, rounded", "", measure(|| encode(Image::Webp, Rounding::Spacing)));
                println!("{:12} png    {}, as the crate does", "", usual(&encode(Image::Png, Rounding::Steps)));
            }
        }
    }
}
