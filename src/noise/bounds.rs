//! What values and slopes noises and fields can have at most.

use super::{
    Basis, Field,
    fractal::{Step, with_step},
    lanes::Plain,
    number::Bound,
};

impl Basis {
    /// The least and the greatest value, or bounds beyond them.
    #[must_use]
    pub fn range(self) -> [f32; 2] {
        match self {
            // Four gradients that meet near the middle of a cell's side-to-side line: 0.984 024.
            Basis::OPerlin => [-0.984_03, 0.984_03],
            Basis::IPerlin | Basis::Blender => [-1.0, 1.0],
            Basis::CellNoise => [0.0, 1.0],
            Basis::Voronoi { feature, metric } => feature.range(metric),
        }
    }

    /// Whether values lie on both sides of zero, evenly.
    pub(super) fn is_signed(self) -> bool {
        matches!(self, Basis::OPerlin | Basis::IPerlin | Basis::Blender)
    }

    /// The greatest slope along an axis, or a bound beyond it, a cell being the unit; infinite if values jump.
    #[must_use]
    pub fn max_slope(self) -> f32 {
        match self {
            // Greatest of the sums over the four corners, each with its best gradient, over all places of a cell: 2.371 42, 2.75 and 1.977 28 · 1.735 427.
            Basis::OPerlin => 2.3715,
            Basis::IPerlin => 2.7501,
            Basis::Blender => 3.4316,
            Basis::CellNoise => f32::INFINITY,
            Basis::Voronoi { feature, metric } => feature.slope(metric),
        }
    }
}

impl Field {
    /// Bounds of all values, by interval arithmetic through the octaves; those of a sum are tight.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        let bound = self.bound();
        [(bound.low as f32).next_down(), (bound.high as f32).next_up()]
    }

    /// A bound of the magnitudes of the slopes along u and along v, a programme unit; infinite if values jump.
    #[must_use]
    pub fn max_slope(&self) -> f32 {
        (self.bound().slope as f32).next_up()
    }

    fn bound(&self) -> Bound {
        let one = Plain::<1>;
        let mut state = self.before(one);
        for octave in &self.octaves {
            let [low, high] = self.basis.range().map(|bound| f64::from(bound) * f64::from(octave.amplitude));
            let slope = f64::from(self.basis.max_slope()) * octave.lattice.frequency * f64::from(octave.amplitude.abs());
            let noise = Bound::new(low.min(high), low.max(high), slope);
            state = with_step!(&octave.step, step => step.after(one, noise, state));
        }
        self.after(one, state)
    }
}
