//! Running a tape over the blocks of a window.

use super::{
    Frame, bounds,
    graph::{Axis, Eroded, Graph, Network, Step},
    kernels::{self, Input},
    operation::Unary,
    sampling::{self, Drawn, Sampling, Wave},
    shape::{Filtered, Write},
    tape::{Instruction, Points, Slot, Tape},
};
use crate::{
    geometry::{Filter, Stop, Window},
    noise::{Fading, Field, Isa, Networks, Rows, SIDE, Stead, Terrain, Valleys},
};

/// Samples a block: registers of a typical programme stay within the first-level cache.
pub(super) const BLOCK: usize = 256;

/// What a programme's noises and shapes are for samples of a given spacing.
pub(super) struct Prepared {
    pub fields: Vec<Field>,
    pub shapes: Vec<Filtered>,
    pub sampling: Sampling,
    /// What stands for the detail of each noise in the parts of samples.
    pub draws: Vec<Option<Drawn>>,
    /// The waves that a sine or cosine of each step makes, where they fade.
    pub waves: Vec<Option<Wave>>,
}

impl Prepared {
    /// For samples that are taken in some way; `waves` are the lengths of all waves.
    pub(super) fn new(graph: &Graph, waves: &[f64], frame: &Frame, sampling: Sampling) -> Self {
        let Sampling { n: subsamples, fading: Fading { spacing, .. } } = sampling;
        let part = spacing / subsamples as f64;
        let detail = sampling::detail(spacing, subsamples);
        let fields = bounds::fields(graph, frame.seed, detail);
        let shapes = graph.shapes.iter().map(|shape| shape.filtered(part)).collect();
        let draws = sampling::draws(graph, waves.len(), subsamples, detail);
        let waves = sampling::waves(graph, waves, subsamples, detail);
        Self { fields, shapes, sampling, draws, waves }
    }

    /// The programme as it is.
    pub(super) fn exact(graph: &Graph, frame: &Frame) -> Self {
        Self::new(graph, &[], frame, Sampling { n: 1, fading: Fading::NONE })
    }
}

/// Offsets of the subsamples of a sample from it, in metres from the west or the south.
pub(super) fn offsets(subsamples: usize, spacing: f64) -> impl Iterator<Item = f64> + Clone {
    let n = subsamples as f64;
    (0..subsamples).map(move |i| if subsamples == 1 { 0.0 } else { ((2 * i + 1) as f64 - n) / (2.0 * n) * spacing })
}

/// Positions of a block's samples in programme coordinates.
#[derive(Clone, Debug, Default)]
struct Positions {
    u: Vec<f64>,
    v: Vec<f64>,
}

/// A tape prepared for a window.
pub(super) struct Evaluation<'a> {
    isa: Isa,
    tape: &'a Tape,
    frame: &'a Frame,
    prepared: Prepared,
    /// Programme coordinates of the columns of every grid, subsamples included.
    grids: Vec<Vec<f64>>,
    noise_rows: Vec<Rows>,
    scalars: Vec<f32>,
    columns: Vec<Vec<f32>>,
    registers: Vec<Vec<f32>>,
    positions: Vec<Positions>,
    /// Of every erosion.
    valleys: Vec<Valleys>,
    eroded: Vec<Eroding<'a>>,
    /// Which row of parts of a sample is evaluated.
    part_row: usize,
    non_finite: u64,
}

/// Networks of valleys, and the terrain that they are cut into.
struct Eroding<'a> {
    networks: Networks,
    terrain: Evaluation<'a>,
}

impl Terrain for Evaluation<'_> {
    fn heights(&mut self, us: &[f64], vs: &[f64], out: &mut [f32]) {
        for ((us, vs), out) in us.chunks(BLOCK).zip(vs.chunks(BLOCK)).zip(out.chunks_mut(BLOCK)) {
            self.positions[0].u[..us.len()].copy_from_slice(us);
            self.positions[0].v[..vs.len()].copy_from_slice(vs);
            self.block(0, 0.0, out);
        }
    }
}

impl Tape {
    /// What stands for the valleys of an erosion that samples cannot carry. Erosions of one `seed=` swing together.
    pub(super) fn stead(&self, number: usize, prepared: &Prepared) -> Stead {
        let Sampling { n, fading } = prepared.sampling;
        if fading.spacing <= 0.0 {
            return Stead::NONE;
        }
        let erosions = &self.graph.erosions;
        let needed = Valleys::needs_mean(&erosions[number].erosion, fading);
        let mut lattices = Vec::new();
        for eroded in &erosions[..=number] {
            let of = self.graph.networks[eroded.networks].lattices;
            if !lattices.contains(&of) {
                lattices.push(of);
            }
        }
        let own = self.graph.networks[erosions[number].networks].lattices;
        let order = lattices.iter().position(|&lattices| lattices == own).unwrap_or(0);
        Stead {
            mean_slope: if needed { self.network_slopes()[erosions[number].networks] } else { 0.0 },
            floor: bounds::erosion_floor(&self.graph, number),
            swings: (n == SIDE).then(|| Stead::swings(order)),
        }
    }

    /// The mean slope of the coarsest of every network, for a seed of 0: what stands for valleys that are too far away to be seen at all.
    pub(super) fn network_slopes(&self) -> &[f32] {
        const FRAME: Frame = Frame { seed: 0, scale: 1.0, origin: [0.0; 2] };
        let slope = |(network, terrain): (&Network, &Tape)| {
            let isa = Isa::active();
            Networks::new(isa, &network.erosion, network.lattices.key(FRAME.seed)).mean_slope(&mut Evaluation::anywhere(isa, terrain, &FRAME))
        };
        self.network_slopes.get_or_init(|| self.graph.networks.iter().zip(&self.terrains).map(slope).collect())
    }
}

impl<'a> Evaluation<'a> {
    pub(super) fn new(isa: Isa, tape: &'a Tape, frame: &'a Frame, window: &Window) -> Self {
        let spacing = if window.filter == Filter::Band { window.spacing() / frame.scale } else { 0.0 };
        let sampling = tape.sampling(spacing);
        let (n, prepared) = (sampling.n, Prepared::new(&tape.graph, &sampling::wave_lengths(&tape.graph), frame, sampling));
        let sub = offsets(n, window.spacing());
        let columns: Vec<f64> =
            window.columns.coordinates().flat_map(|x| sub.clone().map(move |d| x + d)).map(|x| (x - frame.origin[0]) / frame.scale).collect();
        let mut evaluation = Self::prepared(isa, tape, frame, prepared, &columns);
        evaluation.once(columns.len(), window.rows.len() * n);
        evaluation
    }

    /// For positions that are given, of the programme as it is.
    pub(super) fn anywhere(isa: Isa, tape: &'a Tape, frame: &'a Frame) -> Self {
        let prepared = Prepared::exact(&tape.graph, frame);
        let mut evaluation = Self::prepared(isa, tape, frame, prepared, &[]);
        evaluation.once(1, 1);
        evaluation
    }

    fn prepared(isa: Isa, tape: &'a Tape, frame: &'a Frame, prepared: Prepared, columns: &[f64]) -> Self {
        let grids: Vec<Vec<f64>> = tape.grids.iter().map(|[du, _]| columns.iter().map(|u| u + du).collect()).collect();
        let noise_rows = tape.noise_rows.iter().map(|&(noise, grid)| prepared.fields[noise].rows_on(isa, &grids[grid])).collect();
        let valleys = |(number, eroded): (usize, &Eroded)| Valleys::new(&eroded.erosion, prepared.sampling.fading, &tape.stead(number, &prepared));
        let eroding = |(network, terrain): (&Network, &'a Tape)| {
            let networks = Networks::new(isa, &network.erosion, network.lattices.key(frame.seed));
            Eroding { networks, terrain: Self::anywhere(isa, terrain, frame) }
        };
        let valleys = tape.graph.erosions.iter().enumerate().map(valleys).collect();
        let eroded = tape.graph.networks.iter().zip(&tape.terrains).map(eroding).collect();
        Self {
            isa,
            tape,
            frame,
            prepared,
            grids,
            noise_rows,
            scalars: vec![0.0; tape.scalar_count],
            columns: vec![vec![0.0; columns.len()]; tape.column_count],
            registers: vec![vec![0.0; BLOCK]; tape.register_count],
            positions: vec![Positions { u: vec![0.0; BLOCK], v: vec![0.0; BLOCK] }; tape.position_count],
            valleys,
            eroded,
            part_row: 0,
            non_finite: 0,
        }
    }

    /// Evaluates what is the same for the window, and what is the same for each column.
    fn once(&mut self, columns: usize, rows: usize) {
        for instruction in &self.tape.numbers {
            self.non_finite += self.scalar(instruction, 0.0) * (columns * rows) as u64;
        }
        for instruction in &self.tape.columns {
            let Instruction::Step { to: Slot::Column(to), step, at, operands } = *instruction else { continue };
            let mut out = std::mem::take(&mut self.columns[to]);
            for (block, out) in out.chunks_mut(BLOCK).enumerate() {
                self.non_finite += self.apply(step, at, operands, block * BLOCK, 0.0, out) * rows as u64;
            }
            self.columns[to] = out;
        }
    }

    pub(super) fn run(mut self, window: &Window, out: &mut [f32], stop: &Stop) -> u64 {
        let (n, width) = (self.prepared.sampling.n, window.columns.len().max(1));
        let mut fine = vec![0.0; if n > 1 { width * n } else { 0 }];
        for (y, row) in window.rows.coordinates().zip(out.chunks_mut(width)) {
            if stop.is_set() {
                break;
            }
            if n == 1 {
                self.row(y, row);
                continue;
            }
            row.fill(0.0);
            // A power of two, taken first so that no sum is too large.
            let share = 1.0 / (n * n) as f32;
            for (part_row, d) in offsets(n, window.spacing()).enumerate() {
                self.part_row = part_row;
                self.row(y + d, &mut fine);
                for (mean, fine) in row.iter_mut().zip(fine.chunks(n)) {
                    for value in fine {
                        *mean += value * share;
                    }
                }
            }
            for mean in row {
                *mean = mean.clamp(f32::MIN, f32::MAX);
            }
        }
        self.non_finite
    }

    fn row(&mut self, y: f64, out: &mut [f32]) {
        let v = (y - self.frame.origin[1]) / self.frame.scale;
        for (rows, &(_, grid)) in self.noise_rows.iter_mut().zip(&self.tape.noise_rows) {
            rows.begin(v + self.tape.grids[grid][1]);
        }
        for instruction in &self.tape.rows {
            self.non_finite += self.scalar(instruction, v) * out.len() as u64;
        }
        for (block, out) in out.chunks_mut(BLOCK).enumerate() {
            self.block(block * BLOCK, v, out);
        }
    }

    fn block(&mut self, start: usize, v: f64, out: &mut [f32]) {
        let tape = self.tape;
        // What is computed last is written where it belongs.
        let (rest, last) = match (tape.samples.split_last(), tape.root) {
            (Some((last, rest)), Slot::Register(root)) if last.register() == Some(root) => (rest, Some(last)),
            _ => (&tape.samples[..], None),
        };
        for instruction in rest {
            self.non_finite += self.instruction(instruction, start, v, out.len());
        }
        if let Some(last) = last {
            self.non_finite += self.write(last, start, v, out);
            return;
        }
        match self.input(tape.root, start, out.len()) {
            Input::Number(number) => out.fill(number),
            Input::Samples(samples) => out.copy_from_slice(samples),
        }
    }

    /// Evaluates a step whose value is one number.
    fn scalar(&mut self, instruction: &Instruction, v: f64) -> u64 {
        let Instruction::Step { to: Slot::Scalar(to), step, at, operands } = *instruction else { return 0 };
        let operands = operands.map(|slot| if let Slot::Scalar(slot) = slot { self.scalars[slot] } else { 0.0 });
        // What depends on v alone is the same at every u.
        let v = v + if let Some(Points::Grid(grid)) = at { self.tape.grids[grid][1] } else { 0.0 };
        let value = kernels::value(step, operands, [0.0, v], 0, &self.prepared);
        self.scalars[to] = if value.is_finite() { value } else { 0.0 };
        u64::from(!value.is_finite())
    }

    fn input(&self, slot: Slot, start: usize, count: usize) -> Input<'_> {
        match slot {
            Slot::Scalar(slot) => Input::Number(self.scalars[slot]),
            Slot::Column(slot) => Input::Samples(&self.columns[slot][start..start + count]),
            Slot::Register(slot) => Input::Samples(&self.registers[slot][..count]),
        }
    }

    /// Runs an instruction over `count` columns from `start` on.
    fn instruction(&mut self, instruction: &Instruction, start: usize, v: f64, count: usize) -> u64 {
        if let Some(to) = instruction.register() {
            let mut out = std::mem::take(&mut self.registers[to]);
            let non_finite = self.write(instruction, start, v, &mut out[..count]);
            self.registers[to] = out;
            return non_finite;
        }
        match *instruction {
            Instruction::Slopes { to, noise, at } => return self.slopes(to, noise, at, start, v, count),
            Instruction::Move { to, base, by } => {
                let mut positions = self.take_positions(to, base, start, v, count);
                for (positions, slot) in [&mut positions.u, &mut positions.v].into_iter().zip(by) {
                    match self.input(slot, start, count) {
                        Input::Number(by) => positions[..count].iter_mut().for_each(|p| *p += f64::from(by)),
                        Input::Samples(by) => positions.iter_mut().zip(by).for_each(|(p, &by)| *p += f64::from(by)),
                    }
                }
                self.positions[to] = positions;
            }
            Instruction::Shift { to, base, by: [du, dv] } => {
                let mut positions = self.take_positions(to, base, start, v, count);
                positions.u[..count].iter_mut().for_each(|p| *p += du);
                positions.v[..count].iter_mut().for_each(|p| *p += dv);
                self.positions[to] = positions;
            }
            _ => {}
        }
        0
    }

    /// Writes the values of an instruction that has one a sample.
    fn write(&mut self, instruction: &Instruction, start: usize, v: f64, out: &mut [f32]) -> u64 {
        let count = out.len();
        match *instruction {
            Instruction::Rows { rows, .. } => {
                self.noise_rows[rows].fill(start, out);
                kernels::draw(self.isa, self.prepared.draws[self.tape.noise_rows[rows].0].as_ref(), self.part_row, out);
            }
            Instruction::Noise { noise, at, .. } => {
                let at = &self.positions[at];
                self.prepared.fields[noise].points(self.isa, &at.u[..count], &at.v[..count], out);
                kernels::draw(self.isa, self.prepared.draws[noise].as_ref(), self.part_row, out);
            }
            Instruction::Erosion { erosion, of, at, .. } => {
                match self.input(of, start, count) {
                    Input::Number(height) => out.fill(height),
                    Input::Samples(heights) => out.copy_from_slice(heights),
                }
                let valleys = &mut self.valleys[erosion];
                let Eroding { networks, terrain } = &mut self.eroded[self.tape.graph.erosions[erosion].networks];
                match at {
                    Points::Grid(grid) => {
                        let (us, vs) = (&self.grids[grid][start..start + count], [v + self.tape.grids[grid][1]; BLOCK]);
                        valleys.carve(networks, terrain, us, &vs[..count], out, self.part_row * SIDE);
                    }
                    Points::Anywhere(at) => {
                        let at = &self.positions[at];
                        valleys.carve(networks, terrain, &at.u[..count], &at.v[..count], out, self.part_row * SIDE);
                    }
                }
            }
            Instruction::Step { step, at, operands, .. } => return self.apply(step, at, operands, start, v, out),
            Instruction::Slopes { .. } | Instruction::Move { .. } | Instruction::Shift { .. } => return 0,
        }
        kernels::keep_finite(self.isa, out)
    }

    /// Writes both derivatives of a noise.
    fn slopes(&mut self, [to_u, to_v]: [usize; 2], noise: usize, at: Points, start: usize, v: f64, count: usize) -> u64 {
        let (mut du, mut dv) = (std::mem::take(&mut self.registers[to_u]), std::mem::take(&mut self.registers[to_v]));
        let field = &self.prepared.fields[noise];
        match at {
            Points::Grid(grid) => {
                let (us, vs) = (&self.grids[grid][start..start + count], [v + self.tape.grids[grid][1]; BLOCK]);
                field.slope_points(self.isa, us, &vs[..count], &mut du[..count], &mut dv[..count]);
            }
            Points::Anywhere(at) => {
                let at = &self.positions[at];
                field.slope_points(self.isa, &at.u[..count], &at.v[..count], &mut du[..count], &mut dv[..count]);
            }
        }
        let non_finite = kernels::keep_finite(self.isa, &mut du[..count]) + kernels::keep_finite(self.isa, &mut dv[..count]);
        (self.registers[to_u], self.registers[to_v]) = (du, dv);
        non_finite
    }

    /// The positions of number `to`, set to those of a base.
    fn take_positions(&mut self, to: usize, base: Points, start: usize, v: f64, count: usize) -> Positions {
        let mut positions = std::mem::take(&mut self.positions[to]);
        match base {
            Points::Grid(grid) => {
                positions.u[..count].copy_from_slice(&self.grids[grid][start..start + count]);
                positions.v[..count].fill(v + self.tape.grids[grid][1]);
            }
            Points::Anywhere(base) => {
                positions.u[..count].copy_from_slice(&self.positions[base].u[..count]);
                positions.v[..count].copy_from_slice(&self.positions[base].v[..count]);
            }
        }
        positions
    }

    /// Writes a step's values; answers how many were not finite and became 0.
    fn apply(&self, step: Step, at: Option<Points>, operands: [Slot; 3], start: usize, v: f64, out: &mut [f32]) -> u64 {
        let count = out.len();
        let input = |i: usize| self.input(operands[i], start, count);
        let places = Places { evaluation: self, at, start, v };
        match step {
            Step::Number(bits) => {
                out.fill(f32::from_bits(bits));
                0
            }
            Step::Coordinate(axis, _) => places.write(out, |u, v| if axis == Axis::U { u as f32 } else { v as f32 }),
            Step::Shape(shape, _) => self.prepared.shapes[shape].write(&places, out),
            Step::ShapeSlope(shape, axis, _) => {
                let shape = self.prepared.shapes[shape];
                places.write(out, |u, v| shape.slope(axis, u, v))
            }
            Step::Unary(operation, a) => {
                let non_finite = kernels::unary(self.isa, operation, input(0), out);
                if let (Unary::Sin | Unary::Cos, Some(wave)) = (operation, &self.prepared.waves[a]) {
                    kernels::fade(self.isa, wave, self.part_row, out);
                }
                non_finite
            }
            Step::Binary(operation, ..) => kernels::binary(self.isa, operation, input(0), input(1), out),
            Step::Select(..) => kernels::select(self.isa, [input(0), input(1), input(2)], out),
            Step::Terrace(terrace, _) => kernels::map(self.isa, input(0), out, |h| terrace.apply(h)),
            Step::TerraceSlope(terrace, _) => kernels::map(self.isa, input(0), out, |h| terrace.slope(h)),
            Step::Noise(..) | Step::NoiseSlope(..) | Step::Erosion(..) => 0,
        }
    }
}

/// The positions of a block of samples.
struct Places<'a, 'b> {
    evaluation: &'a Evaluation<'b>,
    at: Option<Points>,
    start: usize,
    v: f64,
}

impl Write for Places<'_, '_> {
    fn write(&self, out: &mut [f32], function: impl Fn(f64, f64) -> f32) -> u64 {
        let &Self { evaluation, at, start, v } = self;
        match at {
            Some(Points::Anywhere(at)) => {
                let at = &evaluation.positions[at];
                kernels::at_points(evaluation.isa, &at.u, &at.v, out, function)
            }
            Some(Points::Grid(grid)) => kernels::along_row(evaluation.isa, &evaluation.grids[grid][start..], v + evaluation.tape.grids[grid][1], out, function),
            None => 0,
        }
    }
}
