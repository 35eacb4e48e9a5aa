//! What generators read from features that there are already.

use super::plane::Point;
use crate::{
    geometry::{Curve, Shape},
    layout::Feature,
};

/// A line of water: a river, or the closed shore of a lake, a land or a hole in it.
#[derive(Clone, Debug)]
pub(super) struct Water {
    /// Vertices with elevations; a closed one does not repeat its first vertex.
    pub(super) line: Vec<[f64; 3]>,
    pub(super) closed: bool,
}

/// The lines and rings of features, as they were drawn; points and circles have none.
pub(super) fn lines(features: &[Feature]) -> Vec<Water> {
    features.iter().filter_map(|feature| feature.shape().curve()).flat_map(parts).collect()
}

fn parts(curve: &Curve) -> Vec<Water> {
    let mut waters: Vec<Water> = curve.parts().map(|_| Water { line: Vec::new(), closed: curve.is_closed() }).collect();
    for (number, chord) in curve.chords().enumerate() {
        let line = &mut waters[curve.part_of(number)].line;
        let [a, b] = [0, 1].map(|end| [chord.ends[end][0], chord.ends[end][1], chord.elevations[end]]);
        if line.is_empty() {
            line.push(a);
        }
        if !curve.is_closed() || line[0] != b {
            line.push(b);
        }
    }
    waters
}

/// The rings of the polygons among features.
pub(super) fn rings(features: &[Feature]) -> Vec<Vec<[f64; 3]>> {
    let polygons = features.iter().filter(|feature| matches!(feature.shape(), Shape::Polygon(_)));
    polygons.filter_map(|feature| feature.shape().curve()).flat_map(parts).map(|water| water.line).collect()
}

/// A line without its elevations.
pub(super) fn flat(line: &[[f64; 3]]) -> Vec<Point> {
    line.iter().map(|p| [p[0], p[1]]).collect()
}
