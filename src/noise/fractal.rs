//! How octaves become one value: fractals after F. K. Musgrave (Ebert et al., *Texturing and Modeling*, 3rd edition, chapter 16), step by step.
//!
//! What a spacing cannot carry of an octave is replaced by its mean contribution. Where all octaves from one on are left out whole, their mean is a function of
//! what the octaves before left behind: a constant, or a [`Table`] over the opening.

use super::{
    Lanes,
    number::{Number, Real, Table},
};

/// What goes from octave to octave.
#[derive(Clone, Copy)]
pub(super) struct State<N> {
    pub value: N,
    /// How far the next octave is opened, in shapes that open octaves.
    pub opening: N,
}

impl<L: Lanes> State<Real<L>> {
    /// The state of a vector of samples, as far as a step uses it.
    #[inline(always)]
    pub(super) fn load<S: Step>(lanes: L, values: &[f32], openings: &[f32]) -> Self {
        Self { value: Real(lanes.load(values)), opening: Real(if S::OPENS { lanes.load(openings) } else { lanes.splat(1.0) }) }
    }

    #[inline(always)]
    pub(super) fn store<S: Step>(self, lanes: L, values: &mut [f32], openings: &mut [f32]) {
        lanes.store(self.value.0, values);
        if S::OPENS {
            lanes.store(self.opening.0, openings);
        }
    }
}

/// An octave's step from state to state, given its noise.
pub(super) trait Step: Copy {
    /// Whether it uses the opening.
    const OPENS: bool;

    fn after<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, before: State<N>) -> State<N>;
}

/// v + n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Add;

/// v + |n|.
#[derive(Clone, Copy, Debug)]
pub(super) struct AddAbsolute;

/// v (base + n).
#[derive(Clone, Copy, Debug)]
pub(super) struct Multiply {
    pub base: f32,
}

/// s = (offset - |n|)² · opening: v + s · weight, opening = min(gain · s, 1), gain ≥ 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ridge {
    pub offset: f32,
    pub gain: f32,
    pub weight: f32,
}

/// s = (n + level) · opening: v + s · weight, opening = min(gain · s, 1).
#[derive(Clone, Copy, Debug)]
pub(super) struct Hybrid {
    pub level: f32,
    pub gain: f32,
    pub weight: f32,
}

/// An octave that opens the next and that the spacing does not carry whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<S> {
    pub step: S,
    /// How much the spacing carries.
    pub carried: f32,
    /// The mean signal of a whole opening.
    pub mean_signal: f32,
    /// The mean opening of the next octave, over this one's.
    pub mean_opening: Table,
}

impl Step for Add {
    const OPENS: bool = false;

    #[inline(always)]
    fn after<L: Lanes, N: Number<L>>(&self, _: L, noise: N, before: State<N>) -> State<N> {
        State { value: before.value.plus(noise), ..before }
    }
}

impl Step for AddAbsolute {
    const OPENS: bool = false;

    #[inline(always)]
    fn after<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, before: State<N>) -> State<N> {
        State { value: before.value.plus(noise.abs(lanes)), ..before }
    }
}

impl Step for Multiply {
    const OPENS: bool = false;

    #[inline(always)]
    fn after<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, before: State<N>) -> State<N> {
        State { value: before.value.times(noise.raised(lanes, self.base)), ..before }
    }
}

/// A step by a signal that opens the next octave.
pub(super) trait Opening: Copy {
    /// The signal of a noise for an opening.
    fn signal<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, opening: N) -> N;
    /// What it opens.
    fn opened<L: Lanes, N: Number<L>>(&self, lanes: L, signal: N) -> N;
    fn weight(&self) -> f32;
}

impl Opening for Ridge {
    #[inline(always)]
    fn signal<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, opening: N) -> N {
        noise.abs(lanes).below(lanes, self.offset).squared().times(opening)
    }

    #[inline(always)]
    fn opened<L: Lanes, N: Number<L>>(&self, lanes: L, signal: N) -> N {
        signal.scaled(lanes, self.gain).at_most(lanes, 1.0)
    }

    #[inline(always)]
    fn weight(&self) -> f32 {
        self.weight
    }
}

impl Opening for Hybrid {
    #[inline(always)]
    fn signal<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, opening: N) -> N {
        noise.raised(lanes, self.level).times(opening)
    }

    #[inline(always)]
    fn opened<L: Lanes, N: Number<L>>(&self, lanes: L, signal: N) -> N {
        signal.scaled(lanes, self.gain).at_most(lanes, 1.0)
    }

    #[inline(always)]
    fn weight(&self) -> f32 {
        self.weight
    }
}

/// An opening step of an octave that is carried whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole<S>(pub S);

impl<S: Opening> Step for Whole<S> {
    const OPENS: bool = true;

    #[inline(always)]
    fn after<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, before: State<N>) -> State<N> {
        let signal = self.0.signal(lanes, noise, before.opening);
        State { value: before.value.plus(signal.scaled(lanes, self.0.weight())), opening: self.0.opened(lanes, signal) }
    }
}

impl<S: Opening> Step for Part<S> {
    const OPENS: bool = true;

    #[inline(always)]
    fn after<L: Lanes, N: Number<L>>(&self, lanes: L, noise: N, before: State<N>) -> State<N> {
        let whole = self.step.signal(lanes, noise, before.opening);
        let open = self.step.opened(lanes, whole);
        let (left_out, left_open) = (before.opening.scaled(lanes, self.mean_signal), before.opening.interpolated(lanes, &self.mean_opening));
        let signal = left_out.plus(whole.minus(left_out).scaled(lanes, self.carried));
        State { value: before.value.plus(signal.scaled(lanes, self.step.weight())), opening: left_open.plus(open.minus(left_open).scaled(lanes, self.carried)) }
    }
}

/// Any step.
#[derive(Clone, Debug)]
pub(super) enum AnyStep {
    Add(Add),
    AddAbsolute(AddAbsolute),
    Multiply(Multiply),
    Ridge(Whole<Ridge>),
    Hybrid(Whole<Hybrid>),
    RidgePart(Box<Part<Ridge>>),
    HybridPart(Box<Part<Hybrid>>),
}

/// Steps of one kind.
#[derive(Clone, Debug)]
pub(super) enum Steps {
    Add(Vec<Add>),
    AddAbsolute(Vec<AddAbsolute>),
    Multiply(Vec<Multiply>),
    Ridge(Vec<Whole<Ridge>>),
    Hybrid(Vec<Whole<Hybrid>>),
}

impl Steps {
    /// Those of the first's kind at the beginning; none if octaves of the first's kind are better taken alone.
    pub(super) fn leading<'a>(steps: impl Iterator<Item = &'a AnyStep> + Clone) -> Self {
        macro_rules! collect {
            ($kind:ident) => {
                Steps::$kind(steps.map_while(|step| if let AnyStep::$kind(step) = step { Some(*step) } else { None }).collect())
            };
        }
        match steps.clone().next() {
            Some(AnyStep::AddAbsolute(_)) => collect!(AddAbsolute),
            Some(AnyStep::Multiply(_)) => collect!(Multiply),
            Some(AnyStep::Ridge(_)) => collect!(Ridge),
            Some(AnyStep::Hybrid(_)) => collect!(Hybrid),
            _ => collect!(Add),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Steps::Add(steps) => steps.len(),
            Steps::AddAbsolute(steps) => steps.len(),
            Steps::Multiply(steps) => steps.len(),
            Steps::Ridge(steps) => steps.len(),
            Steps::Hybrid(steps) => steps.len(),
        }
    }
}

/// Evaluates an expression with a step of its own type, so that it is compiled for each.
macro_rules! with_step {
    ($any:expr, $step:ident => $body:expr) => {
        match $any {
            $crate::noise::fractal::AnyStep::Add($step) => $body,
            $crate::noise::fractal::AnyStep::AddAbsolute($step) => $body,
            $crate::noise::fractal::AnyStep::Multiply($step) => $body,
            $crate::noise::fractal::AnyStep::Ridge($step) => $body,
            $crate::noise::fractal::AnyStep::Hybrid($step) => $body,
            $crate::noise::fractal::AnyStep::RidgePart($step) => {
                let $step = &**$step;
                $body
            }
            $crate::noise::fractal::AnyStep::HybridPart($step) => {
                let $step = &**$step;
                $body
            }
        }
    };
}
pub(super) use with_step;
