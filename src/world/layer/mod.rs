//! What lies above the base: layers, each a source of terrain with a way to lie over what is below.

mod adaptive;
mod blend;
mod detail;
mod drawing;
mod generator;
mod ground;
mod item;
mod mask;
mod seeds;
mod source;

pub(super) use blend::Below;
pub use blend::Blend;
pub(super) use generator::generator_problem;
pub use mask::Mask;

use super::{Document, name::check_name, number::whole, object::Object, parts::Parts, problem::Checks, revision::Revision};
use crate::{
    evolve::Generation,
    geometry::{Filter, PLANE_LIMIT, Rectangle, Window},
    layout::{
        Layout,
        geojson::{Collection, Drawn, FeatureSet, Sets},
    },
    programme::Programme,
};
use ground::Ground;
use item::{Item, generate};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use source::{Completed, Drawing, WrittenSource, complete};
use std::{collections::BTreeSet, sync::Arc};

/// Most layers of a world.
const MAX_LAYERS: usize = 64;

/// Most materials of a world: what one byte a sample can tell apart, with one number for none.
const MAX_MATERIALS: usize = 255;

/// A completed layer of a world. Its terrain is made when the document is read and shared by all that read the same layer.
#[derive(Clone, Debug, Serialize)]
pub struct Layer {
    /// Its name, like none of the others.
    pub name: String,
    /// Where its terrain comes from, as completed JSON.
    pub source: serde_json::Value,
    /// How it lies over what is below.
    pub blend: Blend,
    /// Layers are evaluated in ascending priority, of equal priority in their order.
    pub priority: i32,
    /// Where it shows; everywhere without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<Mask>,
    /// Metres inside the mask's border over which the layer comes up to its full strength.
    #[serde(serialize_with = "whole")]
    pub fade: f64,
    /// Where it shows, also where the source alone says so.
    #[serde(skip)]
    shown: Option<Mask>,
    #[serde(skip)]
    ground: Ground,
    #[serde(skip)]
    features: Drawing,
    /// The name of all that the document says of the layer but the features.
    #[serde(skip)]
    form: Revision,
}

impl PartialEq for Layer {
    fn eq(&self, other: &Self) -> bool {
        let of = |layer: &Self| (layer.name.clone(), layer.source.clone(), layer.blend, layer.priority, layer.mask.clone(), layer.fade.to_bits());
        of(self) == of(other)
    }
}

/// A layer as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenLayer<'a> {
    name: String,
    #[serde(borrow)]
    source: Object<WrittenSource<'a>>,
    blend: Option<Blend>,
    priority: Option<i32>,
    mask: Option<Object<Mask>>,
    fade: Option<f64>,
}

/// What layers need to know of their world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setting<'a> {
    pub seed: u64,
    pub sea_level: f64,
    /// Stored parts that it may name.
    pub parts: &'a Parts,
}

impl WrittenLayer<'_> {
    fn complete(self, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Layer> {
        let before = checks.0.len();
        if let Err(detail) = check_name("a layer's name", &self.name) {
            checks.add(&format!("{at}/name"), detail);
        }
        checks.range(&format!("{at}/fade"), self.fade.unwrap_or(0.0), 0.0, PLANE_LIMIT);
        let mask = self.mask.map(|Object(mask)| mask);
        if let Some(mask) = &mask
            && let Err(detail) = mask.check()
        {
            checks.add(&format!("{at}/mask/polygon"), detail);
        }
        let Completed { source, ground, features } = complete(self.source.0, &format!("{at}/source"), setting, checks)?;
        let (blend, priority) = (self.blend.unwrap_or_default(), self.priority.unwrap_or(0));
        let generation = ground.generation();
        let fade = self.fade.unwrap_or_else(|| generation.map_or(0.0, |generation| adaptive::fade(generation)));
        let shown = generation.map_or_else(|| mask.clone(), |generation| Some(adaptive::shown(generation, mask.as_ref(), at, checks)));
        let form = Revision::of(&(blend, &mask, fade, ground.form()));
        (checks.0.len() == before).then_some(Layer { name: self.name, source, blend, priority, mask, fade, shown, ground, features, form })
    }
}

/// Checks and completes the layers of a document.
pub(super) fn layers(written: Vec<Object<WrittenLayer>>, setting: &Setting, checks: &mut Checks) -> Vec<Layer> {
    if written.len() > MAX_LAYERS {
        checks.add("/layers", format!("must be at most {MAX_LAYERS} layers, got {}", written.len()));
        return Vec::new();
    }
    let mut names = BTreeSet::new();
    let mut layers = Vec::new();
    for (i, Object(layer)) in written.into_iter().enumerate() {
        let at = format!("/layers/{i}");
        if !names.insert(layer.name.clone()) {
            checks.add(&format!("{at}/name"), format!("{:?} is the name of another layer", layer.name));
        }
        layers.extend(layer.complete(&at, setting, checks));
    }
    let materials = materials(&layers).len();
    if materials > MAX_MATERIALS {
        checks.add("/layers", format!("all layers together may name {MAX_MATERIALS} materials, these name {materials}"));
    }
    layers
}

/// The materials that layers know of, in lexical order.
pub(super) fn materials(layers: &[Layer]) -> Vec<Box<str>> {
    let all: BTreeSet<Box<str>> = layers.iter().flat_map(|layer| layer.ground.materials().iter().cloned()).collect();
    all.into_iter().collect()
}

/// Makes the features of generators, items of a list with their numbers, as they would be drawn. They may name features and sets of attributes of the world.
pub(super) fn generated(world: &Document, items: Vec<(usize, Value)>, at: &dyn Fn(usize) -> String, checks: &mut Checks) -> Option<Collection> {
    let setting = Setting { seed: world.seed, sea_level: world.sea_level, parts: &Parts::default() };
    let (before, sets) = (checks.0.len(), known_sets(world));
    let (mut seeded, mut numbers) = (Vec::new(), Vec::new());
    for (i, mut item) in items {
        if item.get("generate").is_none() {
            checks.add(&at(i), "expected {\"generate\": …}");
            continue;
        }
        if !seeds::resolve(&mut item, &at(i), world, checks) {
            continue;
        }
        seeded.extend(Item::read(&item.to_string(), &at(i), &Sets::default(), &setting, checks));
        numbers.push(i);
    }
    if checks.0.len() > before {
        return None;
    }
    let features = generate(&seeded, &sets, &|k| at(numbers[k]), &setting, checks)?;
    Collection::of(&features)
}

/// The feature of an id, in the first layer that has one.
pub(super) fn find_feature<'a>(world: &'a Document, id: &str) -> Option<&'a Drawn> {
    world.layers.iter().flat_map(Layer::drawn).find_map(|set| Some(&set.collection().features[set.position(id)?]))
}

/// The sets of attributes of a world by name; of several of one name the first.
pub(super) fn known_sets(world: &Document) -> Sets {
    let mut known = Sets::default();
    let sets = world.layers.iter().flat_map(|layer| std::iter::once(layer.attributes()).chain(layer.drawn().map(|set| &set.collection().sets)));
    for (name, set) in sets.flat_map(Sets::iter) {
        if known.get(name).is_none() {
            known.insert(name, Arc::clone(set));
        }
    }
    known
}

impl Layer {
    /// The sets of attributes that its features share.
    #[must_use]
    pub fn attributes(&self) -> &Sets {
        &self.features.attributes
    }

    /// The first stored set of features that it names, and which item of its list names it.
    #[must_use]
    pub fn stored(&self) -> Option<(usize, &Arc<FeatureSet>)> {
        self.features.stored.as_ref().map(|(i, set)| (*i, set))
    }

    /// All its features as they were drawn, and those that generators made. Features without end are not among them.
    pub fn drawn(&self) -> impl Iterator<Item = &Arc<FeatureSet>> + '_ {
        let generated = match &self.ground {
            Ground::Layout { generated, .. } => Some(generated),
            Ground::Scatter(_) | Ground::Raised(..) => None,
        };
        self.features.drawn.iter().chain(generated)
    }

    /// The programme that lies between the nodes of its heights.
    pub(super) fn detail(&self) -> Option<&Programme> {
        match &self.ground {
            Ground::Raised(_, Some(detail)) => Some(&detail.base().programme),
            _ => None,
        }
    }

    /// The generation of ground that evolves, if it is that.
    #[must_use]
    pub fn generation(&self) -> Option<&Arc<Generation>> {
        self.ground.generation()
    }

    /// The islands of a layer without end that samples so far apart show in an area; none where they would be many.
    #[must_use]
    pub fn islands(&self, area: &Rectangle, spacing: f64) -> Vec<Arc<Layout>> {
        match &self.ground {
            Ground::Layout { .. } | Ground::Raised(..) => Vec::new(),
            Ground::Scatter(scatter) => scatter.islands(area, spacing),
        }
    }

    /// Of each of its own numbers of materials, that in a list of all.
    pub(super) fn numbers(&self, all: &[Box<str>]) -> Vec<u16> {
        let number = |name: &str| all.partition_point(|known| **known < *name) as u16 + 1;
        [0].into_iter().chain(self.ground.materials().iter().map(|name| number(name))).collect()
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    pub(super) fn cost_ns(&self, window: &Window) -> f64 {
        if self.shown.as_ref().is_some_and(|mask| !mask.bounds().meets(&window.bounds())) { 0.0 } else { self.ground.cost_ns(window) }
    }

    /// What can change samples in an area, if it is known how far apart they are and which detail they carry; `None` if nothing of the layer reaches it.
    pub(super) fn content_in(&self, area: &Rectangle, samples: Option<(f64, Filter)>) -> Option<String> {
        let bounds = self.shown.as_ref().map_or(Rectangle::EVERYTHING, Mask::bounds);
        if !bounds.meets(area) {
            return None;
        }
        let content = match (self.ground.generation(), samples) {
            (Some(generation), Some((spacing, filter))) => generation.terrain().seen(&bounds.meet(area), spacing, filter),
            (Some(generation), None) => generation.terrain().seen(&Rectangle::EVERYTHING, 0.0, Filter::Exact),
            (None, _) => self.ground.content_in(area)?.0,
        };
        let content: String = content.iter().map(|byte| format!("{byte:02x}")).collect();
        Some(format!("layer {} {content}", self.form))
    }
}
