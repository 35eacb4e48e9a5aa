//! TIFF with its place on the ground (OGC 19-008r4).

use super::{File, Format, MAX_CELLS, MAX_RATIO, Numbers, Place, Sample, SampleError, Unit, degrees, lzw};
use std::io::Cursor;
use tiff::{
    ColorType, TiffError,
    decoder::{ChunkType, Decoder, DecodingResult, Limits},
    tags::{CompressionMethod, Tag},
};

/// Metres to the east and to the north of a step of a column.
const PIXEL_SCALE: u16 = 33_550;
const TIE_POINT: u16 = 33_922;
const TRANSFORMATION: u16 = 34_264;
const GEO_KEYS: u16 = 34_735;
/// The number that stands for voids, as text (GDAL).
const NODATA: u16 = 42_113;

const COMPRESSION: u16 = 259;
const WIDTH: u16 = 256;

/// Keys of the key directory.
const MODEL_TYPE: u16 = 1024;
const PROJECTION: u16 = 3072;
const LINEAR_UNIT: u16 = 3076;
const VERTICAL_UNIT: u16 = 4099;

/// Coordinates are degrees.
const GEOGRAPHIC: u16 = 2;

pub(super) type Tiff<'a> = Decoder<Cursor<&'a [u8]>>;

/// What a TIFF library finds wrong.
fn wrong(file: &File, place: Place, error: &TiffError) -> SampleError {
    file.wrong(place, error)
}

/// The numbers of a tag, if it is there.
fn numbers(file: &File, tiff: &mut Tiff, tag: u16) -> Result<Option<Vec<f64>>, SampleError> {
    let error = |error: TiffError| wrong(file, Place::Tag(tag), &error);
    tiff.find_tag(Tag::from_u16_exhaustive(tag)).map_err(error)?.map(|value| value.into_f64_vec().map_err(error)).transpose()
}

/// The directory of keys whose values stand in it.
fn keys(file: &File, tiff: &mut Tiff) -> Result<Vec<[u16; 2]>, SampleError> {
    let error = |error: TiffError| wrong(file, Place::Tag(GEO_KEYS), &error);
    let Some(value) = tiff.find_tag(Tag::from_u16_exhaustive(GEO_KEYS)).map_err(error)? else { return Ok(Vec::new()) };
    let words = value.into_u16_vec().map_err(error)?;
    let entries = words.as_chunks::<4>().0.iter().skip(1);
    Ok(entries.filter(|[_, location, ..]| *location == 0).map(|[key, _, _, value]| [*key, *value]).collect())
}

/// The unit of a code of EPSG.
fn unit(file: &File, key: u16, code: u16) -> Result<Unit, SampleError> {
    match code {
        9001 => Ok(Unit::Metres),
        9002 => Ok(Unit::Feet),
        9003 => Ok(Unit::UsSurveyFeet),
        _ => Err(file.error(Place::Tag(GEO_KEYS), format!("key {key} is unit {code}; known are 9001 (metres), 9002 (feet), 9003 (US survey feet)"))),
    }
}

/// Spacings in the units of the coordinates, and the northern edge.
fn scale(file: &File, tiff: &mut Tiff) -> Result<Option<([f64; 2], f64)>, SampleError> {
    if let Some(matrix) = numbers(file, tiff, TRANSFORMATION)? {
        let [x, xy, _, _, yx, y, _, north, ..] = matrix[..] else {
            return Err(file.error(Place::Tag(TRANSFORMATION), format!("must have 16 numbers, has {}", matrix.len())));
        };
        if xy != 0.0 || yx != 0.0 {
            return Err(file.error(Place::Tag(TRANSFORMATION), "the grid is turned: rows must run from west to east"));
        }
        return Ok(Some(([x.abs(), y.abs()], north)));
    }
    let Some(scale) = numbers(file, tiff, PIXEL_SCALE)? else { return Ok(None) };
    let [x, y, ..] = scale[..] else { return Err(file.error(Place::Tag(PIXEL_SCALE), format!("must have 3 numbers, has {}", scale.len()))) };
    let tie = numbers(file, tiff, TIE_POINT)?.unwrap_or_default();
    let north = if let [_, row, _, _, north, ..] = tie[..] { north + row * y } else { 0.0 };
    Ok(Some(([x, y], north)))
}

/// Spacings in metres, if the file has a place on the ground.
fn spacing(file: &File, tiff: &mut Tiff, keys: &[[u16; 2]], rows: usize, notes: &mut Vec<String>) -> Result<Option<[f64; 2]>, SampleError> {
    if file.hints.spacing.is_some() {
        return Ok(None);
    }
    let Some((scale, north)) = scale(file, tiff)? else { return Ok(None) };
    let key = |wanted: u16| keys.iter().find(|[key, _]| *key == wanted).map(|[_, value]| *value);
    if key(MODEL_TYPE) == Some(GEOGRAPHIC) {
        let (metres, note) = degrees::spacing(file, scale, north - scale[1] * rows as f64 / 2.0)?;
        notes.push(note);
        return Ok(Some(metres));
    }
    if key(PROJECTION) == Some(3857) {
        notes.push("metres of EPSG:3857 are taken as metres of the ground, which they are at the equator; say `spacing` where they are not".to_owned());
    }
    let metres = key(LINEAR_UNIT).map_or(Ok(Unit::Metres), |code| unit(file, LINEAR_UNIT, code))?.metres();
    Ok(Some(scale.map(|units| units * metres)))
}

/// Samples of any type as floats.
fn floats(samples: DecodingResult) -> Vec<f32> {
    match samples {
        DecodingResult::U8(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::I8(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::U16(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::I16(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::U32(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
        DecodingResult::I32(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
        DecodingResult::U64(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
        DecodingResult::I64(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
        DecodingResult::F16(samples) => samples.into_iter().map(f32::from).collect(),
        DecodingResult::F32(samples) => samples,
        DecodingResult::F64(samples) => samples.into_iter().map(|sample| sample as f32).collect(),
    }
}

/// Columns, rows and bytes of a sample, once they are known to be possible.
fn layout(file: &File, tiff: &mut Tiff) -> Result<[usize; 3], SampleError> {
    let error = |error: TiffError| wrong(file, Place::Tag(WIDTH), &error);
    let (columns, rows) = tiff.dimensions().map_err(error)?;
    let (columns, rows) = (columns as usize, rows as usize);
    let cells = file.cells(Place::Tag(WIDTH), columns, rows)?;
    let ColorType::Gray(bits) = tiff.colortype().map_err(error)? else {
        return Err(file.error(Place::Tag(262), "must have one number a cell, has colours or several bands"));
    };
    let bytes = (bits as usize).div_ceil(8);
    let compression = tiff.find_tag_unsigned::<u16>(Tag::Compression).map_err(|error| wrong(file, Place::Tag(COMPRESSION), &error))?;
    let compression = compression.map_or(CompressionMethod::None, CompressionMethod::from_u16_exhaustive);
    let read = [CompressionMethod::None, CompressionMethod::LZW, CompressionMethod::Deflate, CompressionMethod::OldDeflate, CompressionMethod::PackBits];
    if !read.contains(&compression) {
        let has = format!("compression {} is not read: it must be none, LZW, deflate or PackBits", compression.to_u16());
        return Err(file.error(Place::Tag(COMPRESSION), has));
    }
    let ratio = if compression == CompressionMethod::None { 1 } else { MAX_RATIO };
    file.expands(Place::Tag(WIDTH), cells * bytes, ratio)?;
    let (wide, high) = tiff.chunk_dimensions();
    let chunk = (wide as usize).saturating_mul(high.min(rows.max(1) as u32 * 64) as usize).saturating_mul(bytes);
    // Tiles at the border are whole, strips are not.
    file.expands(Place::Tag(WIDTH), if wide as usize == columns { chunk.min(cells * bytes) } else { chunk }, ratio)?;
    Ok([columns, rows, bytes])
}

/// Whether it is made of tiles that are compressed by LZW.
fn tiled_by_lzw(file: &File, tiff: &mut Tiff) -> Result<bool, SampleError> {
    let compression = tiff.find_tag_unsigned::<u16>(Tag::Compression).map_err(|error| wrong(file, Place::Tag(COMPRESSION), &error))?;
    Ok(compression == Some(CompressionMethod::LZW.to_u16()) && tiff.get_chunk_type() == ChunkType::Tile)
}

/// The number that stands for voids.
fn void(file: &File, tiff: &mut Tiff) -> Result<Option<f64>, SampleError> {
    let error = |error: TiffError| wrong(file, Place::Tag(NODATA), &error);
    let Some(value) = tiff.find_tag(Tag::from_u16_exhaustive(NODATA)).map_err(error)? else { return Ok(None) };
    let text = value.into_string().map_err(error)?;
    let text = text.trim_matches(|c: char| c == '\0' || c.is_whitespace());
    let number: f64 = text.parse().map_err(|_ignored: std::num::ParseFloatError| {
        let short: String = text.chars().take(24).collect();
        file.error(Place::Tag(NODATA), format!("must be a number, is {short:?}"))
    })?;
    // Voids that are not numbers are found anyway.
    Ok(Some(number).filter(|number| !number.is_nan()))
}

pub(super) fn read(file: &File) -> Result<Sample, SampleError> {
    let mut tiff = Decoder::new(Cursor::new(file.bytes)).map_err(|error| wrong(file, Place::Byte(0), &error))?;
    let [columns, rows, bytes] = layout(file, &mut tiff)?;
    let keys = keys(file, &mut tiff)?;
    let mut notes = Vec::new();
    let own = spacing(file, &mut tiff, &keys, rows, &mut notes)?;
    let spacing = file.spacing(own)?;
    let vertical = keys.iter().find(|[key, _]| *key == VERTICAL_UNIT).map(|[key, code]| unit(file, *key, *code));
    let vertical = if file.hints.unit.is_some() { None } else { vertical.transpose()? };
    let void = void(file, &mut tiff)?;
    if tiled_by_lzw(file, &mut tiff)? {
        let values = lzw::tiles(file, &mut tiff, [columns, rows, bytes])?;
        return file.finish(Format::Geotiff, Numbers { columns, rows, spacing, values, void, unit: vertical, notes });
    }
    let mut limits = Limits::default();
    limits.decoding_buffer_size = columns * rows * bytes;
    limits.intermediate_buffer_size = MAX_CELLS * bytes;
    let samples = tiff.with_limits(limits).read_image().map_err(|error| wrong(file, Place::Byte(file.bytes.len()), &error))?;
    let values = floats(samples);
    if values.len() != columns * rows {
        return Err(file.error(Place::Tag(WIDTH), format!("{columns} × {rows} cells, but {} numbers", values.len())));
    }
    file.finish(Format::Geotiff, Numbers { columns, rows, spacing, values, void, unit: vertical, notes })
}
