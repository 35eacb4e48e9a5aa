//! PNG with greys of 16 bits.

use super::{File, Format, MAX_CELLS, MAX_RATIO, Numbers, Place, Sample, SampleError};
use png::{BitDepth, ColorType, Decoder, Limits, Transformations};
use std::io::Cursor;

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    if file.hints.unit.is_none() && file.hints.range.is_none() {
        return Err(file.error(Place::File, "pictures do not say what greys stand for: say `unit` or `range`"));
    }
    let wrong = |byte: usize, error: &dyn std::fmt::Display| file.wrong(Place::Byte(byte), error);
    // A row and what the decompressor keeps; rows of the greatest pictures have fewer bytes.
    let mut decoder = Decoder::new_with_limits(Cursor::new(file.bytes), Limits { bytes: MAX_CELLS * 2 });
    decoder.set_transformations(Transformations::IDENTITY);
    let mut reader = decoder.read_info().map_err(|error| wrong(0, &error))?;
    let info = reader.info();
    let (columns, rows) = (info.width as usize, info.height as usize);
    if (info.color_type, info.bit_depth) != (ColorType::Grayscale, BitDepth::Sixteen) {
        let has = format!("must be greys of 16 bits, is {:?} of {} bits", info.color_type, info.bit_depth as u8);
        // The bytes of the header that say depth and colour.
        return Err(file.error(Place::Byte(24), has));
    }
    let cells = file.cells(Place::Byte(16), columns, rows)?;
    file.expands(Place::Byte(16), cells * 2, MAX_RATIO)?;
    let mut bytes = vec![0; cells * 2];
    reader.next_frame(&mut bytes).map_err(|error| wrong(file.bytes.len(), &error))?;
    let values = bytes.as_chunks::<2>().0.iter().map(|bytes| f32::from(u16::from_be_bytes(*bytes))).collect();
    let numbers = Numbers { columns, rows, spacing: file.spacing(None)?, values, void: None, unit: None, notes: Vec::new() };
    file.finish(Format::Png16, numbers)
}
