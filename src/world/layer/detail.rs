//! What lies between the nodes of heights: a programme whose detail is finer than they are.

use crate::{
    geometry::{Stop, Window},
    noise,
    programme::{Frame, Tape},
    world::base::Base,
};

/// Heights of this many amplitudes carry all of the detail; lower ones as much less, so that none is where nothing stands.
const FULL: f32 = 4.0;

/// A programme that is added to heights.
#[derive(Debug)]
pub(super) struct Detail {
    base: Base,
    tape: Tape,
    frame: Frame,
}

impl Detail {
    pub(super) fn new(base: Base, seed: u64) -> Self {
        /// Tells its lattices from those of the world's base.
        const DETAIL: u64 = 0x6465_7461_696c;
        let frame = Frame { seed: noise::key(seed, DETAIL), scale: base.scale, origin: base.origin };
        Self { tape: Tape::compile(base.programme.root()), frame, base }
    }

    /// What it was made of.
    pub(super) fn base(&self) -> &Base {
        &self.base
    }

    /// Adds it to elevations that heights were added to. Stopped, it is not whole.
    pub(super) fn add(&self, window: &Window, heights: &[f32], stop: &Stop, elevation: &mut [f32]) {
        let mut values = vec![0.0; elevation.len()];
        self.tape.evaluate_until(stop, &self.frame, window, &mut values);
        let (datum, amplitude) = (self.base.datum as f32, self.base.amplitude as f32);
        let full = FULL * (amplitude.abs() + datum.abs());
        for ((elevation, height), value) in elevation.iter_mut().zip(heights).zip(&values) {
            let t = if full > 0.0 { (height.abs() / full).min(1.0) } else { 0.0 };
            *elevation += (datum + amplitude * value) * (t * t * (3.0 - 2.0 * t));
        }
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    pub(super) fn cost_ns(&self, window: &Window) -> f64 {
        self.tape.cost_ns(window.spacing() / self.frame.scale, window.filter, window.samples()) * window.samples() as f64
    }
}
