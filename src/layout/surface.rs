//! What a layout evaluates to.

use super::{FieldKind, Layout};
use crate::geometry::Stop;

/// What is wanted beside elevation and depth of water.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Numbers of the fields ([`Layout::fields`]), ascending.
    pub fields: Vec<usize>,
    /// Whether the shares of all names are wanted beside the heaviest name.
    pub fractions: bool,
    /// Whether the share of each sample that water covers is wanted.
    pub cover: bool,
    /// What ends the evaluation: then the surface is not whole.
    pub stop: Stop,
}

impl Layout {
    /// Every field with its fractions.
    #[must_use]
    pub fn everything(&self) -> Selection {
        let own = |name: &str| !matches!(name, "elevation" | "water_depth");
        Selection { fields: (0..self.fields.len()).filter(|&i| own(&self.fields[i].name)).collect(), fractions: true, cover: true, stop: Stop::never() }
    }
}

/// The terrain over a window, row by row from north to south.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutSurface {
    /// Elevation of the ground in metres.
    pub elevation: Vec<f32>,
    /// Metres of water above the ground.
    pub water_depth: Vec<f32>,
    /// The share 0 … 1 of each sample that lies under the water of features, the sea not counted; empty if not selected.
    pub water_cover: Vec<f32>,
    /// The share 0 … 1 of each sample that is land though its mean lies below the sea, as far as features say so (from afar); empty if not selected.
    pub dry: Vec<f32>,
    /// The fields that were selected, in their order.
    pub fields: Vec<FieldSurface>,
}

/// One field over a window.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldSurface {
    /// Numbers, all components of a sample together.
    Numbers(Vec<f32>),
    /// Names.
    Names {
        /// 0 where no feature says anything, else one more than the number of the heaviest name; of equal weights the lexically first.
        heaviest: Vec<u16>,
        /// The share of every name, all of a sample together, summing to 1 or 0; empty if not selected.
        fractions: Vec<f32>,
    },
}

impl LayoutSurface {
    pub(super) fn new(layout: &Layout, selection: &Selection, samples: usize) -> Self {
        let field = |&i: &usize| match &layout.fields[i].kind {
            FieldKind::Numbers(components) => FieldSurface::Numbers(vec![0.0; samples * components]),
            FieldKind::Names(names) => {
                let fractions = if selection.fractions { samples * names.len() } else { 0 };
                FieldSurface::Names { heaviest: vec![0; samples], fractions: vec![0.0; fractions] }
            }
        };
        let cover = if selection.cover { samples } else { 0 };
        Self {
            elevation: vec![0.0; samples],
            water_depth: vec![0.0; samples],
            water_cover: vec![0.0; cover],
            dry: Vec::new(),
            fields: selection.fields.iter().map(field).collect(),
        }
    }
}
