//! Drawings against their plain meaning, and their limits.

use super::*;
use crate::geometry::{Filter, Stop, Window};
use serde_json::json;

/// The drawings that ship, by name.
fn presets() -> Vec<(String, Drawing)> {
    let read = |preset: &PresetDrawing| Drawing::parse(preset.json.as_bytes()).unwrap_or_else(|error| panic!("{}: {error}", preset.name));
    PRESET_DRAWINGS.iter().map(|preset| (preset.name.to_owned(), read(preset))).collect()
}

/// On a fourth as many nodes a side; sketches, whose pictures have one size, stay as they are.
fn small(drawing: Drawing) -> Drawing {
    let sketched = drawing.strokes.iter().any(|group| matches!(group.shape, Shape::Sketch(_)));
    if sketched { drawing } else { Drawing { size: [128, 128], spacing: 4.0, ..drawing } }
}

fn ready(name: &str, drawing: &Drawing) -> Plan {
    Plan::new(drawing).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn heights(plan: &Plan) -> Vec<f32> {
    plan.blend(&Stop::never(), &|_| {}).0
}

/// Two lines with the profile of a cone, and what else is given.
fn lines(fields: &str, coordinates: &str) -> Drawing {
    let json = format!(
        r#"{{"size": [160, 120], "edges": {{"random": {{"mean": 1, "deviation": 0}}}}, "sea_level": {{"cost": 60}}, {fields}
        "profiles": {{"cone": {{"points": [[0, 1], [1, 0]], "width": 60}}}},
        "strokes": [{{"shape": {{"geometry": {{"type": "MultiLineString", "coordinates": {coordinates}}}}}, "profiles": ["cone"], "cost": 10}}]}}"#
    );
    Drawing::parse(json.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_preset_is_its_plain_meaning_to_the_bit() {
    for (name, drawing) in presets() {
        let plan = ready(&name, &small(drawing));
        let (plain, heights) = (plan.reference(), heights(&plan));
        let differ = plain.iter().zip(&heights).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differ, 0, "{name}: of {} slots", plain.len());
        assert!(heights.iter().any(|height| *height > 0.0), "{name}");
    }
}

/// So flat a profile that buckets would be too many and are sorted.
#[test]
fn buckets_that_are_sorted_give_the_same_bits() {
    let mut drawing = small(presets().swap_remove(10).1);
    drawing.edges = Edges::Random { mean: 0.75, deviation: 0.749_999 };
    let plan = ready("hills", &drawing);
    assert!(plan.terrain().least_step() < 1e-4);
    assert_eq!(plan.reference(), heights(&plan));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let drawing = small(presets().swap_remove(15).1);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| Plan::new(&drawing).expect("a plan").heights(&Stop::never(), &|_| {}))
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(5));
}

/// A lattice without border: a drawing's own nodes are the same whatever margin is around, as long as paths cannot use it.
#[test]
fn what_strokes_do_not_reach_changes_nothing() {
    let drawing = lines("", "[[[70, 60], [90, 60]]]");
    let (bounded, unbounded) = (Plan::new(&drawing).expect("a plan"), Plan::unbounded(&drawing).expect("a plan"));
    assert!(unbounded.reach() >= 49, "{}", unbounded.reach());
    let [bounded, unbounded] = [bounded, unbounded].map(|plan| plan.heights(&Stop::never(), &|_| {}));
    let margin = (-unbounded.first.column) as usize;
    for row in 0..120 {
        let own = &bounded.metres[row * 160..][..160];
        let other = &unbounded.metres[(row + margin) * unbounded.columns + margin..][..160];
        assert_eq!(own, other, "row {row}");
    }
}

#[test]
fn a_stroke_alone_is_itself_and_many_are_between_mean_and_maximum() {
    let at = |fields: &str, coordinates: &str| Plan::new(&lines(fields, coordinates)).expect("a plan").heights(&Stop::never(), &|_| {}).metres;
    let (west, east) = ("[[60, 20], [60, 100]]", "[[95, 20], [95, 100]]");
    let alone = [west, east].map(|line| at("", &format!("[{line}]")));
    for (b, together) in [(0.0, 0.5), (1000.0, 1.0)] {
        let both = at(&format!("\"bias\": {b}, \"approximate_threshold\": 0.000001,"), &format!("[{west}, {east}]"));
        for column in 50..110 {
            let n = 60 * 160 + column;
            let (one, other) = (alone[0][n], alone[1][n]);
            // Where both are far above where they fade.
            if one.min(other) > 2.0 {
                let wanted = if together == 1.0 { one.max(other) } else { f32::midpoint(one, other) };
                assert!((both[n] - wanted).abs() < 1e-3 * wanted, "b {b}, column {column}: {} for {wanted}", both[n]);
            }
        }
    }
    // At its crest it has its own height.
    assert!((alone[0][60 * 160 + 60] - 50.0).abs() < 1e-4);
}

/// Where a stroke counts hardly any more, taking it away changes the terrain by at most 1 %.
#[test]
fn no_step_shows_where_searches_end() {
    for (name, drawing) in presets().into_iter().filter(|(name, _)| !name.starts_with("edge")) {
        for bias in [0.0, 3.0, 8.0] {
            let drawing = Drawing { bias: Quantity::Number(bias), ..small(drawing.clone()) };
            let plan = ready(&name, &drawing);
            let (whole, blending) = (heights(&plan), plan.blending());
            let blender = Blender::new(plan.terrain(), blending, &plan.field(), &plan.shut);
            let mut seen = 0;
            for left_out in [0, plan.strokes.len() / 2] {
                let mut others = plan.strokes.clone();
                let stroke = others.remove(left_out);
                let without = blender.heights(&others, &Stop::never(), &|_| {}).0;
                for Label { slot, cost } in blender.labels(&stroke) {
                    let (slot, height) = (slot as usize, blending.sea_level_cost - cost);
                    if height < 1.05 * blender.end(slot) {
                        seen += 1;
                        let most = 0.01 * whole[slot].max(2.0 * blending.sea_threshold);
                        assert!((whole[slot] - without[slot]).abs() <= most, "{name}, b {bias}, slot {slot}: {} and {}", whole[slot], without[slot]);
                    }
                }
            }
            assert!(seen > 0, "{name}");
        }
    }
}

/// The profiles of all presets along straight and diagonal flanks of an edge without roughness.
#[test]
fn flanks_have_the_profiles_that_were_drawn() {
    for (name, drawing) in presets() {
        for (profile, written) in &drawing.profiles {
            let Some(points) = &written.points else { continue };
            let shape = Profile::new(points, written.width).expect("a profile");
            let json = json!({
                "size": [401, 401], "edges": {"random": {"mean": 1, "deviation": 0}}, "sea_level": {"cost": 60}, "profiles": {"own": written},
                "strokes": [{"shape": {"geometry": {"type": "Point", "coordinates": [200, 200]}}, "profiles": ["own"], "cost": 12}]
            });
            let flat = Drawing::parse(json.to_string().as_bytes()).expect("a drawing");
            let metres = Plan::new(&flat).expect("a plan").heights(&Stop::never(), &|_| {}).metres;
            let k = (60.0 - 12.0) / 60.0;
            for (steps, length) in [([1_usize, 0_usize], 1.0), ([0, 1], 1.0), ([1, 1], core::f64::consts::SQRT_2)] {
                for i in 1..190 {
                    let distance = i as f64 * length;
                    let wanted = k * 60.0 * shape.height(distance / k / written.width);
                    // Below this strokes are cut off.
                    if wanted > 2.5 {
                        let height = f64::from(metres[(200 - i * steps[1]) * 401 + 200 + i * steps[0]]);
                        assert!((height - wanted).abs() <= 0.02 * k * 60.0, "{name}, {profile}, {distance} nodes: {height} for {wanted}");
                    }
                }
            }
        }
    }
}

#[test]
fn distances_are_those_to_the_nearest() {
    let canvas = canvas::Canvas::new(&lines("", "[[[70, 60], [90, 60]]]"), 3);
    let some: canvas::Slots = (0..40).map(|n| canvas.by_chance(9, n)).collect();
    let squares = canvas.squared_distances(&some);
    let place = |slot: u32| canvas.frame.node(slot as usize);
    for slot in (0..canvas.frame.slots() as u32).step_by(7) {
        let to = |other: &u32| {
            let (a, b) = (place(slot), place(*other));
            ((a.column - b.column).pow(2) + (a.row - b.row).pow(2)) as f64
        };
        assert_eq!(squares[slot as usize], some.iter().map(to).fold(f64::INFINITY, f64::min), "slot {slot}");
    }
    assert!(canvas.squared_distances(&canvas::Slots::new()).iter().all(|square| *square == f64::INFINITY));
}

#[test]
fn nodes_keep_their_heights_at_every_finer_zoom() {
    let drawing = lines("", "[[[40, 30], [90, 80]], [[100, 20], [100, 90]]]");
    let heights = Plan::unbounded(&drawing).expect("a plan").heights(&Stop::never(), &|_| {});
    let (first, columns, rows, metres) = (heights.first, heights.columns, heights.rows, heights.metres.clone());
    let raster = heights.raster(&drawing);
    let at = |x: f64, y: f64, spacing: f64| {
        let mut out = [0.0];
        raster.add(&Window::point(x, y, spacing, Filter::Band).expect("a point"), &Stop::never(), &mut out);
        out[0]
    };
    for spacing in [1.0, 0.5, 0.01] {
        for n in (0..metres.len()).step_by(97) {
            let (x, y) = ((n % columns) as f64 + first.column as f64, (rows - 1 - n / columns) as f64 + first.row as f64);
            assert_eq!(at(x, y, spacing).to_bits(), metres[n].to_bits(), "node {x}, {y}");
        }
    }
    // From afar it keeps its volume.
    let volume: f64 = metres.iter().map(|height| f64::from(*height)).sum();
    for spacing in [2.0, 3.0, 8.0, 20.0] {
        let window = Window::area([-400.0, -400.0, 600.0, 600.0], spacing, Filter::Band, 1 << 22).expect("a window");
        let mut out = vec![0.0; window.samples()];
        raster.add(&window, &Stop::never(), &mut out);
        let seen: f64 = out.iter().map(|height| f64::from(*height) * spacing * spacing).sum();
        assert!((seen / volume - 1.0).abs() < 0.03, "{spacing} m: {seen} of {volume}");
    }
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let refused = |change: &dyn Fn(&mut serde_json::Value), pointer: &str| {
        let mut json = serde_json::to_value(lines("", "[[[70, 60], [90, 60]]]")).expect("JSON");
        change(&mut json);
        let error = Drawing::parse(json.to_string().as_bytes()).and_then(|drawing| Plan::unbounded(&drawing)).map(|plan| plan.strokes()).expect_err(pointer);
        assert_eq!(error.pointer, pointer, "{error}");
        assert!(!error.detail.is_empty());
    };
    refused(&|drawing| drawing["edges"] = json!({"random": {"mean": 1, "deviation": 1}}), "/edges/random/deviation");
    refused(&|drawing| drawing["edges"] = json!({"random": {"mean": 0, "deviation": 0}}), "/edges/random/mean");
    refused(&|drawing| drawing["strokes"][0]["shape"]["geometry"]["coordinates"] = json!([]), "/strokes");
    refused(&|drawing| drawing["strokes"][0]["shape"]["geometry"]["coordinates"] = json!([[[1e9, 0]]]), "/strokes/0/shape/geometry/coordinates/0/0");
    refused(&|drawing| drawing["strokes"][0]["cost"] = json!({"programme": "divide(1, x)", "scale": 1, "between": [3, "x"]}), "/strokes/0/cost");
    refused(&|drawing| drawing["strokes"][0]["cost"] = json!({"programme": "fmb(1, 2, 3)"}), "/strokes/0/cost/programme");
    refused(&|drawing| drawing["strokes"][0]["cost"] = json!({"programme": "3", "between": [1, 2]}), "/strokes/0/cost/programme");
    refused(&|drawing| drawing["profiles"]["cone"]["points"] = json!([[0, 1], [0.5, 1.2], [1, 0]]), "/profiles/cone/points");
    refused(&|drawing| drawing["profiles"]["cone"]["points"] = json!([[0, 1], [0.5, 0.2], [0.5, 0]]), "/profiles/cone/points");
    refused(&|drawing| drawing["profiles"]["cone"]["width"] = json!(2000), "/profiles");
    refused(&|drawing| drawing["strokes"][0]["profiles"] = json!(["cone", "dome"]), "/strokes/0/profiles/1");
    refused(&|drawing| drawing["size"] = json!([100_000, 100_000]), "/size");
    refused(&|drawing| drawing["sea_level"] = json!({"scale": 0}), "/sea_level/scale");
    refused(&|drawing| drawing["masks"] = json!([{"geometry": {"type": "Point", "coordinates": [0, 0]}, "only": ["nobody"]}]), "/masks/0/only");
    refused(&|drawing| drawing["ridges"] = json!([{"count": 1, "share": 1.5}]), "/ridges/0/share");
    refused(&|drawing| drawing["colour"] = json!("red"), "/colour");
    // What would take minutes or gigabytes.
    refused(&|drawing| drawing["size"] = json!([4000, 4000]), "/size");
    refused(
        &|drawing| {
            drawing["size"] = json!([1500, 1500]);
            drawing["strokes"][0]["cost"] = json!({"programme": "erosion(erosion(erosion(fbm(1, 2, 8))))", "scale": 100});
        },
        "/strokes/0/cost/programme",
    );
    let square = json!([[[0, 0], [900, 0], [900, 900], [0, 900], [0, 0]]]);
    refused(
        &|drawing| {
            drawing["size"] = json!([1000, 1000]);
            drawing["strokes"][0]["shape"]["geometry"] = json!({"type": "MultiPolygon", "coordinates": vec![square.clone(); 40]});
        },
        "/strokes/0/shape/geometry/coordinates/10",
    );
    let rings = json!({"shape": {"scatter": {"count": 5000, "radius": [2, 3]}}, "cost": 3, "inside": {"profile": "cone", "only": true}});
    refused(&|drawing| drawing["strokes"][0] = rings.clone(), "/strokes/0/inside");
    refused(&|drawing| drawing["ridges"] = json!([{"count": 100_000, "share": 0.5}]), "/ridges/0/count");
    let picture = |data: &str| json!({"sketch": {"picture": {"data": data}, "colour": "#000000"}});
    refused(&|drawing| drawing["strokes"][0]["shape"] = picture("red.png"), "/strokes/0/shape/sketch/picture/data");
    refused(&|drawing| drawing["strokes"][0]["shape"] = picture("data:image/png;base64,!"), "/strokes/0/shape/sketch/picture/data");
    // A dot of 1 × 1, and a header that says 30,000 × 30,000.
    let dot = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
    refused(&|drawing| drawing["strokes"][0]["shape"] = picture(dot), "/strokes/0/shape/sketch/picture/data");
    let bomb = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAdTAAAHUwCAYAAAC2Xn9uAAAAAElFTkSuQmCC";
    refused(&|drawing| drawing["strokes"][0]["shape"] = picture(bomb), "/strokes/0/shape/sketch/picture/data");
}
