//! Straight edges: the one definition of their distance and of which side of them a point lies on.

/// A straight edge, its ends put in lexicographical order: whichever way it is given, all that is computed of it has the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The lexicographically first end.
    pub start: [f64; 2],
    /// From the first end to the second.
    pub along: [f64; 2],
    /// One over the squared length; 0 for an edge without length.
    pub inverse: f64,
    /// Whether the ends were given in the other order.
    pub flipped: bool,
}

impl Edge {
    /// The edge between two points.
    #[inline(always)]
    #[must_use]
    pub fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        let flipped = is_after(a, b);
        let (start, end) = if flipped { (b, a) } else { (a, b) };
        let along = [end[0] - start[0], end[1] - start[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        Self { start, along, inverse: if square > 1e-200 { 1.0 / square } else { 0.0 }, flipped }
    }

    /// The squared distance of a point, and how far along the edge, 0 … 1 from its first end, the nearest place is.
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, p: [f64; 2]) -> (f64, f64) {
        let [x, y] = [p[0] - self.start[0], p[1] - self.start[1]];
        let t = (x * self.along[0] + y * self.along[1]) * self.inverse;
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < 1.0 { t } else { 1.0 };
        let [x, y] = [x - self.along[0] * t, y - self.along[1] * t];
        (x * x + y * y, t)
    }
}

/// Whether `a` comes after `b` in lexicographical order.
#[inline(always)]
pub(super) fn is_after(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0] > b[0] || (a[0] == b[0] && a[1] > b[1])
}

/// Whether the ray from `p` eastwards crosses the edge from `a` to `b`, of which the lower end belongs to it and the upper one does not.
///
/// Edges wholly east or west of the point are decided by their ends, so that a path east of a point is crossed an odd number of times exactly if its ends lie on
/// both sides of the ray.
#[inline(always)]
#[must_use]
pub fn crosses(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> bool {
    if (a[1] > p[1]) == (b[1] > p[1]) {
        return false;
    }
    if p[0] < a[0] && p[0] < b[0] {
        return true;
    }
    if p[0] > a[0] && p[0] > b[0] {
        return false;
    }
    let (low, high) = if is_after(a, b) { (b, a) } else { (a, b) };
    let turn = (high[0] - low[0]) * (p[1] - low[1]) - (p[0] - low[0]) * (high[1] - low[1]);
    (turn > 0.0) == (high[1] > low[1])
}
