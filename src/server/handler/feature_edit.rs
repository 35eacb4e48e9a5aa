//! A world's features, to be changed.

use super::feature::{GEOJSON, unknown};
use crate::{
    layout::geojson::{Collection, Drawn, Id, Problem, name_of_feature},
    server::{
        error::ApiError,
        extract::{Body, FeatureAt, NameOf, PublicUrl, Upload, WorldAt, WriteCondition},
        features::{change, invalid},
        headers::{Freshness, tagged},
        schema::{AddedSchema, FeatureCollectionSchema, FeatureSchema, ProblemDetails},
        shelf::Shelved,
        state::App,
        upload,
        vocabulary::{MatchCondition, Name, SaveConditions},
        worlds::Live,
    },
    store::{Condition, Kind},
};
use axum::{
    Json,
    extract::State,
    http::{StatusCode, header},
    response::{IntoResponse, Response},
};
use std::collections::BTreeSet;
use utoipa::IntoResponses;

/// Why features are not changed.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the description alone")]
pub(crate) enum EditErrors {
    #[response(status = 400, description = "A condition that cannot be understood, or a body that breaks off", content_type = "application/problem+json")]
    BadRequest(ProblemDetails),
    #[response(
        status = 403,
        description = "The request comes from another machine, or from a web page of another site",
        content_type = "application/problem+json"
    )]
    Forbidden(ProblemDetails),
    #[response(status = 404, description = "No such world or feature", content_type = "application/problem+json")]
    NotFound(ProblemDetails),
    #[response(status = 412, description = "The condition does not hold", content_type = "application/problem+json")]
    Failed(ProblemDetails),
    #[response(status = 413, description = "The body is too large", content_type = "application/problem+json")]
    TooLarge(ProblemDetails),
    #[response(
        status = 422,
        description = "A feature is wrong: every problem with feature, vertex and place; nothing is stored",
        content_type = "application/problem+json"
    )]
    Invalid(ProblemDetails),
}

/// Ids that an answer lists at most.
const MOST_IDS: usize = 1000;

/// Checks a condition against what there is.
fn check(condition: &Condition, what: &str, tag: Option<&str>) -> Result<(), ApiError> {
    if condition.holds(tag) {
        return Ok(());
    }
    let state = tag.map_or_else(|| "absent".to_owned(), |tag| format!("at {tag}"));
    Err(ApiError::PreconditionFailed(format!("the {what} is {state}, not what the request's condition asks for")))
}

/// Adds features to the world: a Feature, a `FeatureCollection`, or one Feature a line.
///
/// Features without an id get one. Nothing is stored unless all are good.
#[utoipa::path(post, path = "/worlds/{world}/features", tag = "features", params(
    ("world" = inline(Name), Path, description = "A name"),
    MatchCondition,
), request_body(content((FeatureCollectionSchema = "application/geo+json"), (String = "application/geo+json-seq"), (String = "application/x-ndjson"))), responses(
    (status = 201, description = "What was added", body = AddedSchema, headers(("ETag" = String, description = "The world's new revision"), ("Location" = String, description = "The feature, if it was one"))),
    EditErrors,
))]
pub(crate) async fn post_features(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Live>,
    WriteCondition(condition): WriteCondition,
    PublicUrl(url): PublicUrl,
    Upload(body): Upload,
) -> Result<Response, ApiError> {
    let new = upload::read(&app, body).await?;
    let (live, first) = change(&app, name, move |live, place| {
        check(&condition, "world", Some(live.revision().as_str()))?;
        new.check(&place.scope()).map_err(invalid)?;
        let mut all = place.set.collection().clone();
        refuse_taken(&all, &new)?;
        let first = all.features.len();
        all.append(new);
        Ok((all, first))
    })
    .await?;
    let (count, ids) = added(&live, first);
    let revision = live.revision().to_string();
    let location = ids.first().filter(|_| count == 1).map(|id| format!("{url}/worlds/{}/features/{}", live.name, escaped(id)));
    let body = AddedSchema { added: count, ids, revision: revision.clone() };
    let response = tagged((StatusCode::CREATED, Json(body)), &revision, Freshness::Revalidate);
    Ok(match location {
        Some(location) => ([(header::LOCATION, location)], response).into_response(),
        None => response,
    })
}

/// Says which ids are taken.
fn refuse_taken(all: &Collection, new: &Collection) -> Result<(), ApiError> {
    if all.features.is_empty() {
        return Ok(());
    }
    let ids: BTreeSet<String> = new.features.iter().filter_map(|drawn| Some(drawn.id.as_ref()?.to_string())).collect();
    let taken: BTreeSet<String> = all.features.iter().filter_map(|drawn| Some(drawn.id.as_ref()?.to_string())).filter(|id| ids.contains(id)).collect();
    if taken.is_empty() {
        return Ok(());
    }
    let problems: Vec<Problem> = new
        .features
        .iter()
        .enumerate()
        .filter_map(|(number, drawn)| Some((number, drawn.id.as_ref()?.to_string())))
        .filter(|(_, id)| taken.contains(id))
        .take(crate::layout::geojson::MOST_PROBLEMS)
        .map(|(number, id)| Problem {
            pointer: format!("{}/id", new.pointer(number)),
            detail: format!("feature {id:?}: the world has a feature with this id already"),
        })
        .collect();
    Err(invalid(problems))
}

/// How many features a world has from a place on, and the ids of the first.
fn added(live: &Live, first: usize) -> (usize, Vec<String>) {
    let place = crate::server::features::Place::of(live);
    let new = &place.set.collection().features[first..];
    (new.len(), new.iter().take(MOST_IDS).filter_map(|drawn| Some(drawn.id.as_ref()?.to_string())).collect())
}

/// A text as one step of a URL's path.
fn escaped(text: &str) -> String {
    text.bytes().map(|b| if b.is_ascii_alphanumeric() || b"-._~".contains(&b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// Saves one feature: in the place of the one with this id, or as a new one.
#[utoipa::path(put, path = "/worlds/{world}/features/{id}", tag = "features", params(
    ("world" = inline(Name), Path, description = "A name"),
    ("id" = String, Path, description = "The feature's id; a feature that has one itself must have this"),
    SaveConditions,
), request_body(content = FeatureSchema, content_type = "application/geo+json"), responses(
    (status = 200, description = "Saved: the feature", body = FeatureSchema, content_type = "application/geo+json", headers(("ETag" = String, description = "The name of its content"))),
    (status = 201, description = "A new feature", body = FeatureSchema, content_type = "application/geo+json", headers(("ETag" = String, description = "The name of its content"))),
    EditErrors,
))]
pub(crate) async fn put_feature(
    State(app): State<App>,
    FeatureAt { world, id }: FeatureAt,
    WriteCondition(condition): WriteCondition,
    Upload(body): Upload,
) -> Result<Response, ApiError> {
    let mut new = upload::read(&app, body).await?;
    let [drawn] = &mut new.features[..] else { return Err(one_feature()) };
    match &drawn.id {
        Some(own) if !own.is(&id) => {
            return Err(invalid([Problem { pointer: "/id".to_owned(), detail: format!("must be {id:?}, as in the address, or left out") }]));
        }
        Some(_) => {}
        None => drawn.id = Some(Id::Text(id.as_str().into())),
    }
    let (_, (drawn, created)) = change(&app, world, move |_, place| {
        let mut all = place.set.collection().clone();
        let position = place.set.position(&id);
        check(&condition, "feature", position.map(|i| name_of_feature(&all.features[i])).as_deref())?;
        new.check(&place.scope()).map_err(invalid)?;
        let last = all.features.len();
        all.append(new);
        if let Some(position) = position {
            // The new one comes to the old one's place.
            all.features.swap_remove(position);
        }
        let drawn = all.features[position.unwrap_or(last)].clone();
        Ok((all, (drawn, position.is_none())))
    })
    .await?;
    let tag = name_of_feature(&drawn);
    let body = serde_json::to_vec(&drawn).map_err(|error| ApiError::internal("writing a feature", &error))?;
    let status = if created { StatusCode::CREATED } else { StatusCode::OK };
    Ok(tagged((status, [(header::CONTENT_TYPE, GEOJSON)], body), &tag, Freshness::Revalidate))
}

fn one_feature() -> ApiError {
    invalid([Problem { pointer: String::new(), detail: "must be one Feature".to_owned() }])
}

/// Takes a feature out of the world.
#[utoipa::path(delete, path = "/worlds/{world}/features/{id}", tag = "features", params(
    ("world" = inline(Name), Path, description = "A name"),
    ("id" = String, Path, description = "The feature's id"),
    MatchCondition,
), responses((status = 204, description = "It is gone", headers(("ETag" = String, description = "The world's new revision"))), EditErrors))]
pub(crate) async fn delete_feature(
    State(app): State<App>,
    FeatureAt { world, id }: FeatureAt,
    WriteCondition(condition): WriteCondition,
) -> Result<Response, ApiError> {
    let (live, ()) = change(&app, world, move |_, place| {
        let position = place.set.position(&id).ok_or_else(|| unknown(&id))?;
        let mut all = place.set.collection().clone();
        check(&condition, "feature", Some(&name_of_feature(&all.features[position])))?;
        let _: Drawn = all.features.remove(position);
        Ok((all, ()))
    })
    .await?;
    Ok(tagged(StatusCode::NO_CONTENT, live.revision().as_str(), Freshness::Revalidate))
}

/// Features that generators make in this world, to be edited and added: nothing is stored.
#[utoipa::path(post, path = "/worlds/{world}/generate", tag = "features", params(("world" = String, Path, description = "`name` or `name@revision`")),
request_body(content = serde_json::Value, description = "An item of a layout, such as `{\"generate\": \"island\", \"seed\": 7}`, roads between places (`{\"generate\": \"roads\", \"places\": [{\"name\": \"North\", \"at\": [0, 900]}, …]}`), or a list of such items. Generators of rivers and ridges take ids of the world's features, or GeoJSON Features, as `land`, `drawn` and `waters`", content_type = "application/json"), responses(
    (status = 200, description = "The features", body = FeatureCollectionSchema, content_type = "application/geo+json"),
    (status = 400, description = "The body is no JSON", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The body is too large", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 422, description = "A parameter is wrong: every problem with its place", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn generate_features(State(app): State<App>, WorldAt { live, .. }: WorldAt, Body(body): Body) -> Result<Response, ApiError> {
    let made = app.0.queries.run(move || live.world.generate(&body)).await?;
    let collection = made.map_err(|error| ApiError::document(Kind::World, error))?;
    let body = serde_json::to_vec(&collection).map_err(|error| ApiError::internal("writing features", &error))?;
    Ok(([(header::CONTENT_TYPE, GEOJSON)], body).into_response())
}
