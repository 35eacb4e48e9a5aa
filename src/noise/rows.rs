//! Fields along the rows of a window.
//!
//! Octaves are added one after another to a few hundred samples that stay in the first-level cache, each in a loop that is compiled for its noise and its step.

use super::{
    Field, Isa, Kernel, Lanes,
    aligned::AlignedArray,
    basis::BasisRows,
    fractal::{AnyStep, State, Step, with_step},
    number::{Number, Real, Table},
};

/// A field along the rows of a window.
pub struct Rows {
    isa: Isa,
    start: f32,
    octaves: Vec<(AnyStep, BasisRows)>,
    tail: Option<Table>,
    /// Whether the opening is used.
    opens: bool,
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
        let mut octaves = Vec::with_capacity(field.octaves.len());
        for octave in &field.octaves {
            octaves.push((octave.step.clone(), BasisRows::new(lanes, isa, field.basis, octave, coordinates)));
        }
        Rows { isa, start: field.start, octaves, tail: field.tail, opens: field.opens(), columns: coordinates.len() }
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
        for (_, rows) in &mut self.rows.octaves {
            rows.begin(lanes, self.v);
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

/// Room for a chunk that neither begins nor ends with a vector.
pub(super) const ROOM: usize = CHUNK + 32;

impl Kernel for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { rows, start, out } = self;
        let (mut values, mut openings) = (AlignedArray([0.0; ROOM]), AlignedArray([0.0; ROOM]));
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            let from = start + chunk * CHUNK;
            let first = from / L::WIDTH;
            let count = (from + out.len()).div_ceil(L::WIDTH) * L::WIDTH - first * L::WIDTH;
            let mut samples = Samples { first, values: &mut values.0[..count], openings: &mut openings.0[..count] };
            samples.values.fill(rows.start);
            if rows.opens {
                samples.openings.fill(1.0);
            }
            for (step, octave) in &rows.octaves {
                with_step!(step, step => octave.add(lanes, *step, &mut samples));
            }
            if let Some(tail) = &rows.tail {
                samples.finish(lanes, tail);
            }
            out.copy_from_slice(&values.0[from - first * L::WIDTH..][..out.len()]);
        }
    }
}

/// Consecutive samples of a row, whole vectors of them.
pub(super) struct Samples<'a> {
    /// Vectors of the row before these.
    pub first: usize,
    pub values: &'a mut [f32],
    pub openings: &'a mut [f32],
}

impl Samples<'_> {
    /// Number of vectors.
    #[inline(always)]
    pub(super) fn vectors<L: Lanes>(&self) -> usize {
        self.values.len() / L::WIDTH
    }

    /// Adds the tail's values.
    #[inline(always)]
    fn finish<L: Lanes>(&mut self, lanes: L, tail: &Table) {
        let tail = *tail;
        for (value, opening) in self.values.chunks_exact_mut(L::WIDTH).zip(self.openings.chunks_exact(L::WIDTH)) {
            let sum = lanes.load(value) + Real(lanes.load(opening)).interpolated(lanes, &tail).0;
            lanes.store(sum, value);
        }
    }
}

/// Adds an octave's noise to a vector of samples.
#[inline(always)]
pub(super) fn add<L: Lanes, S: Step>(lanes: L, step: S, noise: L::Floats, value: &mut [f32], opening: &mut [f32]) {
    let before = State { value: Real(lanes.load(value)), opening: Real(if S::OPENS { lanes.load(opening) } else { lanes.splat(1.0) }) };
    let after: State<Real<L>> = step.after(lanes, Real(noise), before);
    lanes.store(after.value.0, value);
    if S::OPENS {
        lanes.store(after.opening.0, opening);
    }
}
