//! The description of the interface.

use crate::server::openapi;
use axum::{http::header, response::IntoResponse};
use std::sync::LazyLock;

static DESCRIPTION: LazyLock<String> = LazyLock::new(|| openapi().to_pretty_json().unwrap_or_default());

/// This description.
#[utoipa::path(get, path = "/openapi.json", tag = "pages", responses((status = 200, description = "OpenAPI 3.1", body = serde_json::Value)))]
pub(crate) async fn get_openapi() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], DESCRIPTION.as_str())
}
