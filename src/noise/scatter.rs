//! Gradient noise at a block of positions: octave by octave, in short loops whose steps do not wait for each other.
//!
//! First where the positions lie in the octave's lattice, then the gradients around them, then the noise and what the fractal makes of it.

use super::{
    Field, Lanes,
    aligned::AlignedArray,
    cells::{self, Axis, Base, fraction},
    field::Octave,
    fractal::{State, Step, with_step},
    gradient_lanes::{Corners, Noise, Palette},
    hash::{self, NearKeys},
    nodes::{Bounds, Nodes, VECTORS, Window, Windows},
    number::{Dual, Number, Real},
};

/// Slopes a cell, times `frequency` cells a unit.
#[inline(always)]
pub(super) fn per_unit<L: Lanes>(lanes: L, dual: Dual<L>, frequency: f64) -> Dual<L> {
    let frequency = lanes.splat(frequency as f32);
    Dual { value: dual.value, slopes: [dual.slopes[0] * frequency, dual.slopes[1] * frequency] }
}

/// Positions that are taken through an octave together.
pub(super) const BLOCK: usize = 256;

/// What is wanted of noise: values, or values with their slopes.
pub(super) trait Wanted<L: Lanes>: Number<L> {
    fn load(lanes: L, from: &Block, at: usize) -> Self;
    fn store(self, lanes: L, to: &mut Block, at: usize);
    /// That of the noise in cells of side 1/frequency.
    fn noise<N: Noise>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>, frequency: f64) -> Self;
}

impl<L: Lanes> Wanted<L> for Real<L> {
    #[inline(always)]
    fn load(lanes: L, [value, ..]: &Block, at: usize) -> Self {
        Real(lanes.load(&value.0[at..]))
    }

    #[inline(always)]
    fn store(self, lanes: L, [value, ..]: &mut Block, at: usize) {
        lanes.store(self.0, &mut value.0[at..]);
    }

    #[inline(always)]
    fn noise<N: Noise>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>, _: f64) -> Self {
        Real(N::value(lanes, corners, x, y))
    }
}

impl<L: Lanes> Wanted<L> for Dual<L> {
    #[inline(always)]
    fn load(lanes: L, [value, du, dv]: &Block, at: usize) -> Self {
        Dual { value: lanes.load(&value.0[at..]), slopes: [lanes.load(&du.0[at..]), lanes.load(&dv.0[at..])] }
    }

    #[inline(always)]
    fn store(self, lanes: L, [value, du, dv]: &mut Block, at: usize) {
        lanes.store(self.value, &mut value.0[at..]);
        lanes.store(self.slopes[0], &mut du.0[at..]);
        lanes.store(self.slopes[1], &mut dv.0[at..]);
    }

    #[inline(always)]
    fn noise<N: Noise>(lanes: L, corners: &Corners<L>, x: &Axis<L>, y: &Axis<L>, frequency: f64) -> Self {
        per_unit(lanes, N::dual(lanes, corners, x, y), frequency)
    }
}

/// Whole vectors of positions.
#[derive(Clone, Copy)]
pub(super) struct Positions<'a> {
    pub us: &'a [f64],
    pub vs: &'a [f64],
}

/// Memory that blocks are computed in.
pub(super) struct Scratch {
    bounds: Bounds,
    /// Of each octave, along both axes.
    bases: Vec<[Base; 2]>,
    windows: Windows,
    nodes: Nodes,
    /// Grains of each position below other bits, and cells if those are too many to stand there.
    words: [AlignedArray<BLOCK, u32>; 2],
    cells: [AlignedArray<BLOCK, u32>; 2],
    corners: [[AlignedArray<BLOCK>; 2]; 4],
    /// What was computed.
    pub values: Block,
    openings: Block,
}

/// Values and slopes.
pub(super) type Block = [AlignedArray<BLOCK>; 3];

impl Scratch {
    pub(super) fn new() -> Self {
        let words = || [AlignedArray([0; BLOCK]), AlignedArray([0; BLOCK])];
        let floats = || AlignedArray([0.0; BLOCK]);
        let corner = || [floats(), floats()];
        Self {
            bounds: Bounds { least: [[0.0; VECTORS]; 2], greatest: [[0.0; VECTORS]; 2] },
            bases: Vec::new(),
            windows: Windows::new(),
            nodes: Nodes::new(),
            words: words(),
            cells: words(),
            corners: [corner(), corner(), corner(), corner()],
            values: [floats(), floats(), floats()],
            openings: [floats(), floats(), floats()],
        }
    }

    /// Computes the field at a block of positions; not if they are too far away or too far apart.
    #[inline(always)]
    pub(super) fn compute<L: Lanes, W: Wanted<L>, G: Lanes, N: Noise>(
        &mut self,
        (lanes, granule): (L, G),
        noise: N,
        field: &Field,
        positions: Positions,
    ) -> bool {
        let Some([least, greatest]) = self.bound(granule, positions) else { return false };
        let highest = field.octaves.iter().fold(0.0, |highest: f64, octave| highest.max(octave.lattice.frequency));
        if !(0..2).all(|axis| cells::spans(highest, least[axis], greatest[axis])) {
            return false;
        }
        // All at once: one after the other, each would be waited for.
        self.bases.clear();
        for Octave { lattice, .. } in &field.octaves {
            self.bases.push([lattice.base(0, least[0], greatest[0]), lattice.base(1, least[1], greatest[1])]);
        }
        let count = positions.us.len();
        for at in (0..count).step_by(L::WIDTH) {
            W::constant(lanes, field.start).store(lanes, &mut self.values, at);
            W::constant(lanes, 1.0).store(lanes, &mut self.openings, at);
        }
        for (i, octave) in field.octaves.iter().enumerate() {
            let [x, y] = self.bases[i];
            self.octave((lanes, granule), noise, octave, [&x, &y], positions);
            with_step!(&octave.step, step => self.add::<L, W, N, _>(lanes, *step, octave.lattice.frequency, count));
        }
        if let Some(tail) = &field.tail {
            for at in (0..count).step_by(L::WIDTH) {
                let left_out = W::load(lanes, &self.openings, at).interpolated(lanes, tail);
                W::load(lanes, &self.values, at).plus(left_out).store(lanes, &mut self.values, at);
            }
        }
        true
    }

    /// Finds the bounds of each vector, and so of all: the least u and v, and the greatest; none unless all positions are finite.
    #[inline(always)]
    fn bound<L: Lanes>(&mut self, lanes: L, Positions { us, vs }: Positions) -> Option<[[f64; 2]; 2]> {
        let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut sum = lanes.splat_doubles(0.0);
        for (i, (us, vs)) in us.chunks_exact(L::WIDTH).zip(vs.chunks_exact(L::WIDTH)).enumerate() {
            let (us, vs) = (lanes.load_doubles(us), lanes.load_doubles(vs));
            sum = sum + (us + vs);
            let [low, high] = lanes.ends([us, vs], [us, vs]);
            for axis in 0..2 {
                (self.bounds.least[axis][i], self.bounds.greatest[axis][i]) = (low[axis], high[axis]);
                least[axis] = if low[axis] < least[axis] { low[axis] } else { least[axis] };
                greatest[axis] = if high[axis] > greatest[axis] { high[axis] } else { greatest[axis] };
            }
        }
        // What is not finite leaves its mark on the sum.
        let mark = sum * lanes.splat_doubles(0.0);
        let marks = lanes.ends([mark; 2], [mark; 2]);
        (marks == [[0.0; 2]; 2]).then_some([least, greatest])
    }

    /// Finds where positions lie in an octave's lattice, and the gradients around them.
    #[inline(always)]
    fn octave<L: Lanes, G: Lanes, N: Noise>(&mut self, (lanes, granule): (L, G), _: N, octave: &Octave, [x, y]: [&Base; 2], positions: Positions) {
        let (palette, seed, count) = (N::palette(octave.amplitude), octave.lattice.seed, positions.us.len());
        let corners = Corner { palette: &palette, seed, bases: [x, y] };
        let (Some(near_x), Some(near_y)) = (x.near(), y.near()) else {
            self.locate(lanes, [x, y], positions);
            return self.hash::<L, N, false>(lanes, corners, count);
        };
        for at in (0..count).step_by(L::WIDTH) {
            lanes.store_words(near_x.words(lanes, lanes.load_doubles(&positions.us[at..])), &mut self.words[0].0[at..]);
            lanes.store_words(near_y.words(lanes, lanes.load_doubles(&positions.vs[at..])), &mut self.words[1].0[at..]);
        }
        if self.nodes.draw::<L::Single, N>(lanes.single(), &palette, seed, [x, y], count) {
            self.windows.find(granule, [&near_x, &near_y], &self.nodes, &self.bounds, count / G::WIDTH);
            self.fetch::<G, N>(granule, corners, count);
        } else {
            self.hash::<L, N, true>(lanes, corners, count);
        }
    }

    /// Counts cells in words of their own.
    #[inline(always)]
    fn locate<L: Lanes>(&mut self, lanes: L, bases: [&Base; 2], positions: Positions) {
        for (axis, coordinates) in [positions.us, positions.vs].into_iter().enumerate() {
            for at in (0..coordinates.len()).step_by(L::WIDTH) {
                let (cells, low) = bases[axis].words(lanes, lanes.load_doubles(&coordinates[at..]));
                lanes.store_words(cells, &mut self.cells[axis].0[at..]);
                lanes.store_words(low, &mut self.words[axis].0[at..]);
            }
        }
    }

    /// The cells of a vector of positions, counted from their bases; `NEAR` if they share words with the grains.
    #[inline(always)]
    fn counted<L: Lanes, const NEAR: bool>(&self, lanes: L, at: usize) -> [L::Words; 2] {
        if NEAR {
            [lanes.shr::<24>(lanes.load_words(&self.words[0].0[at..])), lanes.shr::<24>(lanes.load_words(&self.words[1].0[at..]))]
        } else {
            [lanes.load_words(&self.cells[0].0[at..]), lanes.load_words(&self.cells[1].0[at..])]
        }
    }

    /// Fetches gradients from the nodes.
    #[inline(always)]
    fn fetch<L: Lanes, N: Noise>(&mut self, lanes: L, corner: Corner, count: usize) {
        for i in 0..count / L::WIDTH {
            let (at, window) = (i * L::WIDTH, self.windows.get(i));
            let words = [lanes.load_words(&self.words[0].0[at..]), lanes.load_words(&self.words[1].0[at..])];
            let corners = match window.kind {
                Window::ROW => self.nodes.row(lanes, window, words[0]),
                Window::ROWS => self.nodes.rows(lanes, window, words),
                _ => corner.hashed::<L, N>(lanes, self.counted::<L, true>(lanes, at)),
            };
            self.put(lanes, at, &corners);
        }
    }

    /// Hashes each position's corners.
    #[inline(always)]
    fn hash<L: Lanes, N: Noise, const NEAR: bool>(&mut self, lanes: L, corner: Corner, count: usize) {
        let Corner { palette, seed, bases: [x, y] } = corner;
        let (Some(columns), Some(rows)) = (NearKeys::new(0, seed, x.cell, x.reach), NearKeys::new(1, seed, y.cell, y.reach)) else {
            for at in (0..count).step_by(L::WIDTH) {
                self.put(lanes, at, &corner.hashed::<L, N>(lanes, self.counted::<L, NEAR>(lanes, at)));
            }
            return;
        };
        let high = lanes.splat_words(columns.high ^ rows.high);
        for at in (0..count).step_by(L::WIDTH) {
            let [x, y] = self.counted::<L, NEAR>(lanes, at);
            let (columns, rows) = (columns.keys(lanes, x), rows.keys(lanes, y));
            self.put(lanes, at, &N::corners(lanes, palette, columns, [rows[0] ^ high, rows[1] ^ high]));
        }
    }

    #[inline(always)]
    fn put<L: Lanes>(&mut self, lanes: L, at: usize, corners: &Corners<L>) {
        for (to, corner) in self.corners.iter_mut().zip(corners) {
            lanes.store(corner[0], &mut to[0].0[at..]);
            lanes.store(corner[1], &mut to[1].0[at..]);
        }
    }

    /// Adds an octave, which [`Self::octave`] has prepared.
    #[inline(always)]
    fn add<L: Lanes, W: Wanted<L>, N: Noise, S: Step>(&mut self, lanes: L, step: S, frequency: f64, count: usize) {
        for at in (0..count).step_by(L::WIDTH) {
            let mut corners = [[lanes.splat(0.0); 2]; 4];
            for (corner, from) in corners.iter_mut().zip(&self.corners) {
                *corner = [lanes.load(&from[0].0[at..]), lanes.load(&from[1].0[at..])];
            }
            let x = Axis::new(lanes, N::FADE, fraction(lanes, lanes.load_words(&self.words[0].0[at..])));
            let y = Axis::new(lanes, N::FADE, fraction(lanes, lanes.load_words(&self.words[1].0[at..])));
            let noise = W::noise::<N>(lanes, &corners, &x, &y, frequency);
            let opening = if S::OPENS { W::load(lanes, &self.openings, at) } else { W::constant(lanes, 1.0) };
            let State { value, opening } = step.after(lanes, noise, State { value: W::load(lanes, &self.values, at), opening });
            value.store(lanes, &mut self.values, at);
            if S::OPENS {
                opening.store(lanes, &mut self.openings, at);
            }
        }
    }
}

/// What the gradients at an octave's corners depend on.
#[derive(Clone, Copy)]
struct Corner<'a> {
    palette: &'a Palette,
    seed: u32,
    bases: [&'a Base; 2],
}

impl Corner<'_> {
    /// The gradients around cells that are counted from the bases, wherever these lie.
    #[inline(always)]
    fn hashed<L: Lanes, N: Noise>(self, lanes: L, [columns, rows]: [L::Words; 2]) -> Corners<L> {
        let Self { palette, seed, bases: [x, y] } = self;
        N::corners(lanes, palette, hash::keys(lanes, 0, 0, x.cell, columns), hash::keys(lanes, 1, seed, y.cell, rows))
    }
}
