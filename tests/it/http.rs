//! Reading: what the calls answer, and what they say to requests that are wrong.

use crate::client::Client;
use axum::http::{Method, StatusCode};
use quick_xml::events::Event;
use serde_json::{Value, json};
use terrane::world::{Document, World};

#[tokio::test]
async fn a_new_server_has_the_example_worlds_with_their_tilesets() {
    let client = Client::new().await;
    let catalog = client.get("/catalog").await.json();
    let worlds = catalog["worlds"].as_array().unwrap();
    let names: Vec<_> = worlds.iter().map(|world| world["name"].as_str().unwrap()).collect();
    assert_eq!(
        names,
        [
            "alps",
            "archipelago",
            "archipelago-endless",
            "cordillera",
            "dunes",
            "eq2",
            "hills",
            "living",
            "mesas",
            "ranges",
            "ridges-and-rivers",
            "ridges-rivers-and-lakes"
        ]
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
            "400 fliter: unknown field `fliter`, expected one of `filter`, `surface`, `page`, `rounding`, `order`, `rows`, `extensions`",
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

#[tokio::test]
async fn answers_say_how_long_they_took_and_metrics_count_them() {
    let client = Client::new().await;
    let path = "/worlds/alps/web/terrarium/9/256/255.png";
    let cold = client.send(Method::GET, path, &[("x-request-id", "mine-1"), ("sec-purpose", "prefetch;prerender")], "").await;
    assert!(cold.header("server-timing").starts_with("queue;dur=") && cold.header("server-timing").contains(", evaluate;dur="), "{:?}", cold.headers);
    assert_eq!(cold.header("x-request-id"), "mine-1");
    let warm = client.get(path).await;
    assert_eq!((warm.header("server-timing"), warm.header("x-request-id").len(), warm.body == cold.body), ("", 16, true));
    assert_eq!(client.get("/worlds/nowhere/web/terrarium/9/256/255.png").await.status, StatusCode::NOT_FOUND);
    let metrics = client.get("/metrics").await;
    assert_eq!(metrics.header("content-type"), "application/openmetrics-text; version=1.0.0; charset=utf-8");
    let text = String::from_utf8(metrics.body.to_vec()).unwrap();
    let route = "/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}";
    for line in [
        &format!("terrane_requests_total{{method=\"GET\",route=\"{route}\",status=\"200\"}} 2"),
        &format!("terrane_requests_total{{method=\"GET\",route=\"{route}\",status=\"404\"}} 1"),
        &format!("terrane_request_seconds_count{{route=\"{route}\"}} 3"),
        "terrane_evaluations_total{tileset=\"terrarium\",source=\"programme\"} 1",
        "terrane_queue_seconds_count{class=\"prefetch\"} 1",
        "terrane_tile_lookups_total{result=\"hit\"} 1",
        "terrane_tile_lookups_total{result=\"miss\"} 1",
        "terrane_cached_tiles 1",
        "terrane_tiles_waiting{class=\"visible\"} 0",
        "# EOF",
    ] {
        assert!(text.lines().any(|other| other == line), "{line} is not in\n{text}");
    }
}

#[tokio::test]
async fn many_points_and_lines_are_answered_as_single_points_are() {
    let client = Client::new().await;
    let post = async |body: Value| client.send(Method::POST, "/worlds/ridges-and-rivers/elevation", &[("host", "maps.example.org")], body.to_string()).await;
    let alone = client.get("/worlds/ridges-and-rivers/elevation?x=1200.5&y=-900").await.json();
    let many = post(json!({"points": [[0, 0], [1200.5, -900], [3000, 3000]]})).await;
    assert_eq!((many.status, many.header("cache-control")), (StatusCode::OK, "no-store"), "asking is no write, whoever asks");
    let many = many.json();
    assert_eq!((&many["elevation"][1], &many["water_depth"][1]), (&alone["elevation"], &alone["water_depth"]));
    let there = client.get("/worlds/ridges-and-rivers/elevation?lon=0.01&lat=0.02&spacing=30").await.json();
    let many = post(json!({"lonlats": [[0.01, 0.02]], "spacing": 30})).await.json();
    assert_eq!(many, json!({"elevation": [there["elevation"]], "water_depth": [there["water_depth"]]}));

    let line = client.get("/worlds/ridges-and-rivers/profile?line=0,0,2401,-1800,2401,0&samples=5").await;
    assert_eq!(line.header("cache-control"), "no-cache");
    let line = line.json();
    assert_eq!((&line["points"][0], &line["points"][4], &line["distance"][0]), (&json!([0.0, 0.0]), &json!([2401.0, 0.0]), &json!(0.0)));
    let last = client.get("/worlds/ridges-and-rivers/elevation?x=2401&y=0").await.json();
    assert_eq!(line["elevation"][4], last["elevation"]);
    let climb = line["ascent"].as_f64().unwrap() - line["descent"].as_f64().unwrap();
    let ends = line["elevation"][4].as_f64().unwrap() - line["elevation"][0].as_f64().unwrap();
    assert!((climb - ends).abs() < 1e-3 && (line["length"].as_f64().unwrap() - 4800.75).abs() < 0.1, "{line}");

    for (body, problem) in [
        (json!({"points": [[0, 0], [1e13, 0]]}), "400 /points/1: "),
        (json!({"points": vec![[0, 0]; 10_001]}), "400 /points: must be at most 10000 points, got 10001"),
        (json!({"points": [[0, 0], [1, 2, 3]]}), "400 /points/1: "),
        (json!({"points": [[0, "a"]]}), "400 /points/0/1: invalid type: string \"a\", expected f64"),
        (json!({"lonlats": [[0, 89]]}), "400 /lonlats/0: a latitude must be within"),
        (json!({"points": [[0, 0]], "spacing": 0}), "400 /spacing: "),
        (json!({"point": []}), "400 /point: unknown field `point`"),
        (json!({}), "400 : either points"),
    ] {
        let answer = post(body).await.problem();
        assert!(answer.starts_with(problem), "{answer}, not {problem}");
    }
    for (query, problem) in [
        ("", "400 line: a line is given by"),
        ("?line=0,0", "400 line: must be 2 to 256 pairs"),
        ("?line=0,0,1", "400 line: must be 2 to 256 pairs"),
        ("?line=0,0,1,1&samples=1", "400 samples: must be a whole number 2 … 10000"),
        ("?lonlat=0,0,0,89", "400 lonlat: a latitude must be within"),
        ("?line=0,0,1e14,0", "400 line: "),
        ("?line=0,0,5,5&spacing=-1", "400 spacing: "),
    ] {
        let answer = client.get(&format!("/worlds/ridges-and-rivers/profile{query}")).await.problem();
        assert!(answer.starts_with(problem), "{answer}, not {problem}");
    }
}

#[tokio::test]
async fn gis_programs_find_every_world_in_the_capabilities() {
    let client = Client::new().await;
    let world = r#"{"seed": 1, "title": "Peaks & <pits>", "description": "a \"new\" one", "base": {"programme": "x", "scale": 1}}"#;
    assert_eq!(client.put("/worlds/peaks", world).await.status, StatusCode::CREATED);
    let answer = client.get("/wmts?SERVICE=WMTS&REQUEST=GetCapabilities").await;
    assert_eq!((answer.header("content-type"), answer.header("cache-control")), ("application/xml", "no-cache"));
    let xml = String::from_utf8(answer.body.to_vec()).unwrap();
    let mut reader = quick_xml::Reader::from_str(&xml);
    reader.config_mut().check_end_names = true;
    let (mut templates, mut denominators, mut titles, mut within) = (Vec::new(), Vec::new(), Vec::new(), String::new());
    loop {
        match reader.read_event().unwrap() {
            Event::Eof => break,
            Event::Start(start) => start.name().as_ref().clone_into(&mut within),
            Event::Empty(element) if element.name().as_ref() == "ResourceURL" => {
                let template = element.attributes().map(Result::unwrap).find(|attribute| attribute.key.as_ref() == "template").unwrap();
                templates.push(template.value.into_owned());
            }
            Event::Text(text) if within == "ScaleDenominator" => denominators.extend(text.trim().parse::<f64>()),
            Event::Text(text) if within == "ows:Title" => titles.push(text.to_string()),
            _ => {}
        }
    }
    assert_eq!((templates.len(), denominators.len()), (13 * 5, 25));
    // The first scale of the well-known set that it names.
    assert!((denominators[0] - 559_082_264.028_717_8).abs() < 1e-6);
    assert!(xml.contains("<ows:Title>Peaks &amp; &lt;pits&gt;: relief</ows:Title><ows:Abstract>a &quot;new&quot; one</ows:Abstract>"), "{titles:?}");
    for template in templates.iter().filter(|template| template.contains("/peaks/")) {
        let path = template.strip_prefix("http://localhost:8080").unwrap().replace("{TileMatrix}", "3").replace("{TileCol}", "2").replace("{TileRow}", "1");
        assert_eq!(client.get(&path).await.status, StatusCode::OK, "{path}");
    }
}
