//! What the ground of an area is like: how much of it can be reached, and its slopes, heights and roughness.

use crate::{
    analysis::{Statistics, accessibility},
    geometry::{Filter, Source, Surface, Until, Window, WindowError},
    server::{
        compute::WhileAsked,
        error::{ApiError, Entry},
        extract::{Asker, Body, WorldAt},
        schema::{AccessibilityQuestion, AccessibilitySchema, ProblemDetails, StatisticsQuestion, StatisticsSchema},
        state::App,
        worlds::Live,
    },
    world::Object,
};
use axum::{
    Json,
    extract::State,
    http::header,
    response::{IntoResponse, Response},
};
use std::sync::Arc;

/// Most cells.
const MAX_CELLS: u64 = 1 << 22;

/// Predicted nanoseconds that an area may take.
const MOST_NS: f64 = 1e10;

/// Nanoseconds that measuring takes a cell.
const CELL_NS: f64 = 100.0;

/// How much of an area can be reached by what climbs slopes up to a limit: the share that is not too steep, the largest connected part of it, and how long the edges of obstacles are.
///
/// Cells are samples in the middle of squares as wide as `spacing`; neighbours are the four that share a side. The terrain is that which tiles of this spacing show.
#[utoipa::path(post, path = "/worlds/{world}/accessibility", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`")), request_body(content = AccessibilityQuestion, description = "An area of up to 2^22 cells"), responses(
    (status = 200, description = "What can be reached", body = AccessibilitySchema),
    (status = 400, description = "The body is wrong, the area is beyond the plane, or it would take longer than 10 s", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The body is too large", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn post_accessibility(State(app): State<App>, WorldAt { live, .. }: WorldAt, asker: Asker, Body(body): Body) -> Result<Response, ApiError> {
    let Object(question): Object<AccessibilityQuestion> = serde_json::from_slice(&body).map_err(|error| wrong("", error.to_string()))?;
    let AccessibilityQuestion { bbox, spacing, slope } = question;
    let slope = slope.unwrap_or(15.0);
    if !(slope > 0.0 && slope < 90.0) {
        return Err(wrong("/slope", format!("must be above 0 and below 90 degrees, got {slope}")));
    }
    let found = measured(&app, &live, asker, Area { bbox, spacing }, move |surface| accessibility(surface, spacing, slope)).await?;
    let body = AccessibilitySchema {
        columns: found.columns,
        rows: found.rows,
        accessible: found.accessible_share(),
        largest: found.largest_share(),
        areas: found.areas,
        obstacles: found.obstacles,
        edge: found.edges as f64 * spacing,
    };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(body)).into_response())
}

/// What the ground of an area is like: slopes, heights, roughness, as an evolution may be asked to come near.
///
/// Samples are in the middle of squares as wide as `spacing`. The terrain is that which tiles of this spacing show; measured at another spacing it has other slopes.
#[utoipa::path(post, path = "/worlds/{world}/statistics", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`")), request_body(content = StatisticsQuestion, description = "An area of up to 2^22 samples"), responses(
    (status = 200, description = "What it is like", body = StatisticsSchema),
    (status = 400, description = "The body is wrong, the area is beyond the plane, or it would take longer than 10 s", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The body is too large", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn post_statistics(State(app): State<App>, WorldAt { live, .. }: WorldAt, asker: Asker, Body(body): Body) -> Result<Response, ApiError> {
    let Object(question): Object<StatisticsQuestion> = serde_json::from_slice(&body).map_err(|error| wrong("", error.to_string()))?;
    let StatisticsQuestion { bbox, spacing } = question;
    let Statistics { slopes, heights, relief, roughness } =
        measured(&app, &live, asker, Area { bbox, spacing }, move |surface| Statistics::of(surface, spacing)).await?;
    let body = StatisticsSchema { slopes: slopes.0, heights: heights.0, relief, roughness };
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(body)).into_response())
}

fn wrong(pointer: &str, detail: String) -> ApiError {
    ApiError::BadRequest("The question is wrong.".to_owned(), vec![Entry::pointer(pointer.to_owned(), detail)])
}

/// What is asked about.
struct Area {
    bbox: [f64; 4],
    spacing: f64,
}

/// What is found of the surface of an area, at its asker's cost.
async fn measured<T: Send + 'static>(
    app: &App,
    live: &Arc<Live>,
    asker: Asker,
    Area { bbox, spacing }: Area,
    find: impl FnOnce(&Surface) -> T + Send + 'static,
) -> Result<T, ApiError> {
    let window = Window::area(bbox, spacing, Filter::Band, MAX_CELLS).map_err(|error| match error {
        WindowError::Spacing(_) => wrong("/spacing", error.to_string()),
        _ => wrong("/bbox", error.to_string()),
    })?;
    if window.columns.is_empty() || window.rows.is_empty() {
        return Err(wrong("/bbox", "must be at least half a spacing wide and high".to_owned()));
    }
    let apron = window.with_apron(1);
    let cost_ns = live.world.cost_ns(&apron) + CELL_NS * window.samples() as f64;
    if cost_ns > MOST_NS {
        return Err(wrong(
            "/spacing",
            format!("the area would take {:.0} s, more than {:.0}: choose a greater spacing or a smaller area", cost_ns / 1e9, MOST_NS / 1e9),
        ));
    }
    asker.pay(app, cost_ns)?;
    let asked = WhileAsked::new();
    let (stop, live) = (asked.stop(), Arc::clone(live));
    let found = app.0.queries.run(move || {
        let mut surface = Surface::of(&apron);
        Until { source: &live.world, stop }.sample(&apron, &mut surface);
        find(&surface)
    });
    Ok(found.await?)
}
