//! Gradient noise along the rows of a window whose samples share little: each hashes its own corners.

use super::{
    Lanes,
    cells::{Axis, Lattice, Located},
    gradient_lanes::{Noise, Palette},
};
use core::marker::PhantomData;

/// One octave's columns in a window, and its present row.
pub(super) struct GradientRows<N> {
    noise: PhantomData<N>,
    lattice: Lattice,
    palette: Palette,
    columns: Located,
    v: f64,
}

impl<N: Noise> GradientRows<N> {
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, lattice: Lattice, amplitude: f32, coordinates: &[f64]) -> Self {
        let columns = Located::new(lanes, &lattice, N::FADE, coordinates, 1);
        Self { noise: PhantomData, lattice, palette: N::palette(amplitude), columns, v: 0.0 }
    }

    /// Goes to the row of programme coordinate `v`.
    pub(super) fn begin(&mut self, v: f64) {
        self.v = v;
    }

    /// Writes the noise at the columns from `start` on, which are whole vectors or the last ones.
    #[inline(always)]
    pub(super) fn fill<L: Lanes>(&self, lanes: L, start: usize, out: &mut [f32]) {
        let (_, rows, y) = self.lattice.axis_at(lanes, N::FADE, 1, self.v);
        let Located { keys: [near, far], fractions, fades, .. } = &self.columns;
        let keys = near[start..].chunks_exact(L::WIDTH).zip(far[start..].chunks_exact(L::WIDTH));
        let places = fractions[start..].chunks_exact(L::WIDTH).zip(fades[start..].chunks_exact(L::WIDTH));
        for (out, ((near, far), (fraction, fade))) in out.chunks_exact_mut(L::WIDTH).zip(keys.zip(places)) {
            let corners = N::corners(lanes, &self.palette, [lanes.load_words(near), lanes.load_words(far)], rows);
            let x = Axis { fraction: lanes.load(fraction), fade: lanes.load(fade), turn: lanes.splat(0.0) };
            lanes.store(N::value(lanes, &corners, &x, &y), out);
        }
    }
}
