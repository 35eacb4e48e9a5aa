//! The suite that every evaluator is held to: the tape on each instruction set, with and without simplification, against the reference, bit for bit.

use super::{Frame, Programme, Reference, Tape};
use crate::{
    geometry::{Filter, Window},
    noise::Isa,
};

const FRAME: Frame = Frame { seed: 42, scale: 1_000.0, origin: [-300.0, 77.0] };

/// Near and far, wide cells and cells far below a sample, odd lengths.
const AREAS: [([f64; 4], f64); 4] = [
    ([-4_000.0, -900.0, 3_900.0, 500.0], 13.7),
    ([0.0, 0.0, 9e7, 1e6], 3e5),
    ([1e12, -1e12, 1e12 + 3.0, 0.5 - 1e12], 0.01),
    ([-2_000.0, -2_000.0, 300_000.0, 5_000.0], 900.0),
];

/// Every sample of the tape equals the reference.
fn check(text: &str) {
    check_in(text, &AREAS);
}

fn check_in(text: &str, areas: &[([f64; 4], f64)]) {
    let programme = Programme::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let tape = Tape::compile(programme.root());
    for &(bbox, spacing) in areas {
        for filter in [Filter::Band, Filter::Exact] {
            let window = Window::area(bbox, spacing, filter, 1 << 20).expect("valid");
            let window = window.band(0, window.rows.len().min(4));
            let mut out = vec![0.0; window.samples()];
            let non_finite = tape.evaluate(&FRAME, &window, &mut out);
            for isa in Isa::ALL {
                let mut other = vec![0.0; window.samples()];
                assert_eq!(tape.evaluate_on(isa, &FRAME, &window, &mut other), non_finite);
                assert!(out.iter().zip(&other).all(|(a, b)| a.to_bits() == b.to_bits()), "{text} on {isa:?}");
            }
            let reference = Reference::new(programme.root(), &FRAME, spacing, filter);
            for (row, y) in out.chunks(window.columns.len()).zip(window.rows.coordinates()) {
                for (i, (got, x)) in row.iter().zip(window.columns.coordinates()).enumerate().filter(|(i, _)| i % 3 == 0) {
                    let want = reference.at(x, y);
                    assert_eq!(got.to_bits(), want.to_bits(), "{text} at {x} {y} (column {i}) {filter:?}: {got} is not {want}");
                }
            }
        }
    }
}

#[test]
fn the_tape_equals_the_reference_bit_for_bit() {
    for text in [
        "3",
        "x",
        "minus(y, x)",
        "log(log(log(log(log(log(log(fbm(1.0, 1.97, 2))))))))",
        "plus(fbm(1, 1.97, 2), multiply(0.3, x))",
        "max(multiply(ridged_multifractal(1, 2, 5, 1, 2), i_perlin), minus(0.2, abs(turbulence(3.5, 0.5, 2, hard=true, basis=i_perlin))))",
        "plus(divide(cell_noise, voronoi_f1(metric=manhattan)), mod(voronoi_f2, minus(x, x)))",
        "power(minus(o_perlin, 0.5), plus(fbm(0.5, 2.1, 3, basis=voronoi_f1), fbm(0.5, 2.1, 3)))",
        "plus(sin(multiply(x, 1e7)), plus(cos(y), plus(tan(x), atan(divide(y, x)))))",
        "plus(log(0), sqrt(negative(y)))",
        "min(power(x, 30), multiply(multiply(x, 1e30), multiply(y, 1e30)))",
        "plus(sin(plus(multiply(plus(0.1, 0.2), x), fbm(1, 2, 3))), multiply(cos(minus(multiply(3, x), negative(y))), abs(sin(multiply(0.7, y)))))",
        "divide(1, 0)",
        "multiply(multiply(1e30, 1e30), x)",
        "plus(o_perlin(seed=3), minus(fbm(1, 2, 1, seed=3), o_perlin))",
    ] {
        check(text);
    }
}

#[test]
fn shapes_and_functions_of_rows_and_columns() {
    for text in [
        "gauss(0.7)",
        "plus(gauss(0.2, 0.5, 0.25, 1.5), step(0.1, e, repeat=0.7))",
        "plus(step(n), plus(step(s, 0.5), multiply(step(w), plane(ne))))",
        "multiply(plane(e), plane(n))",
        "plus(sphere(2, repeat=5), sphere(0.5, centre_x=0.2))",
        "sin(plus(multiply(3, x), cos(multiply(2, y))))",
        "plus(sin(x), multiply(sin(y), sin(plus(1, 2))))",
        "select(minus(x, y), sin(y), cos(x))",
        "select(minus(o_perlin, 0.1), 1, voronoi_f3)",
        "clamp(o_perlin, negative(0.2), x)",
        "mix(o_perlin, i_perlin, gauss(1))",
        "terrace(fbm(1, 2, 5), 8, 0.7)",
        "sin(multiply(40, fbm(1, 2, 6)))",
        "mod(multiply(50, x), 0.4)",
    ] {
        check(text);
    }
}

#[test]
fn every_noise_and_fractal() {
    for text in [
        "plus(blender_noise, plus(voronoi_f3, plus(voronoi_f4(metric=chebychev), voronoi_f2f1)))",
        "plus(voronoi_crackle, plus(voronoi(minkowski, 0.7), voronoi_f2(metric=minkowski, exponent=4)))",
        "multifractal(1, 2, 4.5)",
        "hetero_terrain(0.9, 2.1, 6, 0.7, basis=i_perlin)",
        "hybrid_multifractal(0.25, 2, 7.3, 0.7, 1)",
        "hybrid_multifractal(0.25, 2, 4, 0.7, 1, basis=blender_noise)",
        "ridged_multifractal(0.9, 2, 4, 1, 2, basis=voronoi_crackle)",
        "plus(spectral(2), spectral(1.5, octaves=4))",
        "distorted_noise(1.5, basis1=blender_noise, basis2=i_perlin)",
        "distorted_noise(0.5, voronoi_f2f1, cell_noise)",
    ] {
        check(text);
    }
}

#[test]
fn what_looks_at_other_places() {
    for text in [
        "warp(fbm(1, 2, 6), multiply(0.4, o_perlin), multiply(0.4, o_perlin))",
        "warp(warp(x, y, 1), o_perlin, 0.5)",
        "warp(gauss(1), y, x)",
        "smooth(ridged_multifractal(1, 2, 3, 1, 2), 0.1)",
        "smooth(warp(x, o_perlin, 0), 0.3)",
        "warp(smooth(plus(x, o_perlin), 0.2), i_perlin, y)",
        "gradient_x(fbm(1, 2, 6))",
        "plus(gradient_y(multiply(sin(x), fbm(1, 2, 3))), gradient_x(voronoi_f1))",
        "slope(plus(fbm(1, 2, 3, seed=1), divide(x, plus(2, sin(y)))))",
        "slope(warp(turbulence(4, 0.5, 2, true), multiply(0.3, i_perlin), power(2, x)))",
        "gradient_x(gradient_y(o_perlin))",
        "gradient_x(smooth(terrace(mod(plus(abs(o_perlin), max(x, y)), 0.7), 3, 0.5), 0.1))",
        "slope(min(sqrt(gauss(2)), select(x, tan(x), atan(log(y)))))",
        // Where what is taken as |a| is 0.
        "gradient_x(plus(sqrt(abs(step)), log(negative(abs(negative(step))))))",
        "gradient_x(sqrt(negative(multiply(cell_noise, step))))",
    ] {
        check(text);
    }
}

#[test]
fn valleys() {
    for text in [
        "erosion(fbm(1, 2, 5))",
        "plus(erosion(ridged_multifractal(1, 2, 3, 1, 2), octaves=1.5, scale=2, strength=0.7), x)",
        "slope(erosion(o_perlin, octaves=1))",
        "warp(erosion(plus(x, i_perlin), octaves=2, scale=0.1), o_perlin, 3)",
        "erosion(erosion(o_perlin, octaves=1, scale=3), octaves=1, scale=1)",
        "erosion(3)",
    ] {
        check_in(text, &AREAS[..1]);
    }
    // Every sample finds a network of its own.
    check_in("erosion(x, octaves=2)", &[([1e12, -1e12, 1e12 + 9e5, 4e5 - 1e12], 3e5)]);
}

#[test]
fn what_is_not_finite_is_zero_and_counted_at_its_step() {
    let tape = Tape::compile(Programme::parse("plus(1, multiply(multiply(1e30, 1e30), x))").expect("valid").root());
    let window = Window::area([0.0, 0.0, 10.0, 10.0], 1.0, Filter::Exact, 1_000).expect("valid");
    let mut out = vec![0.0; 100];
    assert_eq!(tape.evaluate(&FRAME, &window, &mut out), 100);
    assert_eq!(out, vec![1.0; 100]);
}

#[test]
fn a_noise_stays_as_it_is_when_the_programme_changes_around_it() {
    let value = |text: &str| Reference::new(Programme::parse(text).expect("valid").root(), &FRAME, 1.0, Filter::Exact).at(123.0, 456.0);
    let alone = value("fbm(1, 2, 4)");
    assert_eq!(value("plus(multiply(0, ridged_multifractal(1, 2, 4, 1, 2)), fbm(1, 2, 4))"), alone);
    assert_eq!(value("plus(fbm(1, 2, 4), multiply(0, fbm(1, 2, 4)))"), alone);
    assert_ne!(value("minus(fbm(1, 2, 4), fbm(1, 2, 4))"), 0.0, "two noises of one kind are two noises");
    assert_eq!(value("minus(fbm(1, 2, 4, seed=9), fbm(1, 2, 4, seed=9))"), 0.0, "noises of one seed are one");
    assert_eq!(value("warp(fbm(1, 2, 4), 0, 0)"), alone);
}
