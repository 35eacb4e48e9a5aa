//! What fractals compute with: plain values, values with their slopes, and bounds of both.
//!
//! A fractal's recurrence is written once over [`Number`]; with bounds in place of values it proves what values and slopes it can have.

use super::{Lanes, lanes::Plain};

/// A number of a fractal's recurrence, one a lane.
pub(super) trait Number<L: Lanes>: Copy {
    fn constant(lanes: L, value: f32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn squared(self) -> Self;
    fn raised(self, lanes: L, by: f32) -> Self;
    fn scaled(self, lanes: L, by: f32) -> Self;
    fn below(self, lanes: L, bound: f32) -> Self;
    fn abs(self, lanes: L) -> Self;
    fn at_most(self, lanes: L, bound: f32) -> Self;
    fn interpolated(self, lanes: L, table: &Table) -> Self;
}

/// Intervals of a table.
pub(super) const INTERVALS: usize = 16;

/// A function of one number by straight lines between equidistant places; beyond them the outer lines go on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Table {
    low: f32,
    /// Intervals a unit.
    density: f32,
    values: [f32; INTERVALS],
    /// How much the function grows in each interval.
    steps: [f32; INTERVALS],
}

impl Table {
    /// From the function's values at `low`, …, `high`.
    pub(super) fn new(low: f64, high: f64, at: impl Fn(f64) -> f64) -> Self {
        let nodes: [f64; INTERVALS + 1] = core::array::from_fn(|i| at(low + (high - low) * i as f64 / INTERVALS as f64));
        let values = core::array::from_fn(|i| nodes[i] as f32);
        let steps = core::array::from_fn(|i| (nodes[i + 1] as f32) - (nodes[i] as f32));
        Self { low: low as f32, density: (INTERVALS as f64 / (high - low)) as f32, values, steps }
    }

    /// The value, and the slope of the line it lies on.
    #[inline(always)]
    fn look<L: Lanes>(&self, lanes: L, x: L::Floats) -> [L::Floats; 2] {
        let at = (x - lanes.splat(self.low)) * lanes.splat(self.density);
        let index = lanes.truncate(lanes.smaller(lanes.larger(at, lanes.splat(0.0)), lanes.splat((INTERVALS - 1) as f32)));
        let step = lanes.lookup16(&self.steps, index);
        let value = lanes.lookup16(&self.values, index) + (at - lanes.convert(index)) * step;
        [value, step * lanes.splat(self.density)]
    }

    /// The function at a point, but for rounding.
    pub(super) fn at(&self, x: f64) -> f64 {
        let at = (x - f64::from(self.low)) * f64::from(self.density);
        let index = at.clamp(0.0, (INTERVALS - 1) as f64) as usize;
        f64::from(self.values[index]) + (at - index as f64) * f64::from(self.steps[index])
    }
}

/// Values.
#[derive(Clone, Copy)]
pub(super) struct Real<L: Lanes>(pub L::Floats);

impl<L: Lanes> Number<L> for Real<L> {
    #[inline(always)]
    fn constant(lanes: L, value: f32) -> Self {
        Self(lanes.splat(value))
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    #[inline(always)]
    fn squared(self) -> Self {
        Self(self.0 * self.0)
    }

    #[inline(always)]
    fn raised(self, lanes: L, by: f32) -> Self {
        Self(self.0 + lanes.splat(by))
    }

    #[inline(always)]
    fn scaled(self, lanes: L, by: f32) -> Self {
        Self(self.0 * lanes.splat(by))
    }

    #[inline(always)]
    fn below(self, lanes: L, bound: f32) -> Self {
        Self(lanes.splat(bound) - self.0)
    }

    #[inline(always)]
    fn abs(self, lanes: L) -> Self {
        Self(lanes.abs(self.0))
    }

    #[inline(always)]
    fn at_most(self, lanes: L, bound: f32) -> Self {
        Self(lanes.smaller(self.0, lanes.splat(bound)))
    }

    #[inline(always)]
    fn interpolated(self, lanes: L, table: &Table) -> Self {
        Self(table.look(lanes, self.0)[0])
    }
}

/// Values with their slopes in two directions.
#[derive(Clone, Copy)]
pub(super) struct Dual<L: Lanes> {
    pub value: L::Floats,
    pub slopes: [L::Floats; 2],
}

impl<L: Lanes> Number<L> for Dual<L> {
    #[inline(always)]
    fn constant(lanes: L, value: f32) -> Self {
        Self { value: lanes.splat(value), slopes: [lanes.splat(0.0); 2] }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        let ([du, dv], [other_du, other_dv]) = (self.slopes, other.slopes);
        Self { value: self.value + other.value, slopes: [du + other_du, dv + other_dv] }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        let ([du, dv], [other_du, other_dv]) = (self.slopes, other.slopes);
        Self { value: self.value - other.value, slopes: [du - other_du, dv - other_dv] }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let ([du, dv], [other_du, other_dv]) = (self.slopes, other.slopes);
        let slopes = [du * other.value + self.value * other_du, dv * other.value + self.value * other_dv];
        Self { value: self.value * other.value, slopes }
    }

    #[inline(always)]
    fn squared(self) -> Self {
        self.times(self)
    }

    #[inline(always)]
    fn raised(self, lanes: L, by: f32) -> Self {
        Self { value: self.value + lanes.splat(by), ..self }
    }

    #[inline(always)]
    fn scaled(self, lanes: L, by: f32) -> Self {
        let by = lanes.splat(by);
        Self { value: self.value * by, slopes: [self.slopes[0] * by, self.slopes[1] * by] }
    }

    #[inline(always)]
    fn below(self, lanes: L, bound: f32) -> Self {
        let zero = lanes.splat(0.0);
        Self { value: lanes.splat(bound) - self.value, slopes: [zero - self.slopes[0], zero - self.slopes[1]] }
    }

    #[inline(always)]
    fn abs(self, lanes: L) -> Self {
        let sign = lanes.to_words(self.value) & lanes.splat_words(0x8000_0000);
        let [du, dv] = [lanes.to_words(self.slopes[0]), lanes.to_words(self.slopes[1])];
        Self { value: lanes.abs(self.value), slopes: [lanes.to_floats(du ^ sign), lanes.to_floats(dv ^ sign)] }
    }

    #[inline(always)]
    fn at_most(self, lanes: L, bound: f32) -> Self {
        let bound = lanes.splat(bound);
        let ([du, dv], zero) = (self.slopes, lanes.splat(0.0));
        let slopes = [lanes.where_less(bound, self.value, zero, du), lanes.where_less(bound, self.value, zero, dv)];
        Self { value: lanes.smaller(self.value, bound), slopes }
    }

    #[inline(always)]
    fn interpolated(self, lanes: L, table: &Table) -> Self {
        let [value, slope] = table.look(lanes, self.value);
        Self { value, slopes: [slope * self.slopes[0], slope * self.slopes[1]] }
    }
}

/// Bounds of a value and of the magnitudes of its slopes, widened by each operation for its rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    pub low: f64,
    pub high: f64,
    pub slope: f64,
}

impl Bound {
    pub(super) fn new(low: f64, high: f64, slope: f64) -> Self {
        // Some ulps of f32, and what underflows.
        let margin = low.abs().max(high.abs()) * 3e-7 + 1e-37;
        Self { low: low - margin, high: high + margin, slope: slope * (1.0 + 1e-6) }
    }

    fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }
}

/// 0 · ∞ is 0 here: a factor that is zero holds however great the other is.
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Number<Plain<1>> for Bound {
    fn constant(_: Plain<1>, value: f32) -> Self {
        Self { low: value.into(), high: value.into(), slope: 0.0 }
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.low + other.low, self.high + other.high, self.slope + other.slope)
    }

    fn minus(self, other: Self) -> Self {
        Self::new(self.low - other.high, self.high - other.low, self.slope + other.slope)
    }

    fn times(self, other: Self) -> Self {
        let corners = [product(self.low, other.low), product(self.low, other.high), product(self.high, other.low), product(self.high, other.high)];
        let (low, high) = corners.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        Self::new(low, high, product(self.slope, other.magnitude()) + product(self.magnitude(), other.slope))
    }

    fn squared(self) -> Self {
        let (low, high) = (self.low * self.low, self.high * self.high);
        let least = if self.low < 0.0 && self.high > 0.0 { 0.0 } else { low.min(high) };
        Self::new(least, low.max(high), 2.0 * product(self.magnitude(), self.slope))
    }

    fn raised(self, lanes: Plain<1>, by: f32) -> Self {
        self.plus(Self::constant(lanes, by))
    }

    fn scaled(self, lanes: Plain<1>, by: f32) -> Self {
        self.times(Self::constant(lanes, by))
    }

    fn below(self, lanes: Plain<1>, bound: f32) -> Self {
        Self::constant(lanes, bound).minus(self)
    }

    fn abs(self, _: Plain<1>) -> Self {
        let least = if self.low < 0.0 && self.high > 0.0 { 0.0 } else { self.low.abs().min(self.high.abs()) };
        Self { low: least, high: self.magnitude(), slope: self.slope }
    }

    fn at_most(self, _: Plain<1>, bound: f32) -> Self {
        Self { low: self.low.min(bound.into()), high: self.high.min(bound.into()), slope: self.slope }
    }

    fn interpolated(self, _: Plain<1>, table: &Table) -> Self {
        let inner = (1..INTERVALS).map(|i| f64::from(table.low) + i as f64 / f64::from(table.density)).filter(|x| (self.low..self.high).contains(x));
        let values = inner.chain([self.low, self.high]).map(|x| table.at(x));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let steepest = table.steps.iter().fold(0.0_f32, |steepest, step| steepest.max(step.abs()));
        Self::new(low, high, product(self.slope, f64::from(steepest * table.density)))
    }
}
