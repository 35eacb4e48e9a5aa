//! Samples without a header.

use super::{Area, writer::Encoder};
use crate::tile::{EncodeError, Steps};

/// Writes metres as f32, or numbers of steps as u16.
pub(super) struct Raw {
    steps: Option<Steps>,
    samples: u64,
}

impl Raw {
    pub(super) fn of(area: &Area, steps: Option<Steps>) -> Self {
        Self { steps, samples: area.window().samples() as u64 }
    }
}

impl Encoder for Raw {
    fn length(&self) -> Option<u64> {
        Some(self.samples * if self.steps.is_some() { 2 } else { 4 })
    }

    fn rows(&mut self, heights: &[f32], out: &mut Vec<u8>) -> Result<(), EncodeError> {
        match self.steps {
            Some(steps) => out.extend(heights.iter().flat_map(|&height| (steps.number(height) as u16).to_le_bytes())),
            None => out.extend(heights.iter().flat_map(|height| height.to_le_bytes())),
        }
        Ok(())
    }
}
