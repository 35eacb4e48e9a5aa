//! Reading: what the calls answer, and what they say to requests that are wrong.

use crate::client::Client;
use axum::http::{Method, StatusCode};
use serde_json::json;
use terrane::world::{Document, World};

#[tokio::test]
async fn a_new_server_has_the_example_worlds_with_their_tilesets() {
    let client = Client::new().await;
    let catalog = client.get("/catalog").await.json();
    let worlds = catalog["worlds"].as_array().unwrap();
    let names: Vec<_> = worlds.iter().map(|world| world["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        ["alps", "archipelago", "archipelago-endless", "cordillera", "dunes", "eq2", "hills", "mesas", "ridges-and-rivers", "ridges-rivers-and-lakes"]
    );
    assert_eq!(worlds[0]["title"], "Alps");
    assert_eq!(worlds[0]["tilesets"][0], json!({"grid": "web", "tileset": "terrarium", "tilejson": "http://localhost:8080/worlds/alps/web/terrarium"}));
    assert_eq!(worlds[0]["tilesets"].as_array().unwrap().len(), 47);
    let list = client.get("/worlds").await.json();
    assert_eq!(list["worlds"][5]["revision"], worlds[5]["revision"]);
    assert!(list["worlds"][5].get("tilesets").is_none());
}

#[tokio::test]
async fn tilejson_leads_to_tiles_that_never_change() {
    let client = Client::new().await;
    for tileset in ["terrarium", "terrain-rgb", "fit", "height16", "r16", "r32", "hillshade", "slope", "normals", "water", "materials", "weights", "relief"] {
        for grid in ["web", "geo", "metric"] {
            let tilejson = client.get(&format!("/worlds/hills/{grid}/{tileset}")).await.json();
            assert_eq!((&tilejson["tilejson"], &tilejson["tileSize"], &tilejson["maxzoom"]), (&json!("3.0.0"), &json!(512), &json!(24)));
            let template = tilejson["tiles"][0].as_str().unwrap();
            let path = template.strip_prefix("http://localhost:8080").unwrap().replace("{z}", "11").replace("{x}", "1024").replace("{y}", "1023");
            assert!(path.contains("/worlds/hills@"), "{path}");
            let tile = client.get(&path).await;
            assert_eq!((tile.status, tile.header("cache-control")), (StatusCode::OK, "public, max-age=31536000, immutable"));
            let plain = client.get(&format!("/worlds/hills/{grid}/{tileset}?live")).await.json();
            assert_eq!(plain["tiles"][0].as_str().unwrap().split_once("/worlds/hills/").unwrap().0, "http://localhost:8080");
        }
    }
    let encoding = async |tileset: &str| client.get(&format!("/worlds/hills/web/{tileset}")).await.json()["encoding"].clone();
    assert_eq!((encoding("terrarium").await, encoding("terrain-rgb").await, encoding("hillshade").await), (json!("terrarium"), json!("mapbox"), json!(null)));
}

#[tokio::test]
async fn tiles_answer_304_from_their_fingerprint_without_evaluation() {
    let client = Client::new().await;
    let path = "/worlds/alps/web/terrarium/9/260/251.png";
    let tile = client.get(path).await;
    assert_eq!((tile.status, tile.header("content-type"), tile.header("cache-control")), (StatusCode::OK, "image/png", "no-cache"));
    assert_eq!(client.app.evaluations(), 1);
    let tag = tile.header("etag").to_owned();
    for known in [tag.clone(), format!("\"other\", W/{tag}"), "*".to_owned()] {
        let again = client.send(Method::GET, path, &[("if-none-match", &known)], "").await;
        assert_eq!((again.status, again.body.len(), again.header("etag")), (StatusCode::NOT_MODIFIED, 0, tag.as_str()));
    }
    // A tile that was never asked for is answered from its fingerprint alone.
    let document = client.get("/worlds/alps").await;
    let world = World::new(Document::parse(&document.body).unwrap());
    let request = terrane::geometry::Tile { z: 9, x: 3, y: 3 };
    let (samples, filter) = (terrane::geometry::Samples::Centres(256), terrane::geometry::Filter::Band);
    let grid = terrane::geometry::Grid::Web;
    let area = grid.window(request, samples, filter).unwrap().bounds();
    let fingerprint = world.fingerprint(terrane::tile::Tileset::Terrarium.form(), &area, grid, request, samples, filter);
    let unseen = client.send(Method::GET, "/worlds/alps/web/terrarium/9/3/3.png", &[("if-none-match", &format!("\"{fingerprint}\""))], "").await;
    assert_eq!((unseen.status, client.app.evaluations()), (StatusCode::NOT_MODIFIED, 1));
    assert_eq!(client.get(path).await.body, tile.body);
    assert_eq!(client.app.evaluations(), 1, "the second time it comes from the cache");
}

#[tokio::test]
async fn everything_with_an_entity_tag_answers_304_to_it() {
    let client = Client::new().await;
    for path in
        ["/", "/worlds/alps", "/worlds/alps/web/terrarium", "/worlds/alps/style.json", "/worlds/alps/elevation?x=1&y=2", "/worlds/alps/metric/r32/3/4/2@9.bin"]
    {
        let first = client.get(path).await;
        let tag = first.header("etag");
        // Without the viewer the page at the root has none.
        if path == "/" && tag.is_empty() {
            continue;
        }
        let again = client.send(Method::GET, path, &[("if-none-match", tag)], "").await;
        assert_eq!((again.status, again.header("etag"), again.body.len()), (StatusCode::NOT_MODIFIED, tag, 0), "{path}");
    }
}

#[tokio::test]
async fn head_options_and_other_methods_are_answered() {
    let client = Client::new().await;
    let path = "/worlds/alps/web/hillshade/9/260/251.png";
    let head = client.send(Method::HEAD, path, &[], "").await;
    assert_eq!((head.status, head.body.len()), (StatusCode::OK, 0));
    assert!(head.header("content-length").parse::<usize>().unwrap() > 1000);
    let get = client.send(Method::GET, path, &[("origin", "https://maps.example")], "").await;
    assert_eq!(get.header("access-control-allow-origin"), "*");
    assert!(get.header("access-control-expose-headers").contains("etag"));
    let preflight = client.send(Method::OPTIONS, path, &[("origin", "https://maps.example"), ("access-control-request-method", "GET")], "").await;
    assert_eq!((preflight.status, preflight.header("access-control-allow-methods")), (StatusCode::OK, "GET,HEAD"));
    let post = client.send(Method::POST, path, &[], "").await;
    assert_eq!((post.status, post.header("allow")), (StatusCode::METHOD_NOT_ALLOWED, "GET,HEAD"));
    assert!(post.problem().starts_with("405 "));
}

#[tokio::test]
async fn elevation_is_that_of_the_world() {
    let client = Client::new().await;
    let at = async |query: &str| client.get(&format!("/worlds/alps/elevation?{query}")).await;
    let exact = at("x=1000.5&y=-2000").await.json();
    assert_eq!((&exact["x"], &exact["y"]), (&json!(1000.5), &json!(-2000.0)));
    let coarse = at("x=1000.5&y=-2000&spacing=5000").await.json();
    assert_ne!(exact["elevation"], coarse["elevation"]);
    let by_degrees = at("lon=1&lat=2").await.json();
    assert_eq!((&by_degrees["longitude"], &by_degrees["latitude"]), (&json!(1.0), &json!(2.0)));
    let again = at(&format!("x={}&y={}", by_degrees["x"], by_degrees["y"])).await.json();
    assert_eq!(again["elevation"], by_degrees["elevation"]);
    assert!(again.get("longitude").is_none());
    let sea = client.get("/worlds/archipelago/elevation?x=0&y=0").await.json();
    assert_eq!(sea["water_depth"].as_f64().unwrap(), (-sea["elevation"].as_f64().unwrap()).max(0.0));
}

#[tokio::test]
async fn wrong_requests_are_told_what_would_be_right() {
    let client = Client::new().await;
    for (path, expected) in [
        ("/worlds/alp/web/terrarium/1/0/0.png", "404 world: no world is named \"alp\" (did you mean \"alps\"?)"),
        (
            "/worlds/alps@0123/web/terrarium/1/0/0.png",
            "404 world: the world \"alps\" has no revision \"0123\"; a revision is 32 hex digits, listed at worlds/alps/revisions",
        ),
        ("/worlds/alps/mercator/terrarium/1/0/0.png", "404 grid: no grid is named \"mercator\"; there are web, geo, metric"),
        (
            "/worlds/alps/web/terrain/1/0/0.png",
            "404 tileset: no tileset is named \"terrain\"; there are terrarium, terrain-rgb, fit, height16, r16, r32, hillshade, slope, normals, water, materials, weights, relief, contours, features, quantized-mesh",
        ),
        ("/worlds/alps/web/terrarium/31/0/0.png", "404 z: zoom must be 0 … 30, got 31"),
        ("/worlds/alps/web/terrarium/-1/0/0.png", "404 z: zoom must be 0 … 30, got -1"),
        ("/worlds/alps/web/terrarium/a/0/0.png", "400 z: must be a whole number, got \"a\""),
        ("/worlds/alps/web/terrarium/1/0.5/0.png", "400 x: must be a whole number, got \"0.5\""),
        (
            "/worlds/alps/web/terrarium/0/0/99999999999999999999.png",
            "404 tile: tile 0/0/9223372036854775807 lies beyond 2^40 m from the origin: at zoom 0, x must be -27435 … 27435 and y -27435 … 27435",
        ),
        ("/worlds/Alps/web/terrarium/0/0/0.png", "404 world: a name is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"Alps\""),
        ("/worlds/%FF", "404 There is nothing at a path that is not UTF-8."),
        (
            "/worlds/alps/web/terrarium/0/40000/0.png",
            "404 tile: tile 0/40000/0 lies beyond 2^40 m from the origin: at zoom 0, x must be -27435 … 27435 and y -27435 … 27435",
        ),
        ("/worlds/alps/web/terrarium/1/0/0.jpg", "404 y: tiles of terrarium end in .png or .webp, got \"0.jpg\""),
        ("/worlds/alps/web/r32/1/0/0.png", "404 y: tiles of r32 end in .bin or .json, got \"0.png\""),
        ("/worlds/alps/web/r32/1/0/0", "404 y: tiles of r32 end in .bin or .json, got \"0\""),
        ("/worlds/alps/web/r32/1/0/0@1026.bin", "404 y: after @ comes 2x (512 pixels) or a number of vertices a side, 2 … 1025; got \"1026\""),
        ("/worlds/alps/web/r32/1/0/0@1.bin", "404 y: after @ comes 2x (512 pixels) or a number of vertices a side, 2 … 1025; got \"1\""),
        ("/worlds/alps/web/r32/1/0/0.bin?filter=none", "400 filter: must be band or exact, got \"none\""),
        (
            "/worlds/alps/web/r32/1/0/0.bin?fliter=exact",
            "400 fliter: unknown field `fliter`, expected one of `filter`, `surface`, `page`, `order`, `rows`, `extensions`",
        ),
        ("/worlds/alps/elevation", "400 x: a point is given by x and y (metres) or by lon and lat (degrees)"),
        ("/worlds/alps/elevation?lon=1.2", "400 lat: a point is given by x and y (metres) or by lon and lat (degrees)"),
        ("/worlds/alps/elevation?x=1&lat=2", "400 x: a point is given by x and y (metres) or by lon and lat (degrees)"),
        ("/worlds/alps/elevation?x=1e13&y=0", "400 x: coordinates must lie within 2^40 = 1099511627776 m of the origin, got 10000000000000"),
        ("/worlds/alps/elevation?x=NaN&y=0", "400 x: coordinates must lie within 2^40 = 1099511627776 m of the origin, got NaN"),
        ("/worlds/alps/elevation?x=1&y=0&spacing=0", "400 spacing: spacing must be a positive number of metres, got 0"),
        ("/worlds/alps/elevation?lon=0&lat=90", "400 lat: must be within ±85.05112877980659 degrees, got 90"),
        ("/worlds/alps/elevation?x=one&y=0", "400 x: must be a number"),
        ("/worlds/alps/style", "404 There is nothing at /worlds/alps/style."),
        ("/nothing", "404 There is nothing at /nothing."),
    ] {
        assert_eq!(client.get(path).await.problem(), expected, "{path}");
    }
    assert_eq!(client.app.evaluations(), 0);
}

#[tokio::test]
async fn the_style_is_complete_and_names_its_revision() {
    let client = Client::new().await;
    let style = client.get("/worlds/alps/style.json").await.json();
    assert_eq!(style["version"], 8);
    for name in ["terrain", "hillshade"] {
        let source = &style["sources"][name];
        assert_eq!((&source["type"], &source["encoding"], &source["tileSize"]), (&json!("raster-dem"), &json!("terrarium"), &json!(512)));
        assert!(source["tiles"][0].as_str().unwrap().starts_with("http://localhost:8080/worlds/alps@"));
    }
    for world in client.get("/worlds").await.json()["worlds"].as_array().unwrap() {
        let style = client.get(&format!("/worlds/{}/style.json", world["name"].as_str().unwrap())).await.json();
        let stops = style["layers"][1]["paint"]["color-relief-color"].as_array().unwrap();
        let elevations: Vec<f64> = stops[3..].iter().step_by(2).map(|stop| stop.as_f64().unwrap()).collect();
        assert!(elevations.windows(2).all(|pair| pair[0] < pair[1]), "{world}: stops must ascend: {elevations:?}");
        assert!(style["zoom"].as_f64().unwrap() >= 0.0);
    }
}

#[tokio::test]
async fn the_public_url_stands_in_every_link() {
    let client = Client::with(|config| config.server.public_url = "https://maps.example.org/terrain/".to_owned()).await;
    for path in ["/catalog", "/worlds/alps/style.json", "/worlds/alps/web/terrarium"] {
        let text = String::from_utf8(client.get(path).await.body.to_vec()).unwrap();
        assert!(text.contains("https://maps.example.org/terrain/worlds/alps") && !text.contains("localhost:8080"), "{path}: {text}");
    }
    let client = Client::new().await;
    for forged in ["a\"b", "a/b", "", "a b"] {
        let answer = client.send(Method::GET, "/catalog", &[("host", forged)], "").await;
        assert_eq!(answer.problem(), "400 The request needs a valid Host header.", "{forged:?}");
    }
}

#[tokio::test]
async fn readiness_ends_when_the_server_drains() {
    let client = Client::new().await;
    assert_eq!((client.get("/healthz").await.status, client.get("/readyz").await.status), (StatusCode::OK, StatusCode::OK));
    client.app.drain();
    assert_eq!((client.get("/healthz").await.status, client.get("/readyz").await.status), (StatusCode::OK, StatusCode::SERVICE_UNAVAILABLE));
}

#[tokio::test]
async fn identical_concurrent_requests_evaluate_once() {
    let client = Client::new().await;
    let requests = (0..64).map(|_| client.get("/worlds/alps/web/r32/8/130/120@1025.bin"));
    let answers = futures_util::future::join_all(requests).await;
    assert!(answers.iter().all(|answer| answer.status == StatusCode::OK && answer.body == answers[0].body));
    assert_eq!((answers[0].body.len(), client.app.evaluations()), (1025 * 1025 * 4, 1));
}

#[tokio::test]
async fn the_root_is_a_page() {
    let client = Client::new().await;
    let page = client.get("/").await;
    assert_eq!((page.status, page.header("content-type").split(';').next()), (StatusCode::OK, Some("text/html")));
}

#[tokio::test]
async fn a_worlds_base_is_a_shader_that_is_known_by_its_revision() {
    let client = Client::new().await;
    let revision = client.get("/worlds/alps").await.header("etag").trim_matches('"').to_owned();
    for (language, function) in [("glsl", "float terrane_elevation(vec2 metres)"), ("wgsl", "fn terrane_elevation(metres: vec2<f32>) -> f32")] {
        let plain = client.get(&format!("/worlds/alps/shader.{language}")).await;
        assert_eq!((plain.status, plain.header("content-type"), plain.header("cache-control")), (StatusCode::OK, "text/plain; charset=utf-8", "no-cache"));
        assert!(String::from_utf8_lossy(&plain.body).contains(function));
        let tag = plain.header("etag").to_owned();
        assert!(tag.contains(&revision), "{tag}");
        let again = client.send(Method::GET, &format!("/worlds/alps/shader.{language}"), &[("if-none-match", &tag)], "").await;
        assert_eq!((again.status, again.body.len()), (StatusCode::NOT_MODIFIED, 0));
        let pinned = client.get(&format!("/worlds/alps@{revision}/shader.{language}")).await;
        assert_eq!((pinned.header("cache-control"), &pinned.body), ("public, max-age=31536000, immutable", &plain.body));
    }
    let large = json!({"seed": 1, "base": {"programme": "smooth(smooth(smooth(multiply(x, y), 0.1), 0.1), 0.1)", "scale": 100}}).to_string();
    assert_eq!(client.send(Method::PUT, "/worlds/large", &[], large).await.status, StatusCode::CREATED);
    let refused = client.get("/worlds/large/shader.glsl").await.problem();
    assert!(refused.starts_with("404 world: with smooth, slope and gradients written out the programme has"), "{refused}");
}

#[tokio::test]
async fn exact_tiles_that_would_take_minutes_are_refused() {
    let client = Client::new().await;
    let world = json!({"seed": 1, "base": {"programme": "erosion(fbm(1, 2, 8))", "scale": 1000}}).to_string();
    assert_eq!(client.send(Method::PUT, "/worlds/valleys", &[], world).await.status, StatusCode::CREATED);
    let refused = client.get("/worlds/valleys/metric/r32/3/0/0.bin?filter=exact").await.problem();
    assert!(refused.starts_with("400 filter: samples 16384 m apart would take this world about"), "{refused}");
    assert_eq!(client.get("/worlds/valleys/metric/r32/3/0/0.bin").await.status, StatusCode::OK);
}
