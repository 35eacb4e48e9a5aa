//! A programme as a graph of plain steps: what is left when warps, averages and derivatives are written out, equal subtrees found and lattices assigned.

use super::{
    node::Lattices,
    operation::{Binary, Unary},
    shape::Shape,
    simplify,
    terrace::Terrace,
};
use crate::noise::{Basis, Erosion, FieldShape, key};
use std::{collections::BTreeMap, sync::Arc};

/// Most steps of a programme whose derivatives and averages are written out.
pub(super) const MAX_STEPS: usize = 65_536;

/// The number of a step. A step's operands have lesser numbers.
pub(super) type Id = usize;

/// The number of a place.
pub(super) type PlaceId = usize;

/// A finite number that is told apart by its bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Exact(u64);

impl Exact {
    pub(super) fn new(number: f64) -> Self {
        Self(number.to_bits())
    }

    pub(super) fn get(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// Where a step is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Place {
    /// The sample's programme coordinates, plus a constant.
    Grid { du: Exact, dv: Exact },
    /// A place plus the values of two steps.
    Moved { base: PlaceId, dx: Id, dy: Id },
    /// A moved place plus a constant.
    Shifted { base: PlaceId, du: Exact, dv: Exact },
}

/// The sample itself.
pub(super) const HERE: PlaceId = 0;

/// A noise or fractal of the programme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    pub shape: FieldShape,
    pub basis: Basis,
    pub lattices: Lattices,
    /// Which of the node's noises, where it has more than one.
    pub part: u64,
}

impl Noise {
    /// What its lattices are hashed with in a world of that seed.
    pub(super) fn key(&self, seed: u64) -> u64 {
        let own = self.lattices.key(seed);
        if self.part == 0 { own } else { key(own, self.part) }
    }
}

/// An erosion of the programme, of a value.
#[derive(Clone, Debug)]
pub(super) struct Eroded {
    pub erosion: Erosion,
    pub of: Id,
    /// The number of its networks.
    pub networks: usize,
}

/// The networks of one or more erosions.
#[derive(Clone, Debug)]
pub(super) struct Network {
    /// That with the most lattices.
    pub erosion: Erosion,
    pub lattices: Lattices,
    /// What is eroded: the graph of the node's subtree, with the value that stands in this graph too.
    pub terrain: Arc<Graph>,
    pub of: Id,
}

/// An axis of the programme's plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Axis {
    U,
    V,
}

/// One value of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Step {
    /// The f32 of these bits.
    Number(u32),
    /// The coordinate of a place.
    Coordinate(Axis, PlaceId),
    /// The shape of that number.
    Shape(usize, PlaceId),
    /// Its derivative.
    ShapeSlope(usize, Axis, PlaceId),
    /// The noise of that number.
    Noise(usize, PlaceId),
    /// Its derivative.
    NoiseSlope(usize, Axis, PlaceId),
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    /// The second where the first is above 0, else the third.
    Select(Id, Id, Id),
    Terrace(Terrace, Id),
    TerraceSlope(Terrace, Id),
    /// The erosion of that number of the value.
    Erosion(usize, Id, PlaceId),
}

impl Step {
    /// The place, if the step has one.
    pub(super) fn place(self) -> Option<PlaceId> {
        match self {
            Step::Coordinate(_, place)
            | Step::Shape(_, place)
            | Step::ShapeSlope(_, _, place)
            | Step::Noise(_, place)
            | Step::NoiseSlope(_, _, place)
            | Step::Erosion(_, _, place) => Some(place),
            _ => None,
        }
    }

    /// The steps that it takes its values from, places apart.
    pub(super) fn operands(self) -> impl Iterator<Item = Id> {
        let all = match self {
            Step::Unary(_, a) | Step::Terrace(_, a) | Step::TerraceSlope(_, a) | Step::Erosion(_, a, _) => [Some(a), None, None],
            Step::Binary(_, a, b) => [Some(a), Some(b), None],
            Step::Select(a, b, c) => [Some(a), Some(b), Some(c)],
            _ => [None; 3],
        };
        all.into_iter().flatten()
    }
}

/// The steps of a programme, in an order in which operands come first.
#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    pub steps: Vec<Step>,
    pub places: Vec<Place>,
    pub noises: Vec<Noise>,
    pub shapes: Vec<Shape>,
    pub erosions: Vec<Eroded>,
    pub networks: Vec<Network>,
    pub root: Id,
}

impl Graph {
    /// The steps that a value depends on, itself included, in their order.
    pub(super) fn reachable(&self, root: Id) -> Vec<Id> {
        let (mut seen, mut open) = (vec![false; root + 1], vec![root]);
        while let Some(id) = open.pop() {
            if !std::mem::replace(&mut seen[id], true) {
                open.extend(self.steps[id].operands());
                open.extend(self.moved_by(id));
            }
        }
        (0..=root).filter(|&id| seen[id]).collect()
    }

    /// The steps whose values lead to the place of a step.
    pub(super) fn moved_by(&self, id: Id) -> Vec<Id> {
        let (mut all, mut place) = (Vec::new(), self.steps[id].place());
        while let Some(at) = place {
            place = match self.places[at] {
                Place::Grid { .. } => None,
                Place::Shifted { base, .. } => Some(base),
                Place::Moved { base, dx, dy } => {
                    all.extend([dx, dy]);
                    Some(base)
                }
            };
        }
        all
    }

    pub(super) fn number(&self, id: Id) -> Option<f32> {
        match self.steps[id] {
            Step::Number(bits) => Some(f32::from_bits(bits)),
            _ => None,
        }
    }
}

/// Too many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooLarge;

/// A graph being made. Equal steps are made once.
pub(super) struct Builder {
    pub graph: Graph,
    steps: BTreeMap<Step, Id>,
    places: BTreeMap<Place, PlaceId>,
    simplify: bool,
    /// Steps of the graphs that are eroded.
    kept: usize,
    too_large: bool,
}

impl Builder {
    pub(super) fn new(simplify: bool) -> Self {
        let mut builder = Self { graph: Graph::default(), steps: BTreeMap::new(), places: BTreeMap::new(), simplify, kept: 0, too_large: false };
        builder.grid(0.0, 0.0);
        builder
    }

    /// The graph of a value.
    ///
    /// # Errors
    /// If there were too many steps.
    pub(super) fn finish(mut self, root: Id) -> Result<Graph, TooLarge> {
        self.graph.root = root;
        if self.too_large { Err(TooLarge) } else { Ok(self.graph) }
    }

    /// The number of a step, found or made; with simplification, of a step that has the same value.
    pub(super) fn push(&mut self, step: Step) -> Id {
        let step = match if self.simplify { simplify::simplify(&self.graph, step) } else { simplify::Simple::Step(step) } {
            simplify::Simple::Same(id) => return id,
            simplify::Simple::Step(step) => step,
        };
        if let Some(&id) = self.steps.get(&step) {
            return id;
        }
        if self.graph.steps.len() >= MAX_STEPS {
            self.too_large = true;
            return 0;
        }
        self.graph.steps.push(step);
        self.steps.insert(step, self.graph.steps.len() - 1);
        self.graph.steps.len() - 1
    }

    /// Whether steps were refused; what is made from then on is of no use.
    pub(super) fn is_full(&self) -> bool {
        self.too_large
    }

    pub(super) fn place(&mut self, place: Place) -> PlaceId {
        if let Some(&id) = self.places.get(&place) {
            return id;
        }
        self.graph.places.push(place);
        self.places.insert(place, self.graph.places.len() - 1);
        self.graph.places.len() - 1
    }

    pub(super) fn grid(&mut self, du: f64, dv: f64) -> PlaceId {
        // -0 and 0 are one shift.
        self.place(Place::Grid { du: Exact::new(du + 0.0), dv: Exact::new(dv + 0.0) })
    }

    pub(super) fn shifted(&mut self, base: PlaceId, du: f64, dv: f64) -> PlaceId {
        match self.graph.places[base] {
            _ if du == 0.0 && dv == 0.0 => base,
            Place::Grid { du: a, dv: b } => self.grid(a.get() + du, b.get() + dv),
            Place::Shifted { base, du: a, dv: b } => self.place(Place::Shifted { base, du: Exact::new(a.get() + du), dv: Exact::new(b.get() + dv) }),
            Place::Moved { .. } => self.place(Place::Shifted { base, du: Exact::new(du), dv: Exact::new(dv) }),
        }
    }

    pub(super) fn noise(&mut self, noise: Noise) -> usize {
        let found = self.graph.noises.iter().position(|other| *other == noise);
        found.unwrap_or_else(|| {
            self.graph.noises.push(noise);
            self.graph.noises.len() - 1
        })
    }

    pub(super) fn shape(&mut self, shape: Shape) -> usize {
        let found = self.graph.shapes.iter().position(|other| *other == shape);
        found.unwrap_or_else(|| {
            self.graph.shapes.push(shape);
            self.graph.shapes.len() - 1
        })
    }

    pub(super) fn erode(&mut self, erosion: Erosion, lattices: Lattices, of: Id) -> Id {
        let networks = self.networks(erosion, lattices, of);
        let same = |other: &Eroded| other.erosion == erosion && other.networks == networks;
        let found = self.graph.erosions.iter().position(same);
        let erosion = found.unwrap_or_else(|| {
            self.graph.erosions.push(Eroded { erosion, of, networks });
            self.graph.erosions.len() - 1
        });
        self.push(Step::Erosion(erosion, of, HERE))
    }

    fn networks(&mut self, erosion: Erosion, lattices: Lattices, of: Id) -> usize {
        let same = |other: &Network| other.erosion.shares_networks(&erosion) && other.lattices == lattices && other.of == of;
        if let Some(found) = self.graph.networks.iter().position(same) {
            let most = &mut self.graph.networks[found].erosion;
            most.octaves = most.octaves.max(erosion.octaves);
            return found;
        }
        self.kept += self.graph.steps.len();
        self.too_large |= self.kept > MAX_STEPS;
        let terrain = if self.too_large { Graph::default() } else { Graph { root: of, ..self.graph.clone() } };
        self.graph.networks.push(Network { erosion, lattices, terrain: Arc::new(terrain), of });
        self.graph.networks.len() - 1
    }

    pub(super) fn number(&mut self, number: f32) -> Id {
        self.push(Step::Number(number.to_bits()))
    }

    pub(super) fn unary(&mut self, operation: Unary, a: Id) -> Id {
        self.push(Step::Unary(operation, a))
    }

    pub(super) fn binary(&mut self, operation: Binary, a: Id, b: Id) -> Id {
        self.push(Step::Binary(operation, a, b))
    }
}
