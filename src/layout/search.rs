//! Which edges of a curve can be nearest to any point of a part of a block.
//!
//! A path is never farther from its chord than its reach (Benjaminsen 2021, chapter 13, with the bound made sound), and its ends lie on the curve. For a point v
//! of the curve and any place x of a path, |p - x|² - |p - v|² is linear in p: what is positive at the four corners of a rectangle is positive in all of it. So a
//! path whose capsule is farther than v from each corner is nowhere nearest and is never halved.

use super::{
    block::{Block, LEAST},
    path::{Flat, Frame, Kept, Paths},
    runs::Runs,
};
use crate::{
    geometry::{Chord, Curve, Edge, EdgeDetail, Rectangle},
    noise::Lanes,
};

/// The path of a chord, or of a segment of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Where its flat form stands.
    flat: u32,
    /// Number of the chord in the search.
    pub chord: u32,
    /// Number of the segment on its level, or of the edge of an expanded chord.
    pub index: u32,
    level: u8,
    straight: bool,
}

/// A chord that can be near.
#[derive(Clone, Debug)]
pub(super) struct Near {
    pub chord: Chord,
    pub straight: Edge,
    pub detail: Option<EdgeDetail>,
    /// Its path, if that is kept.
    kept: Option<Kept>,
}

/// A search for one curve and one block.
#[derive(Clone, Debug)]
pub(super) struct Search {
    pub chords: Vec<Near>,
    /// The paths to begin with.
    pub roots: Vec<Node>,
    pub frame: Frame,
    /// Metres beyond which nothing is asked.
    reach: f32,
    /// Segments that are kept for all blocks.
    paths: Paths,
    /// Segments of this block alone stand after those that are kept: their flat forms and their ends.
    flats: Vec<Flat>,
    ends: Vec<[[f64; 2]; 2]>,
    edges: Vec<u32>,
    next: Vec<Node>,
}

/// Numbers of segments from here on are those of the block alone.
const OWN: u32 = 1 << 31;

impl Search {
    /// For the blocks of a window.
    pub(super) fn new(frame: Frame) -> Self {
        Self {
            chords: Vec::new(),
            roots: Vec::new(),
            frame,
            reach: 0.0,
            paths: Paths::default(),
            flats: Vec::new(),
            ends: Vec::new(),
            edges: Vec::new(),
            next: Vec::new(),
        }
    }

    /// Goes to the curve of a feature and an area.
    pub(super) fn begin(&mut self, number: u32, curve: &Curve, runs: Option<&Runs>, area: &Rectangle, reach: f64, spacing: f64) {
        self.begin_reach(reach);
        self.edges.clear();
        self.paths.limit();
        let stride = curve.stride();
        match runs {
            Some(runs) => runs.near(curve, area, reach, &mut self.edges),
            None => self.edges.extend(0..(curve.chord_count() * stride) as u32),
        }
        let mut last = None;
        for i in 0..self.edges.len() {
            let edge = self.edges[i] as usize;
            let chord = edge / stride;
            if last.replace(chord) != Some(chord) {
                let key = (number, chord as u32);
                let chord = curve.chord(chord);
                let detail = curve.detail().map(|detail| detail.of_edge(chord.ends[0], chord.ends[1], spacing));
                let kept = detail.as_ref().and_then(|detail| {
                    let area = || Rectangle::around(&chord.ends).grown(detail.reach(0, detail.ends[0], detail.ends[1]) + reach);
                    self.paths.get(key, detail, &self.frame, area)
                });
                self.chords.push(Near { chord, straight: Edge::new(chord.ends[0], chord.ends[1]), detail, kept });
            }
            let chord = self.chords.len() as u32 - 1;
            let Near { detail, kept, .. } = &self.chords[chord as usize];
            let root = match (detail, kept) {
                (Some(detail), Some(kept)) => Node { flat: kept.first, chord, index: 0, level: 0, straight: detail.levels == 0 },
                (Some(detail), None) => {
                    let (ends, reach) = (detail.ends, detail.reach(0, detail.ends[0], detail.ends[1]));
                    let flat = own(&mut self.flats, &mut self.ends, &self.frame, ends, reach);
                    Node { flat, chord, index: 0, level: 0, straight: detail.levels == 0 }
                }
                (None, _) => {
                    let flat = own(&mut self.flats, &mut self.ends, &self.frame, curve.edge(edge), 0.0);
                    Node { flat, chord, index: (edge % stride) as u32, level: 0, straight: true }
                }
            };
            self.roots.push(root);
        }
    }

    /// Goes to a single point.
    pub(super) fn begin_point(&mut self, at: [f64; 2], elevation: f64, reach: f64) {
        self.begin_reach(reach);
        let chord = Chord { first: 0, ends: [at; 2], elevations: [elevation; 2] };
        self.chords.push(Near { chord, straight: Edge::new(at, at), detail: None, kept: None });
        let flat = own(&mut self.flats, &mut self.ends, &self.frame, [at; 2], 0.0);
        self.roots.push(Node { flat, chord: 0, index: 0, level: 0, straight: true });
    }

    /// The flat form of a path.
    #[inline(always)]
    fn flat(&self, node: &Node) -> &Flat {
        flat_of(&self.paths, &self.flats, node.flat)
    }

    /// The ends of a path.
    #[inline(always)]
    pub(super) fn ends(&self, node: &Node) -> [[f64; 2]; 2] {
        match &self.chords[node.chord as usize].kept {
            Some(kept) if node.flat < OWN => self.paths.ends(kept, node.level, node.index),
            _ => self.ends[(node.flat - OWN) as usize],
        }
    }

    /// Adds both halves of a path, in the direction of the curve, to the list of what comes next; the beginning of the second in lexicographical order is answered.
    #[inline(always)]
    fn halve(&mut self, node: &Node) -> [f32; 2] {
        let Near { detail, kept, .. } = &self.chords[node.chord as usize];
        let Some(detail) = detail else { return [0.0; 2] };
        let (level, first) = (node.level + 1, 2 * node.index);
        let straight = level == detail.levels;
        let flats = match kept {
            Some(kept) if level <= kept.levels => {
                let at = kept.first + 2 * (node.flat - kept.first) + 1;
                [at, at + 1]
            }
            _ => {
                let [a, b] = self.ends(node);
                let middle = detail.midpoint(node.level, node.index, a, b);
                [[a, middle], [middle, b]].map(|[a, b]| own(&mut self.flats, &mut self.ends, &self.frame, [a, b], detail.reach(level, a, b)))
            }
        };
        let middle = flat_of(&self.paths, &self.flats, flats[1]).start;
        let halves = [Node { flat: flats[0], index: first, level, straight, ..*node }, Node { flat: flats[1], index: first + 1, level, straight, ..*node }];
        self.next.extend_from_slice(&if detail.reversed { [halves[1], halves[0]] } else { halves });
        middle
    }

    fn begin_reach(&mut self, reach: f64) {
        self.chords.clear();
        self.roots.clear();
        self.flats.clear();
        self.ends.clear();
        self.reach = (reach * (1.0 + 1e-6)) as f32;
    }

    /// Leaves those paths in the list that can be nearest to a point of an area, halving them while there are at most `limit`; `true` if all are straight.
    #[inline(always)]
    pub(super) fn refine(&mut self, area: &Rectangle, list: &mut Vec<Node>, limit: usize) -> bool {
        let [xs, ys] = self.frame.corners(area);
        // No point of the area is farther from its nearest corner than half the diagonal.
        let diagonal = [xs[1] - xs[0], ys[2] - ys[0]];
        let far = self.reach + (diagonal[0] * diagonal[0] + diagonal[1] * diagonal[1]).sqrt() * (0.5 + 1e-6);
        loop {
            let witnesses = self.witnesses(&xs, &ys, list);
            let (mut halved, mut crooked) = (false, false);
            let halving = list.len() <= limit;
            self.next.clear();
            for node in &*list {
                let flat = self.flat(node);
                let squares = squares(&xs, &ys, flat);
                let most = far + flat.reach;
                if least(&squares) > most * most || is_dominated(flat.reach, &squares, &witnesses) {
                    continue;
                }
                if node.straight || !halving {
                    crooked |= !node.straight;
                    self.next.push(*node);
                } else {
                    halved = true;
                    self.halve(node);
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
        let [xs, ys] = self.frame.corners(area);
        let mut most_least = [f32::INFINITY; 4];
        for node in list {
            for (least, square) in most_least.iter_mut().zip(squares(&xs, &ys, self.flat(node))) {
                *least = if square < *least { square } else { *least };
            }
        }
        let far = self.reach * self.reach;
        most_least[0] > far || most_least[1] > far || most_least[2] > far || most_least[3] > far
    }

    /// As [`Search::refine`] to the end, asking every point of a least part of a block instead of its corners.
    #[inline(always)]
    pub(super) fn refine_points<L: Lanes>(&mut self, lanes: L, block: &Block, start: usize, list: &mut Vec<Node>) {
        let mut packet = Packet::new(block, start, self.reach);
        for node in &*list {
            for end in self.flat(node).ends() {
                packet.meet(lanes, end);
            }
        }
        loop {
            packet.measure(lanes);
            let mut halved = false;
            self.next.clear();
            for node in &*list {
                if !packet.can_be_nearest(lanes, self.flat(node)) {
                    continue;
                }
                if node.straight {
                    self.next.push(*node);
                } else {
                    halved = true;
                    packet.meet(lanes, self.halve(node));
                }
            }
            std::mem::swap(list, &mut self.next);
            if !halved {
                return;
            }
        }
    }

    /// Whether a path can touch an area.
    pub(super) fn touches(&self, node: &Node, area: &Rectangle) -> bool {
        let [xs, ys] = self.frame.corners(area);
        let flat = self.flat(node);
        let [width, height] = [xs[1] - xs[0], ys[2] - ys[0]];
        let far = (width * width + height * height).sqrt() * (0.5 + 1e-6) + flat.reach;
        least(&squares(&xs, &ys, flat)) <= far * far
    }

    /// For each corner the nearest known point of the curve: its distances from all corners.
    #[inline(always)]
    fn witnesses(&self, xs: &[f32; 4], ys: &[f32; 4], list: &[Node]) -> [[f32; 4]; 4] {
        let (mut least, mut found) = ([f32::INFINITY; 4], [[0.0; 4]; 2]);
        for node in list {
            for point in self.flat(node).ends() {
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
}

/// Adds a segment to those of the block alone.
#[inline(always)]
fn own(flats: &mut Vec<Flat>, all: &mut Vec<[[f64; 2]; 2]>, frame: &Frame, ends: [[f64; 2]; 2], reach: f64) -> u32 {
    flats.push(Flat::new(frame, ends[0], ends[1], reach));
    all.push(ends);
    OWN + flats.len() as u32 - 1
}

#[inline(always)]
fn flat_of<'a>(paths: &'a Paths, own: &'a [Flat], number: u32) -> &'a Flat {
    if number < OWN { &paths.flats[number as usize] } else { &own[(number - OWN) as usize] }
}

/// Whether some witness is nearer than a path at each corner.
#[inline(always)]
fn is_dominated(reach: f32, squares: &[f32; 4], witnesses: &[[f32; 4]; 4]) -> bool {
    let mut dominated = false;
    for distances in witnesses {
        let mut nearer = true;
        for i in 0..4 {
            let most = distances[i] + reach;
            nearer &= squares[i] > most * most;
        }
        dominated |= nearer;
    }
    dominated
}

/// The points of a least part of a block, with the distances of the nearest known points of the curve.
struct Packet<'a> {
    points: [&'a [f32]; 2],
    squares: [f32; LEAST],
    distances: [f32; LEAST],
}

impl<'a> Packet<'a> {
    #[inline(always)]
    fn new(block: &'a Block, start: usize, reach: f32) -> Self {
        let points = [&block.flat[0].0[start..start + LEAST], &block.flat[1].0[start..start + LEAST]];
        // What is beyond the reach is never nearest.
        let most = reach * reach;
        Self { points, squares: [if most < f32::MAX { most } else { f32::MAX }; LEAST], distances: [0.0; LEAST] }
    }

    /// A point of the curve: no point is farther from the curve than from it.
    #[inline(always)]
    fn meet<L: Lanes>(&mut self, lanes: L, p: [f32; 2]) {
        let p = [lanes.splat(p[0]), lanes.splat(p[1])];
        for i in (0..LEAST).step_by(L::WIDTH) {
            let (x, y) = (lanes.load(&self.points[0][i..]) - p[0], lanes.load(&self.points[1][i..]) - p[1]);
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
    fn can_be_nearest<L: Lanes>(&self, lanes: L, flat: &Flat) -> bool {
        let (a, along) = (flat.start.map(|c| lanes.splat(c)), flat.along.map(|c| lanes.splat(c)));
        let (inverse, reach) = (lanes.splat(flat.inverse), lanes.splat(flat.reach));
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let mut can = false;
        for i in (0..LEAST).step_by(L::WIDTH) {
            let (x, y) = (lanes.load(&self.points[0][i..]) - a[0], lanes.load(&self.points[1][i..]) - a[1]);
            let t = lanes.smaller(lanes.larger((x * along[0] + y * along[1]) * inverse, zero), one);
            let (x, y) = (x - along[0] * t, y - along[1] * t);
            let most = lanes.load(&self.distances[i..]) + reach;
            can |= lanes.any_less(x * x + y * y, most * most);
        }
        can
    }
}

/// Squared distances of the corners from the straight segment of a path.
///
/// Plain loops, here and below: closures would not always become part of a kernel.
#[inline(always)]
fn squares(xs: &[f32; 4], ys: &[f32; 4], flat: &Flat) -> [f32; 4] {
    let Flat { start, along, inverse, .. } = flat;
    let mut squares = [0.0; 4];
    for i in 0..4 {
        let (x, y) = (xs[i] - start[0], ys[i] - start[1]);
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
fn least(of: &[f32; 4]) -> f32 {
    let (a, b) = (if of[1] < of[0] { of[1] } else { of[0] }, if of[3] < of[2] { of[3] } else { of[2] });
    if b < a { b } else { a }
}
