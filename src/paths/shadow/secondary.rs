//! Peaks and ridges between the wanted shadows.

use super::{
    super::{canvas::Canvas, document::DrawingError},
    bounds::{Bounds, Part},
    climb::{Kind, Source},
    document::ShadowDrawing,
};
use crate::noise;

/// Places that are tried for every feature; one that finds none is left out.
const TRIES: u64 = 64;

/// Lengths of ridges, shares of the shorter side.
const LENGTHS: [f64; 2] = [0.08, 0.3];

/// A number 0 … 1 out of a hash.
fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// Where secondary features lie, and how high: between the base and what the light allows, by the drawing's shares. `scale` is that of their flanks.
pub(super) fn place(canvas: &Canvas, drawing: &ShadowDrawing, base: &[f32], bounds: &Bounds, scale: f32) -> Result<Vec<Source>, DrawingError> {
    let secondary = &drawing.secondary;
    if secondary.peaks + secondary.ridges == 0 {
        return Ok(Vec::new());
    }
    let shares = canvas.ramp(&drawing.shares(), "/secondary/heights")?;
    let free = |slot: u32| bounds.parts[slot as usize] == Part::Free;
    let mut slots: Vec<u32> = Vec::new();
    for peak in 0..secondary.peaks as u64 {
        let key = noise::key(noise::key(canvas.seed, 5), peak);
        slots.extend((0..TRIES).map(|n| canvas.by_chance(key, n)).find(|slot| free(*slot)));
    }
    for ridge in 0..secondary.ridges as u64 {
        let key = noise::key(noise::key(canvas.seed, 6), ridge);
        slots.extend((0..TRIES).find_map(|n| line(canvas, noise::key(key, n), &free)).into_iter().flatten());
    }
    slots.sort_unstable();
    slots.dedup();
    let of = |slot: u32| {
        let i = slot as usize;
        let height = base[i] + (bounds.upper[i] - base[i]) * shares[i];
        Source { slot, height, scale, kind: Kind::Secondary }
    };
    Ok(slots.into_iter().filter(|slot| !matches!(bounds.parts[*slot as usize], Part::Hole | Part::Crest)).map(of).collect())
}

/// The nodes of a ridge, if both its ends are free: a line bent at its quarters.
fn line(canvas: &Canvas, key: u64, free: &impl Fn(u32) -> bool) -> Option<Vec<u32>> {
    let draw = |n: u64| unit(noise::key(key, n));
    let shorter = canvas.inner.columns.min(canvas.inner.rows) as f64 * canvas.spacing;
    let length = shorter * (LENGTHS[0] + (LENGTHS[1] - LENGTHS[0]) * draw(1));
    let angle = core::f64::consts::TAU * draw(2);
    let along = [libm::cos(angle), libm::sin(angle)].map(|c| c * length);
    let start = canvas.frame.node(canvas.by_chance(key, 0) as usize);
    let start = [start.column, start.row].map(|n| n as f64 * canvas.spacing);
    let point = |quarter: u64| {
        let bend = if quarter.is_multiple_of(4) { 0.0 } else { (draw(2 + quarter) - 0.5) * 0.4 };
        let share = quarter as f64 / 4.0;
        [start[0] + along[0] * share - along[1] * bend, start[1] + along[1] * share + along[0] * bend]
    };
    let points: Vec<[f64; 2]> = (0..=4).map(point).collect();
    let is_free = |point: [f64; 2]| canvas.along(&[point]).first().is_some_and(|slot| free(*slot));
    (is_free(points[0]) && is_free(points[4])).then(|| canvas.along(&points).into_iter().collect())
}
