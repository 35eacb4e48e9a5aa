//! The ground at a point.

use crate::{
    geometry::{MAX_LATITUDE, from_lon_lat},
    query,
    server::{
        error::ApiError,
        extract::{Known, WorldAt},
        headers::{Freshness, json},
        schema::{ElevationSchema, ProblemDetails},
        state::App,
    },
};
use axum::{extract::State, http::HeaderMap, response::Response};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// A point, by plane metres or by longitude and latitude.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct PointQuery {
    /// Metres to the east of the plane's origin, with y.
    x: Option<f64>,
    /// Metres to the north of the plane's origin, with x.
    y: Option<f64>,
    /// Degrees, with lat; on the plane as Web Mercator has it.
    lon: Option<f64>,
    /// Degrees within ±85.0511, with lon.
    lat: Option<f64>,
    /// Metres a pixel: the elevation as a tile of this spacing sees it. Without it, the function as it is.
    spacing: Option<f64>,
}

/// Where a query points to.
struct Point {
    x: f64,
    y: f64,
    lon_lat: Option<(f64, f64)>,
}

impl PointQuery {
    fn point(&self) -> Result<Point, ApiError> {
        match (self.x, self.y, self.lon, self.lat) {
            (Some(x), Some(y), None, None) => Ok(Point { x, y, lon_lat: None }),
            (None, None, Some(lon), Some(lat)) => {
                if !(-MAX_LATITUDE..=MAX_LATITUDE).contains(&lat) {
                    return Err(ApiError::parameter("lat", format!("must be within ±{MAX_LATITUDE} degrees, got {lat}")));
                }
                let (x, y) = from_lon_lat(lon, lat);
                Ok(Point { x, y, lon_lat: Some((lon, lat)) })
            }
            (x, _, lon, lat) => {
                let wrong = match (x, lon, lat) {
                    (None, Some(_), None) => "lat",
                    (None, None, Some(_)) => "lon",
                    (Some(_), None, None) => "y",
                    _ => "x",
                };
                Err(ApiError::parameter(wrong, "a point is given by x and y (metres) or by lon and lat (degrees)"))
            }
        }
    }
}

/// The ground at a point: exact, or as a tile sees it.
#[utoipa::path(get, path = "/worlds/{world}/elevation", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`"), PointQuery), responses(
    (status = 200, description = "The ground there", body = ElevationSchema),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "No point, or one beyond the plane", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_elevation(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    Known(query): Known<PointQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let Point { x, y, lon_lat } = query.point()?;
    let (spacing, world) = (query.spacing, Arc::clone(&live));
    let ground = app.0.queries.run(move || query::elevation(&world.world, x, y, spacing)).await?;
    let ground = ground.map_err(|error| match error {
        crate::geometry::WindowError::Spacing(_) => ApiError::parameter("spacing", error.to_string()),
        _ => ApiError::parameter(if lon_lat.is_some() { "lon" } else { "x" }, error.to_string()),
    })?;
    let (longitude, latitude) = lon_lat.unzip();
    let body = ElevationSchema { x, y, longitude, latitude, elevation: ground.elevation, water_depth: ground.water_depth };
    json(&headers, &body, Freshness::of(pinned))
}
