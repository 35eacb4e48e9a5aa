//! Rivers, grown inland from the coast.

use super::{
    error::{GenerateError, check},
    network::{Network, Profile},
    plane::{Area, Near, Point, Segment, along, cross, crossing, distance, dot, gap, minus, segment_distance, unit},
    random::Stream,
};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Rivers grown inland from the coast by Poisson-disc sampling (R. Bridson 2007): trees whose water falls all the way to the sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rivers {
    /// The least distance between two points of rivers, 1 … 1,000,000 m; rivers keep about this distance from each other.
    pub spacing: f64,
    /// The least distance between two mouths, as a multiple 1 … 100 of the spacing of what grows from them.
    pub mouths: f64,
    /// Rounds of growth, 1 … 8: each has half the spacing of the one before, the last has `spacing`. With one round basins are narrow (Hack's exponent 0.65), with
    /// several they are as compact as real ones: trunks first, then tributaries between them.
    pub rounds: u32,
    /// Points tried round each point before it is left, 1 … 200.
    pub attempts: u32,
    /// The slope of a river at its source, 0.0001 … 1.
    pub source_slope: f64,
    /// How fast slopes fall with the water that has joined, 0 … 1: slope is `source_slope · upstream^-concavity` (J. J. Flint 1974; real rivers have 0.3 to 0.6).
    pub concavity: f64,
}

impl Default for Rivers {
    fn default() -> Self {
        Rivers { spacing: 650.0, mouths: 2.0, rounds: 4, attempts: 40, source_slope: 0.06, concavity: 0.4 }
    }
}

/// Points of rivers at most.
const MOST_NODES: usize = 200_000;
/// The longest step from a point to the next, in spacings.
const LONGEST: f64 = 1.5;
/// How near a river may come to another, in spacings.
const CLEARANCE: f64 = 0.6;
/// The cosine of the least angle between two rivers that join.
const JOIN: f64 = 0.6;
/// The cosine of the least angle between the ways up and down from a point.
const BEND: f64 = -0.2;
/// How far the middle of a piece moves aside between two rounds, as a share of its length: less than half of what keeps pieces apart.
const SWAY: f64 = 0.1;
/// Places that fit a step, of which the straightest is taken.
const CHOICES: u32 = 3;

impl Rivers {
    pub(super) fn check(&self) -> Result<(), GenerateError> {
        check("rivers.spacing", self.spacing, 1.0..=1e6)?;
        check("rivers.mouths", self.mouths, 1.0..=100.0)?;
        check("rivers.rounds", f64::from(self.rounds), 1.0..=8.0)?;
        check("rivers.attempts", f64::from(self.attempts), 1.0..=200.0)?;
        check("rivers.source_slope", self.source_slope, 1e-4..=1.0)?;
        check("rivers.concavity", self.concavity, 0.0..=1.0)
    }

    pub(super) fn profile(&self) -> Profile {
        Profile { source_slope: self.source_slope, concavity: self.concavity }
    }

    /// Grows the trees on the lands inside the rings, from the shore and from rivers drawn by hand; the third coordinate is the shore's elevation.
    pub(super) fn grow(&self, rings: &[Vec<[f64; 3]>], drawn: &[Vec<Point>], seed: u64) -> Result<Network, GenerateError> {
        self.check()?;
        let flat: Vec<Vec<Point>> = rings.iter().map(|ring| ring.iter().map(|p| [p[0], p[1]]).collect()).collect();
        let land = Area::of(flat.iter().map(Vec::as_slice), self.spacing);
        let [low, high] = land.bounds();
        let expected = (high[0] - low[0]).max(0.0) * (high[1] - low[1]).max(0.0) / (self.spacing * self.spacing);
        if expected > MOST_NODES as f64 {
            return Err(GenerateError::TooMany { place: "rivers.spacing", expected, limit: MOST_NODES });
        }
        let mut growth = Growth {
            rivers: self,
            spacing: self.spacing,
            taken: Near::new(land.bounds(), self.spacing),
            shore: vertices(rings, &land, self.spacing),
            land,
            owners: Vec::new(),
            network: Network::default(),
            branches: Vec::new(),
            coasts: Vec::new(),
            drawn: Vec::new(),
            stream: Stream::new(seed, "rivers"),
        };
        for line in drawn {
            growth.draw(line);
        }
        growth.drawn = vec![true; growth.network.nodes.len()];
        for round in (0..self.rounds).rev() {
            growth.spacing = self.spacing * f64::from(1 << round);
            growth.open_mouths();
            growth.spread();
            if round > 0 {
                growth.halve();
            }
        }
        let mut network = growth.network;
        network.drop_dry_mouths();
        network.sort();
        network.accumulate();
        Ok(network)
    }
}

/// The vertices of the shore before and after a mouth.
type Coast = [Point; 2];

/// A vertex of the shore.
struct ShoreVertex {
    at: [f64; 3],
    coast: Coast,
    /// -2 at the head of a narrow bay, 2 at the tip of a cape.
    cape: f64,
}

fn vertices(rings: &[Vec<[f64; 3]>], land: &Area, spacing: f64) -> Vec<ShoreVertex> {
    let corner = |ring: &[[f64; 3]], i: usize| {
        let at = |k: usize| [ring[k % ring.len()][0], ring[k % ring.len()][1]];
        let (before, here, after) = (at(i + ring.len() - 1), at(i), at(i + 1));
        let sides = [unit(minus(before, here)), unit(minus(after, here))];
        // Halfway between the two edges lies the sea in a bay, the land at a cape.
        let between = along(here, 1e-3 * spacing, unit([sides[0][0] + sides[1][0], sides[0][1] + sides[1][1]]));
        let sharpness = 1.0 + dot(sides[0], sides[1]);
        ShoreVertex { at: ring[i], coast: [before, after], cape: if land.contains(between) { sharpness } else { -sharpness } }
    };
    rings.iter().flat_map(|ring| (0..ring.len()).map(|i| corner(ring, i))).collect()
}

/// Trees that grow.
struct Growth<'a> {
    rivers: &'a Rivers,
    /// The spacing of this round.
    spacing: f64,
    land: Area,
    shore: Vec<ShoreVertex>,
    /// Every piece of river so far; mouths are pieces without length.
    taken: Near,
    /// The lower and the upper node of every piece.
    owners: Vec<[usize; 2]>,
    network: Network,
    /// The directions in which rivers leave every node; the first leads down but for mouths.
    branches: Vec<Vec<Point>>,
    /// The coast at every node that is a mouth.
    coasts: Vec<Option<Coast>>,
    /// Which of the first nodes were drawn by hand.
    drawn: Vec<bool>,
    stream: Stream,
}

impl Growth<'_> {
    /// Chooses mouths among the vertices of the shore: bays first, then by lot, none too near to another.
    fn open_mouths(&mut self) {
        let mut order: Vec<(f64, usize)> = self.shore.iter().enumerate().map(|(i, vertex)| (vertex.cape, i)).collect();
        for (rank, _) in &mut order {
            *rank += self.stream.between(0.0, 0.5);
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let apart = self.rivers.mouths * self.spacing;
        for (_, index) in order {
            let [x, y, elevation] = self.shore[index].at;
            let alone = self.network.nodes.iter().zip(&self.coasts).all(|(node, coast)| coast.is_none() || distance(node.at, [x, y]) >= apart);
            if alone {
                let mouth = self.place([x, y], None, elevation);
                self.coasts[mouth] = Some(self.shore[index].coast);
            }
        }
    }

    fn node_at(&self, p: Point) -> Option<usize> {
        self.network.nodes.iter().position(|node| node.at == p)
    }

    /// Takes over a river drawn by hand: from the end that joins one drawn before it or that lies nearer to the shore, to which it is led on.
    fn draw(&mut self, line: &[Point]) {
        let to_shore = |p: Point| {
            let vertices = self.shore.iter().enumerate().map(|(i, vertex)| (distance([vertex.at[0], vertex.at[1]], p), i));
            vertices.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let [Some(&first), Some(&last)] = [line.first(), line.last()] else { return };
        let [Some(start), Some(end)] = [to_shore(first), to_shore(last)] else { return };
        let turned = self.node_at(first).is_none() && (self.node_at(last).is_some() || end.0 < start.0);
        let (lower, (_, shore)) = if turned { (last, end) } else { (first, start) };
        let [x, y, elevation] = self.shore[shore].at;
        let mut node = if let Some(node) = self.node_at(lower).or_else(|| self.node_at([x, y])) {
            node
        } else {
            let mouth = self.place([x, y], None, elevation);
            self.coasts[mouth] = Some(self.shore[shore].coast);
            mouth
        };
        for k in 0..line.len() {
            let at = line[if turned { line.len() - 1 - k } else { k }];
            if at != self.network.nodes[node].at {
                node = self.place(at, Some(node), self.network.nodes[node].elevation);
            }
        }
    }

    /// Adds a node and the piece of river from it to its parent.
    fn place(&mut self, at: Point, parent: Option<usize>, elevation: f64) -> usize {
        let node = self.network.add(at, parent, elevation);
        self.coasts.push(None);
        self.branches.push(Vec::new());
        self.connect(node);
        node
    }

    /// Takes the ground between a node and its parent.
    fn connect(&mut self, node: usize) {
        let at = self.network.nodes[node].at;
        let parent = self.network.nodes[node].parent.unwrap_or(node);
        let from = self.network.nodes[parent].at;
        self.taken.insert([from, at]);
        self.owners.push([parent, node]);
        if parent != node {
            let up = unit(minus(at, from));
            self.branches[parent].push(up);
            self.branches[node].insert(0, [-up[0], -up[1]]);
        }
    }

    /// Halves every piece of river, with a bend in its middle, for the next round to branch from; mouths that stayed dry are forgotten.
    fn halve(&mut self) {
        self.drawn.resize(self.network.nodes.len(), false);
        for node in 0..self.network.nodes.len() {
            let Some(parent) = self.network.nodes[node].parent else { continue };
            let (from, to) = (self.network.nodes[parent].at, self.network.nodes[node].at);
            let piece = minus(to, from);
            // A river drawn by hand keeps its course.
            let is_drawn = self.drawn[node];
            let sway = if is_drawn { 0.0 } else { self.stream.between(-SWAY, SWAY) };
            let middle = along(along(from, 0.5, piece), sway, [-piece[1], piece[0]]);
            let elevation = self.network.nodes[parent].elevation;
            self.network.nodes[node].parent = Some(self.network.add(middle, Some(parent), elevation));
            self.drawn.push(is_drawn);
            self.coasts.push(None);
        }
        let wet = self.network.drop_dry_mouths();
        let (mut with_coast, mut with_hand) = (wet.iter(), wet.iter());
        self.coasts.retain(|_| with_coast.next() == Some(&true));
        self.drawn.retain(|_| with_hand.next() == Some(&true));
        self.taken = Near::new(self.land.bounds(), self.rivers.spacing);
        self.owners.clear();
        self.branches = vec![Vec::new(); self.network.nodes.len()];
        for node in 0..self.network.nodes.len() {
            self.connect(node);
        }
    }

    /// Grows from every node in turn, the oldest first, until no node has room beside it. So no river runs far before all others have had their tributaries.
    fn spread(&mut self) {
        let mut active: VecDeque<usize> = (0..self.network.nodes.len()).collect();
        for k in (1..active.len()).rev() {
            active.swap(k, self.stream.index(k + 1));
        }
        while let Some(node) = active.pop_front() {
            if let Some(child) = self.step_from(node) {
                active.extend([node, child]);
            }
        }
    }

    /// Tries places round a node; of the first few that fit, the one straightest up the river becomes its child.
    fn step_from(&mut self, node: usize) -> Option<usize> {
        let is_mouth = self.coasts[node].is_some();
        if self.branches[node].len() >= if is_mouth { 1 } else { 3 } {
            return None;
        }
        let from = self.network.nodes[node].at;
        let up = self.branches[node].first().map_or([0.0, 0.0], |down| [-down[0], -down[1]]);
        let mut best: Option<(f64, Point)> = None;
        let mut choices = CHOICES;
        for _ in 0..self.rivers.attempts {
            let (direction, length) = (self.stream.direction(), self.spacing * self.stream.between(1.0, LONGEST));
            let piece = [from, along(from, length, direction)];
            let fits = if is_mouth { self.leaves_coast(node, piece) } else { self.leaves_river(node, direction) };
            if !fits || !self.is_free(node, piece) {
                continue;
            }
            let straightness = dot(direction, up);
            if best.is_none_or(|best| best.0 < straightness) {
                best = Some((straightness, piece[1]));
            }
            choices -= 1;
            if choices == 0 {
                break;
            }
        }
        let (_, at) = best?;
        Some(self.place(at, Some(node), self.network.nodes[node].elevation))
    }

    /// Whether a direction turns away enough from the rivers that meet at a node already.
    fn leaves_river(&self, node: usize, direction: Point) -> bool {
        let branches = &self.branches[node];
        // The first branch of a node leads down; the others lead up.
        branches.iter().enumerate().all(|(i, &branch)| dot(branch, direction) <= if i == 0 { BEND } else { JOIN })
    }

    /// Whether a piece of river leaves its mouth well inland of both edges of the shore.
    fn leaves_coast(&self, mouth: usize, [from, to]: Segment) -> bool {
        let direction = unit(minus(to, from));
        self.coasts[mouth].iter().flatten().all(|&neighbour| dot(unit(minus(neighbour, from)), direction) < 0.8)
    }

    /// Whether a piece of river lies on land and keeps clear of the shore and of all other rivers.
    fn is_free(&self, node: usize, piece: Segment) -> bool {
        let spacing = self.spacing;
        let [from, to] = piece;
        if !self.land.contains(to) || self.land.edge_within([to, to], CLEARANCE * spacing) || self.meets_shore(node, piece) {
            return false;
        }
        self.taken.around(piece, spacing).into_iter().all(|number| {
            let (other, owners) = (self.taken.segments()[number], self.owners[number]);
            if distance(other[1], to) < spacing {
                return false;
            }
            if owners.contains(&node) {
                // It meets this piece at the node; only its far end must keep clear.
                let far = if owners[0] == node { other[1] } else { other[0] };
                return far == from || (segment_distance(far, piece) >= CLEARANCE * spacing && segment_distance(to, other) >= CLEARANCE * spacing);
            }
            gap(piece, other) >= CLEARANCE * spacing
        })
    }

    /// Whether a piece of river comes too near to the shore. At its mouth it may, in a wedge that keeps away from both sides.
    fn meets_shore(&self, node: usize, piece: Segment) -> bool {
        let Some(coast) = &self.coasts[node] else { return self.land.edge_within(piece, 0.5 * CLEARANCE * self.spacing) };
        let (mouth, along_piece) = (piece[0], minus(piece[1], piece[0]));
        self.land.edges().around(piece, self.spacing).into_iter().any(|number| {
            let edge = self.land.edges().segments()[number];
            if edge.contains(&mouth) {
                return false;
            }
            let narrow = edge.iter().any(|&p| {
                let offset = minus(p, mouth);
                !coast.contains(&p) && dot(offset, along_piece) > 0.0 && cross(along_piece, offset).abs() < 0.4 * dot(offset, along_piece)
            });
            crossing(piece, edge).is_some() || (narrow && gap(piece, edge) < CLEARANCE * self.spacing)
        })
    }
}
