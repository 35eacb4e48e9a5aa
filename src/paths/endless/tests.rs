//! Endless drawings: the same bits however they are cut, and the same terrain at every zoom.

use super::*;
use crate::{geometry::Axis, paths::document::Quantity};

/// Chains of mountains and a few craters.
fn drawing() -> EndlessDrawing {
    let json = r#"{
        "spacing": 60, "cell": 9000, "seed": 5, "deviation": 0.6, "sea_level_cost": 1500,
        "profiles": {
            "steep": {"points": [[0, 1], [0.14, 0.68], [0.42, 0.27], [0.82, 0.035], [1, 0]], "width": 2400},
            "soft": {"points": [[0, 1], [0.2, 0.9], [0.5, 0.5], [0.8, 0.1], [1, 0]], "width": 2000},
            "bowl": {"points": [[0, 1], [0.28, 0.52], [0.66, 0.1], [1, 0]], "width": 1500}
        },
        "strokes": [
            {"chains": {"count": [0, 2], "length": [3000, 6000], "spurs": 4}, "profiles": ["steep", "soft"], "cost": {"programme": "fbm(1, 2, 4)", "scale": 4000, "between": [0, 900]}},
            {"rings": {"count": [0, 1], "radius": [300, 1200]}, "profiles": ["soft"], "cost": 1100, "inside": {"profile": "bowl", "only": true}}
        ]
    }"#;
    serde_json::from_str(json).expect("a drawing")
}

fn endless() -> Endless {
    Endless::new(drawing(), 5).unwrap_or_else(|error| panic!("{error}"))
}

fn frame(column: i64, row: i64, columns: usize, rows: usize) -> Frame {
    Frame { first: Node { row, column }, columns, rows }
}

fn sampled(endless: &Endless, window: &Window) -> Vec<f32> {
    let mut out = vec![0.0; window.samples()];
    endless.add(window, &Stop::never(), &mut out);
    out
}

#[test]
fn chunks_of_any_size_in_any_order_have_the_same_bits() {
    let whole = endless().heights(0, &frame(-70, -40, 150, 110), &Stop::never());
    assert!(whole.iter().any(|height| *height > 300.0) && whole.contains(&0.0));
    for (columns, rows, backwards) in [(150, 110, false), (37, 23, false), (37, 23, true), (8, 110, true)] {
        let fresh = endless();
        let mut parts: Vec<[usize; 2]> = (0..110).step_by(rows).flat_map(|j| (0..150).step_by(columns).map(move |i| [i, j])).collect();
        if backwards {
            parts.reverse();
        }
        for [i, j] in parts {
            let (columns, rows) = (columns.min(150 - i), rows.min(110 - j));
            let part = fresh.heights(0, &frame(i as i64 - 70, j as i64 - 40, columns, rows), &Stop::never());
            for (k, height) in part.iter().enumerate() {
                let same = whole[(j + k / columns) * 150 + i + k % columns];
                assert_eq!(height.to_bits(), same.to_bits(), "node {k} of the part at {i}, {j}");
            }
        }
    }
}

#[test]
fn threads_share_what_they_find() {
    let (alone, shared) = (endless(), endless());
    let window = |k: i64| Window { columns: Axis::new(k * 16, 1, 90.0, 0.0, 32), rows: Axis::new(k * 8, -1, 90.0, 0.0, 32), filter: Filter::Band };
    let plain: Vec<Vec<f32>> = (0..6).map(|k| sampled(&alone, &window(k))).collect();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..6)
            .rev()
            .map(|k| {
                (
                    k,
                    scope.spawn({
                        let shared = &shared;
                        move || sampled(shared, &window(k))
                    }),
                )
            })
            .collect();
        for (k, thread) in threads {
            assert_eq!(thread.join().expect("no panic"), plain[k as usize]);
        }
    });
}

/// Without roughness the reach is what paths use, to the last step.
#[test]
fn a_search_needs_the_whole_reach() {
    let mut drawing = EndlessDrawing { deviation: 0.0, ..drawing() };
    drawing.strokes.truncate(1);
    drawing.strokes[0].profiles.truncate(1);
    drawing.strokes[0].cost = Quantity::Number(0.0);
    let endless = Endless::new(drawing, 5).unwrap_or_else(|error| panic!("{error}"));
    let (mesh, rule) = (&endless.meshes[0], &endless.rules[0]);
    let place = Place { rule: 0, cell: [0, 0], number: 0, profile: rule.profiles[0], lines: vec![vec![[0.0, 0.0]]] };
    let end = (endless.drawing.sea_level_cost - endless.drawing.sea_threshold) as f32;
    let shown = |margin: usize| {
        let patch = Patch::within(mesh, endless.drawing.diagonal, endless.drawing.sea_level_cost as f32, &place, rule, margin);
        let mut nodes = Vec::new();
        patch.costs(&frame(-200, -200, 401, 401), |node, cost| nodes.extend((cost < end).then_some((node, cost.to_bits()))));
        nodes
    };
    assert!(mesh.reach > 20);
    assert_eq!(shown(mesh.reach), shown(mesh.reach + 9));
    assert!(shown(mesh.reach - 1).len() < shown(mesh.reach).len());
}

#[test]
fn zooms_finer_than_nodes_share_their_samples() {
    let endless = endless();
    let at = |spacing: f64, count: usize, filter| {
        sampled(&endless, &Window { columns: Axis::new(0, 1, spacing, -900.0, count), rows: Axis::new(0, -1, spacing, 1200.0, count), filter })
    };
    let (coarse, fine, exact) = (at(60.0, 20, Filter::Band), at(15.0, 80, Filter::Band), at(15.0, 80, Filter::Exact));
    assert_eq!(fine, exact);
    for j in 0..20 {
        for i in 0..20 {
            assert_eq!(coarse[j * 20 + i].to_bits(), fine[4 * j * 80 + 4 * i].to_bits());
        }
    }
}

#[test]
fn a_parent_looks_like_its_children() {
    let endless = endless();
    let relief = f64::from(endless.highest());
    for k in 0..7 {
        let spacing = 90.0 * f64::from(1 << k);
        let window = |spacing: f64, count: usize| Window {
            columns: Axis::new(1, 2, spacing / 2.0, 1000.0, count),
            rows: Axis::new(-1, -2, spacing / 2.0, 500.0, count),
            filter: Filter::Band,
        };
        let (parent, child) = (sampled(&endless, &window(2.0 * spacing, 32)), sampled(&endless, &window(spacing, 64)));
        let reduced =
            |i: usize, j: usize| [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[a, b]| f64::from(child[(2 * j + b) * 64 + 2 * i + a])).iter().sum::<f64>() / 4.0;
        let squares: f64 = (0..32 * 32)
            .map(|n| {
                let difference = f64::from(parent[n]) - reduced(n % 32, n / 32);
                difference * difference
            })
            .sum();
        let rms = (squares / 1024.0).sqrt() / relief;
        // While the layer fades into its mean, the parent has lost more of it than the child.
        let most = if 2.0 * spacing < CONSTANT[0] * endless.drawing.cell { 0.02 } else { 0.12 };
        assert!(rms < most, "{spacing}: {rms}");
    }
}

/// Whole chunks are counted, on both lattices that a spacing fades between.
#[test]
fn no_tile_touches_more_than_four_million_nodes() {
    let endless = endless();
    for z in 0..=24 {
        let spacing = 156_543.033_928_040_97 / f64::from(1 << z);
        let (steps, share, constant) = endless.detail(spacing, Filter::Band);
        if constant >= 1.0 {
            continue;
        }
        let of = |step: &usize| {
            let level = endless.level(*step);
            let frame = endless.touched(level, step - level, [0.0, 0.0], [256.0 * spacing; 2]);
            let chunks = |first: i64, count: usize| (first + count as i64 - 1).div_euclid(CHUNK as i64) - first.div_euclid(CHUNK as i64) + 1;
            (chunks(frame.first.column, frame.columns) * chunks(frame.first.row, frame.rows)) as usize * CHUNK * CHUNK
        };
        let nodes: usize = steps[..if share > 0.0 { 2 } else { 1 }].iter().map(of).sum();
        assert!(nodes <= 4_000_000, "level {z}: {nodes} nodes");
    }
}

#[test]
fn the_far_plane_is_as_the_near() {
    let endless = endless();
    for origin in [0.0, 1_099_511_000_000.0, -1_099_511_000_000.0] {
        let window = Window { columns: Axis::new(0, 1, 120.0, origin, 200), rows: Axis::new(0, -1, 120.0, -origin, 200), filter: Filter::Band };
        let heights = sampled(&endless, &window);
        let mean = heights.iter().sum::<f32>() / heights.len() as f32;
        assert!(mean > 0.2 * endless.mean && mean < 5.0 * endless.mean, "{origin}: {mean} of {}", endless.mean);
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let refused = |change: &dyn Fn(&mut EndlessDrawing), pointer: &str| {
        let mut drawing = drawing();
        change(&mut drawing);
        let error = Endless::new(drawing, 5).expect_err(pointer);
        assert_eq!(error.pointer, pointer, "{error}");
    };
    refused(&|drawing| drawing.deviation = 1.0, "/deviation");
    refused(&|drawing| drawing.sea_level_cost = f64::NAN, "/sea_level_cost");
    refused(&|drawing| drawing.deviation = 0.999_999, "/profiles");
    refused(&|drawing| drawing.spacing = 6.0, "/profiles");
    refused(&|drawing| drawing.strokes[0].cost = Quantity::Number(f64::INFINITY), "/strokes/0/cost");
    refused(&|drawing| drawing.strokes[0].profiles[0] = "none".to_owned(), "/strokes/0/profiles/0");
    refused(&|drawing| drawing.strokes[1].rings = None, "/strokes/1");
    refused(&|drawing| drawing.strokes.clear(), "/strokes");
    let long = Chains { count: [1, 1], length: [90_000.0, 90_000.0], wander: 0.4, spurs: 0 };
    refused(
        &|drawing| {
            drawing.cell = 200_000.0;
            drawing.strokes[0].chains = Some(long.clone());
        },
        "/strokes",
    );
}
