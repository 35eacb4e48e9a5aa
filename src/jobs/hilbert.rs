//! Tiles of a level in the order of archives: along a Hilbert curve.

use pmtiles::{TileCoord, TileId};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Tiles of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// The level.
    pub z: u8,
    /// First and last.
    pub columns: [u32; 2],
    /// First and last, from the north.
    pub rows: [u32; 2],
}

impl Block {
    /// How many tiles it has; `None` if its level has no such tiles.
    pub(super) fn tiles(&self) -> Option<u64> {
        let side = 1_u64.checked_shl(self.z.into())?;
        let count = |[first, last]: [u32; 2]| (first <= last && u64::from(last) < side).then(|| u64::from(last - first) + 1);
        count(self.columns)?.checked_mul(count(self.rows)?)
    }

    /// The numbers of its tiles as runs, ascending.
    ///
    /// A square of 2^n tiles a side that stands on its own raster is one run, so the block is cut into such squares.
    pub(super) fn runs(&self) -> Vec<Range<u64>> {
        let mut runs = Vec::new();
        self.collect(0, 0, &mut runs);
        runs
    }

    /// The runs in the square that is number `at` of level `z`.
    fn collect(&self, z: u8, at: u64, runs: &mut Vec<Range<u64>>) {
        let deeper = self.z - z;
        let square = coordinate(first_id(z) + at);
        let span = |from: u32| [from << deeper, (from << deeper) + ((1_u64 << deeper) - 1) as u32];
        let (columns, rows) = (span(square.x()), span(square.y()));
        let meets = |own: [u32; 2], other: [u32; 2]| own[0] <= other[1] && other[0] <= own[1];
        let holds = |own: [u32; 2], other: [u32; 2]| own[0] <= other[0] && other[1] <= own[1];
        if !meets(self.columns, columns) || !meets(self.rows, rows) {
            return;
        }
        if !holds(self.columns, columns) || !holds(self.rows, rows) {
            (0..4).for_each(|quarter| self.collect(z + 1, at * 4 + quarter, runs));
            return;
        }
        let first = first_id(self.z) + (at << (2 * deeper));
        let run = first..first + (1 << (2 * deeper));
        match runs.last_mut() {
            Some(last) if last.end == run.start => last.end = run.end,
            _ => runs.push(run),
        }
    }
}

/// The number of the first tile of a level.
fn first_id(z: u8) -> u64 {
    ((1 << (2 * z)) - 1) / 3
}

/// The tile of a number.
pub(super) fn coordinate(id: u64) -> TileCoord {
    TileId::new(id).expect("levels are at most 30").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_the_tiles_of_a_block_and_no_others() {
        for (z, columns, rows) in [(0, [0, 0], [0, 0]), (3, [0, 7], [0, 7]), (5, [3, 17], [9, 9]), (6, [31, 33], [0, 63]), (9, [100, 164], [7, 80])] {
            let block = Block { z, columns, rows };
            let runs = block.runs();
            assert!(runs.windows(2).all(|pair| pair[0].end < pair[1].start), "ascending and apart: {runs:?}");
            let mut found: Vec<_> = runs.into_iter().flatten().map(coordinate).map(|tile| (tile.z(), tile.x(), tile.y())).collect();
            found.sort_unstable();
            let wanted: Vec<_> = (columns[0]..=columns[1]).flat_map(|x| (rows[0]..=rows[1]).map(move |y| (z, x, y))).collect();
            assert_eq!(found, wanted);
        }
    }
}
