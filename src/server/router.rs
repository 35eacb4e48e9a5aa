//! Every call, and the layers around them.

use super::{
    compute::panic_message,
    error::ApiError,
    handler::{catalog, description, elevation, health, tile, viewer, world},
    state::App,
};
use axum::{
    Router,
    extract::{DefaultBodyLimit, Request, State},
    http::{HeaderValue, Method, header},
    middleware::{self, Next},
    response::{IntoResponse, Response},
};
use std::any::Any;
use tower_http::{
    catch_panic::CatchPanicLayer,
    cors::{Any as AnyOrigin, CorsLayer},
};
use utoipa::OpenApi;
use utoipa_axum::{router::OpenApiRouter, routes};

#[derive(OpenApi)]
#[openapi(
    info(title = "Terrane", description = "Streams endless, deterministic, generated terrain to map viewers, GIS tools and game clients."),
    tags(
        (name = "worlds", description = "World documents and their revisions"),
        (name = "tiles", description = "Terrain as tiles"),
        (name = "queries", description = "Questions about the ground"),
        (name = "pages", description = "For people"),
        (name = "health", description = "For those who run the server"),
    ),
)]
struct Api;

fn documented() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Api::openapi())
        .routes(routes!(viewer::get_viewer))
        .routes(routes!(description::get_openapi))
        .routes(routes!(health::get_liveness))
        .routes(routes!(health::get_readiness))
        .routes(routes!(catalog::get_catalog))
        .routes(routes!(catalog::list_worlds, world::post_world))
        .routes(routes!(world::get_world, world::put_world, world::delete_world))
        .routes(routes!(world::list_revisions))
        .routes(routes!(tile::get_style))
        .routes(routes!(elevation::get_elevation))
        .routes(routes!(tile::get_tilejson))
        .routes(routes!(tile::get_tile))
}

/// The `OpenAPI` 3.1 description of the interface.
#[must_use]
pub fn openapi() -> utoipa::openapi::OpenApi {
    documented().split_for_parts().1
}

/// The whole service.
pub fn router(app: App) -> Router {
    let (router, _) = documented().split_for_parts();
    let cors = CorsLayer::new().allow_origin(AnyOrigin).allow_methods([Method::GET, Method::HEAD]).allow_headers(AnyOrigin).expose_headers([
        header::ETAG,
        header::LOCATION,
        header::RETRY_AFTER,
    ]);
    router
        .fallback(viewer::get_file)
        .method_not_allowed_fallback(async || ApiError::MethodNotAllowed)
        .layer(DefaultBodyLimit::max(app.0.world_bytes))
        .layer(middleware::from_fn_with_state(app.clone(), guard_writes))
        .layer(cors)
        .layer(CatchPanicLayer::custom(panicked))
        .with_state(app)
}

/// Refuses writes on an address that others reach, and those that a browser says come from a page of another site: reads are open to all, a user's worlds
/// are not theirs to change.
async fn guard_writes(State(app): State<App>, request: Request, next: Next) -> Response {
    if matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS) {
        return next.run(request).await;
    }
    let site = request.headers().get("sec-fetch-site").map(HeaderValue::as_bytes);
    match (app.0.writable, site) {
        (false, _) => ApiError::ReadOnly.into_response(),
        (true, None | Some(b"same-origin" | b"none")) => next.run(request).await,
        (true, Some(_)) => ApiError::CrossSite.into_response(),
    }
}

#[expect(clippy::needless_pass_by_value, reason = "the layer hands the payload over")]
fn panicked(payload: Box<dyn Any + Send>) -> Response {
    ApiError::internal("a handler panicked", &panic_message(&*payload)).into_response()
}
