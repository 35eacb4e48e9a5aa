//! An island or a massif: all generators in a row.

use super::{Conflict, GenerateError, Lakes, Landmass, Ridges, Rivers, Styles, resolve};
use crate::layout::Feature;

/// What stands on the outline of a land.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub enum Ground {
    /// Land in the sea.
    #[default]
    Island,
    /// Mountains on land: crests and dry valleys that come down to the outline, as heights above what lies beneath.
    Massif,
}

/// A land with rivers, lakes and ridges: Benjaminsen's layouts "ridges and rivers" and "ridges, rivers and lakes" (2021, section 6.1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Island {
    /// Its outline.
    pub landmass: Landmass,
    /// Its rivers.
    pub rivers: Rivers,
    /// Its lakes, if it has any.
    pub lakes: Option<Lakes>,
    /// Its ridges.
    pub ridges: Ridges,
    /// Whether it stands in the sea or on land.
    pub ground: Ground,
}

impl Island {
    /// The layout "ridges and rivers".
    #[must_use]
    pub fn ridges_and_rivers() -> Self {
        Island::default()
    }

    /// The layout "ridges, rivers and lakes".
    #[must_use]
    pub fn ridges_rivers_and_lakes() -> Self {
        Island { lakes: Some(Lakes::default()), ..Island::default() }
    }

    /// Crests and dry valleys on land.
    #[must_use]
    pub fn massif() -> Self {
        Island { ground: Ground::Massif, ..Island::default() }
    }

    /// The styles that suit it.
    ///
    /// # Errors
    /// If the rivers' spacing or the sea's elevation is outside its range.
    pub fn styles(&self, seed: u64, sea_level: f64) -> Result<Styles, GenerateError> {
        match self.ground {
            Ground::Island => Styles::for_sea(self.rivers.spacing, seed, sea_level),
            Ground::Massif => Styles::for_massif(self.rivers.spacing, seed),
        }
    }

    /// The same island in another size: all lengths of the plane times `factor`, slopes as they are.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        self.landmass.radius *= factor;
        self.rivers.spacing *= factor;
        self.ridges.step *= factor;
        self
    }

    /// The features: land, rivers, lakes, ridges.
    ///
    /// # Errors
    /// A parameter outside its range, or attributes that do not fit.
    pub fn features(&self, seed: u64, styles: &Styles) -> Result<Vec<Feature>, GenerateError> {
        let land = self.landmass.features(seed, &styles.land)?;
        let lakes = self.lakes.as_ref().map(|lakes| (lakes, &styles.lakes));
        let waters = self.rivers.features(&land, &[], lakes, seed, &styles.rivers)?;
        let ridges = self.ridges.features(&land, &waters, seed, &styles.ridges)?;
        resolve(&[land, waters, ridges].concat(), Conflict::Cut { clearance: self.ridges.step })
    }
}
