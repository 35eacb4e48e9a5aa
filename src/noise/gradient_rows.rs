//! Gradient noise along the rows of a window.
//!
//! Corners' gradients are hashed once a lattice row, and the lines of [`super::gradient`] computed once a sample row and lattice column, all in vectors. A vector
//! of samples then fetches its cells' lines by permuting the few lines around it, or, where a cell is wide, uses one cell's for many vectors. Where cells are
//! narrower than a sample nothing is shared, and each sample hashes its own corners.

use super::{
    Lanes,
    aligned::Aligned,
    cells::{Axis, Lattice, Position},
    fractal::Step,
    gradient::{self, Noise},
    hash,
    rows::{Samples, add},
};
use core::marker::PhantomData;

/// One octave's columns in a window, and its present row.
pub(super) struct GradientRows<N> {
    noise: PhantomData<N>,
    lattice: Lattice,
    /// Factor of the noise, [`Noise::scale`] included.
    scale: f32,
    /// Of every column, and of some more to make whole vectors.
    fraction: Aligned<f32>,
    fade: Aligned<f32>,
    layout: Layout,
    v: f64,
}

/// How samples come by their corners.
enum Layout {
    /// Cells of about a sample and wider.
    Cells(Cells),
    /// Each sample has its own: keys of its cell's column and of the next.
    Samples([Aligned<u32>; 2]),
}

/// Where the columns lie, in low words of cell numbers.
struct Located {
    fraction: Aligned<f32>,
    fade: Aligned<f32>,
    keys: [Aligned<u32>; 2],
    cells: Aligned<u32>,
}

impl<N: Noise> GradientRows<N> {
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, lattice: Lattice, amplitude: f32, coordinates: &[f64]) -> Self {
        let located = locate::<L, N>(lanes, &lattice, coordinates);
        let cells = if N::BLENDS { Cells::new::<L>(&lattice, coordinates, &located.cells) } else { None };
        let Located { fraction, fade, keys, .. } = located;
        let layout = cells.map_or(Layout::Samples(keys), Layout::Cells);
        Self { noise: PhantomData, lattice, scale: N::scale() * amplitude, fraction, fade, layout, v: 0.0 }
    }

    /// Goes to the row of programme coordinate `v`.
    #[inline(always)]
    pub(super) fn begin<L: Lanes>(&mut self, lanes: L, v: f64) {
        self.v = v;
        if let Layout::Cells(cells) = &mut self.layout {
            let row = self.lattice.axis_at(lanes, N::FADE, 1, v);
            cells.go::<L, N>(lanes, self.lattice.locate(1, v).cell, &row);
            cells.draw(lanes, lanes.splat(self.scale), &row);
        }
    }

    /// Adds the octave to samples.
    #[inline(always)]
    pub(super) fn add<L: Lanes, S: Step>(&self, lanes: L, step: S, samples: &mut Samples<'_>) {
        match &self.layout {
            Layout::Cells(cells) => self.add_cells(lanes, cells, step, samples),
            Layout::Samples(keys) => self.add_samples(lanes, keys, step, samples),
        }
    }

    #[inline(always)]
    fn add_samples<L: Lanes, S: Step>(&self, lanes: L, keys: &[Aligned<u32>; 2], step: S, samples: &mut Samples<'_>) {
        let (from, count) = (samples.first * L::WIDTH, samples.values.len());
        let (fraction, fade) = (&self.fraction[from..][..count], &self.fade[from..][..count]);
        let [near, far] = [&keys[0][from..][..count], &keys[1][from..][..count]];
        let y = self.lattice.axis_at(lanes, N::FADE, 1, self.v);
        let scale = lanes.splat(self.scale);
        let states = samples.values.chunks_exact_mut(L::WIDTH).zip(samples.openings.chunks_exact_mut(L::WIDTH));
        let columns = fraction.chunks_exact(L::WIDTH).zip(fade.chunks_exact(L::WIDTH));
        let keys = near.chunks_exact(L::WIDTH).zip(far.chunks_exact(L::WIDTH));
        for (((value, opening), (fraction, fade)), (near, far)) in states.zip(columns).zip(keys) {
            let keys = [lanes.load_words(near), lanes.load_words(far)];
            let x = Axis { keys, fraction: lanes.load(fraction), fade: lanes.load(fade), turn: lanes.splat(0.0) };
            add(lanes, step, N::value(lanes, scale, &x, &y), value, opening);
        }
    }

    #[inline(always)]
    fn add_cells<L: Lanes, S: Step>(&self, lanes: L, cells: &Cells, step: S, samples: &mut Samples<'_>) {
        let (first, vectors) = (samples.first, samples.vectors::<L>());
        let spans = &cells.spans[cells.spans.partition_point(|span| span.end <= first)..];
        for span in spans.iter().take_while(|span| span.start < first + vectors) {
            let (start, end) = (span.start.max(first), span.end.min(first + vectors));
            let states = (start - first) * L::WIDTH..(end - first) * L::WIDTH;
            let (values, openings) = (&mut samples.values[states.clone()], &mut samples.openings[states]);
            let columns = start * L::WIDTH..end * L::WIDTH;
            let (fraction, fade) = (&self.fraction[columns.clone()], &self.fade[columns.clone()]);
            let states = values.chunks_exact_mut(L::WIDTH).zip(openings.chunks_exact_mut(L::WIDTH));
            let places = fraction.chunks_exact(L::WIDTH).zip(fade.chunks_exact(L::WIDTH));
            if span.is_within_a_cell {
                let [a, b, c, d] = cells.lines_at(cells.bases[start] as usize);
                let lines = [lanes.splat(a), lanes.splat(b), lanes.splat(c), lanes.splat(d)];
                for ((value, opening), (fraction, fade)) in states.zip(places) {
                    add(lanes, step, gradient::mixed(lines, lanes.load(fraction), lanes.load(fade)), value, opening);
                }
            } else {
                let nodes = cells.index[columns].chunks_exact(L::WIDTH).zip(&cells.bases[start..end]);
                let [a, b, c] = cells.sections();
                for (((value, opening), (fraction, fade)), (index, &base)) in states.zip(places).zip(nodes) {
                    let (index, base) = (lanes.load_words(index), base as usize);
                    let [a, b, c] = [&a[base..][..L::WIDTH + 1], &b[base..][..L::WIDTH + 1], &c[base..][..L::WIDTH + 1]];
                    let lines = [lanes.permute(a, index), lanes.permute(b, index), lanes.permute(&c[1..], index), lanes.permute(&b[1..], index)];
                    add(lanes, step, gradient::mixed(lines, lanes.load(fraction), lanes.load(fade)), value, opening);
                }
            }
        }
    }
}

/// Locates columns, and the last one again until vectors are whole.
#[inline(always)]
fn locate<L: Lanes, N: Noise>(lanes: L, lattice: &Lattice, coordinates: &[f64]) -> Located {
    let count = coordinates.len().next_multiple_of(L::WIDTH);
    let floats = || Aligned::new(0.0_f32, count);
    let words = || Aligned::new(0_u32, count);
    let mut located = Located { fraction: floats(), fade: floats(), keys: [words(), words()], cells: words() };
    let greatest = coordinates.iter().fold(0.0_f64, |greatest, c| if c.abs() <= greatest { greatest } else { c.abs() });
    let mut padded = [0.0; 64];
    for from in (0..coordinates.len()).step_by(L::WIDTH) {
        let there = &coordinates[from..coordinates.len().min(from + L::WIDTH)];
        padded[..L::WIDTH].fill(there[there.len() - 1]);
        padded[..there.len()].copy_from_slice(there);
        let to = from..from + L::WIDTH;
        if lattice.holds(greatest) {
            let (cell, fraction) = lattice.locate_lanes(lanes, 0, lanes.load_doubles(&padded));
            let keys = hash::keys::<L, false>(lanes, 0, 0, cell);
            lanes.store(lanes.round(fraction), &mut located.fraction[to.clone()]);
            lanes.store(lanes.round(N::FADE.weights(lanes, fraction)), &mut located.fade[to.clone()]);
            lanes.store_words(cell[0], &mut located.cells[to.clone()]);
            lanes.store_words(keys[0], &mut located.keys[0][to.clone()]);
            lanes.store_words(keys[1], &mut located.keys[1][to]);
        } else {
            for (i, &coordinate) in to.zip(&padded) {
                let Position { cell, fraction } = lattice.locate(0, coordinate);
                (located.fraction[i], located.fade[i]) = (fraction as f32, N::FADE.weight(fraction) as f32);
                (located.cells[i], located.keys[0][i], located.keys[1][i]) = (cell as u32, hash::column_key(cell), hash::column_key(cell + 1));
            }
        }
    }
    located
}

/// Lattice columns of a window whose cells are not much narrower than a sample.
struct Cells {
    /// Of each lattice column, whole vectors of them.
    keys: Aligned<u32>,
    /// The first lattice column that each vector of samples uses.
    bases: Vec<u32>,
    /// Each sample's cell, counted from its vector's base.
    index: Aligned<u32>,
    spans: Vec<Span>,
    /// The lattice row of the first gradients.
    row: Option<i64>,
    /// Components of the gradients south and north of the present row.
    corners: [[Aligned<f32>; 2]; 2],
    /// A, B and A - B of every lattice column.
    lines: [Aligned<f32>; 3],
}

/// Consecutive vectors of samples.
struct Span {
    start: usize,
    end: usize,
    is_within_a_cell: bool,
}

/// Fewest vectors a cell for which those within one cell are told from others.
const WIDE: usize = 16;

impl Cells {
    /// None if some vector of samples touches more cells than it has lanes.
    #[inline(always)]
    fn new<L: Lanes>(lattice: &Lattice, coordinates: &[f64], cells: &[u32]) -> Option<Self> {
        let ends = [lattice.locate(0, *coordinates.first()?).cell, lattice.locate(0, *coordinates.last()?).cell];
        let count = ends[1].checked_sub(ends[0]).and_then(|count| usize::try_from(count).ok()).filter(|&count| count <= coordinates.len())? + 2;
        let (mut bases, mut index, mut spans) = (Vec::with_capacity(cells.len() / L::WIDTH), Aligned::new(0, cells.len()), Vec::<Span>::new());
        let wide = cells.len() >= WIDE * L::WIDTH * count;
        for (at, (cells, index)) in cells.chunks_exact(L::WIDTH).zip(index.chunks_exact_mut(L::WIDTH)).enumerate() {
            let base = cells[0].wrapping_sub(ends[0] as u32);
            let mut greatest = 0;
            for (index, cell) in index.iter_mut().zip(cells) {
                *index = cell.wrapping_sub(cells[0]);
                greatest = greatest.max(*index);
            }
            if greatest as usize >= L::WIDTH || base as usize > count - 2 {
                return None;
            }
            let is_within_a_cell = wide && greatest == 0;
            match spans.last_mut() {
                Some(last) if last.is_within_a_cell == is_within_a_cell && (!wide || bases[at - 1] == base) => last.end = at + 1,
                _ => spans.push(Span { start: at, end: at + 1, is_within_a_cell }),
            }
            bases.push(base);
        }
        // A vector's last permutation reads one column and a whole vector beyond its base.
        let room = (count + 1).next_multiple_of(L::WIDTH) + L::WIDTH;
        let mut keys = Aligned::new(0, room);
        for (key, cell) in keys.iter_mut().zip(0..) {
            *key = hash::column_key(ends[0].wrapping_add(cell));
        }
        let floats = || Aligned::new(0.0, room);
        let corners = [[floats(), floats()], [floats(), floats()]];
        Some(Self { keys, bases, index, spans, row: None, corners, lines: [floats(), floats(), floats()] })
    }

    /// Makes the corners those of a lattice row and the next, hashing what is missing.
    #[inline(always)]
    fn go<L: Lanes, N: Noise>(&mut self, lanes: L, row: i64, y: &Axis<L>) {
        let missing = match self.row.map(|present| row.wrapping_sub(present)) {
            Some(0) => [false, false],
            Some(1) => [false, true],
            Some(-1) => [true, false],
            _ => [true, true],
        };
        if missing[0] != missing[1] {
            self.corners.swap(0, 1);
        }
        self.row = Some(row);
        for (side, _) in missing.into_iter().enumerate().filter(|(_, missing)| *missing) {
            let [gx, gy] = &mut self.corners[side];
            let corners = gx.chunks_exact_mut(L::WIDTH).zip(gy.chunks_exact_mut(L::WIDTH));
            for (keys, (gx, gy)) in self.keys.chunks_exact(L::WIDTH).zip(corners) {
                let gradients = N::gradients(lanes, hash::corners(lanes, lanes.load_words(keys), y.keys[side]));
                lanes.store(gradients[0], gx);
                lanes.store(gradients[1], gy);
            }
        }
    }

    /// Computes the lines of every lattice column.
    #[inline(always)]
    fn draw<L: Lanes>(&mut self, lanes: L, scale: L::Floats, y: &Axis<L>) {
        let [a, b, c] = &mut self.lines;
        let [[south_x, south_y], [north_x, north_y]] = &self.corners;
        let south = south_x.chunks_exact(L::WIDTH).zip(south_y.chunks_exact(L::WIDTH));
        let north = north_x.chunks_exact(L::WIDTH).zip(north_y.chunks_exact(L::WIDTH));
        let lines = a.chunks_exact_mut(L::WIDTH).zip(b.chunks_exact_mut(L::WIDTH)).zip(c.chunks_exact_mut(L::WIDTH));
        for ((south, north), ((to_a, to_b), to_c)) in south.zip(north).zip(lines) {
            let (south, north) = ([lanes.load(south.0), lanes.load(south.1)], [lanes.load(north.0), lanes.load(north.1)]);
            let [a, b] = gradient::line(lanes, scale, y, south, north);
            lanes.store(a, to_a);
            lanes.store(b, to_b);
            lanes.store(a - b, to_c);
        }
    }

    /// A, B and A - B.
    #[inline(always)]
    fn sections(&self) -> [&[f32]; 3] {
        let ([a, b, c], room) = (&self.lines, self.keys.len());
        [&a[..room], &b[..room], &c[..room]]
    }

    /// The lines left and right of a cell.
    #[inline(always)]
    fn lines_at(&self, node: usize) -> [f32; 4] {
        let [a, b, c] = self.sections();
        [a[node], b[node], c[node + 1], b[node + 1]]
    }
}
