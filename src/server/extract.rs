//! Requests as types: handlers never see raw text.

use super::{
    budget::{Budget, Client},
    error::ApiError,
    shelf::{Shelf, Shelved},
    signed::Signed,
    state::App,
    worlds::Live,
};
use crate::{
    geometry::PLANE_LIMIT,
    store::Condition,
    world::{Revision, check_name},
};
use axum::{
    body::{Bytes, HttpBody},
    extract::{FromRequest, FromRequestParts, Query, RawPathParams, Request, rejection::BytesRejection},
    http::{HeaderMap, StatusCode, header, request::Parts},
};
use serde::de::DeserializeOwned;
use std::{convert::Infallible, marker::PhantomData, sync::Arc, time::Instant};

/// Path parameters by name.
pub(super) struct Parameters(RawPathParams);

impl Parameters {
    pub(super) async fn of(parts: &mut Parts) -> Result<Self, ApiError> {
        match RawPathParams::from_request_parts(parts, &()).await {
            Ok(parameters) => Ok(Self(parameters)),
            Err(_) => Err(ApiError::NotFound("There is nothing at a path that is not UTF-8.".to_owned(), Vec::new())),
        }
    }

    /// A parameter, decoded; empty if the path has none of this name.
    pub(super) fn get(&self, name: &str) -> &str {
        self.0.iter().find(|(key, _)| *key == name).map_or("", |(_, value)| value)
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
        let name = Parameters::of(parts).await?.get(T::KIND.noun()).to_owned();
        check_name("a name", &name).map_err(|detail| ApiError::parameter(T::KIND.noun(), detail))?;
        Ok(Self { name, kind: PhantomData })
    }
}

/// The only parameter of a path: the hash of a job or a raster, which may not be there.
pub(super) struct Hash(pub String);

impl FromRequestParts<App> for Hash {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        let (name, hash) = parameters.0.iter().next().unwrap_or_default();
        match Revision::parse(hash) {
            Some(hash) => Ok(Self(hash.to_string())),
            None => Err(ApiError::absent(name, format!("a {name} is named by 32 hex digits, got {hash:?}"))),
        }
    }
}

/// Which generation of a session, and which individual of it, if the path says so.
pub(super) struct IndividualAt {
    pub generation: usize,
    pub individual: usize,
}

impl FromRequestParts<App> for IndividualAt {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        let number = |name: &str| match parameters.get(name) {
            "" => Ok(0),
            text => text.parse().map_err(|_not_whole| ApiError::absent(name, format!("must be a whole number from 0 on, got {text:?}"))),
        };
        Ok(Self { generation: number("generation")?, individual: number("individual")? })
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
        let parameters = Parameters::of(parts).await?;
        let name = parameters.get(T::KIND.noun());
        T::shelf(app).get(name).map(Self).ok_or_else(|| unknown(T::shelf(app), name))
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
        let parameters = Parameters::of(parts).await?;
        let segment = parameters.get("world");
        let worlds = &app.0.worlds;
        let Some((name, revision)) = segment.split_once('@') else {
            let live = worlds.shelf.get(segment).ok_or_else(|| unknown(&worlds.shelf, segment))?;
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
        let parameters = Parameters::of(parts).await?;
        Ok(Self { world: parameters.get("world").to_owned(), id: parameters.get("id").to_owned() })
    }
}

/// A player's address: the name of its world, which may not be there, and its own.
pub(super) struct PlayerAt {
    pub world: String,
    pub player: String,
}

impl FromRequestParts<App> for PlayerAt {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &App) -> Result<Self, ApiError> {
        let parameters = Parameters::of(parts).await?;
        let [world, player] = ["world", "player"].map(|name| (name, parameters.get(name).to_owned()));
        for (name, value) in [&world, &player] {
            check_name("a name", value).map_err(|detail| ApiError::parameter(name, detail))?;
        }
        Ok(Self { world: world.1, player: player.1 })
    }
}

fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<String> {
    let (distance, near) = candidates.map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate)).min()?;
    (distance <= 2).then(|| near.to_owned())
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

/// Bodies are read as they come: what was compressed would have to be unpacked first, and may be a bomb.
fn refuse_packed(headers: &HeaderMap) -> Result<(), ApiError> {
    let encodings = headers.get_all(header::CONTENT_ENCODING).iter().flat_map(|value| value.as_bytes().split(|byte| *byte == b','));
    let packed = encodings.map(<[u8]>::trim_ascii).find(|name| !name.is_empty() && !name.eq_ignore_ascii_case(b"identity"));
    packed.map_or(Ok(()), |name| Err(ApiError::Packed(String::from_utf8_lossy(&name[..name.len().min(40)]).into_owned())))
}

/// A request's body, read while it comes, at most as long as features may be.
pub(super) struct Upload(pub axum::body::Body);

impl FromRequest<App> for Upload {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &App) -> Result<Self, ApiError> {
        refuse_packed(request.headers())?;
        let body = request.into_body();
        // What says that it is too long need not come.
        if body.size_hint().lower() > app.0.feature_bytes as u64 { Err(ApiError::TooLarge(app.0.feature_bytes)) } else { Ok(Self(body)) }
    }
}

impl FromRequest<App> for Body {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &App) -> Result<Self, ApiError> {
        refuse_packed(request.headers())?;
        match Bytes::from_request(request, app).await {
            Ok(bytes) => Ok(Self(bytes)),
            Err(BytesRejection::FailedToBufferBody(rejection)) if rejection.status() == StatusCode::PAYLOAD_TOO_LARGE => {
                Err(ApiError::TooLarge(app.0.world_bytes))
            }
            Err(_) => Err(ApiError::BadRequest("The body could not be read.".to_owned(), Vec::new())),
        }
    }
}

/// An area of a query: least x, least y, greatest x, greatest y in metres.
pub(super) fn parse_bbox(text: &str) -> Result<[f64; 4], ApiError> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok().filter(|c: &f64| c.abs() <= PLANE_LIMIT)).collect();
    match numbers.as_deref() {
        Some(&[x0, y0, x1, y1]) if x0 <= x1 && y0 <= y1 => Ok([x0, y0, x1, y1]),
        _ => Err(ApiError::parameter("bbox", "must be minx,miny,maxx,maxy in metres within 2^40 of the origin, the least corner first")),
    }
}

/// Who asks.
pub(super) struct Asker(pub Client);

impl Asker {
    /// Lets it pay for predicted nanoseconds of evaluation.
    pub(super) fn pay(&self, app: &App, cost_ns: f64) -> Result<(), ApiError> {
        Ok(app.0.budgets.take(&self.0, Budget::Compute, cost_ns / 1e9, Instant::now())?)
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Asker {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self(parts.extensions.get().cloned().unwrap_or(Client::Local)))
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

/// Makes the addresses that answers hold; those of a signed address are signed as it is.
pub(super) struct Links {
    url: String,
    signed: Option<Signed>,
}

impl Links {
    /// The address of a path, which may have a query.
    pub(super) fn to(&self, path: &str) -> String {
        let signed = self.signed.as_ref().map(|signed| format!("{}{}", if path.contains('?') { '&' } else { '?' }, signed.text));
        format!("{}{path}{}", self.url, signed.unwrap_or_default())
    }
}

impl FromRequestParts<App> for Links {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, ApiError> {
        let PublicUrl(url) = PublicUrl::from_request_parts(parts, app).await?;
        Ok(Self { url, signed: parts.extensions.get().cloned() })
    }
}
