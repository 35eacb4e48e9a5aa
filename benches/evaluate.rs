//! Nanoseconds a sample of noise and programmes on one thread, 512 × 512 samples, each instruction set beside two peers on the same kind of field: 8 octaves,
//! lacunarity 2, gain 0.5. `FastNoise2` fetches sources when it is built and is not on this list; its figures stand in the README.
#![expect(clippy::unwrap_used, reason = "a benchmark says what is wrong by failing")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fastnoise_lite::{CellularDistanceFunction, CellularReturnType, DomainWarpType, FastNoiseLite, FractalType, NoiseType};
use noise::{MultiFractal, NoiseFn};
use std::{hint::black_box, time::Duration};
use terrane::{
    geometry::{Filter, Grid, Samples, Tile, Window},
    noise::Isa,
    programme::{Frame, Programme, Reference, Tape},
    tile::{Height, Options, TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};

const SIDE: usize = 512;

/// Samples a side that the slow reference is measured over.
const REFERENCE_SIDE: usize = 32;

/// The same 32 nodes as a peer would have to call one by one.
const MIX: &str = "plus(max(multiply(0.6, fbm(1, 2, 8, basis=i_perlin)), minus(multiply(0.5, i_perlin), 0.2)), multiply(minus(1, abs(i_perlin)), plus(multiply(0.3, \
                   ridged_multifractal(1, 2, 8, 1, 2, basis=i_perlin)), multiply(0.25, multiply(voronoi_f1(seed=1), voronoi_f1(seed=1))))))";

/// Name, programme, samples a unit.
const CASES: [(&str, &str, f64); 9] = [
    ("perlin, wavelength 64", "i_perlin", 64.0),
    ("fbm 8, wavelength 256", "fbm(1, 2, 8, basis=i_perlin)", 256.0),
    ("fbm 8, wavelength 64", "fbm(1, 2, 8, basis=i_perlin)", 64.0),
    ("ridged 8, wavelength 256", "ridged_multifractal(1, 2, 8, 1, 2, basis=i_perlin)", 256.0),
    ("ridged 8, wavelength 64", "ridged_multifractal(1, 2, 8, 1, 2, basis=i_perlin)", 64.0),
    ("cellular F1, wavelength 64", "voronoi_f1", 64.0),
    ("mix of 32 nodes, wavelength 64", MIX, 64.0),
    ("domain warp, wavelength 64", "warp(fbm(1, 2, 8, basis=i_perlin), i_perlin, i_perlin)", 64.0),
    ("erosion of fbm 8, wavelength 216", "erosion(fbm(1, 2, 8))", 216.0),
];

fn fields(c: &mut Criterion) {
    for (name, text, wavelength) in CASES {
        let mut group = c.benchmark_group(name);
        let tape = Tape::compile(Programme::parse(text).unwrap().root());
        let frame = Frame { seed: 7, scale: wavelength, origin: [0.0, 0.0] };
        group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
        let mut out = vec![0.0; SIDE * SIDE];
        for filter in [Filter::Exact, Filter::Band] {
            let window = Window::area([0.0, 0.0, SIDE as f64, SIDE as f64], 1.0, filter, 1 << 20).unwrap();
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
                let id = format!("terrane, {}, {}", isa.name(), filter.name());
                group.bench_function(id, |b| b.iter(|| tape.evaluate_on(isa, &frame, &window, black_box(&mut out))));
            }
        }
        peers(&mut group, name, wavelength);
        group.throughput(Throughput::Elements((REFERENCE_SIDE * REFERENCE_SIDE) as u64));
        let reference = Reference::new(Programme::parse(text).unwrap().root(), &frame, 1.0, Filter::Exact);
        group.bench_function("terrane, reference", |b| {
            b.iter(|| {
                (0..REFERENCE_SIDE * REFERENCE_SIDE).map(|i| reference.at((i % REFERENCE_SIDE) as f64 * 16.0, (i / REFERENCE_SIDE) as f64 * 16.0)).sum::<f32>()
            });
        });
        group.finish();
    }
}

type Group<'a> = criterion::BenchmarkGroup<'a, criterion::measurement::WallTime>;

fn peers(group: &mut Group<'_>, name: &str, wavelength: f64) {
    let points = move || (0..SIDE * SIDE).map(move |i| ((i % SIDE) as f64 / wavelength + 3.1, (i / SIDE) as f64 / wavelength - 7.7));
    if !name.starts_with("mix") && !name.starts_with("erosion") {
        let lite = lite(name);
        let warped = name.starts_with("domain");
        group.bench_function("fastnoise-lite", |b| {
            let at = |(u, v): (f64, f64)| {
                let (u, v) = if warped { lite.domain_warp_2d(u as f32, v as f32) } else { (u as f32, v as f32) };
                lite.get_noise_2d(u, v)
            };
            b.iter(|| points().map(at).sum::<f32>());
        });
    }
    let mut run = |field: &dyn Fn([f64; 2]) -> f64| {
        group.bench_function("noise", |b| b.iter(|| points().map(|(u, v)| field([u, v])).sum::<f64>()));
    };
    match name.split([' ', ',']).next() {
        Some("fbm") => {
            let fbm = noise::Fbm::<noise::Perlin>::new(7).set_octaves(8).set_frequency(1.0).set_lacunarity(2.0);
            run(&|p| fbm.get(p));
        }
        Some("ridged") => {
            let ridged = noise::RidgedMulti::<noise::Perlin>::new(7).set_octaves(8).set_frequency(1.0).set_lacunarity(2.0);
            run(&|p| ridged.get(p));
        }
        Some("cellular") => {
            let worley = noise::Worley::new(7).set_return_type(noise::core::worley::ReturnType::Distance);
            run(&|p| worley.get(p));
        }
        Some("perlin") => {
            let perlin = noise::Perlin::new(7);
            run(&|p| perlin.get(p));
        }
        _ => {}
    }
}

fn lite(name: &str) -> FastNoiseLite {
    let mut lite = FastNoiseLite::with_seed(7);
    lite.set_frequency(Some(1.0));
    lite.set_noise_type(Some(if name.starts_with("cellular") { NoiseType::Cellular } else { NoiseType::Perlin }));
    lite.set_cellular_distance_function(Some(CellularDistanceFunction::Euclidean));
    lite.set_cellular_return_type(Some(CellularReturnType::Distance));
    lite.set_domain_warp_type(Some(DomainWarpType::BasicGrid));
    lite.set_domain_warp_amp(Some(1.0));
    lite.set_fractal_type(match name.split(' ').next() {
        Some("fbm" | "domain") => Some(FractalType::FBm),
        Some("ridged") => Some(FractalType::Ridged),
        _ => None,
    });
    lite.set_fractal_octaves(Some(8));
    lite
}

/// Time is linear in the samples, from a small tile to a large window.
fn growth(c: &mut Criterion) {
    let mut group = c.benchmark_group("growth of fbm 8, wavelength 256");
    let tape = Tape::compile(Programme::parse("fbm(1, 2, 8, basis=i_perlin)").unwrap().root());
    let frame = Frame { seed: 7, scale: 256.0, origin: [0.0, 0.0] };
    for side in [64, 128, 256, 512, 1024, 2048, 4096] {
        group.throughput(Throughput::Elements((side * side) as u64));
        let window = Window::area([0.0, 0.0, side as f64, side as f64], 1.0, Filter::Exact, 1 << 26).unwrap();
        let mut out = vec![0.0; side * side];
        group.bench_function(format!("{side} × {side}"), |b| b.iter(|| tape.evaluate(&frame, &window, black_box(&mut out))));
    }
    group.finish();
}

/// Milliseconds of a 256-pixel tile of every example world, evaluated and encoded.
fn tiles(c: &mut Criterion) {
    let mut group = c.benchmark_group("tile 256");
    for example in EXAMPLES {
        let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
        for tileset in [Tileset::Terrarium, Tileset::R32] {
            let (tile, samples) = (Tile { z: 10, x: 515, y: 509 }, Samples::Centres(256));
            let request = TileRequest { grid: Grid::Web, tile, samples, filter: Filter::Band, tileset, height: Height::Ground, options: Options::default() };
            group.bench_function(format!("{} {}", example.name, tileset.name()), |b| b.iter(|| render(&world, black_box(&request)).unwrap()));
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    targets = fields, growth, tiles
}
criterion_main!(benches);
