//! Long work: asked for, kept, done, given up, taken up again; and what it makes as terrain.

use crate::client::{Answer, Client};
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};
use std::time::Duration;
use terrane::{
    geometry::Stop,
    world::{Turn, Work},
};

/// A drawing of so many strokes; a hundred take some hundred milliseconds.
pub(crate) fn work(strokes: usize, seed: u64) -> Value {
    let lines: Vec<Value> = (0..strokes).map(|i| json!([[40 + i % 37, 50 + i % 41], [90 + i % 29, 80 + i % 31]])).collect();
    json!({"paths": {"drawing": {
        "title": "Test range", "size": [160, 140], "spacing": 10, "origin": [-500, 300], "seed": seed, "edges": {"random": {"mean": 1, "deviation": 0.4}},
        "sea_level": {"cost": 400}, "profiles": {"flank": {"points": [[0, 1], [0.5, 0.3], [1, 0]], "width": 450}},
        "strokes": [{"shape": {"geometry": {"type": "MultiLineString", "coordinates": lines.into_iter().map(|line| {
            json!(line.as_array().unwrap().iter().map(|point| json!([point[0].as_f64().unwrap() * 10.0, point[1].as_f64().unwrap() * 10.0])).collect::<Vec<_>>())
        }).collect::<Vec<_>>()}}, "profiles": ["flank"], "cost": 20}]
    }}})
}

pub(crate) async fn post(client: &Client, path: &str, body: &Value) -> Answer {
    client.send(Method::POST, path, &[], body.to_string()).await
}

/// Looks at a job until it is ended.
pub(crate) async fn ended(client: &Client, id: &str) -> Value {
    for _ in 0..6000 {
        let job = client.get(&format!("/jobs/{id}")).await.json();
        let share = job["progress"].as_f64().unwrap();
        assert!((0.0..=1.0).contains(&share));
        if job["state"] != "waiting" && job["state"] != "running" {
            return job;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    panic!("the job does not end");
}

fn path_of(url: &Value) -> String {
    url.as_str().unwrap().strip_prefix("http://localhost:8080").unwrap().to_owned()
}

#[tokio::test]
async fn a_job_makes_a_raster_that_a_world_shows() {
    let client = Client::new().await;
    let asked = post(&client, "/jobs", &work(3, 7)).await;
    assert_eq!(asked.status, StatusCode::ACCEPTED, "{}", String::from_utf8_lossy(&asked.body));
    let id = asked.json()["id"].as_str().unwrap().to_owned();
    assert_eq!(asked.header("location"), format!("http://localhost:8080/jobs/{id}"));
    let job = ended(&client, &id).await;
    assert_eq!((&job["state"], &job["title"], &job["progress"]), (&json!("done"), &json!("Test range"), &json!(1.0)));
    assert_eq!(job["work"]["paths"]["drawing"]["size"], json!([160, 140]));

    // The heights are those that the library makes, to the bit.
    let course = Work::parse(work(3, 7).to_string().as_bytes()).unwrap().begin(None).unwrap();
    let Some(Turn::Raster(made)) = course.turn(&Stop::never(), &|_| {}).unwrap() else { panic!("a drawing becomes a raster") };
    let raster = client.get(&path_of(&job["raster"])).await.json();
    let [columns, rows] = made.size();
    assert_eq!((&raster["columns"], &raster["rows"], &raster["spacing"]), (&json!(columns), &json!(rows), &json!(10.0)));
    let heights = client.get(&path_of(&raster["heights"])).await;
    let expected: Vec<u8> = made.values().chunks(columns).rev().flatten().flat_map(|height| height.to_le_bytes()).collect();
    assert!(heights.body == expected && heights.header("content-length") == expected.len().to_string());
    assert!(heights.header("cache-control").contains("immutable"));
    let fresh = client.send(Method::GET, &path_of(&raster["heights"]), &[("if-none-match", heights.header("etag"))], "").await;
    assert_eq!(fresh.status, StatusCode::NOT_MODIFIED);
    let picture = client.get(&path_of(&raster["preview"])).await;
    assert_eq!(image::load_from_memory(&picture.body).unwrap().width() as usize, columns);
    assert_eq!(client.get("/rasters").await.json()["rasters"].as_array().unwrap().len(), 1);

    // On a world it stands on what is beneath, node by node.
    let layer = |hash: &str| {
        json!({"seed": 1, "base": {"programme": "0", "scale": 1, "datum": 250}, "layers": [{"name": "range", "source": {"raster": {"hash": hash}}}]})
            .to_string()
    };
    let saved = client.put("/worlds/range", &layer(raster["hash"].as_str().unwrap())).await;
    assert_eq!(saved.status, StatusCode::CREATED, "{}", String::from_utf8_lossy(&saved.body));
    let [x, y] = [raster["bbox"][0].as_f64().unwrap(), raster["bbox"][1].as_f64().unwrap()];
    let mut raised = 0;
    for node in (0..made.values().len()).step_by(977) {
        let (i, j) = (node % columns, node / columns);
        let there = client.get(&format!("/worlds/range/elevation?x={}&y={}", x + i as f64 * 10.0, y + j as f64 * 10.0)).await.json();
        assert_eq!(there["elevation"].as_f64().unwrap() as f32, 250.0 + made.values()[node], "node {i}, {j}");
        raised += usize::from(made.values()[node] > 0.0);
    }
    assert!(raised > 5, "{raised}");
    let unknown = client.put("/worlds/other", &layer("0123456789abcdef0123456789abcdef")).await;
    assert_eq!(
        unknown.problem(),
        "422 /layers/0/source/raster/hash: must be the hash of a stored raster, which a job makes; got \"0123456789abcdef0123456789abcdef\""
    );

    // Asked for again it is there; forgotten, what it made stays.
    let again = post(&client, "/jobs", &work(3, 7)).await;
    assert_eq!((again.status, &again.json()["state"]), (StatusCode::OK, &json!("done")));
    assert_eq!(client.send(Method::DELETE, &format!("/jobs/{id}"), &[], "").await.status, StatusCode::NO_CONTENT);
    assert_eq!(client.get(&format!("/jobs/{id}")).await.problem(), format!("404 job: there is no job {id}"));
    let client = client.restart(|_| {}).await;
    let there = client.get(&format!("/worlds/range/elevation?x={}&y={y}", x + 10.0)).await.json();
    assert_eq!(there["elevation"], 250.0);
}

#[tokio::test]
async fn previews_show_the_same_place_and_store_nothing() {
    let client = Client::new().await;
    let shown = post(&client, "/jobs/preview", &work(3, 7)).await;
    assert_eq!(shown.status, StatusCode::OK, "{}", String::from_utf8_lossy(&shown.body));
    let shown = shown.json();
    assert_eq!(shown["steps"], 3);
    let png = shown["picture"].as_str().unwrap().strip_prefix("data:image/png;base64,").unwrap();
    let picture = image::load_from_memory(&base64::Engine::decode(&base64::engine::general_purpose::STANDARD, png).unwrap()).unwrap().into_rgba8();
    let opaque = picture.pixels().filter(|pixel| pixel.0[3] == 255).count();
    assert!(opaque > 1000 && opaque < (picture.width() * picture.height()) as usize - 1000, "{opaque}");
    assert!(picture.pixels().all(|pixel| [0, 255].contains(&pixel.0[3])));
    // A pixel a node, and half a node around.
    let bbox: Vec<f64> = shown["bbox"].as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    assert_eq!([bbox[2] - bbox[0], bbox[3] - bbox[1]], [f64::from(picture.width()) * 10.0, f64::from(picture.height()) * 10.0]);
    assert!(bbox[0] <= -505.0 && bbox[1] <= 295.0);
    assert_eq!((client.get("/jobs").await.json(), client.get("/rasters").await.json()), (json!({"jobs": []}), json!({"rasters": []})));
    let asked = post(&client, "/jobs", &work(3, 7)).await.json();
    let of_job = client.get(&format!("/jobs/{}/preview", asked["id"].as_str().unwrap())).await.json();
    assert_eq!(of_job, shown);
}

/// A change that makes a drawing wrong, and where that is told.
type Case<'a> = (&'a dyn Fn(&mut Value), &'a str);

#[tokio::test]
async fn what_is_wrong_is_told_with_its_place_and_nothing_is_stored() {
    let client = Client::new().await;
    let cases: [Case; 7] = [
        (&|drawing| drawing["strokes"] = json!([]), "/paths/drawing/strokes: "),
        (&|drawing| drawing["edges"] = json!({"random": {"mean": 1, "deviation": 1}}), "/paths/drawing/edges/random/deviation: "),
        (&|drawing| drawing["strokes"][0]["cost"] = json!(1e9), "/paths/drawing/sea_level: "),
        (&|drawing| drawing["profiles"]["flank"]["points"] = json!([[0, 0], [1, 1]]), "/paths/drawing/profiles/flank/points"),
        (&|drawing| drawing["profiles"]["flank"]["width"] = json!(1e6), "/paths/drawing/profiles"),
        (&|drawing| drawing["size"] = json!([100_000, 100_000]), "/paths/drawing/size: "),
        (&|drawing| drawing["strokes"][0]["profile"] = json!("flank"), "/paths/drawing/strokes/0/profile: "),
    ];
    for (change, expected) in cases {
        let mut wrong = work(2, 1);
        change(&mut wrong["paths"]["drawing"]);
        for path in ["/jobs", "/jobs/preview"] {
            let problem = post(&client, path, &wrong).await.problem();
            assert!(problem.starts_with(&format!("422 {expected}")), "{path}: {problem}");
        }
    }
    assert!(post(&client, "/jobs", &json!({"path": {}})).await.problem().starts_with("422 "));
    let broken = client.send(Method::POST, "/jobs", &[], "{").await;
    assert_eq!(broken.status, StatusCode::BAD_REQUEST);
    assert_eq!(client.get("/jobs/abc").await.problem(), "404 job: a job is named by 32 hex digits, got \"abc\"");
    assert_eq!(client.get("/rasters/0123456789abcdef0123456789abcdef").await.status, StatusCode::NOT_FOUND);
    assert_eq!(client.get("/jobs").await.json(), json!({"jobs": []}));
}

#[tokio::test]
async fn jobs_are_given_up_and_refused_when_too_many_wait() {
    let client = Client::with(|config| config.limits.jobs = 1).await;
    let mut ids = Vec::new();
    // One is under way, one waits, and what would come after is refused.
    for seed in 0..10 {
        let asked = post(&client, "/jobs", &work(2000, seed)).await;
        if asked.status == StatusCode::SERVICE_UNAVAILABLE {
            break;
        }
        ids.push(asked.json()["id"].as_str().unwrap().to_owned());
    }
    assert!((1..=3).contains(&ids.len()), "{}", ids.len());
    for id in &ids {
        assert_eq!(client.send(Method::DELETE, &format!("/jobs/{id}"), &[], "").await.status, StatusCode::NO_CONTENT);
    }
    assert_eq!(client.get("/jobs").await.json(), json!({"jobs": []}));
    // What was given up leaves the thread to what comes next, the same work too.
    let asked = post(&client, "/jobs", &work(1, 0)).await;
    assert_eq!(asked.status, StatusCode::ACCEPTED);
    assert_eq!(ended(&client, asked.json()["id"].as_str().unwrap()).await["state"], "done");
    assert_eq!(client.get("/rasters").await.json()["rasters"].as_array().unwrap().len(), 1, "what was given up leaves nothing");
}

#[tokio::test]
async fn a_drawing_that_is_stopped_begins_anew() {
    let client = Client::new().await;
    let id = post(&client, "/jobs", &work(2000, 5)).await.json()["id"].as_str().unwrap().to_owned();
    let stopped = post(&client, &format!("/jobs/{id}/stop"), &json!({})).await;
    assert_eq!((stopped.status, &stopped.json()["state"]), (StatusCode::OK, &json!("stopped")));
    assert_eq!(post(&client, &format!("/jobs/{id}/stop"), &json!({})).await.status, StatusCode::OK, "it is what was asked for");
    // It waits for nobody, not even after a restart; asking for the same again is one way to go on.
    let client = client.restart(|_| {}).await;
    let small = post(&client, "/jobs", &work(1, 5)).await.json()["id"].as_str().unwrap().to_owned();
    assert_eq!(ended(&client, &small).await["state"], "done");
    assert_eq!(client.get(&format!("/jobs/{id}")).await.json()["state"], "stopped");
    assert_eq!(post(&client, &format!("/jobs/{id}/resume"), &json!({})).await.status, StatusCode::ACCEPTED);
    assert_eq!(post(&client, &format!("/jobs/{id}/stop"), &json!({})).await.json()["state"], "stopped");
    assert_eq!(post(&client, "/jobs", &work(2000, 5)).await.status, StatusCode::ACCEPTED);
    let done = post(&client, &format!("/jobs/{small}/stop"), &json!({})).await.problem();
    assert_eq!(done, "409 The job is done: there is nothing to stop.");
    assert_eq!(post(&client, &format!("/jobs/{small}/resume"), &json!({})).await.problem(), "409 The job is done: there is nothing to resume.");
    let none = "0123456789abcdef0123456789abcdef";
    for what in ["stop", "resume"] {
        assert_eq!(post(&client, &format!("/jobs/{none}/{what}"), &json!({})).await.problem(), format!("404 job: there is no job {none}"));
    }
    assert_eq!(client.send(Method::DELETE, &format!("/jobs/{id}"), &[], "").await.status, StatusCode::NO_CONTENT);
}

#[tokio::test]
async fn jobs_outlive_the_server_and_make_the_same() {
    let client = Client::new().await;
    let slow = post(&client, "/jobs", &work(400, 3)).await.json()["id"].as_str().unwrap().to_owned();
    let waiting = post(&client, "/jobs", &work(2, 4)).await.json()["id"].as_str().unwrap().to_owned();
    let client = client.restart(|_| {}).await;
    let resumed = ended(&client, &slow).await["raster"].as_str().unwrap().to_owned();
    assert_eq!(ended(&client, &waiting).await["state"], "done");
    let other = Client::with(|config| config.server.threads = 1).await;
    post(&other, "/jobs", &work(400, 3)).await;
    assert_eq!(ended(&other, &slow).await["raster"], resumed, "the same work has the same id and makes the same raster");
}
