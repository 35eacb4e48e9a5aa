//! Checks of what users draw.

use super::{Curve, Elevation, MAX_ELEVATION, MAX_VERTICES, ShapeError};
use crate::geometry::PLANE_LIMIT;

/// Checks coordinates.
pub(super) fn vertices(vertices: &[[f64; 2]]) -> Result<(), ShapeError> {
    for (vertex, point) in vertices.iter().enumerate() {
        if let Some(&value) = point.iter().find(|c| c.is_nan() || c.abs() > PLANE_LIMIT) {
            return Err(ShapeError::Coordinate { vertex, value });
        }
    }
    Ok(())
}

/// Checks the elevation of a whole shape.
pub(super) fn constant(elevation: Option<f64>) -> Result<(), ShapeError> {
    if elevation.is_none_or(is_elevation) { Ok(()) } else { Err(ShapeError::Elevation { vertex: 0 }) }
}

fn is_elevation(elevation: f64) -> bool {
    elevation.abs() <= MAX_ELEVATION
}

/// Checks a curve.
pub(super) fn curve(curve: &Curve) -> Result<(), ShapeError> {
    let count = curve.vertices.len();
    if count > MAX_VERTICES {
        return Err(ShapeError::TooMany { vertices: count, limit: MAX_VERTICES });
    }
    let (kind, least) = if curve.closed { ("ring", 4) } else { ("line", 2) };
    if curve.starts.is_empty() {
        return Err(ShapeError::TooFew { kind, vertex: 0, vertices: 0, least });
    }
    vertices(&curve.vertices)?;
    for i in 0..curve.starts.len() {
        let part = curve.part(i);
        if part.len() < least {
            return Err(ShapeError::TooFew { kind, vertex: part.start, vertices: part.len(), least });
        }
        if curve.closed && curve.vertices[part.start] != curve.vertices[part.end - 1] {
            return Err(ShapeError::Open { vertex: part.end - 1, first: part.start });
        }
    }
    elevations(curve)
}

fn elevations(curve: &Curve) -> Result<(), ShapeError> {
    match &curve.elevation {
        Elevation::Absent => Ok(()),
        Elevation::Constant(elevation) => constant(Some(*elevation)),
        Elevation::Vertices(elevations) if elevations.len() != curve.vertices.len() => {
            Err(ShapeError::Elevations { elevations: elevations.len(), vertices: curve.vertices.len() })
        }
        Elevation::Vertices(elevations) => match elevations.iter().position(|&elevation| !is_elevation(elevation)) {
            Some(vertex) => Err(ShapeError::Elevation { vertex }),
            None => Ok(()),
        },
    }
}
