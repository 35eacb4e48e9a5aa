//! Regions of drawings: masks, what lies inside outlines, and waters.

use super::{
    canvas::{Canvas, Slots},
    check::{group_numbers, range},
    document::{Drawing, DrawingError, Mask},
    profile::Scaling,
    profiles::{Profiles, profile_number},
    stroke::Drawn,
};

/// Most masks, and most regions with what lies inside outlines.
const MAX_MASKS: usize = 256;
const MAX_REGIONS: usize = 4096;

/// Most nodes inside outlines, counted for each.
const MOST_COVERED: usize = 1 << 24;

/// Regions by number from 1: what profile rules there, and which groups count.
pub(super) struct Regions {
    pub slots: Vec<u16>,
    pub profiles: Vec<Option<u16>>,
    pub shut: Vec<bool>,
}

/// The floor of a body of water.
#[derive(Debug)]
pub(super) struct Floor {
    pub water: Slots,
    pub profile: u32,
    pub depth: f32,
}

/// Masks, and what lies inside outlines; later ones over earlier ones.
pub(super) fn regions(canvas: &Canvas, drawing: &Drawing, profiles: &Profiles, drawn: &mut [Drawn]) -> Result<Regions, DrawingError> {
    let mut regions = Regions { slots: vec![0; canvas.frame.slots()], profiles: Vec::new(), shut: Vec::new() };
    if drawing.masks.len() > MAX_MASKS {
        return Err(DrawingError::new("/masks", format!("must be at most {MAX_MASKS} masks, got {}", drawing.masks.len())));
    }
    for (i, mask) in drawing.masks.iter().enumerate().filter(|(_, mask)| mask.depth.is_none()) {
        let at = format!("/masks/{i}");
        let groups = group_numbers(drawing, &mask.only, &format!("{at}/only"))?;
        let profile = mask.profile.as_ref().map(|name| profile_number(profiles, name, &format!("{at}/profile"))).transpose()?;
        let region = regions.add(&canvas.covered(&mask.geometry, &format!("{at}/geometry"))?, profile, !mask.only.is_empty());
        for drawn in drawn.iter_mut().filter(|drawn| groups.contains(&drawn.group)) {
            drawn.member_of.push(region);
        }
    }
    let mut covered = 0;
    for drawn in drawn.iter_mut() {
        let Some(inside) = &drawing.strokes[drawn.group].inside else { continue };
        let profile = profile_number(profiles, &inside.profile, &format!("/strokes/{}/inside/profile", drawn.group))?;
        let outline: Slots = drawn.nodes.keys().copied().collect();
        let slots = canvas.inside(&outline);
        covered += slots.len() + outline.len();
        if covered > MOST_COVERED || regions.profiles.len() >= MAX_REGIONS {
            let at = format!("/strokes/{}/inside", drawn.group);
            return Err(DrawingError::new(at, format!("outlines hold too much: at most {MOST_COVERED} nodes together, in {MAX_REGIONS} regions")));
        }
        let region = regions.add(&slots, Some(profile), inside.only);
        drawn.member_of.push(region);
    }
    Ok(regions)
}

impl Regions {
    fn add(&mut self, slots: &Slots, profile: Option<u16>, shut: bool) -> u16 {
        self.profiles.push(profile);
        self.shut.push(shut);
        let number = self.profiles.len() as u16;
        for slot in slots {
            self.slots[*slot as usize] = number;
        }
        number
    }
}

/// The floor of a mask that is water.
pub(super) fn floor(
    canvas: &Canvas,
    mask: &Mask,
    profiles: &Profiles,
    mean: f64,
    least_scale: f64,
    scalings: &mut Vec<Scaling>,
    at: &str,
) -> Result<Option<Floor>, DrawingError> {
    let Some(depth) = mask.depth else { return Ok(None) };
    range(&format!("{at}/depth"), depth, 1e-3..=1e6)?;
    let mut number = 0;
    if let Some(name) = &mask.profile {
        profile_number(profiles, name, &format!("{at}/profile"))?;
        let shaped = &profiles[name].1;
        number = scalings.len();
        scalings.push(shaped.profile.scaling(shaped.stepping, depth, mean, least_scale));
    }
    Ok(Some(Floor { water: canvas.covered(&mask.geometry, &format!("{at}/geometry"))?, profile: number as u32, depth: depth as f32 }))
}
