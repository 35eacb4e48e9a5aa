//! Which fractals there are.

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
    pub(crate) fn progression(self) -> (f64, f64, f64) {
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

    /// Whether every octave's noise enters as it is, in sums and products.
    pub(super) fn is_linear(self) -> bool {
        !matches!(self, FieldShape::Ridged { .. } | FieldShape::Hybrid { .. } | FieldShape::Turbulence { hard: true, .. })
    }

    /// Ratio of the frequencies of neighbouring octaves.
    #[must_use]
    pub fn lacunarity(self) -> f64 {
        self.progression().1
    }

    /// The side of the cells of the finest octave that counts for at least a part of the first one, in programme units.
    #[must_use]
    pub fn finest_cell(self, part: f64) -> f64 {
        let (count, frequency_ratio, weight_ratio) = self.progression();
        let share = |k: usize| libm::pow(weight_ratio, k as f64) * (count - k as f64).min(1.0);
        let finest = (0..self.octaves()).rev().find(|&k| k == 0 || share(k) >= part).unwrap_or(0);
        libm::pow(frequency_ratio, -(finest as f64))
    }

    /// Number of octaves, whole or begun.
    #[must_use]
    pub fn octaves(self) -> usize {
        self.progression().0.ceil() as usize
    }
}
