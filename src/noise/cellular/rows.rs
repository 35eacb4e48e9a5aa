//! Distances along the rows of a window.

use super::{
    nearest::{self, BLOCKS, HAIR, LANES, MOST_RINGS, Places},
    points::{Query, TOGETHER, fill_places},
};
use crate::noise::{
    Kernel, Lanes,
    cells::{Columns, RowCache, Run},
    hash,
    metric::{Measure, Measured, larger, smaller},
};

/// Fewest samples a cell, on average, for which a loop over each cell's samples is worth its beginning.
const WIDE: usize = 12;

/// Distances along the rows of a window.
pub(in crate::noise) struct DistanceRows {
    query: Query,
    row: i64,
    fraction: f32,
    cells: Cells,
}

/// How the columns are gone through.
enum Cells {
    /// Cell by cell: its points are the same for all of its samples.
    Wide(Wide),
    /// Sample by sample: the columns' cells and places in them.
    Narrow { columns: Vec<i64>, fx: Vec<f32> },
}

impl DistanceRows {
    pub(in crate::noise) fn new(query: Query, coordinates: &[f64]) -> Self {
        let columns = Columns::new(&query.lattice, coordinates, HALO, HALO);
        let cells = if coordinates.len() >= WIDE * columns.runs.len() {
            let nodes = columns.keys.len();
            let cells = columns.runs.iter().map(|run| query.lattice.locate(0, coordinates[run.start]).cell).collect();
            Cells::Wide(Wide { columns, cells, hashes: RowCache::new(1 + 2 * HALO as usize, || vec![0; nodes]) })
        } else {
            let (columns, fx) = coordinates.iter().map(|&u| query.lattice.locate(0, u)).map(|at| (at.cell, at.fraction as f32)).unzip();
            Cells::Narrow { columns, fx }
        };
        Self { query, row: 0, fraction: 0.0, cells }
    }

    /// Goes to the row of programme coordinate `v`.
    pub(in crate::noise) fn begin(&mut self, v: f64) {
        let position = self.query.lattice.locate(1, v);
        (self.row, self.fraction) = (position.cell, position.fraction as f32);
        if let Cells::Wide(Wide { columns, hashes, .. }) = &mut self.cells {
            hashes.want(position.cell - HALO, |row, hashes| {
                let row = hash::row_key(row, self.query.lattice.seed);
                for (entry, &column) in hashes.iter_mut().zip(&columns.keys) {
                    *entry = hash::corner(column, row);
                }
            });
        }
    }

    /// Writes the values at the columns from `start` on.
    pub(in crate::noise) fn fill(&self, start: usize, out: &mut [f32]) {
        struct Fill<'a>(&'a DistanceRows, usize, &'a mut [f32]);
        impl Measured for Fill<'_> {
            type Output = ();

            fn run<M: Measure>(self, measure: M) {
                let Fill(rows, start, out) = self;
                match rows.query.feature.order() {
                    1 => rows.query.isa.run(FillRow::<M, 1> { rows, measure, start, out }),
                    2 => rows.query.isa.run(FillRow::<M, 2> { rows, measure, start, out }),
                    _ => rows.query.isa.run(FillRow::<M, 4> { rows, measure, start, out }),
                }
            }
        }
        self.query.metric.measured(Fill(self, start, out));
    }
}

/// [`DistanceRows::fill`] for one measure and number of neighbours.
struct FillRow<'a, M, const K: usize> {
    rows: &'a DistanceRows,
    measure: M,
    start: usize,
    out: &'a mut [f32],
}

impl<M: Measure, const K: usize> Kernel for FillRow<'_, M, K> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { rows, measure, start, out } = self;
        match &rows.cells {
            Cells::Wide(wide) => {
                for run in wide.columns.runs_within(start, start + out.len()) {
                    let number = wide.columns.runs.partition_point(|other| other.end <= run.start);
                    let line = Line { query: &rows.query, measure, cell: [wide.cells[number], rows.row], fy: rows.fraction };
                    line.fill::<K>(wide, run, &mut out[run.start - start..run.end - start]);
                }
            }
            Cells::Narrow { columns, fx } => {
                let end = start + out.len();
                let mut places = [Places { rows: [rows.row; LANES], fy: [rows.fraction; LANES], ..Places::NONE }; BLOCKS];
                for ((columns, fx), out) in columns[start..end].chunks(TOGETHER).zip(fx[start..end].chunks(TOGETHER)).zip(out.chunks_mut(TOGETHER)) {
                    for (places, (columns, fx)) in places.iter_mut().zip(columns.chunks(LANES).zip(fx.chunks(LANES))) {
                        places.columns[..columns.len()].copy_from_slice(columns);
                        places.fx[..fx.len()].copy_from_slice(fx);
                    }
                    fill_places::<M, K>(&rows.query, measure, &places, out);
                }
            }
        }
    }
}

/// Rings of cells whose hashes are kept; two nearly always decide.
const HALO: i64 = 2;

/// Cells of many samples.
struct Wide {
    columns: Columns,
    /// The number of each run's cell.
    cells: Vec<i64>,
    /// Hashes of the cells in the rows around the present one.
    hashes: RowCache<Vec<u32>>,
}

/// Samples of a cell that are looked at together.
const PIECE: usize = 64;

/// Those of them that share registers.
const WIDTH: usize = 16;

/// One row of samples in one cell.
struct Line<'a, M> {
    query: &'a Query,
    measure: M,
    cell: [i64; 2],
    fy: f32,
}

impl<M: Measure> Line<'_, M> {
    #[inline(always)]
    fn fill<const K: usize>(&self, wide: &Wide, run: Run, out: &mut [f32]) {
        // The 3 × 3 points around the cell: their places along the row and the shares of their offsets from it.
        let mut around = [[0.0_f32; 2]; 9];
        for (slot, entry) in around.iter_mut().enumerate() {
            let (a, b) = (slot % 3, slot / 3);
            *entry = self.seen(wide.hashes.get(HALO as usize + b - 1)[run.node + a - 1], a as f32 - 1.0, b as f32 - 1.0);
        }
        let samples = &wide.columns.fraction[run.start..run.end];
        for (samples, out) in samples.chunks(PIECE).zip(out.chunks_mut(PIECE)) {
            self.fill_piece::<K>(wide, run.node, &around, samples, out);
        }
    }

    /// Where a cell's point is along the row, and the share of its offset from the row.
    #[inline(always)]
    fn seen(&self, hash: u32, a: f32, b: f32) -> [f32; 2] {
        let [px, py] = nearest::point(hash, a, b);
        [px, self.measure.axis(py - self.fy)]
    }

    #[inline(always)]
    fn fill_piece<const K: usize>(&self, wide: &Wide, node: usize, around: &[[f32; 2]; 9], samples: &[f32], out: &mut [f32]) {
        let mut fx = [[samples[samples.len() - 1]; WIDTH]; PIECE / WIDTH];
        fx.as_flattened_mut()[..samples.len()].copy_from_slice(samples);
        let mut near = [[[f32::INFINITY; WIDTH]; K]; PIECE / WIDTH];
        let blocks = samples.len().div_ceil(WIDTH);
        let (fx, near) = (&fx[..blocks], &mut near[..blocks]);
        for (fx, near) in fx.iter().zip(&mut *near) {
            let mut least = [[f32::INFINITY; WIDTH]; K];
            for point in around {
                self.add(fx, *point, &mut least);
            }
            *near = least;
        }
        self.look_further(wide, node, fx, near);
        let finish = self.query.finish();
        let mut values = [[0.0; WIDTH]; PIECE / WIDTH];
        for (values, near) in values.iter_mut().zip(&*near) {
            *values = finish.all(self.measure, near);
        }
        out.copy_from_slice(&values.as_flattened()[..out.len()]);
    }

    /// Adds what matters of ring 2 and those beyond.
    #[inline(always)]
    fn look_further<const K: usize>(&self, wide: &Wide, node: usize, fx: &[[f32; WIDTH]], near: &mut [[[f32; WIDTH]; K]]) {
        let last = self.query.feature.order() - 1;
        let [west, east] = [fx[0][0], fx[fx.len() - 1][WIDTH - 1]];
        let mut ring = 2;
        while ring <= MOST_RINGS && self.is_open(ring, last, fx, near) {
            let farthest = farthest(last, near);
            for [a, b] in nearest::ring_cells(ring) {
                let hash = if ring <= HALO {
                    wide.hashes.get((HALO + b) as usize)[(node as i64 + a) as usize]
                } else {
                    hash::corner(hash::column_key(self.cell[0] + a), hash::row_key(self.cell[1] + b, self.query.lattice.seed))
                };
                let [px, share] = self.seen(hash, a as f32, b as f32);
                let away = larger(0.0, larger(px - east, west - px));
                if self.measure.join(self.measure.axis(HAIR * away), share) < farthest {
                    for (fx, near) in fx.iter().zip(&mut *near) {
                        self.add(fx, [px, share], near);
                    }
                }
            }
            ring += 1;
        }
    }

    /// Whether a cell of this ring might hold a point that matters to some sample: first asked without the samples' places in their cells.
    #[inline(always)]
    fn is_open<const K: usize>(&self, ring: i64, last: usize, fx: &[[f32; WIDTH]], near: &[[[f32; WIDTH]; K]]) -> bool {
        let inner = (ring - 1) as f32;
        let least = self.measure.axis(HAIR * inner);
        let margin_y = smaller(self.fy, 1.0 - self.fy);
        let (mut maybe, mut open) = (0, 0);
        for near in near {
            for lane in 0..WIDTH {
                maybe |= u32::from(near[last][lane] > least);
            }
        }
        if maybe != 0 {
            for (fx, near) in fx.iter().zip(near) {
                for lane in 0..WIDTH {
                    let margin = smaller(smaller(fx[lane], 1.0 - fx[lane]), margin_y);
                    open |= u32::from(near[last][lane] > self.measure.axis(HAIR * (inner + margin)));
                }
            }
        }
        open != 0
    }

    /// Adds a point to the nearest of every sample.
    #[inline(always)]
    fn add<const K: usize>(&self, fx: &[f32; WIDTH], [px, share]: [f32; 2], near: &mut [[f32; WIDTH]; K]) {
        let mut rest = [0.0; WIDTH];
        for lane in 0..WIDTH {
            rest[lane] = self.measure.join(self.measure.axis(px - fx[lane]), share);
        }
        for slot in near {
            for lane in 0..WIDTH {
                let before = slot[lane];
                slot[lane] = smaller(before, rest[lane]);
                rest[lane] = larger(before, rest[lane]);
            }
        }
    }
}

/// The greatest of the measures in one slot. Compared as integers, which order as numbers from 0 on do and which a vector register can take the maximum of.
#[inline(always)]
fn farthest<const K: usize>(slot: usize, near: &[[[f32; WIDTH]; K]]) -> f32 {
    let mut greatest = [0; WIDTH];
    for near in near {
        for lane in 0..WIDTH {
            greatest[lane] = greatest[lane].max(near[slot][lane].to_bits());
        }
    }
    f32::from_bits(greatest.into_iter().max().unwrap_or(0))
}
