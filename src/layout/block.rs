//! The points of a block of samples, in an order in which every part of it is a square or half of one.

use super::path::Frame;
use crate::geometry::{Rectangle, Window};

/// Samples a side of a block.
pub(super) const SIDE: usize = 32;
/// Points of a block.
pub(super) const POINTS: usize = SIDE * SIDE;
/// Points of its least part: eight columns of four rows.
pub(super) const LEAST: usize = 32;
/// Columns of its least part.
pub(super) const RUN: usize = 8;

/// One number a point.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Values(pub [f64; POINTS]);

impl Values {
    pub(super) fn new(value: f64) -> Box<Self> {
        Box::new(Self([value; POINTS]))
    }
}

/// One f32 a point.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(super) struct Flats(pub [f32; POINTS]);

/// Row and column of a point of a block: quarters of quarters, and row by row within those.
#[inline(always)]
pub(super) fn place(i: usize) -> [usize; 2] {
    let (large, small, rest) = (i >> 8, (i >> 6) & 3, i & 63);
    [(large >> 1) * 16 + (small >> 1) * 8 + (rest >> 3), (large & 1) * 16 + (small & 1) * 8 + (rest & 7)]
}

/// The points of a block.
pub(super) struct Block {
    pub xs: Box<Values>,
    pub ys: Box<Values>,
    /// The same from the middle of the window, rounded.
    pub flat: [Box<Flats>; 2],
    /// First row and column in the window.
    pub first: [usize; 2],
    /// Rows and columns that the window has there; beyond them the last ones are repeated.
    pub size: [usize; 2],
}

impl Block {
    pub(super) fn new() -> Self {
        Self { xs: Values::new(0.0), ys: Values::new(0.0), flat: [(); 2].map(|()| Box::new(Flats([0.0; POINTS]))), first: [0; 2], size: [0; 2] }
    }

    /// Goes to the block that begins at a row and column.
    pub(super) fn go(&mut self, window: &Window, frame: &Frame, first: [usize; 2]) {
        self.first = first;
        self.size = [(window.rows.len() - first[0]).min(SIDE), (window.columns.len() - first[1]).min(SIDE)];
        let at = |i: usize, axis: usize| (first[axis] + i.min(self.size[axis] - 1)) as i64;
        let ys: [f64; SIDE] = core::array::from_fn(|i| window.rows.coordinate(at(i, 0)));
        let xs: [f64; SIDE] = core::array::from_fn(|i| window.columns.coordinate(at(i, 1)));
        let (flat_xs, flat_ys) = (xs.map(|x| frame.relative(0, x)), ys.map(|y| frame.relative(1, y)));
        for i in (0..POINTS).step_by(RUN) {
            let [row, column] = place(i);
            self.xs.0[i..i + RUN].copy_from_slice(&xs[column..column + RUN]);
            self.ys.0[i..i + RUN].fill(ys[row]);
            self.flat[0].0[i..i + RUN].copy_from_slice(&flat_xs[column..column + RUN]);
            self.flat[1].0[i..i + RUN].fill(flat_ys[row]);
        }
    }

    /// The least rectangle that holds the points of a part.
    #[inline(always)]
    pub(super) fn rectangle(&self, start: usize, count: usize) -> Rectangle {
        let (first, last) = (start, start + count - 1);
        let ([x0, y0], [x1, y1]) = ([self.xs.0[first], self.ys.0[first]], [self.xs.0[last], self.ys.0[last]]);
        Rectangle { min: [x0.min(x1), y0.min(y1)], max: [x0.max(x1), y0.max(y1)] }
    }

    /// Where the points of the block stand in the window; points that repeat others are left out.
    pub(super) fn runs(&self, columns: usize) -> impl Iterator<Item = Run> + '_ {
        (0..POINTS).step_by(RUN).filter_map(move |first| {
            let [row, column] = place(first);
            let inside = row < self.size[0] && column < self.size[1];
            inside.then(|| Run { first, place: (self.first[0] + row) * columns + self.first[1] + column, count: RUN.min(self.size[1] - column) })
        })
    }
}

/// Points of a block that stand side by side in a row of the window.
pub(super) struct Run {
    /// The first point.
    pub first: usize,
    /// Its place among the samples of the window, row by row.
    pub place: usize,
    /// How many there are, at most [`RUN`].
    pub count: usize,
}

impl Run {
    /// Writes values, rounded, to their places.
    #[inline(always)]
    pub(super) fn write(&self, values: &Values, out: &mut [f32]) {
        let Self { first, place, count } = *self;
        let out = &mut out[place..place + count];
        out.iter_mut().zip(&values.0[first..first + count]).for_each(|(out, &value)| *out = value as f32);
    }
}
