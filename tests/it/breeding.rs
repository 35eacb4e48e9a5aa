//! Breeding over HTTP: sessions that are kept, undone, branched, taken up again; and how much of a world can be reached.

use crate::client::{Answer, Client};
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};
use terrane::evolve::{Choice, Genome, Session};

async fn save(client: &Client, name: &str, record: &Value) -> Answer {
    client.put(&format!("/breeding/{name}"), &record.to_string()).await
}

async fn programmes(client: &Client, name: &str, generation: usize) -> Vec<String> {
    let answer = client.get(&format!("/breeding/{name}/generations/{generation}")).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", String::from_utf8_lossy(&answer.body));
    answer.json()["individuals"].as_array().unwrap().iter().map(|one| one["programme"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn a_session_is_bred_undone_branched_and_taken_up_again() {
    let client = Client::new().await;
    let created = client.send(Method::POST, "/breeding?name=mine", &[], r#"{"form":1,"seed":7,"programmes":["fbm(1, 2, 6)"]}"#).await;
    assert_eq!((created.status, created.header("location")), (StatusCode::CREATED, "http://localhost:8080/breeding/mine"));
    let mut record = created.json();
    assert_eq!(programmes(&client, "mine", 0).await[0], "fbm(1, 2, 6)");

    // Choice by choice what the library breeds.
    let mut session = Session::new(7, &[Genome::parse("fbm(1, 2, 6)").unwrap()]).unwrap();
    for parents in [&[3][..], &[0, 5], &[7, 1]] {
        record["choices"].as_array_mut().unwrap().push(json!({"parents": parents}));
        let saved = save(&client, "mine", &record).await;
        assert_eq!(saved.status, StatusCode::OK, "{}", String::from_utf8_lossy(&saved.body));
        session.choose(&Choice::of(parents)).unwrap();
    }
    let bred: Vec<Vec<String>> = session.generations().iter().map(|all| all.iter().map(|bred| bred.genome.to_string()).collect()).collect();
    for (generation, expected) in bred.iter().enumerate() {
        assert_eq!(&programmes(&client, "mine", generation).await, expected, "generation {generation}");
    }

    // A branch goes another way, an undone choice is gone, and both outlive the server.
    let mut branch = record.clone();
    branch["choices"][2] = json!({"parents": [7, 1], "again": 1});
    assert_eq!(save(&client, "branch", &branch).await.status, StatusCode::CREATED);
    assert_ne!(programmes(&client, "branch", 3).await, bred[3]);
    record["choices"].as_array_mut().unwrap().pop();
    save(&client, "mine", &record).await;
    assert_eq!(client.get("/breeding/mine/generations/3").await.problem(), "404 generation: must be 0 … 2, got 3");
    let other = programmes(&client, "branch", 3).await;
    let client = client.restart(|config| config.server.threads = 1).await;
    assert_eq!(programmes(&client, "mine", 2).await, bred[2]);
    assert_eq!(programmes(&client, "branch", 3).await, other);
    let list = client.get("/breeding").await.json();
    assert_eq!(list["sessions"].as_array().unwrap().iter().map(|one| one["generations"].as_u64().unwrap()).collect::<Vec<_>>(), [4, 3]);

    // Pictures, made once.
    let address = "/breeding/branch/generations/3/4/picture.png";
    let picture = client.get(address).await;
    assert_eq!(image::load_from_memory(&picture.body).unwrap().width(), 256);
    let fresh = client.send(Method::GET, address, &[("if-none-match", picture.header("etag"))], "").await;
    assert_eq!(fresh.status, StatusCode::NOT_MODIFIED);
    assert_eq!(client.get("/breeding/branch/generations/3/12/picture.png").await.problem(), "404 individual: there is no such individual");
    assert_eq!(client.send(Method::DELETE, "/breeding/branch", &[], "").await.status, StatusCode::NO_CONTENT);
}

/// What a world made of an individual shows is what its picture shows: the same seed, the same values.
#[tokio::test]
async fn a_world_of_an_individual_has_its_values() {
    let client = Client::new().await;
    save(&client, "mine", &json!({"form": 1, "seed": 3})).await;
    let generation = client.get("/breeding/mine/generations/0").await.json();
    let individual = &generation["individuals"][2];
    let world = json!({"seed": generation["seed"], "base": {"programme": individual["programme"], "scale": 1000, "amplitude": 1}});
    assert_eq!(client.put("/worlds/bred", &world.to_string()).await.status, StatusCode::CREATED);
    let [low, high] = [0, 1].map(|i| individual["values"][i].as_f64().unwrap());
    let points: Vec<Value> = (0..100).map(|i| json!([f64::from(i % 10) * 400.0 - 1990.0, f64::from(i / 10) * 400.0 - 1990.0])).collect();
    let heights = client.send(Method::POST, "/worlds/bred/elevation", &[], json!({"points": points}).to_string()).await.json();
    let heights: Vec<f64> = heights["elevation"].as_array().unwrap().iter().map(|height| height.as_f64().unwrap()).collect();
    let spread = high - low;
    assert!(heights.iter().all(|height| (low - 0.5 * spread..=high + 0.5 * spread).contains(height)), "{low} … {high}: {heights:?}");
    let most = heights.iter().copied().fold(f64::MIN, f64::max) - heights.iter().copied().fold(f64::MAX, f64::min);
    assert!(most > 0.2 * spread, "{most} of {spread}");
}

#[tokio::test]
async fn what_is_wrong_with_a_session_is_told_with_its_place() {
    let client = Client::new().await;
    let cases = [
        (json!({"form": 2, "seed": 1}), "422 /form: must be 1, the form that this version reads, got 2"),
        (
            json!({"form": 1, "seed": 1, "choices": [{"parents": [3, 3]}]}),
            "422 /choices/0/parents: must be one or two different individuals, 0 … 11, got [3, 3]",
        ),
        (json!({"form": 1, "seed": 1, "programmes": ["x", "fmb(1, 2, 3)"]}), "422 /programmes/1: "),
        (json!({"form": 1, "seed": 1, "colour": 3}), "422 /colour: unknown field `colour`"),
        (json!({"form": 1, "seed": -1}), "422 /seed: "),
    ];
    for (record, expected) in cases {
        let problem = save(&client, "wrong", &record).await.problem();
        assert!(problem.starts_with(expected), "{problem}");
    }
    assert_eq!(client.put("/breeding/wrong", "{").await.status, StatusCode::BAD_REQUEST);
    assert_eq!(client.get("/breeding").await.json(), json!({"sessions": []}));
    save(&client, "right", &json!({"form": 1, "seed": 1})).await;
    let stale = client.send(Method::PUT, "/breeding/right", &[("if-match", "\"0123\"")], r#"{"form":1,"seed":1,"choices":[{"parents":[1]}]}"#).await;
    assert_eq!(stale.status, StatusCode::PRECONDITION_FAILED);
}

#[tokio::test]
async fn accessibility_counts_what_can_be_reached() {
    let client = Client::new().await;
    let ask = async |world: &str, question: Value| client.send(Method::POST, &format!("/worlds/{world}/accessibility"), &[], question.to_string()).await;
    // A plain, a ramp too steep everywhere, and a wall from north to south that parts a plain.
    for (name, base) in [
        ("plain", json!({"programme": "7", "scale": 100})),
        ("ramp", json!({"programme": "x", "scale": 100, "amplitude": 100})),
        ("wall", json!({"programme": "max(0, minus(1, abs(x)))", "scale": 100, "amplitude": 400})),
    ] {
        client.put(&format!("/worlds/{name}"), &json!({"seed": 1, "base": base}).to_string()).await;
    }
    let area = json!({"bbox": [-1000, -500, 1000, 500], "spacing": 10, "slope": 30});
    let plain = ask("plain", area.clone()).await.json();
    assert_eq!(plain, json!({"columns": 200, "rows": 100, "accessible": 1.0, "largest": 1.0, "areas": 1, "obstacles": 0, "edge": 0.0}));
    let ramp = ask("ramp", area.clone()).await.json();
    assert_eq!((&ramp["accessible"], &ramp["areas"], &ramp["obstacles"]), (&json!(0.0), &json!(0), &json!(1)));
    let wall = ask("wall", area).await.json();
    assert!(wall["areas"].as_u64().unwrap() >= 2 && wall["largest"].as_f64().unwrap() < 0.5 && wall["accessible"].as_f64().unwrap() > 0.85, "{wall}");
    assert!(wall["edge"].as_f64().unwrap() >= 2000.0);
    for (question, expected) in [
        (json!({"bbox": [0, 0, 100, 100], "spacing": 10, "slope": 90}), "400 /slope: must be above 0 and below 90 degrees, got 90"),
        (json!({"bbox": [0, 0, 100, 100], "spacing": 0}), "400 /spacing: "),
        (json!({"bbox": [100, 0, 0, 100], "spacing": 1}), "400 /bbox: "),
        (json!({"bbox": [0, 0, 1e6, 1e6], "spacing": 1}), "400 /bbox: "),
        (json!({"bbox": [0, 0, 100, 100]}), "400 : missing field `spacing`"),
    ] {
        let problem = ask("plain", question).await.problem();
        assert!(problem.starts_with(expected), "{problem}");
    }
}
