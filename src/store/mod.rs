//! What a server keeps: every saved revision of every world and of every programme of the library, and the sets of features that worlds name; archives of tiles, which are databases too.

mod content;
mod error;
mod feature_set;
mod layout;
mod mbtiles;
mod sqlite;

pub use content::{Content, Kind};
pub use error::StoreError;
pub use mbtiles::MbTiles;
pub use sqlite::{Condition, RevisionEntry, Saved, Store, StoredDocument};
