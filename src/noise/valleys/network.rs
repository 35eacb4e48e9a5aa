//! The network of valleys of one lattice: its nodes, each linked to a lower one.

use super::{BEND, CANDIDATES, HALF_WIDTH, JITTER, candidates_and_reach};
use crate::noise::hash;

/// The lowest place of a cell: relative to the cell's south-west corner, and its height.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Site {
    pub x: f32,
    pub y: f32,
    pub z: f32,
}

/// A valley from a node to a lower one, relative to the corner of the cells around it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub from: Site,
    pub to: [f32; 3],
    pub inverse_square: f32,
    pub bend: f32,
}

/// What the samples around a corner of cells look at.
#[derive(Debug)]
pub(super) struct Around {
    /// Place and slope of the 4 × 4 nodes.
    pub nodes: [[f32; 3]; 16],
    pub links: Vec<Link>,
}

/// A node with what leads away from it.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    site: Site,
    slope: f32,
    /// How many cells its link spans, 0 without one.
    span: i64,
    to: [f32; 3],
    inverse_square: f32,
    bend: f32,
}

/// Cells a side of a page of sites: many heights are asked for together.
const SITES: i64 = 8;

/// Cells a side of a page of nodes: few are found that nobody looks at.
const NODES: i64 = 4;

/// The nodes of a page of cells.
struct NodePage {
    nodes: Vec<Node>,
    /// Those of them whose links span more than a cell.
    far: Vec<usize>,
}

/// The numbers of all pages of `side` × `side` cells that cells `from` … `to` lie in.
fn pages(side: i64, from: [i64; 2], to: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    let ([west, south], [east, north]) = (from.map(|c| c.div_euclid(side)), to.map(|c| c.div_euclid(side)));
    (south..=north).flat_map(move |j| (west..=east).map(move |i| [i, j]))
}

/// The cells of a page of `side` × `side` cells that lie in `from` … `to`, with their numbers in the page.
fn cells(side: i64, page: [i64; 2], from: [i64; 2], to: [i64; 2]) -> impl Iterator<Item = ([i64; 2], usize)> {
    let [west, south] = page.map(|n| n * side);
    let (columns, rows) = (west.max(from[0])..=(west + side - 1).min(to[0]), south.max(from[1])..=(south + side - 1).min(to[1]));
    rows.flat_map(move |j| columns.clone().map(move |i| ([i, j], ((j - south) * side + i - west) as usize)))
}

/// A lattice with its network, as far as it was found.
pub(super) struct Level {
    pub pitch: f64,
    pub cut: f32,
    reach: i64,
    candidates: usize,
    seeds: [u32; CANDIDATES + 1],
    sites: Cache<Vec<Site>>,
    nodes: Cache<NodePage>,
    corners: Cache<Around>,
}

impl Level {
    pub(super) fn new(key: u64, number: usize, pitch: f64, cut: f32) -> Self {
        let (candidates, reach) = candidates_and_reach(number);
        let seeds = core::array::from_fn(|channel| hash::key(hash::key(key, number as u64), channel as u64) as u32);
        Self { pitch, cut, reach, candidates, seeds, sites: Cache::new(), nodes: Cache::new(), corners: Cache::new() }
    }

    /// A place within a cell, from the middle half and a little more.
    pub(super) fn place(&self, [i, j]: [i64; 2], candidate: usize) -> [f32; 2] {
        let bits = hash::corner(hash::column_key(i), hash::row_key(j, self.seeds[candidate]));
        let at = |bits: u32| 0.5 + JITTER * ((bits as f32 + 0.5) / 32_768.0 - 1.0);
        [at(bits & 0xffff), at(bits >> 16)]
    }

    /// In [-1, 1].
    pub(super) fn turn(&self, [i, j]: [i64; 2]) -> f32 {
        let bits = hash::corner(hash::column_key(i), hash::row_key(j, self.seeds[CANDIDATES]));
        ((bits >> 16) as f32 + 0.5) / 32_768.0 - 1.0
    }

    /// The corner of cells nearest to a coordinate, and the coordinate relative to it, in pitches.
    #[inline(always)]
    pub(super) fn locate(pitch: f64, coordinate: f64) -> (i64, f32) {
        let at = coordinate / pitch;
        // Beyond 2^52 cells cannot be told apart; the clamp keeps their neighbours' numbers from overflowing.
        let corner = (at + 0.5).floor().clamp(-4.5e15, 4.5e15);
        (corner as i64, (at - corner).clamp(-0.5, 0.5) as f32)
    }

    /// Everything that samples nearest to a corner of cells look at. `heights` gives the terrain with the valleys of all coarser lattices.
    pub(super) fn around(&mut self, corner: [i64; 2], heights: impl FnMut(&[f64], &[f64], &mut [f32])) -> &Around {
        if self.corners.get(corner).is_none() {
            let around = self.find_around(corner, heights);
            self.corners.keep(corner, around);
        }
        self.corners.last(corner)
    }

    fn find_around(&mut self, [i, j]: [i64; 2], mut heights: impl FnMut(&[f64], &[f64], &mut [f32])) -> Around {
        // Links come from up to `reach` - 1 rings around the 4 × 4 cells.
        let rings = self.reach - 1;
        let (from, to) = ([i - 2, j - 2], [i + 1, j + 1]);
        let (from_far, to_far) = (from.map(|c| c - rings), to.map(|c| c + rings));
        for number in pages(NODES, from_far, to_far) {
            if self.nodes.get(number).is_none() {
                let page = self.find_nodes(number, &mut heights);
                self.nodes.keep(number, page);
            }
        }
        let (mut nodes, mut links) = ([[0.0; 3]; 16], Vec::with_capacity(16));
        let link = |node: &Node, [cell_i, cell_j]: [i64; 2]| {
            let from = Site { x: (cell_i - i) as f32 + node.site.x, y: (cell_j - j) as f32 + node.site.y, z: node.site.z };
            Link { from, to: node.to, inverse_square: node.inverse_square, bend: node.bend }
        };
        for number in pages(NODES, from, to) {
            let page = self.nodes.last(number);
            for (cell, of) in cells(NODES, number, from, to) {
                let link = link(&page.nodes[of], cell);
                nodes[((cell[1] - from[1]) * 4 + cell[0] - from[0]) as usize] = [link.from.x, link.from.y, page.nodes[of].slope];
                if page.nodes[of].span > 0 && is_near(&link) {
                    links.push(link);
                }
            }
        }
        if rings > 0 {
            for number in pages(NODES, from_far, to_far) {
                let page = self.nodes.last(number);
                for &of in &page.far {
                    let cell = [number[0] * NODES + of as i64 % NODES, number[1] * NODES + of as i64 / NODES];
                    let away = (0..2).map(|axis| (from[axis] - cell[axis]).max(cell[axis] - to[axis])).max().unwrap_or(0);
                    let link = link(&page.nodes[of], cell);
                    if away > 0 && page.nodes[of].span > away && is_near(&link) {
                        links.push(link);
                    }
                }
            }
        }
        Around { nodes, links }
    }

    /// The nodes of a page of cells.
    fn find_nodes(&mut self, number: [i64; 2], heights: &mut impl FnMut(&[f64], &[f64], &mut [f32])) -> NodePage {
        let reach = self.reach;
        let first = number.map(|n| n * NODES);
        let (from, to) = (first.map(|c| c - reach), first.map(|c| c + NODES - 1 + reach));
        let side = NODES + 2 * reach;
        let mut sites = vec![Site::default(); (side * side) as usize];
        for number in pages(SITES, from, to) {
            if self.sites.get(number).is_none() {
                let page = self.find_sites(number, heights);
                self.sites.keep(number, page);
            }
            let page = self.sites.last(number);
            for ([i, j], of) in cells(SITES, number, from, to) {
                sites[((j - from[1]) * side + i - from[0]) as usize] = page[of];
            }
        }
        let at = |a: i64, b: i64| sites[((b + reach) * side + a + reach) as usize];
        let node = |(a, b): (i64, i64)| {
            let mut node = Node { site: at(a, b), ..Node::default() };
            if let Some((span, to)) = find_link(&at, reach, [a, b]) {
                let square = to[0] * to[0] + to[1] * to[1];
                let length = square.sqrt();
                let bend = 4.0 * BEND * self.turn([first[0] + a, first[1] + b]) / length;
                node = Node { slope: -to[2] / length, span, to, inverse_square: 1.0 / square, bend, ..node };
            }
            node
        };
        let nodes: Vec<Node> = (0..NODES).flat_map(|b| (0..NODES).map(move |a| (a, b))).map(node).collect();
        let far = (0..nodes.len()).filter(|&of| nodes[of].span > 1).collect();
        NodePage { nodes, far }
    }

    /// The sites of a page of cells.
    fn find_sites(&self, page: [i64; 2], heights: &mut impl FnMut(&[f64], &[f64], &mut [f32])) -> Vec<Site> {
        let (mut us, mut vs, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for cell in 0..SITES * SITES {
            let cell = [page[0] * SITES + cell % SITES, page[1] * SITES + cell / SITES];
            for candidate in 0..self.candidates {
                let [x, y] = self.place(cell, candidate);
                us.push((cell[0] as f64 + f64::from(x)) * self.pitch);
                vs.push((cell[1] as f64 + f64::from(y)) * self.pitch);
                places.push([x, y]);
            }
        }
        let mut zs = vec![0.0; us.len()];
        heights(&us, &vs, &mut zs);
        let mut sites = Vec::with_capacity((SITES * SITES) as usize);
        for (places, zs) in places.chunks(self.candidates).zip(zs.chunks(self.candidates)) {
            let all = places.iter().zip(zs).map(|(&[x, y], &z)| Site { x, y, z });
            // Of equals the first.
            sites.extend(all.reduce(|lowest, other| if other.z < lowest.z { other } else { lowest }));
        }
        sites
    }
}

/// Places along and across a neighbourhood in which each has a slot of its own.
const SLOTS: [i64; 2] = [128, 32];

/// What was found last. What is kept changes no value: it could be found again.
struct Cache<T> {
    /// For each slot, where it stands in `kept`.
    slots: Vec<u32>,
    kept: Vec<([i64; 2], T)>,
}

impl<T> Cache<T> {
    fn new() -> Self {
        Self { slots: vec![u32::MAX; (SLOTS[0] * SLOTS[1]) as usize], kept: Vec::new() }
    }

    #[inline(always)]
    fn slot([i, j]: [i64; 2]) -> usize {
        (j.rem_euclid(SLOTS[1]) * SLOTS[0] + i.rem_euclid(SLOTS[0])) as usize
    }

    #[inline(always)]
    fn get(&self, place: [i64; 2]) -> Option<&T> {
        match self.kept.get(self.slots[Self::slot(place)] as usize) {
            Some((kept, value)) if *kept == place => Some(value),
            _ => None,
        }
    }

    /// What was kept last in the slot of a place: of the place itself, if no other of its slot was kept since.
    #[inline(always)]
    fn last(&self, place: [i64; 2]) -> &T {
        &self.kept[self.slots[Self::slot(place)] as usize].1
    }

    /// Keeps a value in place of the one before in its slot.
    fn keep(&mut self, place: [i64; 2], value: T) {
        let slot = &mut self.slots[Self::slot(place)];
        if let Some(kept) = self.kept.get_mut(*slot as usize) {
            *kept = (place, value);
        } else {
            *slot = self.kept.len() as u32;
            self.kept.push((place, value));
        }
    }
}

/// Whether a valley can reach a sample within half a pitch of the corner: by the box around its link.
fn is_near(link: &Link) -> bool {
    let away = |from: f32, to: f32| {
        let (low, high) = (from.min(from + to) - BEND, from.max(from + to) + BEND);
        low > 0.5 + HALF_WIDTH || high < -0.5 - HALF_WIDTH
    };
    !away(link.from.x, link.to[0]) && !away(link.from.y, link.to[1])
}

/// Where a node's valley leads, relative to it, and how many cells it spans: the neighbour with the greatest drop over distance squared, else the nearest lower node of
/// the first ring that has one. `at` gives the site of a cell, relative to that cell.
pub(super) fn find_link(at: &impl Fn(i64, i64) -> Site, reach: i64, [a, b]: [i64; 2]) -> Option<(i64, [f32; 3])> {
    let from = at(a, b);
    for span in 1..=reach {
        let (mut best, mut found) = (0.0, None);
        for d in -span..=span {
            for c in -span..=span {
                let to = at(a + c, b + d);
                let to = [c as f32 + (to.x - from.x), d as f32 + (to.y - from.y), to.z - from.z];
                let square = to[0] * to[0] + to[1] * to[1];
                let score = if to[2] < 0.0 { if span == 1 { -to[2] / square } else { 1.0 / square } } else { 0.0 };
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
