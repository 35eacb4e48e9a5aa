//! Errors by who caused them, and their form on the wire: `application/problem+json` (RFC 9457).

use super::{budget::Spent, compute::Panicked, observe, schema, shelf::LoadError, tiles::TileFailure};
use crate::{
    store::{Kind, Scope, StoreError},
    world::{DocumentError, Problem},
};
use axum::{
    Json,
    http::{HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

/// What one wrong part of a request is.
pub(super) type Entry = schema::ProblemEntry;

/// Why a request is not answered as asked.
#[derive(Debug)]
pub(super) enum ApiError {
    /// The request is malformed; each entry names a parameter.
    BadRequest(String, Vec<Entry>),
    /// There is no such thing; entries say which part of the address is wrong.
    NotFound(String, Vec<Entry>),
    /// The method is not one of the resource's.
    MethodNotAllowed,
    /// The name is taken.
    Conflict(String),
    /// A condition of the request does not hold.
    PreconditionFailed(String),
    /// The body is larger than allowed.
    TooLarge(usize),
    /// What a job is asked for was understood and is wrong.
    InvalidWork(Vec<Entry>),
    /// The document was understood and is wrong.
    Invalid(Kind, Vec<Entry>),
    /// Feedback, or what goes with it, was understood and is wrong.
    InvalidFeedback(Vec<Entry>),
    /// Features were understood and are wrong.
    InvalidFeatures(Vec<Entry>),
    /// A web page of another origin tries to write.
    CrossSite,
    /// The request may come from another machine, and the server cannot tell who may write.
    ReadOnly,
    /// The request needs a key that it does not have: what is wrong.
    Unauthorized(&'static str),
    /// Its key is for less than this.
    Scope(Scope),
    /// A body is compressed, in this way.
    Packed(String),
    /// The client has used up a budget.
    Spent(Spent),
    /// More work waits than the server takes.
    Overloaded,
    /// More jobs wait than the server takes.
    Queued,
    /// More exports are under way than the server takes.
    Exporting,
    /// More requests are under way than the server takes.
    Busy,
    /// Evaluations of this revision have failed too often.
    SetAside,
    /// The server failed.
    Internal,
}

impl ApiError {
    /// A wrong query or path parameter.
    pub(super) fn parameter(name: &str, detail: impl Into<String>) -> Self {
        ApiError::BadRequest("A parameter is wrong.".to_owned(), vec![Entry::parameter(name, detail)])
    }

    /// A part of the path that names nothing.
    pub(super) fn absent(name: &str, detail: impl Into<String>) -> Self {
        let detail = detail.into();
        ApiError::NotFound(detail.clone(), vec![Entry::parameter(name, detail)])
    }

    /// A failure that is logged here, once, and not told.
    pub(super) fn internal(what: &str, error: &dyn std::fmt::Display) -> Self {
        tracing::error!(id = observe::id(), %error, "{what}");
        ApiError::Internal
    }

    /// Why a body is not a document of a kind.
    pub(super) fn document(kind: Kind, error: DocumentError) -> Self {
        Self::wrong(error, |errors| ApiError::Invalid(kind, errors))
    }

    /// Why a job cannot be asked for.
    pub(super) fn work(error: DocumentError) -> Self {
        Self::wrong(error, ApiError::InvalidWork)
    }

    /// Why feedback is not taken.
    pub(super) fn feedback(error: DocumentError) -> Self {
        Self::wrong(error, ApiError::InvalidFeedback)
    }

    fn wrong(error: DocumentError, invalid: impl FnOnce(Vec<Entry>) -> Self) -> Self {
        match error {
            DocumentError::Syntax(detail) => ApiError::BadRequest(format!("The body is not JSON: {detail}."), Vec::new()),
            DocumentError::Invalid(problems) => invalid(problems.into_iter().map(Entry::from).collect()),
        }
    }

    fn parts(self) -> (StatusCode, &'static str, String, Vec<Entry>) {
        match self {
            ApiError::BadRequest(detail, errors) => (StatusCode::BAD_REQUEST, "bad-request", detail, errors),
            ApiError::NotFound(detail, errors) => (StatusCode::NOT_FOUND, "not-found", detail, errors),
            ApiError::MethodNotAllowed => {
                let detail = "This resource does not have that method; the Allow header lists those it has.";
                (StatusCode::METHOD_NOT_ALLOWED, "method-not-allowed", detail.to_owned(), Vec::new())
            }
            ApiError::Conflict(detail) => (StatusCode::CONFLICT, "conflict", detail, Vec::new()),
            ApiError::PreconditionFailed(detail) => (StatusCode::PRECONDITION_FAILED, "precondition-failed", detail, Vec::new()),
            ApiError::TooLarge(limit) => (StatusCode::PAYLOAD_TOO_LARGE, "too-large", format!("The body must be at most {limit} bytes."), Vec::new()),
            ApiError::Invalid(kind, errors) => {
                let detail = format!("The {kind} document has {} problem{}.", errors.len(), if errors.len() == 1 { "" } else { "s" });
                let invalid = match kind {
                    Kind::World => "invalid-world",
                    Kind::Programme => "invalid-programme",
                    Kind::Session => "invalid-session",
                };
                (StatusCode::UNPROCESSABLE_ENTITY, invalid, detail, errors)
            }
            ApiError::InvalidWork(errors) => {
                let detail = format!("What is asked for has {} problem{}; nothing was stored.", errors.len(), if errors.len() == 1 { "" } else { "s" });
                (StatusCode::UNPROCESSABLE_ENTITY, "invalid-job", detail, errors)
            }
            ApiError::InvalidFeedback(errors) => {
                let detail = format!("What is asked for has {} problem{}; nothing was changed.", errors.len(), if errors.len() == 1 { "" } else { "s" });
                (StatusCode::UNPROCESSABLE_ENTITY, "invalid-feedback", detail, errors)
            }
            ApiError::InvalidFeatures(errors) => {
                let detail = format!("The features have {} problem{}; nothing was stored.", errors.len(), if errors.len() == 1 { "" } else { "s" });
                (StatusCode::UNPROCESSABLE_ENTITY, "invalid-features", detail, errors)
            }
            ApiError::CrossSite => {
                let detail = "Web pages of other sites may read but not write.";
                (StatusCode::FORBIDDEN, "cross-site", detail.to_owned(), Vec::new())
            }
            ApiError::ReadOnly => {
                let detail = "Without keys, worlds and programmes are written on the server's own machine alone (http://localhost:PORT, no proxy). `terrane key new` makes a key for others.";
                (StatusCode::FORBIDDEN, "read-only", detail.to_owned(), Vec::new())
            }
            ApiError::Unauthorized(detail) => (StatusCode::UNAUTHORIZED, "unauthorized", detail.to_owned(), Vec::new()),
            ApiError::Scope(needed) => (StatusCode::FORBIDDEN, "scope", format!("This key's scope does not reach: {needed} is needed."), Vec::new()),
            ApiError::Packed(name) => {
                let detail = format!("The body is compressed ({name}); bodies are read as they are.");
                (StatusCode::UNSUPPORTED_MEDIA_TYPE, "compressed", detail, Vec::new())
            }
            ApiError::Spent(Spent { budget, quota, .. }) => {
                let detail = format!("In 10 s one client may have {quota} {}; RateLimit says when there are some again.", budget.what());
                (StatusCode::TOO_MANY_REQUESTS, "too-many-requests", detail, Vec::new())
            }
            ApiError::Overloaded => (StatusCode::SERVICE_UNAVAILABLE, "overloaded", "Too many tiles are waiting; try again shortly.".to_owned(), Vec::new()),
            ApiError::Queued => (StatusCode::SERVICE_UNAVAILABLE, "busy", "Too many jobs are waiting; try again later.".to_owned(), Vec::new()),
            ApiError::Exporting => (StatusCode::SERVICE_UNAVAILABLE, "busy", "Too many exports are under way; try again later.".to_owned(), Vec::new()),
            ApiError::Busy => (StatusCode::SERVICE_UNAVAILABLE, "busy", "Too many requests are under way; try again shortly.".to_owned(), Vec::new()),
            ApiError::SetAside => {
                let detail =
                    "Evaluating this revision has failed repeatedly, so it is set aside until the server starts again; another revision is not affected.";
                (StatusCode::INTERNAL_SERVER_ERROR, "set-aside", detail.to_owned(), Vec::new())
            }
            ApiError::Internal => (StatusCode::INTERNAL_SERVER_ERROR, "internal", "The server failed; its log says why.".to_owned(), Vec::new()),
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let fields = if let ApiError::Spent(spent) = &self { Some(spent.fields()) } else { None };
        let (status, kind, detail, errors) = self.parts();
        let title = status.canonical_reason().unwrap_or("Error").to_owned();
        let body = schema::ProblemDetails { kind: format!("urn:terrane:{kind}"), title, status: status.as_u16(), detail, errors };
        let mut response = (status, Json(body)).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer realm=\"terrane\""));
        }
        for (name, value) in fields.into_iter().flatten() {
            headers.extend(HeaderValue::from_str(&value).ok().map(|value| (HeaderName::from_static(name), value)));
        }
        if status == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
        }
        response
    }
}

impl From<Problem> for Entry {
    fn from(problem: Problem) -> Self {
        let Problem { pointer, detail, at, start, end } = problem;
        Self { pointer: Some(pointer), parameter: None, detail, at, start, end }
    }
}

impl From<StoreError> for ApiError {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::Unknown { kind, .. } => ApiError::absent(kind.noun(), error.to_string()),
            StoreError::Condition { .. } => ApiError::PreconditionFailed(error.to_string()),
            StoreError::Folder { .. }
            | StoreError::Archive(_)
            | StoreError::InUse(_)
            | StoreError::Newer { .. }
            | StoreError::Older { .. }
            | StoreError::UnknownKey(_)
            | StoreError::Random(_)
            | StoreError::Database(_) => ApiError::internal("the store failed", &error),
        }
    }
}

impl From<TileFailure> for ApiError {
    fn from(failure: TileFailure) -> Self {
        match failure {
            TileFailure::Overloaded => ApiError::Overloaded,
            TileFailure::Failed => ApiError::Internal,
            TileFailure::SetAside => ApiError::SetAside,
        }
    }
}

impl From<LoadError> for ApiError {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Store(error) => error.into(),
            LoadError::Document { .. } | LoadError::Set { .. } | LoadError::Raster { .. } | LoadError::Generation { .. } => {
                ApiError::internal("a stored document cannot be read", &error)
            }
            LoadError::Panicked(Panicked) => ApiError::Internal,
        }
    }
}

impl From<Panicked> for ApiError {
    fn from(_: Panicked) -> Self {
        ApiError::Internal
    }
}
