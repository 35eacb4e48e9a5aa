//! Sources of layers: read, checked, completed, made.

use super::{
    Setting,
    generator::{Generator, Made, Seeded, problem},
    ground::Ground,
};
use crate::{
    geometry::PLANE_LIMIT,
    layout::{
        Layout, Mix, Options, Scatter, ScatterOptions,
        geojson::{Collection, ReadError, Sets},
    },
    noise,
    world::{
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

/// The source of a layer as users write it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenSource<'a> {
    #[serde(borrow)]
    layout: WrittenLayout<'a>,
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
    scatter: Option<WrittenScatter<'a>>,
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
pub(super) fn complete(written: WrittenSource, at: &str, setting: &Setting, checks: &mut Checks) -> Option<(Value, Ground)> {
    let (layout, at) = (written.layout, format!("{at}/layout"));
    match (&layout.features, &layout.scatter) {
        (Some(_), None) => features(layout, &at, setting, checks),
        (None, Some(_)) => scatter(layout, &at, setting, checks),
        _ => {
            checks.add(&at, "a layout has either features or scatter");
            None
        }
    }
}

/// One of a layout's features: drawn, stored or generated.
enum Item {
    Drawn(Box<Collection>),
    /// The hash of a stored set of features, and what it stands for.
    Stored(String, Arc<Collection>),
    Generated(Box<Seeded>),
}

impl Item {
    fn read(item: &str, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Self> {
        let value: Value = serde_json::from_str(item).ok()?;
        if value.get("generate").is_some() {
            return Seeded::read(whole_numbers(value), at, setting, checks).map(|seeded| Self::Generated(Box::new(seeded)));
        }
        if let Some(hash) = value.get("set") {
            let hash = hash.as_str().filter(|_| value.as_object().is_some_and(|object| object.len() == 1));
            let found = hash.and_then(|hash| Some((hash, setting.sets.get(hash)?)));
            if found.is_none() {
                checks.add(&format!("{at}/set"), "must be the hash of a stored set of features, and stand alone");
            }
            return found.map(|(hash, set)| Self::Stored(hash.to_owned(), set));
        }
        if value.get("type").is_none() {
            checks.add(at, "must be a GeoJSON Feature or FeatureCollection, {\"generate\": …} or {\"set\": …}");
            return None;
        }
        Collection::parse(item).map_err(|error| unreadable(error, at, checks)).ok().map(|collection| Self::Drawn(Box::new(collection)))
    }

    fn to_json(&self) -> Value {
        match self {
            Self::Drawn(collection) => json!(collection),
            Self::Stored(hash, _) => json!({"set": hash}),
            Self::Generated(seeded) => seeded.to_json(),
        }
    }

    /// Adds its features to those that were made before.
    fn make(&self, made: &mut Made, sets: &Sets, at: &str, setting: &Setting, checks: &mut Checks) -> Option<()> {
        let features = match self {
            Self::Generated(seeded) => {
                let nested = matches!(seeded.generator, Generator::Island(_));
                return seeded.make(made, sets, setting).map_err(|error| problem(&error, at, nested, checks)).ok();
            }
            Self::Drawn(collection) => collection.features(sets),
            Self::Stored(_, collection) => collection.features(sets),
        };
        made.others.extend(features.map_err(|error| unreadable(error, at, checks)).ok()?);
        Some(())
    }
}

/// Adds the problems of features that stand at a pointer.
fn unreadable(error: ReadError, at: &str, checks: &mut Checks) {
    match error {
        ReadError::Invalid(problems) => problems.into_iter().for_each(|problem| checks.add(&format!("{at}{}", problem.pointer), problem.detail)),
        ReadError::Io(error) => checks.add(at, error.to_string()),
    }
}

fn features(written: WrittenLayout, at: &str, setting: &Setting, checks: &mut Checks) -> Option<(Value, Ground)> {
    let before = checks.0.len();
    let sets = written.attributes.map_or_else(|| Ok(Sets::default()), |sets| Sets::parse(sets.get()));
    let sets = sets.map_err(|error| unreadable(error, &format!("{at}/attributes"), checks)).unwrap_or_default();
    let items: Vec<(String, &RawValue)> = written.features.into_iter().flatten().zip(0..).map(|(item, i)| (format!("{at}/features/{i}"), item)).collect();
    let items: Vec<(String, Item)> = items.into_iter().filter_map(|(at, item)| Some((at.clone(), Item::read(item.get(), &at, setting, checks)?))).collect();
    if checks.0.len() > before {
        return None;
    }
    let (mix, base, defaults) = (written.mix.unwrap_or_default(), written.base.unwrap_or_default(), written.defaults.unwrap_or_default());
    let completed: Vec<Value> = items.iter().map(|(_, item)| item.to_json()).collect();
    let source = whole_numbers(json!({"layout": {"attributes": sets, "features": completed, "mix": mix, "base": base, "defaults": defaults}}));
    let ground = made(&source, setting, || {
        let mut made = Made::default();
        // All items are asked, so that every problem is named.
        let all: Vec<Option<()>> = items.iter().map(|(at, item)| item.make(&mut made, &sets, at, setting, checks)).collect();
        all.into_iter().collect::<Option<()>>()?;
        let features = made.features().map_err(|error| problem(&error, at, false, checks)).ok()?;
        let mix = match mix {
            WrittenMix::Max => Mix::Max,
            WrittenMix::Sum => Mix::Sum,
        };
        let layout = Layout::new(features, Options { mix, sea_level: None, defaults }).map_err(|error| checks.add(at, error.to_string())).ok()?;
        Some(Ground::Layout { layout: Arc::new(layout), over_base: base == Beneath::World })
    });
    Some((source, ground?))
}

fn scatter(written: WrittenLayout, at: &str, setting: &Setting, checks: &mut Checks) -> Option<(Value, Ground)> {
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
    let (written, at) = (written.scatter?, format!("{at}/scatter"));
    let before = checks.0.len();
    checks.range(&format!("{at}/cell"), written.cell, 1.0, PLANE_LIMIT / 1024.0);
    let (seed, chance) = (written.seed.unwrap_or(0), written.chance.unwrap_or(1.0));
    if seed >= 1 << 53 {
        checks.add(&format!("{at}/seed"), "expected a whole number 0 … 9007199254740991");
    }
    let value: Value = serde_json::from_str(written.template.get()).ok()?;
    let template_at = format!("{at}/template");
    if value.get("generate").and_then(Value::as_str) != Some("island") {
        checks.add(&format!("{template_at}/generate"), "must be \"island\"");
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
    Some((source, ground?))
}

/// What was made and is still used by some world, by the name of the source and its setting.
type Known = LruCache<Revision, Remembered>;

/// As [`Ground`], while others keep it.
enum Remembered {
    Layout(Weak<Layout>, bool),
    Scatter(Weak<Scatter>),
}

/// Most sources that are remembered.
const REMEMBERED: NonZeroUsize = NonZeroUsize::new(256).expect("not 0");

static KNOWN: LazyLock<Mutex<Known>> = LazyLock::new(|| Mutex::new(LruCache::new(REMEMBERED)));

/// The terrain of a completed source: that of another world or revision with the same, or made now. Which of the two changes nothing but the time.
fn made(source: &Value, setting: &Setting, make: impl FnOnce() -> Option<Ground>) -> Option<Ground> {
    let key = Revision::of(&(source, setting.seed, setting.sea_level));
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let remembered = match known().get(&key) {
        Some(Remembered::Layout(layout, over_base)) => layout.upgrade().map(|layout| Ground::Layout { layout, over_base: *over_base }),
        Some(Remembered::Scatter(scatter)) => scatter.upgrade().map(Ground::Scatter),
        None => None,
    };
    if remembered.is_some() {
        return remembered;
    }
    let ground = make()?;
    let weak = match &ground {
        Ground::Layout { layout, over_base } => Remembered::Layout(Arc::downgrade(layout), *over_base),
        Ground::Scatter(scatter) => Remembered::Scatter(Arc::downgrade(scatter)),
    };
    known().put(key, weak);
    Some(ground)
}
