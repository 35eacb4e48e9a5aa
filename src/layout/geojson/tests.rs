//! What goes in comes out, and what is wrong is told.

use super::*;
use crate::{
    geometry::{Along, Detail, Elevation, Shape, ShapeError},
    layout::{
        Attribute, AttributeSet, Expression, Feature, Role, Side, TerrainValue, Value, Weight,
        generate::{Island, Styles},
    },
    programme::{Frame, Programme},
};
use proptest::prelude::*;
use std::sync::Arc;

/// Every problem of a text, of reading it or of making features of it.
fn problems(json: &str) -> Vec<String> {
    let read = Collection::parse(json).and_then(|collection| collection.features(&Sets::default()));
    match read {
        Ok(_) => Vec::new(),
        Err(ReadError::Invalid(problems)) => problems.iter().map(ToString::to_string).collect(),
        Err(ReadError::Io(error)) => panic!("{error}"),
    }
}

fn check(json: &str, expected: &str) {
    assert_eq!(problems(json), [expected], "{json}");
}

/// A line with properties beside its attributes.
fn line(coordinates: &str, more: &str) -> String {
    format!(
        r#"{{"type":"Feature","id":"f","geometry":{{"type":"LineString","coordinates":{coordinates}}},"properties":{{"attributes":[{{"name":"elevation","value":"shape","range":9}}]{more}}}}}"#
    )
}

fn polygon(coordinates: &str) -> String {
    line(coordinates, "").replace("LineString", "Polygon")
}

fn attribute(attribute: &str) -> String {
    format!(r#"{{"type":"Feature","id":7,"geometry":{{"type":"Point","coordinates":[1,2,3]}},"properties":{{"attributes":[{attribute}]}}}}"#)
}

#[test]
fn bad_shapes_are_told_with_feature_and_vertex() {
    check(
        &polygon("[[[0,0,1],[10,10,1],[10,0,1],[0,10,1],[0,0,1]]]"),
        r#"/geometry/coordinates/0/0: feature "f": the polygon crosses itself: the edge from vertex 0 meets the edge from vertex 2"#,
    );
    check(
        &polygon("[[[0,0,1],[10,0,1],[10,10,1],[0,10,1]]]"),
        r#"/geometry/coordinates/0/3: feature "f": vertex 3 must close its ring: it must equal vertex 0"#,
    );
    check(
        &polygon("[[[0,0,1],[9,0,1],[0,9,1],[0,0,1]],[[20,20,1],[21,20,1],[20,21,1],[20,20,1]]]"),
        r#"/geometry/coordinates/1/0: feature "f": vertex 4 begins a hole that is not inside the polygon"#,
    );
    check(&line("[[0,0,1],[null,5,1],[6,6,1]]", ""), r#"/geometry/coordinates: feature "f": vertex 1: a coordinate must be a number, got null"#);
    check(
        &line("[[0,0,1],[2e13,5,1]]", ""),
        r#"/geometry/coordinates/1: feature "f": vertex 1: coordinates must be numbers within 2^40 = 1099511627776 m of the origin, got 20000000000000"#,
    );
    check(
        &line("[[0,0,1],[5,5]]", ""),
        r#"/geometry/coordinates/1: feature "f": vertex 1 and vertex 0 are unlike: either every vertex has an elevation as its third coordinate or none has"#,
    );
    check(
        &line("[[0,0],[5,5]]", ""),
        r#"/geometry/coordinates: feature "f": vertex 0: attribute "elevation" takes the elevation of the shape, which has none: give every vertex a third coordinate, or property elevation"#,
    );
    check(&line("[[0,0,1]]", ""), r#"/geometry/coordinates/0: feature "f": the 2 vertices that a line needs at least are not there: vertex 0 begins one of 1"#);
    check(
        &line("[[0,0,1,4],[5,5,1]]", ""),
        r#"/geometry/coordinates: feature "f": vertex 0: a position is [x, y] or [x, y, elevation] in metres, got 4 numbers"#,
    );
    check(
        &line("[0,0,1]", ""),
        r#"/geometry/coordinates: feature "f": vertex 0: the coordinates of a LineString are [[x, y], …], here a position stands 0 lists deep"#,
    );
    check(
        &line("[[0,0,1],[5,5,2]]", r#","elevation":5"#),
        r#"/properties/elevation: feature "f": the vertices have elevations already: give either third coordinates or this"#,
    );
    check(&line("[[0,0,1],[5,5,2]]", r#","radius":5"#), r#"/properties/radius: feature "f": makes a circle of a Point, not of a LineString"#);
    check(
        &line("[[[0,0,1],[5,5,2]]]", "").replace("LineString", "MultiLineString"),
        r#"/geometry/type: feature "f": a MultiLineString is several shapes: make each a Feature of its own, a Point, LineString or Polygon"#,
    );
    check(&line("[[0,0,1],[5,5,2]]", "").replace("\"f\"", "2.5"), "/id: feature 2.5: must be text of 1 to 200 characters or a whole number");
}

#[test]
fn what_json_cannot_say_is_told_with_feature_and_vertex() {
    for number in ["NaN", "Infinity", "-Infinity", "1e999"] {
        let all = problems(&format!(
            r#"{{"type":"FeatureCollection","features":[{},{}]}}"#,
            line("[[0,0,1],[5,5,1]]", ""),
            line(&format!("[[0,0,1],[1,1,1],[2,{number},1]]"), "")
        ));
        assert!(all.len() == 1 && all[0].starts_with("/features/1: feature number 1: vertex 2: not JSON"), "{number}: {all:?}");
    }
    check(
        "",
        "/: feature number 0: not JSON as GeoJSON needs it: EOF while parsing a value at line 1 column 0 (numbers must be finite; NaN and Infinity are none)",
    );
}

#[test]
fn a_shape_with_a_million_vertices_is_refused_and_not_kept() {
    let vertices: Vec<String> = (0..1_000_000).map(|i| format!("[{i},0,1]")).collect();
    check(
        &line(&format!("[{}]", vertices.join(",")), ""),
        r#"/geometry/coordinates: feature "f": vertex 250000: is the first beyond the 250000 vertices that a feature may have: part it into several"#,
    );
}

#[test]
fn edges_that_all_run_aslant_beside_each_other_do_not_take_for_ever() {
    // A comb whose teeth are long diagonals: the boxes of all of them overlap.
    let n = 50_000;
    let mut ring: Vec<[f64; 2]> = (0..n).map(|i| [f64::from(i) + if i % 2 == 0 { 0.0 } else { 1e6 }, if i % 2 == 0 { 0.0 } else { 1e6 }]).collect();
    ring.extend([[2e6, -1.0], [0.0, -1.0], [0.0, 0.0]]);
    assert!(matches!(Shape::polygon(vec![ring], Elevation::Absent), Err(ShapeError::Entangled { .. })));
}

#[test]
fn bad_attributes_are_told_with_the_feature() {
    for range in ["0", "-5"] {
        check(
            &attribute(&format!(r#"{{"name":"elevation","value":"shape","range":{range}}}"#)),
            &format!(r#"/properties/attributes/0: feature 7: attribute "elevation": a range is a positive number of metres or infinite, got {range}"#),
        );
    }
    let of = |json: &str| problems(&attribute(json)).concat();
    let weights = of(r#"{"name":"elevation","value":"shape","range":5,"weight":"liner"}"#);
    assert!(
        weights.starts_with("/properties/attributes/0/weight: feature 7: must be \"linear\"") && weights.ends_with(r#"(did you mean "linear"?)"#),
        "{weights}"
    );
    let kinds = of(r#"{"name":"elevation","value":{"profil":[[0,1]]},"range":5}"#);
    assert_eq!(
        kinds,
        r#"/properties/attributes/0/value: feature 7: must be an object with one of profile, expression, programme, name (did you mean "profile"?)"#
    );
    let names = of(r#"{"name":"Höhe","value":1,"range":5}"#);
    assert!(names.contains("a name is a lower-case letter"), "{names}");
    let text = of(r#"{"name":"elevation","value":{"programme":"fmb(1)","scale":10},"range":5}"#);
    assert!(text.starts_with("/properties/attributes/0/value/programme: feature 7: ") && text.contains("fbm"), "{text}");
    let dear = of(r#"{"name":"elevation","value":{"programme":"erosion(erosion(erosion(fbm(1,2,20))))","scale":10},"range":5}"#);
    assert!(dear.contains("programme"), "{dear}");
    let member = of(r#"{"name":"elevation","value":1,"rang":5}"#);
    assert!(member.contains("/range: feature 7: is missing") && member.contains("/rang: feature 7: is no member that belongs here"), "{member}");
}

#[test]
fn names_of_sets_are_looked_up_wherever_they_stand() {
    let named = |name: &str| line("[[0,0,1],[5,5,1]]", "").replace(r#"[{"name":"elevation","value":"shape","range":9}]"#, &format!("{name:?}"));
    let json = format!(
        r#"{{"features":[{}],"type":"FeatureCollection","attributes":{{"crest":[{{"name":"elevation","value":"shape","range":9}}]}}}}"#,
        named("crest")
    );
    assert_eq!(problems(&json), [""; 0]);
    check(
        &json.replace(r#""attributes":"crest""#, r#""attributes":"crust""#),
        r#"/features/0/properties/attributes: feature "f": no set of attributes is named "crust"; there are crest (did you mean "crest"?)"#,
    );
    let outer = Sets::parse(r#"{"crest":[{"name":"elevation","value":"shape","range":5}]}"#).unwrap();
    let made = Collection::parse(&named("crest")).unwrap().features(&outer).unwrap();
    assert_eq!(made[0].attributes()[0].range, 5.0);
}

#[test]
fn detail_is_checked_and_rivers_keep_their_bound() {
    let detail = |more: &str| line("[[0,0,1],[80,0,1]]", &format!(r#","detail":{{"iterations":8,"displacement":{more}}}"#));
    let count = |json: &str| Collection::parse(json).unwrap().features(&Sets::default()).unwrap().len();
    assert_eq!([count(&detail("0.3")), count(&detail(r#"0.3,"mode":"static""#)), count(&detail(r#"0.3,"mode":"split""#))], [1, 1, 256]);
    assert_eq!(count(&detail(r#"0.3,"mode":"overlap","attributes":[]"#)), 257);
    let river = |displacement: &str| detail(displacement).replace(r#""range":9"#, r#""range":9,"channel":{"half_width":2}"#);
    assert_eq!(count(&river("0.09")), 1);
    let bound = Detail::river_bound(8);
    check(
        &river("0.1"),
        &format!(r#"/properties/detail/displacement: feature "f": a river with 8 iterations needs a displacement of at most {bound} = tan(90°/8)/2, got 0.1"#),
    );
    check(&detail("1.5"), r#"/properties/detail/displacement: feature "f": a displacement is a share of a segment's length between 0 and 1, got 1.5"#);
    check(&detail(r#"0.1,"mode":"lazy""#), r#"/properties/detail/mode: feature "f": must be one of dynamic, static, split, overlap, got "lazy""#);
    let split = polygon("[[[0,0,1],[9,0,1],[0,9,1],[0,0,1]]]")
        .replace(r#","range":9}]"#, r#","range":9}],"detail":{"iterations":2,"displacement":0.1,"mode":"split"}"#);
    check(&split, r#"/properties/detail: feature "f": only lines can be split: the edges of a polygon have no inside"#);
    let point =
        attribute(r#"{"name":"elevation","value":1,"range":5}"#).replace(r#""properties":{"#, r#""properties":{"detail":{"iterations":1,"displacement":0},"#);
    check(&point, "/properties/detail: feature 7: only lines and polygons can have detail");
}

#[test]
fn all_problems_are_told_up_to_a_number() {
    let bad: Vec<String> = (0..150).map(|i| line("[[0,0,1],[null,5,1]]", "").replace("\"f\"", &i.to_string())).collect();
    let all = problems(&format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, bad.join(",")));
    assert_eq!(all.len(), MOST_PROBLEMS);
    assert!(all[99].starts_with("/features/99/geometry/coordinates: feature 99: vertex 1"), "{}", all[99]);
    let two = problems(&format!("{}\n{}", line("[[0,0,1],[null,5,1]]", ""), line("[[0,0,1],[3,5]]", r#","along":"arch","detail":5"#)));
    assert_eq!(two.len(), 4, "{two:?}");
    assert!(two[1].starts_with("/1/properties/along: feature \"f\": ") && two[1].ends_with(r#"(did you mean "arc"?)"#), "{two:?}");
}

#[test]
fn lines_and_collections_are_the_same_features() {
    let (one, two) = (line("[[0,0,1],[5,5,1]]", ""), line("[[0,0,1],[7,5,1]]", "").replace("\"f\"", "\"g\""));
    let hashes = |json: &str| Collection::parse(json).unwrap().features(&Sets::default()).unwrap().iter().map(Feature::hash).collect::<Vec<_>>();
    let collection = hashes(&format!(r#"{{"type":"FeatureCollection","features":[{one},{two}],"links":[],"numberMatched":2}}"#));
    assert_eq!(collection, hashes(&format!("{one}\n{two}\n")));
    assert_eq!(collection, hashes(&format!("\u{1e}{one}\n\u{1e}{two}\n")));
    check(&format!("{one}\n{one}"), r#"/1/id: feature "f": feature number 0 has this id already"#);
    check(&format!(r#"{{"type":"FeatureCollection","features":[{one}]}} {two}"#), "/: something follows the FeatureCollection");
    check(r#"{"type":"FeatureCollection"}"#, "/features: must be there once: a list of features");
    check(r#"{"type":"Topology"}"#, r#"/type: must be "FeatureCollection" or "Feature", got "Topology""#);
    let member = problems(&one.replace(r#""properties""#, r#""propertys""#)).concat();
    assert!(member.starts_with(r#"/propertys: feature "f": is no member"#) && member.contains(r#"(did you mean "properties"?)"#), "{member}");
}

#[test]
fn own_properties_come_back() {
    let json = line("[[0,0,1],[5,5,1]]", r#","name":"Große Höhe","tags":{"a":[1,2.50,null]},"big":12345678901234567890"#);
    let again = serde_json::to_string(&Collection::parse(&json).unwrap().features[0]).unwrap();
    let (before, after): (serde_json::Value, serde_json::Value) = (serde_json::from_str(&json).unwrap(), serde_json::from_str(&again).unwrap());
    for name in ["name", "tags", "big"] {
        assert_eq!(before["properties"][name], after["properties"][name]);
    }
    assert_eq!(Collection::parse(&again).unwrap().features, Collection::parse(&json).unwrap().features);
}

#[test]
fn a_generated_island_comes_back_to_the_bit() {
    let mut island = Island::ridges_rivers_and_lakes();
    (island.landmass.radius, island.rivers.rounds) = (6_000.0, 3);
    let features = island.features(3, &Styles::for_spacing(650.0, 3).unwrap()).unwrap();
    let collection = Collection::of(&features).unwrap();
    assert!(collection.sets.iter().count() > 4);
    let text = serde_json::to_string(&collection).unwrap();
    let again = Collection::parse(&text).unwrap();
    assert_eq!(serde_json::to_string(&again).unwrap(), text);
    let again = again.features(&Sets::default()).unwrap();
    assert!(features.iter().map(Feature::hash).eq(again.iter().map(Feature::hash)));
    assert!(features.iter().zip(&again).all(|(one, two)| one.precedence == two.precedence));
}

#[test]
fn equal_names_of_unlike_sets_are_kept_apart() {
    let of = |range: i32, id: &str| {
        let named = line("[[0,0,1],[5,5,1]]", "").replace(r#"[{"name":"elevation","value":"shape","range":9}]"#, "\"s\"").replace("\"f\"", id);
        let json =
            format!(r#"{{"type":"FeatureCollection","attributes":{{"s":[{{"name":"elevation","value":"shape","range":{range}}}]}},"features":[{named}]}}"#);
        Collection::parse(&json).unwrap()
    };
    let mut all = of(5, "1");
    all.append(of(6, "2"));
    all.append(of(5, "3"));
    let ranges: Vec<f64> = all.features(&Sets::default()).unwrap().iter().map(|feature| feature.attributes()[0].range).collect();
    assert_eq!((ranges, all.sets.iter().count()), (vec![5.0, 6.0, 5.0], 2));
}

#[test]
fn a_stored_set_is_named_by_its_content_and_an_edit_changes_few_parts() {
    let of = |i: usize, x: f64| line(&format!("[[{x},0,1],[5,5,1]]"), "").replace("\"f\"", &i.to_string());
    let set = |edited: Option<usize>| {
        let lines: Vec<String> = (0..5_000).map(|i| of(i, if edited == Some(i) { 0.5 } else { i as f64 })).collect();
        FeatureSet::new(Collection::parse(&lines.join("\n")).unwrap()).unwrap()
    };
    let stored = set(None).stored();
    assert!((8..40).contains(&stored.parts.len()), "{} parts", stored.parts.len());
    let again = FeatureSet::read(&stored).unwrap();
    assert_eq!((again.collection().features.len(), again.stored()), (5_000, stored.clone()));
    for edited in [0, 2_500, 4_999] {
        let changed = set(Some(edited)).stored();
        assert_ne!(changed.name, stored.name);
        let new = changed.parts.iter().filter(|part| !stored.parts.contains(part)).count();
        assert!((1..3).contains(&new), "{new} new parts");
    }
    let found = again.find(&crate::geometry::Rectangle { min: [4_000.0, -1.0], max: [9_000.0, 1.0] });
    assert_eq!(found, (4_000..5_000).collect::<Vec<u32>>());
    assert_eq!((again.position("17"), again.position("-1")), (Some(17), None));
    let empty = FeatureSet::new(Collection::default()).unwrap().stored();
    assert!(empty.parts.is_empty() && FeatureSet::read(&empty).unwrap().collection().features.is_empty());
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![(-1e6..1e6), (-1000_i32..1000).prop_map(f64::from), Just(-0.0), (-1e-9..1e-9), (-1e11..1e11)]
}

fn metres() -> impl Strategy<Value = f64> {
    prop_oneof![(-1e6..1e6), (-1000_i32..1000).prop_map(f64::from)]
}

fn value() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Shape),
        metres().prop_map(Value::Number),
        prop::collection::vec(metres(), 1..5).prop_map(|numbers| Value::Vector(numbers.into())),
        prop_oneof![Just("shape"), Just("rock"), Just("\"\\ \u{e9}")].prop_map(|name| Value::Name(name.into())),
        prop::collection::vec(metres(), 1..6).prop_map(|mut at| {
            at.sort_by(f64::total_cmp);
            at.dedup();
            Value::Profile(at.into_iter().map(|at| [at, at * 0.37]).collect())
        }),
        Just(Value::Expression(Expression::parse("max(0, minus(1, divide(d, 50)))").unwrap())),
        (metres(), any::<u64>(), any::<bool>()).prop_map(|(datum, seed, over_shape)| {
            let programme = if over_shape { Programme::parse("fbm(1, 2, 3)") } else { Programme::parse_json(r#"{"op":"sin","args":["x"]}"#) };
            let frame = Frame { seed, scale: 0.1 + datum.abs(), origin: [datum, 3.0] };
            Value::Terrain(Arc::new(TerrainValue { programme: programme.unwrap(), frame, amplitude: 7.5, datum, over_shape }))
        }),
    ]
}

fn attributes() -> impl Strategy<Value = Attribute> {
    let weight = prop_oneof![
        Just(Weight::Linear),
        Just(Weight::sharp()),
        (0.001..1e4).prop_map(|width| Weight::Sharp { width, nearest: 0.5 }),
        (0.001..1e4).prop_map(|width| Weight::Smooth { width }),
        Just(Weight::Custom(Expression::parse("minus(3, d)").unwrap())),
    ];
    let range = prop_oneof![Just(f64::INFINITY), 0.001..1e6];
    let side = prop_oneof![Just(Side::Inside), Just(Side::Outside), Just(Side::Edge)];
    (value(), weight, range, side, any::<bool>(), any::<u8>(), any::<bool>()).prop_map(|(value, weight, range, side, fade, priority, channel)| {
        let channel = channel && !matches!(value, Value::Name(_));
        let fade = (fade && range.is_finite()).then_some(range / 3.0);
        let role = if channel { Role::Channel { half_width: 2.5 } } else { Role::Level };
        Attribute { name: "own".into(), value, weight, range, side, fade, priority, role }
    })
}

/// Shapes that have an elevation.
fn shapes() -> impl Strategy<Value = Shape> {
    let path = prop::collection::vec((number(), number(), metres()), 2..9);
    prop_oneof![
        (number(), number(), metres()).prop_map(|(x, y, z)| Shape::point([x, y], Some(z)).unwrap()),
        (number(), number(), metres()).prop_map(|(x, y, z)| Shape::circle([x, y], z.abs() + 0.5, Some(z)).unwrap()),
        (path, any::<bool>(), any::<bool>(), any::<u64>()).prop_map(|(path, constant, arc, seed)| {
            let elevation = if constant { Elevation::Constant(path[0].2) } else { Elevation::Vertices(path.iter().map(|p| p.2).collect()) };
            let Shape::Line(curve) = Shape::line(path.iter().map(|p| [p.0, p.1]).collect(), elevation).unwrap() else { unreachable!() };
            let line = Shape::Line(curve.along(if arc { Along::Arc } else { Along::Chord }));
            if seed % 2 == 0 { line } else { line.detailed(Detail::new((seed % 9) as u8, 0.07, seed).unwrap()).unwrap() }
        }),
        (number(), number(), 1.0..1e5_f64, metres()).prop_map(|(x, y, r, z)| {
            let ring = |r: f64| vec![[x - r, y - r], [x + r, y - r], [x, y + 2.0 * r], [x - r, y - r]];
            Shape::polygon(vec![ring(r), ring(r / 4.0)], Elevation::Vertices((0..8).map(|i| z + f64::from(i) / 7.0).collect())).unwrap()
        }),
    ]
}

proptest! {
    #[test]
    fn what_is_written_is_read_back_to_the_bit(shape in shapes(), attributes in prop::collection::vec(attributes(), 0..4), precedence: i32, named: bool) {
        let mut feature = Feature::new(shape, Arc::new(AttributeSet::new(attributes).unwrap())).unwrap();
        feature.precedence = precedence;
        feature.id = Some("é \"1\"".into());
        let text = if named {
            serde_json::to_string(&Collection::of(std::slice::from_ref(&feature)).unwrap()).unwrap()
        } else {
            serde_json::to_string(&Drawn::of(&feature, None).unwrap()).unwrap()
        };
        let read = Collection::parse(&text).unwrap();
        prop_assert_eq!(serde_json::to_string(&read.features[0]).unwrap(), serde_json::to_string(&Collection::parse(&text).unwrap().features[0]).unwrap());
        let again = read.features(&Sets::default()).unwrap();
        prop_assert_eq!(again[0].hash(), feature.hash(), "{}", text);
        prop_assert_eq!((&again[0].id, again[0].precedence), (&feature.id, feature.precedence));
    }

    #[test]
    fn nothing_that_comes_panics(text in r#"[\[\]\{\}",:0-9a-z.eE+-]{0,80}"#) {
        let _ = Collection::parse(&text);
    }
}
