//! Names of parts of a lattice: what is whole in a part is named beforehand, so that naming a large part costs little more than naming its rim.

use core::ops::Range;
use sha2::{Digest, Sha256};

/// Nodes along a side of a block.
const SIDE: usize = 16;

/// The names of the blocks of a lattice, row by row. Blocks at its eastern and northern borders may be smaller.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Blocks {
    across: usize,
    names: Vec<[u8; 16]>,
}

/// The nodes of a block along an axis.
fn nodes(block: usize, count: usize) -> Range<usize> {
    block * SIDE..((block + 1) * SIDE).min(count)
}

fn feed(columns: usize, heights: &[f32], part: &Range<usize>, rows: Range<usize>, hash: &mut Sha256) {
    let mut bytes = [0; 4 * SIDE];
    for row in rows {
        let part = &heights[row * columns..][part.clone()];
        for (bytes, height) in bytes.chunks_exact_mut(4).zip(part) {
            bytes.copy_from_slice(&height.to_bits().to_le_bytes());
        }
        hash.update(&bytes[..4 * part.len()]);
    }
}

impl Blocks {
    /// Those of a lattice, row by row from the south.
    pub(super) fn of(columns: usize, heights: &[f32]) -> Self {
        let rows = heights.len() / columns.max(1);
        let (across, up) = (columns.div_ceil(SIDE), rows.div_ceil(SIDE));
        let name = |block: usize| {
            let mut hash = Sha256::new();
            feed(columns, heights, &nodes(block % across, columns), nodes(block / across, rows), &mut hash);
            let digest = hash.finalize();
            core::array::from_fn(|i| digest[i])
        };
        Self { across, names: (0..across * up).map(name).collect() }
    }

    /// Hashes the nodes of a part that is not empty: of blocks that are whole in it their names, of others the nodes themselves.
    pub(super) fn hash_part(&self, columns: usize, heights: &[f32], across: Range<usize>, up: Range<usize>, hash: &mut Sha256) {
        let rows = heights.len() / columns.max(1);
        for range in [&across, &up] {
            hash.update((range.start as u64).to_le_bytes());
            hash.update((range.end as u64).to_le_bytes());
        }
        for j in up.start / SIDE..up.end.div_ceil(SIDE) {
            for i in across.start / SIDE..across.end.div_ceil(SIDE) {
                let (whole_across, whole_up) = (nodes(i, columns), nodes(j, rows));
                let part = |whole: &Range<usize>, range: &Range<usize>| whole.start.max(range.start)..whole.end.min(range.end);
                let (own_across, own_up) = (part(&whole_across, &across), part(&whole_up, &up));
                if (&own_across, &own_up) == (&whole_across, &whole_up) {
                    hash.update(self.names[j * self.across + i]);
                } else {
                    feed(columns, heights, &own_across, own_up, hash);
                }
            }
        }
    }
}
