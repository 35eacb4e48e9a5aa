//! Every call, and the layers around them.

use super::{
    access::{guard, needed},
    config::Reads,
    error::ApiError,
    handler::{
        accessibility, adaptive, breeding, catalog, description, elevation, event, evolution, export, feature, feature_edit, health, job, layer, programme,
        raster, shader, tile, viewer, world,
    },
    observe::observe,
    state::App,
};
use axum::{
    Router,
    extract::DefaultBodyLimit,
    http::{HeaderName, Method, header},
    middleware,
};
use tower::ServiceBuilder;
use tower_http::cors::{AllowHeaders, Any as AnyOrigin, CorsLayer};
use utoipa::{
    OpenApi,
    openapi::{
        ContentBuilder, RefOr, ResponseBuilder,
        security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme},
    },
};
use utoipa_axum::{router::OpenApiRouter, routes};

#[derive(OpenApi)]
#[openapi(
    info(title = "Terrane", description = "Streams endless, deterministic, generated terrain to map viewers, GIS tools and game clients."),
    tags(
        (name = "worlds", description = "World documents and their revisions"),
        (name = "features", description = "The features that worlds keep: rivers, ridges, lakes, as GeoJSON"),
        (name = "adaptive", description = "Ground that evolves while it is used"),
        (name = "programmes", description = "The library of terrain programmes"),
        (name = "breeding", description = "Terrain programmes bred by a designer's choice"),
        (name = "tiles", description = "Terrain as tiles"),
        (name = "exports", description = "Areas as files"),
        (name = "jobs", description = "Long work, and the rasters that it makes"),
        (name = "events", description = "What happens on the server, as it happens"),
        (name = "queries", description = "Questions about the ground"),
        (name = "pages", description = "For people"),
        (name = "health", description = "For those who run the server"),
    ),
)]
struct Api;

/// The calls whose questions may be too long for an address, so that pages of other sites may post them too.
fn questions() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(elevation::get_elevation, elevation::post_elevation))
        .routes(routes!(accessibility::post_accessibility))
        .routes(routes!(accessibility::post_statistics))
}

fn others() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(Api::openapi())
        .routes(routes!(viewer::get_viewer))
        .routes(routes!(description::get_openapi))
        .routes(routes!(health::get_liveness))
        .routes(routes!(health::get_readiness))
        .routes(routes!(health::get_metrics))
        .routes(routes!(catalog::get_catalog))
        .routes(routes!(catalog::get_wmts))
        .routes(routes!(catalog::list_worlds, world::post_world))
        .routes(routes!(world::get_world, world::put_world, world::delete_world))
        .routes(routes!(world::list_revisions))
        .routes(routes!(feature::list_features, feature_edit::post_features))
        .routes(routes!(feature::get_feature, feature_edit::put_feature, feature_edit::delete_feature))
        .routes(routes!(feature_edit::generate_features))
        .routes(routes!(adaptive::post_feedback))
        .routes(routes!(adaptive::list_generations))
        .routes(routes!(adaptive::put_generation))
        .routes(routes!(adaptive::list_players))
        .routes(routes!(adaptive::put_player, adaptive::delete_player))
        .routes(routes!(programme::list_programmes, programme::post_programme))
        .routes(routes!(programme::get_programme, programme::put_programme, programme::delete_programme))
        .routes(routes!(programme::get_text))
        .routes(routes!(programme::get_tree))
        .routes(routes!(programme::get_preview))
        .routes(routes!(breeding::list_sessions, breeding::post_session))
        .routes(routes!(breeding::get_session, breeding::put_session, breeding::delete_session))
        .routes(routes!(breeding::get_generation))
        .routes(routes!(breeding::get_picture))
        .routes(routes!(job::list_jobs, job::post_job))
        .routes(routes!(job::post_preview))
        .routes(routes!(job::get_job, job::delete_job))
        .routes(routes!(job::stop_job))
        .routes(routes!(job::resume_job))
        .routes(routes!(job::get_preview))
        .routes(routes!(evolution::get_evolution))
        .routes(routes!(evolution::get_best))
        .routes(routes!(raster::list_rasters))
        .routes(routes!(raster::get_raster))
        .routes(routes!(raster::get_heights))
        .routes(routes!(raster::get_preview))
        .routes(routes!(event::get_events))
        .routes(routes!(tile::get_style))
        .routes(routes!(elevation::get_profile))
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
    let mut described = others().merge(questions()).split_for_parts().1;
    describe_common(&mut described);
    described
}

/// Adds to every call that may need a key how to give it and what is answered without it, and to those with a body what all of them refuse.
fn describe_common(described: &mut utoipa::openapi::OpenApi) {
    const NAME: &str = "key";
    let problem = || {
        let schema = RefOr::Ref(utoipa::openapi::Ref::from_schema_name("ProblemDetails"));
        ContentBuilder::new().schema(Some(schema)).build()
    };
    let answer = |description: &str| ResponseBuilder::new().description(description).content("application/problem+json", problem()).build();
    let scheme = HttpBuilder::new().scheme(HttpAuthScheme::Bearer).description(Some("A key of `terrane key new`")).build();
    described.components.get_or_insert_default().add_security_scheme(NAME, SecurityScheme::Http(scheme));
    for (path, item) in &mut described.paths.paths {
        let reads = [&mut item.get].into_iter().flatten().map(|operation| (operation, Method::GET));
        let writes = [&mut item.post, &mut item.put, &mut item.delete].into_iter().flatten().map(|operation| (operation, Method::POST));
        for (operation, method) in reads.chain(writes) {
            if operation.request_body.is_some() {
                operation.responses.responses.insert("415".to_owned(), answer("The body is compressed").into());
            }
            let Some(scope) = needed(&method, path, Reads::Keys) else { continue };
            // An empty requirement says that it also goes without one.
            operation.security = Some(vec![SecurityRequirement::default(), SecurityRequirement::new(NAME, [scope.name()])]);
            let responses = &mut operation.responses.responses;
            responses.insert("401".to_owned(), answer("A key is needed, or there is no such key").into());
            responses.insert(
                "429".to_owned(),
                answer("The client has used up its requests or its seconds of evaluation; RateLimit says when there are some again").into(),
            );
            responses.entry("403".to_owned()).or_insert_with(|| answer("The key's scope does not reach").into());
        }
    }
}

/// Lets pages of every site use methods.
fn cors(methods: &[Method]) -> CorsLayer {
    let exposed = [header::CONTENT_DISPOSITION, header::ETAG, header::LOCATION, header::RETRY_AFTER];
    let own = ["server-timing", "x-request-id", "ratelimit", "ratelimit-policy"].map(HeaderName::from_static);
    CorsLayer::new()
        .allow_origin(AnyOrigin)
        .allow_methods(methods.to_vec())
        .allow_headers(AllowHeaders::mirror_request())
        .expose_headers(exposed.into_iter().chain(own).collect::<Vec<_>>())
}

/// All calls with what lies around them.
pub(super) fn router(app: App) -> Router {
    let read = [Method::GET, Method::HEAD];
    let guarded = |router: OpenApiRouter<App>, methods: &[Method]| {
        // One layer of four: each that a router is given by itself costs every request another box.
        let layers = ServiceBuilder::new()
            .layer(middleware::from_fn_with_state(app.clone(), observe))
            .layer(cors(methods))
            .layer(middleware::from_fn_with_state(app.clone(), guard))
            .layer(DefaultBodyLimit::max(app.0.world_bytes));
        Router::from(router).method_not_allowed_fallback(async || ApiError::MethodNotAllowed).layer(layers)
    };
    let asked = guarded(questions(), &[read.as_slice(), &[Method::POST]].concat());
    guarded(others().fallback(viewer::get_file), &read).merge(asked).with_state(app)
}
