//! The same value elsewhere: what a warp, an average and a difference are made of.

use super::graph::{Builder, HERE, Id, Place, PlaceId, Step};
use std::collections::BTreeMap;

/// How the sample's place is exchanged for another.
#[derive(Clone, Copy, Debug)]
pub(super) enum Motion {
    /// By a constant.
    Shift(f64, f64),
    /// To another place.
    To(PlaceId),
}

impl Builder {
    /// The step that has at a sample the value which `root` has at the moved sample.
    pub(super) fn relocate(&mut self, root: Id, motion: Motion) -> Id {
        let (mut steps, mut places) = (BTreeMap::new(), BTreeMap::new());
        for id in self.graph.reachable(root) {
            if self.is_full() {
                return 0;
            }
            let at = |id: Id| steps.get(&id).copied().unwrap_or(0);
            let moved = match self.graph.steps[id] {
                step @ Step::Number(_) => step,
                Step::Coordinate(axis, place) => Step::Coordinate(axis, self.relocate_place(place, motion, &steps, &mut places)),
                Step::Shape(shape, place) => Step::Shape(shape, self.relocate_place(place, motion, &steps, &mut places)),
                Step::ShapeSlope(shape, axis, place) => Step::ShapeSlope(shape, axis, self.relocate_place(place, motion, &steps, &mut places)),
                Step::Noise(noise, place) => Step::Noise(noise, self.relocate_place(place, motion, &steps, &mut places)),
                Step::NoiseSlope(noise, axis, place) => Step::NoiseSlope(noise, axis, self.relocate_place(place, motion, &steps, &mut places)),
                Step::Erosion(erosion, of, place) => Step::Erosion(erosion, at(of), self.relocate_place(place, motion, &steps, &mut places)),
                Step::Unary(operation, a) => Step::Unary(operation, at(a)),
                Step::Binary(operation, a, b) => Step::Binary(operation, at(a), at(b)),
                Step::Select(mask, a, b) => Step::Select(at(mask), at(a), at(b)),
                Step::Terrace(terrace, a) => Step::Terrace(terrace, at(a)),
                Step::TerraceSlope(terrace, a) => Step::TerraceSlope(terrace, at(a)),
            };
            let moved = self.push(moved);
            steps.insert(id, moved);
        }
        steps[&root]
    }

    fn relocate_place(&mut self, place: PlaceId, motion: Motion, steps: &BTreeMap<Id, Id>, places: &mut BTreeMap<PlaceId, PlaceId>) -> PlaceId {
        if let Some(&moved) = places.get(&place) {
            return moved;
        }
        let moved = match (self.graph.places[place], motion) {
            (Place::Grid { .. }, Motion::Shift(du, dv)) => self.shifted(place, du, dv),
            (Place::Grid { du, dv }, Motion::To(to)) => self.shifted(to, du.get(), dv.get()),
            (Place::Shifted { base, du, dv }, _) => {
                let base = self.relocate_place(base, motion, steps, places);
                self.shifted(base, du.get(), dv.get())
            }
            (Place::Moved { base, dx, dy }, _) => {
                let base = self.relocate_place(base, motion, steps, places);
                let of = |id: Id| steps.get(&id).copied().unwrap_or(0);
                self.place(Place::Moved { base, dx: of(dx), dy: of(dy) })
            }
        };
        places.insert(place, moved);
        moved
    }

    /// The step at the sample's place moved by two values.
    pub(super) fn warp(&mut self, of: Id, dx: Id, dy: Id) -> Id {
        let to = self.place(Place::Moved { base: HERE, dx, dy });
        self.relocate(of, Motion::To(to))
    }
}
