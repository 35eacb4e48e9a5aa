//! What happens, as it happens.

use crate::server::{
    error::ApiError,
    events::{Told, Wanted},
    extract::{Asker, Known},
    schema::ProblemDetails,
    state::App,
    vocabulary::{HashName, Name},
};
use axum::{
    extract::State,
    http::{HeaderMap, HeaderName, header},
    response::{
        IntoResponse, Response,
        sse::{Event, KeepAlive, Sse},
    },
};
use futures_util::StreamExt;
use serde::Deserialize;
use std::{convert::Infallible, time::Duration};
use utoipa::IntoParams;

/// How soon a client comes back that lost its connection.
const RETRY: Duration = Duration::from_secs(1);

/// How often something is sent where nothing happens, so that nobody on the way takes the connection for dead.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Which events are wanted.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct EventQuery {
    /// Only those of this world, and of the job that is named.
    #[param(value_type = Option<Name>, inline)]
    world: Option<String>,
    /// Only those of this job, and of the world that is named.
    #[param(value_type = Option<HashName>, inline)]
    job: Option<String>,
}

fn event(kind: &str, id: String, data: &impl serde::Serialize) -> Event {
    let event = Event::default().event(kind).id(id).retry(RETRY);
    // A field that could not be written would be a map with keys that are no text: no event has one.
    event.json_data(data).unwrap_or_default()
}

/// Events as they happen: server-sent events, which end only with the connection or the server.
///
/// `world` (`{"world", "revision"}`; `null` for a world that is gone), `generation` (`{"world", "layer", "number", "hash", "revision", "changed"}`: ground that evolves shows another, whose
/// revision a `world` tells before; `changed` is `[minx, miny, maxx, maxy]` or `null`) and `job` (`{"job", "state", "progress"}`, when one begins, goes on and ends). Every event has an id; a client that comes back with
/// `Last-Event-ID` hears what it missed, as far as the last 1,024 events of this run of the server go, and `reset` (`{}`) where they do not: then it should look at everything anew.
#[utoipa::path(get, path = "/events", tag = "events", params(
    EventQuery,
    ("Last-Event-ID" = Option<String>, Header, description = "The id of the last event that was heard"),
), responses(
    (status = 200, description = "Events, one after the other", body = String, content_type = "text/event-stream"),
    (status = 400, description = "A parameter is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many are listening, in all or from one address", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_events(
    State(app): State<App>,
    Known(EventQuery { world, job }): Known<EventQuery>,
    Asker(client): Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let last = headers.get("last-event-id").and_then(|id| id.to_str().ok());
    let told = app.0.events.listen(&client, Wanted { world, job }, last).ok_or(ApiError::Busy)?;
    let sent = told.map(|told| {
        Ok::<_, Infallible>(match told {
            Told::Event(id, happened) => event(happened.kind(), id, &*happened),
            Told::Reset(id) => event("reset", id, &serde_json::json!({})),
        })
    });
    // The first bytes go out at once, so that the client knows that it is heard from now on.
    let hello = futures_util::stream::once(async { Ok(Event::default().comment("listening").retry(RETRY)) });
    let stream = Sse::new(hello.chain(sent)).keep_alive(KeepAlive::new().interval(KEEP_ALIVE));
    // Proxies that collect answers before they pass them on are asked not to.
    let fields = [(header::CACHE_CONTROL, "no-store"), (HeaderName::from_static("x-accel-buffering"), "no")];
    Ok((fields, stream).into_response())
}
