//! Shapes in the plane with elevations: points, circles, lines and polygons, plain or with fractal detail.

mod curve;
mod detail;
mod edge;
mod error;
mod nearest;
mod validity;

pub use curve::{Along, Chord, Curve, Elevation};
pub use detail::{Detail, EdgeDetail, MAX_ITERATIONS};
pub use edge::{Edge, crosses};
pub use error::ShapeError;

use super::Rectangle;

/// Most vertices of a shape.
pub const MAX_VERTICES: usize = 1_000_000;

/// Greatest magnitude of an elevation in metres.
const MAX_ELEVATION: f64 = 1_000_000.0;

/// The nearest place of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Metres from the shape, negative inside a polygon or a circle.
    pub distance: f64,
    /// Elevation of the shape there in metres; 0 if it has none.
    pub elevation: f64,
}

/// A shape in the plane. Coordinates are world metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A point.
    Point {
        /// Where it is.
        at: [f64; 2],
        /// Its elevation in metres, if it has one.
        elevation: Option<f64>,
    },
    /// A disc.
    Circle {
        /// Its centre.
        centre: [f64; 2],
        /// Its radius in metres.
        radius: f64,
        /// Its elevation in metres, if it has one.
        elevation: Option<f64>,
    },
    /// A segment, a polyline or several of them.
    Line(Curve),
    /// A polygon with holes.
    Polygon(Curve),
}

impl Shape {
    /// A point.
    ///
    /// # Errors
    /// If a coordinate or the elevation is not a number in range.
    pub fn point(at: [f64; 2], elevation: Option<f64>) -> Result<Self, ShapeError> {
        validity::vertices(&[at])?;
        validity::constant(elevation)?;
        Ok(Self::Point { at, elevation })
    }

    /// A disc; the distance is negative inside.
    ///
    /// # Errors
    /// If a coordinate, the radius or the elevation is not a number in range.
    pub fn circle(centre: [f64; 2], radius: f64, elevation: Option<f64>) -> Result<Self, ShapeError> {
        validity::vertices(&[centre])?;
        validity::constant(elevation)?;
        if !(radius > 0.0 && radius <= super::PLANE_LIMIT) {
            return Err(ShapeError::Radius(radius));
        }
        Ok(Self::Circle { centre, radius, elevation })
    }

    /// A polyline of two vertices or more.
    ///
    /// # Errors
    /// If there are too few or too many vertices, or a coordinate or an elevation is not a number in range.
    pub fn line(vertices: Vec<[f64; 2]>, elevation: Elevation) -> Result<Self, ShapeError> {
        Ok(Self::Line(Curve::new(vec![vertices], elevation, false)?))
    }

    /// A polygon: its outer ring and its holes, each closed (the last vertex is the first), in either direction. Elevations at vertices count over all rings.
    ///
    /// # Errors
    /// If a ring is open or too short, there are too many vertices, edges cross, a hole lies outside, or a coordinate or an elevation is not a number in range.
    pub fn polygon(rings: Vec<Vec<[f64; 2]>>, elevation: Elevation) -> Result<Self, ShapeError> {
        Ok(Self::Polygon(Curve::new(rings, elevation, true)?))
    }

    /// The shape with fractal detail, which is evaluated lazily (mode `dynamic`).
    ///
    /// # Errors
    /// If the shape has no edges.
    pub fn detailed(self, detail: Detail) -> Result<Self, ShapeError> {
        match self {
            Self::Line(curve) => Ok(Self::Line(curve.detailed(detail))),
            Self::Polygon(curve) => Ok(Self::Polygon(curve.detailed(detail))),
            Self::Point { .. } | Self::Circle { .. } => Err(ShapeError::NoEdges),
        }
    }

    /// The lines and rings, `None` for points and circles.
    #[must_use]
    pub fn curve(&self) -> Option<&Curve> {
        match self {
            Self::Line(curve) | Self::Polygon(curve) => Some(curve),
            Self::Point { .. } | Self::Circle { .. } => None,
        }
    }

    /// Whether it says an elevation.
    #[must_use]
    pub fn has_elevation(&self) -> bool {
        match self {
            Self::Point { elevation, .. } | Self::Circle { elevation, .. } => elevation.is_some(),
            Self::Line(curve) | Self::Polygon(curve) => *curve.elevation() != Elevation::Absent,
        }
    }

    /// A rectangle that holds the shape, its detail and all that is at most `offset` metres away.
    #[must_use]
    pub fn bounds(&self, offset: f64) -> Rectangle {
        match self {
            Self::Point { at, .. } => Rectangle::around(&[*at]),
            Self::Circle { centre, radius, .. } => Rectangle::around(&[*centre]).grown(*radius),
            Self::Line(curve) | Self::Polygon(curve) => curve.bounds(),
        }
        .grown(offset)
    }
}

#[cfg(test)]
mod tests;
