//! Nested networks of valleys cut into a terrain: an erosion that is evaluated at a point.
//!
//! As in E. Gaillard et al., "Dendry: a procedural model for dendritic patterns" (2019), every cell of a lattice has a jittered node, every node is linked to a
//! lower one, and the links carve valleys; finer lattices follow the terrain that the coarser ones have carved. Here a link goes where the drop over the distance
//! squared is greatest, a node that is lowest among its neighbours looks further, and valleys are cut as deep as the network around them is steep.
//!
//! Lengths are measured in pitches (the side of a lattice's cell), so that far from the origin nothing is lost: only the heights of nodes need their positions.

mod carve;
mod network;

use super::{
    Isa,
    draws::{self, Draws, SIDE},
    field::carried,
};
use carve::{Carve, Lower};
use network::Level;

/// Heights of a terrain anywhere.
pub trait Terrain {
    /// Writes the heights at programme coordinates.
    fn heights(&mut self, us: &[f64], vs: &[f64], out: &mut [f32]);
}

/// How a terrain is eroded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Erosion {
    /// What is kept of the difference, 0 … 1.
    pub strength: f64,
    /// Pitch of the coarsest lattice in programme units.
    pub scale: f64,
    /// Lattices, 1 … 5, each finer by √10. A fraction counts for the last.
    pub octaves: f64,
    /// How deep valleys are cut for their slope, 0 … 0.9.
    pub depth: f64,
}

impl Erosion {
    /// The pitch of a lattice and how deep its valleys are cut.
    fn level(&self, number: usize) -> (f64, f64) {
        ((0..number).fold(self.scale, |pitch, _| pitch / RATIO), self.depth * CUTS[number])
    }

    /// What counts of a lattice.
    fn share(&self, number: usize) -> f64 {
        (self.octaves - number as f64).clamp(0.0, 1.0)
    }

    /// How much of a lattice samples carry: all from four samples a pitch on, none below two.
    ///
    /// Of the coarsest gradually: all from six on, none below one and a half, the same share for every part of an octave between.
    fn carried(&self, number: usize, Fading { spacing, gradual }: Fading) -> f64 {
        let pitch = self.level(number).0;
        if spacing <= 0.0 {
            1.0
        } else if number == 0 && gradual {
            (libm::log2(pitch / (1.5 * spacing)) / 2.0).clamp(0.0, 1.0)
        } else {
            carried(pitch, spacing)
        }
    }

    fn count(&self) -> usize {
        (self.octaves.ceil() as usize).clamp(1, MAX_LEVELS)
    }

    /// Those of its lattices that anything is left of in samples.
    pub fn lattices_carried(&self, fading: Fading) -> impl Iterator<Item = Lattice> + '_ {
        self.lattices().enumerate().take_while(move |&(number, _)| self.carried(number, fading) > 0.0).map(|(_, lattice)| lattice)
    }

    /// Whether valleys lie where those of another erosion of the same terrain lie, as far as both have their lattices.
    #[must_use]
    pub fn shares_networks(&self, other: &Self) -> bool {
        self.scale == other.scale && self.depth == other.depth
    }

    /// What its lattices ask of the terrain, from the coarsest on.
    pub fn lattices(&self) -> impl Iterator<Item = Lattice> + '_ {
        (0..self.count()).map(|number| {
            let (candidates, reach) = candidates_and_reach(number);
            Lattice { pitch: self.level(number).0, candidates: candidates as f64, reach: reach as f64 }
        })
    }

    /// How far the eroded terrain can lie below the least height of the terrain, as a part of its range.
    ///
    /// A link is at least 0.3 pitches long, so that the slope of a network is at most the range over that.
    #[must_use]
    pub fn greatest_cut(&self) -> f64 {
        let range = (0..self.count()).fold(1.0, |range, number| range * (1.0 + 2.0 * self.level(number).1 / f64::from(1.0 - 2.0 * JITTER)));
        range - 1.0
    }

    /// A bound on the slopes that are added to those of the terrain, for a range of 1.
    #[must_use]
    pub fn greatest_slope(&self) -> f64 {
        // From a valley's rim to its bed, bent, at the pitch of each lattice.
        (0..self.count()).map(|number| 8.0 / (f64::from(HALF_WIDTH) * self.level(number).0)).sum()
    }
}

/// How valleys fade that samples cannot carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fading {
    /// Distance of the samples in programme units; for 0 no valley fades.
    pub spacing: f64,
    /// Whether the coarsest lattice goes over two octaves of the spacing and not over one. Its valleys count most, and cost most where they are last seen. Such samples
    /// must be means of 4 × 4 parts: one alone could not carry what is left.
    pub gradual: bool,
}

impl Fading {
    /// All valleys are carried.
    pub const NONE: Self = Self { spacing: 0.0, gradual: false };
}

/// A lattice of an erosion, as far as its cost is concerned.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// Programme units from node to node.
    pub pitch: f64,
    /// Heights that each node asks for.
    pub candidates: f64,
    /// Cells that a link may span.
    pub reach: f64,
}

/// Most lattices.
const MAX_LEVELS: usize = 5;

/// Ratio of the pitches of neighbouring lattices.
const RATIO: f64 = 3.162_277_660_168_379_5;

/// Incision of each lattice's valleys.
const CUTS: [f64; MAX_LEVELS] = [0.2, 0.55, 1.0, 0.7, 0.5];

/// Trial positions of a node of the coarsest lattice; it takes the lowest. Others have one.
const CANDIDATES: usize = 4;

/// Cells that a link of the coarsest lattice may span. Others span one.
const REACH: i64 = 4;

/// Of a lattice, the coarsest being number 0.
fn candidates_and_reach(number: usize) -> (usize, i64) {
    if number == 0 { (CANDIDATES, REACH) } else { (1, 1) }
}

/// A node lies within this distance of its cell's middle, along both axes.
const JITTER: f32 = 0.35;

/// A link bows out by at most this.
const BEND: f32 = 0.15;

/// Half the width of a valley. The nearest link that is not looked at is 1 - [`JITTER`] - [`BEND`] away.
const HALF_WIDTH: f32 = 0.5;

/// Square of the radius over which slopes are averaged.
const KERNEL: f32 = 2.25;

/// What valleys lower the terrain by on average, in pitches of their lattice (the row), where the network of a lattice that is as coarse or coarser (the column) has
/// slope 1: the first number, and the second times the depth. The beds lie below the terrain even where nothing is cut; finer networks are steeper. Measured on fBm
/// of 3 and of 8 octaves, which agree to a tenth; `the_mean_cuts` of the tests writes it.
const MEAN_CUTS: [&[[f64; 2]]; MAX_LEVELS] = [
    &[[0.184, 0.068]],
    &[[0.064, 0.334], [0.045, 0.212]],
    &[[0.007, 0.888], [0.010, 0.569], [0.022, 0.435]],
    &[[-0.062, 0.978], [-0.036, 0.627], [-0.016, 0.485], [0.026, 0.294]],
    &[[-0.102, 0.985], [-0.062, 0.633], [-0.038, 0.492], [0.004, 0.306], [0.026, 0.207]],
];

/// Cells a side of the square of corners that [`Networks::mean_slope`] looks at, and how far apart they are in programme units.
const LOOKS: i64 = 6;
const LOOK_EVERY: f64 = 4.0;

/// What stands for valleys that samples cannot carry.
#[derive(Clone, Copy, Debug)]
pub struct Stead {
    /// The mean slope of the coarsest network, a pitch: [`Networks::mean_slope`].
    pub mean_slope: f32,
    /// The least height that they may lower the terrain to.
    pub floor: f32,
    /// What part of the mean lowering counts in each part of a sample, where samples are cut into parts: on average 1.
    pub swings: Option<Draws>,
}

impl Stead {
    /// Where all valleys are carried.
    pub const NONE: Self = Self { mean_slope: 0.0, floor: f32::MIN, swings: None };

    /// The lowering as parts of samples see it: the sixteenths of its distribution, in an order for each `number`.
    #[must_use]
    pub fn swings(number: usize) -> Draws {
        draws::ordered(&SWINGS, FIRST_ORDER + number)
    }
}

/// The sixteenths of what valleys lower a terrain by, over the mean: rounded from networks of two and three lattices on fBm, of depth 0.4 and 0.7.
const SWINGS: Draws = [0.02, 0.10, 0.19, 0.28, 0.37, 0.46, 0.55, 0.64, 0.74, 0.86, 0.99, 1.15, 1.37, 1.68, 2.25, 4.35];

/// The order of the first erosion's swings: one that few programmes have noises enough to reach.
const FIRST_ORDER: usize = 9;

/// The networks of the lattices of an erosion. Nodes once found are kept, in bounded numbers; what is kept changes no value.
pub struct Networks {
    isa: Isa,
    levels: Vec<Level>,
}

impl Networks {
    /// Networks with nothing found yet. Every erosion that [shares](Erosion::shares_networks) them and has no more lattices may use them.
    #[must_use]
    pub fn new(isa: Isa, erosion: &Erosion, key: u64) -> Self {
        let level = |number| {
            let (pitch, cut) = erosion.level(number);
            Level::new(key, number, pitch, cut as f32)
        };
        Self { isa, levels: (0..erosion.count()).map(level).collect() }
    }

    /// The mean slope of the coarsest network, a pitch, over 36 places of 24 × 24 programme units around the origin.
    pub fn mean_slope(&mut self, terrain: &mut impl Terrain) -> f32 {
        let level = &mut self.levels[0];
        let pitch = level.pitch;
        let at = |look: i64| ((look as f64 - (LOOKS - 1) as f64 / 2.0) * LOOK_EVERY / pitch).round() as i64;
        let mut sum = 0.0;
        for look in 0..LOOKS * LOOKS {
            let around = level.around([at(look % LOOKS), at(look / LOOKS)], |us, vs, out| terrain.heights(us, vs, out));
            sum += around.nodes.iter().map(|&[_, _, slope]| f64::from(slope)).sum::<f64>() / 16.0;
        }
        (sum / (LOOKS * LOOKS) as f64) as f32
    }
}

/// How an erosion's valleys are carved into samples of some spacing.
pub struct Valleys {
    strength: f32,
    /// How far each level is carved for the samples, and what its slopes say of the levels that are not.
    parts: Vec<[f32; 2]>,
    /// What all are lowered by in place of levels that nothing is left of.
    lowering: f32,
    floor: f32,
    swings: Option<Draws>,
    /// Heights as they were, and what they are lowered by for levels that are left out.
    scratch: [Vec<f32>; 2],
}

impl Valleys {
    /// Valleys for samples that lattices fade for.
    ///
    /// What is left out still lowers the land, by its mean: the slopes of the finest network that is kept say where; once there is none, those of `stead`.
    #[must_use]
    pub fn new(erosion: &Erosion, fading: Fading, stead: &Stead) -> Self {
        let carried = |number| erosion.carried(number, fading);
        let kept = (0..erosion.count()).take_while(|&number| carried(number) > 0.0).count();
        let mut parts: Vec<[f32; 2]> = (0..kept).map(|number| [carried(number) as f32 * erosion.share(number) as f32, 0.0]).collect();
        // What is left out of a level, where the network of another has slope 1.
        let left_out = |number: usize, by: usize| {
            let [bed, cut] = MEAN_CUTS[number][by];
            ((bed + cut * erosion.depth) * (1.0 - carried(number)) * erosion.share(number) * erosion.level(number).0 / erosion.level(by).0) as f32
        };
        // The finest kept level speaks for those that are gone; as it fades, the one above it does, and in the end the mean.
        let finest = kept.saturating_sub(1);
        let part = if kept > 0 { carried(finest) as f32 } else { 0.0 };
        let mut lowering = 0.0;
        for number in 0..erosion.count() {
            if number < finest {
                parts[number][1] += left_out(number, number);
                continue;
            }
            if kept > 0 {
                parts[finest][1] += part * left_out(number, finest);
            }
            match finest {
                0 => lowering += (1.0 - part) * left_out(number, 0) * stead.mean_slope,
                _ => parts[finest - 1][1] += (1.0 - part) * left_out(number, finest - 1),
            }
        }
        Self { strength: erosion.strength as f32, parts, lowering, floor: stead.floor, swings: stead.swings, scratch: [Vec::new(), Vec::new()] }
    }

    /// Whether samples need the mean slope of the coarsest network.
    #[must_use]
    pub fn needs_mean(erosion: &Erosion, fading: Fading) -> bool {
        erosion.carried(0, fading) < 1.0
    }

    /// Turns the heights of the terrain at programme coordinates into eroded ones. `terrain` gives the terrain as it is, unfiltered: the network must not change with
    /// the samples. Where samples are cut into parts, the first height is that of the part of that number, and the others follow it to the east.
    pub fn carve(&mut self, networks: &mut Networks, terrain: &mut impl Terrain, us: &[f64], vs: &[f64], heights: &mut [f32], part: usize) {
        let [mut before, mut lowering] = std::mem::take(&mut self.scratch);
        before.clear();
        before.extend_from_slice(heights);
        lowering.clear();
        lowering.resize(heights.len(), self.lowering);
        for (number, &parts) in self.parts.iter().enumerate() {
            carve(networks.isa, &mut networks.levels[..=number], terrain, us, vs, [heights, &mut lowering], parts);
        }
        // A part alone may be the last.
        let swings = self.swings.map_or([1.0; SIDE], |swings| core::array::from_fn(|i| swings[(part + i) % swings.len()]));
        networks.isa.run(Lower { before: &before, lowering: &lowering, strength: self.strength, swings, floor: self.floor, heights });
        self.scratch = [before, lowering];
    }
}

/// Carves the last of the levels into heights that have the others already, by how much of it; and adds to the lowering what follows from its slopes for levels that are
/// left out.
fn carve(isa: Isa, levels: &mut [Level], terrain: &mut impl Terrain, us: &[f64], vs: &[f64], [heights, lowering]: [&mut [f32]; 2], [part, faded]: [f32; 2]) {
    let Some((level, coarser)) = levels.split_last_mut() else { return };
    let mut locals = [[0.0_f32; CHUNK]; 2];
    let mut start = 0;
    while start < us.len() {
        let (i, x) = Level::locate(level.pitch, us[start]);
        let (j, y) = Level::locate(level.pitch, vs[start]);
        let mut count = 0;
        (locals[0][0], locals[1][0]) = (x, y);
        // Neighbouring samples mostly share their corner.
        loop {
            count += 1;
            if count == CHUNK || start + count == us.len() {
                break;
            }
            let (next_i, x) = Level::locate(level.pitch, us[start + count]);
            let (next_j, y) = Level::locate(level.pitch, vs[start + count]);
            if [next_i, next_j] != [i, j] {
                break;
            }
            (locals[0][count], locals[1][count]) = (x, y);
        }
        let cut = level.cut;
        let run = Carve {
            around: level.around([i, j], |us, vs, out| self::heights(isa, coarser, terrain, us, vs, out)),
            xs: &locals[0][..count],
            ys: &locals[1][..count],
            heights: &mut heights[start..start + count],
            lowering: &mut lowering[start..start + count],
            cut,
            part,
            faded,
        };
        isa.run(run);
        start += count;
    }
}

/// The heights of the terrain with all of these levels carved.
fn heights(isa: Isa, levels: &mut [Level], terrain: &mut impl Terrain, us: &[f64], vs: &[f64], out: &mut [f32]) {
    terrain.heights(us, vs, out);
    let mut lowering = vec![0.0; out.len()];
    for number in 0..levels.len() {
        carve(isa, &mut levels[..=number], terrain, us, vs, [out, &mut lowering], [1.0, 0.0]);
    }
}

/// Samples that are carved at a time.
const CHUNK: usize = 256;

#[cfg(test)]
mod tests;
