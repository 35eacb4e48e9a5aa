//! Slopes of a surface.

use crate::geometry::Surface;

/// The gradient (dz/dx to the east, dz/dy to the north; metres per metre) at an inner sample.
///
/// Third-order finite difference of the 3 × 3 samples around it: B. K. P. Horn, "Hill shading and the reflectance map" (1981).
///
/// # Panics
/// If the sample has not all eight neighbours.
#[must_use]
pub fn gradient(surface: &Surface, row: usize, column: usize, spacing: f64) -> [f32; 2] {
    let [north, middle, south] = [row - 1, row, row + 1].map(|row| &surface.row(row)[column - 1..=column + 1]);
    let east_west = (north[2] + 2.0 * middle[2] + south[2]) - (north[0] + 2.0 * middle[0] + south[0]);
    let north_south = (north[0] + 2.0 * north[1] + north[2]) - (south[0] + 2.0 * south[1] + south[2]);
    let scale = (1.0 / (8.0 * spacing)) as f32;
    [east_west * scale, north_south * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_its_own_gradient() {
        let mut surface = Surface { columns: 3, rows: 3, ..Surface::default() };
        for row in 0..3_u8 {
            for column in 0..3_u8 {
                surface.elevation.push(10.0 + 3.0 * f32::from(column) * 5.0 - 2.0 * f32::from(row) * 5.0);
            }
        }
        assert_eq!(gradient(&surface, 1, 1, 5.0), [3.0, 2.0]);
    }
}
