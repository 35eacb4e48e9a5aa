//! Shadow pictures as users write them.

use super::super::{
    check::range,
    document::{Drawing, DrawingError, Picture, Ramp, one, parse},
};
use crate::geometry::PLANE_LIMIT;
use serde::{Deserialize, Serialize};

/// Most nodes of a shadow picture.
pub const MAX_SHADOW_NODES: usize = 1 << 22;

/// Most secondary peaks, and most ridges.
const MAX_SECONDARY: usize = 10_000;

/// A picture that terrain shall show by its shadows. Lengths and heights are metres, angles degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShadowDrawing {
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The south-western node.
    #[serde(default)]
    pub origin: [f64; 2],
    /// Between nodes.
    #[serde(default = "one")]
    pub spacing: f64,
    /// Nodes from west to east and from south to north.
    pub size: [usize; 2],
    /// What weights and places are drawn from.
    #[serde(default)]
    pub seed: u64,
    /// What the shadows shall show, dark where there is shadow: a node a pixel.
    pub picture: Picture,
    /// Greys (0 black … 1 white) below this are shadow.
    #[serde(default = "half")]
    pub threshold: f64,
    /// Of the light from the vertical, 5 … 88.
    pub tilt: f64,
    /// Where the light comes from, clockwise from north, 0 … 359; without it, the one of these 360 under which the longest shadow is shortest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth: Option<u16>,
    /// What features stand on.
    pub base: ShadowBase,
    /// Mean fall of flanks, metres a metre, above 0; without it twice that of the light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Most deviation from it, 0 up to less than the mean; without it three quarters of the mean.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// How wide the lit ground around shadows is that secondary features keep from; without it 8 nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contrast: Option<f64>,
    /// What makes a landscape of it.
    #[serde(default)]
    pub secondary: Secondary,
}

fn half() -> f64 {
    0.5
}

/// The terrain that features stand on: `datum + amplitude · programme`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShadowBase {
    /// Programme text.
    pub programme: String,
    /// Metres per programme unit.
    pub scale: f64,
    /// Metres from the picture's origin to the programme's.
    #[serde(default)]
    pub origin: [f64; 2],
    /// Hashed with the picture's seed.
    #[serde(default)]
    pub seed: u64,
    /// Metres a unit.
    #[serde(default = "one")]
    pub amplitude: f64,
    /// Metres that are added.
    #[serde(default)]
    pub datum: f64,
}

/// Features that cast no shadow of their own: what makes a landscape of the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Secondary {
    /// How many peaks.
    pub peaks: usize,
    /// How many ridges.
    pub ridges: usize,
    /// How high they are between the base (where its values are least) and what the light allows (where they are greatest); `between` has no meaning here. Without it fBm over a
    /// fourth of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heights: Option<Ramp>,
}

impl Default for Secondary {
    fn default() -> Self {
        Self { peaks: 10, ridges: 75, heights: None }
    }
}

impl ShadowDrawing {
    /// Reads a shadow picture. What it means is checked when it is [made ready](super::ShadowPlan).
    ///
    /// # Errors
    /// If it is not JSON, or a field is missing, unknown or of the wrong type.
    pub fn parse(json: &[u8]) -> Result<Self, DrawingError> {
        parse(json)
    }

    /// Metres a metre that its light falls by over the ground.
    pub(super) fn fall(&self) -> f64 {
        1.0 / libm::tan(self.tilt.to_radians())
    }

    /// Mean fall of flanks and most deviation from it.
    pub(super) fn steepness(&self) -> [f64; 2] {
        let mean = self.mean.unwrap_or(2.0 * self.fall());
        [mean, self.deviation.unwrap_or(0.75 * mean)]
    }

    /// How high secondary features are, 0 … 1.
    pub(super) fn shares(&self) -> Ramp {
        let side = self.size[0].max(self.size[1]) as f64 * self.spacing;
        let usual = || Ramp { programme: "fbm(3, 2, 2)".to_owned(), scale: side / 4.0, origin: [0.0, 0.0], seed: 1, between: None };
        Ramp { between: Some([0.0, 1.0]), ..self.secondary.heights.clone().unwrap_or_else(usual) }
    }

    /// The base as drawings have programmes.
    pub(super) fn ramp(&self) -> Ramp {
        let ShadowBase { programme, scale, origin, seed, .. } = self.base.clone();
        Ramp { programme, scale, origin, seed, between: None }
    }

    /// Refuses numbers outside their ranges.
    pub(super) fn check(&self) -> Result<(), DrawingError> {
        let [columns, rows] = self.size;
        if columns < 4 || rows < 4 || columns.saturating_mul(rows) > MAX_SHADOW_NODES {
            return Err(DrawingError::new("/size", format!("must be at least 4 × 4 and at most {MAX_SHADOW_NODES} nodes together, got {columns} × {rows}")));
        }
        range("/spacing", self.spacing, 1e-3..=1e6)?;
        for (axis, origin) in self.origin.iter().enumerate() {
            range(&format!("/origin/{axis}"), *origin, -PLANE_LIMIT..=PLANE_LIMIT)?;
        }
        range("/threshold", self.threshold, 1e-3..=1.0)?;
        range("/tilt", self.tilt, 5.0..=88.0)?;
        if let Some(azimuth) = self.azimuth.filter(|azimuth| *azimuth >= 360) {
            return Err(DrawingError::new("/azimuth", format!("must be a whole number 0 … 359, got {azimuth}")));
        }
        range("/base/amplitude", self.base.amplitude, -1e6..=1e6)?;
        range("/base/datum", self.base.datum, -1e6..=1e6)?;
        for (axis, origin) in self.base.origin.iter().enumerate() {
            range(&format!("/base/origin/{axis}"), *origin, -PLANE_LIMIT..=PLANE_LIMIT)?;
        }
        let [mean, deviation] = self.steepness();
        range("/mean", mean, 1e-6..=1e6)?;
        if !(0.0..mean).contains(&deviation) {
            return Err(DrawingError::new("/deviation", format!("must be 0 up to less than the mean {mean}, got {deviation}")));
        }
        if let Some(contrast) = self.contrast {
            range("/contrast", contrast, 0.0..=1e9)?;
        }
        for (name, count) in [("peaks", self.secondary.peaks), ("ridges", self.secondary.ridges)] {
            if count > MAX_SECONDARY {
                return Err(DrawingError::new(format!("/secondary/{name}"), format!("must be at most {MAX_SECONDARY}, got {count}")));
            }
        }
        Ok(())
    }
}

/// What a document of paths draws: told apart by `picture`, which only shadow pictures have.
#[derive(Clone, Debug, PartialEq)]
pub enum PathsDocument {
    /// Strokes.
    Drawing(Box<Drawing>),
    /// A picture by its shadows.
    Shadow(Box<ShadowDrawing>),
}

impl PathsDocument {
    /// Reads either.
    ///
    /// # Errors
    /// As [`Drawing::parse`] and [`ShadowDrawing::parse`].
    pub fn parse(json: &[u8]) -> Result<Self, DrawingError> {
        #[derive(Deserialize)]
        struct Probe {
            picture: Option<serde::de::IgnoredAny>,
        }
        let is_shadow = serde_json::from_slice::<Probe>(json).is_ok_and(|probe| probe.picture.is_some());
        if is_shadow { ShadowDrawing::parse(json).map(|own| Self::Shadow(Box::new(own))) } else { Drawing::parse(json).map(|own| Self::Drawing(Box::new(own))) }
    }
}
