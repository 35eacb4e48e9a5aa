//! A world's features, to be read.

use crate::{
    geometry::Rectangle,
    layout::geojson::{Drawn, Sets, name_of_feature},
    server::{
        error::ApiError,
        extract::{FeatureAt, Known, Links, WorldAt, parse_bbox},
        features::Place,
        headers::{Freshness, is_fresh, not_modified, tagged},
        schema::{FeatureCollectionSchema, FeatureSchema, ProblemDetails},
        state::App,
    },
};
use axum::{
    extract::State,
    http::{HeaderMap, header},
    response::Response,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use utoipa::IntoParams;

/// The media type of `GeoJSON`.
pub(super) const GEOJSON: &str = "application/geo+json";

/// Features that one answer holds at most, and without being asked.
const MOST: usize = 10_000;
const USUAL: usize = 100;

/// Which features are wanted.
#[derive(Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct FeaturesQuery {
    /// `minx,miny,maxx,maxy` in world metres: only features that may meet this area.
    bbox: Option<String>,
    /// Features of one answer, 1 … 10000; 100 without it.
    #[param(minimum = 1, maximum = 10000)]
    limit: Option<usize>,
    /// Features to pass over, as the link `next` does.
    offset: Option<usize>,
}

impl FeaturesQuery {
    fn area(&self) -> Result<Option<Rectangle>, ApiError> {
        let Some(bbox) = &self.bbox else { return Ok(None) };
        let [x0, y0, x1, y1] = parse_bbox(bbox)?;
        Ok(Some(Rectangle { min: [x0, y0], max: [x1, y1] }))
    }
}

#[derive(Serialize)]
struct Page<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Sets::is_empty")]
    attributes: Sets,
    features: Vec<&'a Drawn>,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    links: Vec<Link>,
}

#[derive(Serialize)]
struct Link {
    rel: &'static str,
    #[serde(rename = "type")]
    kind: &'static str,
    href: String,
}

/// The features of a world's stored set, page by page, with the sets of attributes that they name.
#[utoipa::path(get, path = "/worlds/{world}/features", tag = "features", params(("world" = String, Path, description = "`name` or `name@revision`"), FeaturesQuery), responses(
    (status = 200, description = "A page of features; its ETag is the world's revision", body = FeatureCollectionSchema, content_type = "application/geo+json", headers(("ETag" = String, description = "The world's revision"))),
    (status = 304, description = "The world is at the revision that If-None-Match names"),
    (status = 400, description = "The query is wrong", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world or revision", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn list_features(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    Known(query): Known<FeaturesQuery>,
    links: Links,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (area, limit, offset) = (query.area()?, query.limit.unwrap_or(USUAL), query.offset.unwrap_or(0));
    if !(1..=MOST).contains(&limit) {
        return Err(ApiError::parameter("limit", format!("must be 1 … {MOST}, got {limit}")));
    }
    // Links depend on how the server is reached, so even a pinned page may change.
    let (revision, freshness) = (live.world.revision().to_string(), Freshness::Revalidate);
    if is_fresh(&headers, &revision) {
        return Ok(not_modified(&revision, freshness));
    }
    let name = if pinned { format!("{}@{revision}", live.name) } else { live.name.clone() };
    let bbox = query.bbox.map_or_else(String::new, |bbox| format!("&bbox={bbox}"));
    let href = move |offset: usize| links.to(&format!("/worlds/{name}/features?limit={limit}&offset={offset}{bbox}"));
    let body = app.0.queries.run(move || page(&Place::of(&live), area, [limit, offset], &href)).await??;
    Ok(tagged(([(header::CONTENT_TYPE, GEOJSON)], body), &revision, freshness))
}

fn page(place: &Place, area: Option<Rectangle>, [limit, offset]: [usize; 2], href: &dyn Fn(usize) -> String) -> Result<Vec<u8>, ApiError> {
    let collection = place.set.collection();
    let found = area.map(|area| place.set.find(&area));
    let matched = found.as_ref().map_or(collection.features.len(), Vec::len);
    let numbers = offset.min(matched)..offset.saturating_add(limit).min(matched);
    let features: Vec<&Drawn> = match &found {
        Some(found) => found[numbers].iter().map(|&number| &collection.features[number as usize]).collect(),
        None => collection.features[numbers].iter().collect(),
    };
    let names: BTreeSet<&str> = features.iter().flat_map(|drawn| drawn.sets()).collect();
    let mut attributes = place.scope();
    attributes.retain(|name| names.contains(name));
    let link = |rel, offset: usize| Link { rel, kind: GEOJSON, href: href(offset) };
    let returned = features.len();
    let mut links = vec![link("self", offset)];
    if offset.saturating_add(returned) < matched && returned > 0 {
        links.push(link("next", offset + returned));
    }
    let page = Page { kind: "FeatureCollection", attributes, features, matched, returned, links };
    serde_json::to_vec(&page).map_err(|error| ApiError::internal("writing features", &error))
}

/// One feature.
#[utoipa::path(get, path = "/worlds/{world}/features/{id}", tag = "features", params(
    ("world" = String, Path, description = "`name` or `name@revision`"),
    ("id" = String, Path, description = "The feature's id"),
), responses(
    (status = 200, description = "The feature; its ETag names its content", body = FeatureSchema, content_type = "application/geo+json", headers(("ETag" = String, description = "The name of its content"))),
    (status = 304, description = "The feature is what If-None-Match names"),
    (status = 404, description = "No such world, revision or feature", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_feature(WorldAt { live, pinned }: WorldAt, FeatureAt { id, .. }: FeatureAt, headers: HeaderMap) -> Result<Response, ApiError> {
    let place = Place::of(&live);
    let number = place.set.position(&id).ok_or_else(|| unknown(&id))?;
    answer(&headers, &place.set.collection().features[number], Freshness::of(pinned))
}

/// What to say of an id that no feature has.
pub(super) fn unknown(id: &str) -> ApiError {
    ApiError::absent("id", format!("no feature of the world's stored set has the id {:?}", id.chars().take(200).collect::<String>()))
}

/// A feature with its content's name as entity tag, or 304.
fn answer(request: &HeaderMap, drawn: &Drawn, freshness: Freshness) -> Result<Response, ApiError> {
    let tag = name_of_feature(drawn);
    if is_fresh(request, &tag) {
        return Ok(not_modified(&tag, freshness));
    }
    let body = serde_json::to_vec(drawn).map_err(|error| ApiError::internal("writing a feature", &error))?;
    Ok(tagged(([(header::CONTENT_TYPE, GEOJSON)], body), &tag, freshness))
}
