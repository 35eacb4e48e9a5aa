//! Signed distances and nearest elevations of one feature over a block.

use super::{
    Feature,
    block::{Block, LEAST, POINTS, Values},
    index::farthest,
    parity::Parity,
    path::Frame,
    runs::Runs,
    search::{Near, Node, Search},
};
use crate::{
    geometry::{Along, Curve, Edge, Elevation, Rectangle, Shape},
    noise::{Isa, Kernel, Lanes},
};

/// So many paths are halved at once; with more, the part of the block is divided first.
const HALVED: usize = 10;
/// So many edges are compared for a part that could still be divided.
const COMPARED: usize = 8;

/// Edges of which one elevation is known where any of them is nearest.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// First edge and the one after the last.
    edges: [u32; 2],
    /// What the share of the way is measured on.
    line: Edge,
    /// Elevation at the beginning of the way, and its rise over the way.
    elevation: [f64; 2],
    way: Way,
}

#[derive(Clone, Copy, Debug)]
enum Way {
    /// Along the only edge of the group.
    Same,
    /// Along the chord.
    Chord,
    /// Along the only edge, which is one piece of the way: its number, the size of a piece, and whether it runs against the way.
    Piece { number: f64, size: f64, flipped: bool },
}

/// Distances over a block, and room to find them.
pub(super) struct Distances {
    /// Metres, negative inside.
    pub signed: Box<Values>,
    pub elevation: Box<Values>,
    /// Beginnings and lengths of the parts of the block that the feature reaches.
    pub parts: Vec<[usize; 2]>,
    search: Search,
    parity: Parity,
    list: Vec<Node>,
    /// The paths of parts that wait.
    waiting: Vec<Node>,
    edges: Vec<Edge>,
    groups: Vec<Group>,
}

/// What the distance of a feature is made of beside that of its edges.
struct Kind<'a> {
    curve: Option<&'a Curve>,
    closed: bool,
    /// Taken from the distance.
    radius: f64,
    /// Whether the elevation changes.
    slopes: bool,
}

impl Distances {
    /// For the blocks of a window.
    pub(super) fn new(frame: Frame) -> Self {
        Self {
            signed: Values::new(0.0),
            elevation: Values::new(0.0),
            parts: Vec::new(),
            search: Search::new(frame),
            parity: Parity::default(),
            list: Vec::new(),
            waiting: Vec::new(),
            edges: Vec::new(),
            groups: Vec::new(),
        }
    }

    /// Finds the distances of a feature, which has a number of its own, as samples `spacing` metres apart see it; 0 for all detail.
    pub(super) fn find(&mut self, isa: Isa, block: &Block, (number, feature): (u32, &Feature), runs: Option<&Runs>, spacing: f64) {
        let (area, reach) = (block.rectangle(0, POINTS), farthest(feature));
        let kind = match feature.shape() {
            Shape::Point { at, elevation } => {
                self.search.begin_point(*at, elevation.unwrap_or(0.0), reach);
                Kind { curve: None, closed: false, radius: 0.0, slopes: false }
            }
            Shape::Circle { centre, radius, elevation } => {
                self.search.begin_point(*centre, elevation.unwrap_or(0.0), reach + radius);
                Kind { curve: None, closed: false, radius: *radius, slopes: false }
            }
            Shape::Line(curve) | Shape::Polygon(curve) => {
                let closed = matches!(feature.shape(), Shape::Polygon(_));
                self.search.begin(number, curve, runs, &area, reach, spacing);
                if closed {
                    self.parity.begin(curve, runs, &area, spacing);
                }
                Kind { curve: Some(curve), closed, radius: 0.0, slopes: matches!(curve.elevation(), Elevation::Vertices(_)) }
            }
        };
        self.parts.clear();
        isa.run(Divide { distances: self, block, kind });
    }

    /// Makes groups of the edges of the list.
    fn group(&mut self, kind: &Kind) {
        self.edges.clear();
        self.groups.clear();
        let mut last = None;
        for node in &self.list {
            let [a, b] = self.search.ends(node);
            let edge = Edge::new(a, b);
            self.edges.push(edge);
            let end = self.edges.len() as u32;
            let way = kind.curve.map_or(Way::Same, |curve| way(curve, &self.search.chords[node.chord as usize], node, &edge));
            // Where the elevation does not change, all edges are one group, and of one chord all are.
            let one = !kind.slopes || (matches!(way, Way::Chord) && last == Some(node.chord));
            last = Some(node.chord);
            if let (true, Some(group)) = (one, self.groups.last_mut()) {
                group.edges[1] = end;
                continue;
            }
            let near = &self.search.chords[node.chord as usize];
            let [start, finish] = near.chord.ordered(&near.straight);
            self.groups.push(Group { edges: [end - 1, end], line: near.straight, elevation: [start, finish - start], way });
        }
    }
}

/// How the elevation of an edge is found.
fn way(curve: &Curve, near: &Near, node: &Node, edge: &Edge) -> Way {
    let pieces = near.detail.as_ref().map_or(curve.stride(), |detail| 1 << detail.levels);
    if pieces == 1 {
        return Way::Same;
    }
    if curve.way() == Along::Chord {
        return Way::Chord;
    }
    // Paths with detail are counted from the lexicographically first end already.
    let against = near.detail.is_none() && near.straight.flipped;
    let number = if against { pieces - 1 - node.index as usize } else { node.index as usize };
    Way::Piece { number: number as f64, size: 1.0 / pieces as f64, flipped: edge.flipped != against }
}

/// [`Distances::find`]: divides the block until few edges are left in each part.
struct Divide<'a> {
    distances: &'a mut Distances,
    block: &'a Block,
    kind: Kind<'a>,
}

impl Kernel for Divide<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { distances, block, kind } = self;
        distances.waiting.clear();
        distances.waiting.extend_from_slice(&distances.search.roots);
        let mut stack = vec![[0, POINTS, 0, distances.waiting.len()]];
        while let Some([start, count, first, end]) = stack.pop() {
            let area = block.rectangle(start, count);
            distances.list.clear();
            distances.list.extend_from_slice(&distances.waiting[first..end]);
            distances.waiting.truncate(end);
            if count == LEAST {
                distances.search.refine_points(lanes, block, start, &mut distances.list);
                distances.part(lanes, block, &kind, &area, [start, count]);
                continue;
            }
            let straight = distances.search.refine(&area, &mut distances.list, HALVED);
            let many = !straight || distances.list.len() > COMPARED;
            if many || (count > 8 * LEAST && distances.search.leaves(&area, &distances.list)) {
                let first = distances.waiting.len();
                distances.waiting.extend_from_slice(&distances.list);
                let size = if count == 2 * LEAST { LEAST } else { count / 4 };
                let children = (start..start + count).step_by(size).rev();
                stack.extend(children.map(|start| [start, size, first, distances.waiting.len()]));
                continue;
            }
            distances.part(lanes, block, &kind, &area, [start, count]);
        }
    }
}

impl Distances {
    /// Writes the distances of a part from the edges in the list.
    #[inline(always)]
    fn part<L: Lanes>(&mut self, lanes: L, block: &Block, kind: &Kind, area: &Rectangle, [start, count]: [usize; 2]) {
        if self.list.is_empty() && !kind.closed {
            return;
        }
        self.group(kind);
        let range = start..start + count;
        let compare = Compare {
            edges: &self.edges,
            groups: &self.groups,
            slopes: kind.slopes,
            radius: kind.radius,
            points: [&block.xs.0[range.clone()], &block.ys.0[range.clone()]],
            out: [&mut self.signed.0[range.clone()], &mut self.elevation.0[range.clone()]],
        };
        compare.run(lanes);
        if kind.closed {
            let mut signs = [0.0; POINTS];
            let together = !self.list.iter().any(|node| self.search.touches(node, area));
            self.parity.fill(&block.xs.0[range.clone()], &block.ys.0[range.clone()], together, &mut signs[..count]);
            if self.list.is_empty() && signs[0] > 0.0 {
                return;
            }
            for (distance, sign) in self.signed.0[range].iter_mut().zip(&signs) {
                *distance *= sign;
            }
        }
        match self.parts.last_mut() {
            Some([first, length]) if *first + *length == start => *length += count,
            _ => self.parts.push([start, count]),
        }
    }
}

/// The least distance of many points from the same few edges.
struct Compare<'a> {
    edges: &'a [Edge],
    groups: &'a [Group],
    slopes: bool,
    radius: f64,
    points: [&'a [f64]; 2],
    /// Distances and elevations.
    out: [&'a mut [f64]; 2],
}

impl Compare<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { edges, groups, slopes, radius, points: [xs, ys], out: [distances, elevations] } = self;
        let radius = lanes.splat_doubles(radius);
        let level = lanes.splat_doubles(groups.first().map_or(0.0, |group| group.elevation[0]));
        for i in (0..xs.len()).step_by(L::WIDTH) {
            let p = [lanes.load_doubles(&xs[i..]), lanes.load_doubles(&ys[i..])];
            let (mut least, mut elevation) = (lanes.splat_doubles(f64::INFINITY), level);
            for group in groups {
                let (mut nearest, mut share) = (lanes.splat_doubles(f64::INFINITY), lanes.splat_doubles(0.0));
                for edge in &edges[group.edges[0] as usize..group.edges[1] as usize] {
                    let [square, t] = square_and_share(lanes, edge, p);
                    nearest = lanes.smaller_doubles(nearest, square);
                    share = t;
                }
                if slopes {
                    let share = group.share(lanes, share, p);
                    let value = lanes.splat_doubles(group.elevation[0]) + lanes.splat_doubles(group.elevation[1]) * share;
                    elevation = lanes.where_less_doubles(nearest, least, value, elevation);
                }
                least = lanes.smaller_doubles(least, nearest);
            }
            lanes.store_doubles(lanes.sqrt_doubles(least) - radius, &mut distances[i..]);
            lanes.store_doubles(elevation, &mut elevations[i..]);
        }
    }
}

impl Group {
    /// The share of the way, from that of the group's last edge.
    #[inline(always)]
    fn share<L: Lanes>(&self, lanes: L, share: L::Doubles, p: [L::Doubles; 2]) -> L::Doubles {
        match self.way {
            Way::Same => share,
            Way::Chord => square_and_share(lanes, &self.line, p)[1],
            Way::Piece { number, size, flipped } => {
                let share = if flipped { lanes.splat_doubles(1.0) - share } else { share };
                (lanes.splat_doubles(number) + share) * lanes.splat_doubles(size)
            }
        }
    }
}

/// [`Edge::nearest`] of every lane.
#[inline(always)]
fn square_and_share<L: Lanes>(lanes: L, edge: &Edge, [x, y]: [L::Doubles; 2]) -> [L::Doubles; 2] {
    let along = [lanes.splat_doubles(edge.along[0]), lanes.splat_doubles(edge.along[1])];
    let (x, y) = (x - lanes.splat_doubles(edge.start[0]), y - lanes.splat_doubles(edge.start[1]));
    let t = (x * along[0] + y * along[1]) * lanes.splat_doubles(edge.inverse);
    let t = lanes.larger_doubles(lanes.splat_doubles(0.0), t);
    let t = lanes.smaller_doubles(lanes.splat_doubles(1.0), t);
    let (x, y) = (x - along[0] * t, y - along[1] * t);
    [x * x + y * y, t]
}
