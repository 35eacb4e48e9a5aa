//! Tiles and what describes them.

use crate::{
    geometry::{DEGREE, Filter, Grid, GridError, Source, Stop, Until, to_lon_lat},
    server::{
        address::{TilePath, TilesetPath, packing, paged, rounding},
        error::ApiError,
        extract::{Asker, Known, Links, WorldAt},
        headers::{Freshness, class, is_fresh, json, not_modified, tagged, timed},
        payment::bought,
        recall::Origin,
        schema::ProblemDetails,
        shelf::Shelved,
        sidecar::{SidecarSchema, sidecar},
        state::App,
        style,
        tilejson::{Factors, MaterialSchema, TileJson, VectorLayerSchema},
        tiles::Order,
        vocabulary::{ByteOrderName, FilterName, GridName, HeightsName, ImageName, RoundingName, RowOrderName, SurfaceName, TileFile, TilesetName},
        worlds::Live,
    },
    tile::{self, Image, Rounding, TileRequest, Tileset},
};
use axum::{
    body::{Body, Bytes},
    extract::State,
    http::{HeaderMap, HeaderValue, Uri, header},
    response::Response,
};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// Zoom levels that `TileJSON` announces.
pub(super) const MAX_ANNOUNCED_ZOOM: u8 = 24;

/// Which tiles are described.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct TilesetQuery {
    /// Present, with any value or none: plain URLs whose tiles change with the world, for editing.
    #[param(value_type = Option<String>, allow_reserved = false)]
    live: Option<String>,
    /// Of `weights`, 0 (default) … 63: the page of materials.
    #[param(value_type = Option<u8>, maximum = 63)]
    page: Option<String>,
    /// `png` (default) or `webp`: how the tiles of the template are packed, without loss; `height16`, raw and vector tiles are no WebP.
    #[param(value_type = Option<ImageName>, inline)]
    format: Option<String>,
    /// Of `terrarium`, `terrain-rgb` and `fit`: `steps` (default), or `spacing`: heights rounded to what the samples' spacing justifies, in fewer bytes.
    #[param(value_type = Option<RoundingName>, inline)]
    rounding: Option<String>,
}

/// A tile.
#[utoipa::path(get, path = "/worlds/{world}/{grid}/{tileset}/{z}/{x}/{y}", tag = "tiles", params(
    ("world" = String, Path, description = "`name`, or `name@revision` for a tile that never changes"),
    ("grid" = inline(GridName), Path, description = "`web`, `geo` or `metric`"),
    ("tileset" = inline(TilesetName), Path, description = "`terrarium`, `terrain-rgb`, `fit`, `height16`, `r16`, `r32`, `hillshade`, `slope`, `normals`, `water`, `materials`, `weights`, `relief`, `contours`, `features` or `quantized-mesh`"),
    ("z" = u8, Path, maximum = 30, description = "Zoom level, 0 … 30"),
    ("x" = i64, Path, description = "Column, to the east; may be negative or beyond 2^z"),
    ("y" = inline(TileFile), Path, description = "Row, to the south, samples and extension: `5.png` or `5.webp` (256 pixels), `5@2x.png` (512), `5@257.bin` (257 × 257 vertices with both edges; 2 … 1025), `5@257.json` (what the samples of `height16`, `r16` and `r32` mean), `5.mvt`, `5.terrain` (65 × 65 samples; `@17`, `@33`, `@129`, `@257`). Rows of `quantized-mesh` count from the south"),
    ("surface" = inline(Option<SurfaceName>), Query, description = "`ground` (default) or `water`: the height that `terrarium`, `terrain-rgb`, `fit`, `height16`, `r16`, `r32`, `hillshade`, `slope`, `normals` and `quantized-mesh` draw; `water` is the water's surface where there is water"),
    ("page" = Option<u8>, Query, maximum = 63, description = "Of `weights`, 0 (default) … 63: page n has the materials of numbers 4 n to 4 n + 3 as red, green, blue and alpha"),
    ("rounding" = inline(Option<RoundingName>), Query, description = "Of `terrarium`, `terrain-rgb` and `fit`: `steps` (default) of the encoding, or `spacing`: the greatest power of two of these that is at most a 64th of the samples' spacing, and at most 16 m"),
    ("order" = inline(Option<ByteOrderName>), Query, description = "Of `r16` and `r32`: `le` (default) or `be`, the byte that comes first"),
    ("rows" = inline(Option<RowOrderName>), Query, description = "Of `height16`, `r16` and `r32`: `north` (default) or `south`, the row that comes first"),
    ("extensions" = Option<String>, Query, description = "Of `quantized-mesh`: any of `octvertexnormals`, `watermask` and `metadata` with hyphens between them; without it what the Accept header says, as in `application/vnd.quantized-mesh;extensions=octvertexnormals-watermask`"),
    ("filter" = inline(Option<FilterName>), Query, description = "`band` (default) leaves out what the spacing cannot carry, `exact` samples the function as it is"),
), responses(
    (status = 200, description = "The tile", content((Vec<u8> = "image/png"), (Vec<u8> = "image/webp"), (Vec<u8> = "application/octet-stream"), (Vec<u8> = "application/vnd.mapbox-vector-tile"), (Vec<u8> = "application/vnd.quantized-mesh"), (SidecarSchema = "application/json")), headers(("ETag" = String, description = "The tile's fingerprint"))),
    (status = 304, description = "The tile is what If-None-Match names; nothing was evaluated"),
    (status = 400, description = "A part of the address is no number, the query is wrong, or exact samples so far apart would take longer than 10 s", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world, grid, tileset, extension or tile", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 500, description = "The evaluation failed, or this revision of the world has failed so often that it is set aside", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many tiles are waiting", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_tile(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    TilePath { request, is_sidecar }: TilePath,
    uri: Uri,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let absent = |error: GridError| ApiError::absent("tile", error.to_string());
    if is_sidecar {
        let stem = uri.path().rsplit('/').next().and_then(|file| file.strip_suffix(".json")).unwrap_or_default();
        return json(&headers, &sidecar(&request, live.world.legend().range, stem).map_err(absent)?, Freshness::of(pinned));
    }
    let window = request.window().map_err(absent)?;
    let (world, form, area) = (&live.world, request.form(&live.world.legend()), window.bounds());
    let is_features = request.tileset == Tileset::Features;
    let form = if is_features { world.features_form(&form, &area) } else { form };
    let mask = request.mask_window().map_err(absent)?;
    let form = form + &mask.map_or_else(String::new, |mask| world.seen_in(&mask));
    let fingerprint = world.fingerprint(&form, &area, request.grid, request.tile, request.samples, request.filter);
    let (tag, freshness) = (fingerprint.to_string(), Freshness::of(pinned));
    if is_fresh(&headers, &tag) {
        return Ok(not_modified(&tag, freshness));
    }
    let head = if pinned { app.0.worlds.shelf.get(&live.name) } else { Some(Arc::clone(&live)) };
    let answer = move |bytes: Bytes| {
        let mut response = Response::new(Body::from(bytes));
        *response.headers_mut() = described(&request);
        // What a mesh holds follows from a header, too.
        if let Some(head) = head.filter(|_| request.tileset != Tileset::QuantizedMesh) {
            response.extensions_mut().insert(Origin { world: Arc::downgrade(&head), fingerprint, tag: tag.clone() });
        }
        tagged(response, &tag, freshness)
    };
    // What is at hand must not even be predicted.
    if let Some(bytes) = app.0.tiles.cached(&fingerprint).await {
        return Ok(answer(bytes));
    }
    let class = class(&headers);
    if app.0.tiles.refuses(&fingerprint, class) {
        return Err(ApiError::Overloaded);
    }
    let cost_ns = live.world.cost_ns(&window) + mask.map_or(0.0, |mask| live.world.cost_ns(&mask)) + request.drawing_ns();
    if cost_ns > MOST_TILE_NS {
        let (spacing, seconds) = (window.spacing(), cost_ns / 1e9);
        let instead = if request.filter == Filter::Exact { "filter=band" } else { "fewer samples" };
        let detail = format!("samples {spacing} m apart would take this world about {seconds:.0} s a tile: ask for {instead} or a finer zoom");
        return Err(ApiError::parameter(if request.filter == Filter::Exact { "filter" } else { "tile" }, detail));
    }
    let kind = [request.tileset.name(), if live.world.document().layers.is_empty() { "programme" } else { "layout" }];
    let order = Order { fingerprint, revision: live.world.revision().clone(), class, cost_ns, kind };
    let draw = move |stop: &Stop| match request.tileset {
        Tileset::Features => tile::render_features(&live.world, &request),
        _ => tile::render(&Until { source: &live.world, stop: stop.clone() }, &request),
    };
    let made = bought(&app, asker, order, draw).await?;
    Ok(timed(answer(made.bytes), made.timing))
}

/// The headers that say what a tile is. A mesh says which extensions it holds, and that they may come from what the client takes.
fn described(request: &TileRequest) -> HeaderMap {
    let (media_type, extensions) = (request.tileset.media_type(request.options.image), request.options.mesh.list());
    let content = if extensions.is_empty() { media_type.to_owned() } else { format!("{media_type};extensions={extensions}") };
    // Room for those that are added on the way out, too.
    let mut headers = HeaderMap::with_capacity(16);
    headers.extend(HeaderValue::from_str(&content).ok().map(|value| (header::CONTENT_TYPE, value)));
    if request.tileset == Tileset::QuantizedMesh {
        headers.insert(header::VARY, HeaderValue::from_static("accept"));
    }
    headers
}

/// The greatest predicted time of a tile. Filtered tiles stay far below, by the budget of programmes; exact samples further apart than the valleys of an erosion do
/// not.
const MOST_TILE_NS: f64 = 1e10;

/// What viewers need to know of a tileset.
#[utoipa::path(get, path = "/worlds/{world}/{grid}/{tileset}", tag = "tiles", params(
    ("world" = String, Path, description = "`name` or `name@revision`"),
    ("grid" = inline(GridName), Path, description = "`web`, `geo` or `metric`"),
    ("tileset" = inline(TilesetName), Path, description = "`terrarium`, `terrain-rgb`, `fit`, `height16`, `r16`, `r32`, `hillshade`, `slope`, `normals`, `water`, `materials`, `weights`, `relief`, `contours`, `features` or `quantized-mesh`"),
    TilesetQuery,
), responses(
    (status = 200, description = "TileJSON 3.0 with `encoding` and `tileSize`", body = TileJson),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world, grid or tileset", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_tilejson(
    WorldAt { live, .. }: WorldAt,
    TilesetPath { grid, tileset }: TilesetPath,
    Known(query): Known<TilesetQuery>,
    links: Links,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let tileset = paged(tileset, query.page.as_deref())?;
    let (document, is_weights) = (live.world.document(), matches!(tileset, Tileset::Weights(_)));
    let options = (packing(tileset, query.format.as_deref())?, rounding(tileset, query.rounding.as_deref())?);
    let template = template(&live, grid.name(), tileset, options, query.live.is_some());
    let (range, steps) = (live.world.legend().range, tileset.steps(live.world.legend().range));
    let factors = (tileset == Tileset::Fit).then(|| steps.map(|steps| Factors::of(&steps))).flatten();
    let body = TileJson {
        tilejson: "3.0.0",
        name: live.title().to_owned(),
        description: document.description.clone(),
        attribution: document.attribution.clone(),
        scheme: if tileset == Tileset::QuantizedMesh { "tms" } else { "xyz" },
        tiles: [links.to(&template)],
        minzoom: 0,
        maxzoom: MAX_ANNOUNCED_ZOOM,
        center: center(&live, grid),
        tile_size: has_pixels(tileset).then_some(512),
        vector_layers: vector_layers(tileset),
        encoding: tileset.encoding(),
        factors,
        elevation: steps.map(|_| range),
        materials: tileset.has_materials().then(|| materials(live.world.materials(), is_weights)),
        pages: is_weights.then(|| live.world.materials().len() / CHANNELS.len() + 1),
    };
    // Its links depend on how the server is reached, so even a pinned one may change.
    json(&headers, &body, Freshness::Revalidate)
}

/// The channels of a page of weights.
const CHANNELS: [&str; 4] = ["r", "g", "b", "a"];

/// The legend of materials; of weights with pages and channels, and with what has no material.
fn materials(names: &[Box<str>], is_weights: bool) -> Vec<MaterialSchema> {
    let entry = |(name, id): (&str, usize)| {
        let [r, g, b] = tile::material_colour(name);
        let (page, channel) = (id / CHANNELS.len(), CHANNELS[id % CHANNELS.len()]);
        let colour = format!("#{r:02x}{g:02x}{b:02x}");
        MaterialSchema { id, name: name.to_owned(), colour, page: is_weights.then_some(page), channel: is_weights.then_some(channel) }
    };
    let all = std::iter::once("").chain(names.iter().map(|name| &**name)).zip(0..);
    all.skip(usize::from(!is_weights)).map(entry).collect()
}

/// What the layers of a vector tileset are called and hold.
fn vector_layers(tileset: Tileset) -> Option<Vec<VectorLayerSchema>> {
    let layer = |layer: &tile::VectorLayer| VectorLayerSchema {
        id: layer.id,
        description: layer.description,
        fields: layer.fields.iter().map(|(name, what)| ((*name).to_owned(), *what)).collect(),
    };
    (!tileset.layers().is_empty()).then(|| tileset.layers().iter().map(layer).collect())
}

/// Whether tiles are squares of samples.
fn has_pixels(tileset: Tileset) -> bool {
    tileset.is_picture() || tileset.is_raw()
}

/// The template of the paths of a tileset's tiles, its pictures packed and its heights rounded in a way.
pub(super) fn template(live: &Live, grid: &str, tileset: Tileset, (image, rounding): (Image, Rounding), plain: bool) -> String {
    let revision = if plain { String::new() } else { format!("@{}", live.world.revision()) };
    let samples = if has_pixels(tileset) { "@2x" } else { "" };
    let query = match tileset {
        Tileset::Weights(page @ 1..) => format!("?page={page}"),
        _ if tileset.has_rounding() && rounding == Rounding::Spacing => "?rounding=spacing".to_owned(),
        _ => String::new(),
    };
    format!("/worlds/{}{revision}/{grid}/{}/{{z}}/{{x}}/{{y}}{samples}.{}{query}", live.name, tileset.name(), tileset.extension(image))
}

/// The middle and zoom (of 512-pixel tiles) of a view with relief: longitude and latitude on `web` and `geo`, metres on `metric`.
fn center(live: &Live, grid: Grid) -> [f64; 3] {
    /// How many pixels the view is meant to fill.
    const VIEW_PIXELS: f64 = 1024.0;
    let survey = &live.survey;
    let [x, y] = survey.centre;
    let zoom = libm::log2(grid.tile_side(0) / 512.0 * VIEW_PIXELS / survey.side).clamp(0.0, f64::from(MAX_ANNOUNCED_ZOOM) - 2.0);
    let round = |value: f64, digits: f64| (value * digits).round() / digits;
    match grid {
        Grid::Web => {
            let (longitude, latitude) = to_lon_lat(x, y);
            [round(longitude, 1e6), round(latitude, 1e6), round(zoom, 100.0)]
        }
        Grid::Geo => [round(x / DEGREE, 1e6), round(y / DEGREE, 1e6), round(zoom, 100.0)],
        Grid::Metric => [x.round(), y.round(), round(zoom, 100.0)],
    }
}

/// What a style is made of.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct StyleQuery {
    /// Present, with any value or none: plain URLs whose tiles change with the world, for editing.
    #[param(value_type = Option<String>, allow_reserved = false)]
    live: Option<String>,
    /// `terrarium` (default), `terrain-rgb` or `fit`: the tileset that heights are read from.
    #[param(value_type = Option<HeightsName>, inline)]
    heights: Option<String>,
    /// `png` (default) or `webp`: how its tiles are packed.
    #[param(value_type = Option<ImageName>, inline)]
    format: Option<String>,
    /// `steps` (default), or `spacing`: heights rounded to what the samples' spacing justifies, in fewer bytes.
    #[param(value_type = Option<RoundingName>, inline)]
    rounding: Option<String>,
}

impl StyleQuery {
    fn heights(&self) -> Result<Tileset, ApiError> {
        match self.heights.as_deref() {
            None | Some("terrarium") => Ok(Tileset::Terrarium),
            Some("terrain-rgb") => Ok(Tileset::TerrainRgb),
            Some("fit") => Ok(Tileset::Fit),
            Some(other) => Err(ApiError::parameter("heights", format!("must be terrarium, terrain-rgb or fit, got {other:?}"))),
        }
    }
}

/// A ready `MapLibre` style: colour relief under hillshade.
#[utoipa::path(get, path = "/worlds/{world}/style.json", tag = "tiles", params(("world" = String, Path, description = "`name` or `name@revision`"), StyleQuery), responses(
    (status = 200, description = "A MapLibre style, version 8", body = serde_json::Value),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_style(WorldAt { live, .. }: WorldAt, Known(query): Known<StyleQuery>, links: Links, headers: HeaderMap) -> Result<Response, ApiError> {
    let heights = query.heights()?;
    let options = (packing(heights, query.format.as_deref())?, rounding(heights, query.rounding.as_deref())?);
    let tiles = |tileset| links.to(&template(&live, Grid::Web.name(), tileset, options, query.live.is_some()));
    let style = style::style(&live, heights, tiles, MAX_ANNOUNCED_ZOOM, center(&live, Grid::Web));
    json(&headers, &style, Freshness::Revalidate)
}
