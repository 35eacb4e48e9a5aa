//! What an adaptive terrain is, and what it was told: plain data that it follows from.

use crate::{
    evolve::record::RecordError,
    geometry::{PLANE_LIMIT, Rectangle},
};
use serde::{Deserialize, Serialize};

/// What follows from a history: it goes up when the same one would give other heights.
pub const HISTORY_FORM: u32 = 1;

/// Most nodes of the lattice of heights.
pub const MAX_LATTICE: usize = 1 << 20;

/// Most nodes of all trees together.
pub const MAX_TREES: usize = 1 << 22;

/// Most generations.
pub const MAX_HISTORY: usize = 10_000;

/// Most positions of a feedback's ways together.
pub const MAX_POSITIONS: usize = 1 << 16;

/// An adaptive terrain before anybody was there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Hashed into every draw; 0 … 2^53 - 1.
    pub seed: u64,
    /// Plane metres of its south-western corner.
    pub origin: [f64; 2],
    /// Metres between the nodes of its lattice.
    pub cell: f64,
    /// Populations from west to east.
    pub populations: usize,
    /// Lines of a population from west to east: individuals.
    pub lines: usize,
    /// Heights of a line from south to north.
    pub length: usize,
    /// Passes of midpoint displacement: lines are 2^passes cells apart.
    pub passes: u32,
    /// Mean height M in metres, which does not change.
    pub mean: f64,
    /// Deviation S of the first generation in metres.
    pub deviation: f64,
    /// Least and greatest height in metres.
    pub range: [f64; 2],
    /// Nodes on the longest way in a tree.
    pub levels: usize,
    /// Most nodes of a tree.
    pub nodes: usize,
    /// Share of the lines that children take the place of.
    pub crossover: f64,
    /// Share of the others that mutate.
    pub mutation: f64,
    /// Share of the lines, at least one, that are made unlike the rest, in turn.
    pub unlike: f64,
    /// Lines that neither mutate nor are made unlike, the fittest.
    pub elite: usize,
    /// Generations between two exchanges of neighbouring populations; 0 for none.
    pub exchange: usize,
    /// Metres around players, and around their ways, in which nothing changes.
    pub promise: f64,
    /// Cells over which what may change fades into what may not.
    pub fade: usize,
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            seed: 0,
            origin: [0.0; 2],
            cell: 10.0,
            populations: 1,
            lines: 33,
            length: 33,
            passes: 2,
            mean: 100.0,
            deviation: 40.0,
            range: [0.0, 200.0],
            levels: 10,
            nodes: 128,
            crossover: 0.3,
            mutation: 0.1,
            unlike: 0.05,
            elite: 2,
            exchange: 5,
            promise: 50.0,
            fade: 6,
        }
    }
}

impl Ground {
    /// Lines of all populations, and heights of each.
    #[must_use]
    pub fn coarse_size(&self) -> [usize; 2] {
        [self.populations * self.lines, self.length]
    }

    /// Nodes of the lattice from west to east and from south to north.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.coarse_size().map(|n| ((n - 1) << self.passes) + 1)
    }

    /// The area of its nodes.
    #[must_use]
    pub fn area(&self) -> Rectangle {
        let [width, height] = self.size().map(|count| (count - 1) as f64 * self.cell);
        Rectangle { min: self.origin, max: [self.origin[0] + width, self.origin[1] + height] }
    }

    /// Holds the numbers to their ranges.
    ///
    /// # Errors
    /// If one lies outside; the error names it below `at`.
    pub fn check(&self, at: &str) -> Result<(), RecordError> {
        let whole = |name: &str, value: usize, [least, most]: [usize; 2]| {
            let wrong = || RecordError::new(format!("{at}/{name}"), format!("must be {least} … {most}, got {value}"));
            if (least..=most).contains(&value) { Ok(()) } else { Err(wrong()) }
        };
        let real = |name: &str, value: f64, [least, most]: [f64; 2]| {
            let wrong = || RecordError::new(format!("{at}/{name}"), format!("must be {least} … {most}, got {value}"));
            if (least..=most).contains(&value) { Ok(()) } else { Err(wrong()) }
        };
        if self.seed > crate::evolve::MAX_SEED {
            return Err(RecordError::new(format!("{at}/seed"), format!("must be 0 … {}, got {}", crate::evolve::MAX_SEED, self.seed)));
        }
        real("origin/0", self.origin[0], [-PLANE_LIMIT, PLANE_LIMIT])?;
        real("origin/1", self.origin[1], [-PLANE_LIMIT, PLANE_LIMIT])?;
        real("cell", self.cell, [0.01, 1e6])?;
        whole("populations", self.populations, [1, 64])?;
        whole("lines", self.lines, [4, 1025])?;
        whole("length", self.length, [4, 1025])?;
        whole("passes", self.passes as usize, [0, 6])?;
        let [columns, rows] = self.size();
        if columns * rows > MAX_LATTICE {
            return Err(RecordError::new(at, format!("lines, length and passes make {columns} × {rows} nodes, more than {MAX_LATTICE} together")));
        }
        real("range/0", self.range[0], [-1e5, 1e5])?;
        real("range/1", self.range[1], [self.range[0] + 0.01, 1e5])?;
        real("mean", self.mean, self.range)?;
        real("deviation", self.deviation, [0.0, self.range[1] - self.range[0]])?;
        whole("levels", self.levels, [2, 32])?;
        whole("nodes", self.nodes, [3, 4096])?;
        let trees = self.populations * self.lines * self.nodes;
        if trees > MAX_TREES {
            return Err(RecordError::new(
                format!("{at}/nodes"),
                format!("lines, populations and nodes allow trees of {trees} nodes, more than {MAX_TREES} together"),
            ));
        }
        real("crossover", self.crossover, [0.0, 0.5])?;
        real("mutation", self.mutation, [0.0, 1.0])?;
        real("unlike", self.unlike, [0.0, 0.25])?;
        whole("elite", self.elite, [0, self.lines / 2])?;
        whole("exchange", self.exchange, [0, MAX_HISTORY])?;
        real("promise", self.promise, [0.0, 1e6])?;
        whole("fade", self.fade, [0, 1024])
    }
}

/// What somebody said of a terrain by being there: more of this.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Feedback {
    /// Plane metres of points of the terrain, whose heights are meant.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 2]>,
    /// Heights in metres.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub heights: Vec<f64>,
    /// Metres around the points in which the terrain changes; everywhere without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Where players have been since the last generation, each way ending where one is: around it nothing changes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ways: Vec<Vec<[f64; 2]>>,
    /// Metres that the ways may be off: so much farther than promised nothing changes around them.
    #[serde(skip_serializing_if = "is_zero")]
    pub margin: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "what serde asks for")]
fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

impl Feedback {
    /// A click on the terrain.
    #[must_use]
    pub fn point(point: [f64; 2]) -> Self {
        Self { points: vec![point], ..Self::default() }
    }

    /// A height that is wanted.
    #[must_use]
    pub fn height(height: f64) -> Self {
        Self { heights: vec![height], ..Self::default() }
    }

    pub(super) fn check(&self, ground: &Ground, at: &str) -> Result<(), RecordError> {
        if !(1..=100).contains(&(self.points.len() + self.heights.len())) {
            return Err(RecordError::new(at, "must hold 1 to 100 points and heights together"));
        }
        let [low, high] = ground.range;
        if let Some(i) = self.heights.iter().position(|height| !(low..=high).contains(height)) {
            return Err(RecordError::new(format!("{at}/heights/{i}"), format!("must be {low} … {high}, the range of the terrain, got {}", self.heights[i])));
        }
        if let Some(radius) = self.radius {
            if !(radius.is_finite() && radius > 0.0) {
                return Err(RecordError::new(format!("{at}/radius"), format!("must be a positive number of metres, got {radius}")));
            }
            if self.points.is_empty() {
                return Err(RecordError::new(format!("{at}/points"), "must hold a point: a radius is a radius around points"));
            }
        }
        if self.ways.iter().map(Vec::len).sum::<usize>() > MAX_POSITIONS {
            return Err(RecordError::new(format!("{at}/ways"), format!("must hold at most {MAX_POSITIONS} positions")));
        }
        if !(0.0..=4.0 * PLANE_LIMIT).contains(&self.margin) {
            return Err(RecordError::new(format!("{at}/margin"), format!("must be 0 … 2^42 metres, got {}", self.margin)));
        }
        let is_wrong = |point: &[f64; 2]| point.iter().any(|c| c.is_nan() || c.abs() > PLANE_LIMIT);
        match self.ways.iter().enumerate().find_map(|(i, way)| way.iter().position(is_wrong).map(|j| (i, j))) {
            Some((i, j)) => Err(RecordError::new(format!("{at}/ways/{i}/{j}"), "must be plane metres within 2^40 of the origin")),
            None => Ok(()),
        }
    }
}

/// A generation that was bred.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// The generation it was bred from.
    pub from: usize,
    /// By what.
    pub feedback: Feedback,
}

/// All that an adaptive terrain and its generations follow from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct History {
    /// [`HISTORY_FORM`].
    pub form: u32,
    /// How it began: generation 0.
    #[serde(default)]
    pub ground: Ground,
    /// How generation n + 1 was bred.
    #[serde(default)]
    pub steps: Vec<Step>,
    /// The generation that is shown, and bred from next.
    #[serde(default)]
    pub current: usize,
}

impl History {
    /// Reads a history.
    ///
    /// # Errors
    /// If it is not one; the error names the place.
    pub fn parse(json: &[u8]) -> Result<Self, RecordError> {
        let history: Self =
            serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(json)).map_err(|error| crate::evolve::record::place(&error))?;
        history.check()?;
        Ok(history)
    }

    pub(super) fn check(&self) -> Result<(), RecordError> {
        if self.form != HISTORY_FORM {
            return Err(RecordError::new("/form", format!("must be {HISTORY_FORM}, the form that this version reads, got {}", self.form)));
        }
        self.ground.check("/ground")?;
        if self.steps.len() > MAX_HISTORY {
            return Err(RecordError::new("/steps", format!("must be at most {MAX_HISTORY}, got {}", self.steps.len())));
        }
        for (i, step) in self.steps.iter().enumerate() {
            if step.from > i {
                return Err(RecordError::new(format!("/steps/{i}/from"), format!("must be 0 … {i}, a generation before, got {}", step.from)));
            }
            step.feedback.check(&self.ground, &format!("/steps/{i}/feedback"))?;
        }
        if self.current > self.steps.len() {
            return Err(RecordError::new("/current", format!("must be 0 … {}, got {}", self.steps.len(), self.current)));
        }
        Ok(())
    }
}
