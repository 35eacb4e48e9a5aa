//! Slopes and normals of the ground, as pictures.

use crate::{analysis, geometry::Surface};

/// The gradient of every sample within an apron of one, row by row.
fn gradients(surface: &Surface, spacing: f64) -> impl Iterator<Item = [f32; 2]> + '_ {
    let places = (1..surface.rows - 1).flat_map(|row| (1..surface.columns - 1).map(move |column| [row, column]));
    places.map(move |[row, column]| analysis::gradient(surface, row, column, spacing))
}

/// The steepest slope of every sample within an apron of one, in half degrees: 0 flat, 90 as steep as 45°, at most 180.
pub(super) fn half_degrees(surface: &Surface, spacing: f64) -> Vec<u8> {
    let rise = |[east, north]: [f32; 2]| f64::from((east * east + north * north).sqrt());
    gradients(surface, spacing).map(|gradient| (libm::atan(rise(gradient)).to_degrees() * 2.0 + 0.5) as u8).collect()
}

/// The unit normal of every sample within an apron of one as red (east), green (north) and blue (up): -1 … 1 as 0 … 255.
pub(super) fn normals(surface: &Surface, spacing: f64) -> Vec<u8> {
    let pixel = |[east, north]: [f32; 2]| {
        let length = (1.0 + east * east + north * north).sqrt();
        [-east, -north, 1.0].map(|part| (part / length * 127.5 + 128.0) as u8)
    };
    gradients(surface, spacing).flat_map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(to_east: f32, to_north: f32) -> Surface {
        let elevation = (0..9_u8).map(|i| to_east * f32::from(i % 3) - to_north * f32::from(i / 3)).collect();
        Surface { columns: 3, rows: 3, elevation, ..Surface::default() }
    }

    #[test]
    fn slopes_are_in_half_degrees() {
        assert_eq!(half_degrees(&plane(0.0, 0.0), 1.0), [0]);
        assert_eq!(half_degrees(&plane(1.0, 0.0), 1.0), [90]);
        assert_eq!(half_degrees(&plane(0.0, -0.577_350_3), 1.0), [60]);
        assert_eq!(half_degrees(&plane(1.0, 0.0), 1e-9), [180]);
    }

    #[test]
    fn normals_lean_away_from_the_rise() {
        assert_eq!(normals(&plane(0.0, 0.0), 1.0), [128, 128, 255]);
        assert_eq!(normals(&plane(1.0, 0.0), 1.0), [37, 128, 218]);
        assert_eq!(normals(&plane(0.0, 1.0), 1.0), [128, 37, 218]);
    }
}
