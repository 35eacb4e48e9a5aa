//! Documents and what becomes of them.

use super::*;
use crate::synthesis::{Level, SampleGrid, tests::hills};
use sha2::{Digest, Sha256};

const WRITTEN: &str = r##"{
    "title": "Two kinds of hills",
    "types": [
        {"name": "mountains", "colour": "#8a7f5c", "samples": [
            {"file": "high/one.asc"}, {"file": "high/two.asc", "crop": {"column": 20, "row": 0, "columns": 90, "rows": 80}, "voids": "trim"}, {"file": "high/three.asc"}
        ]},
        {"name": "hills", "colour": "#a0b070", "samples": [{"file": "low.asc", "unit": "decimetres", "without_water": true}, {"file": "low2.asc"}]}
    ],
    "seams": [{"between": ["hills", "mountains"], "smoothness": 0.3}]
}"##;

/// A file of a made-up sample.
fn file(grid: &SampleGrid) -> Vec<u8> {
    let mut text = format!("ncols {}\nnrows {}\ncellsize {}\n", grid.columns, grid.rows, grid.spacing[0]);
    for row in 0..grid.rows {
        text += &grid.row(row).iter().map(|height| if height.is_nan() { "-9999".to_owned() } else { height.to_string() }).collect::<Vec<_>>().join(" ");
        text.push('\n');
    }
    text.into_bytes()
}

fn files(sample: &LibrarySample) -> Result<Vec<u8>, String> {
    let grid = match sample.name() {
        "high/one.asc" => hills(120, 110, 30.0, 60.0, 1),
        "high/two.asc" => {
            let mut grid = hills(120, 110, 30.0, 60.0, 2);
            (0..110).for_each(|row| grid.heights[row * 120 + 20] = f32::NAN);
            grid
        }
        "high/three.asc" => hills(120, 110, 30.0, 60.0, 3),
        "low.asc" => {
            let mut grid = hills(100, 100, 30.0, 80.0, 4);
            grid.heights[..2500].fill(4000.0);
            grid
        }
        "low2.asc" => hills(80, 80, 30.0, 8.0, 5),
        other => return Err(format!("there is no file {other:?}")),
    };
    Ok(file(&grid))
}

fn library(json: &str) -> Library {
    Library::parse(json.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn what_is_written_is_read_and_written_again() {
    let library = library(WRITTEN);
    assert_eq!(library.smoothness_between("mountains", "hills"), 0.3);
    assert_eq!(library.smoothness_between("mountains", "mountains"), 0.5);
    let again = serde_json::to_vec(&library).unwrap();
    assert_eq!(Library::parse(&again).unwrap(), library);
    assert!(!String::from_utf8(again).unwrap().contains("null"));
}

#[test]
fn samples_are_cut_and_compared_at_levels() {
    let ready = library(WRITTEN).ready(&files).unwrap_or_else(|error| panic!("{error}"));
    let two = &ready.types[0][1];
    assert_eq!(two.part, Crop { column: 21, row: 0, columns: 89, rows: 80 });
    assert_eq!((two.grid.columns, two.grid.voids()), (89, 0));
    assert!(two.notes.iter().any(|note| note.contains("89 × 80 cells of 90 × 80")), "{:?}", two.notes);
    let low = &ready.types[1][0];
    assert_eq!((low.water[0].cells, low.water[0].elevation), (2500, 400.0));
    let spacings = |levels: Vec<Level>| levels.into_iter().map(Level::spacing).collect::<Vec<_>>();
    assert_eq!(spacings(ready.levels(0)), [30.0, 90.0]);
    assert_eq!(spacings(ready.common_levels(&[0, 1])), [30.0, 90.0]);
    assert_eq!(spacings(ready.levels(7)), [0.0; 0]);
    let level = Level::try_from(30.0).unwrap();
    let (model, analyses) = (ready.model(level), ready.analyse(level));
    assert_eq!(model.types[0].samples, 3);
    for (number, samples) in analyses.iter().enumerate() {
        assert!(samples.iter().all(|sample| model.nearest(&sample.profile())[0].0 == number));
    }
    let coarse = ready.model(Level::try_from(810.0).unwrap());
    assert_eq!(coarse.types[0].samples, 0);
    assert!(coarse.nearest(&analyses[0][0].profile()).is_empty());
}

#[test]
fn a_hash_holds_a_file() {
    let mut library = library(WRITTEN);
    let sample = &mut library.types[0].samples[0];
    let bytes = files(sample).unwrap();
    let hash: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    sample.sha256 = Some(hash.clone());
    assert!(sample.ready(&bytes).is_ok());
    let error = sample.ready(&bytes[1..]).unwrap_err();
    assert!(error.detail.contains(&hash), "{error}");
}

#[test]
fn every_sample_that_fails_is_told_by_its_pointer() {
    let json = WRITTEN.replace("low2.asc", "lost.asc").replace("\"column\": 20", "\"column\": 40");
    let LibraryError(problems) = library(&json).ready(&files).unwrap_err();
    let told: Vec<(&str, &str)> = problems.iter().map(|problem| (problem.pointer.as_str(), problem.detail.as_str())).collect();
    let crop = "high/two.asc: file: the crop is not inside of the file, which has 120 × 110 cells";
    assert_eq!(told, [("/types/0/samples/1", crop), ("/types/1/samples/1", "there is no file \"lost.asc\"")]);
}

#[test]
fn what_cannot_be_meant_is_refused_by_pointer() {
    let check = |from: &str, to: &str, pointer: &str, says: &str| {
        let json = WRITTEN.replacen(from, to, 1);
        assert_ne!(json, WRITTEN, "{from}");
        let LibraryError(problems) = Library::parse(json.as_bytes()).expect_err(says);
        assert!(problems.iter().any(|problem| problem.pointer == pointer && problem.detail.contains(says)), "{problems:?}");
    };
    check("\"colour\": \"#8a7f5c\"", "\"color\": \"#8a7f5c\"", "/types/0/color", "did you mean `colour`?");
    check("\"colour\": \"#8a7f5c\", ", "", "/types/0/colour", "missing");
    check("#8a7f5c", "brown", "/types/0/colour", "#8a7f5c");
    check("decimetres", "yards", "/types/1/samples/0/unit", "feet");
    check("\"unit\": \"decimetres\"", "\"units\": \"metres\"", "/types/1/samples/0/units", "did you mean `unit`?");
    check("high/one.asc", "../one.asc", "/types/0/samples/0/file", "below the library");
    check("high/one.asc", "/one.asc", "/types/0/samples/0/file", "below the library");
    check("\"file\": \"high/one.asc\"", "", "/types/0/samples/0", "`file` or `sha256`");
    check("\"file\": \"high/one.asc\"", "\"sha256\": \"ABC\"", "/types/0/samples/0/sha256", "64 digits");
    check("\"columns\": 90", "\"columns\": 0", "/types/0/samples/1/crop", "columns and rows");
    check("\"columns\": 90", "\"columns\": -1", "/types/0/samples/1/crop/columns", "-1");
    check("0.3", "1.3", "/seams/0/smoothness", "0 … 1");
    check("[\"hills\", \"mountains\"]", "[\"hills\", \"plains\"]", "/seams/0/between/1", "no type is called \"plains\"; there are mountains, hills");
    check("[\"hills\", \"mountains\"]", "[\"hills\", \"hills\"]", "/seams/0/between", "two different");
    check("\"name\": \"mountains\"", "\"name\": \"hills\"", "/types/1/name", "two types");
    check("\"name\": \"mountains\"", "\"name\": \"High Mountains\"", "/types/0/name", "a … z");
    check("0.3}]", "0.3}, {\"between\": [\"mountains\", \"hills\"], \"smoothness\": 1}]", "/seams/1/between", "already");
    let cut = Library::parse(&WRITTEN.as_bytes()[..WRITTEN.len() - 3]).unwrap_err();
    assert!(cut.to_string().contains("EOF while parsing"), "{cut}");
    let nothing = Library::parse(br#"{"types": []}"#).unwrap_err();
    assert_eq!(nothing.to_string(), "/types: must be 1 … 256 types, are 0");
}
