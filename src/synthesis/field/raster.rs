//! Maps as cells of a level: which region each lies in, and how far it is from the nearest boundary.

use crate::synthesis::map::{Map, Refined, Topology};

/// A frame of square cells over a map, row by row from the north-western corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The west edge and the north edge, metres.
    pub corner: [f64; 2],
    /// Metres between cells.
    pub spacing: f64,
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
}

/// Where a map begins and ends along an axis.
fn bounds(map: &Map, axis: usize) -> [f64; 2] {
    let all = map.regions.iter().flat_map(|region| region.rings.iter().flatten()).map(|vertex| vertex[axis]);
    all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)])
}

impl Frame {
    /// The least frame that holds all of a map; the last column and row may reach over it.
    #[must_use]
    pub fn around(map: &Map, spacing: f64) -> Self {
        let ([west, _], [_, north]) = (bounds(map, 0), bounds(map, 1));
        let [columns, rows] = Self::sides(map, spacing).map(|cells| cells as usize);
        Self { corner: [west, north], spacing, columns, rows }
    }

    /// How many columns and rows [`around`](Self::around) has, whole numbers however many.
    pub(super) fn sides(map: &Map, spacing: f64) -> [f64; 2] {
        // Nine cells and a rounding are nine cells.
        [0, 1].map(|axis| bounds(map, axis)).map(|[low, high]| libm::ceil((high - low) / spacing - 1e-6).max(1.0))
    }

    /// How many cells it has.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// The northing of the middles of a row.
    fn northing(&self, row: usize) -> f64 {
        self.corner[1] - (row as f64 + 0.5) * self.spacing
    }
}

/// A map at a level.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionRaster {
    /// Where its cells are.
    pub frame: Frame,
    /// Of every cell the region that its middle lies in, by the number of the region that it is one with ([`Topology::merged`]). Cells outside of the map have the region that is nearest.
    pub regions: Vec<u32>,
    /// Which cells lie on the map.
    pub inside: Vec<bool>,
    /// Of every cell the distance of its middle from the nearest side of a cell that two regions meet at, cells; infinite if all is one region.
    pub distance: Vec<f32>,
}

/// Where a row of middles is crossed, how steep the crossing is, and what lies east of it.
type Crossing = (f64, f64, Option<usize>);

/// The region to the east of every crossing of a row.
fn crossings(topology: &Topology, curves: &[Vec<[f64; 2]>], frame: &Frame) -> Vec<Vec<Crossing>> {
    let mut rows = vec![Vec::new(); frame.rows];
    for (edge, curve) in topology.edges.iter().zip(curves) {
        for ends in curve.windows(2) {
            let (a, b) = (ends[0], ends[1]);
            let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
            if low == high {
                continue;
            }
            let east = if b[1] > a[1] { edge.regions[1] } else { edge.regions[0] };
            let row = |northing: f64| libm::floor((frame.corner[1] - northing) / frame.spacing).clamp(0.0, frame.rows as f64 - 1.0) as usize;
            let slope = (b[0] - a[0]) / (b[1] - a[1]);
            for (number, row) in rows.iter_mut().enumerate().take(row(low) + 1).skip(row(high)) {
                let y = frame.northing(number);
                if (low..high).contains(&y) {
                    row.push((a[0] + (y - a[1]) * slope, slope, east));
                }
            }
        }
    }
    for row in &mut rows {
        row.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    }
    rows
}

impl RegionRaster {
    /// Of a map whose edges were refined.
    #[must_use]
    pub fn new(topology: &Topology, refined: &Refined, frame: Frame) -> Self {
        let mut regions = vec![u32::MAX; frame.cells()];
        for (row, crossings) in crossings(topology, &refined.curves, &frame).iter().enumerate() {
            let mut next = crossings.iter().peekable();
            let mut region = None;
            for column in 0..frame.columns {
                let x = frame.corner[0] + (column as f64 + 0.5) * frame.spacing;
                while let Some((_, _, east)) = next.next_if(|crossing| crossing.0 <= x) {
                    region = *east;
                }
                if let Some(region) = region {
                    regions[row * frame.columns + column] = topology.merged[region] as u32;
                }
            }
        }
        let inside: Vec<bool> = regions.iter().map(|region| *region != u32::MAX).collect();
        fill(&mut regions, &frame);
        let distance = boundary_distance(&regions, frame.columns, frame.rows);
        Self { frame, regions, inside, distance }
    }

    /// Regions that have a cell, in order.
    #[must_use]
    pub fn present(&self) -> Vec<u32> {
        let mut present = self.regions.clone();
        present.sort_unstable();
        present.dedup();
        present
    }

    /// It as an image of three bytes a cell: the colour of every region, darker at boundaries and paler outside of the map.
    #[must_use]
    pub fn image(&self, colour: impl Fn(u32) -> [u8; 3]) -> Vec<u8> {
        let cell = |cell: usize| {
            let colour = colour(self.regions[cell]);
            colour.map(|c| {
                if self.distance[cell] < 1.0 {
                    c / 2
                } else if self.inside[cell] {
                    c
                } else {
                    128 + c / 2
                }
            })
        };
        (0..self.regions.len()).flat_map(cell).collect()
    }
}

/// Gives cells without a region that of the nearest cell that has one.
fn fill(regions: &mut [u32], frame: &Frame) {
    let mut present: Vec<u32> = regions.iter().copied().filter(|region| *region != u32::MAX).collect();
    present.sort_unstable();
    present.dedup();
    if present.len() < 2 || !regions.contains(&u32::MAX) {
        let only = present.first().copied().unwrap_or(0);
        regions.iter_mut().filter(|region| **region == u32::MAX).for_each(|region| *region = only);
        return;
    }
    let mut nearest = vec![u64::MAX; regions.len()];
    let known = regions.to_vec();
    for region in present {
        let squares = squared_distances(frame.columns, frame.rows, |cell| known[cell] == region);
        for (cell, square) in squares.into_iter().enumerate() {
            if known[cell] == u32::MAX && square < nearest[cell] {
                (nearest[cell], regions[cell]) = (square, region);
            }
        }
    }
}

/// Far: more than the square of any distance of cells, and far from overflow.
const FAR: u64 = 1 << 40;

/// The lower envelope of parabolas along a line: squares of distances to the places that `line` gives squares for (Felzenszwalb and Huttenlocher 2012), in whole numbers.
fn envelope(line: &[u64], stack: &mut Vec<(usize, usize)>, out: &mut [u64]) {
    stack.clear();
    // The first place from which on the parabola of `b` is lower than that of `a` < `b`: (b² - a² + f(b) - f(a)) / 2 (b - a), rounded upwards.
    let from = |a: usize, b: usize| {
        let top = (b * b - a * a) as i64 + line[b] as i64 - line[a] as i64;
        if top <= 0 { 0 } else { (top as u64).div_ceil(2 * (b - a) as u64) as usize }
    };
    for b in (0..line.len()).filter(|b| line[*b] < FAR) {
        let mut start = 0;
        while let Some((a, begins)) = stack.last() {
            start = from(*a, b);
            if start > *begins {
                break;
            }
            stack.pop();
        }
        if stack.is_empty() {
            start = 0;
        }
        stack.push((b, start));
    }
    let mut lowest = 0;
    for (place, out) in out.iter_mut().enumerate() {
        while lowest + 1 < stack.len() && stack[lowest + 1].1 <= place {
            lowest += 1;
        }
        *out = stack.get(lowest).map_or(FAR, |(b, _)| line[*b] + (b.abs_diff(place) * b.abs_diff(place)) as u64);
    }
}

/// Squares of the exact distances of all cells from the nearest cell that is one, in linear time; [`u64::MAX`] and less but more than any distance if there is none.
pub(super) fn squared_distances(columns: usize, rows: usize, one: impl Fn(usize) -> bool) -> Vec<u64> {
    let mut squares = vec![FAR; columns * rows];
    // Along columns first, both ways.
    for ordered in [false, true] {
        for i in 0..rows {
            let row = if ordered { rows - 1 - i } else { i };
            for column in 0..columns {
                let cell = row * columns + column;
                let before = if i == 0 { FAR } else { squares[if ordered { cell + columns } else { cell - columns }] };
                let next = if before >= FAR { FAR } else { before + 1 };
                squares[cell] = if one(cell) { 0 } else { squares[cell].min(next) };
            }
        }
    }
    let (mut stack, mut line) = (Vec::new(), vec![0; columns]);
    for row in squares.chunks_exact_mut(columns) {
        line.iter_mut().zip(&*row).for_each(|(square, steps)| *square = if *steps >= FAR { FAR } else { steps * steps });
        envelope(&line, &mut stack, row);
    }
    squares
}

/// Distances of the middles of cells from sides between cells of two regions: places of a lattice of half cells, in which middles are odd and sides and their ends even.
fn boundary_distance(regions: &[u32], columns: usize, rows: usize) -> Vec<f32> {
    let (wide, high) = (2 * columns + 1, 2 * rows + 1);
    let mut on = vec![false; wide * high];
    for row in 0..rows {
        for column in 0..columns {
            let own = regions[row * columns + column];
            if column + 1 < columns && regions[row * columns + column + 1] != own {
                (0..3).for_each(|i| on[(2 * row + i) * wide + 2 * column + 2] = true);
            }
            if row + 1 < rows && regions[(row + 1) * columns + column] != own {
                (0..3).for_each(|i| on[(2 * row + 2) * wide + 2 * column + i] = true);
            }
        }
    }
    if !on.contains(&true) {
        return vec![f32::INFINITY; columns * rows];
    }
    let squares = squared_distances(wide, high, |place| on[place]);
    let middle = |cell: usize| squares[(2 * (cell / columns) + 1) * wide + 2 * (cell % columns) + 1];
    (0..columns * rows).map(|cell| ((middle(cell) as f64).sqrt() / 2.0) as f32).collect()
}
