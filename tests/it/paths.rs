//! Terrain by path costs as layers of worlds.

use crate::client::Client;
use axum::http::StatusCode;
use serde_json::{Value, json};
use terrane::{
    geometry::{Filter, Grid, Rectangle, Samples, Stop, Tile, Window},
    paths::{PRESET_SHADOWS, ShadowDrawing, ShadowPlan},
    tile::{Height, Options, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};

fn drawing() -> Value {
    json!({
        "size": [80, 60], "spacing": 50, "origin": [-2000, -1500], "edges": {"random": {"mean": 1, "deviation": 0.5}}, "sea_level": {"cost": 900},
        "profiles": {"flank": {"points": [[0, 1], [0.4, 0.4], [1, 0]], "width": 1200}},
        "strokes": [{"shape": {"geometry": {"type": "LineString", "coordinates": [[1000, 1500], [3000, 1600]]}}, "profiles": ["flank"], "cost": 100}],
        "ridges": [{"count": 5, "share": 0.6}]
    })
}

#[expect(clippy::needless_pass_by_value, reason = "json! makes values")]
fn document(source: Value) -> Value {
    json!({"seed": 5, "base": {"programme": "0", "scale": 2000, "datum": 100}, "layers": [{"name": "alps", "source": {"paths": source}}]})
}

fn world(document: &Value) -> World {
    World::new(Document::parse(document.to_string().as_bytes()).unwrap_or_else(|error| panic!("{error}")))
}

fn elevation(world: &World, x: f64, y: f64) -> f32 {
    world.evaluate(&Window::point(x, y, 1.0, Filter::Exact).unwrap()).elevation[0]
}

#[test]
fn a_drawing_stands_on_what_is_beneath_as_far_as_it_reaches() {
    let world = world(&document(json!({"drawing": drawing()})));
    // On its crest, halfway down, and beyond.
    let [crest, flank, beyond] = [1000.0, 1400.0, 60_000.0].map(|north| elevation(&world, 0.0, north - 950.0));
    assert!((crest - 900.0).abs() < 60.0, "{crest}");
    assert!(flank > 150.0 && flank < crest - 100.0, "{flank}");
    assert_eq!(beyond, 100.0);
    let completed = world.document().to_json();
    assert_eq!(Document::parse(completed.as_bytes()).unwrap().to_json(), completed);
}

#[test]
fn only_tiles_that_it_reaches_are_other_tiles() {
    let (with, without) =
        (world(&document(json!({"drawing": drawing()}))), world(&json!({"seed": 5, "base": {"programme": "0", "scale": 2000, "datum": 100}})));
    let tag = |world: &World, area: Rectangle| world.identify("a tile", &area);
    let near = Rectangle { min: [-100.0, -100.0], max: [100.0, 100.0] };
    let far = Rectangle { min: [90_000.0, 0.0], max: [91_000.0, 100.0] };
    assert_ne!(tag(&with, near), tag(&without, near));
    assert_eq!(tag(&with, far), tag(&without, far));
    let mut moved = drawing();
    moved["strokes"][0]["cost"] = json!(120);
    let moved = world(&document(json!({"drawing": moved})));
    assert_ne!(tag(&with, near), tag(&moved, near));
    assert_eq!(tag(&with, far), tag(&moved, far));
}

fn shadow() -> Value {
    serde_json::from_str(PRESET_SHADOWS[1].json).unwrap()
}

/// A shadow picture has elevations of its own, which layers blend as they say.
#[test]
fn a_shadow_picture_takes_its_place_and_no_more() {
    let with = |blend: &str, datum: f64| {
        let mut document = document(json!({"shadow": shadow()}));
        document["layers"][0]["blend"] = json!(blend);
        document["base"]["datum"] = json!(datum);
        world(&document)
    };
    let drawing = ShadowDrawing::parse(PRESET_SHADOWS[1].json.as_bytes()).unwrap();
    let heights = ShadowPlan::new(&drawing).unwrap().heights(&Stop::never());
    let (replaced, high, low) = (with("replace", 20.0), with("max", 20.0), with("max", -200.0));
    for n in (0..heights.metres.len()).step_by(997) {
        let (column, row, own) = (n % 512, 511 - n / 512, heights.metres[n]);
        let [replaced, high, low] = [&replaced, &high, &low].map(|world| elevation(world, column as f64, row as f64));
        assert!((replaced - own).abs() < 1e-3 && (low - own).abs() < 1e-3, "{column}, {row}: {replaced}, {low} for {own}");
        assert!((high - own.max(20.0)).abs() < 1e-3, "{column}, {row}: {high} for {own}");
    }
    for (x, y) in [(-1.5, 100.0), (600.0, 100.0), (100.0, 513.0), (1e6, -1e6)] {
        assert_eq!(elevation(&replaced, x, y), 20.0, "{x}, {y}");
    }
    // From afar its volume remains.
    let deep = with("replace", -100.0);
    let wanted: f64 = heights.metres.iter().map(|height| f64::from(*height) + 100.0).sum();
    for spacing in [4.0, 40.0] {
        let window = Window::area([-400.0, -400.0, 912.0, 912.0], spacing, Filter::Band, 1 << 22).unwrap();
        let seen = deep.evaluate(&window).elevation;
        let volume: f64 = seen.iter().map(|height| (f64::from(*height) + 100.0) * spacing * spacing).sum();
        assert!((volume / wanted - 1.0).abs() < 0.03, "{spacing} m: {volume} for {wanted}");
    }
    let completed = replaced.document().to_json();
    assert_eq!(Document::parse(completed.as_bytes()).unwrap().to_json(), completed);
}

/// At every level of the example world neighbours share their edge to the bit, and no tile takes too long to say so.
#[test]
fn tiles_of_endless_ranges_have_no_seams() {
    let json = EXAMPLES.iter().find(|example| example.name == "ranges").unwrap().json;
    let (one, other) = (World::new(Document::parse(json.as_bytes()).unwrap()), World::new(Document::parse(json.as_bytes()).unwrap()));
    let heights = |world: &World, z: u8, x: i64, y: i64| -> Vec<f32> {
        let request = TileRequest {
            grid: Grid::Metric,
            tile: Tile { z, x, y },
            samples: Samples::Vertices(33),
            filter: Filter::Band,
            tileset: Tileset::R32,
            height: Height::Ground,
            options: Options::default(),
        };
        let bytes = render(world, &request).unwrap_or_else(|error| panic!("{error}"));
        bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
    };
    for z in [4, 8, 10, 11, 12, 13, 14, 16, 18, 22] {
        let (west, east) = (heights(&one, z, 3, -5), heights(&other, z, 4, -5));
        for row in 0..33 {
            assert_eq!(west[row * 33 + 32].to_bits(), east[row * 33].to_bits(), "level {z}, row {row}");
        }
    }
}

#[tokio::test]
async fn what_is_wrong_with_a_drawing_is_told_with_its_place() {
    let client = Client::new().await;
    let answer = async |source: Value| client.put("/worlds/drawn", &document(source).to_string()).await;
    let wrong = |pointer: &str, value: Value| {
        let mut drawing = drawing();
        *drawing.pointer_mut(pointer).unwrap() = value;
        json!({"drawing": drawing})
    };
    let wrong_shadow = |pointer: &str, value: Value| {
        let mut shadow = shadow();
        *shadow.pointer_mut(pointer).unwrap() = value;
        json!({"shadow": shadow})
    };
    let at = "422 /layers/0/source/paths";
    for (source, problem) in [
        (wrong("/edges/random/deviation", json!(1)), format!("{at}/drawing/edges/random/deviation: must be 0 up to less than the mean 1, got 1")),
        (wrong("/profiles/flank/points/1", json!([0.4, 1.2])), format!("{at}/drawing/profiles/flank/points: point 1 is higher than the one before")),
        (wrong("/profiles/flank/width", json!(90_000)), format!("{at}/drawing/profiles: paths may reach")),
        (wrong("/strokes/0/cost", json!({"programme": "fmb(1)"})), format!("{at}/drawing/strokes/0/cost/programme: ")),
        (wrong("/strokes/0/profiles", json!(["cone"])), format!("{at}/drawing/strokes/0/profiles/0: no profile is called \"cone\"; there are flank")),
        (json!({"drawing": {"size": [9, 9], "colour": 1}}), format!("{at}/drawing/colour: unknown field")),
        (json!({}), format!("{at}: paths are either a drawing, endless or a shadow")),
        (wrong_shadow("/tilt", json!(0)), format!("{at}/shadow/tilt: must be 5 … 88, got 0")),
        (wrong_shadow("/size", json!([9, 9])), format!("{at}/shadow/picture/data: must be 9 × 9 pixels like the drawing, got 512 × 512")),
        (json!({"endless": {"spacing": 10}}), format!("{at}/endless/cell: missing field")),
    ] {
        let answer = answer(source).await;
        assert!(answer.problem().starts_with(&problem), "{} for {problem}", answer.problem());
    }
    assert_eq!(client.get("/worlds/drawn").await.status, StatusCode::NOT_FOUND, "nothing was stored");
    assert_eq!(answer(json!({"drawing": drawing()})).await.status, StatusCode::CREATED);
}

#[test]
fn detail_is_where_heights_are_and_nowhere_else() {
    let with = |detail: Value| {
        let mut document = document(json!({"drawing": drawing()}));
        document["layers"][0]["source"]["detail"] = detail;
        document
    };
    let plain = world(&document(json!({"drawing": drawing()})));
    let detailed = world(&with(json!({"programme": "fbm(1, 2, 6)", "scale": 60, "amplitude": 12})));
    let near: Vec<f32> = (0..200).map(|i| elevation(&detailed, f64::from(i) * 1.7, 0.0) - elevation(&plain, f64::from(i) * 1.7, 0.0)).collect();
    let rms = (near.iter().map(|d| d * d).sum::<f32>() / 200.0).sqrt();
    assert!(rms > 1.0 && near.iter().all(|d| d.abs() <= 24.0), "{rms}");
    assert_eq!(elevation(&detailed, 0.0, 60_000.0), elevation(&plain, 0.0, 60_000.0));
    // What samples cannot carry is not there.
    let seen = |world: &World| world.evaluate(&Window::area([-1000.0, -900.0, 1000.0, 900.0], 200.0, Filter::Band, 1 << 20).unwrap()).elevation;
    let left = seen(&detailed).iter().zip(&seen(&plain)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(left < 0.05 * rms, "{left} of {rms}");
    let completed = detailed.document().to_json();
    assert_eq!(Document::parse(completed.as_bytes()).unwrap().to_json(), completed);
    let tag = |world: &World| world.identify("a tile", &Rectangle { min: [-100.0, -100.0], max: [100.0, 100.0] });
    assert_ne!(tag(&plain), tag(&detailed));

    let refused = |document: &Value| Document::parse(document.to_string().as_bytes()).unwrap_err().to_string();
    let problem = refused(&with(json!({"programme": "fbm(1, 2, 6)", "scale": 60})));
    assert_eq!(problem, "/layers/0/source/detail/amplitude: is needed: metres of elevation per unit of the programme's value");
    let problem = refused(&with(json!({"programme": "fmb(1, 2, 6)", "scale": 60, "amplitude": 1})));
    assert!(problem.starts_with("/layers/0/source/detail/programme: character 1: unknown function \"fmb\""), "{problem}");
    let beside = json!({"seed": 5, "base": {"programme": "0", "scale": 1}, "layers": [{"name": "a", "source":
        {"layout": {"features": []}, "detail": {"programme": "x", "scale": 1, "amplitude": 1}}}]});
    assert_eq!(refused(&beside), "/layers/0/source/detail: has no meaning beside a layout or a shadow");
}
