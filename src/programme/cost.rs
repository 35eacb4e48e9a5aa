//! What a programme costs to evaluate, predicted so that every machine accepts the same worlds.

use super::{
    graph::{Noise, Step},
    operation::{Binary, Unary},
    sampling,
    tape::{Instruction, Tape},
};
use crate::{
    geometry::Filter,
    noise::{Basis, Feature, FieldShape, Metric},
};

/// The greatest predicted cost of a programme, in nanoseconds a sample.
pub const COST_LIMIT_NS: f64 = 2_000.0;

impl Tape {
    /// The predicted cost of a sample in nanoseconds, on one thread, of samples `spacing` programme units apart.
    ///
    /// The constants were measured on AVX2 (the reference): whatever the machine, the prediction is the same.
    #[must_use]
    pub fn cost_ns(&self, spacing: f64, filter: Filter) -> f64 {
        let carried = if filter == Filter::Band { spacing } else { 0.0 };
        match self.subsamples(carried) {
            1 => BLOCK_NS + self.samples_ns(spacing, 1, filter),
            n => self.parts_ns(spacing, n),
        }
    }

    /// The predicted cost of a sample that is the mean of n × n parts.
    pub(super) fn parts_ns(&self, spacing: f64, n: usize) -> f64 {
        BLOCK_NS + (n * n) as f64 * self.samples_ns(spacing, n, Filter::Band)
    }

    /// What one of a sample's n × n parts costs.
    fn samples_ns(&self, spacing: f64, n: usize, filter: Filter) -> f64 {
        self.samples.iter().map(|instruction| self.instruction_ns(instruction, spacing, n, filter)).sum()
    }

    /// The greatest predicted cost of a sample in nanoseconds at any spacing, with nothing but octaves of noise that are finer than the samples.
    ///
    /// Exact samples further apart than the valleys of an erosion cost more: each has to find a network of its own.
    #[must_use]
    pub fn peak_cost_ns(&self) -> f64 {
        let spacings = core::iter::successors(Some(64.0), |spacing| Some(spacing / 2.0)).take(31);
        let band = spacings.map(|spacing| self.cost_ns(spacing, Filter::Band)).fold(0.0, f64::max);
        let pitches = self.graph.erosions.iter().flat_map(|eroded| eroded.erosion.pitches().map(|(pitch, _)| pitch));
        let finest = pitches.fold(64.0, f64::min);
        band.max(self.cost_ns(finest / 2.0, Filter::Exact))
    }

    fn instruction_ns(&self, instruction: &Instruction, spacing: f64, n: usize, filter: Filter) -> f64 {
        let noise = |noise: usize, way: Way| octaves_ns(&self.graph.noises[noise], way, sampling::detail(spacing, n), filter);
        match *instruction {
            Instruction::Move { .. } | Instruction::Shift { .. } => 0.6,
            Instruction::Rows { rows, .. } => noise(self.noise_rows[rows].0, Way::Rows),
            Instruction::Noise { noise: of, .. } => noise(of, Way::Points),
            Instruction::Slopes { noise: of, .. } => SLOPES * noise(of, Way::Points),
            Instruction::Erosion { erosion, .. } => self.erosion_ns(erosion, spacing, n, filter),
            Instruction::Step { step, .. } => step_ns(step),
        }
    }

    /// Links for every sample, and nodes shared by the samples of a cell.
    fn erosion_ns(&self, erosion: usize, spacing: f64, n: usize, filter: Filter) -> f64 {
        let mut terrain = self.terrains[erosion].samples_ns(1.0, 1, Filter::Exact);
        let mut sum = 0.0;
        for (pitch, candidates) in self.graph.erosions[erosion].erosion.pitches() {
            if filter == Filter::Band && pitch <= 2.0 * spacing {
                break;
            }
            // A sample has no more nodes than those around it alone.
            let nodes = (spacing / pitch / n as f64) * (spacing / pitch / n as f64);
            sum += LINKS_NS + nodes.min(400.0) * (NODE_NS + candidates * terrain);
            terrain += LINKS_NS;
        }
        sum
    }
}

/// What an empty programme costs.
const BLOCK_NS: f64 = 0.2;

/// How much more a noise's two slopes cost than its value.
const SLOPES: f64 = 3.0;

/// What the links of one lattice of an erosion cost.
const LINKS_NS: f64 = 25.0;

/// What finding a node and its link costs, its height apart.
const NODE_NS: f64 = 600.0;

/// How a noise is evaluated.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Along the rows of a lattice.
    Rows,
    /// At positions that differ from sample to sample.
    Points,
}

fn octaves_ns(noise: &Noise, way: Way, spacing: f64, filter: Filter) -> f64 {
    let fold = match noise.shape {
        FieldShape::Ridged { .. } | FieldShape::Hybrid { .. } => 0.3,
        _ => 0.1,
    };
    let (mut samples, mut sum) = (1.0 / spacing, 0.2);
    for _ in 0..noise.shape.octaves() {
        if filter == Filter::Exact || samples > 2.0 {
            sum += fold + octave_ns(noise.basis, way, samples);
        }
        samples /= noise.shape.lacunarity();
    }
    sum
}

/// One octave with cells of that many samples a side.
fn octave_ns(basis: Basis, way: Way, samples: f64) -> f64 {
    // What is done once a cell and row, shared by the cell's samples.
    let share = 1.0 / samples.max(0.5);
    match (basis, way) {
        (Basis::OPerlin | Basis::IPerlin, Way::Rows) => 0.3 + 1.5 * share,
        (Basis::OPerlin | Basis::IPerlin, Way::Points) => 1.8,
        (Basis::Blender, Way::Rows) => 1.0 + 2.0 * share,
        (Basis::Blender, Way::Points) => 3.0,
        (Basis::CellNoise, Way::Rows) => 0.2 + share,
        (Basis::CellNoise, Way::Points) => 1.0,
        (Basis::Voronoi { feature, metric }, way) => {
            let order = match feature {
                Feature::F1 => 1.0,
                Feature::F2 | Feature::F2F1 | Feature::Crackle => 1.2,
                Feature::F3 => 4.0,
                Feature::F4 => 6.0,
            };
            let metric = if matches!(metric, Metric::Minkowski { .. }) { 12.0 } else { 1.0 };
            order * metric * if way == Way::Rows { 2.5 + 4.0 * share } else { 8.0 }
        }
    }
}

fn step_ns(step: Step) -> f64 {
    match step {
        Step::Unary(Unary::Negative | Unary::Abs, _) => 0.15,
        Step::Unary(Unary::Sqrt, _) => 0.4,
        Step::Unary(Unary::Tan, _) => 7.0,
        Step::Unary(_, _) => 5.0,
        Step::Binary(Binary::Power, ..) => 30.0,
        Step::Binary(Binary::Divide, ..) => 0.5,
        Step::Binary(Binary::Mod, ..) | Step::Terrace(..) | Step::TerraceSlope(..) => 1.0,
        Step::Binary(..) | Step::Select(..) => 0.2,
        Step::Shape(..) | Step::ShapeSlope(..) => 4.0,
        Step::Number(_) | Step::Coordinate(..) => 0.3,
        Step::Noise(..) | Step::NoiseSlope(..) | Step::Erosion(..) => 0.0,
    }
}
