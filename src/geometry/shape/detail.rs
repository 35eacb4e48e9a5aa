//! Detail by midpoint displacement (Fournier, Fussell, Carpenter 1982; Benjaminsen 2021, chapters 9 and 13).

use super::{ShapeError, edge::is_after};
use core::f64::consts::FRAC_PI_2;

/// Most iterations of midpoint displacement: a segment becomes up to 2^20.
pub const MAX_ITERATIONS: u8 = 20;

/// Midpoint displacement of every edge of a shape.
///
/// The midpoint of an edge moves along the normal by a share of the edge's length that is spread evenly over ± the displacement, and so do the midpoints of the
/// halves, `iterations` times. The share is a hash of the seed, the ends of the edge in lexicographical order, the level and the index: an edge has the same
/// detail in whichever shape and direction it stands.
///
/// Seen at a spacing, iterations whose segments would be shorter than it are left out, the last one by degrees: full where its segments have two spacings, gone
/// where they have one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    iterations: u8,
    displacement: f64,
    seed: u64,
}

impl Detail {
    /// `iterations` halvings, each displaced by at most `displacement` of the length.
    ///
    /// # Errors
    /// If there are more than [`MAX_ITERATIONS`], or the displacement is not within 0 … 1.
    pub fn new(iterations: u8, displacement: f64, seed: u64) -> Result<Self, ShapeError> {
        if iterations > MAX_ITERATIONS {
            return Err(ShapeError::Iterations(iterations));
        }
        if !(0.0..=1.0).contains(&displacement) {
            return Err(ShapeError::Displacement(displacement));
        }
        Ok(Self { iterations, displacement, seed })
    }

    /// As [`Detail::new`], for rivers: the displacement is so small that the path nowhere runs backwards along its chord.
    ///
    /// # Errors
    /// As [`Detail::new`], and if the displacement is greater than [`Detail::river_bound`].
    pub fn river(iterations: u8, displacement: f64, seed: u64) -> Result<Self, ShapeError> {
        let detail = Self::new(iterations, displacement, seed)?;
        let bound = Self::river_bound(iterations);
        if displacement > bound {
            return Err(ShapeError::River { displacement, bound, iterations });
        }
        Ok(detail)
    }

    /// tan(90° / iterations) / 2, at most 1: each iteration turns the path by at most a share of a right angle.
    #[must_use]
    pub fn river_bound(iterations: u8) -> f64 {
        if iterations < 2 { 1.0 } else { (libm::tan(FRAC_PI_2 / f64::from(iterations)) / 2.0).min(1.0) }
    }

    /// Halvings of an edge.
    #[must_use]
    pub fn iterations(&self) -> u8 {
        self.iterations
    }

    /// Greatest share of a segment's length that its midpoint moves by.
    #[must_use]
    pub fn displacement(&self) -> f64 {
        self.displacement
    }

    /// The seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Metres that an edge's detail can be away from it.
    #[must_use]
    pub fn reach(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        self.of_edge(a, b, 0.0).reach(0, a, b)
    }

    /// The detail of one edge as samples `spacing` metres apart see it; 0 for all of it.
    #[must_use]
    pub fn of_edge(&self, a: [f64; 2], b: [f64; 2], spacing: f64) -> EdgeDetail {
        let reversed = is_after(a, b);
        let ends = if reversed { [b, a] } else { [a, b] };
        // Adding zero makes one of the two zeros.
        let key = ends.iter().flatten().fold(mix(self.seed), |key, c| mix(key ^ (c + 0.0).to_bits()));
        let mut detail = EdgeDetail { ends, reversed, key, levels: 0, shares: [0.0; LEVELS], reaches: [0.0; LEVELS] };
        let length = ((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1])).sqrt();
        let mut half = length / 2.0;
        while detail.levels < self.iterations && half > spacing {
            let fade = if spacing > 0.0 { (half / spacing - 1.0).min(1.0) } else { 1.0 };
            detail.shares[usize::from(detail.levels)] = self.displacement * fade;
            detail.levels += 1;
            half /= 2.0;
        }
        for level in (0..usize::from(detail.levels)).rev() {
            let share = detail.shares[level];
            detail.reaches[level] = share + (0.25 + share * share).sqrt() * detail.reaches[level + 1];
        }
        detail
    }
}

/// Levels, and one for what is displaced no more.
const LEVELS: usize = MAX_ITERATIONS as usize + 1;

/// The midpoint displacement of one edge, a binary tree: segment `index` of level n has the halves 2 · index and 2 · index + 1 of level n + 1, counted from the
/// lexicographically first end.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeDetail {
    /// The ends of the edge in lexicographical order.
    pub ends: [[f64; 2]; 2],
    /// Whether the edge was given from the second to the first.
    pub reversed: bool,
    /// How often it is halved.
    pub levels: u8,
    key: u64,
    /// Greatest share of the length a level displaces by.
    shares: [f64; LEVELS],
    /// Distance that a level and those after it can lead away from a segment, over its length.
    reaches: [f64; LEVELS],
}

impl EdgeDetail {
    /// The displaced midpoint of segment `index` of a level, which runs from `a` to `b`.
    #[inline(always)]
    #[must_use]
    pub fn midpoint(&self, level: u8, index: u32, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        // From [0, 2^53) to [-1, 1).
        let spread = (mix(self.key ^ ((1 << level) + u64::from(index))) >> 11) as f64 * (1.0 / 4_503_599_627_370_496.0) - 1.0;
        let share = spread * self.shares[usize::from(level)];
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        [(a[0] + b[0]) * 0.5 - y * share, (a[1] + b[1]) * 0.5 + x * share]
    }

    /// Metres that the path of a segment of a level can be away from it, at most.
    ///
    /// For equal shares d this is d · length · Σ (1/4 + d²)^(j/2) over the levels left, and a little for the rounding of coordinates.
    #[inline(always)]
    #[must_use]
    pub fn reach(&self, level: u8, a: [f64; 2], b: [f64; 2]) -> f64 {
        if level == self.levels {
            return 0.0;
        }
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        let far = a[0].abs().max(a[1].abs()).max(b[0].abs()).max(b[1].abs());
        self.reaches[usize::from(level)] * (x * x + y * y).sqrt() * (1.0 + 1e-9) + far * ROUNDING
    }

    /// Writes all vertices from the lexicographically first end to the second.
    pub fn expand(&self, out: &mut Vec<[f64; 2]>) {
        self.vertices(self.levels, out);
    }

    /// Writes the vertices after the first `levels` halvings, from the lexicographically first end to the second.
    ///
    /// # Panics
    /// If there are more halvings than the edge has.
    pub fn vertices(&self, levels: u8, out: &mut Vec<[f64; 2]>) {
        assert!(levels <= self.levels, "an edge of {} halvings", self.levels);
        let pieces = 1_usize << levels;
        out.clear();
        out.resize(pieces + 1, self.ends[1]);
        out[0] = self.ends[0];
        for level in 0..levels {
            let step = pieces >> level;
            for index in 0..1 << level {
                let at = index as usize * step;
                out[at + step / 2] = self.midpoint(level, index, out[at], out[at + step]);
            }
        }
    }
}

/// 2^-46: twenty levels each round a coordinate by less than 2^-51 of it.
const ROUNDING: f64 = 1.0 / 70_368_744_177_664.0;

/// Mixes 64 bits: the finaliser of `SplitMix64`, variant 13 of D. Stafford.
#[inline(always)]
fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
