//! A generation's lines and the terrain that they make.

use super::{
    lattice,
    players::{smooth, thaw},
    population::{self, Lines},
    settings::{Feedback, Ground},
    terrain::AdaptiveTerrain,
};
use crate::evolve::record::RecordError;

/// All that the next generation is bred of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub lines: Lines,
    pub terrain: AdaptiveTerrain,
}

impl State {
    /// That of generation 0.
    pub(super) fn first(ground: &Ground) -> Self {
        let lines = population::first(ground);
        let terrain = AdaptiveTerrain::new(ground, lattice::heights(ground, &lines).into());
        Self { lines, terrain }
    }

    /// The heights that a feedback asks for, in metres above the mean of the ground.
    pub(super) fn wanted(&self, ground: &Ground, feedback: &Feedback) -> Result<Vec<f64>, RecordError> {
        let mut wanted: Vec<f64> = feedback.heights.iter().map(|height| height - ground.mean).collect();
        for (i, &point) in feedback.points.iter().enumerate() {
            let Some(height) = self.terrain.height(point) else {
                let (area, [x, y]) = (self.terrain.area(), point);
                let message = format!("must lie on the terrain, {:?} … {:?} m, got [{x}, {y}]", area.min, area.max);
                return Err(RecordError::new(format!("/points/{i}"), message));
            };
            wanted.push(f64::from(height) - ground.mean);
        }
        Ok(wanted)
    }

    /// That of generation `number`, bred of this one.
    pub(super) fn next(&self, ground: &Ground, number: usize, feedback: &Feedback) -> Result<Self, RecordError> {
        let lines = population::bred(ground, &self.lines, &self.wanted(ground, feedback)?, number);
        let mut heights = lattice::heights(ground, &lines);
        if feedback.radius.is_some() || !feedback.ways.is_empty() {
            let weights = weights(ground, feedback);
            for ((new, &old), weight) in heights.iter_mut().zip(self.terrain.nodes()).zip(weights) {
                *new = mixed(old, *new, weight);
            }
        }
        Ok(Self { lines, terrain: AdaptiveTerrain::new(ground, heights.into()) })
    }
}

/// From the old to the new height by a weight: exactly the one or the other at its ends.
fn mixed(old: f32, new: f32, weight: f32) -> f32 {
    if weight <= 0.0 {
        old
    } else if weight >= 1.0 {
        new
    } else {
        old + (new - old) * weight
    }
}

/// How much of the new height each node takes: all within half the radius, less and less to its end, and nothing where it is promised.
fn weights(ground: &Ground, feedback: &Feedback) -> Vec<f32> {
    let [columns, rows] = ground.size();
    let mut weights = vec![1.0; columns * rows];
    if let Some(radius) = feedback.radius {
        for (i, weight) in weights.iter_mut().enumerate() {
            let place = [ground.origin[0] + (i % columns) as f64 * ground.cell, ground.origin[1] + (i / columns) as f64 * ground.cell];
            let square = |[x, y]: [f64; 2]| (x - place[0]) * (x - place[0]) + (y - place[1]) * (y - place[1]);
            let nearest = feedback.points.iter().copied().map(square).fold(f64::INFINITY, f64::min).sqrt();
            *weight = smooth(2.0 * (1.0 - nearest / radius));
        }
    }
    thaw(ground, &feedback.ways, ground.promise + feedback.margin, &mut weights);
    weights
}
