//! One terrain through every format, and what is refused.

use super::read;
use crate::synthesis::{Format, Hints, Number, Place, Sample, SampleError, Unit};
use proptest::prelude::*;
use std::io::Cursor;
use tiff::{
    encoder::{Compression, Rational, TiffEncoder, colortype::Gray32Float},
    tags::Tag,
};

const COLUMNS: usize = 23;
const ROWS: usize = 19;

/// Whole metres, with one void.
fn heights() -> Vec<i16> {
    let mut heights: Vec<i16> = (0..COLUMNS * ROWS).map(|i| ((i * 37) % 811 + i / 3) as i16).collect();
    heights[COLUMNS * 5 + 7] = VOID;
    heights
}

const VOID: i16 = -32_768;

fn ascii() -> Vec<u8> {
    let mut text = format!("ncols {COLUMNS}\r\nNROWS {ROWS}\nxllcorner 5000\nyllcorner 7000\ncellsize 30\nNODATA_value {VOID}\n");
    for row in heights().chunks(COLUMNS) {
        text += &row.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        text.push('\n');
    }
    text.into_bytes()
}

/// A `GeoTIFF` of floats with keys of its place.
fn geotiff(compression: Compression, keys: &[u16], scale: [f64; 3], tie: [f64; 6], nodata: &str) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression);
    let mut image = encoder.new_image::<Gray32Float>(COLUMNS as u32, ROWS as u32).unwrap();
    image.x_resolution(Rational { n: 1, d: 1 });
    let directory = image.encoder();
    directory.write_tag(Tag::ModelPixelScaleTag, &scale[..]).unwrap();
    directory.write_tag(Tag::ModelTiepointTag, &tie[..]).unwrap();
    directory.write_tag(Tag::GeoKeyDirectoryTag, keys).unwrap();
    directory.write_tag(Tag::GdalNodata, nodata).unwrap();
    image.write_data(&heights().iter().map(|height| f32::from(*height)).collect::<Vec<_>>()).unwrap();
    bytes.into_inner()
}

/// Keys: a projection in metres.
const PROJECTED: [u16; 12] = [1, 1, 0, 2, 1024, 0, 1, 1, 4099, 0, 1, 9001];

fn plain_geotiff(compression: Compression) -> Vec<u8> {
    geotiff(compression, &PROJECTED, [30.0, 30.0, 0.0], [0.0, 0.0, 0.0, 5000.0, 7000.0, 0.0], "-32768")
}

fn png(bytes: &[u16], columns: u32, rows: u32) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let samples: Vec<u8> = bytes.iter().flat_map(|grey| grey.to_be_bytes()).collect();
    encoder.write_header().unwrap().write_image_data(&samples).unwrap();
    file
}

/// Whole numbers of six columns each.
fn six(numbers: &[i64]) -> String {
    numbers.iter().map(|number| format!("{number:>6}")).collect()
}

/// A USGS DEM in metres every 30 m whose profiles begin and end at different rows; elevations count decimetres above a datum of 100 m.
fn dem(separator: &str) -> Vec<u8> {
    let heights = heights();
    let number = |number: f64| format!("{:>24}", format!("{number:.15E}").replace('E', "D+0").replace("D+0-", "D-0"));
    let mut a = format!("{:<144}", "MADE UP QUADRANGLE");
    a += &six(&[1, 1, 1, 13]);
    a += &number(0.0).repeat(15);
    a += &six(&[2, 2, 4]);
    for [x, y] in [[0.0, 0.0], [0.0, 540.0], [660.0, 540.0], [660.0, 0.0]] {
        a += &number(x);
        a += &number(y);
    }
    a += &number(0.0);
    a += &number(4000.0);
    a += &number(0.0);
    a += &six(&[1]);
    a += "0.300000E+020.300000E+020.100000E+00";
    a += &six(&[1, COLUMNS as i64]);
    let mut blocks = vec![a];
    for column in 0..COLUMNS {
        // The corners of the west are void.
        let skip = 4_usize.saturating_sub(column);
        let mut b = six(&[1, column as i64 + 1, (ROWS - skip) as i64, 1]);
        b += &number(30.0 * column as f64);
        b += &number(30.0 * skip as f64);
        b += &number(100.0);
        b += &number(0.0);
        b += &number(4000.0);
        for row in (0..ROWS - skip).rev() {
            let height = heights[row * COLUMNS + column];
            b += &six(&[if height == VOID { -32_767 } else { (i64::from(height) - 100) * 10 }]);
        }
        blocks.push(b);
    }
    blocks.into_iter().map(|block| format!("{block:<1024}{separator}")).collect::<String>().into_bytes()
}

fn known() -> Hints {
    Hints {
        spacing: Some([30.0; 2]),
        unit: Some(Unit::Metres),
        size: Some([COLUMNS, ROWS]),
        number: Some(Number::I16Be),
        void: Some(f64::from(VOID)),
        ..Hints::default()
    }
}

/// Files of every format with what they cannot say.
fn files() -> Vec<(&'static str, Vec<u8>, Hints)> {
    let raw: Vec<u8> = heights().iter().flat_map(|height| height.to_be_bytes()).collect();
    let floats: Vec<u8> = heights().iter().flat_map(|height| f32::from(*height).to_le_bytes()).collect();
    let unsigned: Vec<u16> = heights().iter().map(|height| if *height == VOID { 65_535 } else { *height as u16 }).collect();
    let picture = Hints { void: Some(65_535.0), ..known() };
    vec![
        ("a.asc", ascii(), Hints::default()),
        ("a.tif", plain_geotiff(Compression::Uncompressed), Hints::default()),
        ("deflated", plain_geotiff(Compression::Deflate(tiff::encoder::DeflateLevel::Fast)), Hints::default()),
        ("lzw", plain_geotiff(Compression::Lzw), Hints::default()),
        ("a.dem", dem(""), Hints::default()),
        ("lines.dem", dem("\r\n"), Hints::default()),
        ("a.png", png(&unsigned, COLUMNS as u32, ROWS as u32), picture),
        ("a.raw", raw, known()),
        ("a.r32", floats, Hints { number: Some(Number::F32), ..known() }),
    ]
}

/// Whether two samples are equal, voids too.
fn same(one: &[f32], other: &[f32]) -> bool {
    one.len() == other.len() && one.iter().zip(other).all(|(one, other)| one == other || (one.is_nan() && other.is_nan()))
}

fn sample(name: &str, bytes: &[u8], hints: &Hints) -> Sample {
    read(name, bytes, hints).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_format_gives_the_same_ground() {
    let expected: Vec<f32> = heights().iter().map(|height| if *height == VOID { f32::NAN } else { f32::from(*height) }).collect();
    for (name, bytes, hints) in files() {
        let mut read = sample(name, &bytes, &hints).grid;
        assert_eq!((read.columns, read.rows, read.spacing), (COLUMNS, ROWS, [30.0; 2]), "{name}");
        if name.ends_with("dem") {
            // Profiles of the west begin further north.
            for column in 0..4 {
                for row in ROWS - (4 - column)..ROWS {
                    let cell = &mut read.heights[row * COLUMNS + column];
                    assert!(cell.is_nan(), "{name}");
                    *cell = expected[row * COLUMNS + column];
                }
            }
        }
        assert!(same(&read.heights, &expected), "{name}");
    }
}

#[test]
fn a_tile_of_the_shuttle_mission_lies_where_its_name_says() {
    let mut bytes: Vec<u8> = (0..1201 * 1201).flat_map(|i: i32| ((i / 1201) as i16).to_be_bytes()).collect();
    bytes[..2].copy_from_slice(&VOID.to_be_bytes());
    let tile = sample("data/N60W085.hgt", &bytes, &Hints::default());
    assert_eq!((tile.format, tile.grid.columns, tile.grid.voids()), (Format::Hgt, 1201, 1));
    let [east, north] = tile.grid.spacing;
    // 55.8 km and 111.4 km a degree at 60.5° (tables of WGS 84: 54.93 and 111.42).
    assert!((east - 54_938.0 / 1200.0).abs() < 0.1 && (north - 111_421.0 / 1200.0).abs() < 0.05, "{east} {north}");
    assert!(tile.notes[0].contains("60.5"), "{:?}", tile.notes);
    let south = sample("s01e010.HGT", &bytes, &Hints::default()).grid.spacing[0];
    assert!((south - 111_316.0 / 1200.0).abs() < 0.05, "{south}");
    refused("tile.hgt", &bytes, &Hints::default(), Place::File, "latitude");
    refused("N60W085.hgt", &bytes[..bytes.len() - 1], &Hints::default(), Place::Byte(bytes.len() - 1), "2884802");
}

#[test]
fn degrees_and_units_of_files_become_metres() {
    let geographic = [1, 1, 0, 2, 1024, 0, 1, 2, 4099, 0, 1, 9002];
    let step = 1.0 / 3600.0;
    let bytes = geotiff(Compression::Uncompressed, &geographic, [step, step, 0.0], [0.0, 0.0, 0.0, -105.0, 40.0 + step * ROWS as f64 / 2.0, 0.0], "-32768");
    let read = sample("feet.tif", &bytes, &Hints::default());
    let [east, north] = read.grid.spacing;
    assert!((east - 85_394.0 / 3600.0).abs() < 1e-3 && (north - 111_035.0 / 3600.0).abs() < 1e-3, "{east} {north}");
    assert_eq!(read.grid.heights[3], (f64::from(heights()[3]) * 0.3048) as f32);
    let decimetres = sample("feet.tif", &bytes, &Hints { unit: Some(Unit::Decimetres), ..Hints::default() });
    assert_eq!(decimetres.grid.heights[3], (f64::from(heights()[3]) * 0.1) as f32);
    let odd = [1, 1, 0, 1, 4099, 0, 1, 9036];
    let bytes = geotiff(Compression::Uncompressed, &odd, [30.0, 30.0, 0.0], [0.0; 6], "-32768");
    refused("odd.tif", &bytes, &Hints::default(), Place::Tag(34_735), "9036");
    let grid = String::from_utf8(ascii()).unwrap().replace("cellsize 30", "cellsize 0.000833333333").replace("5000", "-105.55").replace("7000", "40.09");
    let read = sample("degrees.asc", grid.as_bytes(), &Hints::default());
    assert!((read.grid.spacing[0] - 71.06).abs() < 0.05 && (read.grid.spacing[1] - 92.53).abs() < 0.05, "{:?}", read.grid.spacing);
    assert!(read.notes.iter().any(|note| note.contains("latitude 40.09")) && read.notes.iter().any(|note| note.contains("metres are taken")));
}

/// Files that GDAL wrote: the numbers of 41 × 37 cells in tiles of 16 × 16.
#[test]
fn tiles_of_lzw_are_those_that_gdal_wrote() {
    let expected = |i: i32| f64::from(((i % 41 * 37 + i / 41 * 101) % 613) * 3 - 200 + (i / 41 * (i % 41)) % 7);
    let files: [(&str, &[u8], f64); 3] = [
        ("i16", include_bytes!("fixtures/tiled-lzw-i16.tif"), 1.0),
        ("f32", include_bytes!("fixtures/tiled-lzw-f32.tif"), 4.0),
        ("f64", include_bytes!("fixtures/tiled-lzw-f64.tif"), 4.0),
    ];
    for (name, bytes, divisor) in files {
        let grid = sample(name, bytes, &Hints::default()).grid;
        assert_eq!((grid.columns, grid.rows, grid.spacing), (41, 37, [30.0; 2]));
        assert!(same(&grid.heights, &(0..41 * 37).map(|i| (expected(i) / divisor) as f32).collect::<Vec<_>>()), "{name}");
        for end in (0..bytes.len()).step_by(7) {
            sound(name, &bytes[..end], &Hints::default());
        }
        for at in (0..bytes.len()).step_by(3) {
            let mut bytes = bytes.to_vec();
            bytes[at] ^= 0x55;
            sound(name, &bytes, &Hints::default());
        }
    }
}

#[test]
fn a_range_says_what_greys_stand_for() {
    let greys: Vec<u16> = (0..64).map(|i| i * 1040).collect();
    let hints = Hints { spacing: Some([10.0; 2]), range: Some([-500.0, 1500.0]), ..Hints::default() };
    let read = sample("grey.png", &png(&greys, 8, 8), &hints).grid;
    assert_eq!(read.heights[63], (-500.0 + 65_520.0 / 65_535.0 * 2000.0) as f32);
    let both = Hints { unit: Some(Unit::Metres), ..hints.clone() };
    refused("grey.png", &png(&greys, 8, 8), &both, Place::File, "`range`");
    refused("grey.png", &png(&greys, 8, 8), &Hints { range: None, ..hints.clone() }, Place::File, "`unit` or `range`");
    refused("grey.png", &png(&greys, 8, 8), &Hints { spacing: None, ..hints.clone() }, Place::File, "`spacing`");
    let mut colours = Vec::new();
    let mut encoder = png::Encoder::new(&mut colours, 8, 8);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[7; 192]).unwrap();
    refused("colour.png", &colours, &hints, Place::Byte(24), "greys of 16 bits");
}

fn refused(name: &str, bytes: &[u8], hints: &Hints, place: Place, says: &str) {
    let error: SampleError = read(name, bytes, hints).err().unwrap_or_else(|| panic!("{name} is taken, not {says}"));
    assert_eq!((error.name.as_str(), error.place), (name, place), "{error}");
    assert!(error.detail.contains(says), "{error}");
}

#[test]
fn grids_are_refused_by_line() {
    let text = String::from_utf8(ascii()).unwrap();
    let check =
        |from: &str, to: &str, line: usize, says: &str| refused("a.asc", text.replacen(from, to, 1).as_bytes(), &Hints::default(), Place::Line(line), says);
    check("ncols 23", "ncols x", 1, "followed by a number");
    check("ncols 23", "ncols 2.5", 7, "whole number");
    check("ncols 23", "ncols 99999999", 7, "more than");
    check("ncols 23", "ncols 99999", 7, "cannot hold");
    check("ncols 23", "ncols 24", 25, "456, the file ends after 437");
    check("ncols 23", "ncols 22", 25, "stands after 22 × 19");
    check("yllcorner", "ylcorner", 4, "no key");
    check("cellsize 30\n", "", 6, "cellsize is missing");
    check("\n0 37", "\n0 3x7", 7, "must be a number, is \"3x7\"");
    refused("a.asc", text.replacen("cellsize 30", "cellsize 1e9", 1).as_bytes(), &Hints::default(), Place::File, "apart");
    refused("a.asc", text.replacen("\n0 37", "\n0 99999", 1).as_bytes(), &Hints::default(), Place::Cell { column: 1, row: 0 }, "-12000 … 32767");
    refused("a.asc", b"ncols 2\nnrows 1\ncellsize 10\n1 2\n", &Hints::default(), Place::File, "8 × 8");
    let void = format!("ncols 8\nnrows 8\ncellsize 10\n{}", "-9999 ".repeat(64));
    refused("a.asc", void.as_bytes(), &Hints::default(), Place::File, "every cell is void");
    refused("a.xyz", b"hello", &Hints::default(), Place::File, "no format");
    refused("", b"", &Hints::default(), Place::File, "no format");
}

#[test]
fn records_and_tags_are_refused_by_number() {
    let bytes = dem("");
    let with = |at: usize, text: &str| {
        let mut bytes = bytes.clone();
        bytes[at..at + text.len()].copy_from_slice(text.as_bytes());
        bytes
    };
    let hints = Hints::default();
    refused("a.dem", &with(528, "     9"), &hints, Place::Record(1), "529 … 534");
    refused("a.dem", &with(534, "     0"), &hints, Place::Record(1), "535 … 540");
    refused("a.dem", &with(858, "999999"), &hints, Place::Record(1), "1 … 100000");
    refused("a.dem", &with(858, " 99999"), &hints, Place::Record(1), "cannot hold");
    refused("a.dem", &with(3 * 1024 + 144, " 12x45"), &hints, Place::Record(4), "must be a number, are \"12x45\"");
    refused("a.dem", &bytes[..5 * 1024 + 100], &hints, Place::Record(1), "cannot hold");
    refused("a.dem", &with(2 * 1024 + 12, "900000"), &hints, Place::Record(5298), "cut short");
    refused("a.dem", &with(786, "   0.5D+00              "), &hints, Place::Record(1), "turned");
    let twisted = geotiff(Compression::Uncompressed, &PROJECTED, [0.0, 30.0, 0.0], [0.0; 6], "-32768");
    refused("a.tif", &twisted, &hints, Place::File, "apart");
    refused("a.tif", &geotiff(Compression::Uncompressed, &PROJECTED, [30.0, 30.0, 0.0], [0.0; 6], "none"), &hints, Place::Tag(42_113), "\"none\"");
    refused("a.tif", b"II*\0", &hints, Place::Byte(0), "");
    let raw = vec![0; COLUMNS * ROWS * 2];
    refused("a.raw", &raw[1..], &known(), Place::Byte(raw.len() - 1), "874 bytes, the file has 873");
    refused("a.raw", &raw, &Hints { size: None, ..known() }, Place::File, "`size`");
    refused("a.raw", &raw, &Hints { unit: None, ..known() }, Place::File, "`unit` or `range`");
    refused("a.raw", &raw, &Hints { size: Some([usize::MAX, 3]), ..known() }, Place::File, "more than");
}

/// A picture of 2^31 cells in a few kilobytes, and a TIFF that claims as much.
#[test]
fn bombs_are_refused_before_memory_is_asked_for() {
    let mut picture = png(&[0; 64], 8, 8);
    picture[16..20].copy_from_slice(&50_000_u32.to_be_bytes());
    picture[20..24].copy_from_slice(&50_000_u32.to_be_bytes());
    let checksum = crc(&picture[12..29]);
    picture[29..33].copy_from_slice(&checksum.to_be_bytes());
    let hints = Hints { spacing: Some([10.0; 2]), unit: Some(Unit::Metres), ..Hints::default() };
    refused("bomb.png", &picture, &hints, Place::Byte(16), "more than");
    picture[16..20].copy_from_slice(&5_000_u32.to_be_bytes());
    picture[20..24].copy_from_slice(&5_000_u32.to_be_bytes());
    let checksum = crc(&picture[12..29]);
    picture[29..33].copy_from_slice(&checksum.to_be_bytes());
    refused("bomb.png", &picture, &hints, Place::Byte(16), "cannot hold");
    for (side, says) in [(60_000_u32, "more than"), (8_000, "cannot hold")] {
        let mut tiff = plain_geotiff(Compression::Deflate(tiff::encoder::DeflateLevel::Fast));
        let directory = u32::from_le_bytes(tiff[4..8].try_into().unwrap()) as usize;
        for entry in 0..usize::from(u16::from_le_bytes(tiff[directory..directory + 2].try_into().unwrap())) {
            let at = directory + 2 + 12 * entry;
            // Width, height and rows of a strip.
            if [256, 257, 278].contains(&u16::from_le_bytes(tiff[at..at + 2].try_into().unwrap())) {
                tiff[at + 2..at + 4].copy_from_slice(&4_u16.to_le_bytes());
                tiff[at + 8..at + 12].copy_from_slice(&side.to_le_bytes());
            }
        }
        refused("bomb.tif", &tiff, &Hints::default(), Place::Tag(256), says);
    }
}

/// The checksum of PNG chunks.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 }))
}

/// What was read is sound, what was refused says why.
fn sound(name: &str, bytes: &[u8], hints: &Hints) {
    match read(name, bytes, hints) {
        Ok(sample) => {
            assert_eq!(sample.grid.heights.len(), sample.grid.columns * sample.grid.rows);
            assert!(sample.grid.check(name).is_ok());
        }
        Err(error) => assert!(error.name == name && !error.detail.is_empty() && error.detail.len() < 1_000, "{error}"),
    }
}

#[test]
fn every_file_can_be_cut_anywhere() {
    for (name, bytes, hints) in files() {
        for end in (0..bytes.len()).step_by(bytes.len() / 600 + 1).chain(bytes.len().saturating_sub(40)..bytes.len()) {
            sound(name, &bytes[..end], &hints);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn no_bytes_are_too_wild(file in 0_usize..9, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12), head in any::<bool>()) {
        let (name, mut bytes, hints) = files().swap_remove(file);
        let within = if head { bytes.len().min(300) } else { bytes.len() };
        for (place, byte) in changes {
            bytes[place.index(within)] = byte;
        }
        sound(name, &bytes, &hints);
    }

    #[test]
    fn noise_is_refused(bytes in prop::collection::vec(any::<u8>(), 0..2000), format in 0_usize..6) {
        let format = [Format::Geotiff, Format::Hgt, Format::UsgsDem, Format::AsciiGrid, Format::Png16, Format::Raw][format];
        sound("noise", &bytes, &Hints { format: Some(format), ..known() });
        sound("noise", &bytes, &Hints { format: Some(format), ..Hints::default() });
    }
}
