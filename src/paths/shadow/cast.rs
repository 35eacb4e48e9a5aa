//! Shadows that heights cast.

use super::{super::plan::Heights, light::Light};
use rayon::prelude::*;

/// Of every node whether it lies in the shadow of others, row by row from the north: from it towards the light, a step along the axis that the light follows most at a time, heights in
/// between are linear.
#[must_use]
pub fn cast(heights: &Heights, spacing: f64, light: &Light) -> Vec<bool> {
    let Heights { columns, rows, metres, .. } = heights;
    let most = f64::from(metres.iter().copied().fold(f32::NEG_INFINITY, f32::max));
    let [east, north] = light.direction();
    // Towards the light, in columns and in rows from the north.
    let towards = [-east, north];
    let along = towards[0].abs().max(towards[1].abs());
    let [i, j] = towards.map(|c| c / along);
    let rise = light.fall() * spacing / along;
    let at = |x: f64, y: f64| -> Option<f64> {
        let inside = x >= 0.0 && y >= 0.0 && x <= (columns - 1) as f64 && y <= (rows - 1) as f64;
        inside.then(|| {
            let (x0, y0) = (x.floor(), y.floor());
            let of = |column: usize, row: usize| f64::from(metres[row.min(rows - 1) * columns + column.min(columns - 1)]);
            let (column, row, s, t) = (x0 as usize, y0 as usize, x - x0, y - y0);
            let west_east = |row: usize| of(column, row) + (of(column + 1, row) - of(column, row)) * s;
            west_east(row) + (west_east(row + 1) - west_east(row)) * t
        })
    };
    let is_shaded = |n: usize| {
        let (column, row) = ((n % columns) as f64, (n / columns) as f64);
        let own = f64::from(metres[n]);
        let steps = (1..).map(|step| step as f64).take_while(|step| own + step * rise < most);
        steps.map_while(|step| at(column + step * i, row + step * j).map(|height| (step, height))).any(|(step, height)| height > own + step * rise)
    };
    (0..metres.len()).into_par_iter().map(is_shaded).collect()
}
