//! From the heights of parts to the bytes of a file.

use super::{Area, AreaFormat, cut::Cut, geotiff::GeoTiff, glb::Glb, obj::Obj, png16::Png16, raw::Raw};
use crate::{
    geometry::{Legend, Source},
    tile::{EncodeError, Steps},
};
use rayon::prelude::*;
use std::io::{self, Write};

/// Parts that are evaluated at a time, a thread: enough that those who are done early find more to do.
const PARTS_A_THREAD: usize = 4;

/// A format, which gets rows from north to south.
pub(super) trait Encoder: Send {
    /// The length of the file in bytes, where it is known before its samples.
    fn length(&self) -> Option<u64> {
        None
    }

    /// What comes before the samples.
    fn head(&mut self) -> Vec<u8> {
        Vec::new()
    }

    /// The next rows, whole ones.
    fn rows(&mut self, heights: &[f32], out: &mut Vec<u8>) -> Result<(), EncodeError>;

    /// What comes after the last row, piece by piece.
    fn tail(&mut self) -> Result<Option<Vec<u8>>, EncodeError> {
        Ok(None)
    }
}

/// Writes a file of an area from the heights of its parts, which come in their order: [`AreaWriter::head`], [`AreaWriter::put`] for every part,
/// [`AreaWriter::tail`] until there is nothing more. How the bytes are divided among them means nothing.
pub struct AreaWriter {
    cut: Cut,
    /// The part that comes next.
    next: usize,
    /// Rows whose parts come now.
    band: Vec<f32>,
    encoder: Box<dyn Encoder>,
}

impl AreaWriter {
    /// For a world with a legend.
    ///
    /// # Errors
    /// If the encoder refuses the area.
    pub fn new(area: &Area, legend: &Legend) -> Result<Self, EncodeError> {
        let steps = Steps::of_16_bits(legend.range);
        let encoder: Box<dyn Encoder> = match area.format {
            AreaFormat::GeoTiff => Box::new(GeoTiff::of(area)),
            AreaFormat::R16 => Box::new(Raw::of(area, Some(steps))),
            AreaFormat::R32 => Box::new(Raw::of(area, None)),
            AreaFormat::Png16 => Box::new(Png16::of(area, steps)?),
            AreaFormat::Obj => Box::new(Obj::of(area)),
            AreaFormat::Gltf => Box::new(Glb::of(area)),
        };
        Ok(Self { cut: area.cut, next: 0, band: Vec::new(), encoder })
    }

    /// The length of the file in bytes, where it is known before its samples. It is to be asked for before anything is written.
    #[must_use]
    pub fn length(&self) -> Option<u64> {
        self.encoder.length()
    }

    /// What comes before the samples.
    #[must_use]
    pub fn head(&mut self) -> Vec<u8> {
        self.encoder.head()
    }

    /// The bytes that the heights of the next part complete; none until a band of rows is whole.
    ///
    /// # Errors
    /// If the encoder fails.
    ///
    /// # Panics
    /// If they are not as many as the part has samples, or all parts were there.
    pub fn put(&mut self, heights: &[f32]) -> Result<Vec<u8>, EncodeError> {
        let [[_, rows], [column, columns]] = self.cut.place(self.next);
        assert_eq!(heights.len(), rows * columns, "part {}", self.next);
        let width = self.cut.window.columns.len();
        self.band.resize(rows * width, 0.0);
        for (row, part) in self.band.chunks_exact_mut(width).zip(heights.chunks_exact(columns)) {
            row[column..column + columns].copy_from_slice(part);
        }
        self.next += 1;
        let mut out = Vec::new();
        if column + columns == width {
            self.encoder.rows(&self.band, &mut out)?;
        }
        Ok(out)
    }

    /// What comes after the samples, piece by piece; `None` at the end.
    ///
    /// # Errors
    /// If the encoder fails.
    pub fn tail(&mut self) -> Result<Option<Vec<u8>>, EncodeError> {
        self.encoder.tail()
    }
}

/// Writes a file of an area, on all threads of the present rayon pool.
///
/// # Errors
/// If writing fails, or the encoder does.
pub fn write_area(source: &(impl Source + Sync), area: &Area, mut to: impl Write) -> io::Result<()> {
    let mut writer = AreaWriter::new(area, &source.legend()).map_err(io::Error::other)?;
    to.write_all(&writer.head())?;
    let step = PARTS_A_THREAD * rayon::current_num_threads();
    for first in (0..area.parts()).step_by(step) {
        let parts: Vec<_> = (first..area.parts().min(first + step)).into_par_iter().map(|part| area.evaluate(source, part)).collect();
        for heights in parts {
            to.write_all(&writer.put(&heights).map_err(io::Error::other)?)?;
        }
    }
    while let Some(piece) = writer.tail().map_err(io::Error::other)? {
        to.write_all(&piece)?;
    }
    to.flush()
}
