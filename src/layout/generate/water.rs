//! Rivers and lakes as features.

use super::{
    error::GenerateError,
    lakes::Lakes,
    plane::{Area, Point, crossing},
    read::{Water, flat, lines, rings},
    rivers::Rivers,
    style::Style,
    untangle::untangle,
};
use crate::layout::Feature;

impl Rivers {
    /// Rivers on the polygons of `land`, one feature between two places where waters meet, from its upper to its lower end, and then the lakes on them.
    ///
    /// Mouths are vertices of the land's polygons, the ends of rivers at a lake are vertices of the lake. `drawn` are rivers drawn by hand: they keep their
    /// course, are led to the shore from their lower end, get elevations and tributaries, and are part of what is returned. Channels and profiles of the
    /// style's attributes hold for a source and grow with the water. Where the style's fractal detail would let two waters cross it becomes less.
    ///
    /// # Errors
    /// A parameter outside its range, a land that is no polygon with elevations, a drawn river that is no line on the land or crosses another, or attributes that
    /// do not fit.
    pub fn features(
        &self,
        land: &[Feature],
        drawn: &[Feature],
        lakes: Option<(&Lakes, &Style)>,
        seed: u64,
        style: &Style,
    ) -> Result<Vec<Feature>, GenerateError> {
        for (index, feature) in land.iter().enumerate() {
            if rings(std::slice::from_ref(feature)).is_empty() || !feature.shape().has_elevation() {
                return Err(GenerateError::Seed { place: "rivers.land", index, reason: "must be a polygon with the shore's elevation at its vertices" });
            }
        }
        for (index, feature) in drawn.iter().enumerate() {
            if feature.shape().curve().is_none_or(crate::geometry::Curve::is_closed) {
                return Err(GenerateError::Seed { place: "rivers.drawn", index, reason: "must be a line" });
            }
        }
        let drawn: Vec<_> = lines(drawn).iter().map(|water| flat(&water.line)).collect();
        self.check_drawn(land, &drawn)?;
        let mut network = self.grow(&rings(land), &drawn, seed)?;
        if let Some((lakes, _)) = lakes {
            lakes.flood(&mut network, self.spacing, seed)?;
        }
        network.rise(self.profile());
        let reaches = network.reaches();
        let mut waters: Vec<Water> = reaches.iter().map(|reach| Water { line: reach.line.clone(), closed: false }).collect();
        waters.extend(network.lakes.iter().map(|lake| Water { line: lake.ring.iter().map(|p| [p[0], p[1], lake.level]).collect(), closed: true }));
        let styles = |k: usize| if k < reaches.len() { style } else { lakes.map_or(style, |(_, style)| style) };
        let details = untangle(&waters, (0..waters.len()).map(|k| styles(k).detail).collect());
        let mut features = Vec::with_capacity(waters.len());
        for (k, (water, detail)) in waters.iter().zip(details).enumerate() {
            let attributes = match reaches.get(k) {
                Some(reach) => style.widened(reach.upstream)?,
                None => std::sync::Arc::clone(&styles(k).attributes),
            };
            features.push(styles(k).feature(&water.line, water.closed, &attributes, detail)?);
        }
        Ok(features)
    }

    /// Checks that rivers drawn by hand lie on the land, their lower ends perhaps on its shore, and meet no others but at vertices of both.
    fn check_drawn(&self, land: &[Feature], drawn: &[Vec<Point>]) -> Result<(), GenerateError> {
        let rings: Vec<Vec<Point>> = rings(land).iter().map(|ring| flat(ring)).collect();
        let area = Area::of(rings.iter().map(Vec::as_slice), self.spacing);
        let wrong = |index: usize, reason: String| Err(GenerateError::Unfit { place: format!("rivers.drawn[{index}]"), reason });
        for (index, line) in drawn.iter().enumerate() {
            for (vertex, &p) in line.iter().enumerate() {
                let is_end = vertex == 0 || vertex + 1 == line.len();
                let is_mouth = is_end && rings.iter().any(|ring| ring.contains(&p));
                if !area.contains(p) && !is_mouth {
                    return wrong(index, format!("vertex {vertex} lies outside the land, at {} {}", p[0], p[1]));
                }
            }
            for (vertex, pair) in line.windows(2).enumerate() {
                let piece = [pair[0], pair[1]];
                let meets = |other: &[Point]| !other.iter().any(|end| piece.contains(end)) && crossing(piece, [other[0], other[1]]).is_some();
                // Of two pieces of one river the later is named.
                let before = |other: usize| if other == index { &line[..=vertex] } else { &drawn[other] };
                if let Some(other) = (0..=index).find(|&other| before(other).windows(2).any(meets)) {
                    return wrong(index, format!("crosses drawn[{other}] between vertices {vertex} and {} other than at a vertex of both", vertex + 1));
                }
                if area.edges().around(piece, 0.0).into_iter().any(|edge| meets(&area.edges().segments()[edge])) {
                    return wrong(index, format!("crosses the shore between vertices {vertex} and {}", vertex + 1));
                }
            }
        }
        Ok(())
    }
}
