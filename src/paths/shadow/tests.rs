//! Shadow pictures under a light of the tests' own, and their limits.

use super::{
    super::lattice::{Frame, Node},
    bounds::Part,
    light::{Rays, Towards, shortest},
    regions::{Region, Regions},
    *,
};
use crate::{geometry::Stop, paths::Heights};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde_json::json;

const FACE: &str = crate::paths::PRESET_SHADOWS[0].json;
const TEXT: &str = crate::paths::PRESET_SHADOWS[1].json;

fn read(json: &str) -> ShadowDrawing {
    ShadowDrawing::parse(json.as_bytes()).expect("a shadow picture")
}

fn ready(drawing: &ShadowDrawing) -> ShadowPlan {
    ShadowPlan::new(drawing).unwrap_or_else(|error| panic!("{error}"))
}

/// A picture of `#` in shadow and anything else in light, the first row in the north.
fn written(rows: &[&str]) -> serde_json::Value {
    let (columns, count) = (rows[0].len() as u32, rows.len() as u32);
    let image = image::GrayImage::from_fn(columns, count, |x, y| image::Luma([if rows[y as usize].as_bytes()[x as usize] == b'#' { 0 } else { 255 }]));
    let mut png = Vec::new();
    image.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).expect("a PNG");
    json!({
        "size": [columns, count], "seed": 3, "tilt": 60, "base": {"programme": "fbm(1, 2, 4)", "scale": 20, "amplitude": 0.3},
        "picture": {"data": format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))}, "secondary": {"peaks": 3, "ridges": 5}
    })
}

fn framed(rows: &[&str]) -> (Frame, Vec<bool>) {
    let frame = Frame { first: Node { row: 0, column: 0 }, columns: rows[0].len(), rows: rows.len() };
    let mut shadow = vec![false; frame.slots()];
    for (slots, row) in frame.rows_of_slots().rev().zip(rows) {
        slots.zip(row.bytes()).for_each(|(slot, byte)| shadow[slot] = byte == b'#');
    }
    (frame, shadow)
}

/// Of every node whether a march towards the sun, a quarter of a node at a time over bilinear ground, meets anything higher than its ray.
fn marched(heights: &Heights, spacing: f64, azimuth: f64, altitude: f64) -> Vec<bool> {
    let (columns, rows) = (heights.columns as f64, heights.rows as f64);
    let [sine, cosine] = [azimuth.to_radians().sin(), azimuth.to_radians().cos()];
    let rise = altitude.to_radians().tan() * spacing;
    let most = f64::from(heights.metres.iter().copied().fold(f32::MIN, f32::max));
    let node = |x: f64, y: f64| f64::from(heights.metres[y as usize * heights.columns + x as usize]);
    let ground = |x: f64, y: f64| {
        let (x0, y0) = (x.floor(), y.floor());
        let (x1, y1) = ((x0 + 1.0).min(columns - 1.0), (y0 + 1.0).min(rows - 1.0));
        let (s, t) = (x - x0, y - y0);
        (node(x0, y0) * (1.0 - s) + node(x1, y0) * s) * (1.0 - t) + (node(x0, y1) * (1.0 - s) + node(x1, y1) * s) * t
    };
    let is_shaded = |n: usize| {
        let (x, y) = ((n % heights.columns) as f64, (n / heights.columns) as f64);
        let mut distance = 0.25;
        loop {
            let (px, py, ray) = (x + sine * distance, y - cosine * distance, node(x, y) + distance * rise);
            if px < 0.0 || py < 0.0 || px > columns - 1.0 || py > rows - 1.0 || ray > most {
                return false;
            }
            if ground(px, py) > ray + 1e-6 {
                return true;
            }
            distance += 0.25;
        }
    };
    (0..heights.metres.len()).map(is_shaded).collect()
}

/// Intersection over union of two sets of nodes.
fn overlap(wanted: &[bool], seen: &[bool]) -> f64 {
    let count = |of: &dyn Fn(bool, bool) -> bool| wanted.iter().zip(seen).filter(|(a, b)| of(**a, **b)).count() as f64;
    count(&|a, b| a && b) / count(&|a, b| a || b)
}

/// How much of what is wanted a picture's heights show; its base must have at least a tenth of the relief of what stands on it.
fn shown(name: &str, drawing: &ShadowDrawing) -> f64 {
    let plan = ready(drawing);
    let (light, heights) = (plan.light(), plan.heights(&Stop::never()));
    let [low, high] = plan.base_range();
    let top = heights.metres.iter().copied().fold(f32::MIN, f32::max);
    assert!(high - low >= 0.1 * (top - low), "{name}: relief {} under {top} m", high - low);
    let seen = marched(&heights, drawing.spacing, f64::from(light.azimuth), light.altitude());
    // What the program itself casts is the same as far as nodes see each other.
    let own = overlap(&plan.wanted(), &cast(&heights, drawing.spacing, &light));
    assert!(own >= 0.9, "{name}: from node to node {own}");
    overlap(&plan.wanted(), &seen)
}

#[test]
fn shadows_show_the_text_and_the_face() {
    for (name, json, least) in [("text", TEXT, 0.85), ("face", FACE, 0.75)] {
        let drawing = read(json);
        let mut others = vec![drawing.clone(); 3];
        others[1].seed = 4001;
        others[2].base.programme = "ridged_multifractal(1, 2, 6, 1, 2)".to_owned();
        for (number, drawing) in others.iter().enumerate() {
            let share = shown(&format!("{name} {number}"), drawing);
            assert!(share >= least, "{name} {number}: {share}");
        }
    }
}

/// Rays that follow no row, column or diagonal of the lattice.
#[test]
fn light_may_come_from_anywhere() {
    for (json, azimuth, least) in [(TEXT, 17, 0.8), (TEXT, 300, 0.85), (FACE, 215, 0.85)] {
        let mut drawing = read(json);
        drawing.azimuth = Some(azimuth);
        // Their longest shadows are longer.
        drawing.base.amplitude *= 1.6;
        let share = shown(&format!("{azimuth}°"), &drawing);
        assert!(share >= least, "{azimuth}°: {share}");
    }
}

const NESTED: [&str; 16] = [
    "................................................",
    ".....#####################......................",
    ".....#...................#............##........",
    ".....#...................#...........##.........",
    ".....#....###########....#..........##..........",
    ".....#....#.........#....#......................",
    ".....#....#...##....#....#......########........",
    ".....#....#...##....#....#......#......#........",
    ".....#....#.........#....#......#......#........",
    ".....#....###########....#......####.###........",
    ".....#...................#......................",
    ".....#...................#.......#..............",
    ".....#...................#........#.............",
    ".....#####################.......#..............",
    "................................................",
    "................................................",
];

#[test]
fn regions_lie_in_what_surrounds_them() {
    let (frame, shadow) = framed(&NESTED);
    let found = Regions::new(&frame, &shadow);
    let at = |row: i64, column: i64| found.slots[frame.slot(Node { row: 15 - row, column }).expect("inside")];
    // The outside, the ring and what nests in it: light, ring, light, dot; then a diagonal, an open hook and a zigzag.
    let chain = [at(0, 0), at(1, 5), at(2, 6), at(4, 10), at(5, 11), at(6, 14)];
    for (level, pair) in chain.windows(2).enumerate() {
        assert_eq!(found.regions[pair[1] as usize], Region { parent: Some(pair[0]), level: level as u32 + 1 });
    }
    assert_eq!(found.regions[0], Region { parent: None, level: 0 });
    assert_eq!(at(2, 38), at(4, 36), "shadow joins by corners");
    assert_eq!(at(7, 33), 0, "a hook with a gap has no hole");
    assert_eq!(at(11, 33), at(13, 33));
    assert_eq!(found.regions.len(), 6 + 3);
    // Light does not join by corners.
    let (frame, shadow) = framed(&["....", ".##.", "#..#", ".##.", "...."]);
    assert_eq!(Regions::new(&frame, &shadow).regions.len(), 3);
}

#[test]
fn nested_holes_are_lit_and_what_lies_in_them_is_not() {
    let enlarged: Vec<String> = NESTED.iter().flat_map(|row| vec![row.chars().flat_map(|c| [c; 5]).collect::<String>(); 5]).collect();
    let rows: Vec<&str> = enlarged.iter().map(String::as_str).collect();
    for azimuth in [None, Some(0), Some(33), Some(200)] {
        let mut json = written(&rows);
        json["azimuth"] = json!(azimuth);
        let drawing = read(&json.to_string());
        let plan = ready(&drawing);
        let heights = plan.heights(&Stop::never());
        let light = plan.light();
        let share = overlap(&plan.wanted(), &marched(&heights, 1.0, f64::from(light.azimuth), light.altitude()));
        assert!(share > 0.75, "{azimuth:?}: {share}");
    }
}

/// All 360 directions, node by node along each ray.
#[test]
fn the_direction_is_that_of_a_plain_scan() {
    let blots = |n: i64| -> Vec<String> {
        let dark = |x: i64, y: i64| (x * x * (n + 3) + y * y * 7 + x * y * n) % 61 < 24 && (x + n * y) % 9 > 2;
        (0..37).map(|y| (0..53).map(|x| if dark(x, y) { '#' } else { '.' }).collect()).collect()
    };
    for n in 0..6 {
        let rows = blots(n);
        let (frame, shadow) = framed(&rows.iter().map(String::as_str).collect::<Vec<_>>());
        let longest = |azimuth: u16| {
            let rays = Rays::new(&frame, azimuth);
            let mut most = 0;
            for ray in rays.iter() {
                let mut run = 0;
                for slot in ray {
                    run = if shadow[*slot as usize] { run + 1 } else { 0 };
                    most = most.max(run);
                }
            }
            f64::from(most) * rays.step
        };
        let plain = (0..360).map(|azimuth| (longest(azimuth), azimuth)).reduce(|a, b| if b.0 < a.0 { b } else { a }).expect("360").1;
        assert_eq!(shortest(&frame, &shadow), plain, "picture {n}");
    }
}

/// Every node lies on one digital ray, its neighbours there one step on; ways towards the light keep within half a node of them.
#[test]
fn rays_deal_out_all_nodes() {
    let frame = Frame { first: Node { row: 0, column: 0 }, columns: 23, rows: 31 };
    for azimuth in (0..360).step_by(7) {
        let rays = Rays::new(&frame, azimuth);
        let light = Light { azimuth, tilt: 45.0 };
        let mut slots: Vec<u32> = rays.iter().flatten().copied().collect();
        slots.sort_unstable();
        assert!(slots.iter().copied().eq(frame.rows_of_slots().flatten().map(|slot| slot as u32)), "{azimuth}");
        let place = |slot: usize| frame.node(slot);
        for ray in rays.iter().filter(|ray| ray.len() > 1) {
            let (first, last) = (place(ray[0] as usize), place(ray[ray.len() - 1] as usize));
            let gone = [(last.column - first.column) as f64, (last.row - first.row) as f64];
            let [east, north] = light.direction();
            assert!(gone[0] * east + gone[1] * north > 0.0 && (gone[0] * north - gone[1] * east).abs() <= 1.0, "{azimuth}: {gone:?}");
            let way: Vec<([usize; 2], f64)> = Towards::new(&frame, azimuth).way(ray[ray.len() - 1] as usize).collect();
            for (slot, (slots, share)) in ray.iter().rev().skip(1).zip(way) {
                let near = slots[usize::from(share > 0.5)];
                let (a, b) = (place(near), place(*slot as usize));
                assert!((a.column - b.column).abs() + (a.row - b.row).abs() <= 1, "{azimuth}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn terrain_keeps_between_its_bounds() {
    for json in [TEXT, FACE] {
        for azimuth in [None, Some(300)] {
            let mut drawing = read(json);
            drawing.azimuth = azimuth;
            let plan = ready(&drawing);
            let slots = plan.frame().rows_of_slots().rev().flatten();
            let (mut bounded, mut above) = (0, 0);
            for (slot, height) in slots.zip(plan.heights(&Stop::never()).metres) {
                let (part, upper, base) = (plan.bounds().parts[slot], plan.bounds().upper[slot], plan.base()[slot]);
                assert!(height >= base, "slot {slot}");
                if !matches!(part, Part::Free | Part::Contrast) {
                    bounded += 1;
                    above += usize::from(height > base);
                    // One rounding of the search, which counts from the top.
                    assert!(height <= upper + 1e-4, "slot {slot}, {part:?}: {height} above {upper}");
                }
                // Crests and holes have just the heights that they need.
                if matches!(part, Part::Crest | Part::Hole) {
                    assert!((height - upper).abs() < 1e-4, "slot {slot}, {part:?}: {height} for {upper}");
                }
            }
            assert!(bounded > 10_000 && above > 5_000, "{bounded} {above}");
            for source in plan.sources().iter().filter(|source| source.kind == climb::Kind::Secondary) {
                let slot = source.slot as usize;
                assert!(source.height >= plan.base()[slot] && source.height <= plan.bounds().upper[slot] + 1e-4, "slot {slot}");
            }
        }
    }
}

/// From a hill that throws no shadow nothing must be taken: alone, secondary features and the base leave all of the ground in light.
#[test]
fn secondary_features_throw_no_shadow() {
    let mut rows = vec![".".repeat(160); 160];
    rows[80].replace_range(80..84, "####");
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut json = written(&rows);
    json["secondary"] = json!({"peaks": 60, "ridges": 60, "heights": {"programme": "fbm(1, 2, 4)", "scale": 30}});
    let drawing = read(&json.to_string());
    let (plan, bare) = (ready(&drawing), ready(&ShadowDrawing { secondary: Secondary { peaks: 0, ridges: 0, heights: None }, ..drawing.clone() }));
    let (heights, without) = (plan.heights(&Stop::never()), bare.heights(&Stop::never()));
    let higher = heights.metres.iter().zip(&without.metres).filter(|(a, b)| *a > *b).count();
    assert!(higher > 1000, "{higher} nodes of secondary features");
    let light = plan.light();
    let seen = |heights: &Heights| marched(heights, 1.0, f64::from(light.azimuth), light.altitude()).iter().filter(|shaded| **shaded).count();
    assert!(seen(&heights) <= seen(&without) + 4, "{} for {}", seen(&heights), seen(&without));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let drawing = read(FACE);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let plan = ready(&drawing);
            let heights = plan.heights(&Stop::never());
            let shaded = cast(&heights, drawing.spacing, &plan.light());
            (plan.light(), heights, shaded, plan.preview())
        })
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(5));
}

#[test]
fn what_is_stopped_ends() {
    let stop = Stop::new();
    stop.clone().set();
    let plan = ready(&read(FACE));
    let heights = plan.heights(&stop);
    assert!(heights.settled.nodes < 10_000, "{}", heights.settled.nodes);
}

#[test]
fn what_cannot_be_is_refused_with_its_place() {
    let rows = ["........", "..####..", "..####..", "........", "........"];
    let refused = |change: &dyn Fn(&mut serde_json::Value), pointer: &str| {
        let mut json = written(&rows);
        change(&mut json);
        let error =
            ShadowDrawing::parse(json.to_string().as_bytes()).and_then(|drawing| ShadowPlan::new(&drawing)).map(|plan| plan.light()).expect_err(pointer);
        assert_eq!(error.pointer, pointer, "{error}");
        assert!(!error.detail.is_empty());
    };
    assert!(ShadowPlan::new(&read(&written(&rows).to_string())).is_ok());
    refused(&|json| json["picture"] = written(&["........"; 5])["picture"].clone(), "/picture");
    refused(&|json| json["picture"] = written(&["########"; 5])["picture"].clone(), "/picture");
    refused(&|json| json["picture"] = json!({"data": ""}), "/picture/data");
    refused(&|json| json["picture"] = json!({"data": "data:image/png;base64,"}), "/picture/data");
    refused(&|json| json["picture"] = json!({"data": "data:image/png;base64,!"}), "/picture/data");
    refused(&|json| json["picture"] = json!({"programme": "fmb(1)"}), "/picture/programme");
    let bomb = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAdTAAAHUwCAYAAAC2Xn9uAAAAAElFTkSuQmCC";
    refused(&|json| json["picture"] = json!({"data": bomb}), "/picture/data");
    refused(&|json| json["size"] = json!([9, 5]), "/picture/data");
    refused(&|json| json["size"] = json!([3, 5]), "/size");
    refused(&|json| json["size"] = json!([100_000, 100_000]), "/size");
    for tilt in [0.0, 4.9, 88.1, 90.0, -45.0] {
        refused(&|json| json["tilt"] = json!(tilt), "/tilt");
    }
    refused(&|json| json["tilt"] = json!("low"), "/tilt");
    refused(&|json| json["azimuth"] = json!(360), "/azimuth");
    refused(&|json| json["threshold"] = json!(0), "/threshold");
    refused(&|json| json["spacing"] = json!(0), "/spacing");
    refused(&|json| json["origin"] = json!([0, 1e30]), "/origin/1");
    refused(&|json| json["base"]["programme"] = json!("divide(1, x"), "/base/programme");
    refused(&|json| json["base"]["scale"] = json!(-1), "/base/scale");
    refused(&|json| json["base"]["amplitude"] = json!(1e7), "/base/amplitude");
    refused(&|json| json["base"]["colour"] = json!(1), "/base/colour");
    refused(&|json| json["mean"] = json!(0), "/mean");
    refused(&|json| json["deviation"] = json!(1e3), "/deviation");
    refused(&|json| json["contrast"] = json!(-1), "/contrast");
    refused(&|json| json["secondary"]["ridges"] = json!(100_000), "/secondary/ridges");
    refused(&|json| json["secondary"]["heights"] = json!({"programme": "3"}), "/secondary/heights/programme");
    refused(&|json| json["colour"] = json!("red"), "/colour");
    let missing = |json: &mut serde_json::Value| drop(json.as_object_mut().expect("an object").remove("tilt"));
    refused(&missing, "");
    // What JSON cannot say, code can.
    let drawing = read(&written(&rows).to_string());
    for (drawing, pointer) in [
        (ShadowDrawing { tilt: f64::NAN, ..drawing.clone() }, "/tilt"),
        (ShadowDrawing { threshold: f64::NAN, ..drawing.clone() }, "/threshold"),
        (ShadowDrawing { mean: Some(f64::NAN), ..drawing.clone() }, "/mean"),
        (ShadowDrawing { contrast: Some(f64::INFINITY), ..drawing.clone() }, "/contrast"),
        (ShadowDrawing { base: ShadowBase { datum: f64::NAN, ..drawing.base.clone() }, ..drawing.clone() }, "/base/datum"),
    ] {
        assert_eq!(ShadowPlan::new(&drawing).map(|plan| plan.light()).expect_err(pointer).pointer, pointer);
    }
}

#[test]
fn documents_are_told_apart() {
    assert!(matches!(PathsDocument::parse(TEXT.as_bytes()), Ok(PathsDocument::Shadow(_))));
    let drawing = crate::paths::PRESET_DRAWINGS[0].json;
    assert!(matches!(PathsDocument::parse(drawing.as_bytes()), Ok(PathsDocument::Drawing(_))));
    assert_eq!(PathsDocument::parse(br#"{"picture": {"data": 3}}"#).expect_err("no picture").pointer, "/picture");
}
