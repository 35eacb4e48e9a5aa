//! Evolutions towards what is wanted: how they go, and what they found.

use super::{
    job::{find, stored_work},
    programme::PreviewQuery,
};
use crate::{
    evolve::{Aim, Found, MAX_SEARCH_GENERATIONS, Search, Sight},
    geometry::Until,
    server::{
        error::ApiError,
        extract::{Asker, Hash, Known, PublicUrl},
        headers::{Freshness, class, is_fresh, json, not_modified, tagged, timed},
        payment::bought,
        schema::{BestSchema, CriterionSchema, EvolutionSchema, GenerationPoint, ProblemDetails},
        state::App,
        tiles::Order,
        vocabulary::HashName,
    },
    store::{JobEntry, Log},
    tile::{PREVIEW_FORM, preview},
    world::{Fingerprint, Revision, Work},
};
use axum::{
    extract::State,
    http::{HeaderMap, header},
    response::Response,
};
use serde::Deserialize;
use utoipa::IntoParams;

/// From where on the curve is wanted.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct CurveQuery {
    /// The first generation of the curve that is answered.
    #[param(value_type = Option<u32>, minimum = 0, maximum = 4_294_967_295_u32, default = 0)]
    from: Option<String>,
}

impl CurveQuery {
    fn generation(&self) -> Result<u32, ApiError> {
        let Some(from) = &self.from else { return Ok(0) };
        from.parse().map_err(|_not_whole| ApiError::parameter("from", format!("must be a whole number from 0 on, got {from:?}")))
    }
}

/// An evolution that there is.
async fn search(app: &App, id: &str) -> Result<(JobEntry, Box<Search>), ApiError> {
    let entry = find(app, id).await?;
    match stored_work(app, &entry).await? {
        Work::Evolution(search) => Ok((entry, search)),
        Work::Drawing(_) => Err(ApiError::absent("job", format!("the job {id} is no evolution"))),
    }
}

fn unreadable(error: &serde_json::Error) -> ApiError {
    ApiError::internal("what an evolution found cannot be read", error)
}

fn best(found: &Found, aim: &Aim, picture: String) -> BestSchema {
    // What is flat was not judged.
    let score = |i: usize| found.judgement.scores.get(i).copied().unwrap_or_default();
    let criteria = aim.wanted.0.iter().enumerate();
    BestSchema {
        generation: found.generation,
        programme: found.genome.to_string(),
        score: found.judgement.score,
        criteria: criteria.map(|(i, term)| CriterionSchema { criterion: term.criterion.name(), weight: term.weight, score: score(i) }).collect(),
        seed: aim.seed,
        scale: aim.scale,
        amplitude: found.judgement.amplitude,
        datum: found.judgement.datum,
        side: aim.side,
        picture,
    }
}

/// How an evolution goes: its curve and its best so far. What is answered is on disk.
#[utoipa::path(get, path = "/jobs/{job}/evolution", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id"), CurveQuery), responses(
    (status = 200, description = "The evolution", body = EvolutionSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such job, or it is no evolution", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_evolution(
    State(app): State<App>,
    Hash(id): Hash,
    Known(query): Known<CurveQuery>,
    PublicUrl(url): PublicUrl,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let from = query.generation()?;
    let (_, search) = search(&app, &id).await?;
    let log = app.0.store.log(&id, from.into(), MAX_SEARCH_GENERATIONS as u32 + 1).await?;
    let described = app.0.queries.run(move || {
        let mut answer = EvolutionSchema { generation: None, of: search.settings.generations, goal: search.goal, curve: Vec::new(), best: None };
        if let Some(Log { step, found, lines }) = log {
            answer.generation = Some(step);
            answer.curve = lines.iter().map(|line| serde_json::from_str::<GenerationPoint>(line)).collect::<Result<_, _>>()?;
            answer.best = Some(best(&serde_json::from_str(&found)?, &search.aim, format!("{url}/jobs/{id}/best.png")));
        }
        Ok::<_, serde_json::Error>(answer)
    });
    json(&headers, &described.await?.map_err(|error| unreadable(&error))?, Freshness::Revalidate)
}

/// A relief picture of an evolution's best so far, over the square that it is judged over.
#[utoipa::path(get, path = "/jobs/{job}/best.png", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id"), PreviewQuery), responses(
    (status = 200, description = "The picture", content((Vec<u8> = "image/png")), headers(("ETag" = String, description = "The picture's fingerprint: another best has another"))),
    (status = 304, description = "The picture is what If-None-Match names; nothing was evaluated"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such job, it is no evolution, or it has found nothing yet", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 500, description = "The evaluation failed", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many tiles are waiting", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_best(
    State(app): State<App>,
    Hash(id): Hash,
    Known(query): Known<PreviewQuery>,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let pixels = query.pixels()?;
    let (entry, search) = search(&app, &id).await?;
    let log = app.0.store.log(&id, 0, 0).await?.ok_or_else(|| ApiError::absent("job", format!("the job {id} has found nothing yet")))?;
    let found: Found = serde_json::from_str(&log.found).map_err(|error| unreadable(&error))?;
    let place = [search.aim.scale, search.aim.side, found.judgement.amplitude, found.judgement.datum].map(f64::to_bits);
    let fingerprint = Fingerprint::of(&format!("{PREVIEW_FORM}\nsight {pixels} {} {place:x?}\n{}", search.aim.seed, found.genome));
    let tag = fingerprint.to_string();
    if is_fresh(&headers, &tag) {
        return Ok(not_modified(&tag, Freshness::Revalidate));
    }
    let answer = |bytes| tagged(([(header::CONTENT_TYPE, "image/png")], bytes), &tag, Freshness::Revalidate);
    if let Some(bytes) = app.0.tiles.cached(&fingerprint).await {
        return Ok(answer(bytes));
    }
    let window = search.aim.window(pixels);
    let sight = app.0.queries.run(move || Sight::new(&search.aim, &found)).await?;
    let sight = sight.map_err(|error| ApiError::internal("a bred programme cannot be shown", &error))?;
    let revision = Revision::parse(&entry.id).ok_or_else(|| ApiError::internal("a job has no name", &entry.id))?;
    let order = Order { fingerprint, revision, class: class(&headers), cost_ns: sight.cost_ns(&window), kind: ["preview", "programme"] };
    let made = bought(&app, asker, order, move |stop| preview(&Until { source: &sight, stop: stop.clone() }, &window, -1.0)).await?;
    Ok(timed(answer(made.bytes), made.timing))
}
