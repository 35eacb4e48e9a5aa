//! Nanoseconds a sample of feature layouts on one thread: the case of Benjaminsen 2021 (tables 6.1 and 14.1: 529 features, 512 × 512 samples of a square of
//! 2048 m, 16.4 influence rectangles a sample), with more and more detail, and layouts of 10^3 to 10^6 features of the same density.
#![expect(clippy::unwrap_used, reason = "a benchmark says what is wrong by failing")]
#![expect(clippy::print_stdout, reason = "what is measured is part of the figures")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::{hint::black_box, sync::Arc, time::Duration};
use terrane::{
    geometry::{Detail, Elevation, Filter, Rectangle, Shape, Window},
    layout::{Attribute, AttributeSet, Feature, Layout, Options, Selection, Side, Weight},
    noise::Isa,
};

/// Metres between the ends of the lines, about.
const STEP: f64 = 90.0;
/// Metres that a line has influence on: chosen for 16.4 influence rectangles a sample.
const RANGE: f64 = 157.0;

fn random(i: i64, j: i64, k: u64) -> f64 {
    let hash = terrane::noise::key(terrane::noise::key(k, i as u64), j as u64);
    (hash >> 11) as f64 / 9_007_199_254_740_992.0
}

fn corner(i: i64, j: i64) -> [f64; 2] {
    [(i as f64 + 0.6 * random(i, j, 1) - 0.3) * STEP, (j as f64 + 0.6 * random(i, j, 2) - 0.3) * STEP]
}

/// A line from every corner of a crooked lattice to its eastern or northern neighbour, ridges and rivers by turns; with a landmass if wanted.
fn features(count: usize, detail: u8, landmass: bool) -> Vec<Feature> {
    let set = |attributes| Arc::new(AttributeSet::new(attributes).unwrap());
    let smooth = |width| Weight::Smooth { width };
    let ridge = set(vec![Attribute::elevation(Weight::sharp(), RANGE), Attribute::material("rock", smooth(20.0), RANGE)]);
    let river = set(vec![
        Attribute::elevation(smooth(8.0), RANGE),
        Attribute::material("gravel", smooth(8.0), RANGE),
        Attribute::water_depth(&[[0.0, 3.0], [6.0, 0.0]], Weight::Linear, 6.0),
    ]);
    let lines = count - usize::from(landmass);
    let side = (lines as f64).sqrt().ceil() as i64;
    let mut features = Vec::with_capacity(count);
    for number in 0..lines as i64 {
        let (i, j) = (number % side - side / 2, number / side - side / 2);
        let east = random(i, j, 3) < 0.5;
        let ends = vec![corner(i, j), if east { corner(i + 1, j) } else { corner(i, j + 1) }];
        let height = 400.0 * random(i, j, 4);
        let shape = Shape::line(ends, Elevation::Vertices([height, height + 40.0].into())).unwrap();
        let is_ridge = random(i, j, 5) < 0.5;
        let displacement = if is_ridge { 0.15 } else { Detail::river_bound(10) };
        let shape = if detail == 0 { shape } else { shape.detailed(Detail::new(detail, displacement, 7).unwrap()).unwrap() };
        features.push(Feature::new(shape, Arc::clone(if is_ridge { &ridge } else { &river })).unwrap());
    }
    if landmass {
        let sea = set(vec![
            Attribute::elevation(smooth(60.0), f64::INFINITY).on(Side::Edge),
            Attribute::water_depth(&[[0.0, 0.0], [200.0, 20.0]], smooth(60.0), 400.0).on(Side::Outside),
        ]);
        let mut ring: Vec<[f64; 2]> = (0..24_i64)
            .map(|i| {
                let (angle, radius) = (std::f64::consts::TAU * i as f64 / 24.0, 900.0 + 250.0 * random(i, 0, 6));
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        ring.push(ring[0]);
        let shape = Shape::polygon(vec![ring], Elevation::Constant(0.0)).unwrap();
        let shape = if detail == 0 { shape } else { shape.detailed(Detail::new(detail, 0.1, 7).unwrap()).unwrap() };
        features.push(Feature::new(shape, sea).unwrap());
    }
    features
}

fn window(filter: Filter) -> Window {
    Window::area([-1024.0, -1024.0, 1024.0, 1024.0], 4.0, filter, 1 << 20).unwrap()
}

/// Influence rectangles a sample.
fn density(layout: &Layout) -> f64 {
    let (window, mut found, mut total) = (window(Filter::Exact), Vec::new(), 0);
    for y in window.rows.coordinates().step_by(8) {
        for x in window.columns.coordinates().step_by(8) {
            layout.find(&Rectangle { min: [x, y], max: [x, y] }, &mut found);
            total += found.len();
        }
    }
    total as f64 / 4_096.0
}

fn paper(c: &mut Criterion) {
    let mut group = c.benchmark_group("the paper's case");
    group.throughput(Throughput::Elements(1 << 18));
    for detail in [0, 3, 6, 8, 10] {
        let layout = Layout::new(features(529, detail, true), Options::default()).unwrap();
        println!("{:.2} influence rectangles a sample", density(&layout));
        for filter in [Filter::Exact, Filter::Band] {
            for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available() && (detail == 0 || *isa == Isa::active())) {
                for (what, selection) in [("elevation and water", Selection::default()), ("and materials", layout.everything())] {
                    let id = BenchmarkId::new(format!("{detail} iterations, {}, {}", filter.name(), isa.name()), what);
                    group.bench_function(id, |b| b.iter(|| layout.sample_on(isa, &window(filter), None, black_box(&selection))));
                }
            }
        }
    }
}

fn growth(c: &mut Criterion) {
    let mut group = c.benchmark_group("growth at constant density");
    group.sample_size(10);
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        let layout = Layout::new(features(count, 0, false), Options::default()).unwrap();
        group.throughput(Throughput::Elements(1 << 18));
        group.bench_function(BenchmarkId::new("sample", count), |b| b.iter(|| layout.sample(&window(Filter::Exact), None, black_box(&Selection::default()))));
        drop(layout);
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("load", count), |b| {
            b.iter_batched(|| features(count, 0, false), |features| Layout::new(features, Options::default()).unwrap(), criterion::BatchSize::PerIteration);
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2)).sample_size(20).without_plots();
    targets = paper, growth
}
criterion_main!(benches);
