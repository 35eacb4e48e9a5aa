//! The plain definition of a shape's distance and nearest elevation: every edge is asked.

use super::{Along, Chord, Curve, Edge, Elevation, Nearest, Shape, curve::expand_along, edge::crosses};

impl Shape {
    /// The nearest place of the shape as samples `spacing` metres apart see it; 0 for all detail. Every edge is asked: this is what faster ways are held to.
    ///
    /// Of places at the same distance it is the one on the first edge.
    #[must_use]
    pub fn nearest(&self, p: [f64; 2], spacing: f64) -> Nearest {
        match self {
            Self::Point { at, elevation } => Nearest { distance: Edge::new(*at, *at).nearest(p).0.sqrt(), elevation: elevation.unwrap_or(0.0) },
            Self::Circle { centre, radius, elevation } => {
                Nearest { distance: Edge::new(*centre, *centre).nearest(p).0.sqrt() - radius, elevation: elevation.unwrap_or(0.0) }
            }
            Self::Line(curve) => curve.nearest(p, spacing),
            Self::Polygon(curve) => {
                let nearest = curve.nearest(p, spacing);
                let distance = if curve.surrounds(p, spacing) { -nearest.distance } else { nearest.distance };
                Nearest { distance, ..nearest }
            }
        }
    }
}

impl Curve {
    /// Calls `visit` with every chord and its path: the edges between its vertices, in order.
    fn paths(&self, spacing: f64, mut visit: impl FnMut(&Chord, &[[f64; 2]])) {
        let mut path = Vec::new();
        for chord in self.chords() {
            match &self.detail {
                Some(detail) => {
                    expand_along(&detail.of_edge(chord.ends[0], chord.ends[1], spacing), &mut path);
                    visit(&chord, &path);
                }
                None => visit(&chord, &self.vertices[chord.first..=chord.first + self.stride as usize]),
            }
        }
    }

    fn nearest(&self, p: [f64; 2], spacing: f64) -> Nearest {
        let mut least = f64::INFINITY;
        let mut elevation = 0.0;
        self.paths(spacing, |chord, path| {
            for (i, ends) in path.windows(2).enumerate() {
                let edge = Edge::new(ends[0], ends[1]);
                let (square, t) = edge.nearest(p);
                if square < least {
                    least = square;
                    elevation = self.elevation_on(chord, p, (i, path.len() - 1), (&edge, t));
                }
            }
        });
        Nearest { distance: least.sqrt(), elevation }
    }

    /// The elevation at the place `t` of an edge, number `i` of the `pieces` of a chord's path, which is nearest to `p`.
    fn elevation_on(&self, chord: &Chord, p: [f64; 2], (i, pieces): (usize, usize), (edge, t): (&Edge, f64)) -> f64 {
        if let Elevation::Absent | Elevation::Constant(_) = self.elevation {
            return chord.elevations[0];
        }
        let straight = Edge::new(chord.ends[0], chord.ends[1]);
        let [start, end] = chord.ordered(&straight);
        let share = match self.along {
            Along::Chord => straight.nearest(p).1,
            // Counted from the lexicographically first end, so that an edge has the same elevations in both directions.
            Along::Arc => {
                let piece = if straight.flipped { pieces - 1 - i } else { i };
                let t = if edge.flipped == straight.flipped { t } else { 1.0 - t };
                (piece as f64 + t) * (1.0 / pieces as f64)
            }
        };
        start + (end - start) * share
    }

    /// Whether a point lies inside: the ray eastwards crosses the edges an odd number of times.
    fn surrounds(&self, p: [f64; 2], spacing: f64) -> bool {
        let mut inside = false;
        self.paths(spacing, |_, path| {
            for ends in path.windows(2) {
                inside ^= crosses(p, ends[0], ends[1]);
            }
        });
        inside
    }
}
