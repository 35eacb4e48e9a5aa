//! Keys: made beside a running server, asked for as soon as there is one.

use crate::process::{Server, run, text};
use serde_json::Value;
use std::{
    path::Path,
    time::{Duration, Instant},
};

const WORLD: &str = r#"{"seed": 1, "base": {"programme": "x", "scale": 1}}"#;

/// What `terrane key` prints.
fn key(data: &Path, arguments: &[&str]) -> String {
    let output = run(&[&["key"], arguments, &["--data", data.to_str().unwrap()]].concat(), Path::new("/"));
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    text(&output.stdout).trim().to_owned()
}

/// The status of a request from another machine with a key, or none, and the kind of its problem.
fn ask(server: &Server, method: &str, path: &str, key: Option<&str>) -> String {
    let host = "Host: maps.example.org".to_owned();
    let headers = key.map_or_else(|| host.clone(), |key| format!("{host}\r\nAuthorization: Bearer {key}"));
    let (status, body) = server.request_with(method, path, &headers, if method == "PUT" { WORLD } else { "" }).unwrap();
    let kind = serde_json::from_slice::<Value>(&body).ok().and_then(|problem| Some(problem.get("type")?.as_str()?.to_owned()));
    kind.map_or_else(|| status.to_string(), |kind| format!("{status} {}", kind.trim_start_matches("urn:terrane:")))
}

fn wait_for(mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(30), "it never became so");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn who_has_a_key_writes_from_anywhere_and_nobody_else() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let server = Server::start(&data);
    assert_eq!(ask(&server, "PUT", "/worlds/mine", None), "403 read-only");
    assert_eq!(server.request("PUT", "/worlds/mine", WORLD).unwrap().0, 201, "from this machine");
    let writer = key(&data, &["new", "a designer"]);
    let reader = key(&data, &["new", "a map", "--scope", "read"]);
    // Even from this machine, once the server has taken notice.
    wait_for(|| server.request("PUT", "/worlds/mine", WORLD).unwrap().0 == 401);
    wait_for(|| ask(&server, "PUT", "/worlds/mine", Some(&reader)) == "403 scope");
    assert_eq!(ask(&server, "PUT", "/worlds/mine", Some(&writer)), "200");
    assert_eq!(ask(&server, "PUT", "/worlds/mine", Some("terrane_0")), "401 unauthorized");
    assert_eq!(ask(&server, "GET", "/worlds/mine", None), "200", "reads are open");
    let list = key(&data, &["list"]);
    let lines: Vec<Vec<&str>> = list.lines().map(|line| line.split_whitespace().collect()).collect();
    assert!(lines.len() == 2 && lines[0][1] == "write" && lines[0][3..] == ["a", "designer"] && !list.contains(&writer), "{list}");
    let stored = std::fs::read(data.join("terrane.sqlite")).unwrap().into_iter().chain(std::fs::read(data.join("terrane.sqlite-wal")).unwrap());
    assert!(!text(&stored.collect::<Vec<_>>()).contains(&writer), "no secret is kept");
    key(&data, &["revoke", lines[0][0]]);
    wait_for(|| ask(&server, "PUT", "/worlds/mine", Some(&writer)) == "401 unauthorized");
    let gone = run(&["key", "revoke", lines[0][0], "--data", data.to_str().unwrap()], Path::new("/"));
    assert_eq!(text(&gone.stderr).trim(), format!("error: no key has the id {:?}; `terrane key list` shows them", lines[0][0]));
}

#[test]
fn reads_can_need_a_key_too() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let [reader, admin] = ["read", "admin"].map(|scope| key(&data, &["new", scope, "--scope", scope]));
    let server = Server::start_with(&data, &[("TERRANE_SERVER__READS", "keys")]);
    let tile = "/worlds/alps/web/terrarium/9/256/255.png";
    for (path, without, with_read) in [
        (tile, "401 unauthorized", "200"),
        ("/catalog", "401 unauthorized", "200"),
        ("/programmes", "401 unauthorized", "200"),
        ("/metrics", "401 unauthorized", "403 scope"),
        ("/healthz", "200", "200"),
        ("/openapi.json", "200", "200"),
        ("/", "200", "200"),
    ] {
        assert_eq!((ask(&server, "GET", path, None).as_str(), ask(&server, "GET", path, Some(&reader)).as_str()), (without, with_read), "{path}");
        assert_eq!(ask(&server, "GET", path, Some(&admin)), "200", "{path}");
    }
    assert_eq!(ask(&server, "PUT", "/worlds/mine", Some(&admin)), "201");
    let player = key(&data, &["new", "a game", "--scope", "play"]);
    wait_for(|| ask(&server, "GET", "/worlds/alps", Some(&player)) == "200");
    for (method, path, with_play, with_read) in [
        ("PUT", "/worlds/living/players/ann", "422 invalid-feedback", "403 scope"),
        ("POST", "/worlds/living/feedback", "400 bad-request", "403 scope"),
        ("DELETE", "/worlds/living/players/ann", "204", "403 scope"),
        ("PUT", "/worlds/living/generation", "403 scope", "403 scope"),
        ("PUT", "/worlds/living", "403 scope", "403 scope"),
        ("DELETE", "/worlds/living", "403 scope", "403 scope"),
    ] {
        assert_eq!(
            (ask(&server, method, path, Some(&player)).as_str(), ask(&server, method, path, Some(&reader)).as_str()),
            (with_play, with_read),
            "{method} {path}"
        );
        assert_eq!(ask(&server, method, path, None), "401 unauthorized");
    }
    let wrong = run(&["key", "new", "x", "--scope", "all", "--data", data.to_str().unwrap()], Path::new("/"));
    assert!(text(&wrong.stderr).contains("must be read, play, write or admin, got \"all\""), "{}", text(&wrong.stderr));
}

#[test]
fn a_signed_address_reads_one_world_without_a_key() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    key(&data, &["new", "a map", "--scope", "read"]);
    let id = key(&data, &["list"]).split_whitespace().next().unwrap().to_owned();
    let server = Server::start_with(&data, &[("TERRANE_SERVER__READS", "keys")]);
    let signed = key(&data, &["sign", &id, "alps"]);
    let style = text(&server.get(&format!("/worlds/alps/style.json?heights=fit&{signed}")));
    let style: Value = serde_json::from_str(&style).unwrap();
    let template = style["sources"]["terrain"]["tiles"][0].as_str().unwrap().to_owned();
    assert!(template.ends_with(&format!(".png?{signed}")), "{template}");
    let tile = template.replace("{z}/{x}/{y}", "9/256/255");
    let (_, path) = tile.split_once(&server.address).unwrap();
    assert_eq!(ask(&server, "GET", path, None), "200");
    let layer = text(&server.get(&format!("/worlds/alps/web/quantized-mesh/layer.json?surface=water&{signed}")));
    assert!(layer.contains(&format!(".terrain?surface=water&{signed}")), "{layer}");
    for (method, path, expected) in [
        ("GET", "/worlds/hills/style.json", "401 unauthorized"),
        ("GET", "/catalog", "401 unauthorized"),
        ("PUT", "/worlds/alps", "401 unauthorized"),
        ("GET", "/worlds/alps", "200"),
    ] {
        assert_eq!(ask(&server, method, &format!("{path}?{signed}"), None), expected, "{method} {path}");
    }
    let other = signed.replace("signature=", "signature=0");
    assert_eq!(ask(&server, "GET", &format!("/worlds/alps?{other}"), None), "401 unauthorized");
    let over = key(&data, &["sign", &id, "alps", "--hours", "0"]);
    let (_, body) = server.request("GET", &format!("/worlds/alps?{over}"), "").unwrap();
    assert!(text(&body).contains("The time for which the address was signed is over."), "{}", text(&body));
    key(&data, &["revoke", &id]);
    wait_for(|| ask(&server, "GET", &format!("/worlds/alps?{signed}"), None) == "401 unauthorized");
}
