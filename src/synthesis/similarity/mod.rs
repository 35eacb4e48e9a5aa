//! How much terrain looks like a type, and why (Saunders 2006, IV.3.2.2).

#[cfg(test)]
mod tests;

use super::{
    analysis::{Analysis, Measure, Profile},
    edges::Linking,
};
use serde::Serialize;

/// -2 ln 0.9: a reference is projected to at least 0.9 (Eq. IV.6).
const BASELINE: f64 = 0.210_721_031_315_652_6;

/// The least tolerance, as a share of the library's and outright.
const FLOORS: [f64; 2] = [1e-3, 1e-9];

/// The numbers of a distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// k1.
    Mean,
    /// √k2.
    Deviation,
    /// γ1.
    Skewness,
    /// γ2.
    Kurtosis,
}

impl Statistic {
    /// In their order.
    pub const ALL: [Statistic; 4] = [Statistic::Mean, Statistic::Deviation, Statistic::Skewness, Statistic::Kurtosis];
}

/// A number for every statistic of every distribution.
type Table<T> = [[T; 4]; 5];

/// A curve that projects numbers to 0 … 1 (Eq. IV.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Projection {
    /// Where it is 1: the mean of the references.
    pub mean: f64,
    /// The tolerance.
    pub sigma: f64,
}

impl Projection {
    /// With the least tolerance that gives every number at least 0.9.
    fn over(numbers: &[f64], mean: f64) -> Self {
        let furthest = numbers.iter().map(|number| (number - mean).abs()).fold(0.0, f64::max);
        Self { mean, sigma: furthest / BASELINE.sqrt() }
    }

    /// What a number is projected to.
    #[must_use]
    pub fn at(&self, number: f64) -> f64 {
        let x = (number - self.mean) / self.sigma;
        libm::exp(-0.5 * x * x)
    }
}

/// What a type is known by at a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TypeModel {
    /// How many samples it has.
    pub samples: usize,
    /// Of each statistic.
    pub projections: Table<Projection>,
    /// How well the samples agree in each statistic, 0 … 1 (Eq. IV.8). 0 throughout for distributions that not all of them have.
    pub agreements: Table<f64>,
}

impl TypeModel {
    /// The mean agreement of each distribution (Eq. IV.10).
    #[must_use]
    pub fn distribution_agreements(&self) -> [f64; 5] {
        self.agreements.map(|agreements| agreements.iter().sum::<f64>() / 4.0)
    }

    /// How far similarities to it can be trusted, 0 … 1: the mean agreement.
    #[must_use]
    pub fn trust(&self) -> f64 {
        self.distribution_agreements().iter().sum::<f64>() / 5.0
    }
}

/// How similar a statistic is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StatisticPart {
    /// Which.
    pub statistic: Statistic,
    /// Of what was compared.
    pub value: f64,
    /// Of the type.
    pub reference: Projection,
    /// 0 … 1.
    pub similarity: f64,
    /// 0 … 1.
    pub agreement: f64,
    /// What it counts in its distribution; together 1.
    pub weight: f64,
}

/// How similar a distribution is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Part {
    /// Which.
    pub measure: Measure,
    /// How many values there were. Without any a distribution is not similar at all.
    pub count: usize,
    /// 0 … 1 (Eq. IV.7).
    pub similarity: f64,
    /// 0 … 1.
    pub agreement: f64,
    /// What it counts; together 1.
    pub weight: f64,
    /// Why.
    pub statistics: [StatisticPart; 4],
}

/// How much terrain looks like a type, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Similarity {
    /// 0 … 1 (Eq. IV.11).
    pub value: f64,
    /// How far to trust it, 0 … 1. With 0 nothing distinguishes the type's samples from the library's, and all parts weigh the same.
    pub trust: f64,
    /// By distribution.
    pub parts: [Part; 5],
}

/// Samples of a type at one level.
pub type Samples<'a> = Vec<&'a Analysis>;

/// What all types of a library are known by at one level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Model {
    /// In the order of the library.
    pub types: Vec<TypeModel>,
    /// The library's tolerances, about its mean.
    pub library: Table<Projection>,
}

fn table<T>(of: impl Fn(usize, usize) -> T) -> Table<T> {
    core::array::from_fn(|measure| core::array::from_fn(|statistic| of(measure, statistic)))
}

/// Weights in proportion to agreements, equal ones if nothing agrees (Eq. IV.9, IV.12).
fn weights<const N: usize>(agreements: [f64; N]) -> [f64; N] {
    let sum: f64 = agreements.iter().sum();
    agreements.map(|agreement| if sum > 0.0 { agreement / sum } else { 1.0 / N as f64 })
}

/// One statistic of those profiles that have the distribution.
fn numbers(profiles: &[Profile], measure: usize, statistic: usize) -> Vec<f64> {
    profiles.iter().map(|profile| &profile.0[measure]).filter(|statistics| statistics.count > 0).map(|statistics| statistics.numbers()[statistic]).collect()
}

fn mean(numbers: &[f64]) -> f64 {
    if numbers.is_empty() { 0.0 } else { numbers.iter().sum::<f64>() / numbers.len() as f64 }
}

/// The projection about a type's own mean; tolerances of types with one sample are set later.
fn own_projection(profiles: &[Profile], measure: usize, statistic: usize) -> Projection {
    let numbers = numbers(profiles, measure, statistic);
    Projection::over(&numbers, mean(&numbers))
}

/// What makes a quarter of a sample.
fn quarters(analysis: &Analysis) -> Vec<Profile> {
    analysis.grid.quarters().into_iter().filter(|crop| crop.columns > 0 && crop.rows > 0).map(|crop| analysis.profile_of(crop)).collect()
}

impl Model {
    /// Of the samples of every type.
    #[must_use]
    pub fn new(types: &[Samples]) -> Self {
        let profiles: Vec<Vec<Profile>> = types.iter().map(|samples| samples.iter().map(|sample| sample.profile()).collect()).collect();
        // Only where no type can say how much samples differ, quarters do.
        let alone = profiles.iter().all(|profiles| profiles.len() < 2);
        let parts: Vec<Vec<Profile>> =
            types.iter().map(|samples| if alone { samples.iter().flat_map(|sample| quarters(sample)).collect() } else { Vec::new() }).collect();
        Self::of_profiles(&profiles, &parts)
    }

    /// Of the profiles of every type's samples and, for libraries in which no type has two, of the quarters of these.
    #[must_use]
    pub fn of_profiles(types: &[Vec<Profile>], quarters: &[Vec<Profile>]) -> Self {
        let everything: Vec<Profile> = types.iter().flatten().copied().collect();
        let library = table(|measure, statistic| own_projection(&everything, measure, statistic));
        let floored = |measure: usize, statistic: usize, Projection { mean, sigma }: Projection| {
            let least = (FLOORS[0] * library[measure][statistic].sigma).max(FLOORS[1]);
            Projection { mean, sigma: sigma.max(least) }
        };
        let own: Vec<Table<Projection>> =
            types.iter().map(|profiles| table(|measure, statistic| floored(measure, statistic, own_projection(profiles, measure, statistic)))).collect();
        let usual = table(|measure, statistic| {
            let several = types.iter().zip(&own).filter(|(profiles, _)| numbers(profiles, measure, statistic).len() > 1);
            let sigmas: Vec<f64> = several.map(|(_, own)| own[measure][statistic].sigma).collect();
            (!sigmas.is_empty()).then(|| mean(&sigmas))
        });
        let types = types.iter().zip(&own).enumerate().map(|(i, (profiles, own))| {
            let projections = table(|measure, statistic| {
                let Projection { mean, mut sigma } = own[measure][statistic];
                if numbers(profiles, measure, statistic).len() < 2 {
                    let parts = || quarters.get(i).map_or(0.0, |parts| Projection::over(&numbers(parts, measure, statistic), mean).sigma);
                    sigma = usual[measure][statistic].unwrap_or_else(parts);
                }
                floored(measure, statistic, Projection { mean, sigma })
            });
            let agreements = table(|measure, statistic| {
                let ratio = projections[measure][statistic].sigma / library[measure][statistic].sigma.max(FLOORS[1]);
                let all = !profiles.is_empty() && profiles.iter().all(|profile| profile.0[measure].count > 0);
                if all { (1.0 - ratio * ratio).max(0.0) } else { 0.0 }
            });
            TypeModel { samples: profiles.len(), projections, agreements }
        });
        Self { types: types.collect(), library }
    }

    /// How much terrain looks like a type, and why; `None` if there is no such type.
    #[must_use]
    pub fn similarity(&self, number: usize, profile: &Profile) -> Option<Similarity> {
        self.types.get(number).map(|known| known.similarity(profile))
    }

    /// All types from the most similar one; of equals the first.
    #[must_use]
    pub fn nearest(&self, profile: &Profile) -> Vec<(usize, Similarity)> {
        let mut all: Vec<(usize, Similarity)> =
            self.types.iter().map(|known| known.similarity(profile)).enumerate().filter(|(number, _)| self.types[*number].samples > 0).collect();
        all.sort_by(|(_, one), (_, other)| other.value.total_cmp(&one.value));
        all
    }
}

impl TypeModel {
    /// How much terrain looks like it, and why.
    #[must_use]
    pub fn similarity(&self, profile: &Profile) -> Similarity {
        let of_measures = weights(self.distribution_agreements());
        let parts: [Part; 5] = core::array::from_fn(|m| {
            let statistics = &profile.0[m];
            let (values, of_statistics) = (statistics.numbers(), weights(self.agreements[m]));
            let statistics_parts: [StatisticPart; 4] = core::array::from_fn(|s| {
                let reference = self.projections[m][s];
                let similarity = if statistics.count > 0 { reference.at(values[s]) } else { 0.0 };
                StatisticPart {
                    statistic: Statistic::ALL[s],
                    value: values[s],
                    reference,
                    similarity,
                    agreement: self.agreements[m][s],
                    weight: of_statistics[s],
                }
            });
            let similarity = statistics_parts.iter().map(|part| part.weight * part.similarity).sum();
            let agreement = self.agreements[m].iter().sum::<f64>() / 4.0;
            Part { measure: Measure::ALL[m], count: statistics.count, similarity, agreement, weight: of_measures[m], statistics: statistics_parts }
        });
        let value = parts.iter().map(|part| part.weight * part.similarity).sum();
        Similarity { value, trust: self.trust(), parts }
    }

    /// The value of [`similarity`](Self::similarity) alone.
    #[must_use]
    pub fn value(&self, profile: &Profile) -> f64 {
        self.similarity(profile).value
    }
}

/// What a sample would do to a type if it were added.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Addition {
    /// Before and after, by distribution.
    pub agreements: [(Measure, Table1, Table1); 5],
    /// How far similarities to the type can be trusted, before and after.
    pub trust: [f64; 2],
    /// What agrees much less: from above [`AGREED`] to below [`DIFFERED`].
    pub lost: Vec<(Measure, Statistic)>,
}

/// Agreements of the statistics of one distribution, in the order of [`Statistic::ALL`].
type Table1 = [f64; 4];

/// Above it samples agree.
pub const AGREED: f64 = 0.8;

/// Below it they do not.
pub const DIFFERED: f64 = 0.6;

/// What adding a sample to a type would do to its agreement; `None` if there is no such type.
#[must_use]
pub fn addition(types: &[Vec<Profile>], number: usize, sample: &Profile) -> Option<Addition> {
    let mut with = types.to_vec();
    with.get_mut(number)?.push(*sample);
    let (before, after) = (Model::of_profiles(types, &[]), Model::of_profiles(&with, &[]));
    let (before, after) = (before.types.get(number)?, after.types.get(number)?);
    let lost = (0..5).flat_map(|m| (0..4).map(move |s| (m, s))).filter(|(m, s)| before.agreements[*m][*s] > AGREED && after.agreements[*m][*s] < DIFFERED);
    Some(Addition {
        agreements: core::array::from_fn(|m| (Measure::ALL[m], before.agreements[m], after.agreements[m])),
        trust: [before.trust(), after.trust()],
        lost: lost.map(|(m, s)| (Measure::ALL[m], Statistic::ALL[s])).collect(),
    })
}

/// The profile of a region as the references are made: linked over the whole of it.
#[must_use]
pub fn region_profile(terrain: &Analysis, region: impl Fn(usize) -> bool) -> Profile {
    terrain.profile_in(region, Linking::Whole)
}
