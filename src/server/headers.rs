//! Validators and caching.

use super::{
    error::ApiError,
    extract::entity_tags,
    tiles::{Class, Timing},
};
use axum::{
    http::{HeaderMap, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};
use sha2::{Digest, Sha256};

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

/// A JSON answer whose entity tag is the hash of its bytes, or 304 if the client has them.
pub(super) fn json(request: &HeaderMap, body: &impl serde::Serialize, freshness: Freshness) -> Result<Response, ApiError> {
    let bytes = serde_json::to_vec(body).map_err(|error| ApiError::internal("writing JSON", &error))?;
    Ok(hashed(request, "application/json", bytes, freshness))
}

/// An answer whose entity tag is the hash of its bytes, or 304 if the client has them.
pub(super) fn hashed(request: &HeaderMap, media_type: &'static str, bytes: Vec<u8>, freshness: Freshness) -> Response {
    let tag: String = Sha256::digest(&bytes).iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    if is_fresh(request, &tag) {
        return not_modified(&tag, freshness);
    }
    tagged(([(header::CONTENT_TYPE, media_type)], bytes), &tag, freshness)
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

/// How urgent a request says it is: `Priority` of RFC 9218 (`u=4` and above is not urgent) or `Sec-Purpose: prefetch`.
pub(super) fn class(request: &HeaderMap) -> Class {
    let text = |name: &str| request.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let urgency = text("priority").split(',').find_map(|part| part.trim().strip_prefix("u=")?.parse::<u8>().ok());
    let is_prefetch = text("sec-purpose").split([';', ',']).any(|part| part.trim() == "prefetch") || urgency.is_some_and(|urgency| urgency >= 4);
    if is_prefetch { Class::Prefetch } else { Class::Visible }
}

/// Adds how long an answer took to make, where it was made now.
pub(super) fn timed(mut response: Response, timing: Option<Timing>) -> Response {
    let Some(Timing { queued, evaluated }) = timing else { return response };
    let [queued, evaluated] = [queued, evaluated].map(|time| time.as_secs_f64() * 1e3);
    if let Ok(value) = HeaderValue::from_str(&format!("queue;dur={queued:.2}, evaluate;dur={evaluated:.2}")) {
        response.headers_mut().insert("server-timing", value);
    }
    response
}
