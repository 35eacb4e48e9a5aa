//! Over loopback: milliseconds of a 256-pixel tile cold and warm, and requests a second for a cached tile beside a handler of the same route that returns the
//! same bytes with the same headers and does nothing else. Rounds alternate, so that drift of the machine falls on both.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark says what is wrong by failing, and prints what it measured")]

use axum::{
    Router, ServiceExt,
    body::Bytes,
    extract::Request,
    http::header,
    response::{IntoResponse, Response},
    routing::get,
};
use std::convert::Infallible;
use std::time::{Duration, Instant};
use terrane::server::{App, Config, Front};
use tokio::{
    io::{AsyncReadExt, AsyncWriteExt},
    net::{TcpListener, TcpStream},
};
use tower::Service;

const CONNECTIONS: usize = 16;
const ROUNDS: usize = 7;
const ROUND: Duration = Duration::from_secs(2);
const TILE: &str = "/worlds/alps/web/terrarium/10/515/509.png";

async fn listen<S>(service: S) -> String
where
    S: Service<Request, Response = Response, Error = Infallible, Future: Send> + Clone + Send + 'static,
{
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    tokio::spawn(async { axum::serve(listener, service.into_make_service()).await });
    address
}

/// One request on a kept connection; the length of the answer's body.
async fn ask(stream: &mut TcpStream, path: &str, buffer: &mut Vec<u8>) -> usize {
    stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).await.unwrap();
    buffer.clear();
    loop {
        assert!(stream.read_buf(buffer).await.unwrap() > 0, "the server closed the connection");
        let Some(end) = buffer.windows(4).position(|window| window == b"\r\n\r\n") else { continue };
        let head = std::str::from_utf8(&buffer[..end]).unwrap();
        assert!(head.starts_with("HTTP/1.1 200"), "{head}");
        let length: usize = head.to_lowercase().split("content-length: ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        while buffer.len() < end + 4 + length {
            stream.read_buf(buffer).await.unwrap();
        }
        return length;
    }
}

/// Requests a second over a round.
async fn load(address: &str) -> f64 {
    let start = Instant::now();
    let workers = (0..CONNECTIONS).map(|_| {
        let address = address.to_owned();
        tokio::spawn(async move {
            let (mut stream, mut buffer, mut count) = (TcpStream::connect(address).await.unwrap(), Vec::new(), 0_u32);
            stream.set_nodelay(true).unwrap();
            while start.elapsed() < ROUND {
                ask(&mut stream, TILE, &mut buffer).await;
                count += 1;
            }
            count
        })
    });
    let mut total = 0;
    for worker in workers.collect::<Vec<_>>() {
        total += worker.await.unwrap();
    }
    f64::from(total) / start.elapsed().as_secs_f64()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

async fn latencies(address: &str) {
    let (mut stream, mut buffer) = (TcpStream::connect(address).await.unwrap(), Vec::new());
    stream.set_nodelay(true).unwrap();
    for world in ["alps", "archipelago", "dunes", "eq2", "hills", "mesas"] {
        let (mut cold, mut warm, mut bytes) = (Vec::new(), Vec::new(), 0);
        for x in 500..530 {
            let path = format!("/worlds/{world}/web/terrarium/10/{x}/509.png");
            for times in [&mut cold, &mut warm] {
                let start = Instant::now();
                bytes = ask(&mut stream, &path, &mut buffer).await;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        println!("256 tile of {world:12} cold {:6.2} ms, warm {:5.3} ms ({bytes} bytes)", median(&mut cold), median(&mut warm));
    }
}

/// Milliseconds of cold tiles of the example world that takes longest, none asked for twice, with some clients at a time.
async fn crowd(address: &str, clients: u32, row: u32) {
    const TILES: u32 = 480;
    let workers = (0..clients).map(|client| {
        let address = address.to_owned();
        tokio::spawn(async move {
            let (mut stream, mut buffer, mut times) = (TcpStream::connect(address).await.unwrap(), Vec::new(), Vec::new());
            stream.set_nodelay(true).unwrap();
            for i in 0..TILES / clients {
                let path = format!("/worlds/eq2/web/terrarium/11/{}/{}.png", 1000 + i, row + client);
                let start = Instant::now();
                ask(&mut stream, &path, &mut buffer).await;
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
            times
        })
    });
    let mut times = Vec::new();
    for worker in workers.collect::<Vec<_>>() {
        times.extend(worker.await.unwrap());
    }
    times.sort_by(f64::total_cmp);
    println!("cold tiles of eq2, {clients} clients: p50 {:.1} ms, p99 {:.1} ms", times[times.len() / 2], times[times.len() * 99 / 100]);
}

#[tokio::main]
async fn main() {
    let folder = tempfile::tempdir().unwrap();
    let mut config = Config::default();
    config.server.data = folder.path().to_path_buf();
    let server = listen(Front::new(App::load(&config).await.unwrap())).await;
    latencies(&server).await;
    crowd(&server, 1, 900).await;
    crowd(&server, 16, 950).await;

    let (mut stream, mut tile) = (TcpStream::connect(&server).await.unwrap(), Vec::new());
    let length = ask(&mut stream, TILE, &mut tile).await;
    let body = Bytes::from(tile.split_off(tile.len() - length));
    let headers = [(header::CONTENT_TYPE, "image/png"), (header::ETAG, "\"0123456789abcdef0123456789abcdef\""), (header::CACHE_CONTROL, "no-cache")];
    let fixed = move || async move { (headers, body).into_response() };
    let fixed = listen(Router::new().route("/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}", get(fixed))).await;

    let (mut cached, mut plain) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        cached.push(load(&server).await);
        plain.push(load(&fixed).await);
    }
    let (cached, plain) = (median(&mut cached), median(&mut plain));
    println!("cached tile of {length} bytes: {cached:.0} requests/s, the same bytes from a bare handler: {plain:.0} requests/s, ratio {:.2}", cached / plain);
}
