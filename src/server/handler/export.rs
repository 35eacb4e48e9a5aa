//! Areas as files.

use crate::{
    geometry::{Filter, WindowError},
    server::{
        address::choice,
        error::ApiError,
        exports::Exports,
        extract::{Asker, Known, WorldAt, parse_bbox},
        headers::{Freshness, is_fresh, not_modified, tagged},
        schema::ProblemDetails,
        state::App,
        vocabulary::{AreaFormatName, FilterName, RegistrationName, SurfaceName},
        worlds::Live,
    },
    tile::{Area, AreaError, AreaFormat, AreaRequest, Height, Registration},
    world::{Fingerprint, World},
};
use axum::{
    extract::State,
    http::{HeaderMap, HeaderValue, header},
    response::Response,
};
use serde::Deserialize;
use std::sync::Arc;
use utoipa::IntoParams;

/// Which area is wanted, and as what.
#[derive(Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct ExportQuery {
    /// `minx,miny,maxx,maxy` in world metres; the north-west corner is kept, the sides are rounded to whole spacings.
    #[param(required, example = "-5000,0,5000,10000")]
    bbox: Option<String>,
    /// Metres between neighbouring samples.
    #[param(required, exclusive_minimum = 0, example = 10)]
    spacing: Option<f64>,
    /// `geotiff` (f32 metres with their place, EPSG:3857), `r16` (little-endian u16 over the world's vertical range), `r32` (little-endian f32 metres), `png16`
    /// (grey of 16 bits over the range), `obj` or `gltf` (triangles; one binary `.glb`).
    #[param(required, value_type = AreaFormatName, inline, example = "geotiff")]
    format: Option<String>,
    /// `centres` (samples in the middle of pixels; default of rasters) or `vertices` (on the area's edges, as `@n` of tiles; default of meshes).
    #[param(value_type = Option<RegistrationName>, inline)]
    registration: Option<String>,
    /// `ground` (default) or `water`: the water's surface where there is water.
    #[param(value_type = Option<SurfaceName>, inline)]
    surface: Option<String>,
    /// `band` (default) leaves out what the spacing cannot carry, `exact` samples the function as it is.
    #[param(value_type = Option<FilterName>, inline)]
    filter: Option<String>,
}

impl ExportQuery {
    fn request(&self) -> Result<AreaRequest, ApiError> {
        let needed = |name: &str, what: &str| ApiError::parameter(name, format!("{what} is needed"));
        let bbox = parse_bbox(self.bbox.as_deref().ok_or_else(|| needed("bbox", "an area, minx,miny,maxx,maxy in metres,"))?)?;
        let spacing = self.spacing.ok_or_else(|| needed("spacing", "a number of metres between samples"))?;
        let names = AreaFormat::ALL.map(AreaFormat::name).join(", ");
        let format = self.format.as_deref().ok_or_else(|| needed("format", &format!("one of {names}")))?;
        let format = AreaFormat::from_name(format).ok_or_else(|| ApiError::parameter("format", format!("must be one of {names}, got {format:?}")))?;
        let registrations = match format.registration() {
            Registration::Centres => [Registration::Centres, Registration::Vertices],
            Registration::Vertices => [Registration::Vertices, Registration::Centres],
        };
        Ok(AreaRequest {
            bbox,
            spacing,
            filter: choice("filter", self.filter.as_deref(), [("band", Filter::Band), ("exact", Filter::Exact)], || None)?,
            registration: choice("registration", self.registration.as_deref(), registrations.map(|registration| (registration.name(), registration)), || None)?,
            height: choice("surface", self.surface.as_deref(), [("ground", Height::Ground), ("water", Height::Water)], || None)?,
            format,
        })
    }
}

/// An area as a file, streamed while it is evaluated.
///
/// A mesh is turned as models are: x to the east, y up, z to the south, in metres from the middle of the area.
#[utoipa::path(get, path = "/worlds/{world}/export", tag = "exports", params(("world" = String, Path, description = "`name`, or `name@revision` for a file that never changes"), ExportQuery), responses(
    (status = 200, description = "The file; with its length for all but `png16` and `obj`", content((Vec<u8> = "image/tiff"), (Vec<u8> = "application/octet-stream"), (Vec<u8> = "image/png"), (Vec<u8> = "model/obj"), (Vec<u8> = "model/gltf-binary")), headers(("ETag" = String, description = "The file's fingerprint"), ("Content-Disposition" = String, description = "A name for the file"))),
    (status = 304, description = "The file is what If-None-Match names; nothing was evaluated"),
    (status = 400, description = "The query is wrong, or the area has more samples or would take longer than the server allows", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 404, description = "No such world", body = ProblemDetails, content_type = "application/problem+json"),
    (status = 503, description = "Too many exports are under way", body = ProblemDetails, content_type = "application/problem+json"),
))]
pub(crate) async fn get_export(
    State(app): State<App>,
    WorldAt { live, pinned }: WorldAt,
    Known(query): Known<ExportQuery>,
    asker: Asker,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let exports = &app.0.exports;
    let area = area(exports, &query.request()?)?;
    let (world, freshness) = (Arc::clone(&live), Freshness::of(pinned));
    // Large areas hold many features.
    let (fingerprint, cost_ns) = app.0.queries.run(move || plan(&world.world, &area)).await?;
    let tag = fingerprint.to_string();
    if is_fresh(&headers, &tag) {
        return Ok(not_modified(&tag, freshness));
    }
    if cost_ns > exports.cost_ns {
        let [seconds, most] = [cost_ns, exports.cost_ns].map(|cost_ns| cost_ns / 1e9);
        let detail = format!("this would take about {seconds:.0} s of evaluation, and {most:.0} s are allowed: ask for a wider spacing or a smaller area");
        return Err(ApiError::parameter("spacing", detail));
    }
    asker.pay(&app, cost_ns)?;
    let described = described(&live, &area);
    let export = exports.begin(live, area)?;
    let length = export.length().map(|length| [(header::CONTENT_LENGTH, HeaderValue::from(length))]);
    Ok(tagged((described, length, exports.body(export)), &tag, freshness))
}

/// The file that is asked for, or what is wrong with it.
fn area(exports: &Exports, request: &AreaRequest) -> Result<Area, ApiError> {
    request.area(exports.samples).map_err(|error| match &error {
        AreaError::Window(WindowError::Spacing(_)) => ApiError::parameter("spacing", error.to_string()),
        AreaError::Window(WindowError::Samples { .. }) => ApiError::parameter("spacing", format!("{error}: ask for a wider spacing or a smaller area")),
        AreaError::Vertices(_) => ApiError::parameter("spacing", format!("{error}: ask for a wider spacing, a smaller area or a raster")),
        AreaError::Window(_) | AreaError::Side { .. } | AreaError::Thin => ApiError::parameter("bbox", error.to_string()),
    })
}

/// What the file is called by its content, and the predicted time of it on one thread in nanoseconds.
fn plan(world: &World, area: &Area) -> (Fingerprint, f64) {
    let window = area.evaluated();
    (world.identify_window(&area.form(), window), world.parts_cost_ns(window, area.part_samples()))
}

/// The headers that say what a file is.
fn described(live: &Live, area: &Area) -> HeaderMap {
    let [west, south, east, north] = area.covered().map(|c| (c * 1000.0).round() / 1000.0 + 0.0);
    let name = format!("{}_{west}_{south}_{east}_{north}_{}m.{}", live.name, area.window().spacing(), area.format().extension());
    let mut headers = HeaderMap::new();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(area.format().media_type()));
    headers.extend(HeaderValue::from_str(&format!("attachment; filename=\"{name}\"")).ok().map(|value| (header::CONTENT_DISPOSITION, value)));
    headers
}
