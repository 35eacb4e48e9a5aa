//! A world's base as the source text of a shader.

use crate::{
    programme::{SHADER_FORM, ShaderLanguage},
    server::{
        error::ApiError,
        extract::WorldAt,
        headers::{Freshness, is_fresh, not_modified, tagged},
        schema::ProblemDetails,
        state::App,
    },
};
use axum::{
    extract::State,
    http::{HeaderMap, header},
    response::Response,
};
use std::sync::Arc;

/// The base as GLSL ES 3.00: `float terrane_elevation(vec2 metres)` and what it is made of.
///
/// Pasted into a shader behind its `#version`, it computes the base's elevations as `filter=exact` has them, to within the rounding of f32. For places so far out
/// that one f32 cannot hold them there is `terrane_elevation_at(ivec2 metres, vec2 offset)`.
#[utoipa::path(get, path = "/worlds/{world}/shader.glsl", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`")), responses(
    (status = 200, description = "Source text", body = String, content_type = "text/plain", headers(("ETag" = String, description = "Revision and version of the text"))),
    (status = 304, description = "The text is the one that If-None-Match names"),
    (status = 404, description = "No such world, or its programme is too large for a shader or uses erosion", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_glsl(state: State<App>, world: WorldAt, headers: HeaderMap) -> Result<Response, ApiError> {
    answer(state, world, &headers, ShaderLanguage::Glsl).await
}

/// The base as WGSL: `fn terrane_elevation(metres: vec2<f32>) -> f32` and what it is made of, as in `shader.glsl`.
#[utoipa::path(get, path = "/worlds/{world}/shader.wgsl", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`")), responses(
    (status = 200, description = "Source text", body = String, content_type = "text/plain", headers(("ETag" = String, description = "Revision and version of the text"))),
    (status = 304, description = "The text is the one that If-None-Match names"),
    (status = 404, description = "No such world, or its programme is too large for a shader or uses erosion", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_wgsl(state: State<App>, world: WorldAt, headers: HeaderMap) -> Result<Response, ApiError> {
    answer(state, world, &headers, ShaderLanguage::Wgsl).await
}

async fn answer(State(app): State<App>, WorldAt { live, pinned }: WorldAt, headers: &HeaderMap, language: ShaderLanguage) -> Result<Response, ApiError> {
    let name = if language == ShaderLanguage::Glsl { "glsl" } else { "wgsl" };
    let (tag, freshness) = (format!("{}-{name}-{SHADER_FORM}", live.world.revision()), Freshness::of(pinned));
    if is_fresh(headers, &tag) {
        return Ok(not_modified(&tag, freshness));
    }
    let world = Arc::clone(&live);
    let source = app.0.queries.run(move || world.world.shader(language)).await?;
    let source = source.map_err(|error| ApiError::absent("world", error.to_string()))?;
    Ok(tagged(([(header::CONTENT_TYPE, "text/plain; charset=utf-8")], source), &tag, freshness))
}
