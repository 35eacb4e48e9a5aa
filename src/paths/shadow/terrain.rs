//! A shadow picture's terrain in the plane.

use super::{super::plan::Heights, document::ShadowDrawing};
use crate::geometry::{Raster, Rectangle, Stop, Window};

/// The heights of a shadow picture over the plane: metres of elevation, not above what is beneath. Beyond its nodes what is beneath stays, and where samples are far apart its edge is as
/// soft as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowTerrain {
    heights: Raster,
    /// 1 at nodes.
    cover: Raster,
}

impl ShadowTerrain {
    /// Puts heights in their place.
    #[must_use]
    pub fn new(drawing: &ShadowDrawing, heights: &Heights) -> Self {
        let cover = Heights { metres: vec![1.0; heights.metres.len()], ..heights.clone() };
        Self { heights: heights.placed(drawing.origin, drawing.spacing), cover: cover.placed(drawing.origin, drawing.spacing) }
    }

    /// Beyond this there is nothing at any spacing.
    #[must_use]
    pub fn bounds(&self) -> Rectangle {
        self.cover.bounds()
    }

    /// Puts its elevations over those of a window, row by row from the north. Stopped, they are not whole.
    pub fn lay(&self, window: &Window, stop: &Stop, elevation: &mut [f32]) {
        let [mut own, mut cover] = [vec![0.0; elevation.len()], vec![0.0; elevation.len()]];
        self.heights.add(window, stop, &mut own);
        self.cover.add(window, stop, &mut cover);
        for ((elevation, own), cover) in elevation.iter_mut().zip(own).zip(cover) {
            // Where it does not reach not a bit of what is beneath may change.
            if cover > 0.0 {
                *elevation = *elevation * (1.0 - cover) + own;
            }
        }
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        self.heights.cost_ns(window) + self.cover.cost_ns(window)
    }
}
