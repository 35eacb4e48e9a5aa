//! What is wrong with a programme, and where.

use std::ops::Range;

/// Why something is not a terrain programme.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", if at.is_empty() { String::new() } else { format!("at {at}: ") })]
pub struct ParseError {
    /// A JSON pointer into the tree: `/args/1`, or `/octaves` for a named parameter; empty for the root.
    pub at: String,
    /// Characters (Unicode scalar values) of the text that are wrong; `None` for JSON.
    pub span: Option<Range<usize>>,
    /// What is wrong and what would be right.
    pub message: String,
}

impl ParseError {
    pub(super) fn new(at: impl Into<String>, span: Option<Range<usize>>, message: impl Into<String>) -> Self {
        Self { at: at.into(), span, message: message.into() }
    }
}

/// Names longer than this are no misspelling of ours, and are not repeated whole.
const LONGEST_NAME: usize = 64;

/// A name as an error repeats it.
pub(super) fn shortened(name: &str) -> String {
    if name.chars().count() <= LONGEST_NAME { name.to_owned() } else { name.chars().take(LONGEST_NAME).chain(['…']).collect() }
}

/// ` (did you mean "…"?)` for the candidate that is nearest to a misspelt name, or nothing.
pub(super) fn suggestion<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> String {
    if name.len() > LONGEST_NAME {
        return String::new();
    }
    candidates
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        // Of equals the first: a default comes first.
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, candidate)| *distance <= 2.max(candidate.len() / 3) && *distance < name.chars().count().max(2))
        .map_or_else(String::new, |(_, candidate)| format!(" (did you mean \"{candidate}\"?)"))
}
