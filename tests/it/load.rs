//! More work than the server can do.
#![expect(clippy::print_stdout, reason = "long runs print what they measured")]

use crate::process::Server;
use std::{
    cell::{Cell, RefCell},
    io::{Read, Write},
    net::TcpStream,
    rc::Rc,
    time::{Duration, Instant},
};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

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
    let made = || metric(&server, "terrane_evaluations_total{tileset=\"r32\",source=\"programme\"}");
    // Of very many some would wait even longer than that.
    let refused = || metric(&server, "terrane_refusals_total{reason=\"queue\"}");
    wait_for("they are there", || (there() + made() + refused()) as usize >= leavers());
    let before = made();
    drop(streams);
    let took = wait_for("what they wanted is given up", || there() == 0);
    println!("{} clients left: idle after {:.0} ms", leavers(), took.as_secs_f64() * 1e3);
    let after = made();
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

/// Ten times as many tiles as the server can make, asked for whether or not earlier ones were answered. Server and clients have a core each. Tiles of one world take
/// a millisecond or two, so that refusals by the thousand take their share of the core; those of the other take ten times as long.
#[test]
#[ignore = "a measurement: it takes a minute and both cores"]
fn an_overloaded_server_goes_on_serving() {
    for world in ["alps", "eq2"] {
        overload(world);
    }
}

fn overload(world: &'static str) {
    const SECONDS: u64 = 10;
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start_with(&folder.path().join("data"), &[("TERRANE_SERVER__THREADS", "1")]);
    pin(server.child.id(), 0);
    pin(std::process::id(), 1);
    let pool = Pool { address: server.address.clone(), world, idle: RefCell::default(), tiles: Cell::new(0) };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let local = tokio::task::LocalSet::new();
    local.block_on(&runtime, async {
        let pool = Rc::new(pool);
        let mut alone = Vec::new();
        for _ in 0..300 {
            alone.push(pool.tile().await.1);
        }
        let begun = Instant::now();
        let clients = (0..8).map(|_| {
            let pool = Rc::clone(&pool);
            tokio::task::spawn_local(async move {
                let mut served = 0;
                while begun.elapsed() < Duration::from_secs(SECONDS) {
                    served += u64::from(pool.tile().await.0 == 200);
                }
                served
            })
        });
        let clients: Vec<_> = clients.collect();
        let mut served = 0;
        for client in clients {
            served += client.await.unwrap();
        }
        let capacity = served as f64 / begun.elapsed().as_secs_f64();

        let (begun, mut asked, mut answers) = (Instant::now(), 0, Vec::new());
        let health = tokio::task::spawn_local({
            let pool = Rc::clone(&pool);
            async move {
                let mut times = Vec::new();
                while begun.elapsed() < Duration::from_secs(SECONDS) {
                    times.push(pool.ask("/healthz").await.1);
                    tokio::time::sleep(Duration::from_millis(20)).await;
                }
                times
            }
        });
        while begun.elapsed() < Duration::from_secs(SECONDS) {
            let due = (begun.elapsed().as_secs_f64() * 10.0 * capacity) as u64;
            for _ in asked..due {
                let pool = Rc::clone(&pool);
                answers.push(tokio::task::spawn_local(async move { pool.tile().await }));
            }
            asked = due;
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        let (mut accepted, mut refused) = (Vec::new(), Vec::new());
        for answer in answers {
            let (status, took) = answer.await.unwrap();
            if status == 200 { accepted.push(took) } else { refused.push(took) }
        }
        let goodput = accepted.len() as f64 / begun.elapsed().as_secs_f64();
        println!("{world}: capacity {capacity:.0} tiles/s, alone p99 {:.1} ms", p99(&mut alone));
        println!("asked {:.0}/s: goodput {goodput:.0} tiles/s ({:.0} %)", asked as f64 / SECONDS as f64, 100.0 * goodput / capacity);
        println!("p99 of {} accepted {:.0} ms, of {} refused {:.0} ms", accepted.len(), p99(&mut accepted), refused.len(), p99(&mut refused));
        println!("/healthz p99 {:.1} ms", p99(&mut health.await.unwrap()));
        assert!(!refused.is_empty());
    });
}

fn p99(times: &mut [Duration]) -> f64 {
    times.sort_unstable();
    times.get(times.len() * 99 / 100).map_or(0.0, |time| time.as_secs_f64() * 1e3)
}

/// Gives a process and all its threads one core.
fn pin(process: u32, core: u8) {
    let pinned = std::process::Command::new("taskset").args(["-a", "-c", "-p", &core.to_string(), &process.to_string()]).output();
    println!("core {core}: {}", pinned.map_or_else(|error| error.to_string(), |output| output.status.to_string()));
}

/// Connections that are kept, and tiles that nobody has asked for.
struct Pool {
    address: String,
    world: &'static str,
    idle: RefCell<Vec<tokio::net::TcpStream>>,
    tiles: Cell<u64>,
}

impl Pool {
    async fn tile(&self) -> (u16, Duration) {
        let n = self.tiles.replace(self.tiles.get() + 1);
        self.ask(&format!("/worlds/{}/web/terrarium/14/{}/{}.png", self.world, 4000 + n % 8000, 4000 + n / 8000)).await
    }

    /// Status of an answer, and the time until its last byte.
    async fn ask(&self, path: &str) -> (u16, Duration) {
        let begun = Instant::now();
        let idle = self.idle.borrow_mut().pop();
        let mut stream = match idle {
            Some(stream) => stream,
            None => tokio::net::TcpStream::connect(&self.address).await.unwrap(),
        };
        stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).await.unwrap();
        let mut buffer = Vec::with_capacity(1 << 16);
        let end = loop {
            assert!(stream.read_buf(&mut buffer).await.unwrap() > 0, "the server closed the connection");
            if let Some(end) = buffer.windows(4).position(|window| window == b"\r\n\r\n") {
                break end + 4;
            }
        };
        let head = String::from_utf8_lossy(&buffer[..end]).to_lowercase();
        let length: usize = head.split("content-length: ").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        while buffer.len() < end + length {
            stream.read_buf(&mut buffer).await.unwrap();
        }
        self.idle.borrow_mut().push(stream);
        (head[9..12].parse().unwrap(), begun.elapsed())
    }
}
