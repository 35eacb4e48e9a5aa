//! Generations of individuals on islands.

use super::{
    draws::{Draws, Purpose},
    select::ranking,
    settings::{Settings, SettingsError, Variation},
};
use crate::geometry::Stop;
use rayon::prelude::*;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::{ops::Deref, sync::Arc};

/// What a genetic algorithm must know of what it breeds.
///
/// Every method is a function of its arguments alone, and all randomness comes from the draws that it is given.
pub trait Problem: Sync {
    /// What is inherited.
    type Genome: Clone + Send + Sync;
    /// What is known of a genome once it was evaluated: as much as the evaluation of a child can use.
    type Evaluation: Send + Sync;
    /// What crossover and mutation changed in a copy of its parent.
    type Change: Default + Send;

    /// The genome of individual `number` of an island's first generation.
    fn initialise(&self, number: usize, draws: &mut Draws) -> Self::Genome;

    /// Takes something of a mate into a copy of the first parent.
    fn cross(&self, child: &mut Self::Genome, mate: &Self::Genome, change: &mut Self::Change, draws: &mut Draws);

    /// Changes something in a copy of a parent, perhaps crossed. The evaluation is its parent's.
    fn mutate(&self, child: &mut Self::Genome, parent: &Self::Evaluation, change: &mut Self::Change, draws: &mut Draws);

    /// Evaluates a genome; `from` is the evaluation of the parent that it is a changed copy of, so that only what changed need be evaluated. Stopped, the
    /// result is thrown away.
    fn evaluate(&self, genome: &Self::Genome, from: Option<(&Self::Evaluation, &Self::Change)>, stop: &Stop) -> Self::Evaluation;

    /// How fit it is: more is better. What is not a number is the least of all.
    fn fitness(&self, evaluation: &Self::Evaluation) -> f64;
}

/// A genome with what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Individual<G, E> {
    /// What is inherited.
    pub genome: G,
    /// What it evaluates to.
    pub evaluation: E,
    /// How fit it is.
    pub fitness: f64,
}

/// Something that generations share while it lives on.
#[derive(Debug, PartialEq)]
pub struct Shared<T>(Arc<T>);

impl<T> Shared<T> {
    /// Of something that nobody shares yet.
    pub fn new(value: T) -> Self {
        Self(Arc::new(value))
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: Serialize> Serialize for Shared<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Shared<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        T::deserialize(deserializer).map(|value| Self(Arc::new(value)))
    }
}

/// The individuals of an island.
pub type Island<G, E> = Vec<Shared<Individual<G, E>>>;

/// All that an evolution goes on from: written down after a generation and read again, it goes on to the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State<G, E> {
    /// Hashed into every draw.
    pub seed: u64,
    /// How individuals are bred.
    pub settings: Settings,
    /// How many generations were bred from the first.
    pub generation: usize,
    /// How many genomes were evaluated.
    pub evaluations: u64,
    /// The individuals, island by island.
    pub islands: Vec<Island<G, E>>,
}

/// How far an evolution is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Generations bred.
    pub generation: usize,
    /// Generations wanted.
    pub of: usize,
    /// The greatest fitness.
    pub best: f64,
    /// The mean fitness.
    pub mean: f64,
    /// Genomes evaluated.
    pub evaluations: u64,
}

impl<G, E> State<G, E> {
    /// All individuals.
    pub fn individuals(&self) -> impl Iterator<Item = &Individual<G, E>> {
        self.islands.iter().flatten().map(Deref::deref)
    }

    /// The fittest individual; of equals the first.
    #[must_use]
    pub fn best(&self) -> Option<&Individual<G, E>> {
        self.individuals().reduce(|best, other| if other.fitness > best.fitness { other } else { best })
    }

    /// How far it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let count = self.individuals().count().max(1);
        // Each divided first: so many of the least there is must not sum up to infinity.
        let mean = self.individuals().map(|individual| individual.fitness / count as f64).sum();
        let best = self.best().map_or(f64::MIN, |best| best.fitness);
        Progress { generation: self.generation, of: self.settings.generations, best, mean, evaluations: self.evaluations }
    }
}

type Member<P> = Shared<Individual<<P as Problem>::Genome, <P as Problem>::Evaluation>>;
type StateOf<P> = State<<P as Problem>::Genome, <P as Problem>::Evaluation>;

/// A problem and the generations bred for it so far.
///
/// The same seed gives the same generations at any number of threads: whatever is drawn is hashed from seed, generation, island, individual and purpose.
pub struct Evolution<'a, P: Problem> {
    problem: &'a P,
    state: StateOf<P>,
}

impl<'a, P: Problem> Evolution<'a, P> {
    /// Makes the first generation; `None` if it was stopped.
    ///
    /// # Errors
    /// If a setting is out of its range.
    pub fn new(problem: &'a P, settings: Settings, seed: u64, stop: &Stop) -> Result<Option<Self>, SettingsError> {
        settings.check()?;
        let born = |i: usize| {
            let (island, number) = (i / settings.population, i % settings.population);
            let genome = problem.initialise(number, &mut Draws::individual(seed, 0, island, number, Purpose::Initialise));
            evaluated(problem, genome, None, stop)
        };
        let count = settings.islands * settings.population;
        let all: Vec<Member<P>> = (0..count).into_par_iter().map(born).collect();
        let islands = all.chunks(settings.population).map(<[_]>::to_vec).collect();
        let state = State { seed, settings, generation: 0, evaluations: count as u64, islands };
        Ok((!stop.is_set()).then_some(Self { problem, state }))
    }

    /// Goes on from where another left off.
    ///
    /// # Errors
    /// If a setting is out of its range or the islands are not as large as the settings say.
    pub fn resume(problem: &'a P, state: StateOf<P>) -> Result<Self, SettingsError> {
        state.settings.check()?;
        let Settings { population, islands, .. } = state.settings;
        if state.islands.len() != islands {
            return Err(SettingsError::new("/islands", format!("must be {islands} islands as the settings say, got {}", state.islands.len())));
        }
        if let Some(i) = state.islands.iter().position(|island| island.len() != population) {
            return Err(SettingsError::new(format!("/islands/{i}"), format!("must hold {population} individuals, got {}", state.islands[i].len())));
        }
        Ok(Self { problem, state })
    }

    /// The generations so far.
    #[must_use]
    pub fn state(&self) -> &StateOf<P> {
        &self.state
    }

    /// The generations so far, to keep.
    #[must_use]
    pub fn into_state(self) -> StateOf<P> {
        self.state
    }

    /// Breeds until all generations are bred, it is stopped, or `each`, which sees every generation from the one it begins with, says that it is enough. A
    /// generation under way when it is stopped is given up: the state is that of the last whole one. Answers whether it came to its end.
    pub fn run(&mut self, stop: &Stop, each: &mut dyn FnMut(&StateOf<P>) -> bool) -> bool {
        let mut goes_on = each(&self.state);
        while goes_on && self.state.generation < self.state.settings.generations {
            if !self.step(stop) {
                return false;
            }
            goes_on = each(&self.state);
        }
        true
    }

    /// Breeds one generation; `false`, and nothing is changed, if it was stopped.
    pub fn step(&mut self, stop: &Stop) -> bool {
        let Settings { population, islands, elite, migration, .. } = self.state.settings;
        let generation = self.state.generation + 1;
        let fitness: Vec<Vec<f64>> = self.state.islands.iter().map(|island| island.iter().map(|member| member.fitness).collect()).collect();
        let ranks: Vec<Vec<usize>> = fitness.iter().map(|fitness| ranking(fitness)).collect();
        let member = |i: usize| {
            let (island, number) = (i / population, i % population);
            if number < elite {
                return (self.state.islands[island][ranks[island][number]].clone(), false);
            }
            self.child(generation, [island, number], &fitness[island], stop)
        };
        let all: Vec<(Member<P>, bool)> = (0..islands * population).into_par_iter().map(member).collect();
        if stop.is_set() {
            return false;
        }
        self.state.evaluations += all.iter().filter(|(_, evaluated)| *evaluated).count() as u64;
        self.state.islands = all.chunks(population).map(|island| island.iter().map(|(member, _)| member.clone()).collect()).collect();
        if migration.every > 0 && generation.is_multiple_of(migration.every) {
            self.migrate();
        }
        self.state.generation = generation;
        true
    }

    /// An individual of the next generation, and whether it was evaluated: a copy of its parent is its parent.
    fn child(&self, generation: usize, [island, number]: [usize; 2], fitness: &[f64], stop: &Stop) -> (Member<P>, bool) {
        let Settings { selection, variation, .. } = self.state.settings;
        let draws = |purpose| Draws::individual(self.state.seed, generation, island, number, purpose);
        let mut select = draws(Purpose::Select);
        let parent = &self.state.islands[island][selection.choose(fitness, &mut select)];
        let (crossed, mutated) = match variation {
            Variation::Either { crossover, mutation } => {
                let share = select.unit();
                (share < crossover, share >= crossover && share < crossover + mutation)
            }
            Variation::Both { crossover, mutation } => (select.chance(crossover), select.chance(mutation)),
        };
        if !crossed && !mutated {
            return (parent.clone(), false);
        }
        let (mut genome, mut change) = (parent.genome.clone(), P::Change::default());
        if crossed {
            let mate = &self.state.islands[island][selection.choose(fitness, &mut select)];
            self.problem.cross(&mut genome, &mate.genome, &mut change, &mut draws(Purpose::Cross));
        }
        if mutated {
            self.problem.mutate(&mut genome, &parent.evaluation, &mut change, &mut draws(Purpose::Mutate));
        }
        (evaluated(self.problem, genome, Some((&parent.evaluation, &change)), stop), true)
    }

    /// The fittest of every island replace the least fit of the next, all at once.
    fn migrate(&mut self) {
        let count = self.state.settings.migration.count;
        let ranks: Vec<Vec<usize>> = self.state.islands.iter().map(|island| ranking(&island.iter().map(|member| member.fitness).collect::<Vec<_>>())).collect();
        let before = self.state.islands.clone();
        let islands = before.len();
        for island in (0..islands).filter(|_| islands > 1) {
            let next = (island + 1) % islands;
            for (from, to) in ranks[island].iter().zip(ranks[next].iter().rev()).take(count) {
                self.state.islands[next][*to] = before[island][*from].clone();
            }
        }
    }
}

/// A genome with its evaluation, once it is known; where the work was stopped it is evaluated all the same, which is quick then.
fn evaluated<P: Problem>(problem: &P, genome: P::Genome, from: Option<(&P::Evaluation, &P::Change)>, stop: &Stop) -> Member<P> {
    let evaluation = problem.evaluate(&genome, from, stop);
    let fitness = problem.fitness(&evaluation);
    // What has no place among numbers, nor in JSON, is the least.
    let fitness = if fitness.is_nan() { f64::MIN } else { fitness.clamp(f64::MIN, f64::MAX) };
    Shared(Arc::new(Individual { genome, evaluation, fitness }))
}
