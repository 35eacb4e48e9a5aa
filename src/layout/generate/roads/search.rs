//! Least-cost paths over the lattice, for roads that choose how far above or below the ground they lie.
//!
//! A state is a point with a level, the road's height over the ground in steps of half the earthwork. A move to one of the 32 points that are seen in different
//! directions within three columns and rows is allowed where the road's slope keeps to the limit, the ground between the two points is not too far from the
//! straight line, and no water lies there. Over water go straight bridges in the same directions.

use super::{
    super::plane::{Near, crossing, distance},
    Roads,
    lattice::Lattice,
};
use std::{
    cmp::{Ordering, Reverse},
    collections::{BTreeMap, BTreeSet, BinaryHeap},
};

/// The share of the greatest grade that the search uses: smoothing shortens the way.
const GRADE_KEPT: f64 = 0.85;
/// What a metre costs more at the greatest grade, at the greatest earthwork, and on a bridge, in metres of level road.
const STEEP: f64 = 0.6;
const DEEP: f64 = 3.0;
const BRIDGE: f64 = 8.0;
/// What a metre on a road that there is already costs.
const KNOWN: f64 = 0.3;
/// Levels above and below the ground.
const LEVELS: i64 = 2;
/// The level of a point that no road uses yet.
const FREE: i8 = i8::MAX;

/// Two points that a bridge or a road joins, the smaller first.
pub(super) type Pair = [usize; 2];

pub(super) fn pair(a: usize, b: usize) -> Pair {
    [a.min(b), a.max(b)]
}

/// A move in one of the directions.
struct Move {
    by: [i64; 2],
    /// In metres.
    length: f64,
    /// Places between the two points: the two lattice points on either side, by columns and rows, and the share of the second.
    inner: Vec<([i64; 2], [i64; 2], f64)>,
}

/// What moves cost and which are allowed.
pub(super) struct Terms<'a> {
    pub(super) lattice: &'a Lattice,
    moves: Vec<Move>,
    grade: f64,
    /// Metres between levels, 0 if there is one level.
    level: f64,
    levels: i64,
    /// How far the ground between two points may be from the road.
    deepest: f64,
    earthwork: f64,
    bridge: f64,
    approach: f64,
}

/// Roads found so far.
#[derive(Default)]
pub(super) struct Known {
    /// Of every point, or none at all.
    levels: Vec<i8>,
    /// Every piece, with the pairs of places it belongs to.
    pub(super) pieces: BTreeMap<Pair, Vec<[usize; 2]>>,
    /// Pieces of bridges that turned out too long.
    pub(super) refused: BTreeSet<Pair>,
    /// Points near pieces.
    busy: Vec<bool>,
    near: Option<Near>,
}

/// A cost in an order that is total, so that ties never depend on anything.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cost(f64);

impl Eq for Cost {}

impl PartialOrd for Cost {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cost {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

fn moves(spacing: f64) -> Vec<Move> {
    let common = |a: i64, b: i64| (2..=3).any(|k| a % k == 0 && b % k == 0);
    let mut all = Vec::new();
    for dy in -3_i64..=3 {
        for dx in -3_i64..=3 {
            if (dx, dy) == (0, 0) || common(dx, dy) || dx.abs().max(dy.abs()) > 1 && dx * dy == 0 {
                continue;
            }
            let steps = dx.abs().max(dy.abs());
            let inner = (1..steps).map(|k| {
                let [x, y] = [dx, dy].map(|d| (k * d) as f64 / steps as f64);
                let share = (x - x.floor()).max(y - y.floor());
                ([x.floor() as i64, y.floor() as i64], [x.ceil() as i64, y.ceil() as i64], share)
            });
            all.push(Move { by: [dx, dy], length: spacing * ((dx * dx + dy * dy) as f64).sqrt(), inner: inner.collect() });
        }
    }
    all
}

impl<'a> Terms<'a> {
    pub(super) fn new(roads: &Roads, lattice: &'a Lattice) -> Self {
        let levels = if roads.earthwork > 0.0 { LEVELS } else { 0 };
        Terms {
            lattice,
            moves: moves(lattice.spacing),
            grade: GRADE_KEPT * roads.grade,
            level: roads.earthwork / LEVELS as f64,
            levels,
            deepest: roads.deepest(),
            earthwork: roads.earthwork.max(1.0),
            bridge: roads.bridge,
            approach: roads.approach(lattice.spacing),
        }
    }

    /// Levels of a point.
    fn count(&self) -> usize {
        (2 * self.levels + 1) as usize
    }

    /// The state of a point on the ground.
    pub(super) fn on_ground(&self, node: usize) -> usize {
        node * self.count() + self.levels as usize
    }

    /// Point and level of a state.
    pub(super) fn split(&self, state: usize) -> (usize, i64) {
        (state / self.count(), (state % self.count()) as i64 - self.levels)
    }

    /// The road's elevation in a state.
    pub(super) fn elevation(&self, state: usize) -> f64 {
        let (node, level) = self.split(state);
        self.lattice.elevation[node] + level as f64 * self.level
    }

    /// The end of a straight bridge from a point, and metres of it over water or beside it; `None` if there is no water, or too much.
    fn bridge(&self, node: usize, movement: &Move) -> Option<(usize, f64, f64)> {
        let (mut here, mut wet, mut length) = (node, 0.0, 0.0);
        let steps = movement.inner.len() as f64 + 1.0;
        loop {
            length += movement.length;
            for &(a, b, share) in &movement.inner {
                let (a, b) = (self.lattice.step(here, a)?, self.lattice.step(here, b)?);
                wet += (self.lattice.cover[a] * (1.0 - share) + self.lattice.cover[b] * share) * movement.length / steps;
            }
            let next = self.lattice.step(here, movement.by)?;
            if self.lattice.is_dry(next) {
                return (wet + 2.0 * self.approach <= self.bridge).then_some((next, wet, length));
            }
            wet += self.lattice.cover[next] * movement.length / steps;
            if wet + 2.0 * self.approach > self.bridge || length > self.bridge + 8.0 * self.lattice.spacing {
                return None;
            }
            here = next;
        }
    }

    /// Whether no water lies between a point and where a move leads.
    fn is_dry(&self, node: usize, movement: &Move) -> bool {
        let dry = |by: [i64; 2]| self.lattice.step(node, by).is_some_and(|near| self.lattice.is_dry(near));
        dry(movement.by) && movement.inner.iter().all(|&(a, b, _)| dry(a) && dry(b))
    }

    /// What a move costs a road between two elevations; `None` if the ground between is too far from it.
    fn ground(&self, node: usize, movement: &Move, [from, to]: [f64; 2], ends: [f64; 2]) -> Option<f64> {
        let slope = (to - from).abs() / (movement.length * self.grade);
        let mut deep = 0.5 * (ends[0] * ends[0] + ends[1] * ends[1]);
        let steps = movement.inner.len() as f64 + 1.0;
        for (k, &(a, b, share)) in movement.inner.iter().enumerate() {
            let [a, b] = [self.lattice.step(node, a)?, self.lattice.step(node, b)?].map(|near| self.lattice.elevation[near]);
            let away = from + (to - from) * (k as f64 + 1.0) / steps - (a + (b - a) * share);
            if away.abs() > self.deepest {
                return None;
            }
            deep += away * away;
        }
        deep /= steps * self.earthwork * self.earthwork;
        Some(movement.length * (1.0 + STEEP * slope * slope + DEEP * deep))
    }

    /// Gives the states that a state leads to, with the costs, in a fixed order.
    fn each(&self, state: usize, known: &Known, mut give: impl FnMut(usize, f64)) {
        let (node, own) = self.split(state);
        let (from, is_place) = (self.elevation(state), self.lattice.is_place(node));
        for movement in &self.moves {
            let (to, wet, length) = if self.is_dry(node, movement) {
                match self.lattice.step(node, movement.by) {
                    Some(to) => (to, None, movement.length),
                    None => continue,
                }
            } else {
                match self.bridge(node, movement) {
                    Some((to, wet, length)) => (to, Some(wet), length),
                    None => continue,
                }
            };
            if !known.allows(self.lattice, node, to, wet.is_some()) {
                continue;
            }
            let is_known = known.pieces.contains_key(&pair(node, to));
            let run =
                if is_place || known.levels[to] == 0 && self.lattice.is_place(to) { distance(self.lattice.at(node), self.lattice.at(to)) } else { length };
            let (most, below) = (self.grade * run, self.lattice.elevation[to]);
            for level in -self.levels..=self.levels {
                let target = below + level as f64 * self.level;
                if (target - from).abs() > most || !known.has_level(to, level) {
                    continue;
                }
                let ends = [own, level].map(|level| level as f64 * self.level);
                let cost = match wet {
                    Some(wet) => {
                        let slope = (target - from).abs() / most.max(1e-9);
                        Some(length * (1.0 + STEEP * slope * slope) + BRIDGE * (wet + 2.0 * self.approach))
                    }
                    None => self.ground(node, movement, [from, target], ends),
                };
                if let Some(cost) = cost {
                    give(to * self.count() + (level + self.levels) as usize, if is_known { KNOWN * length } else { cost });
                }
            }
        }
    }

    /// The states of the cheapest way between two points on the ground, from the first to the second.
    pub(super) fn way(&self, from: usize, to: usize, known: &Known) -> Option<Vec<usize>> {
        let goal = self.on_ground(to);
        let target = self.lattice.place(to);
        let least = self.lattice.spacing * if known.pieces.is_empty() { 1.0 } else { KNOWN };
        let left = |state: usize| {
            let [x, y] = self.lattice.place(self.split(state).0);
            let (dx, dy) = (x - target[0], y - target[1]);
            // A little less than the distance, so that rounding never makes it too long.
            least * 0.999_999 * (dx * dx + dy * dy).sqrt()
        };
        let count = self.lattice.elevation.len() * self.count();
        let (mut costs, mut before, mut done) = (vec![f64::INFINITY; count], vec![usize::MAX; count], vec![false; count]);
        let start = self.on_ground(from);
        costs[start] = 0.0;
        let mut heap = BinaryHeap::from([Reverse((Cost(left(start)), start))]);
        while let Some(Reverse((_, state))) = heap.pop() {
            if std::mem::replace(&mut done[state], true) {
                continue;
            }
            if state == goal {
                let mut way = vec![goal];
                while way[way.len() - 1] != start {
                    way.push(before[way[way.len() - 1]]);
                }
                way.reverse();
                return Some(way);
            }
            self.each(state, known, |next, cost| {
                let total = costs[state] + cost;
                if total < costs[next] {
                    (costs[next], before[next]) = (total, state);
                    heap.push(Reverse((Cost(total + left(next)), next)));
                }
            });
        }
        None
    }

    /// What the cheapest way costs between places whose regions, the states nearer to them than to others, meet: enough for the least tree of all cheapest ways
    /// (K. Mehlhorn 1988).
    pub(super) fn meetings(&self, places: &[usize], known: &Known) -> BTreeMap<Pair, f64> {
        let count = self.lattice.elevation.len() * self.count();
        let (mut costs, mut owner, mut done) = (vec![f64::INFINITY; count], vec![u8::MAX; count], vec![false; count]);
        let mut heap = BinaryHeap::new();
        for (number, &place) in places.iter().enumerate() {
            let state = self.on_ground(place);
            (costs[state], owner[state]) = (0.0, number as u8);
            heap.push(Reverse((Cost(0.0), state)));
        }
        let mut met: BTreeMap<Pair, f64> = BTreeMap::new();
        while let Some(Reverse((_, state))) = heap.pop() {
            if std::mem::replace(&mut done[state], true) {
                continue;
            }
            self.each(state, known, |next, cost| {
                let total = costs[state] + cost;
                if done[next] {
                    if owner[next] != owner[state] {
                        let both = met.entry(pair(owner[next].into(), owner[state].into())).or_insert(f64::INFINITY);
                        *both = both.min(total + costs[next]);
                    }
                } else if total < costs[next] {
                    (costs[next], owner[next]) = (total, owner[state]);
                    heap.push(Reverse((Cost(total), next)));
                }
            });
        }
        met
    }

    /// Whether two points are joined by dry moves and bridges, however steep.
    pub(super) fn is_dry_between(&self, from: usize, to: usize) -> bool {
        let mut seen = vec![false; self.lattice.elevation.len()];
        let mut open = vec![from];
        seen[from] = true;
        while let Some(node) = open.pop() {
            for movement in &self.moves {
                let dry = self.is_dry(node, movement).then(|| self.lattice.step(node, movement.by)).flatten();
                let next = dry.or_else(|| Some(self.bridge(node, movement)?.0));
                if let Some(next) = next.filter(|&next| !seen[next]) {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
        seen[to]
    }
}

impl Known {
    /// No roads, and places that all roads meet on the ground.
    pub(super) fn new(lattice: &Lattice, places: &[usize]) -> Self {
        let count = lattice.elevation.len();
        let mut known = Known { levels: vec![FREE; count], busy: vec![false; count], ..Known::default() };
        for &place in places {
            known.levels[place] = 0;
        }
        known
    }

    fn has_level(&self, node: usize, level: i64) -> bool {
        self.levels[node] == FREE || i64::from(self.levels[node]) == level
    }

    /// Whether a piece may be built: no road is crossed but at its points.
    fn allows(&self, lattice: &Lattice, from: usize, to: usize, is_bridge: bool) -> bool {
        if !self.refused.is_empty() && self.refused.contains(&pair(from, to)) {
            return false;
        }
        let Some(near) = self.near.as_ref().filter(|_| is_bridge || self.busy[from]) else { return true };
        let ends = [lattice.place(from), lattice.place(to)];
        near.around(ends, 0.0).into_iter().all(|number| {
            let other = near.segments()[number];
            other.iter().any(|end| ends.contains(end)) || crossing(ends, other).is_none()
        })
    }

    /// Takes in a way of states.
    pub(super) fn add(&mut self, terms: &Terms, way: &[usize], route: [usize; 2]) {
        let lattice = terms.lattice;
        let last = [lattice.columns as f64, lattice.rows as f64];
        let near = self.near.get_or_insert_with(|| Near::new([[0.0, 0.0], last], 4.0));
        for step in way.windows(2) {
            let [(a, from), (b, to)] = [terms.split(step[0]), terms.split(step[1])];
            (self.levels[a], self.levels[b]) = (from as i8, to as i8);
            let routes = self.pieces.entry(pair(a, b)).or_default();
            if routes.is_empty() {
                near.insert([lattice.place(a), lattice.place(b)]);
            }
            routes.push(route);
            for node in [a, b] {
                for dy in -4..=4 {
                    for dx in -4..=4 {
                        if let Some(beside) = lattice.step(node, [dx, dy]) {
                            self.busy[beside] = true;
                        }
                    }
                }
            }
        }
    }

    /// The road's elevation at a point that a road uses.
    pub(super) fn elevation(&self, terms: &Terms, node: usize) -> f64 {
        terms.elevation(terms.on_ground(node)) + f64::from(self.levels[node]) * terms.level
    }
}
