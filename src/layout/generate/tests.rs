//! What generated layouts must keep.

use super::{
    plane::{Area, Point, crossing, distance},
    read::{flat, lines, rings},
    *,
};
use crate::{
    geometry::{Elevation, Filter, Rectangle, Shape},
    layout::{Feature, Layout, Options, Role, Selection},
};

/// An island small enough for debug builds: some 250 features.
fn small() -> Island {
    let mut island = Island::ridges_rivers_and_lakes();
    island.landmass.radius = 6_000.0;
    island.rivers.rounds = 3;
    island
}

fn styles(seed: u64) -> Styles {
    Styles::for_spacing(Rivers::default().spacing, seed).unwrap()
}

fn features(seed: u64) -> Vec<Feature> {
    small().features(seed, &styles(seed)).unwrap()
}

/// The drawn lines of the features of one precedence.
fn drawn(features: &[Feature], precedence: i32) -> Vec<Vec<[f64; 3]>> {
    let own: Vec<Feature> = features.iter().filter(|feature| feature.precedence == precedence).cloned().collect();
    lines(&own).into_iter().map(|water| water.line).collect()
}

// The precedences that `Styles::for_spacing` gives.
const LAND: i32 = 0;
const RIDGES: i32 = 10;
const RIVERS: i32 = 20;
const LAKES: i32 = 30;

#[test]
fn a_seed_is_a_layout() {
    let hashes = |seed| features(seed).iter().map(Feature::hash).collect::<Vec<_>>();
    assert_eq!(hashes(3), hashes(3));
    assert_ne!(hashes(3), hashes(4));
}

#[test]
fn rivers_fall_all_the_way_to_the_sea() {
    for seed in 1..6 {
        let features = features(seed);
        let (rivers, lakes) = (drawn(&features, RIVERS), drawn(&features, LAKES));
        let shore = drawn(&features, LAND).concat();
        assert!(rivers.len() > 60 && !lakes.is_empty(), "seed {seed}: {} rivers, {} lakes", rivers.len(), lakes.len());
        for river in &rivers {
            assert!(river.windows(2).all(|pair| pair[0][2] > pair[1][2]), "seed {seed}: {river:?}");
            let mouth = river[river.len() - 1];
            let goes_on = rivers.iter().any(|next| next[0] == mouth) || lakes.iter().any(|lake| lake.contains(&mouth)) || shore.contains(&mouth);
            assert!(goes_on, "seed {seed}: {mouth:?} is no confluence, lake or vertex of the shore");
        }
    }
}

#[test]
fn lakes_are_flat_and_one_river_leaves_each_at_its_level() {
    for seed in 1..6 {
        let features = features(seed);
        let rivers = drawn(&features, RIVERS);
        for lake in drawn(&features, LAKES) {
            assert!(lake.iter().all(|p| p[2] == lake[0][2]));
            let leaving = rivers.iter().filter(|river| lake.contains(&river[0])).count();
            let entering = rivers.iter().filter(|river| lake.contains(&river[river.len() - 1])).count();
            assert_eq!(leaving, 1);
            assert!(entering >= 1);
            assert!(landmass::is_simple(&flat(&lake)));
        }
    }
}

#[test]
fn widths_grow_downstream() {
    let features = features(1);
    let half_width = |feature: &Feature| {
        feature.attributes().iter().find_map(|attribute| if let Role::Channel { half_width } = attribute.role { Some(half_width) } else { None })
    };
    let rivers: Vec<(Vec<[f64; 3]>, f64)> = features
        .iter()
        .filter(|feature| feature.precedence == RIVERS)
        .map(|feature| (lines(std::slice::from_ref(feature))[0].line.clone(), half_width(feature).unwrap()))
        .collect();
    let widest = rivers.iter().map(|river| river.1).fold(0.0, f64::max);
    assert!(widest > 2.0 * rivers.iter().map(|river| river.1).fold(f64::INFINITY, f64::min));
    for (line, width) in &rivers {
        for (_, below) in rivers.iter().filter(|(below, _)| below[0] == line[line.len() - 1]) {
            assert!(below >= width);
        }
    }
}

/// Whether two lines cross other than where they share a vertex.
fn cross(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    let (a, b) = (flat(a), flat(b));
    a.windows(2).any(|p| b.windows(2).any(|q| !p.iter().any(|end| q.contains(end)) && crossing([p[0], p[1]], [q[0], q[1]]).is_some()))
}

#[test]
fn nothing_crosses_and_ridges_stand_on_dry_land() {
    for seed in 1..4 {
        let features = features(seed);
        let closed = |rings: Vec<Vec<[f64; 3]>>| {
            rings
                .into_iter()
                .map(|mut ring| {
                    ring.push(ring[0]);
                    ring
                })
                .collect::<Vec<_>>()
        };
        let (rivers, ridges) = (drawn(&features, RIVERS), drawn(&features, RIDGES));
        let (lakes, shore) = (closed(drawn(&features, LAKES)), closed(drawn(&features, LAND)));
        assert!(ridges.len() > 30);
        let waters: Vec<_> = [rivers.clone(), lakes.clone(), shore.clone()].concat();
        for (i, water) in waters.iter().enumerate() {
            assert!(waters[..i].iter().all(|other| !cross(water, other)), "seed {seed}");
            assert!(ridges.iter().all(|ridge| !cross(ridge, water)), "seed {seed}");
        }
        let outline: Vec<Vec<Point>> = shore.iter().map(|ring| flat(&ring[1..])).collect();
        let land = Area::of(outline.iter().map(Vec::as_slice), 500.0);
        assert!(ridges.iter().flatten().all(|p| land.contains([p[0], p[1]])));
        assert!(rivers.iter().flat_map(|river| &river[..river.len() - 1]).all(|p| land.contains([p[0], p[1]])));
    }
}

#[test]
fn a_ridge_is_higher_than_the_water_beside_it() {
    let features = features(2);
    let waters: Vec<[f64; 3]> = [drawn(&features, RIVERS), drawn(&features, LAKES), drawn(&features, LAND)].concat().concat();
    for p in drawn(&features, RIDGES).concat() {
        let nearest = waters.iter().min_by(|a, b| distance([a[0], a[1]], [p[0], p[1]]).total_cmp(&distance([b[0], b[1]], [p[0], p[1]]))).unwrap();
        assert!(p[2] > nearest[2], "{p:?} beside {nearest:?}");
    }
}

/// The water's surface at a place, evaluated as a layout of what reaches it.
fn water(layout: &Layout, p: Point) -> f64 {
    let mut found = Vec::new();
    layout.find(&Rectangle { min: p, max: p }, &mut found);
    let near = found.iter().map(|&number| layout.features()[number as usize].clone()).collect();
    let surface = Layout::new(near, layout.options().clone()).unwrap().at(p, 1.0, Filter::Exact, None, &Selection::default());
    f64::from(surface.elevation[0]) + f64::from(surface.water_depth[0])
}

#[test]
fn the_waters_surface_falls_along_the_fractal_path_of_a_river() {
    let layout = Layout::new(features(5), Options { sea_level: Some(0.0), ..Options::default() }).unwrap();
    let rivers = layout.features().iter().filter(|feature| feature.precedence == RIVERS);
    for river in rivers.step_by(8) {
        let path = river.shape().curve().unwrap().expanded().unwrap();
        // Every vertex: they are a few metres apart, about a quarter of a width.
        let mut lowest = f64::INFINITY;
        for &p in path.vertices() {
            let level = water(&layout, p);
            assert!(level <= lowest + 1e-3, "{level} above {lowest} at {p:?}");
            lowest = lowest.min(level);
        }
    }
}

#[test]
fn a_drawn_river_keeps_its_course_and_gets_a_mouth_and_tributaries() {
    let styles = styles(1);
    let land = small().landmass.features(1, &styles.land).unwrap();
    let course = vec![[-3_000.0, 100.0], [-1_000.0, 0.0], [1_000.0, 400.0]];
    let hand = Feature::new(Shape::line(course.clone(), Elevation::Constant(0.0)).unwrap(), styles.rivers.attributes.clone()).unwrap();
    let rivers = small().rivers.features(&land, &[hand], None, 1, &styles.rivers).unwrap();
    let all: Vec<[f64; 3]> = lines(&rivers).into_iter().flat_map(|water| water.line).collect();
    assert!(course.iter().all(|p| all.iter().any(|q| [q[0], q[1]] == *p)), "its vertices are vertices of rivers");
    let main = lines(&rivers).into_iter().filter(|water| water.line.iter().any(|p| course.contains(&[p[0], p[1]]))).count();
    assert!(main > 3, "tributaries part it into {main} reaches");
    assert!(rings(&land)[0].iter().any(|vertex| lines(&rivers).iter().any(|water| water.line.last() == Some(vertex))));
}

#[test]
fn conflicts_are_cut_or_removed_by_precedence() {
    let set = styles(1).ridges.attributes;
    let line = |points: Vec<[f64; 2]>, precedence| {
        let mut feature = Feature::new(Shape::line(points, Elevation::Constant(1.0)).unwrap(), set.clone()).unwrap();
        feature.precedence = precedence;
        feature
    };
    let pond = |precedence| {
        let ring = vec![[4.0, -2.0], [8.0, -2.0], [8.0, 2.0], [4.0, 2.0], [4.0, -2.0]];
        let mut feature = Feature::new(Shape::polygon(vec![ring], Elevation::Constant(1.0)).unwrap(), set.clone()).unwrap();
        feature.precedence = precedence;
        feature
    };
    let ridge = line(vec![[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]], 1);
    let river = line(vec![[15.0, -5.0], [15.0, 5.0]], 2);
    let all = vec![ridge.clone(), pond(3), river.clone()];
    let removed = resolve(&all, Conflict::Remove).unwrap();
    assert_eq!(removed, [pond(3), river.clone()]);
    let cut = resolve(&all, Conflict::Cut { clearance: 1.0 }).unwrap();
    let pieces: Vec<Vec<Point>> = lines(&cut[..3]).iter().map(|water| flat(&water.line)).collect();
    assert_eq!(pieces, [vec![[0.0, 0.0], [3.0, 0.0]], vec![[9.0, 0.0], [10.0, 0.0], [14.0, 0.0]], vec![[16.0, 0.0], [20.0, 0.0]]]);
    assert_eq!(resolve(&[ridge.clone(), line(vec![[20.0, 0.0], [25.0, 9.0]], 2)], Conflict::Remove).unwrap().len(), 2, "sharing a vertex is no conflict");
    assert_eq!(resolve(&[pond(1), ridge], Conflict::Remove).unwrap().len(), 2, "lines do not remove polygons, and equals do not conflict");
}

#[test]
fn bad_parameters_are_named() {
    let check = |change: fn(&mut Island), expected: &str| {
        let mut island = small();
        change(&mut island);
        let message = island.features(1, &styles(1)).unwrap_err().to_string();
        assert!(message.starts_with(expected), "{message}");
    };
    check(|island| island.landmass.radius = f64::NAN, "landmass.radius: must be a number from 1 to 10000000, got NaN");
    check(|island| island.landmass.centre[1] = 1e14, "landmass.centre[1]:");
    check(|island| island.landmass.corners = 2, "landmass.corners:");
    check(|island| island.landmass.iterations = 11, "landmass.iterations:");
    check(|island| island.landmass.variation = 1.0, "landmass.variation:");
    check(|island| island.rivers.spacing = 0.0, "rivers.spacing:");
    check(|island| island.rivers.spacing = 2.0, "rivers.spacing: about");
    check(|island| island.rivers.rounds = 0, "rivers.rounds:");
    check(|island| island.rivers.attempts = 0, "rivers.attempts:");
    check(|island| island.rivers.concavity = -0.1, "rivers.concavity:");
    check(|island| island.lakes = Some(Lakes { share: 1.1, ..Lakes::default() }), "lakes.share:");
    check(|island| island.lakes = Some(Lakes { size: 0.5, ..Lakes::default() }), "lakes.size:");
    check(|island| island.ridges.slope = 0.0, "ridges.slope:");
    check(|island| island.ridges.variation = 2.0, "ridges.variation:");
    assert!(Styles::for_spacing(f64::INFINITY, 1).unwrap_err().to_string().starts_with("styles.spacing:"));
    assert!(resolve(&[], Conflict::Cut { clearance: 0.0 }).unwrap_err().to_string().starts_with("conflict.clearance:"));
    let point = Feature::new(Shape::point([0.0, 0.0], Some(1.0)).unwrap(), styles(1).land.attributes).unwrap();
    let rivers = small().rivers.features(std::slice::from_ref(&point), &[], None, 1, &styles(1).rivers);
    assert!(rivers.unwrap_err().to_string().starts_with("rivers.land[0]:"));
    assert!(small().ridges.features(&[], &[point], 1, &styles(1).ridges).unwrap_err().to_string().starts_with("ridges.waters[0]:"));
}

#[test]
fn an_outline_never_crosses_itself() {
    for seed in 0..200 {
        let land = Landmass { corners: 3 + seed as usize % 9, variation: 0.9, displacement: 0.35, iterations: 4, ..Landmass::default() };
        assert!(landmass::is_simple(&land.outline(seed).unwrap()), "seed {seed}");
    }
}
