//! The terminals that are plain shapes: bell, plane, step and half sphere.
//!
//! Positions are f64, so that a shape keeps its form far from the origin; the value is rounded once. With `repeat`, a shape stands in the middle of every square
//! of that period.

use super::graph::Axis;
use crate::noise::elementary;

/// A compass direction as a unit vector to the east and to the north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Direction(pub [f64; 2]);

impl Direction {
    /// The direction of a name such as `ne`.
    pub(super) fn named(name: &str) -> Self {
        let component = |plus: char, minus: char| f64::from(i8::from(name.contains(plus)) - i8::from(name.contains(minus)));
        let (east, north) = (component('e', 'w'), component('n', 's'));
        let length = (east * east + north * north).sqrt();
        Self([east / length, north / length])
    }

    #[inline(always)]
    fn along(self, u: f64, v: f64) -> f64 {
        let [east, north] = self.0;
        // A component of 0 is left out: it must not turn an infinite coordinate into no number.
        if north == 0.0 {
            u * east
        } else if east == 0.0 {
            v * north
        } else {
            u * east + v * north
        }
    }
}

/// A shape in programme units. `repeat` 0 stands for one shape alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// exp(-r² / 2 w²).
    Gauss { width: f64, centre: [f64; 2], repeat: f64 },
    /// Rises by 1 a unit.
    Plane { direction: Direction },
    /// From 0 to 1 across the origin, as a smoothstep over `softness`; with `repeat` up and down again half a period later.
    Step { direction: Direction, softness: f64, repeat: f64 },
    /// √max(0, R² - r²).
    Sphere { radius: f64, centre: [f64; 2], repeat: f64 },
}

/// Places a side of a period that means are taken over.
const MEAN_PLACES: usize = 64;

impl Shape {
    /// Whether [`Filtered::slopes`] are those of calculus.
    pub(super) fn has_slopes(&self) -> bool {
        !matches!(self, Shape::Step { .. })
    }

    /// The one axis that the value depends on, if it depends on one alone.
    pub(super) fn axis(&self) -> Option<Axis> {
        let (Shape::Plane { direction } | Shape::Step { direction, .. }) = self else { return None };
        match direction.0 {
            [_, 0.0] => Some(Axis::U),
            [0.0, _] => Some(Axis::V),
            _ => None,
        }
    }

    fn repeat(&self) -> f64 {
        match *self {
            Shape::Gauss { repeat, .. } | Shape::Sphere { repeat, .. } | Shape::Step { repeat, .. } => repeat,
            Shape::Plane { .. } => 0.0,
        }
    }

    /// The shape as samples `spacing` programme units apart can carry it; a spacing of 0 leaves it as it is.
    ///
    /// A step is averaged over the spacing, a bell widened to the variance that it has when averaged, and what repeats fades to its mean where its period is
    /// below four spacings, to be gone at two.
    pub(super) fn filtered(self, spacing: f64) -> Filtered {
        let repeat = self.repeat();
        let mut filtered = Filtered { shape: self, spacing, height: 1.0, mean: 0.0, kept: 1.0 };
        if spacing <= 0.0 {
            return filtered;
        }
        if let Shape::Gauss { width, centre, repeat } = self {
            let variance = width * width + spacing * spacing / 12.0;
            filtered.height = width * width / variance;
            filtered.shape = Shape::Gauss { width: variance.sqrt(), centre, repeat };
        }
        if repeat > 0.0 {
            let cell = if matches!(self, Shape::Step { .. }) { repeat / 2.0 } else { repeat };
            let t = (cell / (2.0 * spacing) - 1.0).clamp(0.0, 1.0);
            (filtered.kept, filtered.mean) = (t * t * (3.0 - 2.0 * t), self.mean(repeat));
        }
        filtered
    }

    /// The mean over a period.
    fn mean(self, repeat: f64) -> f64 {
        let exact = self.filtered(0.0);
        let at = |i: usize| (i as f64 + 0.5) / MEAN_PLACES as f64 * repeat;
        let row = |j: usize| (0..MEAN_PLACES).map(|i| f64::from(exact.at(at(i), at(j)))).sum::<f64>();
        (0..MEAN_PLACES).map(row).sum::<f64>() / (MEAN_PLACES * MEAN_PLACES) as f64
    }

    /// The least and the greatest value.
    pub(super) fn range(&self) -> [f64; 2] {
        match *self {
            Shape::Gauss { .. } | Shape::Step { .. } => [0.0, 1.0],
            Shape::Plane { .. } => [f64::NEG_INFINITY, f64::INFINITY],
            Shape::Sphere { radius, .. } => [0.0, radius],
        }
    }

    /// The greatest slope along an axis.
    pub(super) fn max_slope(&self) -> f64 {
        match *self {
            // e^(-1/2) / w, at r = w.
            Shape::Gauss { width, .. } => 0.607 / width,
            Shape::Plane { .. } => 1.0,
            Shape::Step { softness, .. } => 1.5 / softness,
            Shape::Sphere { .. } => f64::INFINITY,
        }
    }
}

/// Positions that a function's values can be written at.
pub(super) trait Write {
    /// Answers how many were not finite.
    fn write(&self, out: &mut [f32], function: impl Fn(f64, f64) -> f32) -> u64;
}

/// A shape for samples of a given spacing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filtered {
    shape: Shape,
    spacing: f64,
    height: f64,
    mean: f64,
    kept: f64,
}

/// A coordinate relative to a centre, or to the nearest of its repetitions.
#[inline(always)]
fn relative(coordinate: f64, centre: f64, repeat: f64) -> f64 {
    let d = coordinate - centre;
    if repeat > 0.0 { d - repeat * (d / repeat + 0.5).floor() } else { d }
}

/// ∫ of the smoothstep from 0 to r.
#[inline(always)]
fn smoothstep_area(r: f64) -> f64 {
    let inside = r.clamp(0.0, 1.0);
    inside * inside * inside * (1.0 - 0.5 * inside) + (r - 1.0).max(0.0)
}

/// exp(-r² / 2 w²), rounded to f32.
#[inline(always)]
fn gauss(width: f64, centre: [f64; 2], repeat: f64, u: f64, v: f64) -> f64 {
    let (x, y) = (relative(u, centre[0], repeat), relative(v, centre[1], repeat));
    f64::from(elementary::exp(((x * x + y * y) / (-2.0 * width * width)) as f32))
}

#[inline(always)]
fn half_sphere(radius: f64, centre: [f64; 2], repeat: f64, u: f64, v: f64) -> f64 {
    let (x, y) = (relative(u, centre[0], repeat), relative(v, centre[1], repeat));
    (radius * radius - (x * x + y * y)).max(0.0).sqrt()
}

/// The distance across a step's edge; with a period, to the nearest edge, upwards where it rises.
#[inline(always)]
fn along_period(direction: Direction, repeat: f64, u: f64, v: f64) -> f64 {
    let t = direction.along(u, v);
    if repeat > 0.0 {
        let in_period = (t + repeat / 4.0) - repeat * ((t + repeat / 4.0) / repeat).floor();
        repeat / 4.0 - (in_period - repeat / 2.0).abs()
    } else {
        t
    }
}

/// A step at 0, averaged over the spacing.
#[inline(always)]
fn step(t: f64, softness: f64, spacing: f64) -> f64 {
    match (softness > 0.0, spacing > 0.0) {
        (false, false) => f64::from(u8::from(t >= 0.0)),
        (false, true) => (t / spacing + 0.5).clamp(0.0, 1.0),
        (true, false) => {
            let r = (t / softness + 0.5).clamp(0.0, 1.0);
            r * r * (3.0 - 2.0 * r)
        }
        (true, true) => {
            let area = |t: f64| smoothstep_area(t / softness + 0.5);
            // Nothing changes farther from the edge, where the difference of large areas would be a little more than 1.
            let t = t.clamp(-0.5 * (softness + spacing), 0.5 * (softness + spacing));
            ((area(t + spacing / 2.0) - area(t - spacing / 2.0)) * (softness / spacing)).clamp(0.0, 1.0)
        }
    }
}

impl Filtered {
    /// The value at programme coordinates.
    #[inline(always)]
    pub(super) fn at(&self, u: f64, v: f64) -> f32 {
        self.filtered(match self.shape {
            Shape::Gauss { width, centre, repeat } => self.height * gauss(width, centre, repeat, u, v),
            Shape::Plane { direction } => direction.along(u, v),
            Shape::Step { direction, softness, repeat } => step(along_period(direction, repeat, u, v), softness, self.spacing),
            Shape::Sphere { radius, centre, repeat } => half_sphere(radius, centre, repeat, u, v),
        })
    }

    /// Has its values written by a function for the kind of shape alone, so that a loop over it does not ask which it is; how many were not finite.
    pub(super) fn write(&self, to: &impl Write, out: &mut [f32]) -> u64 {
        // By value, so that loops know that nothing of it changes.
        let it = *self;
        match it.shape {
            Shape::Gauss { width, centre, repeat } => to.write(out, move |u, v| it.filtered(it.height * gauss(width, centre, repeat, u, v))),
            Shape::Plane { direction } => to.write(out, move |u, v| it.filtered(direction.along(u, v))),
            Shape::Step { direction, softness, repeat } => {
                to.write(out, move |u, v| it.filtered(step(along_period(direction, repeat, u, v), softness, it.spacing)))
            }
            Shape::Sphere { radius, centre, repeat } => to.write(out, move |u, v| it.filtered(half_sphere(radius, centre, repeat, u, v))),
        }
    }

    /// As much of a value as the spacing carries.
    #[inline(always)]
    fn filtered(&self, value: f64) -> f32 {
        (self.mean + self.kept * (value - self.mean)) as f32
    }

    /// The derivative along an axis.
    #[inline(always)]
    pub(super) fn slope(&self, axis: Axis, u: f64, v: f64) -> f32 {
        let along = |x: f64, y: f64| if axis == Axis::U { x } else { y };
        let slope = match self.shape {
            Shape::Gauss { width, centre, repeat } => {
                let (x, y) = (relative(u, centre[0], repeat), relative(v, centre[1], repeat));
                -along(x, y) / (width * width) * (self.height * gauss(width, centre, repeat, u, v))
            }
            Shape::Plane { direction } => along(direction.0[0], direction.0[1]),
            Shape::Sphere { radius, centre, repeat } => {
                let (x, y) = (relative(u, centre[0], repeat), relative(v, centre[1], repeat));
                let inside = radius * radius - (x * x + y * y);
                if inside > 0.0 { -along(x, y) / inside.sqrt() } else { 0.0 }
            }
            Shape::Step { .. } => 0.0,
        };
        (self.kept * slope) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_what_the_paper_says() {
        let at = |shape: Shape, u, v| shape.filtered(0.0).at(u, v);
        let gauss = Shape::Gauss { width: 2.0, centre: [1.0, -1.0], repeat: 0.0 };
        assert_eq!(at(gauss, 1.0, -1.0), 1.0);
        assert!((at(gauss, 3.0, -1.0) - (-0.5_f32).exp()).abs() < 1e-6);
        let plane = |name| Shape::Plane { direction: Direction::named(name) };
        assert_eq!([at(plane("n"), 5.0, 3.0), at(plane("w"), 5.0, 3.0)], [3.0, -5.0]);
        assert!((at(plane("se"), 1.0, -1.0) - core::f32::consts::SQRT_2).abs() < 1e-6);
        let step = |softness, repeat| Shape::Step { direction: Direction::named("e"), softness, repeat };
        assert_eq!([-0.1, 0.0, 0.1].map(|u| at(step(0.0, 0.0), u, 9.0)), [0.0, 1.0, 1.0]);
        assert_eq!([-1.0, -0.5, 0.0, 0.5].map(|u| at(step(1.0, 0.0), u, 9.0)), [0.0, 0.0, 0.5, 1.0]);
        assert_eq!([0.5, 1.5, 2.5, -0.5].map(|u| at(step(0.0, 2.0), u, 9.0)), [1.0, 0.0, 1.0, 0.0]);
        let sphere = Shape::Sphere { radius: 5.0, centre: [0.0, 0.0], repeat: 20.0 };
        assert_eq!([at(sphere, 3.0, 0.0), at(sphere, 17.0, 40.0), at(sphere, 10.0, 10.0)], [4.0, 4.0, 0.0]);
    }

    /// The mean over 10 periods stays as detail is filtered away, and an edge is as wide as a sample.
    #[test]
    fn filtered_shapes_keep_their_mean() {
        let shapes = [
            Shape::Gauss { width: 0.11, centre: [0.2, 0.3], repeat: 1.0 },
            Shape::Step { direction: Direction::named("n"), softness: 0.0, repeat: 1.0 },
            Shape::Step { direction: Direction::named("w"), softness: 0.2, repeat: 1.0 },
            Shape::Sphere { radius: 0.4, centre: [0.0, 0.0], repeat: 1.0 },
        ];
        for shape in shapes {
            let mean = |spacing: f64| {
                let filtered = shape.filtered(spacing);
                let places = || (0..503).map(|i| f64::from(i) * 10.0 / 503.0);
                places().flat_map(|v| places().map(move |u| (u, v))).map(|(u, v)| f64::from(filtered.at(u, v))).sum::<f64>() / (503.0 * 503.0)
            };
            let exact = mean(0.0);
            for spacing in [0.02, 0.07, 0.15, 0.3, 0.45, 0.6, 5.0] {
                assert!((mean(spacing) - exact).abs() < 0.01, "{shape:?} at {spacing}: {} is not {exact}", mean(spacing));
            }
        }
        let far = Shape::Step { direction: Direction::named("e"), softness: 3.0, repeat: 0.0 }.filtered(0.07);
        assert_eq!([-519_000.1, -1.6, 0.0, 1.6, 519_000.1].map(|u| far.at(u, 0.0)), [0.0, 0.0, 0.5, 1.0, 1.0]);
        let edge = Shape::Step { direction: Direction::named("e"), softness: 0.0, repeat: 0.0 }.filtered(2.0);
        assert_eq!([-1.0, 0.0, 0.5, 1.0].map(|u| edge.at(u, 0.0)), [0.0, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn slopes_are_derivatives() {
        let shapes = [
            Shape::Gauss { width: 0.7, centre: [0.2, 0.3], repeat: 3.0 },
            Shape::Plane { direction: Direction::named("nw") },
            Shape::Sphere { radius: 3.0, centre: [0.0, 0.5], repeat: 0.0 },
        ];
        for filtered in shapes.map(|shape| shape.filtered(0.05)) {
            for (u, v) in [(0.3, 0.4), (-0.9, 1.1), (1.3, -0.2)] {
                let d = 1e-3;
                let east = f64::from(filtered.at(u + d, v) - filtered.at(u - d, v)) / (2.0 * d);
                let north = f64::from(filtered.at(u, v + d) - filtered.at(u, v - d)) / (2.0 * d);
                assert!((f64::from(filtered.slope(Axis::U, u, v)) - east).abs() < 1e-3, "{filtered:?}");
                assert!((f64::from(filtered.slope(Axis::V, u, v)) - north).abs() < 1e-3, "{filtered:?}");
            }
        }
    }
}
