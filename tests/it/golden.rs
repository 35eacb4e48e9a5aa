//! Tiles must not change: their digests are kept in `tests/golden`.
//!
//! If a change of output is meant, raise the generator (or encoder) version, look at the pictures, and put the file that the failure names in the place of the old one.

use sha2::{Digest, Sha256};
use std::{fmt::Write, path::Path};
use terrane::{
    geometry::{Filter, Grid, Legend, Samples, Tile},
    tile::{Height, Image, MeshExtensions, Options, PREVIEW_FORM, TileRequest, Tileset, preview, render},
    world::{Document, EXAMPLES, PRESETS, Preset, Survey, World},
};

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().take(12).map(|byte| format!("{byte:02x}")).collect()
}

/// `case: digest min max` for elevations, `case: digest` for pictures.
fn lines() -> String {
    let mut lines = String::new();
    let places = [
        (Grid::Web, Tile { z: 9, x: 257, y: 254 }, Samples::Centres(256), Filter::Band),
        (Grid::Web, Tile { z: 3, x: -9, y: 12 }, Samples::Centres(256), Filter::Band),
        (Grid::Metric, Tile { z: 17, x: -31, y: 4 }, Samples::Vertices(257), Filter::Exact),
        (Grid::Metric, Tile { z: 24, x: 140_737_488_355_000, y: -140_737_488_355_000 }, Samples::Vertices(65), Filter::Band),
        (Grid::Web, Tile { z: 30, x: 1 << 29, y: 1 << 29 }, Samples::Vertices(33), Filter::Exact),
    ];
    for example in EXAMPLES {
        let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
        for (grid, tile, samples, filter) in places {
            // Tiles at the end of the plane: as far as the zoom level goes.
            let tile = if grid == Grid::Metric && tile.z == 24 { Tile { x: 500_000_000_000, y: -500_000_000_000, ..tile } } else { tile };
            let bytes =
                render(&world, &TileRequest { grid, tile, samples, filter, tileset: Tileset::R32, height: Height::Ground, options: Options::default() })
                    .unwrap();
            let elevations: Vec<f32> = bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
            let (min, max) = elevations.iter().fold((f32::MAX, f32::MIN), |(min, max), &e| (min.min(e), max.max(e)));
            writeln!(lines, "{} {} {}/{}/{} {samples:?} {}: {} {min} {max}", example.name, grid.name(), tile.z, tile.x, tile.y, filter.name(), digest(&bytes))
                .unwrap();
        }
        let all = MeshExtensions { normals: true, water_mask: true, metadata: true };
        let (plain, webp, mesh) = (Options::default(), Options { image: Image::Webp, ..Options::default() }, Options { mesh: all, ..Options::default() });
        for (tileset, options) in [
            (Tileset::Terrarium, plain),
            (Tileset::TerrainRgb, plain),
            (Tileset::Hillshade, plain),
            (Tileset::Slope, plain),
            (Tileset::Normals, plain),
            (Tileset::Fit, plain),
            (Tileset::Height16, plain),
            (Tileset::TerrainRgb, webp),
            (Tileset::QuantizedMesh, mesh),
        ] {
            let (grid, tile, samples, filter) = places[0];
            let samples = if tileset == Tileset::QuantizedMesh { Samples::Vertices(65) } else { samples };
            let request = TileRequest { grid, tile, samples, filter, tileset, height: Height::Ground, options };
            let (form, bytes) = (request.form(&Legend::default()).replace('\n', " "), render(&world, &request).unwrap());
            writeln!(lines, "{} {form}: {}", example.name, digest(&bytes)).unwrap();
        }
    }
    lines
}

#[test]
fn tiles_are_those_of_the_golden_digests() {
    let kept = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/tiles.txt")).unwrap_or_default();
    let got = lines();
    if got != kept {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tiles.txt");
        std::fs::write(&place, &got).unwrap();
        let different: Vec<_> = got.lines().filter(|line| !kept.lines().any(|kept| kept == *line)).collect();
        panic!("{} of {} lines differ; what this machine makes is in {}:\n{}", different.len(), got.lines().count(), place.display(), different.join("\n"));
    }
}

/// The pictures of the library; those that differ are left to be looked at.
#[test]
fn previews_are_those_of_the_golden_digests() {
    let kept = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/previews.txt")).unwrap_or_default();
    let (place, mut got) = (Path::new(env!("CARGO_TARGET_TMPDIR")), String::new());
    for shipped in PRESETS {
        let preset = Preset::parse(shipped.json.as_bytes()).unwrap();
        let world = World::new(preset.document());
        for pixels in [64, 256] {
            let png = preview(&world, &Survey::of(&world).window(pixels), preset.sea_level).unwrap();
            let line = format!("{} {PREVIEW_FORM} {pixels}: {}\n", shipped.name, digest(&png));
            if !kept.contains(&line) {
                std::fs::write(place.join(format!("{}-{pixels}.png", shipped.name)), &png).unwrap();
            }
            got += &line;
        }
    }
    if got != kept {
        std::fs::write(place.join("previews.txt"), &got).unwrap();
        panic!("tests/golden/previews.txt differs; what this machine makes, pictures too, is in {}:\n{got}", place.display());
    }
}

/// A small picture that a person can look at.
#[test]
fn the_alps_look_as_they_did() {
    let example = EXAMPLES.iter().find(|example| example.name == "alps").unwrap();
    let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
    let request = TileRequest {
        grid: Grid::Web,
        tile: Tile { z: 8, x: 128, y: 127 },
        samples: Samples::Centres(32),
        filter: Filter::Band,
        tileset: Tileset::R32,
        height: Height::Ground,
        options: Options::default(),
    };
    let bytes = render(&world, &request).unwrap();
    let elevations: Vec<f32> = bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
    let shades = [' ', '.', ':', '-', '=', '+', '*', '%', '#', '@'];
    let picture: String = elevations
        .chunks(32)
        .map(|row| row.iter().map(|e| shades[(((e + 500.0) / 400.0).clamp(0.0, 9.0)) as usize]).collect::<String>().trim_end().to_owned() + "\n")
        .collect();
    let kept = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/alps.txt")).unwrap_or_default();
    if picture != kept {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR")).join("alps.txt");
        std::fs::write(&place, &picture).unwrap();
        panic!("tests/golden/alps.txt differs; what this machine makes is in {}:\n{picture}", place.display());
    }
}
