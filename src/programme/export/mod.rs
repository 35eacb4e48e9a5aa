//! Programmes as shaders: source text in GLSL ES 3.00 or WGSL that computes, at a point, what the server computes.
//!
//! The functions that exports are made of stand in `library.wgsl`; what follows from a programme is written in the same part of WGSL ([`body`] its steps, [`field`]
//! its noises, [`shape`] its shapes), and [`glsl`] translates the whole. Only what is used is written.

mod body;
mod field;
mod glsl;
mod library;
mod number;
mod shape;
mod voronoi;

use super::{
    Frame, Programme,
    graph::{Graph, Step},
};

/// Most steps of an exported programme: compilers of graphics drivers take minutes for more.
pub const MAX_SHADER_STEPS: usize = 2_000;

/// Coordinates beyond these have no place in a shader.
const FURTHEST: f64 = 2_147_483_648.0;

/// The version of the text that a programme becomes.
pub const SHADER_FORM: u32 = 2;

/// A language of shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShaderLanguage {
    /// GLSL ES 3.00, for WebGL 2 (and GLSL from 3.30 on).
    Glsl,
    /// WGSL, for WebGPU.
    Wgsl,
}

/// How a programme's values lie in the plane and become elevations: datum + amplitude · value, held within a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// How programme coordinates lie in the plane.
    pub frame: Frame,
    /// Metres of elevation per unit of the value.
    pub amplitude: f64,
    /// Metres of elevation where the value is 0.
    pub datum: f64,
    /// Least and greatest elevation in metres.
    pub range: [f64; 2],
}

/// Why a programme is not exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// It has too many steps.
    #[error("with smooth, slope and gradients written out the programme has {0} steps, more than the {MAX_SHADER_STEPS} that a shader may have")]
    Steps(usize),
    /// It erodes: valleys are found from a network of a thousand nodes, which a server keeps and a shader would have to find for every pixel.
    #[error("erosion cannot be exported to a shader: its network of valleys has to be kept from sample to sample; load tiles of elevations instead")]
    Erosion,
    /// Its plane does not fit.
    #[error("a shader holds origins within ±2^31 metres and scales from 2^-31 metres a unit on")]
    Plane,
}

impl Programme {
    /// The programme as GLSL ES 3.00, to be pasted into a shader behind its `#version`.
    ///
    /// The source defines `terrane_value(p)` of programme coordinates, and `terrane_value_at(cell, offset)` of their sum, for what lies so far out that one f32
    /// cannot hold it. Other names begin with `terrane_`, `Terrane` or `TERRANE_`. It is the function as it is (`filter=exact`): the same lattices, hashed by the
    /// same integers, the same protected functions, and 0 wherever a step's value is not finite. A place is held in 64 bits an axis (32 for the unit, 32 for its
    /// fraction) and found in each octave's lattice by integer arithmetic, so values are as exact at 2^30 units from the origin as at it; beyond 2^31 there is
    /// no place.
    ///
    /// What remains is the rounding of f32: against the server, 1e-5 of a value's range, 1e-4 for derivatives. Functions that are steep in what they are given
    /// enlarge the error of that. Where a value jumps (cells, steps, the edge of a mask) the jump may lie 1e-6 units elsewhere. Octaves with cells below 2^-32
    /// units are left out, and graphics processors may take numbers below 1e-38 for 0.
    ///
    /// ```
    /// let glsl = terrane::programme::Programme::parse("fbm(1, 2, 8)")?.to_glsl(7)?;
    /// assert!(glsl.contains("float terrane_value(vec2 p)"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the programme has more than [`MAX_SHADER_STEPS`] steps or erodes.
    pub fn to_glsl(&self, seed: u64) -> Result<String, ShaderError> {
        self.write(ShaderLanguage::Glsl, seed, "")
    }

    /// The programme as WGSL: the same as [`Programme::to_glsl`].
    ///
    /// # Errors
    /// If the programme has more than [`MAX_SHADER_STEPS`] steps or erodes.
    pub fn to_wgsl(&self, seed: u64) -> Result<String, ShaderError> {
        self.write(ShaderLanguage::Wgsl, seed, "")
    }

    /// The programme and the elevations that a world makes of it: also `terrane_elevation(metres)` and `terrane_elevation_at(metres, offset)` of plane metres.
    ///
    /// # Errors
    /// If the programme has more than [`MAX_SHADER_STEPS`] steps or erodes, the origin lies beyond 2^31 metres or the scale is below 2^-31.
    pub fn to_shader(&self, language: ShaderLanguage, ground: &Ground) -> Result<String, ShaderError> {
        if ground.frame.scale < 1.0 / FURTHEST || ground.frame.origin.iter().any(|metres| metres.abs() >= FURTHEST) {
            return Err(ShaderError::Plane);
        }
        self.write(language, ground.frame.seed, &elevation(ground))
    }

    fn write(&self, language: ShaderLanguage, seed: u64, more: &str) -> Result<String, ShaderError> {
        let Ok(graph) = Graph::simplified(self.root()) else { return Err(ShaderError::Steps(super::graph::MAX_STEPS)) };
        let order = graph.reachable(graph.root);
        if order.len() > MAX_SHADER_STEPS {
            return Err(ShaderError::Steps(order.len()));
        }
        if order.iter().any(|&id| matches!(graph.steps[id], Step::Erosion(..))) {
            return Err(ShaderError::Erosion);
        }
        let (body, calls) = body::function(&graph, &order);
        let functions = functions(&graph, &calls, seed) + &body + VALUE + more;
        let text = library::used_by(&functions) + &functions;
        let head = format!("// Written by Terrane. Seed {seed}, programme:\n{}\n", commented(&self.to_string()));
        Ok(match language {
            ShaderLanguage::Wgsl => head + text.trim_end() + "\n",
            ShaderLanguage::Glsl => head + PRECISION + glsl::translate(text.trim_end()).as_str(),
        })
    }
}

/// GLSL ES has no default for fragment shaders, and less than 32 bits would do for nothing here.
const PRECISION: &str = "precision highp float;\nprecision highp int;\n\n";

/// The value of a programme by its coordinates.
const VALUE: &str = "// The programme's value at cell + offset, in programme units; |cell| < 2^31.
fn terrane_value_at(cell: vec2<i32>, offset: vec2<f32>) -> f32 {
    return terrane_programme(terrane_moved(TerranePlace(cell, vec2<u32>(0u)), offset));
}

// The programme's value at p, in programme units.
fn terrane_value(p: vec2<f32>) -> f32 {
    return terrane_programme(terrane_place(p));
}

";

/// The elevation by plane coordinates.
fn elevation(ground: &Ground) -> String {
    let Ground { frame: Frame { scale, origin, .. }, amplitude, datum, range } = *ground;
    let float = |number: f64| number::float(number as f32);
    format!(
        "fn terrane_ground(plane: TerranePlace) -> f32 {{
    let units: TerraneSpot = terrane_times(terrane_joined(plane, {}), {});
    let value: f32 = terrane_programme(TerranePlace(vec2<i32>(units.low), units.part));
    return clamp({} + {} * value, {}, {});
}}

// The elevation in metres at metres + offset, x to the east, y to the north; |metres| < 2^31.
fn terrane_elevation_at(metres: vec2<i32>, offset: vec2<f32>) -> f32 {{
    return terrane_ground(terrane_moved(TerranePlace(metres, vec2<u32>(0u)), offset));
}}

// The elevation in metres at a point of the plane, in metres.
fn terrane_elevation(metres: vec2<f32>) -> f32 {{
    return terrane_ground(terrane_place(metres));
}}
",
        number::place(-origin[0], -origin[1]),
        number::factor(1.0 / scale),
        float(datum),
        float(amplitude),
        float(range[0]),
        float(range[1]),
    )
}

/// The functions of noises and shapes that are called.
fn functions(graph: &Graph, calls: &body::Calls, seed: u64) -> String {
    let tables = calls.noises.union(&calls.noise_slopes);
    let (mut text, voronoi) = field::voronois(graph.noises.iter().enumerate().map(|(i, noise)| (noise.basis, calls.noises.contains(&i))));
    for &index in tables {
        text += &field::table(index, &graph.noises[index], seed);
        for (slopes, called) in [(false, &calls.noises), (true, &calls.noise_slopes)] {
            if called.contains(&index) {
                text += &field::function(index, &graph.noises[index], voronoi[index], slopes);
            }
        }
    }
    for (slopes, called) in [(false, &calls.shapes), (true, &calls.shape_slopes)] {
        text.extend(called.iter().map(|&index| shape::function(index, &graph.shapes[index], slopes)));
    }
    text
}

/// A text as comment, in lines of about 120 characters.
fn commented(text: &str) -> String {
    let (mut lines, mut length) = (String::from("//"), 0);
    for word in text.split(' ') {
        if length + word.len() > 120 {
            lines += "\n//";
            length = 0;
        }
        lines += " ";
        lines += word;
        length += word.len() + 1;
    }
    lines + "\n"
}

#[cfg(test)]
mod tests;
