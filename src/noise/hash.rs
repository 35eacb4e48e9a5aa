//! Integer hashes: from the seed of a world to the numbers at a lattice corner.

use super::Lanes;

/// Mixes 64 bits so that every input bit changes every output bit with probability near one half (the finaliser of `SplitMix64`, variant 13 of D. Stafford).
#[must_use]
pub fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The key of something numbered `number` inside something of key `parent`.
#[must_use]
pub fn key(parent: u64, number: u64) -> u64 {
    mix(parent ^ mix(number))
}

/// Factors of the low and the high word of a column's and of a row's number.
const FACTORS: [[u32; 2]; 2] = [[0x9e37_79b1, 0x27d4_eb2f], [0x85eb_ca77, 0xc2b2_ae3d]];

/// A column's share of a corner's hash.
#[inline(always)]
pub(super) fn column_key(i: i64) -> u32 {
    (i as u32).wrapping_mul(FACTORS[0][0]) ^ ((i >> 32) as u32).wrapping_mul(FACTORS[0][1])
}

/// A row's share of a corner's hash, the lattice's seed included.
#[inline(always)]
pub(super) fn row_key(j: i64, seed: u32) -> u32 {
    (j as u32).wrapping_mul(FACTORS[1][0]) ^ ((j >> 32) as u32).wrapping_mul(FACTORS[1][1]) ^ seed
}

/// The 32 random bits of a lattice corner.
///
/// Two rounds of xor-shift and multiply (constants of C. Wellons' prospector search, 2018).
#[inline(always)]
pub(super) fn corner(column: u32, row: u32) -> u32 {
    let h = column ^ row;
    let h = (h ^ (h >> 16)).wrapping_mul(0x21f0_aaad);
    let h = (h ^ (h >> 15)).wrapping_mul(0xd35a_2d97);
    h ^ (h >> 15)
}

/// [`corner`] of every lane.
#[inline(always)]
pub(super) fn corners<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> L::Words {
    let h = top_of_corners(lanes, columns, rows);
    h ^ lanes.shr::<15>(h)
}

/// The topmost 15 bits of [`corner`] of every lane, which its last step does not change, above others.
#[inline(always)]
pub(super) fn top_of_corners<L: Lanes>(lanes: L, columns: L::Words, rows: L::Words) -> L::Words {
    let h = columns ^ rows;
    let h = (h ^ lanes.shr::<16>(h)) * lanes.splat_words(0x21f0_aaad);
    (h ^ lanes.shr::<15>(h)) * lanes.splat_words(0xd35a_2d97)
}

/// [`column_key`] (axis 0) or [`row_key`] (axis 1) of the cells that are counted from `base`, less than 2^31 beyond it, and of the next cells.
#[inline(always)]
pub(super) fn keys<L: Lanes>(lanes: L, axis: usize, seed: u32, base: i64, cells: L::Words) -> [L::Words; 2] {
    let [low_factor, high_factor] = FACTORS[axis].map(|factor| lanes.splat_words(factor));
    let (base_low, seed) = (lanes.splat_words(base as u32), lanes.splat_words(if axis == 0 { 0 } else { seed }));
    let low = base_low + cells;
    let next = low + lanes.splat_words(1);
    // A carry is where the top bit falls from one to zero.
    let high = lanes.splat_words((base >> 32) as u32) + lanes.shr::<31>((base_low ^ low) & base_low);
    let carried = high + lanes.shr::<31>((low ^ next) & low);
    let near = low * low_factor;
    [near ^ (high * high_factor) ^ seed, (near + low_factor) ^ (carried * high_factor) ^ seed]
}

/// [`keys`] of cells that all have the same high words: products of low words, of which every corner's hash takes one a direction and the factor as it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearKeys {
    low: u32,
    factor: u32,
    /// The share of the high word and of the seed.
    pub high: u32,
}

impl NearKeys {
    /// For the cells from `base` to `reach` cells beyond and their neighbours; none if their high words differ.
    #[inline(always)]
    pub(super) fn new(axis: usize, seed: u32, base: i64, reach: u32) -> Option<Self> {
        let [factor, high_factor] = FACTORS[axis];
        let high = base >> 32;
        let seed = if axis == 0 { 0 } else { seed };
        ((base + i64::from(reach) + 1) >> 32 == high).then(|| Self {
            low: (base as u32).wrapping_mul(factor),
            factor,
            high: (high as u32).wrapping_mul(high_factor) ^ seed,
        })
    }

    /// The keys of cells counted from the base and of the next, but for `high`.
    #[inline(always)]
    pub(super) fn keys<L: Lanes>(&self, lanes: L, cells: L::Words) -> [L::Words; 2] {
        let factor = lanes.splat_words(self.factor);
        let near = cells * factor + lanes.splat_words(self.low);
        [near, near + factor]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every bit of a corner's hash is set for half the corners and tells nothing of the neighbours' bits.
    #[test]
    fn corners_have_fair_and_independent_bits() {
        for (x0, y0) in [(-300_i64, -300_i64), (1 << 40, -(1 << 41)), (i64::from(i32::MAX) - 150, 0)] {
            let n = 600_i64;
            let hash = |i: i64, j: i64| corner(column_key(x0 + i), row_key(y0 + j, 0xdead_beef));
            let (mut ones, mut right, mut down, mut diagonal) = ([0_u32; 32], [0_u32; 32], [0_u32; 32], [0_u32; 32]);
            for j in 0..n {
                for i in 0..n {
                    let h = hash(i, j);
                    let neighbours = [hash(i + 1, j), hash(i, j + 1), hash(i + 1, j + 1)];
                    for bit in 0..32 {
                        let b = |h: u32| (h >> bit) & 1;
                        ones[bit] += b(h);
                        right[bit] += b(h) ^ b(neighbours[0]);
                        down[bit] += b(h) ^ b(neighbours[1]);
                        diagonal[bit] += b(h) ^ b(neighbours[2]);
                    }
                }
            }
            // Five standard deviations of a fair coin thrown 360,000 times are 1,500.
            for counts in [ones, right, down, diagonal] {
                for (bit, &count) in counts.iter().enumerate() {
                    assert!((i64::from(count) - n * n / 2).abs() < 1_500, "bit {bit}: {count} of {} at {x0} {y0}", n * n);
                }
            }
        }
    }

    #[test]
    fn keys_of_a_lattice_beyond_32_bits_differ() {
        assert_ne!(column_key(5), column_key(5 + (1 << 32)));
        assert_ne!(row_key(5, 0), row_key(5 + (1 << 32), 0));
    }
}
