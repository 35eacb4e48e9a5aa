//! What a stroke's search found, wherever it is asked for.

use super::{
    Mesh,
    place::{Place, Rule},
};
use crate::paths::{
    canvas::{Canvas, Slots},
    lattice::{Diagonal, Frame, Node, Random, Weights},
    profile::Crest,
    search::{Generator, Search, Terrain, limits},
};

/// The costs of a stroke's paths, over just what they reach.
#[derive(Debug)]
pub(super) struct Patch {
    frame: Frame,
    /// Row by row from the south; infinite where no path arrives.
    costs: Vec<f32>,
    /// Nodes inside its outline where nothing else counts; empty without.
    inside: Vec<Node>,
    settled: usize,
    /// Whether paths came to the border of what was searched.
    cut: bool,
}

impl Patch {
    /// Searches all that a stroke's paths can reach.
    pub(super) fn new(mesh: &Mesh, diagonal: Diagonal, sea_level_cost: f32, place: &Place, rule: &Rule) -> Self {
        // Few strokes use all of the reach. What leaves no label on the border was not cut.
        let half = Self::within(mesh, diagonal, sea_level_cost, place, rule, mesh.reach / 2);
        if half.cut { Self::within(mesh, diagonal, sea_level_cost, place, rule, mesh.reach) } else { half }
    }

    /// Searches so many nodes around a stroke.
    pub(super) fn within(mesh: &Mesh, diagonal: Diagonal, sea_level_cost: f32, place: &Place, rule: &Rule, margin: usize) -> Self {
        let canvas = Canvas::around(place.frame(mesh.spacing), margin, mesh.spacing);
        let frame = canvas.frame;
        let weights = Weights::random(frame, &Random { mean: mesh.mean, deviation: mesh.deviation, key: mesh.key }, diagonal);
        let slots: Slots = place.lines.iter().flat_map(|line| canvas.along(line)).collect();
        let generators: Vec<Generator> = slots
            .iter()
            .map(|slot| (*slot, rule.costs(frame.node(*slot as usize), mesh.spacing)))
            .filter(|(_, cost)| *cost < sea_level_cost)
            .map(|(slot, cost)| Generator { slot, profile: u32::from(place.profile), crest: Crest::new(cost, sea_level_cost - cost, sea_level_cost) })
            .collect();
        let inside = if rule.inside.is_some() { canvas.inside(&slots) } else { Slots::new() };
        let mut regions = Vec::new();
        if let Some(profile) = rule.inside {
            regions = vec![0; frame.slots()];
            for slot in &inside {
                regions[*slot as usize] = profile + 1;
            }
        }
        let terrain = Terrain { weights: &weights, profiles: &mesh.scalings, regions: &regions };
        let mut search = Search::new(&terrain, limits(&frame, |_| sea_level_cost));
        let labels = search.run(&terrain, &generators, sea_level_cost);
        let settled = labels.len();
        let inside = if rule.only { inside.iter().map(|slot| frame.node(*slot as usize)).collect() } else { Vec::new() };
        let Some(trimmed) = trimmed(&frame, labels.iter().map(|label| label.slot as usize)) else {
            return Self { frame: Frame { columns: 0, rows: 0, ..frame }, costs: Vec::new(), inside, settled, cut: false };
        };
        let mut costs = vec![f32::INFINITY; trimmed.columns * trimmed.rows];
        for label in labels {
            let node = frame.node(label.slot as usize);
            let (i, j) = (node.column - trimmed.first.column, node.row - trimmed.first.row);
            costs[j as usize * trimmed.columns + i as usize] = label.cost;
        }
        let cut = trimmed.first.column == frame.first.column
            || trimmed.first.row == frame.first.row
            || trimmed.first.column + trimmed.columns as i64 == frame.first.column + frame.columns as i64
            || trimmed.first.row + trimmed.rows as i64 == frame.first.row + frame.rows as i64;
        Self { frame: trimmed, costs, inside, settled, cut }
    }

    /// Nodes that its search settled.
    pub(super) fn settled(&self) -> usize {
        self.settled
    }

    /// Tells the costs of the nodes that it shares with a frame, by their place in that, row by row from the south.
    pub(super) fn costs(&self, frame: &Frame, mut tell: impl FnMut(usize, f32)) {
        let (a, b) = (&self.frame, frame);
        let shared = |a: i64, n: usize, b: i64, m: usize| (a.max(b), (a + n as i64).min(b + m as i64));
        let (west, east) = shared(a.first.column, a.columns, b.first.column, b.columns);
        let (south, north) = shared(a.first.row, a.rows, b.first.row, b.rows);
        for row in south..north {
            let own = (row - a.first.row) as usize * a.columns;
            let other = (row - b.first.row) as usize * b.columns;
            for column in west..east {
                let cost = self.costs[own + (column - a.first.column) as usize];
                if cost < f32::INFINITY {
                    tell(other + (column - b.first.column) as usize, cost);
                }
            }
        }
    }

    /// Tells the nodes of a frame where it alone counts.
    pub(super) fn inside(&self, frame: &Frame, mut tell: impl FnMut(usize)) {
        for node in &self.inside {
            let (i, j) = (node.column - frame.first.column, node.row - frame.first.row);
            if (0..frame.columns as i64).contains(&i) && (0..frame.rows as i64).contains(&j) {
                tell(j as usize * frame.columns + i as usize);
            }
        }
    }
}

/// The least frame that holds slots of another.
fn trimmed(frame: &Frame, slots: impl Iterator<Item = usize>) -> Option<Frame> {
    let mut ends = [i64::MAX, i64::MAX, i64::MIN, i64::MIN];
    for slot in slots {
        let Node { row, column } = frame.node(slot);
        ends = [ends[0].min(column), ends[1].min(row), ends[2].max(column), ends[3].max(row)];
    }
    let [west, south, east, north] = ends;
    (west <= east).then(|| Frame { first: Node { row: south, column: west }, columns: (east - west + 1) as usize, rows: (north - south + 1) as usize })
}
