//! From lines to a lattice of heights: midpoint displacement (Yao 2008, section 4.1.2).

use super::{population::Lines, settings::Ground};
use crate::genetic::Draws;

/// Mean and deviation of a midpoint's displacement, as shares of the difference of the points around it.
const DISPLACEMENT: [f64; 2] = [0.2, 0.125];

/// The heights of a generation, row by row from the south; displacements follow from the seed and their place alone, never from the generation.
pub(super) fn heights(ground: &Ground, lines: &Lines) -> Vec<f32> {
    let [mut columns, mut rows] = ground.coarse_size();
    let mut heights = vec![0.0; columns * rows];
    for (x, line) in lines.iter().enumerate() {
        for (z, height) in line.heights(rows).enumerate() {
            heights[z * columns + x] = ground.mean as f32 + height;
        }
    }
    for pass in 0..ground.passes {
        heights = along_x(ground, &heights, columns, pass);
        columns = 2 * columns - 1;
        heights = along_z(ground, &heights, columns, pass);
        rows = 2 * rows - 1;
    }
    debug_assert_eq!(heights.len(), columns * rows, "two passes a round");
    heights
}

fn midpoint(ground: &Ground, [a, b]: [f32; 2], place: [u64; 4]) -> f32 {
    let [mean, deviation] = DISPLACEMENT;
    let mut draws = Draws::of(ground.seed, &[0x6d69_6470, place[0], place[1], place[2], place[3]]);
    let (a, b) = (f64::from(a), f64::from(b));
    let middle = f64::midpoint(a, b) + (b - a).abs() * (mean + deviation * draws.normal());
    middle.clamp(ground.range[0], ground.range[1]) as f32
}

fn along_x(ground: &Ground, heights: &[f32], columns: usize, pass: u32) -> Vec<f32> {
    let mut finer = Vec::with_capacity(2 * heights.len());
    for (z, row) in heights.chunks(columns).enumerate() {
        for (x, pair) in row.windows(2).enumerate() {
            finer.extend([pair[0], midpoint(ground, [pair[0], pair[1]], [pass.into(), 0, 2 * x as u64 + 1, z as u64])]);
        }
        finer.extend(row.last());
    }
    finer
}

fn along_z(ground: &Ground, heights: &[f32], columns: usize, pass: u32) -> Vec<f32> {
    let mut finer = Vec::with_capacity(2 * heights.len());
    let rows: Vec<&[f32]> = heights.chunks(columns).collect();
    for (z, pair) in rows.windows(2).enumerate() {
        finer.extend(pair[0]);
        let place = |x: usize| [pass.into(), 1, x as u64, 2 * z as u64 + 1];
        finer.extend(pair[0].iter().zip(pair[1]).enumerate().map(|(x, (a, b))| midpoint(ground, [*a, *b], place(x))));
    }
    finer.extend(rows.last().copied().unwrap_or_default());
    finer
}
