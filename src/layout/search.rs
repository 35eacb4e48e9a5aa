//! Which edges of a curve can be nearest to any point of a part of a block.
//!
//! A path is never farther from its chord than its reach (Benjaminsen 2021, chapter 13, with the bound made sound), and its ends lie on the curve. For a point v
//! of the curve and any place x of a path, |p - x|² - |p - v|² is linear in p: what is positive at the four corners of a rectangle is positive in all of it. So a
//! path whose capsule is farther than v from each corner is nowhere nearest and is never halved.

use super::runs::Runs;
use crate::geometry::{Chord, Curve, Edge, EdgeDetail, Rectangle};

/// The path of a chord, or of a segment of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub a: [f64; 2],
    pub b: [f64; 2],
    /// Metres that the path can be away from the segment from a to b; 0 if it is straight.
    reach: f64,
    /// Number of the chord in the search.
    pub chord: u32,
    /// Number of the segment on its level, or of the edge of an expanded chord.
    pub index: u32,
    pub level: u8,
    pub straight: bool,
}

impl Node {
    /// A rectangle that holds the path.
    pub(super) fn bounds(&self) -> Rectangle {
        Rectangle::around(&[self.a, self.b]).grown(self.reach)
    }
}

/// A chord that can be near.
#[derive(Clone, Debug)]
pub(super) struct Near {
    pub chord: Chord,
    pub straight: Edge,
    pub detail: Option<EdgeDetail>,
}

/// A search for one curve and one block.
#[derive(Clone, Debug, Default)]
pub(super) struct Search {
    pub chords: Vec<Near>,
    /// The paths to begin with.
    pub roots: Vec<Node>,
    /// Metres beyond which nothing is asked.
    reach: f64,
    /// What rounding can make of squared distances.
    slack: f64,
    edges: Vec<u32>,
    next: Vec<Node>,
}

impl Search {
    /// Goes to a curve and an area.
    pub(super) fn begin(&mut self, curve: &Curve, runs: Option<&Runs>, area: &Rectangle, reach: f64, spacing: f64) {
        self.chords.clear();
        self.roots.clear();
        self.edges.clear();
        let stride = curve.stride();
        match runs {
            Some(runs) => runs.near(curve, area, reach, &mut self.edges),
            None => self.edges.extend(0..(curve.chord_count() * stride) as u32),
        }
        let (mut last, mut bounds) = (None, *area);
        for &i in &self.edges {
            let chord = i as usize / stride;
            if last.replace(chord) != Some(chord) {
                let chord = curve.chord(chord);
                let detail = curve.detail().map(|detail| detail.of_edge(chord.ends[0], chord.ends[1], spacing));
                self.chords.push(Near { chord, straight: Edge::new(chord.ends[0], chord.ends[1]), detail });
                bounds = bounds.union(Rectangle::around(&chord.ends));
            }
            let number = self.chords.len() as u32 - 1;
            let near = &self.chords[number as usize];
            self.roots.push(match &near.detail {
                Some(detail) => node(detail, number, 0, 0, detail.ends[0], detail.ends[1]),
                None => {
                    let [a, b] = curve.edge(i as usize);
                    Node { a, b, reach: 0.0, chord: number, index: i % stride as u32, level: 0, straight: true }
                }
            });
        }
        self.begin_reach(reach, bounds);
    }

    /// Goes to a single point.
    pub(super) fn begin_point(&mut self, at: [f64; 2], elevation: f64, reach: f64, area: &Rectangle) {
        let chord = Chord { first: 0, ends: [at; 2], elevations: [elevation; 2] };
        (self.chords.clear(), self.roots.clear());
        self.chords.push(Near { chord, straight: Edge::new(at, at), detail: None });
        self.roots.push(Node { a: at, b: at, reach: 0.0, chord: 0, index: 0, level: 0, straight: true });
        self.begin_reach(reach, area.union(Rectangle::around(&[at])));
    }

    fn begin_reach(&mut self, reach: f64, bounds: Rectangle) {
        let [width, height] = [bounds.max[0] - bounds.min[0], bounds.max[1] - bounds.min[1]];
        self.reach = reach;
        self.slack = (width * width + height * height) * 1e-18;
    }

    /// Leaves those paths in the list that can be nearest to a point of an area, halving them while there are at most `limit`; `true` if all are straight.
    #[inline(always)]
    pub(super) fn refine(&mut self, area: &Rectangle, list: &mut Vec<Node>, limit: usize) -> bool {
        let corners = area.corners();
        let (xs, ys) = (corners.map(|c| c[0]), corners.map(|c| c[1]));
        let [width, height] = [area.max[0] - area.min[0], area.max[1] - area.min[1]];
        let diagonal = (width * width + height * height).sqrt();
        loop {
            let witnesses = witnesses(&xs, &ys, list);
            let (mut halved, mut crooked) = (false, false);
            let halving = list.len() <= limit;
            self.next.clear();
            for node in &*list {
                let squares = squares(&xs, &ys, node);
                if self.is_far(node, &squares, diagonal) || self.is_dominated(node, &squares, &witnesses) {
                    continue;
                }
                if node.straight || !halving {
                    crooked |= !node.straight;
                    self.next.push(*node);
                    continue;
                }
                halved = true;
                if let Some(detail) = &self.chords[node.chord as usize].detail {
                    self.next.extend(halves(detail, node));
                }
            }
            std::mem::swap(list, &mut self.next);
            if !halved {
                return !crooked;
            }
        }
    }

    /// Whether the path is beyond the reach of the search everywhere in an area of a diagonal.
    #[inline(always)]
    fn is_far(&self, node: &Node, squares: &[f64; 4], diagonal: f64) -> bool {
        let least = squares.iter().fold(f64::INFINITY, |least, &square| if square < least { square } else { least });
        // No point of the area is farther from its nearest corner than half the diagonal.
        let far = (self.reach + node.reach + diagonal * 0.5) * (1.0 + 1e-9);
        least > far * far + self.slack
    }

    /// Whether some witness is nearer than the path at each corner.
    #[inline(always)]
    fn is_dominated(&self, node: &Node, squares: &[f64; 4], witnesses: &[[f64; 4]; 4]) -> bool {
        let mut dominated = false;
        for distances in witnesses {
            let mut nearer = true;
            for (square, distance) in squares.iter().zip(distances) {
                let most = distance + node.reach;
                nearer &= *square > most * most * (1.0 + 1e-8) + self.slack;
            }
            dominated |= nearer;
        }
        dominated
    }
}

/// Whether a path can touch an area.
#[inline(always)]
pub(super) fn touches(node: &Node, area: &Rectangle) -> bool {
    let corners = area.corners();
    let squares = squares(&corners.map(|c| c[0]), &corners.map(|c| c[1]), node);
    let least = squares.iter().fold(f64::INFINITY, |least: f64, &square| least.min(square));
    let [width, height] = [area.max[0] - area.min[0], area.max[1] - area.min[1]];
    let far = ((width * width + height * height).sqrt() * 0.5 + node.reach) * (1.0 + 1e-9);
    least <= far * far
}

#[inline(always)]
pub(super) fn node(detail: &EdgeDetail, chord: u32, level: u8, index: u32, a: [f64; 2], b: [f64; 2]) -> Node {
    Node { a, b, reach: detail.reach(level, a, b), chord, index, level, straight: level == detail.levels }
}

/// Both halves of a path, in the direction of the curve.
#[inline(always)]
pub(super) fn halves(detail: &EdgeDetail, of: &Node) -> [Node; 2] {
    let middle = detail.midpoint(of.level, of.index, of.a, of.b);
    let first = node(detail, of.chord, of.level + 1, 2 * of.index, of.a, middle);
    let second = node(detail, of.chord, of.level + 1, 2 * of.index + 1, middle, of.b);
    if detail.reversed { [second, first] } else { [first, second] }
}

/// Squared distances of the corners from the straight segment of a path.
#[inline(always)]
fn squares(xs: &[f64; 4], ys: &[f64; 4], node: &Node) -> [f64; 4] {
    let (along, from) = ([node.b[0] - node.a[0], node.b[1] - node.a[1]], node.a);
    let square = along[0] * along[0] + along[1] * along[1];
    let inverse = if square > 1e-200 { 1.0 / square } else { 0.0 };
    core::array::from_fn(|i| {
        let (x, y) = (xs[i] - from[0], ys[i] - from[1]);
        let t = (x * along[0] + y * along[1]) * inverse;
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < 1.0 { t } else { 1.0 };
        let (x, y) = (x - along[0] * t, y - along[1] * t);
        x * x + y * y
    })
}

/// For each corner the nearest known point of the curve: its distances from all corners.
#[inline(always)]
fn witnesses(xs: &[f64; 4], ys: &[f64; 4], list: &[Node]) -> [[f64; 4]; 4] {
    let (mut least, mut found) = ([f64::INFINITY; 4], [[0.0; 2]; 4]);
    for point in list.iter().flat_map(|node| [node.a, node.b]) {
        for i in 0..4 {
            let (x, y) = (xs[i] - point[0], ys[i] - point[1]);
            let square = x * x + y * y;
            let nearer = square < least[i];
            least[i] = if nearer { square } else { least[i] };
            found[i][0] = if nearer { point[0] } else { found[i][0] };
            found[i][1] = if nearer { point[1] } else { found[i][1] };
        }
    }
    found.map(|point| {
        core::array::from_fn(|i| {
            let (x, y) = (xs[i] - point[0], ys[i] - point[1]);
            (x * x + y * y).sqrt()
        })
    })
}
