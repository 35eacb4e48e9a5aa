//! A game without a picture: somebody walks through ground that evolves, and checks what is promised to those who walk.
//!
//! ```sh
//! cargo run --example adaptive -- 127.0.0.1:8080 living
//! ```
//!
//! It follows the server's events, tells it where it goes, asks for the next generation of the ground ahead again and again, and compares the tiles of each generation with those of the
//! one before: within the promised distance of its way not a bit may differ. Plain sockets and HTTP/1.0, so that everything that goes over the wire can be read here.

use serde_json::{Value, json};
use std::{
    error::Error,
    fmt,
    io::{self, BufRead, BufReader, Read, Write},
    net::TcpStream,
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

/// What ends the walk.
type Failure = Box<dyn Error + Send + Sync>;

/// Plane metres, east and north.
type Point = [f64; 2];

/// The player's name in the world.
const PLAYER: &str = "example-walker";

/// Metres between the positions that are told.
const STEP: f64 = 5.0;

/// Tiles of the `metric` grid: 256 m at level 17, 65 × 65 samples 4 m apart, both edges in it.
const LEVEL: i32 = 17;
const SIDE: usize = 65;
const TILE_METRES: f64 = 256.0;
const SPACING: f64 = TILE_METRES / (SIDE - 1) as f64;

/// How long an event may take to come.
const PATIENCE: Duration = Duration::from_secs(20);

/// A server by its address, and one of its worlds.
struct World<'a> {
    address: &'a str,
    name: &'a str,
}

/// An answer that is not what was asked for.
#[derive(Debug)]
struct Refused {
    what: String,
    status: u16,
    body: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} was answered with {}: {}", self.what, self.status, self.body)
    }
}

impl Error for Refused {}

impl World<'_> {
    fn send(&self, method: &str, path: &str, body: &str) -> io::Result<BufReader<TcpStream>> {
        let mut stream = TcpStream::connect(self.address)?;
        stream.set_nodelay(true)?;
        let (address, length) = (self.address, body.len());
        write!(stream, "{method} {path} HTTP/1.0\r\nHost: {address}\r\nContent-Length: {length}\r\n\r\n{body}")?;
        Ok(BufReader::new(stream))
    }

    /// The body of an answer below the world's address.
    fn ask(&self, method: &str, path: &str, body: &Value) -> Result<Vec<u8>, Failure> {
        let path = format!("/worlds/{}{path}", self.name);
        let body = if body.is_null() { String::new() } else { body.to_string() };
        let mut answer = self.send(method, &path, &body)?;
        let status = status(&mut answer)?;
        let mut bytes = Vec::new();
        answer.read_to_end(&mut bytes)?;
        if (200..300).contains(&status) {
            return Ok(bytes);
        }
        Err(Refused { what: format!("{method} {path}"), status, body: String::from_utf8_lossy(&bytes).into_owned() }.into())
    }

    fn json(&self, method: &str, path: &str, body: &Value) -> Result<Value, Failure> {
        Ok(serde_json::from_slice(&self.ask(method, path, body)?)?)
    }

    /// Heights of a tile of one revision, row by row from the north.
    fn tile(&self, revision: &str, [x, y]: [i64; 2]) -> Result<Vec<f32>, Failure> {
        let bytes = self.ask("GET", &format!("@{revision}/metric/r32/{LEVEL}/{x}/{y}@{SIDE}.bin"), &Value::Null)?;
        let heights: Vec<f32> = bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        if heights.len() == SIDE * SIDE { Ok(heights) } else { Err(format!("tile {x}, {y} has {} samples", heights.len()).into()) }
    }

    /// The world's generations from now on, as they are bred by anybody.
    fn listen(&self) -> Result<Receiver<(Instant, Value)>, Failure> {
        let mut answer = self.send("GET", &format!("/events?world={}", self.name), "")?;
        let status = status(&mut answer)?;
        if status != 200 {
            return Err(format!("the events were answered with {status}").into());
        }
        let (tell, heard) = channel();
        thread::spawn(move || {
            let (mut kind, mut data) = (String::new(), String::new());
            for line in answer.lines().map_while(Result::ok) {
                match line.split_once(": ") {
                    Some(("event", word)) => word.clone_into(&mut kind),
                    Some(("data", text)) => data.push_str(text),
                    _ if line.is_empty() => {
                        // An empty line ends an event.
                        let event = serde_json::from_str(&std::mem::take(&mut data)).unwrap_or_default();
                        if std::mem::take(&mut kind) == "generation" && tell.send((Instant::now(), event)).is_err() {
                            return;
                        }
                    }
                    _ => {}
                }
            }
        });
        Ok(heard)
    }
}

/// The status of an answer, whose body comes next.
fn status(answer: &mut impl BufRead) -> Result<u16, Failure> {
    let mut line = String::new();
    answer.read_line(&mut line)?;
    let status = line.split(' ').nth(1).and_then(|status| status.parse().ok()).ok_or("no HTTP")?;
    while !line.trim_end().is_empty() {
        line.clear();
        answer.read_line(&mut line)?;
    }
    Ok(status)
}

/// Ground that adapts: the name of its layer, its south-western corner, metres from west to east and from south to north.
struct Ground {
    layer: String,
    origin: Point,
    size: Point,
}

fn ground(document: &Value) -> Result<Ground, Failure> {
    let layers = document["layers"].as_array().into_iter().flatten();
    let layer = layers.into_iter().find(|layer| layer["source"]["adaptive"].is_object()).ok_or("nothing in this world adapts")?;
    let ground = &layer["source"]["adaptive"]["ground"];
    let number = |name: &str| ground[name].as_f64().ok_or_else(|| format!("the ground has no {name}"));
    // Every pass halves the distances, which end as those of the cells.
    let line = number("cell")? * (1_u64 << number("passes")?.clamp(0.0, 32.0) as u32) as f64;
    let origin = [0, 1].map(|i| ground["origin"][i].as_f64().unwrap_or(0.0));
    let size = [(number("populations")? * number("lines")? - 1.0) * line, (number("length")? - 1.0) * line];
    Ok(Ground { layer: layer["name"].as_str().unwrap_or_default().to_owned(), origin, size })
}

/// Metres from a point to a way, a line of at least one point.
fn distance(to: Point, way: &[Point]) -> f64 {
    let near = |a: Point, b: Point| {
        let (along, off) = ([b[0] - a[0], b[1] - a[1]], [to[0] - a[0], to[1] - a[1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let t = if length > 0.0 { ((off[0] * along[0] + off[1] * along[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let rest = [off[0] - t * along[0], off[1] - t * along[1]];
        (rest[0] * rest[0] + rest[1] * rest[1]).sqrt()
    };
    way.windows(2).map(|ends| near(ends[0], ends[1])).chain(way.first().map(|&only| near(only, only))).fold(f64::INFINITY, f64::min)
}

/// What became of the samples around a way from one revision to the next.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Compared {
    /// Samples within the promised distance; all of them are as they were.
    pub(crate) kept: usize,
    /// Samples further away that differ.
    pub(crate) changed: usize,
    pub(crate) tiles: usize,
}

/// Compares the tiles around a way.
///
/// # Errors
/// If a sample within the promised distance is another one, or a tile is not answered.
fn compare(world: &World<'_>, revisions: [&str; 2], way: &[Point], promise: f64) -> Result<Compared, Failure> {
    let bound = |axis: usize, sign: f64| way.iter().map(|at| sign * at[axis]).fold(f64::NEG_INFINITY, f64::max) * sign;
    // A tile further than that may change, too; rows count to the south.
    let reach = promise + TILE_METRES;
    let index = |metres: f64| (metres / TILE_METRES).floor() as i64;
    let columns = index(bound(0, -1.0) - reach)..=index(bound(0, 1.0) + reach);
    let rows = index(-bound(1, 1.0) - reach)..=index(-bound(1, -1.0) + reach);
    let mut compared = Compared::default();
    for [x, y] in columns.flat_map(|x| rows.clone().map(move |y| [x, y])) {
        let [before, after] = [world.tile(revisions[0], [x, y])?, world.tile(revisions[1], [x, y])?];
        compared.tiles += 1;
        for (i, (before, after)) in before.iter().zip(&after).enumerate() {
            let (column, row) = ((i % SIDE) as f64, (i / SIDE) as f64);
            let at = [x as f64 * TILE_METRES + column * SPACING, -(y as f64 * TILE_METRES + row * SPACING)];
            let is_same = before.to_bits() == after.to_bits();
            let is_near = distance(at, way) <= promise;
            if is_near && !is_same {
                return Err(format!("the promise is broken at {at:?}: {before} m became {after} m, {:.1} m from the way", distance(at, way)).into());
            }
            compared.kept += usize::from(is_near);
            compared.changed += usize::from(!is_same);
        }
    }
    Ok(compared)
}

/// Where a way to and fro across the ground is after some steps.
fn place(ground: &Ground, step: f64) -> Point {
    // There and back between a tenth and nine tenths of the ground; north at two thirds of the pace, so that the way crosses itself but seldom.
    let swing = |metres: f64, size: f64| {
        let turn = (metres / (0.8 * size)).rem_euclid(2.0);
        size * (0.1 + 0.8 * (1.0 - (turn - 1.0).abs()))
    };
    let metres = step * STEP;
    [ground.origin[0] + swing(0.83 * metres, ground.size[0]), ground.origin[1] + swing(0.55 * metres, ground.size[1])]
}

/// Walks through a world for some generations and tells about it; answers what became of the samples around the way.
///
/// # Errors
/// If the world has no ground that adapts, an answer is not what it should be, or the promise is broken.
pub(crate) fn walk(address: &str, name: &str, generations: usize, out: &mut impl Write) -> Result<Compared, Failure> {
    let world = World { address, name };
    let ground = ground(&world.json("GET", "", &Value::Null)?)?;
    let heard = world.listen()?;
    let mut step = 0.0;
    let mut here = place(&ground, step);
    let mut total = Compared::default();
    for _ in 0..generations {
        let mut way = vec![here];
        while way.len() < 12 {
            step += 1.0;
            here = place(&ground, step);
            way.push(here);
        }
        let promise = world.json("PUT", &format!("/players/{PLAYER}"), &json!({ "positions": way }))?["promise"].as_f64().ok_or("no promise")?;
        let old = revision(&world)?;
        let asked = Instant::now();
        let bred = world.json("POST", "/feedback", &json!({"layer": ground.layer, "players": true}))?;
        let took = asked.elapsed();
        let new = bred["revision"].as_str().ok_or("no revision")?;
        let at = await_event(&heard, new)?;
        let compared = compare(&world, [&old, new], &way, promise)?;
        writeln!(
            out,
            "generation {}: bred in {:.1} ms, heard {:.1} ms after the question; {} samples within {promise} m of the way are the same, {} others in {} tiles are not",
            bred["generation"]["number"],
            took.as_secs_f64() * 1e3,
            at.duration_since(asked).as_secs_f64() * 1e3,
            compared.kept,
            compared.changed,
            compared.tiles,
        )?;
        total = Compared { kept: total.kept + compared.kept, changed: total.changed + compared.changed, tiles: total.tiles + compared.tiles };
    }
    world.ask("DELETE", &format!("/players/{PLAYER}"), &Value::Null)?;
    writeln!(out, "{} samples kept, {} changed: the promise held", total.kept, total.changed)?;
    Ok(total)
}

/// The newest revision of the world.
fn revision(world: &World<'_>) -> Result<String, Failure> {
    let revisions = world.json("GET", "/revisions", &Value::Null)?;
    let newest = revisions.as_array().into_iter().flatten().max_by_key(|entry| entry["number"].as_u64());
    Ok(newest.and_then(|entry| entry["revision"].as_str()).ok_or("the world has no revisions")?.to_owned())
}

/// Waits until the server tells everybody of a revision.
fn await_event(heard: &Receiver<(Instant, Value)>, revision: &str) -> Result<Instant, Failure> {
    loop {
        let (at, event) = heard.recv_timeout(PATIENCE)?;
        if event["revision"] == revision {
            return Ok(at);
        }
    }
}

fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let address = arguments.next().unwrap_or_else(|| "127.0.0.1:8080".to_owned());
    let name = arguments.next().unwrap_or_else(|| "living".to_owned());
    walk(&address, &name, 10, &mut io::stdout().lock())?;
    Ok(())
}
