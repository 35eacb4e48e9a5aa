//! Tiles of TIFFs that are compressed by LZW.
//!
//! The library that reads all other TIFFs stops at tiles that reach over the border (image-tiff, issue 395). Such tiles are common among elevations, so they are read here.

use super::{File, Place, SampleError, geotiff::Tiff};
use tiff::tags::Tag;
use weezl::{BitOrder, LzwStatus, decode::Configuration};

/// What numbers of a sample are (TIFF 6.0, `SampleFormat`; technical note 3 for the predictor of floats).
#[derive(Clone, Copy)]
struct Numbers {
    /// 1 unsigned, 2 with sign, 3 floats.
    format: u16,
    bytes: usize,
    /// 1 as they are, 2 differences along rows, 3 differences of bytes of floats along rows.
    predictor: u16,
    big_endian: bool,
}

impl Numbers {
    fn of(file: &File, tiff: &mut Tiff, bytes: usize) -> Result<Self, SampleError> {
        let mut tag = |tag: Tag| {
            let wrong = |error: tiff::TiffError| file.wrong(Place::Tag(tag.to_u16()), &error);
            tiff.find_tag_unsigned::<u16>(tag).map(|value| value.unwrap_or(1)).map_err(wrong)
        };
        let (format, predictor) = (tag(Tag::SampleFormat)?, tag(Tag::Predictor)?);
        let floats = matches!((format, bytes), (3, 4 | 8));
        if !(floats || (matches!(format, 1 | 2) && matches!(bytes, 1 | 2 | 4 | 8))) {
            let has = format!("numbers of format {format} with {bytes} bytes are not read: they must be integers or floats of 32 or 64 bits");
            return Err(file.error(Place::Tag(Tag::SampleFormat.to_u16()), has));
        }
        if !(matches!(predictor, 1 | 2) || (predictor == 3 && floats)) {
            return Err(file.error(Place::Tag(Tag::Predictor.to_u16()), format!("predictor {predictor} is not read: it must be 1, 2, or for floats 3")));
        }
        Ok(Self { format, bytes, predictor, big_endian: file.bytes.starts_with(b"M") })
    }

    /// The numbers of a row of a tile, whose bytes are changed.
    fn row(self, row: &mut [u8]) -> impl Iterator<Item = f32> {
        let count = row.len() / self.bytes;
        if self.predictor == 3 {
            for i in 1..row.len() {
                row[i] = row[i].wrapping_add(row[i - 1]);
            }
        }
        let mask = u64::MAX >> (64 - 8 * self.bytes as u32);
        let mut before = 0_u64;
        (0..count).map(move |i| {
            let byte = |k: usize| match (self.predictor, self.big_endian) {
                // All first bytes stand before all second ones.
                (3, _) => row[k * count + i],
                (_, true) => row[i * self.bytes + k],
                (_, false) => row[i * self.bytes + self.bytes - 1 - k],
            };
            let mut bits = (0..self.bytes).fold(0_u64, |bits, k| bits << 8 | u64::from(byte(k)));
            if self.predictor == 2 {
                bits = bits.wrapping_add(before) & mask;
                before = bits;
            }
            self.number(bits)
        })
    }

    fn number(self, bits: u64) -> f32 {
        match (self.format, self.bytes) {
            (3, 4) => f32::from_bits(bits as u32),
            (3, _) => f64::from_bits(bits) as f32,
            (2, bytes) => {
                let unused = 64 - 8 * bytes as u32;
                ((bits << unused) as i64 >> unused) as f32
            }
            _ => bits as f32,
        }
    }
}

/// Expands a tile and says how many bytes it has: what follows the last byte that is needed does not matter, nor whether the end is marked.
fn expand(mut compressed: &[u8], out: &mut [u8]) -> usize {
    let mut decoder = Configuration::with_tiff_size_switch(BitOrder::Msb, 8).build();
    let mut length = 0;
    while length < out.len() {
        let step = decoder.decode_bytes(compressed, &mut out[length..]);
        compressed = &compressed[step.consumed_in..];
        length += step.consumed_out;
        if !matches!(step.status, Ok(LzwStatus::Ok)) {
            break;
        }
    }
    length
}

/// The samples of an image of tiles.
pub(super) fn tiles(file: &File, tiff: &mut Tiff, [columns, rows, bytes]: [usize; 3]) -> Result<Vec<f32>, SampleError> {
    let numbers = Numbers::of(file, tiff, bytes)?;
    let (wide, high) = tiff.chunk_dimensions();
    let (wide, high) = (wide as usize, high as usize);
    let mut list = |tag: Tag| tiff.get_tag_u64_vec(tag).map_err(|error| file.wrong(Place::Tag(tag.to_u16()), &error));
    let (offsets, counts) = (list(Tag::TileOffsets)?, list(Tag::TileByteCounts)?);
    if wide == 0 || high == 0 {
        return Err(file.error(Place::Tag(Tag::TileWidth.to_u16()), "tiles must have columns and rows"));
    }
    let across = columns.div_ceil(wide);
    let expected = across * rows.div_ceil(high);
    if offsets.len() != expected || counts.len() != expected {
        let has = format!("{expected} tiles must have as many places and lengths, has {} and {}", offsets.len(), counts.len());
        return Err(file.error(Place::Tag(Tag::TileOffsets.to_u16()), has));
    }
    // Tiles that are not stored are void.
    let mut values = vec![f32::NAN; columns * rows];
    let mut tile = vec![0; wide * high * bytes];
    for (number, (offset, count)) in offsets.into_iter().zip(counts).enumerate().filter(|(_, (_, count))| *count > 0) {
        let place = Place::Byte((offset as usize).min(file.bytes.len()));
        let end = offset.checked_add(count).filter(|end| *end <= file.bytes.len() as u64);
        let end = end.ok_or_else(|| file.error(place, format!("tile {number} has {count} bytes here: the file is cut short")))?;
        let length = expand(&file.bytes[offset as usize..end as usize], &mut tile);
        if length < tile.len() {
            return Err(file.error(place, format!("tile {number} ends after {length} of {} bytes", tile.len())));
        }
        let (column, row) = (number % across * wide, number / across * high);
        for (row, bytes) in (row..rows.min(row + high)).zip(tile.chunks_exact_mut(wide * bytes)) {
            let out = &mut values[row * columns..][column..columns.min(column + wide)];
            out.iter_mut().zip(numbers.row(bytes)).for_each(|(value, number)| *value = number);
        }
    }
    Ok(values)
}
