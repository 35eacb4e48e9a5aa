//! What attributes say over a block, and how it is merged: [`Term`] and the reference, many points at a time.

use super::{
    Mix, Side,
    block::{POINTS, Values},
    term::{Channel, Curve, Term},
};
use crate::noise::{Kernel, Lanes};

/// The values of an attribute over a block.
pub(super) enum Input<'a> {
    /// The elevation of the shape.
    Elevation,
    /// Lines of a profile: the value before the first, and of each line its rise, its beginning and one over its length.
    Profile(f64, &'a [[f64; 3]]),
    /// One number a point.
    Values(&'a Values),
    /// One number a point, times the second, more than the first; over the elevation of the shape if wanted.
    Terrain(&'a Values, [f64; 2], bool),
    /// Numbers.
    Numbers(&'a [f64]),
    /// Nothing but the weight matters.
    Name,
}

/// Sums of one stage of a field.
pub(super) struct Sums {
    pub weight: Box<Values>,
    /// Of weights times values, one a component.
    pub values: Vec<Box<Values>>,
    /// The largest weight, coverage of level 0, or strength of a channel.
    pub most: Box<Values>,
}

/// Adds a term to sums.
pub(super) struct Add<'a> {
    pub term: &'a Term<'a>,
    pub signed: &'a Values,
    pub elevation: &'a Values,
    pub parts: &'a [[usize; 2]],
    /// The values of a custom weight, where it is asked for.
    pub custom: Option<&'a Values>,
    pub input: Input<'a>,
    /// Whether the stage is a level above 0, of which the largest weight counts.
    pub upper: bool,
    pub sums: &'a mut Sums,
}

impl Kernel for Add<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { term, signed, elevation, parts, custom, input, upper, sums } = self;
        let zero = lanes.splat_doubles(0.0);
        for &[start, count] in parts {
            for i in (start..start + count).step_by(L::WIDTH) {
                let s = lanes.load_doubles(&signed.0[i..]);
                let d = match term.attribute.side {
                    Side::Inside => lanes.larger_doubles(zero, s),
                    Side::Outside => lanes.larger_doubles(zero, zero - s),
                    Side::Edge => lanes.larger_doubles(s, zero - s),
                };
                let custom = if let Some(custom) = custom { lanes.load_doubles(&custom.0[i..]) } else { zero };
                let gain = lanes.splat_doubles(term.gain);
                let weight = match &term.channel {
                    None => weight_at(lanes, term, d, custom) * gain,
                    Some(channel) => channel_weight(lanes, channel, d) * gain,
                };
                grow(lanes, &mut sums.weight, i, weight);
                if matches!(input, Input::Name) {
                    continue;
                }
                let most = match &term.channel {
                    Some(channel) => {
                        let d = lanes.larger_doubles(zero, d - lanes.splat_doubles(channel.half_width));
                        let strength = weight_at(lanes, term, d, custom) * lanes.splat_doubles(channel.inverse_first);
                        lanes.smaller_doubles(lanes.splat_doubles(1.0), strength) * gain
                    }
                    None if upper => weight,
                    None => coverage(lanes, term, d) * gain,
                };
                let most = lanes.where_less_doubles(zero, weight, most, zero);
                let before = lanes.load_doubles(&sums.most.0[i..]);
                lanes.store_doubles(lanes.larger_doubles(before, most), &mut sums.most.0[i..]);
                for (k, values) in sums.values.iter_mut().enumerate() {
                    grow(lanes, values, i, weight * input.load(lanes, k, i, s, elevation));
                }
            }
        }
    }
}

impl Input<'_> {
    #[inline(always)]
    fn load<L: Lanes>(&self, lanes: L, component: usize, i: usize, signed: L::Doubles, elevation: &Values) -> L::Doubles {
        match self {
            Input::Elevation => lanes.load_doubles(&elevation.0[i..]),
            Input::Values(values) => lanes.load_doubles(&values.0[i..]),
            Input::Numbers(numbers) => lanes.splat_doubles(numbers[component]),
            Input::Name => lanes.splat_doubles(0.0),
            Input::Profile(first, lines) => {
                let mut value = lanes.splat_doubles(*first);
                for [rise, from, inverse] in *lines {
                    let u = (signed - lanes.splat_doubles(*from)) * lanes.splat_doubles(*inverse);
                    let u = lanes.smaller_doubles(lanes.larger_doubles(lanes.splat_doubles(0.0), u), lanes.splat_doubles(1.0));
                    value = value + lanes.splat_doubles(*rise) * u;
                }
                value
            }
            Input::Terrain(values, [datum, amplitude], over) => {
                let height = lanes.splat_doubles(*datum) + lanes.splat_doubles(*amplitude) * lanes.load_doubles(&values.0[i..]);
                if *over { lanes.load_doubles(&elevation.0[i..]) + height } else { height }
            }
        }
    }
}

/// Adds to sums.
#[inline(always)]
fn grow<L: Lanes>(lanes: L, sums: &mut Values, i: usize, by: L::Doubles) {
    let sum = lanes.load_doubles(&sums.0[i..]) + by;
    lanes.store_doubles(sum, &mut sums.0[i..]);
}

/// The weight without the gain.
#[inline(always)]
fn weight_at<L: Lanes>(lanes: L, term: &Term, d: L::Doubles, custom: L::Doubles) -> L::Doubles {
    let (zero, one) = (lanes.splat_doubles(0.0), lanes.splat_doubles(1.0));
    let inverse_range = lanes.splat_doubles(term.inverse_range);
    match term.curve {
        Curve::Linear => lanes.larger_doubles(zero, one - d * inverse_range),
        Curve::Sharp { width, nearest } => {
            let above = lanes.splat_doubles(width) * lanes.larger_doubles(zero, one - d * inverse_range);
            lanes.divide_doubles(above, lanes.larger_doubles(d, lanes.splat_doubles(nearest)))
        }
        Curve::Smooth { inverse_width } => {
            let (ratio, steep) = (d * inverse_range, d * lanes.splat_doubles(inverse_width));
            let square = ratio * ratio;
            lanes.larger_doubles(zero, lanes.divide_doubles(one - square * square, steep * steep + one))
        }
        Curve::Custom { range, .. } => {
            let above = lanes.larger_doubles(zero, custom);
            lanes.where_less_doubles(lanes.splat_doubles(range), d, zero, above)
        }
    }
}

#[inline(always)]
fn channel_weight<L: Lanes>(lanes: L, channel: &Channel, d: L::Doubles) -> L::Doubles {
    let above = lanes.larger_doubles(lanes.splat_doubles(0.0), lanes.splat_doubles(1.0) - d * lanes.splat_doubles(channel.inverse_reach));
    lanes.divide_doubles(above, lanes.larger_doubles(d, lanes.splat_doubles(channel.nearest)))
}

/// The coverage without the gain.
#[inline(always)]
fn coverage<L: Lanes>(lanes: L, term: &Term, d: L::Doubles) -> L::Doubles {
    let (start, fall) = (lanes.splat_doubles(term.coverage[0]), lanes.splat_doubles(term.coverage[1]));
    let u = lanes.smaller_doubles(lanes.larger_doubles(lanes.splat_doubles(0.0), start - d * fall), lanes.splat_doubles(1.0));
    u * u * (lanes.splat_doubles(3.0) - lanes.splat_doubles(2.0) * u)
}

/// One component of a field, merged over what is below.
pub(super) struct Merge<'a> {
    /// Stages in order; whether each is a level above 0.
    pub stages: &'a [(bool, &'a Sums)],
    pub component: usize,
    pub mix: Mix,
    /// Whether there is something below.
    pub below: bool,
    /// What is below; where there is nothing, 0.
    pub values: &'a mut Values,
}

impl Kernel for Merge<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { stages, component, mix, below, values } = self;
        let (zero, one) = (lanes.splat_doubles(0.0), lanes.splat_doubles(1.0));
        for i in (0..POINTS).step_by(L::WIDTH) {
            let mut value = lanes.load_doubles(&values.0[i..]);
            let mut there = if below { one } else { zero };
            for &(upper, sums) in stages {
                let weight = lanes.load_doubles(&sums.weight.0[i..]);
                let average = lanes.divide_doubles(lanes.load_doubles(&sums.values[component].0[i..]), weight);
                let share = if upper && mix == Mix::Sum { weight } else { lanes.load_doubles(&sums.most.0[i..]) };
                let mixed = value + (average - value) * lanes.smaller_doubles(share, one);
                let new = lanes.where_less_doubles(zero, there, mixed, average);
                value = lanes.where_less_doubles(zero, weight, new, value);
                there = lanes.where_less_doubles(zero, weight, one, there);
            }
            lanes.store_doubles(value, &mut values.0[i..]);
        }
    }
}
