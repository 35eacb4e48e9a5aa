//! Roads between places of a world, and generators that start from what users drew.

use crate::client::Client;
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};

/// Hills with a river through them from north to south, and two villages as point features.
fn world() -> String {
    let river = json!([
        {"name": "elevation", "value": "shape", "weight": {"smooth": {"width": 60}}, "range": 400},
        {"name": "elevation", "value": "shape", "weight": {"smooth": {"width": 15}}, "range": 60, "channel": {"half_width": 6}},
        {"name": "water_depth", "value": {"profile": [[0, 2], [6, 0]]}, "weight": "linear", "range": 6}
    ]);
    let line = json!([[520, 2400, 40], [480, 1500, 30], [560, 700, 20], [500, -400, 10], [540, -1500, 2]]);
    let village =
        |id: &str, x: f64, y: f64| json!({"type": "Feature", "id": id, "geometry": {"type": "Point", "coordinates": [x, y]}, "properties": {"attributes": []}});
    let features = json!([
        {"type": "Feature", "id": "stream", "geometry": {"type": "LineString", "coordinates": line}, "properties": {"attributes": "river"}},
        village("Aldra", 0.0, 0.0), village("Berg", 1100.0, 500.0)
    ]);
    let lane = json!([{"name": "elevation", "value": "shape", "weight": "linear", "range": 9, "channel": {"half_width": 2}}]);
    json!({
        "seed": 5, "base": {"programme": "fbm(1, 2, 5)", "scale": 900, "amplitude": 45, "datum": 60},
        "layers": [{"name": "drawn", "source": {"layout": {"attributes": {"river": river, "lane": lane}, "features": features}}}]
    })
    .to_string()
}

const ROADS: &str = r#"{"generate": "roads", "places": ["Aldra", "Berg", {"name": "Col", "at": [300, 900]}], "grade": 0.1, "spacing": 30}"#;

async fn client() -> Client {
    let client = Client::new().await;
    let saved = client.put("/worlds/w", &world()).await;
    assert_eq!(saved.status, StatusCode::CREATED, "{}", String::from_utf8_lossy(&saved.body));
    client
}

async fn ground(client: &Client, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut all = Vec::new();
    for [x, y] in points {
        let answer = client.get(&format!("/worlds/w/elevation?x={x}&y={y}")).await.json();
        all.push(["elevation", "water_depth"].map(|name| answer[name].as_f64().unwrap()));
    }
    all
}

fn line(feature: &Value) -> Vec<[f64; 3]> {
    feature["geometry"]["coordinates"].as_array().unwrap().iter().map(|p| [0, 1, 2].map(|axis| p[axis].as_f64().unwrap())).collect()
}

#[tokio::test]
async fn roads_are_answered_as_features_that_cut_and_fill_and_leave_rivers_alone() {
    let client = client().await;
    let made = client.send(Method::POST, "/worlds/w/generate", &[], ROADS.to_owned()).await;
    assert_eq!(made.status, StatusCode::OK, "{}", String::from_utf8_lossy(&made.body));
    let made = made.json();
    let features = made["features"].as_array().unwrap();
    let of = |kind: &str| features.iter().filter(|f| f["properties"]["kind"] == kind).collect::<Vec<_>>();
    let (roads, bridges) = (of("road"), of("bridge"));
    assert!(roads.len() > 1 && !bridges.is_empty() && roads.len() + bridges.len() == features.len());
    assert!(roads.iter().any(|road| road["properties"]["name"].as_str().unwrap().contains("Aldra")));
    for road in &roads {
        let line = line(road);
        let steep = line.windows(2).map(|p| (p[1][2] - p[0][2]).abs() / f64::hypot(p[1][0] - p[0][0], p[1][1] - p[0][1])).fold(0.0, f64::max);
        assert!(steep <= 0.1 * (1.0 + 1e-9), "{steep}");
    }
    assert_eq!(made["attributes"][bridges[0]["properties"]["attributes"].as_str().unwrap()], json!([]), "bridges leave the ground as it is");
    // The water beneath a bridge is the same before and after.
    let over: Vec<[f64; 2]> = bridges.iter().flat_map(|bridge| line(bridge)).map(|p| [p[0], p[1]]).collect();
    let before = ground(&client, &over).await;
    assert!(before.iter().any(|sample| sample[1] > 0.5), "there is a river under it");
    let added = client.send(Method::POST, "/worlds/w/features", &[], made.to_string()).await;
    assert_eq!(added.status, StatusCode::CREATED, "{}", String::from_utf8_lossy(&added.body));
    let after = ground(&client, &over).await;
    for (before, after) in before.iter().zip(&after).filter(|(before, _)| before[1] > 0.0) {
        assert_eq!(before, after);
    }
    // The ground is where the road is.
    let on: Vec<[f64; 3]> = roads.iter().flat_map(|road| line(road)).collect();
    let heights = ground(&client, &on.iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>()).await;
    for (p, height) in on.iter().zip(&heights) {
        assert!((p[2] - height[0]).abs() < 0.05 && height[1] == 0.0, "{p:?} {height:?}");
    }
    let again = client.send(Method::POST, "/worlds/w/generate", &[], ROADS.to_owned()).await;
    assert_eq!(again.status, StatusCode::OK, "over the roads that there are by now");
    let again = again.json();
    let is_bridge = |feature: &Value| feature["properties"]["kind"] == "bridge";
    assert!(again["features"].as_array().unwrap().iter().any(is_bridge), "the river is seen beneath the layer of roads");
}

#[tokio::test]
async fn roads_take_styles_and_name_what_is_wrong() {
    let client = client().await;
    let ask = async |body: String| client.send(Method::POST, "/worlds/w/generate", &[], body).await;
    let styled = ask(ROADS.replace("\"spacing\"", "\"styles\": {\"roads\": \"lane\"}, \"spacing\"")).await.json();
    let sets: Vec<&Value> = styled["attributes"].as_object().unwrap().values().collect();
    assert!(sets.iter().any(|set| set[0]["range"] == 9), "{sets:?}");
    let said = async |from: &str, to: &str| ask(ROADS.replace(from, to)).await.problem();
    assert_eq!(said("\"Aldra\"", "\"Nowhere\"").await, "422 /places/0: no feature of the world has the id \"Nowhere\"");
    assert_eq!(said("\"Aldra\"", "\"stream\"").await, "422 /places/0: feature \"stream\" is no Point");
    assert_eq!(said("\"Col\"", "\"Berg\"").await, "422 /places/2: \"Berg\" is the name of another place");
    assert_eq!(said("[300, 900]", "[300]").await.split(": ").next(), Some("422 /places/2/at"));
    assert!(said("[300, 900]", "[505, -400]").await.starts_with("422 /places/2: \"Col\" lies in the water"));
    assert!(said("0.1", "9").await.starts_with("422 /grade: must be a number from 0.005 to 1"));
    assert!(said("\"spacing\"", "\"space\"").await.starts_with("422 /space: unknown field `space`"));
    assert!(said("\"spacing\"", "\"seed\": 1, \"spacing\"").await.starts_with("422 /seed: roads follow from the terrain"));
    assert!(
        said("\"spacing\"", "\"styles\": {\"roads\": \"none\"}, \"spacing\"")
            .await
            .contains("/styles/roads: no set of attributes of the world is named \"none\"")
    );
    let no_way = said("\"spacing\"", "\"bridge\": 0, \"margin\": 200, \"spacing\"").await;
    assert!(no_way.contains("no road leads from \"Aldra\" to \"Berg\": water lies between"), "{no_way}");
    let list = ask(format!("[{}, {ROADS}]", json!({"generate": "landmass", "radius": 900}))).await.json();
    assert!(list["features"].as_array().unwrap().len() > 3 && list["features"][0]["geometry"]["type"] == "Polygon");
    let inside =
        json!({"seed": 1, "base": {"programme": "x", "scale": 1}, "layers": [{"name": "a", "source": {"layout": {"features": [{"generate": "roads"}]}}}]});
    assert!(
        client.put("/worlds/x", &inside.to_string()).await.problem().contains("/layers/0/source/layout/features/0/generate: roads lie over finished terrain")
    );
}

/// A coast of 24 corners round the origin.
fn coast(third: Option<f64>) -> Value {
    let corner = |i: u32| {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(i % 24) / 24.0);
        let radius = 4000.0 + 500.0 * f64::from(i % 24 % 5);
        let at = [(radius * cosine).round(), (radius * sine).round()];
        third.map_or_else(|| json!(at), |z| json!([at[0], at[1], z]))
    };
    let ring: Vec<Value> = (0..=24).map(corner).collect();
    json!({"type": "Feature", "id": "coast", "geometry": {"type": "Polygon", "coordinates": [ring]}, "properties": {"attributes": []}})
}

#[tokio::test]
async fn generators_start_from_what_was_drawn() {
    let client = client().await;
    let river = json!({"type": "Feature", "id": "mine", "geometry": {"type": "LineString", "coordinates": [[0, 0], [900, -700], [1500, -1900], [2100, -2700]]}, "properties": {"attributes": []}});
    assert_eq!(
        client.send(Method::POST, "/worlds/w/features", &[], json!({"type": "FeatureCollection", "features": [coast(None), river]}).to_string()).await.status,
        StatusCode::CREATED
    );
    let ask = async |body: Value| client.send(Method::POST, "/worlds/w/generate", &[], body.to_string()).await;
    let rivers = json!({"generate": "rivers", "spacing": 700, "rounds": 2, "land": ["coast"], "drawn": ["mine"], "lakes": {}});
    let ridges = json!({"generate": "ridges", "step": 180, "land": ["coast"]});
    let made = ask(json!([rivers, ridges])).await;
    assert_eq!(made.status, StatusCode::OK, "{}", String::from_utf8_lossy(&made.body));
    let made = made.json();
    let features = made["features"].as_array().unwrap();
    assert!(features.len() > 60, "{}", features.len());
    let lines: Vec<Vec<[f64; 3]>> = features.iter().filter(|f| f["geometry"]["type"] == "LineString").map(line).collect();
    for p in [[0.0, 0.0], [900.0, -700.0], [1500.0, -1900.0]] {
        assert!(lines.iter().flatten().any(|q| f64::hypot(q[0] - p[0], q[1] - p[1]) < 400.0), "the drawn river is part of what is made");
    }
    assert!(lines.iter().flatten().all(|p| f64::hypot(p[0], p[1]) < 6001.0 && p[2] >= 0.0), "all on the land");
    let inline =
        ask(json!([{"generate": "rivers", "spacing": 700, "rounds": 2, "land": [coast(Some(0.0))], "drawn": [river], "lakes": {}}, ridges])).await.json();
    assert_eq!(inline, made, "by id or inline, with the sea's elevation or without");
    // The same in a document, where features stand inline.
    let item = json!({"generate": "rivers", "spacing": 700, "rounds": 2, "land": [coast(None)]});
    let document = json!({"seed": 5, "base": {"programme": "x", "scale": 1}, "layers": [{"name": "a", "source": {"layout": {"features": [item]}}}]});
    let saved = client.put("/worlds/x", &document.to_string()).await;
    assert_eq!(saved.status, StatusCode::CREATED, "{}", String::from_utf8_lossy(&saved.body));
    let completed = client.get("/worlds/x").await;
    assert_eq!(client.put("/worlds/x", &String::from_utf8_lossy(&completed.body)).await.header("etag"), completed.header("etag"), "completed once");
    let lakes = ask(json!({"generate": "ridges", "land": ["coast"], "waters": ["stream"]})).await;
    assert_eq!(lakes.status, StatusCode::OK, "{}", String::from_utf8_lossy(&lakes.body));
}

#[tokio::test]
async fn what_was_drawn_wrong_is_named_with_feature_and_vertex() {
    let client = client().await;
    let said = async |body: Value| client.send(Method::POST, "/worlds/w/generate", &[], body.to_string()).await.problem();
    let line = |coordinates: Value| json!({"type": "Feature", "id": "mine", "geometry": {"type": "LineString", "coordinates": coordinates}, "properties": {}});
    let with = |drawn: Value| json!({"generate": "rivers", "land": [coast(None)], "drawn": [drawn]});
    assert_eq!(said(json!({"generate": "rivers", "land": ["none"]})).await, "422 /land/0: no feature of the world has the id \"none\"");
    assert_eq!(said(json!({"generate": "rivers", "land": ["stream"]})).await, "422 /land/0/geometry: feature \"stream\": must be a Polygon, the coast");
    assert_eq!(said(with(line(json!([[0, 0], [90_000, 0], [100, 100]])))).await, "422 /drawn/0: vertex 1 lies outside the land, at 90000 0");
    let crossing = said(with(line(json!([[0, 0], [900, 0], [900, 900], [400, -400]])))).await;
    assert!(crossing.starts_with("422 /drawn/0: crosses drawn[0] between vertices 2 and 3"), "{crossing}");
    let mut crossed = coast(None);
    crossed["geometry"]["coordinates"][0][3] = json!([-4000, -4000]);
    let said_of = said(json!({"generate": "rivers", "land": [crossed]})).await;
    assert!(said_of.starts_with("422 /land/0/geometry") && said_of.contains("feature \"coast\"") && said_of.contains("vertex"), "{said_of}");
    let flat = said(json!({"generate": "ridges", "land": [coast(None)], "waters": [line(json!([[0, 0], [500, 0]]))]})).await;
    assert!(flat.starts_with("422 /waters/0/geometry/coordinates: feature \"mine\": vertex 0: has no elevation"), "{flat}");
    assert!(said(json!({"generate": "rivers", "land": 3})).await.starts_with("422 /land: must be a list of GeoJSON Features"));
}
