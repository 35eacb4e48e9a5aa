//! What happens, told to those who listen.

use crate::process::Server;
use serde_json::{Value, json};
use std::{
    io::{BufRead, BufReader, Write},
    net::TcpStream,
    time::Duration,
};

/// A client that listens; every event is (id, kind, data).
struct Listener(BufReader<TcpStream>);

impl Listener {
    fn new(server: &Server, query: &str, last: Option<&str>) -> Self {
        let mut stream = TcpStream::connect(&server.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let last = last.map(|id| format!("Last-Event-ID: {id}\r\n")).unwrap_or_default();
        write!(stream, "GET /events{query} HTTP/1.1\r\nHost: {}\r\nAccept: text/event-stream\r\n{last}\r\n", server.address).unwrap();
        let mut listener = Self(BufReader::new(stream));
        let mut head = Vec::new();
        loop {
            let line = listener.line().unwrap();
            if line.is_empty() {
                break;
            }
            head.push(line.to_ascii_lowercase());
        }
        assert_eq!(head[0], "http/1.1 200 ok");
        for field in ["content-type: text/event-stream", "cache-control: no-store", "access-control-allow-origin: *"] {
            assert!(head.iter().any(|line| line == field), "{field}: {head:?}");
        }
        // From the first bytes on everything is heard.
        while !listener.line().unwrap().starts_with(": listening") {}
        listener
    }

    /// A line without its end; `None` at the end of all.
    fn line(&mut self) -> Option<String> {
        let mut line = String::new();
        (self.0.read_line(&mut line).unwrap() > 0).then(|| line.trim_end().to_owned())
    }

    fn next(&mut self) -> Option<(String, String, Value)> {
        let (mut id, mut kind, mut data) = (String::new(), String::new(), None);
        loop {
            let line = self.line()?;
            match line.split_once(": ") {
                Some(("id", value)) => value.clone_into(&mut id),
                Some(("event", value)) => value.clone_into(&mut kind),
                Some(("data", value)) => data = Some(serde_json::from_str(value).unwrap()),
                _ => {}
            }
            if line.is_empty()
                && let Some(data) = data.take()
            {
                return Some((id, kind, data));
            }
        }
    }
}

fn save(server: &Server, name: &str, seed: u64) -> String {
    let (status, body) = server.request("PUT", &format!("/worlds/{name}"), &json!({"seed": seed, "base": {"programme": "x", "scale": 1}}).to_string()).unwrap();
    assert!(status < 300, "{}", String::from_utf8_lossy(&body));
    let revisions: Value = serde_json::from_slice(&server.request("GET", &format!("/worlds/{name}/revisions"), "").unwrap().1).unwrap();
    revisions.as_array().unwrap().last().unwrap()["revision"].as_str().unwrap().to_owned()
}

#[test]
fn worlds_are_told_in_order_and_who_comes_back_misses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path());
    let (mut all, mut one) = (Listener::new(&server, "", None), Listener::new(&server, "?world=b", None));
    let first = save(&server, "a", 1);
    let second = save(&server, "b", 2);
    save(&server, "b", 2);
    let third = save(&server, "a", 3);
    assert_eq!(server.request("DELETE", "/worlds/b", "").unwrap().0, 204);
    let heard: Vec<_> = (0..4).map(|_| all.next().unwrap()).collect();
    let told: Vec<_> = heard.iter().map(|(_, kind, data)| (kind.as_str(), data.clone())).collect();
    let world = |name: &str, revision: Option<&str>| ("world", json!({"world": name, "revision": revision}));
    assert_eq!(told, [world("a", Some(&first)), world("b", Some(&second)), world("a", Some(&third)), world("b", None)], "what changes nothing is not told");
    assert_eq!((one.next().unwrap().2, one.next().unwrap().2), (world("b", Some(&second)).1, world("b", None).1));

    let mut again = Listener::new(&server, "", Some(&heard[1].0));
    assert_eq!(again.next().unwrap(), heard[2]);
    let mut stranger = Listener::new(&server, "", Some("00000000-7"));
    let (id, kind, data) = stranger.next().unwrap();
    assert_eq!((kind.as_str(), data), ("reset", json!({})));
    drop((stranger, again));
    let last = save(&server, "c", 4);
    let mut again = Listener::new(&server, "", Some(&id));
    assert_eq!(again.next().unwrap().2, world("c", Some(&last)).1);

    let (status, problem) = server.request("GET", "/events?wrold=a", "").unwrap();
    assert_eq!(status, 400, "{}", String::from_utf8_lossy(&problem));
    // A server that stops does not wait for those who listen.
    let (code, log) = server.stop();
    assert_eq!(code, Some(0));
    assert!(!log.iter().any(|line| line.contains("the drain time is over")), "{log:?}");
    while all.next().is_some() {}
}
