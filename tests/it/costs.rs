//! How well the cost model predicts, measured: `make soak` runs this, alone and optimised.

use crate::grow::{Random, programme};
use std::time::Instant;
use terrane::{
    geometry::{Filter, Window},
    noise::Isa,
    programme::{Frame, Programme, Tape},
};

/// Samples a side, or fewer where that many would take longer than [`BUDGET_NS`].
const SIDE: usize = 192;
const LEAST_SIDE: usize = 24;
const BUDGET_NS: f64 = 5e7;
const FRAME: Frame = Frame { seed: 7, scale: 1.0, origin: [0.3, 0.7] };

fn window(tape: &Tape, spacing: f64, filter: Filter) -> Window {
    let affordable = (BUDGET_NS / tape.cost_ns(spacing, filter, SIDE * SIDE)).sqrt() as usize;
    let side = affordable.clamp(LEAST_SIDE, SIDE) as f64 * spacing;
    Window::area([0.0, 0.0, side, side], spacing, filter, 1 << 20).unwrap()
}

/// As for the window that is measured.
fn predicted_ns(tape: &Tape, spacing: f64, filter: Filter) -> f64 {
    tape.cost_ns(spacing, filter, window(tape, spacing, filter).samples())
}

/// The least of a few times, in nanoseconds a sample, on the instruction set of the cost model.
fn measured_ns(tape: &Tape, spacing: f64, filter: Filter) -> f64 {
    let window = window(tape, spacing, filter);
    let mut heights = vec![0.0; window.samples()];
    let times = (0..5).map(|_| {
        let start = Instant::now();
        tape.evaluate_on(Isa::Avx2, &FRAME, &window, &mut heights);
        start.elapsed().as_secs_f64() * 1e9 / window.samples() as f64
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Whether a warp may lead farther away than any tile lies, where noise is found place by place.
fn leads_off_the_plane(programme: &Programme) -> bool {
    let text = programme.to_string();
    text.contains("warp(") && text.split(['(', ')', ',', ' ', '=']).any(|word| word.parse().is_ok_and(|number: f64| number.abs() > 1e6))
}

/// Measured over predicted cost lies in 1/3 … 2 for 95 % of programmes, and is at most 3.
#[test]
#[ignore = "measures time: run by make soak"]
#[expect(clippy::print_stderr, reason = "figures for the reader")]
fn costs_are_predicted() {
    let count = std::env::var("TERRANE_COSTS").map_or(2_000, |text| text.parse().unwrap());
    let mut ratios: Vec<(f64, String)> = (0..count)
        .map(|seed| (seed, programme(&mut Random::new(seed), 6)))
        .filter(|(_, programme)| !leads_off_the_plane(programme))
        .map(|(seed, programme)| {
            let random = &mut Random::new(!seed);
            let spacing = 2f64.powf(random.unit() * 14.0 - 10.0);
            let filter = [Filter::Band, Filter::Exact][random.below(2)];
            let tape = Tape::compile(programme.root());
            let (measured, predicted) = (measured_ns(&tape, spacing, filter), predicted_ns(&tape, spacing, filter));
            (measured / predicted, format!("{measured:.1} ns, predicted {predicted:.1}: {programme} at spacing {spacing:.4} {filter:?}"))
        })
        .collect();
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share) as usize].0;
    eprintln!(
        "measured / predicted of {count} programmes: least {:.2}, 2.5 % {:.2}, median {:.2}, 97.5 % {:.2}, greatest {:.2}",
        at(0.0),
        at(0.025),
        at(0.5),
        at(0.975),
        at(1.0)
    );
    for (ratio, text) in ratios.iter().take(8).chain(ratios.iter().rev().take(12)) {
        eprintln!("  {ratio:.2}: {text}");
    }
    let within = ratios.iter().filter(|(ratio, _)| (1.0 / 3.0..=2.0).contains(ratio)).count() as f64 / ratios.len() as f64;
    eprintln!("within 1/3 … 2: {:.1} %", within * 100.0);
    assert!(within >= 0.95 && at(1.0) <= 3.0);
}

/// The table that the constants are chosen by.
#[test]
#[expect(clippy::print_stderr, reason = "figures for the reader")]
#[ignore = "measures time: for choosing the constants of the cost model"]
fn cost_table() {
    for text in TABLE {
        let tape = Tape::compile(Programme::parse(text).unwrap().root());
        let figures = [Filter::Exact, Filter::Band].map(|filter| {
            [64.0, 8.0, 3.0, 1.0, 0.3].map(|samples| {
                let (measured, predicted) = (measured_ns(&tape, 1.0 / samples, filter), predicted_ns(&tape, 1.0 / samples, filter));
                format!("  {measured:7.2} /{predicted:7.2} {:4.2}", measured / predicted)
            })
        });
        eprintln!("{text:60}{} |{}", figures[0].concat(), figures[1].concat());
    }
}

const TABLE: &[&str] = &[
    "multiply(x, y)",
    "o_perlin",
    "i_perlin",
    "blender_noise",
    "cell_noise",
    "voronoi_f1",
    "voronoi_f1(metric=squared)",
    "voronoi_f1(metric=manhattan)",
    "voronoi_f1(metric=minkowski)",
    "voronoi_f1(metric=minkowski, exponent=0.5)",
    "voronoi_f2",
    "voronoi_f3",
    "voronoi_f4",
    "voronoi_f4(metric=minkowski)",
    "voronoi_f2f1",
    "voronoi_crackle",
    "fbm(1, 2, 6)",
    "ridged_multifractal(1, 2, 6, 1, 2)",
    "multifractal(1, 2, 6)",
    "hetero_terrain(1, 2, 6, 0.7)",
    "hybrid_multifractal(1, 2, 6, 0.7, 1)",
    "turbulence(6, 0.5, 2, hard=true)",
    "fbm(1, 2, 6, basis=voronoi_f1)",
    "fbm(1, 2, 6, basis=blender_noise)",
    "warp(o_perlin, plus(x, y), y)",
    "warp(blender_noise, plus(x, y), y)",
    "warp(cell_noise, plus(x, y), y)",
    "warp(voronoi_f1, plus(x, y), y)",
    "warp(voronoi_f1(metric=minkowski), plus(x, y), y)",
    "warp(voronoi_f2, plus(x, y), y)",
    "warp(voronoi_f3, plus(x, y), y)",
    "warp(voronoi_f4, plus(x, y), y)",
    "warp(fbm(1, 2, 6), plus(x, y), y)",
    "warp(fbm(1, 2, 6, basis=voronoi_f1), plus(x, y), y)",
    "warp(ridged_multifractal(1, 2, 6, 1, 2), plus(x, y), y)",
    "warp(ridged_multifractal(1, 2, 6, 1, 2, basis=cell_noise), plus(x, y), y)",
    "slope(o_perlin)",
    "slope(fbm(1, 2, 6))",
    "slope(ridged_multifractal(1, 2, 6, 1, 2))",
    "slope(fbm(1, 2, 6, basis=blender_noise))",
    "smooth(fbm(1, 2, 6), 0.1)",
    "gauss(1)",
    "sphere(1)",
    "plane(ne)",
    "sin(multiply(x, y))",
    "tan(multiply(x, y))",
    "atan(multiply(x, y))",
    "log(multiply(x, y))",
    "power(x, y)",
    "divide(multiply(x, y), x)",
    "mod(multiply(x, y), x)",
    "sqrt(multiply(x, y))",
    "terrace(multiply(x, y), 3, 0.5)",
    "select(multiply(x, y), x, y)",
    "multiply(multiply(multiply(multiply(multiply(x, y), x), y), x), y)",
    "sin(multiply(x, 1e9))",
    "distorted_noise(1)",
    "erosion(fbm(1, 2, 8))",
    "erosion(fbm(1, 2, 8), octaves=1)",
    "erosion(multiply(fbm(1, 2, 8), ridged_multifractal(1, 2, 8, 1, 2)))",
    "erosion(erosion(fbm(1, 2, 8)), scale=0.5)",
    "erosion(fbm(1, 2, 8, basis=voronoi_f4))",
    "warp(erosion(fbm(1, 2, 8)), plus(x, y), y)",
];
