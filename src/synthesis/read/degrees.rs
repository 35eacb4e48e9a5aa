//! Degrees to metres.

use super::{File, Place, SampleError};

/// Metres of a degree to the east and to the north at a latitude on the ellipsoid WGS 84: the usual series (error below 0.1 m).
#[must_use]
pub(super) fn metres_of_degree(latitude: f64) -> [f64; 2] {
    let cos = |times: f64| libm::cos(times * latitude.to_radians());
    [111_412.84 * cos(1.0) - 93.5 * cos(3.0) + 0.118 * cos(5.0), 111_132.92 - 559.82 * cos(2.0) + 1.175 * cos(4.0) - 0.0023 * cos(6.0)]
}

/// Spacings in degrees to metres at the latitude of the middle, and the sentence that says so.
pub(super) fn spacing(file: &File, degrees: [f64; 2], latitude: f64) -> Result<([f64; 2], String), SampleError> {
    let latitude = file.hints.latitude.unwrap_or(latitude);
    if !(-89.0..=89.0).contains(&latitude) {
        return Err(file.error(Place::File, format!("spacings in degrees need a middle latitude of -89 … 89 degrees, got {latitude}")));
    }
    let metres = metres_of_degree(latitude);
    let spacing = [degrees[0] * metres[0], degrees[1] * metres[1]];
    let note = format!("spacings in degrees are metres at latitude {latitude:.4}: {:.3} from west to east, {:.3} from north to south", spacing[0], spacing[1]);
    Ok((spacing, note))
}
