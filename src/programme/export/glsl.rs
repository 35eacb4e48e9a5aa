//! From the part of WGSL that exports are written in to GLSL ES 3.00.
//!
//! The part: one declaration or statement a line, every type written out, and no function that the two languages spell or order differently (`select`).

/// Types and conversions by their names in both languages, longer names before those they contain.
const NAMES: [(&str, &str); 13] = [
    ("vec2<f32>", "vec2"),
    ("vec3<f32>", "vec3"),
    ("vec4<f32>", "vec4"),
    ("vec2<u32>", "uvec2"),
    ("vec3<u32>", "uvec3"),
    ("vec2<i32>", "ivec2"),
    ("bitcast<u32>(", "floatBitsToUint("),
    ("bitcast<f32>(", "uintBitsToFloat("),
    ("f32(", "float("),
    ("u32(", "uint("),
    ("i32(", "int("),
    ("array<TerraneLattice, ", "TerraneLattice["),
    ("array<u32, ", "uint["),
];

/// Translates a whole text.
pub(super) fn translate(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for line in text.lines() {
        let code = line.trim_start();
        all.push_str(&line[..line.len() - code.len()]);
        all.push_str(&statement(code));
        all.push('\n');
    }
    all
}

fn statement(code: &str) -> String {
    if code.starts_with("//") {
        return code.to_owned();
    }
    let translated = code
        .strip_prefix("struct ")
        .and_then(structure)
        .or_else(|| code.strip_prefix("fn ").and_then(function))
        .or_else(|| code.strip_prefix("const ").and_then(declaration).map(|rest| format!("const {rest}")))
        .or_else(|| code.strip_prefix("let ").or_else(|| code.strip_prefix("var ")).and_then(declaration))
        .or_else(|| code.strip_prefix("for (var ").and_then(declaration).map(|rest| format!("for ({rest}")));
    translated.unwrap_or_else(|| expression(code))
}

/// `Name { a: T, b: U }`.
fn structure(code: &str) -> Option<String> {
    let (name, fields) = code.strip_suffix(" }")?.split_once(" { ")?;
    let fields: Option<String> = fields.split(", ").map(|field| typed(field).map(|field| format!("{field}; "))).collect();
    Some(format!("struct {name} {{ {}}};", fields?))
}

/// `name(a: T, b: U) -> R {`.
fn function(code: &str) -> Option<String> {
    let (name, rest) = code.split_once('(')?;
    let (parameters, result) = rest.strip_suffix(" {")?.split_once(") -> ")?;
    let parameters: Option<Vec<String>> = parameters.split(", ").map(typed).collect();
    Some(format!("{} {name}({}) {{", type_name(result), parameters?.join(", ")))
}

/// `name: T = value`.
fn declaration(code: &str) -> Option<String> {
    let (left, value) = code.split_once(" = ")?;
    Some(format!("{} = {}", typed(left)?, expression(value)))
}

/// `name: T`, which GLSL writes the other way round.
fn typed(code: &str) -> Option<String> {
    let (name, kind) = code.split_once(": ")?;
    Some(format!("{} {name}", type_name(kind)))
}

fn type_name(kind: &str) -> String {
    match kind {
        "f32" => "float".to_owned(),
        "u32" => "uint".to_owned(),
        "i32" => "int".to_owned(),
        _ => expression(kind),
    }
}

fn expression(code: &str) -> String {
    let mut text = NAMES.iter().fold(code.to_owned(), |text, (wgsl, glsl)| text.replace(wgsl, glsl));
    // What is left of `array<T, 4>` is `T[4>`.
    for open in ["TerraneLattice[", "uint["] {
        if let Some(at) = text.find(open).filter(|at| text[*at + open.len()..].starts_with(|c: char| c.is_ascii_digit())) {
            let end = text[at..].find('>').map_or(text.len(), |end| at + end);
            text.replace_range(end..(end + 1).min(text.len()), "]");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_of_a_line() {
        let check = |wgsl: &str, glsl: &str| assert_eq!(translate(wgsl), format!("{glsl}\n"));
        check("struct A { b: vec2<i32>, c: f32 }", "struct A { ivec2 b; float c; };");
        check("fn f(a: vec2<f32>, b: u32) -> f32 {", "float f(vec2 a, uint b) {");
        check("    let x: u32 = bitcast<u32>(f32(a.x) + 1.0) >> 2u;", "    uint x = floatBitsToUint(float(a.x) + 1.0) >> 2u;");
        check("for (var k: i32 = 0; k < 4; k++) {", "for (int k = 0; k < 4; k++) {");
        check("const T: array<u32, 2> = array<u32, 2>(1u, 2u);", "const uint[2] T = uint[2](1u, 2u);");
        check("if (a > 0.0) { return vec3<f32>(0.0); }", "if (a > 0.0) { return vec3(0.0); }");
        check("// let x: f32 = 1.0;", "// let x: f32 = 1.0;");
    }
}
