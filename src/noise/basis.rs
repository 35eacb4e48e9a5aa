//! The noises that stand alone and that fractals are made of.

use super::{
    Metric,
    cells::Lattice,
    cellular::{self, DistanceRows, ValueRows},
    gradient::{self, GradientRows, Gradients},
};

/// A noise in a unit lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Basis {
    /// Perlin 1985: cubic fade, unit gradients; in [-1, 1].
    OPerlin,
    /// Perlin 2002: quintic fade, edge gradients; in [-1, 1].
    IPerlin,
    /// One value a cell, in [0, 1).
    CellNoise,
    /// Distance to the nearest (`order` 1) or second nearest (`order` 2) of one random point a cell.
    Voronoi {
        /// 1 or 2.
        order: u8,
        /// How distance is measured.
        metric: Metric,
    },
}

impl Basis {
    /// Every basis with every metric.
    pub fn all() -> impl Iterator<Item = Basis> {
        let voronoi = [1, 2].into_iter().flat_map(|order| Metric::ALL.map(move |metric| Basis::Voronoi { order, metric }));
        [Basis::OPerlin, Basis::IPerlin, Basis::CellNoise].into_iter().chain(voronoi)
    }

    fn gradients(self) -> Option<Gradients> {
        match self {
            Basis::OPerlin => Some(Gradients::Unit),
            Basis::IPerlin => Some(Gradients::Edges),
            _ => None,
        }
    }

    /// `amplitude` times the noise at a point.
    pub(super) fn at(self, lattice: &Lattice, amplitude: f32, u: f64, v: f64) -> f32 {
        if let Some(gradients) = self.gradients() {
            return gradient::at(gradients, lattice, amplitude, u, v);
        }
        let value = match self {
            Basis::Voronoi { order, metric } => cellular::distance_at(metric, order.into(), lattice, u, v),
            _ => cellular::value_at(lattice, u, v),
        };
        amplitude * value
    }

    pub(super) fn rows(self, lattice: Lattice, amplitude: f32, coordinates: &[f64]) -> BasisRows {
        if let Some(gradients) = self.gradients() {
            return BasisRows::Gradient(GradientRows::new(gradients, lattice, amplitude, coordinates));
        }
        match self {
            Basis::Voronoi { order, metric } => BasisRows::Distance(DistanceRows::new(metric, order.into(), lattice, coordinates), amplitude),
            _ => BasisRows::Value(ValueRows::new(lattice, coordinates), amplitude),
        }
    }
}

/// A basis along the rows of a window.
pub(super) enum BasisRows {
    Gradient(GradientRows),
    Distance(DistanceRows, f32),
    Value(ValueRows, f32),
}

impl BasisRows {
    #[inline(always)]
    pub(super) fn begin(&mut self, v: f64) {
        match self {
            BasisRows::Gradient(rows) => rows.begin(v),
            BasisRows::Distance(rows, _) => rows.begin(v),
            BasisRows::Value(rows, _) => rows.begin(v),
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
        };
        for value in out {
            *value *= amplitude;
        }
    }
}
