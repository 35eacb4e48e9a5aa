//! From a drawing's groups to strokes: their nodes and what each costs.

use super::{
    blend::{Stroke, approximate},
    canvas::{Canvas, Slots, circle},
    check::group_numbers,
    document::{Bands, Drawing, DrawingError, Group, Scatter, Shape},
    lattice::Weights,
    plan::MAX_STROKES,
    profile::{Crest, Scaling},
    profiles::{Profiles, profile_number},
    search::{Generator, Terrain},
};
use crate::noise;
use std::collections::BTreeMap;

/// Places that are tried for everything that is scattered.
const TRIES: u64 = 1000;

/// Most ranges of bands.
const MAX_RANGES: usize = 64;

/// A stroke as it was drawn.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Of which group.
    pub group: usize,
    /// The number of its profile.
    pub profile: u16,
    /// Costs of its nodes.
    pub nodes: BTreeMap<u32, f32>,
    /// Regions that count it though they shut out others, ascending.
    pub member_of: Vec<u16>,
}

impl Drawn {
    /// What searches start from: nodes below sea level, costs counted from `least`.
    pub(super) fn stroke(&self, sea_level_cost: f32, least: f32) -> Stroke {
        let below = self.nodes.iter().filter(|(_, cost)| **cost < sea_level_cost);
        let generators = below.map(|(slot, cost)| Generator {
            slot: *slot,
            profile: u32::from(self.profile),
            crest: Crest::new(cost - least, sea_level_cost - cost, sea_level_cost),
        });
        Stroke { generators: generators.collect(), member_of: self.member_of.clone() }
    }
}

/// The strokes of a drawing, group by group.
pub(super) fn draw(canvas: &Canvas, drawing: &Drawing, profiles: &Profiles, weights: &Weights) -> Result<Vec<Drawn>, DrawingError> {
    let mut drawn: Vec<Drawn> = Vec::new();
    for (number, group) in drawing.strokes.iter().enumerate() {
        let at = format!("/strokes/{number}");
        let numbers = group.profiles.iter().enumerate().map(|(i, name)| profile_number(profiles, name, &format!("{at}/profiles/{i}")));
        let numbers = numbers.collect::<Result<Vec<u16>, DrawingError>>()?;
        let parts = parts(canvas, drawing, group, &drawn, weights, &at)?;
        if drawn.len() + parts.len() > MAX_STROKES {
            return Err(DrawingError::new(at, format!("a drawing has at most {MAX_STROKES} strokes")));
        }
        let costs = canvas.quantity(&group.cost, &format!("{at}/cost"))?;
        for (i, part) in parts.into_iter().enumerate() {
            let profile = if numbers.is_empty() { 0 } else { numbers[i % numbers.len()] };
            let cost = |slot: u32| part.cost.unwrap_or(costs[slot as usize]);
            drawn.push(Drawn { group: number, profile, nodes: part.slots.iter().map(|slot| (*slot, cost(*slot))).collect(), member_of: Vec::new() });
        }
    }
    Ok(drawn)
}

struct Part {
    slots: Slots,
    /// In the place of the group's.
    cost: Option<f32>,
}

fn parts(canvas: &Canvas, drawing: &Drawing, group: &Group, before: &[Drawn], weights: &Weights, at: &str) -> Result<Vec<Part>, DrawingError> {
    let at = |field: &str| format!("{at}/shape/{field}");
    let slots = match &group.shape {
        Shape::Geometry(geometry) => canvas.parts(geometry, true, &at("geometry"))?,
        Shape::Outline(geometry) => canvas.parts(geometry, false, &at("outline"))?,
        Shape::Circles(circles) => {
            let at = at("circles");
            circles.iter().enumerate().map(|(i, circle)| canvas.circle(*circle, &format!("{at}/{i}"))).collect::<Result<_, _>>()?
        }
        Shape::Scatter(scatter) => scattered(canvas, drawing, scatter, before, &at("scatter"))?,
        Shape::Edges(picture) => canvas.components(canvas.edges(&canvas.greys(picture, &at("edges"))?)),
        Shape::Sketch(sketch) => canvas.components(canvas.coloured(&sketch.picture, &sketch.colour, &at("sketch"))?),
        Shape::Bands(bands) => return banded(canvas, bands, weights, &at("bands")),
    };
    Ok(slots.into_iter().filter(|slots| !slots.is_empty()).map(|slots| Part { slots, cost: None }).collect())
}

/// Nodes or circles in places by chance.
fn scattered(canvas: &Canvas, drawing: &Drawing, scatter: &Scatter, before: &[Drawn], at: &str) -> Result<Vec<Slots>, DrawingError> {
    if scatter.count > MAX_STROKES {
        return Err(DrawingError::new(format!("{at}/count"), format!("must be at most {MAX_STROKES}, got {}", scatter.count)));
    }
    let within = scatter.within.as_ref().map(|geometry| canvas.covered(geometry, &format!("{at}/within"))).transpose()?;
    let mut away: Vec<(Vec<f64>, f64)> = Vec::new();
    for (name, distance) in &scatter.away {
        let groups = group_numbers(drawing, core::slice::from_ref(name), &format!("{at}/away"))?;
        let slots = before.iter().filter(|drawn| groups.contains(&drawn.group)).flat_map(|drawn| drawn.nodes.keys().copied());
        let nodes = distance / canvas.spacing;
        away.push((canvas.squared_distances(&slots.collect()), nodes * nodes));
    }
    let fits = |slot: u32| within.as_ref().is_none_or(|within| within.contains(&slot)) && away.iter().all(|(squares, least)| squares[slot as usize] >= *least);
    // What is added to a drawing must not move what was scattered before.
    let key = noise::key(noise::key(canvas.seed, 2), before.last().map_or(0, |drawn| drawn.group as u64 + 1));
    let mut parts = Vec::new();
    for number in 0..scatter.count as u64 {
        let own = noise::key(key, number);
        let Some(slot) = (0..TRIES).map(|n| canvas.by_chance(own, n)).find(|slot| fits(*slot)) else {
            return Err(DrawingError::new(at, format!("there is no room for number {number}: {TRIES} places were tried")));
        };
        parts.push(match scatter.radius {
            None => Slots::from([slot]),
            Some([least, greatest]) => {
                let share = (noise::key(own, TRIES) >> 11) as f64 / (1_u64 << 53) as f64;
                let node = canvas.frame.node(slot as usize);
                let centre = [node.column, node.row].map(|i| i as f64 * canvas.spacing);
                canvas.line(&circle(centre, least + (greatest - least) * share), at)?
            }
        });
    }
    Ok(parts)
}

/// Nodes by the cost of their path from a line, without profile.
fn banded(canvas: &Canvas, bands: &Bands, weights: &Weights, at: &str) -> Result<Vec<Part>, DrawingError> {
    if bands.ranges.len() > MAX_RANGES {
        return Err(DrawingError::new(format!("{at}/ranges"), format!("must be at most {MAX_RANGES} ranges, got {}", bands.ranges.len())));
    }
    let from = canvas.covered(&bands.from, &format!("{at}/from"))?;
    // Farther than any path across the drawing.
    let most = (canvas.inner.columns + canvas.inner.rows) as f32 * 4.0 * weights.greatest();
    let crest = Crest::new(0.0, most, most);
    let generators: Vec<Generator> = from.iter().map(|slot| Generator { slot: *slot, profile: 0, crest }).collect();
    let scalings = [Scaling::none()];
    let terrain = Terrain { weights, profiles: &scalings, regions: &[] };
    let costs: Vec<f32> = approximate(&terrain, &generators, most).into_iter().map(|height| most - height).collect();
    let inner = || canvas.drawn_on().flatten();
    let unit = if bands.shares { inner().map(|slot| costs[slot]).fold(0.0, f32::max) } else { 1.0 };
    let mut parts = Vec::new();
    for (i, [low, high]) in bands.ranges.iter().enumerate() {
        let [low, high] = [low, high].map(|end| *end as f32 * unit);
        let slots: Slots = inner().filter(|slot| costs[*slot] > low && costs[*slot] <= high).map(|slot| slot as u32).collect();
        parts.push(Part { slots, cost: bands.costs.get(i).map(|cost| *cost as f32) });
    }
    parts.retain(|part| !part.slots.is_empty());
    Ok(parts)
}
