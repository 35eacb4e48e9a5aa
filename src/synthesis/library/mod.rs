//! Libraries of terrain types as people write them.

mod check;
mod ready;
#[cfg(test)]
mod tests;

use super::{
    grid::Crop,
    sample::{Format, Hints, Number, Unit},
    voids::Voids,
};
pub use ready::{ReadyLibrary, ReadySample};
use serde::{Deserialize, Serialize};

/// Something wrong with a library.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LibraryProblem {
    /// A JSON pointer (RFC 6901) into the document.
    pub pointer: String,
    /// What is wrong and what would be right.
    pub detail: String,
}

/// Why something is not the library it should be: every problem found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize)]
#[error("{}", .0.iter().map(|problem| format!("{}: {}", if problem.pointer.is_empty() { "/" } else { &problem.pointer }, problem.detail)).collect::<Vec<_>>().join("\n"))]
pub struct LibraryError(pub Vec<LibraryProblem>);

/// Types of terrain, each with samples, and how they meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// For people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// In the order in which others count them.
    pub types: Vec<TerrainType>,
    /// How smooth boundaries of two types are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seams: Vec<Seam>,
    /// How smooth the boundaries of all other pairs are, 0 … 1.
    #[serde(default = "usual_smoothness")]
    pub smoothness: f64,
}

fn usual_smoothness() -> f64 {
    0.5
}

fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A type of terrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerrainType {
    /// 1 to 63 of a … z, 0 … 9 and -.
    pub name: String,
    /// `#rrggbb`, on maps.
    pub colour: String,
    /// Examples of it.
    pub samples: Vec<LibrarySample>,
}

/// A sample of a type: which file it is, what the file does not say, and which part of it counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LibrarySample {
    /// The file's path from the library.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// SHA-256 of the file's bytes, 64 hexadecimal digits: instead of `file`, or to hold a file to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// See [`Hints::format`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<Format>,
    /// See [`Hints::spacing`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing: Option<[f64; 2]>,
    /// See [`Hints::unit`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// See [`Hints::void`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub void: Option<f64>,
    /// See [`Hints::size`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[usize; 2]>,
    /// See [`Hints::number`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<Number>,
    /// See [`Hints::range`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// See [`Hints::latitude`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latitude: Option<f64>,
    /// The part of the file that counts; the whole without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
    /// What becomes of voids.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub voids: Voids,
    /// Whether water is looked for and left out.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub without_water: bool,
}

impl LibrarySample {
    /// What is said about the file.
    #[must_use]
    pub fn hints(&self) -> Hints {
        Hints {
            format: self.format,
            spacing: self.spacing,
            unit: self.unit,
            void: self.void,
            size: self.size,
            number: self.number,
            range: self.range,
            latitude: self.latitude,
        }
    }

    /// What it is called: its file, else its hash.
    #[must_use]
    pub fn name(&self) -> &str {
        self.file.as_deref().or(self.sha256.as_deref()).unwrap_or_default()
    }
}

/// How two types meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seam {
    /// Names of two types.
    pub between: [String; 2],
    /// 0 (jagged) … 1 (straight).
    pub smoothness: f64,
}

impl Library {
    /// Reads a library and checks all that it says; files are read when it is [made ready](Self::ready).
    ///
    /// # Errors
    /// If it is not JSON, a field is missing, unknown or of the wrong type, or what it says cannot be meant.
    pub fn parse(json: &[u8]) -> Result<Self, LibraryError> {
        let library = check::read(json)?;
        check::check(&library)?;
        Ok(library)
    }

    /// How smooth the boundary between two types is.
    #[must_use]
    pub fn smoothness_between(&self, one: &str, other: &str) -> f64 {
        let meets = |seam: &&Seam| {
            let [first, second] = &seam.between;
            (first == one && second == other) || (first == other && second == one)
        };
        self.seams.iter().find(meets).map_or(self.smoothness, |seam| seam.smoothness)
    }
}
