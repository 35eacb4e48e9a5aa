//! Bells, planes, steps and half spheres as functions of a shader.

use super::number::{factor, float, place};
use crate::programme::shape::{Direction, Shape};

fn narrow(number: f64) -> String {
    float(number as f32)
}

/// Lines that set d to a place's offset from a centre, or from the nearest of its repetitions.
fn offset(centre: [f64; 2], repeat: f64) -> String {
    let from = place(-centre[0], -centre[1]);
    if repeat > 0.0 {
        return format!("    let d: vec2<f32> = {} * terrane_around(terrane_joined(at, {from}), {});\n", narrow(repeat), factor(1.0 / repeat));
    }
    format!("    let d: vec2<f32> = terrane_numbers(terrane_joined(at, {from}));\n")
}

/// Lines that set t to the distance across a step, positive where it is 1.
fn across(direction: Direction, repeat: f64) -> String {
    let axis = if direction.0[0] == 0.0 { "y" } else { "x" };
    let minus = if direction.0[0] + direction.0[1] < 0.0 { "-" } else { "" };
    if repeat > 0.0 {
        // A quarter of a period on, the middle of the high half lies at half a period.
        let periods = format!("terrane_times(at, {}).part.{axis}", factor(1.0 / repeat));
        let part = if minus.is_empty() { format!("0x40000000u + {periods}") } else { format!("0x40000000u - {periods}") };
        return format!("    let t: f32 = {} * (0.25 - abs(terrane_fraction(vec2<u32>({part})).x - 0.5));\n", narrow(repeat));
    }
    format!("    let t: f32 = {minus}terrane_numbers(at).{axis};\n")
}

/// The function of a shape's value, or of its derivatives.
pub(super) fn function(index: usize, shape: &Shape, slopes: bool) -> String {
    let (kind, name) = if slopes { ("vec2<f32>", "_slopes") } else { ("f32", "") };
    let body = match *shape {
        Shape::Gauss { width, centre, repeat } => {
            let value = format!("terrane_exp(dot(d, d) * {})", narrow(-0.5 / (width * width)));
            let slopes_of = format!("{} * d * {value}", narrow(-1.0 / (width * width)));
            format!("{}    return {};\n", offset(centre, repeat), if slopes { slopes_of } else { value })
        }
        Shape::Sphere { radius, centre, repeat } => {
            let r = narrow(radius);
            // (r + |d|) (r - |d|) keeps its digits near the rim.
            let inside = format!("    let inside: f32 = ({r} + length(d)) * ({r} - length(d));\n");
            let value = if slopes { "-d / sqrt(inside)" } else { "sqrt(inside)" };
            let zero = if slopes { "vec2<f32>(0.0)" } else { "0.0" };
            format!("{}{inside}    if (inside <= 0.0) {{ return {zero}; }}\n    return {value};\n", offset(centre, repeat))
        }
        Shape::Plane { direction: Direction([east, north]) } => {
            let ascent = format!("vec2<f32>({}, {})", narrow(east), narrow(north));
            if slopes { format!("    return {ascent};\n") } else { format!("    return dot(terrane_numbers(at), {ascent});\n") }
        }
        Shape::Step { .. } if slopes => "    return vec2<f32>(0.0);\n".to_owned(),
        Shape::Step { direction, softness, repeat } => format!("{}    return terrane_rise(t, {});\n", across(direction, repeat), narrow(softness)),
    };
    format!("// {shape:?}\nfn terrane_shape_{index}{name}(at: TerranePlace) -> {kind} {{\n{body}}}\n\n")
}
