//! Genetic terrain programming: a designer chooses, programmes are bred (Frade, Fernández de Vega, Cotta 2009).

use super::{
    Budget, Genome, Mutation,
    operators::{cross, mutate},
    portrait::{Portrait, view_seed},
    record::{Choice, Kept, Record, RecordError},
    vocabulary::{Method, cheapest, grow},
};
use crate::genetic::{Draws, Purpose};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Individuals of a generation (table I).
pub const POPULATION: usize = 12;

/// Depth of the trees of the first generation (table I).
pub const FIRST_DEPTH: usize = 6;

/// Probability that a child of one parent is mutated (table I).
pub const ONE_PARENT_MUTATION: f64 = 0.5;

/// Probability that a child of two parents is crossed, else mutated (table I).
pub const TWO_PARENTS_CROSSOVER: f64 = 0.9;

/// How often a tree of the first generation is drawn, until there is something to see.
const FIRST_TRIES: u64 = 24;

/// How often a child is drawn that is over the budget, before its parent takes its place.
const CHILD_TRIES: u64 = 8;

/// How an individual came to be. Numbers are those of the generation before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// It was given.
    Given,
    /// It was grown at random.
    Grown,
    /// It was chosen, and lives on.
    Chosen(usize),
    /// A child that was neither crossed nor mutated.
    Copied(usize),
    /// A child of one parent.
    Mutated {
        /// Its parent.
        parent: usize,
        /// What was done.
        mutation: Mutation,
    },
    /// A child that has a subtree of the second parent in the place of one of the first.
    Crossed {
        /// Its parents.
        parents: [usize; 2],
    },
    /// All children that were drawn were over the budget: the parent took their place.
    Refused(usize),
}

/// One of a generation.
#[derive(Clone, Debug, PartialEq)]
pub struct Bred {
    /// The programme.
    pub genome: Genome,
    /// How it came to be.
    pub origin: Origin,
    /// How often it was drawn again because it was over the budget or, in the first generation, there was nothing to see.
    pub redrawn: u32,
}

impl Bred {
    fn unchanged(genome: Genome, origin: Origin) -> Self {
        Self { genome, origin, redrawn: 0 }
    }
}

/// A session of breeding: a [`Record`] with the generations that follow from it.
///
/// ```
/// use terrane::evolve::{Choice, Session};
/// let mut session = Session::new(7, &[])?;
/// session.choose(&Choice::of(&[3]))?;
/// session.choose(&Choice::of(&[0, 5]))?;
/// session.keep(2, "worn hills")?;
/// let json = serde_json::to_string(session.record())?;
/// let same = Session::replay(serde_json::from_str(&json)?)?;
/// assert_eq!(same.newest(), session.newest());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    record: Record,
    generations: Vec<Vec<Bred>>,
}

impl Session {
    /// Begins with given programmes, at most twelve, and grown ones in the places that are left.
    ///
    /// # Errors
    /// If the seed is above 2^53 - 1, there are more than twelve programmes or one is over the budget.
    pub fn new(seed: u64, programmes: &[Genome]) -> Result<Self, RecordError> {
        Self::replay(Record { seed, programmes: programmes.to_vec(), ..Record::default() })
    }

    /// Breeds all that a record says: the same programmes on every machine.
    ///
    /// # Errors
    /// If something in the record is not what it must be; the error names the place.
    pub fn replay(record: Record) -> Result<Self, RecordError> {
        record.check()?;
        let choices = record.choices.len();
        let first = first(&record);
        let mut session = Self { record, generations: vec![first] };
        for number in 0..choices {
            session.generations.push(session.bred(number));
        }
        Ok(session)
    }

    /// The session of a record that begins as this one's does: only what differs is bred.
    ///
    /// # Errors
    /// As [`Session::replay`].
    pub fn resume(&self, record: Record) -> Result<Self, RecordError> {
        let Record { seed, budget, programmes, choices, .. } = &self.record;
        if (seed, budget, programmes) != (&record.seed, &record.budget, &record.programmes) {
            return Self::replay(record);
        }
        record.check()?;
        let shared = choices.iter().zip(&record.choices).take_while(|(own, other)| own == other).count();
        let mut session = Self { generations: self.generations[..=shared].to_vec(), record };
        for number in shared..session.record.choices.len() {
            session.generations.push(session.bred(number));
        }
        Ok(session)
    }

    /// What the session follows from: to keep it and to share it.
    #[must_use]
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// All generations, the newest last.
    #[must_use]
    pub fn generations(&self) -> &[Vec<Bred>] {
        &self.generations
    }

    /// The newest generation.
    #[must_use]
    pub fn newest(&self) -> &[Bred] {
        self.generations.last().map_or(&[], Vec::as_slice)
    }

    /// The seed that the noises of all individuals are hashed with where they are shown.
    #[must_use]
    pub fn view_seed(&self) -> u64 {
        view_seed(self.record.seed)
    }

    /// An individual of the newest generation to be looked at.
    ///
    /// # Errors
    /// If there is no such individual.
    pub fn portrait(&self, individual: usize) -> Result<Portrait, RecordError> {
        let genome = &self.individual(individual, "/individual")?.genome;
        Portrait::new(genome, self.view_seed()).map_err(|error| RecordError::new("/individual", error.to_string()))
    }

    /// Breeds a generation of one or two individuals of the newest. What was chosen and undone can be bred differently: [`Choice::again`].
    ///
    /// # Errors
    /// If not one or two different individuals were chosen, there are no such, or the session has all generations it can have.
    pub fn choose(&mut self, choice: &Choice) -> Result<&[Bred], RecordError> {
        choice.check("")?;
        self.record.check_room()?;
        self.record.choices.push(choice.clone());
        let next = self.bred(self.record.choices.len() - 1);
        self.generations.push(next);
        Ok(self.newest())
    }

    /// Takes the newest choice back, and answers it; `None` in the first generation.
    pub fn undo(&mut self) -> Option<Choice> {
        let choice = self.record.choices.pop()?;
        self.generations.pop();
        Some(choice)
    }

    /// Another session that shares the generations up to one, and what was kept, and goes on by itself.
    ///
    /// # Errors
    /// If there is no such generation.
    pub fn branch(&self, generation: usize) -> Result<Self, RecordError> {
        if generation >= self.generations.len() {
            return Err(RecordError::new("/generation", format!("must be 0 … {}, got {generation}", self.generations.len() - 1)));
        }
        let mut branch = self.clone();
        branch.record.choices.truncate(generation);
        branch.generations.truncate(generation + 1);
        Ok(branch)
    }

    /// Keeps an individual of the newest generation under a name, also when its generation is undone. A name that is taken is given anew.
    ///
    /// # Errors
    /// If there is no such individual, the name is not 1 to 100 characters long, or as many are kept as can be.
    pub fn keep(&mut self, individual: usize, name: &str) -> Result<(), RecordError> {
        let programme = self.individual(individual, "/individual")?.genome.clone();
        let kept = Kept { name: name.to_owned(), generation: self.record.choices.len(), individual, programme };
        self.record.keep(kept)
    }

    /// Keeps something no more; whether it was kept.
    pub fn forget(&mut self, name: &str) -> bool {
        let before = self.record.kept.len();
        self.record.kept.retain(|kept| kept.name != name);
        self.record.kept.len() < before
    }

    /// How many children of all generations were replaced by their parents because they were over the budget.
    #[must_use]
    pub fn refused(&self) -> usize {
        self.generations.iter().flatten().filter(|bred| matches!(bred.origin, Origin::Refused(_))).count()
    }

    fn individual(&self, individual: usize, at: &str) -> Result<&Bred, RecordError> {
        self.newest().get(individual).ok_or_else(|| RecordError::new(at, format!("must be 0 … {}, got {individual}", POPULATION - 1)))
    }

    /// The generation that choice `number` breeds of the newest.
    fn bred(&self, number: usize) -> Vec<Bred> {
        let Choice { parents, again } = &self.record.choices[number];
        let chosen: Vec<(usize, &Genome)> = parents.iter().map(|&parent| (parent, &self.newest()[parent].genome)).collect();
        // What was chosen before counts, so that branches differ.
        let path = self.record.choices[..=number].iter().fold(self.record.seed, |key, choice| choice.key(key));
        let child = |individual: usize| match chosen.get(individual) {
            Some(&(parent, genome)) => Bred::unchanged(genome.clone(), Origin::Chosen(parent)),
            None => child(&chosen, &self.record.budget, |purpose, attempt| {
                Draws::of(path, &[number as u64 + 1, u64::from(*again), individual as u64, purpose as u64, attempt])
            }),
        };
        (0..POPULATION).into_par_iter().map(child).collect()
    }
}

/// A child of one or two parents.
fn child(chosen: &[(usize, &Genome)], budget: &Budget, draws: impl Fn(Purpose, u64) -> Draws) -> Bred {
    let mut select = draws(Purpose::Select, 0);
    // Which of two takes, and which gives.
    let taker = select.below(chosen.len());
    let (parent, genome) = chosen[taker];
    let crossed = chosen.len() > 1 && select.chance(TWO_PARENTS_CROSSOVER);
    if chosen.len() == 1 && !select.chance(ONE_PARENT_MUTATION) {
        return Bred::unchanged(genome.clone(), Origin::Copied(parent));
    }
    for attempt in 0..CHILD_TRIES {
        let (genome, origin) = if crossed {
            let (other, giver) = chosen[1 - taker];
            (cross(genome, giver, &mut draws(Purpose::Cross, attempt)), Origin::Crossed { parents: [parent, other] })
        } else {
            let (child, mutation) = mutate(genome, &mut draws(Purpose::Mutate, attempt));
            (child, Origin::Mutated { parent, mutation })
        };
        if budget.admit(&genome).is_some() {
            return Bred { genome, origin, redrawn: attempt as u32 };
        }
    }
    Bred { genome: genome.clone(), origin: Origin::Refused(parent), redrawn: CHILD_TRIES as u32 }
}

/// The given programmes, and grown ones in the places that are left.
fn first(record: &Record) -> Vec<Bred> {
    let grown = |individual: usize| {
        if let Some(genome) = record.programmes.get(individual) {
            return Bred::unchanged(genome.clone(), Origin::Given);
        }
        let draws = |attempt: u64| Draws::of(record.seed, &[0, 0, individual as u64, Purpose::Initialise as u64, attempt]);
        let (genome, redrawn) = grown(individual, &record.budget, view_seed(record.seed), draws);
        Bred { genome, origin: Origin::Grown, redrawn }
    };
    (0..POPULATION).into_par_iter().map(grown).collect()
}

/// A tree, ramped half-and-half: depths from 2 to [`FIRST_DEPTH`] in turn, every second full. Drawn again while there is nothing to see; of those over the budget none is
/// taken, and if all were, it is the cheapest noise. Answers how often it was drawn again, too.
pub(super) fn grown(number: usize, budget: &Budget, view_seed: u64, draws: impl Fn(u64) -> Draws) -> (Genome, u32) {
    let depth = (2 + number / 2 % (FIRST_DEPTH - 1)).min(budget.depth);
    let method = if number.is_multiple_of(2) { Method::Grow } else { Method::Full };
    let mut admitted = None;
    for attempt in 0..FIRST_TRIES {
        let genome = Genome::new(grow(depth, method, &mut draws(attempt)));
        let Some(tape) = budget.admit(&genome) else { continue };
        if Portrait::of(tape, view_seed).extent().is_worth_seeing {
            return (genome, attempt as u32);
        }
        admitted.get_or_insert(genome);
    }
    (admitted.unwrap_or_else(|| Genome::new(vec![cheapest(&mut draws(FIRST_TRIES))])), FIRST_TRIES as u32)
}
