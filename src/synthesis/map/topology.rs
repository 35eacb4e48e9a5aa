//! Which regions meet where.

use super::{Map, MapEdge, MapProblem, Topology};
use crate::geometry::{Edge, PLANE_LIMIT, crosses};
use rstar::{AABB, PointDistance, RTree, RTreeObject, primitives::GeomWithData};
use std::collections::BTreeMap;

/// Most vertices of a map.
const MOST_VERTICES: usize = 100_000;

/// Vertices as their bits, so that they can be sorted and looked up.
type Key = [u64; 2];

fn key(p: [f64; 2]) -> Key {
    // 0 and -0 are one place.
    p.map(|c| (c + 0.0).to_bits())
}

fn problem(region: usize, detail: String) -> MapProblem {
    MapProblem { pointer: format!("/regions/{region}"), detail }
}

/// A segment of a ring on its way with the region to its left.
#[derive(Clone, Copy, Debug)]
struct Segment {
    from: [f64; 2],
    to: [f64; 2],
    region: usize,
}

impl RTreeObject for Segment {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.from, self.to)
    }
}

impl PointDistance for Segment {
    fn distance_2(&self, point: &[f64; 2]) -> f64 {
        Edge::new(self.from, self.to).nearest(*point).0
    }
}

/// Twice the area of a ring, counter-clockwise positive.
fn doubled_area(ring: &[[f64; 2]]) -> f64 {
    let o = ring[0];
    (1..ring.len() - 1).map(|i| (ring[i][0] - o[0]) * (ring[i + 1][1] - o[1]) - (ring[i][1] - o[1]) * (ring[i + 1][0] - o[0])).sum()
}

/// Rings of joined vertices.
struct Joined {
    /// By region and ring, outlines counter-clockwise and holes clockwise.
    rings: Vec<Vec<Vec<[f64; 2]>>>,
}

fn join(map: &Map) -> Result<Joined, MapProblem> {
    let mut places: RTree<GeomWithData<[f64; 2], ()>> = RTree::new();
    let mut rings = Vec::with_capacity(map.regions.len());
    let mut count = 0;
    for (number, region) in map.regions.iter().enumerate() {
        let mut joined = Vec::new();
        for (ring_number, ring) in region.rings.iter().enumerate() {
            count += ring.len();
            if count > MOST_VERTICES {
                return Err(problem(number, format!("a map has at most {MOST_VERTICES} vertices")));
            }
            let mut out: Vec<[f64; 2]> = Vec::with_capacity(ring.len());
            for vertex in ring {
                if vertex.iter().any(|c| !(-PLANE_LIMIT..=PLANE_LIMIT).contains(c)) {
                    return Err(problem(number, format!("{vertex:?} is no place of the plane")));
                }
                let near = places.nearest_neighbor(*vertex).map(|near| *near.geom()).filter(|near| distance(*near, *vertex) <= map.snap);
                let place = near.unwrap_or_else(|| {
                    let place = vertex.map(|c| c + 0.0);
                    places.insert(GeomWithData::new(place, ()));
                    place
                });
                if out.last() != Some(&place) {
                    out.push(place);
                }
            }
            if out.len() > 1 && out.first() == out.last() {
                out.pop();
            }
            if out.len() < 3 || doubled_area(&out) == 0.0 {
                let at = ring.first().map_or_else(String::new, |at| format!(" at {at:?}"));
                return Err(problem(number, format!("ring {ring_number}{at} has fewer than three places that are more than {} m apart", map.snap)));
            }
            if (doubled_area(&out) > 0.0) != (ring_number == 0) {
                out.reverse();
            }
            joined.push(out);
        }
        if joined.is_empty() {
            return Err(problem(number, "has no outline".to_owned()));
        }
        rings.push(joined);
    }
    split(map, Joined { rings }, &places)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    (x * x + y * y).sqrt()
}

/// Splits edges at vertices that lie on them.
fn split(map: &Map, joined: Joined, places: &RTree<GeomWithData<[f64; 2], ()>>) -> Result<Joined, MapProblem> {
    let split_ring = |ring: Vec<[f64; 2]>| {
        let mut out = Vec::with_capacity(ring.len());
        for (i, from) in ring.iter().enumerate() {
            let to = ring[(i + 1) % ring.len()];
            out.push(*from);
            let edge = Edge::new(*from, to);
            let grown = AABB::from_corners(
                [from[0].min(to[0]) - map.snap, from[1].min(to[1]) - map.snap],
                [from[0].max(to[0]) + map.snap, from[1].max(to[1]) + map.snap],
            );
            let on = places.locate_in_envelope(grown).map(|place| *place.geom()).filter(|place| place != from && *place != to);
            let mut on: Vec<[f64; 2]> = on.filter(|place| edge.nearest(*place).0 <= map.snap * map.snap).collect();
            on.sort_by(|a, b| distance(*a, *from).total_cmp(&distance(*b, *from)).then_with(|| key(*a).cmp(&key(*b))));
            out.extend(on);
        }
        out
    };
    let rings: Vec<Vec<Vec<[f64; 2]>>> = joined.rings.into_iter().map(|rings| rings.into_iter().map(split_ring).collect()).collect();
    // A region that is so narrow that its sides were joined passes a place twice in a row of two.
    for (number, region) in rings.iter().enumerate() {
        for ring in region {
            let count = ring.len();
            if let Some(i) = (0..count).find(|i| ring[*i] == ring[(i + 2) % count]) {
                return Err(problem(number, format!("is a sliver at {:?}: its sides are no more than {} m apart", ring[(i + 1) % count], map.snap)));
            }
        }
    }
    Ok(Joined { rings })
}

fn segments(joined: &Joined) -> Vec<Segment> {
    let of = |(region, rings): (usize, &Vec<Vec<[f64; 2]>>)| {
        let ring = move |ring: &Vec<[f64; 2]>| (0..ring.len()).map(|i| Segment { from: ring[i], to: ring[(i + 1) % ring.len()], region }).collect::<Vec<_>>();
        rings.iter().flat_map(ring).collect::<Vec<_>>()
    };
    joined.rings.iter().enumerate().flat_map(of).collect()
}

/// On which side of a line a point lies: the sign is exact.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let coord = |[x, y]: [f64; 2]| robust::Coord { x, y };
    robust::orient2d(coord(a), coord(b), coord(p))
}

/// Whether two segments have a place in common that is not an end of both.
fn cross(one: &Segment, other: &Segment) -> bool {
    if [one.from, one.to].iter().any(|end| *end == other.from || *end == other.to) {
        // Vertices on edges were put into them, so segments that share an end share nothing else, or everything.
        return false;
    }
    let (a, b) = (side(one.from, one.to, other.from), side(one.from, one.to, other.to));
    let (c, d) = (side(other.from, other.to, one.from), side(other.from, other.to, one.to));
    (a > 0.0) != (b > 0.0) && (c > 0.0) != (d > 0.0)
}

/// Refuses edges that cross.
fn check_crossings(segments: &[Segment], tree: &RTree<Segment>) -> Result<(), MapProblem> {
    for one in segments {
        if let Some(other) = tree.locate_in_envelope_intersecting(one.envelope()).find(|other| cross(one, other)) {
            return Err(problem(
                one.region,
                format!("its edge {:?} to {:?} crosses that of region {}, {:?} to {:?}", one.from, one.to, other.region, other.from, other.to),
            ));
        }
    }
    Ok(())
}

/// Joins segments of two regions to edges.
fn edges(segments: &[Segment]) -> Result<Vec<MapEdge>, MapProblem> {
    let mut edges: BTreeMap<(Key, Key), MapEdge> = BTreeMap::new();
    for segment in segments {
        let edge = Edge::new(segment.from, segment.to);
        let (start, end) = if edge.flipped { (segment.to, segment.from) } else { (segment.from, segment.to) };
        let entry = edges.entry((key(start), key(end))).or_insert(MapEdge { start, end, regions: [None; 2] });
        let own = &mut entry.regions[usize::from(edge.flipped)];
        if let Some(other) = own {
            return Err(problem(segment.region, format!("overlaps region {other} along {:?} to {:?}", segment.from, segment.to)));
        }
        *own = Some(segment.region);
    }
    let mut edges: Vec<MapEdge> = edges.into_values().collect();
    edges.sort_by(|a, b| [a.start, a.end].as_flattened().partial_cmp([b.start, b.end].as_flattened()).unwrap_or(core::cmp::Ordering::Equal));
    Ok(edges)
}

/// Refuses a region that lies inside another without sharing an edge there.
fn check_containment(joined: &Joined) -> Result<(), MapProblem> {
    let boxes: Vec<AABB<[f64; 2]>> = joined.rings.iter().map(|rings| AABB::from_points(rings[0].iter())).collect();
    let tree = RTree::bulk_load(
        boxes.iter().enumerate().map(|(region, bounds)| GeomWithData::new(rstar::primitives::Rectangle::from_aabb(*bounds), region)).collect(),
    );
    for (number, rings) in joined.rings.iter().enumerate() {
        let inner = inside(&rings[0]);
        for other in tree.locate_in_envelope_intersecting(AABB::from_point(inner)).map(|other| other.data).filter(|other| *other != number) {
            let odd = joined.rings[other]
                .iter()
                .flat_map(|ring| (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()])))
                .filter(|(a, b)| crosses(inner, *a, *b))
                .count()
                % 2;
            let own =
                rings.iter().flat_map(|ring| (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))).filter(|(a, b)| crosses(inner, *a, *b)).count()
                    % 2;
            if odd == 1 && own == 1 {
                return Err(problem(number, format!("overlaps region {other} at {inner:?}")));
            }
        }
    }
    Ok(())
}

/// A place just inside of a counter-clockwise ring, beside the middle of its longest side.
fn inside(ring: &[[f64; 2]]) -> [f64; 2] {
    let count = ring.len();
    let longest = (0..count).max_by(|a, b| distance(ring[*a], ring[(a + 1) % count]).total_cmp(&distance(ring[*b], ring[(b + 1) % count]))).unwrap_or(0);
    let (a, b) = (ring[longest], ring[(longest + 1) % count]);
    // To the left by a millionth of its length.
    [f64::midpoint(a[0], b[0]) - (b[1] - a[1]) * 1e-6, f64::midpoint(a[1], b[1]) + (b[0] - a[0]) * 1e-6]
}

/// Refuses gaps that are no wider than what vertices are joined over: their outlines are edges with nothing beyond that come near each other.
fn check_gaps(edges: &[MapEdge], snap: f64) -> Result<(), MapProblem> {
    let outer: Vec<Segment> = edges
        .iter()
        .filter_map(|edge| match edge.regions {
            [Some(region), None] => Some(Segment { from: edge.start, to: edge.end, region }),
            [None, Some(region)] => Some(Segment { from: edge.end, to: edge.start, region }),
            _ => None,
        })
        .collect();
    let tree = RTree::bulk_load(outer.clone());
    for one in &outer {
        // Beside the middle, on the side where nothing is.
        let middle = [f64::midpoint(one.from[0], one.to[0]), f64::midpoint(one.from[1], one.to[1])];
        let length = distance(one.from, one.to);
        let out = [(one.to[1] - one.from[1]) / length, (one.from[0] - one.to[0]) / length];
        let beyond = [middle[0] + out[0] * snap, middle[1] + out[1] * snap];
        let near = |other: &&Segment| {
            let apart = distance(one.from, other.from) + distance(one.to, other.to) > 0.0;
            apart && Edge::new(other.from, other.to).nearest(middle).0 <= 4.0 * snap * snap && Edge::new(other.from, other.to).nearest(beyond).0 <= snap * snap
        };
        if let Some(other) = tree.locate_within_distance(middle, 4.0 * snap * snap).find(near) {
            return Err(problem(
                one.region,
                format!("there is a narrow gap to region {} at {middle:?}: move their edges together, or more than {} m apart", other.region, 2.0 * snap),
            ));
        }
    }
    Ok(())
}

/// Regions of one type that share an edge are one.
fn merged(map: &Map, edges: &[MapEdge]) -> Vec<usize> {
    let mut first: Vec<usize> = (0..map.regions.len()).collect();
    let root = |first: &mut [usize], mut region: usize| {
        while first[region] != region {
            first[region] = first[first[region]];
            region = first[region];
        }
        region
    };
    for edge in edges {
        if let [Some(left), Some(right)] = edge.regions
            && map.regions[left].kind == map.regions[right].kind
        {
            let (left, right) = (root(&mut first, left), root(&mut first, right));
            first[left.max(right)] = left.min(right);
        }
    }
    (0..first.len()).map(|region| root(&mut first, region)).collect()
}

pub(super) fn of(map: &Map) -> Result<Topology, MapProblem> {
    if map.regions.is_empty() {
        return Err(MapProblem { pointer: "/regions".to_owned(), detail: "a map has at least one region".to_owned() });
    }
    if !(1e-6..=1e6).contains(&map.snap) {
        return Err(MapProblem { pointer: "/snap".to_owned(), detail: format!("must be 0.000001 … 1000000 metres, is {}", map.snap) });
    }
    let joined = join(map)?;
    let segments = segments(&joined);
    let tree = RTree::bulk_load(segments.clone());
    check_crossings(&segments, &tree)?;
    let edges = edges(&segments)?;
    check_containment(&joined)?;
    check_gaps(&edges, map.snap)?;
    let merged = merged(map, &edges);
    Ok(Topology { edges, merged })
}
