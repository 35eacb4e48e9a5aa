//! Checks of what users draw.

use super::{Curve, Elevation, MAX_ELEVATION, MAX_VERTICES, ShapeError};
use crate::geometry::PLANE_LIMIT;
use robust::{Coord, orient2d};
use rstar::{
    AABB, RTree,
    primitives::{GeomWithData, Rectangle},
};

/// Checks coordinates.
pub(super) fn vertices(vertices: &[[f64; 2]]) -> Result<(), ShapeError> {
    for (vertex, point) in vertices.iter().enumerate() {
        if let Some(&value) = point.iter().find(|c| c.is_nan() || c.abs() > PLANE_LIMIT) {
            return Err(ShapeError::Coordinate { vertex, value });
        }
    }
    Ok(())
}

/// Checks the elevation of a whole shape.
pub(super) fn constant(elevation: Option<f64>) -> Result<(), ShapeError> {
    if elevation.is_none_or(is_elevation) { Ok(()) } else { Err(ShapeError::Elevation { vertex: 0 }) }
}

fn is_elevation(elevation: f64) -> bool {
    elevation.abs() <= MAX_ELEVATION
}

/// Checks a curve.
pub(super) fn curve(curve: &Curve) -> Result<(), ShapeError> {
    let count = curve.vertices.len();
    if count > MAX_VERTICES {
        return Err(ShapeError::TooMany { vertices: count, limit: MAX_VERTICES });
    }
    let (kind, least) = if curve.closed { ("ring", 4) } else { ("line", 2) };
    if curve.starts.is_empty() {
        return Err(ShapeError::TooFew { kind, vertex: 0, vertices: 0, least });
    }
    vertices(&curve.vertices)?;
    for i in 0..curve.starts.len() {
        let part = curve.part(i);
        if part.len() < least {
            return Err(ShapeError::TooFew { kind, vertex: part.start, vertices: part.len(), least });
        }
        if curve.closed && curve.vertices[part.start] != curve.vertices[part.end - 1] {
            return Err(ShapeError::Open { vertex: part.end - 1, first: part.start });
        }
    }
    elevations(curve)?;
    if curve.closed { rings(curve) } else { Ok(()) }
}

fn elevations(curve: &Curve) -> Result<(), ShapeError> {
    match &curve.elevation {
        Elevation::Absent => Ok(()),
        Elevation::Constant(elevation) => constant(Some(*elevation)),
        Elevation::Vertices(elevations) if elevations.len() != curve.vertices.len() => {
            Err(ShapeError::Elevations { elevations: elevations.len(), vertices: curve.vertices.len() })
        }
        Elevation::Vertices(elevations) => match elevations.iter().position(|&elevation| !is_elevation(elevation)) {
            Some(vertex) => Err(ShapeError::Elevation { vertex }),
            None => Ok(()),
        },
    }
}

/// An edge of a ring, from a vertex to the next.
#[derive(Clone, Copy)]
struct Side {
    vertex: usize,
    ring: usize,
    ends: [[f64; 2]; 2],
}

type Sides = RTree<GeomWithData<Rectangle<[f64; 2]>, Side>>;

/// Checks that no edges meet but neighbours in the vertex they share, and rings of one polygon in single points; and that holes lie inside.
fn rings(curve: &Curve) -> Result<(), ShapeError> {
    let mut sides = Vec::with_capacity(curve.vertices.len());
    for ring in 0..curve.starts.len() {
        let part = curve.part(ring);
        // What has no length meets nothing that its neighbours do not.
        let pairs = part.clone().zip(part.skip(1)).map(|(i, j)| (i, [curve.vertices[i], curve.vertices[j]]));
        sides.extend(pairs.filter(|(_, ends)| ends[0] != ends[1]).map(|(vertex, ends)| Side { vertex, ring, ends }));
    }
    let objects = sides.iter().map(|&side| GeomWithData::new(Rectangle::from_corners(side.ends[0], side.ends[1]), side));
    let tree = RTree::bulk_load(objects.collect());
    let mut budget = Budget(LEAST_PAIRS + PAIRS_A_SIDE * sides.len());
    for side in &sides {
        let near = tree.locate_in_envelope_intersecting(AABB::from_corners(side.ends[0], side.ends[1]));
        let mut first = None;
        for other in near.map(|object| object.data) {
            budget.take(side.vertex)?;
            if other.vertex > side.vertex && conflict(side, &other) {
                first = first.into_iter().chain([other.vertex]).min();
            }
        }
        if let Some(other) = first {
            return Err(ShapeError::Crossing { vertex: side.vertex, other });
        }
    }
    holes(curve, &tree, &mut budget)
}

/// Pairs of edges that may be compared: what is drawn by hand or grown needs a few an edge. Only long edges that run aslant beside each other need more, up to the
/// square of their number.
const PAIRS_A_SIDE: usize = 1024;

/// Pairs that a polygon of any size may have: those of 360 edges, whatever they are.
const LEAST_PAIRS: usize = 131_072;

/// Comparisons that are left.
struct Budget(usize);

impl Budget {
    fn take(&mut self, vertex: usize) -> Result<(), ShapeError> {
        self.0 = self.0.checked_sub(1).ok_or(ShapeError::Entangled { vertex })?;
        Ok(())
    }
}

/// Whether two edges meet where they may not.
fn conflict(one: &Side, other: &Side) -> bool {
    let ([a, b], [c, d]) = (one.ends, other.ends);
    let turns = [turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)];
    if turns == [0; 4] {
        return overlap(one.ends, other.ends);
    }
    if turns[0] * turns[1] > 0 || turns[2] * turns[3] > 0 {
        return false;
    }
    let proper = turns[0] * turns[1] < 0 && turns[2] * turns[3] < 0;
    proper || (one.ring == other.ring && ![a, b].iter().any(|end| [c, d].contains(end)))
}

/// Whether two edges on one line share more than an end.
fn overlap(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> bool {
    let sorted = |ends: [[f64; 2]; 2]| if super::edge::is_after(ends[0], ends[1]) { [ends[1], ends[0]] } else { ends };
    let (one, other) = (sorted(one), sorted(other));
    super::edge::is_after(one[1], other[0]) && super::edge::is_after(other[1], one[0])
}

/// 1 if c lies left of the way from a to b, -1 if right, 0 if on its line; exact.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> i8 {
    let coord = |[x, y]: [f64; 2]| Coord { x, y };
    let turn = orient2d(coord(a), coord(b), coord(c));
    i8::from(turn > 0.0) - i8::from(turn < 0.0)
}

/// Checks that the ray from every hole eastwards crosses the other rings an odd number of times.
fn holes(curve: &Curve, tree: &Sides, budget: &mut Budget) -> Result<(), ShapeError> {
    for ring in 1..curve.starts.len() {
        let part = curve.part(ring);
        // A vertex that touches another ring says nothing.
        let free = part.clone().find(|&vertex| {
            let point = curve.vertices[vertex];
            let mut near = tree.locate_in_envelope_intersecting(AABB::from_point(point));
            !near.any(|object| object.data.ring != ring && turn(object.data.ends[0], object.data.ends[1], point) == 0)
        });
        let p = curve.vertices[free.unwrap_or(part.start)];
        let ray = AABB::from_corners(p, [f64::MAX, p[1]]);
        let mut crossings = 0;
        for object in tree.locate_in_envelope_intersecting(ray) {
            budget.take(part.start)?;
            crossings += usize::from(object.data.ring != ring && super::crosses(p, object.data.ends[0], object.data.ends[1]));
        }
        if free.is_some() && crossings % 2 == 0 {
            return Err(ShapeError::Hole { vertex: part.start });
        }
    }
    Ok(())
}
