//! The elevation of a point.

use crate::{
    geometry::{Filter, Wanted, Window, WindowError},
    world::World,
};

/// The ground at a point, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointElevation {
    /// Elevation of the ground, also under water.
    pub elevation: f32,
    /// Depth of the water above it, 0 on land.
    pub water_depth: f32,
}

/// The ground at plane coordinates: the function as it is, or as a tile with `spacing` metres a pixel sees it.
///
/// # Errors
/// If the spacing is not positive or the point lies beyond 2^40 m.
pub fn elevation(world: &World, x: f64, y: f64, spacing: Option<f64>) -> Result<PointElevation, WindowError> {
    Ok(at(world, &point(x, y, spacing)?))
}

/// The window of one sample.
pub(super) fn point(x: f64, y: f64, spacing: Option<f64>) -> Result<Window, WindowError> {
    match spacing {
        Some(spacing) => Window::point(x, y, spacing, Filter::Band),
        None => Window::point(x, y, 1.0, Filter::Exact),
    }
}

/// The ground at a window's first sample.
pub(super) fn at(world: &World, window: &Window) -> PointElevation {
    let ground = world.evaluate_with(window, Wanted { water: true, ..Wanted::default() });
    PointElevation { elevation: ground.elevation[0], water_depth: ground.water_depth[0] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Document;

    #[test]
    fn water_stands_up_to_the_sea_level() {
        let world = World::new(Document::parse(br#"{"seed":1,"sea_level":5,"base":{"programme":"x","scale":1,"amplitude":1}}"#).expect("valid"));
        assert_eq!(elevation(&world, 3.0, 0.0, None), Ok(PointElevation { elevation: 3.0, water_depth: 2.0 }));
        assert_eq!(elevation(&world, 8.0, 0.0, Some(10.0)), Ok(PointElevation { elevation: 8.0, water_depth: 0.0 }));
        assert_eq!(elevation(&world, 1e13, 0.0, None), Err(WindowError::Far(1e13)));
        assert_eq!(elevation(&world, 0.0, 0.0, Some(-1.0)), Err(WindowError::Spacing(-1.0)));
    }
}
