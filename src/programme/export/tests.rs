use super::*;
use crate::noise::{Basis, Field, FieldShape, key};

/// Blender's noise at a point of the lattice's middle cell, plainly and without its scale.
fn unscaled_blender(own: u64, u: f64, v: f64) -> f64 {
    let bits = key(own, 0);
    let [x, y] = [(u, bits >> 32), (v, bits >> 48)].map(|(at, bits)| at + (bits & 0xffff) as f64 / 65_536.0);
    let mut sum = 0.0;
    for (i, j) in [(0_i64, 0_i64), (1, 0), (0, 1), (1, 1)] {
        let (i, j) = (x.floor() as i64 + i, y.floor() as i64 + j);
        let column = (i as u32).wrapping_mul(0x9e37_79b1) ^ ((i >> 32) as u32).wrapping_mul(0x27d4_eb2f);
        let row = (j as u32).wrapping_mul(0x85eb_ca77) ^ ((j >> 32) as u32).wrapping_mul(0xc2b2_ae3d) ^ bits as u32;
        let h = column ^ row;
        let h = (h ^ (h >> 16)).wrapping_mul(0x21f0_aaad);
        let h = (h ^ (h >> 15)).wrapping_mul(0xd35a_2d97);
        let angle = (f64::from((h ^ (h >> 15)) >> 28) + 0.5) * core::f64::consts::TAU / 16.0;
        let (dx, dy) = (x - i as f64, y - j as f64);
        let r = (dx * dx + dy * dy).sqrt();
        if r < 1.0 {
            sum += (1.0 - 3.0 * r * r + 2.0 * r * r * r) * (libm::cos(angle) * dx + libm::sin(angle) * dy);
        }
    }
    sum
}

#[test]
fn the_scale_of_blenders_noise_is_that_of_the_server() {
    let library = library::used_by("TERRANE_BLENDER_SCALE");
    let scale: f64 = library.split("f32 = ").nth(1).and_then(|rest| rest.split(';').next()).and_then(|number| number.parse().ok()).expect("a number");
    let field = Field::exact(FieldShape::Single, Basis::Blender, 5);
    for (u, v) in [(0.3, 0.4), (7.7, -3.2), (-20.1, 0.9)] {
        let (got, want) = (scale * unscaled_blender(5, u, v), f64::from(field.at(u, v)));
        assert!((got - want).abs() < 1e-5, "{got} is not {want}: the library's scale should be {}", scale * want / got);
    }
}

#[test]
fn a_small_programme_is_a_small_shader() {
    let text = Programme::parse("plus(x, multiply(0.5, plus(y, 2)))").expect("valid").to_wgsl(7).expect("small");
    assert!(text.starts_with("// Written by Terrane. Seed 7, programme:\n// plus(x, multiply(0.5, plus(y, 2)))\n"), "{text}");
    assert!(text.contains("    let v4: f32 = terrane_finite(v2 + 2.0);\n") || text.contains("+ 2.0);"), "{text}");
    assert!(!text.contains("terrane_ln") && !text.contains("TerraneLattice"), "only what is used is there: {text}");
    let glsl = Programme::parse("sphere(2)").expect("valid").to_glsl(7).expect("small");
    assert!(!glsl.contains("let ") && !glsl.contains("f32") && !glsl.contains("->"), "{glsl}");
}

#[test]
fn what_is_too_large_is_refused() {
    let nested = "smooth(smooth(smooth(fbm(1, 2, 8), 0.1), 0.1), 0.1)";
    let error = Programme::parse(nested).expect("valid").to_glsl(1).expect_err("19 x 19 x 19 places");
    assert!(matches!(error, ShaderError::Steps(steps) if steps > MAX_SHADER_STEPS));
}

#[test]
fn numbers_alone_are_folded_as_the_server_does() {
    let text = Programme::parse("plus(multiply(1e30, 1e30), divide(1, 0))").expect("valid").to_wgsl(1).expect("small");
    assert!(text.contains("    return 1.0;\n"), "{text}");
}

#[test]
fn planes_that_do_not_fit_are_refused() {
    let programme = Programme::parse("x").expect("valid");
    let shader = |scale, west| {
        let frame = Frame { seed: 1, scale, origin: [west, 0.0] };
        programme.to_shader(ShaderLanguage::Wgsl, &Ground { frame, amplitude: 1.0, datum: 0.0, range: [0.0, 1.0] })
    };
    assert!(shader(1e-3, 2e9).is_ok());
    assert_eq!([shader(1.0, 3e9), shader(1e-10, 0.0)], [Err(ShaderError::Plane), Err(ShaderError::Plane)]);
}
