//! The noises that stand alone and that fractals are made of.

use super::{
    Feature, Isa, Lanes, Metric,
    cells::Lattice,
    cellular::{self, DistanceRows, Query, ValueRows, Values},
    field::Octave,
    gradient::{self, Gradients},
    gradient_lanes::{Blender, IPerlin, OPerlin},
    gradient_rows::GradientRows,
    sheet::{Lines, Sheet},
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

    /// `amplitude` times the noise at a point; `extent` is the spacing of the samples in cells that edges are made fit for, 0 to leave them sharp.
    pub(super) fn at(self, lattice: &Lattice, amplitude: f32, extent: f32, u: f64, v: f64) -> f32 {
        match self {
            Basis::OPerlin => gradient::at(Gradients::Unit, lattice, amplitude, u, v),
            Basis::IPerlin => gradient::at(Gradients::Edges, lattice, amplitude, u, v),
            Basis::Blender => gradient::blender_at(lattice, amplitude, u, v),
            Basis::CellNoise => amplitude * Values::new(*lattice, extent).at(u, v),
            Basis::Voronoi { feature, metric } => amplitude * cellular::feature_at(metric, feature, lattice, extent, u, v),
        }
    }
}

/// The octaves of a basis whose samples share cells.
pub(super) enum BasisSheet {
    None,
    OPerlin(Sheet<OPerlin>),
    IPerlin(Sheet<IPerlin>),
}

impl BasisSheet {
    /// The leading octaves, given by lattice and factor, as many as there can be.
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, basis: Basis, octaves: impl Iterator<Item = (Lattice, f32)>, coordinates: &[f64]) -> Self {
        match basis {
            Basis::OPerlin => BasisSheet::OPerlin(Sheet::new(lanes, octaves, coordinates)),
            Basis::IPerlin => BasisSheet::IPerlin(Sheet::new(lanes, octaves, coordinates)),
            _ => BasisSheet::None,
        }
    }

    #[inline(always)]
    pub(super) fn begin<L: Lanes>(&mut self, lanes: L, v: f64) {
        match self {
            BasisSheet::None => (),
            BasisSheet::OPerlin(sheet) => sheet.begin(lanes, v),
            BasisSheet::IPerlin(sheet) => sheet.begin(lanes, v),
        }
    }

    /// Its lines, if it has octaves.
    #[inline(always)]
    pub(super) fn lines(&self) -> Option<&Lines> {
        let lines = match self {
            BasisSheet::None => return None,
            BasisSheet::OPerlin(sheet) => sheet.lines(),
            BasisSheet::IPerlin(sheet) => sheet.lines(),
        };
        (lines.octaves() > 0).then_some(lines)
    }
}

/// A basis along the rows of a window, an octave of it.
pub(super) enum BasisRows {
    OPerlin(GradientRows<OPerlin>),
    IPerlin(GradientRows<IPerlin>),
    Blender(GradientRows<Blender>),
    /// With its factor.
    Cellular(CellularRows, f32),
}

impl BasisRows {
    #[inline(always)]
    pub(super) fn new<L: Lanes>(lanes: L, isa: Isa, basis: Basis, octave: &Octave, coordinates: &[f64]) -> Self {
        let Octave { lattice, amplitude, extent, .. } = *octave;
        match basis {
            Basis::OPerlin => BasisRows::OPerlin(GradientRows::new(lanes, lattice, amplitude, coordinates)),
            Basis::IPerlin => BasisRows::IPerlin(GradientRows::new(lanes, lattice, amplitude, coordinates)),
            Basis::Blender => BasisRows::Blender(GradientRows::new(lanes, lattice, amplitude, coordinates)),
            Basis::Voronoi { feature, metric } => {
                let query = Query { isa, metric, feature, lattice, extent };
                BasisRows::Cellular(CellularRows::new(CellularKind::Distance(DistanceRows::new(query, coordinates)), coordinates), amplitude)
            }
            Basis::CellNoise => {
                let values = ValueRows::new(isa, Values::new(lattice, extent), coordinates);
                BasisRows::Cellular(CellularRows::new(CellularKind::Value(values), coordinates), amplitude)
            }
        }
    }

    #[inline(always)]
    pub(super) fn begin(&mut self, v: f64) {
        match self {
            BasisRows::OPerlin(rows) => rows.begin(v),
            BasisRows::IPerlin(rows) => rows.begin(v),
            BasisRows::Blender(rows) => rows.begin(v),
            BasisRows::Cellular(rows, _) => rows.begin(v),
        }
    }

    /// Writes the noise at the columns from `start` on, which is a whole number of vectors; what goes beyond the last column may be anything.
    #[inline(always)]
    pub(super) fn fill<L: Lanes>(&self, lanes: L, start: usize, out: &mut [f32]) {
        match self {
            BasisRows::OPerlin(rows) => rows.fill(lanes, start, out),
            BasisRows::IPerlin(rows) => rows.fill(lanes, start, out),
            BasisRows::Blender(rows) => rows.fill(lanes, start, out),
            BasisRows::Cellular(rows, amplitude) => {
                let count = out.len().min(rows.columns - start);
                rows.fill(start, &mut out[..count]);
                for value in out {
                    *value *= amplitude;
                }
            }
        }
    }
}

/// Cellular noise along the rows of a window.
pub(super) struct CellularRows {
    columns: usize,
    kind: CellularKind,
}

enum CellularKind {
    Distance(DistanceRows),
    Value(ValueRows),
}

impl CellularRows {
    fn new(kind: CellularKind, coordinates: &[f64]) -> Self {
        Self { columns: coordinates.len(), kind }
    }

    #[inline(always)]
    fn begin(&mut self, v: f64) {
        match &mut self.kind {
            CellularKind::Distance(rows) => rows.begin(v),
            CellularKind::Value(rows) => rows.begin(v),
        }
    }

    #[inline(always)]
    fn fill(&self, start: usize, out: &mut [f32]) {
        match &self.kind {
            CellularKind::Distance(rows) => rows.fill(start, out),
            CellularKind::Value(rows) => rows.fill(start, out),
        }
    }
}

impl Basis {
    /// Writes a cellular noise at positions.
    pub(super) fn cellular_points(self, isa: Isa, octave: &Octave, us: &[f64], vs: &[f64], out: &mut [f32]) {
        let Octave { lattice, extent, .. } = *octave;
        match self {
            Basis::Voronoi { feature, metric } => cellular::feature_points(&Query { isa, metric, feature, lattice, extent }, us, vs, out),
            _ => cellular::value_points(isa, &Values::new(lattice, extent), us, vs, out),
        }
    }
}
