//! Single noises and fractals over them, with the detail that a spacing cannot carry faded to its mean.
//!
//! Each octave has a lattice of its own (hash and phase). A fractional number of octaves multiplies the last one's contribution by the remainder.

use super::{
    Basis, FieldShape, Isa, Rows,
    cells::Lattice,
    fractal::{Add, AddAbsolute, AnyStep, Multiply, State, Step, with_step},
    lanes::{Lanes, Plain},
    number::{Number, Real, Table},
    opening,
};

/// How much of a lattice with cells of `cell` metres samples `spacing` metres apart can carry: 0 below two samples a cell, 1 from four on.
pub(super) fn carried(cell: f64, spacing: f64) -> f64 {
    let t = (cell / (2.0 * spacing) - 1.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// An octave of a shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub frequency: f64,
    pub weight: f64,
    /// The remainder if the octave is the last of a fractional number, else one.
    pub share: f64,
    /// How much of it the spacing carries.
    pub carried: f64,
}

/// One octave as it is evaluated.
#[derive(Clone, Debug)]
pub(super) struct Octave {
    pub lattice: Lattice,
    /// Factor of the noise.
    pub amplitude: f32,
    /// Spacing of the samples in cells, which edges of cells are made fit for; 0 leaves them sharp.
    pub extent: f32,
    pub step: AnyStep,
}

/// A noise or fractal, ready to be evaluated at programme coordinates.
#[derive(Clone, Debug)]
pub struct Field {
    pub(super) basis: Basis,
    /// The value before the first octave.
    pub(super) start: f32,
    pub(super) octaves: Vec<Octave>,
    /// What octaves that are left out add, over the opening that the last octave leaves.
    pub(super) tail: Option<Table>,
}

impl Field {
    /// The field as it is.
    #[must_use]
    pub fn exact(shape: FieldShape, basis: Basis, key: u64) -> Self {
        Self::new(shape, basis, key, 0.0, |_| 1.0)
    }

    /// The field as samples `spacing` programme units apart can carry it: octaves with cells below four spacings fade, to be gone at two, to their mean.
    #[must_use]
    pub fn banded(shape: FieldShape, basis: Basis, key: u64, spacing: f64) -> Self {
        Self::new(shape, basis, key, spacing, |frequency| carried(1.0 / frequency, spacing))
    }

    pub(super) fn new(shape: FieldShape, basis: Basis, key: u64, spacing: f64, carried: impl Fn(f64) -> f64) -> Self {
        let (count, frequency_ratio, weight_ratio) = shape.progression();
        let (mut frequency, mut weight) = (1.0_f64, 1.0_f64);
        let mut parts = Vec::with_capacity(shape.octaves());
        for k in 0..shape.octaves() {
            parts.push(Part { frequency, weight, share: (count - k as f64).min(1.0), carried: carried(frequency) });
            frequency *= frequency_ratio;
            weight *= weight_ratio;
        }
        let octave = |k: usize, amplitude: f64, step: AnyStep| Octave {
            lattice: Lattice::new(key, k as u32, parts[k].frequency),
            amplitude: amplitude as f32,
            // Only where the noise enters as it is: the mean of a square is not the square of its mean.
            extent: if shape.is_linear() { (spacing * parts[k].frequency) as f32 } else { 0.0 },
            step,
        };
        let moments = basis.moments();
        match shape {
            FieldShape::Ridged { offset, gain, .. } => opening::ridged(basis, &parts, offset, gain, octave),
            FieldShape::Hybrid { offset, gain, .. } => opening::hybrid(basis, &parts, offset, gain, octave),
            FieldShape::Multifractal { .. } => Self::product(basis, &parts, octave, |_, w| (1.0, w)),
            FieldShape::Hetero { offset, .. } => Self::product(basis, &parts, octave, |k, w| if k == 0 { (offset, w) } else { (1.0 + w * offset, w) }),
            FieldShape::Turbulence { hard: true, .. } => Self::sum(basis, &parts, octave, &AnyStep::AddAbsolute(AddAbsolute), moments.absolute, 1.0),
            FieldShape::Spectral { .. } => {
                let total: f64 = parts.iter().map(|part| part.weight * part.share).sum();
                Self::sum(basis, &parts, octave, &AnyStep::Add(Add), moments.mean, 1.0 / total)
            }
            _ => Self::sum(basis, &parts, octave, &AnyStep::Add(Add), moments.mean, 1.0),
        }
    }

    /// Σ w n, or of |n|; what is left out adds its mean beforehand.
    fn sum(basis: Basis, parts: &[Part], octave: impl Fn(usize, f64, AnyStep) -> Octave, step: &AnyStep, mean: f64, scale: f64) -> Self {
        let weights = || parts.iter().map(|part| part.weight * part.share * scale);
        let start: f64 = parts.iter().zip(weights()).map(|(part, weight)| weight * (1.0 - part.carried) * mean).sum();
        let kept = parts.iter().zip(weights()).enumerate().filter(|(_, (part, _))| part.carried > 0.0);
        let octaves = kept.map(|(k, (part, weight))| octave(k, weight * part.carried, step.clone())).collect();
        Self { basis, start: start as f32, octaves, tail: None }
    }

    /// Π (base + w n), each octave's `factors` being base and w; octaves are independent, so the mean of what is left out is the product of means.
    fn product(basis: Basis, parts: &[Part], octave: impl Fn(usize, f64, AnyStep) -> Octave, factors: impl Fn(usize, f64) -> (f64, f64)) -> Self {
        let mean = basis.moments().mean;
        let (mut start, mut octaves) = (1.0, Vec::new());
        for (k, part) in parts.iter().enumerate() {
            let (base, weight) = factors(k, part.weight * part.share);
            let base = base + weight * (1.0 - part.carried) * mean;
            if part.carried > 0.0 {
                octaves.push(octave(k, weight * part.carried, AnyStep::Multiply(Multiply { base: base as f32 })));
            } else {
                start *= base;
            }
        }
        Self { basis, start: start as f32, octaves, tail: None }
    }

    /// The value at programme coordinates: the definition that [`Rows`] and [`Field::points`] are held to.
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> f32 {
        let one = Plain::<1>;
        let mut state = self.before(one);
        for octave in &self.octaves {
            let noise = Real(one.splat(self.basis.at(&octave.lattice, octave.amplitude, octave.extent, u, v)));
            state = with_step!(&octave.step, step => step.after(one, noise, state));
        }
        let Real(value) = self.after(one, state);
        value.0[0]
    }

    /// The state before the first octave.
    #[inline(always)]
    pub(super) fn before<L: Lanes, N: Number<L>>(&self, lanes: L) -> State<N> {
        State { value: N::constant(lanes, self.start), opening: N::constant(lanes, 1.0) }
    }

    /// The value after the last octave.
    #[inline(always)]
    pub(super) fn after<L: Lanes, N: Number<L>>(&self, lanes: L, state: State<N>) -> N {
        match &self.tail {
            Some(tail) => state.value.plus(state.opening.interpolated(lanes, tail)),
            None => state.value,
        }
    }

    /// The same along rows of samples at the given columns (programme coordinates, ascending), on the instruction set that is active.
    #[must_use]
    pub fn rows(&self, coordinates: &[f64]) -> Rows {
        self.rows_on(Isa::active(), coordinates)
    }

    /// The same on a given instruction set.
    #[must_use]
    pub fn rows_on(&self, isa: Isa, coordinates: &[f64]) -> Rows {
        Rows::new(self, isa, coordinates)
    }
}
