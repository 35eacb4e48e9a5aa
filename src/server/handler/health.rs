//! Whether the server lives and takes requests.

use crate::server::{
    error::ApiError,
    metrics::Levels,
    schema::{Health, ProblemDetails},
    state::App,
    tiles::Class,
};
use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::IntoResponse,
};

/// Whether the process lives.
#[utoipa::path(get, path = "/healthz", tag = "health", responses((status = 200, description = "It lives", body = Health)))]
pub(crate) async fn get_liveness() -> Json<Health> {
    Json(Health { status: "ok" })
}

/// Whether the server takes requests.
#[utoipa::path(get, path = "/readyz", tag = "health", responses(
    (status = 200, description = "It does", body = Health),
    (status = 503, description = "It is finishing its last requests", body = Health),
))]
pub(crate) async fn get_readiness(State(app): State<App>) -> (StatusCode, Json<Health>) {
    if app.is_draining() { (StatusCode::SERVICE_UNAVAILABLE, Json(Health { status: "draining" })) } else { (StatusCode::OK, Json(Health { status: "ok" })) }
}

/// What the server counts and measures, for Prometheus.
#[utoipa::path(get, path = "/metrics", tag = "health", responses(
    (status = 200, description = "Requests, tiles, queue, cache and failures, as OpenMetrics text", body = String, content_type = "application/openmetrics-text"),
    (status = 500, description = "The text could not be written", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_metrics(State(app): State<App>) -> Result<impl IntoResponse, ApiError> {
    let ((evaluating, waiting), (cached_tiles, cached_bytes)) = (app.0.tiles.load(), app.0.tiles.held());
    let waiting = Class::ALL.map(|class| (class.name(), waiting[class as usize]));
    let levels = Levels { waiting, evaluating, cached_tiles, cached_bytes, worlds: app.0.worlds.shelf.all().len() };
    let text = app.0.metrics.text(&levels).map_err(|error| ApiError::internal("writing metrics", &error))?;
    Ok(([(header::CONTENT_TYPE, "application/openmetrics-text; version=1.0.0; charset=utf-8"), (header::CACHE_CONTROL, "no-store")], text))
}
