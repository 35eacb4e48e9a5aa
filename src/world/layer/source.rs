//! Sources of layers: read, checked, completed, made.

use super::{
    Setting,
    adaptive::{self, WrittenAdaptive},
    detail::Detail,
    drawing::{self, WrittenPaths},
    generator::{Generator, Seeded, problem},
    ground::{Ground, Heights, Raised},
    item::{Item, generate},
};
use crate::{
    geometry::PLANE_LIMIT,
    layout::{
        Layout, Mix, Options, Scatter, ScatterOptions,
        geojson::{Collection, FeatureSet, Sets},
    },
    noise,
    world::{
        base::WrittenBase,
        object::Object,
        problem::{Checks, whole_numbers},
        revision::Revision,
    },
};
use lru::LruCache;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json, value::RawValue};
use std::{
    collections::BTreeMap,
    num::NonZeroUsize,
    sync::{Arc, LazyLock, Mutex, PoisonError, Weak},
};

/// Fewer features than these are not worth other threads.
const FEW: usize = 4096;

/// The source of a layer as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSource<'a> {
    #[serde(borrow)]
    layout: Option<Object<WrittenLayout<'a>>>,
    paths: Option<Object<WrittenPaths>>,
    raster: Option<Object<WrittenRaster>>,
    adaptive: Option<Object<WrittenAdaptive>>,
    #[serde(borrow)]
    detail: Option<Object<WrittenBase<'a>>>,
}

/// Stored heights as users write them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenRaster {
    hash: String,
}

/// The features of a layer that were drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawing {
    /// Sets of attributes that all of them share.
    pub attributes: Sets,
    /// The features of every item that was drawn, in the order of the items.
    pub drawn: Vec<Arc<FeatureSet>>,
    /// The first stored set, and which item it is.
    pub stored: Option<(usize, Arc<FeatureSet>)>,
}

/// A completed source.
pub(super) struct Completed {
    pub source: Value,
    pub ground: Ground,
    pub features: Drawing,
}

/// What lies beneath the features of a layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Beneath {
    /// What is below the layer.
    #[default]
    World,
    /// Nothing: where a feature reaches at all it decides alone.
    None,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum WrittenMix {
    #[default]
    Max,
    Sum,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenLayout<'a> {
    #[serde(borrow)]
    attributes: Option<&'a RawValue>,
    #[serde(borrow)]
    features: Option<Vec<&'a RawValue>>,
    #[serde(borrow)]
    scatter: Option<Object<WrittenScatter<'a>>>,
    mix: Option<WrittenMix>,
    base: Option<Beneath>,
    defaults: Option<BTreeMap<String, Vec<f64>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenScatter<'a> {
    cell: f64,
    seed: Option<u64>,
    chance: Option<f64>,
    scale: Option<[f64; 2]>,
    far_spacing: Option<f64>,
    #[serde(borrow)]
    template: &'a RawValue,
}

/// Checks and completes a source; makes its terrain unless that is there already or something is wrong.
pub(super) fn complete(mut written: WrittenSource, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let detail = written.detail.take();
    let mut completed = without_detail(written, at, setting, checks);
    if let Some(Object(detail)) = detail {
        let at = format!("{at}/detail");
        if detail.amplitude.is_none() {
            checks.add(&format!("{at}/amplitude"), "is needed: metres of elevation per unit of the programme's value");
        }
        let detail = detail.complete(&at, checks)?;
        let completed = completed.as_mut()?;
        let own = match &mut completed.ground {
            Ground::Raised(raised, own) if !matches!(raised.heights, Heights::Shadow(_)) => own,
            _ => {
                checks.add(&at, "has no meaning beside a layout or a shadow");
                return None;
            }
        };
        completed.source.as_object_mut()?.insert("detail".to_owned(), whole_numbers(json!(detail)));
        *own = Some(Arc::new(Detail::new(detail, setting.seed)));
    }
    completed
}

fn without_detail(written: WrittenSource, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let layout = match (written.layout, written.paths, written.raster, written.adaptive) {
        (Some(Object(layout)), None, None, None) => layout,
        (None, Some(Object(paths)), None, None) => return drawing::complete(paths, &format!("{at}/paths"), setting, checks),
        (None, None, Some(Object(raster)), None) => return stored(&raster, &format!("{at}/raster"), setting, checks),
        (None, None, None, Some(Object(adaptive))) => return adaptive::complete(adaptive, &format!("{at}/adaptive"), setting, checks),
        _ => {
            checks.add(at, "a source is either a layout, paths, a raster or adaptive");
            return None;
        }
    };
    let at = format!("{at}/layout");
    match (&layout.features, &layout.scatter) {
        (Some(_), None) => features(layout, &at, setting, checks),
        (None, Some(_)) => scatter(layout, &at, setting, checks),
        _ => {
            checks.add(&at, "a layout has either features or scatter");
            None
        }
    }
}

fn stored(written: &WrittenRaster, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let hash = &written.hash;
    let Some(raster) = setting.parts.raster(hash) else {
        checks.add(&format!("{at}/hash"), format!("must be the hash of a stored raster, which a job makes; got {hash:?}"));
        return None;
    };
    let raised = Raised { heights: Heights::Finite(Arc::clone(raster)), form: format!("raster 1 {hash}") };
    Some(Completed { source: json!({"raster": {"hash": hash}}), ground: Ground::Raised(Arc::new(raised), None), features: Drawing::default() })
}

fn features(written: WrittenLayout, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    let before = checks.0.len();
    let attributes = match written.attributes.map_or(Ok(Sets::default()), |json| Sets::parse(json.get())) {
        Ok(sets) => sets,
        Err(error) => {
            checks.geojson(&format!("{at}/attributes"), error);
            return None;
        }
    };
    let mut items = Vec::new();
    for (i, item) in written.features.into_iter().flatten().enumerate() {
        items.extend(Item::read(item.get(), &format!("{at}/features/{i}"), &attributes, setting, checks));
    }
    if checks.0.len() > before {
        return None;
    }
    let (mix, base, defaults) = (written.mix.unwrap_or_default(), written.base.unwrap_or_default(), written.defaults.unwrap_or_default());
    let completed: Vec<Value> = items.iter().map(Item::to_json).collect();
    let source = whole_numbers(json!({"layout": {"attributes": attributes, "features": completed, "mix": mix, "base": base, "defaults": defaults}}));
    let ground = made(&source, setting, || {
        let mut features = generate(&items, &attributes, &|i| format!("{at}/features/{i}"), setting, checks)?;
        // Generated features are as anybody could have drawn them: their detail is lazy.
        let generated = Arc::new(Collection::of(&features)?.into());
        for (i, item) in items.iter().enumerate() {
            let Some(set) = item.drawn() else { continue };
            features.extend(set.collection().features(&attributes).map_err(|error| checks.geojson(&format!("{at}/features/{i}"), error)).ok()?);
        }
        let mix = match mix {
            WrittenMix::Max => Mix::Max,
            WrittenMix::Sum => Mix::Sum,
        };
        let new = if features.len() < FEW { Layout::new } else { Layout::new_parallel };
        let layout = new(features, Options { mix, sea_level: None, defaults }).map_err(|error| checks.add(at, error.to_string())).ok()?;
        Some(Ground::Layout { layout: Arc::new(layout), over_base: base == Beneath::World, generated })
    })?;
    let stored = items.iter().enumerate().find_map(|(i, item)| if let Item::Stored(..) = item { Some((i, Arc::clone(item.drawn()?))) } else { None });
    let drawn = items.iter().filter_map(|item| item.drawn().cloned()).collect();
    Some(Completed { source, ground, features: Drawing { attributes, drawn, stored } })
}

fn scatter(written: WrittenLayout, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Completed> {
    for (field, given) in [
        ("attributes", written.attributes.is_some()),
        ("mix", written.mix.is_some()),
        ("base", written.base.is_some()),
        ("defaults", written.defaults.is_some()),
    ] {
        if given {
            checks.add(&format!("{at}/{field}"), "has no meaning beside scatter");
        }
    }
    let (Object(written), at) = (written.scatter?, format!("{at}/scatter"));
    let before = checks.0.len();
    checks.range(&format!("{at}/cell"), written.cell, 1.0, PLANE_LIMIT / 1024.0);
    let (seed, chance) = (written.seed.unwrap_or(0), written.chance.unwrap_or(1.0));
    if seed >= 1 << 53 {
        checks.add(&format!("{at}/seed"), "expected a whole number 0 … 9007199254740991");
    }
    let value: Value = serde_json::from_str(written.template.get()).ok()?;
    let template_at = format!("{at}/template");
    if !matches!(value.get("generate").and_then(Value::as_str), Some("island" | "massif")) {
        checks.add(&format!("{template_at}/generate"), "must be \"island\" or \"massif\"");
        return None;
    }
    for field in ["seed", "styles", "landmass/centre"] {
        if value.pointer(&format!("/{field}")).is_some_and(|value| !matches!(value, Value::Array(pair) if pair.iter().all(|c| c.as_f64() == Some(0.0)))) {
            checks.add(&format!("{template_at}/{field}"), "is the cell's: leave it out");
        }
    }
    let template = Seeded::read(whole_numbers(value), &template_at, setting, checks)?;
    let Generator::Island(island) = &template.generator else { return None };
    let options = ScatterOptions {
        cell: written.cell,
        seed: noise::key(setting.seed, seed),
        chance,
        scale: written.scale.unwrap_or([1.0, 1.0]),
        far_spacing: written.far_spacing.unwrap_or(written.cell / 32.0),
        sea_level: setting.sea_level,
    };
    if checks.0.len() > before {
        return None;
    }
    let mut template_json = template.to_json();
    template_json.as_object_mut()?.remove("seed");
    let completed = json!({
        "cell": options.cell, "seed": seed, "chance": chance, "scale": options.scale, "far_spacing": options.far_spacing, "template": template_json
    });
    let source = whole_numbers(json!({"layout": {"scatter": completed}}));
    let ground = made(&source, setting, || {
        let scatter = Scatter::new(island.clone(), options);
        scatter
            .map(|scatter| Ground::Scatter(Arc::new(scatter)))
            .map_err(|error| {
                let own = error.to_string().starts_with("scatter.");
                problem(&error, if own { &at } else { &template_at }, !own, checks);
            })
            .ok()
    });
    Some(Completed { source, ground: ground?, features: Drawing::default() })
}

/// What was made and is still used by some world, by the name of the source and its setting.
type Known = LruCache<Revision, Remembered>;

/// As [`Ground`], while others keep it.
enum Remembered {
    Layout(Weak<Layout>, bool, Weak<FeatureSet>),
    Scatter(Weak<Scatter>),
    Raised(Weak<Raised>),
}

/// Most sources that are remembered.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(256).expect("not 0");

static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(|| Mutex::new(LruCache::new(REMEMBERED)));

/// The terrain of a completed source: that of another world or revision with the same, or made now. Which of the two changes nothing but the time.
pub(super) fn made(source: &Value, setting: &Setting, make: impl FnOnce() -> Option<Ground>) -> Option<Ground> {
    let key = Revision::of(&(source, setting.seed, setting.sea_level));
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let remembered = match known().get(&key) {
        Some(Remembered::Layout(layout, over_base, generated)) => {
            layout.upgrade().zip(generated.upgrade()).map(|(layout, generated)| Ground::Layout { layout, over_base: *over_base, generated })
        }
        Some(Remembered::Scatter(scatter)) => scatter.upgrade().map(Ground::Scatter),
        Some(Remembered::Raised(raised)) => raised.upgrade().map(|raised| Ground::Raised(raised, None)),
        None => None,
    };
    if remembered.is_some() {
        return remembered;
    }
    let ground = make()?;
    let weak = match &ground {
        Ground::Layout { layout, over_base, generated } => Remembered::Layout(Arc::downgrade(layout), *over_base, Arc::downgrade(generated)),
        Ground::Scatter(scatter) => Remembered::Scatter(Arc::downgrade(scatter)),
        Ground::Raised(raised, _) => Remembered::Raised(Arc::downgrade(raised)),
    };
    known().put(key, weak);
    Some(ground)
}
