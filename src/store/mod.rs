//! What a server keeps: every saved revision of every world and of every programme of the library, the sets of features that worlds name, and keys; archives of tiles, which are databases too.

mod checkpoint;
mod content;
mod error;
mod feature_set;
mod generations;
mod keys;
mod layout;
mod mbtiles;
mod runs;
mod sqlite;

pub use checkpoint::{Log, Step, pack};
pub use content::{Content, Kind};
pub use error::StoreError;
pub use generations::{GenerationEntry, GenerationError, NewGeneration, StoredGeneration};
pub use keys::{KeyEntry, Scope, hash_of, is_signature, sign};
pub use mbtiles::MbTiles;
pub use runs::{JobEntry, JobState, RasterEntry};
pub use sqlite::{Beside, Condition, RevisionEntry, Saved, Store, StoredDocument};
