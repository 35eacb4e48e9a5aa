//! A drawing made ready: its graph, its strokes and their costs.

use super::{
    blend::{Bias, Blender, Blending, Settled, Stroke, approximate},
    canvas::Canvas,
    check::{MAX_BIAS, check},
    document::{Drawing, DrawingError, Edges, Quantity, SeaLevel},
    lattice::{Node, Random, Weights},
    profile::{Crest, Scaling},
    profiles::{profiles, scalings},
    regions::{Floor, floor, regions},
    ridges,
    search::{Generator, Terrain},
    stroke::{Drawn, draw},
};
use crate::{
    geometry::{Lattice, Raster, Stop},
    noise,
};
use std::collections::{BTreeMap, BTreeSet};

/// Most nodes of a drawing.
pub const MAX_NODES: usize = 1 << 24;

/// Most nodes of a drawing with all that its strokes reach.
const MAX_UNBOUNDED: usize = 1 << 22;

/// Most nodes that searches for regions which shut strokes out may go over, a frame a region.
const MOST_SHUT: usize = 1 << 28;

/// Most steps from a crest to where its paths end.
pub const MAX_REACH: usize = 1024;

/// Most strokes of a drawing.
pub const MAX_STROKES: usize = 100_000;

/// A drawing ready to become heights.
#[derive(Debug)]
pub struct Plan {
    pub(super) canvas: Canvas,
    pub(super) weights: Weights,
    pub(super) scalings: Vec<Scaling>,
    pub(super) regions: Vec<u16>,
    /// Of every slot the region that counts its members only, or 0; empty without such.
    pub(super) shut: Vec<u16>,
    pub(super) strokes: Vec<Stroke>,
    biases: Biases,
    floors: Vec<Floor>,
    sea_level_cost: f32,
    vertical_scale: f32,
    /// Profiles that rule in regions, whatever stroke a path comes from.
    ruling: Vec<u16>,
    thresholds: [f32; 2],
}

#[derive(Debug)]
enum Biases {
    Constant(f32),
    Slots(Vec<f32>),
}

/// A finite drawing's heights.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// The south-western node; the drawing's own is (0, 0).
    pub first: Node,
    /// Nodes from west to east.
    pub columns: usize,
    /// Nodes from south to north.
    pub rows: usize,
    /// Metres above sea level, row by row from the north.
    pub metres: Vec<f32>,
    /// How many nodes were settled for it.
    pub settled: Settled,
}

impl Heights {
    /// The heights in their drawing's place.
    #[must_use]
    pub fn raster(&self, drawing: &Drawing) -> Raster {
        self.placed(drawing.origin, drawing.spacing)
    }

    /// The heights on nodes `spacing` metres apart; the drawing's own south-western node lies at `origin`.
    #[must_use]
    pub fn placed(&self, origin: [f64; 2], spacing: f64) -> Raster {
        let values = self.metres.chunks(self.columns.max(1)).rev().flatten().copied().collect();
        let place = Lattice { origin, first: [self.first.column, self.first.row], spacing };
        Raster::new(place, self.columns, values)
    }
}

impl Plan {
    /// Checks a drawing and makes it ready.
    ///
    /// # Errors
    /// If a number, programme, picture or name in it is not what it must be.
    pub fn new(drawing: &Drawing) -> Result<Self, DrawingError> {
        check(drawing)?;
        Self::with_margin(drawing, 0)
    }

    /// The same with all the ground around the drawing that its strokes reach: there is no border that paths end at.
    ///
    /// # Errors
    /// As [`Plan::new`], or if its strokes may reach more than [`MAX_REACH`] nodes, or there are more than 2^22 nodes with what they reach.
    pub fn unbounded(drawing: &Drawing) -> Result<Self, DrawingError> {
        let [columns, rows] = drawing.size;
        if columns.saturating_mul(rows) > MAX_UNBOUNDED {
            return Err(DrawingError::new("/size", format!("must be at most {MAX_UNBOUNDED} nodes together, got {columns} × {rows}")));
        }
        let mut plan = Self::new(drawing)?;
        let mut margin = 0;
        while plan.reach() > margin {
            margin = plan.reach();
            if margin > MAX_REACH {
                return Err(DrawingError::new(
                    "/profiles",
                    format!("paths may reach {margin} nodes, more than {MAX_REACH}: make profiles less wide or the spacing greater"),
                ));
            }
            let [columns, rows] = drawing.size.map(|n| n + 2 * margin);
            if columns.saturating_mul(rows) > MAX_UNBOUNDED {
                return Err(DrawingError::new(
                    "/size",
                    format!("with the {margin} nodes that strokes may reach these are {columns} × {rows}, more than {MAX_UNBOUNDED} together"),
                ));
            }
            plan = Self::with_margin(drawing, margin)?;
        }
        Ok(plan)
    }

    /// The most steps that a path takes from a crest before it ends.
    #[must_use]
    pub fn reach(&self) -> usize {
        // Of each profile the highest crest.
        let mut highest: BTreeMap<u32, Crest> = BTreeMap::new();
        for generator in self.strokes.iter().flat_map(|stroke| &stroke.generators) {
            let crest = highest.entry(generator.profile).or_insert(generator.crest);
            if generator.crest.cost < crest.cost {
                *crest = generator.crest;
            }
        }
        let (end, weights) = (self.sea_level_cost - self.thresholds[0], [self.weights.least(); 8]);
        let steps = |(profile, crest): (&u32, &Crest)| {
            let after = |cost: f32| {
                let profiles = self.ruling.iter().map(|ruling| u32::from(*ruling)).chain([*profile]);
                profiles.map(|number| self.scalings[number as usize].after(cost, crest, &weights)[0]).fold(f32::INFINITY, f32::min)
            };
            let costs = core::iter::successors(Some(crest.cost), |cost| Some(after(*cost)));
            costs.skip(1).take_while(|cost| *cost < end).take(MAX_REACH + 1).count()
        };
        highest.iter().map(steps).max().unwrap_or(0)
    }

    /// Nodes that searches settle at most.
    #[must_use]
    pub fn most_settled(&self) -> u64 {
        let (frame, reach) = (&self.canvas.frame, self.reach() as u64);
        let of = |stroke: &Stroke| {
            let nodes = stroke.generators.iter().map(|generator| frame.node(generator.slot as usize));
            let extent = |of: &dyn Fn(Node) -> i64| {
                if stroke.generators.is_empty() {
                    return 0;
                }
                let range = nodes.clone().map(of).fold([i64::MAX, i64::MIN], |[low, high], i| [low.min(i), high.max(i)]);
                (range[1] - range[0] + 1) as u64 + 2 * reach
            };
            (extent(&|node| node.column) * extent(&|node| node.row)).min((frame.columns * frame.rows) as u64)
        };
        self.strokes.iter().map(of).sum()
    }

    fn with_margin(drawing: &Drawing, margin: usize) -> Result<Self, DrawingError> {
        let canvas = Canvas::new(drawing, margin);
        let weights = weights(&canvas, drawing)?;
        let profiles = profiles(&drawing.profiles, [drawing.spacing; 2], drawing.least_scale)?;
        let mut drawn = draw(&canvas, drawing, &profiles, &weights)?;
        let mean = if let Edges::Random { mean, .. } = drawing.edges { mean * drawing.spacing } else { 1.0 };
        let scalings = |sea_level_cost: f64| scalings(&profiles, sea_level_cost, mean, drawing.least_scale);
        let regions = regions(&canvas, drawing, &profiles, &mut drawn)?;
        let rules = |region: &u16| region.checked_sub(1).and_then(|region| regions.profiles[usize::from(region)]).map_or(0, |profile| profile + 1);
        let by_profile: Vec<u16> = regions.slots.iter().map(rules).collect();
        if !drawing.ridges.is_empty() {
            let sea_level_cost = sea_level_cost(drawing, &drawn)?;
            let scalings = scalings(sea_level_cost);
            let terrain = Terrain { weights: &weights, profiles: &scalings, regions: &by_profile };
            ridges::grow(&canvas, drawing, &terrain, sea_level_cost, &mut drawn)?;
        }
        let sea_level_cost = sea_level_cost(drawing, &drawn)?;
        let least = drawn.iter().flat_map(|drawn| drawn.nodes.values()).copied().fold(0.0, f32::min);
        let strokes: Vec<Stroke> = drawn.iter().map(|drawn| drawn.stroke(sea_level_cost as f32, least)).collect();
        if strokes.iter().all(|stroke| stroke.generators.is_empty()) {
            let detail = format!("no node costs less than sea level, {sea_level_cost}: there is nothing to be above it");
            return Err(DrawingError::new("/sea_level", detail));
        }
        let shut = if regions.shut.contains(&true) {
            regions.slots.iter().map(|&region| if region > 0 && regions.shut[usize::from(region) - 1] { region } else { 0 }).collect()
        } else {
            Vec::new()
        };
        let biases = match &drawing.bias {
            Quantity::Number(bias) => Biases::Constant(*bias as f32),
            Quantity::Programme(ramp) => Biases::Slots(canvas.ramp(ramp, "/bias")?.into_iter().map(|bias| bias.clamp(0.0, MAX_BIAS as f32)).collect()),
        };
        let mut ruling: Vec<u16> = regions.profiles.iter().copied().flatten().collect();
        ruling.sort_unstable();
        ruling.dedup();
        let mut plan = Self {
            canvas,
            weights,
            scalings: scalings(sea_level_cost),
            regions: if by_profile.iter().any(|profile| *profile > 0) { by_profile } else { Vec::new() },
            shut,
            strokes,
            biases,
            floors: Vec::new(),
            sea_level_cost: sea_level_cost as f32 - least,
            vertical_scale: drawing.vertical_scale as f32,
            ruling,
            thresholds: [drawing.sea_threshold as f32, drawing.approximate_threshold as f32],
        };
        let shut = plan.shut_regions().len();
        if shut.saturating_mul(plan.canvas.frame.slots()) > MOST_SHUT {
            return Err(DrawingError::new(
                "/strokes",
                format!("{shut} regions that shut others out are too many for so many nodes: {MOST_SHUT} of all together"),
            ));
        }
        for (i, mask) in drawing.masks.iter().enumerate() {
            plan.floors.extend(floor(&plan.canvas, mask, &profiles, mean, drawing.least_scale, &mut plan.scalings, &format!("/masks/{i}"))?);
        }
        Ok(plan)
    }

    /// How many strokes it has.
    #[must_use]
    pub fn strokes(&self) -> usize {
        self.strokes.len()
    }

    pub(super) fn terrain(&self) -> Terrain<'_> {
        Terrain { weights: &self.weights, profiles: &self.scalings, regions: &self.regions }
    }

    /// The generators of all strokes, or of a region's members, in the order of their slots.
    pub(super) fn generators(&self, member: Option<u16>) -> Vec<Generator> {
        let strokes = self.strokes.iter().filter(|stroke| member.is_none_or(|region| stroke.member_of.contains(&region)));
        let mut generators: Vec<Generator> = strokes.flat_map(|stroke| stroke.generators.iter().copied()).collect();
        generators.sort_by_key(|generator| generator.slot);
        generators
    }

    /// Regions that show and shut strokes out.
    pub(super) fn shut_regions(&self) -> BTreeSet<u16> {
        self.shut.iter().copied().filter(|region| *region > 0).collect()
    }

    /// What all searches of strokes compare with: the heights of one search from all generators; in regions that shut strokes out, from those of their members.
    pub(super) fn field(&self) -> Vec<f32> {
        let mut heights = approximate(&self.terrain(), &self.generators(None), self.sea_level_cost);
        for region in self.shut_regions() {
            let own = approximate(&self.terrain(), &self.generators(Some(region)), self.sea_level_cost);
            for (slot, height) in heights.iter_mut().enumerate().filter(|(slot, _)| self.shut[*slot] == region) {
                *height = own[slot];
            }
        }
        heights
    }

    /// The heights of one search from all generators, quickly found: strokes meet in creases.
    #[must_use]
    pub fn preview(&self) -> Heights {
        self.finish(self.field(), Settled::default())
    }

    /// The heights; `done` hears how many strokes are blended. Stopped, which is looked at before every stroke, they are not whole.
    #[must_use]
    pub fn heights(&self, stop: &Stop, done: &(dyn Fn(usize) + Sync)) -> Heights {
        let (heights, settled) = self.blend(stop, done);
        self.finish(heights, settled)
    }

    /// Of every slot the height above sea level, before waters are dug.
    pub(super) fn blend(&self, stop: &Stop, done: &(dyn Fn(usize) + Sync)) -> (Vec<f32>, Settled) {
        Blender::new(self.terrain(), self.blending(), &self.field(), &self.shut).heights(&self.strokes, stop, done)
    }

    pub(super) fn blending(&self) -> Blending<'_> {
        let bias = match &self.biases {
            Biases::Constant(bias) => Bias::Constant(*bias),
            Biases::Slots(biases) => Bias::Slots(biases),
        };
        let [sea_threshold, approximate_threshold] = self.thresholds;
        Blending { sea_level_cost: self.sea_level_cost, sea_threshold, approximate_threshold, bias }
    }

    /// Puts the floors of waters in, and heights in metres from the north.
    fn finish(&self, mut heights: Vec<f32>, settled: Settled) -> Heights {
        for floor in &self.floors {
            self.dig(floor, &mut heights);
        }
        let frame = self.canvas.frame;
        let metres = frame.rows_of_slots().rev().flatten().map(|slot| heights[slot] * self.vertical_scale).collect();
        Heights { first: frame.first, columns: frame.columns, rows: frame.rows, metres, settled }
    }

    /// Searches from the shore of a body of water down to its floor.
    fn dig(&self, floor: &Floor, heights: &mut [f32]) {
        let offsets = self.canvas.frame.offsets();
        let is_shore = |slot: u32| offsets.iter().any(|offset| !floor.water.contains(&((slot as usize).wrapping_add_signed(*offset) as u32)));
        let shore = floor.water.iter().filter(|slot| is_shore(**slot));
        let generators: Vec<Generator> =
            shore.map(|slot| Generator { slot: *slot, profile: floor.profile, crest: Crest::new(0.0, floor.depth, floor.depth) }).collect();
        let terrain = Terrain { regions: &[], ..self.terrain() };
        let depths = approximate(&terrain, &generators, floor.depth);
        for slot in &floor.water {
            heights[*slot as usize] = depths[*slot as usize] - floor.depth;
        }
    }
}

fn weights(canvas: &Canvas, drawing: &Drawing) -> Result<Weights, DrawingError> {
    match &drawing.edges {
        Edges::Random { mean, deviation } => {
            let [mean, deviation] = [mean, deviation].map(|slope| (slope * drawing.spacing) as f32);
            let random = Random { mean, deviation, key: noise::key(drawing.seed, 1) };
            Ok(Weights::random(canvas.frame, &random, drawing.diagonal))
        }
        Edges::Picture { picture, range: [black, white] } => {
            let greys = canvas.greys(picture, "/edges/picture/picture")?;
            let [black, white] = [black, white].map(|slope| (slope * drawing.spacing) as f32);
            let weight = |slot: usize| black + (white - black) * greys[slot];
            Ok(Weights::of_nodes(canvas.frame, |node| canvas.frame.slot(node).map_or(f32::INFINITY, weight), drawing.diagonal))
        }
    }
}

/// The cost of sea level: given, or a multiple of the greatest of a generator.
fn sea_level_cost(drawing: &Drawing, drawn: &[Drawn]) -> Result<f64, DrawingError> {
    let most = drawn.iter().flat_map(|drawn| drawn.nodes.values()).copied().fold(f32::NEG_INFINITY, f32::max);
    if drawn.is_empty() {
        return Err(DrawingError::new("/strokes", "must have a node within the drawing that paths can start from: none has"));
    }
    match drawing.sea_level {
        SeaLevel::Cost(cost) => Ok(cost),
        SeaLevel::Scale(scale) if scale * f64::from(most) > 0.0 => Ok(scale * f64::from(most)),
        SeaLevel::Scale(scale) => Err(DrawingError::new(
            "/sea_level/scale",
            format!("gives sea level the cost {}: the greatest cost of a node is {most}; give a cost outright", scale * f64::from(most)),
        )),
    }
}
