//! Pyramids of tiles: archives read back by readers of our own, held to the server's bytes; killed, resumed, cut into shards.

use crate::{
    client::Client,
    process::{TERRANE, run, text},
};
use flate2::read::GzDecoder;
use serde_json::Value;
use sqlx::{Connection, Row, SqliteConnection};
use std::{
    collections::BTreeMap,
    fs,
    io::Read,
    path::Path,
    process::{Command, Stdio},
    time::Duration,
};
use terrane::{
    geometry::{Filter, Grid, Samples, Tile},
    jobs::{self, Part, Pyramid, Shard, merge},
    tile::{Height, Options, TileRequest, Tileset},
    world::{Document, World},
};

/// A world with a sea, whose tiles are all alike.
const WORLD: &str = r#"{"seed":3,"title":"Isles","attribution":"me","elevation":{"min":0,"max":900},"base":{"programme":"fbm(1, 2, 8)","scale":90000,"amplitude":900,"datum":-250}}"#;

type Tiles = BTreeMap<(u8, u32, u32), Vec<u8>>;

/// What a `PMTiles` archive says and holds.
struct Archive {
    header: Vec<u8>,
    metadata: Value,
    tiles: Tiles,
    /// Entries of all directories, and leaves among them.
    entries: usize,
    leaves: usize,
}

impl Archive {
    fn word(&self, at: usize) -> u64 {
        word(&self.header, at)
    }
}

fn word(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn gunzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    GzDecoder::new(bytes).read_to_end(&mut out).unwrap();
    out
}

/// Number of the first tile, run, length and offset of each entry: columns of varints, numbers as differences, offset 0 for what follows the entry before.
fn directory(bytes: &[u8]) -> Vec<[u64; 4]> {
    let bytes = gunzip(bytes);
    let mut at = 0;
    let mut next = || {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = bytes[at];
            at += 1;
            value |= u64::from(byte & 127) << shift;
            shift += 7;
            if byte < 128 {
                return value;
            }
        }
    };
    let mut entries = vec![[0_u64; 4]; next() as usize];
    let mut id = 0;
    for entry in &mut entries {
        id += next();
        entry[0] = id;
    }
    (1..3).for_each(|column| entries.iter_mut().for_each(|entry| entry[column] = next()));
    for i in 0..entries.len() {
        let offset = next();
        entries[i][3] = if offset == 0 { entries[i - 1][3] + entries[i - 1][2] } else { offset - 1 };
    }
    entries
}

/// Level, column and row of a tile's number.
fn place(id: u64) -> (u8, u32, u32) {
    let (mut z, mut first) = (0, 0);
    while first + (1 << (2 * z)) <= id {
        first += 1 << (2 * z);
        z += 1;
    }
    let (mut at, mut x, mut y) = (id - first, 0, 0);
    for level in 0..z {
        let side = 1_u32 << level;
        let (right, up) = (((at / 2) & 1) as u32, ((at ^ (at / 2)) & 1) as u32);
        if up == 0 {
            if right == 1 {
                (x, y) = (side - 1 - x, side - 1 - y);
            }
            (x, y) = (y, x);
        }
        (x, y) = (x + side * right, y + side * up);
        at /= 4;
    }
    (z, x, y)
}

fn read_pmtiles(path: &Path) -> Archive {
    let file = fs::read(path).unwrap();
    assert_eq!(&file[..8], b"PMTiles\x03");
    let section = |at: usize| &file[word(&file, at) as usize..][..word(&file, at + 8) as usize];
    let (data, leaf_section) = (section(56), section(40));
    assert!(word(&file, 8) == 127 && word(&file, 16) <= 16_257, "the root is within the first 16 KiB");
    let mut archive =
        Archive { header: file[..127].to_vec(), metadata: serde_json::from_slice(&gunzip(section(24))).unwrap(), tiles: Tiles::new(), entries: 0, leaves: 0 };
    let mut ends = 0;
    for root in directory(section(8)) {
        let entries = if root[1] == 0 { directory(&leaf_section[root[3] as usize..][..root[2] as usize]) } else { vec![root] };
        archive.leaves += usize::from(root[1] == 0);
        for [id, length, size, offset] in entries {
            assert!(offset <= ends, "clustered: tiles lie in their order");
            ends = ends.max(offset + size);
            archive.entries += 1;
            (id..id + length).for_each(|id| assert!(archive.tiles.insert(place(id), data[offset as usize..][..size as usize].to_vec()).is_none()));
        }
    }
    archive
}

async fn read_mbtiles(path: &Path) -> (BTreeMap<String, String>, Tiles) {
    let mut file = SqliteConnection::connect(&format!("sqlite://{}?mode=ro", path.display())).await.unwrap();
    let rows = sqlx::query("SELECT name, value FROM metadata").fetch_all(&mut file).await.unwrap();
    let metadata = rows.iter().map(|row| (row.get("name"), row.get("value"))).collect();
    let rows = sqlx::query("SELECT zoom_level AS z, tile_column AS x, tile_row AS y, tile_data AS tile FROM tiles").fetch_all(&mut file).await.unwrap();
    let tile = |row: &sqlx::sqlite::SqliteRow| {
        let (z, x, y): (u8, u32, u32) = (row.get("z"), row.get("x"), row.get("y"));
        ((z, x, (1 << z) - 1 - y), row.get("tile"))
    };
    (metadata, rows.iter().map(tile).collect())
}

/// `terrane export` of the world, which must be done.
fn export(folder: &Path, arguments: &[&str]) -> String {
    let done = run(&[&["export", "world.json"], arguments].concat(), folder);
    assert!(done.status.success(), "{arguments:?}: {}", text(&done.stderr));
    text(&done.stdout)
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("world.json"), WORLD).unwrap();
    folder
}

const AREA: [&str; 4] = ["--bbox", "-90000,-70000,150000,110000", "--zoom", "7-10"];

#[tokio::test]
async fn archives_hold_the_tiles_of_the_server() {
    let (folder, client) = (folder(), Client::new().await);
    assert!(client.put("/worlds/isles", WORLD).await.status.is_success());
    for (options, tileset, ending, kind) in
        [(&[][..], "terrarium", ".png", 2), (&["--tileset", "fit", "--webp", "--size", "512", "--filter", "exact"], "fit", "@2x.webp?filter=exact", 4)]
    {
        for extension in ["pmtiles", "mbtiles"] {
            let name = format!("{tileset}.{extension}");
            let said = export(folder.path(), &[&AREA[..], options, &["-o", &name]].concat());
            let path = folder.path().join(&name);
            let tiles = if extension == "pmtiles" {
                let archive = read_pmtiles(&path);
                let unique: std::collections::BTreeSet<_> = archive.tiles.values().collect();
                assert_eq!(
                    [archive.word(72), archive.word(80), archive.word(88)],
                    [archive.tiles.len(), archive.entries, unique.len()].map(|count| count as u64)
                );
                assert_eq!(archive.header[96..102], [1, 2, 1, kind, 7, 10], "clustered, gzip, no compression of tiles, kind, levels");
                let degree = |at: usize| f64::from(i32::from_le_bytes(archive.header[at..at + 4].try_into().unwrap())) / 1e7;
                assert!((degree(102) - -0.808_483).abs() < 1e-5 && (degree(114) - 0.988_096).abs() < 1e-5, "{} {}", degree(102), degree(114));
                let said = ["name", "attribution", "encoding"].map(|key| archive.metadata[key].as_str().unwrap());
                assert_eq!(archive.metadata["tileSize"], if tileset == "fit" { 512 } else { 256 });
                assert_eq!(said, ["Isles", "me", if tileset == "fit" { "custom" } else { tileset }]);
                archive.tiles
            } else {
                let (metadata, tiles) = read_mbtiles(&path).await;
                let said = ["name", "format", "minzoom", "maxzoom", "type"].map(|key| metadata[key].as_str());
                assert_eq!(said, ["Isles", if tileset == "fit" { "webp" } else { "png" }, "7", "10", "baselayer"]);
                assert_eq!((metadata["bounds"].split(',').count(), metadata["center"].ends_with(",7")), (4, true));
                tiles
            };
            assert_eq!(said, format!("{name}: {} tiles, {} bytes\n", tiles.len(), fs::metadata(&path).unwrap().len()));
            // Edges of the area at level 10 are 2.3 tiles west, 1.8 south, 3.8 east and 2.8 north of the middle.
            let level: Vec<_> = tiles.keys().filter(|tile| tile.0 == 10).collect();
            let ends =
                |axis: fn(&(u8, u32, u32)) -> u32| (level.iter().map(|tile| axis(tile)).min().unwrap(), level.iter().map(|tile| axis(tile)).max().unwrap());
            assert_eq!((ends(|tile| tile.1), ends(|tile| tile.2), level.len()), ((509, 515), (509, 513), 35));
            for ((z, x, y), tile) in tiles {
                let answer = client.get(&format!("/worlds/isles/web/{tileset}/{z}/{x}/{y}{ending}")).await;
                assert!(answer.body[..] == tile[..], "{name}: {z}/{x}/{y}");
            }
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 5, "no parts are left");
}

#[tokio::test]
async fn archives_hold_vector_tiles_compressed_and_none_without_content() {
    let (folder, client) = (folder(), Client::new().await);
    let isle = r#"{"seed":3,"base":{"programme":"0","scale":1},"layers":[{"name":"isle","source":{"layout":{"features":[{"type":"Feature","id":"hill",
        "properties":{"attributes":[{"name":"elevation","value":500,"range":9000}]},"geometry":{"type":"Point","coordinates":[20000,20000]}}]}}}]}"#;
    fs::write(folder.path().join("world.json"), isle).unwrap();
    let saved = client.put("/worlds/isle", isle).await;
    assert!(saved.status.is_success(), "{}", text(&saved.body));
    for tileset in ["contours", "features"] {
        let arguments = [&AREA[..], &["--tileset", tileset, "-o"]].concat();
        export(folder.path(), &[&arguments[..], &["a.pmtiles"]].concat());
        export(folder.path(), &[&arguments[..], &["a.mbtiles"]].concat());
        let archive = read_pmtiles(&folder.path().join("a.pmtiles"));
        assert_eq!(archive.header[96..102], [1, 2, 2, 1, 7, 10], "clustered, gzip, tiles too, vector tiles, levels");
        let (metadata, tiles) = read_mbtiles(&folder.path().join("a.mbtiles")).await;
        assert_eq!((metadata["format"].as_str(), metadata["type"].as_str(), &archive.metadata["type"]), ("pbf", "overlay", &Value::from("overlay")));
        let layers = serde_json::from_str::<Value>(&metadata["json"]).unwrap();
        let tilejson = client.get(&format!("/worlds/isle/web/{tileset}")).await.json();
        assert_eq!((&layers["vector_layers"], &archive.metadata["vector_layers"]), (&tilejson["vector_layers"], &tilejson["vector_layers"]));
        assert!(archive.metadata.get("tileSize").is_none() && !metadata.contains_key("tilesize"), "vector tiles have no pixels");
        assert!(tiles == archive.tiles && !tiles.is_empty(), "the same tiles in both");
        let mut there = 0;
        for (z, x, y) in (509..=515).flat_map(|x| (509..=513).map(move |y| (10, x, y))) {
            let answer = client.get(&format!("/worlds/isle/web/{tileset}/{z}/{x}/{y}.mvt")).await;
            let kept = tiles.get(&(z, x, y)).map(|tile| gunzip(tile)).unwrap_or_default();
            assert!(answer.body[..] == kept[..], "{tileset} {z}/{x}/{y}");
            there += usize::from(!kept.is_empty());
        }
        assert!((1..35).contains(&there), "{tileset}: {there} tiles have content");
        fs::remove_file(folder.path().join("a.pmtiles")).unwrap();
        fs::remove_file(folder.path().join("a.mbtiles")).unwrap();
    }
}

/// The sea is one tile, however often it is there.
#[test]
fn equal_tiles_are_kept_once() {
    let folder = folder();
    let flat = r#"{"seed":3,"base":{"programme":"voronoi_f1","scale":3000000,"amplitude":9000,"datum":-4000},"elevation":{"min":0,"max":100}}"#;
    fs::write(folder.path().join("world.json"), flat).unwrap();
    export(folder.path(), &["--zoom", "0-6", "-o", "a.pmtiles"]);
    let archive = read_pmtiles(&folder.path().join("a.pmtiles"));
    assert_eq!(archive.tiles.len(), (1 << 14) / 3);
    assert!(archive.word(88) < archive.entries as u64 && archive.entries < archive.tiles.len(), "{} contents, {} entries", archive.word(88), archive.entries);
}

/// More tiles than the first 16 KiB can name.
#[test]
fn large_directories_have_leaves() {
    let folder = folder();
    let world = World::new(Document::parse(WORLD.as_bytes()).unwrap());
    let (tile, samples, tileset) = (Tile { z: 0, x: 0, y: 0 }, Samples::Centres(256), Tileset::Terrarium);
    let request = TileRequest { grid: Grid::Web, tile, samples, filter: Filter::Band, tileset, height: Height::Ground, options: Options::default() };
    let pyramid = Pyramid::new(request, None, [2, 7]).unwrap();
    let mut part = Part::resume(&folder.path().join("part"), &pyramid.plan(&world), Shard::WHOLE).unwrap();
    let named: Vec<_> =
        (0..pyramid.tiles()).map(|place| pyramid.request(place).tile).map(|tile| format!("{}/{}/{}", tile.z, tile.x, tile.y).into_bytes()).collect();
    named.chunks(1000).for_each(|tiles| part.append(tiles).unwrap());
    let to = folder.path().join("a.pmtiles");
    assert_eq!(merge(vec![part], jobs::Archive::PmTiles, &to, &mut |_| {}).unwrap(), 21_840);
    let archive = read_pmtiles(&to);
    assert!(archive.leaves > 1 && archive.tiles.len() == 21_840);
    assert!(archive.tiles.iter().all(|((z, x, y), tile)| *tile == format!("{z}/{x}/{y}").into_bytes()));
}

#[tokio::test]
async fn shards_and_threads_change_no_byte() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    for (kind, threads) in [("pmtiles", "1"), ("mbtiles", "3")] {
        export(folder.path(), &[&AREA[..], &["-o", &format!("whole.{kind}"), "--threads", threads]].concat());
        let mut parts = Vec::new();
        for shard in ["2/3", "1/3", "3/3"] {
            let said = export(folder.path(), &[&AREA[..], &["-o", &format!("cut.{kind}"), "--shard", shard]].concat());
            parts.push(format!("cut.{kind}.part-{}", shard.replace('/', "-of-")));
            assert!(said.starts_with(&format!("{}: ", parts[parts.len() - 1])), "{said}");
        }
        let parts: Vec<_> = parts.iter().map(String::as_str).collect();
        let cut = format!("cut.{kind}");
        let missing = run(&["merge", &cut, parts[0], parts[1]], folder.path());
        assert_eq!(text(&missing.stderr), "error: of 3 parts each is needed once; given are 1, 2\n");
        let merged = run(&[&["merge", &cut][..], &parts].concat(), folder.path());
        assert!(merged.status.success(), "{}", text(&merged.stderr));
        assert!(fs::read(path(&cut)).unwrap() == fs::read(path(&format!("whole.{kind}"))).unwrap(), "{kind}");
    }
}

/// Kills an export again and again; what it had finished stays, and the archive is that of one run.
#[test]
fn a_killed_export_goes_on_to_the_same_bytes() {
    let rounds = std::env::var("TERRANE_KILLS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(4_u64);
    let folder = folder();
    let area = ["--bbox", "-200000,-200000,200000,200000", "--zoom", "8-11", "--tileset", "terrain-rgb"];
    for kind in ["pmtiles", "mbtiles"] {
        export(folder.path(), &[&area[..], &["-o", &format!("whole.{kind}")]].concat());
        let whole = fs::read(folder.path().join(format!("whole.{kind}"))).unwrap();
        let (name, mut kills) = (format!("killed.{kind}"), 0);
        let (output, part) = (folder.path().join(&name), folder.path().join(format!("{name}.part-1-of-1")));
        for round in 0..rounds {
            let arguments = [&["export", "world.json"], &area[..], &["-o", &name]].concat();
            let mut child = Command::new(TERRANE).env_clear().args(arguments).current_dir(folder.path()).stdout(Stdio::null()).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(60 + round * 97 % 400));
            kills += u64::from(child.try_wait().unwrap().is_none());
            child.kill().unwrap();
            child.wait().unwrap();
            if output.exists() {
                assert!(fs::read(&output).unwrap() == whole, "{name} has its name and is not whole");
                let _ = fs::remove_file(&output);
                let _ = fs::remove_file(&part);
            }
        }
        assert!(kills > 0, "nothing was killed in {rounds} rounds");
        let said = export(folder.path(), &[&area[..], &["-o", &name]].concat());
        assert!(fs::read(&output).unwrap() == whole, "{name} after {kills} kills: {said}");
        assert!(!part.exists());
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_export_says_how_to_go_on() {
    let folder = folder();
    let arguments = ["export", "world.json", "--zoom", "0-9", "-o", "all.pmtiles"];
    let child = Command::new(TERRANE).env_clear().args(arguments).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let done = child.wait_with_output().unwrap();
    let said = text(&done.stdout);
    assert_eq!(done.status.code(), Some(130), "{said}{}", text(&done.stderr));
    let rest = " of 349525 tiles are kept in all.pmtiles.part-1-of-1; the same command goes on from there\n";
    assert!(said.starts_with("stopped: ") && said.ends_with(rest), "{said}");
}

#[test]
fn wrong_exports_name_what_is_wrong() {
    let folder = folder();
    fs::write(folder.path().join("there.pmtiles"), "something").unwrap();
    for (arguments, expected) in [
        (&["--zoom", "0-1", "-o", "a.tiles"][..], "error: a.tiles must end in .pmtiles or .mbtiles\n"),
        (&["--zoom", "0-1", "-o", "there.pmtiles"], "error: there.pmtiles is there already: delete it, or choose another output\n"),
        (&["--zoom", "3-1", "-o", "a.pmtiles"], "error: levels must be MIN-MAX with 0 ≤ MIN ≤ MAX ≤ 24, got 3-1\n"),
        (&["--zoom", "0-1", "-o", "a.pmtiles", "--grid", "metric"], "error: archives know the grid web alone, not metric\n"),
        (&["--zoom", "0-1", "-o", "a.pmtiles", "--tileset", "r32"], "error: archives hold pictures and vector tiles here: r32 is neither\n"),
        (
            &["--zoom", "0-1", "-o", "a.pmtiles", "--bbox", "3e7,0,4e7,9"],
            "error: the area must have its least corner first and meet the grid's own range, ±20037508 m (minx,miny,maxx,maxy)\n",
        ),
        (&["--zoom", "0-1", "-o", "none/a.pmtiles"], "error: none/a.pmtiles.part-1-of-1: No such file or directory (os error 2)\n"),
    ] {
        let failed = run(&[&["export", "world.json"], arguments].concat(), folder.path());
        assert_eq!((failed.status.code(), text(&failed.stderr)), (Some(1), expected.to_owned()));
    }
    let begun = ["--zoom", "0-2", "-o", "b.pmtiles", "--shard", "1/2"];
    export(folder.path(), &begun);
    let other = run(&[&["export", "world.json"], &begun[..], &["--tileset", "relief"]].concat(), folder.path());
    let expected = "error: b.pmtiles.part-1-of-2: this is a part of another export (the tilesets or their options differ); delete it to start anew, or choose another output\n";
    assert_eq!(text(&other.stderr), expected);
    let alone = run(&["merge", "b.pmtiles", "world.json"], folder.path());
    assert_eq!(text(&alone.stderr), "error: world.json: this is no part of an export\n");
}
