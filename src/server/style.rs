//! A world as a `MapLibre` style.

use super::{shelf::Shelved, worlds::Live};
use crate::tile::Ramp;
use serde_json::{Value, json};

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
    let ramp = Ramp::over(live.world.document().sea_level, live.survey.elevations.map(f64::from));
    let stops = ramp.stops().flat_map(|(elevation, [r, g, b])| [json!(elevation), json!(format!("#{r:02x}{g:02x}{b:02x}"))]);
    [json!("interpolate"), json!(["linear"]), json!(["elevation"])].into_iter().chain(stops).collect()
}
