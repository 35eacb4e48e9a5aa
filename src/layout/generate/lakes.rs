//! Lakes on the way of rivers.

use super::{
    error::{GenerateError, check},
    network::Network,
    plane::{Point, along, distance, dot, minus, unit},
    random::Stream,
};
use serde::{Deserialize, Serialize};

/// Lakes on the way of rivers: flat, with the river below starting at the lake's level and the rivers above ending at it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lakes {
    /// The share 0 … 1 of the places with room for a lake that get one.
    pub share: f64,
    /// The mean distance of a lake's shore from its middle, as a share 0.02 … 0.4 of the rivers' spacing.
    pub size: f64,
    /// Vertices of a lake's shore before rivers add theirs, 4 … 64.
    pub corners: usize,
}

impl Default for Lakes {
    fn default() -> Self {
        Lakes { share: 0.2, size: 0.22, corners: 9 }
    }
}

/// A lake round a node of a network.
#[derive(Clone, Debug)]
pub(super) struct Lake {
    /// The shore; a vertex for every river that enters or leaves.
    pub(super) ring: Vec<Point>,
    pub(super) level: f64,
    /// For the upper node of every river that meets the lake, where it does: the share of the distance between the river's two nodes.
    arms: Vec<(usize, f64)>,
}

impl Lake {
    /// How far the lake reaches along the river whose upper node is `branch`, as a share of the distance between its nodes.
    pub(super) fn arm(&self, branch: usize) -> f64 {
        self.arms.iter().find(|arm| arm.0 == branch).map_or(0.0, |arm| arm.1)
    }
}

/// The longest arm of a lake along a river, as a share of the way to the next node: two lakes never meet.
const LONGEST_ARM: f64 = 0.45;

impl Lakes {
    pub(super) fn check(&self) -> Result<(), GenerateError> {
        check("lakes.share", self.share, 0.0..=1.0)?;
        check("lakes.size", self.size, 0.02..=0.4)?;
        check("lakes.corners", self.corners as f64, 4.0..=64.0)
    }

    /// Puts lakes on nodes by lot: never on a mouth, a source or beside another lake.
    pub(super) fn flood(&self, network: &mut Network, spacing: f64, seed: u64) -> Result<(), GenerateError> {
        self.check()?;
        let children = network.children();
        let mut stream = Stream::new(seed, "lakes");
        for (index, children) in children.iter().enumerate() {
            let wanted = stream.unit() < self.share;
            let Some(parent) = network.nodes[index].parent else { continue };
            let has_neighbour = children.iter().chain([&parent]).any(|&other| network.nodes[other].lake.is_some());
            if !wanted || has_neighbour || children.is_empty() || network.nodes[parent].parent.is_none() {
                continue;
            }
            let lake = self.round(network, index, children, spacing, &mut stream);
            network.nodes[index].lake = Some(network.lakes.len());
            network.lakes.push(lake);
        }
        Ok(())
    }

    /// A lake round a node: star-shaped, with a vertex exactly on every river.
    fn round(&self, network: &Network, index: usize, children: &[usize], spacing: f64, stream: &mut Stream) -> Lake {
        let node = &network.nodes[index];
        let middle = node.at;
        let radius = spacing * self.size * stream.between(0.7, 1.3);
        let mut arms = Vec::new();
        let mut spokes = Vec::new();
        for (branch, other) in children.iter().map(|&child| (child, child)).chain(node.parent.map(|parent| (index, parent))) {
            let far = network.nodes[other].at;
            let share = (radius * stream.between(0.9, 1.6) / distance(middle, far)).min(LONGEST_ARM);
            arms.push((branch, share));
            spokes.push((unit(minus(far, middle)), along(middle, share, minus(far, middle))));
        }
        let rivers = spokes.len();
        for corner in 0..self.corners {
            let turn = (corner as f64 + stream.between(-0.3, 0.3)) / self.corners as f64;
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * turn);
            let (direction, reach) = ([cosine, sine], radius * stream.between(0.55, 1.0));
            if spokes[..rivers].iter().all(|&(river, _)| dot(river, direction) < 0.92) {
                spokes.push((direction, along(middle, reach, direction)));
            }
        }
        spokes.sort_by(|a, b| turn(a.0).total_cmp(&turn(b.0)));
        Lake { ring: spokes.into_iter().map(|(_, p)| p).collect(), level: node.elevation, arms }
    }
}

/// Grows with a direction's angle, from 0 to 4 counter-clockwise from the east; no arc tangent is needed.
fn turn([x, y]: Point) -> f64 {
    let share = y / (x.abs() + y.abs());
    if x < 0.0 {
        2.0 - share
    } else if y < 0.0 {
        4.0 + share
    } else {
        share
    }
}
