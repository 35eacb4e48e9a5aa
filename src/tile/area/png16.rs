//! Greys of 16 bits, compressed while they come.

use super::{Area, writer::Encoder};
use crate::tile::{EncodeError, Steps};
use png::{BitDepth, ColorType, Compression, Filter, StreamWriter};
use std::{
    io::{self, Write},
    sync::{Arc, Mutex, PoisonError},
};

/// Bytes of a chunk of compressed samples.
const CHUNK_BYTES: usize = 1 << 16;

/// Takes what the compressor gives, which keeps it to itself.
#[derive(Clone, Default)]
struct Taken(Arc<Mutex<Vec<u8>>>);

impl Taken {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Taken {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes steps over a vertical range.
pub(super) struct Png16 {
    taken: Taken,
    /// `None` once all is written.
    stream: Option<StreamWriter<'static, Taken>>,
    steps: Steps,
}

impl Png16 {
    pub(super) fn of(area: &Area, steps: Steps) -> Result<Self, EncodeError> {
        let (window, taken) = (area.window(), Taken::default());
        let mut encoder = png::Encoder::new(taken.clone(), window.columns.len() as u32, window.rows.len() as u32);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(BitDepth::Sixteen);
        // As tiles are.
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Paeth);
        let stream = encoder.write_header()?.into_stream_writer_with_size(CHUNK_BYTES)?;
        Ok(Self { taken, stream: Some(stream), steps })
    }
}

impl Encoder for Png16 {
    fn rows(&mut self, heights: &[f32], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let numbers: Vec<u8> = heights.iter().flat_map(|&height| (self.steps.number(height) as u16).to_be_bytes()).collect();
        if let Some(stream) = &mut self.stream {
            stream.write_all(&numbers).map_err(png::EncodingError::from)?;
        }
        out.append(&mut self.taken.take());
        Ok(())
    }

    fn tail(&mut self) -> Result<Option<Vec<u8>>, EncodeError> {
        let Some(stream) = self.stream.take() else { return Ok(None) };
        stream.finish()?;
        Ok(Some(self.taken.take()))
    }
}
