//! Sessions of breeding: chosen by eye, bred, kept.

use super::document::{self, DeleteErrors, NameQuery, SaveErrors};
use crate::{
    evolve::{Genome, Portrait},
    geometry::Until,
    server::{
        breeding::Breeding,
        error::ApiError,
        extract::{Asker, Body, IndividualAt, Known, NameOf, Present, PublicUrl, WriteCondition},
        headers::{Freshness, class, is_fresh, json, not_modified, tagged, timed},
        payment::bought,
        schema::{GenerationSchema, IndividualSchema, ProblemDetails, SessionEntry, SessionList, SessionSchema},
        shelf::Shelved,
        state::App,
        tiles::Order,
        vocabulary::{MatchCondition, Name, SaveConditions},
    },
    tile::{PREVIEW_FORM, preview},
    world::Fingerprint,
};
use axum::{
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::Response,
};

/// Pixels a side of a picture.
const PIXELS: usize = 256;

/// The sessions that are kept.
#[utoipa::path(get, path = "/breeding", tag = "breeding", responses(
    (status = 200, description = "The sessions, by name", body = SessionList, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
))]
pub(crate) async fn list_sessions(State(app): State<App>, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let entry = |live: &Breeding| SessionEntry {
        name: live.name().to_owned(),
        revision: live.revision().to_string(),
        generations: live.session().generations().len(),
        document: format!("{url}/breeding/{}", live.name()),
    };
    let sessions = app.0.breeding.all().values().map(|live| entry(live)).collect();
    json(&headers, &SessionList { sessions }, Freshness::Revalidate)
}

/// A session: what all its generations follow from.
#[utoipa::path(get, path = "/breeding/{session}", tag = "breeding", params(("session" = String, Path, description = "A name")), responses(
    (status = 200, description = "The record; its ETag is the revision", body = SessionSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 304, description = "The session is at the revision that If-None-Match names"),
    (status = 404, description = "No such session", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_session(Present(live): Present<Breeding>, headers: HeaderMap) -> Response {
    document::get(&headers, &*live, Freshness::Revalidate)
}

/// Saves a session. With one more choice the next generation is bred, with one less the newest is undone; under another name it is a branch.
///
/// What was acknowledged is on disk. `If-Match: "<revision>"` saves only over that revision, `If-None-Match: *` only a new session.
#[utoipa::path(put, path = "/breeding/{session}", tag = "breeding", params(
    ("session" = inline(Name), Path, description = "A name: 1 to 63 of a … z, 0 … 9 and -"),
    SaveConditions,
), request_body = SessionSchema, responses(
    (status = 200, description = "Saved, or already so: the record", body = SessionSchema, headers(("ETag" = String, description = "The revision"))),
    (status = 201, description = "A new session: the record", body = SessionSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The session"))),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn put_session(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Breeding>,
    WriteCondition(condition): WriteCondition,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    document::put::<Breeding>(&app, &url, name, condition, body).await
}

/// Saves a new session.
#[utoipa::path(post, path = "/breeding", tag = "breeding", params(NameQuery), request_body = SessionSchema, responses(
    (status = 201, description = "The record", body = SessionSchema, headers(("ETag" = String, description = "The revision"), ("Location" = String, description = "The session"))),
    (status = 409, description = "The name is taken", body = ProblemDetails, content_type = "application/problem+json"),
    SaveErrors,
))]
pub(crate) async fn post_session(
    State(app): State<App>,
    Known(query): Known<NameQuery>,
    PublicUrl(url): PublicUrl,
    Body(body): Body,
) -> Result<Response, ApiError> {
    document::post::<Breeding>(&app, &url, query, body).await
}

/// Takes a session away.
#[utoipa::path(delete, path = "/breeding/{session}", tag = "breeding", params(
    ("session" = inline(Name), Path, description = "A name"),
    MatchCondition,
), responses(
    (status = 204, description = "It is gone"),
    (status = 404, description = "No such session", body = ProblemDetails, content_type = "application/problem+json"),
    DeleteErrors,
))]
pub(crate) async fn delete_session(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Breeding>,
    WriteCondition(condition): WriteCondition,
) -> Result<StatusCode, ApiError> {
    document::delete::<Breeding>(app, name, condition).await
}

fn shown(genome: &Genome, seed: u64) -> Result<Portrait, ApiError> {
    Portrait::new(genome, seed).map_err(|error| ApiError::internal("a bred programme cannot be shown", &error))
}

/// A generation of a session: its programmes, how they came to be, and their pictures.
#[utoipa::path(get, path = "/breeding/{session}/generations/{generation}", tag = "breeding", params(
    ("session" = String, Path, description = "A name"),
    ("generation" = usize, Path, description = "0 is the first"),
), responses(
    (status = 200, description = "The generation", body = GenerationSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 404, description = "No such session or generation", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_generation(
    State(app): State<App>,
    Present(live): Present<Breeding>,
    IndividualAt { generation, .. }: IndividualAt,
    PublicUrl(url): PublicUrl,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let generations = live.session().generations().len();
    if generation >= generations {
        return Err(ApiError::absent("generation", format!("must be 0 … {}, got {generation}", generations - 1)));
    }
    let address = format!("{url}/breeding/{}/generations/{generation}", live.name());
    let described = app.0.queries.run(move || {
        let session = live.session();
        let individuals = session.generations()[generation].iter().enumerate().map(|(i, bred)| {
            Ok::<_, ApiError>(IndividualSchema {
                programme: bred.genome.to_string(),
                origin: serde_json::to_value(bred.origin).map_err(|error| ApiError::internal("writing an origin", &error))?,
                values: shown(&bred.genome, session.view_seed())?.extent().measured,
                picture: format!("{address}/{i}/picture.png"),
            })
        });
        Ok::<_, ApiError>(GenerationSchema { generation, generations, seed: session.view_seed(), individuals: individuals.collect::<Result<_, _>>()? })
    });
    json(&headers, &described.await??, Freshness::Revalidate)
}

/// A relief picture of a bred programme, over 4 programme units a side about the origin.
#[utoipa::path(get, path = "/breeding/{session}/generations/{generation}/{individual}/picture.png", tag = "breeding", params(
    ("session" = String, Path, description = "A name"),
    ("generation" = usize, Path, description = "0 is the first"),
    ("individual" = usize, Path, description = "0 … 11"),
), responses(
    (status = 200, description = "The picture", content((Vec<u8> = "image/png")), headers(("ETag" = String, description = "The picture's fingerprint"))),
    (status = 304, description = "The picture is what If-None-Match names; nothing was evaluated"),
    (status = 404, description = "No such session, generation or individual", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 500, description = "The evaluation failed", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many tiles are waiting", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_picture(
    State(app): State<App>,
    Present(live): Present<Breeding>,
    IndividualAt { generation, individual }: IndividualAt,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let bred = live.session().generations().get(generation).and_then(|generation| generation.get(individual));
    let genome = bred.ok_or_else(|| ApiError::absent("individual", "there is no such individual"))?.genome.clone();
    let seed = live.session().view_seed();
    let fingerprint = Fingerprint::of(&format!("{PREVIEW_FORM}\nportrait {PIXELS} {seed}\n{genome}"));
    let tag = fingerprint.to_string();
    if is_fresh(&headers, &tag) {
        return Ok(not_modified(&tag, Freshness::Revalidate));
    }
    let answer = |bytes| tagged(([(header::CONTENT_TYPE, "image/png")], bytes), &tag, Freshness::Revalidate);
    if let Some(bytes) = app.0.tiles.cached(&fingerprint).await {
        return Ok(answer(bytes));
    }
    let (portrait, window) = (app.0.queries.run(move || shown(&genome, seed)).await??, Portrait::window(PIXELS));
    let order =
        Order { fingerprint, revision: live.revision().clone(), class: class(&headers), cost_ns: portrait.cost_ns(&window), kind: ["preview", "programme"] };
    let made = bought(&app, asker, order, move |stop| preview(&Until { source: &portrait, stop: stop.clone() }, &window, -1.0)).await?;
    Ok(timed(answer(made.bytes), made.timing))
}
