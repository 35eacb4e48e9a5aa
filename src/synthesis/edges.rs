//! Edges with their own scales: where ground bends from flat to steep and back.
//!
//! T. Lindeberg, "Edge detection and ridge detection with automatic scale selection" (1998): the gradient of the ground blurred by a Gaussian of variance t is greatest along its own direction, and t^(1/2) times
//! its square is greatest over t. Points of that kind which touch in place and scale are one edge.

use super::gaussian::{blur, kernel};
use core::ops::Range;
use serde::Serialize;

/// Deviations of the Gaussians, cells, three an octave. The first and the last are there to be compared with; what is found in between spans a factor of three, as two levels do, and coarser
/// edges belong to coarser levels.
const SIGMAS: [f64; 7] = [0.7, 0.881_944_736, 1.111_180_738, 1.4, 1.763_889_472, 2.222_361_475, 2.8];

/// Scales an octave.
const STEPS: f64 = 3.0;

/// Scales that points are found at.
const SCALES: Range<usize> = 1..SIGMAS.len() - 1;

/// By what share a gradient must exceed its neighbours: what plain slopes differ by is rounding.
const RISE: f32 = 1e-3;

/// Points of an edge at least.
const LEAST_POINTS: usize = 3;

/// A point of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// The cell, from west to east.
    pub column: usize,
    /// The cell, from north to south.
    pub row: usize,
    /// Cells from the middle of the north-western cell, to the east and to the south.
    pub position: [f32; 2],
    /// The deviation of the Gaussian, metres.
    pub scale: f32,
    /// (t^(1/2) · |gradient|²)^(1/2), t in m².
    pub strength: f32,
    /// The number of the scale among those that were looked at.
    step: u8,
}

impl EdgePoint {
    /// The number of its scale among those that were looked at, from the finest.
    #[must_use]
    pub fn step(&self) -> u8 {
        self.step
    }
}

/// Points that touch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// Numbers of its points, in order.
    pub points: Vec<usize>,
    /// Mean over its points, metres.
    pub scale: f64,
    /// Metres along its points.
    pub length: f64,
    /// Mean over its points.
    pub strength: f64,
}

/// How far points are linked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linking {
    /// Over the whole area.
    Whole,
    /// Within blocks of so many cells a side from the north-western corner: a change costs its block.
    Blocks(usize),
}

/// Gradients of a grid at one scale.
struct Scale {
    east: Vec<f32>,
    south: Vec<f32>,
    magnitude: Vec<f32>,
    /// The root of the deviation in metres: what makes a gradient's magnitude a strength.
    normal: f32,
}

impl Scale {
    /// Of a blurred grid.
    fn new(heights: &[f32], columns: usize, rows: usize, spacing: f64, sigma: f64) -> Self {
        let scale = (1.0 / (2.0 * spacing)) as f32;
        let row = |row: usize| &heights[row * columns..][..columns];
        let mut gradient = Self {
            east: Vec::with_capacity(heights.len()),
            south: Vec::with_capacity(heights.len()),
            magnitude: Vec::new(),
            normal: (sigma * spacing).sqrt() as f32,
        };
        for y in 0..rows {
            let (north, middle, south) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(rows - 1)));
            gradient.east.extend((0..columns).map(|x| (middle[(x + 1).min(columns - 1)] - middle[x.saturating_sub(1)]) * scale));
            gradient.south.extend(south.iter().zip(north).map(|(south, north)| (south - north) * scale));
        }
        gradient.magnitude = gradient.east.iter().zip(&gradient.south).map(|(east, south)| (east * east + south * south).sqrt()).collect();
        gradient
    }

    /// What the detector answers at a cell.
    fn strength(&self, cell: usize) -> f32 {
        self.normal * self.magnitude[cell]
    }

    /// The magnitude a cell away in a direction of length 1, between the four cells around.
    fn magnitude_at(&self, cell: usize, columns: usize, [east, south]: [f32; 2]) -> f32 {
        let column = if east < 0.0 { cell - 1 } else { cell + 1 };
        let down = |cell: usize| if south < 0.0 { cell - columns } else { cell + columns };
        let (x, y) = (east.abs(), south.abs());
        let near = self.magnitude[cell] * (1.0 - x) + self.magnitude[column] * x;
        let far = self.magnitude[down(cell)] * (1.0 - x) + self.magnitude[down(column)] * x;
        near * (1.0 - y) + far * y
    }

    /// Where between a cell's neighbours in the gradient's direction the gradient is greatest, if it is at the cell.
    fn crest(&self, cell: usize, columns: usize) -> Option<[f32; 2]> {
        let middle = self.magnitude[cell];
        if middle <= 0.0 {
            return None;
        }
        let direction = [self.east[cell] / middle, self.south[cell] / middle];
        let ahead = self.magnitude_at(cell, columns, direction);
        let behind = self.magnitude_at(cell, columns, direction.map(|d| -d));
        if ahead.max(behind) > middle * (1.0 - RISE) {
            return None;
        }
        Some(direction.map(|d| d * summit(behind, middle, ahead)))
    }
}

/// Where between -1/2 and 1/2 a parabola through three values has its summit, the middle one of which is the greatest.
fn summit(before: f32, middle: f32, after: f32) -> f32 {
    let bend = (middle - before) + (middle - after);
    (after - before) / (2.0 * bend)
}

/// Finds points of edges, in the order of rows, columns and scales.
pub(super) fn detect(heights: &[f32], columns: usize, rows: usize, spacing: f64) -> Vec<EdgePoint> {
    if columns < 3 || rows < 3 {
        return Vec::new();
    }
    // Small numbers are blurred with small errors.
    let (low, high) = heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| (low.min(*height), high.max(*height)));
    detect_part(heights, columns, rows, spacing, f32::midpoint(low, high), [0, 0])
}

/// Cells that a point of an edge depends on, to each side.
pub(super) fn reach() -> usize {
    let radius = |i: usize| kernel((SIGMAS[i] * SIGMAS[i] - if i == 0 { 0.0 } else { SIGMAS[i - 1] * SIGMAS[i - 1] }).sqrt()).len() - 1;
    // A cell for the gradient and one for its neighbours'.
    (0..SIGMAS.len()).map(radius).sum::<usize>() + 2
}

/// Finds points in a part of a grid whose north-western cell is `first` of the whole. Further than [`reach`] from sides that are not the whole's, they are those of the whole to the bit if heights
/// are counted from the same `middle`.
pub(super) fn detect_part(heights: &[f32], columns: usize, rows: usize, spacing: f64, middle: f32, first: [usize; 2]) -> Vec<EdgePoint> {
    if columns < 3 || rows < 3 {
        return Vec::new();
    }
    let mut blurred: Vec<f32> = heights.iter().map(|height| height - middle).collect();
    let mut before = 0.0;
    let scales = SIGMAS.map(|sigma| {
        // Variances add up.
        blurred = blur(&blurred, columns, rows, (sigma * sigma - before * before).sqrt());
        before = sigma;
        Scale::new(&blurred, columns, rows, spacing, sigma)
    });
    let mut points = Vec::new();
    for row in 1..rows - 1 {
        for column in 1..columns - 1 {
            points.extend(SCALES.filter_map(|step| point(&scales, step, row * columns + column, columns, spacing, [first[0] + column, first[1] + row])));
        }
    }
    points
}

/// The point at a cell and scale, if there is one.
fn point(scales: &[Scale; SIGMAS.len()], step: usize, cell: usize, columns: usize, spacing: f64, [column, row]: [usize; 2]) -> Option<EdgePoint> {
    let [finer, own, coarser] = [step - 1, step, step + 1].map(|step| scales[step].strength(cell));
    if own <= finer || own <= coarser {
        return None;
    }
    let [east, south] = scales[step].crest(cell, columns)?;
    let between = summit(finer, own, coarser);
    let scale = SIGMAS[step] * spacing * libm::exp2(f64::from(between) / STEPS);
    let strength = own + (coarser - finer) * between / 4.0;
    Some(EdgePoint { column, row, position: [column as f32 + east, row as f32 + south], scale: scale as f32, strength, step: step as u8 })
}

/// Points by their cells.
struct Cells<'a> {
    points: &'a [EdgePoint],
    /// Of every row the number of its first point.
    rows: Vec<usize>,
    linking: Linking,
}

impl<'a> Cells<'a> {
    fn new(points: &'a [EdgePoint], linking: Linking) -> Self {
        let last = points.last().map_or(0, |point| point.row);
        let rows = (0..last + 4).map(|row| points.partition_point(|point| point.row < row)).collect();
        Self { points, rows, linking }
    }

    /// Numbers of the points of a cell.
    fn at(&self, column: usize, row: usize) -> Range<usize> {
        let (start, end) = (self.rows[row], self.rows[row + 1]);
        let points = &self.points[start..end];
        let first = start + points.partition_point(|point| point.column < column);
        let count = self.points[first..end].iter().take_while(|point| point.column == column).count();
        first..first + count
    }

    fn linked(&self, one: &EdgePoint, other: &EdgePoint) -> bool {
        let together = match self.linking {
            Linking::Whole => true,
            Linking::Blocks(side) => [one.column / side, one.row / side] == [other.column / side, other.row / side],
        };
        together && one.step.abs_diff(other.step) <= 1
    }

    /// Whether a point is linked with one in a cell.
    fn touches(&self, one: &EdgePoint, column: usize, row: usize) -> bool {
        self.at(column, row).any(|other| self.linked(one, &self.points[other]))
    }

    /// Links of a point with points to the east and to the south: their numbers, and metres, 0 across a corner that a neighbour goes around.
    fn links(&self, number: usize, spacing: f64, mut link: impl FnMut(usize, f64)) {
        let one = &self.points[number];
        let (column, row) = (one.column, one.row);
        for (east, south) in [(1, 0), (-1, 1), (0, 1), (1, 1)] {
            let Some(x) = column.checked_add_signed(east) else { continue };
            let around = south == 1 && east != 0 && (self.touches(one, x, row) || self.touches(one, column, row + 1));
            for other in self.at(x, row + south) {
                let point = &self.points[other];
                if self.linked(one, point) {
                    let [dx, dy] = [0, 1].map(|axis| f64::from(point.position[axis]) - f64::from(one.position[axis]));
                    link(other, if around { 0.0 } else { (dx * dx + dy * dy).sqrt() * spacing });
                }
            }
        }
    }
}

/// Links points, which are in the order of their detection, to edges, which are in the order of their first points.
#[must_use]
pub fn link(points: &[EdgePoint], spacing: f64, linking: Linking) -> Vec<Edge> {
    let cells = Cells::new(points, linking);
    let mut first: Vec<usize> = (0..points.len()).collect();
    let mut length = vec![0.0; points.len()];
    for (number, length) in length.iter_mut().enumerate() {
        cells.links(number, spacing, |other, metres| {
            let (one, other) = (root(&mut first, number), root(&mut first, other));
            first[one.max(other)] = one.min(other);
            *length += metres;
        });
    }
    let mut edges: Vec<Edge> = Vec::new();
    let mut edge_of = vec![usize::MAX; points.len()];
    for (number, point) in points.iter().enumerate() {
        let root = root(&mut first, number);
        if root == number {
            edge_of[number] = edges.len();
            edges.push(Edge { points: Vec::new(), scale: 0.0, length: 0.0, strength: 0.0 });
        }
        let edge = &mut edges[edge_of[root]];
        edge.points.push(number);
        edge.scale += f64::from(point.scale);
        edge.strength += f64::from(point.strength);
        edge.length += length[number];
    }
    edges.retain(|edge| edge.points.len() >= LEAST_POINTS);
    for edge in &mut edges {
        let count = edge.points.len() as f64;
        edge.scale /= count;
        edge.strength /= count;
    }
    edges
}

/// The first point that a point is joined to.
fn root(first: &mut [usize], mut number: usize) -> usize {
    while first[number] != number {
        first[number] = first[first[number]];
        number = first[number];
    }
    number
}
