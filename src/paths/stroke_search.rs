//! Searches of single strokes: each in a window of its own, which fits into caches however large the frame is.

use super::{
    lattice::{Frame, Node, Weights},
    search::{Generator, Label, Search, Terrain},
};

/// Nodes around the first stroke that are searched.
const FIRST_MARGIN: usize = 48;

/// What searches of strokes need, kept from one to the next.
#[derive(Debug)]
pub(super) struct StrokeSearch {
    search: Search,
    /// How far the widest stroke so far went, and somewhat more.
    margin: usize,
    regions: Vec<u16>,
    generators: Vec<Generator>,
}

impl StrokeSearch {
    /// For terrain whose steps cost at least `step`.
    pub(super) fn new(step: f32) -> Self {
        Self { search: Search::empty(step), margin: FIRST_MARGIN, regions: Vec::new(), generators: Vec::new() }
    }

    /// Labels all that paths from the generators reach below the limits, as [`Search::run`] over the whole frame does: what leaves no label at the edge of its window was not cut.
    pub(super) fn labels(&mut self, terrain: &Terrain, limits: &[f32], generators: &[Generator], sea_level_cost: f32) -> Vec<Label> {
        let frame = &terrain.weights.frame;
        let Some(own) = around(frame, generators.iter().map(|generator| generator.slot)) else { return Vec::new() };
        loop {
            let window = within(&own.grown(self.margin), frame);
            let labels = self.searched(terrain, limits, generators, sea_level_cost, window);
            let reached = around(frame, labels.iter().map(|label| label.slot)).unwrap_or(own);
            if !cut(&reached, &window, frame) {
                let farthest = farthest(&reached, &own);
                self.margin = self.margin.max(farthest + farthest / 4 + 2);
                return labels;
            }
            self.margin *= 2;
        }
    }

    fn searched(&mut self, terrain: &Terrain, limits: &[f32], generators: &[Generator], sea_level_cost: f32, window: Frame) -> Vec<Label> {
        let frame = &terrain.weights.frame;
        let origin = frame.slot(window.first).unwrap_or_default() - frame.stride() - 1;
        let (stride, own) = (frame.stride(), window.stride());
        self.search.fit(terrain, limits, origin, window);
        self.regions.clear();
        if !terrain.regions.is_empty() {
            self.regions.extend((0..window.rows + 2).flat_map(|row| &terrain.regions[origin + row * stride..][..own]));
        }
        self.generators.clear();
        self.generators.extend(generators.iter().map(|generator| {
            let slot = generator.slot as usize - origin;
            Generator { slot: (slot / stride * own + slot % stride) as u32, ..*generator }
        }));
        let weights = Weights { frame: window, values: Vec::new(), rule: terrain.weights.rule };
        let local = Terrain { weights: &weights, profiles: terrain.profiles, regions: &self.regions };
        let labels = self.search.run(&local, &self.generators, sea_level_cost);
        let (own, stride, origin) = (own as u32, stride as u32, origin as u32);
        labels.iter().map(|label| Label { slot: origin + label.slot / own * stride + label.slot % own, ..*label }).collect()
    }
}

/// The least frame that holds slots of another.
fn around(frame: &Frame, slots: impl Iterator<Item = u32>) -> Option<Frame> {
    let stride = frame.stride() as u32;
    let mut ends = [u32::MAX, u32::MAX, 0, 0];
    for slot in slots {
        let (row, column) = (slot / stride, slot % stride);
        ends = [ends[0].min(column), ends[1].min(row), ends[2].max(column), ends[3].max(row)];
    }
    let [west, south, east, north] = ends;
    (west <= east).then(|| {
        let first = frame.node((south * stride + west) as usize);
        Frame { first, columns: (east - west + 1) as usize, rows: (north - south + 1) as usize }
    })
}

fn ends(frame: &Frame) -> [i64; 4] {
    [frame.first.column, frame.first.row, frame.first.column + frame.columns as i64, frame.first.row + frame.rows as i64]
}

/// The part of a frame that lies in another.
fn within(frame: &Frame, other: &Frame) -> Frame {
    let ([a, b, c, d], [west, south, east, north]) = (ends(frame), ends(other));
    let (first, last) = ([a.max(west), b.max(south)], [c.min(east), d.min(north)]);
    Frame { first: Node { row: first[1], column: first[0] }, columns: (last[0] - first[0]) as usize, rows: (last[1] - first[1]) as usize }
}

/// Whether what was reached touches an edge of the window that is none of the frame.
fn cut(reached: &Frame, window: &Frame, frame: &Frame) -> bool {
    let (reached, window, frame) = (ends(reached), ends(window), ends(frame));
    (0..4).any(|side| reached[side] == window[side] && window[side] != frame[side])
}

/// How far a frame goes beyond another inside it.
fn farthest(frame: &Frame, inner: &Frame) -> usize {
    let (frame, inner) = (ends(frame), ends(inner));
    (0..4).map(|side| frame[side].abs_diff(inner[side]) as usize).max().unwrap_or_default()
}
