//! The ground at a point, at many points, and along a line.

use crate::{
    geometry::{MAX_LATITUDE, WindowError, from_lon_lat},
    query::{self, BatchError, PointElevation},
    server::{
        compute::WhileAsked,
        error::{ApiError, Entry},
        extract::{Asker, Body, Known, WorldAt},
        headers::{Freshness, json},
        schema::{BatchSchema, ElevationSchema, ElevationsSchema, ProblemDetails, ProfileSchema},
        state::App,
        worlds::Live,
    },
    world::Object,
};
use axum::{
    Json,
    extract::State,
    http::{HeaderMap, header},
    response::{IntoResponse, Response},
};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// A point, by plane metres or by longitude and latitude.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct PointQuery {
    /// Metres to the east of the plane's origin, with y.
    #[param(minimum = -1_099_511_627_776_i64, maximum = 1_099_511_627_776_i64)]
    x: Option<f64>,
    /// Metres to the north of the plane's origin, with x.
    #[param(minimum = -1_099_511_627_776_i64, maximum = 1_099_511_627_776_i64)]
    y: Option<f64>,
    /// Degrees, with lat; on the plane as Web Mercator has it.
    lon: Option<f64>,
    /// Degrees within ±85.0511, with lon.
    lat: Option<f64>,
    /// Metres a pixel: the elevation as a tile of this spacing sees it. Without it, the function as it is.
    #[param(exclusive_minimum = 0)]
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
        WindowError::Spacing(_) => ApiError::parameter("spacing", error.to_string()),
        _ => ApiError::parameter(if lon_lat.is_some() { "lon" } else { "x" }, error.to_string()),
    })?;
    let (longitude, latitude) = lon_lat.unzip();
    let body = ElevationSchema { x, y, longitude, latitude, elevation: ground.elevation, water_depth: ground.water_depth };
    json(&headers, &body, Freshness::of(pinned))
}

/// Most points of a batch and of a profile.
const MAX_POINTS: usize = 10_000;

/// Predicted nanoseconds that points may take together.
const MOST_NS: f64 = 1e10;

/// Nanoseconds that a point costs its client: about what one of an eroded world takes alone.
const POINT_NS: f64 = 20_000.0;

/// Points of a profile without a wish.
const USUAL_POINTS: usize = 256;

/// Evaluates points apart from the threads that answer, for as long as somebody waits.
async fn evaluate(
    app: &App,
    asker: &Asker,
    live: Arc<Live>,
    points: Vec<[f64; 2]>,
    spacing: Option<f64>,
) -> Result<Result<Vec<PointElevation>, BatchError>, ApiError> {
    asker.pay(app, POINT_NS * points.len() as f64)?;
    let asked = WhileAsked::new();
    let stop = asked.stop();
    Ok(app.0.queries.run(move || query::elevations(&live.world, &points, spacing, MOST_NS, &stop)).await?)
}

/// A point that a request gives, on the plane.
fn on_plane([lon, lat]: [f64; 2]) -> Result<[f64; 2], String> {
    if !(-MAX_LATITUDE..=MAX_LATITUDE).contains(&lat) {
        return Err(format!("a latitude must be within ±{MAX_LATITUDE} degrees, got {lat}"));
    }
    let (x, y) = from_lon_lat(lon, lat);
    Ok([x, y])
}

/// The ground at many points, in their order.
#[utoipa::path(post, path = "/worlds/{world}/elevation", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`")), request_body(content = BatchSchema, description = "Up to 10,000 points"), responses(
    (status = 200, description = "The ground there", body = ElevationsSchema),
    (status = 400, description = "The body is wrong, a point is beyond the plane, or the points would take longer than 10 s", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 413, description = "The body is too large", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn post_elevation(State(app): State<App>, WorldAt { live, .. }: WorldAt, asker: Asker, Body(body): Body) -> Result<Response, ApiError> {
    let wrong = |pointer: String, detail: String| ApiError::BadRequest("The points are wrong.".to_owned(), vec![Entry::pointer(pointer, detail)]);
    let mut reader = serde_json::Deserializer::from_slice(&body);
    let Object(batch): Object<BatchSchema> = serde_path_to_error::deserialize(&mut reader).map_err(|error| {
        let path = error.path().to_string();
        let pointer = if path == "." { String::new() } else { format!("/{}", path.replace('[', "/").replace([']', '.'], "").replace("//", "/")) };
        wrong(pointer, error.into_inner().to_string())
    })?;
    reader.end().map_err(|error| wrong(String::new(), error.to_string()))?;
    let (name, points) = match (batch.points, batch.lonlats) {
        (Some(points), None) => ("points", points),
        (None, Some(lonlats)) => {
            let plane = lonlats.into_iter().enumerate().map(|(i, point)| on_plane(point).map_err(|detail| wrong(format!("/lonlats/{i}"), detail)));
            ("lonlats", plane.collect::<Result<_, _>>()?)
        }
        _ => return Err(wrong(String::new(), "either points ([[x, y], …] in metres) or lonlats ([[lon, lat], …] in degrees) are needed".to_owned())),
    };
    if points.len() > MAX_POINTS {
        return Err(wrong(format!("/{name}"), format!("must be at most {MAX_POINTS} points, got {}", points.len())));
    }
    let ground = evaluate(&app, &asker, live, points, batch.spacing).await?.map_err(|error| match error {
        BatchError::Point { error: error @ WindowError::Spacing(_), .. } => wrong("/spacing".to_owned(), error.to_string()),
        BatchError::Point { index, error } => wrong(format!("/{name}/{index}"), error.to_string()),
        error => wrong(format!("/{name}"), error.to_string()),
    })?;
    let [elevation, water_depth] = columns(&ground);
    Ok(([(header::CACHE_CONTROL, "no-store")], Json(ElevationsSchema { elevation, water_depth })).into_response())
}

/// Elevations, and depths of water.
fn columns(ground: &[PointElevation]) -> [Vec<f32>; 2] {
    [ground.iter().map(|point| point.elevation).collect(), ground.iter().map(|point| point.water_depth).collect()]
}

/// A line and how closely it is looked at.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct ProfileQuery {
    /// Metres: `x,y,x,y,…`, two to 256 corners.
    #[param(example = "0,0,20000,5000")]
    line: Option<String>,
    /// Degrees: `lon,lat,lon,lat,…`, instead of `line`; the line is straight on the plane between its corners, as Web Mercator shows it.
    lonlat: Option<String>,
    /// How many points at equal distances, both ends among them: 2 … 10000, 256 without it.
    #[param(value_type = Option<usize>, minimum = 2, maximum = 10000)]
    samples: Option<String>,
    /// Metres a pixel: the elevations as tiles of this spacing see them. Without it, the function as it is.
    #[param(exclusive_minimum = 0)]
    spacing: Option<f64>,
}

impl ProfileQuery {
    /// The name of what gives the line, and its corners on the plane.
    fn corners(&self) -> Result<(&'static str, Vec<[f64; 2]>), ApiError> {
        /// Most corners of a line.
        const MAX_CORNERS: usize = 256;
        let (name, text) = match (&self.line, &self.lonlat) {
            (Some(line), None) => ("line", line),
            (None, Some(lonlat)) => ("lonlat", lonlat),
            _ => return Err(ApiError::parameter("line", "a line is given by line=x,y,x,y,… (metres) or by lonlat=lon,lat,lon,lat,… (degrees)")),
        };
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
        let numbers = numbers.ok().filter(|numbers| numbers.len() % 2 == 0 && (2..=MAX_CORNERS).contains(&(numbers.len() / 2)));
        let numbers =
            numbers.ok_or_else(|| ApiError::parameter(name, format!("must be 2 to {MAX_CORNERS} pairs of numbers with commas between all of them")))?;
        let corners = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        let on_plane = |corner| if name == "line" { Ok(corner) } else { on_plane(corner).map_err(|detail| ApiError::parameter(name, detail)) };
        Ok((name, corners.map(on_plane).collect::<Result<_, _>>()?))
    }

    fn samples(&self) -> Result<usize, ApiError> {
        let samples = self.samples.as_ref().map_or(Ok(USUAL_POINTS), |samples| samples.parse());
        let samples = samples.ok().filter(|samples| (2..=MAX_POINTS).contains(samples));
        samples.ok_or_else(|| ApiError::parameter("samples", format!("must be a whole number 2 … {MAX_POINTS}")))
    }
}

/// The ground along a line.
#[utoipa::path(get, path = "/worlds/{world}/profile", tag = "queries", params(("world" = String, Path, description = "`name` or `name@revision`"), ProfileQuery), responses(
    (status = 200, description = "Points at equal distances from the first corner to the last", body = ProfileSchema),
    (status = 304, description = "The answer is the one that If-None-Match names"),
    (status = 400, description = "No line, one that leaves the plane, or points that would take longer than 10 s", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_profile(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    Known(query): Known<ProfileQuery>,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let ((name, corners), samples) = (query.corners()?, query.samples()?);
    let (points, distance) = query::along(&corners, samples);
    let ground = evaluate(&app, &asker, live, points.clone(), query.spacing).await?.map_err(|error| match error {
        BatchError::Point { error: error @ WindowError::Spacing(_), .. } => ApiError::parameter("spacing", error.to_string()),
        BatchError::Point { error, .. } => ApiError::parameter(name, error.to_string()),
        error => ApiError::parameter(name, error.to_string()),
    })?;
    let [elevation, water_depth] = columns(&ground);
    let climb = |up: f32| elevation.windows(2).map(|pair| f64::from(((pair[1] - pair[0]) * up).max(0.0))).sum();
    let body = ProfileSchema {
        length: distance.last().copied().unwrap_or_default(),
        ascent: climb(1.0),
        descent: climb(-1.0),
        distance,
        points,
        water_depth,
        elevation,
    };
    json(&headers, &body, Freshness::of(pinned))
}
