//! Shapes against brute force and by hand.

use super::*;

/// Numbers in 0 … 1 that look random.
fn random(count: usize, seed: u64) -> impl Iterator<Item = f64> {
    let mut state = seed;
    std::iter::repeat_with(move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 9_007_199_254_740_992.0
    })
    .take(count)
}

fn square(x: f64, y: f64, side: f64) -> Vec<[f64; 2]> {
    vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
}

fn polygon(rings: Vec<Vec<[f64; 2]>>) -> Result<Shape, ShapeError> {
    Shape::polygon(rings, Elevation::Constant(5.0))
}

fn at(shape: &Shape, x: f64, y: f64) -> (f64, f64) {
    let nearest = shape.nearest([x, y], 0.0);
    (nearest.distance, nearest.elevation)
}

#[test]
fn distances_and_elevations_are_those_of_the_nearest_place() {
    let point = Shape::point([1.0, 2.0], Some(7.0)).expect("valid");
    assert_eq!(at(&point, 4.0, 6.0), (5.0, 7.0));
    let circle = Shape::circle([0.0, 0.0], 3.0, None).expect("valid");
    assert_eq!((at(&circle, 0.0, 5.0), at(&circle, 0.0, 1.0)), ((2.0, 0.0), (-2.0, 0.0)));
    let line = Shape::line(vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]], Elevation::Vertices([0.0, 10.0, 30.0].into())).expect("valid");
    assert_eq!((at(&line, 2.5, -4.0), at(&line, 12.0, 5.0), at(&line, -3.0, 4.0)), ((4.0, 2.5), (2.0, 20.0), (5.0, 0.0)));
    let ring = polygon(vec![square(0.0, 0.0, 10.0), square(4.0, 4.0, 2.0)]).expect("valid");
    assert_eq!((at(&ring, 1.0, 5.0), at(&ring, 5.0, 5.0), at(&ring, 13.0, 14.0)), ((-1.0, 5.0), (1.0, 5.0), (5.0, 5.0)));
    assert_eq!(line.bounds(3.0), super::super::Rectangle { min: [-3.0, -3.0], max: [13.0, 13.0] });
}

#[test]
fn an_edge_is_the_same_in_both_directions() {
    let numbers: Vec<f64> = random(600, 3).map(|r| r * 200.0 - 100.0).collect();
    for n in numbers.chunks_exact(6) {
        let (a, b, p) = ([n[0], n[1]], [n[2], n[3]], [n[4], n[5]]);
        assert_eq!(Edge::new(a, b).nearest(p), Edge::new(b, a).nearest(p));
        assert_eq!(crosses(p, a, b), crosses(p, b, a));
        let detail = Detail::new(5, 0.2, 9).expect("valid");
        for way in [Along::Chord, Along::Arc] {
            let line = |vertices, elevations| match Shape::line(vertices, Elevation::Vertices(elevations)).and_then(|line| line.detailed(detail)) {
                Ok(Shape::Line(curve)) => Shape::Line(curve.along(way)),
                other => panic!("{other:?}"),
            };
            let (there, back) = (line(vec![a, b], [1.0, 5.0].into()), line(vec![b, a], [5.0, 1.0].into()));
            assert_eq!(there.nearest(p, 0.0), back.nearest(p, 0.0));
        }
    }
}

#[test]
fn static_and_lazy_detail_are_the_same_to_the_bit() {
    let numbers: Vec<f64> = random(2_000, 5).collect();
    for (far, n) in [0.0, 1e6, 1e11].into_iter().flat_map(|far| numbers.chunks_exact(40).map(move |n| (far, n))).step_by(7) {
        let vertices: Vec<[f64; 2]> = n[..10].chunks(2).map(|c| [far + c[0] * 100.0, c[1] * 100.0 - far]).collect();
        let elevations = n[10..15].iter().map(|r| r * 1_000.0).collect();
        let detail = Detail::new((n[15] * 9.0) as u8, n[16] * 0.5, (n[17] * 1e9) as u64).expect("valid");
        let line = Shape::line(vertices, Elevation::Vertices(elevations)).and_then(|line| line.detailed(detail)).expect("valid");
        let Shape::Line(curve) = line else { panic!("a line") };
        for way in [Along::Chord, Along::Arc] {
            let lazy = curve.clone().along(way);
            let plain = Shape::Line(lazy.expanded().expect("few vertices"));
            let bounds = lazy.bounds();
            assert!(plain.curve().is_some_and(|curve| curve.vertices().iter().all(|&v| bounds.holds(v))), "detail leaves its bounds");
            let lazy = Shape::Line(lazy);
            for c in n[18..].chunks_exact(2) {
                let p = [far + c[0] * 200.0 - 50.0, c[1] * 200.0 - 50.0 - far];
                assert_eq!(lazy.nearest(p, 0.0), plain.nearest(p, 0.0));
            }
        }
    }
}

#[test]
fn detail_stays_within_reach_and_keeps_the_vertices() {
    for (iterations, displacement) in [(1, 0.5), (6, 0.25), (10, 0.1), (9, 1.0)] {
        let detail = Detail::new(iterations, displacement, 4).expect("valid");
        let (a, b) = ([3.0, 7.0], [-60.0, 40.0]);
        let (edge, chord) = (detail.of_edge(a, b, 0.0), Edge::new(a, b));
        let mut path = Vec::new();
        edge.expand(&mut path);
        assert_eq!((path.len(), path[0], path[path.len() - 1]), ((1 << iterations) + 1, b, a), "from the lexicographically first end on");
        let far = path.iter().map(|&p| chord.nearest(p).0.sqrt()).fold(0.0, f64::max);
        let reach = detail.reach(a, b);
        assert!(far <= reach && far > reach * 0.01, "{far} m of {reach} m");
    }
}

/// One iteration fades at a time, and where it is gone nothing moves.
#[test]
fn detail_fades_with_the_spacing() {
    let detail = Detail::new(6, 0.3, 1).expect("valid");
    let (a, b) = ([0.0, 0.0], [64.0, 0.0]);
    let path = |spacing: f64| {
        let mut path = Vec::new();
        detail.of_edge(a, b, spacing).expand(&mut path);
        path
    };
    assert_eq!([32.1, 32.0, 16.0, 15.9, 8.0, 0.5].map(|spacing| path(spacing).len()), [2, 2, 3, 5, 5, 65]);
    assert_eq!(path(8.0), path(0.0).into_iter().step_by(16).collect::<Vec<_>>(), "segments of two spacings are there in full");
    let mut last = path(40.0);
    for step in 1..4_000 {
        let next = path(40.0 - f64::from(step) / 100.0);
        if next.len() == last.len() {
            let moved = next.iter().zip(&last).map(|(p, q)| (p[0] - q[0]).abs().max((p[1] - q[1]).abs())).fold(0.0, f64::max);
            assert!(moved < 0.05, "{moved} m at step {step}");
        }
        last = next;
    }
}

#[test]
fn rivers_turn_less_than_backwards() {
    assert!((Detail::river_bound(8) - 0.0995).abs() < 1e-4);
    assert_eq!(Detail::river(8, 0.2, 1), Err(ShapeError::River { displacement: 0.2, bound: Detail::river_bound(8), iterations: 8 }));
    for seed in 0..200 {
        let detail = Detail::river(8, Detail::river_bound(8), seed).expect("at the bound");
        let mut path = Vec::new();
        detail.of_edge([0.0, 0.0], [100.0, 0.0], 0.0).expand(&mut path);
        assert!(path.windows(2).all(|ends| ends[0][0] <= ends[1][0] + 1e-9), "seed {seed} runs backwards");
    }
}

#[test]
fn what_is_wrong_is_named() {
    let line = |vertices: &[[f64; 2]], elevation| Shape::line(vertices.to_vec(), elevation).expect_err("wrong");
    assert!(matches!(line(&[[0.0, 0.0], [f64::NAN, 0.0]], Elevation::Absent), ShapeError::Coordinate { vertex: 1, .. }));
    assert!(matches!(line(&[[0.0, 0.0], [1.0, 0.0], [0.0, 2e12]], Elevation::Absent), ShapeError::Coordinate { vertex: 2, .. }));
    assert_eq!(line(&[[0.0, 0.0]], Elevation::Absent), ShapeError::TooFew { kind: "line", vertex: 0, vertices: 1, least: 2 });
    assert_eq!(line(&[[0.0, 0.0], [1.0, 0.0]], Elevation::Vertices([1.0, f64::NAN].into())), ShapeError::Elevation { vertex: 1 });
    assert_eq!(line(&[[0.0, 0.0], [1.0, 0.0]], Elevation::Vertices([1.0].into())), ShapeError::Elevations { elevations: 1, vertices: 2 });
    assert_eq!(line(&vec![[0.0, 0.0]; MAX_VERTICES + 1], Elevation::Absent), ShapeError::TooMany { vertices: MAX_VERTICES + 1, limit: MAX_VERTICES });
    let wrong = |rings| polygon(rings).expect_err("wrong");
    assert_eq!(wrong(vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]]), ShapeError::Open { vertex: 3, first: 0 });
    let bow = vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0], [0.0, 0.0]];
    assert_eq!(wrong(vec![bow]), ShapeError::Crossing { vertex: 0, other: 2 });
    let spike = vec![[0.0, 0.0], [4.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 0.0]];
    assert_eq!(wrong(vec![spike]), ShapeError::Crossing { vertex: 0, other: 1 });
    let touch = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0], [0.0, 0.0]];
    assert_eq!(wrong(vec![touch]), ShapeError::Crossing { vertex: 0, other: 2 });
    assert_eq!(wrong(vec![square(0.0, 0.0, 4.0), square(2.0, 2.0, 4.0)]), ShapeError::Crossing { vertex: 1, other: 5 });
    assert_eq!(wrong(vec![square(0.0, 0.0, 4.0), square(12.0, 2.0, 4.0)]), ShapeError::Hole { vertex: 5 });
    assert_eq!(wrong(vec![square(0.0, 0.0, 9.0), square(1.0, 1.0, 6.0), square(2.0, 2.0, 1.0)]), ShapeError::Hole { vertex: 10 });
    assert!(polygon(vec![square(0.0, 0.0, 4.0), vec![[0.0, 0.0], [1.0, 2.0], [2.0, 1.0], [0.0, 0.0]]]).is_ok(), "a hole may touch in a point");
    assert_eq!(Shape::circle([0.0, 0.0], -1.0, None), Err(ShapeError::Radius(-1.0)));
    assert_eq!((Detail::new(21, 0.1, 0), Detail::new(3, 1.5, 0)), (Err(ShapeError::Iterations(21)), Err(ShapeError::Displacement(1.5))));
    assert_eq!(Shape::point([0.0, 0.0], None).expect("valid").detailed(Detail::new(3, 0.1, 0).expect("valid")), Err(ShapeError::NoEdges));
}

/// A star of many vertices, wound so tightly that its edges' rectangles overlap.
#[test]
fn a_large_polygon_is_checked_quickly() {
    let count = 20_000;
    let ring = |i: usize| {
        let (angle, radius) = (std::f64::consts::TAU * i as f64 / count as f64, if i.is_multiple_of(2) { 900.0 } else { 1_000.0 });
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mut vertices: Vec<[f64; 2]> = (0..count).map(ring).collect();
    vertices.push(vertices[0]);
    assert!(polygon(vec![vertices.clone()]).is_ok());
    vertices[10_000] = [1_500.0, 0.0];
    assert!(matches!(polygon(vec![vertices]), Err(ShapeError::Crossing { .. })));
}
