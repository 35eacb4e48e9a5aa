//! Fractals whose octaves open the next: ridged and hybrid.
//!
//! The mean of a clamped product is not the product of means. What octaves that a spacing does not carry add on average is therefore tabulated over the opening
//! they start from: backwards from the last, `T_k(c)` = c · weight · E s + E `T_(k+1)`(clamp(gain · c · s)), the octaves being independent.

use super::{
    Basis, Field,
    field::{Octave, Part},
    fractal::{AnyStep, Hybrid, Part as PartStep, Ridge, Whole},
    number::Table,
};

/// An octave's signals, how they open the next octave, and what they add.
struct Signals {
    /// Equally likely signals of a whole opening.
    likely: Vec<f64>,
    mean: f64,
    gain: f64,
    weight: f64,
    /// The least opening that comes in and that goes out.
    low: [f64; 2],
}

impl Signals {
    fn expected(&self, opening: f64, next: impl Fn(f64) -> f64) -> f64 {
        let sum: f64 = self.likely.iter().map(|signal| next((self.gain * opening * signal).clamp(self.low[1], 1.0))).sum();
        sum / self.likely.len() as f64
    }

    /// The mean opening of the next octave.
    fn mean_opening(&self) -> Table {
        Table::new(self.low[0], 1.0, |opening| self.expected(opening, |next| next))
    }

    /// What this octave and those after it add, given what those after it add.
    fn tail(&self, next: Option<&Table>) -> Table {
        Table::new(self.low[0], 1.0, |opening| {
            let own = opening * self.weight * self.mean;
            own + next.map_or(0.0, |next| self.expected(opening, |opening| next.at(opening)))
        })
    }
}

/// (offset - |n|)², each octave opened by the one before.
pub(super) fn ridged(basis: Basis, parts: &[Part], offset: f64, gain: f64, octave: impl Fn(usize, f64, AnyStep) -> Octave) -> Field {
    let moments = basis.moments();
    // A gain below zero never opens anything, nor does zero: so there is no clamp at zero.
    let gain = gain.max(0.0);
    let signals = |k: usize| Signals {
        likely: basis.parts().iter().map(|&n| (offset - f64::from(n)) * (offset - f64::from(n))).collect(),
        mean: offset * offset - 2.0 * offset * moments.absolute + moments.square,
        gain,
        weight: parts[k].weight * parts[k].share,
        low: [0.0; 2],
    };
    let step = |k: usize| {
        let signals = signals(k);
        let step = Ridge { offset: offset as f32, gain: gain as f32, weight: signals.weight as f32 };
        if parts[k].carried >= 1.0 { AnyStep::Ridge(Whole(step)) } else { AnyStep::RidgePart(Box::new(part(step, &signals, parts[k].carried))) }
    };
    opened(basis, parts, signals, |k| octave(k, 1.0, step(k)))
}

/// (n + offset) w, each octave opened by the one before.
pub(super) fn hybrid(basis: Basis, parts: &[Part], offset: f64, gain: f64, octave: impl Fn(usize, f64, AnyStep) -> Octave) -> Field {
    let mean = basis.moments().mean;
    let noises: Vec<f64> = basis.parts().iter().map(|&n| f64::from(n)).flat_map(|n| if basis.is_signed() { [-n, n] } else { [n, n] }).collect();
    let lows = lows(basis, parts, offset, gain);
    let signals = |k: usize| Signals {
        likely: noises.iter().map(|n| (n + offset) * parts[k].weight).collect(),
        mean: (mean + offset) * parts[k].weight,
        gain,
        weight: parts[k].share,
        low: [lows[k], lows[k + 1]],
    };
    let step = |k: usize| {
        let part_of = &parts[k];
        let step = Hybrid { level: (part_of.weight * offset) as f32, gain: gain as f32, weight: part_of.share as f32 };
        if part_of.carried >= 1.0 { AnyStep::Hybrid(Whole(step)) } else { AnyStep::HybridPart(Box::new(part(step, &signals(k), part_of.carried))) }
    };
    opened(basis, parts, signals, |k| octave(k, parts[k].weight, step(k)))
}

/// The least opening before each octave, by interval arithmetic; openings far below zero are rare, and tables go on straight beyond their ends.
fn lows(basis: Basis, parts: &[Part], offset: f64, gain: f64) -> Vec<f64> {
    let [least, greatest] = basis.range().map(|n| f64::from(n) + offset);
    let mut lows = vec![0.0_f64];
    for (k, part) in parts.iter().enumerate() {
        let next = gain * part.weight * least.min(lows[k] * greatest);
        lows.push(next.clamp(-2.0, 0.0));
    }
    lows
}

fn part<S>(step: S, signals: &Signals, carried: f64) -> PartStep<S> {
    PartStep { step, carried: carried as f32, mean_signal: signals.mean as f32, mean_opening: signals.mean_opening() }
}

fn opened(basis: Basis, parts: &[Part], signals: impl Fn(usize) -> Signals, octave: impl Fn(usize) -> Octave) -> Field {
    let kept = parts.iter().rposition(|part| part.carried > 0.0).map_or(0, |last| last + 1);
    let tail = (kept..parts.len()).rev().fold(None, |next: Option<Table>, k| Some(signals(k).tail(next.as_ref())));
    Field { basis, start: 0.0, octaves: (0..kept).map(octave).collect(), tail }
}
