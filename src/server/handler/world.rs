//! World documents.

use super::document::{self, DeleteErrors, NameQuery, SaveErrors};
use crate::server::{
    adaptive::check_change,
    error::ApiError,
    extract::{Body, Known, NameOf, PublicUrl, WorldAt, WriteCondition},
    headers::Freshness,
    schema::{ProblemDetails, RevisionSchema, WorldSchema},
    state::App,
    vocabulary::{MatchCondition, Name, SaveConditions},
    worlds::Live,
};
use axum::{
    Json,
    extract::State,
    http::{HeaderMap, StatusCode},
    response::Response,
};

/// A world document, completed.
#[utoipa::path(get, path = "/worlds/{world}", tag = "worlds", params(("world" = String, Path, description = "`name` or `name@revision`")), responses(
    (status = 200, description = "The document; its ETag is the revision", body = WorldSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 304, description = "The world is at the revision that If-None-Match names"),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_world(WorldAt { live, pinned }: WorldAt, headers: HeaderMap) -> Response {
    document::get(&headers, &*live, Freshness::of(pinned))
}

/// Saves a world: a new one, or a new revision.
///
/// What was acknowledged is on disk. `If-Match: "<revision>"` saves only over that revision, `If-None-Match: *` only a new world.
#[utoipa::path(put, path = "/worlds/{world}", tag = "worlds", params(
    ("world" = inline(Name), Path, description = "A name: 1 to 63 of a … z, 0 … 9 and -"),
    SaveConditions,
), request_body = WorldSchema, responses(
    (status = 200, description = "Saved, or already so: the completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 201, description = "A new world: the completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The world"))),
    (status = 409, description = "A player is on ground that would be another generation", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn put_world(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Live>,
    WriteCondition(condition): WriteCondition,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    // Where somebody plays, ground that evolves stays what it is.
    let players = app.0.players.hold(&name).await;
    let old = app.0.worlds.shelf.get(&name);
    document::put_held::<Live, _>(&app, &url, name, condition, body, players, |players, new| old.map_or(Ok(()), |old| check_change(&old, new, players))).await
}

/// Saves a new world.
#[utoipa::path(post, path = "/worlds", tag = "worlds", params(NameQuery), request_body = WorldSchema, responses(
    (status = 201, description = "The completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The world"))),
    (status = 409, description = "The name is taken", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn post_world(
    State(app): State<App>,
    Known(query): Known<NameQuery>,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    document::post::<Live>(&app, &url, query, body).await
}

/// Takes a world out of the catalogue. Its history stays, and goes on if the name is used again.
#[utoipa::path(delete, path = "/worlds/{world}", tag = "worlds", params(
    ("world" = inline(Name), Path, description = "A name"),
    MatchCondition,
), responses(
    (status = 204, description = "It is gone"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    DeleteErrors,
))]
pub(crate) async fn delete_world(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Live>,
    WriteCondition(condition): WriteCondition,
) -> Result<StatusCode, ApiError> {
    document::delete::<Live>(app, name, condition).await
}

/// Every saved revision of a world, newest last.
#[utoipa::path(get, path = "/worlds/{world}/revisions", tag = "worlds", params(("world" = String, Path, description = "A name")), responses(
    (status = 200, description = "The history", body = Vec<RevisionSchema>),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_revisions(State(app): State<App>, WorldAt { live, .. }: WorldAt) -> Result<Json<Vec<RevisionSchema>>, ApiError> {
    let entries = app.0.worlds.shelf.revisions(&live.name).await?;
    Ok(Json(entries.into_iter().map(|entry| RevisionSchema { number: entry.number, time: entry.time, revision: entry.revision }).collect()))
}
