//! Elevations in three bytes, rounded to nearest.

/// R·256 + G + B/256 - 32768 (Tilezen); steps of 1/256 m.
#[inline]
pub(super) fn terrarium(elevation: f32) -> [u8; 3] {
    pack((f64::from(elevation) + 32_768.0) * 256.0)
}

/// -10000 + (R·65536 + G·256 + B)/10 (Mapbox); steps of 1/10 m.
#[inline]
pub(super) fn terrain_rgb(elevation: f32) -> [u8; 3] {
    pack((f64::from(elevation) + 10_000.0) * 10.0)
}

#[inline]
fn pack(steps: f64) -> [u8; 3] {
    // The cast truncates towards zero and saturates at zero.
    let [_, r, g, b] = ((steps + 0.5) as u32).min(0xff_ffff).to_be_bytes();
    [r, g, b]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elevations_come_back_within_half_a_step() {
        for i in 0..200_000_u32 {
            let elevation = -10_000.0 + f64::from(i) * 0.213_7;
            let elevation = elevation.min(32_767.0) as f32;
            let [r, g, b] = terrarium(elevation).map(f64::from);
            assert!((r * 256.0 + g + b / 256.0 - 32_768.0 - f64::from(elevation)).abs() <= 0.5 / 256.0);
            let [r, g, b] = terrain_rgb(elevation).map(f64::from);
            assert!((-10_000.0 + (r * 65_536.0 + g * 256.0 + b) * 0.1 - f64::from(elevation)).abs() <= 0.05 + 1e-9);
        }
    }

    #[test]
    fn known_values() {
        assert_eq!((terrarium(0.0), terrarium(-32_768.0), terrarium(32_767.996)), ([128, 0, 0], [0, 0, 0], [255, 255, 255]));
        assert_eq!((terrain_rgb(0.0), terrain_rgb(-10_000.0), terrain_rgb(8_848.9)), ([1, 134, 160], [0, 0, 0], [2, 224, 73]));
        assert_eq!((terrarium(-40_000.0), terrarium(1e9)), ([0, 0, 0], [255, 255, 255]), "what does not fit is clamped");
    }
}
