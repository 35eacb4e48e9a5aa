//! Cell noise: one random value a cell.
//!
//! A sample that stands for a square of side s < 1 cells has the square's mean, exactly: the square covers up to 2 × 2 cells, and its parts beyond the nearer side
//! of the sample's own column and row are (s/2 - m)/s, m the distance to that side.

use super::nearest::{self, LANES};
use crate::noise::{
    Isa, Kernel, Lanes,
    cells::{Columns, Lattice, RowCache},
    hash,
};

/// The value of a cell, in [0, 1).
#[inline(always)]
fn value(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// How much of a square around a sample lies beyond the nearer side of its cell, along one axis. `per_extent` is 1/s: infinite for a sample that is a point.
#[inline(always)]
fn beyond(per_extent: f32, fraction: f32) -> f32 {
    let margin = if fraction < 0.5 { fraction } else { 1.0 - fraction };
    let part = 0.5 - margin * per_extent;
    if part > 0.0 { part } else { 0.0 }
}

/// Which neighbour is on the nearer side.
#[inline(always)]
fn nearer(fraction: f32) -> i64 {
    if fraction < 0.5 { -1 } else { 1 }
}

#[inline(always)]
fn mix(a: f32, b: f32, part: f32) -> f32 {
    a + part * (b - a)
}

/// Cell noise in a lattice, averaged over squares.
#[derive(Clone, Copy)]
pub(in crate::noise) struct Values {
    lattice: Lattice,
    /// 1/s, at least 1.
    per_extent: f32,
}

impl Values {
    /// `extent`: side of the square that a sample stands for, in cells; 0 for the value as it is, more than 1 counts as 1.
    pub(in crate::noise) fn new(lattice: Lattice, extent: f32) -> Self {
        Self { lattice, per_extent: 1.0 / if extent < 1.0 { extent } else { 1.0 } }
    }

    fn is_exact(&self) -> bool {
        self.per_extent == f32::INFINITY
    }

    /// The value at a point.
    pub(in crate::noise) fn at(&self, u: f64, v: f64) -> f32 {
        let (column, row) = (self.lattice.locate(0, u), self.lattice.locate(1, v));
        self.of([column.cell, row.cell], [column.fraction as f32, row.fraction as f32])
    }

    /// The value at a place in a cell.
    #[inline(always)]
    fn of(&self, [i, j]: [i64; 2], [fx, fy]: [f32; 2]) -> f32 {
        let value = |i: i64, j: i64| value(hash::corner(hash::column_key(i), hash::row_key(j, self.lattice.seed)));
        if self.is_exact() {
            return value(i, j);
        }
        let (beside, above, part) = (i + nearer(fx), j + nearer(fy), beyond(self.per_extent, fy));
        mix(mix(value(i, j), value(i, above), part), mix(value(beside, j), value(beside, above), part), beyond(self.per_extent, fx))
    }
}

/// The values at the points (us, vs).
pub(in crate::noise) fn value_points(isa: Isa, values: &Values, us: &[f64], vs: &[f64], out: &mut [f32]) {
    isa.run(FillPoints { values, us, vs, out });
}

/// [`value_points`].
struct FillPoints<'a> {
    values: &'a Values,
    us: &'a [f64],
    vs: &'a [f64],
    out: &'a mut [f32],
}

impl Kernel for FillPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let lattice = &self.values.lattice;
        let (mut cells, mut fractions) = ([[0; LANES]; 2], [[0.0; LANES]; 2]);
        for ((us, vs), out) in self.us.chunks(LANES).zip(self.vs.chunks(LANES)).zip(self.out.chunks_mut(LANES)) {
            (cells[0], fractions[0]) = nearest::locate(lattice, 0, us);
            (cells[1], fractions[1]) = nearest::locate(lattice, 1, vs);
            fill(self.values, &cells, &fractions, out);
        }
    }
}

/// Writes the values at up to `LANES` places.
#[inline(always)]
fn fill(values: &Values, cells: &[[i64; LANES]; 2], fractions: &[[f32; LANES]; 2], out: &mut [f32]) {
    let mut line = [0.0; LANES];
    for lane in 0..LANES {
        line[lane] = values.of([cells[0][lane], cells[1][lane]], [fractions[0][lane], fractions[1][lane]]);
    }
    if out.len() == LANES {
        out.copy_from_slice(&line);
    } else {
        out.copy_from_slice(&line[..out.len()]);
    }
}

/// Fewest samples a cell, on average, for which a loop over each cell's samples is worth its beginning.
const WIDE: usize = 8;

/// Cell values along the rows of a window.
pub(in crate::noise) struct ValueRows {
    isa: Isa,
    values: Values,
    row: i64,
    fraction: f32,
    cells: Cells,
}

/// How the columns are gone through.
enum Cells {
    /// Cell by cell.
    Wide(Wide),
    /// Sample by sample: the columns' cells and places in them.
    Narrow { columns: Vec<i64>, fx: Vec<f32> },
}

/// Cells of many samples.
struct Wide {
    columns: Columns,
    /// The values of the lattice rows around the present one.
    values: RowCache<Vec<f32>>,
    /// Those of the present row, mixed with the nearer row's.
    line: Vec<f32>,
}

impl ValueRows {
    pub(in crate::noise) fn new(isa: Isa, values: Values, coordinates: &[f64]) -> Self {
        let columns = Columns::new(&values.lattice, coordinates, 1, 1);
        let cells = if coordinates.len() >= WIDE * columns.runs.len() {
            let nodes = columns.keys.len();
            Cells::Wide(Wide { columns, values: RowCache::new(3, || vec![0.0; nodes]), line: vec![0.0; nodes] })
        } else {
            let (columns, fx) = coordinates.iter().map(|&u| values.lattice.locate(0, u)).map(|at| (at.cell, at.fraction as f32)).unzip();
            Cells::Narrow { columns, fx }
        };
        Self { isa, values, row: 0, fraction: 0.0, cells }
    }

    /// Goes to the row of programme coordinate `v`.
    pub(in crate::noise) fn begin(&mut self, v: f64) {
        let position = self.values.lattice.locate(1, v);
        (self.row, self.fraction) = (position.cell, position.fraction as f32);
        let Cells::Wide(Wide { columns, values, line }) = &mut self.cells else { return };
        values.want(position.cell - 1, |row, values| {
            let row = hash::row_key(row, self.values.lattice.seed);
            for (entry, &column) in values.iter_mut().zip(&columns.keys) {
                *entry = value(hash::corner(column, row));
            }
        });
        let (part, above) = (beyond(self.values.per_extent, self.fraction), values.get((1 + nearer(self.fraction)) as usize));
        for (line, (&own, &above)) in line.iter_mut().zip(values.get(1).iter().zip(above)) {
            *line = mix(own, above, part);
        }
    }

    /// Writes the values at the columns from `start` on.
    pub(in crate::noise) fn fill(&self, start: usize, out: &mut [f32]) {
        self.isa.run(FillRow { rows: self, start, out });
    }
}

/// [`ValueRows::fill`].
struct FillRow<'a> {
    rows: &'a ValueRows,
    start: usize,
    out: &'a mut [f32],
}

impl Kernel for FillRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { rows, start, out } = self;
        let end = start + out.len();
        match &rows.cells {
            Cells::Wide(Wide { columns, line, .. }) => {
                let exact = rows.values.is_exact();
                for run in columns.runs_within(start, end) {
                    let (west, own, east) = (line[run.node - 1], line[run.node], line[run.node + 1]);
                    let out = &mut out[run.start - start..run.end - start];
                    if exact {
                        out.fill(own);
                        continue;
                    }
                    for (out, &fx) in out.iter_mut().zip(&columns.fraction[run.start..run.end]) {
                        *out = mix(own, if fx < 0.5 { west } else { east }, beyond(rows.values.per_extent, fx));
                    }
                }
            }
            Cells::Narrow { columns, fx } => {
                let (mut cells, mut fractions) = ([[0; LANES], [rows.row; LANES]], [[0.0; LANES], [rows.fraction; LANES]]);
                for ((columns, fx), out) in columns[start..end].chunks(LANES).zip(fx[start..end].chunks(LANES)).zip(out.chunks_mut(LANES)) {
                    for lane in 0..LANES {
                        let sample = lane.min(out.len() - 1);
                        (cells[0][lane], fractions[0][lane]) = (columns[sample], fx[sample]);
                    }
                    fill(&rows.values, &cells, &fractions, out);
                }
            }
        }
    }
}
