//! Fitness as a weighted mean of criteria.

use serde::{Deserialize, Serialize};

/// Something that individuals are judged by.
pub trait Criterion<S: ?Sized> {
    /// From 0, as far as can be from what is wanted, to 1, just that.
    fn score(&self, subject: &S) -> f64;
}

/// A criterion and how much it counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Term<C> {
    /// At least 0.
    #[serde(default = "one")]
    pub weight: f64,
    /// What is judged.
    pub criterion: C,
}

fn one() -> f64 {
    1.0
}

/// The mean of criteria by their weights; 0 without any weight.
///
/// ```
/// use terrane::genetic::{Criterion, Term, Weighted};
/// struct Near(f64);
/// impl Criterion<f64> for Near {
///     fn score(&self, subject: &f64) -> f64 {
///         1.0 / (1.0 + (subject - self.0).abs())
///     }
/// }
/// let wanted = Weighted(vec![Term { weight: 3.0, criterion: Near(2.0) }, Term { weight: 1.0, criterion: Near(4.0) }]);
/// assert_eq!(wanted.score(&2.0), (3.0 + 1.0 / 3.0) / 4.0);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Weighted<C>(pub Vec<Term<C>>);

impl<C> Weighted<C> {
    /// The score of every criterion, in order.
    pub fn scores<S: ?Sized>(&self, subject: &S) -> Vec<f64>
    where
        C: Criterion<S>,
    {
        self.0.iter().map(|term| term.criterion.score(subject)).collect()
    }
}

impl<S: ?Sized, C: Criterion<S>> Criterion<S> for Weighted<C> {
    fn score(&self, subject: &S) -> f64 {
        let weights: f64 = self.0.iter().map(|term| term.weight).sum();
        let sum: f64 = self.0.iter().map(|term| term.weight * term.criterion.score(subject)).sum();
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}
