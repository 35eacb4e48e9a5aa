//! How finely a programme is sampled: the parts that every sample is the mean of, and what stands for the detail that they cannot carry.

use super::{
    bounds,
    cost::COST_LIMIT_NS,
    graph::{Graph, Step},
    tape::Tape,
    waves,
};
use crate::noise::{self, Draws, Fading, Field, SIDE};

/// How samples are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sampling {
    /// Parts a side that every sample is the mean of, 1, 2 or 4.
    pub n: usize,
    /// How its valleys fade.
    pub fading: Fading,
}

/// Values that are added to a noise, a part of a sample each, and the range that it stays in.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    pub values: Draws,
    pub range: [f32; 2],
}

impl Drawn {
    /// A noise's value in a part of a sample, with the part's own draw.
    #[inline(always)]
    pub(super) fn apply(&self, value: f32, draw: f32) -> f32 {
        let sum = value + draw;
        let low = if sum < self.range[0] { self.range[0] } else { sum };
        if low > self.range[1] { self.range[1] } else { low }
    }
}

/// A wave in the parts of samples: how much of it they carry, and what stands for the rest.
#[derive(Clone, Debug)]
pub(super) struct Wave {
    carried: f32,
    drawn: Drawn,
}

impl Wave {
    /// What stands for it in every part of a sample.
    pub(super) fn draws(&self) -> &Draws {
        &self.drawn.values
    }

    /// A sine or cosine in a part of a sample, with the part's own draw.
    #[inline(always)]
    pub(super) fn apply(&self, value: f32, draw: f32) -> f32 {
        self.drawn.apply(value * self.carried, draw)
    }
}

/// The lengths of the programme's waves, each once: where a programme is held against its simplified form, those of that, which has none that are never chosen.
pub(super) fn wave_lengths(graph: &Graph) -> Vec<f64> {
    let lengths = waves::lengths(graph);
    let mut all: Vec<f64> = waves::arguments(graph).filter_map(|argument| lengths[argument]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The waves, of all lengths there are, that sines and cosines of each step make and that parts of samples, `spacing` programme units apart, do not carry whole.
pub(super) fn waves(graph: &Graph, all: &[f64], subsamples: usize, spacing: f64) -> Vec<Option<Wave>> {
    if subsamples != SIDE {
        return vec![None; graph.steps.len()];
    }
    let wave = |length: Option<f64>| {
        let (carried, values) = noise::wave_draws(length?, spacing, all.iter().position(|&other| Some(other) == length)?)?;
        Some(Wave { carried, drawn: Drawn { values, range: [-1.0, 1.0] } })
    };
    waves::lengths(graph).into_iter().map(wave).collect()
}

/// What stands for the detail of every noise in the parts of samples, those parts being `spacing` programme units apart; nothing for a spacing of 0.
/// `first` is how many draws the waves have.
pub(super) fn draws(graph: &Graph, first: usize, subsamples: usize, spacing: f64) -> Vec<Option<Drawn>> {
    if subsamples != SIDE {
        return vec![None; graph.noises.len()];
    }
    // Octaves of one lattice swing together, whatever they are part of.
    let mut lattices = Vec::new();
    for noise in &graph.noises {
        if !lattices.contains(&(noise.lattices, noise.part)) {
            lattices.push((noise.lattices, noise.part));
        }
    }
    let drawn = |noise: &super::graph::Noise| {
        let number = lattices.iter().position(|&lattice| lattice == (noise.lattices, noise.part))?;
        let values = Field::draws(noise.shape, noise.basis, spacing, |octave| first + number + octave * lattices.len())?;
        Some(Drawn { values, range: Field::exact(noise.shape, noise.basis, 0).range() })
    };
    graph.noises.iter().map(drawn).collect()
}

/// An octave matters that counts for this part of its noise's first.
const MATTERS: f64 = 0.125;

/// The spacing that noises and waves are filtered for, in programme units, of samples of a spacing that are cut into parts.
///
/// What a part alone could not carry is carried by sixteen: octaves fade from two parts a cell on, to be gone at one.
pub(super) fn detail(spacing: f64, subsamples: usize) -> f64 {
    let part = spacing / subsamples as f64;
    if subsamples == SIDE { part / 2.0 } else { part }
}

/// Parts a side that a sample is better cut into for its noises and waves to fade unseen: so many that those that matter are carried whole, as far as that many help.
fn fading(graph: &Graph, spacing: f64) -> usize {
    let noises = graph.reachable(graph.root).into_iter().filter_map(|id| if let Step::Noise(noise, _) = graph.steps[id] { Some(noise) } else { None });
    let finest = noises.map(|noise| graph.noises[noise].shape.finest_cell(MATTERS)).fold(f64::INFINITY, f64::min);
    let shortest = wave_lengths(graph).first().copied().unwrap_or(f64::INFINITY);
    match 4.0 * spacing / finest.min(shortest) {
        parts if parts <= 1.0 => 1,
        parts if parts <= 2.0 => 2,
        _ => SIDE,
    }
}

impl Tape {
    /// How samples `spacing` programme units apart are taken; 0 for the programme as it is.
    ///
    /// In as many parts as functions need that turn quickly; where octaves fade that matter, in as many as can be paid for; and with gradual valleys if those can be, too.
    pub(super) fn sampling(&self, spacing: f64) -> Sampling {
        let needed = bounds::subsamples(&self.graph, &bounds::fields(&self.graph, 0, spacing), spacing);
        let parts = |n| Sampling { n, fading: Fading { spacing, gradual: false } };
        if spacing <= 0.0 {
            return parts(needed);
        }
        let is_paid = |sampling: &Sampling| self.tile_ns(*sampling) <= COST_LIMIT_NS;
        let wanted = fading(&self.graph, spacing);
        let sampling = [SIDE, 2].into_iter().filter(|&n| n <= wanted && n > needed).map(parts).find(is_paid).unwrap_or_else(|| parts(needed));
        let gradual = Sampling { fading: Fading { spacing, gradual: true }, ..sampling };
        if sampling.n == SIDE && !self.graph.erosions.is_empty() && is_paid(&gradual) { gradual } else { sampling }
    }
}
