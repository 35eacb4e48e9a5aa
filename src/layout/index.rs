//! A set of features, found by where they reach.

use super::{ContentHash, Feature, Field, Value, content, field, runs::Runs};
use crate::geometry::{Rectangle, Shape, Window};
use rayon::prelude::*;
use rstar::{AABB, RTree, RTreeObject};
use std::collections::BTreeMap;

/// Why features do not make a layout.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LayoutError {
    /// Attributes of one name whose values are not of one kind.
    #[error("the values of attribute {0:?} are of different kinds: all must be numbers, vectors of one length, or names")]
    Kinds(String),
    /// More features than there may be.
    #[error("{0} features are more than the {max} allowed", max = MAX_FEATURES)]
    TooMany(usize),
    /// A default value that does not fit its attribute.
    #[error("the default of {0:?} must be one number for each component of the attribute")]
    Default(String),
}

/// Most features of a layout.
const MAX_FEATURES: usize = 2_000_000;

/// Nanoseconds to find a feature's edges near the blocks it reaches, and to add it to a sample that its influence rectangle holds.
const FEATURE_NS: f64 = 12_000.0;
const FEATURE_SAMPLE_NS: f64 = 8.0;

/// By how much a level of priority above 0 replaces what is below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mix {
    /// The largest weight of the level, at most 1.
    #[default]
    Max,
    /// The sum of the level's weights, at most 1.
    Sum,
}

/// What a layout needs to know beside its features.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// How higher levels are mixed in.
    pub mix: Mix,
    /// Elevation of the sea's surface in metres: ground below it is under water.
    pub sea_level: Option<f64>,
    /// What attributes of the user's own are where no feature says anything; features fade into it as elevations fade into the base. Without one they do not fade,
    /// and where no feature reaches the value is 0.
    pub defaults: BTreeMap<String, Vec<f64>>,
}

/// Features that can be evaluated.
#[derive(Clone, Debug)]
pub struct Layout {
    /// In the order of their hashes.
    pub(super) features: Box<[Feature]>,
    pub(super) fields: Box<[Field]>,
    pub(super) options: Options,
    /// Of each feature, the number of its set of attributes.
    pub(super) sets: Box<[u32]>,
    /// Trees over the edges of features that have many.
    pub(super) runs: BTreeMap<u32, Box<Runs>>,
    tree: RTree<Entry>,
    /// Features that reach everywhere.
    everywhere: Box<[u32]>,
    /// Outside of it only those have influence.
    bounds: Rectangle,
    /// Of what all features are.
    content: ContentHash,
    /// Square metres of all influence rectangles together.
    reached: f64,
}

/// Where a feature reaches.
#[derive(Clone, Copy, Debug)]
struct Entry {
    envelope: AABB<[f64; 2]>,
    feature: u32,
}

impl RTreeObject for Entry {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        self.envelope
    }
}

/// Where all features reach.
struct Reaches {
    tree: RTree<Entry>,
    everywhere: Box<[u32]>,
    bounds: Rectangle,
    reached: f64,
}

impl Reaches {
    fn of(features: &[Feature]) -> Self {
        let (mut entries, mut everywhere) = (Vec::with_capacity(features.len()), Vec::new());
        for (feature, number) in features.iter().zip(0..) {
            let bounds = reach(feature);
            if bounds == Rectangle::EVERYTHING {
                everywhere.push(number);
            } else if !feature.attributes().is_empty() {
                entries.push(Entry { envelope: AABB::from_corners(bounds.min, bounds.max), feature: number });
            }
        }
        let rectangle = |entry: &Entry| Rectangle { min: entry.envelope.lower(), max: entry.envelope.upper() };
        let bounds = entries.iter().fold(Rectangle::EMPTY, |all, entry| all.union(rectangle(entry)));
        let reached = entries.iter().map(|entry| area(&rectangle(entry))).sum();
        Self { tree: RTree::bulk_load(entries), everywhere: everywhere.into(), bounds, reached }
    }
}

/// What else a layout knows of its features.
struct Rest {
    fields: Box<[Field]>,
    sets: Box<[u32]>,
    runs: BTreeMap<u32, Box<Runs>>,
    content: ContentHash,
}

impl Rest {
    fn of(features: &[Feature], options: &Options) -> Result<Self, LayoutError> {
        let fields = field::fields(features)?;
        for (name, values) in &options.defaults {
            let field = fields.iter().find(|field| *field.name == **name);
            let numbers = values.iter().all(|value| value.is_finite());
            if !numbers || field.is_some_and(|field| !matches!(field.kind, super::FieldKind::Numbers(count) if count == values.len())) {
                return Err(LayoutError::Default(name.clone()));
            }
        }
        let runs = features.iter().zip(0..).filter_map(|(feature, number)| Some((number, Runs::new(feature.shape().curve()?)?))).collect();
        Ok(Self { fields, sets: sets(features), runs, content: content::of_features(features.iter()) })
    }
}

impl Layout {
    /// Puts features in order and indexes them; `O(n log n)`.
    ///
    /// # Errors
    /// If there are too many features, or attributes of one name have values of different kinds.
    pub fn new(mut features: Vec<Feature>, options: Options) -> Result<Self, LayoutError> {
        check_count(&features)?;
        features.sort_by_key(Feature::hash);
        let (reaches, rest) = (Reaches::of(&features), Rest::of(&features, &options)?);
        Ok(Self::of_parts(features, options, reaches, rest))
    }

    /// As [`Layout::new`], the same layout on the threads of the present pool. Not for callers that hold a lock: meanwhile their thread may do other work.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub fn new_parallel(mut features: Vec<Feature>, options: Options) -> Result<Self, LayoutError> {
        check_count(&features)?;
        features.par_sort_by_key(Feature::hash);
        let (reaches, rest) = rayon::join(|| Reaches::of(&features), || Rest::of(&features, &options));
        Ok(Self::of_parts(features, options, reaches, rest?))
    }

    fn of_parts(features: Vec<Feature>, options: Options, reaches: Reaches, rest: Rest) -> Self {
        let (Reaches { tree, everywhere, bounds, reached }, Rest { fields, sets, runs, content }) = (reaches, rest);
        Self { features: features.into(), fields, options, sets, runs, tree, everywhere, bounds, content, reached }
    }

    /// The features, in the order of their hashes.
    #[must_use]
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// What the features say something about, `elevation` and `water_depth` always among it, in lexical order.
    #[must_use]
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// How it is merged.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Whether any feature can have influence in an area.
    #[must_use]
    pub fn reaches(&self, area: &Rectangle) -> bool {
        !self.everywhere.is_empty() || self.tree.locate_in_envelope_intersecting(AABB::from_corners(area.min, area.max)).next().is_some()
    }

    /// The name of the content of all features that can have influence in an area; `None` if there are none. Whatever changes terrain in the area changes it.
    #[must_use]
    pub fn content_in(&self, area: &Rectangle) -> Option<ContentHash> {
        if self.is_all_within(area) {
            return (!self.features.is_empty()).then_some(self.content);
        }
        let mut found = Vec::new();
        self.find(area, &mut found);
        (!found.is_empty()).then(|| content::of_features(found.iter().map(|&number| &self.features[number as usize])))
    }

    fn is_all_within(&self, area: &Rectangle) -> bool {
        area.holds(self.bounds.min) && area.holds(self.bounds.max)
    }

    /// The predicted time to evaluate a window on one thread, in nanoseconds.
    #[must_use]
    pub fn cost_ns(&self, window: &Window) -> f64 {
        let (bounds, samples) = (window.bounds(), window.samples() as f64);
        let square = window.spacing() * window.spacing();
        let everywhere = self.everywhere.len() as f64 * samples;
        let (count, reached) = if self.is_all_within(&bounds) {
            (self.features.len() as f64, self.reached / square)
        } else {
            let envelope = AABB::from_corners(bounds.min, bounds.max);
            let found = self.tree.locate_in_envelope_intersecting(envelope).map(|entry| {
                let (low, high) = (entry.envelope.lower(), entry.envelope.upper());
                let side = |axis: usize| high[axis].min(bounds.max[axis]) - low[axis].max(bounds.min[axis]);
                side(0) * side(1)
            });
            found.fold((0.0, 0.0), |(count, sum), area| (count + 1.0, sum + area / square))
        };
        FEATURE_NS * count + FEATURE_SAMPLE_NS * (reached + everywhere)
    }

    /// Numbers of the features that can have influence in an area, ascending: those whose influence rectangle meets it, and those that reach everywhere.
    pub fn find(&self, area: &Rectangle, found: &mut Vec<u32>) {
        found.clear();
        found.extend_from_slice(&self.everywhere);
        found.extend(self.tree.locate_in_envelope_intersecting(AABB::from_corners(area.min, area.max)).map(|entry| entry.feature));
        found.sort_unstable();
    }
}

fn check_count(features: &[Feature]) -> Result<(), LayoutError> {
    if features.len() > MAX_FEATURES { Err(LayoutError::TooMany(features.len())) } else { Ok(()) }
}

fn area(rectangle: &Rectangle) -> f64 {
    (rectangle.max[0] - rectangle.min[0]) * (rectangle.max[1] - rectangle.min[1])
}

/// Numbers of sets of attributes, equal for equal contents.
fn sets(features: &[Feature]) -> Box<[u32]> {
    let mut numbers = BTreeMap::new();
    let number = |feature: &Feature| {
        let next = numbers.len() as u32;
        *numbers.entry(feature.attributes().hash()).or_insert(next)
    };
    features.iter().map(number).collect()
}

/// A rectangle outside of which a feature has no influence.
fn reach(feature: &Feature) -> Rectangle {
    let reach = feature.attributes().reach();
    if reach.is_infinite() {
        return Rectangle::EVERYTHING;
    }
    feature.shape().bounds(reach)
}

/// Metres from a shape beyond which nothing about it is asked but on which side a point lies; infinite if values depend on the distance inside.
pub(super) fn farthest(feature: &Feature) -> f64 {
    let closed = matches!(feature.shape(), Shape::Polygon(_) | Shape::Circle { .. });
    let sees = |value: &Value| match value {
        Value::Number(_) | Value::Vector(_) | Value::Name(_) => false,
        Value::Terrain(terrain) => terrain.over_shape,
        Value::Shape | Value::Profile(_) | Value::Expression(_) => true,
    };
    if closed && feature.attributes().iter().any(|attribute| sees(&attribute.value)) {
        return f64::INFINITY;
    }
    feature.attributes().reach()
}
