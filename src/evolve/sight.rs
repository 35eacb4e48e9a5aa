//! The square that programmes are judged over, to be seen.

use super::{Aim, Found};
use crate::{
    geometry::{Source, Surface, Window},
    programme::{Frame, ParseError, Tape},
};

/// The terrain of a judged programme as it was judged: on the square about the origin, with the amplitude and the datum that it was given.
#[derive(Clone, Debug)]
pub struct Sight {
    tape: Tape,
    frame: Frame,
    amplitude: f64,
    datum: f64,
}

impl Sight {
    /// What was found by an aim.
    ///
    /// # Errors
    /// If the genome breaks a limit of programmes.
    pub fn new(aim: &Aim, found: &Found) -> Result<Self, ParseError> {
        let tape = Tape::compile(found.genome.programme()?.root());
        Ok(Self { tape, frame: aim.frame(), amplitude: found.judgement.amplitude, datum: found.judgement.datum })
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        self.tape.cost_ns(window.spacing() / self.frame.scale, window.filter, window.samples()) * window.samples() as f64
    }
}

impl Source for Sight {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        surface.non_finite += self.tape.evaluate_until(&surface.stop.clone(), &self.frame, window, &mut surface.elevation);
        for elevation in &mut surface.elevation {
            *elevation = (self.datum + self.amplitude * f64::from(*elevation)) as f32;
        }
    }
}
