//! What a server has.

use crate::{
    geometry::Grid,
    server::{
        error::ApiError,
        extract::PublicUrl,
        headers::{Freshness, hashed},
        schema::{Catalog, CatalogEntry, ProblemDetails, TilesetEntry, WorldEntry, WorldList},
        shelf::Shelved,
        state::App,
        wmts::capabilities,
        worlds::Live,
    },
    tile::Tileset,
};
use axum::{Json, extract::State, http::HeaderMap, response::Response};

fn entry(live: &Live) -> WorldEntry {
    WorldEntry { name: live.name.clone(), title: live.title().to_owned(), revision: live.world.revision().to_string() }
}

/// Every world with its tilesets.
#[utoipa::path(get, path = "/catalog", tag = "worlds", responses(
    (status = 200, description = "The worlds, by name", body = Catalog),
    (status = 400, description = "No valid Host header", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_catalog(State(app): State<App>, PublicUrl(url): PublicUrl) -> Result<Json<Catalog>, ApiError> {
    let tilesets = |name: &str| {
        let all = Grid::ALL.into_iter().flat_map(|grid| Tileset::ALL.map(|tileset| (grid, tileset))).filter(|(grid, tileset)| tileset.is_on(*grid));
        let names = all.map(|(grid, tileset)| (grid.name(), tileset.name()));
        names.map(|(grid, tileset)| TilesetEntry { grid, tileset, tilejson: format!("{url}/worlds/{name}/{grid}/{tileset}") }).collect()
    };
    let worlds = app.0.worlds.shelf.all().values().map(|live| CatalogEntry { world: entry(live), tilesets: tilesets(&live.name) }).collect();
    Ok(Json(Catalog { worlds }))
}

/// Every world.
#[utoipa::path(get, path = "/worlds", tag = "worlds", responses((status = 200, description = "The worlds, by name", body = WorldList)))]
pub(crate) async fn list_worlds(State(app): State<App>) -> Json<WorldList> {
    Json(WorldList { worlds: app.0.worlds.shelf.all().values().map(|live| entry(live)).collect() })
}

/// Every world as layers of a Web Map Tile Service.
#[utoipa::path(get, path = "/wmts", tag = "worlds", responses(
    (status = 200, description = "Capabilities, version 1.0.0; a query, as `SERVICE=WMTS&REQUEST=GetCapabilities`, changes nothing", body = String, content_type = "application/xml"),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "No valid Host header", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_wmts(State(app): State<App>, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Response {
    let xml = capabilities(&url, app.0.worlds.shelf.all().values());
    hashed(&headers, "application/xml", xml.into_bytes(), Freshness::Revalidate)
}
