//! What is done alike with documents of every kind: answered, saved, named, deleted.

use crate::{
    server::{
        error::ApiError,
        headers::{Freshness, is_fresh, not_modified, tagged},
        schema::ProblemDetails,
        shelf::Shelved,
        state::App,
        vocabulary::Name,
    },
    store::{Condition, Saved},
    world::check_name,
};
use axum::{
    body::Bytes,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::{IntoParams, IntoResponses};

/// The name of a new document.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct NameQuery {
    /// Without it a name is made from the title, or from the revision.
    #[param(value_type = Option<Name>, inline)]
    name: Option<String>,
}

/// Why a document is not saved.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the description alone")]
pub(crate) enum SaveErrors {
    #[response(status = 400, description = "No JSON, no valid name, or a condition that cannot be understood", content_type = "application/problem+json")]
    BadRequest(ProblemDetails),
    #[response(
        status = 403,
        description = "The request comes from another machine, or from a web page of another site",
        content_type = "application/problem+json"
    )]
    Forbidden(ProblemDetails),
    #[response(status = 413, description = "The document is too large", content_type = "application/problem+json")]
    TooLarge(ProblemDetails),
    #[response(status = 422, description = "The document is wrong: every problem with its place", content_type = "application/problem+json")]
    Invalid(ProblemDetails),
}

/// Why a document is not deleted.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the description alone")]
pub(crate) enum DeleteErrors {
    #[response(status = 400, description = "No valid name, or a condition that cannot be understood", content_type = "application/problem+json")]
    BadRequest(ProblemDetails),
    #[response(
        status = 403,
        description = "The request comes from another machine, or from a web page of another site",
        content_type = "application/problem+json"
    )]
    Forbidden(ProblemDetails),
    #[response(status = 412, description = "The condition does not hold", content_type = "application/problem+json")]
    Failed(ProblemDetails),
}

/// The document itself with its revision as entity tag, or 304 if the client has it.
pub(super) fn get<T: Shelved>(request: &HeaderMap, live: &T, freshness: Freshness) -> Response {
    let revision = live.revision().as_str();
    if is_fresh(request, revision) { not_modified(revision, freshness) } else { answer(StatusCode::OK, live, freshness) }
}

fn answer<T: Shelved>(status: StatusCode, live: &T, freshness: Freshness) -> Response {
    let content = T::content(live.document());
    tagged((status, ([(header::CONTENT_TYPE, "application/json")], content.body)), content.revision.as_str(), freshness)
}

/// 201 with the new document's place.
fn created<T: Shelved>(url: &str, live: &T) -> Response {
    let location = [(header::LOCATION, format!("{url}/{}/{}", T::PATH, live.name()))];
    (location, answer(StatusCode::CREATED, live, Freshness::Revalidate)).into_response()
}

/// Saves on a task of its own, which holds something until it is done: once begun it ends, whether or not the client stays, and memory never lags behind the disk.
async fn save<T: Shelved>(
    app: &App,
    name: String,
    document: T::Document,
    condition: Condition,
    held: impl Send + 'static,
) -> Result<(Saved, Arc<T>), ApiError> {
    let app = app.clone();
    let task = tokio::spawn(async move {
        let _held = held;
        T::shelf(&app).save(&name, document, &condition).await
    });
    match task.await {
        Ok(saved) => Ok(saved?),
        Err(error) => Err(ApiError::internal("saving a document", &error)),
    }
}

async fn parse<T: Shelved>(app: &App, body: Bytes) -> Result<T::Document, ApiError> {
    T::shelf(app).parse(body, None).await?.map_err(|error| ApiError::document(T::KIND, error))
}

/// Saves a document under a name.
pub(super) async fn put<T: Shelved>(app: &App, url: &str, name: String, condition: Condition, body: Bytes) -> Result<Response, ApiError> {
    put_held::<T, ()>(app, url, name, condition, body, (), |(), _| Ok(())).await
}

/// As [`put`], while something is held that first says whether the document may be saved.
pub(super) async fn put_held<T: Shelved, H: Send + 'static>(
    app: &App,
    url: &str,
    name: String,
    condition: Condition,
    body: Bytes,
    held: H,
    check: impl FnOnce(&H, &T::Document) -> Result<(), ApiError>,
) -> Result<Response, ApiError> {
    let document = parse::<T>(app, body).await?;
    check(&held, &document)?;
    let (saved, live) = save::<T>(app, name, document, condition, held).await?;
    Ok(match saved {
        Saved::Created => created(url, &*live),
        Saved::Changed | Saved::Unchanged => answer(StatusCode::OK, &*live, Freshness::Revalidate),
    })
}

/// Saves a new document under the name asked for, or under one made for it.
pub(super) async fn post<T: Shelved>(app: &App, url: &str, query: NameQuery, body: Bytes) -> Result<Response, ApiError> {
    if let Some(name) = &query.name {
        check_name("a name", name).map_err(|detail| ApiError::parameter("name", detail))?;
    }
    let document = parse::<T>(app, body).await?;
    let names: Box<dyn Iterator<Item = String> + Send> = match query.name {
        Some(name) => Box::new(std::iter::once(name)),
        None => Box::new(made_names::<T>(&document)),
    };
    let mut last = String::new();
    for name in names {
        // Most taken names are known without compiling the document for them.
        if T::shelf(app).get(&name).is_some() {
            last = name;
            continue;
        }
        match save::<T>(app, name.clone(), document.clone(), Condition::Absent, ()).await {
            Ok((_, live)) => return Ok(created(url, &*live)),
            Err(ApiError::PreconditionFailed(_)) => last = name,
            Err(error) => return Err(error),
        }
    }
    Err(ApiError::Conflict(format!("A {} is already named {last:?}.", T::KIND)))
}

/// Names to try for a document: its title's, then that with numbers.
fn made_names<T: Shelved>(document: &T::Document) -> impl Iterator<Item = String> + use<T> {
    let name = made_name::<T>(document);
    (1..1000).map(move |number| if number == 1 { name.clone() } else { format!("{name}-{number}") })
}

/// A title's letters and digits joined by hyphens; the kind and the revision's start without any.
fn made_name<T: Shelved>(document: &T::Document) -> String {
    let title = T::title_of(document).unwrap_or_default().to_ascii_lowercase();
    let words: Vec<_> = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let name: String = words.join("-").chars().take(50).collect();
    match name.trim_end_matches('-') {
        "" => format!("{}-{}", T::KIND, &T::content(document).revision.as_str()[..12]),
        name => name.to_owned(),
    }
}

/// Takes a name out of use.
pub(super) async fn delete<T: Shelved>(app: App, name: String, condition: Condition) -> Result<StatusCode, ApiError> {
    let task = tokio::spawn(async move { T::shelf(&app).delete(&name, &condition).await });
    match task.await {
        Ok(deleted) => Ok(deleted.map(|()| StatusCode::NO_CONTENT)?),
        Err(error) => Err(ApiError::internal("deleting a document", &error)),
    }
}
