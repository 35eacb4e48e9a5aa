//! Derivatives of steps along an axis, by the rules of calculus; where a step has none, by a central difference.

use super::{
    graph::{Axis, Builder, Id, Place, PlaceId, Step},
    motion::Motion,
    operation::{Binary, Unary},
};
use std::collections::BTreeMap;

/// Half the distance of a difference, in programme units.
pub(super) const DIFFERENCE: f64 = 1.0 / 1_024.0;

/// The derivatives found so far, of one axis. Numbers have none, which stands for 0 and is not added or multiplied.
struct Derivatives {
    axis: Axis,
    steps: BTreeMap<Id, Option<Id>>,
    places: BTreeMap<PlaceId, [Option<Id>; 2]>,
}

impl Builder {
    /// The derivative of a step along an axis of the programme's plane, in its values a programme unit.
    pub(super) fn derivative(&mut self, root: Id, axis: Axis) -> Id {
        let mut known = Derivatives { axis, steps: BTreeMap::new(), places: BTreeMap::new() };
        for id in self.graph.reachable(root) {
            if self.is_full() {
                return 0;
            }
            let derivative = self.derive(id, &mut known);
            known.steps.insert(id, derivative);
        }
        known.steps[&root].unwrap_or_else(|| self.number(0.0))
    }

    fn derive(&mut self, id: Id, known: &mut Derivatives) -> Option<Id> {
        let of = |id: Id| known.steps.get(&id).copied().flatten();
        match self.graph.steps[id] {
            Step::Number(_) => None,
            Step::Coordinate(axis, place) => self.place_derivative(place, known)[axis as usize],
            Step::Shape(shape, place) if self.graph.shapes[shape].has_slopes() => {
                let moved = self.place_derivative(place, known);
                self.chain(moved, |axis| Step::ShapeSlope(shape, axis, place))
            }
            Step::Noise(noise, place) if self.graph.noises[noise].basis.has_slopes() => {
                let moved = self.place_derivative(place, known);
                self.chain(moved, |axis| Step::NoiseSlope(noise, axis, place))
            }
            Step::Unary(operation, a) => {
                let a = self.seen(operation, a);
                of(a).map(|da| self.unary_derivative(operation, id, a, da))
            }
            Step::Binary(operation, a, b) => self.binary_derivative(operation, id, [a, b], [of(a), of(b)]),
            Step::Select(mask, a, b) => {
                let (da, db) = (of(a), of(b));
                self.either(mask, da, db)
            }
            Step::Terrace(terrace, a) => of(a).map(|da| {
                let slope = self.push(Step::TerraceSlope(terrace, a));
                self.binary(Binary::Multiply, slope, da)
            }),
            _ => Some(self.difference(id, known.axis)),
        }
    }

    /// What a function of |a| alone is a function of: where it is 0, its sides must be told apart as they are after simplification.
    fn seen(&self, operation: Unary, a: Id) -> Id {
        match (operation, self.graph.steps[a]) {
            (Unary::Abs | Unary::Sqrt | Unary::Log, Step::Unary(Unary::Negative | Unary::Abs, inner)) => self.seen(operation, inner),
            _ => a,
        }
    }

    /// (f(p + d) - f(p - d)) / 2 d.
    fn difference(&mut self, of: Id, axis: Axis) -> Id {
        let shift = |d: f64| match axis {
            Axis::U => Motion::Shift(d, 0.0),
            Axis::V => Motion::Shift(0.0, d),
        };
        let (after, before) = (self.relocate(of, shift(DIFFERENCE)), self.relocate(of, shift(-DIFFERENCE)));
        let difference = self.binary(Binary::Minus, after, before);
        let scale = self.number((0.5 / DIFFERENCE) as f32);
        self.binary(Binary::Multiply, difference, scale)
    }

    /// How a place's two coordinates move along the axis.
    fn place_derivative(&mut self, place: PlaceId, known: &mut Derivatives) -> [Option<Id>; 2] {
        if let Some(&found) = known.places.get(&place) {
            return found;
        }
        let derivative = match self.graph.places[place] {
            Place::Grid { .. } => {
                let one = Some(self.number(1.0));
                if known.axis == Axis::U { [one, None] } else { [None, one] }
            }
            Place::Shifted { base, .. } => self.place_derivative(base, known),
            Place::Moved { base, dx, dy } => {
                let [u, v] = self.place_derivative(base, known);
                let of = |id: Id| known.steps.get(&id).copied().flatten();
                let (du, dv) = (of(dx), of(dy));
                [self.sum(u, du), self.sum(v, dv)]
            }
        };
        known.places.insert(place, derivative);
        derivative
    }

    fn chain(&mut self, [u, v]: [Option<Id>; 2], slope: impl Fn(Axis) -> Step) -> Option<Id> {
        let along = |builder: &mut Self, axis, moved: Option<Id>| {
            moved.map(|moved| {
                let slope = builder.push(slope(axis));
                builder.scaled(slope, moved)
            })
        };
        let (u, v) = (along(self, Axis::U, u), along(self, Axis::V, v));
        self.sum(u, v)
    }

    fn sum(&mut self, a: Option<Id>, b: Option<Id>) -> Option<Id> {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.binary(Binary::Plus, a, b)),
            (one, other) => one.or(other),
        }
    }

    fn difference_of(&mut self, a: Option<Id>, b: Option<Id>) -> Option<Id> {
        match (a, b) {
            (Some(a), Some(b)) => Some(self.binary(Binary::Minus, a, b)),
            (a, None) => a,
            (None, Some(b)) => Some(self.unary(Unary::Negative, b)),
        }
    }

    /// The product; a factor of 1 is left out.
    fn scaled(&mut self, a: Id, by: Id) -> Id {
        match (self.graph.number(a), self.graph.number(by)) {
            (Some(1.0), _) => by,
            (_, Some(1.0)) => a,
            _ => self.binary(Binary::Multiply, a, by),
        }
    }

    /// `a` where the mask is above 0, else `b`.
    fn either(&mut self, mask: Id, a: Option<Id>, b: Option<Id>) -> Option<Id> {
        if a.is_none() && b.is_none() {
            return None;
        }
        let zero = self.number(0.0);
        Some(self.push(Step::Select(mask, a.unwrap_or(zero), b.unwrap_or(zero))))
    }

    fn unary_derivative(&mut self, operation: Unary, id: Id, a: Id, da: Id) -> Id {
        match operation {
            Unary::Sin => {
                let cos = self.unary(Unary::Cos, a);
                self.scaled(cos, da)
            }
            Unary::Cos => {
                let sin = self.unary(Unary::Sin, a);
                let minus = self.unary(Unary::Negative, sin);
                self.scaled(minus, da)
            }
            Unary::Tan => {
                // 1 + tan²
                let (one, square) = (self.number(1.0), self.binary(Binary::Multiply, id, id));
                let factor = self.binary(Binary::Plus, one, square);
                self.scaled(factor, da)
            }
            Unary::Atan => {
                let (one, square) = (self.number(1.0), self.binary(Binary::Multiply, a, a));
                let divisor = self.binary(Binary::Plus, one, square);
                self.binary(Binary::Divide, da, divisor)
            }
            Unary::Negative => self.unary(Unary::Negative, da),
            Unary::Log => self.binary(Binary::Divide, da, a),
            Unary::Abs => self.with_sign_of(a, da),
            Unary::Sqrt => {
                let (two, signed) = (self.number(2.0), self.with_sign_of(a, da));
                let divisor = self.binary(Binary::Multiply, two, id);
                self.binary(Binary::Divide, signed, divisor)
            }
        }
    }

    fn with_sign_of(&mut self, a: Id, da: Id) -> Id {
        let negative = self.unary(Unary::Negative, da);
        self.push(Step::Select(a, da, negative))
    }

    fn binary_derivative(&mut self, operation: Binary, id: Id, [a, b]: [Id; 2], [da, db]: [Option<Id>; 2]) -> Option<Id> {
        match operation {
            Binary::Plus => self.sum(da, db),
            Binary::Minus => self.difference_of(da, db),
            Binary::Multiply => {
                let (left, right) = (da.map(|da| self.scaled(da, b)), db.map(|db| self.scaled(a, db)));
                self.sum(left, right)
            }
            Binary::Divide => {
                // (a' - (a / b) b') / b
                let right = db.map(|db| self.scaled(id, db));
                self.difference_of(da, right).map(|top| self.binary(Binary::Divide, top, b))
            }
            Binary::Power => {
                // a^b (b a' / a + b' ln a)
                let base = da.map(|da| {
                    let top = self.scaled(b, da);
                    self.binary(Binary::Divide, top, a)
                });
                let exponent = db.map(|db| {
                    let log = self.unary(Unary::Log, a);
                    self.scaled(db, log)
                });
                self.sum(base, exponent).map(|factor| self.scaled(id, factor))
            }
            Binary::Mod => {
                // a' - ⌊a / b⌋ b', and ⌊a / b⌋ = (a - mod) / b
                let right = db.map(|db| {
                    let top = self.binary(Binary::Minus, a, id);
                    let floor = self.binary(Binary::Divide, top, b);
                    self.scaled(floor, db)
                });
                self.difference_of(da, right)
            }
            Binary::Min => {
                let mask = self.binary(Binary::Minus, a, b);
                self.either(mask, db, da)
            }
            Binary::Max => {
                let mask = self.binary(Binary::Minus, b, a);
                self.either(mask, db, da)
            }
        }
    }
}
