//! Lines and rings: the parts of polylines and polygons.

use super::{Detail, Edge, EdgeDetail, MAX_VERTICES, ShapeError, validity};
use crate::geometry::Rectangle;
use std::ops::Range;

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
        let (vertices, starts) = (vertices.into(), starts.into());
        let curve = Self { vertices, starts, elevation, along: Along::default(), closed, detail: None, stride: 1 };
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

    /// The curve without its detail.
    #[must_use]
    pub fn plain(&self) -> Self {
        Self { detail: None, ..self.clone() }
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
    pub(super) fn part(&self, i: usize) -> Range<usize> {
        let end = self.starts.get(i + 1).map_or(self.vertices.len(), |&end| end as usize);
        self.starts[i] as usize..end
    }

    /// The elevations.
    #[must_use]
    pub fn elevation(&self) -> &Elevation {
        &self.elevation
    }

    /// How many chords there are: edges between vertices as they were drawn.
    #[must_use]
    pub fn chord_count(&self) -> usize {
        (self.vertices.len() - self.starts.len()) / self.stride as usize
    }

    /// Edges a chord: more than one after [`Curve::expanded`].
    #[must_use]
    pub fn stride(&self) -> usize {
        self.stride as usize
    }

    /// The chords in order.
    pub fn chords(&self) -> impl Iterator<Item = Chord> + '_ {
        (0..self.chord_count()).map(|chord| self.chord(chord))
    }

    /// The part that a chord belongs to.
    ///
    /// # Panics
    /// If the curve has no parts.
    #[must_use]
    pub fn part_of(&self, chord: usize) -> usize {
        // Before part i there are as many vertices as edges, and i more.
        let ends_before = |start: u32, part: usize| (start as usize - part) / self.stride as usize <= chord;
        let (mut low, mut high) = (0, self.starts.len());
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            if ends_before(self.starts[middle], middle) { low = middle } else { high = middle }
        }
        low
    }

    /// A chord by its number.
    ///
    /// # Panics
    /// If there is no such chord.
    #[must_use]
    pub fn chord(&self, chord: usize) -> Chord {
        let (part, stride) = (self.part_of(chord), self.stride as usize);
        let first = chord * stride + part;
        let elevations = [self.drawn_elevation(chord + part), self.drawn_elevation(chord + part + 1)];
        Chord { first, ends: [self.vertices[first], self.vertices[first + stride]], elevations }
    }

    /// The ends of an edge by its number, counted over all parts.
    ///
    /// # Panics
    /// If there is no such edge.
    #[must_use]
    pub fn edge(&self, edge: usize) -> [[f64; 2]; 2] {
        let first = edge + self.part_of(edge / self.stride as usize);
        [self.vertices[first], self.vertices[first + 1]]
    }

    /// The elevation of a vertex as it was drawn; 0 if the shape has none.
    fn drawn_elevation(&self, vertex: usize) -> f64 {
        match &self.elevation {
            Elevation::Absent => 0.0,
            Elevation::Constant(elevation) => *elevation,
            Elevation::Vertices(elevations) => elevations[vertex],
        }
    }

    /// The elevation at a vertex in metres; 0 if the shape has none.
    ///
    /// # Panics
    /// If there is no such vertex, or the curve was expanded.
    #[must_use]
    pub fn elevation_at(&self, vertex: usize) -> f64 {
        assert_eq!(self.stride, 1, "vertices between those that were drawn have no elevation of their own");
        self.drawn_elevation(vertex)
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

    /// The curve with all vertices of its detail as vertices of its own (mode `static`): the same distances and elevations as lazily.
    ///
    /// # Errors
    /// If there are more than [`MAX_VERTICES`].
    pub fn expanded(&self) -> Result<Self, ShapeError> {
        let Some(detail) = self.detail else { return Ok(self.clone()) };
        let stride = 1_usize << detail.iterations();
        let total = self.chord_count() * stride + self.starts.len();
        if total > MAX_VERTICES {
            return Err(ShapeError::TooMany { vertices: total, limit: MAX_VERTICES });
        }
        let (mut vertices, mut starts, mut path) = (Vec::with_capacity(total), Vec::new(), Vec::new());
        for part in self.parts() {
            starts.push(vertices.len() as u32);
            for ends in part.windows(2) {
                let edge = detail.of_edge(ends[0], ends[1], 0.0);
                expand_along(&edge, &mut path);
                vertices.extend_from_slice(&path[..stride]);
            }
            vertices.extend(part.last());
        }
        Ok(Self { vertices: vertices.into(), starts: starts.into(), detail: None, stride: stride as u32, ..self.clone() })
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

/// An edge as it was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// Its first vertex.
    pub first: usize,
    /// Its ends.
    pub ends: [[f64; 2]; 2],
    /// The elevations at its ends.
    pub elevations: [f64; 2],
}

impl Chord {
    /// The elevations at the first and at the second end of the chord's edge.
    #[inline(always)]
    #[must_use]
    pub fn ordered(&self, edge: &Edge) -> [f64; 2] {
        let [a, b] = self.elevations;
        if edge.flipped { [b, a] } else { [a, b] }
    }
}

/// Writes the vertices of a detailed edge in the direction that it was given.
pub(super) fn expand_along(edge: &EdgeDetail, path: &mut Vec<[f64; 2]>) {
    edge.expand(path);
    if edge.reversed {
        path.reverse();
    }
}
