//! The meaning of a programme at a point, plainly.

use super::{
    Frame,
    evaluate::{Prepared, offsets},
    graph::{Eroded, Graph, HERE, Id, Place, PlaceId, Step},
    kernels,
    node::Node,
    sampling::wave_lengths,
    tape::Tape,
};
use crate::{
    geometry::Filter,
    noise::{Isa, Networks, Terrain, Valleys},
};
use std::cell::RefCell;

/// A programme as it is held against [`super::Tape`]: step by step as it was written, without simplification, one point at a time.
pub struct Reference {
    graph: Graph,
    order: Vec<Id>,
    frame: Frame,
    prepared: Prepared,
    spacing: f64,
    erosions: Vec<RefCell<(Valleys, Networks, Reference)>>,
}

impl Terrain for Reference {
    fn heights(&mut self, us: &[f64], vs: &[f64], out: &mut [f32]) {
        for (out, (&u, &v)) in out.iter_mut().zip(us.iter().zip(vs)) {
            *out = self.value([u, v], 0);
        }
    }
}

impl Reference {
    /// A programme as samples `spacing` metres apart see it.
    ///
    /// # Panics
    /// If the node does not come from a [`super::Programme`], which has checked its size.
    #[must_use]
    pub fn new(root: &Node, frame: &Frame, spacing: f64, filter: Filter) -> Self {
        let tapes = |root| Tape::plain(root).ok().zip(Tape::try_compile(root).ok());
        let (plain, simplified) = tapes(root).expect("a programme's size was checked when it was parsed");
        let units = if filter == Filter::Band { spacing / frame.scale } else { 0.0 };
        let prepared = Prepared::new(&plain.graph, &wave_lengths(&simplified.graph), frame, simplified.sampling(units));
        Self::prepared(plain.graph.clone(), frame, prepared, spacing, &plain)
    }

    fn prepared(graph: Graph, frame: &Frame, prepared: Prepared, spacing: f64, tape: &Tape) -> Self {
        let eroding = |(number, eroded): (usize, &Eroded)| {
            let stead = tape.stead(number, &prepared);
            let network = &graph.networks[eroded.networks];
            let valleys = Valleys::new(&eroded.erosion, prepared.sampling.fading, &stead);
            let networks = Networks::new(Isa::Baseline, &eroded.erosion, network.lattices.key(frame.seed));
            let terrain = Graph::clone(&network.terrain);
            let exact = Prepared::exact(&terrain, frame);
            RefCell::new((valleys, networks, Self::prepared(terrain, frame, exact, 1.0, tape)))
        };
        let erosions = graph.erosions.iter().enumerate().map(eroding).collect();
        Self { order: graph.reachable(graph.root), graph, frame: *frame, prepared, spacing, erosions }
    }

    /// The value at plane coordinates (x, y).
    #[must_use]
    pub fn at(&self, x: f64, y: f64) -> f32 {
        let n = self.prepared.sampling.n;
        if n == 1 {
            return self.sample(x, y, 0);
        }
        let (mut sum, share) = (0.0, 1.0 / (n * n) as f32);
        for (row, dy) in offsets(n, self.spacing).enumerate() {
            for (column, dx) in offsets(n, self.spacing).enumerate() {
                sum += share * self.sample(x + dx, y + dy, row * n + column);
            }
        }
        sum.clamp(f32::MIN, f32::MAX)
    }

    fn sample(&self, x: f64, y: f64, part: usize) -> f32 {
        self.value([(x - self.frame.origin[0]) / self.frame.scale, (y - self.frame.origin[1]) / self.frame.scale], part)
    }

    fn value(&self, here: [f64; 2], part: usize) -> f32 {
        let mut values = vec![0.0_f32; self.graph.steps.len()];
        for &id in &self.order {
            let step = self.graph.steps[id];
            let at = self.position(step.place().unwrap_or(HERE), here, &values);
            let mut operands = [0.0; 3];
            for (value, operand) in operands.iter_mut().zip(step.operands()) {
                *value = values[operand];
            }
            let mut value = kernels::value(step, operands, at, part, &self.prepared);
            if let Step::Erosion(erosion, ..) = step {
                let (valleys, networks, terrain) = &mut *self.erosions[erosion].borrow_mut();
                valleys.carve(networks, terrain, &at[..1], &at[1..], std::slice::from_mut(&mut value), part);
            }
            values[id] = if value.is_finite() { value } else { 0.0 };
        }
        values[self.graph.root]
    }

    fn position(&self, place: PlaceId, here: [f64; 2], values: &[f32]) -> [f64; 2] {
        match self.graph.places[place] {
            Place::Grid { du, dv } => [here[0] + du.get(), here[1] + dv.get()],
            Place::Shifted { base, du, dv } => {
                let [u, v] = self.position(base, here, values);
                [u + du.get(), v + dv.get()]
            }
            Place::Moved { base, dx, dy } => {
                let [u, v] = self.position(base, here, values);
                [u + f64::from(values[dx]), v + f64::from(values[dy])]
            }
        }
    }
}
