//! What a programme costs to evaluate, predicted so that every machine accepts the same worlds.

use super::{
    graph::{Noise, Step},
    operation::{Binary, Unary},
    sampling::{self, Sampling},
    shape::Shape,
    tape::{Instruction, Points, Tape},
};
use crate::{
    geometry::Filter,
    noise::{Basis, Fading, Feature, FieldShape, Lattice, Metric, SIDE},
};

/// The greatest predicted cost of a programme, in nanoseconds a sample.
pub const COST_LIMIT_NS: f64 = 6_500.0;

impl Tape {
    /// The predicted cost of a sample in nanoseconds, on one thread, of about `count` samples of a square, `spacing` programme units apart. What an erosion finds
    /// around the square is shared by all of them.
    ///
    /// The constants were measured on AVX2 (the reference): whatever the machine, the prediction is the same.
    #[must_use]
    pub fn cost_ns(&self, spacing: f64, filter: Filter, count: usize) -> f64 {
        let carried = if filter == Filter::Band { spacing } else { 0.0 };
        let Sampling { n, fading } = self.sampling(carried);
        self.parts_ns(Samples { spacing, n, filter, fading, side: (count.max(1) as f64).sqrt() })
    }

    /// The predicted cost of a sample of a tile.
    pub(super) fn tile_ns(&self, Sampling { n, fading }: Sampling) -> f64 {
        self.parts_ns(Samples { spacing: fading.spacing, n, filter: Filter::Band, fading, side: TILE })
    }

    fn parts_ns(&self, samples: Samples) -> f64 {
        let parts = samples.n as f64;
        // Once a column and once a row, shared by all samples of it.
        let columns: f64 = self.columns.iter().map(|instruction| self.instruction_ns(instruction, samples)).sum();
        let rows: f64 = self.rows.iter().map(|instruction| ROW_NS + self.instruction_ns(instruction, samples)).sum();
        parts * parts * (BLOCK_NS + self.part_ns(samples)) + parts * (columns + rows) / samples.side
    }

    /// What one of a sample's n × n parts costs.
    fn part_ns(&self, samples: Samples) -> f64 {
        self.samples.iter().map(|instruction| self.instruction_ns(instruction, samples)).sum()
    }

    /// The greatest predicted cost of a sample of a tile in nanoseconds at any spacing, with nothing but octaves of noise that are finer than the samples.
    ///
    /// Exact samples further apart than the valleys of an erosion cost more: each has to find a network of its own.
    #[must_use]
    pub fn peak_cost_ns(&self) -> f64 {
        let count = (TILE * TILE) as usize;
        let spacings = core::iter::successors(Some(64.0), |spacing| Some(spacing / 2.0)).take(31);
        let band = spacings.map(|spacing| self.cost_ns(spacing, Filter::Band, count)).fold(0.0, f64::max);
        let pitches = self.graph.erosions.iter().flat_map(|eroded| eroded.erosion.lattices().map(|lattice| lattice.pitch));
        let finest = pitches.fold(64.0, f64::min);
        band.max(self.cost_ns(finest / 2.0, Filter::Exact, count))
    }

    fn instruction_ns(&self, instruction: &Instruction, samples: Samples) -> f64 {
        let drawn = if samples.n == SIDE { DRAWN_NS } else { 0.0 };
        let noise = |noise: usize, way: Way| drawn + octaves_ns(&self.graph.noises[noise], way, samples);
        match *instruction {
            Instruction::Move { .. } | Instruction::Shift { .. } => 1.4,
            Instruction::Rows { rows, .. } => noise(self.noise_rows[rows].0, Way::Rows),
            Instruction::Noise { noise: of, .. } => noise(of, Way::Points),
            Instruction::Slopes { noise: of, .. } => SLOPES * noise(of, Way::Points),
            Instruction::Erosion { erosion, at, .. } => self.erosion_ns(erosion, at, samples),
            Instruction::Step { step: Step::Shape(shape, _), .. } => shape_ns(self.graph.shapes[shape], [6.0, 1.2]),
            Instruction::Step { step: Step::ShapeSlope(shape, ..), .. } => shape_ns(self.graph.shapes[shape], [20.0, 5.0]),
            Instruction::Step { step, .. } => step_ns(step),
        }
    }

    /// Lattices whose nodes an erosion finds at the same places before another does.
    fn found_before(&self, erosion: usize, at: Points) -> usize {
        let eroded = &self.graph.erosions;
        let before = self.samples.iter().filter_map(|instruction| match *instruction {
            Instruction::Erosion { erosion: other, at: there, .. } if there == at => Some(other),
            _ => None,
        });
        let before = before.take_while(|&other| other != erosion).filter(|&other| eroded[other].networks == eroded[erosion].networks);
        before.map(|other| eroded[other].erosion.lattices().count()).max().unwrap_or(0)
    }

    /// Links for every sample; and nodes, shared by the samples of a cell and found around the window too, where the terrain is asked for their heights.
    fn erosion_ns(&self, erosion: usize, at: Points, samples: Samples) -> f64 {
        let Samples { spacing, n, fading, side, .. } = samples;
        let square = |side: f64| side * side;
        let eroded = &self.graph.erosions[erosion];
        let lattices: Vec<Lattice> = eroded.erosion.lattices_carried(fading).collect();
        let found_before = self.found_before(erosion, at);
        // Wherever else samples are, they are farther apart.
        let stretch = if matches!(at, Points::Grid(_)) { 1.0 } else { WARPED };
        let (parts, mut sum, mut beyond) = (side * n as f64, LOWER_NS, 0.0);
        for (number, &Lattice { pitch, candidates, reach }) in lattices.iter().enumerate().rev() {
            let across = side * spacing * stretch / pitch;
            // More is found around the window; and no sample has more than what is around it alone.
            let found = |around: f64| square(across + around).min(square(parts * around));
            let margin = 10.0 + 4.0 * reach;
            let heights = candidates * found(beyond + margin);
            let terrain =
                self.terrains[eroded.networks].part_ns(Samples { spacing: pitch, n: 1, filter: Filter::Exact, fading: Fading::NONE, side: heights.sqrt() });
            let nodes = found(beyond + 5.0 + 2.0 * reach) * NODE_NS * reach;
            let corners = found(beyond + 1.0) * (CORNER_NS + AROUND_NS * reach);
            // Samples in a row around one corner share vectors.
            let run = (pitch / (spacing * stretch) * n as f64).clamp(1.0, 8.0);
            sum += LINKS_NS * 8.0 / run;
            if number >= found_before {
                sum += (heights * (terrain + SCATTERED_NS * number as f64) + nodes + corners) / square(parts);
            }
            // Nodes of a finer lattice ask for heights of this one.
            beyond = (beyond + margin) * number.checked_sub(1).map_or(1.0, |coarser| pitch / lattices[coarser].pitch);
        }
        sum
    }
}

/// Samples of a square.
#[derive(Clone, Copy)]
struct Samples {
    /// Their distance in programme units.
    spacing: f64,
    /// Parts a side of each.
    n: usize,
    filter: Filter,
    fading: Fading,
    /// How many there are along a side.
    side: f64,
}

/// Samples along a side of a tile.
const TILE: f64 = 256.0;

/// What a step costs for one number alone.
const ROW_NS: f64 = 60.0;

/// What an empty programme costs.
const BLOCK_NS: f64 = 0.4;

/// How much more a noise's two slopes cost than its value.
const SLOPES: f64 = 1.3;

/// What it costs to draw what stands for the detail of a noise.
const DRAWN_NS: f64 = 0.5;

/// What an erosion costs without any valleys.
const LOWER_NS: f64 = 1.5;

/// What the links of one lattice of an erosion cost.
const LINKS_NS: f64 = 25.0;

/// How much farther apart samples are whose places are moved.
const WARPED: f64 = 2.0;

/// What the links of each coarser lattice cost at a node of a finer one: few samples there share a corner.
const SCATTERED_NS: f64 = 105.0;

/// What finding a node's link costs, for every cell that it may span.
const NODE_NS: f64 = 75.0;

/// What putting together what is around a corner costs, and for every cell that links may span.
const CORNER_NS: f64 = 200.0;
const AROUND_NS: f64 = 150.0;

/// How a noise is evaluated.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Along the rows of a lattice.
    Rows,
    /// At positions that differ from sample to sample.
    Points,
}

fn octaves_ns(noise: &Noise, way: Way, Samples { spacing, n, filter, .. }: Samples) -> f64 {
    let fold = match noise.shape {
        FieldShape::Ridged { .. } | FieldShape::Hybrid { .. } => 0.25,
        _ => 0.05,
    };
    // Parts of samples along a cell, and how many there would be of what octaves are filtered for.
    let (mut parts, mut samples, mut sum) = (n as f64 / spacing, 1.0 / sampling::detail(spacing, n), 0.5);
    for _ in 0..noise.shape.octaves() {
        if filter == Filter::Exact || samples > 2.0 {
            sum += fold + octave_ns(noise.basis, way, parts);
        }
        (parts, samples) = (parts / noise.shape.lacunarity(), samples / noise.shape.lacunarity());
    }
    sum
}

/// Samples along a side of a cell from which on rows take it as a whole.
const WIDE: f64 = 12.0;

/// One octave with cells of that many samples a side.
fn octave_ns(basis: Basis, way: Way, samples: f64) -> f64 {
    // What is done once a cell and row, shared by the cell's samples.
    let share = 1.0 / samples.max(0.5);
    let wide = way == Way::Rows && samples >= WIDE;
    match basis {
        Basis::OPerlin | Basis::IPerlin if way == Way::Rows => 0.75 + 0.6 * share,
        Basis::OPerlin | Basis::IPerlin => 2.8,
        Basis::Blender if way == Way::Rows => 2.8,
        Basis::Blender => 4.4,
        Basis::CellNoise if wide => 0.6,
        Basis::CellNoise if way == Way::Rows => 3.7,
        Basis::CellNoise => 6.8,
        Basis::Voronoi { feature, metric } => {
            let order = match feature {
                Feature::F1 => 1.0,
                Feature::F2 | Feature::F2F1 => 1.2,
                Feature::Crackle => 1.3,
                Feature::F3 => 1.75,
                Feature::F4 => 2.2,
            };
            let metric = match metric {
                Metric::Minkowski { exponent: 0.5 } => 2.0,
                Metric::Minkowski { .. } => 3.8,
                _ => 1.0,
            };
            let nearest = if wide {
                3.9 + 45.0 * share
            } else if way == Way::Rows {
                10.8
            } else {
                14.0
            };
            order * metric * nearest
        }
    }
}

fn shape_ns(shape: Shape, [gauss_ns, other_ns]: [f64; 2]) -> f64 {
    match shape {
        Shape::Gauss { .. } => gauss_ns,
        Shape::Plane { .. } | Shape::Step { .. } | Shape::Sphere { .. } => other_ns,
    }
}

fn step_ns(step: Step) -> f64 {
    match step {
        Step::Unary(Unary::Negative | Unary::Abs, _) => 0.15,
        Step::Unary(Unary::Sqrt, _) | Step::Terrace(..) | Step::TerraceSlope(..) => 1.1,
        // Five times that for angles beyond 2^17, which are rare.
        Step::Unary(Unary::Sin | Unary::Cos | Unary::Tan, _) => 6.0,
        Step::Unary(Unary::Atan, _) => 5.4,
        Step::Unary(Unary::Log, _) => 4.1,
        Step::Binary(Binary::Power, ..) => 39.0,
        Step::Binary(Binary::Divide | Binary::Mod, ..) => 0.45,
        Step::Binary(..) => 0.2,
        Step::Select(..) | Step::Number(_) | Step::Coordinate(..) => 0.3,
        Step::Shape(..) | Step::ShapeSlope(..) | Step::Noise(..) | Step::NoiseSlope(..) | Step::Erosion(..) => 0.0,
    }
}
