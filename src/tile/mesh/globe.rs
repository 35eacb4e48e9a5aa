//! The plane on the globe: where a tile of `geo` or `web` lies on the ellipsoid WGS 84.

use crate::geometry::{Axis, DEGREE, Grid, to_lon_lat};
use core::f64::consts::PI;

/// Semi-axes of WGS 84 in metres (NIMA TR8350.2).
pub(super) const RADII: [f64; 3] = [6_378_137.0, 6_378_137.0, 6_356_752.314_245_179];

/// The square of its first eccentricity.
const ECCENTRICITY_2: f64 = 6.694_379_990_141_317e-3;

/// A direction or a place in earth-centred, earth-fixed coordinates.
pub(super) type Vector = [f64; 3];

/// The scalar product.
pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector by a number.
fn times(a: Vector, by: f64) -> Vector {
    a.map(|c| c * by)
}

/// The length of a vector.
pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The longitudes of a row of samples in radians; they go on beyond ±π.
pub(super) fn longitudes(grid: Grid, columns: &Axis) -> Vec<f64> {
    columns.coordinates().map(|x| if grid == Grid::Geo { x / DEGREE } else { to_lon_lat(x, 0.0).0 } * PI / 180.0).collect()
}

/// The geodetic latitudes of a column of samples in radians.
pub(super) fn latitudes(grid: Grid, rows: &Axis) -> Vec<f64> {
    rows.coordinates().map(|y| if grid == Grid::Geo { y / DEGREE } else { to_lon_lat(0.0, y).1 } * PI / 180.0).collect()
}

/// Up, east and north at a longitude and latitude.
struct Frame {
    up: Vector,
    east: Vector,
    north: Vector,
    /// Cosine of the latitude.
    narrow: f64,
}

impl Frame {
    fn at(longitude: f64, latitude: f64) -> Self {
        let (sin_lon, cos_lon) = (libm::sin(longitude), libm::cos(longitude));
        let (sin_lat, cos_lat) = (libm::sin(latitude), libm::cos(latitude));
        let up = [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat];
        Self { up, east: [-sin_lon, cos_lon, 0.0], north: [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat], narrow: cos_lat }
    }
}

/// The place at a longitude, latitude (radians) and height above the ellipsoid (metres).
pub(super) fn place(longitude: f64, latitude: f64, height: f64) -> Vector {
    let up = Frame::at(longitude, latitude).up;
    let curvature = RADII[0] / (1.0 - ECCENTRICITY_2 * up[2] * up[2]).sqrt();
    [(curvature + height) * up[0], (curvature + height) * up[1], (curvature * (1.0 - ECCENTRICITY_2) + height) * up[2]]
}

/// The unit normal of ground that rises by so much to the east and north for a metre of the plane.
///
/// A metre of the plane is shorter on the ground: on `web` by the cosine of the latitude both ways, on `geo` along parallels. At a pole, which is a whole edge of
/// the plane, it points up.
pub(super) fn normal(grid: Grid, longitude: f64, latitude: f64, gradient: [f32; 2]) -> Vector {
    /// Below this cosine the plane's width means nothing.
    const POLE: f64 = 1e-9;
    let Frame { up, east, north, narrow } = Frame::at(longitude, latitude);
    if narrow < POLE {
        return up;
    }
    let to_east = f64::from(gradient[0]) / narrow;
    let to_north = if grid == Grid::Geo { f64::from(gradient[1]) } else { f64::from(gradient[1]) / narrow };
    let normal: Vector = core::array::from_fn(|i| up[i] - east[i] * to_east - north[i] * to_north);
    times(normal, 1.0 / length(normal))
}

/// A sphere round places: the middle of their bounding box, and the distance to the farthest.
pub(super) fn sphere(places: &[Vector]) -> (Vector, f64) {
    let centre = core::array::from_fn(|axis| {
        let along = places.iter().map(|place| place[axis]);
        f64::midpoint(along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max))
    });
    let radius = places.iter().map(|place| length(core::array::from_fn(|i| place[i] - centre[i]))).fold(0.0, f64::max);
    // A hair more, for those who compute in another order.
    (centre, radius * (1.0 + 1e-12))
}

/// The point on the line from the earth's centre through `towards` that the horizon hides only when it hides all places; coordinates are over the radii of the
/// ellipsoid.
///
/// Not a number where there is none, for tiles that reach a quarter round the earth: what compares with it then hides nothing.
///
/// Source: K. Ring, "Computing the horizon occlusion point" (Cesium, 2013).
pub(super) fn occlusion_point(towards: Vector, places: &[Vector]) -> Vector {
    let scaled = |place: Vector| -> Vector { core::array::from_fn(|i| place[i] / RADII[i]) };
    let direction = scaled(towards);
    let direction = times(direction, 1.0 / length(direction));
    let mut farthest = 0.0_f64;
    for place in places {
        let place = scaled(*place);
        // What lies below the ellipsoid counts as if it lay on it.
        let (over, own) = (length(place).max(1.0), times(place, 1.0 / length(place)));
        let (cos_a, sin_a) = (dot(own, direction), length(cross(own, direction)));
        let (cos_b, sin_b) = (1.0 / over, (over * over - 1.0).sqrt() / over);
        let along = 1.0 / (cos_a * cos_b - sin_a * sin_b);
        farthest = if along > 0.0 { farthest.max(along) } else { f64::NAN };
        if farthest.is_nan() {
            break;
        }
    }
    times(direction, farthest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_places() {
        let close = |a: Vector, b: Vector| length(core::array::from_fn(|i| a[i] - b[i])) < 1e-3;
        assert!(close(place(0.0, 0.0, 100.0), [RADII[0] + 100.0, 0.0, 0.0]));
        assert!(close(place(0.0, PI / 2.0, -50.0), [0.0, 0.0, RADII[2] - 50.0]));
        // EPSG guidance note 7-2, section 4.1.1: 53°48'33.820" N, 2°7'46.380" E, 73 m.
        let (longitude, latitude) = (2.0 + 7.0 / 60.0 + 46.38 / 3600.0, 53.0 + 48.0 / 60.0 + 33.82 / 3600.0);
        let leeds = place(longitude * PI / 180.0, latitude * PI / 180.0, 73.0);
        assert!(length(core::array::from_fn(|i| leeds[i] - [3_771_793.968, 140_253.342, 5_124_304.349][i])) < 0.1, "{leeds:?}");
    }

    #[test]
    fn normals_are_unit_vectors_that_lean_away_from_the_rise() {
        for (longitude, latitude) in [(0.0, 0.0), (2.0, 1.2), (-3.0, -0.9)] {
            let Frame { up, east, north, .. } = Frame::at(longitude, latitude);
            assert!(dot(normal(Grid::Web, longitude, latitude, [0.0, 0.0]), up) > 1.0 - 1e-12);
            let steep = normal(Grid::Geo, longitude, latitude, [0.5, -0.25]);
            assert!((length(steep) - 1.0).abs() < 1e-12 && dot(steep, east) < 0.0 && dot(steep, north) > 0.0);
        }
        assert_eq!(normal(Grid::Geo, 1.0, PI / 2.0, [1.0, 1.0]), Frame::at(1.0, PI / 2.0).up);
    }

    /// A camera that sees a place sees the occlusion point: neither lies behind the ellipsoid.
    #[test]
    fn the_occlusion_point_is_hidden_only_with_all_places() {
        let hidden = |camera: Vector, point: Vector| {
            // Both over the radii: behind the plane of the horizon and within its cone.
            let to: Vector = core::array::from_fn(|i| point[i] - camera[i]);
            let (over, along) = (dot(camera, camera) - 1.0, -dot(to, camera));
            along > over && along * along / dot(to, to) > over
        };
        let scaled = |place: Vector| -> Vector { core::array::from_fn(|i| place[i] / RADII[i]) };
        let places: Vec<Vector> = (0..25_u8).map(|i| place(0.1 + f64::from(i % 5) * 0.02, 0.7 + f64::from(i / 5) * 0.02, f64::from(i) * 300.0)).collect();
        let point = occlusion_point(sphere(&places).0, &places);
        let (mut seen, mut unseen) = (0, 0);
        for i in 0..40_u32 {
            for j in 0..40_u32 {
                let camera = scaled(place(f64::from(i) * 0.16, f64::from(j) * 0.078 - 1.56, 1e3 + f64::from(i * j) * 4e3));
                let any = places.iter().any(|place| !hidden(camera, scaled(*place)));
                assert!(!any || !hidden(camera, point), "{i} {j}");
                if any { seen += 1 } else { unseen += i32::from(hidden(camera, point)) }
            }
        }
        assert!(seen > 100 && unseen > 100, "{seen} {unseen}");
        let half: Vec<Vector> = (0..9_u8).map(|i| place(f64::from(i) * 0.4, 0.0, 0.0)).collect();
        assert!(occlusion_point(half[4], &half)[0].is_nan());
    }
}
