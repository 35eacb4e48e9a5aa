//! The programme library: what it lists, keeps, shows and refuses.

use crate::client::{Answer, Client};
use axum::http::{Method, StatusCode};
use serde_json::{Value, json};
use terrane::world::{PRESETS, Preset, Survey, World};

const MINE: &str = r#"{"title":"Folded land","tags":["hills","mine"],"origin":"drawn by hand","programme":"fbm(1, 2, 8)"}"#;

async fn listed(client: &Client, query: &str) -> Vec<String> {
    let list = client.get(&format!("/programmes{query}")).await.json();
    let names: Vec<_> = list["programmes"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap().to_owned()).collect();
    assert_eq!(list["found"], names.len(), "{query}");
    names
}

fn created(answer: &Answer) -> (StatusCode, &str) {
    (answer.status, answer.header("location"))
}

#[tokio::test]
async fn a_new_server_lists_what_ships_with_links_that_lead_there() {
    let client = Client::new().await;
    let shipped: Vec<_> = PRESETS.iter().map(|preset| preset.name).collect();
    assert_eq!(listed(&client, "").await, shipped);
    for entry in client.get("/programmes").await.json()["programmes"].as_array().unwrap() {
        assert_eq!(entry["origin"], "shipped with Terrane");
        assert!(entry["title"].is_string() && entry["description"].is_string() && !entry["tags"].as_array().unwrap().is_empty(), "{entry}");
        let path = |link: &str| entry[link].as_str().unwrap().strip_prefix("http://localhost:8080").unwrap().to_owned();
        let document = client.get(&path("document")).await;
        assert_eq!((document.status, document.header("etag")), (StatusCode::OK, format!("{}", json!(entry["revision"])).as_str()));
        assert!(path("preview").ends_with("/preview.png"));
    }
    let client = Client::with(|config| config.server.public_url = "https://maps.example.org/terrain".to_owned()).await;
    let first = client.get("/programmes").await.json()["programmes"][0].clone();
    assert_eq!(first["preview"], "https://maps.example.org/terrain/programmes/alps/preview.png");
}

#[tokio::test]
async fn the_list_is_narrowed_by_tags_and_words() {
    let client = Client::new().await;
    client.put("/programmes/mine", MINE).await;
    let tagged = |tags: &[&str]| -> Vec<String> {
        let presets = PRESETS.iter().filter(|preset| {
            let document: serde_json::Value = serde_json::from_str(preset.json).unwrap();
            tags.iter().all(|tag| document["tags"].as_array().unwrap().contains(&json!(tag)))
        });
        presets.map(|preset| preset.name.to_owned()).collect()
    };
    let (deserts, canyons) = (tagged(&["desert"]), tagged(&["desert", "canyons"]));
    assert!(deserts.contains(&"dunes".to_owned()) && deserts.len() < PRESETS.len());
    assert_eq!(listed(&client, "?tag=desert").await, deserts);
    assert_eq!(listed(&client, "?tag=desert&tag=canyons").await, canyons);
    assert_eq!(listed(&client, "?q=BY+Hand+FOLDED").await, ["mine"]);
    assert_eq!(listed(&client, "?q=by+hand&tag=hills").await, ["mine"]);
    assert_eq!(listed(&client, "?q=mine%20shipped").await, [""; 0]);
    assert_eq!(listed(&client, "?tag=des").await, [""; 0]);
    assert_eq!(listed(&client, "?tag=desert&q=").await, deserts);
    assert_eq!(client.get("/programmes?tags=desert").await.problem(), "400 tags: unknown field `tags`, expected `tag` or `q`");
}

#[tokio::test]
async fn what_get_gives_can_be_put_and_changes_nothing() {
    let client = Client::new().await;
    let new = client.put("/programmes/mine", MINE).await;
    assert_eq!(created(&new), (StatusCode::CREATED, "http://localhost:8080/programmes/mine"));
    let got = client.get("/programmes/mine").await;
    assert_eq!((got.header("etag"), &got.body), (new.header("etag"), &new.body));
    let document = got.json();
    assert_eq!((&document["scale"], &document["amplitude"], &document["seed"]), (&json!(20_000), &json!(1000), &json!(0)));
    assert_eq!(document["elevation"], json!({"min": -10_000, "max": 9000}));
    let again = client.put("/programmes/mine", std::str::from_utf8(&got.body).unwrap()).await;
    assert_eq!((again.status, again.header("etag"), &again.body), (StatusCode::OK, new.header("etag"), &got.body));
    let client = client.restart(|_| {}).await;
    assert_eq!(client.get("/programmes/mine").await.body, got.body, "after a restart too");
}

#[tokio::test]
async fn a_programme_is_given_as_text_and_as_a_tree_however_it_came() {
    let client = Client::new().await;
    client.put("/programmes/text", r#"{"programme":"plus( fbm(1.0,2,octaves=8), x )"}"#).await;
    client.put("/programmes/tree", r#"{"programme":{"op":"plus","args":[{"op":"fbm","args":[1,2,8]},"x"]}}"#).await;
    for name in ["text", "tree"] {
        let text = client.get(&format!("/programmes/{name}/programme.txt")).await;
        assert_eq!((text.header("content-type"), &text.body[..]), ("text/plain; charset=utf-8", &b"plus(fbm(1, 2, 8), x)"[..]));
        let tree = client.get(&format!("/programmes/{name}/programme.json")).await;
        assert_eq!(tree.json(), json!({"op": "plus", "args": [{"op": "fbm", "args": [1, 2, 8]}, "x"]}));
    }
    assert_eq!(client.get("/programmes/text").await.json()["programme"], "plus( fbm(1.0,2,octaves=8), x )", "the document stays as it was written");
}

#[tokio::test]
async fn pictures_are_made_once_and_answered_with_304() {
    let client = Client::new().await;
    let path = "/programmes/alps/preview.png";
    let requests = (0..16).map(|_| client.get(path));
    let answers = futures_util::future::join_all(requests).await;
    assert!(answers.iter().all(|answer| answer.status == StatusCode::OK && answer.body == answers[0].body));
    assert_eq!((client.app.evaluations(), answers[0].header("content-type"), answers[0].header("cache-control")), (1, "image/png", "no-cache"));
    let preset = Preset::parse(PRESETS[0].json.as_bytes()).unwrap();
    let world = World::new(preset.document());
    assert_eq!(answers[0].body, terrane::tile::preview(&world, &Survey::of(&world).window(256), preset.sea_level).unwrap());
    assert_eq!(client.get("/programmes/alps/preview.png?size=256").await.body, answers[0].body);
    // One that was never asked for is answered from its fingerprint alone.
    let tag = format!("\"{}\"", world.view_fingerprint(terrane::tile::PREVIEW_FORM, 100));
    let unseen = client.send(Method::GET, "/programmes/alps/preview.png?size=100", &[("if-none-match", &tag)], "").await;
    assert_eq!((unseen.status, unseen.header("etag"), unseen.body.len(), client.app.evaluations()), (StatusCode::NOT_MODIFIED, tag.as_str(), 0, 1));
    let small = client.get("/programmes/alps/preview.png?size=64").await;
    assert_eq!((small.status, &small.body[16..24]), (StatusCode::OK, &[0, 0, 0, 64, 0, 0, 0, 64][..]));

    // What does not change the ground does not change the picture; what does, does.
    let etag = async |change: fn(&mut Value)| {
        let mut document = client.get("/programmes/alps").await.json();
        change(&mut document);
        assert_eq!(client.put("/programmes/alps", &document.to_string()).await.status, StatusCode::OK);
        client.get(path).await.header("etag").to_owned()
    };
    assert_eq!(etag(|document| document["tags"] = json!(["other"])).await, answers[0].header("etag"));
    assert_ne!(etag(|document| document["seed"] = json!(8)).await, answers[0].header("etag"));
}

#[tokio::test]
async fn everything_with_an_entity_tag_answers_304_to_it() {
    let client = Client::new().await;
    for path in ["", "?tag=desert", "/dunes", "/dunes/programme.txt", "/dunes/programme.json", "/dunes/preview.png?size=64"] {
        let path = format!("/programmes{path}");
        let first = client.get(&path).await;
        let again = client.send(Method::GET, &path, &[("if-none-match", first.header("etag"))], "").await;
        assert_eq!((again.status, again.header("etag"), again.body.len()), (StatusCode::NOT_MODIFIED, first.header("etag"), 0), "{path}");
        assert!(first.header("etag").len() > 30, "{path}");
        let head = client.send(Method::HEAD, &path, &[], "").await;
        assert_eq!((head.status, head.body.len()), (StatusCode::OK, 0));
    }
}

#[tokio::test]
async fn conditions_are_kept() {
    let client = Client::new().await;
    let send = async |headers: &[(&str, &str)], seed: u64| {
        client.send(Method::PUT, "/programmes/mine", headers, format!(r#"{{"seed":{seed},"programme":"x"}}"#)).await
    };
    assert_eq!(send(&[("if-match", "*")], 1).await.problem(), "412 the programme is absent, not what the request's condition asks for");
    let first = send(&[("if-none-match", "*")], 1).await;
    assert_eq!(first.status, StatusCode::CREATED);
    assert_eq!(send(&[("if-none-match", "*")], 2).await.status, StatusCode::PRECONDITION_FAILED);
    let second = send(&[("if-match", first.header("etag"))], 2).await;
    assert_eq!(second.status, StatusCode::OK);
    let stale = send(&[("if-match", first.header("etag"))], 3).await;
    assert!(stale.problem().starts_with("412 the programme is at revision "), "{}", stale.problem());
    let delete = async |tag: &str| client.send(Method::DELETE, "/programmes/mine", &[("if-match", tag)], "").await.status;
    assert_eq!((delete(first.header("etag")).await, delete(second.header("etag")).await), (StatusCode::PRECONDITION_FAILED, StatusCode::NO_CONTENT));
    assert_eq!(send(&[("if-match", "\"\u{e9}\"")], 3).await.status, StatusCode::BAD_REQUEST);
}

#[tokio::test]
async fn programmes_are_posted_named_and_deleted() {
    let client = Client::new().await;
    let post = async |query: &str, body: &str| client.send(Method::POST, &format!("/programmes{query}"), &[], body.to_owned()).await;
    assert_eq!(created(&post("?name=mine", MINE).await), (StatusCode::CREATED, "http://localhost:8080/programmes/mine"));
    assert_eq!(post("?name=mine", MINE).await.problem(), "409 A programme is already named \"mine\".");
    assert_eq!(post("?name=My", MINE).await.problem(), "400 name: a name is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"My\"");
    assert_eq!(created(&post("", MINE).await).1, "http://localhost:8080/programmes/folded-land");
    assert_eq!(created(&post("", MINE).await).1, "http://localhost:8080/programmes/folded-land-2");
    assert!(created(&post("", r#"{"programme":"x"}"#).await).1.starts_with("http://localhost:8080/programmes/programme-"));
    for status in [StatusCode::NO_CONTENT, StatusCode::NOT_FOUND] {
        assert_eq!(client.send(Method::DELETE, "/programmes/mine", &[], "").await.status, status);
    }
    assert_eq!(client.get("/programmes/mine").await.problem(), "404 programme: no programme is named \"mine\"");
    assert!(client.get("/worlds/mine").await.problem().starts_with("404 world"), "names of worlds are others");
}

#[tokio::test]
async fn what_was_shipped_is_the_user_s_to_change_and_delete() {
    let client = Client::new().await;
    client.send(Method::DELETE, "/programmes/alps", &[], "").await;
    let mut edited = client.get("/programmes/dunes").await.json();
    edited["title"] = json!("My dunes");
    let edited = client.put("/programmes/dunes", &edited.to_string()).await;
    let client = client.restart(|_| {}).await;
    assert_eq!(client.get("/programmes/alps").await.status, StatusCode::NOT_FOUND);
    assert_eq!(client.get("/programmes/dunes").await.body, edited.body);
    assert_eq!(client.get("/programmes/mesas").await.status, StatusCode::OK);
}

#[tokio::test]
async fn wrong_documents_are_told_every_place_and_store_nothing() {
    let client = Client::new().await;
    let before = listed(&client, "").await;
    let huge = format!(r#"{{"programme":"x","description":"{}"}}"#, "x".repeat(2_000_000));
    let costly = format!(r#"{{"programme":"{}x{}"}}"#, "plus(fbm(1, 2, 32), ".repeat(200), ")".repeat(200));
    for (body, expected) in [
        ("", "400 The body is not JSON: EOF while parsing a value at line 1 column 0."),
        ("{}", "422 /programme: missing field `programme`"),
        (
            r#"{"programme":"x","sale":1}"#,
            "422 /sale: unknown field `sale`, expected one of `title`, `description`, `tags`, `origin`, `programme`, `scale`, `amplitude`, `datum`, `sea_level`, `seed`, `elevation` (did you mean `scale`?)",
        ),
        (r#"{"programme":"plus(x, fmb(1, 2, 8))"}"#, "422 /programme: unknown function \"fmb\" (did you mean \"fbm\"?)"),
        (r#"{"programme":{"op":"sin","args":["z"]}}"#, "422 /programme/args/0: unknown name \"z\" (did you mean \"x\"?)"),
        (r#"{"programme":"x","tags":["Alps","a","a"],"seed":-1}"#, "422 /seed: expected a whole number 0 … 9007199254740991"),
        (
            r#"{"programme":"x","tags":["Alps","a","a"],"elevation":{"min":5,"max":4}}"#,
            "422 /elevation: min must be less than max, got 5 and 4; /tags/0: a tag is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"Alps\"; /tags/2: \"a\" is given twice",
        ),
        (huge.as_str(), "413 The body must be at most 1048576 bytes."),
    ] {
        assert_eq!(client.put("/programmes/new", body).await.problem(), expected);
    }
    assert!(client.put("/programmes/new", &costly).await.problem().starts_with("422 /programme: "), "budgets are those of worlds");
    let wrong = client.put("/programmes/new", r#"{"programme":"fmb(x)"}"#).await.json();
    assert_eq!((&wrong["type"], &wrong["detail"]), (&json!("urn:terrane:invalid-programme"), &json!("The programme document has 1 problem.")));
    assert_eq!((&wrong["errors"][0]["start"], &wrong["errors"][0]["end"]), (&json!(0), &json!(3)));
    assert!(client.put("/programmes/New", MINE).await.problem().starts_with("400 programme: a name is"));
    assert_eq!(listed(&client, "").await, before);
}

#[tokio::test]
async fn wrong_requests_are_told_what_would_be_right() {
    let client = Client::new().await;
    for (path, expected) in [
        ("/programmes/alp", "404 programme: no programme is named \"alp\" (did you mean \"alps\"?)"),
        ("/programmes/Alps/preview.png", "404 programme: a name is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"Alps\""),
        ("/programmes/alps/preview.png?size=63", "400 size: must be a whole number 64 … 1024, got \"63\""),
        ("/programmes/alps/preview.png?size=1025", "400 size: must be a whole number 64 … 1024, got \"1025\""),
        ("/programmes/alps/preview.png?size=2.5e2", "400 size: must be a whole number 64 … 1024, got \"2.5e2\""),
        ("/programmes/alps/preview.png?sise=256", "400 sise: unknown field `sise`, expected `size`"),
        ("/programmes/alps/preview.jpg", "404 There is nothing at /programmes/alps/preview.jpg."),
        ("/programmes/nothing/programme.txt", "404 programme: no programme is named \"nothing\""),
    ] {
        assert_eq!(client.get(path).await.problem(), expected, "{path}");
    }
    assert_eq!(client.app.evaluations(), 0);
    let patched = client.send(Method::PATCH, "/programmes/alps", &[], "").await;
    assert_eq!((patched.status, patched.header("allow")), (StatusCode::METHOD_NOT_ALLOWED, "GET,HEAD,PUT,DELETE"));
}

#[tokio::test]
async fn only_the_own_machine_and_the_own_pages_write() {
    let client = Client::new().await;
    for headers in [&[("sec-fetch-site", "cross-site")][..], &[("host", "evil.example:8080")], &[("x-forwarded-for", "203.0.113.5")]] {
        for (method, path) in [(Method::PUT, "/programmes/alps"), (Method::POST, "/programmes"), (Method::DELETE, "/programmes/alps")] {
            assert_eq!(client.send(method, path, headers, MINE).await.status, StatusCode::FORBIDDEN, "{path} {headers:?}");
        }
    }
    let client = Client::with(|config| config.server.listen = ([0, 0, 0, 0], 8080).into()).await;
    assert!(
        client
            .put("/programmes/mine", MINE)
            .await
            .problem()
            .starts_with("403 Without keys, worlds and programmes are written on the server's own machine alone")
    );
    assert_eq!(client.get("/programmes/alps/preview.png?size=64").await.status, StatusCode::OK);
}

#[tokio::test]
async fn a_long_library_is_listed_in_part_and_counted_in_full() {
    let client = Client::new().await;
    let write = async |i: u64| client.put(&format!("/programmes/p{i}"), &format!(r#"{{"seed":{i},"tags":["many"],"programme":"x"}}"#)).await;
    for i in 0..1001 {
        assert_eq!(write(i).await.status, StatusCode::CREATED);
    }
    let list = client.get("/programmes?tag=many").await.json();
    assert_eq!((&list["found"], list["programmes"].as_array().unwrap().len()), (&json!(1001), 1000));
}
