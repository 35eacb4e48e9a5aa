//! Which edges of a curve can be nearest to any point of a part of a block.
//!
//! A path is never farther from its chord than its reach (Benjaminsen 2021, chapter 13, with the bound made sound), and its ends lie on the curve. For a point v
//! of the curve and any place x of a path, |p - x|² - |p - v|² is linear in p: what is positive at the four corners of a rectangle is positive in all of it. So a
//! path whose capsule is farther than v from each corner is nowhere nearest and is never halved.

use super::{block::LEAST, runs::Runs};
use crate::{
    geometry::{Chord, Curve, Edge, EdgeDetail, Rectangle},
    noise::Lanes,
};

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
            self.roots.push(if let Some(detail) = &near.detail {
                node(detail, number, 0, 0, detail.ends[0], detail.ends[1])
            } else {
                let [a, b] = curve.edge(i as usize);
                Node { a, b, reach: 0.0, chord: number, index: i % stride as u32, level: 0, straight: true }
            });
        }
        self.begin_reach(reach, bounds);
    }

    /// Goes to a single point.
    pub(super) fn begin_point(&mut self, at: [f64; 2], elevation: f64, reach: f64, area: &Rectangle) {
        let chord = Chord { first: 0, ends: [at; 2], elevations: [elevation; 2] };
        self.chords.clear();
        self.roots.clear();
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
        let ([xs, ys], diagonal) = (corners(area), diagonal(area));
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

    /// Whether some corner of an area is beyond the reach of the search.
    #[inline(always)]
    pub(super) fn leaves(&self, area: &Rectangle, list: &[Node]) -> bool {
        let [xs, ys] = corners(area);
        let mut most_least = [f64::INFINITY; 4];
        for node in list {
            for (least, square) in most_least.iter_mut().zip(squares(&xs, &ys, node)) {
                *least = if square < *least { square } else { *least };
            }
        }
        let far = self.reach * self.reach;
        most_least[0] > far || most_least[1] > far || most_least[2] > far || most_least[3] > far
    }

    /// As [`Search::refine`] to the end, asking every point of a least part of a block instead of its corners.
    #[inline(always)]
    pub(super) fn refine_points<L: Lanes>(&mut self, lanes: L, points: [&[f64]; 2], list: &mut Vec<Node>) {
        let mut packet = Packet::new(lanes, points, self.reach);
        for node in &*list {
            packet.meet(lanes, node.a);
            packet.meet(lanes, node.b);
        }
        loop {
            packet.measure(lanes);
            let mut halved = false;
            self.next.clear();
            for node in &*list {
                if !packet.can_be_nearest(lanes, node) {
                    continue;
                }
                match &self.chords[node.chord as usize].detail {
                    Some(detail) if !node.straight => {
                        halved = true;
                        let halves = halves(detail, node);
                        packet.meet(lanes, if detail.reversed { halves[0].a } else { halves[0].b });
                        self.next.extend(halves);
                    }
                    _ => self.next.push(*node),
                }
            }
            std::mem::swap(list, &mut self.next);
            if !halved {
                return;
            }
        }
    }

    /// Whether the path is beyond the reach of the search everywhere in an area of a diagonal.
    #[inline(always)]
    fn is_far(&self, node: &Node, squares: &[f64; 4], diagonal: f64) -> bool {
        // No point of the area is farther from its nearest corner than half the diagonal.
        let far = (self.reach + node.reach + diagonal * 0.5) * (1.0 + 1e-9);
        least(squares) > far * far + self.slack
    }

    /// Whether some witness is nearer than the path at each corner.
    #[inline(always)]
    fn is_dominated(&self, node: &Node, squares: &[f64; 4], witnesses: &[[f64; 4]; 4]) -> bool {
        let mut dominated = false;
        for distances in witnesses {
            let mut nearer = true;
            for i in 0..4 {
                let most = distances[i] + node.reach;
                nearer &= squares[i] > most * most * (1.0 + 1e-8) + self.slack;
            }
            dominated |= nearer;
        }
        dominated
    }
}

/// The points of a least part of a block in f32, from its middle, with the distances of the nearest known points of the curve.
struct Packet {
    middle: [f64; 2],
    /// Metres from the middle to the farthest point, at most.
    radius: f64,
    xs: [f32; LEAST],
    ys: [f32; LEAST],
    squares: [f32; LEAST],
    distances: [f32; LEAST],
}

/// What rounding to f32 can make of squares, relative to the squared size of what is computed with: 64 roundings.
const ROUNDING: f32 = 4e-6;

impl Packet {
    #[inline(always)]
    fn new<L: Lanes>(lanes: L, [xs, ys]: [&[f64]; 2], reach: f64) -> Self {
        let last = LEAST - 1;
        let middle = [(xs[0] + xs[last]) * 0.5, (ys[0] + ys[last]) * 0.5];
        let radius = (xs[last] - xs[0]).abs() + (ys[last] - ys[0]).abs();
        let mut packet = Self { middle, radius, xs: [0.0; LEAST], ys: [0.0; LEAST], squares: [0.0; LEAST], distances: [0.0; LEAST] };
        for i in (0..LEAST).step_by(L::WIDTH) {
            let x = lanes.round(lanes.load_doubles(&xs[i..]) - lanes.splat_doubles(middle[0]));
            let y = lanes.round(lanes.load_doubles(&ys[i..]) - lanes.splat_doubles(middle[1]));
            lanes.store(x, &mut packet.xs[i..]);
            lanes.store(y, &mut packet.ys[i..]);
        }
        // What is beyond the reach is never nearest; a little more, for rounding.
        packet.squares = [(reach * reach * (1.0 + 1e-5)).min(f64::from(f32::MAX)) as f32; LEAST];
        packet
    }

    /// A place relative to the middle, rounded.
    #[inline(always)]
    fn relative(&self, p: [f64; 2]) -> [f32; 2] {
        [(p[0] - self.middle[0]) as f32, (p[1] - self.middle[1]) as f32]
    }

    /// A point of the curve: no point is farther from the curve than from it.
    #[inline(always)]
    fn meet<L: Lanes>(&mut self, lanes: L, p: [f64; 2]) {
        let p = self.relative(p);
        let p = [lanes.splat(p[0]), lanes.splat(p[1])];
        for i in (0..LEAST).step_by(L::WIDTH) {
            let (x, y) = (lanes.load(&self.xs[i..]) - p[0], lanes.load(&self.ys[i..]) - p[1]);
            let least = lanes.smaller(lanes.load(&self.squares[i..]), x * x + y * y);
            lanes.store(least, &mut self.squares[i..]);
        }
    }

    #[inline(always)]
    fn measure<L: Lanes>(&mut self, lanes: L) {
        for i in (0..LEAST).step_by(L::WIDTH) {
            lanes.store(lanes.sqrt(lanes.load(&self.squares[i..])), &mut self.distances[i..]);
        }
    }

    /// Whether a path can be nearer to any of the points than all that is known.
    #[inline(always)]
    fn can_be_nearest<L: Lanes>(&self, lanes: L, node: &Node) -> bool {
        let (a, b) = (self.relative(node.a), self.relative(node.b));
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        let inverse = lanes.splat(if square > 1e-30 { 1.0 / square } else { 0.0 });
        let size = a[0].abs() + a[1].abs() + b[0].abs() + b[1].abs() + self.radius as f32 + node.reach as f32;
        let slack = lanes.splat(size * size * ROUNDING);
        let (a, along) = ([lanes.splat(a[0]), lanes.splat(a[1])], [lanes.splat(along[0]), lanes.splat(along[1])]);
        let (zero, one, reach) = (lanes.splat(0.0), lanes.splat(1.0), lanes.splat(node.reach as f32));
        let mut can = false;
        for i in (0..LEAST).step_by(L::WIDTH) {
            let (x, y) = (lanes.load(&self.xs[i..]) - a[0], lanes.load(&self.ys[i..]) - a[1]);
            let t = lanes.smaller(lanes.larger((x * along[0] + y * along[1]) * inverse, zero), one);
            let (x, y) = (x - along[0] * t, y - along[1] * t);
            let most = lanes.load(&self.distances[i..]) + reach;
            can |= lanes.any_less(x * x + y * y, most * most + slack);
        }
        can
    }
}

/// Whether a path can touch an area.
#[inline(always)]
pub(super) fn touches(node: &Node, area: &Rectangle) -> bool {
    let [xs, ys] = corners(area);
    let far = (diagonal(area) * 0.5 + node.reach) * (1.0 + 1e-9);
    least(&squares(&xs, &ys, node)) <= far * far
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
///
/// Plain loops, here and below: closures would not always become part of a kernel.
#[inline(always)]
fn squares(xs: &[f64; 4], ys: &[f64; 4], node: &Node) -> [f64; 4] {
    let (along, from) = ([node.b[0] - node.a[0], node.b[1] - node.a[1]], node.a);
    let square = along[0] * along[0] + along[1] * along[1];
    let inverse = if square > 1e-200 { 1.0 / square } else { 0.0 };
    let mut squares = [0.0; 4];
    for i in 0..4 {
        let (x, y) = (xs[i] - from[0], ys[i] - from[1]);
        let t = (x * along[0] + y * along[1]) * inverse;
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < 1.0 { t } else { 1.0 };
        let (x, y) = (x - along[0] * t, y - along[1] * t);
        squares[i] = x * x + y * y;
    }
    squares
}

/// The least of four numbers.
#[inline(always)]
fn least(of: &[f64; 4]) -> f64 {
    let (a, b) = (if of[1] < of[0] { of[1] } else { of[0] }, if of[3] < of[2] { of[3] } else { of[2] });
    if b < a { b } else { a }
}

/// The coordinates of the corners of an area.
#[inline(always)]
fn corners(area: &Rectangle) -> [[f64; 4]; 2] {
    let ([x0, y0], [x1, y1]) = (area.min, area.max);
    [[x0, x1, x0, x1], [y0, y0, y1, y1]]
}

/// The diagonal of an area.
#[inline(always)]
fn diagonal(area: &Rectangle) -> f64 {
    let [width, height] = [area.max[0] - area.min[0], area.max[1] - area.min[1]];
    (width * width + height * height).sqrt()
}

/// For each corner the nearest known point of the curve: its distances from all corners.
#[inline(always)]
fn witnesses(xs: &[f64; 4], ys: &[f64; 4], list: &[Node]) -> [[f64; 4]; 4] {
    let (mut least, mut found) = ([f64::INFINITY; 4], [[0.0; 4]; 2]);
    for node in list {
        for point in [node.a, node.b] {
            for i in 0..4 {
                let (x, y) = (xs[i] - point[0], ys[i] - point[1]);
                let square = x * x + y * y;
                let nearer = square < least[i];
                least[i] = if nearer { square } else { least[i] };
                found[0][i] = if nearer { point[0] } else { found[0][i] };
                found[1][i] = if nearer { point[1] } else { found[1][i] };
            }
        }
    }
    let mut distances = [[0.0; 4]; 4];
    for (distances, (px, py)) in distances.iter_mut().zip(found[0].iter().zip(&found[1])) {
        for i in 0..4 {
            let (x, y) = (xs[i] - px, ys[i] - py);
            distances[i] = (x * x + y * y).sqrt();
        }
    }
    distances
}
