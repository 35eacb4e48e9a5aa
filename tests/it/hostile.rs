//! Connections that mean no good: all are closed, and others are served meanwhile.

use crate::process::Server;
use std::{
    io::{ErrorKind, Read, Write},
    net::TcpStream,
    time::{Duration, Instant},
};

/// So many of each kind; `TERRANE_HOSTILE` says otherwise.
fn count() -> usize {
    std::env::var("TERRANE_HOSTILE").map_or(40, |text| text.parse().expect("TERRANE_HOSTILE is a number"))
}

/// What is sent at once, and what is sent again and again.
const KINDS: [(&str, &str, &str); 5] = [
    ("silent", "", ""),
    ("one byte", "G", ""),
    ("partial head", "GET / HTTP/1.1\r\nHost: ", ""),
    ("slow head", "GET / HTTP/1.1\r\nHost: a\r\nX: ", "x"),
    ("slow body", "POST /worlds HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000\r\n\r\n{", " "),
];

/// Whether the server has closed a connection; what it answers is passed over.
fn is_closed(stream: &mut TcpStream) -> bool {
    let mut buffer = [0; 1024];
    loop {
        match stream.read(&mut buffer) {
            Ok(0) => return true,
            Ok(_) => {}
            Err(error) => return error.kind() != ErrorKind::WouldBlock,
        }
    }
}

fn server(folder: &tempfile::TempDir) -> Server {
    Server::start_with(&folder.path().join("data"), &[("TERRANE_LIMITS__HEAD_SECONDS", "1"), ("TERRANE_LIMITS__STALL_SECONDS", "1")])
}

#[test]
fn connections_that_send_too_little_are_closed() {
    let folder = tempfile::tempdir().unwrap();
    let server = server(&folder);
    let mut open: Vec<(&str, &str, TcpStream)> = Vec::new();
    for (name, first, again) in KINDS {
        for _ in 0..count() {
            let mut stream = TcpStream::connect(&server.address).unwrap();
            stream.write_all(first.as_bytes()).unwrap();
            stream.set_nonblocking(true).unwrap();
            open.push((name, again, stream));
        }
    }
    // An idle connection that was used is closed, too.
    let mut idle = TcpStream::connect(&server.address).unwrap();
    idle.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    idle.set_nonblocking(true).unwrap();
    open.push(("idle", "", idle));
    let start = Instant::now();
    while !open.is_empty() {
        server.get("/healthz");
        let names: Vec<&str> = open.iter().map(|(name, ..)| *name).collect();
        assert!(start.elapsed() < Duration::from_mins(1), "still open: {names:?}");
        std::thread::sleep(Duration::from_millis(50));
        open.retain_mut(|(_, again, stream)| stream.write_all(again.as_bytes()).is_ok() && !is_closed(stream));
    }
}

#[test]
fn connections_that_take_nothing_are_closed() {
    const REQUESTS: usize = 40;
    let folder = tempfile::tempdir().unwrap();
    let server = server(&folder);
    let request = "GET /worlds/hills/web/r32/9/255/255@1025.bin HTTP/1.1\r\nHost: localhost\r\n\r\n";
    let mut streams: Vec<TcpStream> = (0..4).map(|_| TcpStream::connect(&server.address).unwrap()).collect();
    for stream in &mut streams {
        stream.write_all(request.repeat(REQUESTS).as_bytes()).unwrap();
    }
    // One that begins to read only when it has been given up gets what the system had taken already.
    for mut stream in streams {
        std::thread::sleep(Duration::from_secs(3));
        let mut all = Vec::new();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        let ended = stream.read_to_end(&mut all);
        assert!(ended.as_ref().err().is_none_or(|error| error.kind() == ErrorKind::ConnectionReset), "{ended:?}");
        assert!(all.len() > 1024 && all.len() < REQUESTS * 1025 * 1025 * 4, "{}", all.len());
        server.get("/healthz");
    }
}
