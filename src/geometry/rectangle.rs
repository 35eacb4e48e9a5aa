//! Rectangles with sides along the axes.

/// A closed rectangle in plane metres; empty if a least coordinate is greater than the greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Least x and y.
    pub min: [f64; 2],
    /// Greatest x and y.
    pub max: [f64; 2],
}

impl Rectangle {
    /// The rectangle that holds nothing.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };

    /// The rectangle that holds everything.
    pub const EVERYTHING: Self = Self { min: [f64::NEG_INFINITY; 2], max: [f64::INFINITY; 2] };

    /// The least rectangle that holds all the points.
    #[must_use]
    pub fn around(points: &[[f64; 2]]) -> Self {
        points.iter().fold(Self::EMPTY, |all, &point| all.union(Self { min: point, max: point }))
    }

    /// The least rectangle that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])], max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])] }
    }

    /// What lies in both.
    #[must_use]
    pub fn meet(self, other: &Self) -> Self {
        Self { min: [self.min[0].max(other.min[0]), self.min[1].max(other.min[1])], max: [self.max[0].min(other.max[0]), self.max[1].min(other.max[1])] }
    }

    /// The rectangle with every side moved outwards by `offset` metres.
    #[must_use]
    pub fn grown(self, offset: f64) -> Self {
        Self { min: self.min.map(|c| c - offset), max: self.max.map(|c| c + offset) }
    }

    /// Whether the two share a point.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }

    /// Whether the point lies in it.
    #[must_use]
    pub fn holds(&self, point: [f64; 2]) -> bool {
        (0..2).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// Its four corners.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let ([x0, y0], [x1, y1]) = (self.min, self.max);
        [[x0, y0], [x1, y0], [x0, y1], [x1, y1]]
    }
}
