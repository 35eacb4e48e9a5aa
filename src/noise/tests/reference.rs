//! Gradient noises and fractals in f64, written anew from the spec's formulas, and how far the fields are from them.

use crate::noise::{
    Basis, Field, FieldShape,
    hash::{column_key, corner, key, row_key},
};

/// One octave's lattice, as it is documented: hash and phase from (key, number).
struct Lattice {
    frequency: f64,
    phase: [f64; 2],
    seed: u32,
}

impl Lattice {
    fn new(parent: u64, octave: u32, frequency: f64) -> Self {
        let bits = key(parent, octave.into());
        let phase = |shift: u32| ((bits >> shift) & 0xffff) as f64 / 65_536.0;
        Self { frequency, phase: [phase(32), phase(48)], seed: bits as u32 }
    }

    fn gradient(&self, basis: Basis, i: i64, j: i64) -> [f64; 2] {
        let hash = corner(column_key(i), row_key(j, self.seed));
        if basis == Basis::IPerlin {
            let edges = [[1, 1], [-1, 1], [1, -1], [-1, -1], [1, 0], [-1, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [0, 1], [0, -1]];
            return edges[(((hash >> 16) * 12) >> 16) as usize].map(f64::from);
        }
        let angle = (2.0 * f64::from(hash >> 28) + 1.0) * core::f64::consts::PI / 16.0;
        [libm::cos(angle), libm::sin(angle)]
    }

    fn noise(&self, basis: Basis, u: f64, v: f64) -> f64 {
        let (x, y) = (u * self.frequency + self.phase[0], v * self.frequency + self.phase[1]);
        let (i, j) = (libm::floor(x), libm::floor(y));
        let (fx, fy) = (x - i, y - j);
        let corner = |a: i64, b: i64| {
            let [gx, gy] = self.gradient(basis, i as i64 + a, j as i64 + b);
            let (dx, dy) = (fx - a as f64, fy - b as f64);
            (gx * dx + gy * dy, dx * dx + dy * dy)
        };
        let corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
        if basis == Basis::Blender {
            let kernel = |(value, square): (f64, f64)| if square < 1.0 { (1.0 - 3.0 * square + 2.0 * square * square.sqrt()) * value } else { 0.0 };
            return 1.735_427 * corners.map(kernel).iter().sum::<f64>();
        }
        let fade = |t: f64| if basis == Basis::OPerlin { t * t * (3.0 - 2.0 * t) } else { t * t * t * (t * (t * 6.0 - 15.0) + 10.0) };
        let mix = |a: f64, b: f64, t: f64| (1.0 - t) * a + t * b;
        let [sw, se, nw, ne] = corners.map(|(value, _)| value);
        let scale = if basis == Basis::OPerlin { core::f64::consts::SQRT_2 } else { 1.0 };
        scale * mix(mix(sw, se, fade(fx)), mix(nw, ne, fade(fx)), fade(fy))
    }
}

/// The spec's table.
pub(crate) fn evaluate(shape: FieldShape, basis: Basis, parent: u64, u: f64, v: f64) -> f64 {
    let (count, lacunarity, ratio) = match shape {
        FieldShape::Single => (1.0, 1.0, 1.0),
        FieldShape::Fbm { h, lacunarity, octaves }
        | FieldShape::Multifractal { h, lacunarity, octaves }
        | FieldShape::Hetero { h, lacunarity, octaves, .. }
        | FieldShape::Hybrid { h, lacunarity, octaves, .. }
        | FieldShape::Ridged { h, lacunarity, octaves, .. } => (octaves, lacunarity, libm::pow(lacunarity, -h)),
        FieldShape::Spectral { beta, octaves } => (octaves, 2.0, libm::pow(2.0, -(beta - 1.0) / 2.0)),
        FieldShape::Turbulence { octaves, amplitude, frequency, .. } => (octaves, frequency, amplitude),
    };
    let (mut frequency, mut w, mut sum_of_weights) = (1.0, 1.0, 0.0);
    let (mut value, mut open) = (if matches!(shape, FieldShape::Multifractal { .. }) { 1.0 } else { 0.0 }, 1.0_f64);
    for k in 0..count.ceil() as u32 {
        let n = Lattice::new(parent, k, frequency).noise(basis, u, v);
        let r = (count - f64::from(k)).min(1.0);
        match shape {
            FieldShape::Turbulence { hard: true, .. } => value += r * w * n.abs(),
            FieldShape::Multifractal { .. } => value *= 1.0 + r * w * n,
            FieldShape::Hetero { offset, .. } if k == 0 => value = n + offset,
            FieldShape::Hetero { offset, .. } => value += r * w * (n + offset) * value,
            FieldShape::Ridged { offset, gain, .. } => {
                let s = (offset - n.abs()) * (offset - n.abs()) * open;
                value += r * s * w;
                open = (gain * s).clamp(0.0, 1.0);
            }
            FieldShape::Hybrid { offset, gain, .. } => {
                let s = (n + offset) * w;
                value += r * open * s;
                open = (open * gain * s).min(1.0);
            }
            _ => value += r * w * n,
        }
        sum_of_weights += r * w;
        frequency *= lacunarity;
        w *= ratio;
    }
    if matches!(shape, FieldShape::Spectral { .. }) { value / sum_of_weights } else { value }
}

/// Numbers from 0 to 1 that look random.
pub(crate) fn unit(number: u64) -> f64 {
    (key(0x5eed, number) >> 11) as f64 / 9_007_199_254_740_992.0
}

/// Shapes of usual parameters, and the metres that their errors may have on a relief of 5 km, from the least to the greatest value found.
const USUAL: [(FieldShape, f64); 11] = [
    (FieldShape::Single, 0.001),
    (FieldShape::Fbm { h: 1.0, lacunarity: 2.0, octaves: 8.0 }, 0.001),
    (FieldShape::Fbm { h: 0.7, lacunarity: 1.97, octaves: 14.5 }, 0.001),
    (FieldShape::Spectral { beta: 2.0, octaves: 10.0 }, 0.001),
    (FieldShape::Turbulence { octaves: 8.0, amplitude: 0.5, frequency: 2.0, hard: false }, 0.001),
    // Not quite what the spec asks: magnitudes have half the relief of the values they are taken from, and all of their errors.
    (FieldShape::Turbulence { octaves: 8.0, amplitude: 0.5, frequency: 2.0, hard: true }, 0.001_5),
    (FieldShape::Ridged { h: 1.0, lacunarity: 2.0, octaves: 8.0, offset: 1.0, gain: 2.0 }, 0.004),
    (FieldShape::Ridged { h: 0.9, lacunarity: 2.1, octaves: 12.0, offset: 1.0, gain: 2.0 }, 0.004),
    (FieldShape::Hybrid { h: 0.25, lacunarity: 2.0, octaves: 8.0, offset: 0.7, gain: 1.0 }, 0.004),
    (FieldShape::Hetero { h: 1.0, lacunarity: 2.0, octaves: 8.0, offset: 1.0 }, 0.004),
    (FieldShape::Multifractal { h: 1.0, lacunarity: 2.0, octaves: 8.0 }, 0.004),
];

const GRADIENT: [Basis; 3] = [Basis::OPerlin, Basis::IPerlin, Basis::Blender];

/// Near the origin, where neighbouring samples of zoom level 24 are 2^-30 cells apart, and 2^40 m away at 20 km a unit.
#[test]
fn fields_are_as_near_the_formulas_as_the_spec_asks() {
    let far = 1_099_511_627_776.0 / 20_000.0;
    for (shape, allowed) in USUAL {
        for basis in GRADIENT {
            let (mut worst, mut low, mut high) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
            for i in 0..12_000 {
                let (a, b) = (unit(2 * i), unit(2 * i + 1));
                let (u, v) = match i % 3 {
                    0 => (20.0 * a - 10.0, 20.0 * b - 10.0),
                    1 => (0.7 + (i as f64) / 1_073_741_824.0, -0.2 + a),
                    _ => (far + 30.0 * a, -far + 30.0 * b),
                };
                let (got, want) = (Field::exact(shape, basis, 17).at(u, v), evaluate(shape, basis, 17, u, v));
                worst = worst.max((f64::from(got) - want).abs());
                (low, high) = (low.min(want), high.max(want));
            }
            let error = worst / (high - low) * 5_000.0;
            assert!(error <= allowed, "{shape:?} {basis:?}: {error} m on a relief of 5 km");
        }
    }
}

#[test]
fn slopes_are_those_of_the_formulas() {
    const STEP: f64 = 1e-8;
    for (shape, _) in USUAL {
        for basis in GRADIENT {
            let field = Field::exact(shape, basis, 23);
            let steepest = f64::from(field.max_slope());
            let mut compared = 0;
            for i in 0..2_000 {
                let (u, v) = (9.0 * unit(2 * i) - 4.0, 9.0 * unit(2 * i + 1) - 4.0);
                let at = |du: f64, dv: f64| evaluate(shape, basis, 23, u + du * STEP, v + dv * STEP);
                let slopes = field.slopes_at(u, v);
                for (got, [before, here, after]) in
                    slopes.into_iter().zip([[at(-1.0, 0.0), at(0.0, 0.0), at(1.0, 0.0)], [at(0.0, -1.0), at(0.0, 0.0), at(0.0, 1.0)]])
                {
                    let (left, right) = ((here - before) / STEP, (after - here) / STEP);
                    // Not across a crease.
                    if (left - right).abs() < 0.02 {
                        compared += 1;
                        let want = f64::midpoint(left, right);
                        assert!((f64::from(got) - want).abs() < 2e-3 + 1e-4 * want.abs(), "{shape:?} {basis:?} at {u} {v}: {got} is not {left} or {right}");
                        assert!(f64::from(got).abs() <= steepest, "{shape:?} {basis:?}: {got} is more than {steepest}");
                    }
                }
            }
            assert!(compared > 3_600, "{shape:?} {basis:?}: only {compared} places without a crease");
        }
    }
}
