//! Tiles of the Shuttle Radar Topography Mission: a degree a side, 16-bit big-endian metres from north to south, -32768 where nothing is known.

use super::{File, Format, Numbers, Place, Sample, SampleError, Unit, degrees};

/// (columns, rows): 3″, 1″, and 2″ × 1″ as north of 50°.
const SIZES: [[usize; 2]; 3] = [[1201, 1201], [3601, 3601], [1801, 3601]];

/// The latitude of the middle from a name like `N36W085.hgt`.
fn latitude(name: &str) -> Option<f64> {
    let name = name.rsplit(['/', '\\']).next()?;
    let (hemisphere, digits) = (name.get(..1)?, name.get(1..3)?);
    let south = f64::from(digits.parse::<u8>().ok()?);
    match hemisphere {
        "N" | "n" => Some(south + 0.5),
        "S" | "s" => Some(0.5 - south),
        _ => None,
    }
}

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    let [columns, rows] = *SIZES.iter().find(|[columns, rows]| columns * rows * 2 == file.bytes.len()).ok_or_else(|| {
        let right: Vec<String> = SIZES.iter().map(|[columns, rows]| format!("{} ({columns} × {rows})", columns * rows * 2)).collect();
        file.error(Place::Byte(file.bytes.len()), format!("must have {} bytes, ends here", right.join(" or ")))
    })?;
    let mut notes = Vec::new();
    let own = if file.hints.spacing.is_some() {
        None
    } else {
        let latitude = file
            .hints
            .latitude
            .or_else(|| latitude(file.name))
            .ok_or_else(|| file.error(Place::File, "its latitude stands in the name, like N36W085.hgt: name it so or say `latitude`"))?;
        let (spacing, note) = degrees::spacing(file, [1.0 / (columns - 1) as f64, 1.0 / (rows - 1) as f64], latitude)?;
        notes.push(note);
        Some(spacing)
    };
    let values = file.bytes.as_chunks::<2>().0.iter().map(|bytes| f32::from(i16::from_be_bytes(*bytes))).collect();
    let numbers = Numbers { columns, rows, spacing: file.spacing(own)?, values, void: Some(-32_768.0), unit: Some(Unit::Metres), notes };
    file.finish(Format::Hgt, numbers)
}
