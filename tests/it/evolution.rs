//! Evolutions over HTTP: what they find is what the library finds, whatever stops them in between.

use crate::{
    client::{Answer, Client},
    jobs::{ended, post, work as drawing},
    process::Server,
};
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};
use std::{
    path::Path,
    process::Command,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};
use terrane::{
    evolve::{Aim, Choice, Genome, Judgement, Search, Session},
    genetic::{Evolution, State},
    geometry::Stop,
    programme::Tape,
};

/// A small evolution of so many generations.
fn work(generations: usize, seed: u64) -> Value {
    json!({"evolution": {"seed": seed, "settings": {"population": 10, "islands": 2, "generations": generations, "migration": {"every": 2, "count": 1}},
        "aim": {"seed": 3, "samples": 24, "relief": 250, "wanted": [
            {"weight": 3, "criterion": {"accessibility": {"slope": 15, "share": 0.8}}},
            {"criterion": {"edges": {"slope": 15, "density": 6000}}}]}}})
}

/// The same in the library, straight through.
fn bred(work: &Value) -> (Search, State<Genome, Judgement>, Vec<Value>) {
    let search: Search = serde_json::from_value(work["evolution"].clone()).unwrap();
    let mut evolution = Evolution::new(&search.aim, search.settings, search.seed, &Stop::never()).unwrap().unwrap();
    let mut curve = Vec::new();
    evolution.run(&Stop::never(), &mut |state| {
        let progress = state.progress();
        curve.push(json!({"generation": progress.generation, "best": progress.best, "mean": progress.mean, "evaluations": progress.evaluations}));
        true
    });
    let state = evolution.into_state();
    (search, state, curve)
}

async fn ask(client: &Client, work: &Value) -> String {
    let asked = post(client, "/jobs", work).await;
    assert_eq!(asked.status, StatusCode::ACCEPTED, "{}", String::from_utf8_lossy(&asked.body));
    asked.json()["id"].as_str().unwrap().to_owned()
}

async fn evolution(client: &Client, id: &str) -> Value {
    client.get(&format!("/jobs/{id}/evolution")).await.json()
}

/// Waits until so many generations are kept.
async fn reaches(client: &Client, id: &str, generation: u64) {
    while evolution(client, id).await["generation"].as_u64().is_none_or(|there| there < generation) {
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
}

async fn order(client: &Client, id: &str, what: &str) -> Answer {
    client.send(Method::POST, &format!("/jobs/{id}/{what}"), &[], "").await
}

#[tokio::test]
async fn a_job_finds_what_the_library_finds_and_a_world_shows_it() {
    let client = Client::new().await;
    let id = ask(&client, &work(5, 11)).await;
    let job = ended(&client, &id).await;
    assert_eq!((&job["state"], &job["kind"], &job["raster"]), (&json!("done"), &json!("evolution"), &Value::Null));
    assert_eq!(job["work"]["evolution"]["settings"]["elite"], 2, "what was left out is told");
    let address = job["evolution"].as_str().unwrap().strip_prefix("http://localhost:8080").unwrap();

    let (search, state, curve) = bred(&work(5, 11));
    let found = client.get(address).await.json();
    assert_eq!((&found["generation"], &found["of"], &found["curve"]), (&json!(5), &json!(5), &json!(curve)));
    let (best, expected) = (&found["best"], state.best().unwrap());
    assert_eq!(best["programme"], expected.genome.to_string());
    assert_eq!(best["score"], expected.evaluation.score);
    let scores: Vec<f64> = best["criteria"].as_array().unwrap().iter().map(|one| one["score"].as_f64().unwrap()).collect();
    assert_eq!(
        (&scores, &best["criteria"][0]["criterion"], &best["criteria"][0]["weight"]),
        (&expected.evaluation.scores, &json!("accessibility"), &json!(3.0))
    );
    let later = client.get(&format!("{address}?from=4")).await.json();
    assert_eq!((&later["curve"], &later["best"]), (&json!(curve[4..]), best));
    assert_eq!(client.get(&format!("{address}?from=4.5")).await.problem(), "400 from: must be a whole number from 0 on, got \"4.5\"");

    // Its picture, and the same ground as a world.
    let path = format!("/jobs/{id}/best.png");
    let picture = client.get(&format!("{path}?size=128")).await;
    assert_eq!(image::load_from_memory(&picture.body).unwrap().width(), 128);
    let fresh = client.send(Method::GET, &format!("{path}?size=128"), &[("if-none-match", picture.header("etag"))], "").await;
    assert_eq!(fresh.status, StatusCode::NOT_MODIFIED);
    let world =
        json!({"seed": best["seed"], "base": {"programme": best["programme"], "scale": best["scale"], "amplitude": best["amplitude"], "datum": best["datum"]}});
    assert_eq!(client.put("/worlds/found", &world.to_string()).await.status, StatusCode::CREATED);
    let question = json!({"bbox": [-2000, -2000, 2000, 2000], "spacing": 4000.0 / 24.0, "slope": 15});
    let reached = post(&client, "/worlds/found/accessibility", &question).await.json();
    let score = 1.0 - (reached["largest"].as_f64().unwrap() - 0.8).abs() / 0.8;
    assert!((score - scores[0]).abs() < 0.01, "{score} {scores:?}");
    let (surface, _) = search.aim.surface(&Tape::compile(expected.genome.programme().unwrap().root()), &Stop::never()).unwrap();
    let question = json!({"bbox": [-2000, -2000, 2000, 2000], "spacing": 4000.0 / 24.0});
    let measured = post(&client, "/worlds/found/statistics", &question).await.json();
    let own = terrane::analysis::Statistics::of(&surface, search.aim.spacing());
    assert!((measured["relief"].as_f64().unwrap() - own.relief).abs() < 0.01 * own.relief, "{measured} {own:?}");
    assert!((measured["roughness"].as_f64().unwrap() - own.roughness).abs() < 0.01 * own.roughness);

    // What is measured of a world can be wanted.
    let mut like = work(0, 1);
    like["evolution"]["aim"]["wanted"] = json!([{"criterion": {"likeness": {"sample": measured}}}]);
    let like = ask(&client, &like).await;
    assert_eq!(ended(&client, &like).await["state"], "done");
    assert!(evolution(&client, &like).await["best"]["score"].as_f64().unwrap() > 0.3);
}

#[tokio::test]
async fn stopped_restarted_and_resumed_it_ends_as_if_it_had_never_stopped() {
    let whole = Client::with(|config| config.server.threads = 1).await;
    let id = ask(&whole, &work(12, 7)).await;
    ended(&whole, &id).await;
    let expected = evolution(&whole, &id).await;
    assert_eq!(expected["curve"].as_array().unwrap().len(), 13);

    let client = Client::with(|config| config.server.threads = 3).await;
    assert_eq!(ask(&client, &work(12, 7)).await, id);
    reaches(&client, &id, 2).await;
    let stopped = order(&client, &id, "stop").await.json();
    assert_eq!((&stopped["state"], stopped["progress"].as_f64().unwrap() > 0.1), (&json!("stopped"), true));
    let half = evolution(&client, &id).await;
    let there = half["generation"].as_u64().unwrap() as usize;
    assert!((2..12).contains(&there));
    assert_eq!(half["curve"], json!(expected["curve"].as_array().unwrap()[..=there]));
    assert_eq!(client.get(&format!("/jobs/{id}/best.png")).await.status, StatusCode::OK);
    let client = client.restart(|config| config.server.threads = 2).await;
    assert_eq!(evolution(&client, &id).await, half, "what is stopped stays so");

    assert_eq!(order(&client, &id, "resume").await.status, StatusCode::ACCEPTED);
    reaches(&client, &id, there as u64 + 1).await;
    // In the middle of a generation.
    let client = client.restart(|_| {}).await;
    ended(&client, &id).await;
    assert_eq!(evolution(&client, &id).await, expected);
    assert_eq!(order(&client, &id, "stop").await.problem(), "409 The job is done: there is nothing to stop.");
    assert_eq!(post(&client, "/jobs", &work(12, 7)).await.status, StatusCode::OK);
    // Forgotten, it begins anew.
    assert_eq!(client.send(Method::DELETE, &format!("/jobs/{id}"), &[], "").await.status, StatusCode::NO_CONTENT);
    assert_eq!(client.get(&format!("/jobs/{id}/evolution")).await.status, StatusCode::NOT_FOUND);
    ask(&client, &work(12, 7)).await;
    ended(&client, &id).await;
    assert_eq!(evolution(&client, &id).await, expected);
}

#[tokio::test]
async fn what_takes_long_lets_others_go_first() {
    let client = Client::with(|config| config.limits.jobs = 2).await;
    let long = ask(&client, &work(10_000, 1)).await;
    reaches(&client, &long, 0).await;
    let short = ask(&client, &drawing(1, 1)).await;
    assert_eq!(ended(&client, &short).await["state"], "done");
    let job = client.get(&format!("/jobs/{long}")).await.json();
    assert!(job["state"] == "running" || job["state"] == "waiting", "{job}");
    let generation = evolution(&client, &long).await["generation"].as_u64().unwrap();
    reaches(&client, &long, generation + 1).await;
    order(&client, &long, "stop").await;

    // A goal ends it before its generations are bred.
    let mut easy = work(10_000, 2);
    easy["evolution"]["goal"] = json!(0.3);
    let easy = ask(&client, &easy).await;
    let job = ended(&client, &easy).await;
    assert_eq!((&job["state"], &job["progress"]), (&json!("done"), &json!(1.0)));
    assert!(evolution(&client, &easy).await["generation"].as_u64().unwrap() < 100);
    assert_eq!(client.get(&format!("/jobs/{short}/evolution")).await.problem(), format!("404 job: the job {short} is no evolution"));
    assert_eq!(client.get(&format!("/jobs/{easy}/preview")).await.problem(), "404 job: an evolution has no preview: look at its best.png");
}

/// A change that makes a search wrong, and where that is told.
type Case<'a> = (&'a dyn Fn(&mut Value), &'a str);

#[tokio::test]
async fn what_is_wrong_is_told_with_its_place_and_nothing_is_stored() {
    let client = Client::new().await;
    let cases: [Case; 5] = [
        (&|search| search["aim"]["wanted"][0]["criterion"] = json!({"beauty": {}}), "/evolution/aim/wanted/0/criterion"),
        (&|search| search["aim"]["wanted"][1]["criterion"]["edges"]["slope"] = json!(90), "/evolution/aim/wanted/1/criterion/edges/slope: "),
        (&|search| search["settings"]["population"] = json!(1), "/evolution/settings/population: "),
        (&|search| search["aim"] = Value::Null, "/evolution/aim"),
        (
            &|search| (search["settings"]["generations"], search["aim"]["samples"]) = (json!(10_000), json!(1024)),
            "/evolution/settings/generations: all generations may take",
        ),
    ];
    for (change, expected) in cases {
        let mut wrong = work(2, 1);
        change(&mut wrong["evolution"]);
        let problem = post(&client, "/jobs", &wrong).await.problem();
        assert!(problem.starts_with(&format!("422 {expected}")), "{problem}");
    }
    let both = json!({"evolution": work(2, 1)["evolution"], "paths": drawing(1, 1)["paths"]});
    assert!(post(&client, "/jobs", &both).await.problem().starts_with("422 : must have one member"));
    assert!(post(&client, "/jobs/preview", &work(2, 1)).await.problem().starts_with("422 /evolution: has no preview"));
    assert_eq!(client.get("/jobs").await.json(), json!({"jobs": []}));
    let none = "0123456789abcdef0123456789abcdef";
    for what in ["evolution", "best.png"] {
        assert_eq!(client.get(&format!("/jobs/{none}/{what}")).await.problem(), format!("404 job: there is no job {none}"));
    }
}

fn get(server: &Server, path: &str) -> Value {
    serde_json::from_slice(&server.get(path)).unwrap()
}

/// Kills a server without warning.
fn kill(mut server: Server) {
    assert!(Command::new("kill").args(["-9", &server.child.id().to_string()]).status().unwrap().success());
    server.child.wait().unwrap();
}

/// Lets a job end, killing the server after every so many milliseconds. Answers what it found and how often the server was killed.
fn found(data: &Path, work: &Value, kill_ms: Option<u64>) -> (Value, u32) {
    let (mut kills, mut id) = (0, None);
    for round in 0.. {
        let server = Server::start(data);
        let id = id.get_or_insert_with(|| {
            let (status, body) = server.request("POST", "/jobs", &work.to_string()).unwrap();
            assert_eq!(status, 202);
            serde_json::from_slice::<Value>(&body).unwrap()["id"].as_str().unwrap().to_owned()
        });
        // A killing never twice at the same place of a generation, and rarer and rarer, so that it ends.
        let patience = Duration::from_millis(kill_ms.map_or(u64::MAX, |ms| ms + round * 37 % 90 + round * round));
        let begun = std::time::Instant::now();
        while begun.elapsed() < patience {
            if get(&server, &format!("/jobs/{id}"))["state"] == "done" {
                let mut found = get(&server, &format!("/jobs/{id}/evolution"));
                found["best"]["picture"] = Value::Null;
                return (found, kills);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        kill(server);
        kills += 1;
    }
    unreachable!("it ends");
}

#[test]
fn a_killed_server_finds_what_one_finds_that_was_not() {
    let (whole, killed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (expected, _) = found(whole.path(), &work(20, 5), None);
    let (again, kills) = found(killed.path(), &work(20, 5), Some(60));
    assert!(kills >= 2, "{kills}");
    assert_eq!(again, expected);
}

/// Breeds as fast as it can, kills the server in the middle, and looks for every choice that was acknowledged and for the children of all.
#[test]
fn a_killed_server_breeds_what_was_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut chosen: Vec<[usize; 2]> = Vec::new();
    let record = |chosen: &[[usize; 2]]| json!({"form": 1, "seed": 4, "choices": chosen.iter().map(|parents| json!({"parents": parents})).collect::<Vec<_>>()});
    let mut pending: Option<Vec<[usize; 2]>> = None;
    for round in 0..4_u64 {
        let server = Server::start(folder.path());
        if round > 0 {
            let stored = get(&server, "/breeding/storm")["choices"].as_array().unwrap().len();
            let expected = [chosen.len(), pending.as_ref().map_or(chosen.len(), Vec::len)];
            assert!(expected.contains(&stored), "{stored} choices, not one of {expected:?}");
            if stored != chosen.len() {
                chosen = pending.take().unwrap();
            }
            let mut session = Session::new(4, &[]).unwrap();
            for parents in &chosen {
                session.choose(&Choice::of(parents)).unwrap();
            }
            let generation = get(&server, &format!("/breeding/storm/generations/{}", chosen.len()));
            let programmes: Vec<_> = generation["individuals"].as_array().unwrap().iter().map(|one| one["programme"].as_str().unwrap().to_owned()).collect();
            let expected: Vec<_> = session.generations()[chosen.len()].iter().map(|bred| bred.genome.to_string()).collect();
            assert_eq!(programmes, expected, "after {round} kills");
        }
        // After some choices, at another point of the next one each time.
        let (killed, made) = (server.child.id().to_string(), Arc::new(AtomicUsize::new(0)));
        let counted = Arc::clone(&made);
        let killing = std::thread::spawn(move || {
            while counted.load(Ordering::Relaxed) < 3 {
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(Duration::from_millis(round * 7));
            Command::new("kill").args(["-9", &killed]).status().unwrap()
        });
        loop {
            let i = chosen.len();
            let next = [chosen.clone(), vec![[i % 12, (i * 5 + 1) % 12 + usize::from(i % 12 == (i * 5 + 1) % 12)]]].concat();
            let next: Vec<[usize; 2]> = next.into_iter().map(|[a, b]| [a, b % 12]).collect();
            pending = Some(next.clone());
            match server.request("PUT", "/breeding/storm", &record(&next).to_string()) {
                Ok((200 | 201, _)) => {
                    chosen = next;
                    made.fetch_add(1, Ordering::Relaxed);
                }
                Ok((status, body)) => panic!("{status}: {}", String::from_utf8_lossy(&body)),
                Err(_) => break,
            }
        }
        assert!(killing.join().unwrap().success());
        drop(server);
    }
    assert!(chosen.len() >= 12, "{} choices", chosen.len());
}

#[test]
#[expect(clippy::print_stdout, reason = "writes the figures")]
#[ignore = "prints figures: how large checkpoints are and how long storing them takes"]
fn checkpoints_are_small() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    for (population, islands) in [(64, 1), (256, 1), (1024, 4)] {
        let aim = Aim::parse(br#"{"samples": 16, "wanted": [{"criterion": {"roughness": {"value": 0.1}}}]}"#).unwrap();
        let settings = terrane::genetic::Settings { population, islands, generations: 10, ..Default::default() };
        let search = Search { aim, settings, seed: 1, goal: None };
        let mut stage = search.begin(&Stop::never()).unwrap().unwrap();
        for _ in 0..10 {
            stage = search.advance(stage, &Stop::never()).unwrap().unwrap();
        }
        let written = std::time::Instant::now();
        let state = serde_json::to_vec(&stage).unwrap();
        let packed = terrane::store::pack(&state);
        let written = written.elapsed();
        let folder = tempfile::tempdir().unwrap();
        let stored = runtime.block_on(async {
            let store = terrane::store::Store::open(folder.path()).await.unwrap();
            store.ask("a", "{}").await.unwrap();
            let begun = std::time::Instant::now();
            for number in 0..20 {
                let step = terrane::store::Step { number, of: 20, line: "{}".to_owned(), found: "{}".to_owned(), state: packed.clone(), is_last: false };
                assert!(store.advance("a", &step).await.unwrap());
            }
            begun.elapsed() / 20
        });
        let count = population * islands;
        println!("{count} individuals: {} bytes of JSON, {} packed, {written:.1?} to write, {stored:.1?} to store", state.len(), packed.len());
    }
}
