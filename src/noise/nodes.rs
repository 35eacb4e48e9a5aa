//! The gradients at all lattice nodes around a block of positions, hashed once, and how vectors of positions fetch theirs.
//!
//! Warped coordinates are smooth: neighbouring samples lie in the same cells or in neighbouring ones. A vector of them whose cells lie in two rows and a few
//! columns permutes its gradients from the nodes there, where it would otherwise hash four corners a lane.

use super::{
    Lanes,
    aligned::AlignedArray,
    cells::{Base, Near},
    gradient_lanes::{Corners, Noise, Palette},
    hash,
};

/// Most nodes of a block.
const MOST: usize = 512;

/// What permutations read beyond the last node.
const SLACK: usize = 32;

/// The gradients at the nodes around a block.
pub(super) struct Nodes {
    components: [AlignedArray<{ MOST + SLACK }>; 2],
    /// From one row of nodes to the next.
    stride: usize,
}

impl Nodes {
    pub(super) fn new() -> Self {
        Self { components: [AlignedArray([0.0; MOST + SLACK]), AlignedArray([0.0; MOST + SLACK])], stride: 0 }
    }

    /// Hashes the nodes around the cells from the bases to as far as they reach, if that is worth while for so many samples.
    #[inline(always)]
    pub(super) fn draw<L: Lanes, N: Noise>(&mut self, lanes: L, palette: &Palette, seed: u32, [x, y]: [&Base; 2], samples: usize) -> bool {
        const FIRST: [u32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
        let stride = (x.reach as usize + 2).next_multiple_of(L::WIDTH);
        // A vector in the last row of cells has a third row of nodes, which it reads and does not use.
        if stride * (y.reach as usize + 3) > MOST.min(samples + samples / 2) {
            return false;
        }
        self.stride = stride;
        let [to_gx, to_gy] = &mut self.components;
        for column in (0..stride).step_by(L::WIDTH) {
            let cells = lanes.load_words(&FIRST) + lanes.splat_words(column as u32);
            let [key, _] = hash::keys(lanes, 0, 0, x.cell, cells);
            for row in 0..y.reach as usize + 2 {
                let row_key = lanes.splat_words(hash::row_key(y.cell + row as i64, seed));
                let [gx, gy] = N::gradients(lanes, palette, key, row_key);
                lanes.store(gx, &mut to_gx.0[row * stride + column..]);
                lanes.store(gy, &mut to_gy.0[row * stride + column..]);
            }
        }
        true
    }

    /// The gradients around a vector of positions in one row of cells, given as words by [`Near::words`].
    #[inline(always)]
    pub(super) fn row<L: Lanes>(&self, lanes: L, window: Window, x: L::Words) -> Corners<L> {
        let index = lanes.shr::<24>(x - lanes.splat_words(window.west));
        let [gx, gy] = &self.components;
        let (south, north) = (window.node as usize, window.node as usize + self.stride);
        let (south_x, north_x) = (&gx.0[south..][..=L::REACH], &gx.0[north..][..=L::REACH]);
        let (south_y, north_y) = (&gy.0[south..][..=L::REACH], &gy.0[north..][..=L::REACH]);
        [
            [lanes.permute(south_x, index), lanes.permute(south_y, index)],
            [lanes.permute(&south_x[1..], index), lanes.permute(&south_y[1..], index)],
            [lanes.permute(north_x, index), lanes.permute(north_y, index)],
            [lanes.permute(&north_x[1..], index), lanes.permute(&north_y[1..], index)],
        ]
    }

    /// Those around a vector in two rows of cells.
    #[inline(always)]
    pub(super) fn rows<L: Lanes>(&self, lanes: L, window: Window, [x, y]: [L::Words; 2]) -> Corners<L> {
        let (column, row) = (lanes.shr::<24>(x - lanes.splat_words(window.west)), lanes.shr::<24>(y - lanes.splat_words(window.south)));
        let index = column + if L::SPAN == 4 { lanes.shl::<2>(row) } else { lanes.shl::<4>(row) };
        let (first, stride) = (window.node as usize, self.stride);
        let [gx, gy] = &self.components;
        let [gx, gy] = [&gx.0[first..], &gy.0[first..]];
        let gx = [&gx[..=L::SPAN], &gx[stride..][..=L::SPAN], &gx[2 * stride..][..=L::SPAN]];
        let gy = [&gy[..=L::SPAN], &gy[stride..][..=L::SPAN], &gy[2 * stride..][..=L::SPAN]];
        [
            [lanes.permute_two([gx[0], gx[1]], index), lanes.permute_two([gy[0], gy[1]], index)],
            [lanes.permute_two([&gx[0][1..], &gx[1][1..]], index), lanes.permute_two([&gy[0][1..], &gy[1][1..]], index)],
            [lanes.permute_two([gx[1], gx[2]], index), lanes.permute_two([gy[1], gy[2]], index)],
            [lanes.permute_two([&gx[1][1..], &gx[2][1..]], index), lanes.permute_two([&gy[1][1..], &gy[2][1..]], index)],
        ]
    }
}

/// Where the cells of a vector of positions begin.
#[derive(Clone, Copy)]
pub(super) struct Window {
    pub kind: u32,
    /// The first of its nodes.
    node: u32,
    west: u32,
    south: u32,
}

impl Window {
    /// The cells are too many.
    pub(super) const NONE: u32 = 0;
    /// The cells lie in one row.
    pub(super) const ROW: u32 = 1;
    /// They lie in two.
    pub(super) const ROWS: u32 = 2;
}

/// Most vectors of a block.
pub(super) const VECTORS: usize = 64;

/// The least and the greatest coordinates of each vector of a block: u and v.
pub(super) struct Bounds {
    pub least: [[f64; VECTORS]; 2],
    pub greatest: [[f64; VECTORS]; 2],
}

/// The windows of each vector of a block, property by property.
pub(super) struct Windows {
    kind: [u32; VECTORS],
    node: [u32; VECTORS],
    west: [u32; VECTORS],
    south: [u32; VECTORS],
}

impl Windows {
    pub(super) fn new() -> Self {
        Self { kind: [0; VECTORS], node: [0; VECTORS], west: [0; VECTORS], south: [0; VECTORS] }
    }

    /// Finds those of the first vectors.
    #[inline(always)]
    pub(super) fn find<L: Lanes>(&mut self, _: L, [x, y]: [&Near; 2], nodes: &Nodes, bounds: &Bounds, vectors: usize) {
        for i in 0..vectors {
            let (west, east) = (x.word(bounds.least[0][i]) >> 24, x.word(bounds.greatest[0][i]) >> 24);
            let (south, north) = (y.word(bounds.least[1][i]) >> 24, y.word(bounds.greatest[1][i]) >> 24);
            let (columns, rows) = (east - west, north - south);
            let two = if columns < L::SPAN as u32 && rows < 2 { Window::ROWS } else { Window::NONE };
            self.kind[i] = if columns < L::REACH as u32 && rows == 0 { Window::ROW } else { two };
            self.node[i] = south * nodes.stride as u32 + west;
            (self.west[i], self.south[i]) = (west << 24, south << 24);
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, vector: usize) -> Window {
        Window { kind: self.kind[vector], node: self.node[vector], west: self.west[vector], south: self.south[vector] }
    }
}
