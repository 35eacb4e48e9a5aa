//! What a list of the library is narrowed to.

use super::{error::ApiError, library::Shown, shelf::Shelved};
use axum::{
    extract::{FromRequestParts, Query},
    http::request::Parts,
};

/// `?tag=` and `?q=`: every tag, and every word somewhere in what is said about a programme.
#[derive(Debug, Default)]
pub(super) struct Search {
    tags: Vec<String>,
    words: Vec<String>,
}

impl<S: Send + Sync> FromRequestParts<S> for Search {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        // A pair each, since a tag may be given more than once.
        let Ok(Query(pairs)) = Query::<Vec<(String, String)>>::from_request_parts(parts, state).await else {
            return Err(ApiError::parameter("query", "must be UTF-8, as in tag=desert&q=dunes"));
        };
        let mut search = Self::default();
        for (name, value) in pairs {
            match name.as_str() {
                "tag" => search.tags.push(value),
                "q" => search.words.extend(value.split_whitespace().map(str::to_lowercase)),
                _ => return Err(ApiError::parameter(&name, format!("unknown field `{name}`, expected `tag` or `q`"))),
            }
        }
        Ok(search)
    }
}

impl Search {
    /// Whether a programme has every tag, and every word in its name, title, description, tags or origin.
    pub(super) fn finds(&self, shown: &Shown) -> bool {
        let preset = shown.document();
        if !self.tags.iter().all(|tag| preset.tags.contains(tag)) {
            return false;
        }
        if self.words.is_empty() {
            return true;
        }
        let said = [shown.name(), shown.title(), preset.description.as_deref().unwrap_or_default(), &preset.origin, &preset.tags.join(" ")];
        let said = said.join("\n").to_lowercase();
        self.words.iter().all(|word| said.contains(word))
    }
}
