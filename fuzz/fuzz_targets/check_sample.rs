//! What must hold for any bytes that are taken as a sample of elevations. The tests of the package run it over the corpus.

use terrane::synthesis::{Format, Hints, Number, SampleError, Unit, Voids, read};

/// The first byte chooses the format, the rest is the file.
pub(crate) fn check(data: &[u8]) {
    let Some((choice, bytes)) = data.split_first() else { return };
    let format = match choice % 7 {
        0 => None,
        1 => Some(Format::Geotiff),
        2 => Some(Format::Hgt),
        3 => Some(Format::UsgsDem),
        4 => Some(Format::AsciiGrid),
        5 => Some(Format::Png16),
        _ => Some(Format::Raw),
    };
    let known = Hints { spacing: Some([30.0; 2]), unit: Some(Unit::Metres), size: Some([8, 8]), number: Some(Number::I16), ..Hints::default() };
    for hints in [Hints { format, ..Hints::default() }, Hints { format, ..known }] {
        match read("sample", bytes, &hints) {
            Ok(sample) => {
                let grid = sample.grid;
                assert_eq!(grid.heights.len(), grid.columns * grid.rows);
                grid.check("sample").expect("what was read is sound");
                if grid.heights.len() <= 4_096 {
                    let part = Voids::Rectangle.part(&grid).expect("not all is void");
                    assert_eq!(grid.crop(part).expect("it lies inside").voids(), 0);
                }
            }
            Err(error) => tells(&error),
        }
    }
}

/// A problem says something, and not too much.
fn tells(error: &SampleError) {
    assert!(error.name == "sample" && !error.detail.is_empty() && error.detail.len() < 1_000, "{error}");
}
