//! How the terrain of a layer lies over what is below.

use super::Layer;
use crate::geometry::{SurfaceRows, Window};
use serde::{Deserialize, Serialize};

/// How a layer lies over what is below. Where nothing of the layer reaches, all of them leave what is below as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Blend {
    /// The layer takes the place of what is below.
    #[default]
    Replace,
    /// Its elevations are added.
    Add,
    /// The higher ground.
    Max,
    /// The lower ground.
    Min,
}

impl Blend {
    fn elevation(self, below: f32, own: f32) -> f32 {
        match self {
            Self::Replace => own,
            // Where the layer adds nothing, not even the sign of a zero may change: how a window is divided decides whether a layer is asked there.
            Self::Add if own == 0.0 => below,
            Self::Add => below + own,
            Self::Max if own > below => own,
            Self::Min if own < below => own,
            Self::Max | Self::Min => below,
        }
    }
}

/// What is below a layer: elevations, and the water that layers brought.
pub(in crate::world) struct Below<'a, 'b> {
    pub rows: SurfaceRows<'a>,
    /// The share of each sample that is land though its mean may lie below the sea; empty if water is not wanted.
    pub dry: &'b mut [f32],
    /// Of each of the layer's numbers of materials, that in the world.
    pub materials: &'b [u16],
    /// The share of every material of the world, and before them of none, all of a sample together; empty if weights are not wanted.
    pub shares: &'b mut [f32],
}

/// Mixes the shares of a layer's materials at a sample into those of the world's below it, as far as the layer says anything.
fn mix(below: &mut [f32], own: &[f32], materials: &[u16], share: f32) {
    if own.iter().all(|&own| own == 0.0) {
        return;
    }
    for below in &mut *below {
        *below *= 1.0 - share;
    }
    for (&own, &material) in own.iter().zip(&materials[1..]) {
        below[usize::from(material)] += share * own;
    }
}

impl Layer {
    /// Lays the layer over what is below, and gives that back.
    pub(in crate::world) fn lay<'a>(&self, window: &Window, below: Below<'a, '_>) -> SurfaceRows<'a> {
        let Below { mut rows, dry, materials, shares: all } = below;
        let bounds = window.bounds();
        if !self.ground.reaches(&bounds) || self.shown.as_ref().is_some_and(|mask| !mask.bounds().meets(&bounds)) {
            return rows;
        }
        let SurfaceRows { elevation, water_depth, water_cover, material, weights, stop, .. } = &mut rows;
        let nothing = if self.blend == Blend::Add { vec![0.0; elevation.len()] } else { Vec::new() };
        let base: &[f32] = if self.blend == Blend::Add { &nothing } else { elevation };
        let (own, names, fractions) = self.ground.sample(window, base, [!water_cover.is_empty(), !material.is_empty(), !weights.is_empty()], stop);
        let (count, known) = (all.len() / elevation.len().max(1), materials.len() - 1);
        let shares = self.shown.as_ref().map(|mask| mask.shares(window, self.fade));
        for i in 0..elevation.len() {
            let share = shares.as_ref().map_or(1.0, |shares| shares[i]);
            if share == 0.0 {
                continue;
            }
            let under = elevation[i];
            let ground = self.blend.elevation(under, own.elevation[i]);
            elevation[i] = if share == 1.0 { ground } else { under + (ground - under) * share };
            if let Some(depth) = water_depth.get_mut(i) {
                // Water that was there keeps its surface where the ground rises, and does not follow it down.
                let kept = (under + *depth - elevation[i]).min(*depth).max(0.0);
                // Of water that is too narrow for its depth to be seen, a metre of ground covers all.
                let still = if *depth > 0.0 { kept / *depth } else { (1.0 + under - elevation[i]).clamp(0.0, 1.0) };
                let brought = share
                    * match self.blend {
                        Blend::Replace | Blend::Add => own.water_depth[i],
                        // Water under ground that another layer gives does not show.
                        Blend::Max | Blend::Min => (own.elevation[i] + own.water_depth[i] - ground).clamp(0.0, own.water_depth[i]),
                    };
                water_cover[i] = (water_cover[i] * still).max(own.water_cover[i] * share);
                *depth = kept.max(brought);
                dry[i] = (dry[i] * (1.0 - share)).max(own.dry.get(i).copied().unwrap_or(0.0) * share);
            }
            if let Some(own) = fractions.get(i * known..(i + 1) * known) {
                mix(&mut all[i * count..][..count], own, materials, share);
            }
            if let Some(&name) = names.get(i).filter(|&&name| name > 0 && share >= 0.5) {
                material[i] = materials[usize::from(name)];
            }
        }
        rows
    }
}
