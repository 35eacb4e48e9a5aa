//! The nodes of a drawing: where its shapes lie, and what programmes say of them.

use super::{
    document::{Drawing, DrawingError, Geometry, Quantity, Ramp},
    lattice::{Frame, Node},
};
use crate::{
    geometry::{Axis, Filter, Window},
    noise,
    programme::{self, Programme, Tape},
};
use std::{cell::Cell, collections::BTreeSet};

/// Slots, each once, in ascending order.
pub(super) type Slots = BTreeSet<u32>;

/// Nodes that the shapes of a drawing may have together.
const MOST_DRAWN: f64 = 8_388_608.0;

/// Predicted nanoseconds that the programmes of a drawing may take together.
const MOST_NS: f64 = 4e9;

/// A drawing's nodes in the plane.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    /// Predicted nanoseconds that its programmes took so far, and nodes that its shapes have.
    spent: Cell<f64>,
    drawn: Cell<f64>,
    /// What is drawn on.
    pub inner: Frame,
    /// That and a margin around, which paths may use.
    pub frame: Frame,
    pub origin: [f64; 2],
    pub spacing: f64,
    pub seed: u64,
}

impl Canvas {
    /// With a margin of so many nodes.
    pub(super) fn new(drawing: &Drawing, margin: usize) -> Self {
        let [columns, rows] = drawing.size;
        let inner = Frame { first: Node { row: 0, column: 0 }, columns, rows };
        Self {
            spent: Cell::new(0.0),
            drawn: Cell::new(0.0),
            inner,
            frame: inner.grown(margin),
            origin: drawing.origin,
            spacing: drawing.spacing,
            seed: drawing.seed,
        }
    }

    /// For strokes in a frame of the plane's lattice, with a margin of so many nodes.
    pub(super) fn around(inner: Frame, margin: usize, spacing: f64) -> Self {
        Self { spent: Cell::new(0.0), drawn: Cell::new(0.0), inner, frame: inner.grown(margin), origin: [0.0, 0.0], spacing, seed: 0 }
    }

    /// The slots of what is drawn on, row by row from the south.
    pub(super) fn drawn_on(&self) -> impl DoubleEndedIterator<Item = core::ops::Range<usize>> + use<> {
        let (margin, stride, columns) = ((self.inner.first.row - self.frame.first.row) as usize, self.frame.stride(), self.inner.columns);
        (0..self.inner.rows).map(move |row| {
            let first = (row + margin + 1) * stride + margin + 1;
            first..first + columns
        })
    }

    /// The node nearest to a slot's in what is drawn on, as if that were mirrored at its edges without end: its column and row there.
    pub(super) fn mirrored(&self, slot: usize) -> [usize; 2] {
        let node = self.frame.node(slot);
        let fold = |i: i64, count: usize| {
            let i = i.rem_euclid(2 * count as i64) as usize;
            i.min(2 * count - 1 - i)
        };
        [fold(node.column, self.inner.columns), fold(node.row, self.inner.rows)]
    }

    /// The value of every slot; of those of the border 0.
    pub(super) fn quantity(&self, quantity: &Quantity, at: &str) -> Result<Vec<f32>, DrawingError> {
        match quantity {
            Quantity::Number(number) if number.is_finite() => Ok(vec![*number as f32; self.frame.slots()]),
            Quantity::Number(number) => Err(DrawingError::new(at, format!("must be a finite number, got {number}"))),
            Quantity::Programme(ramp) => self.ramp(ramp, at),
        }
    }

    /// The value of a programme in every slot.
    pub(super) fn ramp(&self, ramp: &Ramp, at: &str) -> Result<Vec<f32>, DrawingError> {
        let wrong = |field: &str, detail: String| DrawingError::new(format!("{at}/{field}"), detail);
        let programme = Programme::parse(&ramp.programme).map_err(|error| wrong("programme", error.to_string()))?;
        programme.check_cost().map_err(|error| wrong("programme", error.to_string()))?;
        if !(ramp.scale.is_finite() && ramp.scale > 0.0) {
            return Err(wrong("scale", format!("must be a positive number of metres, got {}", ramp.scale)));
        }
        let tape = Tape::compile(programme.root());
        let nodes = self.frame.columns * self.frame.rows;
        self.spent.set(self.spent.get() + tape.cost_ns(self.spacing / ramp.scale, Filter::Exact, nodes) * nodes as f64);
        if self.spent.get() > MOST_NS {
            return Err(wrong(
                "programme",
                format!("takes too long at {nodes} nodes, with what is before it: all programmes of a drawing have {} s", MOST_NS / 1e9),
            ));
        }
        let frame =
            programme::Frame { seed: noise::key(self.seed, ramp.seed), scale: ramp.scale, origin: [0, 1].map(|axis| self.origin[axis] + ramp.origin[axis]) };
        let axis = |first: i64, origin: f64, count: usize| Axis::new(first, 1, self.spacing, origin, count);
        let columns = axis(self.frame.first.column, self.origin[0], self.frame.columns);
        let rows = axis(self.frame.first.row, self.origin[1], self.frame.rows);
        let mut values = vec![0.0; self.frame.columns * self.frame.rows];
        tape.evaluate(&frame, &Window { columns, rows, filter: Filter::Exact }, &mut values);
        if let Some([least, greatest]) = ramp.between {
            let margin = (self.inner.first.row - self.frame.first.row) as usize;
            let inner = values.chunks(self.frame.columns).skip(margin).take(self.inner.rows).flat_map(|row| &row[margin..margin + self.inner.columns]);
            let range = inner.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
            if range[1] <= range[0] {
                return Err(wrong("programme", format!("is {} everywhere: its least and its greatest value must differ", range[0])));
            }
            for value in &mut values {
                *value = least as f32 + (greatest - least) as f32 * ((*value - range[0]) / (range[1] - range[0]));
            }
        }
        if let Some(i) = values.iter().position(|value| !value.is_finite()) {
            let node = Node { row: self.frame.first.row + (i / self.frame.columns) as i64, column: self.frame.first.column + (i % self.frame.columns) as i64 };
            return Err(wrong("programme", format!("is not a finite number at node ({}, {})", node.column, node.row)));
        }
        let mut slots = vec![0.0; self.frame.slots()];
        for (range, row) in self.frame.rows_of_slots().zip(values.chunks(self.frame.columns)) {
            slots[range].copy_from_slice(row);
        }
        Ok(slots)
    }

    /// Where a place (metres from the origin) lies among the nodes, in columns and rows.
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [point[0] / self.spacing, point[1] / self.spacing]
    }

    /// The slot of a node that can be drawn on.
    fn slot(&self, column: i64, row: i64) -> Option<u32> {
        let node = Node { row, column };
        self.inner.slot(node).and_then(|_| self.frame.slot(node)).map(|slot| slot as u32)
    }

    /// The nodes of every part of a geometry; polygons filled or by their outlines. Parts that meet no node are left out.
    pub(super) fn parts(&self, geometry: &Geometry, filled: bool, at: &str) -> Result<Vec<Slots>, DrawingError> {
        let at = format!("{at}/coordinates");
        let polygon = |rings: &Vec<Vec<[f64; 2]>>, at: &str| if filled { self.polygon(rings, at) } else { self.outline(rings, at) };
        let parts = match geometry {
            Geometry::Point(point) => vec![self.line(&[*point], &at)?],
            Geometry::MultiPoint(points) => each(points, &at, |point, at| self.line(&[*point], at))?,
            Geometry::LineString(points) => vec![self.line(points, &at)?],
            Geometry::MultiLineString(lines) => each(lines, &at, |line, at| self.line(line, at))?,
            Geometry::Polygon(rings) => vec![polygon(rings, &at)?],
            Geometry::MultiPolygon(polygons) => each(polygons, &at, polygon)?,
        };
        Ok(parts.into_iter().filter(|part| !part.is_empty()).collect())
    }

    /// All nodes of a geometry, polygons filled.
    pub(super) fn covered(&self, geometry: &Geometry, at: &str) -> Result<Slots, DrawingError> {
        Ok(self.parts(geometry, true, at)?.into_iter().flatten().collect())
    }

    fn check(&self, points: &[[f64; 2]], at: &str) -> Result<(), DrawingError> {
        // So far outside nothing can be meant, and indices stay exact.
        let limit = 16.0 * self.spacing * self.inner.columns.max(self.inner.rows) as f64;
        match points.iter().position(|point| !point.iter().all(|c| c.abs() <= limit)) {
            Some(i) => Err(DrawingError::new(format!("{at}/{i}"), format!("must be two numbers of metres within {limit} of the drawing's origin"))),
            None => Ok(()),
        }
    }

    /// Counts nodes of shapes before they are laid out.
    fn charge(&self, nodes: f64, at: &str) -> Result<(), DrawingError> {
        self.drawn.set(self.drawn.get() + nodes);
        if self.drawn.get() <= MOST_DRAWN {
            Ok(())
        } else {
            Err(DrawingError::new(at, format!("shapes have too many nodes: all of a drawing have {MOST_DRAWN}")))
        }
    }

    /// The nodes along a line: in every column or row that it crosses, whichever are more, the nearest.
    pub(super) fn line(&self, points: &[[f64; 2]], at: &str) -> Result<Slots, DrawingError> {
        self.check(points, at)?;
        let steps = points.windows(2).map(|pair| (0..2).map(|axis| (pair[1][axis] - pair[0][axis]).abs() / self.spacing).fold(1.0, f64::max));
        self.charge(steps.sum(), at)?;
        Ok(self.along(points))
    }

    /// The nodes along a line that is known to lie near.
    pub(super) fn along(&self, points: &[[f64; 2]]) -> Slots {
        let mut slots = Slots::new();
        let places: Vec<[f64; 2]> = points.iter().map(|point| self.place(*point)).collect();
        for i in 0..places.len() {
            let (from, to) = (places[i], places[(i + 1).min(places.len() - 1)]);
            let [start, end] = [from, to].map(|place| place.map(f64::round));
            let steps = (0..2).map(|axis| (end[axis] - start[axis]).abs()).fold(0.0, f64::max);
            for step in 0..=steps as i64 {
                let share = if steps == 0.0 { 0.0 } else { step as f64 / steps };
                let [column, row] = [0, 1].map(|axis| (start[axis] + (end[axis] - start[axis]) * share).round() as i64);
                slots.extend(self.slot(column, row));
            }
        }
        slots
    }

    fn outline(&self, rings: &[Vec<[f64; 2]>], at: &str) -> Result<Slots, DrawingError> {
        let mut slots = Slots::new();
        for (i, ring) in rings.iter().enumerate() {
            slots.extend(self.line(ring, &format!("{at}/{i}"))?);
        }
        Ok(slots)
    }

    /// The nodes inside a polygon (an odd number of edges to the east) and on its outline.
    fn polygon(&self, rings: &[Vec<[f64; 2]>], at: &str) -> Result<Slots, DrawingError> {
        let mut slots = self.outline(rings, at)?;
        for row in 0..self.inner.rows as i64 {
            let mut crossings: Vec<f64> = Vec::new();
            for edge in rings.iter().flat_map(|ring| ring.windows(2)) {
                let [[x0, y0], [x1, y1]] = [self.place(edge[0]), self.place(edge[1])];
                let y = row as f64;
                if (y0 <= y) != (y1 <= y) {
                    crossings.push(x0 + (x1 - x0) * ((y - y0) / (y1 - y0)));
                }
            }
            crossings.sort_unstable_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let first = (pair[0].ceil() as i64).max(0);
                let last = (pair[1].floor() as i64).min(self.inner.columns as i64 - 1);
                self.charge((last - first + 1).max(0) as f64, at)?;
                slots.extend((first..=last).filter_map(|column| self.slot(column, row)));
            }
        }
        Ok(slots)
    }

    /// The outline of a circle.
    pub(super) fn circle(&self, [x, y, radius]: [f64; 3], at: &str) -> Result<Slots, DrawingError> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(DrawingError::new(format!("{at}/2"), format!("must be a positive radius in metres, got {radius}")));
        }
        self.line(&circle([x, y], radius), at)
    }

    /// The connected parts of a set of nodes (8 neighbours), in the order of their first nodes.
    pub(super) fn components(&self, mut left: Slots) -> Vec<Slots> {
        let offsets = self.frame.offsets();
        let mut parts = Vec::new();
        while let Some(first) = left.pop_first() {
            let (mut part, mut open) = (Slots::from([first]), vec![first]);
            while let Some(slot) = open.pop() {
                for neighbour in offsets.map(|offset| (slot as usize).wrapping_add_signed(offset) as u32) {
                    if left.remove(&neighbour) {
                        part.insert(neighbour);
                        open.push(neighbour);
                    }
                }
            }
            parts.push(part);
        }
        parts
    }

    /// Of every slot the square of its distance in nodes to the nearest of some, infinite without any (Felzenszwalb and Huttenlocher 2012).
    pub(super) fn squared_distances(&self, to: &Slots) -> Vec<f64> {
        let (stride, rows) = (self.frame.stride(), self.frame.rows + 2);
        let mut squares = vec![f64::INFINITY; self.frame.slots()];
        for slot in to {
            squares[*slot as usize] = 0.0;
        }
        let mut line = Vec::new();
        for column in 0..stride {
            line.clear();
            line.extend((0..rows).map(|row| squares[row * stride + column]));
            for (row, square) in nearest(&line).into_iter().enumerate() {
                squares[row * stride + column] = square;
            }
        }
        for row in squares.chunks_mut(stride) {
            let near = nearest(row);
            row.copy_from_slice(&near);
        }
        squares
    }

    fn column_row(&self, slot: u32) -> [f64; 2] {
        let node = self.frame.node(slot as usize);
        [node.column as f64, node.row as f64]
    }

    /// What lies inside an outline: whatever cannot reach the frame's border without crossing it (4 neighbours).
    pub(super) fn inside(&self, outline: &Slots) -> Slots {
        let columns_rows: Vec<[f64; 2]> = outline.iter().map(|slot| self.column_row(*slot)).collect();
        let range = |axis: usize| columns_rows.iter().fold([i64::MAX, i64::MIN], |[low, high], c| [low.min(c[axis] as i64), high.max(c[axis] as i64)]);
        let ([west, east], [south, north]) = (range(0), range(1));
        let (columns, rows) = ((east - west + 3) as usize, (north - south + 3) as usize);
        let slot = |i: usize| self.slot(west - 1 + (i % columns) as i64, south - 1 + (i / columns) as i64);
        let mut outside = vec![false; columns * rows];
        let mut open = vec![0_usize];
        outside[0] = true;
        while let Some(i) = open.pop() {
            let (column, row) = (i % columns, i / columns);
            let neighbours =
                [(column > 0).then(|| i - 1), (column + 1 < columns).then(|| i + 1), (row > 0).then(|| i - columns), (row + 1 < rows).then(|| i + columns)];
            for next in neighbours.into_iter().flatten() {
                if !outside[next] && slot(next).is_none_or(|slot| !outline.contains(&slot)) {
                    outside[next] = true;
                    open.push(next);
                }
            }
        }
        (0..outside.len()).filter(|i| !outside[*i]).filter_map(slot).filter(|slot| !outline.contains(slot)).collect()
    }
}

/// A ring of points on a circle, the last like the first.
pub(super) fn circle(centre: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    const POINTS: usize = 128;
    (0..=POINTS)
        .map(|i| {
            let angle = (i % POINTS) as f64 * (core::f64::consts::TAU / POINTS as f64);
            [centre[0] + radius * libm::cos(angle), centre[1] + radius * libm::sin(angle)]
        })
        .collect()
}

/// Of every place i of a line the least of (i - j)² + value j: the lower envelope of parabolas.
fn nearest(values: &[f64]) -> Vec<f64> {
    let crossing = |a: usize, b: usize| ((values[b] + (b * b) as f64) - (values[a] + (a * a) as f64)) / (2 * (b - a)) as f64;
    let mut envelope: Vec<(usize, f64)> = Vec::new();
    for i in (0..values.len()).filter(|i| values[*i].is_finite()) {
        while let Some((last, from)) = envelope.last().copied() {
            if crossing(last, i) > from {
                break;
            }
            envelope.pop();
        }
        let from = envelope.last().map_or(f64::NEG_INFINITY, |(last, _)| crossing(*last, i));
        envelope.push((i, from));
    }
    let mut part = 0;
    let of = |i: usize| {
        while envelope.get(part + 1).is_some_and(|(_, from)| *from < i as f64) {
            part += 1;
        }
        envelope.get(part).map_or(f64::INFINITY, |(j, _)| i.abs_diff(*j).pow(2) as f64 + values[*j])
    };
    (0..values.len()).map(of).collect()
}

fn each<T>(parts: &[T], at: &str, slots: impl Fn(&T, &str) -> Result<Slots, DrawingError>) -> Result<Vec<Slots>, DrawingError> {
    parts.iter().enumerate().map(|(i, part)| slots(part, &format!("{at}/{i}"))).collect()
}
