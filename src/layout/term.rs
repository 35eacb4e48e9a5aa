//! What one attribute of one feature says at a distance: the plain definition.

use super::{Attribute, Expression, Role, Side, Value, Weight};

/// Numbers that smaller distances cannot divide by, in channels: see [`Weight::Sharp`].
const NEAREST: f64 = 0.001;

/// An attribute as samples of a spacing see it.
#[derive(Clone, Debug)]
pub(super) struct Term<'a> {
    pub attribute: &'a Attribute,
    pub curve: Curve<'a>,
    /// One over the range; 0 for an infinite one.
    pub inverse_range: f64,
    /// The coverage before it is smoothed is the first minus the distance times the second.
    pub coverage: [f64; 2],
    /// Share of its weight that an attribute keeps whose range the samples hardly see.
    pub gain: f64,
    pub channel: Option<Channel>,
}

/// A weight with its constants.
#[derive(Clone, Copy, Debug)]
pub(super) enum Curve<'a> {
    Linear,
    Sharp { width: f64, nearest: f64 },
    Smooth { inverse_width: f64 },
    Custom { expression: &'a Expression, range: f64 },
}

/// What makes a channel exact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    pub half_width: f64,
    /// One over the range and the half width.
    pub inverse_reach: f64,
    pub nearest: f64,
    /// One over the weight at 0.
    pub inverse_first: f64,
}

/// a > 0 ? a : 0, which makes 0 of what is not a number.
#[inline(always)]
pub(super) fn above_zero(a: f64) -> f64 {
    if a > 0.0 { a } else { 0.0 }
}

/// b < a ? b : a.
#[inline(always)]
pub(super) fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

impl<'a> Term<'a> {
    /// `spacing` is 0 for the function as it is.
    pub(super) fn new(attribute: &'a Attribute, spacing: f64) -> Self {
        let range = attribute.range;
        let fade = attribute.fade.unwrap_or(range / 4.0);
        let coverage = if range.is_finite() { [range / fade, 1.0 / fade] } else { [1.0, 0.0] };
        let curve = match &attribute.weight {
            Weight::Linear => Curve::Linear,
            Weight::Sharp { width, nearest } => Curve::Sharp { width: *width, nearest: nearest.max(spacing / 2.0) },
            Weight::Smooth { width } => Curve::Smooth { inverse_width: 1.0 / width },
            Weight::Custom(expression) => Curve::Custom { expression, range },
        };
        let mut term = Self { attribute, curve, inverse_range: 1.0 / range, coverage, gain: gain(attribute.reach(), spacing), channel: None };
        if let Role::Channel { half_width } = attribute.role {
            let first = term.curve_at(0.0);
            let inverse_first = if first > 0.0 { 1.0 / first } else { 0.0 };
            term.channel = Some(Channel { half_width, inverse_reach: 1.0 / (half_width + range), nearest: NEAREST.max(spacing / 2.0), inverse_first });
        }
        term
    }

    /// The distance that weights see.
    pub(super) fn distance(&self, signed: f64) -> f64 {
        match self.attribute.side {
            Side::Inside => above_zero(signed),
            Side::Outside => above_zero(-signed),
            Side::Edge => signed.abs(),
        }
    }

    fn curve_at(&self, d: f64) -> f64 {
        match self.curve {
            Curve::Linear => above_zero(1.0 - d * self.inverse_range),
            Curve::Sharp { width, nearest } => width * above_zero(1.0 - d * self.inverse_range) / if nearest > d { nearest } else { d },
            Curve::Smooth { inverse_width } => {
                let (ratio, steep) = (d * self.inverse_range, d * inverse_width);
                let square = ratio * ratio;
                above_zero((1.0 - square * square) / (steep * steep + 1.0))
            }
            Curve::Custom { expression, range } => {
                if d <= range {
                    above_zero(expression.at(d))
                } else {
                    0.0
                }
            }
        }
    }

    /// The weight in an average.
    pub(super) fn weight(&self, d: f64) -> f64 {
        match self.channel {
            None => self.curve_at(d) * self.gain,
            Some(channel) => {
                let nearest = if channel.nearest > d { channel.nearest } else { d };
                above_zero(1.0 - d * channel.inverse_reach) / nearest * self.gain
            }
        }
    }

    /// How much of what is below a level shows no more: 1 near the shape, 0 from the range on.
    pub(super) fn coverage(&self, d: f64) -> f64 {
        let u = lesser(above_zero(self.coverage[0] - d * self.coverage[1]), 1.0);
        u * u * (3.0 - 2.0 * u) * self.gain
    }

    /// How much a channel decides, 0 … 1.
    pub(super) fn strength(&self, channel: &Channel, d: f64) -> f64 {
        lesser(self.curve_at(above_zero(d - channel.half_width)) * channel.inverse_first, 1.0) * self.gain
    }

    /// The value of one component at a signed distance; of a terrain programme, its elevation there is given.
    pub(super) fn value(&self, component: usize, signed: f64, elevation: f64, terrain: f64) -> f64 {
        match &self.attribute.value {
            Value::Shape => elevation,
            Value::Number(number) => *number,
            Value::Vector(numbers) => numbers[component],
            Value::Name(_) => 0.0,
            Value::Profile(pairs) => profile(pairs, signed),
            Value::Expression(expression) => expression.at(signed),
            Value::Terrain(value) => {
                let height = value.datum + value.amplitude * terrain;
                if value.over_shape { elevation + height } else { height }
            }
        }
    }
}

/// Straight lines through points, constant beyond the ends: a sum over the lines, each of which is used up to its end.
fn profile(pairs: &[[f64; 2]], at: f64) -> f64 {
    let mut value = pairs[0][1];
    for [rise, from, inverse] in lines(pairs) {
        value += rise * lesser(above_zero((at - from) * inverse), 1.0);
    }
    value
}

/// Where an attribute that is a depth of water puts water, for the share of samples that it covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cover {
    /// Metres from the shape to the water's edge, on the side that the depth counts from.
    edge: f64,
    /// The other edge: of a line the same on its other side, else none.
    inner: f64,
    side: Side,
    /// Metres beyond which the feature says nothing.
    reach: f64,
    /// Half a sample and one over a whole one; 0 for samples without size.
    half: f64,
    inverse: f64,
    /// Share that a feature keeps whose reach the samples hardly see.
    gain: f64,
}

impl Cover {
    /// `None` if the attribute is no depth or never more than 0. `reach` is that of all the feature's attributes, `spacing` 0 for the function as it is.
    pub(super) fn new(attribute: &Attribute, reach: f64, is_line: bool, spacing: f64) -> Option<Self> {
        let edge = match &attribute.value {
            _ if *attribute.name != *"water_depth" => return None,
            Value::Profile(pairs) => dry_from(pairs)?.min(attribute.reach()),
            Value::Number(depth) if *depth <= 0.0 => return None,
            _ => attribute.reach(),
        };
        let inner = if is_line { -edge } else { f64::NEG_INFINITY };
        let inverse = if spacing > 0.0 { 1.0 / spacing } else { 0.0 };
        Some(Self { edge, inner, side: attribute.side, reach, half: spacing / 2.0, inverse, gain: gain(reach, spacing) })
    }

    /// The share of a sample that water covers, as if its edge were straight there.
    #[inline(always)]
    pub(super) fn share(&self, signed: f64) -> f64 {
        let d = match self.side {
            Side::Inside => signed,
            Side::Outside => -signed,
            Side::Edge => signed.abs(),
        };
        if d > self.reach {
            return 0.0;
        }
        if self.half == 0.0 {
            return if d < self.edge { 1.0 } else { 0.0 };
        }
        let (low, high) = (d - self.half, d + self.half);
        if self.inner == f64::NEG_INFINITY && high <= self.edge {
            return self.gain;
        }
        let low = if self.inner > low { self.inner } else { low };
        lesser(above_zero((lesser(high, self.edge) - low) * self.inverse), 1.0) * self.gain
    }
}

/// The distance from which on a depth is no more than 0; `None` if it is nowhere more.
fn dry_from(pairs: &[[f64; 2]]) -> Option<f64> {
    let last = pairs.iter().rposition(|pair| pair[1] > 0.0)?;
    let ([from, depth], Some([to, dry])) = (pairs[last], pairs.get(last + 1)) else { return Some(f64::INFINITY) };
    Some(from + (to - from) * (depth / (depth - dry)))
}

/// The share of its weight that something keeps whose reach samples of a spacing hardly see: all of it at two spacings, nothing at a quarter of one.
fn gain(reach: f64, spacing: f64) -> f64 {
    let seen = if spacing > 0.0 { lesser(above_zero((reach / spacing - 0.25) / 1.75), 1.0) } else { 1.0 };
    seen * seen * (3.0 - 2.0 * seen)
}

/// Rise, beginning and one over the length of every line.
#[inline(always)]
pub(super) fn lines(pairs: &[[f64; 2]]) -> impl Iterator<Item = [f64; 3]> + '_ {
    pairs.windows(2).map(|pair| [pair[1][1] - pair[0][1], pair[0][0], 1.0 / (pair[1][0] - pair[0][0])])
}
