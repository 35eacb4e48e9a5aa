//! Around every request: its id, its count, its line in the log.

use super::{compute::panic_message, error::ApiError, state::App};
use axum::{
    extract::{MatchedPath, Request, State},
    http::{HeaderMap, HeaderName, HeaderValue, Method},
    middleware::Next,
    response::{IntoResponse, Response},
};
use futures_util::FutureExt;
use std::{
    hash::{BuildHasher, RandomState},
    panic::AssertUnwindSafe,
    sync::{
        Arc, LazyLock,
        atomic::{AtomicU64, Ordering},
    },
    time::Instant,
};

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const TRACE_PARENT: &str = "traceparent";

/// Most characters of a request's id.
const MAX_ID: usize = 128;

tokio::task_local! {
    /// The id of the request that a task answers. A span of `tracing` would write it down for every request, whether or not there is anything to log.
    static ID: HeaderValue;
}

/// The id of the request that this task answers; empty if it answers none.
pub(super) fn id() -> String {
    ID.try_with(|id| id.to_str().unwrap_or_default().to_owned()).unwrap_or_default()
}

/// Counts, times and logs a request. Its id is that of the client or proxy, the trace's, or a new one; answers and lines of the log carry it.
pub(super) async fn observe(State(app): State<App>, request: Request, next: Next) -> Response {
    let begun = Instant::now();
    let id = request_id(request.headers());
    let (method, route) = (name(request.method()), route(&request));
    let uri = request.uri().clone();
    let outcome = ID.scope(id.clone(), AssertUnwindSafe(next.run(request)).catch_unwind()).await;
    let mut response = outcome.unwrap_or_else(|payload| {
        app.0.metrics.panicked("handler");
        ID.sync_scope(id.clone(), || ApiError::internal("a handler panicked", &panic_message(&*payload))).into_response()
    });
    answered(&app, &Asked { begun, method, route, path: uri.path(), id }, &mut response);
    response
}

/// What is told of a request.
pub(super) struct Asked<'a> {
    pub begun: Instant,
    pub method: &'static str,
    pub route: Arc<str>,
    pub path: &'a str,
    pub id: HeaderValue,
}

/// Counts and logs an answer, and gives it the request's id.
pub(super) fn answered(app: &App, asked: &Asked, response: &mut Response) {
    let Asked { begun, method, route, path, id } = asked;
    let (status, took) = (response.status().as_u16(), begun.elapsed());
    app.0.metrics.answered(method, route, status, took);
    let (id_text, milliseconds) = (id.to_str().unwrap_or_default(), took.as_secs_f64() * 1e3);
    // Refusals come by the thousand when there is no time to write of them; they are counted.
    if status >= 500 && status != 503 {
        tracing::warn!(id = id_text, status, method, path, milliseconds, "answered");
    } else {
        tracing::debug!(id = id_text, status, method, path, milliseconds, "answered");
    }
    response.headers_mut().insert(REQUEST_ID, id.clone());
}

/// The id that came with a request, that of its trace (W3C Trace Context: version, 32 hex digits, …), or a new one.
pub(super) fn request_id(headers: &HeaderMap) -> HeaderValue {
    let is_id = |id: &&HeaderValue| !id.is_empty() && id.len() <= MAX_ID && id.as_bytes().iter().all(u8::is_ascii_graphic);
    let trace = || {
        let trace = headers.get(TRACE_PARENT)?.to_str().ok()?.split('-').nth(1)?;
        let is_trace = trace.len() == 32 && trace.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_trace.then(|| HeaderValue::from_str(trace).ok()).flatten()
    };
    headers.get(REQUEST_ID).filter(is_id).cloned().or_else(trace).unwrap_or_else(new_id)
}

/// An id that no other request of this or another process has.
fn new_id() -> HeaderValue {
    /// Keys that the system draws for every process.
    static KEYS: LazyLock<RandomState> = LazyLock::new(RandomState::new);
    static NEXT: AtomicU64 = AtomicU64::new(0);
    let id = KEYS.hash_one(NEXT.fetch_add(1, Ordering::Relaxed));
    let digit = |place: u32| b"0123456789abcdef"[(id >> (60 - 4 * place)) as usize & 15];
    let digits: [u8; 16] = std::array::from_fn(|place| digit(place as u32));
    HeaderValue::from_bytes(&digits).unwrap_or_else(|_| HeaderValue::from_static("0"))
}

/// The route of a request, so that there are few of them; files of the viewer and what is not there are one.
fn route(request: &Request) -> Arc<str> {
    static OTHER: LazyLock<Arc<str>> = LazyLock::new(|| "other".into());
    request.extensions().get::<MatchedPath>().map_or_else(|| Arc::clone(&OTHER), |path| path.as_str().into())
}

/// A method's name; those that no resource has are one.
fn name(method: &Method) -> &'static str {
    match *method {
        Method::GET => "GET",
        Method::HEAD => "HEAD",
        Method::POST => "POST",
        Method::PUT => "PUT",
        Method::DELETE => "DELETE",
        Method::OPTIONS => "OPTIONS",
        _ => "other",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_comes_from_the_client_the_trace_or_is_new() {
        let id = |headers: &[(&'static str, &str)]| {
            let headers = headers.iter().map(|(name, value)| (HeaderName::from_static(name), HeaderValue::from_str(value).expect("a value")));
            request_id(&headers.collect()).to_str().expect("text").to_owned()
        };
        let trace = ("traceparent", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01");
        assert_eq!(id(&[("x-request-id", "a-1"), trace]), "a-1");
        assert_eq!(id(&[("x-request-id", "a b"), trace]), "4bf92f3577b34da6a3ce929d0e0e4736");
        let new = [id(&[]), id(&[("traceparent", "00-xyz-1")]), id(&[("x-request-id", &"a".repeat(129))])];
        assert!(new.iter().all(|id| id.len() == 16) && new[0] != new[1] && new[1] != new[2], "{new:?}");
    }
}
