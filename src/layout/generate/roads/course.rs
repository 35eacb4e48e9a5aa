//! The course of roads: smoothed between fixed points, graded over the true ground, with bridges where there is water.

use super::{
    super::plane::{Point, along, distance, minus, unit},
    GenerateError, MOST_VERTICES, Road, Roads,
    lattice::Lattice,
    search::{Known, Pair, Terms, pair},
};
use crate::geometry::{Filter, Source, Surface, Wanted, Window};
use std::collections::{BTreeMap, BTreeSet};

/// How far smoothing may move a road from the way that was found, in spacings of the lattice.
const FARTHEST: f64 = 0.75;
/// How far smoothing works along the road, in spacings.
const SMOOTH: f64 = 0.8;
/// Rounds of smoothing at most.
const MOST_ROUNDS: f64 = 400.0;

/// The ground and the water at a place as samples of a spacing see them; `spacing` 0 for the function as it is.
fn sample(source: &impl Source, [x, y]: Point, spacing: f64) -> [f64; 3] {
    let (spacing, filter) = if spacing > 0.0 { (spacing, Filter::Band) } else { (1.0, Filter::Exact) };
    let Ok(window) = Window::point(x, y, spacing, filter) else { return [0.0; 3] };
    let mut surface = Surface::with(&window, Wanted { water: true, ..Wanted::default() });
    source.sample(&window, &mut surface);
    [surface.elevation[0], surface.water_depth[0], surface.water_cover[0]].map(f64::from)
}

/// The elevation of the ground at a place.
pub(super) fn ground(source: &impl Source, p: Point) -> f64 {
    sample(source, p, 0.0)[0]
}

/// What is needed to lay out courses.
pub(super) struct Courses<'a, S> {
    roads: &'a Roads,
    source: &'a S,
    lattice: &'a Lattice,
    /// Metres between vertices at most.
    step: f64,
    /// The water at the vertices of pieces that were looked at, which ways over and over lead over.
    seen: BTreeMap<Pair, Vec<Option<f64>>>,
}

/// A line between two fixed points.
struct Course {
    line: Vec<Point>,
    /// Vertices that stay where they are.
    pinned: Vec<bool>,
    routes: Vec<[usize; 2]>,
    /// Elevations of both ends.
    ends: [f64; 2],
}

/// A course with its elevations.
struct Graded {
    line: Vec<Point>,
    stations: Stations,
    /// First and last vertex of every bridge.
    bridges: Vec<[usize; 2]>,
    heights: Vec<f64>,
    /// The deepest cutting or highest embankment.
    deepest: f64,
}

/// What lies at the vertices of a course.
#[derive(Default)]
struct Stations {
    /// Metres along the line.
    at: Vec<f64>,
    ground: Vec<f64>,
    /// The surface of the water, where there is some within the road's reach.
    water: Vec<Option<f64>>,
}

impl<'a, S: Source> Courses<'a, S> {
    pub(super) fn new(roads: &'a Roads, source: &'a S, lattice: &'a Lattice) -> Self {
        Self { roads, source, lattice, step: roads.step(lattice.spacing), seen: BTreeMap::new() }
    }

    /// The pieces of a way that belong to bridges which are too long as the water truly lies.
    pub(super) fn too_long(&mut self, terms: &Terms, known: &Known, way: &[usize]) -> Vec<Pair> {
        let (mut line, mut owners, mut water) = (Vec::new(), Vec::new(), Vec::new());
        for step in way.windows(2) {
            let ends = [terms.split(step[0]).0, terms.split(step[1]).0];
            let name = pair(ends[0], ends[1]);
            let mut piece = self.divided(self.lattice.at(name[0]), self.lattice.at(name[1]));
            let mut wet = match self.seen.remove(&name) {
                Some(wet) => wet,
                None => self.water(&piece),
            };
            self.seen.insert(name, wet.clone());
            if name != ends {
                piece.reverse();
                wet.reverse();
            }
            owners.extend(piece.iter().map(|_| name));
            line.extend(piece);
            water.extend(wet);
        }
        let mut stations = Stations { water, ..Stations::default() };
        stations.measure(&line);
        stations.spread(self.roads.approach(self.lattice.spacing));
        let stretches = stations.wet().into_iter().filter(|&[from, to]| stations.at[to] - stations.at[from] > self.roads.bridge);
        let refused: BTreeSet<Pair> = stretches.flat_map(|[from, to]| owners[from..=to].iter().copied()).collect();
        refused.into_iter().filter(|piece| !known.pieces.contains_key(piece)).collect()
    }

    /// A straight line with vertices no further apart than the step.
    fn divided(&self, a: Point, b: Point) -> Vec<Point> {
        let count = (distance(a, b) / self.step).ceil().max(1.0);
        (0..=count as usize).map(|k| if k as f64 == count { b } else { along(a, k as f64 / count, minus(b, a)) }).collect()
    }

    /// The roads of a network.
    pub(super) fn roads(&self, terms: &Terms, known: &Known) -> Result<Vec<Road>, GenerateError> {
        let mut roads = Vec::new();
        let mut vertices = 0;
        for course in self.courses(terms, known) {
            vertices += course.line.len();
            if vertices > MOST_VERTICES {
                return Err(GenerateError::TooMany { place: "roads.places", expected: vertices as f64, limit: MOST_VERTICES });
            }
            roads.extend(self.built(&course));
        }
        Ok(roads)
    }

    /// The lines between places and forks, in the order of their first points.
    fn courses(&self, terms: &Terms, known: &Known) -> Vec<Course> {
        let mut beside: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &[a, b] in known.pieces.keys() {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        }
        let is_end = |node: usize| self.lattice.is_place(node) || beside[&node].len() != 2;
        let mut courses = Vec::new();
        for (&start, nexts) in beside.iter().filter(|&(&node, _)| is_end(node)) {
            for &next in nexts {
                let mut way = vec![start, next];
                while !is_end(way[way.len() - 1]) {
                    let [before, here] = [way[way.len() - 2], way[way.len() - 1]];
                    way.extend(beside[&here].iter().copied().find(|&node| node != before));
                }
                // Every line is met from both of its ends.
                let back = way[way.len() - 1];
                if start < back || (start == back && next < way[way.len() - 2]) {
                    courses.push(self.course(terms, known, &way));
                }
            }
        }
        courses
    }

    fn course(&self, terms: &Terms, known: &Known, way: &[usize]) -> Course {
        let (mut line, mut pinned) = (Vec::new(), Vec::new());
        for step in way.windows(2) {
            let piece = self.divided(self.lattice.at(step[0]), self.lattice.at(step[1]));
            let fixed = !piece.iter().all(|&p| self.lattice.is_dry_at(p));
            let first = usize::from(!line.is_empty());
            if let (Some(last), true) = (pinned.last_mut(), fixed) {
                *last = true;
            }
            pinned.extend(piece[first..].iter().map(|_| fixed));
            line.extend(&piece[first..]);
        }
        let last = line.len() - 1;
        (pinned[0], pinned[last]) = (true, true);
        let ends = [way[0], way[way.len() - 1]].map(|node| known.elevation(terms, node));
        Course { line, pinned, routes: known.pieces[&pair(way[0], way[1])].clone(), ends }
    }

    /// The road along a course, in pieces between bridges.
    fn built(&self, course: &Course) -> Vec<Road> {
        let Graded { line, stations, bridges, heights, .. } = self.best(course);
        let mut roads = Vec::new();
        let mut from = 0;
        for [first, last] in bridges.iter().copied().chain([[line.len() - 1, 0]]) {
            for (range, is_bridge) in [((from, first), false), ((first, last), true)] {
                if range.1 > range.0 {
                    roads.push(road(&line, &heights, &stations, range, is_bridge, &course.routes));
                }
            }
            from = last;
        }
        roads
    }

    /// The course with as much smoothing as keeps cuttings and embankments to what the search allows, or to the least that some smoothing gives.
    fn best(&self, course: &Course) -> Graded {
        let far = SMOOTH * self.lattice.spacing / self.step;
        let mut rounds = (2.0 * far * far).min(MOST_ROUNDS) as usize;
        let mut best: Option<Graded> = None;
        loop {
            let line = self.smoothed(course, rounds);
            let length: f64 = line.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
            // The way as it was found is long enough to climb between its ends, smoothing may make it too short.
            if rounds == 0 || length * self.roads.grade >= (course.ends[1] - course.ends[0]).abs() {
                let stations = self.stations(&line);
                let bridges = stations.wet();
                let heights = self.graded(course, &stations, &bridges);
                let dry = (0..line.len()).filter(|&i| stations.water[i].is_none());
                let deepest = dry.map(|i| (heights[i] - stations.ground[i]).abs()).fold(0.0, f64::max);
                if best.as_ref().is_none_or(|best| deepest < best.deepest) {
                    best = Some(Graded { line, stations, bridges, heights, deepest });
                }
            }
            match best {
                Some(best) if rounds == 0 || best.deepest <= self.roads.deepest() => return best,
                _ => rounds /= 4,
            }
        }
    }

    /// The line after rounds of smoothing: every vertex moves towards the middle of its neighbours, unless that leads too far away or to water.
    fn smoothed(&self, course: &Course, rounds: usize) -> Vec<Point> {
        let mut line = course.line.clone();
        for _ in 0..rounds {
            let old = line.clone();
            for i in 1..line.len() - 1 {
                let mean = along(old[i], 0.25, minus(along(old[i - 1], 1.0, old[i + 1]), along(old[i], 1.0, old[i])));
                let stays = course.pinned[i] || distance(mean, course.line[i]) > FARTHEST * self.lattice.spacing || !self.lattice.is_dry_at(mean);
                if !stays {
                    line[i] = mean;
                }
            }
        }
        line
    }

    /// What lies at the vertices of a line.
    fn stations(&self, line: &[Point]) -> Stations {
        let ground = line.iter().map(|&p| ground(self.source, p)).collect();
        let mut stations = Stations { at: Vec::new(), ground, water: self.water(line) };
        stations.measure(line);
        stations.spread(self.roads.approach(self.lattice.spacing));
        stations
    }

    /// The surface of the water at the vertices of a line, as far as the road reaches to either side.
    fn water(&self, line: &[Point]) -> Vec<Option<f64>> {
        let (reach, step) = (self.roads.reach(), self.step);
        let sides = (reach / step).ceil();
        let around = 1 + (reach / self.lattice.spacing).ceil() as i64;
        let at = |i: usize| {
            // Where the lattice holds no point near for wet there is no water.
            if self.lattice.is_dry_round(line[i], around) {
                return None;
            }
            let way = unit(minus(line[(i + 1).min(line.len() - 1)], line[i.saturating_sub(1)]));
            let water = (-(sides as i64)..=sides as i64).filter_map(|k| {
                // Samples that overlap see all water between them.
                let [elevation, depth, cover] = sample(self.source, along(line[i], k as f64 * reach / sides, [-way[1], way[0]]), 1.5 * step);
                (cover > 0.0 || depth > 0.0).then_some(elevation + depth)
            });
            water.reduce(f64::max)
        };
        (0..line.len()).map(at).collect()
    }

    /// The road's elevation at every station.
    ///
    /// Of all lines no steeper than the grade, the mean of the least one above the ground and the greatest one below it is furthest from the ground by the least;
    /// averaged over a few widths, raised over water, and led to the ends. Each of these steps keeps to the grade.
    fn graded(&self, course: &Course, stations: &Stations, bridges: &[[usize; 2]]) -> Vec<f64> {
        let grade = self.roads.grade;
        let mut ground = stations.ground.clone();
        for &[first, last] in bridges {
            let (from, length) = (stations.at[first], (stations.at[last] - stations.at[first]).max(1e-9));
            for (ground, at) in ground[first..=last].iter_mut().zip(&stations.at[first..=last]) {
                *ground = stations.ground[first] + (stations.ground[last] - stations.ground[first]) * ((at - from) / length);
            }
        }
        let middle = balanced(&ground, &stations.at, grade);
        let mut heights = balanced(&averaged(&middle, &stations.at, 2.0 * self.roads.reach()), &stations.at, grade);
        let decks: Vec<f64> = stations.water.iter().map(|water| water.map_or(f64::NEG_INFINITY, |surface| surface + self.roads.clearance)).collect();
        for (height, deck) in heights.iter_mut().zip(envelope(&decks, &stations.at, grade)) {
            *height = height.max(deck);
        }
        let length = stations.at[stations.at.len() - 1];
        for (height, &at) in heights.iter_mut().zip(&stations.at) {
            let [a, b] = course.ends;
            let (low, high) = ((a - grade * at).max(b - grade * (length - at)), (a + grade * at).min(b + grade * (length - at)));
            *height = height.max(low).min(high);
        }
        heights
    }
}

impl Stations {
    /// Measures the way along the line.
    fn measure(&mut self, line: &[Point]) {
        self.at = vec![0.0];
        for step in line.windows(2) {
            self.at.push(self.at[self.at.len() - 1] + distance(step[0], step[1]));
        }
    }

    /// Lets water count at all stations so near to it along the line.
    fn spread(&mut self, away: f64) {
        let found: Vec<(f64, f64)> = self.at.iter().zip(&self.water).filter_map(|(&at, water)| Some((at, (*water)?))).collect();
        let mut first = 0;
        for (i, water) in self.water.iter_mut().enumerate() {
            let at = self.at[i];
            while found.get(first).is_some_and(|found| found.0 < at - away) {
                first += 1;
            }
            for &(_, surface) in found[first..].iter().take_while(|found| found.0 <= at + away) {
                *water = Some(water.map_or(surface, |most| most.max(surface)));
            }
        }
    }

    /// First and last station of every stretch at water.
    fn wet(&self) -> Vec<[usize; 2]> {
        let mut stretches: Vec<[usize; 2]> = Vec::new();
        for i in (0..self.water.len()).filter(|&i| self.water[i].is_some()) {
            match stretches.last_mut() {
                Some([_, last]) if *last + 1 >= i => *last = i,
                _ => stretches.push([i, i]),
            }
        }
        stretches.retain(|[first, last]| first < last);
        stretches
    }
}

/// The least line above all heights that is no steeper than the grade.
fn envelope(heights: &[f64], at: &[f64], grade: f64) -> Vec<f64> {
    let mut line = heights.to_vec();
    for i in 1..line.len() {
        line[i] = line[i].max(line[i - 1] - grade * (at[i] - at[i - 1]));
    }
    for i in (1..line.len()).rev() {
        line[i - 1] = line[i - 1].max(line[i] - grade * (at[i] - at[i - 1]));
    }
    line
}

/// The line no steeper than the grade whose greatest distance from the heights is least.
fn balanced(heights: &[f64], at: &[f64], grade: f64) -> Vec<f64> {
    let above = envelope(heights, at, grade);
    let below = envelope(&heights.iter().map(|h| -h).collect::<Vec<_>>(), at, grade);
    above.iter().zip(below).map(|(above, below)| 0.5 * (above - below)).collect()
}

/// The mean of the heights no further away than half the width.
fn averaged(heights: &[f64], at: &[f64], width: f64) -> Vec<f64> {
    let (mut first, mut end) = (0, 0);
    let mean = |&here: &f64| {
        while at[first] < here - 0.5 * width {
            first += 1;
        }
        while end < at.len() && at[end] <= here + 0.5 * width {
            end += 1;
        }
        heights[first..end].iter().sum::<f64>() / (end - first) as f64
    };
    at.iter().map(mean).collect()
}

/// A piece of a course between two of its vertices.
fn road(line: &[Point], heights: &[f64], stations: &Stations, (from, to): (usize, usize), is_bridge: bool, routes: &[[usize; 2]]) -> Road {
    let range = from..=to;
    let grade = (from..to).map(|i| (heights[i + 1] - heights[i]).abs() / (stations.at[i + 1] - stations.at[i])).fold(0.0, f64::max);
    let above = range.clone().map(|i| heights[i] - if is_bridge { stations.water[i].unwrap_or(heights[i]) } else { stations.ground[i] });
    let (cut, fill) = above.fold((0.0_f64, 0.0_f64), |(cut, fill), above| (cut.max(-above), fill.max(above)));
    Road {
        line: range.map(|i| [line[i][0], line[i][1], heights[i]]).collect(),
        is_bridge,
        routes: routes.to_vec(),
        length: stations.at[to] - stations.at[from],
        grade,
        cut: if is_bridge { 0.0 } else { cut },
        fill,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_balanced_line_keeps_to_the_grade_and_halves_the_greatest_distance() {
        let at: Vec<f64> = (0..200).map(|i| 5.0 * f64::from(i)).collect();
        let ground: Vec<f64> = at.iter().map(|&s| 20.0 * libm::sin(s / 60.0) + 4.0 * libm::sin(s / 7.0)).collect();
        let line = balanced(&ground, &at, 0.1);
        assert!(line.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 0.5 * (1.0 + 1e-9)));
        let worst = |line: &[f64]| line.iter().zip(&ground).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // No line does better than half of what any two heights differ by beyond the grade.
        let least = (0..200).flat_map(|i| (0..200).map(move |j| (i, j))).map(|(i, j)| 0.5 * (ground[i] - ground[j] - 0.1 * (at[i] - at[j]).abs()));
        assert!((worst(&line) - least.fold(0.0, f64::max)).abs() < 1e-9);
        assert!(balanced(&line, &at, 0.1).iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-9), "what keeps to the grade stays");
    }

    #[test]
    fn water_spreads_along_the_road() {
        let mut stations = Stations { at: (0..10).map(|i| 10.0 * f64::from(i)).collect(), ground: vec![0.0; 10], water: vec![None; 10] };
        (stations.water[3], stations.water[8]) = (Some(1.0), Some(2.0));
        stations.spread(15.0);
        assert_eq!(stations.wet(), [[2, 4], [7, 9]]);
        assert_eq!(stations.water[2..5], [Some(1.0); 3]);
    }
}
