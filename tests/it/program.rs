//! The real program: it starts, serves, survives being killed, and its log is clean.

use crate::process::{Server, TERRANE, run, text};
use serde_json::Value;
use std::{process::Command, time::Duration};

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
    for (output, start) in [("a.png", &b"\x89PNG"[..]), ("a.tif", b"II*\0"), ("a.r16", b""), ("a.r32", b"")] {
        let done = run(&[&["render", "world.json"], &area[..], &["-o", output]].concat(), folder.path());
        assert!(done.status.success(), "{}", text(&done.stderr));
        assert_eq!(text(&done.stdout), format!("{output}: 200 × 150 samples of 10 m over -1000,0,1000,1500\n"));
        assert!(std::fs::read(folder.path().join(output)).unwrap().starts_with(start));
    }
    assert_eq!(std::fs::metadata(folder.path().join("a.r32")).unwrap().len(), 200 * 150 * 4);
    for (output, start) in [("a.obj", &b"# Terrain over -1000,0,1000,1500:"[..]), ("a.glb", b"glTF\x02")] {
        let done = run(&[&["render", "world.json"], &area[..], &["-o", output]].concat(), folder.path());
        assert_eq!(text(&done.stdout), format!("{output}: 201 × 151 samples of 10 m over -1000,0,1000,1500\n"), "vertices on both edges");
        assert!(std::fs::read(folder.path().join(output)).unwrap().starts_with(start));
    }
    drop(Server::start(&folder.path().join("data-store")));
    assert!(run(&[&["render", "alps"], &area[..], &["-o", "b.png", "--tileset", "terrarium"]].concat(), folder.path()).status.success());
    for (arguments, expected) in [
        (
            &["render", "alp", "-o", "c.png"][..],
            "error: alp is neither a file nor one of the worlds in ./data-store: alps, archipelago, archipelago-endless, cordillera, dunes, eq2, hills, living, mesas, ranges, ridges-and-rivers, ridges-rivers-and-lakes\n",
        ),
        (&["render", "alps", "-o", "c.jpg"], "error: c.jpg must end in .png, .tif, .r16, .r32, .obj or .glb\n"),
        (&["render", "alps", "-o", "c.png", "--registration", "vertices"], "error: --registration vertices is for heights: pictures are made of pixels\n"),
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

/// The service manager is a socket that the test holds.
#[cfg(unix)]
#[test]
fn a_service_manager_is_told_and_health_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notify");
    let manager = std::os::unix::net::UnixDatagram::bind(&path).unwrap();
    manager.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let told = || {
        let mut buffer = [0; 100];
        let length = manager.recv(&mut buffer).unwrap();
        text(&buffer[..length])
    };
    let server = Server::start_with(&folder.path().join("data"), &[("NOTIFY_SOCKET", path.to_str().unwrap())]);
    assert_eq!(told(), "READY=1\n");
    let address = server.address.clone();
    let health = || run(&["health", "--listen", &address], folder.path());
    let answer = health();
    assert!(answer.status.success(), "{}", text(&answer.stderr));
    let (code, log) = server.stop();
    assert_eq!((code, told().as_str()), (Some(0), "STOPPING=1\n"), "{log:?}");
    let answer = health();
    assert!(!answer.status.success() && text(&answer.stderr).starts_with(&format!("error: asking http://{address}/healthz: ")), "{}", text(&answer.stderr));
}

#[cfg(all(unix, feature = "disk"))]
#[test]
fn tiles_on_disk_outlive_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let start = || Server::start_with(&data, &[("TERRANE_CACHE__DISK_BYTES", "134217728")]);
    let tile = "/worlds/alps/web/terrarium/9/256/255.png";
    let count = |server: &Server, metric: &str| text(&server.get("/metrics")).lines().any(|line| line == metric);
    let server = start();
    let made = server.get(tile);
    assert!(count(&server, "terrane_tile_lookups_total{result=\"miss\"} 1"));
    assert_eq!(server.stop().0, Some(0));
    let server = start();
    assert!(server.get(tile) == made && server.get(tile) == made, "other bytes");
    assert!(count(&server, "terrane_tile_lookups_total{result=\"disk\"} 1") && count(&server, "terrane_tile_lookups_total{result=\"hit\"} 1"));
    assert_eq!(server.stop().0, Some(0));
}
