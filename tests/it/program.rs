//! The real program: it starts, serves, survives being killed, and its log is clean.

use serde_json::Value;
use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Output, Stdio},
    sync::{Arc, Mutex},
    thread::JoinHandle,
    time::Duration,
};

const TERRANE: &str = env!("CARGO_BIN_EXE_terrane");

/// A running server on a free port.
struct Server {
    child: Child,
    address: String,
    log: Arc<Mutex<Vec<String>>>,
    reader: Option<JoinHandle<()>>,
}

impl Server {
    fn start(data: &Path) -> Self {
        let mut child = Command::new(TERRANE).args(["serve", "--listen", "127.0.0.1:0", "--data"]).arg(data).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let log = Arc::new(Mutex::new(Vec::new()));
        let address = loop {
            let line = lines.next().expect("the server ended before it listened").unwrap();
            log.lock().unwrap().push(line.clone());
            if let Some((_, address)) = line.split_once("listening on http://") {
                break address.to_owned();
            }
        };
        let rest = Arc::clone(&log);
        let reader = std::thread::spawn(move || lines.map_while(Result::ok).for_each(|line| rest.lock().unwrap().push(line)));
        Self { child, address, log, reader: Some(reader) }
    }

    /// Status and body of a request on a connection of its own.
    fn request(&self, method: &str, path: &str, body: &str) -> std::io::Result<(u16, Vec<u8>)> {
        let mut stream = TcpStream::connect(&self.address)?;
        stream.set_read_timeout(Some(Duration::from_secs(20)))?;
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}", self.address, body.len())?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer)?;
        let end = answer.windows(4).position(|window| window == b"\r\n\r\n").ok_or(std::io::ErrorKind::UnexpectedEof)?;
        let status = std::str::from_utf8(&answer[9..12]).ok().and_then(|status| status.parse().ok()).ok_or(std::io::ErrorKind::InvalidData)?;
        Ok((status, answer.split_off(end + 4)))
    }

    fn get(&self, path: &str) -> Vec<u8> {
        let (status, body) = self.request("GET", path, "").unwrap();
        assert_eq!(status, 200, "{path}: {}", String::from_utf8_lossy(&body));
        body
    }

    /// SIGTERM; the exit code and the log.
    #[cfg(unix)]
    fn stop(mut self) -> (Option<i32>, Vec<String>) {
        let asked = Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        assert!(asked.success());
        let code = self.child.wait().unwrap().code();
        self.reader.take().unwrap().join().unwrap();
        let log = self.log.lock().unwrap().clone();
        (code, log)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(TERRANE).env_clear().args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[cfg(unix)]
#[test]
fn the_program_serves_and_its_log_is_clean() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&folder.path().join("data"));
    let catalog: Value = serde_json::from_slice(&server.get("/catalog")).unwrap();
    let mut tiles = Vec::new();
    for world in catalog["worlds"].as_array().unwrap() {
        let name = world["name"].as_str().unwrap();
        let style: Value = serde_json::from_slice(&server.get(&format!("/worlds/{name}/style.json"))).unwrap();
        let template = style["sources"]["terrain"]["tiles"][0].as_str().unwrap();
        let path = template.split_once(&server.address).unwrap().1.replace("{z}", "9").replace("{x}", "256").replace("{y}", "255");
        tiles.push((path.clone(), server.get(&path)));
    }
    let (code, log) = server.stop();
    assert_eq!(code, Some(0));
    let unclean: Vec<_> = log.iter().filter(|line| line.contains("WARN") || line.contains("ERROR") || line.contains("panicked")).collect();
    assert!(unclean.is_empty() && log.last().unwrap().contains("stopped"), "{log:#?}");

    let server = Server::start(&folder.path().join("data"));
    tiles.reverse();
    for (path, bytes) in tiles {
        assert_eq!(server.get(&path), bytes, "a new process gives the same bytes: {path}");
    }
}

/// What must be stored under a name: the last seed acknowledged, and one whose answer never came, which may be stored or not.
#[derive(Clone, Copy, Default)]
struct Written {
    acknowledged: Option<u64>,
    in_flight: Option<u64>,
}

/// Where a document is kept, and the document with a seed: worlds and programmes in turn.
fn kept(which: usize, seed: u64) -> (String, String) {
    match which % 2 {
        0 => (format!("/worlds/w{which}"), format!(r#"{{"seed":{seed},"base":{{"programme":"fbm(1, 2, 3)","scale":1000}}}}"#)),
        _ => (format!("/programmes/w{which}"), format!(r#"{{"seed":{seed},"programme":"fbm(1, 2, 3)"}}"#)),
    }
}

/// Writes as fast as it can, kills the server in the middle, and looks for every document whose write was acknowledged.
#[test]
fn a_killed_server_loses_nothing_it_acknowledged() {
    let rounds = std::env::var("TERRANE_KILLS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(5_u64);
    let folder = tempfile::tempdir().unwrap();
    let (mut written, mut writes) = ([Written::default(); 7], 0);
    for round in 0..=rounds {
        let mut server = Server::start(folder.path());
        for (i, written) in written.iter_mut().enumerate() {
            let (status, body) = server.request("GET", &kept(i, 0).0, "").unwrap();
            let stored = serde_json::from_slice::<Value>(&body).unwrap()["seed"].as_u64().filter(|_| status == 200);
            let expected = [written.acknowledged, written.in_flight.or(written.acknowledged)];
            assert!(expected.contains(&stored), "w{i} holds {stored:?} after {round} kills, not one of {expected:?}");
            *written = Written { acknowledged: stored, in_flight: None };
        }
        if round == rounds {
            break;
        }
        let (killed, delay) = (server.child.id().to_string(), Duration::from_millis(20 + round * 37 % 160));
        let kill = std::thread::spawn(move || {
            std::thread::sleep(delay);
            Command::new("kill").args(["-9", &killed]).status().unwrap()
        });
        for i in 0_u64.. {
            let (which, seed) = ((i % 7) as usize, round * 100_000 + i);
            let (path, body) = kept(which, seed);
            written[which].in_flight = Some(seed);
            match server.request("PUT", &path, &body) {
                Ok((200 | 201, _)) => written[which] = Written { acknowledged: Some(seed), in_flight: None },
                Ok((status, body)) => panic!("{status}: {}", text(&body)),
                Err(_) => break,
            }
            writes += 1;
        }
        kill.join().unwrap();
        server.child.wait().unwrap();
    }
    assert!(writes > 3 * rounds, "{writes} writes in {rounds} rounds");
}

#[test]
fn check_completes_documents_and_names_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("good.json"), r#"{"seed":1,"base":{"programme":"x","scale":1}}"#).unwrap();
    std::fs::write(folder.path().join("bad.json"), r#"{"seed":-1,"base":{"programme":"x","scale":1}}"#).unwrap();
    let good = run(&["check", "good.json"], folder.path());
    assert!(good.status.success());
    assert_eq!(serde_json::from_slice::<Value>(&good.stdout).unwrap()["base"]["amplitude"], 1000);
    let bad = run(&["check", "bad.json"], folder.path());
    assert_eq!((bad.status.code(), text(&bad.stderr)), (Some(1), "error: bad.json:\n  /seed: expected a whole number 0 … 9007199254740991\n".to_owned()));
    let none = run(&["check", "none.json"], folder.path());
    assert!(text(&none.stderr).starts_with("error: reading none.json: No such file"), "{}", text(&none.stderr));
}

#[test]
fn render_writes_every_format_from_files_and_stored_worlds() {
    let folder = tempfile::tempdir().unwrap();
    let area = ["--bbox", "-1000,0,1000,1500", "--spacing", "10"];
    std::fs::write(folder.path().join("world.json"), r#"{"seed":1,"base":{"programme":"fbm(1, 2, 8)","scale":1000}}"#).unwrap();
    for (output, start) in [("a.png", &b"\x89PNG"[..]), ("a.tif", b"II*\0"), ("a.r32", b"")] {
        let done = run(&[&["render", "world.json"], &area[..], &["-o", output]].concat(), folder.path());
        assert!(done.status.success(), "{}", text(&done.stderr));
        assert_eq!(text(&done.stdout), format!("{output}: 200 × 150 samples of 10 m over -1000,0,1000,1500\n"));
        assert!(std::fs::read(folder.path().join(output)).unwrap().starts_with(start));
    }
    assert_eq!(std::fs::metadata(folder.path().join("a.r32")).unwrap().len(), 200 * 150 * 4);
    drop(Server::start(&folder.path().join("data-store")));
    assert!(run(&[&["render", "alps"], &area[..], &["-o", "b.png", "--tileset", "terrarium"]].concat(), folder.path()).status.success());
    for (arguments, expected) in [
        (
            &["render", "alp", "-o", "c.png"][..],
            "error: alp is neither a file nor one of the worlds in ./data-store: alps, archipelago, archipelago-endless, cordillera, dunes, eq2, hills, mesas, ridges-and-rivers, ridges-rivers-and-lakes\n",
        ),
        (&["render", "alps", "-o", "c.jpg"], "error: c.jpg must end in .png, .tif or .r32\n"),
        (&["render", "alps", "-o", "c.tif", "--tileset", "terrarium"], "error: --tileset is for .png files: .tif holds the elevations themselves\n"),
    ] {
        let failed = run(&[arguments, &area[..]].concat(), folder.path());
        assert_eq!((failed.status.code(), text(&failed.stderr)), (Some(1), expected.to_owned()));
    }
    let large = run(&["render", "alps", "--bbox", "0,0,1e6,1e6", "--spacing", "1", "-o", "c.png"], folder.path());
    assert_eq!(text(&large.stderr), "error: 1000000000000 samples are more than the 268435456 allowed\n");
}

#[test]
fn every_instruction_set_renders_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let programme = "plus(log(fbm(1, 2, 8)), plus(sin(multiply(9, ridged_multifractal(1, 2, 6, 1, 2))), mod(voronoi_f2, 0.3)))";
    std::fs::write(folder.path().join("w.json"), format!(r#"{{"seed":1,"base":{{"programme":"{programme}","scale":1000}}}}"#)).unwrap();
    let render = |isa: &str| {
        let arguments = ["render", "w.json", "--bbox", "-9000,0,1007,5003", "--spacing", "17", "-o", "out.r32"];
        let done = Command::new(TERRANE).env_clear().env("TERRANE_ISA", isa).args(arguments).current_dir(folder.path()).output().unwrap();
        done.status.success().then(|| std::fs::read(folder.path().join("out.r32")).unwrap()).ok_or_else(|| text(&done.stderr))
    };
    let baseline = render("baseline").unwrap();
    for isa in terrane::noise::Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
        assert!(render(isa.name()).unwrap() == baseline, "{}", isa.name());
    }
    let unknown = render("sse9").unwrap_err();
    assert!(unknown.starts_with("error: TERRANE_ISA: this machine has baseline") && unknown.ends_with(", got sse9\n"), "{unknown}");
}

#[test]
fn wrong_configuration_is_named_in_full() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("t.toml"), "[server]\nthreads = 5000\n[limits]\nworld_bytes = 0\n").unwrap();
    let failed = run(&["serve", "--config", "t.toml"], folder.path());
    assert_eq!(failed.status.code(), Some(1));
    assert_eq!(
        text(&failed.stderr),
        "error: configuration:\n  server.threads: must be 0 … 1024, got 5000\n  limits.world_bytes: must be 1 … 16777216, got 0\n"
    );
}
