//! Terrain by path costs: the 26 drawings that ship, the two cases of many strokes of Rusnell 2009 (section 4.6), and tiles of an endless world, cold and warm. Seconds on all threads,
//! least and median of `ROUNDS` (3).
#![expect(clippy::unwrap_used, reason = "a benchmark says what is wrong by failing")]
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use serde_json::json;
use std::time::{Duration, Instant};
use terrane::{
    geometry::{Filter, Grid, Samples, Stop, Tile},
    paths::{Drawing, PRESET_DRAWINGS, Plan},
    tile::{Height, Options, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};

fn rounds() -> usize {
    std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(3)
}

fn timed<T>(mut work: impl FnMut() -> T) -> ([Duration; 2], T) {
    let mut last = None;
    let mut times: Vec<Duration> = (0..rounds().max(1))
        .map(|_| {
            let start = Instant::now();
            last = Some(work());
            start.elapsed()
        })
        .collect();
    times.sort_unstable();
    ([times[0], times[times.len() / 2]], last.unwrap())
}

fn whole(drawing: &Drawing) -> (u64, usize) {
    let plan = Plan::new(drawing).unwrap();
    (plan.heights(&Stop::never(), &|_| {}).settled.nodes, plan.strokes())
}

fn presets() {
    let (mut least, mut median) = (Duration::ZERO, Duration::ZERO);
    for preset in PRESET_DRAWINGS {
        let drawing = Drawing::parse(preset.json.as_bytes()).unwrap();
        let (times, (nodes, strokes)) = timed(|| whole(&drawing));
        println!(
            "{:22} {strokes:4} strokes, {:6} nodes each: {:.3} s, median {:.3}",
            preset.name,
            nodes / strokes as u64,
            times[0].as_secs_f64(),
            times[1].as_secs_f64()
        );
        least += times[0];
        median += times[1];
    }
    let count = PRESET_DRAWINGS.len() as f64;
    println!("mean of {count}: {:.3} s, median {:.3}", least.as_secs_f64() / count, median.as_secs_f64() / count);
}

/// Strokes of one node, `count` of them on `side` × `side` nodes, as wide as those of the thesis.
fn many(side: usize, count: usize, width: f64) {
    let drawing = json!({
        "size": [side, side], "seed": 3, "edges": {"random": {"mean": 1, "deviation": 0.75}}, "sea_level": {"scale": 2}, "bias": 4,
        "profiles": {"steep": {"points": [[0, 1], [0.06, 0.86], [0.14, 0.68], [0.26, 0.47], [0.42, 0.27], [0.62, 0.12], [0.82, 0.035], [1, 0]], "width": width, "stepping": "slope"}},
        "strokes": [{"shape": {"scatter": {"count": count}}, "profiles": ["steep"], "cost": {"programme": "fbm(3, 2, 2)", "scale": 128, "between": [0, 30]}}]
    });
    let drawing = Drawing::parse(drawing.to_string().as_bytes()).unwrap();
    let plan = Plan::new(&drawing).unwrap();
    let (preview, _) = timed(|| plan.preview());
    let (times, settled) = timed(|| plan.heights(&Stop::never(), &|_| {}).settled);
    println!(
        "{side} × {side}, {count} strokes: {} nodes each, at most {}: {:.2} s, median {:.2}; approximate field {:.0} ms, median {:.0}",
        settled.nodes / count as u64,
        settled.most,
        times[0].as_secs_f64(),
        times[1].as_secs_f64(),
        preview[0].as_secs_f64() * 1e3,
        preview[1].as_secs_f64() * 1e3
    );
}

fn endless() {
    let json = EXAMPLES.iter().find(|example| example.name == "ranges").unwrap().json;
    for z in [6, 8, 10, 12, 14] {
        let request = TileRequest {
            grid: Grid::Web,
            tile: Tile { z, x: (1 << z) / 2 + 3, y: (1 << z) / 2 + 2 },
            samples: Samples::Centres(256),
            filter: Filter::Band,
            tileset: Tileset::Terrarium,
            height: Height::Ground,
            options: Options::default(),
        };
        let (mut cold, mut warm) = (Vec::new(), Vec::new());
        for round in 0..rounds() {
            // Of a world of another seed nothing is known.
            let document = json.replacen("\"seed\": 12", &format!("\"seed\": {}", 1_000 + round), 1);
            let world = World::new(Document::parse(document.as_bytes()).unwrap());
            for times in [&mut cold, &mut warm] {
                let start = Instant::now();
                render(&world, &request).unwrap();
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        cold.sort_unstable_by(f64::total_cmp);
        warm.sort_unstable_by(f64::total_cmp);
        println!("ranges, web level {z}: cold {:.0} … {:.0} ms, warm {:.1} … {:.1} ms", cold[0], cold[cold.len() - 1], warm[0], warm[warm.len() - 1]);
    }
}

fn main() {
    presets();
    many(512, 1703, 121.0);
    many(1536, 14_758, 125.0);
    endless();
}
