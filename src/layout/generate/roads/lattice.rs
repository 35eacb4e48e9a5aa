//! The terrain as the search for roads sees it: heights and water at the points of a square lattice.

use super::super::plane::Point;
use crate::geometry::{Axis, Filter, Source, Surface, Wanted, Window};
use std::collections::BTreeMap;

/// Heights and water at the points of a square lattice, numbered row by row from the north-west.
pub(super) struct Lattice {
    window: Window,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Metres between points.
    pub(super) spacing: f64,
    /// Metres, as samples of the spacing see the ground.
    pub(super) elevation: Vec<f64>,
    /// The share of each point's square that lies under water.
    pub(super) cover: Vec<f64>,
    /// Whether a road keeps clear of water at the point.
    dry: Vec<bool>,
    /// Points that stand elsewhere: at the places that roads join.
    moved: BTreeMap<usize, Point>,
}

impl Lattice {
    /// The samples of a lattice over a rectangle and a margin round it. Points are multiples of the spacing, wherever the rectangle lies.
    pub(super) fn window([low, high]: [Point; 2], margin: f64, spacing: f64) -> Window {
        let index = |c: f64| (c / spacing).floor() as i64;
        let axis = |axis: usize| (index(low[axis] - margin), index(high[axis] + margin) + 1);
        let ((west, east), (south, north)) = (axis(0), axis(1));
        Window {
            columns: Axis::new(west, 1, spacing, 0.0, (east - west + 1) as usize),
            rows: Axis::new(north, -1, spacing, 0.0, (north - south + 1) as usize),
            filter: Filter::Band,
        }
    }

    /// Samples the terrain; points nearer to water than `reach` are not dry.
    pub(super) fn sample(source: &impl Source, window: &Window, reach: f64) -> Self {
        let mut surface = Surface::with(window, Wanted { water: true, ..Wanted::default() });
        source.sample(window, &mut surface);
        let (columns, rows, spacing) = (window.columns.len(), window.rows.len(), window.spacing());
        let wet: Vec<bool> = surface.water_cover.iter().zip(&surface.water_depth).map(|(&cover, &depth)| cover > 0.0 || depth > 0.0).collect();
        // A point's own square reaches half a spacing already.
        let away = ((reach - 0.5 * spacing) / spacing).ceil().max(0.0) as i64;
        let mut lattice = Self {
            window: *window,
            columns,
            rows,
            spacing,
            elevation: surface.elevation.iter().map(|&e| e.into()).collect(),
            cover: surface.water_cover.iter().map(|&cover| cover.into()).collect(),
            dry: wet.iter().map(|wet| !wet).collect(),
            moved: BTreeMap::new(),
        };
        for node in (0..wet.len()).filter(|&node| wet[node]) {
            for dy in -away..=away {
                for dx in -away..=away {
                    if let Some(near) = lattice.step(node, [dx, dy]) {
                        lattice.dry[near] = false;
                    }
                }
            }
        }
        lattice
    }

    pub(super) fn is_dry(&self, node: usize) -> bool {
        self.dry[node]
    }

    /// The point so many columns and rows away, if there is one.
    pub(super) fn step(&self, node: usize, [dx, dy]: [i64; 2]) -> Option<usize> {
        let (column, row) = ((node % self.columns) as i64 + dx, (node / self.columns) as i64 + dy);
        let inside = (0..self.columns as i64).contains(&column) && (0..self.rows as i64).contains(&row);
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// Column and row.
    pub(super) fn place(&self, node: usize) -> [f64; 2] {
        [(node % self.columns) as f64, (node / self.columns) as f64]
    }

    /// Lets a point stand at a place, where the ground has an elevation of its own.
    pub(super) fn settle(&mut self, node: usize, at: Point, elevation: f64) {
        self.elevation[node] = elevation;
        self.moved.insert(node, at);
    }

    /// Whether a point stands at a place.
    pub(super) fn is_place(&self, node: usize) -> bool {
        self.moved.contains_key(&node)
    }

    /// Coordinates in metres.
    pub(super) fn at(&self, node: usize) -> Point {
        self.moved.get(&node).copied().unwrap_or_else(|| self.corner(node))
    }

    /// Coordinates in metres of a point that stands nowhere else.
    fn corner(&self, node: usize) -> Point {
        [self.window.columns.coordinate((node % self.columns) as i64), self.window.rows.coordinate((node / self.columns) as i64)]
    }

    /// Column and row as numbers with fractions.
    fn inside(&self, p: Point) -> [f64; 2] {
        let [west, north] = self.corner(0);
        [((p[0] - west) / self.spacing).clamp(0.0, self.columns as f64 - 1.0), ((north - p[1]) / self.spacing).clamp(0.0, self.rows as f64 - 1.0)]
    }

    /// The point nearest to a place.
    pub(super) fn nearest(&self, p: Point) -> usize {
        let [column, row] = self.inside(p).map(|c| c.round() as usize);
        row * self.columns + column
    }

    /// Whether the four points round a place are dry.
    pub(super) fn is_dry_at(&self, p: Point) -> bool {
        let [column, row] = self.inside(p);
        let ends = |c: f64| [c.floor() as usize, c.ceil() as usize];
        ends(row).into_iter().all(|row| ends(column).into_iter().all(|column| self.dry[row * self.columns + column]))
    }

    /// Whether all points are dry that lie at most so many columns and rows from the one nearest to a place.
    pub(super) fn is_dry_round(&self, p: Point, away: i64) -> bool {
        let node = self.nearest(p);
        (-away..=away).all(|dy| (-away..=away).all(|dx| self.step(node, [dx, dy]).is_none_or(|near| self.dry[near])))
    }
}
