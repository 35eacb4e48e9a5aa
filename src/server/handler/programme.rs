//! The programme library.

use super::document::{self, DeleteErrors, NameQuery, SaveErrors};
use crate::server::{
    error::ApiError,
    extract::{Asker, Body, Known, NameOf, Present, PublicUrl, WriteCondition},
    headers::{Freshness, class, hashed, is_fresh, json, not_modified, tagged, timed},
    library::Shown,
    payment::bought,
    schema::{ProblemDetails, ProgrammeEntry, ProgrammeList, ProgrammeSchema},
    search::Search,
    shelf::Shelved,
    state::App,
    tiles::Order,
    vocabulary::{MatchCondition, Name, SaveConditions},
};
use axum::{
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::Response,
};
use serde::Deserialize;
use std::ops::RangeInclusive;
use utoipa::IntoParams;

/// Most programmes in one answer.
const MAX_LISTED: usize = 1_000;

/// Pixels a side of a picture, and how many without a wish.
const PIXELS: RangeInclusive<usize> = 64..=1024;
const USUAL_PIXELS: usize = 256;

/// The programmes of the library.
#[utoipa::path(get, path = "/programmes", tag = "programmes", params(
    ("tag" = Option<Vec<String>>, Query, description = "Only those with this tag; given more than once, with every one", example = json!(["desert"])),
    ("q" = Option<String>, Query, description = "Only those with every one of these words in their name, title, description, tags or origin"),
), responses(
    (status = 200, description = "The programmes, by name", body = ProgrammeList, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "An unknown parameter, or no valid Host header", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_programmes(State(app): State<App>, search: Search, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let all = app.0.library.all();
    let found: Vec<_> = all.values().filter(|shown| search.finds(shown)).collect();
    let programmes = found.iter().take(MAX_LISTED).map(|shown| entry(&url, shown)).collect();
    json(&headers, &ProgrammeList { found: found.len(), programmes }, Freshness::Revalidate)
}

fn entry(url: &str, shown: &Shown) -> ProgrammeEntry {
    let (preset, document) = (shown.document(), format!("{url}/programmes/{}", shown.name()));
    ProgrammeEntry {
        name: shown.name().to_owned(),
        title: shown.title().to_owned(),
        description: preset.description.clone(),
        tags: preset.tags.clone(),
        origin: preset.origin.clone(),
        revision: shown.revision().to_string(),
        preview: format!("{document}/preview.png"),
        document,
    }
}

/// A programme of the library, completed.
#[utoipa::path(get, path = "/programmes/{programme}", tag = "programmes", params(("programme" = String, Path, description = "A name")), responses(
    (status = 200, description = "The document; its ETag is the revision", body = ProgrammeSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 304, description = "The programme is at the revision that If-None-Match names"),
    (status = 404, description = "No such programme", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_programme(Present(shown): Present<Shown>, headers: HeaderMap) -> Response {
    document::get(&headers, &*shown, Freshness::Revalidate)
}

/// Saves a programme: a new one, or a new revision.
///
/// What was acknowledged is on disk. `If-Match: "<revision>"` saves only over that revision, `If-None-Match: *` only a new programme.
#[utoipa::path(put, path = "/programmes/{programme}", tag = "programmes", params(
    ("programme" = inline(Name), Path, description = "A name: 1 to 63 of a … z, 0 … 9 and -"),
    SaveConditions,
), request_body = ProgrammeSchema, responses(
    (status = 200, description = "Saved, or already so: the completed document", body = ProgrammeSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 201, description = "A new programme: the completed document", body = ProgrammeSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The programme"))),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn put_programme(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Shown>,
    WriteCondition(condition): WriteCondition,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    document::put::<Shown>(&app, &url, name, condition, body).await
}

/// Saves a new programme.
#[utoipa::path(post, path = "/programmes", tag = "programmes", params(NameQuery), request_body = ProgrammeSchema, responses(
    (status = 201, description = "The completed document", body = ProgrammeSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The programme"))),
    (status = 409, description = "The name is taken", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn post_programme(
    State(app): State<App>,
    Known(query): Known<NameQuery>,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    document::post::<Shown>(&app, &url, query, body).await
}

/// Takes a programme out of the library. One that ships with Terrane does not come back.
#[utoipa::path(delete, path = "/programmes/{programme}", tag = "programmes", params(
    ("programme" = inline(Name), Path, description = "A name"),
    MatchCondition,
), responses(
    (status = 204, description = "It is gone"),
    (status = 404, description = "No such programme", body = ProblemDetails, content_type = "application/problem+json"),
    DeleteErrors,
))]
pub(crate) async fn delete_programme(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Shown>,
    WriteCondition(condition): WriteCondition,
) -> Result<StatusCode, ApiError> {
    document::delete::<Shown>(app, name, condition).await
}

/// The programme alone, as canonical text.
#[utoipa::path(get, path = "/programmes/{programme}/programme.txt", tag = "programmes", params(("programme" = String, Path, description = "A name")), responses(
    (status = 200, description = "Programme text", body = String, content_type = "text/plain", headers(("ETag" = String, description = "A hash of the text"))),
    (status = 304, description = "The text is the one that If-None-Match names"),
    (status = 404, description = "No such programme", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_text(Present(shown): Present<Shown>, headers: HeaderMap) -> Response {
    hashed(&headers, "text/plain; charset=utf-8", shown.document().programme.to_string().into_bytes(), Freshness::Revalidate)
}

/// The programme alone, as canonical JSON tree.
#[utoipa::path(get, path = "/programmes/{programme}/programme.json", tag = "programmes", params(("programme" = String, Path, description = "A name")), responses(
    (status = 200, description = "A number, the name of a terminal, or an object with `op`", body = serde_json::Value, headers(("ETag" = String, description = "A hash of the tree"))),
    (status = 304, description = "The tree is the one that If-None-Match names"),
    (status = 404, description = "No such programme", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_tree(Present(shown): Present<Shown>, headers: HeaderMap) -> Result<Response, ApiError> {
    json(&headers, &shown.document().programme.to_json(), Freshness::Revalidate)
}

/// How large a picture is.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct PreviewQuery {
    /// Pixels a side.
    #[param(value_type = Option<u16>, minimum = 64, maximum = 1024, default = 256)]
    size: Option<String>,
}

impl PreviewQuery {
    pub(super) fn pixels(&self) -> Result<usize, ApiError> {
        let Some(size) = &self.size else { return Ok(USUAL_PIXELS) };
        let pixels = size.parse().ok().filter(|pixels| PIXELS.contains(pixels));
        pixels.ok_or_else(|| ApiError::parameter("size", format!("must be a whole number {} … {}, got {size:?}", PIXELS.start(), PIXELS.end())))
    }
}

/// A relief picture of the terrain that a programme makes, where it shows most of it.
#[utoipa::path(get, path = "/programmes/{programme}/preview.png", tag = "programmes", params(("programme" = String, Path, description = "A name"), PreviewQuery), responses(
    (status = 200, description = "The picture", content((Vec<u8> = "image/png")), headers(("ETag" = String, description = "The picture's fingerprint"))),
    (status = 304, description = "The picture is what If-None-Match names; nothing was evaluated"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such programme", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 500, description = "The evaluation failed, or this revision of the programme has failed so often that it is set aside", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many tiles are waiting", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_preview(
    State(app): State<App>,
    Present(shown): Present<Shown>,
    Known(query): Known<PreviewQuery>,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let pixels = query.pixels()?;
    let fingerprint = shown.preview_fingerprint(pixels);
    let tag = fingerprint.to_string();
    if is_fresh(&headers, &tag) {
        return Ok(not_modified(&tag, Freshness::Revalidate));
    }
    let answer = |bytes| tagged(([(header::CONTENT_TYPE, "image/png")], bytes), &tag, Freshness::Revalidate);
    if let Some(bytes) = app.0.tiles.cached(&fingerprint).await {
        return Ok(answer(bytes));
    }
    let cost_ns = shown.preview_cost_ns(pixels);
    let order = Order { fingerprint, revision: shown.revision().clone(), class: class(&headers), cost_ns, kind: ["preview", "programme"] };
    let made = bought(&app, asker, order, move |stop| shown.preview(pixels, stop)).await?;
    Ok(timed(answer(made.bytes), made.timing))
}
