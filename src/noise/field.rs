//! Single noises and fractals over them, with the detail that a spacing cannot carry faded to its mean.
//!
//! Fractals are those of F. K. Musgrave (Ebert et al., *Texturing and Modeling*, 3rd edition, chapter 16), weights `w_k` = lacunarity^(-k H). Each octave has a
//! lattice of its own (hash and phase). A fractional number of octaves multiplies the last one's contribution by the remainder.

use super::{Basis, Isa, Kernel, basis::BasisRows, cells::Lattice};

/// How octaves of a basis become one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldShape {
    /// The basis itself.
    Single,
    /// Σ `w_k` `n_k`.
    Fbm {
        /// Fractal increment H, 0 … 4.
        h: f64,
        /// Ratio of the frequencies of neighbouring octaves, 1.1 … 8.
        lacunarity: f64,
        /// 1 … 32.
        octaves: f64,
    },
    /// s = (offset - |`n_0|)²`, v = s; then s = (offset - |`n_k|)²` · clamp(gain · s, 0, 1), v += s `w_k`.
    Ridged {
        /// Fractal increment H, 0 … 4.
        h: f64,
        /// Ratio of the frequencies of neighbouring octaves, 1.1 … 8.
        lacunarity: f64,
        /// 1 … 32.
        octaves: f64,
        /// What |n| is taken from.
        offset: f64,
        /// How strongly an octave's signal opens the next.
        gain: f64,
    },
    /// Π (1 + `w_k` `n_k`).
    Multifractal {
        /// Fractal increment H, 0 … 4.
        h: f64,
        /// Ratio of the frequencies of neighbouring octaves, 1.1 … 8.
        lacunarity: f64,
        /// 1 … 32.
        octaves: f64,
    },
    /// v = `n_0` + offset; then v += `w_k` (`n_k` + offset) v.
    Hetero {
        /// Fractal increment H, 0 … 4.
        h: f64,
        /// Ratio of the frequencies of neighbouring octaves, 1.1 … 8.
        lacunarity: f64,
        /// 1 … 32.
        octaves: f64,
        /// What is added to n.
        offset: f64,
    },
    /// v = `n_0` + offset, g = gain · v; then g = min(g, 1), s = (`n_k` + offset) `w_k`, v += g s, g *= gain · s.
    Hybrid {
        /// Fractal increment H, 0 … 4.
        h: f64,
        /// Ratio of the frequencies of neighbouring octaves, 1.1 … 8.
        lacunarity: f64,
        /// 1 … 32.
        octaves: f64,
        /// What is added to n.
        offset: f64,
        /// How strongly an octave's signal opens the next.
        gain: f64,
    },
    /// An endless random surface whose profiles have the power spectrum f^-beta: fBm of lacunarity 2 and H = (beta - 1)/2, its weights divided by their sum.
    Spectral {
        /// 1 … 3.
        beta: f64,
        /// 1 … 32.
        octaves: f64,
    },
    /// Σ amplitude^k `n_k` at frequency^k; |`n_k`| if `hard`.
    Turbulence {
        /// 1 … 32.
        octaves: f64,
        /// Ratio of the amplitudes of neighbouring octaves.
        amplitude: f64,
        /// Ratio of their frequencies.
        frequency: f64,
        /// Whether absolute values are added.
        hard: bool,
    },
}

impl FieldShape {
    /// Number of octaves (possibly fractional), ratio of frequencies and ratio of weights from octave to octave.
    fn progression(self) -> (f64, f64, f64) {
        match self {
            FieldShape::Single => (1.0, 1.0, 1.0),
            FieldShape::Fbm { h, lacunarity, octaves }
            | FieldShape::Multifractal { h, lacunarity, octaves }
            | FieldShape::Hetero { h, lacunarity, octaves, .. }
            | FieldShape::Hybrid { h, lacunarity, octaves, .. }
            | FieldShape::Ridged { h, lacunarity, octaves, .. } => (octaves, lacunarity, libm::pow(lacunarity, -h)),
            FieldShape::Spectral { beta, octaves } => (octaves, 2.0, libm::pow(2.0, (1.0 - beta) / 2.0)),
            FieldShape::Turbulence { octaves, amplitude, frequency, .. } => (octaves, frequency, amplitude),
        }
    }

    /// Number of octaves, whole or begun.
    #[must_use]
    pub fn octaves(self) -> usize {
        self.progression().0.ceil() as usize
    }
}

/// How much of a lattice with cells of `cell` metres samples `spacing` metres apart can carry: 0 below two samples a cell, 1 from four on.
fn carried(cell: f64, spacing: f64) -> f64 {
    let t = (cell / (2.0 * spacing) - 1.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// One octave as it is evaluated.
#[derive(Clone, Copy, Debug)]
struct Octave {
    lattice: Lattice,
    /// Factor of the noise: the octave's weight and what the spacing carries, where both are linear in the noise.
    amplitude: f32,
    /// Weight of a ridged octave's signal.
    weight: f32,
    /// What the spacing carries of a ridged octave.
    carried: f32,
    /// The spacing in cells that edges are made fit for.
    extent: f32,
}

/// How octaves are put together.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Sum { hard: bool },
    Ridged(Ridge),
}

/// How ridged octaves follow each other.
#[derive(Clone, Copy, Debug)]
struct Ridge {
    offset: f32,
    gain: f32,
    /// The mean of (offset - |n|)².
    mean_signal: f32,
    mean_opening: [f32; STEPS + 1],
}

/// The value so far, and how far the next octave is opened.
#[derive(Clone, Copy, Debug)]
struct Ridged {
    value: f32,
    opening: f32,
}

impl Ridge {
    /// Adds an octave that the spacing carries whole.
    #[inline(always)]
    fn add_whole(&self, octave: &Octave, n: f32, before: Ridged) -> Ridged {
        let crest = self.offset - n.abs();
        let signal = crest * crest * before.opening;
        Ridged { value: before.value + signal * octave.weight, opening: (self.gain * signal).clamp(0.0, 1.0) }
    }

    /// Adds an octave that the spacing carries in part or not at all.
    #[inline(always)]
    fn add_part(&self, octave: &Octave, n: f32, before: Ridged) -> Ridged {
        let crest = self.offset - n.abs();
        let whole = crest * crest * before.opening;
        let open = (self.gain * whole).clamp(0.0, 1.0);
        let (left_out, left_open) = (self.mean_signal * before.opening, interpolate(&self.mean_opening, before.opening));
        let signal = left_out + octave.carried * (whole - left_out);
        Ridged { value: before.value + signal * octave.weight, opening: left_open + octave.carried * (open - left_open) }
    }
}

/// Steps of the table of mean openings.
const STEPS: usize = 16;

/// The mean of clamp(gain · (offset - |n|)² · opening, 0, 1) over the noise, for openings from 0 to 1.
///
/// An octave that is left out opens the next by this much; the mean of a clamped product is not the product of means.
fn mean_openings(basis: Basis, offset: f32, gain: f32) -> [f32; STEPS + 1] {
    let parts = basis.parts();
    core::array::from_fn(|step| {
        let opening = step as f32 / STEPS as f32;
        let sum: f32 = parts.iter().map(|n| (gain * ((offset - n) * (offset - n) * opening)).clamp(0.0, 1.0)).sum();
        sum / parts.len() as f32
    })
}

/// The table's value at an opening in 0 … 1, between its steps by straight lines.
#[inline(always)]
fn interpolate(table: &[f32; STEPS + 1], opening: f32) -> f32 {
    let at = opening * STEPS as f32;
    let step = (at as usize).min(STEPS - 1);
    table[step] + (at - step as f32) * (table[step + 1] - table[step])
}

/// A noise or fractal, ready to be evaluated at programme coordinates.
#[derive(Clone, Debug)]
pub struct Field {
    basis: Basis,
    shape: Shape,
    octaves: Vec<Octave>,
    /// Mean of what was left out.
    bias: f32,
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

    fn new(shape: FieldShape, basis: Basis, key: u64, spacing: f64, carried: impl Fn(f64) -> f64) -> Self {
        let (count, frequency_ratio, weight_ratio) = shape.progression();
        let moments = basis.moments();
        let (kind, linear_mean) = match shape {
            FieldShape::Ridged { offset, gain, .. } => {
                let mean_signal = offset * offset - 2.0 * offset * moments.absolute + moments.square;
                let (offset, gain) = (offset as f32, gain as f32);
                (Shape::Ridged(Ridge { offset, gain, mean_signal: mean_signal as f32, mean_opening: mean_openings(basis, offset, gain) }), None)
            }
            FieldShape::Turbulence { hard: true, .. } => (Shape::Sum { hard: true }, Some(moments.absolute)),
            _ => (Shape::Sum { hard: false }, Some(moments.mean)),
        };
        let (mut frequency, mut weight, mut bias, mut octaves) = (1.0_f64, 1.0_f64, 0.0_f64, Vec::new());
        for k in 0..shape.octaves() {
            let part = (count - k as f64).min(1.0);
            let kept = carried(frequency);
            if let Some(mean) = linear_mean {
                bias += weight * part * (1.0 - kept) * mean;
            }
            if kept > 0.0 || linear_mean.is_none() {
                let amplitude = if linear_mean.is_some() { weight * part * kept } else { 1.0 };
                octaves.push(Octave {
                    lattice: Lattice::new(key, k as u32, frequency),
                    amplitude: amplitude as f32,
                    weight: (weight * part) as f32,
                    carried: kept as f32,
                    // Only sums: the mean of a square's ridges is not the ridge of its mean.
                    extent: if linear_mean.is_some() { (spacing * frequency) as f32 } else { 0.0 },
                });
            }
            frequency *= frequency_ratio;
            weight *= weight_ratio;
        }
        Self { basis, shape: kind, octaves, bias: bias as f32 }
    }

    /// The value at programme coordinates: the definition that [`Rows`] is held to.
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> f32 {
        match self.shape {
            Shape::Sum { hard } => {
                let mut sum = self.bias;
                for octave in &self.octaves {
                    let n = self.basis.at(&octave.lattice, octave.amplitude, octave.extent, u, v);
                    sum += if hard { n.abs() } else { n };
                }
                sum
            }
            Shape::Ridged(ridge) => {
                let mut ridged = Ridged { value: 0.0, opening: 1.0 };
                for octave in &self.octaves {
                    let n = if octave.carried > 0.0 { self.basis.at(&octave.lattice, 1.0, octave.extent, u, v) } else { 0.0 };
                    ridged = if octave.carried >= 1.0 { ridge.add_whole(octave, n, ridged) } else { ridge.add_part(octave, n, ridged) };
                }
                ridged.value
            }
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
        let make = |octave: &Octave| {
            let rows = (octave.carried > 0.0).then(|| self.basis.rows(isa, octave.lattice, octave.amplitude, octave.extent, coordinates));
            (*octave, rows)
        };
        Rows { isa, shape: self.shape, bias: self.bias, octaves: self.octaves.iter().map(make).collect() }
    }
}

/// A field along the rows of a window.
pub struct Rows {
    isa: Isa,
    shape: Shape,
    bias: f32,
    octaves: Vec<(Octave, Option<BasisRows>)>,
}

impl Rows {
    /// Goes to the row of programme coordinate `v`.
    pub fn begin(&mut self, v: f64) {
        self.isa.run(Begin { rows: self, v });
    }

    /// Writes the values at the columns from `start` on.
    pub fn fill(&self, start: usize, out: &mut [f32]) {
        self.isa.run(Fill { rows: self, start, out });
    }

    #[inline(always)]
    fn fill_sum(&self, hard: bool, start: usize, out: &mut [f32]) {
        out.fill(self.bias);
        let mut scratch = [0.0_f32; CHUNK];
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            let noise = &mut scratch[..out.len()];
            for rows in self.octaves.iter().filter_map(|(_, rows)| rows.as_ref()) {
                rows.fill(start + chunk * CHUNK, noise);
                if hard {
                    out.iter_mut().zip(&*noise).for_each(|(sum, n)| *sum += n.abs());
                } else {
                    out.iter_mut().zip(&*noise).for_each(|(sum, n)| *sum += n);
                }
            }
        }
    }

    #[inline(always)]
    fn fill_ridged(&self, ridge: &Ridge, start: usize, out: &mut [f32]) {
        let (mut noise, mut opening) = ([0.0_f32; CHUNK], [0.0_f32; CHUNK]);
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            out.fill(0.0);
            opening.fill(1.0);
            for (octave, rows) in &self.octaves {
                let noise = &mut noise[..out.len()];
                match rows {
                    Some(rows) => rows.fill(start + chunk * CHUNK, noise),
                    None => noise.fill(0.0),
                }
                if octave.carried >= 1.0 {
                    step(out, noise, &mut opening, |n, before| ridge.add_whole(octave, n, before));
                } else {
                    step(out, noise, &mut opening, |n, before| ridge.add_part(octave, n, before));
                }
            }
        }
    }
}

/// [`Rows::begin`].
struct Begin<'a> {
    rows: &'a mut Rows,
    v: f64,
}

impl Kernel for Begin<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for rows in self.rows.octaves.iter_mut().filter_map(|(_, rows)| rows.as_mut()) {
            rows.begin(self.v);
        }
    }
}

/// [`Rows::fill`].
struct Fill<'a> {
    rows: &'a Rows,
    start: usize,
    out: &'a mut [f32],
}

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        match &self.rows.shape {
            Shape::Sum { hard } => self.rows.fill_sum(*hard, self.start, self.out),
            Shape::Ridged(ridge) => self.rows.fill_ridged(ridge, self.start, self.out),
        }
    }
}

/// Adds an octave to every sample of a chunk.
#[inline(always)]
fn step(values: &mut [f32], noise: &[f32], openings: &mut [f32], add: impl Fn(f32, Ridged) -> Ridged) {
    for ((value, n), opening) in values.iter_mut().zip(noise).zip(openings) {
        let after = add(*n, Ridged { value: *value, opening: *opening });
        (*value, *opening) = (after.value, after.opening);
    }
}

/// Samples that are put together at a time: what octaves write stays in the first-level cache.
const CHUNK: usize = 256;

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [FieldShape; 5] = [
        FieldShape::Single,
        FieldShape::Fbm { h: 1.0, lacunarity: 2.03, octaves: 6.4 },
        FieldShape::Ridged { h: 0.9, lacunarity: 2.1, octaves: 5.5, offset: 1.0, gain: 2.0 },
        FieldShape::Turbulence { octaves: 4.0, amplitude: 0.5, frequency: 2.0, hard: true },
        FieldShape::Turbulence { octaves: 3.5, amplitude: 0.6, frequency: 1.9, hard: false },
    ];

    /// Rows and points agree to the bit: wide cells and cells far below a sample, near and far, both filters, odd lengths.
    #[test]
    fn rows_equal_points_bit_for_bit() {
        for shape in SHAPES {
            for basis in Basis::all() {
                for (origin, spacing) in [(0.0, 0.0031), (-3.7, 0.11), (5.4e7, 0.013), (12.25, 0.6), (-1e9, 7.3), (0.0, 1e-9)] {
                    for field in [Field::exact(shape, basis, 99), Field::banded(shape, basis, 99, spacing)] {
                        for isa in Isa::ALL {
                            check_rows(&field, isa, origin, spacing);
                        }
                    }
                }
            }
        }
    }

    fn check_rows(field: &Field, isa: Isa, origin: f64, spacing: f64) {
        let columns: Vec<f64> = (0..77).map(|i| origin + f64::from(i) * spacing).collect();
        let mut rows = field.rows_on(isa, &columns);
        let mut line = vec![0.0; 60];
        for j in [0, 1, 2, 9, 8, 7, 40] {
            let v = origin * 0.5 - f64::from(j) * spacing;
            rows.begin(v);
            rows.fill(17, &mut line);
            for (got, &u) in line.iter().zip(&columns[17..]) {
                assert_eq!(got.to_bits(), field.at(u, v).to_bits(), "{isa:?} {field:?} at {u} {v}");
            }
        }
    }

    #[test]
    fn gradient_noise_stays_in_its_range_and_uses_it() {
        for basis in [Basis::OPerlin, Basis::IPerlin] {
            let field = Field::exact(FieldShape::Single, basis, 5);
            let (mut low, mut high) = (0.0_f32, 0.0_f32);
            for i in 0..400_000 {
                let n = field.at(f64::from(i % 1000) * 0.171, f64::from(i / 1000) * 0.233);
                (low, high) = (low.min(n), high.max(n));
            }
            assert!(low >= -1.0 && high <= 1.0 && low < -0.85 && high > 0.85, "{basis:?}: {low} … {high}");
        }
    }

    /// The mean must not move when detail is left out, or ridged land would sink on zooming out.
    #[test]
    fn the_mean_stays_from_level_to_level() {
        for shape in SHAPES {
            for basis in [
                Basis::OPerlin,
                Basis::IPerlin,
                Basis::CellNoise,
                Basis::Voronoi { feature: crate::noise::Feature::F1, metric: crate::noise::Metric::Distance },
            ] {
                let means: Vec<f64> = (0..9).map(|level| mean_at(shape, basis, 0.02 * f64::from(1 << level))).collect();
                let amplitude = 1.0;
                for (level, pair) in means.windows(2).enumerate() {
                    assert!((pair[1] - pair[0]).abs() < 0.01 * amplitude, "{shape:?} {basis:?}: mean {} becomes {} at level {level}", pair[0], pair[1]);
                }
            }
        }
    }

    /// Mean of the field filtered to a spacing over 10⁶ samples that cover 1,400 cells a side, whatever the spacing.
    fn mean_at(shape: FieldShape, basis: Basis, spacing: f64) -> f64 {
        let field = Field::banded(shape, basis, 7, spacing);
        let columns: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1.4).collect();
        let mut rows = field.rows(&columns);
        let mut line = vec![0.0; columns.len()];
        let mut sum = 0.0;
        for &v in &columns {
            rows.begin(v);
            rows.fill(0, &mut line);
            sum += line.iter().map(|&n| f64::from(n)).sum::<f64>();
        }
        sum / (columns.len() * columns.len()) as f64
    }
}
