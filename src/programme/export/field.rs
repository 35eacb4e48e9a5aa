//! Noises and fractals as functions of a shader.
//!
//! Each has a table of its octaves and a loop over them; the formulas are those of [`FieldShape`]. Octaves with cells below 2^-32 of a unit, the resolution of
//! places, are left out.

use super::{number, voronoi};
use crate::{
    noise::{Basis, FieldShape, key},
    programme::graph::Noise,
};

/// Cells a unit from which an octave is left out.
const FINEST: f64 = 4_294_967_296.0;

/// Frequency and weight of every octave, the last one's remainder and a spectrum's norm included.
fn octaves(shape: FieldShape) -> Vec<(f64, f64)> {
    let (count, frequency_ratio, weight_ratio) = shape.progression();
    let (mut frequency, mut weight, mut all) = (1.0, 1.0, Vec::new());
    for k in 0..count.ceil() as usize {
        all.push((frequency, weight * (count - k as f64).min(1.0)));
        frequency *= frequency_ratio;
        weight *= weight_ratio;
    }
    if matches!(shape, FieldShape::Spectral { .. }) {
        let total: f64 = all.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut all {
            *weight /= total;
        }
    }
    all.retain(|(frequency, _)| *frequency < FINEST);
    all
}

/// An octave's lattice, hashed as noises hash it.
fn lattice(own: u64, octave: usize, (frequency, weight): (f64, f64)) -> String {
    let bits = key(own, octave as u64);
    let phase = |bits: u64| (bits & 0xffff) << 16;
    let (frequency, weight) = (number::factor(frequency), number::float(weight as f32));
    format!("TerraneLattice({frequency}, vec2<u32>({}u, {}u), {}u, {weight})", phase(bits >> 32), phase(bits >> 48), bits as u32)
}

/// What a noise is, for people.
fn description(noise: &Noise) -> String {
    let basis = match noise.basis {
        Basis::OPerlin => "o_perlin".to_owned(),
        Basis::IPerlin => "i_perlin".to_owned(),
        Basis::Blender => "blender_noise".to_owned(),
        Basis::CellNoise => "cell_noise".to_owned(),
        Basis::Voronoi { feature, metric } => format!("voronoi {feature:?} by {}", metric.name()).to_lowercase(),
    };
    match noise.shape {
        FieldShape::Single => basis,
        shape => format!("{shape:?} over {basis}"),
    }
}

/// The value of one octave's noise; with slopes, a vector of value and derivatives.
fn octave_noise(basis: Basis, voronoi: usize, slopes: bool) -> String {
    let part = if slopes { "" } else { ".x" };
    match basis {
        Basis::OPerlin => format!("terrane_o_perlin(at, lattice){part}"),
        Basis::IPerlin => format!("terrane_i_perlin(at, lattice){part}"),
        Basis::Blender => format!("terrane_blender(at, lattice){part}"),
        Basis::CellNoise => "terrane_cell_noise(at, lattice)".to_owned(),
        Basis::Voronoi { .. } => format!("terrane_voronoi_{voronoi}(at, lattice)"),
    }
}

/// What a loop over octaves carries from one to the next besides the value, and what it does with an octave's noise n.
fn value_steps(shape: FieldShape) -> (&'static str, Vec<String>) {
    let lines = |lines: &[&str]| lines.iter().map(|&line| line.to_owned()).collect();
    let float = |number: f64| number::float(number as f32);
    match shape {
        FieldShape::Single | FieldShape::Fbm { .. } | FieldShape::Spectral { .. } | FieldShape::Turbulence { hard: false, .. } => {
            ("", lines(&["value += lattice.weight * n;"]))
        }
        FieldShape::Turbulence { hard: true, .. } => ("", lines(&["value += lattice.weight * abs(n);"])),
        FieldShape::Multifractal { .. } => {
            ("var factor: f32 = 1.0;", lines(&["factor = terrane_finite(factor * (1.0 + lattice.weight * n));", "value = factor;"]))
        }
        FieldShape::Hetero { offset, .. } => {
            let add = format!("value = terrane_finite(value + lattice.weight * (n + {}) * factor);", float(offset));
            ("var factor: f32 = 1.0;", vec![add, "factor = value;".to_owned()])
        }
        FieldShape::Hybrid { offset, gain, .. } => {
            let signal = format!("let signal: f32 = lattice.weight * (n + {}) * opening;", float(offset));
            let open = format!("opening = min({} * signal, 1.0);", float(gain));
            ("var opening: f32 = 1.0;", vec![signal, "value = terrane_finite(value + signal);".to_owned(), open])
        }
        FieldShape::Ridged { offset, gain, .. } => {
            let crest = format!("let crest: f32 = {} - abs(n);", float(offset));
            let open = format!("opening = clamp({} * signal, 0.0, 1.0);", float(gain));
            let add = "value += lattice.weight * signal;".to_owned();
            ("var opening: f32 = 1.0;", vec![crest, "let signal: f32 = crest * crest * opening;".to_owned(), add, open])
        }
    }
}

/// The same with n, value and what is carried being vectors of a value and its two derivatives.
fn slope_steps(shape: FieldShape) -> (&'static str, Vec<String>) {
    let lines = |lines: &[&str]| lines.iter().map(|&line| line.to_owned()).collect();
    let float = |number: f64| number::float(number as f32);
    let one = "vec3<f32>(1.0, 0.0, 0.0)";
    match shape {
        FieldShape::Turbulence { hard: true, .. } => ("", lines(&["value += lattice.weight * sign(n.x) * n;"])),
        FieldShape::Multifractal { .. } => {
            let multiply = format!("factor = terrane_product(factor, {one} + lattice.weight * n);");
            ("var factor: vec3<f32> = vec3<f32>(1.0, 0.0, 0.0);", vec![multiply, "value = factor;".to_owned()])
        }
        FieldShape::Hetero { offset, .. } => {
            let add = format!("value += terrane_product(lattice.weight * (n + {} * {one}), factor);", float(offset));
            ("var factor: vec3<f32> = vec3<f32>(1.0, 0.0, 0.0);", vec![add, "factor = value;".to_owned()])
        }
        FieldShape::Hybrid { offset, gain, .. } => {
            let signal = format!("let signal: vec3<f32> = terrane_product(lattice.weight * (n + {} * {one}), opening);", float(offset));
            let open = format!("opening = {} * signal;", float(gain));
            let shut = format!("if (opening.x > 1.0) {{ opening = {one}; }}");
            ("var opening: vec3<f32> = vec3<f32>(1.0, 0.0, 0.0);", vec![signal, "value += signal;".to_owned(), open, shut])
        }
        FieldShape::Ridged { offset, gain, .. } => {
            let crest = format!("let crest: vec3<f32> = {} * {one} - sign(n.x) * n;", float(offset));
            let signal = "let signal: vec3<f32> = terrane_product(terrane_product(crest, crest), opening);".to_owned();
            let open = format!("opening = {} * signal;", float(gain));
            let high = format!("if (opening.x > 1.0) {{ opening = {one}; }}");
            let low = "if (opening.x < 0.0) { opening = vec3<f32>(0.0); }".to_owned();
            ("var opening: vec3<f32> = vec3<f32>(1.0, 0.0, 0.0);", vec![crest, signal, "value += lattice.weight * signal;".to_owned(), open, high, low])
        }
        _ => ("", lines(&["value += lattice.weight * n;"])),
    }
}

/// The table of a noise's octaves.
pub(super) fn table(index: usize, noise: &Noise, seed: u64) -> String {
    let (own, octaves) = (noise.key(seed), octaves(noise.shape));
    let kind = format!("array<TerraneLattice, {}>", octaves.len());
    let rows: Vec<String> = octaves.iter().enumerate().map(|(k, octave)| format!("    {}", lattice(own, k, *octave))).collect();
    format!("// {}\nconst TERRANE_OCTAVES_{index}: {kind} = {kind}(\n{}\n);\n\n", description(noise), rows.join(",\n"))
}

/// The function of a noise's value, or of its value and derivatives.
pub(super) fn function(index: usize, noise: &Noise, voronoi: usize, slopes: bool) -> String {
    if noise.shape == FieldShape::Single {
        return single(index, noise.basis, voronoi, slopes);
    }
    let (kind, zero, name) = if slopes { ("vec3<f32>", "vec3<f32>(0.0)", "_slopes") } else { ("f32", "0.0", "") };
    let (carried, steps) = if slopes { slope_steps(noise.shape) } else { value_steps(noise.shape) };
    let mut lines = vec![format!("    var value: {kind} = {zero};")];
    if !carried.is_empty() {
        lines.push(format!("    {carried}"));
    }
    lines.push(format!("    for (var k: i32 = 0; k < {}; k++) {{", octaves(noise.shape).len()));
    lines.push(format!("        let lattice: TerraneLattice = TERRANE_OCTAVES_{index}[k];"));
    lines.push(format!("        let n: {kind} = {};", octave_noise(noise.basis, voronoi, slopes)));
    lines.extend(steps.iter().map(|step| format!("        {step}")));
    format!("fn terrane_noise_{index}{name}(at: TerranePlace) -> {kind} {{\n{}\n    }}\n    return value;\n}}\n\n", lines.join("\n"))
}

fn single(index: usize, basis: Basis, voronoi: usize, slopes: bool) -> String {
    let (kind, name) = if slopes { ("vec3<f32>", "_slopes") } else { ("f32", "") };
    let value = octave_noise(basis, voronoi, slopes).replace("lattice", &format!("TERRANE_OCTAVES_{index}[0]"));
    format!("fn terrane_noise_{index}{name}(at: TerranePlace) -> {kind} {{\n    return {value};\n}}\n\n")
}

/// The functions of the Voronoi noises among some bases, where they are called, and for every basis the number of its own.
pub(super) fn voronois(bases: impl Iterator<Item = (Basis, bool)>) -> (String, Vec<usize>) {
    let (mut text, mut known, mut numbers) = (String::new(), Vec::new(), Vec::new());
    for (basis, called) in bases {
        let (Basis::Voronoi { feature, metric }, true) = (basis, called) else {
            numbers.push(0);
            continue;
        };
        let found = known.iter().position(|other| *other == basis);
        numbers.push(found.unwrap_or_else(|| {
            text.push_str(&voronoi::function(known.len(), feature, metric));
            known.push(basis);
            known.len() - 1
        }));
    }
    (text, numbers)
}
