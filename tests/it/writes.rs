//! Writing worlds: conditions, errors, history.

use crate::client::{Answer, Client};
use axum::http::{Method, StatusCode};

fn world(seed: u64) -> String {
    format!(r#"{{"seed":{seed},"base":{{"programme":"fbm(1, 2, 8)","scale":20000}}}}"#)
}

async fn names(client: &Client) -> Vec<String> {
    client.get("/worlds").await.json()["worlds"].as_array().unwrap().iter().map(|world| world["name"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn what_get_gives_can_be_put_and_changes_nothing() {
    let client = Client::new().await;
    let created = client.put("/worlds/mine", &world(1)).await;
    assert_eq!((created.status, created.header("location")), (StatusCode::CREATED, "http://localhost:8080/worlds/mine"));
    let got = client.get("/worlds/mine").await;
    assert_eq!((got.header("etag"), &got.body), (created.header("etag"), &created.body));
    let text = String::from_utf8(got.body.to_vec()).unwrap();
    let again = client.put("/worlds/mine", &text).await;
    assert_eq!((again.status, again.header("etag"), &again.body), (StatusCode::OK, created.header("etag"), &got.body));
    assert_eq!(client.get("/worlds/mine/revisions").await.json().as_array().unwrap().len(), 1);
    let fresh = client.send(Method::GET, "/worlds/mine", &[("if-none-match", created.header("etag"))], "").await;
    assert_eq!(fresh.status, StatusCode::NOT_MODIFIED);
}

/// Members that may be left out, as `null` and left out: the same document, so the same revision.
#[tokio::test]
async fn null_means_left_out() {
    let client = Client::new().await;
    let layer = |extra: &str, layout: &str| {
        format!(r#"{{"seed":1,"base":{{"programme":"0","scale":1}},"layers":[{{"name":"a"{extra},"source":{{"layout":{{{layout}}}}}}}]}}"#)
    };
    let item = |generate: &str| layer("", &format!(r#""features":[{generate}]"#));
    let feature = |properties: &str, more: &str| {
        let geometry = r#""geometry":{"type":"Point","coordinates":[0,0,5]}"#;
        item(&format!(
            r#"{{"type":"Feature","id":"a","properties":{{"attributes":[{{"name":"elevation","value":5,"range":50}}]{properties}}},{geometry}{more}}}"#
        ))
    };
    let nulls = |names: &[&str]| names.iter().map(|name| format!(",\"{name}\":null")).collect::<String>();
    let cases = [
        (
            "worlds",
            world(1),
            world(1).replace("20000}", "20000,\"origin\":null,\"amplitude\":null,\"datum\":null}").replacen(
                '{',
                r#"{"title":null,"description":null,"attribution":null,"generator":null,"elevation":null,"sea_level":null,"layers":null,"#,
                1,
            ),
        ),
        ("worlds", world(1).replacen('{', r#"{"elevation":{},"#, 1), world(1).replacen('{', r#"{"elevation":{"min":null,"max":null},"#, 1)),
        ("worlds", feature("", ""), feature(&nulls(&["elevation", "radius", "detail", "along", "precedence"]), &nulls(&["bbox"]))),
        (
            "worlds",
            layer("", r#""features":[]"#),
            layer(&nulls(&["blend", "priority", "mask", "fade"]), &format!(r#""features":[]{}"#, nulls(&["attributes", "scatter", "mix", "base", "defaults"]))),
        ),
        (
            "worlds",
            item(r#"{"generate":"island"}"#),
            item(
                r#"{"generate":"island","seed":null,"styles":null,"landmass":{"radius":null,"elevation":null},"ridges":{"step":null},"rivers":null,"lakes":null}"#,
            ),
        ),
        (
            "programmes",
            r#"{"programme":"x"}"#.to_owned(),
            format!(
                r#"{{"programme":"x"{}}}"#,
                nulls(&["title", "description", "tags", "origin", "scale", "amplitude", "datum", "sea_level", "seed", "elevation"])
            ),
        ),
    ];
    for (number, (kind, without, with)) in cases.into_iter().enumerate() {
        let revision = async |document: &str| {
            let answer = client.put(&format!("/{kind}/null-{number}"), document).await;
            assert!(answer.status.is_success(), "{document}: {}", answer.problem());
            answer.header("etag").to_owned()
        };
        assert_eq!(revision(&without).await, revision(&with).await, "{with}");
    }
    let point = async |more: &str| client.send(Method::POST, "/worlds/hills/elevation", &[], format!(r#"{{"points":[[1,2]]{more}}}"#)).await;
    assert_eq!(point(&nulls(&["lonlats", "spacing"])).await.body, point("").await.body);
    let refused = client.put("/worlds/null", r#"{"seed":null,"base":{"programme":"x","scale":1}}"#).await;
    assert_eq!(refused.problem(), "422 /seed: expected a whole number 0 … 9007199254740991");
}

#[tokio::test]
async fn a_change_changes_plain_tiles_and_leaves_pinned_ones() {
    let client = Client::new().await;
    client.put("/worlds/mine", &world(1)).await;
    let old = client.get("/worlds/mine/revisions").await.json()[0]["revision"].as_str().unwrap().to_owned();
    let plain = "/worlds/mine/web/terrarium/9/255/255.png";
    let pinned = format!("/worlds/mine@{old}/web/terrarium/9/255/255.png");
    let before = client.get(plain).await;
    assert_eq!(client.get(&pinned).await.header("etag"), before.header("etag"));
    assert_eq!(client.put("/worlds/mine", &world(2)).await.status, StatusCode::OK);
    let after = client.get(plain).await;
    assert_ne!(after.header("etag"), before.header("etag"));
    assert_eq!(client.get(&pinned).await.body, before.body);
    let client = client.restart(|_| {}).await;
    assert_eq!((client.get(plain).await.body, client.get(&pinned).await.body), (after.body, before.body), "after a restart too");
    // Title and spelling are not terrain.
    let spelt = world(2).replace("fbm(1, 2, 8)", "fbm(1.0,2,octaves=8)").replace("\"seed\"", "\"title\":\"Mine\",\"seed\"");
    assert_eq!(client.put("/worlds/mine", &spelt).await.status, StatusCode::OK);
    assert_eq!(client.get(plain).await.header("etag"), after.headers["etag"]);
}

#[tokio::test]
async fn conditions_are_kept() {
    let client = Client::new().await;
    let send = async |headers: &[(&str, &str)], seed| client.send(Method::PUT, "/worlds/mine", headers, world(seed)).await;
    assert_eq!(send(&[("if-match", "*")], 1).await.status, StatusCode::PRECONDITION_FAILED);
    let first = send(&[("if-none-match", "*")], 1).await;
    assert_eq!(first.status, StatusCode::CREATED);
    assert_eq!(send(&[("if-none-match", "*")], 2).await.status, StatusCode::PRECONDITION_FAILED);
    let second = send(&[("if-match", first.header("etag"))], 2).await;
    assert_eq!(second.status, StatusCode::OK);
    let stale = send(&[("if-match", first.header("etag"))], 3).await;
    assert!(stale.problem().starts_with("412 the world is at revision "), "{}", stale.problem());
    for unreadable in [
        &[("if-match", "\"x\""), ("if-none-match", "*")][..],
        &[("if-match", "\"\u{e9}\"")],
        &[("if-match", "W/\"x\"")],
        &[("if-match", "")],
        &[("if-match", " , ")],
        &[("if-none-match", "")],
        &[("if-none-match", "\"x\"")],
    ] {
        assert_eq!(send(unreadable, 3).await.status, StatusCode::BAD_REQUEST, "{unreadable:?}");
    }
    assert_eq!(client.get("/worlds/mine").await.header("etag"), second.header("etag"));
}

#[tokio::test]
async fn worlds_are_posted_named_and_deleted() {
    let client = Client::new().await;
    let post = async |query: &str, body: String| client.send(Method::POST, &format!("/worlds{query}"), &[], body).await;
    let location = |answer: &Answer| (answer.status, answer.header("location").to_owned());
    assert_eq!(location(&post("?name=mine", world(1)).await), (StatusCode::CREATED, "http://localhost:8080/worlds/mine".to_owned()));
    assert_eq!(post("?name=mine", world(2)).await.problem(), "409 A world is already named \"mine\".");
    assert_eq!(post("?name=My%20World", world(2)).await.problem(), "400 name: a name is 1 to 63 of a … z, 0 … 9 and -, the first not -; got \"My World\"");
    let titled = world(3).replace("\"seed\"", "\"title\":\"The  Far: North!\",\"seed\"");
    assert_eq!(location(&post("", titled.clone()).await).1, "http://localhost:8080/worlds/the-far-north");
    for (seed, name) in [("4", "the-far-north-2"), ("4", "the-far-north-3")] {
        assert_eq!(location(&post("", titled.replace('3', seed)).await).1, format!("http://localhost:8080/worlds/{name}"));
    }
    assert!(location(&post("", world(5)).await).1.starts_with("http://localhost:8080/worlds/world-"));
    assert_eq!(client.send(Method::DELETE, "/worlds/mine", &[], "").await.status, StatusCode::NO_CONTENT);
    assert_eq!(client.send(Method::DELETE, "/worlds/mine", &[], "").await.status, StatusCode::NOT_FOUND);
    assert_eq!(client.get("/worlds/mine/web/r32/1/0/0.bin").await.status, StatusCode::NOT_FOUND);
    let client = client.restart(|_| {}).await;
    assert!(!names(&client).await.contains(&"mine".to_owned()));
}

#[tokio::test]
async fn wrong_documents_are_told_every_place_and_store_nothing() {
    let client = Client::new().await;
    let before = names(&client).await;
    let huge = format!("{{\"seed\":1,\"title\":\"{}\"}}", "x".repeat(10_000_000));
    let deep = format!(r#"{{"seed":1,"base":{{"programme":{},"scale":1}}}}"#, r#"{"op":"sin","args":["#.repeat(20_000));
    for (body, expected) in [
        ("", "400 The body is not JSON: EOF while parsing a value at line 1 column 0."),
        ("{\"seed\":1,", "400 The body is not JSON: EOF while parsing a value at line 1 column 10."),
        (
            r#"{"seed":1,"sea":2,"base":{"programme":"x","scale":1}}"#,
            "422 /sea: unknown field `sea`, expected one of `title`, `description`, `attribution`, `seed`, `generator`, `elevation`, `sea_level`, `base`, `layers`",
        ),
        (r#"{"seed":1,"base":{"programme":"plus(x, fmb(1, 2, 8))","scale":1}}"#, "422 /base/programme: unknown function \"fmb\" (did you mean \"fbm\"?)"),
        (
            r#"{"seed":1,"base":{"programme":"fbm(1, 2)","scale":1}}"#,
            "422 /base/programme: fbm lacks its argument \"octaves\": fbm(H, lacunarity, octaves, basis=o_perlin)",
        ),
        (r#"{"seed":1,"base":{"programme":"sin(x, y)","scale":1}}"#, "422 /base/programme: sin takes 1 argument, got 2: sin(a)"),
        (r#"{"seed":1,"base":{"programme":{"op":"sin","args":["z"]},"scale":1}}"#, "422 /base/programme/args/0: unknown name \"z\" (did you mean \"x\"?)"),
        (r#"{"seed":1,"base":{"programme":"x","scale":"1"}}"#, "422 /base/scale: invalid type: string \"1\", expected a number"),
        (
            r#"{"seed":9007199254740992,"base":{"programme":"x","scale":-1}}"#,
            "422 /seed: must be 0 … 2^53 - 1 = 9007199254740991, got 9007199254740992; /base/scale: must be more than 0 and at most 2^40 metres per programme unit, got -1",
        ),
        (huge.as_str(), "413 The body must be at most 1048576 bytes."),
        (deep.as_str(), "400 The body is not JSON: expected value at line 1 column 400031."),
    ] {
        assert_eq!(client.put("/worlds/new", body).await.problem(), expected);
    }
    let in_text = client.put("/worlds/new", r#"{"seed":1,"base":{"programme":"plus(x, fmb(1, 2, 8))","scale":1}}"#).await.json();
    assert_eq!((&in_text["errors"][0]["at"], &in_text["errors"][0]["start"], &in_text["errors"][0]["end"]), (&"/args/1".into(), &8.into(), &11.into()));
    assert_eq!(client.put("/worlds/New", &world(1)).await.status, StatusCode::BAD_REQUEST);
    assert_eq!(client.put("/worlds/-new", &world(1)).await.status, StatusCode::BAD_REQUEST);
    assert_eq!(names(&client).await, before);
    let client = client.restart(|_| {}).await;
    assert_eq!(names(&client).await, before);
}

#[tokio::test]
async fn only_the_own_machine_and_the_own_pages_write() {
    let client = Client::new().await;
    for (headers, allowed) in [
        (&[][..], true),
        (&[("sec-fetch-site", "same-origin"), ("origin", "http://localhost:8080")], true),
        (&[("sec-fetch-site", "none")], true),
        (&[("host", "127.0.0.1:99")], true),
        (&[("host", "[::1]:99")], true),
        (&[("sec-fetch-site", "cross-site")], false),
        (&[("sec-fetch-site", "same-site")], false),
        (&[("origin", "http://evil.example")], false),
        (&[("origin", "null")], false),
        // A stranger's name that resolves to this machine, and the page that it served.
        (&[("host", "evil.example:8080"), ("origin", "http://evil.example:8080")], false),
        (&[("host", "evil.example:8080"), ("sec-fetch-site", "same-origin")], false),
        (&[("x-forwarded-for", "203.0.113.5")], false),
        (&[("forwarded", "for=203.0.113.5")], false),
    ] {
        let answer = client.send(Method::PUT, "/worlds/mine", headers, world(1)).await;
        assert_eq!(answer.status.is_success(), allowed, "{headers:?}: {}", answer.status);
        assert!(allowed || answer.status == StatusCode::FORBIDDEN);
    }
    let read = client.send(Method::GET, "/worlds/mine", &[("sec-fetch-site", "cross-site"), ("host", "evil.example")], "").await;
    assert_eq!(read.status, StatusCode::OK);
}

#[tokio::test]
async fn a_server_that_others_reach_only_reads() {
    for change in [(|config| config.server.listen = ([0, 0, 0, 0], 8080).into()) as fn(&mut terrane::server::Config), |config| {
        config.server.public_url = "https://maps.example.org".to_owned();
    }] {
        let client = Client::with(change).await;
        assert!(
            client
                .put("/worlds/mine", &world(1))
                .await
                .problem()
                .starts_with("403 Without keys, worlds and programmes are written on the server's own machine alone")
        );
        assert_eq!(client.send(Method::DELETE, "/worlds/alps", &[], "").await.status, StatusCode::FORBIDDEN);
        assert_eq!(client.get("/worlds/alps").await.status, StatusCode::OK);
    }
}

#[tokio::test]
async fn what_was_put_comes_back_to_the_last_bit() {
    let client = Client::new().await;
    for i in 0..200_u64 {
        let number = |salt: u64, below: f64| (terrane::noise::mix(i * 8 + salt) as f64 / u64::MAX as f64) * below;
        let (scale, amplitude, x, datum) = (number(1, 1e9) + 1e-9, number(2, 1e6), number(3, 1e12), -number(4, 1e3));
        let body = format!(
            r#"{{"seed":{i},"base":{{"programme":"multiply({x:e}, x)","scale":{scale:e},"amplitude":{amplitude:e},"origin":[{x:e},0],"datum":{datum:e}}}}}"#
        );
        let put = client.put("/worlds/mine", &body).await;
        assert!(put.status.is_success(), "{}", put.problem());
        let again = client.put("/worlds/mine", std::str::from_utf8(&put.body).unwrap()).await;
        assert_eq!((again.header("etag"), &again.body), (put.header("etag"), &put.body));
        let base = put.json()["base"].clone();
        assert_eq!((base["scale"].as_f64(), base["amplitude"].as_f64(), base["origin"][0].as_f64()), (Some(scale), Some(amplitude), Some(x)));
    }
}

#[tokio::test]
async fn concurrent_writes_leave_memory_and_disk_alike() {
    let client = Client::new().await;
    let bodies: Vec<_> = (0..40).map(world).collect();
    let answers = futures_util::future::join_all(bodies.iter().map(|body| client.put("/worlds/mine", body))).await;
    assert!(answers.iter().all(|answer| answer.status.is_success()));
    let head = client.get("/worlds/mine").await.header("etag").to_owned();
    assert_eq!(client.get("/worlds/mine/revisions").await.json().as_array().unwrap().len(), 40);
    let client = client.restart(|_| {}).await;
    assert_eq!(client.get("/worlds/mine").await.header("etag"), head);
}
