//! What roads must keep, over terrains that are formulas.

use super::{
    super::plane::{Point, along, minus, nearest, unit},
    *,
};
use crate::{
    geometry::{Elevation, Filter, Shape, Surface},
    layout::{Feature, Layout, Options, Selection},
};
use std::sync::Arc;

/// Ground and depth of water at a place.
struct Formula<F>(F);

impl<F: Fn(f64, f64) -> [f64; 2]> Source for Formula<F> {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        let half = if window.filter == Filter::Band { 0.5 * window.spacing() } else { 0.0 };
        let mut i = 0;
        for y in window.rows.coordinates() {
            for x in window.columns.coordinates() {
                let [ground, depth] = (self.0)(x, y);
                surface.elevation[i] = ground as f32;
                if let Some(out) = surface.water_depth.get_mut(i) {
                    *out = depth as f32;
                    // Water anywhere in the sample's square is seen.
                    let near = (-4..=4).flat_map(|dy| (-4..=4).map(move |dx| [dx, dy].map(|d| f64::from(d) * half / 4.0)));
                    surface.water_cover[i] = near.filter(|[dx, dy]| (self.0)(x + dx, y + dy)[1] > 0.0).count() as f32 / 81.0;
                }
                i += 1;
            }
        }
    }
}

/// Hills of 60 m, too steep to go straight.
fn hills(x: f64, y: f64) -> [f64; 2] {
    [40.0 * libm::sin(x / 130.0) * libm::cos(y / 170.0) + 20.0 * libm::sin(x / 61.0 + y / 47.0), 0.0]
}

/// A river 20 m wide along x = 700 in a flat land with a bank of 2 m.
fn river(x: f64, _: f64) -> [f64; 2] {
    let away = (x - 700.0).abs();
    if away < 10.0 { [5.0, 3.0] } else { [10.0 + 0.01 * x, 0.0] }
}

fn places(list: &[[f64; 2]]) -> Vec<Place> {
    list.iter().enumerate().map(|(i, &at)| Place { name: format!("place {i}"), at }).collect()
}

/// Small enough for debug builds.
fn roads() -> Roads {
    Roads { spacing: Some(30.0), ..Roads::default() }
}

fn grade_of(line: &[[f64; 3]]) -> f64 {
    line.windows(2).map(|pair| (pair[1][2] - pair[0][2]).abs() / distance([pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]])).fold(0.0, f64::max)
}

#[test]
fn roads_over_hills_keep_to_the_grade_and_join_all_places() {
    let places = places(&[[0.0, 0.0], [900.0, 200.0], [450.0, 800.0], [-200.0, 700.0]]);
    for grade in [0.08, 0.12] {
        let built = Roads { grade, ..roads() }.build(&Formula(hills), &places).expect("roads");
        for road in &built {
            assert!(!road.is_bridge && grade_of(&road.line) <= grade * (1.0 + 1e-9), "{}", grade_of(&road.line));
            assert!((road.grade - grade_of(&road.line)).abs() < 1e-9 && road.cut < 15.0 && road.fill < 15.0, "{} {}", road.cut, road.fill);
        }
        assert!(built.iter().any(|road| road.cut > 0.5) && built.iter().any(|road| road.fill > 0.5), "it cuts and it fills");
        // Ends that are one place are one point of space; all pieces hang together and reach every place at the height of its ground.
        let ends: Vec<[[f64; 3]; 2]> = built.iter().map(|road| [road.line[0], road.line[road.line.len() - 1]]).collect();
        for place in &places {
            let ground = f64::from(hills(place.at[0], place.at[1])[0] as f32);
            assert!(ends.iter().flatten().any(|end| *end == [place.at[0], place.at[1], ground]), "{place:?}");
        }
        let mut joined = vec![ends[0][0]];
        for _ in 0..ends.len() {
            let more: Vec<[f64; 3]> = ends.iter().filter(|ends| ends.iter().any(|end| joined.contains(end))).flatten().copied().collect();
            joined.extend(more);
            joined.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            joined.dedup();
        }
        assert!(ends.iter().flatten().all(|end| joined.contains(end)));
    }
}

#[test]
fn the_same_request_is_the_same_roads() {
    let places = places(&[[0.0, 0.0], [900.0, 200.0], [450.0, 800.0]]);
    let built = || roads().build(&Formula(hills), &places).expect("roads");
    assert_eq!(built(), built());
}

/// The distance of the nearest place of any road, and the road's elevation there.
fn nearest_of(built: &[Road], p: Point) -> [f64; 2] {
    let mut best = [f64::INFINITY, 0.0];
    for pair in built.iter().flat_map(|road| road.line.windows(2)) {
        let segment = [[pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]]];
        let t = nearest(p, segment);
        let away = distance(p, along(segment[0], t, minus(segment[1], segment[0])));
        if away < best[0] {
            best = [away, pair[0][2] + (pair[1][2] - pair[0][2]) * t];
        }
    }
    best
}

#[test]
fn a_road_levels_the_ground_across_its_width_and_leaves_what_is_beyond_its_shoulder() {
    let (parameters, places) = (roads(), places(&[[0.0, 0.0], [700.0, 500.0]]));
    let built = parameters.build(&Formula(hills), &places).expect("roads");
    let attributes = Arc::new(parameters.attributes().expect("attributes"));
    let feature = |road: &Road| {
        let shape = Shape::line(road.line.iter().map(|p| [p[0], p[1]]).collect(), Elevation::Vertices(road.line.iter().map(|p| p[2]).collect()));
        Feature::new(shape.expect("a line"), Arc::clone(&attributes)).expect("a feature")
    };
    let layout = Layout::new(built.iter().map(feature).collect(), Options::default()).expect("a layout");
    let at = |p: Point| f64::from(layout.at(p, 1.0, Filter::Exact, Some(hills(p[0], p[1])[0] as f32), &Selection::default()).elevation[0]);
    let (mut level, mut changed) = (0, 0.0_f64);
    for road in &built {
        for pair in road.line.windows(2) {
            let [a, b] = [[pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]]];
            let way = unit(minus(b, a));
            let middle = along(a, 0.5, minus(b, a));
            for side in [-2.9, -1.0, 0.0, 1.0, 2.9] {
                // On the inner side of a bend another piece of the road is nearer.
                let p = along(middle, side, [-way[1], way[0]]);
                let [away, height] = nearest_of(&built, p);
                assert!(away < 2.91 && (at(p) - height).abs() < 0.25, "{side} m aside: {} m for {height} m", at(p));
                level += 1;
            }
            changed = changed.max((at(middle) - hills(middle[0], middle[1])[0]).abs());
            let beyond = along(middle, 30.0, [-way[1], way[0]]);
            if nearest_of(&built, beyond)[0] > 15.1 {
                assert!((at(beyond) - hills(beyond[0], beyond[1])[0]).abs() < 1e-4);
            }
        }
    }
    assert!(level > 500 && changed > 1.0, "{level} {changed}");
}

#[test]
fn rivers_are_crossed_by_bridges_alone() {
    let (parameters, places) = (roads(), places(&[[400.0, 0.0], [1000.0, 90.0]]));
    let built = parameters.build(&Formula(river), &places).expect("roads");
    let bridges: Vec<&Road> = built.iter().filter(|road| road.is_bridge).collect();
    let [bridge] = bridges[..] else { panic!("{} bridges", bridges.len()) };
    assert!(bridge.length > 20.0 + 2.0 * parameters.reach() && bridge.length <= parameters.bridge, "{}", bridge.length);
    let over = bridge.line.iter().filter(|p| (p[0] - 700.0).abs() < 10.0);
    assert!(over.clone().count() > 2 && over.into_iter().all(|p| p[2] >= 8.0 + parameters.clearance - 1e-9));
    // What cuts and fills stays clear of the water.
    for road in built.iter().filter(|road| !road.is_bridge) {
        assert!(road.line.iter().all(|p| (p[0] - 700.0).abs() >= 10.0 + parameters.reach()), "{:?}", road.line);
    }
    assert!(built.windows(2).all(|pair| pair[0].line[pair[0].line.len() - 1] == pair[1].line[0]), "the pieces follow each other");
}

#[test]
fn what_cannot_be_built_is_said_with_the_places() {
    let said = |roads: Roads, list: &[[f64; 2]]| roads.build(&Formula(river), &places(list)).expect_err("refused").to_string();
    let two = [[400.0, 0.0], [1000.0, 90.0]];
    let no_bridge = said(Roads { bridge: 0.0, ..roads() }, &two);
    assert!(no_bridge.starts_with("roads.places[1]: no road leads from \"place 0\" to \"place 1\": water lies between"), "{no_bridge}");
    assert!(said(Roads { bridge: 45.0, ..roads() }, &two).contains("water lies between"), "20 m of water and twice 15 m of shoulder");
    assert_eq!(said(roads(), &[[400.0, 0.0], [705.0, 0.0]]), "roads.places[1]: \"place 1\" lies in the water or within 45 m of it");
    assert!(said(roads(), &[[400.0, 0.0], [404.0, 1.0]]).starts_with("roads.places[1]: \"place 1\" lies 4 m from \"place 0\", nearer than"));
    assert_eq!(said(roads(), &two[..1]), "roads.places: must be 2 to 64 places, got 1");
    assert!(said(roads(), &[[0.0, 0.0], [1e6, 1e6]]).starts_with("roads.spacing: "));
    assert_eq!(said(Roads { grade: 0.0, ..roads() }, &two), "roads.grade: must be a number from 0.005 to 1, got 0");
    let cliff = Formula(|x: f64, _: f64| [if x < 500.0 { 0.0 } else { 80.0 }, 0.0]);
    let steep = roads().build(&cliff, &places(&[[300.0, 0.0], [700.0, 0.0]])).expect_err("a cliff").to_string();
    assert!(steep.contains("steeper than the grade"), "{steep}");
}

#[test]
fn an_embankment_or_a_cutting_crosses_a_step_that_is_too_steep() {
    // 5 m over 10 m: a slope of a half.
    let step = Formula(|x: f64, _: f64| [5.0 * ((x - 495.0) / 10.0).clamp(0.0, 1.0), 0.0]);
    let built = roads().build(&step, &places(&[[300.0, 0.0], [700.0, 0.0]])).expect("a road");
    let [road] = &built[..] else { panic!("{} roads", built.len()) };
    assert!(grade_of(&road.line) <= 0.08 * (1.0 + 1e-9) && road.cut > 1.0 && road.fill > 1.0 && road.cut.max(road.fill) < 3.0, "{} {}", road.cut, road.fill);
    assert!(road.length < 420.0);
}
