//! Long work: pyramids of tiles as archives, evaluated on all threads, kept as they are done, resumed after any end.

mod archive;
mod hilbert;
mod part;
mod pyramid;
mod run;

pub use archive::{Archive, ArchiveError, merge};
pub use hilbert::Block;
pub use part::{Part, PartError};
pub use pyramid::{Plan, Pyramid, PyramidError, Shard};
pub use run::{Outcome, RunError, run};
