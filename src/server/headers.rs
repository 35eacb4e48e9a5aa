//! Validators and caching.

use super::extract::entity_tags;
use axum::{
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

/// How long an answer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Freshness {
    /// The address names a revision: for ever.
    Immutable,
    /// Ask again every time; the entity tag makes that cheap.
    Revalidate,
}

impl Freshness {
    pub(super) fn of(pinned: bool) -> Self {
        if pinned { Freshness::Immutable } else { Freshness::Revalidate }
    }

    fn value(self) -> HeaderValue {
        HeaderValue::from_static(match self {
            Freshness::Immutable => "public, max-age=31536000, immutable",
            Freshness::Revalidate => "no-cache",
        })
    }
}

/// Whether the request's `If-None-Match` holds the entity tag, so that 304 answers it.
pub(super) fn is_fresh(request: &HeaderMap, tag: &str) -> bool {
    let tags = entity_tags(request, header::IF_NONE_MATCH).unwrap_or_default();
    tags.iter().any(|known| known == "*" || known.trim_start_matches("W/").trim_matches('"') == tag)
}

/// Adds the entity tag and caching to an answer.
pub(super) fn tagged(response: impl IntoResponse, tag: &str, freshness: Freshness) -> Response {
    let mut response = response.into_response();
    let headers = response.headers_mut();
    if let Ok(value) = HeaderValue::from_str(&format!("\"{tag}\"")) {
        headers.insert(header::ETAG, value);
    }
    headers.insert(header::CACHE_CONTROL, freshness.value());
    response
}

/// 304 with the same headers.
pub(super) fn not_modified(tag: &str, freshness: Freshness) -> Response {
    tagged(StatusCode::NOT_MODIFIED, tag, freshness)
}
