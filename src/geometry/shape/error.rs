//! What can be wrong with a shape.

/// Why a shape cannot be made. Vertices are counted from 0, over all rings of a polygon, closing vertices included.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A coordinate that is not a number, is infinite or lies beyond [`PLANE_LIMIT`](crate::geometry::PLANE_LIMIT).
    #[error("vertex {vertex}: coordinates must be numbers within 2^40 = 1099511627776 m of the origin, got {value}")]
    Coordinate {
        /// Which vertex.
        vertex: usize,
        /// Its coordinate.
        value: f64,
    },
    /// A vertex without an elevation where others have one, or with one that is not a number of metres within ±10^6.
    #[error("vertex {vertex} needs an elevation between -1000000 and 1000000 m, as the third coordinate")]
    Elevation {
        /// Which vertex.
        vertex: usize,
    },
    /// Not as many elevations as vertices.
    #[error("{elevations} elevations do not match {vertices} vertices")]
    Elevations {
        /// How many elevations there are.
        elevations: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More vertices than [`MAX_VERTICES`](super::MAX_VERTICES).
    #[error("{vertices} vertices are more than the {limit} allowed: vertex {limit} is the first too many")]
    TooMany {
        /// How many there are.
        vertices: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A line or a ring with too few vertices.
    #[error("the {least} vertices that a {kind} needs at least are not there: vertex {vertex} begins one of {vertices}")]
    TooFew {
        /// `line` or `ring`.
        kind: &'static str,
        /// Where it begins.
        vertex: usize,
        /// How many it has.
        vertices: usize,
        /// How many it needs.
        least: usize,
    },
    /// A ring whose last vertex is not its first.
    #[error("vertex {vertex} must close its ring: it must equal vertex {first}")]
    Open {
        /// The last vertex of the ring.
        vertex: usize,
        /// The first vertex of the ring.
        first: usize,
    },
    /// Two edges of a polygon that cross, touch within a ring, or overlap.
    #[error("the polygon crosses itself: the edge from vertex {vertex} meets the edge from vertex {other}")]
    Crossing {
        /// Where the first edge begins.
        vertex: usize,
        /// Where the second edge begins.
        other: usize,
    },
    /// A polygon whose edges lie so close together that checking them would take too long.
    #[error("vertex {vertex}: so many of the polygon's edges lie across each other's ways that they cannot be checked: give it fewer or shorter edges")]
    Entangled {
        /// Where the check had to stop.
        vertex: usize,
    },
    /// A hole that does not lie inside the outer ring, or lies inside another hole.
    #[error("vertex {vertex} begins a hole that is not inside the polygon")]
    Hole {
        /// Where the hole begins.
        vertex: usize,
    },
    /// A radius that is not a positive number of metres.
    #[error("a radius must be a positive number of metres up to 2^40, got {0}")]
    Radius(f64),
    /// Detail for a shape without edges.
    #[error("only lines and polygons can have detail")]
    NoEdges,
    /// A polygon whose edges were to become features.
    #[error("only lines can be split: the edges of a polygon have no inside")]
    Split,
    /// Too many iterations of midpoint displacement.
    #[error("{0} iterations of midpoint displacement are more than the {max} allowed", max = super::MAX_ITERATIONS)]
    Iterations(u8),
    /// A displacement that is not between 0 and 1.
    #[error("a displacement is a share of a segment's length between 0 and 1, got {0}")]
    Displacement(f64),
    /// A displacement by which a river would leave its straight path too far.
    #[error("a river with {iterations} iterations needs a displacement of at most {bound} = tan(90°/{iterations})/2, got {displacement}")]
    River {
        /// The displacement asked for.
        displacement: f64,
        /// The greatest allowed.
        bound: f64,
        /// Iterations.
        iterations: u8,
    },
}

impl ShapeError {
    /// The vertex that is wrong, if it is one.
    #[must_use]
    pub fn vertex(&self) -> Option<usize> {
        match self {
            Self::Coordinate { vertex, .. }
            | Self::Elevation { vertex }
            | Self::TooFew { vertex, .. }
            | Self::Open { vertex, .. }
            | Self::Crossing { vertex, .. }
            | Self::Entangled { vertex }
            | Self::Hole { vertex } => Some(*vertex),
            Self::TooMany { limit, .. } => Some(*limit),
            _ => None,
        }
    }
}
