//! Long work: asked for, looked at, given up.

use super::raster::picture;
use crate::{
    server::{
        error::ApiError,
        extract::{Asker, Body, Hash, PublicUrl},
        headers::{Freshness, json},
        jobs::Progress,
        schema::{JobList, JobPreviewSchema, JobSchema, JobStateName, ProblemDetails, WorkSchema},
        state::App,
        vocabulary::HashName,
    },
    store::{JobEntry, JobState},
    world::{Work, WorkKind},
};
use axum::{
    Json,
    extract::State,
    http::{HeaderMap, StatusCode, header},
    response::{IntoResponse, Response},
};
use base64::{Engine, engine::general_purpose::STANDARD};
use utoipa::IntoResponses;

/// Most jobs in one answer.
const MAX_LISTED: u32 = 1_000;

/// Most pixels of a preview along a side.
const PIXELS: usize = 1024;

/// Why work is not taken.
#[derive(IntoResponses)]
#[expect(dead_code, reason = "for the description alone")]
pub(crate) enum WorkErrors {
    #[response(status = 400, description = "The body is no JSON", content_type = "application/problem+json")]
    BadRequest(ProblemDetails),
    #[response(
        status = 403,
        description = "The request comes from another machine, or from a web page of another site",
        content_type = "application/problem+json"
    )]
    Forbidden(ProblemDetails),
    #[response(status = 413, description = "The body is too large", content_type = "application/problem+json")]
    TooLarge(ProblemDetails),
    #[response(
        status = 422,
        description = "Something in it is wrong: every problem with its place; nothing is stored",
        content_type = "application/problem+json"
    )]
    Invalid(ProblemDetails),
}

fn unknown(id: &str) -> ApiError {
    ApiError::absent("job", format!("there is no job {id}"))
}

/// A job that there is.
pub(super) async fn find(app: &App, id: &str) -> Result<JobEntry, ApiError> {
    app.0.store.job(id).await?.ok_or_else(|| unknown(id))
}

/// What a stored job was asked for.
pub(super) async fn stored_work(app: &App, entry: &JobEntry) -> Result<Work, ApiError> {
    let text = entry.work.clone();
    let work = app.0.queries.run(move || Work::parse(text.as_bytes())).await?;
    work.map_err(|error| ApiError::internal("a stored job cannot be read", &error))
}

fn schema(app: &App, url: &str, entry: JobEntry, whole: bool) -> Result<JobSchema, ApiError> {
    let unreadable = |error: &dyn std::fmt::Display| ApiError::internal("a stored job cannot be read", error);
    let work: serde_json::Value = serde_json::from_str(&entry.work).map_err(|error| unreadable(&error))?;
    let title = work.pointer("/paths/drawing/title").and_then(serde_json::Value::as_str).map(str::to_owned);
    let (kind, evolution) = match work.get("evolution") {
        Some(_) => (WorkKind::Evolution, Some(format!("{url}/jobs/{}/evolution", entry.id))),
        None => (WorkKind::Paths, None),
    };
    let kept = entry.steps.map_or(0.0, |[done, of]| if of > 0 { done as f64 / of as f64 } else { 0.0 });
    let (mut raster, mut failure) = (None, None);
    let (state, progress) = match entry.state {
        JobState::Open => match app.0.jobs.progress(&entry.id) {
            Progress::Waiting => (JobStateName::Waiting, kept),
            Progress::Running(share) => (JobStateName::Running, share.max(kept)),
        },
        JobState::Stopped => (JobStateName::Stopped, kept),
        JobState::Done(name) => {
            raster = name.map(|name| format!("{url}/rasters/{name}"));
            (JobStateName::Done, 1.0)
        }
        JobState::Failed(why) => {
            failure = Some(why);
            (JobStateName::Failed, kept)
        }
    };
    Ok(JobSchema { id: entry.id, kind, title, time: entry.time, state, progress, raster, evolution, failure, work: whole.then_some(work) })
}

/// The jobs that were asked for.
#[utoipa::path(get, path = "/jobs", tag = "jobs", responses(
    (status = 200, description = "The jobs, newest first", body = JobList, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
))]
pub(crate) async fn list_jobs(State(app): State<App>, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let entries = app.0.store.jobs(MAX_LISTED).await?;
    let jobs = entries.into_iter().map(|entry| schema(&app, &url, entry, false)).collect::<Result<_, _>>()?;
    json(&headers, &JobList { jobs }, Freshness::Revalidate)
}

/// Asks for long work.
///
/// Jobs are done in turn and outlive the server: what is acknowledged is on disk. Asking for the same gives the same job, and what is done is not done again.
#[utoipa::path(post, path = "/jobs", tag = "jobs", request_body = WorkSchema, responses(
    (status = 200, description = "It was asked for before", body = JobSchema, headers(("Location" = String, description = "The job"))),
    (status = 202, description = "It waits, or is under way", body = JobSchema, headers(("Location" = String, description = "The job"))),
    (status = 503, description = "Too many jobs are waiting", body = ProblemDetails, content_type = "application/problem+json"),
    WorkErrors,
))]
pub(crate) async fn post_job(State(app): State<App>, PublicUrl(url): PublicUrl, Body(body): Body) -> Result<Response, ApiError> {
    let checked = app.0.queries.run(move || {
        let work = Work::parse(&body)?;
        work.check()?;
        Ok(work)
    });
    let work = checked.await?.map_err(ApiError::work)?;
    asked(&app, &url, ask(&app, work).await?)
}

/// Asks for work. Once begun it ends, whether or not the client stays: what is on disk is also in the queue.
async fn ask(app: &App, work: Work) -> Result<JobEntry, ApiError> {
    let asking = app.clone();
    tokio::spawn(async move { asking.0.jobs.ask(work).await }).await.map_err(|error| ApiError::internal("asking for a job", &error))?
}

/// What is answered to who asked for a job.
fn asked(app: &App, url: &str, entry: JobEntry) -> Result<Response, ApiError> {
    let status = if matches!(entry.state, JobState::Open) { StatusCode::ACCEPTED } else { StatusCode::OK };
    let location = [(header::LOCATION, format!("{url}/jobs/{}", entry.id))];
    Ok((status, location, [(header::CACHE_CONTROL, "no-store")], Json(schema(app, url, entry, false)?)).into_response())
}

/// How far a job is, and what it is asked for.
#[utoipa::path(get, path = "/jobs/{job}", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id")), responses(
    (status = 200, description = "The job", body = JobSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 404, description = "No such job", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_job(State(app): State<App>, Hash(id): Hash, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let entry = find(&app, &id).await?;
    json(&headers, &schema(&app, &url, entry, true)?, Freshness::Revalidate)
}

/// Gives a job up, or forgets it when it is done. What it made stays.
#[utoipa::path(delete, path = "/jobs/{job}", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id")), responses(
    (status = 204, description = "It is gone"),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such job", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn delete_job(State(app): State<App>, Hash(id): Hash) -> Result<StatusCode, ApiError> {
    let forgetting = (app.clone(), id.clone());
    let forgotten = tokio::spawn(async move { forgetting.0.0.jobs.forget(&forgetting.1).await }).await;
    let known = forgotten.map_err(|error| ApiError::internal("forgetting a job", &error))??;
    if known { Ok(StatusCode::NO_CONTENT) } else { Err(unknown(&id)) }
}

/// Lays a job aside: the step under way is given up, what was done before it stays. Asking for the same again, or resuming it, goes on from there to the same end.
///
/// An evolution loses at most the generation under way; a drawing begins anew.
#[utoipa::path(post, path = "/jobs/{job}/stop", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id")), responses(
    (status = 200, description = "It is stopped", body = JobSchema),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such job", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 409, description = "It is done, or failed", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn stop_job(State(app): State<App>, Hash(id): Hash, PublicUrl(url): PublicUrl) -> Result<Response, ApiError> {
    let stopping = (app.clone(), id.clone());
    let stopped = tokio::spawn(async move { stopping.0.0.jobs.lay_aside(&stopping.1).await }).await;
    let entry = stopped.map_err(|error| ApiError::internal("stopping a job", &error))??.ok_or_else(|| unknown(&id))?;
    if entry.state != JobState::Stopped {
        return Err(ApiError::Conflict(format!("The job is {}: there is nothing to stop.", entry.state.name())));
    }
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(schema(&app, &url, entry, false)?)).into_response())
}

/// Lets a stopped job go on from where it was.
#[utoipa::path(post, path = "/jobs/{job}/resume", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id")), responses(
    (status = 200, description = "It is done by now", body = JobSchema, headers(("Location" = String, description = "The job"))),
    (status = 202, description = "It waits, or is under way", body = JobSchema, headers(("Location" = String, description = "The job"))),
    (status = 403, description = "The request comes from another machine, or from a web page of another site", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such job", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 409, description = "It is done, or failed", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many jobs are waiting", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn resume_job(State(app): State<App>, Hash(id): Hash, PublicUrl(url): PublicUrl) -> Result<Response, ApiError> {
    let entry = find(&app, &id).await?;
    match entry.state {
        JobState::Stopped | JobState::Open => asked(&app, &url, ask(&app, stored_work(&app, &entry).await?).await?),
        JobState::Done(_) => Err(ApiError::Conflict("The job is done: there is nothing to resume.".to_owned())),
        JobState::Failed(_) => Err(ApiError::Conflict("The job failed: ask for the same again to begin anew.".to_owned())),
    }
}

/// About what a job will make, on the threads of questions.
async fn preview(app: &App, read: impl FnOnce() -> Result<Work, ApiError> + Send + 'static) -> Result<JobPreviewSchema, ApiError> {
    let drawn = app.0.queries.run(move || {
        let (raster, steps) = read()?.preview().map_err(ApiError::work)?;
        let (bbox, png) = picture(&raster, PIXELS)?;
        let picture = format!("data:image/png;base64,{}", STANDARD.encode(png));
        Ok(JobPreviewSchema { bbox, elevation: raster.range(), steps, picture })
    });
    drawn.await?
}

/// About what work would make, quickly: nothing is stored.
///
/// Heights are those of one search from all strokes together, which is within a second what the job then takes its time for: where strokes meet there are creases yet.
#[utoipa::path(post, path = "/jobs/preview", tag = "jobs", request_body = WorkSchema, responses(
    (status = 200, description = "A picture and its place", body = JobPreviewSchema),
    WorkErrors,
))]
pub(crate) async fn post_preview(State(app): State<App>, Body(body): Body) -> Result<Response, ApiError> {
    let shown = preview(&app, move || Work::parse(&body).map_err(ApiError::work)).await?;
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(shown)).into_response())
}

/// About what a job will make.
#[utoipa::path(get, path = "/jobs/{job}/preview", tag = "jobs", params(("job" = inline(HashName), Path, description = "A job's id")), responses(
    (status = 200, description = "A picture and its place", body = JobPreviewSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 404, description = "No such job", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_preview(State(app): State<App>, Hash(id): Hash, asker: Asker, headers: HeaderMap) -> Result<Response, ApiError> {
    /// Predicted nanoseconds.
    const COST_NS: f64 = 5e8;
    let entry = find(&app, &id).await?;
    let work = stored_work(&app, &entry).await?;
    if work.kind() != WorkKind::Paths {
        return Err(ApiError::absent("job", "an evolution has no preview: look at its best.png"));
    }
    asker.pay(&app, COST_NS)?;
    let shown = preview(&app, move || Ok(work)).await?;
    json(&headers, &shown, Freshness::Revalidate)
}
