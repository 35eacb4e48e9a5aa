//! Statistics of ground block by block, so that a change costs its blocks: all sums go over a block's cells in order, then over the blocks in order, however they came to be known.

use super::pattern::HeightGrid;
use crate::synthesis::{
    analysis::{Profile, degrees, gradients},
    edges::{self, EdgePoint, Linking, link},
    grid::SampleGrid,
    statistics::Statistics,
};

/// Genes of a block a side.
pub(super) const BLOCK: usize = 4;

/// Rows of blocks that are looked at together.
const STRIP: usize = 4;

/// Sums of the first four powers of differences from a reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    count: usize,
    powers: [f64; 4],
}

impl Sums {
    fn add(&mut self, difference: f64) {
        let square = difference * difference;
        self.count += 1;
        self.powers[0] += difference;
        self.powers[1] += square;
        self.powers[2] += square * difference;
        self.powers[3] += square * square;
    }

    fn append(&mut self, other: &Self) {
        self.count += other.count;
        self.powers.iter_mut().zip(other.powers).for_each(|(sum, other)| *sum += other);
    }
}

/// A region's share of a block: elevation, slope, scale, length and strength of edges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Share {
    region: u16,
    sums: [Sums; 5],
}

/// What there is in a block.
pub(super) type Block = Vec<Share>;

/// How ground is cut into blocks.
pub(super) struct Blocks<'a> {
    /// Of every cell the number of its region among those that are compared; [`NOWHERE`] outside of the map.
    pub(super) regions: &'a [u16],
    /// Of every region the numbers that differences are taken from.
    pub(super) references: Vec<[f64; 5]>,
    /// Metres.
    pub(super) spacing: f64,
    /// Cells of a block a side.
    pub(super) side: usize,
    /// Blocks from west to east and from north to south.
    pub(super) count: [usize; 2],
    /// What elevations are counted from when edges are looked for, metres.
    pub(super) middle: f32,
    /// Cells that an edge depends on.
    pub(super) reach: usize,
}

/// A cell outside of the map.
pub(super) const NOWHERE: u16 = u16::MAX;

/// A part of a ground, and where it lies.
fn cropped(ground: &HeightGrid, from: [usize; 2], to: [usize; 2], spacing: f64) -> SampleGrid {
    let [columns, rows] = [to[0] - from[0], to[1] - from[1]];
    let heights = (from[1]..to[1]).flat_map(|row| &ground.heights[row * ground.columns + from[0]..][..columns]).copied().collect();
    SampleGrid { columns, rows, spacing: [spacing; 2], heights }
}

impl Blocks<'_> {
    /// Looks at the blocks that are `dirty`.
    pub(super) fn update(&self, ground: &HeightGrid, dirty: &[bool], blocks: &mut [Block]) {
        let mut done = vec![false; dirty.len()];
        let open = |done: &[bool], x: usize, y: usize| dirty[y * self.count[0] + x] && !done[y * self.count[0] + x];
        for y in 0..self.count[1] {
            let mut x = 0;
            while x < self.count[0] {
                if !open(&done, x, y) {
                    x += 1;
                    continue;
                }
                let end = (x..self.count[0]).find(|x| !open(&done, *x, y)).unwrap_or(self.count[0]);
                let below = (y + 1..self.count[1].min(y + STRIP)).find(|y| !(x..end).all(|x| open(&done, x, *y))).unwrap_or(self.count[1].min(y + STRIP));
                for row in y..below {
                    done[row * self.count[0] + x..row * self.count[0] + end].fill(true);
                }
                self.look([x, y], [end, below], ground, blocks);
                x = end;
            }
        }
    }

    /// Looks at a rectangle of blocks.
    fn look(&self, first: [usize; 2], end: [usize; 2], ground: &HeightGrid, blocks: &mut [Block]) {
        let size = [ground.columns, ground.rows];
        let from = first.map(|block| block * self.side);
        let to = [0, 1].map(|axis: usize| (end[axis] * self.side).min(size[axis]));
        let grown = |by: usize| (from.map(|c| c.saturating_sub(by)), [0, 1].map(|axis: usize| (to[axis] + by).min(size[axis])));
        let (near, near_end) = grown(1);
        let gradient = gradients(&cropped(ground, near, near_end, self.spacing));
        let (wide, wide_end) = grown(self.reach);
        let part = cropped(ground, wide, wide_end, self.spacing);
        let points = edges::detect_part(&part.heights, part.columns, part.rows, self.spacing, self.middle, wide);
        let mut found: Vec<Vec<(u16, Vec<EdgePoint>)>> = vec![Vec::new(); (end[0] - first[0]) * (end[1] - first[1])];
        for point in points.into_iter().filter(|point| (from[0]..to[0]).contains(&point.column) && (from[1]..to[1]).contains(&point.row)) {
            let region = self.regions[point.row * size[0] + point.column];
            let block = &mut found[(point.row / self.side - first[1]) * (end[0] - first[0]) + point.column / self.side - first[0]];
            match block.iter_mut().find(|(known, _)| *known == region) {
                Some((_, points)) => points.push(point),
                None => block.push((region, vec![point])),
            }
        }
        for row in first[1]..end[1] {
            for column in first[0]..end[0] {
                let block = &mut blocks[row * self.count[0] + column];
                block.clear();
                let slope = |x: usize, y: usize| f64::from(degrees(gradient[(y - near[1]) * (near_end[0] - near[0]) + x - near[0]]));
                self.cells([column, row], ground, slope, block);
                let points = &found[(row - first[1]) * (end[0] - first[0]) + column - first[0]];
                self.edges(points, block);
            }
        }
    }

    /// Elevations and slopes of a block.
    fn cells(&self, [column, row]: [usize; 2], ground: &HeightGrid, slope: impl Fn(usize, usize) -> f64, block: &mut Block) {
        for y in row * self.side..((row + 1) * self.side).min(ground.rows) {
            for x in column * self.side..((column + 1) * self.side).min(ground.columns) {
                let region = self.regions[y * ground.columns + x];
                if region == NOWHERE {
                    continue;
                }
                let reference = &self.references[usize::from(region)];
                let sums = share(block, region);
                sums[0].add(f64::from(ground.heights[y * ground.columns + x]) - reference[0]);
                sums[1].add(slope(x, y) - reference[1]);
            }
        }
    }

    /// Edges of a block.
    fn edges(&self, points: &[(u16, Vec<EdgePoint>)], block: &mut Block) {
        for (region, points) in points.iter().filter(|(region, _)| *region != NOWHERE) {
            let reference = &self.references[usize::from(*region)];
            let sums = share(block, *region);
            for edge in link(points, self.spacing, Linking::Whole) {
                for (measure, number) in [edge.scale, edge.length, edge.strength].into_iter().enumerate() {
                    sums[2 + measure].add(number - reference[2 + measure]);
                }
            }
        }
    }

    /// The distributions of every region.
    pub(super) fn profiles(&self, blocks: &[Block]) -> Vec<Profile> {
        let mut sums = vec![[Sums::default(); 5]; self.references.len()];
        for share in blocks.iter().flatten() {
            sums[usize::from(share.region)].iter_mut().zip(&share.sums).for_each(|(sum, share)| sum.append(share));
        }
        let profile = |(sums, references): (&[Sums; 5], &[f64; 5])| {
            Profile(core::array::from_fn(|measure| Statistics::of_sums(sums[measure].count, references[measure], sums[measure].powers)))
        };
        sums.iter().zip(&self.references).map(profile).collect()
    }
}

/// A region's share of a block.
fn share(block: &mut Block, region: u16) -> &mut [Sums; 5] {
    let number = block.iter().position(|share| share.region == region).unwrap_or(block.len());
    if number == block.len() {
        block.push(Share { region, sums: [Sums::default(); 5] });
    }
    &mut block[number].sums
}
