//! Fields along the rows of a window.
//!
//! Octaves are added to a few hundred samples at a time, which stay in the first-level cache: first those that share cells all in one go, then the others one
//! after another.

use super::{
    Field, Isa, Kernel, Lanes,
    aligned::AlignedArray,
    basis::{BasisRows, BasisSheet},
    fractal::{AnyStep, State, Step, Steps, with_step},
    number::{Number, Real, Table},
    sheet::{Lines, side_by_side},
};

/// A field along the rows of a window.
pub struct Rows {
    isa: Isa,
    start: f32,
    sheet: BasisSheet,
    /// Of the sheet's octaves.
    steps: Steps,
    octaves: Vec<(AnyStep, BasisRows)>,
    tail: Option<Table>,
    /// How many columns there are.
    columns: usize,
}

impl Rows {
    pub(super) fn new(field: &Field, isa: Isa, coordinates: &[f64]) -> Self {
        isa.run(New { field, isa, coordinates })
    }

    /// Goes to the row of programme coordinate `v`.
    pub fn begin(&mut self, v: f64) {
        self.isa.run(Begin { rows: self, v });
    }

    /// Writes the values at the columns from `start` on.
    ///
    /// # Panics
    /// If there are not as many columns.
    pub fn fill(&self, start: usize, out: &mut [f32]) {
        assert!(start + out.len() <= self.columns, "{} columns from {start} on are more than {}", out.len(), self.columns);
        self.isa.run(Fill { rows: self, start, out });
    }
}

/// [`Field::rows`].
struct New<'a> {
    field: &'a Field,
    isa: Isa,
    coordinates: &'a [f64],
}

impl Kernel for New<'_> {
    type Output = Rows;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Rows {
        let Self { field, isa, coordinates } = self;
        let steps = Steps::leading(field.octaves.iter().map(|octave| &octave.step));
        let leading = field.octaves[..steps.len()].iter().map(|octave| (octave.lattice, octave.amplitude));
        let sheet = BasisSheet::new(lanes, field.basis, leading, coordinates);
        let mut octaves = Vec::with_capacity(field.octaves.len());
        for octave in &field.octaves[sheet.lines().map_or(0, Lines::octaves)..] {
            octaves.push((octave.step.clone(), BasisRows::new(lanes, isa, field.basis, octave, coordinates)));
        }
        Rows { isa, start: field.start, sheet, steps, octaves, tail: field.tail, columns: coordinates.len() }
    }
}

/// [`Rows::begin`].
struct Begin<'a> {
    rows: &'a mut Rows,
    v: f64,
}

impl Kernel for Begin<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        self.rows.sheet.begin(lanes, self.v);
        for (_, rows) in &mut self.rows.octaves {
            rows.begin(self.v);
        }
    }
}

/// [`Rows::fill`].
struct Fill<'a> {
    rows: &'a Rows,
    start: usize,
    out: &'a mut [f32],
}

/// Samples that octaves are added to at a time.
const CHUNK: usize = 256;

/// Room for a chunk that neither begins nor ends with a group of vectors.
const ROOM: usize = CHUNK + 64;

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let (Self { rows, start, out }, group) = (self, side_by_side::<L>() * L::WIDTH);
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            let from = start + chunk * CHUNK;
            let first = from / group;
            let count = (from + out.len()).div_ceil(group) * group - first * group;
            let (mut values, mut openings) = (AlignedArray([rows.start; ROOM]), AlignedArray([1.0; ROOM]));
            let (values, openings) = (&mut values.0[..count], &mut openings.0[..count]);
            if let Some(lines) = rows.sheet.lines() {
                match &rows.steps {
                    Steps::Add(steps) => lines.add(lanes, steps, first, values, openings),
                    Steps::AddAbsolute(steps) => lines.add(lanes, steps, first, values, openings),
                    Steps::Multiply(steps) => lines.add(lanes, steps, first, values, openings),
                    Steps::Ridge(steps) => lines.add(lanes, steps, first, values, openings),
                    Steps::Hybrid(steps) => lines.add(lanes, steps, first, values, openings),
                }
            }
            for (step, octave) in &rows.octaves {
                let mut noise = AlignedArray([0.0; ROOM]);
                let noise = &mut noise.0[..count];
                octave.fill(lanes, first * group, noise);
                with_step!(step, step => add_noise(lanes, *step, noise, values, openings));
            }
            if let Some(tail) = &rows.tail {
                finish(lanes, *tail, values, openings);
            }
            out.copy_from_slice(&values[from - first * group..][..out.len()]);
        }
    }
}

/// Adds an octave's noise to samples.
#[inline(always)]
pub(super) fn add_noise<L: Lanes, S: Step>(lanes: L, step: S, noise: &[f32], values: &mut [f32], openings: &mut [f32]) {
    let states = values.chunks_exact_mut(L::WIDTH).zip(openings.chunks_exact_mut(L::WIDTH));
    for (noise, (value, opening)) in noise.chunks_exact(L::WIDTH).zip(states) {
        let state = State::load::<S>(lanes, value, opening);
        step.after(lanes, Real(lanes.load(noise)), state).store::<S>(lanes, value, opening);
    }
}

/// Adds what is left out.
#[inline(always)]
pub(super) fn finish<L: Lanes>(lanes: L, tail: Table, values: &mut [f32], openings: &[f32]) {
    for (value, opening) in values.chunks_exact_mut(L::WIDTH).zip(openings.chunks_exact(L::WIDTH)) {
        let sum = lanes.load(value) + Real(lanes.load(opening)).interpolated(lanes, &tail).0;
        lanes.store(sum, value);
    }
}
