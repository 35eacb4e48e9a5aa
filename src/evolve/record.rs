//! Sessions of breeding as plain data.

use super::{Budget, Genome, breeding::POPULATION};
use crate::noise;
use serde::{Deserialize, Serialize};

/// What is bred from a record: it goes up when the same record would breed other programmes.
pub const RECORD_FORM: u32 = 1;

/// Most choices of a session.
pub const MAX_CHOICES: usize = 10_000;

/// Most individuals that a session keeps.
pub const MAX_KEPT: usize = 1_000;

/// The greatest seed, 2^53 - 1: greater ones are not whole in every reader of JSON.
pub const MAX_SEED: u64 = (1 << 53) - 1;

/// Something in a record that is not what it must be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", if at.is_empty() { String::new() } else { format!("at {at}: ") })]
pub struct RecordError {
    /// A JSON pointer.
    pub at: String,
    /// What would be right.
    pub message: String,
}

impl RecordError {
    pub(super) fn new(at: impl Into<String>, message: impl Into<String>) -> Self {
        Self { at: at.into(), message: message.into() }
    }
}

/// What a designer chose.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// One or two individuals of the generation, 0 … 11.
    pub parents: Vec<usize>,
    /// Another number breeds other children of the same parents.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub again: u32,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

impl Choice {
    /// Of these individuals.
    #[must_use]
    pub fn of(parents: &[usize]) -> Self {
        Self { parents: parents.to_vec(), again: 0 }
    }

    pub(super) fn check(&self, at: &str) -> Result<(), RecordError> {
        let at = format!("{at}/parents");
        match self.parents[..] {
            [a] if a < POPULATION => Ok(()),
            [a, b] if a != b && a < POPULATION && b < POPULATION => Ok(()),
            _ => Err(RecordError::new(at, format!("must be one or two different individuals, 0 … {}, got {:?}", POPULATION - 1, self.parents))),
        }
    }

    /// The key of a generation bred so of one with that key.
    pub(super) fn key(&self, parent: u64) -> u64 {
        let chosen = self.parents.iter().fold(noise::key(parent, self.parents.len() as u64), |key, &parent| noise::key(key, parent as u64));
        noise::key(chosen, self.again.into())
    }
}

/// An individual that was kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kept {
    /// 1 to 100 characters; no two are the same.
    pub name: String,
    /// The generation it was kept in, 0 the first.
    pub generation: usize,
    /// Which of the generation, 0 … 11.
    pub individual: usize,
    /// The programme itself, for generations can be undone.
    pub programme: Genome,
}

/// A session: all follows from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// [`RECORD_FORM`].
    pub form: u32,
    /// Hashed into every draw; 0 … 2^53 - 1.
    pub seed: u64,
    /// Limits of all programmes.
    #[serde(default)]
    pub budget: Budget,
    /// The first of the first generation, at most 12; the others are grown.
    #[serde(default)]
    pub programmes: Vec<Genome>,
    /// What was chosen, generation by generation.
    #[serde(default)]
    pub choices: Vec<Choice>,
    /// What was kept.
    #[serde(default)]
    pub kept: Vec<Kept>,
}

impl Default for Record {
    fn default() -> Self {
        Self { form: RECORD_FORM, seed: 0, budget: Budget::default(), programmes: Vec::new(), choices: Vec::new(), kept: Vec::new() }
    }
}

impl Record {
    /// Reads a record.
    ///
    /// # Errors
    /// If it is not one; the error names the place.
    pub fn parse(json: &[u8]) -> Result<Self, RecordError> {
        let record: Self = serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(json)).map_err(|error| place(&error))?;
        record.check()?;
        Ok(record)
    }

    pub(super) fn check(&self) -> Result<(), RecordError> {
        if self.form != RECORD_FORM {
            return Err(RecordError::new("/form", format!("must be {RECORD_FORM}, the form that this version reads, got {}", self.form)));
        }
        if self.seed > MAX_SEED {
            return Err(RecordError::new("/seed", format!("must be 0 … {MAX_SEED}, got {}", self.seed)));
        }
        if let Some((limit, message)) = self.budget.wrong() {
            return Err(RecordError::new(format!("/budget/{limit}"), message));
        }
        if self.programmes.len() > POPULATION {
            return Err(RecordError::new("/programmes", format!("must be at most {POPULATION}, got {}", self.programmes.len())));
        }
        if let Some(i) = self.programmes.iter().position(|genome| self.budget.admit(genome).is_none()) {
            return Err(RecordError::new(format!("/programmes/{i}"), self.over_budget()));
        }
        if self.choices.len() > MAX_CHOICES {
            return Err(RecordError::new("/choices", format!("must be at most {MAX_CHOICES}, got {}", self.choices.len())));
        }
        self.choices.iter().enumerate().try_for_each(|(i, choice)| choice.check(&format!("/choices/{i}")))?;
        (0..self.kept.len()).try_for_each(|i| self.check_kept(&self.kept[i], &format!("/kept/{i}")))
    }

    fn over_budget(&self) -> String {
        let Budget { nodes, depth, cost_ns } = self.budget;
        format!("is over the budget of {nodes} nodes, {depth} levels and {cost_ns} ns a sample: use fewer or simpler nodes or octaves")
    }

    pub(super) fn check_room(&self) -> Result<(), RecordError> {
        if self.choices.len() < MAX_CHOICES {
            return Ok(());
        }
        Err(RecordError::new("", format!("a session has at most {MAX_CHOICES} choices: begin another with the programmes of this one")))
    }

    fn check_kept(&self, kept: &Kept, at: &str) -> Result<(), RecordError> {
        if !(1..=100).contains(&kept.name.chars().count()) {
            return Err(RecordError::new(format!("{at}/name"), "must be 1 to 100 characters long"));
        }
        if self.kept.iter().filter(|other| other.name == kept.name).count() > 1 {
            return Err(RecordError::new(format!("{at}/name"), format!("is given twice: {:?}", kept.name)));
        }
        if kept.individual >= POPULATION {
            return Err(RecordError::new(format!("{at}/individual"), format!("must be 0 … {}, got {}", POPULATION - 1, kept.individual)));
        }
        if self.kept.len() > MAX_KEPT {
            return Err(RecordError::new("/kept", format!("must be at most {MAX_KEPT}, got {}", self.kept.len())));
        }
        Ok(())
    }

    pub(super) fn keep(&mut self, kept: Kept) -> Result<(), RecordError> {
        let before = self.kept.clone();
        self.kept.retain(|other| other.name != kept.name);
        self.kept.push(kept);
        let checked = self.check_kept(&self.kept[self.kept.len() - 1], "").map_err(|error| RecordError { at: error.at, ..error });
        if checked.is_err() {
            self.kept = before;
        }
        checked
    }
}

/// The error of a reader with the place where it stopped.
pub(super) fn place(error: &serde_path_to_error::Error<serde_json::Error>) -> RecordError {
    let path = error.path().to_string();
    let pointer: String =
        if path == "." { String::new() } else { path.split(['.', '[', ']']).filter(|part| !part.is_empty()).map(|part| format!("/{part}")).collect() };
    let message = error.inner().to_string();
    RecordError::new(pointer, message.split(" at line ").next().unwrap_or(&message))
}
