//! A world as a `MapLibre` style.

use super::{shelf::Shelved, tilejson::Factors, worlds::Live};
use crate::{
    geometry::Source,
    tile::{Ramp, Tileset},
};
use serde_json::{Value, json};

/// Colour relief under hillshade, from two sources of the same tiles: `MapLibre` draws terrain and hillshade best from one each.
///
/// Contours and features lie over them, not shown until somebody makes them visible. `heights` is the tileset that heights are read from, `tiles` gives the
/// address of a tileset's tiles.
pub(super) fn style(live: &Live, heights: Tileset, tiles: impl Fn(Tileset) -> String, max_zoom: u8, [longitude, latitude, zoom]: [f64; 3]) -> Value {
    let document = live.world.document();
    let source = elevation(live, heights, &tiles, max_zoom);
    let vector = |tileset| json!({"type": "vector", "tiles": [tiles(tileset)], "minzoom": 0, "maxzoom": max_zoom});
    let mut style = json!({
        "version": 8,
        "name": live.title(),
        "center": [longitude, latitude],
        "zoom": zoom,
        "sources": {"terrain": source, "hillshade": source, "contours": vector(Tileset::Contours)},
        "layers": [
            {"id": "background", "type": "background", "paint": {"background-color": "#dfe5e8"}},
            {"id": "relief", "type": "color-relief", "source": "hillshade", "paint": {"color-relief-color": colours(live)}},
            {"id": "hillshade", "type": "hillshade", "source": "hillshade", "paint": {
                "hillshade-method": "standard", "hillshade-exaggeration": 0.5,
                "hillshade-shadow-color": "#2b2a33", "hillshade-highlight-color": "#fffdf4", "hillshade-accent-color": "#3a3a44",
            }},
        ],
    });
    let mut overlays = vec![
        line("contours", &json!(["!", ["get", "index"]]), "rgba(92, 62, 30, 0.45)", 0.6),
        line("contours", &json!(["get", "index"]), "rgba(92, 62, 30, 0.75)", 1.2),
    ];
    if !document.layers.is_empty() {
        style["sources"]["features"] = vector(Tileset::Features);
        overlays.extend(features());
    }
    // Both kinds of line come from one layer of tiles, so their ids tell them apart.
    for (number, mut layer) in overlays.into_iter().enumerate() {
        layer["id"] = json!(format!("{}-{number}", layer["source"].as_str().unwrap_or_default()));
        layer["layout"]["visibility"] = json!("none");
        if let Some(layers) = style["layers"].as_array_mut() {
            layers.push(layer);
        }
    }
    style
}

/// A source of heights.
fn elevation(live: &Live, heights: Tileset, tiles: impl Fn(Tileset) -> String, max_zoom: u8) -> Value {
    let mut source =
        json!({"type": "raster-dem", "tiles": [tiles(heights)], "tileSize": 512, "encoding": heights.encoding(), "minzoom": 0, "maxzoom": max_zoom});
    if let Some(attribution) = &live.world.document().attribution {
        source["attribution"] = json!(attribution);
    }
    if let (Tileset::Fit, Some(steps)) = (heights, heights.steps(live.world.legend().range)) {
        let Factors { red_factor, green_factor, blue_factor, base_shift } = Factors::of(&steps);
        for (key, value) in [("redFactor", red_factor), ("greenFactor", green_factor), ("blueFactor", blue_factor), ("baseShift", base_shift)] {
            source[key] = json!(value);
        }
    }
    source
}

fn line(source: &str, filter: &Value, colour: &str, width: f64) -> Value {
    let layer = if source == "contours" { "contours" } else { "lines" };
    json!({
        "type": "line", "source": source, "source-layer": layer, "filter": filter,
        "layout": {"line-join": "round", "line-cap": "round"}, "paint": {"line-color": colour, "line-width": width},
    })
}

/// Areas, lines and points; water is blue.
fn features() -> [Value; 5] {
    let colour = json!(["case", ["==", ["get", "water"], true], "#1663b5", "#b3261e"]);
    let areas = json!({"type": "fill", "source": "features", "source-layer": "areas", "layout": {}, "paint": {"fill-color": colour, "fill-opacity": 0.12}});
    let mut borders = line("features", &json!(true), "", 1.0);
    borders["source-layer"] = json!("areas");
    borders["paint"]["line-color"] = colour.clone();
    let dry = line("features", &json!(["!=", ["get", "water"], true]), "#b3261e", 1.4);
    let wet = line("features", &json!(["==", ["get", "water"], true]), "#1663b5", 1.4);
    let points = json!({
        "type": "circle", "source": "features", "source-layer": "points", "layout": {},
        "paint": {"circle-color": colour, "circle-radius": 4, "circle-stroke-color": "#ffffff", "circle-stroke-width": 1.2},
    });
    [areas, borders, dry, wet, points]
}

/// An interpolation over elevation whose stops spread over what the world's survey found.
fn colours(live: &Live) -> Value {
    let ramp = Ramp::over(live.world.document().sea_level, live.survey.elevations.map(f64::from));
    let stops = ramp.stops().flat_map(|(elevation, [r, g, b])| [json!(elevation), json!(format!("#{r:02x}{g:02x}{b:02x}"))]);
    [json!("interpolate"), json!(["linear"]), json!(["elevation"])].into_iter().chain(stops).collect()
}
