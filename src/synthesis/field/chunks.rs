//! Chunks of samples side by side, cut where they differ least (after Efros and Freeman, "Image quilting for texture synthesis and transfer", 2001), and levelled.

use super::{gene::Turn, relax::Slopes, source::TypeSources};
use crate::genetic::Draws;

/// How many chunks are looked at for every place.
const LOOKS: usize = 48;

/// How much less a chunk fits for having been used.
const USED: f64 = 6.0;

/// A rectangle of a sample laid on the ground.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    sample: usize,
    turn: Turn,
    /// The north-western cell on the ground.
    at: [i32; 2],
    /// Where in the sample that cell is.
    origin: [i32; 2],
    /// The north-western cell of the rectangle in the sample, and its sides.
    source: [[i32; 2]; 2],
}

/// Ground of one type.
pub(super) struct Quilt<'a> {
    stock: &'a TypeSources,
    columns: usize,
    rows: usize,
    chunks: Vec<Chunk>,
    /// Of every cell the number of its chunk.
    labels: Vec<u32>,
    heights: Vec<f32>,
}

/// Where chunks begin along an axis.
fn starts(cells: usize, chunk: usize, step: usize) -> Vec<usize> {
    if chunk >= cells {
        return vec![0];
    }
    let count = (cells - chunk).div_ceil(step.max(1));
    (0..=count).map(|i| i * (cells - chunk) / count).collect()
}

impl<'a> Quilt<'a> {
    /// Of chunks of at most so many cells a side; `None` if no sample holds one.
    pub(super) fn new(stock: &'a TypeSources, [columns, rows]: [usize; 2], chunk: [usize; 2], draws: &mut Draws) -> Option<Self> {
        let size = [chunk[0].min(columns), chunk[1].min(rows)];
        let mut quilt = Self { stock, columns, rows, chunks: Vec::new(), labels: vec![u32::MAX; columns * rows], heights: vec![0.0; columns * rows] };
        let step = size.map(|side| side - (side / 3).max(2).min(side - 1));
        for y in starts(rows, size[1], step[1]) {
            for x in starts(columns, size[0], step[0]) {
                let at = [x as i32, y as i32];
                let mut candidates: Vec<Chunk> = (0..LOOKS).filter_map(|_| quilt.candidate(at, size, true, draws)).collect();
                if candidates.is_empty() {
                    // Where nearly nothing counts, what does not count is better than nothing.
                    candidates.extend(quilt.candidate(at, size, false, draws));
                }
                let costs: Vec<f64> = candidates.iter().map(|candidate| quilt.cost(candidate, size)).collect();
                let best = (0..costs.len()).reduce(|best, other| if costs[other] < costs[best] { other } else { best })?;
                quilt.lay(candidates[best], size);
            }
        }
        Some(quilt)
    }

    /// A chunk by chance, if it lies where cells count or these need not.
    fn candidate(&self, at: [i32; 2], [columns, rows]: [usize; 2], counting: bool, draws: &mut Draws) -> Option<Chunk> {
        let turn = Turn(draws.below(8) as u8);
        let size = if turn.0 & 1 == 0 { [columns, rows] } else { [rows, columns] };
        let free = |of: [usize; 2]| [0, 1].map(|axis: usize| (of[axis] + 1).saturating_sub(size[axis]));
        let weights: Vec<f64> = self
            .stock
            .sources
            .iter()
            .map(|source| free([source.grid.columns, source.grid.rows]))
            .map(|[x, y]| x.min(1) as f64 * y.min(1) as f64 * ((x * y) as f64).sqrt())
            .collect();
        if weights.iter().all(|weight| *weight == 0.0) {
            return None;
        }
        let sample = draws.weighted(&weights);
        let source = &self.stock.sources[sample];
        let corner = free([source.grid.columns, source.grid.rows]).map(|free| draws.below(free) as i32);
        let size = size.map(|side| side as i32);
        if counting && !source.counts(corner, size) {
            return None;
        }
        let ends = [turn.of([0, 0]), turn.of([columns as i32 - 1, rows as i32 - 1])];
        let origin = [0, 1].map(|axis| corner[axis] - ends[0][axis].min(ends[1][axis]));
        Some(Chunk { sample, turn, at, origin, source: [corner, size] })
    }

    /// The height that a chunk gives a cell, also where it is not its own.
    fn height(&self, chunk: &Chunk, x: i32, y: i32) -> Option<f32> {
        let [dx, dy] = chunk.turn.of([x - chunk.at[0], y - chunk.at[1]]);
        let (column, row) = (chunk.origin[0] + dx, chunk.origin[1] + dy);
        let grid = &self.stock.sources[chunk.sample].grid;
        let inside = column >= 0 && row >= 0 && column < grid.columns as i32 && row < grid.rows as i32;
        inside.then(|| grid.heights[row as usize * grid.columns + column as usize])
    }

    /// Cells of a chunk that are taken already, with what is there and what the chunk gives.
    fn overlap(&self, chunk: &Chunk, [columns, rows]: [usize; 2]) -> Vec<(usize, f64)> {
        let mut overlap = Vec::new();
        for y in chunk.at[1]..chunk.at[1] + rows as i32 {
            for x in chunk.at[0]..chunk.at[0] + columns as i32 {
                let cell = y as usize * self.columns + x as usize;
                if self.labels[cell] != u32::MAX
                    && let Some(height) = self.height(chunk, x, y)
                {
                    overlap.push((cell, f64::from(height) - f64::from(self.heights[cell])));
                }
            }
        }
        overlap
    }

    /// How badly a chunk fits.
    fn cost(&self, chunk: &Chunk, size: [usize; 2]) -> f64 {
        let overlap = self.overlap(chunk, size);
        let count = overlap.len().max(1) as f64;
        let mean = overlap.iter().map(|(_, difference)| difference).sum::<f64>() / count;
        let variance = overlap.iter().map(|(_, difference)| (difference - mean) * (difference - mean)).sum::<f64>() / count;
        let shared = |other: &Chunk| {
            let along = |axis: usize| {
                let (a, b) = (chunk.source, other.source);
                ((a[0][axis] + a[1][axis]).min(b[0][axis] + b[1][axis]) - a[0][axis].max(b[0][axis])).max(0)
            };
            if other.sample == chunk.sample { f64::from(along(0) * along(1)) / (size[0] * size[1]) as f64 } else { 0.0 }
        };
        let used: f64 = self.chunks.iter().map(shared).sum();
        let least = 1e-5 * self.stock.range * self.stock.range;
        (variance + 0.1 * mean * mean + least) * (1.0 + USED * used)
    }

    /// Lays a chunk: its own is what lies beyond the line of least difference.
    fn lay(&mut self, chunk: Chunk, [columns, rows]: [usize; 2]) {
        let differences = self.overlap(&chunk, [columns, rows]);
        let count = differences.len().max(1) as f64;
        let mean = differences.iter().map(|(_, difference)| difference).sum::<f64>() / count;
        let [x0, y0] = chunk.at.map(|c| c as usize);
        let mut errors = vec![None; columns * rows];
        for (cell, difference) in differences {
            let (x, y) = (cell % self.columns - x0, cell / self.columns - y0);
            errors[y * columns + x] = Some((difference - mean) * (difference - mean));
        }
        let width = (0..columns).take_while(|x| errors[(rows - 1) * columns + x].is_some()).count();
        let height = (0..rows).take_while(|y| errors[y * columns + columns - 1].is_some()).count();
        let error = |x: usize, y: usize| errors[y * columns + x].unwrap_or(0.0);
        let west = if width < columns { cut(width, rows, error) } else { vec![0; rows] };
        let north = if height < rows { cut(height, columns, |y, x| error(x, y)) } else { vec![0; columns] };
        let number = self.chunks.len() as u32;
        for (y, west) in west.iter().enumerate() {
            for (x, north) in north.iter().enumerate() {
                let cell = (y0 + y) * self.columns + x0 + x;
                if (self.labels[cell] == u32::MAX || (x >= *west && y >= *north))
                    && let Some(height) = self.height(&chunk, (x0 + x) as i32, (y0 + y) as i32)
                {
                    (self.labels[cell], self.heights[cell]) = (number, height);
                }
            }
        }
        self.chunks.push(chunk);
    }

    /// Its heights as they were laid and the differences of neighbours; over seams these are the mean of those of both chunks.
    pub(super) fn slopes(&self) -> Slopes {
        let step = |cell: usize, other: usize| {
            let place = |cell: usize| ((cell % self.columns) as i32, (cell / self.columns) as i32);
            let ((x, y), (to_x, to_y)) = (place(cell), place(other));
            let by = |label: u32| {
                let chunk = self.chunks.get(label as usize)?;
                Some(f64::from(self.height(chunk, to_x, to_y)?) - f64::from(self.height(chunk, x, y)?))
            };
            match (by(self.labels[cell]), by(self.labels[other])) {
                (Some(a), Some(b)) => f64::midpoint(a, b),
                (Some(one), None) | (None, Some(one)) => one,
                (None, None) => 0.0,
            }
        };
        let mut slopes = Slopes::new(self.columns, self.rows);
        for cell in 0..self.columns * self.rows {
            slopes.heights[cell] = f64::from(self.heights[cell]);
            if cell % self.columns + 1 < self.columns {
                slopes.east[cell] = step(cell, cell + 1);
            }
            if cell / self.columns + 1 < self.rows {
                slopes.south[cell] = step(cell, cell + self.columns);
            }
        }
        slopes
    }
}

/// The line through a band of `width` × `length` along which errors are least, from one end to the other: of every line across the cell from which on the new is.
fn cut(width: usize, length: usize, error: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    if width == 0 {
        return vec![0; length];
    }
    let mut sums = vec![0.0; width * length];
    for y in 0..length {
        for x in 0..width {
            let before = |x: usize| sums[(y - 1) * width + x];
            let least = if y == 0 { 0.0 } else { (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(before).fold(f64::INFINITY, f64::min) };
            sums[y * width + x] = least + error(x, y);
        }
    }
    let least = |y: usize, from: usize, to: usize| (from..=to).reduce(|a, b| if sums[y * width + b] < sums[y * width + a] { b } else { a }).unwrap_or(from);
    let mut line = vec![0; length];
    let mut x = least(length - 1, 0, width - 1);
    for y in (0..length).rev() {
        if y + 1 < length {
            x = least(y, x.saturating_sub(1), (x + 1).min(width - 1));
        }
        line[y] = x;
    }
    line
}
