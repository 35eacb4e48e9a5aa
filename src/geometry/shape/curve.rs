//! Lines and rings: the parts of polylines and polygons.

use super::{Detail, ShapeError, validity};
use crate::geometry::Rectangle;

/// Elevations of a shape in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Elevation {
    /// The shape has none.
    #[default]
    Absent,
    /// One for the whole shape.
    Constant(f64),
    /// One a vertex; between vertices they change evenly.
    Vertices(Box<[f64]>),
}

/// How the elevation runs between the vertices of a shape with detail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Along {
    /// Along the straight line from vertex to vertex: the elevation where it is nearest. It does not jump at inner corners.
    #[default]
    Chord,
    /// Along the displaced path itself, each of the 2^n pieces between two vertices having an equal share of the way.
    Arc,
}

/// One or several polylines or rings, with or without fractal detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub(super) vertices: Box<[[f64; 2]]>,
    /// Where each part begins.
    pub(super) starts: Box<[u32]>,
    pub(super) elevation: Elevation,
    pub(super) along: Along,
    pub(super) closed: bool,
    pub(super) detail: Option<Detail>,
    /// Edges between two original vertices, 2^n after static displacement.
    pub(super) stride: u32,
}

impl Curve {
    pub(super) fn new(parts: Vec<Vec<[f64; 2]>>, elevation: Elevation, closed: bool) -> Result<Self, ShapeError> {
        let (mut vertices, mut starts) = (Vec::with_capacity(parts.iter().map(Vec::len).sum()), Vec::with_capacity(parts.len()));
        for part in parts {
            starts.push(vertices.len() as u32);
            vertices.extend(part);
        }
        let curve = Self {
            vertices: vertices.into(),
            starts: starts.into(),
            elevation,
            along: Along::default(),
            closed,
            detail: None,
            stride: 1,
        };
        validity::curve(&curve)?;
        Ok(curve)
    }

    pub(super) fn detailed(self, detail: Detail) -> Self {
        Self { detail: Some(detail), ..self }
    }

    /// The curve with another way of its elevation between vertices.
    #[must_use]
    pub fn along(self, along: Along) -> Self {
        Self { along, ..self }
    }

    /// All vertices; those of a ring end with its first one again.
    #[must_use]
    pub fn vertices(&self) -> &[[f64; 2]] {
        &self.vertices
    }

    /// The vertices of each polyline or ring.
    pub fn parts(&self) -> impl Iterator<Item = &[[f64; 2]]> + '_ {
        (0..self.starts.len()).map(|i| &self.vertices[self.part(i)])
    }

    /// Indices of the vertices of a part.
    pub(super) fn part(&self, i: usize) -> std::ops::Range<usize> {
        let end = self.starts.get(i + 1).map_or(self.vertices.len(), |&end| end as usize);
        self.starts[i] as usize..end
    }

    /// The elevations.
    #[must_use]
    pub fn elevation(&self) -> &Elevation {
        &self.elevation
    }

    /// The elevation of a vertex in metres; 0 if the shape has none.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn elevation_at(&self, vertex: usize) -> f64 {
        match &self.elevation {
            Elevation::Absent => 0.0,
            Elevation::Constant(elevation) => *elevation,
            Elevation::Vertices(elevations) => elevations[vertex],
        }
    }

    /// How the elevation runs between vertices.
    #[must_use]
    pub fn way(&self) -> Along {
        self.along
    }

    /// The fractal detail that is evaluated lazily.
    #[must_use]
    pub fn detail(&self) -> Option<&Detail> {
        self.detail.as_ref()
    }

    /// Whether the parts are rings.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    /// A rectangle that holds the curve with its detail.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        let Some(detail) = &self.detail else { return Rectangle::around(&self.vertices) };
        let mut bounds = Rectangle::EMPTY;
        for part in self.parts() {
            for ends in part.windows(2) {
                bounds = bounds.union(Rectangle::around(ends).grown(detail.reach(ends[0], ends[1])));
            }
        }
        bounds
    }
}
