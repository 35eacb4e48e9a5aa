//! Shaded relief.

use crate::{analysis, geometry::Surface};

/// Towards the light, as east, north and up: azimuth 315°, altitude 45°.
const LIGHT: [f32; 3] = [-0.5, 0.5, core::f32::consts::FRAC_1_SQRT_2];

/// Lambert's grey of every sample within an apron of one: 255 facing the light, 180 on flat ground, 0 turned away.
///
/// Source: the reflectance map of B. K. P. Horn, "Hill shading and the reflectance map" (1981).
pub(super) fn shade(surface: &Surface, spacing: f64) -> Vec<u8> {
    let mut greys = Vec::with_capacity(surface.elevation.len());
    for row in 1..surface.rows - 1 {
        for column in 1..surface.columns - 1 {
            let [east, north] = analysis::gradient(surface, row, column, spacing);
            // The normal is (-dz/dx, -dz/dy, 1) over its length.
            let facing = (LIGHT[2] - east * LIGHT[0] - north * LIGHT[1]) / (1.0 + east * east + north * north).sqrt();
            greys.push((facing * 255.0 + 0.5) as u8);
        }
    }
    greys
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(dx: f32, dy: f32) -> u8 {
        let elevation = (0..9_u8).map(|i| dx * f32::from(i % 3) - dy * f32::from(i / 3)).collect();
        shade(&Surface { columns: 3, rows: 3, elevation, ..Surface::default() }, 1.0)[0]
    }

    #[test]
    fn slopes_that_face_the_north_west_are_bright() {
        assert_eq!(grey(0.0, 0.0), 180);
        // Rising to the south-east: facing the light.
        assert_eq!(grey(core::f32::consts::FRAC_1_SQRT_2, -core::f32::consts::FRAC_1_SQRT_2), 255);
        assert_eq!(grey(-5.0, 5.0), 0);
        assert_eq!(grey(1.0, 1.0), grey(-1.0, -1.0));
    }
}
