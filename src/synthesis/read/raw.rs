//! Numbers row by row and nothing else.

use super::{File, Format, Numbers, Place, Sample, SampleError};
use crate::synthesis::sample::Number;

/// The numbers.
fn values(number: Number, bytes: &[u8]) -> Vec<f32> {
    let (twos, fours) = (bytes.as_chunks::<2>().0.iter(), bytes.as_chunks::<4>().0.iter());
    match number {
        Number::U16 => twos.map(|bytes| f32::from(u16::from_le_bytes(*bytes))).collect(),
        Number::U16Be => twos.map(|bytes| f32::from(u16::from_be_bytes(*bytes))).collect(),
        Number::I16 => twos.map(|bytes| f32::from(i16::from_le_bytes(*bytes))).collect(),
        Number::I16Be => twos.map(|bytes| f32::from(i16::from_be_bytes(*bytes))).collect(),
        Number::F32 => fours.map(|bytes| f32::from_le_bytes(*bytes)).collect(),
        Number::F32Be => fours.map(|bytes| f32::from_be_bytes(*bytes)).collect(),
    }
}

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    let asked = |field: &str| file.error(Place::File, format!("raw files do not say it: say `{field}`"));
    let [columns, rows] = file.hints.size.ok_or_else(|| asked("size"))?;
    let number = file.hints.number.ok_or_else(|| asked("number"))?;
    if file.hints.unit.is_none() && file.hints.range.is_none() {
        return Err(asked("unit` or `range"));
    }
    if file.hints.range.is_some() && !matches!(number, Number::U16 | Number::U16Be) {
        return Err(file.error(Place::File, "`range` is for `u16` and `u16-be`; other numbers have a `unit`"));
    }
    let cells = file.cells(Place::File, columns, rows)?;
    let bytes = cells * number.bytes();
    if file.bytes.len() != bytes {
        return Err(file.error(
            Place::Byte(bytes.min(file.bytes.len())),
            format!("{columns} × {rows} numbers of {} bytes are {bytes} bytes, the file has {}", number.bytes(), file.bytes.len()),
        ));
    }
    let numbers = Numbers { columns, rows, spacing: file.spacing(None)?, values: values(number, file.bytes), void: None, unit: None, notes: Vec::new() };
    file.finish(Format::Raw, numbers)
}
