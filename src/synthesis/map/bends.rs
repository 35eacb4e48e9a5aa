//! Curves of many bends by a genetic algorithm (Saunders 2006, IV.3.1).

use crate::noise::{key, mix};
use core::f32::consts::{FRAC_PI_2, FRAC_PI_3, PI};

/// Curves of a population.
pub(super) const POPULATION: usize = 5;

/// Generations.
pub(super) const CYCLES: usize = 20;

/// How often two curves are spliced, and how often a bend changes.
const CROSSOVER: f32 = 0.7;
const MUTATION: f32 = 0.1;

/// Greatest angle with the straight edge.
const MOST: f32 = FRAC_PI_3;

/// Chords of 1, 2, 4 and 8 segments: the bends of all count alike.
const DOUBLINGS: usize = 4;

/// Draws from a seed, one after the other.
struct Draws {
    seed: u64,
    count: u64,
}

impl Draws {
    fn next(&mut self) -> u64 {
        self.count += 1;
        mix(self.seed ^ self.count.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// 0 … 1 without 1.
    fn share(&mut self) -> f32 {
        (self.next() >> 40) as f32 / 16_777_216.0
    }

    /// One of so many.
    fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.next()) * count as u128) >> 64) as usize
    }
}

/// What can be bred. The operators change what their first argument is.
trait Breed {
    /// A curve by chance.
    fn random(&self, draws: &mut Draws, out: &mut [f32]);
    /// Takes over a part of another curve.
    fn splice(&self, draws: &mut Draws, own: &mut [f32], other: &[f32]);
    /// Changes bends.
    fn mutate(&self, draws: &mut Draws, own: &mut [f32]);
    /// How fit a curve is.
    fn fitness(&mut self, own: &[f32]) -> f32;
}

/// Genes are bends: what a segment turns by against the one before, the first against the straight edge.
struct Bends {
    smoothness: f32,
    /// Angles of chords, and all bends: what is computed in between.
    chords: Vec<f32>,
    all: Vec<f32>,
}

/// Sums of bends that are added up side by side.
const LANES: usize = 8;

impl Bends {
    fn new(smoothness: f64) -> Self {
        Self { smoothness: smoothness as f32, chords: Vec::new(), all: Vec::new() }
    }

    /// How fit a bend is (Eq. IV.3): the sine of 0 … 1.1 π is the cosine of a quarter turn less, by its series to an error of 10⁻⁵.
    #[inline(always)]
    fn fit(&self, bend: f32) -> f32 {
        let x = (PI - bend.abs()) * (1.1 - self.smoothness) - FRAC_PI_2;
        let z = x * x;
        1.0 + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z * (1.0 / 40_320.0 - z * (1.0 / 3_628_800.0)))))
    }
}

/// Angles with the straight edge that bends lead to: none is greater than [`MOST`], whatever the bend.
fn angles_of(bends: &[f32], out: &mut Vec<f32>) {
    out.clear();
    let mut angle = 0.0_f32;
    out.extend(bends.iter().map(|bend| {
        angle = (angle + bend).clamp(-MOST, MOST);
        angle
    }));
}

impl Breed for Bends {
    fn random(&self, draws: &mut Draws, out: &mut [f32]) {
        for bend in out {
            *bend = (2.0 * draws.share() - 1.0) * MOST;
        }
    }

    fn splice(&self, draws: &mut Draws, own: &mut [f32], other: &[f32]) {
        let at = draws.below(own.len());
        own[at..].copy_from_slice(&other[at..]);
    }

    fn mutate(&self, draws: &mut Draws, own: &mut [f32]) {
        for four in own.chunks_mut(4) {
            // Sixteen bits for each of four segments.
            let bits = draws.next();
            for (i, bend) in four.iter_mut().enumerate() {
                if (((bits >> (16 * i)) & 0xffff) as f32) < MUTATION * 65_536.0 {
                    *bend = (2.0 * draws.share() - 1.0) * PI;
                }
            }
        }
    }

    fn fitness(&mut self, own: &[f32]) -> f32 {
        self.all.clear();
        angles_of(own, &mut self.chords);
        for doubling in 0..DOUBLINGS {
            if doubling > 0 {
                // The direction of a chord is the mean of its segments' angles, which are all within 60° of the straight edge.
                let pairs = self.chords.len() / 2;
                for i in 0..pairs {
                    self.chords[i] = f32::midpoint(self.chords[2 * i], self.chords[2 * i + 1]);
                }
                self.chords.truncate(pairs);
            }
            let next = self.chords.iter().skip(1);
            self.all.extend(next.zip(&self.chords).map(|(next, angle)| next - angle));
        }
        let mut sums = [0.0; LANES];
        let (whole, rest) = self.all.as_chunks::<LANES>();
        for bends in whole {
            for (sum, bend) in sums.iter_mut().zip(bends) {
                *sum += self.fit(*bend);
            }
        }
        for (sum, bend) in sums.iter_mut().zip(rest) {
            *sum += self.fit(*bend);
        }
        if self.all.is_empty() { 0.0 } else { sums.iter().sum::<f32>() / self.all.len() as f32 }
    }
}

/// The fittest of a population after all cycles; of equals the first.
fn evolve(breed: &mut impl Breed, genes: usize, seed: u64) -> Vec<f32> {
    let mut draws = Draws { seed, count: 0 };
    let mut population: Vec<(f32, Vec<f32>)> = (0..POPULATION)
        .map(|_| {
            let mut curve = vec![0.0; genes];
            breed.random(&mut draws, &mut curve);
            (breed.fitness(&curve), curve)
        })
        .collect();
    let mut next = population.clone();
    for _ in 0..CYCLES {
        let best = fittest(&population);
        next[0].clone_from(&population[best]);
        for child in &mut next[1..] {
            let parents = [(); 2].map(|()| tournament(&mut draws, &population));
            child.1.copy_from_slice(&population[parents[0]].1);
            if draws.share() < CROSSOVER {
                breed.splice(&mut draws, &mut child.1, &population[parents[1]].1);
            }
            breed.mutate(&mut draws, &mut child.1);
            child.0 = breed.fitness(&child.1);
        }
        core::mem::swap(&mut population, &mut next);
    }
    let best = fittest(&population);
    population.swap_remove(best).1
}

fn fittest(population: &[(f32, Vec<f32>)]) -> usize {
    (1..population.len()).fold(0, |best, i| if population[i].0 > population[best].0 { i } else { best })
}

/// The fitter of two by chance.
fn tournament(draws: &mut Draws, population: &[(f32, Vec<f32>)]) -> usize {
    let [one, other] = [(); 2].map(|()| draws.below(population.len()));
    if population[other].0 > population[one].0 { other } else { one }
}

/// Angles with the straight edge of the segments of a curve, -60° … 60°: it cannot cross itself. `smoothness` is 0 … 1.
pub(super) fn angles(segments: usize, smoothness: f64, seed: u64) -> Vec<f32> {
    let bends = evolve(&mut Bends::new(smoothness), segments, key(seed, segments as u64));
    let mut angles = Vec::with_capacity(segments);
    angles_of(&bends, &mut angles);
    angles
}

/// [`Breed::fitness`] of bends.
#[cfg(test)]
pub(super) fn fitness(bends: &[f32], smoothness: f64) -> f32 {
    Bends::new(smoothness).fitness(bends)
}
