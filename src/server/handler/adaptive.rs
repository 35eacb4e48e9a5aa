//! Ground that evolves while it is used: feedback, generations, players.

use crate::{
    evolve::{Feedback, HISTORY_FORM, History, Step},
    geometry::PLANE_LIMIT,
    server::{
        adaptive::{self, Said, Shown, Target, invalid},
        error::ApiError,
        extract::{Asker, Body, Known, NameOf, PlayerAt, WorldAt, WriteCondition},
        headers::{Freshness, json, tagged},
        players::Full,
        schema::{
            FedSchema, FeedbackSchema, GenerationName, GenerationsSchema, GrownGeneration, HashOrNumber, PlayerSchema, PlayersSchema, ProblemDetails,
            PromiseSchema, ReturnSchema, WaySchema,
        },
        shelf::Shelved,
        state::App,
        vocabulary::{MatchCondition, Name},
        worlds::Live,
    },
    store::GenerationEntry,
    world::read_document,
};
use axum::{
    Json,
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use serde::{Deserialize, de::DeserializeOwned};
use std::time::Instant;
use utoipa::{IntoParams, IntoResponses};

/// Most positions that are told at a time.
const MAX_POSITIONS: usize = 1024;

/// Most bytes of feedback in a history that is answered.
const MAX_HISTORY_BYTES: u64 = 1 << 26;

/// Why the ground stays as it is.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the description alone")]
pub(crate) enum AdaptiveErrors {
    #[response(status = 400, description = "The body is no JSON, or a condition cannot be understood", content_type = "application/problem+json")]
    BadRequest(ProblemDetails),
    #[response(
        status = 403,
        description = "The request comes from another machine, or from a web page of another site",
        content_type = "application/problem+json"
    )]
    Forbidden(ProblemDetails),
    #[response(status = 404, description = "No such world", content_type = "application/problem+json")]
    NotFound(ProblemDetails),
    #[response(status = 413, description = "The body is too large", content_type = "application/problem+json")]
    TooLarge(ProblemDetails),
    #[response(
        status = 422,
        description = "Something in it is wrong: the place and what would be right; nothing is changed",
        content_type = "application/problem+json"
    )]
    Invalid(ProblemDetails),
}

/// Which layer's generations are asked for.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct GenerationsQuery {
    /// The name of the layer; needed if several are adaptive.
    layer: Option<String>,
    /// Present, with any value or none: with all that they follow from.
    #[param(value_type = Option<String>)]
    history: Option<String>,
}

fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, ApiError> {
    read_document(body).map_err(ApiError::feedback)
}

fn answer(changed: Shown) -> Response {
    let Shown { live, layer, generation, changed, deviation } = changed;
    let revision = live.revision().to_string();
    let body = FedSchema {
        layer,
        generation: GenerationName { hash: generation.hash().to_owned(), number: generation.number() },
        revision: revision.clone(),
        changed,
        deviation,
    };
    tagged(Json(body), &revision, Freshness::Revalidate)
}

/// Breeds the next generation of an adaptive layer: more of what the feedback points at.
///
/// The world's new revision shows it. Around players, and their ways since the last generation, nothing changes.
#[utoipa::path(post, path = "/worlds/{world}/feedback", tag = "adaptive", params(("world" = inline(Name), Path, description = "A name"), MatchCondition), request_body = FeedbackSchema, responses(
    (status = 200, description = "The generation", body = FedSchema, headers(("ETag" = String, description = "The world's new revision"))),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too much feedback is waiting", body = ProblemDetails, content_type = "application/problem+json"),
    AdaptiveErrors,
))]
pub(crate) async fn post_feedback(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Live>,
    WriteCondition(condition): WriteCondition,
    asker: Asker,
    Body(body): Body,
) -> Result<Response, ApiError> {
    let FeedbackSchema { layer, points, heights, radius, players } = read(&body)?;
    let feedback = Feedback { points, heights, radius, ways: Vec::new(), margin: 0.0 };
    Ok(answer(adaptive::feed(&app, asker, name, Said { layer, feedback, players }, condition).await?))
}

/// The generations of an adaptive layer, from the first to the one that is shown.
#[utoipa::path(get, path = "/worlds/{world}/generations", tag = "adaptive", params(("world" = String, Path, description = "`name` or `name@revision`"), GenerationsQuery), responses(
    (status = 200, description = "The generations", body = GenerationsSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "The layer is not one that adapts, or the history is too long to be answered", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_generations(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    Known(query): Known<GenerationsQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (_, layer, generation) = adaptive::chosen(live.document(), query.layer.as_deref()).map_err(|detail| ApiError::parameter("layer", detail))?;
    let mut way = app.0.store.generations(generation.hash()).await?;
    if way.is_empty() {
        // Nobody has fed it.
        way.push(GenerationEntry { hash: generation.hash().to_owned(), number: 0, time: String::new(), feedback: None, deviation: None });
    }
    let history = match query.history {
        Some(_) => Some(history(&app, generation).await?),
        None => None,
    };
    let generations = way.into_iter().map(grown).collect::<Result<_, _>>()?;
    let body = GenerationsSchema { layer: layer.name.clone(), current: generation.hash().to_owned(), generations, history };
    json(&headers, &body, Freshness::of(pinned))
}

fn unreadable(error: &dyn std::fmt::Display) -> ApiError {
    ApiError::internal("a stored generation cannot be read", error)
}

fn grown(GenerationEntry { hash, number, time, feedback, deviation }: GenerationEntry) -> Result<GrownGeneration, ApiError> {
    let is_bred = number > 0;
    let feedback = feedback.map(|json| serde_json::from_str(&json)).transpose().map_err(|error| unreadable(&error))?;
    Ok(GrownGeneration { number: number as usize, hash, time: is_bred.then_some(time), feedback, deviation })
}

async fn history(app: &App, generation: &crate::evolve::Generation) -> Result<History, ApiError> {
    let too_long = || ApiError::parameter("history", format!("is longer than {MAX_HISTORY_BYTES} bytes: ask for that of an older revision"));
    let way = app.0.store.whole_generations(generation.hash(), MAX_HISTORY_BYTES).await?.ok_or_else(too_long)?;
    let bred = way.iter().filter_map(|entry| entry.feedback.as_deref());
    let step = |(from, json)| Ok(Step { from, feedback: serde_json::from_str(json).map_err(|error| unreadable(&error))? });
    let steps: Vec<Step> = bred.enumerate().map(step).collect::<Result<_, ApiError>>()?;
    Ok(History { form: HISTORY_FORM, ground: (**generation.ground()).clone(), current: steps.len(), steps })
}

/// Lets an adaptive layer show a generation that was bred before, from which the next will be bred. Nothing is lost: those after it can be gone to by their hashes.
#[utoipa::path(put, path = "/worlds/{world}/generation", tag = "adaptive", params(("world" = inline(Name), Path, description = "A name"), MatchCondition), request_body = ReturnSchema, responses(
    (status = 200, description = "The generation", body = FedSchema, headers(("ETag" = String, description = "The world's revision"))),
    (status = 409, description = "A player is on the ground, or within the promised distance of it", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 412, description = "The condition does not hold", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too much feedback is waiting", body = ProblemDetails, content_type = "application/problem+json"),
    AdaptiveErrors,
))]
pub(crate) async fn put_generation(
    State(app): State<App>,
    NameOf { name, .. }: NameOf<Live>,
    WriteCondition(condition): WriteCondition,
    Body(body): Body,
) -> Result<Response, ApiError> {
    let ReturnSchema { layer, generation } = read(&body)?;
    let target = match generation {
        HashOrNumber::Hash(hash) => Target::Hash(hash),
        HashOrNumber::Number(number) => Target::Number(number),
    };
    Ok(answer(adaptive::go_to(&app, name, layer, target, condition).await?))
}

/// Who plays in a world.
#[utoipa::path(get, path = "/worlds/{world}/players", tag = "adaptive", params(("world" = String, Path, description = "`name` or `name@revision`")), responses(
    (status = 200, description = "The players", body = PlayersSchema),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_players(State(app): State<App>, WorldAt { live, .. }: WorldAt) -> Response {
    let room = app.0.players.hold(&live.name).await;
    let players = room.all(Instant::now()).map(|(name, position, seen)| PlayerSchema { name: name.to_owned(), position, seen: seen.as_secs_f64() }).collect();
    ([(header::CACHE_CONTROL, "no-store")], Json(PlayersSchema { players })).into_response()
}

/// Tells where a player went since it last did. Who is not heard of for a minute is gone.
///
/// As long as it is there, nothing changes within the promised distance of where it is, and of its way since each generation: for exact samples, and for tiles at spacings up to the
/// cells of the ground.
#[utoipa::path(put, path = "/worlds/{world}/players/{player}", tag = "adaptive", params(
    ("world" = inline(Name), Path, description = "A name"),
    ("player" = inline(Name), Path, description = "A name of its own: 1 to 63 of a … z, 0 … 9 and -"),
), request_body = WaySchema, responses(
    (status = 200, description = "It is there", body = PromiseSchema),
    (status = 409, description = "As many players as a world can have are there", body = ProblemDetails, content_type = "application/problem+json"),
    AdaptiveErrors,
))]
pub(crate) async fn put_player(State(app): State<App>, PlayerAt { world, player }: PlayerAt, Body(body): Body) -> Result<Response, ApiError> {
    let WaySchema { positions } = read(&body)?;
    if !(1..=MAX_POSITIONS).contains(&positions.len()) {
        return Err(invalid("/positions", format!("must hold 1 to {MAX_POSITIONS} positions, got {}", positions.len())));
    }
    if let Some(i) = positions.iter().position(|position| position.iter().any(|c| c.abs() > PLANE_LIMIT)) {
        return Err(invalid(&format!("/positions/{i}"), "must be plane metres within 2^40 of the origin"));
    }
    // While a generation is bred this waits: what is answered counts from then on.
    let mut room = app.0.players.hold(&world).await;
    let live = Live::shelf(&app).get(&world).ok_or_else(|| ApiError::absent("world", format!("no world is named {world:?}")))?;
    let grounds = adaptive::grounds(live.document());
    room.go(&player, &positions, &grounds, Instant::now()).map_err(|Full| ApiError::Conflict("As many players as a world can have are there.".to_owned()))?;
    let promise = grounds.iter().map(|(_, ground)| ground.promise).reduce(f64::min);
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(PromiseSchema { promise })).into_response())
}

/// A player leaves, or has left already: nothing is promised to whoever is not there.
#[utoipa::path(delete, path = "/worlds/{world}/players/{player}", tag = "adaptive", params(
    ("world" = inline(Name), Path, description = "A name"),
    ("player" = inline(Name), Path, description = "The player's name"),
), responses(
    (status = 204, description = "It is gone"),
    (status = 400, description = "No valid name", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn delete_player(State(app): State<App>, PlayerAt { world, player }: PlayerAt) -> Result<StatusCode, ApiError> {
    if Live::shelf(&app).get(&world).is_none() {
        return Err(ApiError::absent("world", format!("no world is named {world:?}")));
    }
    app.0.players.hold(&world).await.leave(&player);
    Ok(StatusCode::NO_CONTENT)
}
