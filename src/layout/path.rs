//! Displaced paths as searches see them: in f32 from the middle of a window, and halved once for all blocks that they reach.
//!
//! Nothing here decides a value: it is asked only which parts of a path can be nearest, and what rounding could change is added to the reach of every part.

use crate::geometry::{EdgeDetail, Rectangle, Window};
use std::collections::BTreeMap;

/// What rounding to f32 can make of distances, relative to the size of the coordinates: 32 roundings.
const ROUNDING: f64 = 32.0 / 16_777_216.0;

/// Most halvings that a path keeps: 2^10 segments are 64 KiB.
const MOST_LEVELS: u8 = 10;

/// Fewest halvings that are worth keeping.
const LEAST_LEVELS: u8 = 3;

/// Samples near a chord for each segment that is kept of its path.
const SAMPLES: f64 = 4.0;

/// Where the samples of a window lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    middle: [f64; 2],
    /// Metres from the middle to the farthest sample along both axes together.
    radius: f64,
    bounds: Rectangle,
    /// Square metres a sample.
    sample: f64,
}

impl Frame {
    pub(super) fn new(window: &Window) -> Self {
        let bounds = window.bounds();
        let middle = [0, 1].map(|axis| f64::midpoint(bounds.min[axis], bounds.max[axis]));
        let radius = (bounds.max[0] - middle[0]) + (bounds.max[1] - middle[1]);
        Self { middle, radius, bounds, sample: window.columns.spacing() * window.rows.spacing() }
    }

    /// A coordinate of an axis from the middle, rounded.
    #[inline(always)]
    pub(super) fn relative(&self, axis: usize, c: f64) -> f32 {
        (c - self.middle[axis]) as f32
    }

    /// The corners of an area from the middle, rounded.
    #[inline(always)]
    pub(super) fn corners(&self, area: &Rectangle) -> [[f32; 4]; 2] {
        let at = |p: [f64; 2]| [self.relative(0, p[0]), self.relative(1, p[1])];
        let ([x0, y0], [x1, y1]) = (at(area.min), at(area.max));
        [[x0, x1, x0, x1], [y0, y0, y1, y1]]
    }

    /// How often it is worth to halve a path beforehand that has influence in an area.
    fn levels(&self, area: &Rectangle, most: u8) -> u8 {
        let side = |axis: usize| (area.max[axis].min(self.bounds.max[axis]) - area.min[axis].max(self.bounds.min[axis])).max(0.0);
        let segments = side(0) * side(1) / self.sample / SAMPLES;
        (0..most.min(MOST_LEVELS)).take_while(|level| f64::from(2_u32 << level) <= segments).count() as u8
    }
}

/// A segment of a path, in f32 from the middle of the window.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flat {
    pub start: [f32; 2],
    pub along: [f32; 2],
    /// One over the squared length; 0 for a segment without length.
    pub inverse: f32,
    /// Metres that the path can be away from the segment, with all that rounding can do to its distances from samples and to theirs from other places.
    pub reach: f32,
}

impl Flat {
    #[inline(always)]
    pub(super) fn new(frame: &Frame, a: [f64; 2], b: [f64; 2], reach: f64) -> Self {
        let (start, along) = ([a[0] - frame.middle[0], a[1] - frame.middle[1]], [b[0] - a[0], b[1] - a[1]]);
        let size = start[0].abs() + start[1].abs() + along[0].abs() + along[1].abs() + frame.radius;
        let (start, along) = ([start[0] as f32, start[1] as f32], [along[0] as f32, along[1] as f32]);
        let square = along[0] * along[0] + along[1] * along[1];
        Self { start, along, inverse: if square > 1e-30 { 1.0 / square } else { 0.0 }, reach: (reach + size * ROUNDING) as f32 }
    }

    /// Its ends.
    #[inline(always)]
    pub(super) fn ends(&self) -> [[f32; 2]; 2] {
        let Self { start, along, .. } = self;
        [*start, [start[0] + along[0], start[1] + along[1]]]
    }
}

/// Places of the first halvings of a path in [`Paths`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    /// Where its segments begin, level by level; a segment's halves stand at twice its number there and one or two more.
    pub first: u32,
    /// Where its vertices begin.
    vertices: u32,
    /// How often it is halved here.
    pub levels: u8,
}

/// Paths of chords that are kept for the blocks of a window: by number of the feature and of the chord.
#[derive(Clone, Debug, Default)]
pub(super) struct Paths {
    /// `None` for those that are not worth it.
    known: BTreeMap<(u32, u32), Option<Kept>>,
    /// From the lexicographically first end to the second.
    vertices: Vec<[f64; 2]>,
    pub flats: Vec<Flat>,
    path: Vec<[f64; 2]>,
    reaches: Vec<f64>,
}

/// Segments that are kept at most: 24 MiB.
const MOST_SEGMENTS: usize = 1 << 20;

impl Paths {
    /// Forgets what is kept if it is much.
    pub(super) fn limit(&mut self) {
        if self.flats.len() > MOST_SEGMENTS {
            *self = Self::default();
        }
    }

    /// A path; `None` if it is not worth it for the samples of an area, outside of which the path has no influence.
    pub(super) fn get(&mut self, key: (u32, u32), detail: &EdgeDetail, frame: &Frame, area: impl FnOnce() -> Rectangle) -> Option<Kept> {
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let levels = frame.levels(&area(), detail.levels);
        let kept = (levels >= LEAST_LEVELS).then(|| self.keep(detail, frame, levels));
        self.known.insert(key, kept);
        kept
    }

    fn keep(&mut self, detail: &EdgeDetail, frame: &Frame, levels: u8) -> Kept {
        let kept = Kept { first: self.flats.len() as u32, vertices: self.vertices.len() as u32, levels };
        detail.vertices(levels, &mut self.path);
        let (path, reaches) = (&self.path, &mut self.reaches);
        self.vertices.extend_from_slice(path);
        let count = (2 << levels) - 1;
        reaches.clear();
        reaches.resize(count, 0.0);
        self.flats.resize(kept.first as usize + count, Flat::default());
        let flats = &mut self.flats[kept.first as usize..];
        for level in (0..=levels).rev() {
            let (first, step) = ((1 << level) - 1, 1 << (levels - level));
            for i in 0..1 << level {
                let (at, [a, b]) = (i * step, [path[i * step], path[(i + 1) * step]]);
                let reach = match levels - level {
                    0 => detail.reach(level, a, b),
                    1 => away(a, b, [path[at + 1]]) + greatest(&reaches[2 * first + 1 + 2 * i..][..2]),
                    _ => away(a, b, [path[at + step / 4], path[at + step / 2], path[at + step / 4 * 3]]) + greatest(&reaches[4 * first + 3 + 4 * i..][..4]),
                };
                reaches[first + i] = reach;
                flats[first + i] = Flat::new(frame, a, b, reach);
            }
        }
        kept
    }

    /// The ends of a segment that is kept.
    #[inline(always)]
    pub(super) fn ends(&self, kept: &Kept, level: u8, index: u32) -> [[f64; 2]; 2] {
        let step = 1 << (kept.levels - level);
        let first = kept.vertices as usize + index as usize * step;
        [self.vertices[first], self.vertices[first + step]]
    }
}

/// Metres from a segment to the farthest of some vertices, and a little for rounding.
#[inline(always)]
fn away<const N: usize>(a: [f64; 2], b: [f64; 2], vertices: [[f64; 2]; N]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let inverse = if square > 1e-200 { 1.0 / square } else { 0.0 };
    let squares = vertices.map(|p| {
        let [x, y] = [p[0] - a[0], p[1] - a[1]];
        let t = ((x * along[0] + y * along[1]) * inverse).clamp(0.0, 1.0);
        let [x, y] = [x - along[0] * t, y - along[1] * t];
        x * x + y * y
    });
    greatest(&squares).sqrt() * (1.0 + 1e-9)
}

#[inline(always)]
fn greatest(of: &[f64]) -> f64 {
    of.iter().fold(0.0, |most, &reach| if reach > most { reach } else { most })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Detail, Edge, Filter};

    /// Everything that a segment leads to is within its reach, and its reach is mostly far less than any path of its kind could need.
    #[test]
    fn kept_segments_hold_their_paths() {
        let (mut tight, mut loose) = (0.0, 0.0);
        for seed in 0..40 {
            let far = [0.0, 1e6, 7e11][seed as usize % 3];
            let (a, b) = ([far - 40.0, 3.0 - far], [far + 700.0, 130.0 + f64::from(seed as u32) - far]);
            let detail = Detail::new([3, 6, 13][seed as usize % 3], [0.08, 0.3, 1.0][seed as usize / 3 % 3], seed).expect("valid").of_edge(a, b, 0.0);
            let window = Window::area([far - 500.0, -500.0 - far, far + 500.0, 500.0 - far], 2.0, Filter::Exact, 1 << 20).expect("valid");
            let (frame, mut paths, mut all) = (Frame::new(&window), Paths::default(), Vec::new());
            detail.expand(&mut all);
            let area = Rectangle::around(&[a, b]).grown(300.0);
            let kept = paths.get((0, 0), &detail, &frame, || area).expect("many samples");
            assert_eq!(paths.get((0, 0), &detail, &frame, || Rectangle::EMPTY).map(|kept| kept.levels), Some(kept.levels));
            for level in 0..=kept.levels {
                for index in 0..1_u32 << level {
                    let [a, b] = paths.ends(&kept, level, index);
                    let piece = 1_usize << (detail.levels - level);
                    let first = index as usize * piece;
                    assert_eq!([a, b], [all[first], all[first + piece]]);
                    let flat = &paths.flats[(kept.first + (1 << level) - 1 + index) as usize];
                    let edge = Edge::new(a, b);
                    let farthest = all[first..=first + piece].iter().map(|&p| edge.nearest(p).0.sqrt()).fold(0.0, f64::max);
                    assert!(farthest <= f64::from(flat.reach), "seed {seed}, level {level}: {farthest} and {}", flat.reach);
                    if far == 0.0 && level + 2 <= kept.levels {
                        tight += f64::from(flat.reach);
                        loose += detail.reach(level, a, b);
                    }
                }
            }
        }
        assert!(tight < 0.6 * loose, "{tight} of {loose}");
    }

    #[test]
    fn few_samples_keep_nothing() {
        let detail = Detail::new(10, 0.2, 1).expect("valid").of_edge([0.0, 0.0], [100.0, 0.0], 0.0);
        let window = Window::point(50.0, 3.0, 1.0, Filter::Exact).expect("valid");
        let mut paths = Paths::default();
        assert!(paths.get((0, 0), &detail, &Frame::new(&window), || Rectangle::EVERYTHING).is_none() && paths.flats.is_empty());
    }
}
