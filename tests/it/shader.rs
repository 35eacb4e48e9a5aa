//! Exported shaders are valid: `naga` reads and checks every one. That they compute what the server computes is shown in a browser (`tests/browser`).

use naga::valid::{Capabilities, ValidationFlags, Validator};
use terrane::{
    programme::{Programme, Signature},
    world::EXAMPLES,
};

/// `tolerance: programme` a line, or `tolerance: programme == other`, covering every operation, basis, metric and fractal.
const PROGRAMMES: &str = include_str!("../browser/programmes.txt");

fn programmes() -> impl Iterator<Item = &'static str> {
    let lines = PROGRAMMES.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(|line| line.split_once(": ").unwrap().1).map(|text| text.split_once(" == ").map_or(text, |(first, _)| first))
}

fn validate(module: &naga::Module) -> Result<(), String> {
    Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module).map(drop).map_err(|error| format!("{error:?}"))
}

fn check_wgsl(name: &str, source: &str, call: &str) {
    let whole =
        format!("{source}\n@fragment fn main(@builtin(position) p: vec4<f32>) -> @location(0) vec4<f32> {{ return vec4<f32>({call}(p.xy), 0.0, 0.0, 1.0); }}");
    let module = naga::front::wgsl::parse_str(&whole).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&whole)));
    validate(&module).unwrap_or_else(|error| panic!("{name}: {error}\n{whole}"));
}

fn check_glsl(name: &str, source: &str, call: &str) {
    let main = format!("layout(location = 0) out vec4 result;\nvoid main() {{ result = vec4({call}(gl_FragCoord.xy), 0.0, 0.0, 1.0); }}");
    let whole = format!("#version 460 core\n{source}\n{main}\n");
    let options = naga::front::glsl::Options::from(naga::ShaderStage::Fragment);
    let module = naga::front::glsl::Frontend::default().parse(&options, &whole).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&whole)));
    validate(&module).unwrap_or_else(|error| panic!("{name}: {error}\n{whole}"));
}

#[test]
fn every_operation_is_among_the_programmes() {
    for signature in Signature::all() {
        let called = |text: &str| text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).any(|word| word == signature.name);
        // Erosion is refused.
        assert!(signature.name == "erosion" || programmes().any(called), "no programme has {}", signature.name);
    }
}

#[test]
fn every_operation_is_valid_wgsl_and_glsl() {
    for text in programmes() {
        let programme = Programme::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        check_wgsl(text, &programme.to_wgsl(7).unwrap(), "terrane_value");
        check_glsl(text, &programme.to_glsl(7).unwrap(), "terrane_value");
    }
}

#[test]
fn every_example_world_is_valid_wgsl_and_glsl() {
    use terrane::{
        programme::{ShaderError, ShaderLanguage},
        world::{Document, World},
    };
    for example in EXAMPLES {
        let world = World::new(Document::parse(example.json.as_bytes()).unwrap());
        if example.json.contains("erosion(") {
            assert_eq!(world.shader(ShaderLanguage::Wgsl), Err(ShaderError::Erosion), "{}", example.name);
            continue;
        }
        check_wgsl(example.name, &world.shader(ShaderLanguage::Wgsl).unwrap(), "terrane_elevation");
        let says_so = world.shader(ShaderLanguage::Glsl).unwrap().starts_with("// The base of the world alone, without what lies above it: its layers (");
        assert_eq!(says_so, !world.document().layers.is_empty(), "{}", example.name);
        check_glsl(example.name, &world.shader(ShaderLanguage::Glsl).unwrap(), "terrane_elevation");
    }
}
