//! Ridges, between the waters that there are already.

use super::{
    error::{GenerateError, check},
    plane::{Area, Near, Point, along, crossing, distance, dot, minus, segment_distance, unit},
    random::Stream,
    read::{Water, flat, lines, rings},
    style::Style,
    voronoi::{Edge, Vertex, diagram},
};
use crate::layout::Feature;
use serde::{Deserialize, Serialize};

/// Ridges: the edges of the Voronoi diagram of rivers, lakes and shores that cross none of them, and so run between their basins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ridges {
    /// The distance of the places along the waters that the diagram is made of, 1 … 1,000,000 m: about a quarter of the rivers' spacing.
    pub step: f64,
    /// How steeply ridges rise above the nearest water: metres of height per metre of distance, 0.001 … 5.
    pub slope: f64,
    /// How much peaks and passes differ, as a share 0 … 0.9 of the ridge's height above the water.
    pub variation: f64,
    /// How near to water a ridge may come, in steps, 0.05 … 10.
    pub clearance: f64,
    /// The shortest spur, in steps, 0 … 100.
    pub spur: f64,
}

impl Default for Ridges {
    fn default() -> Self {
        Ridges { step: 160.0, slope: 0.45, variation: 0.25, clearance: 0.7, spur: 2.2 }
    }
}

/// Places of a diagram at most.
const MOST_PLACES: usize = 2_000_000;
/// How far a ridge may leave the edges of the diagram when it is simplified, in steps.
const SIMPLIFY: f64 = 0.12;
/// The cosine of the greatest angle between two edges of one ridge.
const STRAIGHT: f64 = core::f64::consts::FRAC_1_SQRT_2;
/// Two places count as two sides of a ridge when they are this far apart, as a multiple of their distance from it: 60 degrees as seen from the ridge.
const APART: f64 = 1.0;

/// Waters as places along them.
#[derive(Default)]
struct Places {
    at: Vec<Point>,
    elevation: Vec<f64>,
    /// Pairs of places that follow each other along a water, in ascending order.
    links: Vec<[usize; 2]>,
}

impl Ridges {
    fn check(&self) -> Result<(), GenerateError> {
        check("ridges.step", self.step, 1.0..=1e6)?;
        check("ridges.slope", self.slope, 0.001..=5.0)?;
        check("ridges.variation", self.variation, 0.0..=0.9)?;
        check("ridges.clearance", self.clearance, 0.05..=10.0)?;
        check("ridges.spur", self.spur, 0.0..=100.0)
    }

    /// Ridges on the polygons of `land`, between its shores and the `waters`: rivers, and lakes, in which no ridge stands.
    ///
    /// # Errors
    /// A parameter outside its range, a land that is no polygon, a water without elevations, or attributes that do not fit.
    pub fn features(&self, land: &[Feature], waters: &[Feature], seed: u64, style: &Style) -> Result<Vec<Feature>, GenerateError> {
        self.check()?;
        for (place, features) in [("ridges.land", land), ("ridges.waters", waters)] {
            for (index, feature) in features.iter().enumerate() {
                if feature.shape().curve().is_none() || !feature.shape().has_elevation() {
                    return Err(GenerateError::Seed { place, index, reason: "must be a line or a polygon with elevations at its vertices" });
                }
            }
        }
        let area = |features: &[Feature]| {
            let rings: Vec<Vec<Point>> = rings(features).iter().map(|ring| flat(ring)).collect();
            Area::of(rings.iter().map(Vec::as_slice), 4.0 * self.step)
        };
        let mut all = lines(land);
        all.extend(lines(waters));
        let crests = self.between(&all, &area(land), &area(waters), seed)?;
        crests.iter().flat_map(|crest| arms(crest)).map(|arm| style.feature(arm, false, &style.attributes, style.detail)).collect()
    }

    /// Ridges as lines on the land, outside the ponds; the elevations are the crest's.
    fn between(&self, waters: &[Water], land: &Area, ponds: &Area, seed: u64) -> Result<Vec<Vec<[f64; 3]>>, GenerateError> {
        let places = self.places(waters)?;
        let (vertices, edges) = diagram(&places.at);
        let mut stream = Stream::new(seed, "ridges");
        let heights: Vec<f64> = vertices.iter().map(|vertex| self.height(vertex, &places, &mut stream)).collect();
        let shores = Near::of(places.links.iter().map(|&[a, b]| [places.at[a], places.at[b]]), self.step);
        let stands: Vec<bool> = vertices
            .iter()
            .map(|vertex| {
                let clear = distance(vertex.at, places.at[vertex.places[0]]) >= self.clearance * self.step;
                clear && land.contains(vertex.at) && !ponds.contains(vertex.at)
            })
            .collect();
        let kept = edges.into_iter().filter(|edge| {
            edge.ends.iter().all(|&end| stands[end]) && divides(edge, &vertices, &places) && {
                let segment = edge.ends.map(|end| vertices[end].at);
                !shores.around(segment, 0.0).into_iter().any(|number| crossing(segment, shores.segments()[number]).is_some())
            }
        });
        let mut graph = Graph::new(kept, &vertices, &heights);
        graph.join(0.3 * self.step);
        graph.prune(self.spur * self.step);
        Ok(graph.lines().into_iter().map(|line| simplify(&line, SIMPLIFY * self.step)).collect())
    }

    /// Places along the waters, their ends included, no further apart than the step.
    fn places(&self, waters: &[Water]) -> Result<Places, GenerateError> {
        let mut all: Vec<[f64; 3]> = Vec::new();
        let mut links = Vec::new();
        for water in waters {
            let first = all.len();
            for (i, &a) in water.line.iter().enumerate() {
                let next = if water.closed { Some(water.line[(i + 1) % water.line.len()]) } else { water.line.get(i + 1).copied() };
                all.push(a);
                let Some(b) = next else { continue };
                let pieces = (distance([a[0], a[1]], [b[0], b[1]]) / self.step).ceil().max(1.0);
                let expected = all.len() as f64 + pieces;
                if expected > MOST_PLACES as f64 {
                    return Err(GenerateError::TooMany { place: "ridges.step", expected, limit: MOST_PLACES });
                }
                all.extend((1..pieces as usize).map(|k| [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * (k as f64 / pieces))));
            }
            links.extend((first + 1..all.len()).map(|k| [k - 1, k]));
            if water.closed && all.len() > first {
                links.push([all.len() - 1, first]);
            }
        }
        Ok(Places::merge(&all, links))
    }

    /// The crest's elevation at a vertex: above the highest of the nearest waters, by its distance from them.
    fn height(&self, vertex: &Vertex, places: &Places, stream: &mut Stream) -> f64 {
        let water = vertex.places.iter().map(|&place| places.elevation[place]).fold(f64::NEG_INFINITY, f64::max);
        let away = distance(vertex.at, places.at[vertex.places[0]]);
        water + self.slope * away * (1.0 + self.variation * stream.between(-1.0, 1.0))
    }
}

/// Whether an edge has water on two sides rather than two places of one bank.
fn divides(edge: &Edge, vertices: &[Vertex], places: &Places) -> bool {
    let [a, b] = edge.places;
    let span = distance(places.at[a], places.at[b]);
    let nearest = segment_distance(places.at[a], edge.ends.map(|end| vertices[end].at));
    places.links.binary_search(&[a.min(b), a.max(b)]).is_err() && span >= APART * nearest
}

impl Places {
    /// Places where every position occurs once.
    fn merge(all: &[[f64; 3]], links: Vec<[usize; 2]>) -> Self {
        let mut order: Vec<usize> = (0..all.len()).collect();
        let compare = |a: &usize, b: &usize| all[*a][0].total_cmp(&all[*b][0]).then(all[*a][1].total_cmp(&all[*b][1]));
        order.sort_by(compare);
        let mut names = vec![0; all.len()];
        let mut places = Places::default();
        for (k, &index) in order.iter().enumerate() {
            let [x, y, elevation] = all[index];
            if k > 0 && places.at.last() == Some(&[x, y]) {
                let last = places.elevation.len() - 1;
                places.elevation[last] = places.elevation[last].max(elevation);
            } else {
                places.at.push([x, y]);
                places.elevation.push(elevation);
            }
            names[index] = places.at.len() - 1;
        }
        places.links = links.into_iter().map(|[a, b]| [names[a].min(names[b]), names[a].max(names[b])]).filter(|[a, b]| a != b).collect();
        places.links.sort_unstable();
        places.links.dedup();
        places
    }
}

/// Crests as a graph.
struct Graph {
    at: Vec<[f64; 3]>,
    neighbours: Vec<Vec<usize>>,
}

impl Graph {
    fn new(edges: impl Iterator<Item = Edge>, vertices: &[Vertex], heights: &[f64]) -> Self {
        let at = vertices.iter().zip(heights).map(|(vertex, &height)| [vertex.at[0], vertex.at[1], height]).collect();
        let mut graph = Graph { at, neighbours: vec![Vec::new(); vertices.len()] };
        for Edge { ends: [a, b], .. } in edges {
            graph.link(a, b);
        }
        graph
    }

    fn link(&mut self, a: usize, b: usize) {
        if a != b && !self.neighbours[a].contains(&b) {
            self.neighbours[a].push(b);
            self.neighbours[b].push(a);
        }
    }

    fn unlink(&mut self, a: usize, b: usize) {
        self.neighbours[a].retain(|&other| other != b);
        self.neighbours[b].retain(|&other| other != a);
    }

    fn length(&self, a: usize, b: usize) -> f64 {
        distance([self.at[a][0], self.at[a][1]], [self.at[b][0], self.at[b][1]])
    }

    /// Draws vertices nearer than `least` together, so that no ridge is a mere point.
    fn join(&mut self, least: f64) {
        for a in 0..self.at.len() {
            while let Some(b) = self.neighbours[a].iter().copied().find(|&b| self.length(a, b) < least) {
                let others = self.neighbours[b].clone();
                for other in others {
                    self.unlink(b, other);
                    self.link(a, other);
                }
            }
        }
    }

    /// The vertices from `a` over `b` to the next end or fork.
    fn follow(&self, a: usize, b: usize) -> Vec<usize> {
        let mut line = vec![a, b];
        let (mut from, mut here) = (a, b);
        while let [one, two] = self.neighbours[here][..] {
            (from, here) = (here, if one == from { two } else { one });
            line.push(here);
            if here == a {
                break;
            }
        }
        line
    }

    /// Takes away loose ends shorter than `least`, shorter ones first decided by index alone: one round over the ends that there are.
    fn prune(&mut self, least: f64) {
        for start in 0..self.at.len() {
            let [next] = self.neighbours[start][..] else { continue };
            let line = self.follow(start, next);
            if line.windows(2).map(|pair| self.length(pair[0], pair[1])).sum::<f64>() < least {
                for pair in line.windows(2) {
                    self.unlink(pair[0], pair[1]);
                }
            }
        }
    }

    /// The ridges between ends and forks, then those that close on themselves.
    fn lines(mut self) -> Vec<Vec<[f64; 3]>> {
        let mut lines = Vec::new();
        for forks in [true, false] {
            for start in 0..self.at.len() {
                while let Some(&next) = self.neighbours[start].first().filter(|_| !forks || self.neighbours[start].len() != 2) {
                    let line = self.follow(start, next);
                    for pair in line.windows(2) {
                        self.unlink(pair[0], pair[1]);
                    }
                    lines.push(line.into_iter().map(|vertex| self.at[vertex]).collect());
                }
            }
        }
        lines
    }
}

/// Cuts a crest wherever it turns by more than 45 degrees. Between the arms of one ridge the height would jump from that of one arm to that of the other; those of two
/// are merged.
fn arms(crest: &[[f64; 3]]) -> Vec<&[[f64; 3]]> {
    let (mut arms, mut first, mut directions) = (Vec::new(), 0, Vec::new());
    for (k, pair) in crest.windows(2).enumerate() {
        let direction = unit(minus([pair[1][0], pair[1][1]], [pair[0][0], pair[0][1]]));
        if directions.iter().any(|&other| dot(other, direction) < STRAIGHT) {
            arms.push(&crest[first..=k]);
            first = k;
            directions.clear();
        }
        directions.push(direction);
    }
    arms.push(&crest[first..]);
    arms
}

/// Leaves out vertices that lie nearer than `tolerance` to the line without them (D. Douglas and T. Peucker 1973), heights included.
fn simplify(line: &[[f64; 3]], tolerance: f64) -> Vec<[f64; 3]> {
    let mut kept = vec![false; line.len()];
    let mut spans = vec![(0, line.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        (kept[first], kept[last]) = (true, true);
        let worst = (first + 1..last).map(|k| (deviation(line[k], [line[first], line[last]]), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, k)) = worst.filter(|worst| worst.0 > tolerance) {
            spans.extend([(first, k), (k, last)]);
        }
    }
    line.iter().zip(kept).filter_map(|(&p, kept)| kept.then_some(p)).collect()
}

/// The distance of a vertex from a segment in the plane, or in height where that is more.
fn deviation(p: [f64; 3], [a, b]: [[f64; 3]; 2]) -> f64 {
    let segment = [[a[0], a[1]], [b[0], b[1]]];
    let t = super::plane::nearest([p[0], p[1]], segment);
    let flat = distance([p[0], p[1]], along(segment[0], t, minus(segment[1], segment[0])));
    flat.max((p[2] - (a[2] + t * (b[2] - a[2]))).abs())
}
