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
    ///
    /// Positions are rounded, once, to whole [`GRAIN`]s of a cell, which f32 holds wherever in a cell they lie.
    #[inline(always)]
    pub(super) fn locate(&self, axis: usize, coordinate: f64) -> Position {
        let at = coordinate * self.frequency;
        // Cells beyond 2^62 cannot be told apart in f64 anyway; the clamp keeps their neighbours' numbers from overflowing.
        let cell = at.floor().clamp(-4.611_686_018_427_388e18, 4.611_686_018_427_388e18);
        // One sum, as in a `Base`: the difference to a small negative cell would be rounded itself, and may come to lie between two grains by that.
        let grains =
            if cell.abs() < FAR { at + (self.phase[axis] + GRAINS - cell) } else { (at - cell).clamp(0.0, 1.0) + (self.phase[axis] + GRAINS) } - GRAINS;
        let carried = grains.floor();
        Position { cell: whole(cell + carried), fraction: grains - carried }
    }
}

/// Parts of a cell that positions are whole numbers of: those that f32 tells apart in a cell's upper half.
const GRAIN: f64 = 1.0 / 16_777_216.0;

/// At 3 · 2^27 the spacing of f64 is a [`GRAIN`]: what is added to it stands in the low word, cells above 24 bits of grains.
const GRAINS: f64 = 402_653_184.0;

/// Up to here the difference of a phase and a cell is exact, as phases are multiples of 2^-16; from here on that of a position and its cell is.
const FAR: f64 = 68_719_476_736.0;

/// The high word of [`GRAINS`]; its low word is zero.
const GRAINS_HIGH: u32 = 0x41b8_0000;

/// Whether vectors of coordinates from `least` to `greatest` have bases in a lattice: not if they are too far away, if there are too many cells between them or
/// if they are the wrong way round.
#[inline(always)]
pub(super) fn spans(frequency: f64, least: f64, greatest: f64) -> bool {
    const FARTHEST: f64 = 1e15;
    const MOST: f64 = 6.7e7;
    (least * frequency).abs() < FARTHEST && (greatest * frequency).abs() < FARTHEST && (0.0..MOST).contains(&((greatest - least) * frequency))
}

/// Cells that a vector's cells are counted from, along one axis of a lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    pub cell: i64,
    /// How many cells the greatest coordinate lies beyond.
    pub reach: u32,
    frequency: f64,
    /// What is subtracted and then added to put positions among the grains; of the two operations only the second rounds.
    shifts: [f64; 2],
}

impl Lattice {
    /// The base for coordinates from `least` to `greatest`, which the lattice spans.
    #[inline(always)]
    pub(super) fn base(&self, axis: usize, least: f64, greatest: f64) -> Base {
        let cell = self.locate(axis, least).cell;
        let (from, to) = (cell as f64, self.phase[axis] + GRAINS);
        let shifts = if from.abs() < FAR { [0.0, to - from] } else { [from, to] };
        let last = (greatest * self.frequency - shifts[0] + shifts[1]).to_bits() - GRAINS.to_bits();
        Base { cell, reach: (last >> 24) as u32, frequency: self.frequency, shifts }
    }
}

impl Base {
    /// Whether one word holds cells and grains, exact by one sum.
    #[inline(always)]
    pub(super) fn near(&self) -> Option<Near> {
        (self.shifts[0] == 0.0 && self.reach < 255).then_some(Near { frequency: self.frequency, shift: self.shifts[1] })
    }

    /// Cells counted from the base's, and words of which the low 24 bits are grains, of coordinates between those that the base is for. The sum rounds as that of
    /// [`Lattice::locate`] does: they differ by whole cells.
    #[inline(always)]
    pub(super) fn words<L: Lanes>(&self, lanes: L, coordinates: L::Doubles) -> (L::Words, L::Words) {
        let at = coordinates * lanes.splat_doubles(self.frequency) - lanes.splat_doubles(self.shifts[0]) + lanes.splat_doubles(self.shifts[1]);
        let (low, high) = (lanes.low_words(at), lanes.high_words(at));
        (lanes.shl::<8>(high - lanes.splat_words(GRAINS_HIGH)) | lanes.shr::<24>(low), low)
    }
}

/// A [`Base`] whose cells and grains share a word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    frequency: f64,
    shift: f64,
}

impl Near {
    /// Cells counted from the base's above 24 bits of grains.
    #[inline(always)]
    pub(super) fn words<L: Lanes>(&self, lanes: L, coordinates: L::Doubles) -> L::Words {
        lanes.low_words(coordinates * lanes.splat_doubles(self.frequency) + lanes.splat_doubles(self.shift))
    }

    /// The same of one coordinate.
    #[inline(always)]
    pub(super) fn word(&self, coordinate: f64) -> u32 {
        (coordinate * self.frequency + self.shift).to_bits() as u32
    }
}

/// The fractions of a cell in the low 24 bits.
#[inline(always)]
pub(super) fn fraction<L: Lanes>(lanes: L, words: L::Words) -> L::Floats {
    lanes.convert(words & lanes.splat_words(0x00ff_ffff)) * lanes.splat(GRAIN as f32)
}

/// Where samples lie in their cells along one axis.
#[derive(Clone, Copy)]
pub(super) struct Axis<L: Lanes> {
    pub fraction: L::Floats,
    pub fade: L::Floats,
    /// The fade's slope.
    pub turn: L::Floats,
}

impl<L: Lanes> Axis<L> {
    #[inline(always)]
    pub(super) fn new(lanes: L, fade: Fade, fraction: L::Floats) -> Self {
        Self { fraction, fade: fade.weights(lanes, fraction), turn: fade.turns(lanes, fraction) }
    }
}

impl Lattice {
    /// The cell of one coordinate, near or far, the keys of its corners and the next, and where it lies in it, in every lane.
    #[inline(always)]
    pub(super) fn axis_at<L: Lanes>(&self, lanes: L, fade: Fade, axis: usize, coordinate: f64) -> (i64, [L::Words; 2], Axis<L>) {
        let Position { cell, fraction } = self.locate(axis, coordinate);
        let key = |cell| if axis == 0 { hash::column_key(cell) } else { hash::row_key(cell, self.seed) };
        let keys = [lanes.splat_words(key(cell)), lanes.splat_words(key(cell + 1))];
        (cell, keys, Axis::new(lanes, fade, lanes.splat(fraction as f32)))
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
        let ends = coordinates.first().zip(coordinates.last()).filter(|&(&first, &last)| spans(lattice.frequency, first, last));
        let base = ends.map(|(&first, &last)| lattice.base(0, first, last));
        let mut padded = [0.0; 16];
        for start in (0..count).step_by(L::WIDTH) {
            for (i, padded) in padded[..L::WIDTH].iter_mut().enumerate() {
                *padded = coordinates[(start + i).min(coordinates.len() - 1)];
            }
            match &base {
                Some(base) => located.write(lanes, base, fade, start, &padded),
                None => located.write_far(lattice, fade, start, &padded[..L::WIDTH]),
            }
        }
        located
    }

    #[inline(always)]
    fn write<L: Lanes>(&mut self, lanes: L, base: &Base, fade: Fade, start: usize, coordinates: &[f64]) {
        let (cells, low) = base.words(lanes, lanes.load_doubles(coordinates));
        let fraction = fraction(lanes, low);
        let keys = hash::keys(lanes, 0, 0, base.cell, cells);
        lanes.store_words(cells + lanes.splat_words(base.cell as u32), &mut self.cells[start..]);
        lanes.store_words(keys[0], &mut self.keys[0][start..]);
        lanes.store_words(keys[1], &mut self.keys[1][start..]);
        lanes.store(fraction, &mut self.fractions[start..]);
        lanes.store(fade.weights(lanes, fraction), &mut self.fades[start..]);
    }

    fn write_far(&mut self, lattice: &Lattice, fade: Fade, start: usize, coordinates: &[f64]) {
        for (i, &coordinate) in (start..).zip(coordinates) {
            let Position { cell, fraction } = lattice.locate(0, coordinate);
            self.cells[i] = cell as u32;
            (self.keys[0][i], self.keys[1][i]) = (hash::column_key(cell), hash::column_key(cell + 1));
            (self.fractions[i], self.fades[i]) = (fraction as f32, fade.weight(fraction as f32));
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
    /// A whole number of grains in [0, 1), which f32 holds.
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
    #[inline(always)]
    pub(super) fn weight(self, t: f32) -> f32 {
        match self {
            Fade::Cubic => t * t * (3.0 - 2.0 * t),
            // Around the middle, where 0.5 is the weight: the usual form loses five bits near 1.
            Fade::Quintic => {
                let s = t - 0.5;
                let z = s * s;
                0.5 + s * (1.875 - z * (5.0 - 6.0 * z))
            }
            Fade::None => 0.0,
        }
    }

    /// [`Fade::weight`] of every lane.
    #[inline(always)]
    pub(super) fn weights<L: Lanes>(self, lanes: L, t: L::Floats) -> L::Floats {
        match self {
            Fade::Cubic => t * t * (lanes.splat(3.0) - lanes.splat(2.0) * t),
            Fade::Quintic => {
                let s = t - lanes.splat(0.5);
                let z = s * s;
                lanes.splat(0.5) + s * (lanes.splat(1.875) - z * (lanes.splat(5.0) - lanes.splat(6.0) * z))
            }
            Fade::None => lanes.splat(0.0),
        }
    }

    /// The slope of the weight.
    #[inline(always)]
    pub(super) fn turns<L: Lanes>(self, lanes: L, t: L::Floats) -> L::Floats {
        let rest = lanes.splat(1.0) - t;
        match self {
            Fade::Cubic => lanes.splat(6.0) * t * rest,
            Fade::Quintic => lanes.splat(30.0) * (t * rest) * (t * rest),
            Fade::None => lanes.splat(0.0),
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

    /// Just above the middle of two grains, where the difference to the cell would be rounded into the middle and then to an even grain.
    #[test]
    fn positions_are_rounded_once() {
        let lattice = Lattice { frequency: 1.0, phase: [0.0; 2], seed: 1 };
        for k in 1..1000 {
            let coordinate = -(f64::from(k) + 0.5) * GRAIN + 1.0 / (1_u64 << 54) as f64;
            let Position { cell, fraction } = lattice.locate(0, coordinate);
            assert_eq!((cell, fraction), (-1, 1.0 - f64::from(k) * GRAIN), "{coordinate}");
            assert_eq!(lattice.base(0, coordinate, coordinate).near().map(|near| near.word(coordinate) & 0x00ff_ffff), Some((1 << 24) - k as u32));
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
