//! `GeoTIFF`: elevations as 32-bit floats with their place on the plane.
//!
//! Nothing is compressed, so where every row lies is known before the first is evaluated: the directory comes first and the file can be streamed.

use super::{Area, writer::Encoder};
use crate::tile::EncodeError;

/// `GeoKeys` (OGC 19-008r4): a projected model, pixels as areas, EPSG:3857, vertical units of metres (EPSG:9001).
const GEO_KEYS: [u16; 20] = [1, 1, 0, 4, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 3857, 4099, 0, 1, 9001];

/// Bytes of a strip, for rows that are not longer.
const STRIP_BYTES: usize = 1 << 18;

/// The values of a tag.
enum Values {
    Shorts(Vec<u16>),
    Longs(Vec<u32>),
    Doubles(Vec<f64>),
}

impl Values {
    /// The number of the type (TIFF 6.0), and how many there are.
    fn kind(&self) -> (u16, usize) {
        match self {
            Values::Shorts(values) => (3, values.len()),
            Values::Longs(values) => (4, values.len()),
            Values::Doubles(values) => (12, values.len()),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Values::Shorts(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::Longs(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Values::Doubles(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}

/// All that comes before the samples of a classic, little-endian TIFF: header and directory. Areas stay far below the 4 GiB that it can address.
fn head(area: &Area) -> Vec<u8> {
    let window = area.window();
    let (columns, rows, spacing) = (window.columns.len(), window.rows.len(), window.spacing());
    // Pixels are squares around samples, wherever these stand.
    let (west, north) = (window.columns.coordinate(0) - spacing / 2.0, window.rows.coordinate(0) + spacing / 2.0);
    let strip_rows = (STRIP_BYTES / (columns * 4)).clamp(1, rows);
    let lengths: Vec<u32> = (0..rows).step_by(strip_rows).map(|row| (strip_rows.min(rows - row) * columns * 4) as u32).collect();
    let tags = |offset: u32| {
        let offsets = lengths.iter().scan(offset, |at, length| Some(std::mem::replace(at, *at + length))).collect();
        [
            (256, Values::Longs(vec![columns as u32])),
            (257, Values::Longs(vec![rows as u32])),
            (258, Values::Shorts(vec![32])),
            (259, Values::Shorts(vec![1])),
            (262, Values::Shorts(vec![1])),
            (273, Values::Longs(offsets)),
            (277, Values::Shorts(vec![1])),
            (278, Values::Longs(vec![strip_rows as u32])),
            (279, Values::Longs(lengths.clone())),
            (284, Values::Shorts(vec![1])),
            // Floats.
            (339, Values::Shorts(vec![3])),
            (33550, Values::Doubles(vec![spacing, spacing, 0.0])),
            (33922, Values::Doubles(vec![0.0, 0.0, 0.0, west, north, 0.0])),
            (34735, Values::Shorts(GEO_KEYS.to_vec())),
        ]
    };
    // How long the directory is does not depend on where the samples are.
    let length = directory(&tags(0)).len();
    directory(&tags(length as u32))
}

/// Header and directory of tags, which ascend, with the values that find no room in it after it; padded so that samples are aligned.
fn directory(tags: &[(u16, Values)]) -> Vec<u8> {
    const HEADER: [u8; 8] = *b"II*\0\x08\0\0\0";
    let mut far = Vec::new();
    let mut directory = [&HEADER[..], &(tags.len() as u16).to_le_bytes()].concat();
    let far_at = directory.len() + tags.len() * 12 + 4;
    for (tag, values) in tags {
        let ((kind, count), mut bytes) = (values.kind(), values.bytes());
        directory.extend_from_slice(&tag.to_le_bytes());
        directory.extend_from_slice(&kind.to_le_bytes());
        directory.extend_from_slice(&(count as u32).to_le_bytes());
        if bytes.len() > 4 {
            directory.extend_from_slice(&((far_at + far.len()) as u32).to_le_bytes());
            far.append(&mut bytes);
            far.resize(far.len().next_multiple_of(2), 0);
        } else {
            bytes.resize(4, 0);
            directory.append(&mut bytes);
        }
    }
    // There is no other directory.
    directory.extend_from_slice(&[0; 4]);
    directory.append(&mut far);
    directory.resize(directory.len().next_multiple_of(16), 0);
    directory
}

/// Writes the samples of an area with their place; plane metres are Web Mercator metres, so GIS tools lay it over the tiles of the `web` grid.
pub(super) struct GeoTiff {
    head: Vec<u8>,
    samples: u64,
}

impl GeoTiff {
    pub(super) fn of(area: &Area) -> Self {
        Self { head: head(area), samples: area.window().samples() as u64 }
    }
}

impl Encoder for GeoTiff {
    fn length(&self) -> Option<u64> {
        Some(self.head.len() as u64 + self.samples * 4)
    }

    fn head(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.head)
    }

    fn rows(&mut self, heights: &[f32], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        out.extend(heights.iter().flat_map(|height| height.to_le_bytes()));
        Ok(())
    }
}
