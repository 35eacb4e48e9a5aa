//! Longitude and latitude on the plane: spherical Web Mercator (EPSG:3857), as map viewers use it.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Radius of the sphere in metres.
const RADIUS: f64 = 6_378_137.0;

/// The latitude in degrees at which the Web Mercator square ends.
pub const MAX_LATITUDE: f64 = 85.051_128_779_806_59;

/// Plane metres of a longitude and latitude in degrees, the latitude within ±[`MAX_LATITUDE`].
///
/// The same bits on every machine (`libm`, not the platform's).
///
/// ```
/// let (x, y) = terrane::geometry::from_lon_lat(180.0, 0.0);
/// assert_eq!((x, y.abs() < 1e-8), (20037508.342789244, true));
/// ```
#[must_use]
pub fn from_lon_lat(longitude: f64, latitude: f64) -> (f64, f64) {
    let x = RADIUS * (longitude * PI / 180.0);
    let y = RADIUS * libm::log(libm::tan(FRAC_PI_4 + latitude * PI / 360.0));
    (x, y)
}

/// Longitude and latitude in degrees of a point of the plane; longitudes go on beyond ±180°.
#[must_use]
pub fn to_lon_lat(x: f64, y: f64) -> (f64, f64) {
    let latitude = 2.0 * libm::atan(libm::exp(y / RADIUS)) - FRAC_PI_2;
    (x / RADIUS * 180.0 / PI, latitude * 180.0 / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_comes_back() {
        for (lon, lat) in [(0.0, 0.0), (13.4, 52.5), (-179.9, -84.9), (540.0, 85.0)] {
            let (x, y) = from_lon_lat(lon, lat);
            let (back_lon, back_lat) = to_lon_lat(x, y);
            assert!((back_lon - lat * 0.0 - lon).abs() < 1e-10 && (back_lat - lat).abs() < 1e-10, "{lon} {lat} came back as {back_lon} {back_lat}");
        }
        assert!((from_lon_lat(0.0, MAX_LATITUDE).1 - 20_037_508.342_789_244).abs() < 1e-6);
    }
}
