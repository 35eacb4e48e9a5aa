//! More work than the server can do.
#![expect(clippy::print_stdout, reason = "long runs print what they measured")]

use crate::process::Server;
use std::{
    io::{Read, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

/// Clients that leave; `TERRANE_LEAVERS` says otherwise.
fn leavers() -> usize {
    std::env::var("TERRANE_LEAVERS").map_or(100, |text| text.parse().expect("TERRANE_LEAVERS is a number"))
}

/// The value of a metric without labels, or with those given.
fn metric(server: &Server, name: &str) -> u64 {
    let text = String::from_utf8(server.get("/metrics")).unwrap();
    text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')).map_or(0, |value| value.parse().unwrap())
}

fn put(server: &Server, name: &str, world: &str) {
    let (status, body) = server.request("PUT", &format!("/worlds/{name}"), world).unwrap();
    assert_eq!(status, 201, "{}", String::from_utf8_lossy(&body));
}

fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) -> Duration {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_mins(1), "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
    start.elapsed()
}

/// Each wants a tile that takes seconds; when they go, nothing is evaluated for them any more.
#[test]
fn what_clients_wanted_that_left_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let patient = [("TERRANE_LIMITS__QUEUE_MS", "600000"), ("TERRANE_LIMITS__REQUESTS", "4096")];
    let server = Server::start_with(&folder.path().join("data"), &patient);
    put(&server, "valleys", r#"{"seed": 1, "base": {"programme": "erosion(fbm(1, 2, 8))", "scale": 1000}}"#);
    let connect = |x: usize| {
        let mut stream = TcpStream::connect(&server.address).unwrap();
        write!(stream, "GET /worlds/valleys/metric/r32/9/{x}/0@257.bin?filter=exact HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        stream
    };
    let streams: Vec<TcpStream> = (0..leavers()).map(connect).collect();
    let there = || metric(&server, "terrane_tiles_evaluating") + metric(&server, "terrane_tiles_waiting{class=\"visible\"}");
    wait_for("they are there", || there() as usize == leavers());
    let before = metric(&server, "terrane_evaluations_total{tileset=\"r32\",source=\"programme\"}");
    drop(streams);
    let took = wait_for("what they wanted is given up", || there() == 0);
    println!("{} clients left: idle after {:.0} ms", leavers(), took.as_secs_f64() * 1e3);
    let after = metric(&server, "terrane_evaluations_total{tileset=\"r32\",source=\"programme\"}");
    let given_up = |state: &str| metric(&server, &format!("terrane_cancellations_total{{state=\"{state}\"}}"));
    assert!(given_up("running") > 0 && given_up("waiting") > 0, "{} and {}", given_up("running"), given_up("waiting"));
    assert!(after - before <= 2, "those that were nearly done: {before}, {after}");
}

/// A page of a map: three sources of 60 tiles each over six connections, four such pages at once. Nothing is refused.
#[test]
fn ordinary_pages_are_never_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start_with(&folder.path().join("data"), &[("TERRANE_LIMITS__QUEUE_MS", "1")]);
    let connection = |page: usize, number: usize| {
        let address = server.address.clone();
        std::thread::spawn(move || {
            let mut stream = TcpStream::connect(&address).unwrap();
            for tile in (number..60).step_by(2) {
                let tileset = ["terrarium", "hillshade", "relief"][number / 2];
                let path = format!("/worlds/mesas/web/{tileset}/12/{}/{}.png", 2048 + page * 10 + tile % 10, 2048 + tile / 10);
                write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
                assert_eq!(answer(&mut stream), 200, "{path}");
            }
        })
    };
    let all: Vec<_> = (0..24).map(|i| connection(i / 6, i % 6)).collect();
    for connection in all {
        connection.join().unwrap();
    }
    assert_eq!(metric(&server, "terrane_refusals_total{reason=\"queue\"}"), 0);
}

/// The status of an answer, whose body is read and passed over.
fn answer(stream: &mut TcpStream) -> u16 {
    let (mut head, mut byte) = (Vec::new(), [0]);
    while !head.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte).unwrap();
        head.push(byte[0]);
    }
    let head = String::from_utf8(head).unwrap().to_lowercase();
    let length: usize = head.split("content-length: ").nth(1).and_then(|rest| rest.lines().next()).map_or(0, |length| length.parse().unwrap());
    let mut body = vec![0; length];
    stream.read_exact(&mut body).unwrap();
    head.split(' ').nth(1).unwrap().parse().unwrap()
}
