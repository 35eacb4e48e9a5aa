//! Evolution of programmes without a designer: towards what is wanted.

use super::{
    Budget, Genome,
    breeding::grown,
    fitness::{Judged, Wanted},
    operators::{cross, mutate},
    portrait::bulk,
    record::RecordError,
};
use crate::{
    genetic::{Criterion, Draws, Problem, Term, Weighted},
    geometry::{Axis, Filter, Stop, Surface, Window},
    noise,
    programme::{Frame, MAX_METRES, Tape},
};
use serde::{Deserialize, Serialize};

/// How often a child is drawn that is over the budget, before it stays as its parent is.
const TRIES: usize = 8;

/// Samples a side that a programme may be judged on.
const SAMPLES: [usize; 2] = [16, 1024];

/// What terrain is wanted, and how it is looked at: programmes over a square of the plane about the origin, of a given relief.
///
/// ```
/// use terrane::{evolve::Aim, genetic::{Evolution, Settings}, geometry::Stop};
/// let aim = Aim::parse(br#"{"seed": 7, "samples": 32, "wanted": [
///     {"weight": 2, "criterion": {"accessibility": {"slope": 15, "share": 0.8}}},
///     {"criterion": {"edges": {"slope": 15, "density": 4000}}}]}"#)?;
/// let settings = Settings { population: 12, generations: 4, ..Settings::default() };
/// let mut evolution = Evolution::new(&aim, settings, 7, &Stop::never())?.expect("nobody stops it");
/// evolution.run(&Stop::never(), &mut |state| state.progress().best < 0.99);
/// let best = evolution.state().best().expect("twelve individuals");
/// assert_eq!(best.evaluation.scores.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Aim {
    /// The seed of the world that the programme is for; 0 … 2^53 - 1.
    pub seed: u64,
    /// Metres a programme unit.
    pub scale: f64,
    /// Metres a side of the square.
    pub side: f64,
    /// Samples a side, 16 … 1024.
    pub samples: usize,
    /// Metres between the elevations that 2 % and 98 % of the square lie below: what programmes give is stretched to it, so that no terrain is flat for want of height.
    pub relief: f64,
    /// Limits of all programmes.
    pub budget: Budget,
    /// What is wanted, and how much each counts.
    pub wanted: Weighted<Wanted>,
}

impl Default for Aim {
    fn default() -> Self {
        Self { seed: 0, scale: 1_000.0, side: 4_000.0, samples: 128, relief: 300.0, budget: Budget::small(), wanted: Weighted(Vec::new()) }
    }
}

/// How near a programme comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Judgement {
    /// The score of everything that is wanted, in order; empty for a programme that is flat or almost so, or not finite somewhere.
    pub scores: Vec<f64>,
    /// Their weighted mean.
    pub score: f64,
    /// The amplitude that gives the programme the relief that is wanted, in metres.
    pub amplitude: f64,
    /// The datum that puts the least sample at 0 m then.
    pub datum: f64,
}

impl Aim {
    /// Reads what is wanted.
    ///
    /// # Errors
    /// If something is not what it must be; the error names the place.
    pub fn parse(json: &[u8]) -> Result<Self, RecordError> {
        let aim: Self = serde_path_to_error::deserialize(&mut serde_json::Deserializer::from_slice(json)).map_err(|error| super::record::place(&error))?;
        aim.check()?;
        Ok(aim)
    }

    /// Holds everything to its range.
    ///
    /// # Errors
    /// If something lies outside; the error names the place.
    pub fn check(&self) -> Result<(), RecordError> {
        if self.seed > super::MAX_SEED {
            return Err(RecordError::new("/seed", format!("must be 0 … {}, got {}", super::MAX_SEED, self.seed)));
        }
        for (name, metres) in [("scale", self.scale), ("side", self.side), ("relief", self.relief)] {
            if !(0.01..=1e9).contains(&metres) {
                return Err(RecordError::new(format!("/{name}"), format!("must be 0.01 … 1000000000 metres, got {metres}")));
            }
        }
        let [least, most] = SAMPLES;
        if !(least..=most).contains(&self.samples) {
            return Err(RecordError::new("/samples", format!("must be {least} … {most} a side, got {}", self.samples)));
        }
        if let Some((limit, message)) = self.budget.wrong() {
            return Err(RecordError::new(format!("/budget/{limit}"), message));
        }
        if !self.wanted.0.iter().any(|term| term.weight > 0.0) {
            return Err(RecordError::new("/wanted", "must hold a criterion with a weight above 0"));
        }
        for (i, Term { weight, criterion }) in self.wanted.0.iter().enumerate() {
            if !(0.0..=1e6).contains(weight) {
                return Err(RecordError::new(format!("/wanted/{i}/weight"), format!("must be 0 … 1000000, got {weight}")));
            }
            criterion.check(&format!("/wanted/{i}/criterion"))?;
        }
        Ok(())
    }

    /// Metres between samples.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.side / self.samples as f64
    }

    /// The window of the whole square with that many samples a side.
    #[must_use]
    pub fn window(&self, samples: usize) -> Window {
        let half = self.side / samples.max(1) as f64 / 2.0;
        let axis = |sign: i64| Axis::new(sign, 2 * sign, half, -self.side / 2.0 * sign as f64, samples);
        Window { columns: axis(1), rows: axis(-1), filter: Filter::Band }
    }

    pub(super) fn frame(&self) -> Frame {
        Frame { seed: self.seed, scale: self.scale, origin: [0.0; 2] }
    }

    /// The terrain of a programme over the square with an apron of one sample, and amplitude and datum that give it its relief; `None` if it is flat, or not finite
    /// somewhere, or no world could show it as high, or was stopped.
    #[must_use]
    pub fn surface(&self, tape: &Tape, stop: &Stop) -> Option<(Surface, [f64; 2])> {
        let window = self.window(self.samples).with_apron(1);
        let mut surface = Surface::of(&window);
        let non_finite = tape.evaluate_until(stop, &self.frame(), &window, &mut surface.elevation);
        if non_finite > 0 || stop.is_set() {
            return None;
        }
        let [low, high] = bulk(&surface)?.map(f64::from);
        let amplitude = self.relief / (high - low);
        let least = surface.elevation.iter().copied().fold(f32::INFINITY, f32::min);
        let datum = -f64::from(least) * amplitude;
        for elevation in &mut surface.elevation {
            *elevation = (datum + amplitude * f64::from(*elevation)) as f32;
        }
        (amplitude <= MAX_METRES && datum.abs() <= MAX_METRES).then_some((surface, [amplitude, datum]))
    }

    /// How near a programme comes to what is wanted.
    #[must_use]
    pub fn judge(&self, tape: &Tape, stop: &Stop) -> Judgement {
        let Some((surface, [amplitude, datum])) = self.surface(tape, stop) else {
            return Judgement { scores: Vec::new(), score: 0.0, amplitude: 1.0, datum: 0.0 };
        };
        let judged = Judged::new(&surface, self.spacing());
        Judgement { scores: self.wanted.scores(&judged), score: self.wanted.score(&judged), amplitude, datum }
    }

    /// The first child within the budget, if there is one among a few.
    fn within_budget(&self, genome: &mut Genome, mut child: impl FnMut(&Genome) -> Genome) {
        for _ in 0..TRIES {
            let drawn = child(genome);
            if self.budget.admit(&drawn).is_some() {
                *genome = drawn;
                return;
            }
        }
    }
}

impl Problem for Aim {
    type Genome = Genome;
    type Evaluation = Judgement;
    type Change = ();

    fn initialise(&self, number: usize, draws: &mut Draws) -> Genome {
        let key = draws.bits();
        grown(number, &self.budget, self.seed, |attempt| Draws::new(noise::key(key, attempt))).0
    }

    fn cross(&self, child: &mut Genome, mate: &Genome, (): &mut (), draws: &mut Draws) {
        self.within_budget(child, |genome| cross(genome, mate, draws));
    }

    fn mutate(&self, child: &mut Genome, _: &Judgement, (): &mut (), draws: &mut Draws) {
        self.within_budget(child, |genome| mutate(genome, draws).0);
    }

    fn evaluate(&self, genome: &Genome, _: Option<(&Judgement, &())>, stop: &Stop) -> Judgement {
        match genome.programme() {
            Ok(programme) => self.judge(&Tape::compile(programme.root()), stop),
            Err(_) => Judgement { scores: Vec::new(), score: 0.0, amplitude: 1.0, datum: 0.0 },
        }
    }

    fn fitness(&self, judgement: &Judgement) -> f64 {
        judgement.score
    }
}
