//! Where samples lie in a noise lattice: cell, fraction and fade, found once a column and once a row.

use super::{Lanes, aligned::Aligned, hash};

/// One octave's lattice: cells of side 1/frequency in programme units, its own corner hashes and its own phase.
///
/// The phase keeps the corners of different octaves apart: gradient noise is zero at its corners, and octaves that share them would all vanish in one regular pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lattice {
    pub frequency: f64,
    phase: [f64; 2],
    pub seed: u32,
}

impl Lattice {
    pub(super) fn new(key: u64, octave: u32, frequency: f64) -> Self {
        let bits = hash::key(key, octave.into());
        let phase = |bits: u64| (bits & 0xffff) as f64 / 65_536.0;
        Self { frequency, phase: [phase(bits >> 32), phase(bits >> 48)], seed: bits as u32 }
    }

    /// Cell and position of programme coordinate `u` along the columns (`axis` 0) or `v` along the rows (`axis` 1).
    #[inline(always)]
    pub(super) fn locate(&self, axis: usize, coordinate: f64) -> Position {
        let at = coordinate * self.frequency + self.phase[axis];
        // Cells beyond 2^62 cannot be told apart in f64 anyway; the clamp keeps their neighbours' numbers from overflowing.
        let cell = at.floor().clamp(-4.611_686_018_427_388e18, 4.611_686_018_427_388e18);
        Position { cell: whole(cell), fraction: (at - cell).clamp(0.0, 1.0) }
    }
}

/// Where samples lie along one axis of a lattice.
#[derive(Clone, Copy)]
pub(super) struct Axis<L: Lanes> {
    /// Keys of the cells' own corners and of the next.
    pub keys: [L::Words; 2],
    pub fraction: L::Floats,
    pub fade: L::Floats,
    /// The fade's slope.
    pub turn: L::Floats,
}

impl Lattice {
    /// Whether coordinates up to a magnitude have cells whose numbers fit 52 bits, as vectors of them need.
    pub(super) fn holds(&self, greatest: f64) -> bool {
        greatest * self.frequency < 1e15
    }

    /// Whether their numbers fit 32 bits.
    pub(super) fn is_near(&self, greatest: f64) -> bool {
        greatest * self.frequency < 2e9
    }

    /// As [`Lattice::locate`], without the clamps that coordinates which the lattice holds do not need: low and high words of the cells, and fractions.
    #[inline(always)]
    pub(super) fn locate_lanes<L: Lanes>(&self, lanes: L, axis: usize, coordinates: L::Doubles) -> ([L::Words; 2], L::Doubles) {
        let at = coordinates * lanes.splat_doubles(self.frequency) + lanes.splat_doubles(self.phase[axis]);
        let cell = lanes.floor(at);
        (lanes.whole_words(cell), at - cell)
    }

    /// Everything about coordinates that the lattice holds; `NEAR` if they are near.
    #[inline(always)]
    pub(super) fn axis<L: Lanes, const NEAR: bool>(&self, lanes: L, fade: Fade, axis: usize, coordinates: L::Doubles) -> Axis<L> {
        let (words, fraction) = self.locate_lanes(lanes, axis, coordinates);
        Axis {
            keys: hash::keys::<L, NEAR>(lanes, axis, self.seed, words),
            fraction: lanes.round(fraction),
            fade: lanes.round(fade.weights(lanes, fraction)),
            turn: lanes.round(fade.turns(lanes, fraction)),
        }
    }

    /// The cell of one coordinate, near or far, and everything about it in every lane.
    #[inline(always)]
    pub(super) fn axis_at<L: Lanes>(&self, lanes: L, fade: Fade, axis: usize, coordinate: f64) -> (i64, Axis<L>) {
        let Position { cell, fraction } = self.locate(axis, coordinate);
        let key = |cell| if axis == 0 { hash::column_key(cell) } else { hash::row_key(cell, self.seed) };
        let keys = [lanes.splat_words(key(cell)), lanes.splat_words(key(cell + 1))];
        let [fade, turn] = [lanes.splat(fade.weight(fraction) as f32), lanes.splat(fade.turn(fraction) as f32)];
        (cell, Axis { keys, fraction: lanes.splat(fraction as f32), fade, turn })
    }
}

/// Where the columns of a window lie in a lattice, and the last one again until groups of vectors are whole.
pub(super) struct Located {
    /// Low words of cells' numbers.
    pub cells: Aligned<u32>,
    /// Keys of the cells' own columns and of the next.
    pub keys: [Aligned<u32>; 2],
    pub fractions: Aligned<f32>,
    pub fades: Aligned<f32>,
}

impl Located {
    /// `group` is the number of vectors that groups have.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, lattice: &Lattice, fade: Fade, coordinates: &[f64], group: usize) -> Self {
        let count = coordinates.len().next_multiple_of(group * L::WIDTH);
        let (words, floats) = (|| Aligned::new(0, count), || Aligned::new(0.0, count));
        let mut located = Self { cells: words(), keys: [words(), words()], fractions: floats(), fades: floats() };
        let greatest = coordinates.iter().fold(0.0_f64, |greatest, c| if c.abs() <= greatest { greatest } else { c.abs() });
        let mut padded = [0.0; 16];
        for start in (0..count).step_by(L::WIDTH) {
            for (i, padded) in padded[..L::WIDTH].iter_mut().enumerate() {
                *padded = coordinates[(start + i).min(coordinates.len() - 1)];
            }
            if lattice.holds(greatest) {
                located.write(lanes, lattice, fade, start, &padded);
            } else {
                located.write_far(lattice, fade, start, &padded[..L::WIDTH]);
            }
        }
        located
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, lanes: L, lattice: &Lattice, fade: Fade, start: usize, coordinates: &[f64]) {
        let (words, fraction) = lattice.locate_lanes(lanes, 0, lanes.load_doubles(coordinates));
        let keys = hash::keys::<L, false>(lanes, 0, 0, words);
        lanes.store_words(words[0], &mut self.cells[start..]);
        lanes.store_words(keys[0], &mut self.keys[0][start..]);
        lanes.store_words(keys[1], &mut self.keys[1][start..]);
        lanes.store(lanes.round(fraction), &mut self.fractions[start..]);
        lanes.store(lanes.round(fade.weights(lanes, fraction)), &mut self.fades[start..]);
    }

    fn write_far(&mut self, lattice: &Lattice, fade: Fade, start: usize, coordinates: &[f64]) {
        for (i, &coordinate) in (start..).zip(coordinates) {
            let Position { cell, fraction } = lattice.locate(0, coordinate);
            self.cells[i] = cell as u32;
            (self.keys[0][i], self.keys[1][i]) = (hash::column_key(cell), hash::column_key(cell + 1));
            (self.fractions[i], self.fades[i]) = (fraction as f32, fade.weight(fraction) as f32);
        }
    }
}

/// A whole number of at most 2^62 as an integer, 0 for what is not a number: `cell as i64` by additions, which vector registers of every width have.
#[inline(always)]
fn whole(cell: f64) -> i64 {
    // Numbers added to these stand in the low bits of the sum: up to 2^52 from 0 on, and of either sign up to 2^51.
    const FROM_ZERO: f64 = 4_503_599_627_370_496.0;
    const SIGNED: f64 = 6_755_399_441_055_744.0;
    const WORD: f64 = 4_294_967_296.0;
    let cell = if cell.is_nan() { 0.0 } else { cell };
    let high = (cell / WORD).floor();
    let low = cell - high * WORD;
    let words = [(low + FROM_ZERO).to_bits(), (high + SIGNED).to_bits()];
    ((words[1] << 32) | (words[0] & 0xffff_ffff)) as i64
}

/// A place along one axis of a lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position {
    pub cell: i64,
    /// In [0, 1], exact to f64.
    pub fraction: f64,
}

/// How a fraction of a cell becomes the weight of its far side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fade {
    /// t² (3 - 2 t), Perlin 1985.
    Cubic,
    /// t³ (t (6 t - 15) + 10), Perlin 2002.
    Quintic,
    /// For noise that does not blend.
    None,
}

impl Fade {
    /// In f64, rounded once by the caller.
    #[inline(always)]
    pub(super) fn weight(self, t: f64) -> f64 {
        match self {
            Fade::Cubic => t * t * (3.0 - 2.0 * t),
            Fade::Quintic => t * t * t * (t * (t * 6.0 - 15.0) + 10.0),
            Fade::None => 0.0,
        }
    }

    /// The slope of the weight.
    #[inline(always)]
    pub(super) fn turn(self, t: f64) -> f64 {
        match self {
            Fade::Cubic => 6.0 * t * (1.0 - t),
            Fade::Quintic => 30.0 * (t * (1.0 - t)) * (t * (1.0 - t)),
            Fade::None => 0.0,
        }
    }

    /// [`Fade::weight`] of every lane.
    #[inline(always)]
    pub(super) fn weights<L: Lanes>(self, lanes: L, t: L::Doubles) -> L::Doubles {
        let [two, three, six] = [lanes.splat_doubles(2.0), lanes.splat_doubles(3.0), lanes.splat_doubles(6.0)];
        match self {
            Fade::Cubic => t * t * (three - two * t),
            Fade::Quintic => t * t * t * (t * (t * six - lanes.splat_doubles(15.0)) + lanes.splat_doubles(10.0)),
            Fade::None => lanes.splat_doubles(0.0),
        }
    }

    /// [`Fade::turn`] of every lane.
    #[inline(always)]
    pub(super) fn turns<L: Lanes>(self, lanes: L, t: L::Doubles) -> L::Doubles {
        let rest = lanes.splat_doubles(1.0) - t;
        match self {
            Fade::Cubic => lanes.splat_doubles(6.0) * t * rest,
            Fade::Quintic => lanes.splat_doubles(30.0) * (t * rest) * (t * rest),
            Fade::None => lanes.splat_doubles(0.0),
        }
    }
}

/// Consecutive columns in one cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub start: usize,
    pub end: usize,
    /// Where the cell's own number stands among the nodes.
    pub node: usize,
}

/// The columns of a window in one lattice.
///
/// Only the lattice columns that some sample touches are kept, so cells may be wider or much narrower than a sample.
pub(super) struct Columns {
    /// Keys of the lattice columns touched, from west to east. The cell of a run stands at `node`, the next cell at `node + 1`, and so on for the halo asked for.
    pub keys: Vec<u32>,
    pub runs: Vec<Run>,
    pub fraction: Vec<f32>,
}

impl Columns {
    /// Locates programme coordinates in ascending order; `before` and `after` say how many neighbours of a cell its noise needs.
    pub(super) fn new(lattice: &Lattice, coordinates: &[f64], before: i64, after: i64) -> Self {
        let (mut keys, mut runs) = (Vec::new(), Vec::<Run>::new());
        let mut fractions = Vec::with_capacity(coordinates.len());
        let (mut last_node, mut last_cell) = (i64::MIN, i64::MIN);
        for (i, &coordinate) in coordinates.iter().enumerate() {
            let Position { cell, fraction } = lattice.locate(0, coordinate);
            fractions.push(fraction as f32);
            if cell == last_cell {
                runs.last_mut().expect("a cell was seen").end = i + 1;
                continue;
            }
            last_cell = cell;
            let from = (cell - before).max(last_node.saturating_add(1));
            for node in from..=cell + after {
                keys.push(hash::column_key(node));
            }
            last_node = cell + after;
            runs.push(Run { start: i, end: i + 1, node: keys.len() - 1 - after as usize });
        }
        Self { keys, runs, fraction: fractions }
    }

    /// The runs that touch the columns `start … end`, cut to them.
    #[inline(always)]
    pub(super) fn runs_within(&self, start: usize, end: usize) -> impl Iterator<Item = Run> + '_ {
        let first = self.runs.partition_point(|run| run.end <= start);
        self.runs[first..].iter().take_while(move |run| run.start < end).map(move |run| Run {
            start: run.start.max(start),
            end: run.end.min(end),
            node: run.node,
        })
    }
}

/// What was computed for the last few lattice rows, so that the sample rows in one cell share it.
pub(super) struct RowCache<T> {
    entries: Vec<(Option<i64>, T)>,
}

impl<T> RowCache<T> {
    pub(super) fn new(rows: usize, make: impl Fn() -> T) -> Self {
        Self { entries: (0..rows).map(|_| (None, make())).collect() }
    }

    /// Makes the entries hold rows `first …`, one a slot, in order, computing only what is missing.
    #[inline(always)]
    pub(super) fn want(&mut self, first: i64, mut compute: impl FnMut(i64, &mut T)) {
        let wanted = first..first + self.entries.len() as i64;
        for (slot, row) in wanted.clone().enumerate() {
            if self.entries[slot].0 == Some(row) {
                continue;
            }
            if let Some(other) = (slot + 1..self.entries.len()).find(|&other| self.entries[other].0 == Some(row)) {
                self.entries.swap(slot, other);
                continue;
            }
            // The slot's own row may still be wanted further down: move it there before it is overwritten.
            while let Some(home) = self.entries[slot].0.filter(|row| wanted.contains(row)).map(|row| (row - first) as usize).filter(|&home| home > slot) {
                self.entries.swap(slot, home);
            }
            compute(row, &mut self.entries[slot].1);
            self.entries[slot].0 = Some(row);
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, slot: usize) -> &T {
        &self.entries[slot].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_hold_each_touched_cell_once() {
        let lattice = Lattice { frequency: 1.0, phase: [0.0; 2], seed: 1 };
        let columns = Columns::new(&lattice, &[0.25, 0.5, 1.5, 7.0, 7.9], 1, 1);
        let expected: Vec<u32> = [-1, 0, 1, 2, 6, 7, 8].map(hash::column_key).to_vec();
        assert_eq!(columns.keys, expected);
        let runs: Vec<_> = columns.runs.iter().map(|run| (run.start, run.end, run.node)).collect();
        assert_eq!(runs, [(0, 2, 1), (2, 3, 2), (3, 5, 5)]);
        let cut: Vec<_> = columns.runs_within(1, 4).map(|run| (run.start, run.end)).collect();
        assert_eq!(cut, [(1, 2), (2, 3), (3, 4)]);
    }

    #[test]
    fn rows_are_computed_once_in_either_direction() {
        let mut cache = RowCache::new(3, || 0);
        let mut made = Vec::new();
        for first in [5, 5, 4, 3, 4, 6, 20] {
            cache.want(first, |row, entry| {
                made.push(row);
                *entry = row;
            });
            assert_eq!([0, 1, 2].map(|slot| *cache.get(slot)), [first, first + 1, first + 2]);
        }
        assert_eq!(made, [5, 6, 7, 4, 3, 6, 7, 8, 20, 21, 22]);
    }

    #[test]
    fn whole_numbers_become_integers() {
        let far = 4_611_686_018_427_388e3_f64;
        for cell in [0.0, -0.0, 1.0, -1.0, 4_294_967_295.0, 4_294_967_296.0, -4_294_967_296.0, -4_294_967_297.0, 9e15, -9e15, far, -far, f64::NAN] {
            assert_eq!(whole(cell), cell as i64, "{cell}");
        }
        for i in 0..100_000 {
            let cell = (f64::from(i) * 1.234_567e11 * f64::from(i % 1_000) - 4e18).floor();
            assert_eq!(whole(cell), cell as i64, "{cell}");
        }
    }

    #[test]
    fn far_cells_have_fractions_too() {
        let lattice = Lattice { frequency: 1.0, phase: [0.0; 2], seed: 1 };
        for coordinate in [-0.25, 1e30, -1e30, f64::MAX] {
            let position = lattice.locate(0, coordinate);
            assert!((0.0..=1.0).contains(&position.fraction), "{coordinate}: {position:?}");
        }
    }
}
