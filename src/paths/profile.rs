//! Profiles: the shape of a feature's flank, and how far paths climb down by it.

use serde::{Deserialize, Serialize};

/// Parts of a table.
const PARTS: usize = 1024;

/// How far a profile that steps by distance is tilted, so that flats still cost something and paths over them are found in order.
const TILT: f64 = 1.0 / 512.0;

/// Which way a profile shapes costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stepping {
    /// A step's cost is its weight times the profile's slope at the cost so far (Rusnell 2009, Eq. 3.4–3.6): cannot hold flats or terraces.
    Slope,
    /// A step advances along the profile by its weight over the mean; the cost is read there.
    Distance,
}

/// Why points make no profile.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// Fewer than two points, or more than the limit.
    #[error("a profile has 2 to {most} points, got {0}", most = Profile::MAX_POINTS)]
    Points(usize),
    /// A number that is not finite.
    #[error("point {0} is not a pair of finite numbers")]
    NotFinite(usize),
    /// Abscissae that do not grow.
    #[error("point {0} must lie further from the crest than the one before")]
    Order(usize),
    /// A rise.
    #[error("point {0} is higher than the one before: a profile falls from the crest or stays level")]
    Rises(usize),
    /// No fall at all.
    #[error("the last point must be lower than the first")]
    Level,
}

/// The shape of a flank, from its crest (distance 0, height 1) to sea level (distance 1, height 0), and its width.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// (distance, height), both 0 … 1.
    points: Vec<[f64; 2]>,
    /// At the points.
    slopes: Vec<f64>,
    /// Lattice steps from the crest to sea level of a feature whose crest costs nothing.
    width: f64,
}

impl Profile {
    /// Most points of a profile.
    pub const MAX_POINTS: usize = 4096;

    /// A profile through points (distance from the crest, height), a monotone cubic between them (Fritsch and Butland 1984); both are scaled to 0 … 1. `width` in lattice steps.
    ///
    /// # Errors
    /// If there are fewer than two points, distances do not grow, or heights rise or never fall.
    pub fn new(points: &[[f64; 2]], width: f64) -> Result<Self, ProfileError> {
        if points.len() < 2 || points.len() > Self::MAX_POINTS {
            return Err(ProfileError::Points(points.len()));
        }
        if let Some(i) = points.iter().position(|point| !point.iter().all(|c| c.is_finite())) {
            return Err(ProfileError::NotFinite(i));
        }
        for (i, pair) in points.windows(2).enumerate() {
            if pair[1][0] <= pair[0][0] {
                return Err(ProfileError::Order(i + 1));
            }
            if pair[1][1] > pair[0][1] {
                return Err(ProfileError::Rises(i + 1));
            }
        }
        let (first, last) = (points[0], points[points.len() - 1]);
        let [length, height] = [last[0] - first[0], first[1] - last[1]];
        if height <= 0.0 {
            return Err(ProfileError::Level);
        }
        let points: Vec<[f64; 2]> = points.iter().map(|[x, h]| [(x - first[0]) / length, (h - last[1]) / height]).collect();
        Ok(Self { slopes: slopes(&points), points, width })
    }

    /// Its height at a distance, both 0 … 1.
    #[must_use]
    pub fn height(&self, x: f64) -> f64 {
        let x = x.clamp(0.0, 1.0);
        let after = self.points.partition_point(|point| point[0] < x).clamp(1, self.points.len() - 1);
        let [[x0, h0], [x1, h1]] = [self.points[after - 1], self.points[after]];
        let (width, [m0, m1]) = (x1 - x0, [self.slopes[after - 1], self.slopes[after]]);
        let t = (x - x0) / width;
        let u = 1.0 - t;
        u * u * (h0 * (1.0 + 2.0 * t) + m0 * width * t) + t * t * (h1 * (1.0 + 2.0 * u) - m1 * width * u)
    }

    /// The same shape with another width in lattice steps.
    #[must_use]
    pub fn with_width(self, width: f64) -> Self {
        Self { width, ..self }
    }

    /// How paths step by it best: by slope where flanks without roughness then keep within 1 % of it, whole and half as high; else, as with flats and terraces, by distance.
    #[must_use]
    pub fn stepping(&self, least_scale: f64) -> Stepping {
        const MOST_ERROR: f64 = 0.01;
        let scaling = self.slopes(1.0, 1.0, least_scale);
        let follows = |span: f64| {
            let crest = Crest::new((1.0 - span) as f32, span as f32, 1.0);
            let costs = core::iter::successors(Some(crest.cost), |cost| Some(scaling.after(*cost, &crest, &[1.0; 8])[0]));
            let flank = costs.enumerate().take((self.width * span) as usize + 1);
            let error = flank.map(|(i, cost)| (1.0 - f64::from(cost) - span * self.height(i as f64 / (self.width * span))).abs());
            error.fold(0.0, f64::max) <= MOST_ERROR * span
        };
        if follows(1.0) && follows(0.5) { Stepping::Slope } else { Stepping::Distance }
    }

    /// Its table for costs 0 … `sea_level_cost` and a mean weight of edges; scales below `least_scale` are filled from those around.
    #[must_use]
    pub fn scaling(&self, stepping: Stepping, sea_level_cost: f64, mean: f64, least_scale: f64) -> Scaling {
        match stepping {
            Stepping::Slope => self.slopes(sea_level_cost, mean, least_scale),
            Stepping::Distance => self.distances(sea_level_cost, mean),
        }
    }

    fn slopes(&self, sea_level_cost: f64, mean: f64, least_scale: f64) -> Scaling {
        // The mean slope between two costs is the rise over the run between the distances where the profile reaches them.
        let step = self.width / PARTS as f64;
        let mut good: Vec<[f64; 2]> = Vec::new();
        for i in 0..PARTS {
            let [above, below] = [i, i + 1].map(|i| self.height(i as f64 / PARTS as f64));
            let scale = (above - below) * sea_level_cost / step / mean;
            let cost = 1.0 - f64::midpoint(above, below);
            if scale >= least_scale {
                good.push([cost, scale]);
            }
        }
        let at = |cost: f64| {
            let after = good.partition_point(|point| point[0] < cost);
            match (after.checked_sub(1).map(|i| good[i]), good.get(after).copied()) {
                (Some([c0, s0]), Some([c1, s1])) if c1 > c0 => s0 + (s1 - s0) * ((cost - c0) / (c1 - c0)),
                (_, Some([_, s])) | (Some([_, s]), None) => s,
                (None, None) => least_scale,
            }
        };
        let table: Vec<f32> = (0..=PARTS).map(|i| at(i as f64 / PARTS as f64) as f32).collect();
        let least = table.iter().copied().fold(f32::INFINITY, f32::min);
        Scaling { kind: Kind::Slope, least, table: pad(table), per_weight: 0.0 }
    }

    fn distances(&self, sea_level_cost: f64, mean: f64) -> Scaling {
        let table: Vec<f32> = (0..=PARTS)
            .map(|i| {
                let x = i as f64 / PARTS as f64;
                ((1.0 - TILT) * (1.0 - self.height(x)) + TILT * x) as f32
            })
            .collect();
        let slope = table.windows(2).map(|pair| pair[1] - pair[0]).fold(f32::INFINITY, f32::min) * PARTS as f32;
        // A weight's share of the table, at the scale of a feature that costs nothing at its crest.
        let per_weight = PARTS as f64 / (mean * self.width);
        let least = f64::from(slope) * sea_level_cost / (mean * self.width);
        Scaling { kind: Kind::Distance, least: least as f32, table: pad(table), per_weight: per_weight as f32 }
    }
}

/// The slopes of a monotone cubic: between two points the weighted harmonic mean of the slopes around, at the ends the parabola's, both so bounded that nothing overshoots.
fn slopes(points: &[[f64; 2]]) -> Vec<f64> {
    let widths: Vec<f64> = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let secants: Vec<f64> = points.windows(2).zip(&widths).map(|(pair, width)| (pair[1][1] - pair[0][1]) / width).collect();
    let end = |near: usize, next: Option<usize>| {
        let Some(next) = next else { return secants[near] };
        let slope = ((2.0 * widths[near] + widths[next]) * secants[near] - widths[near] * secants[next]) / (widths[near] + widths[next]);
        slope.clamp(3.0 * secants[near], 0.0)
    };
    let last = secants.len() - 1;
    let inner = (1..points.len() - 1).map(|i| {
        let ([a, b], [w0, w1]) = ([secants[i - 1], secants[i]], [widths[i - 1], widths[i]]);
        if a * b <= 0.0 { 0.0 } else { 3.0 * (w0 + w1) / ((2.0 * w1 + w0) / a + (w1 + 2.0 * w0) / b) }
    });
    let first = end(0, (last > 0).then_some(1));
    [first].into_iter().chain(inner).chain([end(last, last.checked_sub(1))]).collect()
}

/// The last value once more, so that a place at the very end has a next.
fn pad(mut table: Vec<f32>) -> Vec<f32> {
    table.extend(table.last().copied());
    table
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// The table holds scales of weights, by cost.
    Slope,
    /// The table holds costs, by distance.
    Distance,
}

/// A profile made ready for searches: how much a step adds to a cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    kind: Kind,
    table: Vec<f32>,
    /// Least cost of a step of weight 1.
    least: f32,
    /// Parts of the table that a step of weight 1 advances.
    per_weight: f32,
}

/// The crest that a path comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crest {
    /// Its cost.
    pub cost: f32,
    /// Sea level's cost less its own.
    pub span: f32,
    /// PARTS / span.
    parts: f32,
    /// The span that profiles were made for / span.
    shrink: f32,
}

impl Crest {
    /// A crest of some cost, `span` below the cost of sea level; `sea_level_cost` is what profiles were scaled to.
    #[must_use]
    pub fn new(cost: f32, span: f32, sea_level_cost: f32) -> Self {
        Self { cost, span, parts: PARTS as f32 / span, shrink: sea_level_cost / span }
    }
}

impl Scaling {
    /// Without a profile: a step costs its weight.
    #[must_use]
    pub fn none() -> Self {
        Self { kind: Kind::Slope, table: vec![1.0; PARTS + 2], least: 1.0, per_weight: 0.0 }
    }

    /// The least cost of a step of weight 1.
    #[must_use]
    pub fn least(&self) -> f32 {
        self.least
    }

    /// The costs after each of eight steps from a node of some cost, on a path from a crest.
    #[inline]
    #[must_use]
    pub fn after(&self, cost: f32, crest: &Crest, weights: &[f32; 8]) -> [f32; 8] {
        let part = (cost - crest.cost) * crest.parts;
        match self.kind {
            Kind::Slope => {
                let scale = self.at(part);
                weights.map(|weight| cost + weight * scale)
            }
            Kind::Distance => {
                let here = self.distance(part * (1.0 / PARTS as f32));
                let per_weight = self.per_weight * crest.shrink;
                weights.map(|weight| {
                    let there = crest.cost + crest.span * self.at(here + weight * per_weight);
                    if there > cost { there } else { cost }
                })
            }
        }
    }

    /// The table at a place in parts.
    #[inline]
    fn at(&self, part: f32) -> f32 {
        let part = part.clamp(0.0, PARTS as f32);
        let i = part as usize;
        let [a, b] = [self.table[i], self.table[i + 1]];
        a + (b - a) * (part - i as f32)
    }

    /// The place where a table of costs has this one, in parts.
    #[inline]
    fn distance(&self, cost: f32) -> f32 {
        let i = self.table[1..PARTS].partition_point(|&c| c <= cost);
        let [a, b] = [self.table[i], self.table[i + 1]];
        let share = ((cost - a) / (b - a)).clamp(0.0, 1.0);
        i as f32 + share
    }
}
