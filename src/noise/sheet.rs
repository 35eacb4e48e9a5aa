//! Gradient noise whose samples share cells, along the rows of a window, several octaves in one go.
//!
//! Corners' gradients are hashed once a lattice row, and the lines of [`super::gradient`] computed once a sample row and lattice column, all in vectors. A vector
//! of samples then fetches its cells' lines by permuting the few lines from its first cell on. Octaves follow each other while the sum is in registers, some
//! vectors side by side, so that one computes while the others wait.

use super::{
    Lanes,
    aligned::Aligned,
    cells::{Axis, Lattice, Located},
    fractal::{State, Step},
    gradient_lanes::{self, Noise, Palette},
    hash,
    number::Real,
};
use core::marker::PhantomData;

/// How many vectors of samples go side by side.
#[inline(always)]
pub(super) fn side_by_side<L: Lanes>() -> usize {
    if L::WIDTH == 8 { 4 } else { 2 }
}

/// Octaves of one noise whose samples share cells, and their present row.
pub(super) struct Sheet<N> {
    noise: PhantomData<N>,
    levels: Vec<Level>,
    lines: Lines,
}

/// An octave.
struct Level {
    lattice: Lattice,
    palette: Palette,
    /// Where its lattice columns begin among all octaves'.
    start: usize,
    /// Of each lattice column, whole vectors of them.
    keys: Aligned<u32>,
    /// The lattice row of the first gradients.
    row: Option<i64>,
    /// Components of the gradients south and north of the present row.
    corners: [[Aligned<f32>; 2]; 2],
}

/// Lines of the present row, and how samples find theirs.
pub(super) struct Lines {
    octaves: usize,
    /// A, B and A - B of every lattice column, one after the other, each `room` long.
    values: Aligned<f32>,
    room: usize,
    /// For each group of vectors side by side, for each octave, for each vector: [`BASE`] times the vector's first lattice column plus each sample's cell counted from
    /// there, fractions, fades.
    records: Aligned<f32>,
}

/// What a vector's first lattice column is multiplied by: a multiple of every vector's lanes, so that permutations do not see it.
const BASE: u32 = 16;

/// Most lattice columns of an octave: their numbers times [`BASE`] fit a word, also those of 32 octaves.
const MOST: usize = 1 << 22;

/// An octave of a sheet to be.
struct Plan {
    level: Level,
    located: Located,
    first: u32,
}

impl<N: Noise> Sheet<N> {
    /// The leading octaves, given by lattice and factor, whose samples share cells.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, octaves: impl Iterator<Item = (Lattice, f32)>, coordinates: &[f64]) -> Self {
        let (mut plans, mut start) = (Vec::new(), 0);
        if N::BLENDS {
            for (lattice, amplitude) in octaves {
                let Some(plan) = plan::<L, N>(lanes, lattice, amplitude, coordinates, start) else { break };
                start += plan.level.keys.len();
                plans.push(plan);
            }
        }
        // A vector's permutations read one column and a whole vector beyond its base, though they use no more than are drawn.
        let room = start + L::WIDTH;
        let lines = Lines { octaves: plans.len(), values: Aligned::new(0.0, 3 * room), room, records: records(lanes, &plans) };
        Self { noise: PhantomData, levels: plans.into_iter().map(|plan| plan.level).collect(), lines }
    }

    /// Goes to the row of programme coordinate `v`.
    #[inline(always)]
    pub(super) fn begin<L: Lanes>(&mut self, lanes: L, v: f64) {
        let Lines { values, room, .. } = &mut self.lines;
        let (a, rest) = values.split_at_mut(*room);
        let (b, c) = rest.split_at_mut(*room);
        for level in &mut self.levels {
            let (row, keys, y) = level.lattice.axis_at(lanes, N::FADE, 1, v);
            level.go::<L, N>(lanes, row, keys);
            let columns = level.start..level.start + level.keys.len();
            level.draw(lanes, &y, [&mut a[columns.clone()], &mut b[columns.clone()], &mut c[columns]]);
        }
    }

    /// The lines.
    #[inline(always)]
    pub(super) fn lines(&self) -> &Lines {
        &self.lines
    }
}

/// None if some vector of samples touches more cells than it has lanes.
#[inline(always)]
fn plan<L: Lanes, N: Noise>(lanes: L, lattice: Lattice, amplitude: f32, coordinates: &[f64], start: usize) -> Option<Plan> {
    let ends = [lattice.locate(0, *coordinates.first()?).cell, lattice.locate(0, *coordinates.last()?).cell];
    let count = ends[1].checked_sub(ends[0]).and_then(|count| usize::try_from(count).ok()).filter(|&count| count <= coordinates.len().min(MOST))? + 2;
    let located = Located::new(lanes, &lattice, N::FADE, coordinates, side_by_side::<L>());
    let first = ends[0] as u32;
    for cells in located.cells.chunks_exact(L::WIDTH) {
        let base = cells[0].wrapping_sub(first);
        let greatest = cells.iter().fold(0, |greatest: u32, cell| greatest.max(cell.wrapping_sub(cells[0])));
        if greatest as usize >= L::WIDTH || base as usize + greatest as usize > count - 2 {
            return None;
        }
    }
    let drawn = count.next_multiple_of(L::WIDTH);
    let mut keys = Aligned::new(0, drawn);
    for (key, cell) in keys.iter_mut().zip(0..) {
        *key = hash::column_key(ends[0].wrapping_add(cell));
    }
    let floats = || Aligned::new(0.0, drawn);
    let corners = [[floats(), floats()], [floats(), floats()]];
    Some(Plan { level: Level { lattice, palette: N::palette(amplitude), start, keys, row: None, corners }, located, first })
}

/// The records of all octaves.
#[inline(always)]
fn records<L: Lanes>(lanes: L, plans: &[Plan]) -> Aligned<f32> {
    let side = side_by_side::<L>();
    let samples = plans.first().map_or(0, |plan| plan.located.cells.len());
    let mut records = Aligned::new(0.0, 3 * samples * plans.len());
    for (k, Plan { level, located, first }) in plans.iter().enumerate() {
        for (at, cells) in located.cells.chunks_exact(L::WIDTH).enumerate() {
            let slot = (at / side * plans.len() + k) * side + at % side;
            let record = &mut records[slot * 3 * L::WIDTH..][..3 * L::WIDTH];
            let base = cells[0].wrapping_sub(*first) + level.start as u32;
            let index = lanes.load_words(cells) - lanes.splat_words(cells[0].wrapping_sub(base * BASE));
            lanes.store(lanes.to_floats(index), record);
            record[L::WIDTH..][..L::WIDTH].copy_from_slice(&located.fractions[at * L::WIDTH..][..L::WIDTH]);
            record[2 * L::WIDTH..].copy_from_slice(&located.fades[at * L::WIDTH..][..L::WIDTH]);
        }
    }
    records
}

impl Level {
    /// Makes the corners those of a lattice row and the next, hashing what is missing.
    #[inline(always)]
    fn go<L: Lanes, N: Noise>(&mut self, lanes: L, row: i64, rows: [L::Words; 2]) {
        let missing = match self.row.map(|present| row.wrapping_sub(present)) {
            Some(0) => return,
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
                let gradients = N::gradients(lanes, &self.palette, lanes.load_words(keys), rows[side]);
                lanes.store(gradients[0], gx);
                lanes.store(gradients[1], gy);
            }
        }
    }

    /// Computes the lines of every lattice column.
    #[inline(always)]
    fn draw<L: Lanes>(&self, lanes: L, y: &Axis<L>, [a, b, c]: [&mut [f32]; 3]) {
        let [[south_x, south_y], [north_x, north_y]] = &self.corners;
        let south = south_x.chunks_exact(L::WIDTH).zip(south_y.chunks_exact(L::WIDTH));
        let north = north_x.chunks_exact(L::WIDTH).zip(north_y.chunks_exact(L::WIDTH));
        let lines = a.chunks_exact_mut(L::WIDTH).zip(b.chunks_exact_mut(L::WIDTH)).zip(c.chunks_exact_mut(L::WIDTH));
        for ((south, north), ((to_a, to_b), to_c)) in south.zip(north).zip(lines) {
            let (south, north) = ([lanes.load(south.0), lanes.load(south.1)], [lanes.load(north.0), lanes.load(north.1)]);
            let [a, b] = gradient_lanes::line(lanes, y, south, north);
            lanes.store(a, to_a);
            lanes.store(b, to_b);
            lanes.store(a - b, to_c);
        }
    }
}

impl Lines {
    /// How many octaves there are.
    pub(super) fn octaves(&self) -> usize {
        self.octaves
    }

    /// Takes samples, whole groups of vectors from the row's group `first` on, through all octaves, a step each.
    #[inline(always)]
    pub(super) fn add<L: Lanes, S: Step>(&self, lanes: L, steps: &[S], first: usize, values: &mut [f32], openings: &mut [f32]) {
        if side_by_side::<L>() == 4 {
            self.add_groups::<L, S, 4>(lanes, steps, first, values, openings);
        } else {
            self.add_groups::<L, S, 2>(lanes, steps, first, values, openings);
        }
    }

    #[inline(always)]
    fn add_groups<L: Lanes, S: Step, const SIDE: usize>(&self, lanes: L, steps: &[S], first: usize, values: &mut [f32], openings: &mut [f32]) {
        let (a, rest) = self.values.split_at(self.room);
        let (b, c) = rest.split_at(self.room);
        let (lines, steps) = ([a, b, &c[..self.room]], &steps[..self.octaves]);
        let (group, record) = (SIDE * L::WIDTH, 3 * SIDE * L::WIDTH);
        let records = self.records[first * record * self.octaves..].chunks_exact(record * self.octaves);
        let states = values.chunks_exact_mut(group).zip(openings.chunks_exact_mut(group));
        for (records, (values, openings)) in records.zip(states) {
            let mut states = [State::<Real<L>>::load::<S>(lanes, values, openings); SIDE];
            for i in 1..SIDE {
                states[i] = State::load::<S>(lanes, &values[i * L::WIDTH..], &openings[i * L::WIDTH..]);
            }
            // The next octave's noise is begun before this one's is used, so that nothing waits for long.
            let mut records = records.chunks_exact(record);
            let mut noises = records.next().map_or([lanes.splat(0.0); SIDE], |record| side::<L, SIDE>(lanes, lines, record));
            let (last, steps) = steps.split_last().expect("an octave at least");
            for (record, step) in records.zip(steps) {
                let next = side::<L, SIDE>(lanes, lines, record);
                for i in 0..SIDE {
                    states[i] = step.after(lanes, Real(noises[i]), states[i]);
                }
                noises = next;
            }
            for i in 0..SIDE {
                states[i] = last.after(lanes, Real(noises[i]), states[i]);
            }
            for i in 0..SIDE {
                states[i].store::<S>(lanes, &mut values[i * L::WIDTH..], &mut openings[i * L::WIDTH..]);
            }
        }
    }
}

/// The noise of vectors side by side.
#[inline(always)]
fn side<L: Lanes, const SIDE: usize>(lanes: L, lines: [&[f32]; 3], record: &[f32]) -> [L::Floats; SIDE] {
    let mut noises = [lanes.splat(0.0); SIDE];
    for (i, noise) in noises.iter_mut().enumerate() {
        *noise = self::noise(lanes, lines, &record[3 * i * L::WIDTH..]);
    }
    noises
}

/// The noise of a vector of samples.
#[inline(always)]
fn noise<L: Lanes>(lanes: L, [a, b, c]: [&[f32]; 3], record: &[f32]) -> L::Floats {
    let base = (record[0].to_bits() / BASE) as usize;
    let [a, b, c] = [&a[base..][..=L::WIDTH], &b[base..][..=L::WIDTH], &c[base..][..=L::WIDTH]];
    let index = lanes.to_words(lanes.load(record));
    let lines = [lanes.permute(a, index), lanes.permute(b, index), lanes.permute(&c[1..], index), lanes.permute(&b[1..], index)];
    gradient_lanes::mixed(lines, lanes.load(&record[L::WIDTH..]), lanes.load(&record[2 * L::WIDTH..]))
}
