//! Detail by midpoint displacement, four ways to have it (Benjaminsen 2021, chapters 8 and 13).

use super::{AttributeSet, Feature, FeatureError};
use crate::geometry::{Curve, Detail, Elevation, Shape, ShapeError};
use std::sync::Arc;

/// How a feature gets its detail.
#[derive(Clone, Debug, PartialEq)]
pub enum DetailMode {
    /// All vertices become vertices of the shape. It has the same distances as `Dynamic`, but nothing fades with the spacing of samples.
    Static,
    /// Every segment of the path becomes a feature; lines only.
    Split,
    /// The feature stays, and every segment of its path becomes a feature with these attributes, of higher priority and shorter range; lines only.
    Overlap(Arc<AttributeSet>),
    /// As `Static`, evaluated lazily.
    Dynamic,
}

impl Feature {
    /// The feature with detail: one feature, or several.
    ///
    /// # Errors
    /// If the shape has no edges, a polygon is to be split, or there would be too many vertices.
    pub fn detailed(&self, detail: Detail, mode: &DetailMode) -> Result<Vec<Self>, FeatureError> {
        let shape = self.shape().clone().detailed(detail)?;
        match mode {
            DetailMode::Dynamic => Ok(vec![self.with(shape, self.attributes())?]),
            DetailMode::Static => Ok(vec![self.with(expanded(&shape)?, self.attributes())?]),
            DetailMode::Split => self.split(&shape, self.attributes()),
            DetailMode::Overlap(fine) => {
                let mut features = self.split(&shape, fine)?;
                features.push(self.clone());
                Ok(features)
            }
        }
    }

    fn with(&self, shape: Shape, attributes: &Arc<AttributeSet>) -> Result<Self, FeatureError> {
        let mut feature = Self::new(shape, Arc::clone(attributes))?;
        feature.id.clone_from(&self.id);
        feature.precedence = self.precedence;
        Ok(feature)
    }

    /// Every segment of a line's path; a vertex between two that were drawn has its share of their elevations.
    fn split(&self, shape: &Shape, attributes: &Arc<AttributeSet>) -> Result<Vec<Self>, FeatureError> {
        let Shape::Line(curve) = expanded(shape)? else { return Err(ShapeError::Split.into()) };
        let stride = curve.stride();
        let mut features = Vec::with_capacity(curve.chord_count() * stride);
        for chord in curve.chords() {
            let [start, end] = chord.elevations;
            let at = |i: usize| start + (end - start) * (i as f64 / stride as f64);
            for i in 0..stride {
                let ends = curve.vertices()[chord.first + i..][..2].to_vec();
                let elevation = match curve.elevation() {
                    Elevation::Vertices(_) => Elevation::Vertices([at(i), at(i + 1)].into()),
                    same => same.clone(),
                };
                features.push(self.with(Shape::line(ends, elevation)?, attributes)?);
            }
        }
        Ok(features)
    }
}

fn expanded(shape: &Shape) -> Result<Shape, ShapeError> {
    match shape {
        Shape::Line(curve) => Curve::expanded(curve).map(Shape::Line),
        Shape::Polygon(curve) => Curve::expanded(curve).map(Shape::Polygon),
        Shape::Point { .. } | Shape::Circle { .. } => Err(ShapeError::NoEdges),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Attribute, Weight};

    fn set(range: f64) -> Arc<AttributeSet> {
        Arc::new(AttributeSet::new(vec![Attribute::elevation(Weight::Linear, range)]).expect("valid"))
    }

    #[test]
    fn all_modes_follow_one_path() {
        let line = Shape::line(vec![[0.0, 0.0], [80.0, 0.0], [80.0, 60.0]], Elevation::Vertices([0.0, 80.0, 20.0].into())).expect("valid");
        let mut feature = Feature::new(line, set(50.0)).expect("valid");
        feature.id = Some("a".into());
        let detail = Detail::new(3, 0.2, 5).expect("valid");
        let made = |mode| feature.detailed(detail, &mode).expect("a line");
        let (plain, split, lazy) = (made(DetailMode::Static), made(DetailMode::Split), made(DetailMode::Dynamic));
        let overlap = made(DetailMode::Overlap(set(5.0)));
        assert_eq!([plain.len(), split.len(), lazy.len(), overlap.len()], [1, 16, 1, 17]);
        assert_eq!((overlap[16].clone(), overlap[0].attributes().reach(), split[3].id.as_deref()), (feature.clone(), 5.0, Some("a")));
        assert_eq!(split[8].shape().nearest([80.0, 0.0], 0.0).elevation, 80.0);
        for i in 0..200 {
            let p = [f64::from(i % 20) * 6.0 - 20.0, f64::from(i / 20) * 9.0 - 20.0];
            let distance = |feature: &Feature| feature.shape().nearest(p, 0.0).distance;
            let least = split.iter().map(distance).fold(f64::INFINITY, f64::min);
            assert_eq!((distance(&plain[0]), distance(&lazy[0])), (least, least));
        }
    }

    #[test]
    fn polygons_are_not_split() {
        let ring = vec![[0.0, 0.0], [9.0, 0.0], [0.0, 9.0], [0.0, 0.0]];
        let polygon = Feature::new(Shape::polygon(vec![ring], Elevation::Constant(1.0)).expect("valid"), set(5.0)).expect("valid");
        let detail = Detail::new(2, 0.1, 5).expect("valid");
        assert_eq!(polygon.detailed(detail, &DetailMode::Split), Err(FeatureError::Shape(ShapeError::Split)));
        assert_eq!(polygon.detailed(detail, &DetailMode::Static).expect("valid")[0].shape().curve().map(Curve::stride), Some(4));
        let point = Feature::new(Shape::point([0.0, 0.0], Some(1.0)).expect("valid"), set(5.0)).expect("valid");
        assert_eq!(point.detailed(detail, &DetailMode::Dynamic), Err(FeatureError::Shape(ShapeError::NoEdges)));
    }
}
