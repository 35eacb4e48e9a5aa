//! Endless drawings as users write them.

use super::{
    Mesh,
    place::{Rule, Shape},
};
use crate::{
    noise,
    paths::{
        MAX_REACH,
        check::range,
        document::{DrawingError, Inside, Quantity, WrittenProfile, one, usual_approximate_threshold, usual_least_scale},
        lattice::Diagonal,
        profile::{Crest, Scaling},
        profiles::{profile_number, profiles, scalings},
    },
    programme::{Programme, Tape},
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Most strokes a cell.
const MAX_STROKES: f64 = 64.0;

/// Strokes without end: every cell of the plane has some of its own. Lengths and costs are metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndlessDrawing {
    /// Metres between nodes of the finest lattice.
    pub spacing: f64,
    /// Metres along a cell's side.
    pub cell: f64,
    /// What weights, places and costs are drawn from, with the world's.
    #[serde(default)]
    pub seed: u64,
    /// Mean weight of edges, costs a metre; with a profile it only says how much the deviation counts.
    #[serde(default = "usual_mean")]
    pub mean: f64,
    /// Most deviation of a weight, less than the mean.
    #[serde(default = "usual_deviation")]
    pub deviation: f64,
    /// How long diagonal steps are.
    #[serde(default)]
    pub diagonal: Diagonal,
    /// The cost of sea level: a crest of cost c stands this less c above what is beneath.
    pub sea_level_cost: f64,
    /// How much the higher of two strokes counts.
    #[serde(default = "usual_bias")]
    pub bias: f64,
    /// A stroke ends where it is no higher than this.
    #[serde(default = "usual_sea_threshold")]
    pub sea_threshold: f64,
    /// A stroke fades where it is no higher than this share of the highest.
    #[serde(default = "usual_approximate_threshold")]
    pub approximate_threshold: f64,
    /// Scales of weights below this are filled from those around.
    #[serde(default = "usual_least_scale")]
    pub least_scale: f64,
    /// Metres a unit of cost.
    #[serde(default = "one")]
    pub vertical_scale: f64,
    /// Profiles by name.
    #[serde(default)]
    pub profiles: BTreeMap<String, WrittenProfile>,
    /// What every cell has.
    pub strokes: Vec<CellStrokes>,
}

fn usual_mean() -> f64 {
    1.0
}

fn usual_deviation() -> f64 {
    0.6
}

fn usual_bias() -> f64 {
    4.0
}

fn usual_sea_threshold() -> f64 {
    2.0
}

/// Strokes of a cell that share profiles and costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CellStrokes {
    /// Mountain chains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chains: Option<Chains>,
    /// Rings such as those of craters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rings: Option<Rings>,
    /// The names of profiles, one of them by chance a stroke.
    pub profiles: Vec<String>,
    /// The cost of a node. `between` maps the least and the greatest value that a programme can have.
    pub cost: Quantity,
    /// What rules inside rings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inside: Option<Inside>,
}

/// Mountain chains: wandering lines with spurs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chains {
    /// Least and most a cell.
    pub count: [u32; 2],
    /// Metres, least and greatest.
    pub length: [f64; 2],
    /// How far a chain turns, 0 … 1.
    #[serde(default = "usual_wander")]
    pub wander: f64,
    /// Spurs a chain, each up to a third as long.
    #[serde(default)]
    pub spurs: u32,
}

fn usual_wander() -> f64 {
    0.4
}

/// Rings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rings {
    /// Least and most a cell.
    pub count: [u32; 2],
    /// Metres, least and greatest; small ones are more frequent.
    pub radius: [f64; 2],
}

impl EndlessDrawing {
    pub(super) fn check(&self) -> Result<(), DrawingError> {
        range("/spacing", self.spacing, 1e-3..=1e6)?;
        range("/cell", self.cell, 16.0 * self.spacing..=1e9)?;
        range("/mean", self.mean, 1e-6..=1e6)?;
        if !(0.0..self.mean).contains(&self.deviation) {
            return Err(DrawingError::new("/deviation", format!("must be 0 up to less than the mean {}, got {}", self.mean, self.deviation)));
        }
        range("/sea_level_cost", self.sea_level_cost, 1e-3..=1e6)?;
        range("/bias", self.bias, 0.0..=1000.0)?;
        range("/sea_threshold", self.sea_threshold, 1e-6..=self.sea_level_cost / 2.0)?;
        range("/approximate_threshold", self.approximate_threshold, 0.0..=0.5)?;
        range("/least_scale", self.least_scale, 1e-6..=1.0)?;
        range("/vertical_scale", self.vertical_scale, 1e-6..=1e6)
    }

    /// What every cell has, checked.
    pub(super) fn rules(&self) -> Result<Vec<Rule>, DrawingError> {
        let profiles = profiles(&self.profiles, [self.spacing; 2], self.least_scale)?;
        let mut rules = Vec::new();
        for (number, strokes) in self.strokes.iter().enumerate() {
            let at = format!("/strokes/{number}");
            let shape = match (&strokes.chains, &strokes.rings) {
                (Some(chains), None) => self.chains(chains, &format!("{at}/chains"))?,
                (None, Some(rings)) => self.rings(rings, &format!("{at}/rings"))?,
                _ => return Err(DrawingError::new(at, "strokes are either chains or rings")),
            };
            let numbers = strokes.profiles.iter().enumerate().map(|(i, name)| profile_number(&profiles, name, &format!("{at}/profiles/{i}")));
            let numbers = numbers.collect::<Result<Vec<u16>, _>>()?;
            let inside = strokes.inside.as_ref().map(|inside| profile_number(&profiles, &inside.profile, &format!("{at}/inside/profile"))).transpose()?;
            rules.push(self.rule(strokes, shape, numbers, inside, &at)?);
        }
        let expected: f64 = rules.iter().map(Rule::expected).sum();
        if rules.is_empty() || expected > MAX_STROKES {
            return Err(DrawingError::new("/strokes", format!("must be up to {MAX_STROKES} strokes a cell, and some, got {expected} on average")));
        }
        Ok(rules)
    }

    fn rule(&self, strokes: &CellStrokes, shape: Shape, profiles: Vec<u16>, inside: Option<u16>, at: &str) -> Result<Rule, DrawingError> {
        let at = format!("{at}/cost");
        let (tape, frame, line, costs) = match &strokes.cost {
            Quantity::Number(cost) => (None, None, [0.0, *cost], [*cost; 2]),
            Quantity::Programme(ramp) => {
                let wrong = |field: &str, detail: String| DrawingError::new(format!("{at}/{field}"), detail);
                let programme = Programme::parse(&ramp.programme).map_err(|error| wrong("programme", error.to_string()))?;
                programme.check_cost().map_err(|error| wrong("programme", error.to_string()))?;
                range(&format!("{at}/scale"), ramp.scale, 1e-3..=1e12)?;
                let tape = Tape::compile(programme.root());
                let [low, high] = tape.range();
                let between = ramp.between.unwrap_or([low, high]);
                if !(low.is_finite() && high.is_finite() && low < high) {
                    return Err(wrong("programme", "must have a least and a greatest value that differ".to_owned()));
                }
                let slope = (between[1] - between[0]) / (high - low);
                let frame = crate::programme::Frame { seed: noise::key(self.seed, ramp.seed), scale: ramp.scale, origin: ramp.origin };
                (Some(tape), Some(frame), [slope, between[0] - slope * low], [between[0].min(between[1]), between[0].max(between[1])])
            }
        };
        for cost in costs {
            range(&at, cost, 0.0..=self.sea_level_cost)?;
        }
        Ok(Rule {
            shape,
            profiles,
            inside,
            only: strokes.inside.as_ref().is_some_and(|inside| inside.only),
            tape,
            frame,
            line: line.map(|c| c as f32),
            costs: costs.map(|c| c as f32),
        })
    }

    fn chains(&self, chains: &Chains, at: &str) -> Result<Shape, DrawingError> {
        check_count(chains.count, at)?;
        range(&format!("{at}/length/0"), chains.length[0], self.spacing..=self.cell)?;
        range(&format!("{at}/length/1"), chains.length[1], chains.length[0]..=self.cell)?;
        range(&format!("{at}/wander"), chains.wander, 0.0..=1.0)?;
        if chains.spurs > 64 {
            return Err(DrawingError::new(format!("{at}/spurs"), format!("must be at most 64, got {}", chains.spurs)));
        }
        Ok(Shape::Chains(chains.clone()))
    }

    fn rings(&self, rings: &Rings, at: &str) -> Result<Shape, DrawingError> {
        check_count(rings.count, at)?;
        range(&format!("{at}/radius/0"), rings.radius[0], self.spacing..=self.cell)?;
        range(&format!("{at}/radius/1"), rings.radius[1], rings.radius[0]..=self.cell)?;
        Ok(Shape::Rings(rings.clone()))
    }

    /// Its lattices, from the finest to one on which a cell is a few nodes.
    pub(super) fn meshes(&self, rules: &[Rule]) -> Result<Vec<Mesh>, DrawingError> {
        let mut meshes = Vec::new();
        let mut spacing = self.spacing;
        loop {
            let profiles = profiles(&self.profiles, [self.spacing, spacing], self.least_scale)?;
            let [mean, deviation] = [self.mean, self.deviation].map(|slope| (slope * spacing) as f32);
            let scalings = scalings(&profiles, self.sea_level_cost, f64::from(mean), self.least_scale);
            let own = |rule: &Rule| if rule.profiles.is_empty() { vec![0] } else { rule.profiles.clone() };
            let used: Vec<u16> = rules.iter().flat_map(|rule| own(rule).into_iter().chain(rule.inside)).collect();
            let least = rules.iter().map(|rule| rule.costs[0]).fold(f32::INFINITY, f32::min);
            let reach = self.reach(&scalings, &used, least, mean - deviation);
            if reach > MAX_REACH {
                let detail = format!("paths may reach more than {MAX_REACH} nodes: make profiles less wide, the deviation less or the spacing greater");
                return Err(DrawingError::new("/profiles", detail));
            }
            let key = noise::key(noise::key(self.seed, 1), meshes.len() as u64);
            meshes.push(Mesh { spacing, mean, deviation, key, scalings, reach });
            // On lattices much coarser a flank is a few nodes, and crests are as broad as those are apart.
            spacing *= 2.0;
            if spacing > self.cell * super::CONSTANT[1] / 8.0 {
                return Ok(meshes);
            }
        }
    }

    /// The most steps that a path takes from a crest of the least cost before strokes end.
    fn reach(&self, scalings: &[Scaling], used: &[u16], least: f32, weight: f32) -> usize {
        let sea_level_cost = self.sea_level_cost as f32;
        let crest = Crest::new(least, sea_level_cost - least, sea_level_cost);
        let end = sea_level_cost - self.sea_threshold as f32;
        let after = |cost: f32| {
            let costs = used.iter().map(|number| scalings[usize::from(*number)].after(cost, &crest, &[weight; 8])[0]);
            costs.fold(f32::INFINITY, f32::min)
        };
        let costs = core::iter::successors(Some(least), |cost| Some(after(*cost)));
        costs.skip(1).take_while(|cost| *cost < end).take(MAX_REACH + 1).count()
    }
}

fn check_count(count: [u32; 2], at: &str) -> Result<(), DrawingError> {
    if count[0] > count[1] {
        Err(DrawingError::new(format!("{at}/count"), format!("must be the least and the most, got {} and {}", count[0], count[1])))
    } else {
        Ok(())
    }
}
