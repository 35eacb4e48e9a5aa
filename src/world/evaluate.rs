//! A world ready to be evaluated.

use super::{
    Document, Revision,
    fingerprint::Prefix,
    layer::{Below, materials},
    weights,
};
use crate::{
    geometry::{Filter, Legend, Source, Surface, SurfaceRows, Wanted, Window},
    programme::{Frame, Tape},
};
use rayon::prelude::*;

/// Rows that one thread evaluates at a time.
const BAND_ROWS: usize = 64;

/// Rows of weights of materials that are evaluated at a time: all materials of a sample are kept till then.
const WEIGHT_ROWS: usize = 16;

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
    /// What the layers' ground can be made of, in lexical order.
    materials: Vec<Box<str>>,
    /// The layers by their places in the document, in the order of evaluation, each with the numbers of its materials among all.
    order: Vec<(usize, Vec<u16>)>,
    pub(super) prefix: Prefix,
}

impl World {
    /// Compiles a document.
    #[must_use]
    pub fn new(document: Document) -> Self {
        let base = &document.base;
        let tape = Tape::compile(base.programme.root());
        let frame = Frame { seed: document.seed, scale: base.scale, origin: base.origin };
        let materials = materials(&document.layers);
        let mut order: Vec<usize> = (0..document.layers.len()).collect();
        order.sort_by_key(|&i| document.layers[i].priority);
        let numbered = |i: usize| (i, document.layers[i].numbers(&materials));
        let order = order.into_iter().map(numbered).collect();
        Self { revision: document.revision(), tape, frame, order, materials, prefix: Prefix::new(&document), document }
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

    /// What the ground can be made of: the material of number n in a [`Surface`] is the one at n - 1.
    #[must_use]
    pub fn materials(&self) -> &[Box<str>] {
        &self.materials
    }

    /// The document's layers in the order in which they are laid.
    pub(super) fn layers(&self) -> impl Iterator<Item = &super::Layer> {
        self.order.iter().map(|(i, _)| &self.document.layers[*i])
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        let base = self.area_cost_ns(window.spacing(), window.filter, window.samples());
        base + self.layers().map(|layer| layer.cost_ns(window)).sum::<f64>()
    }

    /// The predicted time to evaluate a window in parts of `count` samples each on one thread, in nanoseconds: what parts share is found again for every one.
    #[must_use]
    pub fn parts_cost_ns(&self, window: &Window, count: usize) -> f64 {
        let (samples, count) = (window.samples(), count.clamp(1, window.samples().max(1)));
        let base = |count| self.area_cost_ns(window.spacing(), window.filter, count);
        self.cost_ns(window) - base(samples) + base(count) * (samples as f64 / count as f64)
    }

    /// The predicted time to evaluate the base at `count` samples of a square, `spacing` metres apart, on one thread, in nanoseconds.
    #[must_use]
    pub fn area_cost_ns(&self, spacing: f64, filter: Filter, count: usize) -> f64 {
        self.tape.cost_ns(spacing / self.frame.scale, filter, count) * count as f64
    }

    /// The elevations over a window, on the calling thread.
    #[must_use]
    pub fn evaluate(&self, window: &Window) -> Surface {
        self.evaluate_with(window, Wanted::default())
    }

    /// The terrain over a window with what is wanted of it, on the calling thread.
    #[must_use]
    pub fn evaluate_with(&self, window: &Window, wanted: Wanted) -> Surface {
        let mut surface = Surface::with(window, wanted);
        self.sample(window, &mut surface);
        surface
    }

    /// The elevations over a large window, on all threads of the present rayon pool; the same bytes as [`World::evaluate`].
    #[must_use]
    pub fn evaluate_parallel(&self, window: &Window) -> Surface {
        self.evaluate_parallel_with(window, Wanted::default())
    }

    /// The terrain over a large window with what is wanted of it, on all threads of the present rayon pool; the same bytes as [`World::evaluate_with`].
    #[must_use]
    pub fn evaluate_parallel_with(&self, window: &Window, wanted: Wanted) -> Surface {
        let mut surface = Surface::with(window, wanted);
        let columns = surface.columns.max(1);
        let height = if surface.weights.is_empty() { BAND_ROWS } else { WEIGHT_ROWS };
        let bands = surface.bands_mut(height);
        let fill = |(i, rows): (usize, SurfaceRows)| self.fill(&window.band(i * height, rows.elevation.len() / columns), rows);
        surface.non_finite = bands.into_par_iter().enumerate().map(fill).sum();
        surface
    }

    /// Fills rows; answers how many node results were not finite.
    fn fill(&self, window: &Window, mut rows: SurfaceRows) -> u64 {
        let non_finite = self.tape.evaluate_until(&rows.stop, &self.frame, window, rows.elevation);
        let (datum, amplitude) = (self.document.base.datum as f32, self.document.base.amplitude as f32);
        for value in &mut *rows.elevation {
            *value = datum + amplitude * *value;
        }
        let mut dry = vec![0.0; rows.water_cover.len()];
        let mut shares = weights::base(rows.weights.len(), self.materials.len());
        for (i, materials) in &self.order {
            if rows.stop.is_set() {
                break;
            }
            rows = self.document.layers[*i].lay(window, Below { rows, dry: &mut dry, materials, shares: &mut shares });
        }
        weights::write(&shares, self.materials.len(), rows.page, rows.weights);
        let (min, max) = (self.document.elevation.min as f32, self.document.elevation.max as f32);
        for value in &mut *rows.elevation {
            *value = value.clamp(min, max);
        }
        self.flood(&mut rows, &dry);
        non_finite
    }

    /// Adds the sea to the water of layers.
    fn flood(&self, rows: &mut SurfaceRows, dry: &[f32]) {
        let sea_level = self.document.sea_level as f32;
        for (i, (depth, cover)) in rows.water_depth.iter_mut().zip(&mut *rows.water_cover).enumerate() {
            let sea = sea_level - rows.elevation[i];
            if sea > 0.0 {
                *depth = depth.max(sea);
                *cover = cover.max(1.0 - dry[i]);
            }
        }
    }
}

impl Source for World {
    fn legend(&self) -> Legend {
        let Document { sea_level, elevation, .. } = &self.document;
        Legend { sea_level: *sea_level, range: [elevation.min, elevation.max], materials: self.materials.clone() }
    }

    fn sample(&self, window: &Window, surface: &mut Surface) {
        let columns = surface.columns.max(1);
        let height = if surface.weights.is_empty() { window.rows.len() } else { WEIGHT_ROWS };
        let bands = surface.bands_mut(height).into_iter().enumerate();
        let non_finite: u64 = bands.map(|(i, rows)| self.fill(&window.band(i * height, rows.elevation.len() / columns), rows)).sum();
        surface.non_finite += non_finite;
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
