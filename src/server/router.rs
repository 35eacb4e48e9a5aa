//! Every call, and the layers around them.

use super::{
    compute::panic_message,
    error::ApiError,
    handler::{catalog, description, elevation, export, feature, feature_edit, health, layer, programme, shader, tile, viewer, world},
    state::App,
};
use axum::{
    Router,
    extract::{DefaultBodyLimit, Request, State},
    http::{HeaderMap, HeaderValue, Method, header, uri::Authority},
    middleware::{self, Next},
    response::{IntoResponse, Response},
};
use std::{any::Any, net::IpAddr};
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
        (name = "features", description = "The features that worlds keep: rivers, ridges, lakes, as GeoJSON"),
        (name = "programmes", description = "The library of terrain programmes"),
        (name = "tiles", description = "Terrain as tiles"),
        (name = "exports", description = "Areas as files"),
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
        .routes(routes!(feature::list_features, feature_edit::post_features))
        .routes(routes!(feature::get_feature, feature_edit::put_feature, feature_edit::delete_feature))
        .routes(routes!(feature_edit::generate_features))
        .routes(routes!(programme::list_programmes, programme::post_programme))
        .routes(routes!(programme::get_programme, programme::put_programme, programme::delete_programme))
        .routes(routes!(programme::get_text))
        .routes(routes!(programme::get_tree))
        .routes(routes!(programme::get_preview))
        .routes(routes!(tile::get_style))
        .routes(routes!(elevation::get_elevation))
        .routes(routes!(export::get_export))
        .routes(routes!(shader::get_glsl))
        .routes(routes!(shader::get_wgsl))
        .routes(routes!(tile::get_tilejson))
        .routes(routes!(layer::get_layer))
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
        header::CONTENT_DISPOSITION,
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

/// Refuses writes that may come from another machine, or that a browser makes for a page of another site: reads are open to all, a user's worlds and
/// programmes are not theirs to change.
async fn guard_writes(State(app): State<App>, request: Request, next: Next) -> Response {
    if matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS) {
        return next.run(request).await;
    }
    if !app.0.writable || !is_local(request.headers()) {
        return ApiError::ReadOnly.into_response();
    }
    if is_cross_site(request.headers()) {
        return ApiError::CrossSite.into_response();
    }
    next.run(request).await
}

/// Whether a request was made to this machine by its own name and came through no proxy. A name that merely resolves to this machine may be a stranger's.
fn is_local(headers: &HeaderMap) -> bool {
    let proxied = ["forwarded", "via", "x-forwarded-for", "x-forwarded-host", "x-forwarded-proto", "x-real-ip"].iter().any(|name| headers.contains_key(*name));
    let authority = headers.get(header::HOST).and_then(|host| host.to_str().ok()).and_then(|host| host.parse::<Authority>().ok());
    let loopback = authority.is_some_and(|authority| {
        let host = authority.host();
        host == "localhost" || host.trim_matches(['[', ']']).parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
    });
    loopback && !proxied
}

/// Whether a browser says that the page behind a request is not one of this server's.
fn is_cross_site(headers: &HeaderMap) -> bool {
    let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
    let host = headers.get(header::HOST).map(HeaderValue::as_bytes);
    let origin = headers.get(header::ORIGIN).map(HeaderValue::as_bytes);
    let own = origin.is_none_or(|origin| host.is_some_and(|host| origin.strip_prefix(b"http://") == Some(host)));
    !own || !matches!(site, None | Some(b"same-origin" | b"none"))
}

#[expect(clippy::needless_pass_by_value, reason = "the layer hands the payload over")]
fn panicked(payload: Box<dyn Any + Send>) -> Response {
    ApiError::internal("a handler panicked", &panic_message(&*payload)).into_response()
}
