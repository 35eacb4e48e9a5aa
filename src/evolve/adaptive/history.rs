//! Generations, kept and bred.

use super::{
    players::Players,
    settings::{Feedback, Ground, HISTORY_FORM, History, MAX_HISTORY, Step},
    state::State,
    terrain::AdaptiveTerrain,
};
use crate::evolve::record::RecordError;
use std::{collections::BTreeMap, sync::Arc};

/// Every so many generations one is kept in memory for good: others are bred again from it when they are asked for.
const KEPT: usize = 32;

/// Of the newest generations this many are kept, too.
const NEWEST: usize = 8;

/// A terrain that evolves: its [`History`] with generations of it.
///
/// ```
/// use terrane::evolve::{Adaptive, Feedback, Ground};
/// let mut terrain = Adaptive::new(Ground { seed: 7, ..Ground::default() })?;
/// let newest = terrain.feed(Feedback::point([400.0, 900.0]))?;
/// assert_eq!((newest, terrain.current()), (1, 1));
/// assert!(terrain.feed(Feedback::point([-400.0, 900.0])).is_err(), "off the terrain");
/// let same = Adaptive::replay(terrain.history().clone())?;
/// assert_eq!(same.terrain(1)?, terrain.terrain(1)?);
/// # Ok::<(), terrane::evolve::RecordError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Adaptive {
    history: History,
    kept: BTreeMap<usize, Arc<State>>,
}

impl Adaptive {
    /// A terrain of one generation.
    ///
    /// # Errors
    /// If a number of the ground is not what it must be.
    pub fn new(ground: Ground) -> Result<Self, RecordError> {
        Self::replay(History { form: HISTORY_FORM, ground, steps: Vec::new(), current: 0 })
    }

    /// Breeds all that a history says: the same heights on every machine.
    ///
    /// # Errors
    /// If something in the history is not what it must be; the error names the place.
    pub fn replay(history: History) -> Result<Self, RecordError> {
        history.check()?;
        let mut adaptive = Self { kept: BTreeMap::from([(0, Arc::new(State::first(&history.ground)))]), history };
        for (i, step) in adaptive.history.steps.clone().iter().enumerate() {
            let next = adaptive.bred(i + 1, step).map_err(|error| RecordError::new(format!("/steps/{i}/feedback{}", error.at), error.message))?;
            adaptive.keep(i + 1, next);
        }
        Ok(adaptive)
    }

    /// What all follows from: to keep it and to share it.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// How many generations there are.
    #[must_use]
    pub fn generations(&self) -> usize {
        self.history.steps.len() + 1
    }

    /// The generation that is shown, and bred from next.
    #[must_use]
    pub fn current(&self) -> usize {
        self.history.current
    }

    /// The terrain of a generation.
    ///
    /// # Errors
    /// If there is no such generation.
    pub fn terrain(&self, generation: usize) -> Result<AdaptiveTerrain, RecordError> {
        self.generation(generation).map(|generation| generation.terrain.clone())
    }

    /// Breeds a generation of the current one, which becomes the current one; answers its number.
    ///
    /// # Errors
    /// If the feedback lies off the terrain or is not what it must be otherwise, or there are all generations there can be: nothing is changed then.
    pub fn feed(&mut self, feedback: Feedback) -> Result<usize, RecordError> {
        feedback.check(&self.history.ground, "")?;
        let number = self.generations();
        if number > MAX_HISTORY {
            return Err(RecordError::new("", format!("the terrain has all {MAX_HISTORY} generations it can have: begin another")));
        }
        let step = Step { from: self.history.current, feedback };
        let next = self.bred(number, &step)?;
        self.history.steps.push(step);
        self.history.current = number;
        self.keep(number, next);
        Ok(number)
    }

    /// Goes to another generation, from which the next is bred. Generations in between stay.
    ///
    /// # Errors
    /// If there is no such generation, or a player is on the terrain or so near that it was promised not to change there.
    pub fn go_to(&mut self, generation: usize, players: &Players) -> Result<(), RecordError> {
        let area = self.terrain(generation)?.area();
        if let Some(player) = players.within(&area, self.history.ground.promise) {
            let message = format!("{player:?} is on the terrain: it was promised that nothing changes around players, wait until all have left");
            return Err(RecordError::new("/generation", message));
        }
        self.history.current = generation;
        Ok(())
    }

    fn keep(&mut self, number: usize, generation: State) {
        self.kept.insert(number, Arc::new(generation));
        self.kept.retain(|&kept, _| kept.is_multiple_of(KEPT) || kept + NEWEST > number);
    }

    /// A generation that is kept, or bred again from one that is.
    fn generation(&self, number: usize) -> Result<Arc<State>, RecordError> {
        if number >= self.generations() {
            return Err(RecordError::new("/generation", format!("must be 0 … {}, got {number}", self.generations() - 1)));
        }
        let (mut way, mut at) = (Vec::new(), number);
        while !self.kept.contains_key(&at) {
            way.push(at);
            at = self.history.steps[at - 1].from;
        }
        let mut generation = Arc::clone(&self.kept[&at]);
        for number in way.into_iter().rev() {
            generation = Arc::new(generation.next(&self.history.ground, number, &self.history.steps[number - 1].feedback)?);
        }
        Ok(generation)
    }

    fn bred(&self, number: usize, step: &Step) -> Result<State, RecordError> {
        self.generation(step.from)?.next(&self.history.ground, number, &step.feedback)
    }
}
