//! Genes: pieces of samples on a grid, and the ground that they blend to (Saunders 2006, IV.3.2.1).

use super::{
    pattern::{HeightGrid, cubic},
    source::{Source, TypeSources},
};
use crate::synthesis::grid::SampleGrid;
use serde::{Deserialize, Serialize};

/// Share of a gene that the next one overlaps.
pub(super) const OVERLAP: f64 = 0.2;

/// One of the eight ways to lay a square on itself: quarters of a turn 0 … 3, after a mirror from 4 on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Turn(pub u8);

impl Turn {
    /// What an offset to the east and south becomes in the sample.
    #[must_use]
    pub fn of<T: Copy + core::ops::Neg<Output = T>>(self, [x, y]: [T; 2]) -> [T; 2] {
        let x = if self.0 & 4 == 0 { x } else { -x };
        match self.0 & 3 {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// What a gradient in the sample becomes where it is laid.
    #[must_use]
    pub fn back<T: Copy + core::ops::Neg<Output = T>>(self, [x, y]: [T; 2]) -> [T; 2] {
        let [x, y] = match self.0 & 3 {
            0 => [x, y],
            1 => [y, -x],
            2 => [-x, -y],
            _ => [-y, x],
        };
        [if self.0 & 4 == 0 { x } else { -x }, y]
    }
}

/// A gene: which piece of which sample, and what is made of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "(u32, i32, i32, Turn, f32, f32, f32)", into = "(u32, i32, i32, Turn, f32, f32, f32)")]
pub struct Gene {
    /// The sample's number among those of the type that reach the level.
    pub sample: u32,
    /// The column of the piece's middle.
    pub column: i32,
    /// The row of the piece's middle.
    pub row: i32,
    /// Quarters of a turn, and a mirror.
    pub turn: Turn,
    /// A turn beyond the quarters, radians.
    pub rotation: f32,
    /// Vertical, about the mean of the piece.
    pub scale: f32,
    /// Vertical, metres.
    pub offset: f32,
}

impl Default for Gene {
    fn default() -> Self {
        Self { sample: 0, column: 0, row: 0, turn: Turn(0), rotation: 0.0, scale: 1.0, offset: 0.0 }
    }
}

impl From<(u32, i32, i32, Turn, f32, f32, f32)> for Gene {
    fn from((sample, column, row, turn, rotation, scale, offset): (u32, i32, i32, Turn, f32, f32, f32)) -> Self {
        Self { sample, column, row, turn, rotation, scale, offset }
    }
}

impl From<Gene> for (u32, i32, i32, Turn, f32, f32, f32) {
    fn from(gene: Gene) -> Self {
        (gene.sample, gene.column, gene.row, gene.turn, gene.rotation, gene.scale, gene.offset)
    }
}

impl Gene {
    /// The turn beyond the quarters as cosine and sine.
    pub(super) fn direction(&self) -> [f32; 2] {
        if self.rotation == 0.0 { [1.0, 0.0] } else { [libm::cosf(self.rotation), libm::sinf(self.rotation)] }
    }

    /// What an offset from its middle becomes in its sample.
    pub(super) fn place(&self, [cos, sin]: [f32; 2], [x, y]: [f32; 2]) -> [f32; 2] {
        self.turn.of([cos * x - sin * y, sin * x + cos * y])
    }

    /// What a gradient in its sample becomes.
    pub(super) fn gradient(&self, [cos, sin]: [f32; 2], gradient: [f32; 2]) -> [f32; 2] {
        let [x, y] = self.turn.back(gradient);
        [self.scale * (cos * x + sin * y), self.scale * (cos * y - sin * x)]
    }

    /// Cells around its middle that it may read.
    pub(super) fn needs(&self, reach: usize) -> usize {
        if self.rotation == 0.0 {
            return reach;
        }
        let [cos, sin] = self.direction();
        libm::ceilf(reach as f32 * (cos.abs() + sin.abs())) as usize
    }
}

/// A grid of genes over a grid of cells.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// Cells of the ground.
    pub(super) cells: [usize; 2],
    /// Cells on either side of a gene's middle.
    pub(super) reach: usize,
    /// Cells between the middles of two genes, an odd number.
    pub(super) pitch: usize,
    /// Genes from west to east and from north to south.
    pub(super) genes: [usize; 2],
    /// Of every column and row the first gene that counts there, and what the next one counts.
    blends: [Vec<(usize, f32)>; 2],
}

impl Layout {
    /// Of genes of about so many cells a side.
    pub(super) fn new(cells: [usize; 2], gene: usize) -> Self {
        let reach = gene / 2;
        let side = (2 * reach + 1) as f64;
        // The nearest odd number to what is not overlapped.
        let pitch = 2 * libm::round((side * (1.0 - OVERLAP) - 1.0) / 2.0).max(1.0) as usize + 1;
        let genes = cells.map(|cells| cells.div_ceil(pitch));
        let blends = [0, 1].map(|axis| blend(cells[axis], genes[axis], pitch, reach));
        Self { cells, reach, pitch, genes, blends }
    }

    /// Cells of a gene a side.
    pub(super) fn side(&self) -> usize {
        2 * self.reach + 1
    }

    /// How many genes.
    pub(super) fn count(&self) -> usize {
        self.genes[0] * self.genes[1]
    }

    /// The middle of a gene: a column and a row, perhaps beyond the last.
    pub(super) fn middle(&self, gene: usize) -> [usize; 2] {
        [gene % self.genes[0], gene / self.genes[0]].map(|number| number * self.pitch + self.pitch / 2)
    }
}

/// Gaussian weights of a gene and the next one along an axis. Where a gene ends it counts next to nothing.
fn blend(cells: usize, genes: usize, pitch: usize, reach: usize) -> Vec<(usize, f32)> {
    let (half, reach, apart) = ((pitch / 2) as isize, reach as isize, pitch as f64);
    // A gene's weight at its end is a hundredth of that of the next.
    let near = apart - reach as f64;
    let variance = ((reach * reach) as f64 - near * near) / (2.0 * 4.6);
    let weight = |x: f64| libm::exp(-x * x / (2.0 * variance));
    let one = |cell: usize| {
        let number = (cell / pitch).min(genes - 1);
        let from = cell as isize - (number * pitch) as isize - half;
        let x = from as f64;
        if from < 0 && from + pitch as isize <= reach && number > 0 {
            let (before, own) = (weight(x + apart), weight(x));
            return (number - 1, (own / (before + own)) as f32);
        }
        if from > 0 && from - pitch as isize >= -reach && number + 1 < genes {
            let (own, next) = (weight(x), weight(x - apart));
            return (number, (next / (own + next)) as f32);
        }
        (number, 0.0)
    };
    (0..cells).map(one).collect()
}

/// What a row of a gene is read with.
struct Reader<'a> {
    grid: &'a SampleGrid,
    heights: &'a [f32],
    gene: &'a Gene,
    direction: [f32; 2],
    mean: f32,
    offset: f32,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source, gene: &'a Gene, reading: Reading) -> Self {
        let (grid, direction) = (&source.grid, gene.direction());
        match reading {
            Reading::Whole => {
                let means = &source.scales.gene;
                let mean = means.mean[means.cell(gene.column as isize, gene.row as isize)];
                Self { grid, heights: &grid.heights, gene, direction, mean, offset: gene.offset }
            }
            Reading::Detail => Self { grid, heights: &source.detail, gene, direction, mean: 0.0, offset: 0.0 },
        }
    }

    /// The height `x` cells east and `y` south of its middle.
    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> f32 {
        let grid = self.grid;
        let clamp = |at: i32, cells: usize| at.clamp(0, cells as i32 - 1) as usize;
        let cell = |column: i32, row: i32| self.heights[clamp(row, grid.rows) * grid.columns + clamp(column, grid.columns)];
        let height = if self.gene.rotation == 0.0 {
            let [x, y] = self.gene.turn.of([x, y]);
            cell(self.gene.column + x, self.gene.row + y)
        } else {
            let [x, y] = self.gene.place(self.direction, [x as f32, y as f32]);
            let (west, north) = (libm::floorf(x), libm::floorf(y));
            let (across, down) = (cubic(x - west), cubic(y - north));
            let (column, row) = (self.gene.column + west as i32 - 1, self.gene.row + north as i32 - 1);
            let line = |row: i32| {
                across[0] * cell(column, row) + across[1] * cell(column + 1, row) + across[2] * cell(column + 2, row) + across[3] * cell(column + 3, row)
            };
            down[0] * line(row) + down[1] * line(row + 1) + down[2] * line(row + 2) + down[3] * line(row + 3)
        };
        height + self.offset + (self.gene.scale - 1.0) * (height - self.mean)
    }
}

/// What of a sample is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reading {
    /// Its heights.
    #[cfg_attr(not(test), expect(dead_code, reason = "grounds take details; heights prove that nothing is lost"))]
    Whole,
    /// What the level before does not hold.
    Detail,
}

/// Which type each gene is of, and the samples.
pub(super) struct Stock<'a> {
    /// By type.
    pub(super) types: &'a [TypeSources],
    /// Of every gene.
    pub(super) kinds: &'a [usize],
    /// What of the samples is read.
    pub(super) reading: Reading,
}

impl Layout {
    /// The ground of a rectangle: x0 + Σ wᵢ (xᵢ - x0) / Σ wᵢ with weights that are products of those of columns and rows, so that pieces of one ground give that ground to the bit.
    pub(super) fn decode(&self, genome: &[Gene], stock: &Stock, onto: &mut HeightGrid, [west, east]: [usize; 2], [north, south]: [usize; 2]) {
        if west >= east {
            return;
        }
        let mut lines = [vec![0.0; east - west], vec![0.0; east - west]];
        for row in north..south {
            let (number, share) = self.blends[1][row];
            self.line(genome, stock, number, row, west, &mut lines[0]);
            let out = &mut onto.heights[row * onto.columns + west..][..east - west];
            if share == 0.0 {
                out.copy_from_slice(&lines[0]);
                continue;
            }
            self.line(genome, stock, number + 1, row, west, &mut lines[1]);
            let [first, second] = &lines;
            out.iter_mut().zip(first.iter().zip(second)).for_each(|(out, (a, b))| *out = a + share * (b - a));
        }
    }

    /// Cells of a row from a column on by one row of genes.
    fn line(&self, genome: &[Gene], stock: &Stock, number: usize, row: usize, west: usize, out: &mut [f32]) {
        let y = row as i32 - (number * self.pitch + self.pitch / 2) as i32;
        let mut column = west;
        let end = west + out.len();
        let mut readers: [Option<(usize, Reader)>; 2] = [None, None];
        while column < end {
            let (first, share) = self.blends[0][column];
            let mut read = |gene: usize| {
                let index = number * self.genes[0] + gene;
                let slot = &mut readers[gene % 2];
                if slot.as_ref().is_none_or(|(known, _)| *known != gene) {
                    let kind = &stock.types[stock.kinds[index]];
                    *slot = Some((gene, Reader::new(&kind.sources[genome[index].sample as usize], &genome[index], stock.reading)));
                }
                let x = column as i32 - (gene * self.pitch + self.pitch / 2) as i32;
                slot.as_ref().map_or(0.0, |(_, reader)| reader.at(x, y))
            };
            let a = read(first);
            out[column - west] = if share == 0.0 { a } else { a + share * (read(first + 1) - a) };
            column += 1;
        }
    }
}
