//! Random numbers that follow from what they are for.

use crate::noise;
use core::f64::consts::TAU;

/// What individuals draw for; a draw for one purpose tells nothing of those for others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The first genome.
    Initialise,
    /// Which parents, and what is done with them.
    Select,
    /// Where two genomes are crossed.
    Cross,
    /// What is mutated.
    Mutate,
}

/// Random numbers of one key, told apart by how many were drawn before. Nobody else draws from them, so neither threads nor their order can change a number.
///
/// ```
/// use terrane::genetic::Draws;
/// let (mut one, mut same) = (Draws::new(7), Draws::new(7));
/// assert_eq!(one.bits(), same.bits());
/// assert!((0.0..1.0).contains(&one.unit()) && one.below(6) < 6);
/// ```
#[derive(Clone, Debug)]
pub struct Draws {
    key: u64,
    drawn: u64,
}

impl Draws {
    /// The numbers of a key.
    #[must_use]
    pub fn new(key: u64) -> Self {
        Self { key, drawn: 0 }
    }

    /// The numbers of something that is found by a path of numbers below a seed.
    #[must_use]
    pub fn of(seed: u64, path: &[u64]) -> Self {
        Self::new(path.iter().fold(seed, |key, &step| noise::key(key, step)))
    }

    /// The numbers of an individual of a generation and island for one purpose.
    #[must_use]
    pub fn individual(seed: u64, generation: usize, island: usize, individual: usize, purpose: Purpose) -> Self {
        Self::of(seed, &[generation as u64, island as u64, individual as u64, purpose as u64])
    }

    /// 64 fair bits.
    pub fn bits(&mut self) -> u64 {
        self.drawn += 1;
        noise::key(self.key, self.drawn)
    }

    /// A whole number from 0 to `n` - 1, each as often; 0 for `n` = 0.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// A number in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with a probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A number of the normal distribution of mean 0 and deviation 1 (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        // In (0, 1], where the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        radius * libm::cos(TAU * self.unit())
    }

    /// An index with probability in proportion to its weight. Weights that are not positive numbers count as 0; are all 0, every index is as likely.
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        let weight = |weight: f64| if weight.is_finite() && weight > 0.0 { weight } else { 0.0 };
        let sum: f64 = weights.iter().copied().map(weight).sum();
        if sum <= 0.0 || !sum.is_finite() {
            return self.below(weights.len());
        }
        let mut left = self.unit() * sum;
        let mut last = 0;
        for (i, w) in weights.iter().copied().map(weight).enumerate().filter(|(_, w)| *w > 0.0) {
            last = i;
            if left < w {
                return i;
            }
            left -= w;
        }
        last
    }
}
