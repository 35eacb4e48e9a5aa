//! Cellular noise: distances to the nearest of one random point a cell (S. Worley, "A cellular texture basis function", 1996), and one random value a cell.
//!
//! F1 and F2 are the true nearest distances of the whole plane: rings of cells are added until no nearer point can exist. A point outside the rings 0 … r lies at
//! least r + m away in every metric here, m the distance from the sample to the nearest side of its own cell.

use super::{
    cells::{Columns, Fade, Lattice, RowCache},
    elementary, hash,
};

/// How far apart two points are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Metric {
    /// Euclidean distance.
    #[default]
    Distance,
    /// Euclidean distance squared.
    Squared,
    /// |dx| + |dy|.
    Manhattan,
    /// max(|dx|, |dy|).
    Chebychev,
    /// (|dx|^e + |dy|^e)^(1/e).
    Minkowski {
        /// e, at least 0.5.
        exponent: f32,
    },
}

/// Which measure of the distances to the nearest points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// The distance to the nearest point.
    F1,
    /// To the second nearest.
    F2,
    /// To the third nearest.
    F3,
    /// To the fourth nearest.
    F4,
    /// F2 - F1.
    F2F1,
    /// min(1, 10 (F2 - F1)).
    Crackle,
}

impl Feature {
    /// Every feature.
    pub const ALL: [Feature; 6] = [Feature::F1, Feature::F2, Feature::F3, Feature::F4, Feature::F2F1, Feature::Crackle];

    /// How many of the nearest points must be known.
    #[inline(always)]
    fn order(self) -> usize {
        match self {
            Feature::F1 => 1,
            Feature::F2 | Feature::F2F1 | Feature::Crackle => 2,
            Feature::F3 => 3,
            Feature::F4 => 4,
        }
    }

    #[inline(always)]
    fn of(self, distances: [f32; 4]) -> f32 {
        let [f1, f2, f3, f4] = distances;
        match self {
            Feature::F1 => f1,
            Feature::F2 => f2,
            Feature::F3 => f3,
            Feature::F4 => f4,
            Feature::F2F1 => f2 - f1,
            Feature::Crackle => smaller(1.0, 10.0 * (f2 - f1)),
        }
    }
}

impl Metric {
    /// Every metric without a parameter.
    pub const ALL: [Metric; 4] = [Metric::Distance, Metric::Squared, Metric::Manhattan, Metric::Chebychev];

    /// The name in programmes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Metric::Distance => "distance",
            Metric::Squared => "squared",
            Metric::Manhattan => "manhattan",
            Metric::Chebychev => "chebychev",
            Metric::Minkowski { .. } => "minkowski",
        }
    }

    /// A measure that grows with the distance and is cheap to compare.
    #[inline(always)]
    fn compare(self, dx: f32, dy: f32) -> f32 {
        match self {
            Metric::Distance | Metric::Squared => dx * dx + dy * dy,
            Metric::Manhattan => dx.abs() + dy.abs(),
            Metric::Chebychev => larger(dx.abs(), dy.abs()),
            Metric::Minkowski { exponent } => elementary::pow(dx.abs(), exponent) + elementary::pow(dy.abs(), exponent),
        }
    }

    /// The compared measure of an offset along one axis.
    #[inline(always)]
    fn compare_axis(self, d: f32) -> f32 {
        match self {
            Metric::Distance | Metric::Squared => d * d,
            Metric::Manhattan | Metric::Chebychev => d,
            Metric::Minkowski { exponent } => elementary::pow(d, exponent),
        }
    }

    /// The distance of a compared measure.
    #[inline(always)]
    fn distance(self, compared: f32) -> f32 {
        match self {
            Metric::Distance => compared.sqrt(),
            Metric::Minkowski { exponent } => elementary::pow(compared, 1.0 / exponent),
            _ => compared,
        }
    }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// The four least compared measures so far.
#[derive(Clone, Copy)]
struct Nearest([f32; 4]);

impl Nearest {
    #[inline(always)]
    fn add(&mut self, d: f32) {
        let [first, second, third, fourth] = self.0;
        self.0 = [smaller(first, d), smaller(second, larger(first, d)), smaller(third, larger(second, d)), smaller(fourth, larger(third, d))];
    }
}

/// The point of a cell, relative to the cell's south-west corner.
#[inline(always)]
fn point(hash: u32) -> [f32; 2] {
    const UNIT: f32 = 1.0 / 65_536.0;
    [((hash & 0xffff) as f32 + 0.5) * UNIT, ((hash >> 16) as f32 + 0.5) * UNIT]
}

/// Distance from a fraction of a cell to its nearer side, along both axes.
#[inline(always)]
fn margin(fx: f32, fy: f32) -> f32 {
    smaller(smaller(fx, 1.0 - fx), smaller(fy, 1.0 - fy))
}

/// Adds the points of the ring of cells `ring` steps from (i, j).
fn add_ring(metric: Metric, seed: u32, [i, j]: [i64; 2], [fx, fy]: [f32; 2], ring: i64, nearest: &mut Nearest) {
    for b in -ring..=ring {
        let step = if b.abs() == ring { 1 } else { (2 * ring).max(1) };
        let mut a = -ring;
        while a <= ring {
            let [px, py] = point(hash::corner(hash::column_key(i + a), hash::row_key(j + b, seed)));
            nearest.add(metric.compare((px + a as f32) - fx, (py + b as f32) - fy));
            a += step;
        }
    }
}

/// Adds rings from `ring` on until the `order`-th nearest is certain.
fn finish(metric: Metric, seed: u32, cell: [i64; 2], at: [f32; 2], mut ring: i64, order: usize, nearest: &mut Nearest) {
    while nearest.0[order - 1] > metric.compare_axis((ring - 1) as f32 + margin(at[0], at[1])) {
        add_ring(metric, seed, cell, at, ring, nearest);
        ring += 1;
    }
}

/// The feature at a point.
pub(super) fn feature_at(metric: Metric, feature: Feature, lattice: &Lattice, u: f64, v: f64) -> f32 {
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    let (cell, at) = ([column.cell, row.cell], [column.fraction as f32, row.fraction as f32]);
    let mut nearest = Nearest([f32::INFINITY; 4]);
    add_ring(metric, lattice.seed, cell, at, 0, &mut nearest);
    add_ring(metric, lattice.seed, cell, at, 1, &mut nearest);
    finish(metric, lattice.seed, cell, at, 2, feature.order(), &mut nearest);
    feature.of(nearest.0.map(|d| metric.distance(d)))
}

/// Distances along the rows of a window.
pub(super) struct DistanceRows {
    metric: Metric,
    order: usize,
    lattice: Lattice,
    columns: Columns,
    /// The number of each run's cell.
    cells: Vec<i64>,
    points: RowCache<Vec<[f32; 2]>>,
    row: i64,
    fraction: f32,
}

impl DistanceRows {
    pub(super) fn new(metric: Metric, feature: Feature, lattice: Lattice, coordinates: &[f64]) -> Self {
        let columns = Columns::new(&lattice, Fade::None, coordinates, 1, 1);
        let cells = columns.runs.iter().map(|run| lattice.locate(0, coordinates[run.start]).cell).collect();
        let nodes = columns.keys.len();
        Self { metric, order: feature.order(), lattice, columns, cells, points: RowCache::new(3, || vec![[0.0; 2]; nodes]), row: 0, fraction: 0.0 }
    }

    /// Goes to the row of programme coordinate `v`.
    #[inline(always)]
    pub(super) fn begin(&mut self, v: f64) {
        let position = self.lattice.locate(1, v);
        (self.row, self.fraction) = (position.cell, position.fraction as f32);
        let Self { columns, lattice, .. } = self;
        self.points.want(position.cell - 1, |row, points| {
            let row = hash::row_key(row, lattice.seed);
            for (entry, &column) in points.iter_mut().zip(&columns.keys) {
                *entry = point(hash::corner(column, row));
            }
        });
    }

    /// Writes the distances at the columns from `start` on.
    #[inline(always)]
    pub(super) fn fill(&self, start: usize, out: &mut [f32]) {
        match self.metric {
            Metric::Distance => self.fill_by(|dx, dy| Metric::Distance.compare(dx, dy), start, out),
            Metric::Squared => self.fill_by(|dx, dy| Metric::Squared.compare(dx, dy), start, out),
            Metric::Manhattan => self.fill_by(|dx, dy| Metric::Manhattan.compare(dx, dy), start, out),
            Metric::Chebychev => self.fill_by(|dx, dy| Metric::Chebychev.compare(dx, dy), start, out),
            Metric::Minkowski { exponent } => self.fill_by(|dx, dy| Metric::Minkowski { exponent }.compare(dx, dy), start, out),
        }
    }

    #[inline(always)]
    fn fill_by(&self, compare: impl Fn(f32, f32) -> f32, start: usize, out: &mut [f32]) {
        for run in self.columns.runs_within(start, start + out.len()) {
            // The 3 × 3 points around the run's cell, relative to its corner; their offsets to the row are the same for the whole run.
            let mut around = [[0.0_f32; 2]; 9];
            for (slot, entry) in around.iter_mut().enumerate() {
                let (a, b) = (slot % 3, slot / 3);
                let [px, py] = self.points.get(b)[run.node + a - 1];
                *entry = [px + (a as f32 - 1.0), (py + (b as f32 - 1.0)) - self.fraction];
            }
            let samples = &self.columns.fraction[run.start..run.end];
            for (out, &fx) in out[run.start - start..run.end - start].iter_mut().zip(samples) {
                let mut nearest = Nearest([f32::INFINITY; 4]);
                for &[px, dy] in &around {
                    nearest.add(compare(px - fx, dy));
                }
                *out = nearest.0[self.order - 1];
            }
            self.finish_run(run.start, samples, &mut out[run.start - start..run.end - start]);
        }
    }

    /// Looks further where 3 × 3 cells do not decide, and turns measures into distances.
    #[inline(always)]
    fn finish_run(&self, first: usize, samples: &[f32], out: &mut [f32]) {
        for (i, (out, &fx)) in out.iter_mut().zip(samples).enumerate() {
            if *out > self.metric.compare_axis(1.0 + margin(fx, self.fraction)) {
                let run = self.columns.runs.partition_point(|run| run.end <= first + i);
                let (cell, at) = ([self.cells[run], self.row], [fx, self.fraction]);
                let mut nearest = Nearest([f32::INFINITY; 4]);
                add_ring(self.metric, self.lattice.seed, cell, at, 0, &mut nearest);
                add_ring(self.metric, self.lattice.seed, cell, at, 1, &mut nearest);
                finish(self.metric, self.lattice.seed, cell, at, 2, self.order, &mut nearest);
                *out = nearest.0[self.order - 1];
            }
            *out = self.metric.distance(*out);
        }
    }
}

/// The value of a cell, in [0, 1).
#[inline(always)]
fn value(hash: u32) -> f32 {
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The value of the cell around a point.
pub(super) fn value_at(lattice: &Lattice, u: f64, v: f64) -> f32 {
    let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
    value(hash::corner(hash::column_key(column.cell), hash::row_key(row.cell, lattice.seed)))
}

/// Cell values along the rows of a window.
pub(super) struct ValueRows {
    lattice: Lattice,
    columns: Columns,
    values: RowCache<Vec<f32>>,
}

impl ValueRows {
    pub(super) fn new(lattice: Lattice, coordinates: &[f64]) -> Self {
        let columns = Columns::new(&lattice, Fade::None, coordinates, 0, 0);
        let nodes = columns.keys.len();
        Self { lattice, columns, values: RowCache::new(1, || vec![0.0; nodes]) }
    }

    /// Goes to the row of programme coordinate `v`.
    #[inline(always)]
    pub(super) fn begin(&mut self, v: f64) {
        let position = self.lattice.locate(1, v);
        let Self { columns, lattice, .. } = self;
        self.values.want(position.cell, |row, values| {
            let row = hash::row_key(row, lattice.seed);
            for (entry, &column) in values.iter_mut().zip(&columns.keys) {
                *entry = value(hash::corner(column, row));
            }
        });
    }

    /// Writes the values at the columns from `start` on.
    #[inline(always)]
    pub(super) fn fill(&self, start: usize, out: &mut [f32]) {
        let values = self.values.get(0);
        for run in self.columns.runs_within(start, start + out.len()) {
            out[run.start - start..run.end - start].fill(values[run.node]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All points within nine cells, the plain way.
    fn brute_force(metric: Metric, feature: Feature, lattice: &Lattice, u: f64, v: f64) -> f32 {
        let (column, row) = (lattice.locate(0, u), lattice.locate(1, v));
        let mut all = Vec::new();
        for b in -9..=9_i64 {
            for a in -9..=9_i64 {
                let [px, py] = point(hash::corner(hash::column_key(column.cell + a), hash::row_key(row.cell + b, lattice.seed)));
                all.push(metric.compare((px + a as f32) - column.fraction as f32, (py + b as f32) - row.fraction as f32));
            }
        }
        all.sort_by(f32::total_cmp);
        feature.of(core::array::from_fn(|k| metric.distance(all[k])))
    }

    #[test]
    fn distances_are_those_of_the_whole_plane() {
        let lattice = Lattice::new(11, 0, 1.0);
        for metric in Metric::ALL {
            for feature in Feature::ALL {
                for i in 0..20_000 {
                    let (u, v) = (f64::from(i % 141) * 0.37 - 20.0, f64::from(i / 141) * 0.31 - 20.0);
                    assert_eq!(feature_at(metric, feature, &lattice, u, v), brute_force(metric, feature, &lattice, u, v), "{metric:?} {feature:?} at {u} {v}");
                }
            }
        }
    }
}
