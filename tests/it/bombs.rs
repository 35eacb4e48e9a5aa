//! Bodies that would cost much more than they are: an error soon, and little memory.
#![expect(clippy::print_stdout, reason = "long runs print what they measured")]

use crate::process::{Server, text};
use std::{fmt::Write as _, fs, io::Write as _, time::Instant};

/// Bytes that a server may take beyond what it has while it refuses one body.
const MOST_BYTES: u64 = 32 << 20;

/// A number of kilobytes that the system tells of a process, as bytes.
fn told(server: &Server, name: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", server.child.id())).unwrap();
    let line = status.lines().find(|line| line.starts_with(name)).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

/// What the peak of the memory of a server was beyond what it had before.
fn growth(server: &Server, mut act: impl FnMut()) -> u64 {
    // Makes the peak what is in use now.
    fs::write(format!("/proc/{}/clear_refs", server.child.id()), "5").unwrap();
    let before = told(server, "VmRSS:");
    act();
    told(server, "VmHWM:").saturating_sub(before)
}

/// An array in an array in an array …
fn nested(depth: usize) -> String {
    "[".repeat(depth) + &"]".repeat(depth)
}

/// A programme of a number of nodes, as text.
fn programme(nodes: usize) -> String {
    let mut text = "x".to_owned();
    for _ in 0..nodes / 2 {
        text.push_str("+x");
    }
    text
}

fn world(programme: &str) -> String {
    format!(r#"{{"seed": 1, "base": {{"programme": "{programme}", "scale": 1}}}}"#)
}

fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn bombs_are_refused_soon_and_with_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&folder.path().join("data"));
    let host = format!("Host: {}", server.address);
    let mut wide = String::from("{");
    (0..80_000).for_each(|i| write!(wide, "\"k{i}\": 0,").unwrap());
    wide.push_str("\"seed\": 1}");
    let point = r#"{"type":"Feature","properties":{"kind":"point","elevation":1},"geometry":{"type":"Point","coordinates":[0,0]}}"#;
    let shallow = format!("[{}]", "[0,0],".repeat(150_000) + "[0,0]");
    let longer = format!("{host}\r\nContent-Encoding: gzip");
    let bombs = [
        ("gzip", "PUT", "/worlds/a", &longer, zipped(&vec![b' '; 1 << 24]), 415),
        ("gzip of features", "POST", "/worlds/hills/features", &longer, "x".repeat(1000).into_bytes(), 415),
        ("deep world", "PUT", "/worlds/a", &host, nested(500_000).into_bytes(), 422),
        ("deep layers", "PUT", "/worlds/a", &host, format!(r#"{{"seed": 1, "layers": {}}}"#, nested(500_000)).into_bytes(), 422),
        ("deep features", "POST", "/worlds/hills/features", &host, nested(5_000_000).into_bytes(), 422),
        ("deep points", "POST", "/worlds/hills/elevation", &host, format!(r#"{{"points": {}}}"#, nested(500_000)).into_bytes(), 400),
        ("wide world", "PUT", "/worlds/a", &host, wide.clone().into_bytes(), 422),
        ("wide points", "POST", "/worlds/hills/elevation", &host, format!(r#"{{"points": {shallow}}}"#).into_bytes(), 400),
        ("wide properties", "POST", "/worlds/hills/features", &host, point.replace(r#""kind":"point""#, &format!("\"a\":{wide}")).into_bytes(), 422),
        ("programme of a million nodes", "PUT", "/worlds/a", &host, world(&programme(1_000_000)).into_bytes(), 422),
        ("programme of a million nodes, saved", "PUT", "/programmes/a", &host, format!(r#"{{"programme": "{}"}}"#, programme(1_000_000)).into_bytes(), 422),
        ("brackets", "PUT", "/worlds/a", &host, world(&"(".repeat(900_000)).into_bytes(), 422),
        ("functions", "PUT", "/worlds/a", &host, world(&"sin(".repeat(200_000)).into_bytes(), 422),
        ("long number", "PUT", "/worlds/a", &host, format!(r#"{{"seed": {}}}"#, "9".repeat(1_000_000)).into_bytes(), 422),
        ("long name", "PUT", "/worlds/a", &host, format!(r#"{{"seed": 1, "title": "{}"}}"#, "a".repeat(1_000_000)).into_bytes(), 422),
        ("over the limit", "PUT", "/worlds/a", &host, "[".repeat(3 << 20).into_bytes(), 413),
    ];
    for (name, method, path, headers, body, expected) in bombs {
        let mut answer = (0, Vec::new());
        let start = Instant::now();
        let grown = growth(&server, || answer = server.request_with(method, path, headers, &body).unwrap());
        println!("{name}: {} bytes, {:?}, {:.1} MB", body.len(), start.elapsed(), grown as f64 / 1e6);
        assert_eq!(answer.0, expected, "{name}: {}", text(&answer.1[..answer.1.len().min(500)]));
        assert!(text(&answer.1).starts_with("{\"type\":\"urn:terrane:") && answer.1.len() < 200_000, "{name}: {}", text(&answer.1[..answer.1.len().min(500)]));
        assert!(grown <= MOST_BYTES, "{name}: {grown} bytes more");
    }
    assert_eq!(server.request("GET", "/worlds/a", "").unwrap().0, 404, "nothing was stored");
}

/// Features over the limit: those that say so are not read at all, others are until there are too many.
#[test]
fn features_that_are_too_many_bytes_are_refused_before_they_come() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&folder.path().join("data"));
    let mut stream = std::net::TcpStream::connect(&server.address).unwrap();
    let start = Instant::now();
    let grown = growth(&server, || {
        write!(stream, "POST /worlds/hills/features HTTP/1.1\r\nHost: {}\r\nContent-Length: 600000000\r\n\r\n", server.address).unwrap();
        let mut answer = [0; 12];
        std::io::Read::read_exact(&mut stream, &mut answer).unwrap();
        assert_eq!(&answer, b"HTTP/1.1 413");
    });
    println!("said to be over the limit: {:?}, {:.1} MB", start.elapsed(), grown as f64 / 1e6);
    assert!(grown <= MOST_BYTES, "{grown} bytes more");
}
