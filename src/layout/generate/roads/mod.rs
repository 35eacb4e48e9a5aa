//! Roads between places: least-cost paths over finished terrain that keep to a grade, cut and fill.
//!
//! The terrain is sampled on a lattice ([`lattice`]). Paths over it choose at every point how far the road lies above or below the ground, so that its own slope, not
//! the ground's, is what is limited ([`search`]; cost functions after E. Galin, A. Peytavie, N. Maréchal, E. Guérin 2010, "Procedural generation of roads"). Which
//! places are joined is decided over all of them at once ([`network`]), and the courses found are smoothed, graded and bridged ([`course`]).

mod course;
mod lattice;
mod network;
mod search;

use super::{
    error::{GenerateError, check},
    plane::{bounds, distance},
};
use crate::{
    geometry::{PLANE_LIMIT, Source, Window},
    layout::{Attribute, AttributeError, AttributeSet, Value, Weight},
};
use course::Courses;
use lattice::Lattice;
use search::Terms;
use serde::{Deserialize, Serialize};

/// How roads are built.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Roads {
    /// The width of the road, which is level across, 1 … 100 m.
    pub width: f64,
    /// Metres on either side over which cuttings and embankments come back to the terrain, 0.5 … 1,000.
    pub shoulder: f64,
    /// The greatest slope along the road, 0.005 … 1 metres a metre.
    pub grade: f64,
    /// How deep the search may cut or fill at the points of its lattice, 0 … 100 m; between them up to twice as much and a metre.
    pub earthwork: f64,
    /// The longest bridge, from one abutment to the other, 0 … 10,000 m; 0 for none.
    pub bridge: f64,
    /// Metres that bridges keep above the water where grades allow, 0 … 100.
    pub clearance: f64,
    /// Places that are neighbours also get a road of their own if the way over others costs more than this many times the direct one, 1 … 1000.
    pub detour: f64,
    /// Metres between the points of the search's lattice, 1 … 1,000; as fits the area where it is not given.
    pub spacing: Option<f64>,
    /// Metres round the places that roads may use, 0 … 1,000,000; a quarter of the places' extent where it is not given.
    pub margin: Option<f64>,
    /// What the road is made of; nothing if it is empty.
    pub material: String,
}

impl Default for Roads {
    fn default() -> Self {
        Roads {
            width: 6.0,
            shoulder: 12.0,
            grade: 0.08,
            earthwork: 4.0,
            bridge: 120.0,
            clearance: 2.0,
            detour: 2.0,
            spacing: None,
            margin: None,
            material: "gravel".to_owned(),
        }
    }
}

/// A place that roads join.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name, for errors and for the names of roads.
    pub name: String,
    /// Where it is, in metres.
    pub at: [f64; 2],
}

/// A piece of road between places, forks and bridges, or a bridge.
#[derive(Clone, Debug, PartialEq)]
pub struct Road {
    /// Vertices with the elevation of the road.
    pub line: Vec<[f64; 3]>,
    /// Whether it is a bridge, which leaves the terrain beneath it as it is.
    pub is_bridge: bool,
    /// Which pairs of places it joins, by their numbers.
    pub routes: Vec<[usize; 2]>,
    /// Metres along it, in the plane.
    pub length: f64,
    /// Its greatest slope.
    pub grade: f64,
    /// Metres that it lies below the ground of its middle line at most; 0 for bridges.
    pub cut: f64,
    /// Metres that it lies above the ground of its middle line at most, bridges above the surface of the water.
    pub fill: f64,
}

/// Places at most.
const MOST_PLACES: usize = 64;
/// Points of a lattice at most, and where no spacing is given.
const MOST_POINTS: f64 = 131_072.0;
const USUAL_POINTS: f64 = 40_000.0;
/// Vertices of all roads at most.
const MOST_VERTICES: usize = 60_000;

/// What is wrong with roads, said of one parameter or place.
fn wrong(place: impl Into<String>, reason: impl Into<String>) -> GenerateError {
    GenerateError::Unfit { place: format!("roads.{}", place.into()), reason: reason.into() }
}

impl Roads {
    fn check(&self) -> Result<(), GenerateError> {
        check("roads.width", self.width, 1.0..=100.0)?;
        check("roads.shoulder", self.shoulder, 0.5..=1000.0)?;
        check("roads.grade", self.grade, 0.005..=1.0)?;
        check("roads.earthwork", self.earthwork, 0.0..=100.0)?;
        check("roads.bridge", self.bridge, 0.0..=10_000.0)?;
        check("roads.clearance", self.clearance, 0.0..=100.0)?;
        check("roads.detour", self.detour, 1.0..=1000.0)?;
        check("roads.spacing", self.spacing.unwrap_or(1.0), 1.0..=1000.0)?;
        check("roads.margin", self.margin.unwrap_or(0.0), 0.0..=1e6)
    }

    /// Metres from the middle line that the road changes the terrain.
    fn reach(&self) -> f64 {
        0.5 * self.width + self.shoulder
    }

    /// How far the ground between points of the lattice may be from the road.
    fn deepest(&self) -> f64 {
        2.0 * self.earthwork + 1.0
    }

    /// Metres between vertices at most, on a lattice of a spacing.
    fn step(&self, spacing: f64) -> f64 {
        self.width.max(4.0).min(spacing / 3.0)
    }

    /// Metres before and behind water that belong to a bridge: the road's end is round, and half a sample of water may lie before the first that sees it.
    fn approach(&self, spacing: f64) -> f64 {
        self.reach() + 2.5 * self.step(spacing)
    }

    /// The attributes of roads: level across the width, coming back to the terrain over the shoulder, above rivers and lakes of the same layer, and made of the
    /// material.
    ///
    /// # Errors
    /// If the width, the shoulder or the material is not what it may be.
    pub fn attributes(&self) -> Result<AttributeSet, AttributeError> {
        let bed = Attribute::new("elevation", Value::Shape, Weight::Smooth { width: 0.5 * self.shoulder }, self.shoulder);
        let mut attributes = vec![bed.as_channel(0.5 * self.width).with_priority(200)];
        if !self.material.is_empty() {
            let heavy = Weight::Sharp { width: 100.0 * self.width, nearest: 0.001 };
            attributes.push(Attribute::material(&self.material, heavy, 0.5 * self.width));
        }
        AttributeSet::new(attributes)
    }

    /// The samples of the terrain that the search goes over.
    ///
    /// # Errors
    /// A parameter outside its range, or places too far apart for the spacing.
    pub fn window(&self, places: &[Place]) -> Result<Window, GenerateError> {
        self.check()?;
        if !(2..=MOST_PLACES).contains(&places.len()) {
            return Err(wrong("places", format!("must be 2 to {MOST_PLACES} places, got {}", places.len())));
        }
        for (i, place) in places.iter().enumerate() {
            if !place.at.iter().all(|c| c.abs() <= PLANE_LIMIT / 2.0) {
                return Err(wrong(format!("places[{i}]"), format!("{:?} lies too far from the origin", place.name)));
            }
        }
        let [low, high] = bounds(places.iter().map(|place| place.at));
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(1.0);
        let margin = self.margin.unwrap_or(0.25 * extent).max(4.0 * self.spacing.unwrap_or(0.0));
        let sides = [0, 1].map(|axis| high[axis] - low[axis] + 2.0 * margin);
        let spacing = self.spacing.unwrap_or_else(|| (sides[0] * sides[1] / USUAL_POINTS).sqrt().max(self.width).max(4.0).ceil());
        let points = (sides[0] / spacing + 2.0) * (sides[1] / spacing + 2.0);
        if points > MOST_POINTS || spacing > 1000.0 {
            let least = (sides[0] * sides[1] / MOST_POINTS).sqrt().ceil();
            let most = if least > 1000.0 { "; the places lie too far apart for that, so ask for fewer at a time" } else { "" };
            return Err(wrong("spacing", format!("{points:.0} points would be needed, {MOST_POINTS} are allowed: at least {least} m, and at most 1000{most}")));
        }
        Ok(Lattice::window([low, high], margin, spacing))
    }

    /// Roads over the terrain that join all places: the least tree of least-cost paths, and further roads where it makes for long ways round.
    ///
    /// # Errors
    /// A parameter outside its range, a place in the water, two places in one, or a place that no road reaches: the error says which and why.
    pub fn build(&self, source: &impl Source, places: &[Place]) -> Result<Vec<Road>, GenerateError> {
        let window = self.window(places)?;
        let mut lattice = Lattice::sample(source, &window, self.reach());
        let nodes = self.settle(&mut lattice, source, places)?;
        let terms = Terms::new(self, &lattice);
        let mut courses = Courses::new(self, source, &lattice);
        let network = network::join(&terms, places, &nodes, &mut courses, self.detour)?;
        courses.roads(&terms, &network)
    }

    /// The lattice's points that the places stand on; there the ground is as high as at the places themselves.
    fn settle(&self, lattice: &mut Lattice, source: &impl Source, places: &[Place]) -> Result<Vec<usize>, GenerateError> {
        let mut nodes: Vec<usize> = Vec::new();
        for (i, place) in places.iter().enumerate() {
            let node = lattice.nearest(place.at);
            if let Some(other) = nodes.iter().position(|&other| other == node) {
                let apart = distance(place.at, places[other].at);
                let reason = format!("{:?} lies {apart:.0} m from {:?}, nearer than the lattice's {} m", place.name, places[other].name, lattice.spacing);
                return Err(wrong(format!("places[{i}]"), reason));
            }
            if !lattice.is_dry(node) {
                let reason = format!("{:?} lies in the water or within {:.0} m of it", place.name, self.reach() + lattice.spacing);
                return Err(wrong(format!("places[{i}]"), reason));
            }
            lattice.settle(node, place.at, course::ground(source, place.at));
            nodes.push(node);
        }
        Ok(nodes)
    }
}

#[cfg(test)]
mod tests;
