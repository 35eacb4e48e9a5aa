//! Pictures: sketches, edges, weights and profiles out of greys and colours.

use super::{
    canvas::{Canvas, Slots},
    document::{DrawingError, Picture, PictureFile},
};
use crate::noise;
use base64::prelude::{BASE64_STANDARD, Engine as _};
use image::{ImageError, ImageReader, RgbImage};
use std::io::Cursor;

/// Most bytes of a picture's file.
const MAX_BYTES: usize = 16 << 20;

/// Most pixels a side of a profile's picture.
const MAX_SIDE: u32 = 2048;

/// Reads a picture from a `data:` address, if its size, which is looked at first, may be.
fn decode(data: &str, at: &str, check: impl Fn(u32, u32) -> Result<(), String>) -> Result<RgbImage, DrawingError> {
    let wrong = |detail: String| DrawingError::new(format!("{at}/data"), detail);
    let unread = |error: ImageError| wrong(format!("is not a picture that can be read: {error}"));
    let Some((_, text)) = data.strip_prefix("data:image/").and_then(|rest| rest.split_once(";base64,")) else {
        return Err(wrong("must be a picture as a data: address: data:image/png;base64,…".to_owned()));
    };
    if text.len() / 4 * 3 > MAX_BYTES {
        return Err(wrong(format!("must be at most {MAX_BYTES} bytes, got {}", text.len() / 4 * 3)));
    }
    let bytes = BASE64_STANDARD.decode(text).map_err(|error| wrong(format!("is not base64: {error}")))?;
    let reader = || ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(|error| wrong(error.to_string()));
    if reader()?.format().is_none() {
        return Err(wrong("is neither PNG nor JPEG nor WebP".to_owned()));
    }
    let (width, height) = reader()?.into_dimensions().map_err(unread)?;
    check(width, height).map_err(wrong)?;
    Ok(reader()?.decode().map_err(unread)?.to_rgb8())
}

impl Canvas {
    /// A picture of just the drawing's size.
    fn sized(&self, file: &PictureFile, at: &str) -> Result<RgbImage, DrawingError> {
        let [columns, rows] = [self.inner.columns, self.inner.rows].map(|n| n as u32);
        decode(&file.data, at, |width, height| {
            let fits = (width, height) == (columns, rows);
            if fits { Ok(()) } else { Err(format!("must be {columns} × {rows} pixels like the drawing, got {width} × {height}")) }
        })
    }

    /// The slots of a picture's pixels, whose rows run from the north.
    fn pixels(&self) -> impl Iterator<Item = usize> {
        self.drawn_on().rev().flatten()
    }

    /// The grey 0 … 1 of every slot, a file's mirrored at its edges: 0.3 red + 0.59 green + 0.11 blue (Rusnell 2009, Eq. 4.4).
    pub(super) fn greys(&self, picture: &Picture, at: &str) -> Result<Vec<f32>, DrawingError> {
        match picture {
            Picture::Programme(ramp) => {
                let mut ramp = ramp.clone();
                ramp.between = ramp.between.or(Some([0.0, 1.0]));
                self.ramp(&ramp, at)
            }
            Picture::File(file) => {
                let image = self.sized(file, at)?;
                let mut greys = vec![0.0; self.frame.slots()];
                for slot in self.frame.rows_of_slots().flatten() {
                    let [column, row] = self.mirrored(slot);
                    let [red, green, blue] = image.get_pixel(column as u32, (self.inner.rows - 1 - row) as u32).0.map(f32::from);
                    greys[slot] = (0.3 * red + 0.59 * green + 0.11 * blue) / 255.0;
                }
                Ok(greys)
            }
        }
    }

    /// Pixels of a colour.
    pub(super) fn coloured(&self, file: &PictureFile, colour: &str, at: &str) -> Result<Slots, DrawingError> {
        let wanted = colour.strip_prefix('#').filter(|hex| hex.len() == 6).and_then(|hex| u32::from_str_radix(hex, 16).ok());
        let Some(wanted) = wanted else {
            return Err(DrawingError::new(format!("{at}/colour"), format!("must be a colour such as \"#ff0000\", got {colour:?}")));
        };
        let image = self.sized(file, &format!("{at}/picture"))?;
        let is = |pixel: &image::Rgb<u8>| pixel.0.iter().fold(0, |number, c| number << 8 | u32::from(*c)) == wanted;
        Ok(self.pixels().zip(image.pixels()).filter(|(_, pixel)| is(pixel)).map(|(slot, _)| slot as u32).collect())
    }

    /// Where greys change most: 3 × 3 Sobel operators, gradients from halfway between the least and the greatest on.
    pub(super) fn edges(&self, greys: &[f32]) -> Slots {
        let stride = self.frame.stride();
        let inner = || {
            let rows = self.inner.rows;
            self.drawn_on().skip(1).take(rows.saturating_sub(2)).flat_map(|row| row.start + 1..row.end - 1)
        };
        let gradient = |slot: usize| {
            let at = |i: isize, j: isize| f64::from(greys[slot.wrapping_add_signed(j * stride as isize + i)]);
            let x = at(1, -1) + 2.0 * at(1, 0) + at(1, 1) - at(-1, -1) - 2.0 * at(-1, 0) - at(-1, 1);
            let y = at(-1, 1) + 2.0 * at(0, 1) + at(1, 1) - at(-1, -1) - 2.0 * at(0, -1) - at(1, -1);
            (x * x + y * y).sqrt()
        };
        let [low, high] = inner().map(gradient).fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], g| [low.min(g), high.max(g)]);
        let threshold = low + 0.5 * (high - low);
        inner().filter(|slot| high > low && gradient(*slot) >= threshold).map(|slot| slot as u32).collect()
    }

    /// Node number `n` of a series by chance.
    pub(super) fn by_chance(&self, key: u64, n: u64) -> u32 {
        let bits = noise::key(key, n);
        let pick = |bits: u64, count: usize| (((bits & 0xffff_ffff) * count as u64) >> 32) as usize;
        let (column, row) = (pick(bits, self.inner.columns), pick(bits >> 32, self.inner.rows));
        let margin = (self.inner.first.row - self.frame.first.row) as usize;
        ((row + margin + 1) * self.frame.stride() + column + margin + 1) as u32
    }
}

/// The curve of a profile's picture: of each column the uppermost pixel darker than half.
pub(super) fn curve(data: &str, at: &str) -> Result<Vec<[f64; 2]>, DrawingError> {
    let image = decode(data, at, |width, height| {
        if width.max(height) > MAX_SIDE { Err(format!("must be at most {MAX_SIDE} pixels a side, got {width} × {height}")) } else { Ok(()) }
    })?;
    let dark = |x: u32| (0..image.height()).find(|y| image.get_pixel(x, *y).0.iter().map(|c| u32::from(*c)).sum::<u32>() < 3 * 128);
    Ok((0..image.width()).filter_map(|x| dark(x).map(|y| [f64::from(x), -f64::from(y)])).collect())
}
