//! Whether the server lives and takes requests.

use crate::server::{schema::Health, state::App};
use axum::{Json, extract::State, http::StatusCode};

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
