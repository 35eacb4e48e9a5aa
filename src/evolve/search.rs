//! A whole evolution as plain data: what is wanted, how it is bred towards, when it is enough; and the stages that it goes on from.

use super::{
    Aim, Genome, Judgement,
    record::{MAX_SEED, RecordError},
};
use crate::{
    genetic::{Evolution, Progress, Settings, SettingsError, State},
    geometry::Stop,
};
use serde::{Deserialize, Serialize};

/// What is bred from a search: it goes up when the same search would breed other programmes, and stages of another form are not gone on from.
pub const SEARCH_FORM: u32 = 1;

/// Most generations of a search: each leaves a point of the curve.
pub const MAX_SEARCH_GENERATIONS: usize = 10_000;

/// Most nodes that all individuals may have together: what a stage holds.
const MAX_SEARCH_NODES: usize = 1 << 20;

/// Nanoseconds that judging takes a sample, beside the programme's own.
const JUDGE_NS: f64 = 250.0;

/// Most nanoseconds of one processor that a search may be predicted to take: ten hours.
const MOST_NS: f64 = 3.6e13;

/// What terrain is wanted and how it is searched for.
///
/// ```
/// use terrane::{evolve::Search, geometry::Stop};
/// let search: Search = serde_json::from_str(r#"{"seed": 7, "goal": 0.99, "settings": {"population": 12, "generations": 4}, "aim": {"samples": 32, "wanted": [
///     {"criterion": {"accessibility": {"slope": 15, "share": 0.8}}}]}}"#)?;
/// search.check()?;
/// let mut stage = search.begin(&Stop::never())?.expect("nobody stops it");
/// while !search.is_over(&stage) {
///     stage = search.advance(stage, &Stop::never())?.expect("nobody stops it");
/// }
/// assert!(stage.best().judgement.score > 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Search {
    /// What is wanted.
    pub aim: Aim,
    /// How programmes are bred.
    #[serde(default)]
    pub settings: Settings,
    /// Hashed into every draw; 0 … 2^53 - 1.
    #[serde(default)]
    pub seed: u64,
    /// The score, above 0 and up to 1, at which it is enough; without one all generations are bred.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub goal: Option<f64>,
}

/// The best programme so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Found {
    /// The generation that it first was in.
    pub generation: usize,
    /// The programme.
    pub genome: Genome,
    /// How near it comes.
    pub judgement: Judgement,
}

/// Where a search stands after a generation: written as JSON and read again, it goes on to the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stage {
    form: u32,
    state: State<Genome, Judgement>,
    best: Found,
}

impl Search {
    /// Holds everything to its range, and refuses what would take too long or too much room.
    ///
    /// # Errors
    /// If something lies outside; the error names the place.
    pub fn check(&self) -> Result<(), RecordError> {
        self.aim.check().map_err(|RecordError { at, message }| RecordError::new(format!("/aim{at}"), message))?;
        self.settings.check().map_err(settings_error)?;
        let Settings { population, islands, generations, .. } = self.settings;
        if generations > MAX_SEARCH_GENERATIONS {
            return Err(RecordError::new("/settings/generations", format!("must be at most {MAX_SEARCH_GENERATIONS}, got {generations}")));
        }
        if self.seed > MAX_SEED {
            return Err(RecordError::new("/seed", format!("must be 0 … {MAX_SEED}, got {}", self.seed)));
        }
        if let Some(goal) = self.goal.filter(|goal| !(*goal > 0.0 && *goal <= 1.0)) {
            return Err(RecordError::new("/goal", format!("must be a score above 0, at most 1, got {goal}")));
        }
        let nodes = population * islands * self.aim.budget.nodes;
        if nodes > MAX_SEARCH_NODES {
            let message = format!(
                "{population} individuals on each of {islands} islands, of up to {} nodes, are {nodes} nodes, more than {MAX_SEARCH_NODES}: use fewer of them, or a smaller budget",
                self.aim.budget.nodes
            );
            return Err(RecordError::new("/settings/population", message));
        }
        let hours = self.most_ns() / 3.6e12;
        if self.most_ns() > MOST_NS {
            let message = format!(
                "all generations may take {hours:.1} hours of a processor, more than {:.0}: use fewer individuals, generations or samples, or a smaller budget",
                MOST_NS / 3.6e12
            );
            return Err(RecordError::new("/settings/generations", message));
        }
        Ok(())
    }

    /// The longest that it may take on one thread in nanoseconds, if every programme costs as much as the budget admits and nothing is enough.
    #[must_use]
    pub fn most_ns(&self) -> f64 {
        let Settings { population, islands, generations, elite, .. } = self.settings;
        let bred = population as f64 + (population.saturating_sub(elite) as f64) * generations as f64;
        let samples = ((self.aim.samples + 2) as f64) * ((self.aim.samples + 2) as f64);
        bred * islands as f64 * samples * (self.aim.budget.cost_ns + JUDGE_NS)
    }

    /// The first generation; `None` if it was stopped.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn begin(&self, stop: &Stop) -> Result<Option<Stage>, RecordError> {
        let first = Evolution::new(&self.aim, self.settings, self.seed, stop).map_err(settings_error)?;
        Ok(first.and_then(|evolution| Stage::of(evolution.into_state(), None)))
    }

    /// The next generation; `None` if it was stopped, and the stage is that of before then as well.
    ///
    /// # Errors
    /// If the stage is none of this search: its settings are other ones, or it is of another form.
    pub fn advance(&self, stage: Stage, stop: &Stop) -> Result<Option<Stage>, RecordError> {
        self.check_stage(&stage)?;
        let Stage { state, best, .. } = stage;
        let mut evolution = Evolution::resume(&self.aim, state).map_err(settings_error)?;
        Ok(if evolution.step(stop) { Stage::of(evolution.into_state(), Some(best)) } else { None })
    }

    /// Whether a stage is one of this search, as this version breeds it.
    ///
    /// # Errors
    /// If it is not; the error names what differs.
    pub fn check_stage(&self, stage: &Stage) -> Result<(), RecordError> {
        if stage.form != SEARCH_FORM {
            return Err(RecordError::new("/form", format!("must be {SEARCH_FORM}, the form that this version breeds, got {}", stage.form)));
        }
        if stage.state.settings != self.settings || stage.state.seed != self.seed {
            return Err(RecordError::new("/state", "must be of the settings and the seed of the search"));
        }
        Ok(())
    }

    /// Whether all generations are bred, or the best is good enough.
    #[must_use]
    pub fn is_over(&self, stage: &Stage) -> bool {
        stage.state.generation >= self.settings.generations || self.goal.is_some_and(|goal| stage.best.judgement.score >= goal)
    }
}

impl Stage {
    fn of(state: State<Genome, Judgement>, before: Option<Found>) -> Option<Self> {
        let best = state.best()?;
        let kept = before.filter(|found| found.judgement.score >= best.evaluation.score);
        let best = kept.unwrap_or_else(|| Found { generation: state.generation, genome: best.genome.clone(), judgement: best.evaluation.clone() });
        Some(Self { form: SEARCH_FORM, state, best })
    }

    /// The best of all generations so far; of equals the first.
    #[must_use]
    pub fn best(&self) -> &Found {
        &self.best
    }

    /// How far it is. Its best is that of the generation alone.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.state.progress()
    }

    /// The generation.
    #[must_use]
    pub fn state(&self) -> &State<Genome, Judgement> {
        &self.state
    }
}

fn settings_error(SettingsError { at, message }: SettingsError) -> RecordError {
    RecordError::new(format!("/settings{at}"), message)
}
