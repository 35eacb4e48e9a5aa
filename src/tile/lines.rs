//! Features as a vector tile: every line with the detail that the terrain shows at the tile's spacing, clipped a little beyond the tile.

use super::{
    TileError, TileRequest,
    clip::{Frame, lines, ring},
    mvt::{Geometry, Layer, Value, encode},
};
use crate::{
    geometry::{Curve, Detail, Elevation, Rectangle, Shape},
    layout::{self, AttributeSet, Role, geojson::Drawn},
    world::World,
};

/// Features that a tile holds at most; of more, the largest.
const MOST_FEATURES: usize = 50_000;

/// Corners that a circle is drawn with.
const CORNERS: u32 = 64;

/// Names of the layers: points, lines, areas.
pub(super) const LAYERS: [&str; 3] = ["points", "lines", "areas"];

/// A feature as it is drawn.
struct Item<'a> {
    layer: &'a str,
    id: Option<String>,
    number: u64,
    set: Option<&'a str>,
    attributes: Option<&'a AttributeSet>,
    shape: &'a Shape,
    detail: Option<&'a Detail>,
    /// Whether its detail fades with the spacing.
    fades: bool,
    own: Option<&'a str>,
}

/// Draws the features of a world that a tile meets.
///
/// # Errors
/// If the grid has no such tile.
pub fn render_features(world: &World, request: &TileRequest) -> Result<Vec<u8>, TileError> {
    let window = request.window()?;
    let (area, spacing) = (window.bounds(), window.spacing());
    let frame = Frame::new(request.grid, request.tile, &area)?;
    let found = world.features_in(&area);
    let islands = world.islands_in(&area, spacing);
    let drawn = found.iter().flat_map(|features| {
        let sets = [&features.set.collection().sets, features.attributes];
        features.drawn().map(move |drawn| Item::drawn(features.layer, drawn, drawn.attributes(sets).map(|set| &**set)))
    });
    let mut numbers = Vec::new();
    let generated = islands.iter().flat_map(|(layer, island)| {
        island.find(&area, &mut numbers);
        let features: Vec<_> = numbers.iter().map(|&number| Item::generated(layer, &island.features()[number as usize])).collect();
        features
    });
    let mut layers = LAYERS.map(Layer::new);
    for item in largest(drawn.chain(generated).collect()) {
        let (layer, geometry) = item.geometry(&frame, &area, if item.fades { spacing } else { 0.0 });
        layers[layer].add(Some(item.number), &item.properties(), &geometry);
    }
    Ok(encode(layers.into()))
}

/// The largest of too many items, in their order.
fn largest(items: Vec<Item>) -> Vec<Item> {
    if items.len() <= MOST_FEATURES {
        return items;
    }
    let size = |item: &Item| {
        let bounds = item.shape.bounds(0.0);
        (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1])
    };
    let mut sized: Vec<(f64, usize, Item)> = items.into_iter().enumerate().map(|(i, item)| (size(&item), i, item)).collect();
    sized.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    sized.truncate(MOST_FEATURES);
    sized.sort_by_key(|item| item.1);
    sized.into_iter().map(|(_, _, item)| item).collect()
}

/// A number of 53 bits out of a name, for readers that know numbers alone.
fn number_of(name: &str) -> u64 {
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    name.parse().ok().filter(|number| *number < 1 << 53).unwrap_or(hash >> 11)
}

impl<'a> Item<'a> {
    fn drawn(layer: &'a str, drawn: &'a Drawn, attributes: Option<&'a AttributeSet>) -> Self {
        let id = drawn.id.as_ref().map(ToString::to_string);
        let number = id.as_deref().map_or_else(|| number_of(&layout::geojson::name_of_feature(drawn)), number_of);
        let (detail, fades) = drawn.detail().map_or((None, true), |(detail, fades)| (Some(detail), fades));
        Self { layer, id, number, set: drawn.set(), attributes, shape: drawn.shape(), detail, fades, own: drawn.properties() }
    }

    fn generated(layer: &'a str, feature: &'a layout::Feature) -> Self {
        let hash = feature.hash().0;
        let number = u64::from_le_bytes(core::array::from_fn(|i| hash[i])) >> 11;
        let detail = feature.shape().curve().and_then(Curve::detail);
        Self { layer, id: None, number, set: None, attributes: Some(feature.attributes()), shape: feature.shape(), detail, fades: true, own: None }
    }

    /// The number of its layer, and its geometry.
    fn geometry(&self, frame: &Frame, area: &Rectangle, spacing: f64) -> (usize, Geometry) {
        let path = |part: &[[f64; 2]]| path(part, self.detail, spacing, area, frame.unit());
        match self.shape {
            Shape::Point { at, .. } if area.holds(*at) => (0, Geometry::Point(frame.rounded(frame.place(*at)))),
            Shape::Point { .. } => (0, Geometry::Lines(Vec::new())),
            Shape::Circle { centre, radius, .. } => {
                let corner = |i: u32| {
                    let (sine, cosine) = libm::sincos(core::f64::consts::TAU * f64::from(i) / f64::from(CORNERS));
                    [centre[0] + radius * cosine, centre[1] + radius * sine]
                };
                let corners: Vec<[f64; 2]> = (0..CORNERS).map(corner).collect();
                (2, Geometry::Polygon(ring(frame, &corners, true).into_iter().collect()))
            }
            Shape::Line(curve) => (1, Geometry::Lines(curve.parts().flat_map(|part| lines(frame, &path(part))).collect())),
            Shape::Polygon(curve) => {
                let mut rings = Vec::new();
                for (i, part) in curve.parts().enumerate() {
                    let clipped = ring(frame, &path(part)[1..], i == 0);
                    // Without its outer ring nothing of a polygon is seen.
                    if i == 0 && clipped.is_none() {
                        break;
                    }
                    rings.extend(clipped);
                }
                (2, Geometry::Polygon(rings))
            }
        }
    }

    fn properties(&self) -> Vec<(String, Value)> {
        let mut all = vec![("layer", Value::Text(self.layer.to_owned()))];
        all.extend(self.id.clone().map(|id| ("id", Value::Text(id))));
        all.extend(self.set.map(|set| ("attributes", Value::Text(set.to_owned()))));
        let elevation = match self.shape {
            Shape::Point { elevation, .. } | Shape::Circle { elevation, .. } => *elevation,
            Shape::Line(curve) | Shape::Polygon(curve) => match curve.elevation() {
                Elevation::Absent => None,
                Elevation::Constant(elevation) => Some(*elevation),
                Elevation::Vertices(elevations) => elevations.iter().copied().reduce(f64::max),
            },
        };
        all.extend(elevation.map(|elevation| ("elevation", Value::Double(elevation))));
        if let Some(set) = self.attributes {
            let water = set.iter().any(|attribute| &*attribute.name == "water_depth" || matches!(attribute.role, Role::Channel { .. }));
            all.push(("water", Value::Bool(water)));
        }
        let own: serde_json::Map<String, serde_json::Value> = self.own.and_then(|own| serde_json::from_str(own).ok()).unwrap_or_default();
        let mut own: Vec<(String, Value)> = own.into_iter().filter_map(|(name, value)| Some((name, own_value(value)?))).collect();
        own.retain(|(name, _)| all.iter().all(|(known, _)| known != name));
        all.into_iter().map(|(name, value)| (name.to_owned(), value)).chain(own).collect()
    }
}

/// A property as vector tiles know it: lists and objects become text.
fn own_value(value: serde_json::Value) -> Option<Value> {
    match value {
        serde_json::Value::Null => None,
        serde_json::Value::Bool(value) => Some(Value::Bool(value)),
        serde_json::Value::String(text) => Some(Value::Text(text)),
        serde_json::Value::Number(number) => number.as_i64().map(Value::Int).or(number.as_f64().map(Value::Double)),
        other => Some(Value::Text(other.to_string())),
    }
}

/// A line or ring with its detail, as far as an area and a smallest size need it; elsewhere it is straight, and never nearer to the area than it was.
fn path(part: &[[f64; 2]], detail: Option<&Detail>, spacing: f64, area: &Rectangle, unit: f64) -> Vec<[f64; 2]> {
    let Some(detail) = detail else { return part.to_vec() };
    let mut out: Vec<[f64; 2]> = part.first().copied().into_iter().collect();
    for ends in part.windows(2) {
        let edge = detail.of_edge(ends[0], ends[1], spacing);
        let mut points = vec![edge.ends[0]];
        let mut open = vec![(0_u8, 0_u32, edge.ends[0], edge.ends[1])];
        while let Some((level, index, a, b)) = open.pop() {
            let reach = edge.reach(level, a, b);
            let bounds = Rectangle::around(&[a, b]).grown(reach);
            let size = (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1]);
            if level == edge.levels || size < unit || !bounds.meets(area) {
                points.push(b);
                continue;
            }
            let middle = edge.midpoint(level, index, a, b);
            open.push((level + 1, 2 * index + 1, middle, b));
            open.push((level + 1, 2 * index, a, middle));
        }
        if edge.reversed {
            points.reverse();
        }
        out.extend_from_slice(&points[1..]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        geometry::{Filter, Grid, Samples, Tile},
        tile::{Height, Options, Tileset, mvt::tests},
        world::Document,
    };

    fn world(features: &str) -> World {
        let json = format!(
            r#"{{"seed":1,"base":{{"programme":"x","scale":1000}},"layers":[{{"name":"own","source":{{"layout":{{"attributes":{{"crest":[{{"name":"elevation","value":"shape","range":9}}]}},"features":[{{"type":"FeatureCollection","features":[{features}]}}]}}}}}}]}}"#
        );
        World::new(Document::parse(json.as_bytes()).unwrap_or_else(|error| panic!("{error}")))
    }

    fn feature(id: &str, kind: &str, coordinates: &str, more: &str) -> String {
        format!(r#"{{"type":"Feature","id":{id},"geometry":{{"type":"{kind}","coordinates":{coordinates}}},"properties":{{"attributes":"crest"{more}}}}}"#)
    }

    /// The tile of 8,192 m a side whose north-west corner is the origin: two metres a unit.
    fn tile(world: &World) -> Vec<tests::Read> {
        let request = TileRequest {
            grid: Grid::Metric,
            tile: Tile { z: 12, x: 0, y: 0 },
            samples: Samples::Vertices(257),
            filter: Filter::Band,
            tileset: Tileset::Features,
            height: Height::Ground,
            options: Options::default(),
        };
        tests::read(&render_features(world, &request).expect("drawn"))
    }

    #[test]
    fn shapes_are_clipped_and_keep_their_names_and_properties() {
        let world = world(
            &[
                feature("7", "LineString", "[[-20000,-400,10],[20000,-400,10]]", r#","name":"Long Ridge","length":40.5,"tags":["a"],"open":true"#),
                feature("\"peak\"", "Point", "[4096,-4096,300]", ""),
                feature("\"far\"", "Point", "[9000,-4096,300]", ""),
                feature("\"plain\"", "Polygon", "[[[-9000,9000,5],[9000,9000,5],[9000,-9000,5],[-9000,-9000,5],[-9000,9000,5]],[[100,-100,5],[200,-100,5],[200,-200,5],[100,-200,5],[100,-100,5]]]", ""),
            ]
            .join(","),
        );
        let features = tile(&world);
        let of = |id: &str| features.iter().find(|feature| feature.properties["id"] == id);
        let line = of("7").expect("there");
        assert_eq!((line.id, &*line.layer, &line.paths), (7, "lines", &vec![vec![[-64, 200], [4160, 200]]]));
        let property = |name: &str| &*line.properties[name];
        assert_eq!(
            ["name", "length", "tags", "open", "layer", "attributes", "elevation"].map(property),
            ["Long Ridge", "40.5", r#"["a"]"#, "true", "own", "crest", "10"]
        );
        assert_eq!(of("peak").expect("there").paths, [[[2048, 2048]]]);
        assert!(of("far").is_none());
        let areas = of("plain").expect("there");
        let doubled = |ring: &[[i64; 2]]| (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()])).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<i64>();
        assert_eq!(areas.paths.iter().map(|ring| doubled(ring) / 2).collect::<Vec<_>>(), [4224 * 4224, -50 * 50], "outer rings are positive, holes negative");
    }

    #[test]
    fn lines_have_the_detail_that_the_terrain_shows() {
        let detailed = feature("1", "LineString", "[[-6000,-2000,10],[14000,-5000,10]]", r#","detail":{"iterations":14,"displacement":0.1,"seed":5}"#);
        let features = tile(&world(&detailed));
        let detail = Detail::new(14, 0.1, 5).expect("valid");
        let mut expected = Vec::new();
        // 32 m a sample: finer segments are not shown.
        detail.of_edge([-6000.0, -2000.0], [14_000.0, -5000.0], 32.0).expand(&mut expected);
        let inside = |p: &[f64; 2]| (0.0..8192.0).contains(&p[0]) && (-8192.0..0.0).contains(&p[1]);
        let points: Vec<[i64; 2]> = features[0].paths.concat();
        let near = |p: &[f64; 2]| {
            let (x, y) = (p[0] / 2.0, -p[1] / 2.0);
            points.windows(2).any(|pair| {
                let [a, b] = [0, 1].map(|i| [pair[i][0] as f64, pair[i][1] as f64]);
                crate::geometry::Edge::new(a, b).nearest([x, y]).0 <= 1.0
            })
        };
        let inside: Vec<_> = expected.iter().filter(|p| inside(p)).collect();
        assert!(inside.len() > 100 && inside.into_iter().all(near), "{} points", points.len());
        let still = detailed.replace(r#""seed":5"#, r#""seed":5,"mode":"static""#);
        assert!(tile(&world(&still))[0].paths.concat().len() > points.len(), "static detail does not fade");
    }
}
