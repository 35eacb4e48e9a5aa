//! Tiles decoded by other libraries.

use terrane::{
    geometry::{Filter, Grid, Samples, Tile, Window},
    tile::{TileRequest, Tileset, render, write_geotiff},
    world::{Document, EXAMPLES, World},
};

fn world(name: &str) -> World {
    let example = EXAMPLES.iter().find(|example| example.name == name).unwrap();
    World::new(Document::parse(example.json.as_bytes()).unwrap())
}

fn request(tileset: Tileset, samples: Samples) -> TileRequest {
    TileRequest { grid: Grid::Web, tile: Tile { z: 9, x: 257, y: 254 }, samples, filter: Filter::Band, tileset }
}

fn elevations(world: &World, samples: Samples) -> Vec<f32> {
    render(world, &request(Tileset::R32, samples)).unwrap().chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

/// Decodes with the `png` crate, whatever wrote it, and lists the chunks.
fn decode(bytes: &[u8]) -> (png::ColorType, (u32, u32), Vec<u8>, Vec<String>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let (mut at, mut chunks) = (8, Vec::new());
    while at < bytes.len() {
        let length = u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        chunks.push(String::from_utf8(bytes[at + 4..at + 8].to_vec()).unwrap());
        at += length + 12;
    }
    chunks.dedup();
    (info.color_type, (info.width, info.height), pixels, chunks)
}

#[test]
fn rgb_tiles_decode_to_the_sampled_elevation_within_half_a_step() {
    for name in ["alps", "eq2", "dunes"] {
        let world = world(name);
        for samples in [Samples::Centres(256), Samples::Centres(512), Samples::Vertices(129)] {
            let want = elevations(&world, samples);
            for (tileset, decode_pixel, half_step) in [
                (Tileset::Terrarium, (|r, g, b| r * 256.0 + g + b / 256.0 - 32_768.0) as fn(f64, f64, f64) -> f64, 0.5 / 256.0),
                (Tileset::TerrainRgb, |r, g, b| -10_000.0 + (r * 65_536.0 + g * 256.0 + b) * 0.1, 0.05 + 1e-9),
            ] {
                let (colour, (width, height), pixels, chunks) = decode(&render(&world, &request(tileset, samples)).unwrap());
                assert_eq!((colour, width as usize, height as usize), (png::ColorType::Rgb, samples.side(), samples.side()));
                assert_eq!(chunks, ["IHDR", "IDAT", "IEND"], "no colour management, no transparency");
                for (pixel, &want) in pixels.chunks_exact(3).zip(&want) {
                    let got = decode_pixel(pixel[0].into(), pixel[1].into(), pixel[2].into());
                    assert!((got - f64::from(want)).abs() <= half_step, "{name} {tileset:?}: {got} is not {want}");
                }
            }
        }
    }
}

#[test]
fn hillshade_is_opaque_grey_and_shows_relief() {
    let (colour, size, pixels, _) = decode(&render(&world("alps"), &request(Tileset::Hillshade, Samples::Centres(256))).unwrap());
    assert_eq!((colour, size), (png::ColorType::Grayscale, (256, 256)));
    let (low, high) = (pixels.iter().min().unwrap(), pixels.iter().max().unwrap());
    assert!(high - low > 100, "{low} … {high}");
}

#[test]
fn a_geotiff_holds_elevations_and_their_place() {
    let world = world("hills");
    let window = Window::area([-500.0, 1000.0, 1500.0, 2000.0], 10.0, Filter::Band, 1 << 20).unwrap();
    let surface = world.evaluate(&window);
    let mut file = std::io::Cursor::new(Vec::new());
    write_geotiff(&surface, &window, &mut file).unwrap();
    file.set_position(0);
    let mut tiff = tiff::decoder::Decoder::new(file).unwrap();
    assert_eq!(tiff.dimensions().unwrap(), (200, 100));
    assert_eq!(tiff.get_tag_f64_vec(tiff::tags::Tag::ModelPixelScaleTag).unwrap(), [10.0, 10.0, 0.0]);
    assert_eq!(tiff.get_tag_f64_vec(tiff::tags::Tag::ModelTiepointTag).unwrap(), [0.0, 0.0, 0.0, -500.0, 2000.0, 0.0]);
    let tiff::decoder::DecodingResult::F32(values) = tiff.read_image().unwrap() else { panic!("not f32") };
    assert_eq!(values, surface.elevation);
}
