//! Requests as types: handlers never see raw text.

use super::{
    error::ApiError,
    shelf::{Shelf, Shelved},
    state::App,
    worlds::Live,
};
use crate::{
    geometry::{Filter, Grid, MAX_SIDE, MAX_ZOOM, Samples, Tile},
    store::Condition,
    tile::{Height, TileRequest, Tileset},
    world::{Revision, check_name},
};
use axum::{
    body::Bytes,
    extract::{FromRequest, FromRequestParts, Path, Query, Request, rejection::BytesRejection},
    http::{HeaderMap, StatusCode, header, request::Parts},
};
use serde::{Deserialize, de::DeserializeOwned};
use std::{collections::HashMap, marker::PhantomData, sync::Arc};

/// Path parameters by name.
async fn path(parts: &mut Parts) -> Result<HashMap<String, String>, ApiError> {
    match Path::<HashMap<String, String>>::from_request_parts(parts, &()).await {
        Ok(Path(parameters)) => Ok(parameters),
        Err(_) => Err(ApiError::NotFound("There is nothing at a path that is not UTF-8.".to_owned(), Vec::new())),
    }
}

/// A query whose parameters are all known.
pub(super) struct Known<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Known<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        match Query::<T>::from_request_parts(parts, state).await {
            Ok(Query(query)) => Ok(Self(query)),
            Err(rejection) => {
                let text = rejection.body_text();
                let detail = text.split_once(": ").map_or(text.as_str(), |(_, detail)| detail);
                // A wrong value or an unknown name comes as "name: what is wrong".
                let (name, detail) = detail.split_once(": ").unwrap_or(("query", detail));
                let number = detail.contains("float");
                Err(ApiError::parameter(name, if number { "must be a number" } else { detail }))
            }
        }
    }
}

/// A name of a kind of documents in a path, valid but perhaps not taken.
pub(super) struct NameOf<T> {
    pub name: String,
    kind: PhantomData<fn() -> T>,
}

impl<T: Shelved> FromRequestParts<App> for NameOf<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let name = path(parts).await?.remove(T::KIND.noun()).unwrap_or_default();
        check_name("a name", &name).map_err(|detail| ApiError::parameter(T::KIND.noun(), detail))?;
        Ok(Self { name, kind: PhantomData })
    }
}

/// What to say of a name that nothing has.
fn unknown<T: Shelved>(shelf: &Shelf<T>, name: &str) -> ApiError {
    let noun = T::KIND.noun();
    if let Err(detail) = check_name("a name", name) {
        return ApiError::absent(noun, detail);
    }
    let near = nearest(name, shelf.all().keys().map(String::as_str)).map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
    ApiError::absent(noun, format!("no {noun} is named {name:?}{near}"))
}

/// A document that there is.
pub(super) struct Present<T>(pub Arc<T>);

impl<T: Shelved> FromRequestParts<App> for Present<T> {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let name = path(parts).await?.remove(T::KIND.noun()).unwrap_or_default();
        T::shelf(app).get(&name).map(Self).ok_or_else(|| unknown(T::shelf(app), &name))
    }
}

/// A world that there is: `name` as it is now, or `name@revision`.
pub(super) struct WorldAt {
    pub live: Arc<Live>,
    /// Whether the address names a revision, so that the answer never changes.
    pub pinned: bool,
}

impl FromRequestParts<App> for WorldAt {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let segment = path(parts).await?.remove("world").unwrap_or_default();
        let worlds = &app.0.worlds;
        let Some((name, revision)) = segment.split_once('@') else {
            let live = worlds.shelf.get(&segment).ok_or_else(|| unknown(&worlds.shelf, &segment))?;
            return Ok(Self { live, pinned: false });
        };
        if worlds.shelf.get(name).is_none() {
            return Err(unknown(&worlds.shelf, name));
        }
        let missing = || {
            ApiError::absent(
                "world",
                format!("the world {name:?} has no revision {revision:?}; a revision is 32 hex digits, listed at worlds/{name}/revisions"),
            )
        };
        let revision = Revision::parse(revision).ok_or_else(missing)?;
        let live = worlds.at(name, &revision).await?.ok_or_else(missing)?;
        Ok(Self { live, pinned: true })
    }
}

/// A feature's address: the name of its world and its id, either of which may not be there.
pub(super) struct FeatureAt {
    pub world: String,
    pub id: String,
}

impl FromRequestParts<App> for FeatureAt {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let mut parameters = path(parts).await?;
        Ok(Self { world: parameters.remove("world").unwrap_or_default(), id: parameters.remove("id").unwrap_or_default() })
    }
}

fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    let (distance, near) = candidates.map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate)).min()?;
    (distance <= 2).then(|| near.to_owned())
}

/// The grid and tileset of a path.
pub(super) struct TilesetPath {
    pub grid: Grid,
    pub tileset: Tileset,
}

impl TilesetPath {
    fn parse(parameters: &HashMap<String, String>) -> Result<Self, ApiError> {
        let get = |name: &str| parameters.get(name).map_or("", String::as_str);
        let (grid, tileset) = (get("grid"), get("tileset"));
        let list = |names: Vec<&str>| names.join(", ");
        let grid = Grid::from_name(grid).ok_or_else(|| {
            ApiError::absent("grid", format!("no grid is named {grid:?}; there are {}", list(Grid::ALL.iter().map(|grid| grid.name()).collect())))
        })?;
        let tileset = Tileset::from_name(tileset).ok_or_else(|| {
            let all = list(Tileset::ALL.iter().map(|tileset| tileset.name()).collect());
            ApiError::absent("tileset", format!("no tileset is named {tileset:?}; there are {all}"))
        })?;
        Ok(Self { grid, tileset })
    }
}

impl FromRequestParts<App> for TilesetPath {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        Self::parse(&path(parts).await?)
    }
}

/// How the samples of a tile are filtered.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct TileQuery {
    filter: Option<String>,
    surface: Option<String>,
    page: Option<String>,
}

/// A tile that there is.
pub(super) struct TilePath(pub TileRequest);

impl FromRequestParts<App> for TilePath {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let parameters = path(parts).await?;
        let Known(query) = Known::<TileQuery>::from_request_parts(parts, app).await?;
        let TilesetPath { grid, tileset } = TilesetPath::parse(&parameters)?;
        let get = |name: &str| parameters.get(name).map_or("", String::as_str);
        let (y, samples) = parse_file(get("y"), tileset)?;
        let tile = Tile { z: parse_zoom(get("z"))?, x: parse_index("x", get("x"))?, y };
        grid.check(tile).map_err(|error| ApiError::absent("tile", error.to_string()))?;
        let filter = match query.filter.as_deref() {
            None | Some("band") => Filter::Band,
            Some("exact") => Filter::Exact,
            Some(other) => return Err(ApiError::parameter("filter", format!("must be band or exact, got {other:?}"))),
        };
        let height = match query.surface.as_deref() {
            None | Some("ground") => Height::Ground,
            Some("water") if tileset.has_height() => Height::Water,
            Some("water") => return Err(ApiError::parameter("surface", format!("{} draws no heights: leave it out", tileset.name()))),
            Some(other) => return Err(ApiError::parameter("surface", format!("must be ground or water, got {other:?}"))),
        };
        let tileset = paged(tileset, query.page.as_deref())?;
        Ok(Self(TileRequest { grid, tile, samples, filter, tileset, height }))
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

/// Row, samples and extension: `5.png`, `5@2x.png`, `5@257.bin`.
fn parse_file(file: &str, tileset: Tileset) -> Result<(i64, Samples), ApiError> {
    let (stem, extension) = file.rsplit_once('.').unwrap_or((file, ""));
    let wanted = tileset.extension();
    if extension != wanted {
        return Err(ApiError::absent("y", format!("tiles of {} end in .{wanted}, got {file:?}", tileset.name())));
    }
    // Vector tiles are drawn from vertices, which neighbours share.
    let pixels = |side: usize| if tileset.layers().is_empty() { Samples::Centres(side) } else { Samples::Vertices(side + 1) };
    let Some((row, samples)) = stem.split_once('@') else { return Ok((parse_index("y", stem)?, pixels(256))) };
    let row = parse_index("y", row)?;
    let side = samples.parse::<usize>().ok().filter(|side| (2..=MAX_SIDE).contains(side));
    match (samples, side) {
        ("2x", _) => Ok((row, pixels(512))),
        (_, Some(side)) => Ok((row, Samples::Vertices(side))),
        _ => Err(ApiError::absent("y", format!("after @ comes 2x (512 pixels) or a number of vertices a side, 2 … {MAX_SIDE}; got {samples:?}"))),
    }
}

/// The conditions of a write.
pub(super) struct WriteCondition(pub Condition);

impl FromRequestParts<App> for WriteCondition {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        // A condition that cannot be read must not become none: a header that is there holds tags, or the request is refused.
        let tags = |name: header::HeaderName| {
            let read = entity_tags(&parts.headers, name.clone()).filter(|tags| !tags.is_empty() || !parts.headers.contains_key(&name));
            read.ok_or_else(|| ApiError::BadRequest(format!("The header {name} holds no readable entity tag."), Vec::new()))
        };
        let (matching, other) = (tags(header::IF_MATCH)?, tags(header::IF_NONE_MATCH)?);
        if matching.iter().any(|tag| tag.starts_with("W/")) {
            let detail = "If-Match compares strong entity tags; W/… was weakened on the way, by a proxy that compresses: use the revision itself, in quotes.";
            return Err(ApiError::BadRequest(detail.to_owned(), Vec::new()));
        }
        Ok(Self(match (matching, other) {
            (matching, other) if matching.is_empty() && other.is_empty() => Condition::Any,
            (tags, other) if other.is_empty() && tags == ["*"] => Condition::Present,
            (tags, other) if other.is_empty() => Condition::At(tags.iter().map(|tag| tag.trim_matches('"').to_owned()).collect()),
            (matching, tags) if matching.is_empty() && tags == ["*"] => Condition::Absent,
            _ => {
                let detail = "Writes understand one of If-Match: \"<revision>\", If-Match: * and If-None-Match: *.";
                return Err(ApiError::BadRequest(detail.to_owned(), Vec::new()));
            }
        }))
    }
}

/// The comma-separated entity tags of a header, as they are written; `None` if one is not visible ASCII.
pub(super) fn entity_tags(headers: &HeaderMap, name: header::HeaderName) -> Option<Vec<String>> {
    let values: Option<Vec<&str>> = headers.get_all(name).iter().map(|value| value.to_str().ok()).collect();
    Some(values?.into_iter().flat_map(|value| value.split(',')).map(|tag| tag.trim().to_owned()).filter(|tag| !tag.is_empty()).collect())
}

/// A request's body, at most as long as a document may be.
pub(super) struct Body(pub Bytes);

impl FromRequest<App> for Body {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &App) -> Result<Self, ApiError> {
        match Bytes::from_request(request, app).await {
            Ok(bytes) => Ok(Self(bytes)),
            Err(BytesRejection::FailedToBufferBody(rejection)) if rejection.status() == StatusCode::PAYLOAD_TOO_LARGE => {
                Err(ApiError::TooLarge(app.0.world_bytes))
            }
            Err(_) => Err(ApiError::BadRequest("The body could not be read.".to_owned(), Vec::new())),
        }
    }
}

/// The URL that clients reach the server by, without a slash at its end.
pub(super) struct PublicUrl(pub String);

impl FromRequestParts<App> for PublicUrl {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        if !app.0.public_url.is_empty() {
            return Ok(Self(app.0.public_url.clone()));
        }
        let host = parts.headers.get(header::HOST).and_then(|host| host.to_str().ok()).or(parts.uri.authority().map(axum::http::uri::Authority::as_str));
        // What is no authority would become part of URLs in documents that others read.
        let host = host.filter(|host| host.parse::<axum::http::uri::Authority>().is_ok());
        host.map(|host| Self(format!("http://{host}"))).ok_or_else(|| ApiError::BadRequest("The request needs a valid Host header.".to_owned(), Vec::new()))
    }
}
