//! The ground at many points, and along lines.

use super::{
    PointElevation,
    elevation::{at, point},
};
use crate::{
    geometry::{Stop, Window, WindowError},
    world::World,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Why the ground at many points is not answered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// A point is beyond the plane, or the spacing is none.
    #[error("point {index}: {error}")]
    Point {
        /// Its place in the list.
        index: usize,
        /// What is wrong with it.
        error: WindowError,
    },
    /// They would take longer than allowed.
    #[error("these points would take this world more than {seconds} s: ask for fewer, or for such as lie closer together")]
    Costly {
        /// What is allowed.
        seconds: f64,
    },
    /// They were no longer wanted.
    #[error("it was stopped")]
    Stopped,
}

/// The ground at points of the plane in their order, on all threads of the present rayon pool, each as [`super::elevation`] has it; `limit_ns` is how much predicted time
/// they may take together, what is already at hand counted as free.
///
/// # Errors
/// If a point cannot be evaluated, all together take too long, or `stop` is set.
pub fn elevations(world: &World, points: &[[f64; 2]], spacing: Option<f64>, limit_ns: f64, stop: &Stop) -> Result<Vec<PointElevation>, BatchError> {
    let windows = points.iter().enumerate().map(|(index, &[x, y])| point(x, y, spacing).map_err(|error| BatchError::Point { index, error }));
    let windows: Vec<Window> = windows.collect::<Result<_, _>>()?;
    let spent = AtomicU64::new(0);
    let evaluate = |window: &Window| {
        if stop.is_set() {
            return Err(BatchError::Stopped);
        }
        let cost_ns = world.cost_ns(window) as u64;
        let is_costly = (spent.fetch_add(cost_ns, Ordering::Relaxed) + cost_ns) as f64 > limit_ns;
        if is_costly { Err(BatchError::Costly { seconds: limit_ns / 1e9 }) } else { Ok(at(world, window)) }
    };
    windows.par_iter().map(evaluate).collect()
}

/// `count` points at equal distances along a line through corners, from its first to its last, and their distances from the first, all in metres.
///
/// ```
/// let (points, distances) = terrane::query::along(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0]], 3);
/// assert_eq!((points, distances), (vec![[0.0, 0.0], [2.0, 0.0], [3.0, 1.0]], vec![0.0, 2.0, 4.0]));
/// ```
#[must_use]
pub fn along(corners: &[[f64; 2]], count: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
    let ends = corners.windows(2).scan(0.0, |end, edge| {
        *end += libm::hypot(edge[1][0] - edge[0][0], edge[1][1] - edge[0][1]);
        Some(*end)
    });
    let ends: Vec<f64> = ends.collect();
    let (length, last) = (ends.last().copied().unwrap_or(0.0), count.saturating_sub(1).max(1));
    let distances: Vec<f64> = (0..count).map(|i| length * i as f64 / last as f64).collect();
    let place = |&distance: &f64| {
        let edge = ends.partition_point(|&end| end < distance).min(ends.len().saturating_sub(1));
        let start = if edge == 0 { 0.0 } else { ends[edge - 1] };
        let (from, to) = (corners[edge], corners[(edge + 1).min(corners.len() - 1)]);
        let part = if ends.get(edge).is_some_and(|&end| end > start) { (distance - start) / (ends[edge] - start) } else { 0.0 };
        // The ends are the corners to the bit.
        if part >= 1.0 { to } else { [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part) }
    };
    let points = if corners.is_empty() { Vec::new() } else { distances.iter().map(place).collect() };
    (points, distances)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{query::elevation, world::Document};

    fn world() -> World {
        World::new(Document::parse(br#"{"seed":1,"base":{"programme":"fbm(1, 2, 8)","scale":900}}"#).expect("valid"))
    }

    #[test]
    fn many_points_are_as_each_alone_whatever_the_threads() {
        let (world, points) = (world(), along(&[[-5000.0, 3.0], [700.0, 9000.0], [700.0, -2.5]], 333).0);
        let alone: Vec<_> = points.iter().map(|&[x, y]| elevation(&world, x, y, Some(30.0)).expect("on the plane")).collect();
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            assert_eq!(pool.install(|| elevations(&world, &points, Some(30.0), 1e10, &Stop::never())), Ok(alone.clone()));
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let (world, stop) = (world(), Stop::new());
        let ask = |points: &[[f64; 2]], limit_ns| elevations(&world, points, None, limit_ns, &stop);
        assert_eq!(ask(&[[0.0, 0.0], [1e13, 0.0]], 1e10).expect_err("beyond").to_string(), format!("point 1: {}", WindowError::Far(1e13)));
        assert_eq!(ask(&[[0.0, 0.0]; 100], 1.0), Err(BatchError::Costly { seconds: 1e-9 }));
        stop.set();
        assert_eq!(ask(&[[0.0, 0.0]], 1e10), Err(BatchError::Stopped));
    }

    #[test]
    fn a_line_is_divided_from_end_to_end() {
        let (points, distances) = along(&[[0.1, 0.2], [0.1, 0.2], [7.3, 0.2]], 4);
        assert_eq!((points[0], points[3], distances[0]), ([0.1, 0.2], [7.3, 0.2], 0.0));
        assert!((distances[3] - 7.2).abs() < 1e-12 && points.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{points:?}");
        assert_eq!(along(&[[1.0, 2.0]], 2).0, [[1.0, 2.0]; 2], "a point is a short line");
    }
}
