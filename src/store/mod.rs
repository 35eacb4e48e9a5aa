//! What a server keeps: every saved revision of every world and of every programme of the library.

mod content;
mod error;
mod layout;
mod sqlite;

pub use content::{Content, Kind};
pub use error::StoreError;
pub use sqlite::{Condition, RevisionEntry, Saved, Store, StoredDocument};
