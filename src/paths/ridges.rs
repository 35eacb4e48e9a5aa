//! Ridges: least-cost paths from random nodes back to the strokes they grow from.

use super::{
    canvas::Canvas,
    check::group_numbers,
    document::{Drawing, DrawingError},
    search::{Generator, Search, Terrain, limits},
    stroke::Drawn,
};
use crate::noise;
use std::collections::BTreeMap;

/// Most ridges of a rule.
const MAX_RIDGES: usize = 10_000;

/// Nodes that are tried for every ridge.
const TRIES: u64 = 1000;

/// Grows the ridges of a drawing, rule by rule; nodes that they walk over join the stroke they come from.
pub(super) fn grow(canvas: &Canvas, drawing: &Drawing, terrain: &Terrain, sea_level_cost: f64, drawn: &mut [Drawn]) -> Result<(), DrawingError> {
    for (number, rule) in drawing.ridges.iter().enumerate() {
        let at = format!("/ridges/{number}");
        if !(0.0..=1.0).contains(&rule.share) {
            return Err(DrawingError::new(format!("{at}/share"), format!("must be 0 … 1, got {}", rule.share)));
        }
        if rule.count > MAX_RIDGES {
            return Err(DrawingError::new(format!("{at}/count"), format!("must be at most {MAX_RIDGES}, got {}", rule.count)));
        }
        let groups = group_numbers(drawing, &rule.of, &format!("{at}/of"))?;
        let chosen: Vec<usize> = (0..drawn.len()).filter(|i| groups.is_empty() || groups.contains(&drawn[*i].group)).collect();
        let grown = Grown::new(terrain, sea_level_cost as f32, drawn, &chosen);
        let near = rule.within.map(|within| {
            let nodes = within / canvas.spacing;
            (canvas.squared_distances(&chosen.iter().flat_map(|i| drawn[*i].nodes.keys().copied()).collect()), nodes * nodes)
        });
        let mut taken: BTreeMap<u32, usize> = chosen.iter().rev().flat_map(|i| drawn[*i].nodes.keys().map(|slot| (*slot, *i))).collect();
        let key = noise::key(noise::key(canvas.seed, 3), number as u64);
        for ridge in 0..rule.count as u64 {
            let own = noise::key(key, ridge);
            let fits = |slot: u32| {
                let is_near = near.as_ref().is_none_or(|(squares, most)| squares[slot as usize] <= *most);
                is_near && grown.reaches(slot) && !taken.contains_key(&slot)
            };
            let Some(start) = (0..TRIES).map(|n| canvas.by_chance(own, n)).find(|slot| fits(*slot)) else {
                return Err(DrawingError::new(at, format!("there is no node left for ridge {ridge} to begin at: {TRIES} were tried")));
            };
            for (slot, cost, stroke) in grown.walk(start) {
                if let std::collections::btree_map::Entry::Vacant(free) = taken.entry(slot) {
                    free.insert(stroke);
                    drawn[stroke].nodes.insert(slot, cost * rule.share as f32);
                }
            }
        }
    }
    Ok(())
}

/// A search from the strokes that ridges grow from.
struct Grown<'a> {
    terrain: &'a Terrain<'a>,
    search: Search,
    generators: Vec<Generator>,
    /// Which stroke each generator belongs to.
    strokes: Vec<usize>,
    /// What costs are counted from.
    least: f32,
}

impl<'a> Grown<'a> {
    fn new(terrain: &'a Terrain, sea_level_cost: f32, drawn: &[Drawn], chosen: &[usize]) -> Self {
        let least = chosen.iter().flat_map(|i| drawn[*i].nodes.values()).copied().fold(0.0, f32::min);
        let mut seeds: Vec<(Generator, usize)> =
            chosen.iter().flat_map(|i| drawn[*i].stroke(sea_level_cost, least).generators.into_iter().map(|generator| (generator, *i))).collect();
        seeds.sort_by_key(|(generator, stroke)| (generator.slot, *stroke));
        let (generators, strokes): (Vec<Generator>, Vec<usize>) = seeds.into_iter().unzip();
        let mut search = Search::new(terrain, limits(&terrain.weights.frame, |_| sea_level_cost - least));
        search.run(terrain, &generators, sea_level_cost - least);
        Self { terrain, search, generators, strokes, least }
    }

    fn reaches(&self, slot: u32) -> bool {
        self.search.label(slot).is_some()
    }

    /// The nodes of the path that leads to a slot, from there back to its generator, which is left out: slot, cost, stroke.
    fn walk(&self, start: u32) -> Vec<(u32, f32, usize)> {
        let mut walked = Vec::new();
        let mut at = start;
        while let Some((cost, origin)) = self.search.label(at) {
            if self.generators[origin as usize].slot == at {
                break;
            }
            walked.push((at, cost + self.least, self.strokes[origin as usize]));
            let Some(before) = self.search.before(self.terrain, &self.generators, at) else { break };
            at = before;
        }
        walked
    }
}
