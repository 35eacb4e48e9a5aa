//! Ways that have become too long to be kept: squares of the plane that they went through.

use std::collections::BTreeSet;

/// Samples of a way at most, beside its own points.
const SAMPLES: f64 = 4096.0;

/// Squares that hold a way: every point of it is within `margin` of the middle of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cover {
    side: f64,
    margin: f64,
    squares: BTreeSet<[i64; 2]>,
}

impl Cover {
    /// Adds a way, with squares of at least so many metres, and at most so many of them, or four.
    pub(super) fn add(&mut self, way: &[[f64; 2]], least: f64, most: usize) {
        let length: f64 = way.windows(2).map(|pair| (pair[1][0] - pair[0][0]).abs() + (pair[1][1] - pair[0][1]).abs()).sum();
        if self.squares.is_empty() {
            (self.side, self.margin) = (least, 0.0);
        }
        // Points along the way are at most a side apart: so many that they can be counted.
        while length > SAMPLES * self.side {
            self.coarsen();
        }
        self.margin = self.margin.max(1.21 * self.side);
        let snapped = |[x, y]: [f64; 2], side: f64| [(x / side).floor() as i64, (y / side).floor() as i64];
        for (i, &point) in way.iter().enumerate() {
            let before = way[i.saturating_sub(1)];
            let steps = (((point[0] - before[0]).abs() + (point[1] - before[1]).abs()) / self.side).ceil().max(1.0);
            for step in 0..=steps as usize {
                let t = step as f64 / steps;
                self.squares.insert(snapped([0, 1].map(|axis| before[axis] + t * (point[axis] - before[axis])), self.side));
            }
        }
        // Around a corner that all squares have there are four at any size.
        while self.squares.len() > most.max(4) {
            self.coarsen();
        }
    }

    /// Squares twice as wide in the place of these.
    fn coarsen(&mut self) {
        self.side *= 2.0;
        if !self.squares.is_empty() {
            // From the middle of a quarter to that of the whole.
            self.margin += 0.36 * self.side;
        }
        self.squares = self.squares.iter().map(|square| square.map(|c| c.div_euclid(2))).collect();
    }

    /// The middles of the squares.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.squares.iter().map(|square| square.map(|c| (c as f64 + 0.5) * self.side))
    }

    /// How far from the nearest of them points of the way are at most.
    pub(super) fn margin(&self) -> f64 {
        self.margin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::genetic::Draws;

    #[test]
    fn every_point_of_a_way_is_near_a_square() {
        let mut draws = Draws::new(6);
        for (scale, most) in [(3.0, 256), (200.0, 256), (1e9, 256), (10.0, 1)] {
            let (mut cover, mut at, mut all) = (Cover::default(), [5.0, -900.0], vec![[5.0, -900.0]]);
            for _ in 0..6 {
                let way: Vec<[f64; 2]> = (0..800)
                    .map(|_| {
                        at = [at[0] + scale * draws.normal(), at[1] + scale * draws.normal()];
                        at
                    })
                    .collect();
                let joined: Vec<_> = all.last().copied().into_iter().chain(way.iter().copied()).collect();
                cover.add(&joined, 20.0, most);
                all.extend(way);
            }
            let middles: Vec<[f64; 2]> = cover.points().collect();
            assert!(middles.len() <= most.max(4) && (scale > 3.0 || cover.margin() < 200.0), "{} {}", middles.len(), cover.margin());
            for pair in all.windows(2).step_by(7) {
                let t = draws.unit();
                let point = [0, 1].map(|axis| pair[0][axis] + t * (pair[1][axis] - pair[0][axis]));
                let near = middles.iter().map(|[x, y]| libm::hypot(x - point[0], y - point[1])).fold(f64::INFINITY, f64::min);
                assert!(near <= cover.margin(), "{near} of {}", cover.margin());
            }
        }
    }
}
