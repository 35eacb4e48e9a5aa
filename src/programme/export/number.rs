//! Numbers as shader source has them.

/// A finite f32.
pub(super) fn float(number: f32) -> String {
    let text = if number.abs() > 3.4e38 { format!("{:?}", f64::from(number)) } else { format!("{number:?}") };
    if number.is_sign_negative() { format!("({text})") } else { text }
}

/// The integer below a number and the rest in 2^-32.
fn halves(number: f64) -> (i32, u32) {
    let number = number.clamp(-2_147_483_648.0, 2_147_483_647.5);
    let cell = number.floor();
    (cell as i32, ((number - cell) * 4_294_967_296.0).round() as u32)
}

/// A constant place.
pub(super) fn place(u: f64, v: f64) -> String {
    let ((i, a), (j, b)) = (halves(u), halves(v));
    format!("TerranePlace(vec2<i32>({}, {}), vec2<u32>({a}u, {b}u))", integer(i), integer(j))
}

/// -2^31 is no literal: it is the negative of one that is too great.
fn integer(number: i32) -> String {
    if number == i32::MIN { "-2147483647 - 1".to_owned() } else { number.to_string() }
}

/// A factor of [0, 2^32) in whole numbers, 2^-32 and 2^-64.
pub(super) fn factor(number: f64) -> String {
    let mut rest = number.clamp(0.0, 4_294_967_295.0);
    let [whole, fine, finest] = core::array::from_fn(|_| {
        let word = rest.floor();
        rest = (rest - word) * 4_294_967_296.0;
        word as u32
    });
    format!("vec3<u32>({whole}u, {fine}u, {finest}u)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_exactly() {
        assert_eq!([1.0, -0.5, 1e30, 1e-7].map(float), ["1.0", "(-0.5)", "1e30", "1e-7"]);
        assert_eq!(float(f32::MAX), "3.4028234663852886e38");
        assert_eq!(place(-0.25, 3.5), "TerranePlace(vec2<i32>(-1, 3), vec2<u32>(3221225472u, 2147483648u))");
        assert_eq!(place(-1e12, 0.0), "TerranePlace(vec2<i32>(-2147483647 - 1, 0), vec2<u32>(0u, 0u))");
        assert_eq!(factor(2.5), "vec3<u32>(2u, 2147483648u, 0u)");
        assert_eq!(factor(2.0_f64.powi(-40)), "vec3<u32>(0u, 0u, 16777216u)");
    }
}
