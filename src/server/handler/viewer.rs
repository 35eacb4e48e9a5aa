//! The viewer, embedded in the program when it was built.

use crate::server::{
    embedded::Viewer,
    error::ApiError,
    headers::{Freshness, is_fresh, not_modified, tagged},
};
use axum::{
    http::{HeaderMap, Uri, header},
    response::{Html, IntoResponse, Response},
};

/// What `/` says when the program was built without the viewer.
const WITHOUT_VIEWER: &str = include_str!("../without-viewer.html");

/// The viewer, or how to get it.
#[utoipa::path(get, path = "/", tag = "pages", responses(
    (status = 200, description = "A page", body = String, content_type = "text/html"),
    (status = 304, description = "It has not changed"),
))]
pub(crate) async fn get_viewer(headers: HeaderMap) -> Response {
    file("index.html", &headers).unwrap_or_else(|| Html(WITHOUT_VIEWER).into_response())
}

/// The viewer's other files; everything else that has no route is not there.
pub(crate) async fn get_file(uri: Uri, headers: HeaderMap) -> Result<Response, ApiError> {
    let path = uri.path();
    let absent = || ApiError::NotFound(format!("There is nothing at {path}."), Vec::new());
    file(path.trim_start_matches('/'), &headers).ok_or_else(absent)
}

/// An embedded file; names of files under `assets/` carry a hash of their content, so they never change.
fn file(path: &str, headers: &HeaderMap) -> Option<Response> {
    let file = Viewer::get(path)?;
    let tag: String = file.metadata.sha256_hash().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    let freshness = Freshness::of(path.starts_with("assets/"));
    if is_fresh(headers, &tag) {
        return Some(not_modified(&tag, freshness));
    }
    let media_type = mime_guess::from_path(path).first_or_octet_stream().to_string();
    Some(tagged(([(header::CONTENT_TYPE, media_type)], file.data.into_owned()), &tag, freshness))
}
