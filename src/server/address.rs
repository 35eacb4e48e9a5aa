//! Addresses of tiles as types.

use super::{
    error::ApiError,
    extract::{Known, Parameters},
    state::App,
};
use crate::{
    geometry::{Filter, Grid, MAX_SIDE, MAX_ZOOM, Samples, Tile},
    tile::{ByteOrder, Height, Image, MESH_SIDES, MeshExtensions, Options, Rounding, RowOrder, TileRequest, Tileset},
};
use axum::{
    extract::FromRequestParts,
    http::{HeaderMap, header, request::Parts},
};
use serde::Deserialize;

/// The grid and tileset of a path.
pub(super) struct TilesetPath {
    pub grid: Grid,
    pub tileset: Tileset,
}

impl TilesetPath {
    fn parse(grid: &str, tileset: &str) -> Result<Self, ApiError> {
        let list = |names: Vec<&str>| names.join(", ");
        let grid = Grid::from_name(grid).ok_or_else(|| {
            ApiError::absent("grid", format!("no grid is named {grid:?}; there are {}", list(Grid::ALL.iter().map(|grid| grid.name()).collect())))
        })?;
        let tileset = Tileset::from_name(tileset).ok_or_else(|| {
            let all = list(Tileset::ALL.iter().map(|tileset| tileset.name()).collect());
            ApiError::absent("tileset", format!("no tileset is named {tileset:?}; there are {all}"))
        })?;
        if !tileset.is_on(grid) {
            let grids = list(Grid::ALL.into_iter().filter(|grid| tileset.is_on(*grid)).map(Grid::name).collect());
            return Err(ApiError::absent("tileset", format!("{} lies on the globe: the grids {grids} have it, {} does not", tileset.name(), grid.name())));
        }
        Ok(Self { grid, tileset })
    }
}

impl FromRequestParts<App> for TilesetPath {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        Self::parse(parameters.get("grid"), parameters.get("tileset"))
    }
}

/// A grid of a path that meshes lie on.
pub(super) struct GlobePath(pub Grid);

impl FromRequestParts<App> for GlobePath {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        Ok(Self(TilesetPath::parse(parameters.get("grid"), Tileset::QuantizedMesh.name())?.grid))
    }
}

/// What the query of a tile says.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TileQuery {
    filter: Option<String>,
    surface: Option<String>,
    page: Option<String>,
    rounding: Option<String>,
    order: Option<String>,
    rows: Option<String>,
    extensions: Option<String>,
}

impl TileQuery {
    fn filter(&self) -> Result<Filter, ApiError> {
        let choices = [("band", Filter::Band), ("exact", Filter::Exact)];
        choice("filter", self.filter.as_deref(), choices, || None)
    }

    fn height(&self, tileset: Tileset) -> Result<Height, ApiError> {
        let missing = || (!tileset.has_height()).then(|| format!("{} draws no heights", tileset.name()));
        choice("surface", self.surface.as_deref(), [("ground", Height::Ground), ("water", Height::Water)], missing)
    }

    fn order(&self, tileset: Tileset) -> Result<ByteOrder, ApiError> {
        let missing = || (!tileset.is_raw()).then(|| format!("{} has an order of bytes of its own", tileset.name()));
        choice("order", self.order.as_deref(), [("le", ByteOrder::Little), ("be", ByteOrder::Big)], missing)
    }

    fn rows(&self, tileset: Tileset) -> Result<RowOrder, ApiError> {
        let missing = || (!tileset.has_sidecar()).then(|| format!("rows of {} run from the north", tileset.name()));
        choice("rows", self.rows.as_deref(), [("north", RowOrder::North), ("south", RowOrder::South)], missing)
    }
}

/// What a mesh is to hold beside its triangles: `extensions=` (names with hyphens between them), else what the media type that the client takes says.
fn mesh_extensions(tileset: Tileset, query: Option<&str>, headers: &HeaderMap) -> Result<MeshExtensions, ApiError> {
    match (tileset, query) {
        (Tileset::QuantizedMesh, Some(names)) => Ok(MeshExtensions::named(names.split('-'))),
        (Tileset::QuantizedMesh, None) => {
            let ranges = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok()).flat_map(|value| value.split(','));
            let meshes = ranges.filter_map(|range| range.trim().strip_prefix("application/vnd.quantized-mesh"));
            let names = meshes.flat_map(|range| range.split(';')).filter_map(|parameter| parameter.trim().strip_prefix("extensions="));
            Ok(MeshExtensions::named(names.flat_map(|names| names.trim_matches('"').split('-'))))
        }
        (_, None) => Ok(MeshExtensions::default()),
        (tileset, Some(_)) => Err(ApiError::parameter("extensions", format!("{} has no extensions: leave it out", tileset.name()))),
    }
}

/// The row from the north of a row from the south, as meshes count them.
fn from_the_south(grid: Grid, tile: Tile) -> Result<Tile, ApiError> {
    let [columns, rows] = grid.size(tile.z);
    if (0..columns).contains(&tile.x) && (0..rows).contains(&tile.y) {
        return Ok(Tile { y: rows - 1 - tile.y, ..tile });
    }
    let (last_x, last_y) = (columns - 1, rows - 1);
    let detail = format!("meshes end with the globe: at zoom {}, x must be 0 … {last_x} and y, from the south, 0 … {last_y}", tile.z);
    Err(ApiError::absent("tile", detail))
}

/// One of two choices of a query by their names, the first by default; `missing` says why there is no second one.
pub(super) fn choice<T: Copy>(name: &str, text: Option<&str>, [first, second]: [(&str, T); 2], missing: impl Fn() -> Option<String>) -> Result<T, ApiError> {
    match text {
        None => Ok(first.1),
        Some(text) if text == first.0 => Ok(first.1),
        Some(text) if text == second.0 => missing().map_or(Ok(second.1), |why| Err(ApiError::parameter(name, format!("{why}: leave it out")))),
        Some(other) => Err(ApiError::parameter(name, format!("must be {} or {}, got {other:?}", first.0, second.0))),
    }
}

/// A tile that there is, or what its sidecar is about.
pub(super) struct TilePath {
    pub request: TileRequest,
    /// Whether the description of the tile's samples is asked for in place of the tile.
    pub is_sidecar: bool,
}

impl FromRequestParts<App> for TilePath {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        let Known(query) = Known::<TileQuery>::from_request_parts(parts, app).await?;
        let TilesetPath { grid, tileset } = TilesetPath::parse(parameters.get("grid"), parameters.get("tileset"))?;
        let File { y, samples, image, is_sidecar } = File::parse(parameters.get("y"), tileset)?;
        let tile = Tile { z: parse_zoom(parameters.get("z"))?, x: parse_index("x", parameters.get("x"))?, y };
        let tile = if tileset == Tileset::QuantizedMesh { from_the_south(grid, tile)? } else { tile };
        grid.check(tile).map_err(|error| ApiError::absent("tile", error.to_string()))?;
        let (filter, height) = (query.filter()?, query.height(tileset)?);
        let mesh = mesh_extensions(tileset, query.extensions.as_deref(), &parts.headers)?;
        let rounding = rounding(tileset, query.rounding.as_deref())?;
        let options = Options { image, rounding, order: query.order(tileset)?, rows: query.rows(tileset)?, mesh };
        let tileset = paged(tileset, query.page.as_deref())?;
        Ok(Self { request: TileRequest { grid, tile, samples, filter, tileset, height, options }, is_sidecar })
    }
}

/// The page of a tileset that has pages.
pub(super) fn paged(tileset: Tileset, page: Option<&str>) -> Result<Tileset, ApiError> {
    match (tileset, page) {
        (tileset, None) => Ok(tileset),
        (Tileset::Weights(_), Some(page)) => {
            let number = page.parse::<u8>().ok().filter(|number| *number < 64);
            number.map(Tileset::Weights).ok_or_else(|| ApiError::parameter("page", format!("must be a whole number 0 … 63, got {page:?}")))
        }
        (tileset, Some(_)) => Err(ApiError::parameter("page", format!("{} has no pages: leave it out", tileset.name()))),
    }
}

fn parse_zoom(z: &str) -> Result<u8, ApiError> {
    let number: i64 = parse_index("z", z)?;
    let zoom = u8::try_from(number).ok().filter(|zoom| *zoom <= MAX_ZOOM);
    zoom.ok_or_else(|| ApiError::absent("z", format!("zoom must be 0 … {MAX_ZOOM}, got {z}")))
}

fn parse_index(name: &str, text: &str) -> Result<i64, ApiError> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || digits.len() > 64 || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err(ApiError::parameter(name, format!("must be a whole number, got {:?}", text.chars().take(64).collect::<String>())));
    }
    // What does not fit is beyond the plane as well, which the grid says better.
    Ok(text.parse().unwrap_or(if text.starts_with('-') { i64::MIN } else { i64::MAX }))
}

/// How the pictures of a tileset are packed, by the name of the packing: `png` by default, or `webp`.
pub(super) fn packing(tileset: Tileset, format: Option<&str>) -> Result<Image, ApiError> {
    let missing = || (!tileset.has_webp()).then(|| format!("{} is no WebP", tileset.name()));
    choice("format", format, [("png", Image::Png), ("webp", Image::Webp)], missing)
}

/// To what the heights of a tileset are rounded, by name: `steps` by default, or `spacing`.
pub(super) fn rounding(tileset: Tileset, name: Option<&str>) -> Result<Rounding, ApiError> {
    let missing = || (!tileset.has_rounding()).then(|| format!("{} is not rounded", tileset.name()));
    choice("rounding", name, [("steps", Rounding::Steps), ("spacing", Rounding::Spacing)], missing)
}

/// What the last segment of a tile's address says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct File {
    y: i64,
    samples: Samples,
    image: Image,
    is_sidecar: bool,
}

impl File {
    /// Row, samples and extension: `5.png`, `5@2x.webp`, `5@257.bin`, `5@257.json`.
    fn parse(file: &str, tileset: Tileset) -> Result<Self, ApiError> {
        let (stem, extension) = file.rsplit_once('.').unwrap_or((file, ""));
        let (image, is_sidecar) = match extension {
            "json" if tileset.has_sidecar() => (Image::Png, true),
            extension if extension == tileset.extension(Image::Png) => (Image::Png, false),
            extension if extension == tileset.extension(Image::Webp) => (Image::Webp, false),
            _ => return Err(ApiError::absent("y", format!("tiles of {} end in {}, got {file:?}", tileset.name(), endings(tileset)))),
        };
        let (y, samples) = parse_stem(stem, tileset)?;
        Ok(Self { y, samples, image, is_sidecar })
    }
}

/// The extensions that a tileset's files can have.
fn endings(tileset: Tileset) -> String {
    let first = tileset.extension(Image::Png);
    let second = if tileset.has_sidecar() { " or .json" } else { "" };
    format!(".{first}{}", if tileset.has_webp() { " or .webp" } else { second })
}

/// Row and samples: `5`, `5@2x`, `5@257`.
fn parse_stem(stem: &str, tileset: Tileset) -> Result<(i64, Samples), ApiError> {
    // Vector tiles and meshes are drawn from vertices, which neighbours share.
    let pixels = |side: usize| match tileset {
        Tileset::QuantizedMesh => Samples::Vertices(side / 4 + 1),
        _ if tileset.layers().is_empty() => Samples::Centres(side),
        _ => Samples::Vertices(side + 1),
    };
    let Some((row, samples)) = stem.split_once('@') else { return Ok((parse_index("y", stem)?, pixels(256))) };
    let row = parse_index("y", row)?;
    let side = samples.parse::<usize>().ok().filter(|side| (2..=MAX_SIDE).contains(side));
    match (samples, side) {
        ("2x", _) => Ok((row, pixels(512))),
        (_, Some(side)) if tileset == Tileset::QuantizedMesh && !MESH_SIDES.contains(&side) => {
            Err(ApiError::absent("y", format!("meshes are drawn from one of {MESH_SIDES:?} samples a side; got {side}")))
        }
        (_, Some(side)) => Ok((row, Samples::Vertices(side))),
        _ => Err(ApiError::absent("y", format!("after @ comes 2x (512 pixels) or a number of vertices a side, 2 … {MAX_SIDE}; got {samples:?}"))),
    }
}
