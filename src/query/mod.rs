//! Questions about a world's ground.

mod elevation;

pub use elevation::{PointElevation, elevation};
