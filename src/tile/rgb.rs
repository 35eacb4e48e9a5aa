//! Elevations in three bytes, rounded to nearest.

/// Metres of a step of `terrarium` and of `terrain-rgb`.
pub(super) const TERRARIUM_STEP: f64 = 1.0 / 256.0;
pub(super) const TERRAIN_RGB_STEP: f64 = 0.1;

/// R·256 + G + B/256 - 32768 (Tilezen); steps of 1/256 m.
#[inline]
pub(super) fn terrarium(elevation: f32, bits: u32) -> [u8; 3] {
    pack((f64::from(elevation) + 32_768.0) * 256.0, bits)
}

/// -10000 + (R·65536 + G·256 + B)/10 (Mapbox); steps of 1/10 m.
#[inline]
pub(super) fn terrain_rgb(elevation: f32, bits: u32) -> [u8; 3] {
    pack((f64::from(elevation) + 10_000.0) * 10.0, bits)
}

#[inline]
fn pack(steps: f64, bits: u32) -> [u8; 3] {
    // The cast truncates towards zero and saturates at zero.
    bytes((steps + 0.5) as u32, bits)
}

/// A number of steps as red, green and blue, its last bits rounded away.
#[inline]
pub(super) fn bytes(number: u32, bits: u32) -> [u8; 3] {
    let half = (1_u32 << bits) >> 1;
    let rounded = (number.min(0xff_ffff) + half) & (u32::MAX << bits);
    let [_, r, g, b] = rounded.min(0xff_ffff & (u32::MAX << bits)).to_be_bytes();
    [r, g, b]
}

/// How many last bits of a number of steps, each of so many metres, samples at a spacing do not justify: what is left of a height is at most a 64th of the spacing, which
/// is a slope of a degree between neighbours, and at most 16 m.
pub(super) fn needless_bits(step: f64, spacing: f64) -> u32 {
    let coarsest = (spacing / 64.0).min(16.0);
    (1..=16).take_while(|bits| step * f64::from(1_u32 << bits) <= coarsest).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elevations_come_back_within_half_a_step() {
        for i in 0..200_000_u32 {
            let elevation = -10_000.0 + f64::from(i) * 0.213_7;
            let elevation = elevation.min(32_767.0) as f32;
            let [r, g, b] = terrarium(elevation, 0).map(f64::from);
            assert!((r * 256.0 + g + b / 256.0 - 32_768.0 - f64::from(elevation)).abs() <= 0.5 / 256.0);
            let [r, g, b] = terrain_rgb(elevation, 0).map(f64::from);
            assert!((-10_000.0 + (r * 65_536.0 + g * 256.0 + b) * 0.1 - f64::from(elevation)).abs() <= 0.05 + 1e-9);
        }
    }

    #[test]
    fn known_values() {
        assert_eq!((terrarium(0.0, 0), terrarium(-32_768.0, 0), terrarium(32_767.996, 0)), ([128, 0, 0], [0, 0, 0], [255, 255, 255]));
        assert_eq!((terrain_rgb(0.0, 0), terrain_rgb(-10_000.0, 0), terrain_rgb(8_848.9, 0)), ([1, 134, 160], [0, 0, 0], [2, 224, 73]));
        assert_eq!((terrarium(-40_000.0, 0), terrarium(1e9, 0)), ([0, 0, 0], [255, 255, 255]), "what does not fit is clamped");
    }

    #[test]
    fn what_the_spacing_does_not_justify_is_rounded_away() {
        // Metres a pixel of the web's map at levels 0, 10, 14 and 20: 16, 2, 1/8 and 1/256 m.
        let bits = [156_543.0, 152.9, 9.55, 0.149].map(|spacing| (needless_bits(TERRARIUM_STEP, spacing), needless_bits(TERRAIN_RGB_STEP, spacing)));
        assert_eq!(bits, [(12, 7), (9, 4), (5, 0), (0, 0)]);
        for i in 0..100_000_u32 {
            let elevation = (-9_000.0 + f64::from(i) * 0.213_7) as f32;
            let [r, g, b] = terrarium(elevation, 9).map(f64::from);
            let back = r * 256.0 + g + b / 256.0 - 32_768.0;
            assert!((back - f64::from(elevation)).abs() <= 1.0 + 0.5 / 256.0 && back % 2.0 == 0.0, "{elevation} came back as {back}");
        }
        assert_eq!((bytes(0xff_ffff, 4), bytes(u32::MAX, 4), bytes(7, 4), bytes(8, 4)), ([255, 255, 240], [255, 255, 240], [0, 0, 0], [0, 0, 16]));
    }
}
