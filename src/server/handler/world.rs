//! World documents.

use crate::{
    server::{
        error::ApiError,
        extract::{Body, Known, PublicUrl, WorldAt, WorldName, WriteCondition},
        headers::{Freshness, is_fresh, not_modified, tagged},
        schema::{ProblemDetails, RevisionSchema, WorldSchema},
        state::App,
        worlds::Live,
    },
    store::{Condition, Saved},
    world::Document,
};
use axum::{
    Json,
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// The document itself, with its revision as entity tag.
fn answer(status: StatusCode, live: &Live, freshness: Freshness) -> Response {
    let body = ([(header::CONTENT_TYPE, "application/json")], live.world.document().to_json());
    tagged((status, body), live.world.revision().as_str(), freshness)
}

/// Saves on a task of its own: once begun it ends, whether or not the client stays, and memory never lags behind the disk.
async fn save(app: &App, name: String, document: Document, condition: Condition) -> Result<(Saved, Arc<Live>), ApiError> {
    let app = app.clone();
    let task = tokio::spawn(async move { app.0.worlds.save(&name, document, &condition).await });
    match task.await {
        Ok(saved) => Ok(saved?),
        Err(error) => Err(ApiError::internal("saving a world", &error)),
    }
}

/// A world document, completed.
#[utoipa::path(get, path = "/worlds/{world}", tag = "worlds", params(("world" = String, Path, description = "`name` or `name@revision`")), responses(
    (status = 200, description = "The document; its ETag is the revision", body = WorldSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 304, description = "The world is at the revision that If-None-Match names"),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_world(WorldAt { live, pinned }: WorldAt, headers: HeaderMap) -> Response {
    let freshness = Freshness::of(pinned);
    let revision = live.world.revision().as_str();
    if is_fresh(&headers, revision) { not_modified(revision, freshness) } else { answer(StatusCode::OK, &live, freshness) }
}

/// Saves a world: a new one, or a new revision.
///
/// What was acknowledged is on disk. `If-Match: "<revision>"` saves only over that revision, `If-None-Match: *` only a new world.
#[utoipa::path(put, path = "/worlds/{world}", tag = "worlds", params(
    ("world" = String, Path, description = "A name: 1 to 63 of a … z, 0 … 9 and -"),
    ("If-Match" = Option<String>, Header, description = "Revisions the world must be at, or *"),
    ("If-None-Match" = Option<String>, Header, description = "*: there must be no such world"),
), request_body = WorldSchema, responses(
    (status = 200, description = "Saved, or already so: the completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 201, description = "A new world: the completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The world"))),
    (status = 400, description = "No JSON, no valid name, or a condition that cannot be understood", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The document is too large", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 422, description = "The document is wrong: every problem with its place", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn put_world(
    State(app): State<App>,
    WorldName(name): WorldName,
    WriteCondition(condition): WriteCondition,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    let (saved, live) = save(&app, name, Document::parse(&body)?, condition).await?;
    Ok(match saved {
        Saved::Created => created(&url, &live),
        Saved::Changed | Saved::Unchanged => answer(StatusCode::OK, &live, Freshness::Revalidate),
    })
}

/// 201 with the new world's place.
fn created(url: &str, live: &Live) -> Response {
    let location = [(header::LOCATION, format!("{url}/worlds/{}", live.name))];
    (location, answer(StatusCode::CREATED, live, Freshness::Revalidate)).into_response()
}

/// The name of a new world.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct NameQuery {
    /// Without it a name is made from the title, or from the revision.
    name: Option<String>,
}

/// Saves a new world.
#[utoipa::path(post, path = "/worlds", tag = "worlds", params(NameQuery), request_body = WorldSchema, responses(
    (status = 201, description = "The completed document", body = WorldSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The world"))),
    (status = 400, description = "No JSON, or no valid name", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 409, description = "The name is taken", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The document is too large", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 422, description = "The document is wrong: every problem with its place", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn post_world(
    State(app): State<App>,
    Known(query): Known<NameQuery>,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    let given = query.name.map(|name| WorldName::parse(&name)).transpose().map_err(|detail| ApiError::parameter("name", detail))?;
    let document = Document::parse(&body)?;
    let names: Box<dyn Iterator<Item = String> + Send> = match given {
        Some(WorldName(name)) => Box::new(std::iter::once(name)),
        None => Box::new(made_names(&document)),
    };
    let mut last = String::new();
    for name in names {
        // Most taken names are known without compiling the world for them.
        if app.0.worlds.get(&name).is_some() {
            last = name;
            continue;
        }
        match save(&app, name.clone(), document.clone(), Condition::Absent).await {
            Ok((_, live)) => return Ok(created(&url, &live)),
            Err(ApiError::PreconditionFailed(_)) => last = name,
            Err(error) => return Err(error),
        }
    }
    Err(ApiError::Conflict(format!("A world is already named {last:?}.")))
}

/// Names to try for a document: its title's, then that with numbers.
fn made_names(document: &Document) -> impl Iterator<Item = String> + use<> {
    let name = made_name(document);
    (1..1000).map(move |number| if number == 1 { name.clone() } else { format!("{name}-{number}") })
}

/// A title's letters and digits joined by hyphens; `world-` and the revision's start without any.
fn made_name(document: &Document) -> String {
    let title = document.title.as_deref().unwrap_or_default().to_ascii_lowercase();
    let words: Vec<_> = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let name: String = words.join("-").chars().take(50).collect();
    if name.is_empty() { format!("world-{}", &document.revision().as_str()[..12]) } else { name.trim_end_matches('-').to_owned() }
}

/// Takes a world out of the catalogue. Its history stays, and goes on if the name is used again.
#[utoipa::path(delete, path = "/worlds/{world}", tag = "worlds", params(
    ("world" = String, Path, description = "A name"),
    ("If-Match" = Option<String>, Header, description = "Revisions the world must be at, or *"),
), responses(
    (status = 204, description = "It is gone"),
    (status = 400, description = "No valid name, or a condition that cannot be understood", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn delete_world(
    State(app): State<App>,
    WorldName(name): WorldName,
    WriteCondition(condition): WriteCondition,
) -> Result<StatusCode, ApiError> {
    let task = tokio::spawn(async move { app.0.worlds.delete(&name, &condition).await });
    match task.await {
        Ok(deleted) => Ok(deleted.map(|()| StatusCode::NO_CONTENT)?),
        Err(error) => Err(ApiError::internal("deleting a world", &error)),
    }
}

/// Every saved revision of a world, newest last.
#[utoipa::path(get, path = "/worlds/{world}/revisions", tag = "worlds", params(("world" = String, Path, description = "A name")), responses(
    (status = 200, description = "The history", body = Vec<RevisionSchema>),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_revisions(State(app): State<App>, WorldAt { live, .. }: WorldAt) -> Result<Json<Vec<RevisionSchema>>, ApiError> {
    let entries = app.0.worlds.revisions(&live.name).await?;
    Ok(Json(entries.into_iter().map(|entry| RevisionSchema { number: entry.number, time: entry.time, revision: entry.revision }).collect()))
}
