//! What islands make of the samples of a window.

use crate::{geometry::Stop, layout::LayoutSurface};

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
    /// Shares of all materials, all of a sample together; empty if not wanted.
    pub shares: Vec<f32>,
    /// How many materials there are.
    pub names: usize,
    pub columns: usize,
    pub stop: Stop,
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

    /// Sets the shares of a sample: those of the near form and the one material of the far form, as much of it as is seen. From the middle of the shelf on the
    /// island says nothing of materials.
    pub(super) fn put_shares(&mut self, at: usize, near: &[f32], far: u16, [part, share]: [f64; 2]) {
        let names = self.names;
        let Some(out) = self.shares.get_mut(at * names..(at + 1) * names).filter(|_| share >= 0.5) else { return };
        let near = near.get(..names).unwrap_or_default();
        for (i, out) in out.iter_mut().enumerate() {
            let own = f64::from(near.get(i).copied().unwrap_or(0.0));
            let seen = if usize::from(far) == i + 1 { 1.0 } else { 0.0 };
            *out = (own + (seen - own) * part) as f32;
        }
        let total: f32 = out.iter().sum();
        if total > 0.0 {
            for share in out.iter_mut() {
                *share /= total;
            }
        }
    }
}
