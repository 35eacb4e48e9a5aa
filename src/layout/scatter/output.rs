//! What islands make of the samples of a window.

use crate::layout::LayoutSurface;

/// What an island says at a sample.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    pub elevation: f64,
    pub depth: f64,
    pub cover: f64,
    /// The share that is known to be dry though its mean height lies below the sea.
    pub dry: f64,
    pub material: u16,
}

impl Sample {
    pub(super) fn mixed(&self, other: &Self, part: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * part;
        Self {
            elevation: mix(self.elevation, other.elevation),
            depth: mix(self.depth, other.depth),
            cover: mix(self.cover, other.cover),
            dry: mix(self.dry, other.dry),
            material: if part < 0.5 { self.material } else { other.material },
        }
    }
}

/// What is being evaluated.
pub(super) struct Output {
    pub surface: LayoutSurface,
    pub materials: Vec<u16>,
    pub columns: usize,
}

impl Output {
    /// Mixes a sample in.
    pub(super) fn put(&mut self, at: usize, sample: &Sample, share: f64) {
        let mix = |out: &mut f32, to: f64| *out = (f64::from(*out) + (to - f64::from(*out)) * share) as f32;
        let LayoutSurface { elevation, water_depth, water_cover, dry, .. } = &mut self.surface;
        mix(&mut elevation[at], sample.elevation);
        mix(&mut water_depth[at], sample.depth);
        if let (Some(cover), Some(dry)) = (water_cover.get_mut(at), dry.get_mut(at)) {
            mix(cover, sample.cover);
            mix(dry, sample.dry);
        }
        if let Some(material) = self.materials.get_mut(at).filter(|_| share >= 0.5) {
            *material = sample.material;
        }
    }
}
