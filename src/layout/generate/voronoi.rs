//! The Voronoi diagram of places, as a graph of its vertices.
//!
//! The triangulation is the crate `delaunator` (ISC; the port of the reference implementation by its author). It computes in single IEEE operations with exact
//! orientation tests (`robust`), sorts, and uses no hash maps, so it gives the same triangles on every machine.

use super::plane::Point;

/// A vertex of the diagram: the centre of a circle through three places that holds no other place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) at: Point,
    /// The three places on the circle, by their indices.
    pub(super) places: [usize; 3],
}

/// An edge of the diagram: it lies as far from one place as from the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Its ends, as indices of vertices.
    pub(super) ends: [usize; 2],
    /// The places on both of its sides.
    pub(super) places: [usize; 2],
}

/// Vertices and finite edges of the Voronoi diagram; empty when all places lie on one line. Places must differ from each other.
pub(super) fn diagram(places: &[Point]) -> (Vec<Vertex>, Vec<Edge>) {
    // Near the first place numbers are small, and products of them exact enough, wherever on the plane the layout lies.
    let Some(&origin) = places.first() else { return (Vec::new(), Vec::new()) };
    let local: Vec<_> = places.iter().map(|p| delaunator::Point { x: p[0] - origin[0], y: p[1] - origin[1] }).collect();
    let triangulation = delaunator::triangulate(&local);
    let triangles = &triangulation.triangles;
    let vertices = triangles
        .chunks_exact(3)
        .map(|corner| {
            let places = [corner[0], corner[1], corner[2]];
            let centre = circumcentre(places.map(|place| [local[place].x, local[place].y]));
            Vertex { at: [origin[0] + centre[0], origin[1] + centre[1]], places }
        })
        .collect();
    let edges = triangulation.halfedges.iter().enumerate().filter(|&(half, &twin)| twin != delaunator::EMPTY && half < twin);
    let edges = edges.map(|(half, &twin)| Edge { ends: [half / 3, twin / 3], places: [triangles[half], triangles[delaunator::next_halfedge(half)]] });
    (vertices, edges.collect())
}

/// The centre of the circle through three places; not finite when they lie on one line.
fn circumcentre([a, b, c]: [Point; 3]) -> Point {
    let ([dx, dy], [ex, ey]) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let (b2, c2, twice) = (dx * dx + dy * dy, ex * ex + ey * ey, 2.0 * (dx * ey - dy * ex));
    [a[0] + (ey * b2 - dy * c2) / twice, a[1] + (dx * c2 - ex * b2) / twice]
}
