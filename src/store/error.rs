//! Why the store did not do what was asked.

use super::Kind;

/// Why a call to the store failed.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The data folder cannot be made or used.
    #[error("the data folder {path}: {source}")]
    Folder {
        /// The folder.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// An archive cannot be begun.
    #[error("starting: {0}")]
    Archive(#[source] std::io::Error),
    /// Another server uses the folder.
    #[error("another server uses the data folder {0}: stop it, or give this one a folder of its own with --data")]
    InUse(String),
    /// The database was written by a newer version of the program.
    #[error("the database has layout {found}, this version of terrane knows {known}: use the version that wrote it, or a newer one")]
    Newer {
        /// The layout found.
        found: i64,
        /// The newest layout known.
        known: i64,
    },
    /// The database is that of an older version whose server runs.
    #[error("the database has layout {found}, this version of terrane has {known}, and an older server uses it: stop that first")]
    Older {
        /// The layout found.
        found: i64,
        /// The layout of this version.
        known: i64,
    },
    /// There is no such document.
    #[error("no {kind} is named {name:?}")]
    Unknown {
        /// What it would be.
        kind: Kind,
        /// The name.
        name: String,
    },
    /// The document is not at the revision, or in the state, that the caller asked for.
    #[error("the {kind} is {}, not what the request's condition asks for", .revision.as_ref().map_or_else(|| "absent".to_owned(), |revision| format!("at revision {revision}")))]
    Condition {
        /// What it is.
        kind: Kind,
        /// Where it is; `None` if it is absent.
        revision: Option<String>,
    },
    /// There is no such key.
    #[error("no key has the id {0:?}; `terrane key list` shows them")]
    UnknownKey(String),
    /// The system gives no random bytes.
    #[error("the system gives no random bytes: {0}")]
    Random(String),
    /// The database failed.
    #[error("the database: {0}")]
    Database(#[from] sqlx::Error),
}
