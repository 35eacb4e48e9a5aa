//! A world ready to be evaluated.

use super::{Document, Revision, fingerprint::Prefix};
use crate::{
    geometry::{Filter, Source, Surface, Window},
    programme::{Frame, Tape},
};
use rayon::prelude::*;

/// Rows that one thread evaluates at a time.
const BAND_ROWS: usize = 64;

/// A document with its compiled programme.
///
/// ```
/// use terrane::{geometry::{Filter, Window}, world::{Document, World}};
/// let document = Document::parse(br#"{"seed": 7, "base": {"programme": "fbm(1, 2, 8)", "scale": 20000}}"#)?;
/// let world = World::new(document);
/// let surface = world.evaluate(&Window::area([0.0, 0.0, 25600.0, 25600.0], 100.0, Filter::Band, 1 << 20)?);
/// assert_eq!(surface.elevation.len(), 256 * 256);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct World {
    document: Document,
    revision: Revision,
    tape: Tape,
    frame: Frame,
    pub(super) prefix: Prefix,
}

impl World {
    /// Compiles a document.
    #[must_use]
    pub fn new(document: Document) -> Self {
        let base = &document.base;
        let tape = Tape::compile(base.programme.root());
        let frame = Frame { seed: document.seed, scale: base.scale, origin: base.origin };
        Self { revision: document.revision(), tape, frame, prefix: Prefix::new(&document), document }
    }

    /// The document.
    #[must_use]
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The name of the document's content.
    #[must_use]
    pub fn revision(&self) -> &Revision {
        &self.revision
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        self.area_cost_ns(window.spacing(), window.filter, window.samples())
    }

    /// The predicted time to evaluate `count` samples of a square, `spacing` metres apart, on one thread, in nanoseconds.
    #[must_use]
    pub fn area_cost_ns(&self, spacing: f64, filter: Filter, count: usize) -> f64 {
        self.tape.cost_ns(spacing / self.frame.scale, filter, count) * count as f64
    }

    /// The terrain over a window, on the calling thread.
    #[must_use]
    pub fn evaluate(&self, window: &Window) -> Surface {
        let mut surface = Surface::of(window);
        self.sample(window, &mut surface);
        surface
    }

    /// The terrain over a large window, on all threads of the present rayon pool; the same bytes as [`World::evaluate`].
    #[must_use]
    pub fn evaluate_parallel(&self, window: &Window) -> Surface {
        let mut surface = Surface::of(window);
        let columns = surface.columns.max(1);
        let bands = surface.elevation.par_chunks_mut(columns * BAND_ROWS).enumerate();
        surface.non_finite = bands.map(|(i, out)| self.fill(&window.band(i * BAND_ROWS, out.len() / columns), out)).sum();
        surface
    }

    /// Writes elevations; answers how many node results were not finite.
    fn fill(&self, window: &Window, out: &mut [f32]) -> u64 {
        let non_finite = self.tape.evaluate(&self.frame, window, out);
        let (datum, amplitude) = (self.document.base.datum as f32, self.document.base.amplitude as f32);
        let (min, max) = (self.document.elevation.min as f32, self.document.elevation.max as f32);
        for value in out {
            *value = (datum + amplitude * *value).clamp(min, max);
        }
        non_finite
    }
}

impl Source for World {
    fn sample(&self, window: &Window, surface: &mut Surface) {
        surface.non_finite += self.fill(window, &mut surface.elevation);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Filter;

    #[test]
    fn threads_do_not_change_a_bit() {
        let document = Document::parse(br#"{"seed": 3, "elevation": {"min": -200, "max": 400}, "base": {"programme": "log(fbm(1, 2, 6))", "scale": 500}}"#);
        let world = World::new(document.expect("valid"));
        let window = Window::area([-5_000.0, -5_000.0, 5_000.0, 5_000.0], 31.0, Filter::Band, 1 << 20).expect("valid");
        let whole = world.evaluate(&window);
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            assert_eq!(pool.install(|| world.evaluate_parallel(&window)), whole);
        }
        let (low, high) = whole.range().expect("samples");
        assert!(low >= -200.0 && high <= 400.0 && low < high);
    }
}
