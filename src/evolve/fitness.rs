//! What is wanted of terrain, and how near a surface comes to it.

use super::record::RecordError;
use crate::{
    analysis::{Accessibility, Quantiles, Statistics, accessibility},
    genetic::Criterion,
    geometry::Surface,
};
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// One thing that is wanted. Scores are from 0, as far as can be, to 1, just as wanted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Wanted {
    /// A share of the ground in one connected area that is not too steep.
    Accessibility {
        /// The steepest slope that can be climbed, in degrees, above 0 and below 90.
        slope: f64,
        /// The share, 0 … 1.
        share: f64,
    },
    /// Obstacles with long edges: many, rather than one.
    Edges {
        /// As of [`Wanted::Accessibility`].
        slope: f64,
        /// Length of their edges in metres a square kilometre, above 0.
        density: f64,
    },
    /// A distribution of slopes.
    Slopes {
        /// Degrees at equal shares of the ground, ascending, at least two: `[0, 5, 40]` has half of the ground flatter than 5°.
        degrees: Quantiles,
    },
    /// A distribution of elevations.
    Elevations {
        /// Shares of the relief at equal shares of the ground, ascending from 0 to 1, at least two: `[0, 0.1, 1]` has half of the ground on the lowest tenth.
        heights: Quantiles,
    },
    /// Roughness as [`Statistics::roughness`] measures it.
    Roughness {
        /// Metres a metre, above 0.
        value: f64,
    },
    /// Slopes, elevations and roughness of real terrain, measured at the same spacing.
    Likeness {
        /// What it is like.
        sample: Statistics,
    },
}

/// Slopes that lie so many degrees off on average score half.
const HALF_DEGREES: f64 = 6.0;

/// Heights that lie such a share of the relief off on average score half.
const HALF_HEIGHTS: f64 = 0.12;

/// A surface that is judged, with what was found of it so far.
pub(super) struct Judged<'a> {
    surface: &'a Surface,
    spacing: f64,
    statistics: OnceCell<Statistics>,
    /// By the threshold in degrees: criteria that share one share its areas.
    accessibility: OnceCell<(f64, Accessibility)>,
}

impl<'a> Judged<'a> {
    /// A surface with an apron of one sample.
    pub(super) fn new(surface: &'a Surface, spacing: f64) -> Self {
        Self { surface, spacing, statistics: OnceCell::new(), accessibility: OnceCell::new() }
    }

    fn statistics(&self) -> &Statistics {
        self.statistics.get_or_init(|| Statistics::of(self.surface, self.spacing))
    }

    fn accessible<T>(&self, degrees: f64, of: impl Fn(&Accessibility) -> T) -> T {
        let find = || accessibility(self.surface, self.spacing, degrees);
        match self.accessibility.get_or_init(|| (degrees, find())) {
            (threshold, found) if *threshold == degrees => of(found),
            _ => of(&find()),
        }
    }
}

/// From 1 for no difference over a half to 0.
fn near(difference: f64, half: f64) -> f64 {
    half / (half + difference)
}

/// The smaller of two over the greater.
fn ratio(a: f64, b: f64) -> f64 {
    if a.max(b) > 0.0 { a.min(b) / a.max(b) } else { 1.0 }
}

impl Criterion<Judged<'_>> for Wanted {
    fn score(&self, judged: &Judged) -> f64 {
        match self {
            Wanted::Accessibility { slope, share } => 1.0 - (judged.accessible(*slope, Accessibility::largest_share) - share).abs() / share.max(1.0 - share),
            Wanted::Edges { slope, density } => ratio(judged.accessible(*slope, |found| found.edge_density(judged.spacing)), *density),
            Wanted::Slopes { degrees } => near(judged.statistics().slopes.distance(degrees), HALF_DEGREES),
            Wanted::Elevations { heights } => near(judged.statistics().heights.distance(heights), HALF_HEIGHTS),
            Wanted::Roughness { value } => ratio(judged.statistics().roughness, *value),
            Wanted::Likeness { sample } => {
                let own = judged.statistics();
                let slopes = near(own.slopes.distance(&sample.slopes), HALF_DEGREES);
                let heights = near(own.heights.distance(&sample.heights), HALF_HEIGHTS);
                (slopes + heights + ratio(own.roughness, sample.roughness)) / 3.0
            }
        }
    }
}

impl Wanted {
    /// Its name, as it is written.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Wanted::Accessibility { .. } => "accessibility",
            Wanted::Edges { .. } => "edges",
            Wanted::Slopes { .. } => "slopes",
            Wanted::Elevations { .. } => "elevations",
            Wanted::Roughness { .. } => "roughness",
            Wanted::Likeness { .. } => "likeness",
        }
    }

    pub(super) fn check(&self, at: &str) -> Result<(), RecordError> {
        let number = |name: &str, value: f64, holds: bool, range: &str| {
            if holds { Ok(()) } else { Err(RecordError::new(format!("{at}/{name}"), format!("must be {range}, got {value}"))) }
        };
        let slope = |name: &str, value: f64| number(&format!("{name}/slope"), value, value > 0.0 && value < 90.0, "above 0 and below 90 degrees");
        let quantiles = |name: &str, Quantiles(values): &Quantiles, most: f64| {
            let ascends = values.windows(2).all(|pair| pair[0] <= pair[1]);
            let holds = (2..=1025).contains(&values.len()) && ascends && values.iter().all(|value| (0.0..=most).contains(value));
            let wrong = || RecordError::new(format!("{at}/{name}"), format!("must be 2 to 1025 ascending numbers, 0 … {most}"));
            if holds { Ok(()) } else { Err(wrong()) }
        };
        match self {
            Wanted::Accessibility { slope: degrees, share } => {
                slope("accessibility", *degrees)?;
                number("accessibility/share", *share, (0.0..=1.0).contains(share), "a share, 0 … 1")
            }
            Wanted::Edges { slope: degrees, density } => {
                slope("edges", *degrees)?;
                number("edges/density", *density, density.is_finite() && *density > 0.0, "above 0 metres a square kilometre")
            }
            Wanted::Slopes { degrees } => quantiles("slopes/degrees", degrees, 90.0),
            Wanted::Elevations { heights } => quantiles("elevations/heights", heights, 1.0),
            Wanted::Roughness { value } => number("roughness/value", *value, value.is_finite() && *value > 0.0, "above 0"),
            Wanted::Likeness { sample } => {
                quantiles("likeness/sample/slopes", &sample.slopes, 90.0)?;
                quantiles("likeness/sample/heights", &sample.heights, 1.0)?;
                let roughness = sample.roughness;
                number("likeness/sample/roughness", roughness, roughness.is_finite() && roughness >= 0.0, "at least 0")
            }
        }
    }
}
