//! What light allows: crests that cast the wanted shadows, and of every node how high terrain may be.
//!
//! Rusnell 2009 counts costs down from the highest crest and calls the bound of heights the lower bound of costs; here all of it is heights.

use super::{
    climb::Kind,
    light::{Rays, Towards},
};

/// Of a node, what it is to the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Far from shadows: secondary features may begin here.
    Free,
    /// Lit, and so near to a shadow that it sets it off (the thesis's anti-shadow).
    Contrast,
    /// Where a wanted shadow is cast from.
    Crest,
    /// In a wanted shadow.
    Shadow,
    /// Lit inside a shadow: a hole.
    Hole,
}

/// How far below the light's edge terrain in shadow stays, in steps of the light's fall, or half of what is left.
const MARGIN: f64 = 0.75;

/// How far above the light's edge holes begin, in steps of its fall; and how much less than the light they fall.
const LIFT: f64 = 1.0;
const LEVELLING: f64 = 0.05;

/// How far ground that shall be lit comes above what shades it, in steps of the light's fall.
const CLEAR: f64 = 0.05;

/// Of the light's fall, how steeply free ground may rise away from shadows and what sets them off.
const GENTLE: f64 = 0.4;

/// Of every node what it is, and how high terrain may be there.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub parts: Vec<Part>,
    /// Metres. Of crests and holes it is just the height that they need.
    pub upper: Vec<f32>,
    /// The highest crest.
    pub top: f32,
}

/// What bounds are found from.
pub(super) struct Ground<'a> {
    /// Heights of the base.
    pub base: &'a [f32],
    /// Of every slot how many regions surround it.
    pub levels: &'a [u32],
    /// Of every slot how many nodes it is from the nearest shadow; lit ones up to `contrast` set it off.
    pub distances: &'a [f64],
    pub contrast: f64,
    /// Metres that light falls by a step along a ray.
    pub fall: f64,
}

/// The height of the light's edge, or of a surface much like it, along a ray: falls by `fall` a step and is `foot` high at `end`.
#[derive(Clone, Copy, Debug)]
struct Edge {
    foot: f64,
    end: f64,
    fall: f64,
}

impl Edge {
    fn at(&self, step: f64) -> f64 {
        self.foot + (self.end - step) * self.fall
    }
}

/// Unbroken runs of a ray's steps from `first` to `last` for which something holds.
fn runs(first: usize, last: usize, holds: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for i in (first..=last).filter(|i| holds(*i)) {
        match runs.last_mut() {
            Some(run) if run[1] + 1 == i => run[1] = i,
            _ => runs.push([i, i]),
        }
    }
    runs
}

impl Bounds {
    /// Ray by ray: first what lies in shadows, level by level of the region tree, then, where all crests are known, what lies around them.
    pub(super) fn new(ground: &Ground, rays: &Rays, towards: &Towards) -> Self {
        let parts = ground.levels.iter().zip(ground.distances).map(|(level, distance)| match level {
            0 if *distance <= ground.contrast => Part::Contrast,
            0 => Part::Free,
            level if level % 2 == 1 => Part::Shadow,
            _ => Part::Hole,
        });
        let mut bounds = Self { parts: parts.collect(), upper: vec![f32::NEG_INFINITY; ground.base.len()], top: f32::NEG_INFINITY };
        for ray in rays.iter().filter(|ray| !ray.is_empty()) {
            Shadows { ground, ray, bounds: &mut bounds }.outer();
        }
        bounds.raise_holes(ground.fall, towards);
        let crests = bounds.parts.iter().zip(&bounds.upper).filter(|(part, _)| **part == Part::Crest);
        bounds.top = crests.map(|(_, height)| *height).fold(f32::NEG_INFINITY, f32::max);
        for ray in rays.iter() {
            bounds.around(ground, ray);
        }
        for slot in rays.iter().flatten().map(|slot| *slot as usize) {
            if matches!(bounds.parts[slot], Part::Free | Part::Contrast) {
                let most = f64::from(ground.base[slot]) + GENTLE * ground.fall * ground.distances[slot];
                bounds.upper[slot] = bounds.upper[slot].min(most as f32);
            }
            bounds.upper[slot] = bounds.upper[slot].max(ground.base[slot]);
        }
        bounds
    }

    /// How high paths from a kind of generator may be in a slot: flanks of crests are bounded where light must not be; [`keep_lit`](super::ShadowPlan) sees to the rest.
    pub(super) fn of(&self, slot: usize, kind: Kind) -> f32 {
        let upper = self.upper[slot];
        let bounded = kind == Kind::Secondary || !matches!(self.parts[slot], Part::Free | Part::Contrast) || upper == f32::NEG_INFINITY;
        if bounded { upper } else { f32::INFINITY }
    }

    /// Raises holes until all that stands towards the light lets it in: rays pass between the digital ones that heights were found along.
    fn raise_holes(&mut self, fall: f64, towards: &Towards) {
        for slot in towards.lines().flatten() {
            if self.parts[slot] != Part::Hole {
                continue;
            }
            let mut horizon = f64::NEG_INFINITY;
            for (step, (slots, share)) in towards.way(slot).enumerate() {
                let [a, b] = slots.map(|slot| f64::from(self.upper[slot]));
                if a == f64::NEG_INFINITY && b == f64::NEG_INFINITY {
                    break;
                }
                let height = if share == 0.0 {
                    a
                } else if b == f64::NEG_INFINITY || a == f64::NEG_INFINITY {
                    a.max(b)
                } else {
                    a + (b - a) * share
                };
                horizon = horizon.max(height - (step + 1) as f64 * fall);
            }
            let lit = horizon + CLEAR * fall;
            if f64::from(self.upper[slot]) < lit {
                self.upper[slot] = lit as f32;
            }
        }
    }

    /// Algorithm 6 where light sets shadows off, then Algorithm 7 elsewhere.
    fn around(&mut self, ground: &Ground, ray: &[u32]) {
        let Some(last) = ray.len().checked_sub(1) else { return };
        let part = |bounds: &Self, i: usize| bounds.parts[ray[i] as usize];
        let base = |i: usize| f64::from(ground.base[ray[i] as usize]);
        let top = f64::from(self.top);
        for [s, e] in runs(0, last, |i| part(self, i) == Part::Contrast) {
            let bound = |i: usize| f64::from(self.upper[ray[i] as usize]);
            // At its start the shadow before it ends, if there is one: there the light's edge meets the base.
            let after_shadow = s > 0 && part(self, s - 1) == Part::Shadow;
            let before_crest = e < last && part(self, e + 1) == Part::Crest;
            let start = if after_shadow { bound(s - 1).max(base(s)) } else { base(s) };
            let end = if before_crest { bound(e + 1) } else { top };
            self.between(ray, [s, e], [start, end]);
        }
        for [s, e] in runs(0, last, |i| part(self, i) == Part::Free) {
            let before = s.checked_sub(1).map(|i| f64::from(self.upper[ray[i] as usize]));
            let after = (e < last).then(|| [f64::from(self.upper[ray[e + 1] as usize]), base(e + 1)]);
            match (before, after) {
                (Some(start), Some([end, _])) => self.between(ray, [s, e], [start, end]),
                (Some(start), None) => self.between(ray, [s, e], [start, top]),
                // Nothing here may cast its shadow on what sets others off.
                (None, Some([_, foot])) => {
                    for (i, slot) in (s..).zip(&ray[s..=e]) {
                        self.upper[*slot as usize] = top.min(foot + (e + 1 - i) as f64 * GENTLE * ground.fall) as f32;
                    }
                }
                (None, None) => ray[s..=e].iter().for_each(|slot| self.upper[*slot as usize] = self.top),
            }
        }
    }

    /// Heights between those of the two ends of a run.
    fn between(&mut self, ray: &[u32], [s, e]: [usize; 2], [start, end]: [f64; 2]) {
        for (i, slot) in ray[s..=e].iter().enumerate() {
            let share = if e > s { i as f64 / (e - s) as f64 } else { 1.0 };
            self.upper[*slot as usize] = (start + (end - start) * share) as f32;
        }
    }
}

/// The wanted shadows of a ray.
struct Shadows<'a, 'b> {
    ground: &'a Ground<'a>,
    ray: &'a [u32],
    bounds: &'b mut Bounds,
}

impl Shadows<'_, '_> {
    fn level(&self, i: usize) -> u32 {
        self.ground.levels[self.ray[i] as usize]
    }

    fn base(&self, i: usize) -> f64 {
        f64::from(self.ground.base[self.ray[i] as usize])
    }

    /// The shadows of outer regions, as if they had no holes: each ends where its light's edge meets the base.
    fn outer(mut self) {
        let last = self.ray.len() - 1;
        for [s, e] in runs(0, last, |i| self.level(i) > 0) {
            let foot = f64::midpoint(self.base(e), self.base((e + 1).min(last)));
            self.shadow([s, e], 1, foot);
        }
    }

    /// A run of shadow whose light's edge ends `foot` high (Rusnell 2009, Eq. 5.4 and Algorithm 5).
    fn shadow(&mut self, [s, e]: [usize; 2], level: u32, foot: f64) {
        let (end, fall) = (e as f64 + 0.5, self.ground.fall);
        let holes = runs(s, e, |i| self.level(i) > level);
        // What the far end of a hole throws beyond the edge must end where the edge should: the edge ends before.
        let beyond = holes.iter().map(|[a, b]| (LIFT + LEVELLING * (b - a) as f64) * fall).fold(0.0, f64::max);
        let edge = Edge { foot: foot - beyond, end, fall };
        // The crest stands before the shadow.
        let crest = s.saturating_sub(1);
        self.raise(crest, edge.at(crest as f64));
        let (ground, ray) = (self.ground, self.ray);
        for i in (s..=e).filter(|i| ground.levels[ray[*i] as usize] == level && *i != crest) {
            let below = (0.5 * (end - i as f64)).min(MARGIN) * fall;
            self.bounds.upper[self.ray[i] as usize] = (edge.at(i as f64) - below) as f32;
        }
        for hole in holes {
            self.hole(hole, level + 1, edge);
        }
    }

    /// A run of light inside a shadow: a surface just above the light's edge that falls a little less.
    fn hole(&mut self, [s, e]: [usize; 2], level: u32, edge: Edge) {
        let fall = self.ground.fall;
        let start = edge.at(s as f64) + LIFT * fall;
        let own = Edge { foot: start, end: s as f64, fall: fall * (1.0 - LEVELLING) };
        let (ground, ray) = (self.ground, self.ray);
        for i in (s..=e).filter(|i| ground.levels[ray[*i] as usize] == level) {
            self.bounds.upper[self.ray[i] as usize] = own.at(i as f64) as f32;
        }
        for [a, b] in runs(s, e, |i| self.level(i) > level) {
            if a > s {
                self.shadow([a, b], level + 1, own.at(b as f64 + 0.5));
            } else {
                // Nothing stands before it but the shadow around.
                for i in a..=b {
                    let below = (0.5 * (edge.end - i as f64)).min(MARGIN) * fall;
                    self.bounds.upper[self.ray[i] as usize] = (edge.at(i as f64) - below) as f32;
                }
            }
        }
    }

    fn raise(&mut self, i: usize, height: f64) {
        let slot = self.ray[i] as usize;
        self.bounds.parts[slot] = Part::Crest;
        self.bounds.upper[slot] = self.bounds.upper[slot].max(height as f32);
    }
}
