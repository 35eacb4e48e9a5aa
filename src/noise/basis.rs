//! The noises that stand alone and that fractals are made of.

use super::{
    Feature, Isa, Metric,
    cells::Lattice,
    cellular::{self, DistanceRows, Query, ValueRows, Values},
    gradient::{self, GradientRows, Gradients},
};

/// A noise in a unit lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// Perlin 1985: cubic fade, unit gradients; in [-1, 1].
    OPerlin,
    /// Perlin 2002: quintic fade, edge gradients; in [-1, 1].
    IPerlin,
    /// One value a cell, in [0, 1).
    CellNoise,
    /// Gradient noise with a radial cubic kernel, as in Blender; in [-1, 1].
    Blender,
    /// A measure of the distances to the nearest of one random point a cell.
    Voronoi {
        /// Which measure.
        feature: Feature,
        /// How distance is measured.
        metric: Metric,
    },
}

impl Basis {
    /// Every basis with every metric.
    pub fn all() -> impl Iterator<Item = Basis> {
        let voronoi = Feature::ALL.into_iter().flat_map(|feature| Metric::ALL.map(move |metric| Basis::Voronoi { feature, metric }));
        [Basis::OPerlin, Basis::IPerlin, Basis::Blender, Basis::CellNoise].into_iter().chain(voronoi)
    }

    fn gradients(self) -> Option<Gradients> {
        match self {
            Basis::OPerlin => Some(Gradients::Unit),
            Basis::IPerlin => Some(Gradients::Edges),
            _ => None,
        }
    }

    /// `amplitude` times the noise at a point; `extent` is the spacing of the samples in cells that edges are made fit for, 0 to leave them sharp.
    pub(super) fn at(self, lattice: &Lattice, amplitude: f32, extent: f32, u: f64, v: f64) -> f32 {
        if let Some(gradients) = self.gradients() {
            return gradient::at(gradients, lattice, amplitude, u, v);
        }
        let value = match self {
            Basis::Voronoi { feature, metric } => cellular::feature_at(metric, feature, lattice, extent, u, v),
            Basis::Blender => gradient::blender_at(lattice, u, v),
            _ => Values::new(*lattice, extent).at(u, v),
        };
        amplitude * value
    }

    pub(super) fn rows(self, isa: Isa, lattice: Lattice, amplitude: f32, extent: f32, coordinates: &[f64]) -> BasisRows {
        if let Some(gradients) = self.gradients() {
            return BasisRows::Gradient(GradientRows::new(gradients, lattice, amplitude, coordinates));
        }
        match self {
            Basis::Voronoi { feature, metric } => {
                BasisRows::Distance(DistanceRows::new(Query { isa, metric, feature, lattice, extent }, coordinates), amplitude)
            }
            Basis::Blender => BasisRows::Points { basis: self, lattice, amplitude, columns: coordinates.to_vec(), row: 0.0 },
            _ => BasisRows::Value(ValueRows::new(isa, Values::new(lattice, extent), coordinates), amplitude),
        }
    }
}

/// A basis along the rows of a window.
pub(super) enum BasisRows {
    Gradient(GradientRows),
    Distance(DistanceRows, f32),
    Value(ValueRows, f32),
    /// Sample by sample.
    Points {
        basis: Basis,
        lattice: Lattice,
        amplitude: f32,
        columns: Vec<f64>,
        row: f64,
    },
}

impl BasisRows {
    #[inline(always)]
    pub(super) fn begin(&mut self, v: f64) {
        match self {
            BasisRows::Gradient(rows) => rows.begin(v),
            BasisRows::Distance(rows, _) => rows.begin(v),
            BasisRows::Value(rows, _) => rows.begin(v),
            BasisRows::Points { row, .. } => *row = v,
        }
    }

    #[inline(always)]
    pub(super) fn fill(&self, start: usize, out: &mut [f32]) {
        let amplitude = match self {
            BasisRows::Gradient(rows) => return rows.fill(start, out),
            BasisRows::Distance(rows, amplitude) => {
                rows.fill(start, out);
                *amplitude
            }
            BasisRows::Value(rows, amplitude) => {
                rows.fill(start, out);
                *amplitude
            }
            BasisRows::Points { basis, lattice, amplitude, columns, row } => {
                for (out, &u) in out.iter_mut().zip(&columns[start..]) {
                    *out = basis.at(lattice, *amplitude, 0.0, u, *row);
                }
                return;
            }
        };
        for value in out {
            *value *= amplitude;
        }
    }
}
