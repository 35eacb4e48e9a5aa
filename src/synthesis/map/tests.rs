//! Maps by chance, and maps that are wrong.

use super::*;
use crate::noise::mix;
use rstar::{AABB, RTree, RTreeObject};

fn share(seed: u64) -> f64 {
    (mix(seed) >> 11) as f64 / 9_007_199_254_740_992.0
}

/// Quadrangles of a lattice whose vertices are moved, some of them cut into triangles, of three types.
fn random_map(side: usize, cell: f64, seed: u64) -> Map {
    let vertex = |column: usize, row: usize| {
        let number = seed ^ ((column as u64) << 32 | (row as u64) << 1);
        [cell * (column as f64 + 0.7 * (share(number) - 0.5)), cell * (row as f64 + 0.7 * (share(number + 1) - 0.5))]
    };
    let mut regions = Vec::new();
    for row in 0..side {
        for column in 0..side {
            let [a, b, c, d] = [vertex(column, row), vertex(column + 1, row), vertex(column + 1, row + 1), vertex(column, row + 1)];
            let draw = mix(seed ^ 0x5eed ^ ((column as u64) << 40) ^ ((row as u64) << 20));
            let kind = |i: u64| format!("type-{}", (draw / 7 + i) % 3);
            let rings = if draw.is_multiple_of(3) && convex([a, b, c, d]) { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] };
            regions.extend(rings.into_iter().zip(0..).map(|(ring, i)| MapRegion { kind: kind(i), rings: vec![ring] }));
        }
    }
    Map { regions, snap: 0.5 }
}

fn convex(corners: [[f64; 2]; 4]) -> bool {
    (0..4).all(|i| {
        let [a, b, c] = [corners[i], corners[(i + 1) % 4], corners[(i + 2) % 4]];
        (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) > 0.0
    })
}

fn topology(map: &Map) -> Topology {
    map.topology().unwrap_or_else(|problem| panic!("{problem:?}"))
}

struct Step {
    ends: [[f64; 2]; 2],
    curve: usize,
    number: usize,
}

impl RTreeObject for Step {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.ends[0], self.ends[1])
    }
}

fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    let coord = |[x, y]: [f64; 2]| robust::Coord { x, y };
    robust::orient2d(coord(a), coord(b), coord(p))
}

/// Whether two steps have more than a shared end in common.
fn meet(one: &Step, other: &Step) -> bool {
    let ([a, b], [c, d]) = (one.ends, other.ends);
    if [a, b].iter().any(|end| *end == c || *end == d) {
        return false;
    }
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

#[test]
fn ten_thousand_edges_keep_to_themselves() {
    let (mut edges, mut straight, mut bent) = (0, 0, 0.0);
    for (seed, smoothness) in [(1, 0.0), (2, 0.2), (3, 0.4), (4, 0.6), (5, 0.9)] {
        let topology = topology(&random_map(40, 1000.0, seed));
        let refined = refine(&topology, &|_, _| smoothness, Refinement { spacing: 40.0, seed: 7 });
        straight += refined.straight;
        let mut steps = Vec::new();
        for (number, (edge, curve)) in topology.edges.iter().zip(&refined.curves).enumerate() {
            assert_eq!((curve[0], curve[curve.len() - 1]), (edge.start, edge.end));
            if curve.len() > 2 {
                edges += 1;
                for pair in curve.windows(2) {
                    let [x, y] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
                    assert!((x * x + y * y).sqrt() <= 80.0 * (1.0 + 1e-9));
                }
                let length: f64 = curve.windows(2).map(|pair| ((pair[1][0] - pair[0][0]).powi(2) + (pair[1][1] - pair[0][1]).powi(2)).sqrt()).sum();
                bent += length / ((edge.end[0] - edge.start[0]).powi(2) + (edge.end[1] - edge.start[1]).powi(2)).sqrt();
            }
            steps.extend(curve.windows(2).enumerate().map(|(i, pair)| Step { ends: [pair[0], pair[1]], curve: number, number: i }));
        }
        let tree = RTree::bulk_load(steps);
        for step in &tree {
            for other in tree.locate_in_envelope_intersecting(step.envelope()) {
                let same = (step.curve, step.number) == (other.curve, other.number);
                assert!(same || !meet(step, other), "{:?} of edge {} and {:?} of edge {}", step.ends, step.curve, other.ends, other.curve);
            }
        }
    }
    assert!(edges >= 10_000, "{edges}");
    assert!(straight * 100 <= edges, "{straight} of {edges} are straight");
    assert!(bent / edges as f64 > 1.01, "edges are only {} times as long", bent / edges as f64);
}

#[test]
fn an_edge_is_the_same_from_both_sides_and_on_any_number_of_threads() {
    let map = random_map(6, 1000.0, 5);
    let mut turned = map.clone();
    turned.regions.reverse();
    for region in &mut turned.regions {
        region.rings[0].reverse();
        region.rings[0].rotate_left(1);
    }
    let refined = |map: &Map, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| refine(&topology(map), &|_, _| 0.3, Refinement { spacing: 30.0, seed: 1 }))
    };
    assert_eq!(refined(&map, 1), refined(&turned, 3));
    let other = refine(&topology(&map), &|_, _| 0.3, Refinement { spacing: 30.0, seed: 2 });
    assert_ne!(other, refined(&map, 2));
}

#[test]
fn smooth_seams_are_straighter_and_fit_their_wish() {
    let map = Map { regions: vec![square("a", [0.0, 0.0], 4000.0), square("b", [4000.0, 0.0], 4000.0)], snap: 1.0 };
    let topology = topology(&map);
    let shared = topology.edges.iter().position(|edge| edge.regions.iter().all(Option::is_some)).unwrap();
    let length = |smoothness: f64| {
        let curve = &refine(&topology, &|_, _| smoothness, Refinement { spacing: 30.0, seed: 3 }).curves[shared];
        curve.windows(2).map(|pair| ((pair[1][0] - pair[0][0]).powi(2) + (pair[1][1] - pair[0][1]).powi(2)).sqrt()).sum::<f64>() / 4000.0
    };
    assert!(length(0.0) > 1.05 && length(1.0) < 2.0, "{} {}", length(0.0), length(1.0));
    let bend = |smoothness: f64| {
        let of = |seed| bends::angles(64, smoothness, seed).windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f32>() / 63.0;
        (0..20).map(of).sum::<f32>() / 20.0
    };
    let mean = [0.0, 0.2, 0.4, 0.6].map(bend);
    assert!(mean.is_sorted_by(|jagged, smooth| jagged > smooth) && mean[0] > 2.0 * mean[3], "{mean:?}");
    for smoothness in [0.0, 0.3, 0.9] {
        let mean = |of: &dyn Fn(u64) -> f32| (0..20).map(of).sum::<f32>() / 20.0;
        let evolved = mean(&|seed| {
            let angles = bends::angles(64, smoothness, seed);
            let bends: Vec<f32> = (0..64).map(|i| angles[i] - if i == 0 { 0.0 } else { angles[i - 1] }).collect();
            bends::fitness(&bends, smoothness)
        });
        let random = mean(&|seed| {
            let bends: Vec<f32> = (0..64).map(|i| ((share(seed * 64 + i) * 2.0 - 1.0) * core::f64::consts::FRAC_PI_3) as f32).collect();
            bends::fitness(&bends, smoothness)
        });
        assert!(evolved > random, "{smoothness}: {evolved}, by chance {random}");
    }
}

fn square(kind: &str, [x, y]: [f64; 2], side: f64) -> MapRegion {
    MapRegion { kind: kind.to_owned(), rings: vec![vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]] }
}

#[test]
fn neighbours_share_edges_and_equal_types_merge() {
    // Two small squares beside a large one, a little off.
    let map = Map { regions: vec![square("a", [0.0, 0.0], 200.0), square("b", [200.3, 0.2], 100.0), square("b", [200.0, 100.0], 100.0)], snap: 1.0 };
    let topology = topology(&map);
    let shared: Vec<[Option<usize>; 2]> = topology.edges.iter().map(|edge| edge.regions).filter(|regions| regions.iter().all(Option::is_some)).collect();
    assert_eq!(shared.len(), 3, "{topology:?}");
    assert_eq!(topology.merged, [0, 1, 1]);
    let refined = refine(&topology, &|_, _| 0.2, Refinement { spacing: 10.0, seed: 0 });
    for (edge, curve) in topology.edges.iter().zip(&refined.curves) {
        let seam = matches!(edge.regions, [Some(0), Some(_)] | [Some(_), Some(0)]);
        assert_eq!(curve.len() > 2, seam, "{edge:?}");
    }
}

#[test]
fn holes_are_filled_by_others() {
    let mut outer = square("a", [0.0, 0.0], 300.0);
    outer.rings.push(vec![[100.0, 100.0], [200.0, 100.0], [200.0, 200.0], [100.0, 200.0]]);
    let map = Map { regions: vec![outer, square("b", [100.0, 100.0], 100.0)], snap: 1.0 };
    assert_eq!(topology(&map).edges.iter().filter(|edge| edge.regions.iter().all(Option::is_some)).count(), 4);
}

#[test]
fn wrong_maps_are_refused_with_the_place() {
    let refused = |regions: Vec<MapRegion>, pointer: &str, says: &str| {
        let problem = Map { regions, snap: 1.0 }.topology().expect_err(says);
        assert!(problem.pointer == pointer && problem.detail.contains(says), "{problem:?}");
    };
    refused(vec![], "/regions", "at least one");
    refused(vec![square("a", [0.0, 0.0], 100.0), square("b", [50.0, 50.0], 100.0)], "/regions/0", "crosses that of region 1");
    refused(vec![square("a", [0.0, 0.0], 100.0), square("b", [0.0, 0.0], 100.0)], "/regions/1", "overlaps region 0");
    refused(vec![square("a", [0.0, 0.0], 100.0), square("b", [20.0, 20.0], 30.0)], "/regions/1", "overlaps region 0 at");
    refused(vec![square("a", [0.0, 0.0], 0.5)], "/regions/0", "fewer than three places");
    let sliver = MapRegion { kind: "a".to_owned(), rings: vec![vec![[0.0, 0.0], [100.0, 0.4], [50.0, 0.9]]] };
    refused(vec![sliver], "/regions/0", "sliver at");
    refused(vec![square("a", [0.0, 0.0], 100.0), square("b", [101.5, 0.0], 100.0)], "/regions/0", "narrow gap to region 1 at [100.0, 50.0]");
    refused(vec![square("a", [0.0, 0.0], f64::NAN)], "/regions/0", "no place");
}

#[test]
fn a_map_is_read_from_its_own_form_and_from_geojson() {
    let own = br#"{"regions": [{"type": "a", "rings": [[[0, 0], [9, 0], [9, 9]]]}, {"type": "b", "rings": [[[9, 0], [20, 0], [9, 9]]]}], "snap": 0.5}"#;
    let collection = br#"{"type": "FeatureCollection", "snap": 0.5, "features": [
        {"type": "Feature", "properties": {"type": "a", "name": "left"}, "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9]]]}},
        {"type": "Feature", "properties": {"type": "b"}, "geometry": {"type": "MultiPolygon", "coordinates": [[[[9, 0], [20, 0], [9, 9]]]]}}]}"#;
    let map = Map::parse(own).unwrap_or_else(|problem| panic!("{problem:?}"));
    assert_eq!(Map::parse(collection), Ok(map));
    let problem = |json: &str| Map::parse(json.as_bytes()).expect_err("wrong").pointer;
    assert_eq!(problem(r#"{"regions": [{"type": "a", "rings": [[[0, "x"]]]}]}"#), "/regions/0/rings/0/0/1");
    assert_eq!(problem(r#"{"type": "Feature", "features": []}"#), "/type");
    assert_eq!(problem(r#"{"type": "FeatureCollection", "features": [{"geometry": {"type": "Polygon", "coordinates": []}}]}"#), "/features/0/properties/type");
}
