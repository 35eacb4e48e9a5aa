//! What programmes are grown from, and how often.
//!
//! The sets are those of Frade, Fernández de Vega and Cotta 2009 (tables IV and V), where every member is drawn as often. Departures, each because a first generation
//! of twelve drawn evenly is flat, torn or torn off at a plane for the most part:
//!
//! - Fractals have numbers for parameters here, so they are leaves. They stand where the paper's `fftGen` stood, which most of its good terrains had, and are drawn most.
//! - Of functions, sums, products, extremes and mixtures are drawn more than those that tear: `tan`, `power`, `divide`, `mod` and `log`.
//! - Plane, step and bell are drawn seldom, and shapes repeat, so that they stand everywhere on an endless plane.
//! - `min`, `max`, `abs`, `mix`, `warp`, `terrace`, `smooth`, `erosion` are this project's own.

use super::genome::Gene;
use crate::{
    genetic::Draws,
    programme::{Parameter, Signature, Value},
};

/// Functions and how often each is drawn.
const FUNCTIONS: [(&str, f64); 24] = [
    ("plus", 4.0),
    ("minus", 3.0),
    ("multiply", 4.0),
    ("sin", 1.0),
    ("cos", 1.0),
    ("tan", 0.2),
    ("atan", 1.0),
    ("log", 0.5),
    ("power", 0.4),
    ("divide", 0.4),
    ("mod", 0.3),
    ("sqrt", 0.8),
    ("negative", 0.5),
    ("min", 1.2),
    ("max", 1.5),
    ("abs", 0.8),
    ("mix", 1.2),
    ("select", 0.2),
    ("warp", 1.2),
    ("terrace", 0.5),
    ("smooth", 0.2),
    ("slope", 0.1),
    ("clamp", 0.3),
    ("erosion", 0.3),
];

/// Leaves and how often each is drawn; a number is drawn as `NUMBER` says.
const LEAVES: [(&str, f64); 25] = [
    ("gauss", 0.3),
    ("plane", 0.1),
    ("step", 0.15),
    ("sphere", 0.3),
    ("blender_noise", 0.8),
    ("o_perlin", 0.8),
    ("i_perlin", 0.8),
    ("voronoi_f1", 0.5),
    ("voronoi_f2", 0.4),
    ("voronoi_f3", 0.2),
    ("voronoi_f4", 0.2),
    ("voronoi_f2f1", 0.4),
    ("voronoi_crackle", 0.15),
    ("cell_noise", 0.05),
    ("distorted_noise", 0.7),
    ("hetero_terrain", 1.5),
    ("multifractal", 1.5),
    ("hybrid_multifractal", 2.0),
    ("ridged_multifractal", 2.5),
    ("fbm", 3.0),
    ("turbulence", 1.5),
    ("voronoi", 0.3),
    ("spectral", 1.5),
    ("x", 0.1),
    ("y", 0.1),
];

/// How often a leaf is a number.
const NUMBER: f64 = 1.6;

/// Seeds of noises are drawn below this: short to write, and hardly ever the same twice in a programme.
const SEEDS: usize = 100_000;

/// Between which values a parameter is drawn: terrain lies there. Mutation may lead beyond, within the parameter's range.
fn usual(signature: &Signature, parameter: &Parameter) -> [f64; 2] {
    match (signature.name, parameter.name) {
        (_, "H") => [0.75, 1.4],
        (_, "lacunarity" | "frequency") => [1.8, 2.4],
        ("erosion", "octaves") => [1.0, 2.0],
        (_, "octaves") => [4.0, 9.0],
        (_, "offset") => [0.5, 1.2],
        (_, "gain") => [1.0, 3.0],
        (_, "amplitude") => [0.4, 0.6],
        (_, "distortion") => [0.2, 2.0],
        (_, "beta") => [1.8, 2.8],
        (_, "exponent") => [0.5, 6.0],
        (_, "width") | ("erosion", "scale") => [0.2, 0.8],
        (_, "radius") => [0.3, 1.2],
        (_, "centre_x" | "centre_y") => [-1.0, 1.0],
        (_, "repeat") => [2.0, 4.0],
        (_, "softness") => [0.1, 1.0],
        (_, "n") => [2.0, 8.0],
        (_, "sharpness") => [0.3, 0.95],
        (_, "r") => [0.02, 0.3],
        (_, "strength" | "depth") => [0.4, 0.9],
        _ => [parameter.min, parameter.max],
    }
}

/// To four digits after the point: programmes are read by people.
fn rounded(number: f64) -> f64 {
    (number * 10_000.0).round() / 10_000.0
}

fn held(number: f64, parameter: &Parameter) -> f64 {
    rounded(number).clamp(parameter.min, parameter.max)
}

/// How often each basis is drawn, by the beginning of its name: half of the fractals have the usual one, few have the square steps of cells.
const BASES: [(&str, f64); 5] = [("o_perlin", 5.0), ("i_perlin", 1.5), ("blender", 1.0), ("cell", 0.1), ("voronoi", 0.4)];

/// The index of a value. All choices but the basis are as likely as each other.
fn choice(name: &str, values: &[&str], draws: &mut Draws) -> usize {
    if !name.starts_with("basis") {
        return draws.below(values.len());
    }
    let weight = |value: &&str| BASES.iter().find(|(basis, _)| value.starts_with(basis)).map_or(0.0, |(_, weight)| *weight);
    draws.weighted(&values.iter().map(weight).collect::<Vec<_>>())
}

fn drawn(signature: &'static Signature, draws: &mut Draws) -> Gene {
    let parameters = signature.parameters.iter().map(|parameter| {
        let [low, high] = usual(signature, parameter);
        held(draws.between(low, high), parameter)
    });
    let parameters = parameters.collect();
    let choices = signature.choices.iter().map(|chosen| choice(chosen.name, chosen.values, draws)).collect();
    let seed = signature.noise.then(|| draws.below(SEEDS) as u32);
    Gene { signature: Some(signature), value: Value { parameters, choices, seed } }
}

fn one_of(set: &[(&str, f64)], draws: &mut Draws) -> Option<Gene> {
    let weights: Vec<f64> = set.iter().map(|(_, weight)| *weight).collect();
    Signature::named(set[draws.weighted(&weights)].0).map(|signature| drawn(signature, draws))
}

/// A number as constants are drawn: magnitudes from 0.1 to 4, one in three below 0.
fn number(draws: &mut Draws) -> f64 {
    let magnitude = 0.1 * libm::exp(draws.unit() * libm::log(40.0));
    rounded(if draws.chance(1.0 / 3.0) { -magnitude } else { magnitude })
}

fn leaf(draws: &mut Draws) -> Gene {
    let leaves: f64 = LEAVES.iter().map(|(_, weight)| weight).sum();
    let gene = if draws.chance(NUMBER / (NUMBER + leaves)) { None } else { one_of(&LEAVES, draws) };
    gene.unwrap_or_else(|| Gene::number(number(draws)))
}

/// The noise that costs least, which every budget has room for.
pub(super) fn cheapest(draws: &mut Draws) -> Gene {
    Signature::named("o_perlin").map_or_else(|| Gene::number(0.0), |signature| drawn(signature, draws))
}

/// How trees are grown (Koza 1992).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// Functions down to the last level.
    Full,
    /// Leaves may stand at every level but the root's.
    Grow,
}

/// Where trees are grown by [`Method::Grow`], this share of the nodes between the root and the last level are leaves.
const EARLY_LEAVES: f64 = 0.4;

/// Grows a tree of at most `depth` levels.
pub(super) fn grow(depth: usize, method: Method, draws: &mut Draws) -> Vec<Gene> {
    let mut genes = Vec::new();
    // Levels that are left for every subtree to come, the next last.
    let mut open = vec![depth];
    while let Some(levels) = open.pop() {
        let is_leaf = levels <= 1 || (method == Method::Grow && !genes.is_empty() && draws.chance(EARLY_LEAVES));
        let function = if is_leaf { None } else { one_of(&FUNCTIONS, draws) };
        let gene = function.unwrap_or_else(|| leaf(draws));
        open.extend(core::iter::repeat_n(levels - 1, gene.arity()));
        genes.push(gene);
    }
    genes
}

/// Changes some of the parameters, choices, seeds and numbers of the genes, one on average.
pub(super) fn vary(genes: &mut [Gene], draws: &mut Draws) {
    let values = |gene: &Gene| gene.value.parameters.len() + gene.value.choices.len() + usize::from(gene.value.seed.is_some());
    let count: usize = genes.iter().map(values).sum();
    let chance = 1.0 / count.max(1) as f64;
    for gene in genes {
        vary_gene(gene, chance, draws);
    }
}

fn vary_gene(gene: &mut Gene, chance: f64, draws: &mut Draws) {
    let Some(signature) = gene.signature else {
        if draws.chance(chance) {
            gene.value.parameters[0] = rounded(gene.value.parameters[0] * (1.0 + 0.3 * draws.normal())).clamp(-1e6, 1e6);
        }
        return;
    };
    for (parameter, value) in signature.parameters.iter().zip(&mut gene.value.parameters) {
        if draws.chance(chance) {
            let [low, high] = usual(signature, parameter);
            *value = held(*value + 0.2 * (high - low) * draws.normal(), parameter);
        }
    }
    for (chosen, value) in signature.choices.iter().zip(&mut gene.value.choices) {
        if draws.chance(chance) {
            *value = choice(chosen.name, chosen.values, draws);
        }
    }
    if gene.value.seed.is_some() && draws.chance(chance) {
        gene.value.seed = Some(draws.below(SEEDS) as u32);
    }
}
