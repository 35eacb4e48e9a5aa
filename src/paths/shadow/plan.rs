//! A shadow picture made ready, and its heights.

use super::{
    super::{
        blend::Settled,
        canvas::Canvas,
        document::DrawingError,
        lattice::{Diagonal, Frame, Node, Random, Weights},
        plan::Heights,
    },
    bounds::{Bounds, Ground, Part},
    climb::{Kind, Source, climb},
    document::ShadowDrawing,
    light::{Light, Rays, Towards, shortest},
    regions::Regions,
    secondary,
};
use crate::{geometry::Stop, noise};
use std::collections::BTreeSet;

/// Of the light's fall, what lit ground falls by at most: so light reaches it at any rounding.
const LIT: f64 = 0.85;

/// How far lit ground comes above what shades it, in steps of the light's fall.
const RISE: f64 = 0.1;

/// Nodes around shadows that secondary features keep from.
const USUAL_CONTRAST: f64 = 8.0;

/// The most that a generator's profile makes its flanks steeper.
const MOST_SCALE: f32 = 8.0;

/// How much longer a path of straight and diagonal steps can be than the way as the crow flies.
const DETOUR: f64 = 1.083;

/// A shadow picture ready to become heights.
#[derive(Clone, Debug)]
pub struct ShadowPlan {
    frame: Frame,
    light: Light,
    towards: Towards,
    weights: Weights,
    base: Vec<f32>,
    bounds: Bounds,
    sources: Vec<Source>,
    /// Metres that light falls by a step along a ray.
    fall: f64,
    shadow: Vec<bool>,
}

impl ShadowPlan {
    /// Checks a shadow picture and makes it ready.
    ///
    /// # Errors
    /// If a number, programme or picture in it is not what it must be, or the picture has no shadow or nothing else.
    pub fn new(drawing: &ShadowDrawing) -> Result<Self, DrawingError> {
        drawing.check()?;
        let [columns, rows] = drawing.size;
        let frame = Frame { first: Node { row: 0, column: 0 }, columns, rows };
        let mut canvas = Canvas::around(frame, 0, drawing.spacing);
        canvas.origin = drawing.origin;
        canvas.seed = drawing.seed;
        let shadow = shadow(&canvas, drawing)?;
        let azimuth = drawing.azimuth.unwrap_or_else(|| shortest(&frame, &shadow));
        let light = Light { azimuth, tilt: drawing.tilt };
        let rays = Rays::new(&frame, azimuth);
        let base = base(&canvas, drawing)?;
        let regions = Regions::new(&frame, &shadow);
        let levels: Vec<u32> = (0..frame.slots()).map(|slot| regions.level(slot)).collect();
        let distances = distances(&canvas, &levels);
        let contrast = drawing.contrast.map_or(USUAL_CONTRAST, |metres| metres / drawing.spacing);
        let fall = light.fall() * rays.step * drawing.spacing;
        let towards = Towards::new(&frame, azimuth);
        let bounds = Bounds::new(&Ground { base: &base, levels: &levels, distances: &distances, contrast, fall }, &rays, &towards);
        let [mean, deviation] = drawing.steepness();
        let [mean_step, deviation_step] = [mean, deviation].map(|slope| (slope * drawing.spacing) as f32);
        let random = Random { mean: mean_step, deviation: deviation_step, key: noise::key(drawing.seed, 1) };
        let weights = Weights::random(frame, &random, Diagonal::Euclidean);
        let mut sources = primary(&weights, &bounds);
        // Secondary flanks are nowhere as steep as the light: they cast no shadow.
        let gentle = LIT * light.fall() / ((mean + deviation) * DETOUR);
        sources.extend(secondary::place(&canvas, drawing, &base, &bounds, gentle as f32)?);
        Ok(Self { frame, light, towards, weights, base, bounds, sources, fall, shadow })
    }

    /// The light under which the shadows show the picture.
    #[must_use]
    pub fn light(&self) -> Light {
        self.light
    }

    /// Whether shadow is wanted, node by node, row by row from the north, as heights are.
    #[must_use]
    pub fn wanted(&self) -> Vec<bool> {
        self.frame.rows_of_slots().rev().flatten().map(|slot| self.shadow[slot]).collect()
    }

    /// The heights without a search, quickly found: crests, the ground that they shade as high as it may be, and the base.
    #[must_use]
    pub fn preview(&self) -> Heights {
        let of = |(slot, base): (usize, &f32)| {
            let shown = matches!(self.bounds.parts[slot], Part::Crest | Part::Hole | Part::Shadow);
            if shown { self.bounds.upper[slot].max(*base) } else { *base }
        };
        self.finish(&self.base.iter().enumerate().map(of).collect::<Vec<f32>>(), 0)
    }

    /// The heights. Stopped, they are not whole.
    #[must_use]
    pub fn heights(&self, stop: &Stop) -> Heights {
        let floor = self.frame.rows_of_slots().flatten().map(|slot| self.base[slot]).fold(f32::INFINITY, f32::min);
        let (mut heights, settled) = climb(&self.weights, &self.sources, |slot, kind| self.bounds.of(slot, kind), floor, stop);
        for (height, base) in heights.iter_mut().zip(&self.base) {
            *height = height.max(*base);
        }
        let before = heights.clone();
        self.keep_lit(&mut heights, stop);
        self.come_up(&mut heights, &before, stop);
        self.finish(&heights, settled)
    }

    /// Takes down what would cast a shadow where there should be light: towards the light, ground rises no more than nearly as much as it does.
    fn keep_lit(&self, heights: &mut [f32], stop: &Stop) {
        let rise = LIT * self.fall;
        let top = f64::from(heights.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        let mut most = vec![f32::INFINITY; heights.len()];
        for slot in self.towards.lines().rev().take_while(|_| !stop.is_set()).flatten() {
            let least = match self.bounds.parts[slot] {
                Part::Shadow => continue,
                Part::Free | Part::Contrast => self.base[slot],
                Part::Crest | Part::Hole => heights[slot],
            };
            if heights[slot] > most[slot] {
                // What took it down took down what stands behind it: rays of its own would spread that sideways.
                heights[slot] = most[slot].max(least);
                continue;
            }
            let rays = (1..).map(|step| f64::from(heights[slot]) + step as f64 * rise);
            for (ray, (slots, share)) in rays.take_while(|ray| *ray <= top).zip(self.towards.way(slot)) {
                let passed = if share > 0.0 { &slots[..] } else { &slots[..1] };
                for slot in passed {
                    most[*slot] = most[*slot].min(ray as f32);
                }
            }
        }
    }

    /// Brings up again, as far as it was before, what was taken down so far that its neighbours shade it.
    fn come_up(&self, heights: &mut [f32], before: &[f32], stop: &Stop) {
        let top = f64::from(heights.iter().copied().fold(f32::NEG_INFINITY, f32::max));
        for slot in self.towards.lines().take_while(|_| !stop.is_set()).flatten() {
            if heights[slot] >= before[slot] {
                continue;
            }
            let own = f64::from(heights[slot]);
            let falls = (1..).map(|step| f64::from(step) * self.fall).take_while(|fall| own + fall < top);
            let horizon = falls.zip(self.towards.way(slot)).map(|(fall, ([a, b], share))| {
                let [a, b] = [a, b].map(|slot| f64::from(heights[slot]));
                a + (b - a) * share - fall
            });
            let horizon = horizon.fold(f64::NEG_INFINITY, f64::max);
            if horizon + RISE * self.fall > own {
                heights[slot] = before[slot].min((horizon + RISE * self.fall) as f32);
            }
        }
    }

    fn finish(&self, heights: &[f32], settled: u64) -> Heights {
        let metres = self.frame.rows_of_slots().rev().flatten().map(|slot| heights[slot]).collect();
        let Frame { first, columns, rows } = self.frame;
        Heights { first, columns, rows, metres, settled: Settled { nodes: settled, most: settled } }
    }
}

/// Of every slot whether shadow is wanted.
fn shadow(canvas: &Canvas, drawing: &ShadowDrawing) -> Result<Vec<bool>, DrawingError> {
    let greys = canvas.greys(&drawing.picture, "/picture")?;
    let mut shadow = vec![false; greys.len()];
    for slot in canvas.frame.rows_of_slots().flatten() {
        shadow[slot] = f64::from(greys[slot]) < drawing.threshold;
    }
    let count = shadow.iter().filter(|shadow| **shadow).count();
    let threshold = drawing.threshold;
    if count == 0 {
        Err(DrawingError::new("/picture", format!("has no shadow: no pixel is darker than {threshold} (0 black … 1 white)")))
    } else if count == canvas.frame.columns * canvas.frame.rows {
        Err(DrawingError::new("/picture", format!("is all shadow: no pixel is as bright as {threshold} (0 black … 1 white), so no light is left to show it")))
    } else {
        Ok(shadow)
    }
}

fn base(canvas: &Canvas, drawing: &ShadowDrawing) -> Result<Vec<f32>, DrawingError> {
    let [amplitude, datum] = [drawing.base.amplitude, drawing.base.datum].map(|metres| metres as f32);
    let values = canvas.ramp(&drawing.ramp(), "/base")?;
    let heights: Vec<f32> = values.into_iter().map(|value| datum + amplitude * value).collect();
    match heights.iter().find(|height| height.abs() > 1e9) {
        Some(height) => Err(DrawingError::new("/base/amplitude", format!("makes the base {height} m high somewhere: must be within 1e9"))),
        None => Ok(heights),
    }
}

/// Of every slot how many nodes it is from the nearest shadow.
fn distances(canvas: &Canvas, levels: &[u32]) -> Vec<f64> {
    let inside: BTreeSet<u32> = (0..levels.len() as u32).filter(|slot| levels[*slot as usize] > 0).collect();
    canvas.squared_distances(&inside).into_iter().map(f64::sqrt).collect()
}

/// Generators of crests and holes. Their profiles are constant: so steep that those beside them keep their heights.
fn primary(weights: &Weights, bounds: &Bounds) -> Vec<Source> {
    let offsets = weights.frame.offsets();
    let is = |slot: usize| matches!(bounds.parts[slot], Part::Crest | Part::Hole);
    let own = |slot: usize| {
        let height = bounds.upper[slot];
        let falls = offsets.into_iter().zip(weights.of(slot)).map(|(offset, weight)| (slot.wrapping_add_signed(offset), weight));
        let steepest = falls.filter(|(to, _)| is(*to)).map(|(to, weight)| (height - bounds.upper[to]) / weight).fold(1.0, f32::max);
        Source { slot: slot as u32, height, scale: steepest.min(MOST_SCALE), kind: Kind::Primary }
    };
    weights.frame.rows_of_slots().flatten().filter(|slot| is(*slot)).map(own).collect()
}

#[cfg(test)]
impl ShadowPlan {
    pub(super) fn frame(&self) -> Frame {
        self.frame
    }

    pub(super) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    pub(super) fn base(&self) -> &[f32] {
        &self.base
    }

    pub(super) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Least and greatest height of the base.
    pub(super) fn base_range(&self) -> [f32; 2] {
        let slots = self.frame.rows_of_slots().flatten();
        slots.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], slot| [low.min(self.base[slot]), high.max(self.base[slot])])
    }
}
