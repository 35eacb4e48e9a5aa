//! Nested networks of valleys cut into a terrain: an erosion that is evaluated at a point.
//!
//! As in E. Gaillard et al., "Dendry: a procedural model for dendritic patterns" (2019), every cell of a lattice has a jittered node, every node is linked to a
//! lower one, and the links carve valleys; finer lattices follow the terrain that the coarser ones have carved. Here a link goes where the drop over the distance
//! squared is greatest, a node that is lowest among its neighbours looks further, and valleys are cut as deep as the network around them is steep.
//!
//! Lengths are measured in pitches (the side of a lattice's cell), so that far from the origin nothing is lost: only the heights of nodes need their positions.

use super::{
    Isa, Kernel, Lanes,
    draws::{self, Draws, SIDE},
    field::carried,
    hash,
};
use std::collections::BTreeMap;

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

    /// How much of a lattice samples `spacing` programme units apart carry: all from four samples a pitch on, none below two.
    fn carried(&self, number: usize, spacing: f64) -> f64 {
        carried(self.level(number).0, spacing)
    }

    fn count(&self) -> usize {
        (self.octaves.ceil() as usize).clamp(1, MAX_LEVELS)
    }

    /// The pitch of every lattice in programme units, and how many heights each of its nodes asks for.
    pub fn pitches(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        (0..self.count()).map(|number| (self.level(number).0, if number == 0 { CANDIDATES as f64 } else { 1.0 }))
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

/// Cells a side of the square of corners that [`Valleys::mean_slope`] looks at, and how far apart they are in programme units.
const LOOKS: i64 = 6;
const LOOK_EVERY: f64 = 4.0;

/// What stands for valleys that samples cannot carry.
#[derive(Clone, Copy, Debug)]
pub struct Stead {
    /// The mean slope of the coarsest network, a pitch: [`Valleys::mean_slope`].
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

/// A terrain with its valleys. Nodes once found are kept, in bounded numbers; what is kept changes no value.
pub struct Valleys {
    isa: Isa,
    strength: f32,
    levels: Vec<Level>,
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
    /// Valleys for samples `spacing` programme units apart: lattices whose pitch is below four spacings fade, to be gone at two. 0 keeps them all.
    ///
    /// What is left out still lowers the land, by its mean: the slopes of the finest network that is kept say where; once there is none, those of `stead`.
    #[must_use]
    pub fn new(isa: Isa, erosion: &Erosion, key: u64, spacing: f64, stead: &Stead) -> Self {
        let carried = |number| if spacing > 0.0 { erosion.carried(number, spacing) } else { 1.0 };
        let kept = (0..erosion.count()).take_while(|&number| carried(number) > 0.0).count();
        let (mut levels, mut parts) = (Vec::<Level>::new(), Vec::new());
        for number in 0..kept {
            let (pitch, cut) = erosion.level(number);
            levels.push(Level::new(key, number, pitch, cut as f32, erosion.share(number) as f32));
            parts.push([carried(number) as f32, 0.0]);
        }
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
        Self { isa, strength: erosion.strength as f32, levels, parts, lowering, floor: stead.floor, swings: stead.swings, scratch: [Vec::new(), Vec::new()] }
    }

    /// The mean slope of the coarsest network, a pitch, over 36 places of 24 × 24 programme units around the origin.
    pub fn mean_slope(isa: Isa, erosion: &Erosion, key: u64, terrain: &mut impl Terrain) -> f32 {
        let (pitch, cut) = erosion.level(0);
        let mut level = Level::new(key, 0, pitch, cut as f32, 1.0);
        let at = |look: i64| ((look as f64 - (LOOKS - 1) as f64 / 2.0) * LOOK_EVERY / pitch).round() as i64;
        let mut sum = 0.0;
        for look in 0..LOOKS * LOOKS {
            let around = find_around(isa, &mut level, &mut [], terrain, [at(look % LOOKS), at(look / LOOKS)]);
            sum += around.nodes.iter().map(|&[_, _, slope]| f64::from(slope)).sum::<f64>() / 16.0;
        }
        (sum / (LOOKS * LOOKS) as f64) as f32
    }

    /// Whether samples `spacing` programme units apart need the mean slope of the coarsest network.
    #[must_use]
    pub fn needs_mean(erosion: &Erosion, spacing: f64) -> bool {
        spacing > 0.0 && erosion.carried(0, spacing) < 1.0
    }

    /// Turns the heights of the terrain at programme coordinates into eroded ones. `terrain` gives the terrain as it is, unfiltered: the network must not change with
    /// the samples. Where samples are cut into parts, the first height is that of the part of that number, and the others follow it to the east.
    pub fn carve(&mut self, terrain: &mut impl Terrain, us: &[f64], vs: &[f64], heights: &mut [f32], part: usize) {
        let [mut before, mut lowering] = std::mem::take(&mut self.scratch);
        before.clear();
        before.extend_from_slice(heights);
        lowering.clear();
        lowering.resize(heights.len(), self.lowering);
        for number in 0..self.levels.len() {
            carve(self.isa, &mut self.levels[..=number], terrain, us, vs, [heights, &mut lowering], self.parts[number]);
        }
        for (i, (height, (&before, &lowering))) in heights.iter_mut().zip(before.iter().zip(&lowering)).enumerate() {
            let carved = before + self.strength * (*height - before);
            *height = if lowering == 0.0 {
                carved
            } else {
                let swing = self.swings.map_or(1.0, |swings| swings[part + i % SIDE]);
                let lowered = carved - self.strength * swing * lowering;
                // Never up, where the floor is above what is carved by a rounding.
                let floor = if self.floor < carved { self.floor } else { carved };
                if lowered < floor { floor } else { lowered }
            };
        }
        self.scratch = [before, lowering];
    }
}

/// The lowest place of a cell: relative to the cell's south-west corner, and its height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Site {
    x: f32,
    y: f32,
    z: f32,
}

/// A valley from a node to a lower one, relative to the corner of the cells around it.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: Site,
    to: [f32; 3],
    inverse_square: f32,
    bend: f32,
}

/// What the samples around a corner of cells look at.
struct Around {
    /// Place and slope of the 4 × 4 nodes.
    nodes: [[f32; 3]; 16],
    links: Vec<Link>,
}

/// Cells a side of what is found at a time.
const PAGE: i64 = 8;

/// Most pages and corners that a level keeps.
const KEPT: usize = 4_096;

struct Level {
    pitch: f64,
    cut: f32,
    /// What counts of the level where it is carved whole.
    part: f32,
    reach: i64,
    candidates: usize,
    seeds: [u32; CANDIDATES + 1],
    pages: BTreeMap<[i64; 2], Vec<Site>>,
    corners: BTreeMap<[i64; 2], Around>,
}

impl Level {
    fn new(key: u64, number: usize, pitch: f64, cut: f32, part: f32) -> Self {
        let (candidates, reach) = if number == 0 { (CANDIDATES, REACH) } else { (1, 1) };
        let seeds = core::array::from_fn(|channel| hash::key(hash::key(key, number as u64), channel as u64) as u32);
        Self { pitch, cut, part, reach, candidates, seeds, pages: BTreeMap::new(), corners: BTreeMap::new() }
    }

    /// A place within a cell, from the middle half and a little more.
    fn place(&self, [i, j]: [i64; 2], candidate: usize) -> [f32; 2] {
        let bits = hash::corner(hash::column_key(i), hash::row_key(j, self.seeds[candidate]));
        let at = |bits: u32| 0.5 + JITTER * ((bits as f32 + 0.5) / 32_768.0 - 1.0);
        [at(bits & 0xffff), at(bits >> 16)]
    }

    /// In [-1, 1].
    fn turn(&self, [i, j]: [i64; 2]) -> f32 {
        let bits = hash::corner(hash::column_key(i), hash::row_key(j, self.seeds[CANDIDATES]));
        ((bits >> 16) as f32 + 0.5) / 32_768.0 - 1.0
    }

    /// The corner of cells nearest to a coordinate, and the coordinate relative to it, in pitches.
    #[inline(always)]
    fn locate(pitch: f64, coordinate: f64) -> (i64, f32) {
        let at = coordinate / pitch;
        // Beyond 2^52 cells cannot be told apart; the clamp keeps their neighbours' numbers from overflowing.
        let corner = (at + 0.5).floor().clamp(-4.5e15, 4.5e15);
        (corner as i64, (at - corner).clamp(-0.5, 0.5) as f32)
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
        if level.corners.len() > KEPT {
            level.corners.clear();
        }
        if !level.corners.contains_key(&[i, j]) {
            let around = find_around(isa, level, coarser, terrain, [i, j]);
            level.corners.insert([i, j], around);
        }
        let (cut, part) = (level.cut, part * level.part);
        let run = Carve {
            around: &level.corners[&[i, j]],
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

/// The sites of a page of cells.
fn find_page(isa: Isa, level: &Level, coarser: &mut [Level], terrain: &mut impl Terrain, page: [i64; 2]) -> Vec<Site> {
    let mut sites = Vec::with_capacity((PAGE * PAGE) as usize);
    let (mut us, mut vs, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for cell in 0..PAGE * PAGE {
        let cell = [page[0] * PAGE + cell % PAGE, page[1] * PAGE + cell / PAGE];
        for candidate in 0..level.candidates {
            let [x, y] = level.place(cell, candidate);
            us.push((cell[0] as f64 + f64::from(x)) * level.pitch);
            vs.push((cell[1] as f64 + f64::from(y)) * level.pitch);
            places.push([x, y]);
        }
    }
    let mut zs = vec![0.0; us.len()];
    heights(isa, coarser, terrain, &us, &vs, &mut zs);
    for (places, zs) in places.chunks(level.candidates).zip(zs.chunks(level.candidates)) {
        let all = places.iter().zip(zs).map(|(&[x, y], &z)| Site { x, y, z });
        // Of equals the first.
        sites.extend(all.reduce(|lowest, other| if other.z < lowest.z { other } else { lowest }));
    }
    sites
}

/// Everything that samples nearest to a corner of cells look at.
fn find_around(isa: Isa, level: &mut Level, coarser: &mut [Level], terrain: &mut impl Terrain, [i, j]: [i64; 2]) -> Around {
    // Links from up to `reach` - 1 rings around the 4 × 4 cells, and what those may lead to.
    let half = 1 + 2 * level.reach;
    let side = 2 * half;
    let mut sites = vec![Site::default(); (side * side) as usize];
    for (number, site) in sites.iter_mut().enumerate() {
        let cell = [i - half + number as i64 % side, j - half + number as i64 / side];
        let page = cell.map(|c| c.div_euclid(PAGE));
        if !level.pages.contains_key(&page) {
            if level.pages.len() > KEPT {
                level.pages.clear();
            }
            let found = find_page(isa, level, coarser, terrain, page);
            level.pages.insert(page, found);
        }
        let Site { x, y, z } = level.pages[&page][(cell[1].rem_euclid(PAGE) * PAGE + cell[0].rem_euclid(PAGE)) as usize];
        *site = Site { x: (cell[0] - i) as f32 + x, y: (cell[1] - j) as f32 + y, z };
    }
    let at = |a: i64, b: i64| sites[((b + half) * side + a + half) as usize];
    let (mut nodes, mut links) = ([[0.0; 3]; 16], Vec::new());
    for b in -1 - level.reach..=level.reach {
        for a in -1 - level.reach..=level.reach {
            let site = at(a, b);
            let found = find_link(&at, level.reach, [a, b]);
            let rings = [-2 - a, a - 1, -2 - b, b - 1].into_iter().max().unwrap_or(0).max(0);
            let mut slope = 0.0;
            if let Some((span, target)) = found {
                let to = [target.x - site.x, target.y - site.y, target.z - site.z];
                let square = to[0] * to[0] + to[1] * to[1];
                let length = square.sqrt();
                slope = -to[2] / length;
                if span > rings {
                    let bend = 4.0 * BEND * level.turn([i + a, j + b]) / length;
                    links.push(Link { from: site, to, inverse_square: 1.0 / square, bend });
                }
            }
            if rings == 0 {
                nodes[((b + 2) * 4 + a + 2) as usize] = [site.x, site.y, slope];
            }
        }
    }
    links.retain(is_near);
    Around { nodes, links }
}

/// Whether a valley can reach a sample within half a pitch of the corner: by the box around its link.
fn is_near(link: &Link) -> bool {
    let away = |from: f32, to: f32| {
        let (low, high) = (from.min(from + to) - BEND, from.max(from + to) + BEND);
        low > 0.5 + HALF_WIDTH || high < -0.5 - HALF_WIDTH
    };
    !away(link.from.x, link.to[0]) && !away(link.from.y, link.to[1])
}

/// Where a node's valley leads and how many cells it spans: the neighbour with the greatest drop over distance squared, else the nearest lower node of the first ring
/// that has one.
fn find_link(at: &impl Fn(i64, i64) -> Site, reach: i64, [a, b]: [i64; 2]) -> Option<(i64, Site)> {
    let from = at(a, b);
    for span in 1..=reach {
        let (mut best, mut found) = (0.0, None);
        for d in -span..=span {
            for c in -span..=span {
                let to = at(a + c, b + d);
                let square = (to.x - from.x) * (to.x - from.x) + (to.y - from.y) * (to.y - from.y);
                let drop = from.z - to.z;
                let score = if drop > 0.0 { if span == 1 { drop / square } else { 1.0 / square } } else { 0.0 };
                if score > best {
                    (best, found) = (score, Some((span, to)));
                }
            }
        }
        if found.is_some() {
            return found;
        }
    }
    None
}

/// Samples that are carved at a time.
const CHUNK: usize = 256;

/// Carves samples around one corner.
struct Carve<'a> {
    around: &'a Around,
    xs: &'a [f32],
    ys: &'a [f32],
    heights: &'a mut [f32],
    lowering: &'a mut [f32],
    cut: f32,
    part: f32,
    faded: f32,
}

/// Samples are carved in groups of these, the last filled up: loops of whole vectors.
const GROUP: usize = 16;

impl Kernel for Carve<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) {
        let Self { around, xs, ys, heights, lowering, cut, part, faded } = self;
        let results = heights.chunks_mut(GROUP).zip(lowering.chunks_mut(GROUP));
        for ((xs, ys), (heights, lowering)) in xs.chunks(GROUP).zip(ys.chunks(GROUP)).zip(results) {
            let (mut x, mut y, mut height) = ([xs[0]; GROUP], [ys[0]; GROUP], [heights[0]; GROUP]);
            x[..xs.len()].copy_from_slice(xs);
            y[..ys.len()].copy_from_slice(ys);
            height[..heights.len()].copy_from_slice(heights);
            let slope = around.slopes(&x, &y);
            let lowest = around.lowest(&x, &y, &height, &slope.map(|slope| cut * slope));
            for i in 0..GROUP {
                height[i] += part * (lowest[i] - height[i]);
            }
            for (lowering, slope) in lowering.iter_mut().zip(slope) {
                *lowering += faded * slope;
            }
            let count = heights.len();
            heights.copy_from_slice(&height[..count]);
        }
    }
}

impl Around {
    /// How steep the network is around samples, a pitch.
    #[inline(always)]
    fn slopes(&self, x: &[f32; GROUP], y: &[f32; GROUP]) -> [f32; GROUP] {
        let (mut sum, mut weights) = ([0.0; GROUP], [0.0; GROUP]);
        for &[node_x, node_y, slope] in &self.nodes {
            for i in 0..GROUP {
                let (dx, dy) = (x[i] - node_x, y[i] - node_y);
                let near = at_least_0(1.0 - (dx * dx + dy * dy) * (1.0 / KERNEL));
                let weight = near * near;
                sum[i] += weight * slope;
                weights[i] += weight;
            }
        }
        core::array::from_fn(|i| sum[i] / weights[i])
    }

    /// The lowest that any valley leaves of samples; their beds lie `incision` below their links.
    #[inline(always)]
    fn lowest(&self, x: &[f32; GROUP], y: &[f32; GROUP], height: &[f32; GROUP], incision: &[f32; GROUP]) -> [f32; GROUP] {
        let mut lowest = *height;
        for link in &self.links {
            let Link { from, to: [ex, ey, ez], inverse_square, bend } = *link;
            for i in 0..GROUP {
                let (px, py) = (x[i] - from.x, y[i] - from.y);
                let along = at_least_0((px * ex + py * ey) * inverse_square);
                let t = if along > 1.0 { 1.0 } else { along };
                let bow = bend * (t * (1.0 - t));
                let (dx, dy) = ((px - t * ex) + bow * ey, (py - t * ey) - bow * ex);
                let weight = at_least_0(1.0 - (dx * dx + dy * dy).sqrt() * (1.0 / HALF_WIDTH));
                let bed = (from.z + t * ez) - incision[i];
                let carved = height[i] - weight * at_least_0(height[i] - bed);
                lowest[i] = if carved < lowest[i] { carved } else { lowest[i] };
            }
        }
        lowest
    }
}

#[inline(always)]
fn at_least_0(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::{Basis, Field, FieldShape};

    struct Flat;

    impl Terrain for Flat {
        fn heights(&mut self, _: &[f64], _: &[f64], out: &mut [f32]) {
            out.fill(0.25);
        }
    }

    /// Where a link leads, and how it turns.
    type Target = (Site, f32);

    struct Ground(Field);

    impl Terrain for Ground {
        fn heights(&mut self, us: &[f64], vs: &[f64], out: &mut [f32]) {
            self.0.points(Isa::Baseline, us, vs, out);
        }
    }

    fn ground() -> Ground {
        Ground(Field::exact(FieldShape::Fbm { h: 1.0, lacunarity: 2.0, octaves: 5.0 }, Basis::OPerlin, 7))
    }

    const EROSION: Erosion = Erosion { strength: 1.0, scale: 0.4, octaves: 3.0, depth: 0.7 };

    fn eroded(valleys: &mut Valleys, us: &[f64], vs: &[f64]) -> Vec<f32> {
        let mut ground = ground();
        let mut heights = vec![0.0; us.len()];
        ground.heights(us, vs, &mut heights);
        valleys.carve(&mut ground, us, vs, &mut heights, 0);
        heights
    }

    /// A grid of places of some side and spacing around a place.
    fn places(around: f64, spacing: f64) -> (Vec<f64>, Vec<f64>) {
        let at = |i: i32| around + f64::from(i) * spacing;
        ((0..900).map(|i| at(i % 30)).collect(), (0..900).map(|i| at(i / 30)).collect())
    }

    /// Whatever was asked before, in whatever order and on whatever instruction set.
    #[test]
    fn a_place_has_one_height() {
        for (around, spacing) in [(0.3, 0.004), (-5.0, 0.31), (3e7, 0.02), (1e12, 1e9)] {
            let (us, vs) = places(around, spacing);
            let all = eroded(&mut Valleys::new(Isa::Baseline, &EROSION, 5, 0.0, &Stead::NONE), &us, &vs);
            for isa in Isa::ALL {
                let mut valleys = Valleys::new(isa, &EROSION, 5, 0.0, &Stead::NONE);
                let (back_us, back_vs): (Vec<f64>, Vec<f64>) = (us.iter().rev().copied().collect(), vs.iter().rev().copied().collect());
                let back = eroded(&mut valleys, &back_us, &back_vs);
                assert!(back.iter().rev().zip(&all).all(|(a, b)| a.to_bits() == b.to_bits()), "{isa:?} {around} {spacing}");
                for i in (0..us.len()).step_by(97) {
                    let alone = eroded(&mut valleys, &us[i..=i], &vs[i..=i]);
                    assert_eq!(alone[0].to_bits(), all[i].to_bits(), "{isa:?} at {} {}", us[i], vs[i]);
                }
            }
        }
    }

    /// The definition written out: every link of every cell near enough, none left out for being far.
    #[test]
    fn valleys_are_those_of_every_link_around() {
        let (us, vs) = places(0.7, 0.021);
        let erosion = Erosion { octaves: 1.0, ..EROSION };
        let got = eroded(&mut Valleys::new(Isa::active(), &erosion, 5, 0.0, &Stead::NONE), &us, &vs);
        let (pitch, cut) = erosion.level(0);
        let level = Level::new(5, 0, pitch, cut as f32, 1.0);
        let mut ground = ground();
        let site = |i: i64, j: i64, ground: &mut Ground| {
            let all = (0..CANDIDATES).map(|candidate| {
                let [x, y] = level.place([i, j], candidate);
                let mut z = [0.0];
                ground.heights(&[(i as f64 + f64::from(x)) * pitch], &[(j as f64 + f64::from(y)) * pitch], &mut z);
                Site { x: i as f32 + x, y: j as f32 + y, z: z[0] }
            });
            all.reduce(|lowest, other| if other.z < lowest.z { other } else { lowest }).expect("four")
        };
        let sites: BTreeMap<[i64; 2], Site> = (-16..24).flat_map(|j| (-16..24).map(move |i| [i, j])).map(|[i, j]| ([i, j], site(i, j, &mut ground))).collect();
        let links: Vec<(Site, [f32; 2], Option<Target>)> = (-11..19)
            .flat_map(|j| (-11..19).map(move |i| [i, j]))
            .map(|[i, j]| {
                let found = find_link(&|a, b| sites[&[a, b]], REACH, [i, j]).map(|(_, to)| (to, level.turn([i, j])));
                (sites[&[i, j]], [i as f32 + 0.5, j as f32 + 0.5], found)
            })
            .collect();
        for ((&u, &v), got) in us.iter().zip(&vs).zip(got) {
            let (x, y) = ((u / pitch) as f32, (v / pitch) as f32);
            let (mut sum, mut weights, mut height) = (0.0, 0.0, [0.0]);
            ground.heights(&[u], &[v], &mut height);
            for (site, [cell_x, cell_y], found) in &links {
                // The 4 × 4 cells around the nearest corner.
                if (cell_x - (x + 0.5).floor()).abs() < 2.0 && (cell_y - (y + 0.5).floor()).abs() < 2.0 {
                    let square = |dx: f32, dy: f32| dx * dx + dy * dy;
                    let near = (1.0 - square(x - site.x, y - site.y) / KERNEL).max(0.0);
                    let slope = found.map_or(0.0, |(to, _)| (site.z - to.z) / square(to.x - site.x, to.y - site.y).sqrt());
                    (sum, weights) = (sum + near * near * slope, weights + near * near);
                }
            }
            let mut lowest = height[0];
            for (site, _, found) in &links {
                let Some((to, turn)) = found else { continue };
                let (ex, ey, ez) = (to.x - site.x, to.y - site.y, to.z - site.z);
                let square = ex * ex + ey * ey;
                let t = (((x - site.x) * ex + (y - site.y) * ey) / square).clamp(0.0, 1.0);
                let bow = 4.0 * BEND * turn / square.sqrt() * t * (1.0 - t);
                let (dx, dy) = (x - site.x - t * ex + bow * ey, y - site.y - t * ey - bow * ex);
                let weight = (1.0 - (dx * dx + dy * dy).sqrt() / HALF_WIDTH).max(0.0);
                lowest = lowest.min(height[0] - weight * (height[0] - (site.z + t * ez - cut as f32 * (sum / weights))).max(0.0));
            }
            assert!((lowest - got).abs() < 2e-5, "{u} {v}: {got} is not {lowest}");
        }
    }

    /// Valleys lower the land; nowhere more than the range allows.
    #[test]
    fn erosion_only_lowers_and_flat_land_stays() {
        let (us, vs) = places(0.0, 0.05);
        let mut before = vec![0.0; us.len()];
        ground().heights(&us, &vs, &mut before);
        let after = eroded(&mut Valleys::new(Isa::active(), &EROSION, 5, 0.0, &Stead::NONE), &us, &vs);
        let [low, high] = ground().0.range();
        assert!(before.iter().zip(&after).all(|(before, after)| after <= before));
        assert!(after.iter().all(|&height| height >= low - (high - low) * EROSION.greatest_cut() as f32));
        let mut flat = vec![0.25; us.len()];
        Valleys::new(Isa::active(), &EROSION, 5, 0.0, &Stead::NONE).carve(&mut Flat, &us, &vs, &mut flat, 0);
        assert!(flat.iter().all(|&height| height == 0.25));
    }

    /// The mean over an area moves by less than a hundredth of the amplitude from level to level.
    #[test]
    fn the_mean_stays_as_lattices_fade() {
        let side = 160;
        let at = |i: usize| i as f64 * 0.05;
        let (us, vs): (Vec<f64>, Vec<f64>) = (0..side * side).map(|i| (at(i % side), at(i / side))).unzip();
        let mean_slope = Valleys::mean_slope(Isa::active(), &EROSION, 5, &mut ground());
        let mean = |spacing: f64| {
            let heights = eroded(&mut Valleys::new(Isa::active(), &EROSION, 5, spacing, &Stead { mean_slope, ..Stead::NONE }), &us, &vs);
            heights.iter().map(|&h| f64::from(h)).sum::<f64>() / heights.len() as f64
        };
        let [low, high] = ground().0.range();
        let amplitude = f64::from(high - low) / 2.0;
        let means: Vec<f64> = [0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32].map(mean).to_vec();
        assert!(means.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.008 * amplitude), "{means:?}");
    }

    /// What stands for valleys swings around its mean, never lower than the floor and never up.
    #[test]
    fn what_stands_for_valleys_swings_and_keeps_its_floor() {
        let swings = Stead::swings(0);
        assert!((swings.iter().sum::<f32>() / 16.0 - 1.0).abs() < 1e-3);
        let lowered = |floor: f32| {
            let stead = Stead { mean_slope: 0.5, floor, swings: Some(swings) };
            let (us, vs, mut heights) = ([0.0; 4], [0.0; 4], [1.0; 4]);
            Valleys::new(Isa::active(), &EROSION, 5, 10.0, &stead).carve(&mut Flat, &us, &vs, &mut heights, 4);
            heights
        };
        let free = lowered(f32::MIN);
        let ratio = (1.0 - free[1]) / (1.0 - free[2]);
        assert!(free.iter().all(|&height| height < 1.0) && (ratio * swings[6] / swings[5] - 1.0).abs() < 1e-3, "{free:?}");
        assert!(lowered(0.99).iter().zip(free).all(|(&height, free)| height == free.max(0.99)));
        assert_eq!(lowered(2.0), [1.0; 4]);
    }

    /// Writes [`MEAN_CUTS`]: `cargo test --release --lib the_mean_cuts -- --ignored --nocapture`.
    #[test]
    #[ignore = "writes the table"]
    #[expect(clippy::print_stdout, reason = "writes the table")]
    fn the_mean_cuts() {
        for (h, octaves) in [(1.0, 3.0), (1.0, 8.0), (0.9, 5.0)] {
            let mut table = [[[0.0_f64; 2]; MAX_LEVELS]; MAX_LEVELS];
            for seed in 0..4 {
                let mut ground = Ground(Field::exact(FieldShape::Fbm { h, lacunarity: 2.05, octaves }, Basis::OPerlin, seed));
                for (which, depth) in [0.3, 0.8].into_iter().enumerate() {
                    let erosion = Erosion { strength: 1.0, scale: 0.4, octaves: 5.0, depth };
                    let found = mean_cuts(&erosion, seed, &mut ground);
                    (0..MAX_LEVELS).for_each(|k| (0..=k).for_each(|by| table[k][by][which] += found[k][by] / 4.0));
                }
            }
            println!("H {h}, {octaves} octaves");
            for (k, row) in table.iter().enumerate() {
                let fit = |&[low, high]: &[f64; 2]| {
                    let rise = (high - low) / 0.5;
                    format!("[{:.3}, {:.3}]", low - 0.3 * rise, rise)
                };
                println!("    {}", row[..=k].iter().map(fit).collect::<Vec<_>>().join(", "));
            }
        }
    }

    /// What each lattice lowers the terrain by, in its pitches, where the network of each coarser one has slope 1.
    fn mean_cuts(erosion: &Erosion, key: u64, ground: &mut Ground) -> [[f64; MAX_LEVELS]; MAX_LEVELS] {
        let side = 96;
        let at = |i: usize| i as f64 * 0.083_7 - 4.0;
        let (us, vs): (Vec<f64>, Vec<f64>) = (0..side * side).map(|i| (at(i % side), at(i / side))).unzip();
        let mean = |heights: &[f32]| heights.iter().map(|&h| f64::from(h)).sum::<f64>() / heights.len() as f64;
        let mut heights = vec![0.0; us.len()];
        ground.heights(&us, &vs, &mut heights);
        let mut valleys = Valleys::new(Isa::active(), erosion, key, 0.0, &Stead::NONE);
        let (mut cuts, mut slopes) = ([0.0; MAX_LEVELS], [0.0; MAX_LEVELS]);
        for number in 0..MAX_LEVELS {
            let (before, pitch) = (heights.clone(), valleys.levels[number].pitch);
            let mut slope = vec![0.0; us.len()];
            carve(Isa::active(), &mut valleys.levels[..=number], ground, &us, &vs, [&mut heights, &mut slope], [1.0, 1.0]);
            (cuts[number], slopes[number]) = ((mean(&before) - mean(&heights)) / pitch, mean(&slope) / pitch);
        }
        core::array::from_fn(|k| core::array::from_fn(|by| cuts[k] / slopes[by]))
    }
}
