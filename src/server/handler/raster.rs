//! Heights that jobs made.

use crate::{
    geometry::{Filter, Raster, Window},
    server::{
        error::ApiError,
        extract::{Asker, Hash, PublicUrl},
        headers::{Freshness, is_fresh, json, not_modified, tagged},
        schema::{ProblemDetails, RasterList, RasterSchema},
        state::App,
        vocabulary::HashName,
    },
    store::RasterEntry,
    tile::overlay,
    world::{RasterHead, StoredRaster},
};
use axum::{
    body::{Body, Bytes},
    extract::State,
    http::{HeaderMap, header},
    response::Response,
};
use futures_util::{Stream, StreamExt, stream};
use std::{convert::Infallible, sync::Arc};

/// Most rasters in one answer.
const MAX_LISTED: u32 = 1_000;

/// Most pixels of a picture along a side.
const PIXELS: usize = 512;

/// Predicted nanoseconds of a picture.
const PICTURE_NS: f64 = 5e7;

fn schema(url: &str, hash: &str, time: Option<String>, head: &RasterHead) -> RasterSchema {
    let address = format!("{url}/rasters/{hash}");
    RasterSchema {
        hash: hash.to_owned(),
        time,
        bbox: head.bbox(),
        spacing: head.place.spacing,
        columns: head.columns,
        rows: head.rows,
        elevation: head.elevation,
        heights: format!("{address}/heights.bin"),
        preview: format!("{address}/preview.png"),
    }
}

/// The rasters that jobs made.
#[utoipa::path(get, path = "/rasters", tag = "jobs", responses(
    (status = 200, description = "The rasters, newest first", body = RasterList, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
))]
pub(crate) async fn list_rasters(State(app): State<App>, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let entries = app.0.store.rasters(MAX_LISTED).await?;
    let one = |RasterEntry { name, time, head }: RasterEntry| Some(schema(&url, &name, Some(time), &StoredRaster::head(&head).ok()?));
    json(&headers, &RasterList { rasters: entries.into_iter().filter_map(one).collect() }, Freshness::Revalidate)
}

/// A raster that there is.
async fn find(app: &App, hash: &str) -> Result<Arc<Raster>, ApiError> {
    let found = app.0.parts.raster(&app.0.queries, hash).await?;
    found.ok_or_else(|| ApiError::absent("raster", format!("there is no raster {hash}")))
}

/// A raster without its heights. It never changes.
#[utoipa::path(get, path = "/rasters/{raster}", tag = "jobs", params(("raster" = inline(HashName), Path, description = "A raster's hash")), responses(
    (status = 200, description = "The raster", body = RasterSchema, headers(("ETag" = String, description = "A hash of the answer"))),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 404, description = "No such raster", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_raster(State(app): State<App>, Hash(hash): Hash, PublicUrl(url): PublicUrl, headers: HeaderMap) -> Result<Response, ApiError> {
    let raster = find(&app, &hash).await?;
    json(&headers, &schema(&url, &hash, None, &RasterHead::from(&*raster)), Freshness::Revalidate)
}

/// The heights of a raster in metres: f32 little-endian, row by row from the north.
#[utoipa::path(get, path = "/rasters/{raster}/heights.bin", tag = "jobs", params(("raster" = inline(HashName), Path, description = "A raster's hash")), responses(
    (status = 200, description = "The heights", content((Vec<u8> = "application/octet-stream")), headers(("ETag" = String, description = "The hash"))),
    (status = 304, description = "The raster is the one that If-None-Match names"),
    (status = 404, description = "No such raster", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_heights(State(app): State<App>, Hash(hash): Hash, headers: HeaderMap) -> Result<Response, ApiError> {
    let raster = find(&app, &hash).await?;
    if is_fresh(&headers, &hash) {
        return Ok(not_modified(&hash, Freshness::Immutable));
    }
    let length = raster.values().len() * 4;
    let body = Body::from_stream(rows(raster));
    let described = [(header::CONTENT_TYPE, "application/octet-stream".to_owned()), (header::CONTENT_LENGTH, length.to_string())];
    Ok(tagged((described, body), &hash, Freshness::Immutable))
}

/// The heights from the north, some rows at a time, as they are taken.
fn rows(raster: Arc<Raster>) -> impl Stream<Item = Result<Bytes, Infallible>> {
    let [columns, rows] = raster.size();
    let step = (16_384 / columns.max(1)).max(1);
    stream::iter((0..rows).step_by(step)).map(move |north| {
        let south = rows - (north + step).min(rows);
        let band = &raster.values()[south * columns..(rows - north) * columns];
        Ok(band.chunks(columns).rev().flatten().flat_map(|height| height.to_le_bytes()).collect())
    })
}

/// A relief picture of a raster, transparent where there is nothing.
#[utoipa::path(get, path = "/rasters/{raster}/preview.png", tag = "jobs", params(("raster" = inline(HashName), Path, description = "A raster's hash")), responses(
    (status = 200, description = "The picture", content((Vec<u8> = "image/png")), headers(("ETag" = String, description = "The hash"))),
    (status = 304, description = "The raster is the one that If-None-Match names"),
    (status = 404, description = "No such raster", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_preview(State(app): State<App>, Hash(hash): Hash, asker: Asker, headers: HeaderMap) -> Result<Response, ApiError> {
    let raster = find(&app, &hash).await?;
    if is_fresh(&headers, &hash) {
        return Ok(not_modified(&hash, Freshness::Immutable));
    }
    asker.pay(&app, PICTURE_NS)?;
    let (_, png) = app.0.queries.run(move || picture(&raster, PIXELS)).await??;
    Ok(tagged(([(header::CONTENT_TYPE, "image/png")], png), &hash, Freshness::Immutable))
}

/// A picture of at most so many pixels a side, and the area that it shows.
pub(super) fn picture(raster: &Raster, pixels: usize) -> Result<([f64; 4], Vec<u8>), ApiError> {
    let failed = |error: &dyn std::fmt::Display| ApiError::internal("drawing a raster", error);
    let [columns, rows] = raster.size();
    let spacing = raster.place().spacing * columns.max(rows).div_ceil(pixels) as f64;
    let [min_x, min_y, max_x, max_y] = RasterHead::from(raster).bbox();
    let half = raster.place().spacing / 2.0;
    let bbox = [min_x - half, min_y - half, max_x + half, max_y + half];
    let window = Window::area(bbox, spacing, Filter::Band, 1 << 22).map_err(|error| failed(&error))?;
    let png = overlay(raster, &window).map_err(|error| failed(&error))?;
    let end = |n: usize| n as f64 * spacing;
    Ok(([bbox[0], bbox[3] - end(window.rows.len()), bbox[0] + end(window.columns.len()), bbox[3]], png))
}
