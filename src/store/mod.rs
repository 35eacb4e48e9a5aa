//! What a server keeps: every saved revision of every world.

mod error;
mod sqlite;

pub use error::StoreError;
pub use sqlite::{Condition, RevisionEntry, Saved, Store, StoredWorld};
