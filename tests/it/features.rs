//! A world's features over HTTP: added, found, changed, refused, drawn.

use crate::client::{Answer, Client};
use axum::{
    body::Body,
    http::{Method, StatusCode},
};
use serde_json::{Value, json};

const WORLD: &str = "/worlds/w";

async fn client() -> Client {
    let client = Client::new().await;
    assert_eq!(client.put(WORLD, r#"{"seed":3,"base":{"programme":"fbm(1,2,4)","scale":20000,"amplitude":100}}"#).await.status, StatusCode::CREATED);
    client
}

fn ridge(id: &str, x: f64, y: f64) -> Value {
    json!({
        "type": "Feature", "id": id, "geometry": {"type": "LineString", "coordinates": [[x, y, 700], [x + 300.0, y + 40.0, 800]]},
        "properties": {"attributes": "crest", "name": format!("Ridge {id}")},
    })
}

fn collection(features: &[Value]) -> String {
    let crest = json!([{"name": "elevation", "value": "shape", "weight": "linear", "range": 200}]);
    json!({"type": "FeatureCollection", "attributes": {"crest": crest}, "features": features}).to_string()
}

async fn post(client: &Client, headers: &[(&str, &str)], body: impl Into<Body>) -> Answer {
    client.send(Method::POST, &format!("{WORLD}/features"), headers, body).await
}

fn quoted(revision: &str) -> String {
    format!("\"{revision}\"")
}

async fn revision(client: &Client) -> String {
    client.get(WORLD).await.header("etag").trim_matches('"').to_owned()
}

#[tokio::test]
async fn features_are_added_found_changed_and_deleted() {
    let client = client().await;
    let empty = client.get(&format!("{WORLD}/features")).await;
    assert_eq!(
        (empty.header("content-type"), empty.json()["features"].clone(), empty.json()["numberMatched"].clone()),
        ("application/geo+json", json!([]), json!(0))
    );
    let before = revision(&client).await;
    let features: Vec<Value> = (0..5).map(|i| ridge(&format!("r{i}"), f64::from(i) * 10_000.0, 0.0)).collect();
    let added = post(&client, &[("if-match", &quoted(&before))], collection(&features)).await;
    assert_eq!((added.status, added.json()["added"].clone()), (StatusCode::CREATED, json!(5)), "{:?}", added.json());
    let after = revision(&client).await;
    assert_eq!((added.header("etag"), added.json()["revision"].as_str()), (quoted(&after).as_str(), Some(after.as_str())));
    assert_ne!(before, after);
    let late = post(&client, &[("if-match", &quoted(&before))], collection(&[ridge("late", 0.0, 0.0)])).await;
    assert_eq!(late.status, StatusCode::PRECONDITION_FAILED);

    // Pages follow one another by their links and hold everything once.
    let (mut ids, mut next) = (Vec::new(), format!("{WORLD}/features?limit=2"));
    loop {
        let page = client.get(&next).await.json();
        ids.extend(page["features"].as_array().unwrap().iter().map(|feature| feature["id"].as_str().unwrap().to_owned()));
        assert_eq!((page["attributes"]["crest"][0]["range"].clone(), page["numberMatched"].clone()), (json!(200), json!(5)));
        let Some(link) = page["links"].as_array().unwrap().iter().find(|link| link["rel"] == "next") else { break };
        link["href"].as_str().unwrap().trim_start_matches("http://localhost:8080").clone_into(&mut next);
    }
    assert_eq!(ids, ["r0", "r1", "r2", "r3", "r4"]);
    let near = client.get(&format!("{WORLD}/features?bbox=19000,-100,20100,100")).await.json();
    assert_eq!((near["numberReturned"].clone(), near["features"][0]["properties"]["name"].clone()), (json!(1), json!("Ridge r2")));

    let one = client.get(&format!("{WORLD}/features/r2")).await;
    assert_eq!(one.json(), near["features"][0]);
    let tag = one.header("etag").to_owned();
    assert_eq!(client.send(Method::GET, &format!("{WORLD}/features/r2"), &[("if-none-match", &tag)], "").await.status, StatusCode::NOT_MODIFIED);
    let moved = ridge("r2", 20_500.0, 0.0).to_string();
    // What happens to other features is no change of this one.
    assert_eq!(client.send(Method::DELETE, &format!("{WORLD}/features/r0"), &[], "").await.status, StatusCode::NO_CONTENT);
    let put = client.send(Method::PUT, &format!("{WORLD}/features/r2"), &[("if-match", &tag)], moved.clone()).await;
    assert_eq!((put.status, put.json()["geometry"]["coordinates"][0].clone()), (StatusCode::OK, json!([20_500, 0, 700])));
    assert_eq!(client.send(Method::PUT, &format!("{WORLD}/features/r2"), &[("if-match", &tag)], moved).await.status, StatusCode::PRECONDITION_FAILED);
    assert_eq!(client.send(Method::DELETE, &format!("{WORLD}/features/r2"), &[("if-match", &tag)], "").await.status, StatusCode::PRECONDITION_FAILED);
    let new = client.put(&format!("{WORLD}/features/a%2Fb"), &ridge("a/b", 0.0, 5_000.0).to_string()).await;
    assert_eq!((new.status, client.get(&format!("{WORLD}/features/a%2Fb")).await.json()["id"].clone()), (StatusCode::CREATED, json!("a/b")));
    let only = client.send(Method::PUT, &format!("{WORLD}/features/r1"), &[("if-none-match", "*")], ridge("r1", 0.0, 0.0).to_string()).await;
    assert_eq!(only.status, StatusCode::PRECONDITION_FAILED);
    assert_eq!(client.get(&format!("{WORLD}/features/r0")).await.status, StatusCode::NOT_FOUND);
    assert_eq!(client.send(Method::DELETE, &format!("{WORLD}/features/r0"), &[], "").await.status, StatusCode::NOT_FOUND);
    assert_eq!(
        client.put(&format!("{WORLD}/features/r1"), &ridge("r9", 0.0, 0.0).to_string()).await.problem(),
        "422 /id: must be \"r1\", as in the address, or left out"
    );

    // All of it is on disk, and every revision stays.
    let client = client.restart(|_| {}).await;
    let list = client.get(&format!("{WORLD}/features")).await.json();
    let ids: Vec<&str> = list["features"].as_array().unwrap().iter().map(|feature| feature["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["r1", "r2", "r3", "r4", "a/b"]);
    let old = client.get(&format!("{WORLD}@{after}/features")).await.json();
    assert_eq!(old["numberMatched"], 5);
    assert_eq!(client.get(&format!("{WORLD}/revisions")).await.json().as_array().unwrap().len(), 5);
    // The document names the set, and can be saved under another name.
    let document = client.get(WORLD).await;
    assert_eq!(document.json()["layers"][0]["source"]["layout"]["features"][0]["set"].as_str().unwrap().len(), 32);
    assert_eq!(client.put("/worlds/copy", std::str::from_utf8(&document.body).unwrap()).await.status, StatusCode::CREATED);
    assert_eq!(client.get("/worlds/copy/features").await.json()["numberMatched"], 5);
    let unknown = std::str::from_utf8(&document.body)
        .unwrap()
        .replace(document.json()["layers"][0]["source"]["layout"]["features"][0]["set"].as_str().unwrap(), &"0".repeat(32));
    assert!(client.put("/worlds/other", &unknown).await.problem().starts_with("422 /layers/0/source/layout/features/0/set: "));
}

#[tokio::test]
async fn lines_come_in_pieces_and_ids_are_made() {
    let client = client().await;
    post(&client, &[], collection(&[ridge("a", 0.0, 0.0)])).await;
    let mut plain = ridge("x", 4_000.0, 0.0);
    plain.as_object_mut().unwrap().remove("id");
    let text = format!("{}\n{}\n\u{1e}{}\n", plain, ridge("7", 8_000.0, 0.0), plain);
    // Pieces of 7 bytes split tokens and characters wherever they like.
    let pieces: Vec<Result<Vec<u8>, std::io::Error>> = text.as_bytes().chunks(7).map(|piece| Ok(piece.to_vec())).collect();
    let added = post(&client, &[("content-type", "application/geo+json-seq")], Body::from_stream(futures_util::stream::iter(pieces))).await;
    let ids: Vec<String> = serde_json::from_value(added.json()["ids"].clone()).unwrap();
    assert_eq!((ids.len(), ids[1].as_str(), format!("{}-2", ids[0])), (3, "7", ids[2].clone()));
    let taken = post(&client, &[], collection(&[ridge("b", 0.0, 0.0), ridge("7", 0.0, 0.0)])).await;
    assert_eq!(taken.problem(), "422 /features/1/id: feature \"7\": the world has a feature with this id already");
    let broken: Vec<Result<Vec<u8>, std::io::Error>> = vec![Ok(b"{\"type\":\"Feature\",".to_vec()), Err(std::io::Error::other("gone"))];
    assert_eq!(post(&client, &[], Body::from_stream(futures_util::stream::iter(broken))).await.status, StatusCode::BAD_REQUEST);
    assert_eq!(client.get(&format!("{WORLD}/features")).await.json()["numberMatched"], 4);
    for (query, problem) in [("limit=0", "400 limit: must be 1 … 10000, got 0"), ("bbox=1,2,3", "400 bbox: must be minx,miny,maxx,maxy"), ("zoom=1", "400 ")]
    {
        let answer = client.get(&format!("{WORLD}/features?{query}")).await.problem();
        assert!(answer.starts_with(problem), "{answer}");
    }
}

#[tokio::test]
async fn bodies_have_a_limit_of_their_own() {
    let client = Client::with(|config| config.limits.feature_bytes = 600).await;
    client.put(WORLD, r#"{"seed":3,"base":{"programme":"x","scale":20000}}"#).await;
    assert_eq!(post(&client, &[], collection(&[ridge("a", 0.0, 0.0)])).await.status, StatusCode::CREATED);
    let answer = post(&client, &[], collection(&[ridge("b", 0.0, 0.0), ridge("c", 0.0, 0.0), ridge("d", 0.0, 0.0)])).await;
    assert_eq!(answer.problem(), "413 The body must be at most 600 bytes.");
}

#[tokio::test]
async fn bad_input_is_told_with_feature_and_vertex_and_nothing_is_stored() {
    let client = client().await;
    post(&client, &[], collection(&[ridge("good", 0.0, 0.0)])).await;
    let before = revision(&client).await;
    let line = |coordinates: &str| ridge("bad", 0.0, 0.0).to_string().replace("[[0.0,0.0,700],[300.0,40.0,800]]", coordinates);
    let polygon = |coordinates: &str| line(coordinates).replace("LineString", "Polygon");
    let attribute = |attribute: &str| line("[[0,0,1],[9,9,1]]").replace("\"crest\"", &format!("[{attribute}]"));
    let million: Vec<String> = (0..1_000_000).map(|i| format!("[{i},0,1]")).collect();
    let cases = [
        (
            polygon("[[[0,0,1],[9,9,1],[9,0,1],[0,9,1],[0,0,1]]]"),
            "feature \"bad\": the polygon crosses itself: the edge from vertex 0 meets the edge from vertex 2",
        ),
        (polygon("[[[0,0,1],[9,0,1],[9,9,1]]]"), "vertex 0"),
        (polygon("[[[0,0,1],[9,0,1],[9,9,1],[0,9,1]]]"), "feature \"bad\": vertex 3 must close its ring"),
        (line("[[0,0,1],[9,null,1]]"), "feature \"bad\": vertex 1: a coordinate must be a number, got null"),
        (line("[[0,0,1],[NaN,0,1]]"), "feature number 1: vertex 1: not JSON"),
        (line(&format!("[{}]", million.join(","))), "feature \"bad\": vertex 250000: is the first beyond the 250000"),
        (line("[[0,0],[9,9]]"), "feature \"bad\": vertex 0: attribute \"elevation\" takes the elevation of the shape"),
        (line("[[0,0,1],[9,9]]"), "feature \"bad\": vertex 1 and vertex 0 are unlike"),
        (
            attribute(r#"{"name":"elevation","value":"shape","range":0}"#),
            "feature \"bad\": attribute \"elevation\": a range is a positive number of metres or infinite, got 0",
        ),
        (
            attribute(r#"{"name":"elevation","value":"shape","range":-3}"#),
            "feature \"bad\": attribute \"elevation\": a range is a positive number of metres or infinite, got -3",
        ),
        (attribute(r#"{"name":"elevation","value":"shape","range":3,"weight":"gaussian"}"#), "feature \"bad\": must be \"linear\""),
        (
            attribute(r#"{"name":"elevation","value":{"spline":[]},"range":3}"#),
            "feature \"bad\": must be an object with one of profile, expression, programme, name",
        ),
        (
            line("[[0,0,1],[9,9,1]]").replace("crest", "crust"),
            "feature \"bad\": no set of attributes is named \"crust\"; there are crest (did you mean \"crest\"?)",
        ),
    ];
    for (bad, expected) in cases {
        let body = collection(&[ridge("fine", 0.0, 0.0), json!("here")]).replace("\"here\"", &bad);
        let answer = post(&client, &[], body).await;
        let problem = answer.problem();
        assert!(problem.starts_with("422 /features/1") && problem.contains(expected), "{problem:.400} for {expected}");
        assert_eq!(answer.json()["type"], "urn:terrane:invalid-features");
    }
    assert_eq!(revision(&client).await, before);
    assert_eq!(client.get(&format!("{WORLD}/features")).await.json()["numberMatched"], 1);
    let two = post(&client, &[], collection(&[ridge("a", 0.0, 0.0), ridge("a", 0.0, 0.0)])).await;
    assert_eq!(two.problem(), "422 /features/1/id: feature \"a\": feature number 0 has this id already");
}

#[tokio::test]
async fn writes_from_elsewhere_are_refused() {
    let client = client().await;
    for (method, path) in [(Method::POST, "features"), (Method::PUT, "features/a"), (Method::DELETE, "features/a"), (Method::POST, "generate")] {
        let answer = client.send(method, &format!("{WORLD}/{path}"), &[("x-forwarded-for", "192.0.2.1")], "{}").await;
        assert_eq!(answer.status, StatusCode::FORBIDDEN);
    }
}

#[tokio::test]
async fn what_generators_make_can_be_edited_and_added() {
    let client = client().await;
    let item = json!({"generate": "island", "seed": 7, "landmass": {"radius": 5000}, "rivers": {"rounds": 2}}).to_string();
    let made = client.send(Method::POST, &format!("{WORLD}/generate"), &[], item.clone()).await;
    assert_eq!((made.status, made.header("content-type")), (StatusCode::OK, "application/geo+json"), "{}", String::from_utf8_lossy(&made.body));
    let features = made.json()["features"].as_array().unwrap().len();
    assert!(features > 20, "{features}");
    assert_eq!(
        client.send(Method::POST, &format!("{WORLD}/generate"), &[], item.replace("5000", "-1")).await.problem(),
        "422 /landmass/radius: must be a number from 1 to 10000000, got -1"
    );
    assert_eq!(client.send(Method::POST, &format!("{WORLD}/generate"), &[], "[{}]").await.problem(), "422 /0: expected {\"generate\": …}");
    let tile = format!("{WORLD}/metric/r32/12/0/-1@33.bin");
    let before = client.get(&tile).await;
    let added = post(&client, &[], made.body.clone()).await;
    assert_eq!((added.status, added.json()["added"].clone()), (StatusCode::CREATED, json!(features)));
    // As features they make the terrain that the generator makes in the document.
    let layer = json!({"name": "island", "source": {"layout": {"features": [serde_json::from_str::<Value>(&item).unwrap()]}}});
    let document = json!({"seed": 3, "base": {"programme": "fbm(1,2,4)", "scale": 20000, "amplitude": 100}, "layers": [layer]}).to_string();
    client.put("/worlds/generated", &document).await;
    let (drawn, generated) = (client.get(&tile).await, client.get(&tile.replace("/w/", "/generated/")).await);
    assert_eq!(drawn.body, generated.body);
    assert_ne!(drawn.body, before.body);
    let vector = client.get(&format!("{WORLD}/metric/features/12/0/-1.mvt")).await;
    assert_eq!((vector.status, vector.header("content-type")), (StatusCode::OK, "application/vnd.mapbox-vector-tile"));
    assert!(vector.body.len() > 500);
    let same = client.get("/worlds/generated/metric/features/12/0/-1.mvt").await;
    assert!(same.body.len() > 500, "generated features are drawn too");
}

#[tokio::test]
async fn an_edit_changes_the_tags_of_the_tiles_it_can_reach_and_no_others() {
    let client = client().await;
    let fixed: Vec<Value> = (0..8).map(|i| ridge(&format!("r{i}"), f64::from(i % 4) * 2_000.0, f64::from(i / 4) * 2_000.0)).collect();
    post(&client, &[], collection(&fixed)).await;
    // Tiles of 1,024 m a side, 33 vertices: 32 m a sample.
    let tiles: Vec<(i64, i64)> = (-2..9).flat_map(|x| (-6..4).map(move |y| (x, y))).collect();
    for (number, tileset) in ["r32", "hillshade", "contours", "features"].into_iter().enumerate() {
        let extension = match tileset {
            "r32" => "bin",
            "hillshade" => "png",
            _ => "mvt",
        };
        let address = |x: i64, y: i64| format!("{WORLD}/metric/{tileset}/15/{x}/{y}@33.{extension}");
        let mut before = Vec::new();
        for &(x, y) in &tiles {
            before.push(client.get(&address(x, y)).await.header("etag").to_owned());
        }
        let at = if number % 2 == 0 { 2_900.0 } else { 3_000.0 };
        let old = client.get(&format!("{WORLD}/features/r5")).await.json()["geometry"]["coordinates"][0].clone();
        assert_eq!(client.put(&format!("{WORLD}/features/r5"), &ridge("r5", at, 2_100.0).to_string()).await.status, StatusCode::OK);
        let [old_x, old_y] = [0, 1].map(|axis| old[axis].as_f64().unwrap());
        // Influence rectangles: the shape and 200 m, and samples beyond the tile.
        let apron = match tileset {
            "r32" => 0.0,
            "hillshade" => 32.0,
            _ => 4.0 * 32.0,
        };
        let reached = |x: i64, y: i64| {
            let (west, north) = (x as f64 * 1024.0, -(y as f64) * 1024.0);
            [(old_x, old_y), (at, 2_100.0)].into_iter().any(|(left, bottom)| {
                let grown = 200.0 + apron;
                left - grown <= west + 1024.0 && left + 300.0 + grown >= west && bottom - grown <= north && bottom + 40.0 + grown >= north - 1024.0
            })
        };
        let mut changed = 0;
        for (&(x, y), tag) in tiles.iter().zip(&before) {
            let status = client.send(Method::GET, &address(x, y), &[("if-none-match", tag)], "").await.status;
            let expected = if reached(x, y) { StatusCode::OK } else { StatusCode::NOT_MODIFIED };
            assert_eq!(status, expected, "{tileset} {x} {y}");
            changed += usize::from(reached(x, y));
        }
        assert!((2..30).contains(&changed), "{tileset}: {changed}");
    }
}

#[tokio::test]
async fn vector_tilesets_tell_their_layers() {
    let client = client().await;
    let tilejson = client.get(&format!("{WORLD}/web/contours")).await.json();
    assert_eq!(
        (tilejson["vector_layers"][0]["id"].clone(), tilejson["vector_layers"][0]["fields"]["index"].clone()),
        (json!("contours"), json!("Boolean: every fifth line"))
    );
    assert!(tilejson["tiles"][0].as_str().unwrap().ends_with("/web/contours/{z}/{x}/{y}.mvt") && tilejson.get("tileSize").is_none());
    let ids = client.get(&format!("{WORLD}/web/features")).await.json()["vector_layers"].clone();
    assert_eq!(ids.as_array().unwrap().iter().map(|layer| layer["id"].as_str().unwrap()).collect::<Vec<_>>(), ["points", "lines", "areas"]);
    let tile = client.get(&format!("{WORLD}/web/contours/12/2048/2047.mvt")).await;
    assert_eq!((tile.status, tile.header("content-type")), (StatusCode::OK, "application/vnd.mapbox-vector-tile"));
    assert!(tile.body.len() > 100);
    assert_eq!(
        client.send(Method::GET, &format!("{WORLD}/web/contours/12/2048/2047.mvt"), &[("if-none-match", tile.header("etag"))], "").await.status,
        StatusCode::NOT_MODIFIED
    );
    assert_eq!(client.get(&format!("{WORLD}/web/contours/12/2048/2047.png")).await.status, StatusCode::NOT_FOUND);
    let nothing = client.get(&format!("{WORLD}/web/features/12/2048/2047.mvt")).await;
    assert_eq!((nothing.status, nothing.body.len()), (StatusCode::OK, 0));
}
