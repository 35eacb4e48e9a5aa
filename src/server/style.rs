//! A world as a `MapLibre` style.

use super::worlds::Live;
use serde_json::{Value, json};

/// Colours of the land, from its foot to its top.
const LAND: [(f64, [u8; 3]); 7] = [
    (0.0, [0x5f, 0x8a, 0x5a]),
    (0.12, [0x86, 0xa8, 0x67]),
    (0.3, [0xc2, 0xc1, 0x84]),
    (0.5, [0xb8, 0x9a, 0x6b]),
    (0.7, [0x8f, 0x75, 0x60]),
    (0.86, [0xb7, 0xac, 0xa6]),
    (1.0, [0xf7, 0xf7, 0xf5]),
];

/// Metres above the foot where the land's colours end in snow; lower land ends in an earlier colour.
const SNOW_HEIGHT: f64 = 2_600.0;

/// The part of the land's colours that low land gets at least.
const LEAST_COLOURS: f64 = 0.45;

/// Colours of the sea, from its deepest place to the shore.
const SEA: [(f64, &str); 3] = [(0.0, "#123a5c"), (0.6, "#2f6f9f"), (1.0, "#8fc1d9")];

/// Least height in metres that the colours of land and sea are spread over.
const LEAST_SPREAD: f64 = 1.0;

/// Colour relief under hillshade, from two sources of the same tiles: `MapLibre` draws terrain and hillshade best from one each.
pub(super) fn style(live: &Live, tiles: &str, max_zoom: u8, [longitude, latitude, zoom]: [f64; 3]) -> Value {
    let document = live.world.document();
    let mut source = json!({"type": "raster-dem", "tiles": [tiles], "tileSize": 512, "encoding": "terrarium", "minzoom": 0, "maxzoom": max_zoom});
    if let Some(attribution) = &document.attribution {
        source["attribution"] = json!(attribution);
    }
    json!({
        "version": 8,
        "name": live.title(),
        "center": [longitude, latitude],
        "zoom": zoom,
        "sources": {"terrain": source, "hillshade": source},
        "layers": [
            {"id": "background", "type": "background", "paint": {"background-color": "#dfe5e8"}},
            {"id": "relief", "type": "color-relief", "source": "hillshade", "paint": {"color-relief-color": colours(live)}},
            {"id": "hillshade", "type": "hillshade", "source": "hillshade", "paint": {
                "hillshade-method": "standard", "hillshade-exaggeration": 0.5,
                "hillshade-shadow-color": "#2b2a33", "hillshade-highlight-color": "#fffdf4", "hillshade-accent-color": "#3a3a44",
            }},
        ],
    })
}

/// An interpolation over elevation whose stops spread over what the world's survey found.
fn colours(live: &Live) -> Value {
    let sea = live.world.document().sea_level;
    let [low, high] = live.survey.elevations.map(f64::from);
    let mut expression = vec![json!("interpolate"), json!(["linear"]), json!(["elevation"])];
    if low < sea {
        let depth = (sea - low).max(LEAST_SPREAD);
        for (at, colour) in SEA {
            // The shore's own colour ends just below the sea's surface, where land begins.
            expression.extend([json!(sea - depth * (1.0 - at) - 0.01), json!(colour)]);
        }
    }
    let foot = low.max(sea);
    let height = (high - foot).max(LEAST_SPREAD);
    let used = (height / SNOW_HEIGHT).clamp(LEAST_COLOURS, 1.0);
    for (at, _) in LAND {
        let [r, g, b] = land_colour(at * used);
        expression.extend([json!(foot + height * at), json!(format!("#{r:02x}{g:02x}{b:02x}"))]);
    }
    Value::Array(expression)
}

/// The land's colour at a place from 0 to 1.
fn land_colour(at: f64) -> [u8; 3] {
    let above = LAND.iter().position(|(place, _)| *place >= at).unwrap_or(LAND.len() - 1).max(1);
    let ((from, low), (to, high)) = (LAND[above - 1], LAND[above]);
    let t = (at - from) / (to - from);
    core::array::from_fn(|i| (f64::from(low[i]) + t * (f64::from(high[i]) - f64::from(low[i]))).round() as u8)
}
