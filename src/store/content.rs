//! What the store keeps by name.

use crate::{
    evolve::Record,
    world::{Document, Preset, Revision},
};
use std::fmt;

/// The kinds of documents; each has names of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A world.
    World,
    /// A programme of the library.
    Programme,
    /// A session of breeding.
    Session,
}

impl Kind {
    /// Its name in the database and in messages.
    #[must_use]
    pub fn noun(self) -> &'static str {
        match self {
            Kind::World => "world",
            Kind::Programme => "programme",
            Kind::Session => "session",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.noun())
    }
}

/// A document as the store keeps it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// What it is.
    pub kind: Kind,
    /// The name of the content.
    pub revision: Revision,
    /// The document.
    pub body: String,
}

impl From<&Document> for Content {
    fn from(document: &Document) -> Self {
        Self { kind: Kind::World, revision: document.revision(), body: document.to_json() }
    }
}

impl From<&Preset> for Content {
    fn from(preset: &Preset) -> Self {
        Self { kind: Kind::Programme, revision: preset.revision(), body: preset.to_json() }
    }
}

impl From<&Record> for Content {
    fn from(record: &Record) -> Self {
        // A record has only string keys and finite numbers.
        Self { kind: Kind::Session, revision: Revision::of(record), body: serde_json::to_string_pretty(record).unwrap_or_default() }
    }
}
