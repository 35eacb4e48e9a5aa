//! How a document's content is named.

use serde::Serialize;
use sha2::{Digest, Sha256};
use std::fmt;

/// The name of a document's content: the first 32 hex digits of SHA-256 of its canonical form (RFC 8785).
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub struct Revision(String);

impl Revision {
    /// The name of a document's content.
    ///
    /// # Panics
    /// If it has keys that are no strings, or numbers that are not finite.
    #[must_use]
    pub fn of(document: &impl Serialize) -> Self {
        let canonical = serde_json_canonicalizer::to_vec(document).expect("a document has only string keys and finite numbers");
        Self(Sha256::digest(canonical).iter().take(16).map(|byte| format!("{byte:02x}")).collect())
    }

    /// The 32 hex digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Reads 32 lower-case hex digits.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let hex = text.len() == 32 && text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
        hex.then(|| Self(text.to_owned()))
    }
}

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
