//! What can be wrong with `GeoJSON`, and how it is told.

use std::fmt;

/// Problems that are told at most; of those beyond, the number.
pub const MOST_PROBLEMS: usize = 100;

/// Something wrong with what was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// A JSON pointer (RFC 6901) into what was read; features that come one a line count as an array.
    pub pointer: String,
    /// What is wrong and what would be right. Of a feature, it begins with its id, or with its number counted from 0.
    pub detail: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", if self.pointer.is_empty() { "/" } else { &self.pointer }, self.detail)
    }
}

/// Why something is not the `GeoJSON` it should be.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It could not be read to its end.
    #[error("reading failed: {0}")]
    Io(std::io::Error),
    /// Every problem found.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Invalid(Vec<Problem>),
}

/// Problems found so far.
#[derive(Debug, Default)]
pub(super) struct Problems {
    list: Vec<Problem>,
    more: usize,
}

impl Problems {
    pub(super) fn add(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        if self.list.len() < MOST_PROBLEMS {
            self.list.push(Problem { pointer: pointer.into(), detail: detail.into() });
        } else {
            self.more += 1;
        }
    }

    pub(super) fn count(&self) -> usize {
        self.list.len() + self.more
    }

    /// Puts something before the pointers and details of all problems from number `first` on.
    pub(super) fn place(&mut self, first: usize, pointer: &str, detail: &str) {
        for problem in self.list.iter_mut().skip(first) {
            problem.pointer.insert_str(0, pointer);
            problem.detail.insert_str(0, detail);
        }
    }

    /// Whether there are as many as are told.
    pub(super) fn is_full(&self) -> bool {
        self.list.len() == MOST_PROBLEMS
    }

    /// All of them, if there are any.
    pub(super) fn into_result<T>(mut self, value: T) -> Result<T, ReadError> {
        if self.more > 0 {
            self.list.push(Problem { pointer: String::new(), detail: format!("and {} more problems", self.more) });
        }
        if self.list.is_empty() { Ok(value) } else { Err(ReadError::Invalid(self.list)) }
    }
}
