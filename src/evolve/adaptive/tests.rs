//! The behaviour that is promised of adaptive terrain.
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use super::*;
use crate::{
    genetic::Draws,
    geometry::{Filter, Rectangle, Source, Surface, Window},
};

fn adaptive(seed: u64) -> Adaptive {
    Adaptive::new(Ground { seed, ..Ground::default() }).expect("the ground is right")
}

/// Plane metres of a node.
fn place(terrain: &AdaptiveTerrain, ground: &Ground, node: usize) -> [f64; 2] {
    let columns = terrain.size()[0];
    [ground.origin[0] + (node % columns) as f64 * ground.cell, ground.origin[1] + (node / columns) as f64 * ground.cell]
}

/// The inner node around which 9 × 9 heights differ least.
fn flattest(terrain: &AdaptiveTerrain) -> usize {
    let [columns, rows] = terrain.size();
    let spread = |node: usize| {
        let around = (0..9).flat_map(|j| &terrain.nodes()[node - 4 + j * columns - 4 * columns..][..9]);
        let [low, high] = around.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &h| [low.min(h), high.max(h)]);
        high - low
    };
    let inner = (0..columns * rows).filter(|node| (4..columns - 4).contains(&(node % columns)) && (4..rows - 4).contains(&(node / columns)));
    inner.min_by(|&a, &b| spread(a).total_cmp(&spread(b))).expect("nodes")
}

fn highest(terrain: &AdaptiveTerrain) -> usize {
    (0..terrain.nodes().len()).max_by(|&a, &b| terrain.nodes()[a].total_cmp(&terrain.nodes()[b])).expect("nodes")
}

/// Clicks thirty times; the deviation about the first click before it, and about the last after it.
fn click(adaptive: &mut Adaptive, choose: fn(&AdaptiveTerrain) -> usize) -> [f64; 2] {
    let mut deviations = [0.0; 2];
    for i in 0..30 {
        let before = adaptive.terrain(adaptive.current()).expect("a generation");
        let node = choose(&before);
        let y = f64::from(before.nodes()[node]);
        if i == 0 {
            deviations[0] = before.deviation(y);
        }
        let point = place(&before, &adaptive.history().ground.clone(), node);
        let newest = adaptive.feed(Feedback::point(point)).expect("on the terrain");
        deviations[1] = adaptive.terrain(newest).expect("a generation").deviation(y);
    }
    deviations
}

#[test]
fn clicks_on_flat_ground_make_it_flat_and_clicks_on_peaks_raise_it_again() {
    let mut rugged = 0;
    for seed in 0..20 {
        let mut adaptive = adaptive(seed);
        let [first, flat] = click(&mut adaptive, flattest);
        let [_, peaks] = click(&mut adaptive, highest);
        let spread = |generation: usize| adaptive.terrain(generation).expect("a generation").deviation(100.0);
        println!(
            "seed {seed}: {first:.1} m, flat {flat:.1} m ({:.2}), peaks {peaks:.1} m ({:.2}); about the mean {:.1}, {:.1}, {:.1} m",
            flat / first,
            peaks / first,
            spread(0),
            spread(30),
            spread(60)
        );
        assert!(flat < first / 3.0, "seed {seed}: {flat} of {first}");
        assert!(peaks >= first / 2.0, "seed {seed}: {peaks} of {first}");
        rugged += usize::from(spread(60) > 1.5 * spread(30));
    }
    // Not about a far height alone: the ground itself is rugged again, where it has not become a plain at the height of the peaks.
    assert!(rugged >= 15, "{rugged} of 20");
}

#[test]
fn a_history_gives_the_same_heights_and_any_generation_again() {
    let mut adaptive = Adaptive::new(Ground { seed: 5, populations: 3, lines: 11, length: 20, ..Ground::default() }).expect("the ground is right");
    let mut terrains = vec![adaptive.terrain(0).expect("the first")];
    for i in 0..100_u32 {
        if i % 17 == 5 {
            adaptive.go_to(adaptive.current() / 2, &Players::default()).expect("nobody is there");
        }
        let mut feedback = if i % 3 == 0 { Feedback::height(f64::from(40 + i)) } else { Feedback::point([f64::from(10 * i), 333.0]) };
        feedback.radius = (i % 3 == 1).then_some(200.0);
        if i % 4 == 2 {
            feedback.ways.push(vec![[f64::from(i), 100.0], [500.0, 300.0]]);
        }
        adaptive.feed(feedback).expect("on the terrain");
        terrains.push(adaptive.terrain(adaptive.current()).expect("the newest"));
    }
    let json = serde_json::to_string(adaptive.history()).expect("JSON");
    let replayed = Adaptive::replay(History::parse(json.as_bytes()).expect("a history")).expect("a history");
    for (generation, terrain) in terrains.iter().enumerate() {
        assert_eq!(adaptive.terrain(generation).expect("a generation"), *terrain, "kept or bred again: {generation}");
        assert_eq!(replayed.terrain(generation).expect("a generation"), *terrain, "replayed: {generation}");
    }
    assert_eq!(replayed.current(), adaptive.current());
}

#[test]
fn trees_and_heights_stay_within_their_bounds() {
    let ground = Ground { seed: 2, nodes: 40, range: [60.0, 130.0], populations: 2, ..Ground::default() };
    let mut lines = population::first(&ground);
    for generation in 1..60 {
        lines = population::bred(&ground, &lines, &[if generation % 2 == 0 { 30.0 } else { -40.0 }, 5.0], generation);
        for line in &lines {
            assert!(line.0.len() <= 40 && line.0[0].arity == 2, "{} nodes", line.0.len());
            let open = line.0.iter().fold(1, |open, node| open + usize::from(node.arity) - 1);
            assert_eq!(open, 0, "a whole tree");
        }
        assert!(lattice::heights(&ground, &lines).iter().all(|height| (60.0..=130.0).contains(height)));
    }
}

/// The rule itself: 30 % are replaced by children, the least fit; the fittest live on; a line keeps its place.
#[test]
fn the_least_fit_are_replaced_in_their_places() {
    let ground = Ground { mutation: 0.0, unlike: 0.0, lines: 40, ..Ground::default() };
    let lines = population::first(&ground);
    let next = population::bred(&ground, &lines, &[10.0], 1);
    let mut order: Vec<usize> = (0..40).collect();
    order.sort_by(|&a, &b| lines[a].fitness(33, &[10.0]).total_cmp(&lines[b].fitness(33, &[10.0])));
    assert!(order[..28].iter().all(|&line| next[line] == lines[line]));
    let changed = order[28..].iter().filter(|&&line| next[line] != lines[line]).count();
    assert!(changed >= 11, "{changed} of 12");
    assert_eq!(population::deviation(&ground, &[0.5]), 4.0);
    assert_eq!(population::deviation(&ground, &[-30.0]), 30.0);
    assert_eq!(population::deviation(&ground, &[90.0]), 50.0);
}

#[test]
fn feedback_off_the_terrain_is_refused_and_changes_nothing() {
    let mut adaptive = adaptive(3);
    adaptive.feed(Feedback::height(120.0)).expect("within the range");
    let before = (adaptive.history().clone(), adaptive.terrain(1).expect("a generation"));
    let mut check = |feedback: Feedback, at: &str| assert_eq!(adaptive.feed(feedback).expect_err("wrong").at, at);
    check(Feedback::point([-0.1, 0.0]), "/points/0");
    check(Feedback { points: vec![[5.0, 5.0], [5.0, 1280.1]], ..Feedback::default() }, "/points/1");
    check(Feedback::point([f64::NAN, 0.0]), "/points/0");
    check(Feedback::height(200.1), "/heights/0");
    check(Feedback::default(), "");
    check(Feedback { radius: Some(5.0), ..Feedback::height(100.0) }, "/points");
    check(Feedback { radius: Some(0.0), ..Feedback::point([5.0, 5.0]) }, "/radius");
    check(Feedback { ways: vec![vec![[0.0, 0.0], [f64::INFINITY, 0.0]]], ..Feedback::height(100.0) }, "/ways/0/1");
    assert_eq!((adaptive.history().clone(), adaptive.terrain(1).expect("a generation")), before);
    assert!(adaptive.terrain(2).is_err());
    for (json, at) in [
        (r#"{"form": 1, "ground": {"lines": 3}}"#, "/ground/lines"),
        (r#"{"form": 1, "ground": {"mean": 300}}"#, "/ground/mean"),
        (r#"{"form": 1, "ground": {"passes": 6, "lines": 1000, "length": 1000}}"#, "/ground"),
        (r#"{"form": 1, "steps": [{"from": 1, "feedback": {"heights": [100]}}]}"#, "/steps/0/from"),
        (r#"{"form": 1, "steps": [{"from": 0, "feedback": {"height": [100]}}]}"#, "/steps/0/feedback/height"),
        (r#"{"form": 1, "current": 1}"#, "/current"),
    ] {
        assert_eq!(History::parse(json.as_bytes()).expect_err("wrong").at, at, "{json}");
    }
}

fn sampled(terrain: &AdaptiveTerrain, window: &Window) -> Vec<f32> {
    let mut surface = Surface::of(window);
    terrain.sample(window, &mut surface);
    surface.elevation
}

#[test]
fn local_feedback_changes_nothing_beyond_its_radius() {
    let mut adaptive = adaptive(8);
    let (centre, radius) = ([600.0, 500.0], 400.0);
    adaptive.feed(Feedback { radius: Some(radius), ..Feedback::point(centre) }).expect("on the terrain");
    let [old, new] = [0, 1].map(|generation| adaptive.terrain(generation).expect("a generation"));
    let whole = {
        let mut whole = self::adaptive(8);
        whole.feed(Feedback::point(centre)).expect("on the terrain");
        whole.terrain(1).expect("a generation")
    };
    let (mut inside, mut changed) = (0, 0);
    for node in 0..old.nodes().len() {
        let [x, y] = place(&old, &Ground::default(), node);
        let distance = ((x - centre[0]) * (x - centre[0]) + (y - centre[1]) * (y - centre[1])).sqrt();
        let [before, after, all] = [&old, &new, &whole].map(|terrain| terrain.nodes()[node]);
        if distance >= radius {
            assert_eq!(before.to_bits(), after.to_bits());
        } else if distance <= radius / 2.0 {
            assert_eq!(after, all);
            (inside, changed) = (inside + 1, changed + usize::from(before != after));
        }
    }
    assert!(changed * 20 > inside, "{changed} of {inside}");
}

/// Random walks of several players: samples within the promise of where they went are the same to the bit, exact and at spacings up to the cell.
#[test]
fn nothing_changes_around_players() {
    let ground = Ground { seed: 4, origin: [-317.0, 44.0], promise: 37.0, fade: 3, mutation: 0.5, ..Ground::default() };
    let mut adaptive = Adaptive::new(ground.clone()).expect("the ground is right");
    let mut players = Players::default();
    let (mut draws, mut seen, mut changed) = (Draws::new(99), 0, 0);
    for walk in 0..60 {
        for player in ["one", "two", "three"] {
            let mut at = [draws.between(-350.0, 900.0), draws.between(0.0, 1300.0)];
            for _ in 0..draws.below(4) {
                players.go(player, at).expect("in the plane");
                at = [at[0] + 60.0 * draws.normal(), at[1] + 60.0 * draws.normal()];
            }
            players.go(player, at).expect("in the plane");
        }
        let (ways, before) = (players.ways(), adaptive.terrain(adaptive.current()).expect("a generation"));
        let y = draws.between(10.0, 190.0);
        adaptive.feed(Feedback { ways: ways.clone(), ..Feedback::height(y) }).expect("within the range");
        let after = adaptive.terrain(adaptive.current()).expect("a generation");
        for way in &ways {
            for _ in 0..40 {
                let part = draws.below(way.len());
                let [from, to] = [way[part], way[(part + 1).min(way.len() - 1)]];
                let (t, angle, distance) = (draws.unit(), draws.between(0.0, 6.3), ground.promise * draws.unit().sqrt());
                let on = |axis: usize| from[axis] + t * (to[axis] - from[axis]);
                let point = [on(0) + distance * libm::cos(angle), on(1) + distance * libm::sin(angle)];
                for (spacing, filter) in [(0.3, Filter::Band), (10.0, Filter::Band), (1000.0, Filter::Exact)] {
                    let window = Window::point(point[0], point[1], spacing, filter).expect("in the plane");
                    let [was, is] = [&before, &after].map(|terrain| sampled(terrain, &window)[0]);
                    assert_eq!(was.to_bits(), is.to_bits(), "walk {walk} at {point:?}, spacing {spacing}");
                    seen += 1;
                }
            }
        }
        changed += before.nodes().iter().zip(after.nodes()).filter(|(a, b)| a != b).count();
        players.rest();
    }
    assert!(seen > 20_000 && changed > 60 * 500, "{seen} samples, {changed} nodes changed elsewhere");
    // A player stands there: no way back; when all have left there is.
    players.go("one", [0.0, 100.0]).expect("in the plane");
    assert_eq!(adaptive.go_to(3, &players).expect_err("somebody is there").at, "/generation");
    for player in ["one", "two", "three"] {
        assert!(players.leave(player));
    }
    adaptive.go_to(3, &players).expect("nobody is there");
    assert_eq!((adaptive.current(), adaptive.generations()), (3, 61));
}

/// The frozen zone is the promise and two cells, no more: just beyond it ground may change.
#[test]
fn the_frozen_zone_is_the_promise_and_two_cells() {
    let ground = Ground { promise: 40.0, fade: 0, ..Ground::default() };
    let mut weights = vec![1.0; 129 * 129];
    players::thaw(&ground, &[vec![[600.0, 600.0]], vec![[100.0, 100.0], [300.0, 100.0]]], ground.promise, &mut weights);
    let at = |column: usize, row: usize| weights[row * 129 + column];
    assert_eq!([at(60, 66), at(60, 67), at(66, 60), at(67, 60)], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!([at(20, 16), at(20, 17), at(36, 10), at(37, 10)], [0.0, 1.0, 0.0, 1.0]);
    // Across a corner: of the square of two cells, then of the disc.
    assert_eq!([at(64, 64), at(65, 65)], [0.0, 1.0]);
}

/// Beyond the rectangle that changed all samples are the same, at any spacing.
#[test]
fn what_changed_holds_every_sample_that_differs() {
    let mut adaptive = adaptive(8);
    adaptive.feed(Feedback { radius: Some(120.0), ..Feedback::point([600.0, 500.0]) }).expect("on the terrain");
    let [old, new] = [0, 1].map(|generation| adaptive.terrain(generation).expect("a generation"));
    for (spacing, filter) in [(3.0, Filter::Band), (10.0, Filter::Band), (17.0, Filter::Band), (45.0, Filter::Band), (45.0, Filter::Exact)] {
        let window = Window::area([-200.0, -200.0, 1500.0, 1500.0], spacing, filter, 1 << 20).expect("a window");
        let changed = old.changed(&new, spacing, filter);
        assert!(changed.min[0] > 200.0 && changed.max[0] < 1000.0, "{changed:?}");
        let (a, b) = (sampled(&old, &window), sampled(&new, &window));
        let mut differ = 0;
        for (row, y) in window.rows.coordinates().enumerate() {
            for (column, x) in window.columns.coordinates().enumerate() {
                let i = row * window.columns.len() + column;
                if a[i].to_bits() != b[i].to_bits() {
                    differ += 1;
                    assert!(changed.holds([x, y]), "{x} {y} at {spacing}, beyond {changed:?}");
                }
            }
        }
        assert!(differ > 0);
    }
    let everywhere = {
        adaptive.feed(Feedback::height(150.0)).expect("within the range");
        new.changed(&adaptive.terrain(2).expect("a generation"), 10.0, Filter::Band)
    };
    assert!(everywhere.min[1] == f64::NEG_INFINITY && everywhere.max[1] == f64::INFINITY, "lines reach from border to border");
    assert!(!old.changed(&old, 10.0, Filter::Band).meets(&old.area()));
}

#[test]
fn samples_on_nodes_are_their_heights_and_none_is_beyond_its_neighbours() {
    let terrain = adaptive(6).terrain(0).expect("the first");
    let window = Window::vertices([0.0, 0.0, 1280.0, 1280.0], 10.0, Filter::Band, 1 << 20).expect("a window");
    let samples = sampled(&terrain, &window);
    let northern: Vec<f32> = terrain.nodes().chunks(129).rev().flatten().copied().collect();
    assert_eq!(samples, northern);
    for spacing in [1.7, 33.0, 700.0] {
        let window = Window::area([-100.0, -100.0, 1400.0, 1400.0], spacing, Filter::Band, 1 << 20).expect("a window");
        let [low, high] = terrain.range();
        assert!(sampled(&terrain, &window).iter().all(|height| (low - 1e-3..=high + 1e-3).contains(height)));
    }
    assert_eq!(terrain.height([1280.0, 0.0]), Some(terrain.nodes()[128]));
    assert_eq!(terrain.height([1280.1, 0.0]), None);
}

/// What follows from a history is part of what it is: the same on every machine and with every version of its form.
#[test]
fn a_history_gives_what_it_always_gave() {
    let mut adaptive = adaptive(7);
    for height in [120.0, 60.0, 101.0] {
        adaptive.feed(Feedback::height(height)).expect("within the range");
    }
    let terrain = adaptive.terrain(3).expect("a generation");
    let digest = terrain.nodes().iter().fold(0, |digest, height| crate::noise::key(digest, height.to_bits().into()));
    assert_eq!(digest, 2_678_345_519_401_204_429);
}

/// A generation by itself is the one of a history, however it came to be.
#[test]
fn generations_are_those_of_their_history() {
    let ground = Ground { seed: 5, populations: 2, lines: 11, length: 20, ..Ground::default() };
    let mut adaptive = Adaptive::new(ground.clone()).expect("the ground is right");
    let mut generation = Generation::first(&ground).expect("the ground is right");
    assert_eq!(generation.hash(), ground.hash());
    for i in 0..30_u32 {
        let mut feedback = if i % 3 == 0 { Feedback::height(f64::from(40 + i)) } else { Feedback::point([f64::from(10 * i), 333.0]) };
        feedback.radius = (i % 3 == 1).then_some(200.0);
        if i % 4 == 2 {
            feedback.ways.push(vec![[f64::from(i), 100.0], [500.0, 300.0]]);
        }
        let newest = adaptive.feed(feedback.clone()).expect("on the terrain");
        let next = generation.next(&feedback).expect("on the terrain");
        assert_eq!((next.number(), next.terrain()), (newest, &adaptive.terrain(newest).expect("a generation")));
        let read = Generation::from_bytes(next.ground(), next.hash(), next.number(), &next.to_bytes()).expect("its own bytes");
        assert_eq!(read, next);
        assert_ne!(next.hash(), generation.hash());
        generation = read;
    }
    assert_ne!(generation.next(&Feedback::height(100.0)).expect("bred").hash(), generation.next(&Feedback::height(101.0)).expect("bred").hash());
    let wrong = generation.next(&Feedback::point([-1.0, 0.0])).expect_err("off the terrain");
    assert_eq!(wrong.at, "/points/0");

    // Bytes that are cut off, too long, of other trees or of another ground are refused.
    let bytes = generation.to_bytes();
    let read = |bytes: &[u8]| Generation::from_bytes(generation.ground(), generation.hash(), 30, bytes);
    for wrong in [&bytes[..bytes.len() - 1], &[&bytes[..], &[0]].concat(), &[], &[&[9], &bytes[1..]].concat()] {
        assert!(read(wrong).is_err());
    }
    for at in (0..bytes.len()).step_by(97) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        // No panic: other heights may be those of a ground, too.
        let _ = read(&damaged);
    }
    assert!(Generation::from_bytes(&Ground { lines: 12, ..ground }.into(), "", 1, &bytes).is_err());
}

#[test]
fn levels_are_counted_as_subtrees_say() {
    for line in population::first(&Ground { seed: 9, ..Ground::default() }) {
        for at in 0..line.0.len() {
            assert_eq!(line.level(at), (0..at).filter(|&above| line.subtree(above).contains(&at)).count());
        }
    }
}

/// Row by row only what lies near a way is looked at; a plain look at every node says the same.
#[test]
fn what_is_frozen_is_what_every_distance_says() {
    let mut draws = Draws::new(4);
    for case in 0..60 {
        let ground = Ground { promise: draws.between(0.0, 300.0), fade: draws.below(9), origin: [-200.0, 90.0], ..Ground::default() };
        let scale = [40.0, 900.0, 1e6][case % 3];
        let mut point = || [600.0 + scale * draws.normal(), 500.0 + scale * draws.normal()];
        let ways: Vec<Vec<[f64; 2]>> =
            vec![vec![point()], vec![point(), point(), point()], vec![[300.0, 400.0], [300.0, point()[1]]], vec![[1.0, 700.0], [point()[0], 700.0]]];
        let size = ground.size();
        let (mut fast, mut plain) = (vec![1.0; size[0] * size[1]], vec![1.0_f32; size[0] * size[1]]);
        players::thaw(&ground, &ways, ground.promise, &mut fast);
        let fade = ground.fade as f64 * ground.cell;
        for (node, weight) in plain.iter_mut().enumerate() {
            let seen = players::seen_from(&ground, [node % size[0], node / size[0]], 2.0 * ground.cell);
            for [from, to] in ways.iter().flat_map(|way| players::parts(way)) {
                let beyond = players::to_box(from, to, &seen) - ground.promise;
                let own = if beyond <= 1e-6 * ground.cell { 0.0 } else { players::smooth(if fade > 0.0 { beyond / fade } else { 1.0 }) };
                *weight = weight.min(own);
            }
        }
        assert_eq!(fast, plain, "case {case}");
        assert!(case % 3 > 0 || plain.contains(&0.0));
    }
}

/// The name of what is seen changes if and only if a node that samples see does; and where it does not, samples are the same.
#[test]
fn what_is_seen_is_named_to_the_node() {
    let mut adaptive = adaptive(8);
    adaptive.feed(Feedback { radius: Some(120.0), ..Feedback::point([600.0, 500.0]) }).expect("on the terrain");
    let [old, new] = [0, 1].map(|generation| adaptive.terrain(generation).expect("a generation"));
    let (mut draws, mut kept, mut changed) = (Draws::new(3), 0, 0);
    for _ in 0..3000 {
        let spacing = [0.7, 4.0, 10.0, 17.0, 40.0, 90.0][draws.below(6)];
        let filter = if draws.chance(0.3) { Filter::Exact } else { Filter::Band };
        let (side, corner) = (draws.between(1.0, 30.0) * spacing, [draws.between(-100.0, 1300.0), draws.between(-100.0, 1300.0)]);
        let window = Window::vertices([corner[0], corner[1], corner[0] + side, corner[1] + side], spacing, filter, 1 << 20).expect("a window");
        let area = window.bounds();
        let same = old.seen(&area, spacing, filter) == new.seen(&area, spacing, filter);
        let [before, after] = [&old, &new].map(|terrain| sampled(terrain, &window));
        if same {
            assert_eq!(before, after);
            kept += 1;
        } else {
            changed += 1;
            // A node of a level that is seen does differ.
            assert!(old.changed(&new, spacing, filter).grown(4.0 * spacing.max(10.0)).meets(&area));
        }
    }
    assert!(kept > 300 && changed > 300, "{kept} {changed}");
    assert_eq!(
        old.seen(&Rectangle::EVERYTHING, 0.0, Filter::Exact),
        adaptive.terrain(0).expect("a generation").seen(&Rectangle::EVERYTHING, 0.0, Filter::Exact)
    );
    // Whole blocks are named by their names, and those follow from their nodes alone.
    let node = 40 * 129 + 70;
    let mut nodes = old.nodes().to_vec();
    nodes[node] += 1.0;
    let other = AdaptiveTerrain::new(&Ground { seed: 8, ..Ground::default() }, nodes.into());
    for (area, differs) in [
        (Rectangle { min: [0.0; 2], max: [1280.0; 2] }, true),
        (Rectangle { min: [720.0, 420.0], max: [730.0, 430.0] }, false),
        (Rectangle { min: [719.0, 419.0], max: [730.0, 430.0] }, true),
        (Rectangle { min: [0.0, 0.0], max: [680.0 - 1e-9, 1280.0] }, false),
    ] {
        assert_eq!(old.seen(&area, 10.0, Filter::Band) != other.seen(&area, 10.0, Filter::Band), differs, "{area:?}");
    }
}
