//! A programme as lists of instructions: what is done once a window, once a column, once a row and once a sample.

use super::{
    Frame, bounds,
    evaluate::Evaluation,
    graph::{Axis, Graph, Id, Place, PlaceId, Step, TooLarge},
    node::Node,
    operation::Unary,
};
use crate::{
    geometry::{Stop, Window},
    noise::{Isa, Terrain},
};
use std::{collections::BTreeMap, sync::OnceLock};

/// What a value depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    Number,
    Column,
    Row,
    Sample,
}

impl Class {
    fn and(self, other: Class) -> Class {
        match (self, other) {
            (Class::Number, class) | (class, Class::Number) => class,
            (one, other) if one == other => one,
            _ => Class::Sample,
        }
    }
}

/// Where a value is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// One number, the same for a window or for a row.
    Scalar(usize),
    /// One number a column of the window.
    Column(usize),
    /// One number a sample of the block.
    Register(usize),
}

/// Where a step's samples lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Points {
    /// The window's lattice, shifted: number of the grid.
    Grid(usize),
    /// Anywhere: number of the block's positions.
    Anywhere(usize),
}

/// One step of a tape. No operand is the register that is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Instruction {
    /// Positions: those of `base` plus two values.
    Move { to: usize, base: Points, by: [Slot; 2] },
    /// Positions: those of `base` plus a constant.
    Shift { to: usize, base: Points, by: [f64; 2] },
    /// A noise on a grid, along its rows: number of the noise's rows.
    Rows { to: usize, rows: usize },
    /// A noise at positions.
    Noise { to: usize, noise: usize, at: usize },
    /// Both derivatives of a noise.
    Slopes { to: [usize; 2], noise: usize, at: Points },
    /// Valleys cut into a value.
    Erosion { to: usize, erosion: usize, of: Slot, at: Points },
    /// A step whose value follows from its place and its operands.
    Step { to: Slot, step: Step, at: Option<Points>, operands: [Slot; 3] },
}

impl Instruction {
    /// The register that it writes, if it writes one.
    pub(super) fn register(&self) -> Option<usize> {
        match *self {
            Instruction::Rows { to, .. }
            | Instruction::Noise { to, .. }
            | Instruction::Erosion { to, .. }
            | Instruction::Step { to: Slot::Register(to), .. } => Some(to),
            _ => None,
        }
    }
}

/// A compiled programme.
///
/// ```
/// use terrane::{geometry::{Filter, Window}, programme::{Frame, Programme, Tape}};
/// let tape = Tape::compile(Programme::parse("multiply(2, x)")?.root());
/// let frame = Frame { seed: 7, scale: 100.0, origin: [0.0, 0.0] };
/// let window = Window::area([0.0, 0.0, 300.0, 100.0], 100.0, Filter::Band, 100)?;
/// let mut heights = [0.0; 3];
/// tape.evaluate(&frame, &window, &mut heights);
/// assert_eq!(heights, [1.0, 3.0, 5.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tape {
    pub(super) graph: Graph,
    /// Once a window, once a column, once a row and once a sample, in the order of their operands.
    pub(super) numbers: Vec<Instruction>,
    pub(super) columns: Vec<Instruction>,
    pub(super) rows: Vec<Instruction>,
    pub(super) samples: Vec<Instruction>,
    /// Shifts of the grids.
    pub(super) grids: Vec<[f64; 2]>,
    /// Noise and grid of every noise that is evaluated along rows.
    pub(super) noise_rows: Vec<(usize, usize)>,
    pub(super) scalar_count: usize,
    pub(super) column_count: usize,
    pub(super) register_count: usize,
    pub(super) position_count: usize,
    pub(super) root: Slot,
    /// What is eroded, for positions that are given.
    pub(super) terrains: Vec<Tape>,
    /// [`Tape::network_slopes`], once they are asked for.
    pub(super) network_slopes: OnceLock<Vec<f32>>,
}

impl Tape {
    /// Compiles a programme.
    ///
    /// # Panics
    /// If the node does not come from a [`super::Programme`], which has checked its size.
    #[must_use]
    pub fn compile(root: &Node) -> Self {
        Self::try_compile(root).expect("a programme's size was checked when it was parsed")
    }

    pub(super) fn try_compile(root: &Node) -> Result<Self, TooLarge> {
        Ok(Compiler::new(Graph::simplified(root)?, Samples::Lattice).compile())
    }

    /// As [`Tape::try_compile`], of the programme as it was written.
    pub(super) fn plain(root: &Node) -> Result<Self, TooLarge> {
        Ok(Compiler::new(Graph::plain(root)?, Samples::Lattice).compile())
    }

    /// The least and the greatest value that any sample can have, by interval arithmetic over the exact programme; the values of what is filtered lie within it.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let range = bounds::ranges(&self.graph, &bounds::fields(&self.graph, 0, 0.0))[self.graph.root];
        if self.graph.number(self.graph.root).is_some() { range } else { bounds::averaged(range) }
    }

    /// Evaluates a window into `out`, row by row from north to south; answers how many results were not finite and became 0.
    ///
    /// # Panics
    /// If `out` has not one element a sample.
    pub fn evaluate(&self, frame: &Frame, window: &Window, out: &mut [f32]) -> u64 {
        self.evaluate_on(Isa::active(), frame, window, out)
    }

    /// As [`Tape::evaluate`], on a given instruction set: the same bits, in another time.
    ///
    /// # Panics
    /// If `out` has not one element a sample.
    pub fn evaluate_on(&self, isa: Isa, frame: &Frame, window: &Window, out: &mut [f32]) -> u64 {
        assert_eq!(out.len(), window.samples(), "one element a sample");
        Evaluation::new(isa, self, frame, window).run(window, out, &Stop::never())
    }

    /// As [`Tape::evaluate`], until it is stopped: rows that were not begun then are left as they are.
    ///
    /// # Panics
    /// If `out` has not one element a sample.
    pub fn evaluate_until(&self, stop: &Stop, frame: &Frame, window: &Window, out: &mut [f32]) -> u64 {
        assert_eq!(out.len(), window.samples(), "one element a sample");
        Evaluation::new(Isa::active(), self, frame, window).run(window, out, stop)
    }
}

/// A programme compiled for positions that are given one by one.
///
/// ```
/// use terrane::{noise::Isa, programme::{Frame, PointTape, Programme}};
/// let tape = PointTape::compile(Programme::parse("multiply(2, x)")?.root());
/// let mut values = [0.0; 2];
/// tape.evaluate(Isa::active(), &Frame { seed: 7, scale: 1.0, origin: [0.0, 0.0] }, &[3.0, 5.0], &[0.0, 0.0], &mut values);
/// assert_eq!(values, [6.0, 10.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PointTape(Tape);

impl PointTape {
    /// Compiles a programme.
    ///
    /// # Panics
    /// If the node does not come from a [`super::Programme`], which has checked its size.
    #[must_use]
    pub fn compile(root: &Node) -> Self {
        let tape = Graph::simplified(root).map(|graph| Compiler::new(graph, Samples::Anywhere).compile());
        Self(tape.expect("a programme's size was checked when it was parsed"))
    }

    /// The programme as it is at positions in programme coordinates; what is not finite is 0.
    ///
    /// # Panics
    /// If there are not as many positions as values.
    pub fn evaluate(&self, isa: Isa, frame: &Frame, us: &[f64], vs: &[f64], out: &mut [f32]) {
        assert!(us.len() == out.len() && vs.len() == out.len(), "one value a position");
        Evaluation::anywhere(isa, &self.0, frame).heights(us, vs, out);
    }
}

/// Where a tape's samples lie.
#[derive(Clone, Copy, PartialEq)]
enum Samples {
    /// On a lattice of rows and columns.
    Lattice,
    /// At positions that are given, number 0 of the block's positions.
    Anywhere,
}

struct Compiler {
    samples: Samples,
    tape: Tape,
    order: Vec<Id>,
    classes: Vec<Class>,
    slots: Vec<Option<Slot>>,
    /// The position in `order` after which a value is not wanted.
    last_use: Vec<usize>,
    free: Vec<usize>,
    places: Vec<Option<Points>>,
    /// The derivatives of noises.
    slopes: BTreeMap<Step, Id>,
}

impl Compiler {
    fn new(graph: Graph, samples: Samples) -> Self {
        let terrains = graph.networks.iter().map(|network| Compiler::new(Graph::clone(&network.terrain), Samples::Anywhere).compile()).collect();
        let order = graph.reachable(graph.root);
        let (steps, places) = (graph.steps.len(), graph.places.len());
        let tape = Tape {
            numbers: Vec::new(),
            columns: Vec::new(),
            rows: Vec::new(),
            samples: Vec::new(),
            grids: Vec::new(),
            noise_rows: Vec::new(),
            scalar_count: 0,
            column_count: 0,
            register_count: 0,
            position_count: usize::from(samples == Samples::Anywhere),
            terrains,
            network_slopes: OnceLock::new(),
            root: Slot::Scalar(0),
            graph,
        };
        let slopes = order.iter().map(|&id| (tape.graph.steps[id], id)).filter(|(step, _)| matches!(step, Step::NoiseSlope(..))).collect();
        let (classes, slots, last_use) = (vec![Class::Number; steps], vec![None; steps], vec![0; steps]);
        Self { samples, tape, order, classes, slots, last_use, free: Vec::new(), places: vec![None; places], slopes }
    }

    fn compile(mut self) -> Tape {
        for (position, &id) in self.order.clone().iter().enumerate() {
            self.classes[id] = self.class(id);
            for operand in self.tape.graph.steps[id].operands() {
                self.last_use[operand] = position;
            }
            for moved_by in self.tape.graph.moved_by(id) {
                self.last_use[moved_by] = position;
            }
        }
        self.last_use[self.tape.graph.root] = self.order.len();
        for position in 0..self.order.len() {
            let id = self.order[position];
            self.step(id);
            self.release(position);
        }
        self.tape.root = self.slot(self.tape.graph.root);
        self.tape
    }

    fn class(&self, id: Id) -> Class {
        let graph = &self.tape.graph;
        let on_grid = |place: PlaceId| self.samples == Samples::Lattice && matches!(graph.places[place], Place::Grid { .. });
        let along = |axis: Option<Axis>| match axis {
            Some(Axis::U) => Class::Column,
            Some(Axis::V) => Class::Row,
            None => Class::Sample,
        };
        match graph.steps[id] {
            Step::Number(_) => Class::Number,
            Step::Coordinate(axis, place) if on_grid(place) => along(Some(axis)),
            Step::Shape(shape, place) if on_grid(place) => along(graph.shapes[shape].axis()),
            step if step.place().is_some() => Class::Sample,
            // Seen from afar, it has a value of its own in every part of a sample.
            Step::Unary(Unary::Sin | Unary::Cos, a) if self.classes[a] != Class::Number => Class::Sample,
            step => step.operands().fold(Class::Number, |class, operand| class.and(self.classes[operand])),
        }
    }

    fn slot(&self, id: Id) -> Slot {
        self.slots[id].expect("operands come first")
    }

    fn register(&mut self) -> usize {
        self.free.pop().unwrap_or_else(|| {
            self.tape.register_count += 1;
            self.tape.register_count - 1
        })
    }

    /// Frees the registers whose last use is over.
    fn release(&mut self, position: usize) {
        let id = self.order[position];
        let graph = &self.tape.graph;
        let mut done: Vec<Id> = graph.steps[id].operands().collect();
        done.extend(graph.moved_by(id));
        done.sort_unstable();
        done.dedup();
        done.retain(|&id| self.last_use[id] == position);
        let registers = done.into_iter().filter_map(|id| if let Some(Slot::Register(register)) = self.slots[id] { Some(register) } else { None });
        self.free.extend(registers);
    }

    fn step(&mut self, id: Id) {
        if self.slots[id].is_some() {
            return;
        }
        let step = self.tape.graph.steps[id];
        let at = step.place().map(|place| self.points(place));
        match (step, at) {
            (Step::Noise(noise, _), Some(Points::Grid(grid))) => {
                let (to, rows) = (self.register(), self.noise_rows(noise, grid));
                self.keep(id, to, Instruction::Rows { to, rows });
            }
            (Step::Noise(noise, _), Some(Points::Anywhere(at))) => {
                let to = self.register();
                self.keep(id, to, Instruction::Noise { to, noise, at });
            }
            (Step::Erosion(erosion, of, _), Some(at)) => {
                let (to, of) = (self.register(), self.slot(of));
                self.keep(id, to, Instruction::Erosion { to, erosion, of, at });
            }
            (Step::NoiseSlope(noise, axis, place), Some(at)) => self.slopes(id, noise, axis, place, at),
            _ => self.plain_step(id, step, at),
        }
    }

    fn keep(&mut self, id: Id, to: usize, instruction: Instruction) {
        self.slots[id] = Some(Slot::Register(to));
        self.tape.samples.push(instruction);
    }

    fn noise_rows(&mut self, noise: usize, grid: usize) -> usize {
        let found = self.tape.noise_rows.iter().position(|&rows| rows == (noise, grid));
        found.unwrap_or_else(|| {
            self.tape.noise_rows.push((noise, grid));
            self.tape.noise_rows.len() - 1
        })
    }

    /// Both derivatives come from one instruction.
    fn slopes(&mut self, id: Id, noise: usize, axis: Axis, place: PlaceId, at: Points) {
        let other = if axis == Axis::U { Axis::V } else { Axis::U };
        let partner = self.slopes.get(&Step::NoiseSlope(noise, other, place)).copied();
        let (own, others) = (self.register(), self.register());
        let to = if axis == Axis::U { [own, others] } else { [others, own] };
        self.keep(id, own, Instruction::Slopes { to, noise, at });
        match partner {
            Some(partner) => self.slots[partner] = Some(Slot::Register(others)),
            None => self.free.push(others),
        }
    }

    fn plain_step(&mut self, id: Id, step: Step, at: Option<Points>) {
        let mut operands = [Slot::Scalar(0); 3];
        for (slot, operand) in operands.iter_mut().zip(step.operands()) {
            *slot = self.slot(operand);
        }
        let to = match self.classes[id] {
            Class::Number | Class::Row => {
                self.tape.scalar_count += 1;
                Slot::Scalar(self.tape.scalar_count - 1)
            }
            Class::Column => {
                self.tape.column_count += 1;
                Slot::Column(self.tape.column_count - 1)
            }
            Class::Sample => Slot::Register(self.register()),
        };
        self.slots[id] = Some(to);
        let instruction = Instruction::Step { to, step, at, operands };
        match self.classes[id] {
            Class::Number => self.tape.numbers.push(instruction),
            Class::Column => self.tape.columns.push(instruction),
            Class::Row => self.tape.rows.push(instruction),
            Class::Sample => self.tape.samples.push(instruction),
        }
    }

    /// Where a place's samples lie; finding positions is an instruction of its own.
    fn points(&mut self, place: PlaceId) -> Points {
        if let Some(points) = self.places[place] {
            return points;
        }
        let points = match self.tape.graph.places[place] {
            Place::Grid { du, dv } if self.samples == Samples::Anywhere => {
                let by = [du.get(), dv.get()];
                if by == [0.0; 2] { Points::Anywhere(0) } else { self.position(|to| Instruction::Shift { to, base: Points::Anywhere(0), by }) }
            }
            Place::Grid { du, dv } => {
                self.tape.grids.push([du.get(), dv.get()]);
                Points::Grid(self.tape.grids.len() - 1)
            }
            Place::Moved { base, dx, dy } => {
                let (base, by) = (self.points(base), [dx, dy].map(|id| self.slot(id)));
                self.position(|to| Instruction::Move { to, base, by })
            }
            Place::Shifted { base, du, dv } => {
                let base = self.points(base);
                self.position(|to| Instruction::Shift { to, base, by: [du.get(), dv.get()] })
            }
        };
        self.places[place] = Some(points);
        points
    }

    fn position(&mut self, instruction: impl Fn(usize) -> Instruction) -> Points {
        let to = self.tape.position_count;
        self.tape.position_count += 1;
        self.tape.samples.push(instruction(to));
        Points::Anywhere(to)
    }
}
