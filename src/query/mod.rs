//! Questions about a world's ground.

mod batch;
mod elevation;

pub use batch::{BatchError, along, elevations};
pub use elevation::{PointElevation, elevation};
