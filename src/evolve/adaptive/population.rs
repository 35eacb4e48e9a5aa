//! A generation of lines, and how the next is bred (Yao 2008, sections 3.2.3 to 3.2.8).

use super::{line::Line, settings::Ground};
use crate::genetic::Draws;
use std::sync::Arc;

/// Least and greatest deviation of what is grown, as shares of the range: without them heights collapse to two, or run away.
const DEVIATIONS: [f64; 2] = [0.02, 0.25];

/// Metres that are added to a fitness before a line becomes a parent in proportion to its inverse.
const EPSILON: f64 = 0.01;

/// What a line draws for.
#[derive(Clone, Copy)]
enum Purpose {
    Grow,
    Cross,
    Mutate,
    Unlike,
}

/// The lines of all populations, from west to east. A line keeps its place; generations share lines that live on.
pub(super) type Lines = Vec<Arc<Line>>;

/// The first generation.
pub(super) fn first(ground: &Ground) -> Lines {
    let line = |i: usize| Arc::new(Line::grown(ground, ground.deviation, &mut draws(ground, 0, i, Purpose::Grow)));
    (0..ground.populations * ground.lines).map(line).collect()
}

fn draws(ground: &Ground, generation: usize, line: usize, purpose: Purpose) -> Draws {
    Draws::of(ground.seed, &[0x6c69_6e65, generation as u64, line as u64, purpose as u64])
}

/// The deviation of what is grown after feedback at these heights above the mean.
pub(super) fn deviation(ground: &Ground, wanted: &[f64]) -> f64 {
    let mean_square = wanted.iter().map(|y| y * y).sum::<f64>() / wanted.len().max(1) as f64;
    let [least, most] = DEVIATIONS.map(|share| share * (ground.range[1] - ground.range[0]));
    mean_square.sqrt().clamp(least, most)
}

/// Breeds generation number `generation` of another.
pub(super) fn bred(ground: &Ground, lines: &Lines, wanted: &[f64], generation: usize) -> Lines {
    let fitness: Vec<f64> = lines.iter().map(|line| line.fitness(ground.length, wanted)).collect();
    // Of every population the fittest first: an index is sorted, lines keep their places.
    let ranks: Vec<Vec<usize>> = (0..ground.populations)
        .map(|population| {
            let mut order: Vec<usize> = (population * ground.lines..(population + 1) * ground.lines).collect();
            order.sort_by(|&a, &b| fitness[a].total_cmp(&fitness[b]));
            order
        })
        .collect();
    let mut next = lines.clone();
    for order in &ranks {
        breed(ground, lines, &fitness, order, deviation(ground, wanted), generation, &mut next);
    }
    if ground.exchange > 0 && generation.is_multiple_of(ground.exchange) {
        for (population, order) in ranks.iter().enumerate().filter(|_| ground.populations > 1) {
            let neighbour = &ranks[(population + 1) % ground.populations];
            next[neighbour[ground.lines - 1]] = Arc::clone(&lines[order[0]]);
        }
    }
    next
}

/// Breeds one population, whose lines are in the order of their fitness.
fn breed(ground: &Ground, lines: &Lines, fitness: &[f64], order: &[usize], deviation: f64, generation: usize, next: &mut Lines) {
    let n = order.len();
    let replaced = ((ground.crossover * n as f64).round() as usize).min(n / 2);
    let fit = &order[..n.div_ceil(2)];
    let chances: Vec<f64> = fit.iter().map(|&line| 1.0 / (EPSILON + fitness[line])).collect();
    for &line in &order[n - replaced..] {
        let mut draws = draws(ground, generation, line, Purpose::Cross);
        let [parent, other] = [draws.weighted(&chances), draws.weighted(&chances)].map(|i| &lines[fit[i]]);
        next[line] = Arc::new(parent.crossed(other, ground, &mut draws));
    }
    for &line in &order[ground.elite..n - replaced] {
        let mut draws = draws(ground, generation, line, Purpose::Mutate);
        if draws.chance(ground.mutation) {
            next[line] = Arc::new(lines[line].mutated(ground, deviation, &mut draws));
        }
    }
    // Spikes in a plain, plains among spikes.
    let unlike = if deviation < ground.deviation / 2.0 { ground.deviation } else { DEVIATIONS[0] * (ground.range[1] - ground.range[0]) };
    let mut others: Vec<usize> = order[ground.elite..].to_vec();
    others.sort_unstable();
    let count = if ground.unlike > 0.0 { (ground.unlike * n as f64).floor().max(1.0) as usize } else { 0 };
    for i in 0..count {
        let line = others[(generation * count + i) % others.len()];
        next[line] = Arc::new(Line::grown(ground, unlike, &mut draws(ground, generation, line, Purpose::Unlike)));
    }
}
