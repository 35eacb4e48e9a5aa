//! Ground that evolves while it is used, over HTTP: generations and the revisions that pin them, players and what they are promised.

use crate::{
    client::{Answer, Client},
    process::{Server, text},
};
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};
use std::{
    process::Command,
    sync::atomic::{AtomicU64, Ordering::SeqCst},
    time::Duration,
};
use terrane::{evolve, genetic::Draws};

/// 129 × 129 nodes, 1,280 m a side.
fn world(ground: &Value) -> String {
    json!({
        "seed": 3, "base": {"programme": "fbm(1, 2, 6)", "scale": 3000, "amplitude": 60, "datum": 80},
        "layers": [{"name": "ground", "source": {"adaptive": {"ground": ground}}, "fade": 100}]
    })
    .to_string()
}

async fn client() -> Client {
    let client = Client::new().await;
    let saved = client.put("/worlds/live", &world(&json!({"seed": 5}))).await;
    assert_eq!(saved.status, StatusCode::CREATED, "{}", String::from_utf8_lossy(&saved.body));
    client
}

async fn post(client: &Client, path: &str, body: &Value) -> Answer {
    client.send(Method::POST, path, &[], body.to_string()).await
}

async fn feed(client: &Client, body: &Value) -> Value {
    let fed = post(client, "/worlds/live/feedback", body).await;
    assert_eq!(fed.status, StatusCode::OK, "{}", String::from_utf8_lossy(&fed.body));
    fed.json()
}

/// The tiles of the metric grid of 320 m a side around the ground, with `spacing` metres between samples.
fn tiles(prefix: &str, z: u8, from: i64, to: i64, side: &str) -> Vec<String> {
    (from..to).flat_map(|x| (from..to).map(move |y| (x, y))).map(|(x, y)| format!("{prefix}/metric/r32/{z}/{x}/{y}{side}.bin")).collect()
}

async fn tags(client: &Client, paths: &[String]) -> Vec<(String, Vec<u8>)> {
    let mut tags = Vec::new();
    for path in paths {
        let tile = client.get(path).await;
        assert_eq!(tile.status, StatusCode::OK, "{path}");
        tags.push((tile.header("etag").to_owned(), tile.body.to_vec()));
    }
    tags
}

#[tokio::test]
async fn feedback_breeds_a_generation_that_a_revision_pins() {
    let client = client().await;
    let document = client.get("/worlds/live").await;
    let old = document.header("etag").trim_matches('"').to_owned();
    let first = document.json()["layers"][0]["source"]["adaptive"]["generation"].as_str().unwrap().to_owned();
    let ground = evolve::Ground { seed: 5, ..evolve::Ground::default() };
    assert_eq!(first, ground.hash());

    // Tiles of 512 m from 1,536 m west and south of the origin on; those of the ground have y from -3 to -1.
    let paths = tiles("/worlds/live", 16, -5, 6, "@33");
    let before = tags(&client, &paths).await;
    let fed = feed(&client, &json!({"points": [[600, 500]], "radius": 150})).await;
    let generation = evolve::Generation::first(&ground).unwrap();
    let next = generation.next(&evolve::Feedback { radius: Some(150.0), ..evolve::Feedback::point([600.0, 500.0]) }).unwrap();
    assert_eq!((&fed["layer"], &fed["generation"]), (&json!("ground"), &json!({"hash": next.hash(), "number": 1})));
    assert!(fed["deviation"].as_f64().unwrap() > 0.0);
    let changed: Vec<f64> = serde_json::from_value(fed["changed"].clone()).unwrap();
    assert!(changed[0] >= 420.0 && changed[1] >= 320.0 && changed[2] <= 780.0 && changed[3] <= 680.0, "{changed:?}");
    let now = client.get("/worlds/live").await;
    assert_eq!(now.header("etag").trim_matches('"'), fed["revision"]);
    assert_eq!(now.json()["layers"][0]["source"]["adaptive"]["generation"], fed["generation"]["hash"]);

    // Tags change where bytes do, and nowhere else; old revisions stay.
    let after = tags(&client, &paths).await;
    let pinned = tags(&client, &tiles(&format!("/worlds/live@{old}"), 16, -5, 6, "@33")).await;
    let mut differ = 0;
    for ((path, before), (after, pinned)) in paths.iter().zip(&before).zip(after.iter().zip(&pinned)) {
        assert_eq!(before.0 != after.0, before.1 != after.1, "{path}");
        assert_eq!(before, pinned, "{path}");
        differ += usize::from(before.1 != after.1);
    }
    assert!((1..=4).contains(&differ), "{differ}");

    // The heights are those of the library.
    let there = client.get("/worlds/live/elevation?x=600&y=500").await.json();
    assert_eq!(there["elevation"].as_f64().unwrap() as f32, next.terrain().height([600.0, 500.0]).unwrap());

    // Started again, with all of it.
    let client = client.restart(|_| {}).await;
    assert_eq!(tags(&client, &paths).await, after);
    let listed = client.get("/worlds/live/generations").await.json();
    assert_eq!((&listed["layer"], &listed["current"]), (&json!("ground"), &fed["generation"]["hash"]));
    let all = listed["generations"].as_array().unwrap();
    assert_eq!((all.len(), &all[0]["hash"], &all[1]["number"], &all[1]["deviation"]), (2, &json!(first), &json!(1), &fed["deviation"]));
    assert_eq!(all[1]["feedback"], json!({"points": [[600.0, 500.0]], "radius": 150.0}));
    assert!(all[1]["time"].as_str().unwrap().ends_with('Z'));
    let of_old = client.get(&format!("/worlds/live@{old}/generations?history")).await.json();
    assert_eq!((of_old["generations"].as_array().unwrap().len(), &of_old["history"]["steps"]), (1, &json!([])));
}

#[tokio::test]
async fn what_is_wrong_changes_nothing() {
    let client = client().await;
    let before = client.get("/worlds/live").await;
    let check = async |body: Value, problem: &str| {
        let refused = post(&client, "/worlds/live/feedback", &body).await;
        assert!(refused.problem().starts_with(problem), "{}", refused.problem());
    };
    check(json!({"points": [[600, 500], [1280.5, 3]]}), "422 /points/1: must lie on the terrain").await;
    check(json!({"points": [[600]]}), "422 /points/0").await;
    check(json!({"heights": [201]}), "422 /heights/0: must be 0 … 200").await;
    check(json!({"heights": [20], "radius": 100}), "422 /points: must hold a point").await;
    check(json!({"points": [[1, 1]], "radius": -1}), "422 /radius").await;
    check(json!({}), "422 : must hold 1 to 100").await;
    check(json!({"point": [1, 1]}), "422 /point: unknown field").await;
    check(json!({"players": true}), "422 /players: no player is on the ground").await;
    check(json!({"layer": "other", "heights": [100]}), "422 /layer: must be the name of an adaptive layer, of [\"ground\"]").await;
    let no_json = client.send(Method::POST, "/worlds/live/feedback", &[], "{").await;
    assert_eq!(no_json.status, StatusCode::BAD_REQUEST);
    let stale = client.send(Method::POST, "/worlds/live/feedback", &[("if-match", "\"0123456789abcdef0123456789abcdef\"")], r#"{"heights":[100]}"#).await;
    assert_eq!(stale.status, StatusCode::PRECONDITION_FAILED);
    assert_eq!(post(&client, "/worlds/nowhere/feedback", &json!({"heights": [100]})).await.status, StatusCode::NOT_FOUND);
    let none = post(&client, "/worlds/hills/feedback", &json!({"heights": [100]})).await;
    assert_eq!(none.problem(), "422 /layer: the world has no adaptive layer");
    let after = client.get("/worlds/live").await;
    assert_eq!((&after.body, after.header("etag")), (&before.body, before.header("etag")));

    // Documents name what is wrong in them.
    let put = async |ground: Value, generation: Value, problem: &str| {
        let layer = json!({"name": "a", "source": {"adaptive": {"ground": ground, "generation": generation}}});
        let document = json!({"seed": 1, "base": {"programme": "0", "scale": 1}, "layers": [layer]});
        let refused = client.put("/worlds/other", &document.to_string()).await;
        assert!(refused.problem().starts_with(&format!("422 /layers/0/source/adaptive{problem}")), "{}", refused.problem());
    };
    put(json!({"lines": 3}), json!(null), "/ground/lines: must be 4 … 1025, got 3").await;
    put(json!({"line": 3}), json!(null), "/ground/line: unknown field").await;
    put(json!({"lines": 1000, "length": 1000, "passes": 3}), json!(null), "/ground: lines, length and passes make").await;
    put(json!({"lines": 1025, "nodes": 4096, "populations": 4, "passes": 0}), json!(null), "/ground/nodes: lines, populations and nodes allow").await;
    put(json!({}), json!("0123456789abcdef0123456789abcdef"), "/generation: must be the hash of a stored generation").await;
    let fed = feed(&client, &json!({"heights": [100]})).await;
    put(json!({"seed": 6}), fed["generation"]["hash"].clone(), "/generation: must be a generation of this ground").await;
    let layer = json!({"name": "a", "source": {"adaptive": {"ground": {}}}, "mask": {"polygon": [[0, 0], [500, 0], [0, 1281]]}});
    let document = json!({"seed": 1, "base": {"programme": "0", "scale": 1}, "layers": [layer]});
    assert!(client.put("/worlds/other", &document.to_string()).await.problem().starts_with("422 /layers/0/mask/polygon/2: must lie on the terrain"));
}

/// Going back and breeding anew makes a branch; both are kept.
#[tokio::test]
async fn one_can_go_back_and_on_from_there() {
    let client = client().await;
    let mut hashes = vec![client.get("/worlds/live/generations").await.json()["current"].clone()];
    for height in [110, 60, 140] {
        hashes.push(feed(&client, &json!({"heights": [height]})).await["generation"]["hash"].clone());
    }
    let shown = async || client.get("/worlds/live/generations").await.json()["current"].clone();
    let go = async |generation: Value| client.put("/worlds/live/generation", &json!({"generation": generation}).to_string()).await;
    let tile = "/worlds/live/metric/r32/15/0/-1@65.bin";
    let newest = client.get(tile).await;
    let gone = go(json!(1)).await.json();
    assert_eq!((&gone["generation"], shown().await), (&json!({"hash": hashes[1], "number": 1}), hashes[1].clone()));
    assert_ne!(client.get(tile).await.body, newest.body);
    let branch = feed(&client, &json!({"heights": [150]})).await;
    assert_eq!(branch["generation"]["number"], 2);
    assert_ne!(branch["generation"]["hash"], hashes[2]);
    assert_eq!(go(json!(3)).await.problem(), "422 /generation: must be 0 … 2, a generation on the way to this one, or a hash; got 3");
    assert_eq!(go(json!("no")).await.problem(), "422 /generation: no stored generation of this ground has the hash \"no\"");
    let back = go(hashes[3].clone()).await.json();
    assert_eq!(back["generation"]["number"], 3);
    let again = client.get(tile).await;
    assert_eq!((again.header("etag"), &again.body), (newest.header("etag"), &newest.body));
    go(json!(0)).await;
    assert_eq!(shown().await, hashes[0]);
    // The same feedback of the same generation is the same generation.
    assert_eq!(feed(&client, &json!({"heights": [110]})).await["generation"]["hash"], hashes[1]);

    // A history is all that it follows from.
    go(hashes[3].clone()).await;
    let history = client.get("/worlds/live/generations?history").await.json()["history"].to_string();
    let replayed = evolve::Adaptive::replay(evolve::History::parse(history.as_bytes()).unwrap()).unwrap();
    let there = client.get("/worlds/live/elevation?x=640&y=640").await.json();
    assert_eq!(there["elevation"].as_f64().unwrap() as f32, replayed.terrain(3).unwrap().height([640.0, 640.0]).unwrap());
}

#[tokio::test(flavor = "multi_thread")]
async fn feedback_of_many_at_once_is_a_line_of_generations() {
    let client = std::sync::Arc::new(client().await);
    let tasks: Vec<_> = (0..20)
        .map(|i| {
            let client = std::sync::Arc::clone(&client);
            tokio::spawn(async move { feed(&client, &json!({"points": [[60 * i, 50 * i]]})).await["generation"]["number"].as_u64().unwrap() })
        })
        .collect();
    let mut numbers = Vec::new();
    for task in tasks {
        numbers.push(task.await.unwrap());
    }
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=20).collect::<Vec<_>>());
    let listed = client.get("/worlds/live/generations").await.json();
    assert_eq!(listed["generations"].as_array().unwrap().len(), 21);
    assert_eq!(client.get("/worlds/live/revisions").await.json().as_array().unwrap().len(), 21);
    // Bred again from what is stored, far from the last whole one.
    let there = async |client: &Client| client.get("/worlds/live/elevation?x=640&y=640").await.json();
    let before = there(&client).await;
    let client = std::sync::Arc::into_inner(client).unwrap().restart(|_| {}).await;
    assert_eq!(there(&client).await, before);
}

#[tokio::test]
async fn players_come_and_go_and_hold_generations() {
    let client = client().await;
    let go = async |player: &str, positions: Value| client.put(&format!("/worlds/live/players/{player}"), &json!({"positions": positions}).to_string()).await;
    feed(&client, &json!({"heights": [120]})).await;
    assert_eq!(go("ann", json!([[100, 100], [300, 120]])).await.json(), json!({"promise": 50.0}));
    let listed = client.get("/worlds/live/players").await.json();
    assert_eq!((&listed["players"][0]["name"], &listed["players"][0]["position"]), (&json!("ann"), &json!([300.0, 120.0])));
    assert!(listed["players"][0]["seen"].as_f64().unwrap() < 60.0);
    assert_eq!(go("ann", json!([])).await.problem(), "422 /positions: must hold 1 to 1024 positions, got 0");
    assert_eq!(go("ann", json!([[1, 2], [3e12, 0]])).await.problem(), "422 /positions/1: must be plane metres within 2^40 of the origin");
    assert_eq!(go("Ann", json!([[1, 2]])).await.status, StatusCode::BAD_REQUEST);
    assert_eq!(client.put("/worlds/hills/players/bob", r#"{"positions":[[0,0]]}"#).await.json(), json!({"promise": null}));

    // Where a player is counts as a point, and nothing changes around its way.
    let fed = feed(&client, &json!({"players": true})).await;
    assert_eq!(fed["generation"]["number"], 2);
    let history = client.get("/worlds/live/generations?history").await.json();
    assert_eq!(history["generations"][2]["feedback"], json!({"points": [[300.0, 120.0]]}));
    assert_eq!(history["history"]["steps"][1]["feedback"]["ways"], json!([[[100.0, 100.0], [300.0, 120.0]]]));
    feed(&client, &json!({"heights": [120]})).await;
    let history = client.get("/worlds/live/generations?history").await.json();
    assert_eq!(history["history"]["steps"][2]["feedback"]["ways"], json!([[[300.0, 120.0]]]));

    // As long as it is there nothing else may change what is shown.
    let back = client.put("/worlds/live/generation", r#"{"generation":0}"#).await;
    assert!(back.problem().starts_with("409 The player \"ann\" is on the ground of the layer \"ground\""), "{}", back.problem());
    let mut document = client.get("/worlds/live").await.json();
    document["title"] = json!("Another name");
    assert_eq!(client.put("/worlds/live", &document.to_string()).await.status, StatusCode::OK, "that is no other generation");
    for change in [json!([]), json!([{"name": "ground", "source": {"adaptive": {"ground": {"seed": 5}}}}])] {
        let changed = json!({"seed": 3, "base": document["base"], "layers": change});
        assert_eq!(client.put("/worlds/live", &changed.to_string()).await.status, StatusCode::CONFLICT);
    }
    assert_eq!(client.send(Method::DELETE, "/worlds/live/players/ann", &[], "").await.status, StatusCode::NO_CONTENT);
    assert_eq!(client.send(Method::DELETE, "/worlds/live/players/ann", &[], "").await.status, StatusCode::NO_CONTENT, "who is gone is gone");
    assert_eq!(client.send(Method::DELETE, "/worlds/nowhere/players/ann", &[], "").await.status, StatusCode::NOT_FOUND);
    go("ann", json!([[-51, 0]])).await;
    assert_eq!(client.put("/worlds/live/generation", r#"{"generation":0}"#).await.status, StatusCode::OK);
}

/// The promise: from a generation to the next, nothing changes within the promised distance of where players are and of their ways since the one before.
#[tokio::test]
async fn nothing_changes_around_players() {
    let client = Client::new().await;
    client.put("/worlds/live", &world(&json!({"seed": 8, "promise": 60, "fade": 3, "mutation": 0.5}))).await;
    let (mut draws, mut seen, mut changed) = (Draws::new(12), 0, 0);
    for round in 0..12 {
        let mut ways: Vec<Vec<[f64; 2]>> = Vec::new();
        for player in ["ann", "bob"] {
            let mut at = [draws.between(0.0, 1280.0), draws.between(0.0, 1280.0)];
            let mut way = Vec::new();
            for _ in 0..=draws.below(3) {
                at = [at[0] + 50.0 * draws.normal(), at[1] + 50.0 * draws.normal()];
                way.push(at);
            }
            // As a new player: what it comes from does not count.
            client.send(Method::DELETE, &format!("/worlds/live/players/{player}"), &[], "").await;
            let told = client.put(&format!("/worlds/live/players/{player}"), &json!({"positions": way}).to_string()).await;
            assert_eq!(told.json()["promise"], 60.0);
            ways.push(way);
        }
        // Exact samples around the ways, and tiles that lie within the promise: 20 m and 5 m wide.
        let mut points = Vec::new();
        for way in &ways {
            for _ in 0..60 {
                let part = draws.below(way.len());
                let [from, to] = [way[part], way[(part + 1).min(way.len() - 1)]];
                let (t, angle, distance) = (draws.unit(), draws.between(0.0, 6.3), 59.9 * draws.unit());
                let on = |axis: usize| from[axis] + t * (to[axis] - from[axis]);
                points.push([on(0) + distance * libm::cos(angle), on(1) + distance * libm::sin(angle)]);
            }
        }
        let tiles: Vec<String> = ways
            .iter()
            .flat_map(|way| way.iter())
            .flat_map(|[x, y]| {
                // 2^(25 - z) m a side: 32 m at 9 m spacing … of 5 samples, exact and band.
                let at = |side: f64| ((x / side).floor() as i64, (-y / side).floor() as i64);
                let ((x1, y1), (x2, y2)) = (at(32.0), at(8.0));
                [format!("metric/r32/20/{x1}/{y1}@5.bin"), format!("metric/r32/20/{x1}/{y1}@33.bin?filter=exact"), format!("metric/r32/22/{x2}/{y2}@65.bin")]
            })
            .collect();
        let elevations = async |spacing: Option<f64>| {
            let asked = post(&client, "/worlds/live/elevation", &json!({"points": points, "spacing": spacing})).await;
            assert_eq!(asked.status, StatusCode::OK);
            asked.json()["elevation"].clone()
        };
        let paths: Vec<String> = tiles.iter().map(|tile| format!("/worlds/live/{tile}")).collect();
        let before = (elevations(None).await, elevations(Some(10.0)).await, tags(&client, &paths).await);
        let all = client.get("/worlds/live/metric/r32/14/0/-1@129.bin").await.body;
        let feedback = if round % 2 == 0 { json!({"heights": [draws.between(10.0, 190.0)]}) } else { json!({"points": [[640, 640]]}) };
        feed(&client, &feedback).await;
        let after = (elevations(None).await, elevations(Some(10.0)).await, tags(&client, &paths).await);
        assert_eq!(before, after, "round {round}: {ways:?}");
        seen += 2 * points.len() + paths.len();
        changed += usize::from(client.get("/worlds/live/metric/r32/14/0/-1@129.bin").await.body != all);
    }
    assert!(seen > 2000 && changed == 12, "{seen} {changed}");
}

/// What was answered is on disk, and what was not is there wholly or not at all, whenever the server is killed.
#[test]
fn a_server_that_is_killed_has_whole_generations() {
    let (folder, answered) = (tempfile::tempdir().unwrap(), AtomicU64::new(0));
    for round in 0..4 {
        let server = Server::start(folder.path());
        if round == 0 {
            let (status, body) = server.request("PUT", "/worlds/live", &world(&json!({"seed": 5}))).unwrap();
            assert_eq!(status, 201, "{}", text(&body));
        }
        let listed: Value = serde_json::from_slice(&server.get("/worlds/live/generations")).unwrap();
        let (there, told) = (listed["generations"].as_array().unwrap().len() as u64 - 1, answered.load(SeqCst));
        assert!((told..=told + 4).contains(&there), "{there} generations are there, {told} were answered");
        let document: Value = serde_json::from_slice(&server.get("/worlds/live")).unwrap();
        assert_eq!(document["layers"][0]["source"]["adaptive"]["generation"], listed["current"]);
        server.get("/worlds/live/elevation?x=640&y=640");
        answered.store(there, SeqCst);
        std::thread::scope(|scope| {
            let (server, answered) = (&server, &answered);
            for i in 0..4 {
                scope.spawn(move || {
                    let body = json!({"points": [[100 * i + 50, 700]]}).to_string();
                    while let Ok((200, fed)) = server.request("POST", "/worlds/live/feedback", &body) {
                        let fed: Value = serde_json::from_slice(&fed).unwrap();
                        answered.fetch_max(fed["generation"]["number"].as_u64().unwrap(), SeqCst);
                    }
                });
            }
            std::thread::sleep(Duration::from_millis(700));
            assert!(Command::new("kill").args(["-9", &server.child.id().to_string()]).status().unwrap().success());
        });
    }
    assert!(answered.load(SeqCst) > 3);
}

/// Each layer has its own line of generations, and what counts of a way for one does not count for the other less.
#[tokio::test]
async fn several_layers_evolve_beside_each_other() {
    let client = Client::new().await;
    let layer = |name: &str, x: f64| json!({"name": name, "source": {"adaptive": {"ground": {"seed": 2, "lines": 9, "length": 9, "origin": [x, 0]}}}});
    let document = json!({"seed": 3, "base": {"programme": "0", "scale": 1}, "layers": [layer("west", -400.0), layer("east", 400.0)]});
    assert_eq!(client.put("/worlds/live", &document.to_string()).await.status, StatusCode::CREATED);
    let unnamed = post(&client, "/worlds/live/feedback", &json!({"heights": [100]})).await;
    assert_eq!(unnamed.problem(), "422 /layer: is needed: the world has several adaptive layers, [\"west\", \"east\"]");
    assert!(client.get("/worlds/live/generations").await.problem().starts_with("400 layer: is needed"));
    client.put("/worlds/live/players/ann", r#"{"positions":[[-300,10],[-200,20]]}"#).await;
    let ways = async |layer: &str| {
        feed(&client, &json!({"layer": layer, "heights": [90]})).await;
        let history = client.get(&format!("/worlds/live/generations?layer={layer}&history")).await.json();
        history["history"]["steps"].as_array().unwrap().last().unwrap()["feedback"]["ways"].clone()
    };
    assert_eq!(ways("west").await, json!([[[-300.0, 10.0], [-200.0, 20.0]]]));
    assert_eq!(ways("west").await, json!([[[-200.0, 20.0]]]));
    assert_eq!(ways("east").await, json!([[[-300.0, 10.0], [-200.0, 20.0]]]));
    // Who is on one ground does not keep the other from going back.
    let back = async |layer: &str| client.put("/worlds/live/generation", &json!({"layer": layer, "generation": 0}).to_string()).await.status;
    assert_eq!((back("east").await, back("west").await), (StatusCode::OK, StatusCode::CONFLICT));
}

/// `cargo test --release --test it -- --ignored --nocapture the_figures_of_feedback`.
#[tokio::test]
#[ignore = "takes a minute, and says how long things take"]
#[expect(clippy::print_stdout, reason = "writes the figures")]
async fn the_figures_of_feedback() {
    let client = Client::new().await;
    let size = |folder: &std::path::Path| -> u64 { std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().metadata().unwrap().len()).sum() };
    let resident = || std::fs::read_to_string("/proc/self/statm").ok().and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok()).unwrap_or_default() / 256;
    let large = json!({"seed": 5, "lines": 128, "length": 128, "passes": 3, "cell": 4});
    client.put("/worlds/large", &world(&large)).await;
    for (name, side, count) in [("living", 1900.0, 1000_u32), ("large", 4000.0, 60)] {
        let (disk, memory) = (size(client.folder()), resident());
        let mut times = Vec::new();
        let mut draws = Draws::new(1);
        for i in 0..count {
            let point = [draws.between(if name == "living" { -side } else { 0.0 }, side), draws.between(0.0, side)];
            let radius = if i % 2 == 0 { json!(300) } else { json!(null) };
            let begun = std::time::Instant::now();
            let fed = post(&client, &format!("/worlds/{name}/feedback"), &json!({"points": [point], "radius": radius})).await;
            times.push(begun.elapsed().as_secs_f64() * 1e3);
            assert_eq!(fed.status, StatusCode::OK);
        }
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times[(share * (times.len() - 1) as f64) as usize];
        println!(
            "{name}: {count} generations, p50 {:.1} ms, p99 {:.1} ms, {} kB on disk, {} MB in memory more",
            at(0.5),
            at(0.99),
            (size(client.folder()) - disk) / 1024,
            resident() - memory
        );
    }
    for tile in ["hills/metric/terrarium/13/0/-1.png", "living/metric/terrarium/13/0/-1.png", "large/metric/terrarium/13/0/-1.png"] {
        let mut times = Vec::new();
        for i in 0..2000 {
            // A query that changes nothing: no answer is recalled by its address.
            let path = format!("/worlds/{tile}?filter=band&rounding=steps");
            let begun = std::time::Instant::now();
            let answer = client.send(Method::GET, &path, &[("if-none-match", "\"another\"")], "").await;
            if i > 0 {
                times.push(begun.elapsed().as_secs_f64() * 1e6);
            }
            assert_eq!(answer.status, StatusCode::OK);
        }
        times.sort_by(f64::total_cmp);
        println!("{tile} again: p50 {:.0} µs, p99 {:.0} µs", times[1000], times[1980]);
    }
}
