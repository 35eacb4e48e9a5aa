//! How a bred programme is looked at: where in the plane, from what least to what greatest value, and whether there is something to see.

use super::Genome;
use crate::{
    analysis,
    geometry::{Axis, Filter, Source, Surface, Window},
    noise,
    programme::{Frame, Tape},
};

/// Samples a side of the lattice that programmes are measured on.
const MEASURED: usize = 48;

/// The square that programmes are shown over: programme units a side, about the origin, where bells and steps stand.
pub const VIEW_SIDE: f64 = 4.0;

/// The greatest share of the square's side that portraits are high.
const HEIGHT: f64 = 0.25;

/// What the values of a programme are over the square it is shown in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Least and greatest value there can be anywhere, by interval arithmetic.
    pub bounds: [f64; 2],
    /// Least and greatest of the samples of a fixed lattice over the square.
    pub measured: [f32; 2],
    /// Whether there is terrain to be seen: neither flat nor torn, no mere ramp, and no needles in a plain.
    pub is_worth_seeing: bool,
}

/// A programme as a source of terrain over the square of `VIEW_SIDE` × `VIEW_SIDE` metres about the origin: one programme unit a metre, heights from 0 to a quarter of the side.
#[derive(Clone, Debug)]
pub struct Portrait {
    tape: Tape,
    frame: Frame,
    extent: Extent,
}

impl Portrait {
    /// Measures a programme whose noises are hashed with a seed.
    ///
    /// # Errors
    /// If the genome breaks a limit of programmes.
    pub fn new(genome: &Genome, seed: u64) -> Result<Self, crate::programme::ParseError> {
        Ok(Self::of(Tape::compile(genome.programme()?.root()), seed))
    }

    pub(super) fn of(tape: Tape, seed: u64) -> Self {
        let frame = Frame { seed, scale: 1.0, origin: [0.0; 2] };
        let extent = measure(&tape, &frame);
        Self { tape, frame, extent }
    }

    /// The values of the programme.
    #[must_use]
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        self.tape.cost_ns(window.spacing(), window.filter, window.samples()) * window.samples() as f64
    }

    /// The window of the whole square with that many samples a side.
    #[must_use]
    pub fn window(samples: usize) -> Window {
        square(samples, Filter::Band)
    }
}

/// Samples at pixel centres of the square, the same whatever the number of threads.
fn square(samples: usize, filter: Filter) -> Window {
    let half = VIEW_SIDE / (2.0 * samples.max(1) as f64);
    let axis = |sign: i64| Axis::new(sign, 2 * sign, half, -VIEW_SIDE / 2.0 * sign as f64, samples);
    Window { columns: axis(1), rows: axis(-1), filter }
}

fn measure(tape: &Tape, frame: &Frame) -> Extent {
    let window = square(MEASURED, Filter::Band);
    let mut surface = Surface::of(&window);
    surface.non_finite = tape.evaluate(frame, &window, &mut surface.elevation);
    let (low, high) = surface.range().unwrap_or_default();
    Extent { bounds: tape.range(), measured: [low, high], is_worth_seeing: is_worth_seeing(&surface, window.spacing()) }
}

/// Share of the samples below and above which the bulk of the values does not lie.
const BULK: f64 = 0.02;

/// The bulk has at least this share of the whole range: else a few needles stand in a plain.
const LEAST_BULK: f32 = 0.15;

/// Mean slope where the bulk is as high as the square is wide: a plane has 1, white noise 25, fractals 3 … 9.
const SLOPES: [f64; 2] = [1.6, 16.0];

/// Samples among which neighbours are of one value, as on treads and in plains, are at most this share.
const MOST_FLAT: f64 = 0.6;

/// The values that the bulk of a surface's samples lies between; `None` if that is nowhere: f32 hardly tells them apart.
pub(super) fn bulk(surface: &Surface) -> Option<[f32; 2]> {
    let mut sorted = surface.elevation.clone();
    sorted.sort_unstable_by(f32::total_cmp);
    let cut = (sorted.len() as f64 * BULK) as usize;
    let (low, high) = (*sorted.get(cut)?, *sorted.get(sorted.len() - 1 - cut)?);
    (high - low > 1e-4 * low.abs().max(high.abs())).then_some([low, high])
}

fn is_worth_seeing(surface: &Surface, spacing: f64) -> bool {
    let (Some([low, high]), Some((least, greatest))) = (bulk(surface), surface.range()) else { return false };
    let bulk = high - low;
    if surface.non_finite > 0 || bulk < (greatest - least) * LEAST_BULK {
        return false;
    }
    let (mut slopes, mut flat, mut count) = (0.0, 0.0, 0.0);
    for row in 1..surface.rows - 1 {
        for column in 1..surface.columns - 1 {
            let [east, north] = analysis::gradient(surface, row, column, spacing).map(f64::from);
            let slope = (east * east + north * north).sqrt() * VIEW_SIDE / f64::from(bulk);
            slopes += slope;
            flat += f64::from(u8::from(slope < 0.02));
            count += 1.0;
        }
    }
    (SLOPES[0]..=SLOPES[1]).contains(&(slopes / count)) && flat <= MOST_FLAT * count
}

impl Source for Portrait {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        surface.non_finite += self.tape.evaluate_until(&surface.stop.clone(), &self.frame, window, &mut surface.elevation);
        let [low, high] = self.extent.measured;
        let scale = if high > low { (VIEW_SIDE * HEIGHT) as f32 / (high - low) } else { 1.0 };
        for elevation in &mut surface.elevation {
            *elevation = (*elevation - low) * scale;
        }
    }
}

/// The seed of the noises that the individuals of a session are shown with.
pub(super) fn view_seed(seed: u64) -> u64 {
    // A world can have it: 0 … 2^53 - 1.
    noise::key(seed, 0x7669_6577) >> 11
}
