//! Worlds: the document that is the whole truth about a terrain, and its evaluation.

mod document;
mod evaluate;
mod examples;
mod fingerprint;
mod shader;
mod survey;

pub use document::{Base, Document, DocumentError, ElevationRange, GENERATOR, Problem, Revision};
pub use evaluate::World;
pub use examples::{EXAMPLES, Example};
pub use fingerprint::Fingerprint;
pub use survey::Survey;
