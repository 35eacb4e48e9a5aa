//! Terrain that is bred: [programmes by a designer's choice](Session) or [by what is wanted of them](Aim), and [ground that evolves while it is used](Adaptive).

mod adaptive;
mod aim;
mod breeding;
mod budget;
mod fitness;
mod genome;
mod operators;
mod portrait;
mod record;
mod search;
mod sight;
#[cfg(test)]
mod tests;
mod vocabulary;

pub use adaptive::{
    Adaptive, AdaptiveTerrain, Feedback, Generation, Ground, HISTORY_FORM, History, MAX_HISTORY, MAX_LATTICE, MAX_POSITIONS, MAX_TREES, Players, Step,
};
pub use aim::{Aim, Judgement};
pub use breeding::{Bred, FIRST_DEPTH, ONE_PARENT_MUTATION, Origin, POPULATION, Session, TWO_PARENTS_CROSSOVER};
pub use budget::Budget;
pub use fitness::Wanted;
pub use genome::{Gene, Genome};
pub use operators::{Mutation, cross, mutate};
pub use portrait::{Extent, Portrait, VIEW_SIDE};
pub use record::{Choice, Kept, MAX_CHOICES, MAX_KEPT, MAX_SEED, RECORD_FORM, Record, RecordError};
pub use search::{Found, MAX_SEARCH_GENERATIONS, SEARCH_FORM, Search, Stage};
pub use sight::Sight;
