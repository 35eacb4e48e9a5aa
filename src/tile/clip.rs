//! Clipping lines and rings to a tile with its border (Y.-D. Liang and B. Barsky 1984; I. Sutherland and G. Hodgman 1974), and rounding them to its units.

use super::mvt::{EXTENT, straightened};
use crate::geometry::{Grid, GridError, Rectangle, Samples, Tile};

/// Units of a tile and what of the plane it shows.
pub(super) struct Frame {
    corner: [f64; 2],
    unit: f64,
    /// Least and greatest unit of each axis that is drawn.
    low: [f64; 2],
    high: [f64; 2],
}

impl Frame {
    /// A tile that shows an area.
    pub(super) fn new(grid: Grid, tile: Tile, area: &Rectangle) -> Result<Self, GridError> {
        let corners = grid.window(tile, Samples::Vertices(2), crate::geometry::Filter::Exact)?;
        let corner = [corners.columns.coordinate(0), corners.rows.coordinate(0)];
        let mut frame = Self { corner, unit: grid.tile_side(tile.z) / f64::from(EXTENT), low: [0.0; 2], high: [0.0; 2] };
        (frame.low, frame.high) = (frame.place([area.min[0], area.max[1]]), frame.place([area.max[0], area.min[1]]));
        Ok(frame)
    }

    /// Metres of a unit.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// A point in units, to the east and to the south.
    pub(super) fn place(&self, p: [f64; 2]) -> [f64; 2] {
        [(p[0] - self.corner[0]) / self.unit, (self.corner[1] - p[1]) / self.unit]
    }

    /// A point inside the border in whole units.
    #[expect(clippy::unused_self, reason = "only what was placed by a frame can be rounded")]
    pub(super) fn rounded(&self, p: [f64; 2]) -> [i32; 2] {
        p.map(|c| c.round() as i32)
    }

    /// The part of a segment inside the border.
    fn segment(&self, a: [f64; 2], b: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let along = b[axis] - a[axis];
            for (distance, sign) in [(self.low[axis] - a[axis], 1.0), (a[axis] - self.high[axis], -1.0)] {
                // Inside this side where distance - t · sign · along is at most 0.
                let rate = sign * along;
                if rate == 0.0 {
                    if distance > 0.0 {
                        return None;
                    }
                } else if rate > 0.0 {
                    from = from.max(distance / rate);
                } else {
                    to = to.min(distance / rate);
                }
            }
        }
        let at = |t: f64| core::array::from_fn(|axis| (a[axis] + (b[axis] - a[axis]) * t).clamp(self.low[axis], self.high[axis]));
        (from <= to).then(|| [if from > 0.0 { at(from) } else { a }, if to < 1.0 { at(to) } else { b }])
    }
}

/// The parts of a line inside the border.
pub(super) fn lines(frame: &Frame, line: &[[f64; 2]]) -> Vec<Vec<[i32; 2]>> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for pair in line.windows(2) {
        let Some([a, b]) = frame.segment(frame.place(pair[0]), frame.place(pair[1])) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&a) => part.push(b),
            _ => parts.push(vec![a, b]),
        }
    }
    let rounded = parts.into_iter().map(|part| straightened(part.into_iter().map(|p| frame.rounded(p))));
    rounded.filter(|part| part.len() > 1).collect()
}

/// A ring inside the border, its first vertex not repeated; outer rings run clockwise as seen on the map. `None` if nothing of it is seen.
pub(super) fn ring(frame: &Frame, vertices: &[[f64; 2]], outer: bool) -> Option<Vec<[i32; 2]>> {
    let mut ring: Vec<[f64; 2]> = vertices.iter().map(|&p| frame.place(p)).collect();
    for axis in 0..2 {
        for (limit, sign) in [(frame.low[axis], 1.0), (frame.high[axis], -1.0)] {
            ring = half(&ring, axis, limit, sign);
        }
    }
    let mut ring = straightened(ring.into_iter().map(|p| frame.rounded(p)));
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let doubled: i64 = (0..ring.len())
        .map(|i| (ring[i], ring[(i + 1) % ring.len()]))
        .map(|(a, b)| i64::from(a[0]) * i64::from(b[1]) - i64::from(b[0]) * i64::from(a[1]))
        .sum();
    if doubled == 0 {
        return None;
    }
    if (doubled > 0) != outer {
        ring.reverse();
    }
    Some(ring)
}

/// What of a ring lies on one side of a line along an axis.
fn half(ring: &[[f64; 2]], axis: usize, limit: f64, sign: f64) -> Vec<[f64; 2]> {
    let inside = |p: [f64; 2]| (p[axis] - limit) * sign >= 0.0;
    let mut out = Vec::with_capacity(ring.len() + 4);
    for (i, &b) in ring.iter().enumerate() {
        let a = ring[(i + ring.len() - 1) % ring.len()];
        if inside(a) != inside(b) {
            let t = (limit - a[axis]) / (b[axis] - a[axis]);
            let mut cut = [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
            cut[axis] = limit;
            out.push(cut);
        }
        if inside(b) {
            out.push(b);
        }
    }
    out
}
