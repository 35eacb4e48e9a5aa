//! What becomes of features that cross.

use super::{
    error::{GenerateError, check},
    plane::{Area, Near, Point, Segment, along, crossing, distance, minus},
    read::{Water, flat, lines},
};
use crate::{
    geometry::{Elevation, Shape},
    layout::Feature,
};

/// What becomes of a feature that crosses another of higher [precedence](Feature::precedence).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Conflict {
    /// It goes.
    Remove,
    /// A line loses what is nearer to the crossing than `clearance`, 0.001 … 1,000,000 m along the line, what lies inside the other's polygon, and pieces
    /// that are shorter than the clearance; polygons go.
    Cut {
        /// Metres along the line.
        clearance: f64,
    },
}

/// Leaves no two features of different precedence that cross as they were drawn: the lower one is cut or removed.
///
/// A line is in conflict with lines and polygons' edges that it crosses or touches other than at vertices of both, and with polygons that it runs inside of; a
/// polygon with polygons whose edges it crosses. Points and circles stay. Features keep their order.
///
/// # Errors
/// A clearance outside its range.
pub fn resolve(features: &[Feature], conflict: Conflict) -> Result<Vec<Feature>, GenerateError> {
    if let Conflict::Cut { clearance } = conflict {
        check("conflict.clearance", clearance, 0.001..=1e6)?;
    }
    let mut order: Vec<usize> = (0..features.len()).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(features[index].precedence));
    let mut kept: Vec<Option<Vec<Feature>>> = features.iter().map(|_| None).collect();
    let mut above = Above::default();
    let mut next = 0;
    while next < order.len() {
        // Features of one precedence do not conflict with each other: all are judged before any is added.
        let rank = features[order[next]].precedence;
        let end = next + order[next..].iter().take_while(|&&index| features[index].precedence == rank).count();
        above.index();
        for &index in &order[next..end] {
            kept[index] = Some(above.judge(&features[index], conflict)?);
        }
        for &index in &order[next..end] {
            above.add(kept[index].iter().flatten());
        }
        next = end;
    }
    Ok(kept.into_iter().flatten().flatten().collect())
}

/// Features of higher precedence.
#[derive(Default)]
struct Above {
    edges: Vec<Segment>,
    /// Which of the edges are a polygon's.
    rings: Vec<Vec<Point>>,
    is_ring: Vec<bool>,
    grid: Option<(Near, Area)>,
}

impl Above {
    fn add<'a>(&mut self, features: impl Iterator<Item = &'a Feature>) {
        for Water { line, closed } in features.flat_map(|feature| lines(std::slice::from_ref(feature))) {
            let line = flat(&line);
            let count = if closed { line.len() } else { line.len() - 1 };
            self.edges.extend((0..count).map(|i| [line[i], line[(i + 1) % line.len()]]));
            self.is_ring.resize(self.edges.len(), closed);
            if closed {
                self.rings.push(line);
            }
        }
    }

    fn index(&mut self) {
        let longest = self.edges.iter().map(|edge| distance(edge[0], edge[1])).fold(1e-3, f64::max);
        self.grid = Some((Near::of(self.edges.iter().copied(), longest), Area::of(self.rings.iter().map(Vec::as_slice), longest)));
    }

    /// Where along a segment, 0 … 1, it crosses edges, ascending.
    fn crossings(&self, segment: Segment, rings_only: bool) -> Vec<f64> {
        let Some((near, _)) = self.grid.as_ref().filter(|_| !self.edges.is_empty()) else { return Vec::new() };
        let numbers = near.around(segment, 0.0).into_iter().filter(|&number| self.is_ring[number] || !rings_only);
        let shared = |edge: &Segment| edge.iter().any(|end| segment.contains(end));
        let mut at: Vec<f64> =
            numbers.map(|number| near.segments()[number]).filter(|edge| !shared(edge)).filter_map(|edge| Some(crossing(segment, edge)?[0])).collect();
        at.sort_by(f64::total_cmp);
        at
    }

    fn is_inside(&self, p: Point) -> bool {
        self.grid.as_ref().is_some_and(|(_, area)| area.contains(p))
    }

    /// What stays of a feature.
    fn judge(&self, feature: &Feature, conflict: Conflict) -> Result<Vec<Feature>, GenerateError> {
        let Some(curve) = feature.shape().curve() else { return Ok(vec![feature.clone()]) };
        let parts = lines(std::slice::from_ref(feature));
        let closed = curve.is_closed();
        let is_clear = parts.iter().all(|part| {
            let ring = part.line.first().filter(|_| closed);
            let line = flat(&part.line.iter().chain(ring).copied().collect::<Vec<_>>());
            line.windows(2).all(|pair| {
                let segment = [pair[0], pair[1]];
                self.crossings(segment, closed).is_empty() && (closed || !self.is_inside(along(pair[0], 0.5, minus(pair[1], pair[0]))))
            })
        });
        match conflict {
            _ if is_clear => Ok(vec![feature.clone()]),
            Conflict::Cut { clearance } if !closed => {
                let pieces = parts.iter().flat_map(|part| self.pieces(&part.line, clearance));
                pieces.map(|piece| like(feature, &piece)).collect()
            }
            Conflict::Cut { .. } | Conflict::Remove => Ok(Vec::new()),
        }
    }

    /// The pieces of a line that stay.
    fn pieces(&self, line: &[[f64; 3]], clearance: f64) -> Vec<Vec<[f64; 3]>> {
        let mut pieces = vec![Vec::new()];
        for pair in line.windows(2) {
            let point = |t: f64| [0, 1, 2].map(|axis| pair[0][axis] + (pair[1][axis] - pair[0][axis]) * t);
            let stops: Vec<f64> = [0.0].into_iter().chain(self.crossings([[pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]]], false)).chain([1.0]).collect();
            for (k, ends) in stops.windows(2).enumerate() {
                let middle = point(f64::midpoint(ends[0], ends[1]));
                if k > 0 || self.is_inside([middle[0], middle[1]]) {
                    pieces.push(Vec::new());
                }
                if self.is_inside([middle[0], middle[1]]) {
                    continue;
                }
                for p in ends.iter().map(|&t| point(t)) {
                    pieces.last_mut().into_iter().filter(|piece| piece.last() != Some(&p)).for_each(|piece| piece.push(p));
                }
            }
        }
        let [first, last] = [line[0], line[line.len() - 1]];
        let cut = pieces.into_iter().map(|piece| {
            let piece = if piece.first() == Some(&first) { piece } else { shortened(&piece, clearance) };
            if piece.last() == Some(&last) { piece } else { reversed(shortened(&reversed(piece), clearance)) }
        });
        cut.filter(|piece| length(piece) >= clearance).collect()
    }
}

fn reversed(mut line: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    line.reverse();
    line
}

fn span(a: [f64; 3], b: [f64; 3]) -> f64 {
    distance([a[0], a[1]], [b[0], b[1]])
}

fn length(line: &[[f64; 3]]) -> f64 {
    line.windows(2).map(|pair| span(pair[0], pair[1])).sum()
}

/// A line without its first `away` metres.
fn shortened(line: &[[f64; 3]], away: f64) -> Vec<[f64; 3]> {
    let mut left = away;
    for k in 1..line.len() {
        let (a, b) = (line[k - 1], line[k]);
        let step = span(a, b);
        if step > left {
            let start = [0, 1, 2].map(|axis| a[axis] + (b[axis] - a[axis]) * (left / step));
            return [start].into_iter().chain(line[k..].iter().copied()).collect();
        }
        left -= step;
    }
    Vec::new()
}

/// A feature along another line.
fn like(feature: &Feature, line: &[[f64; 3]]) -> Result<Feature, GenerateError> {
    let elevation = if feature.shape().has_elevation() { Elevation::Vertices(line.iter().map(|p| p[2]).collect()) } else { Elevation::Absent };
    let shape = Shape::line(flat(line), elevation)?;
    let detail = feature.shape().curve().and_then(|curve| curve.detail());
    let mut piece = Feature::new(if let Some(detail) = detail { shape.detailed(*detail)? } else { shape }, std::sync::Arc::clone(feature.attributes()))?;
    (piece.precedence, piece.id) = (feature.precedence, feature.id.clone());
    Ok(piece)
}
