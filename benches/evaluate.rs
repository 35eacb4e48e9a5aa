//! Nanoseconds a sample of noise and programmes on one thread, 512 × 512 samples (the reference: 64 × 64 of them), beside two peers on the same kind of field:
//! base wavelength 256 samples, 8 octaves, lacunarity 2, gain 0.5.
#![expect(clippy::unwrap_used, reason = "a benchmark says what is wrong by failing")]

use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime};
use fastnoise_lite::{CellularDistanceFunction, CellularReturnType, FastNoiseLite, FractalType, NoiseType};
use noise::{MultiFractal, NoiseFn};
use std::{hint::black_box, time::Duration};
use terrane::{
    geometry::{Filter, Grid, Samples, Tile, Window},
    noise::{Basis, Feature, Field, FieldShape, Metric},
    programme::{Frame, Programme, Tape, reference},
    tile::{TileRequest, Tileset, render},
    world::{Document, EXAMPLES, World},
};

const SIDE: usize = 512;
const WAVELENGTH: f64 = 256.0;

fn points() -> impl Iterator<Item = (f64, f64)> {
    (0..SIDE * SIDE).map(|i| ((i % SIDE) as f64 / WAVELENGTH + 3.1, (i / SIDE) as f64 / WAVELENGTH - 7.7))
}

/// Samples a side that the slow reference is measured over.
const REFERENCE_SIDE: usize = 64;

fn ours(c: &mut Criterion, name: &str, text: &str, shape: FieldShape, basis: Basis) {
    let mut group = c.benchmark_group(name);
    let programme = Programme::parse(text).unwrap();
    let tape = Tape::compile(programme.root());
    let frame = Frame { seed: 7, scale: WAVELENGTH, origin: [0.0, 0.0] };
    group.throughput(Throughput::Elements((REFERENCE_SIDE * REFERENCE_SIDE) as u64));
    let coordinates = || (0..REFERENCE_SIDE * REFERENCE_SIDE).map(|i| ((i % REFERENCE_SIDE) as f64 * 8.0, (i / REFERENCE_SIDE) as f64 * 8.0));
    let reference = |(x, y)| reference::evaluate(programme.root(), &frame, x, y, 1.0, Filter::Exact).0;
    group.bench_function("terrane, reference", |b| b.iter(|| coordinates().map(reference).sum::<f32>()));
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    let window = Window::area([0.0, 0.0, SIDE as f64, SIDE as f64], 1.0, Filter::Exact, 1 << 20).unwrap();
    let mut out = vec![0.0; SIDE * SIDE];
    group.bench_function("terrane, blocks", |b| b.iter(|| tape.evaluate(&frame, &window, black_box(&mut out))));
    let field = Field::exact(shape, basis, 7);
    group.bench_function("terrane, points", |b| b.iter(|| points().map(|(u, v)| field.at(u, v)).sum::<f32>()));
    group.bench_function("fastnoise-lite", |b| {
        let lite = lite(name);
        b.iter(|| points().map(|(u, v)| lite.get_noise_2d(u as f32, v as f32)).sum::<f32>());
    });
    match name {
        "fbm 8" => noise(&mut group, &noise::Fbm::<noise::Perlin>::new(7).set_octaves(8).set_frequency(1.0).set_lacunarity(2.0)),
        "ridged 8" => noise(&mut group, &noise::RidgedMulti::<noise::Perlin>::new(7).set_octaves(8).set_frequency(1.0).set_lacunarity(2.0)),
        "cellular F1" => noise(&mut group, &noise::Worley::new(7).set_return_type(noise::core::worley::ReturnType::Distance)),
        _ => noise(&mut group, &noise::Perlin::new(7)),
    }
    group.finish();
}

fn lite(name: &str) -> FastNoiseLite {
    let mut lite = FastNoiseLite::with_seed(7);
    lite.set_frequency(Some(1.0));
    lite.set_noise_type(Some(if name == "cellular F1" { NoiseType::Cellular } else { NoiseType::Perlin }));
    lite.set_cellular_distance_function(Some(CellularDistanceFunction::Euclidean));
    lite.set_cellular_return_type(Some(CellularReturnType::Distance));
    lite.set_fractal_type(match name {
        "fbm 8" => Some(FractalType::FBm),
        "ridged 8" => Some(FractalType::Ridged),
        _ => None,
    });
    lite.set_fractal_octaves(Some(8));
    lite
}

fn noise(group: &mut BenchmarkGroup<'_, WallTime>, noise: &impl NoiseFn<f64, 2>) {
    group.bench_function("noise", |b| b.iter(|| points().map(|(u, v)| noise.get([u, v])).sum::<f64>()));
}

fn fields(c: &mut Criterion) {
    let (h, lacunarity, octaves) = (1.0, 2.0, 8.0);
    ours(c, "perlin", "i_perlin", FieldShape::Single, Basis::IPerlin);
    ours(c, "fbm 8", "fbm(1, 2, 8, basis=i_perlin)", FieldShape::Fbm { h, lacunarity, octaves }, Basis::IPerlin);
    let ridged = FieldShape::Ridged { h, lacunarity, octaves, offset: 1.0, gain: 2.0 };
    ours(c, "ridged 8", "ridged_multifractal(1, 2, 8, 1, 2, basis=i_perlin)", ridged, Basis::IPerlin);
    ours(c, "cellular F1", "voronoi_f1", FieldShape::Single, Basis::Voronoi { feature: Feature::F1, metric: Metric::Distance });
}

/// Milliseconds of a 256-pixel terrarium tile of every example world, evaluated and encoded.
fn tiles(c: &mut Criterion) {
    let mut group = c.benchmark_group("tile 256");
    for example in EXAMPLES {
        let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
        for tileset in [Tileset::Terrarium, Tileset::R32] {
            let (tile, samples) = (Tile { z: 10, x: 515, y: 509 }, Samples::Centres(256));
            let request = TileRequest { grid: Grid::Web, tile, samples, filter: Filter::Band, tileset };
            group.bench_function(format!("{} {}", example.name, tileset.name()), |b| b.iter(|| render(&world, black_box(&request)).unwrap()));
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    targets = fields, tiles
}
criterion_main!(benches);
