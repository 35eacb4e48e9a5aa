//! The house: which rooms may use which, and what no file may hold.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// From the bottom up; a room may use those before it. Rooms that are not built yet have their place already.
const ROOMS: [&str; 15] =
    ["geometry", "noise", "genetic", "analysis", "programme", "layout", "paths", "synthesis", "evolve", "world", "tile", "query", "store", "jobs", "server"];

/// Rooms that do not know each other: they meet in `world`.
const STRANGERS: [(&str, &str); 4] = [("programme", "synthesis"), ("layout", "paths"), ("layout", "synthesis"), ("paths", "synthesis")];

fn sources(folder: &Path) -> Vec<PathBuf> {
    files(folder).into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// Every file below a folder that is not installed or built.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if !["node_modules", "dist", "out"].iter().any(|name| path.ends_with(name)) {
                files.extend(self::files(&path));
            }
        } else {
            files.push(path);
        }
    }
    files
}

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The code of a file without comments and without its tests, which may use anything.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let code = text.split("\n#[cfg(test)]\nmod tests").next().unwrap();
    code.lines().map(|line| line.split("//").next().unwrap()).collect::<Vec<_>>().join("\n")
}

/// First segments after `crate::`, also inside `crate::{…}`.
fn uses(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for part in code.split("crate::").skip(1) {
        let Some(group) = part.strip_prefix('{') else {
            found.insert(word(part));
            continue;
        };
        let (mut depth, mut start) = (0, true);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => start = true,
                c if start && !c.is_whitespace() => {
                    found.insert(word(&group[i..]));
                    start = false;
                }
                _ => {}
            }
        }
    }
    found
}

#[test]
fn imports_are_found_in_groups_too() {
    let found = uses("use crate::{\n    geometry::{Grid, Tile},\n    noise,\n};\nlet x = crate::tile::render;");
    assert_eq!(found.into_iter().collect::<Vec<_>>(), ["geometry", "noise", "tile"]);
}

#[test]
fn dependencies_point_down() {
    let floor = |room: &str| ROOMS.iter().position(|known| *known == room);
    let mut wrong = Vec::new();
    for path in sources(&src()) {
        let inside = path.strip_prefix(src()).unwrap().to_path_buf();
        let room = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs").to_owned();
        if matches!(room.as_str(), "lib" | "main" | "command") {
            continue;
        }
        let own = floor(&room).unwrap_or_else(|| panic!("{room} is not a room of the house: give it its place in ROOMS and in ARCHITECTURE.md"));
        for used in uses(&code(&path)) {
            let strangers = STRANGERS.contains(&(room.as_str(), used.as_str())) || STRANGERS.contains(&(used.as_str(), room.as_str()));
            if floor(&used).is_some_and(|other| other > own) || strangers {
                wrong.push(format!("{} uses {used}", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn only_the_server_knows_http_and_only_instruction_sets_are_unsafe() {
    for path in sources(&src()) {
        let (code, name) = (code(&path), path.strip_prefix(src()).unwrap().display().to_string());
        let server = name.starts_with("server/") || name.starts_with("store/") || name.starts_with("command/") || name == "main.rs";
        for library in ["axum", "tokio", "tower", "hyper", "sqlx"] {
            assert!(server || !code.contains(&format!("{library}::")), "{name} uses {library}");
        }
        assert!(["noise/isa.rs", "noise/x86.rs"].contains(&name.as_str()) || !code.contains("unsafe "), "{name} is unsafe");
        // Tests may use what they like to say what is right.
        let tests = name.ends_with("/tests.rs") || name.contains("/tests/");
        for word in ["mul_add", "todo!(", "unimplemented!(", "dbg!(", ".unwrap()", "SystemTime", "Instant::now"] {
            // Peers are given time, what waits is told so, progress has a rate, and signatures end; what is served never depends on a clock.
            let clock = name.starts_with("server/") || name == "command/progress.rs";
            let date = name == "server/signed.rs" || name == "command/key.rs";
            let allowed = (tests && word == ".unwrap()") || (clock && word == "Instant::now") || (date && word == "SystemTime");
            assert!(allowed || !code.contains(word), "{name} holds {word}");
        }
        let kernels = !tests
            && ["noise/", "genetic/", "programme/", "layout/", "paths/", "synthesis/", "evolve/", "geometry/", "world/", "analysis/", "tile/", "query/"]
                .iter()
                .any(|room| name.starts_with(room));
        for word in [
            ".sin(",
            ".cos(",
            ".tan(",
            ".powf(",
            ".powi(",
            ".exp(",
            ".exp2(",
            ".ln(",
            ".log(",
            ".atan(",
            ".atan2(",
            ".log2(",
            ".log10(",
            ".hypot(",
            ".cbrt(",
            "f32::sin",
            "f64::sin",
            "f32::cos",
            "f64::cos",
            "f32::powf",
            "f64::powf",
            "f32::powi",
            "f64::powi",
            "f32::exp",
            "f64::exp",
            "f32::ln",
            "f64::ln",
            "HashMap",
            "HashSet",
        ] {
            assert!(!kernels || !code.contains(word), "{name} holds {word}: results must not depend on the platform or on hashing order");
        }
    }
}

#[test]
fn the_tree_names_no_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["src", "tests", "web", "docs", "config", "docker", "openapi", "benches", "data"] {
        let mut texts = 0;
        for path in files(&root.join(folder)) {
            if let Ok(text) = fs::read_to_string(&path) {
                texts += 1;
                for machine in [concat!("/", "work/"), concat!("/", "root/"), concat!("/", "home/")] {
                    assert!(!text.contains(machine), "{} names {machine}", path.display());
                }
            }
        }
        assert!(texts > 0, "nothing was read in {folder}");
    }
}
