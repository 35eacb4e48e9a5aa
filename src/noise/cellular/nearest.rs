//! The measures of the nearest points: at one place (the definition) and at several at a time (the same bits).
//!
//! Rings of cells around the sample's own are added until no nearer point can exist: a point outside the rings 0 … r lies at least r + m away along an axis, m the
//! distance from the sample to the nearest side of its own cell. The fast forms may look at more points than that or leave out such as cannot matter; as the k-th
//! least of the measures depends neither on these nor on the order that they come in, they find the same.

use crate::noise::{
    cells::Lattice,
    hash,
    metric::{Measure, larger, smaller},
};

/// Distances that say what a cell can hold are cut by this, far more than what all roundings and the inexact powers may add up to: no point is overlooked. Points
/// keep 2^-17 from the sides of their cells anyway.
pub(super) const HAIR: f32 = 1.0 - 1.0 / 262_144.0;

/// No metric needs more rings: Minkowski's ½ has its fourth point within 16/3 (see [`super::Feature::range`]). It is what ends the search at coordinates that are
/// not numbers.
pub(super) const MOST_RINGS: i64 = 8;

/// The point of a cell, relative to a place that the cell's south-west corner is (`a`, `b`) away from. Exact for up to 128 cells.
#[inline(always)]
pub(super) fn point(hash: u32, a: f32, b: f32) -> [f32; 2] {
    const UNIT: f32 = 1.0 / 65_536.0;
    [(hash & 0xffff) as f32 * UNIT + (a + 0.5 * UNIT), (hash >> 16) as f32 * UNIT + (b + 0.5 * UNIT)]
}

/// Puts a measure among the least `K` so far, ascending.
#[inline(always)]
pub(super) fn insert<const K: usize>(near: &mut [f32; K], measure: f32) {
    let mut rest = measure;
    for slot in near {
        let before = *slot;
        *slot = smaller(before, rest);
        rest = larger(before, rest);
    }
}

/// Where a sample is: its cell and its place in it.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub cell: [i64; 2],
    pub fraction: [f32; 2],
}

/// The `K` least measures at a place, the first `order` of them certain.
#[inline(always)]
pub(super) fn at<M: Measure, const K: usize>(measure: M, seed: u32, order: usize, place: Place) -> [f32; K] {
    let mut near = [f32::INFINITY; K];
    add_ring(measure, seed, place, 0, &mut near);
    add_ring(measure, seed, place, 1, &mut near);
    finish(measure, seed, order, place, 2, &mut near);
    near
}

/// Adds rings from `ring` on until the `order`-th nearest is certain.
fn finish<M: Measure, const K: usize>(measure: M, seed: u32, order: usize, place: Place, mut ring: i64, near: &mut [f32; K]) {
    let [fx, fy] = place.fraction;
    let margin = smaller(smaller(fx, 1.0 - fx), smaller(fy, 1.0 - fy));
    while ring <= MOST_RINGS && near[order - 1] > measure.axis(HAIR * ((ring - 1) as f32 + margin)) {
        add_ring(measure, seed, place, ring, near);
        ring += 1;
    }
}

/// Adds the points of the cells `ring` steps away.
fn add_ring<M: Measure, const K: usize>(measure: M, seed: u32, place: Place, ring: i64, near: &mut [f32; K]) {
    let ([i, j], [fx, fy]) = (place.cell, place.fraction);
    for [a, b] in ring_cells(ring) {
        let [px, py] = point(hash::corner(hash::column_key(i + a), hash::row_key(j + b, seed)), a as f32, b as f32);
        insert(near, measure.join(measure.axis(px - fx), measure.axis(py - fy)));
    }
}

/// The cells `ring` steps away.
#[inline(always)]
pub(super) fn ring_cells(ring: i64) -> impl Iterator<Item = [i64; 2]> {
    let across = move |b: i64| if b.abs() == ring { 1 } else { (2 * ring).max(1) as usize };
    (-ring..=ring).flat_map(move |b| (-ring..=ring).step_by(across(b)).map(move |a| [a, b]))
}

/// Samples at places anywhere that are looked at together: loops over so many are not unrolled but become vector code.
pub(super) const LANES: usize = 32;

/// What each of the samples has of something.
pub(super) type Lanes<T> = [T; LANES];

/// Cells and fractions of up to `LANES` coordinates along one axis.
#[inline(always)]
pub(super) fn locate(lattice: &Lattice, axis: usize, coordinates: &[f64]) -> (Lanes<i64>, Lanes<f32>) {
    let (mut all, mut cells, mut fractions) = ([0.0; LANES], [0; LANES], [0.0; LANES]);
    all[..coordinates.len()].copy_from_slice(coordinates);
    for lane in 0..LANES {
        let position = lattice.locate(axis, all[lane]);
        (cells[lane], fractions[lane]) = (position.cell, position.fraction as f32);
    }
    (cells, fractions)
}

/// The places of some samples.
#[derive(Clone, Copy)]
pub(super) struct Places {
    pub columns: Lanes<i64>,
    pub rows: Lanes<i64>,
    pub fx: Lanes<f32>,
    pub fy: Lanes<f32>,
}

impl Places {
    pub(super) const NONE: Self = Self { columns: [0; LANES], rows: [0; LANES], fx: [0.0; LANES], fy: [0.0; LANES] };

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, place: Place) {
        [self.columns[lane], self.rows[lane]] = place.cell;
        [self.fx[lane], self.fy[lane]] = place.fraction;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Place {
        Place { cell: [self.columns[lane], self.rows[lane]], fraction: [self.fx[lane], self.fy[lane]] }
    }

    /// Adds the points of the cells up to `ring` steps away, but for those up to `inner` steps.
    #[inline(always)]
    fn add_rings<M: Measure, const K: usize>(&self, measure: M, seed: u32, inner: i64, ring: i64, near: &mut [Lanes<f32>; K]) {
        let mut row_keys = [[0; LANES]; 1 + 2 * MOST_RINGS as usize];
        for (b, keys) in (-ring..=ring).zip(&mut row_keys) {
            for lane in 0..LANES {
                keys[lane] = hash::row_key(self.rows[lane] + b, seed);
            }
        }
        let mut column_keys = [0; LANES];
        for a in -ring..=ring {
            for lane in 0..LANES {
                column_keys[lane] = hash::column_key(self.columns[lane] + a);
            }
            for (b, row_keys) in (-ring..=ring).zip(&row_keys) {
                if a.abs() > inner || b.abs() > inner {
                    self.add(measure, &column_keys, row_keys, [a as f32, b as f32], near);
                }
            }
        }
    }

    /// Adds the point of the cell [a, b] steps from each sample's own.
    #[inline(always)]
    fn add<M: Measure, const K: usize>(&self, measure: M, columns: &Lanes<u32>, rows: &Lanes<u32>, [a, b]: [f32; 2], near: &mut [Lanes<f32>; K]) {
        for lane in 0..LANES {
            let [px, py] = point(hash::corner(columns[lane], rows[lane]), a, b);
            let mut least: [f32; K] = core::array::from_fn(|k| near[k][lane]);
            insert(&mut least, measure.join(measure.axis(px - self.fx[lane]), measure.axis(py - self.fy[lane])));
            for k in 0..K {
                near[k][lane] = least[k];
            }
        }
    }

    /// For which samples a cell of this ring might hold a point that matters: 1 or 0.
    #[inline(always)]
    fn open<M: Measure>(&self, measure: M, ring: i64, last: &Lanes<f32>) -> Lanes<u32> {
        let inner = (ring - 1) as f32;
        let mut open = [0; LANES];
        for lane in 0..LANES {
            let (fx, fy) = (self.fx[lane], self.fy[lane]);
            let margin = smaller(smaller(fx, 1.0 - fx), smaller(fy, 1.0 - fy));
            open[lane] = u32::from(last[lane] > measure.axis(HAIR * (inner + margin)));
        }
        open
    }
}

/// Blocks of `LANES` samples whose undecided ones are put together.
pub(super) const BLOCKS: usize = 4;

/// Fewest undecided samples for which they are put together.
const FEW: usize = 3;

/// The `K` least measures of the first `count` samples at the places, the first `order` of them certain.
#[inline(always)]
pub(super) fn around<M: Measure, const K: usize>(measure: M, seed: u32, order: usize, places: &[Places; BLOCKS], count: usize) -> [[Lanes<f32>; K]; BLOCKS] {
    let mut near = [[[f32::INFINITY; LANES]; K]; BLOCKS];
    let (mut undecided, mut number) = ([0; LANES * BLOCKS], 0);
    for (block, (places, near)) in places.iter().zip(&mut near).take(count.div_ceil(LANES)).enumerate() {
        places.add_rings(measure, seed, -1, 1, near);
        let open = places.open(measure, 2, &near[order - 1]);
        if open.iter().fold(0, |any, open| any | open) != 0 {
            let first = block * LANES;
            for lane in 0..LANES.min(count - first) {
                undecided[number] = first + lane;
                number += open[lane] as usize;
            }
        }
    }
    for samples in undecided[..number].chunks(LANES) {
        look_further(measure, seed, order, places, samples, &mut near);
    }
    near
}

/// Adds what matters to some samples of ring 2 and those beyond.
#[inline(always)]
fn look_further<M: Measure, const K: usize>(
    measure: M,
    seed: u32,
    order: usize,
    places: &[Places; BLOCKS],
    samples: &[usize],
    near: &mut [[Lanes<f32>; K]; BLOCKS],
) {
    let split = |sample: usize| (sample / LANES % BLOCKS, sample % LANES);
    let (mut here, mut least) = (Places::NONE, [[0.0; LANES]; K]);
    for (lane, &sample) in samples.iter().enumerate().take(LANES) {
        let (block, from) = split(sample);
        here.set(lane, places[block].get(from));
        for k in 0..K {
            least[k][lane] = near[block][k][from];
        }
    }
    if samples.len() > FEW {
        for ring in 2..=MOST_RINGS {
            here.add_rings(measure, seed, ring - 1, ring, &mut least);
            let open = here.open(measure, ring + 1, &least[order - 1]);
            if open.iter().fold(0, |any, open| any | open) == 0 {
                break;
            }
        }
    } else {
        for lane in 0..samples.len() {
            let mut few: [f32; K] = core::array::from_fn(|k| least[k][lane]);
            finish(measure, seed, order, here.get(lane), 2, &mut few);
            for k in 0..K {
                least[k][lane] = few[k];
            }
        }
    }
    for (lane, &sample) in samples.iter().enumerate().take(LANES) {
        let (block, to) = split(sample);
        for k in 0..K {
            near[block][k][to] = least[k][lane];
        }
    }
}
