//! Generators of features as documents name them.

use super::{Setting, seeds::Seeds};
use crate::{
    layout::{
        AttributeError, Feature,
        generate::{Conflict, GenerateError, Ground, Island, Lakes, Landmass, Ridges, Rivers, Styles, resolve},
        geojson::Sets,
    },
    noise,
    world::problem::{Checks, drop_nulls, read_value},
};
use serde_json::{Map, Value, json};
use std::{collections::BTreeMap, sync::Arc};

/// Metres between the places of a ridges' diagram, as a share of the rivers' spacing, where the document does not say.
const RIDGE_STEP: f64 = 160.0 / 650.0;

/// The precedence of features that are there already: they are never cut.
const GIVEN: i32 = i32::MAX;

/// What has a style of its own.
const STYLES: [&str; 4] = ["land", "rivers", "lakes", "ridges"];

/// A generator with its parameters and seed.
#[derive(Clone, Debug)]
pub(super) enum Generator {
    /// All of the following in a row.
    Island(Island),
    /// An outline.
    Landmass(Landmass),
    /// Rivers, and lakes on them, on the land that comes before.
    Rivers(Rivers, Option<Lakes>),
    /// Ridges between all that comes before.
    Ridges(Ridges),
}

/// A generator, and the seed that is hashed with the world's.
#[derive(Clone, Debug)]
pub(super) struct Seeded {
    pub generator: Generator,
    pub seed: u64,
    /// Features drawn by hand that it starts from.
    seeds: Seeds,
    /// Names of sets of attributes to take in the place of the usual ones, by what they are for.
    styles: BTreeMap<String, String>,
}

/// Features that generators made so far.
#[derive(Default)]
pub(super) struct Made {
    pub land: Vec<Feature>,
    pub waters: Vec<Feature>,
    pub others: Vec<Feature>,
    /// Waters drawn by hand: they are there already, and ridges that would cross them are cut.
    given: Vec<Feature>,
    /// Metres between rivers, which the styles of all are made for.
    spacing: Option<f64>,
    /// Metres that a ridge keeps from what it would cross.
    clearance: Option<f64>,
}

impl Seeded {
    /// Reads what stands at a pointer, `{"generate": "island", …}`; problems are added to the checks.
    pub(super) fn read(mut value: Value, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Self> {
        let object = value.as_object_mut()?;
        drop_nulls(object);
        let name = object.remove("generate");
        let seed = object.remove("seed").map_or(Some(0), |seed| seed.as_u64().or(seed.as_f64().filter(|f| f.fract() == 0.0 && *f >= 0.0).map(|f| f as u64)));
        let Some(seed) = seed.filter(|&seed| seed < 1 << 53) else {
            checks.add(&format!("{at}/seed"), "expected a whole number 0 … 9007199254740991");
            return None;
        };
        let styles: BTreeMap<String, String> = match object.remove("styles") {
            Some(styles) => read_value(styles, &format!("{at}/styles"), checks)?,
            None => BTreeMap::new(),
        };
        if let Some(unknown) = styles.keys().find(|key| !STYLES.contains(&key.as_str())) {
            checks.add(&format!("{at}/styles/{unknown}"), format!("unknown field `{unknown}`, expected one of `{}`", STYLES.join("`, `")));
            return None;
        }
        let name = name.as_ref().and_then(Value::as_str);
        let seeds = Seeds::take(name.unwrap_or_default(), object, at, setting, checks)?;
        let generator = match name {
            Some("island") => Self::island(object, Ground::Island, at, setting, checks)?,
            Some("massif") => Self::island(object, Ground::Massif, at, setting, checks)?,
            Some("landmass") => {
                object.entry("elevation").or_insert(json!(setting.sea_level));
                Generator::Landmass(read_value(value, at, checks)?)
            }
            Some("rivers") => {
                let lakes = object.remove("lakes");
                let lakes = if let Some(lakes) = lakes { Some(read_value(lakes, &format!("{at}/lakes"), checks)?) } else { None };
                Generator::Rivers(read_value(value, at, checks)?, lakes)
            }
            Some("ridges") => Generator::Ridges(read_value(value, at, checks)?),
            Some("roads") => {
                checks.add(
                    &format!("{at}/generate"),
                    "roads lie over finished terrain: ask POST /worlds/{world}/generate for them, and add what it answers to the features",
                );
                return None;
            }
            Some("lakes") => {
                checks.add(&format!("{at}/generate"), "lakes lie on rivers: give the generator of rivers the parameter \"lakes\": {}");
                return None;
            }
            _ => {
                checks.add(&format!("{at}/generate"), "must be \"island\", \"massif\", \"landmass\", \"rivers\" or \"ridges\"");
                return None;
            }
        };
        Some(Self { generator, seed, seeds, styles })
    }

    fn island(object: &mut Map<String, Value>, ground: Ground, at: &str, setting: &Setting, checks: &mut Checks) -> Option<Generator> {
        let part = |name: &str, default: &str, number: &dyn Fn(&Map<String, Value>) -> f64| {
            let own = object.get(name).cloned().unwrap_or_else(|| json!({}));
            let Value::Object(mut fields) = own else { return own };
            drop_nulls(&mut fields);
            if !default.is_empty() && !fields.contains_key(default) {
                fields.insert(default.to_owned(), json!(number(object)));
            }
            Value::Object(fields)
        };
        let spacing = |island: &Map<String, Value>| island.get("rivers").and_then(|rivers| rivers.get("spacing")).and_then(Value::as_f64);
        let foot = if ground == Ground::Island { setting.sea_level } else { 0.0 };
        let landmass = part("landmass", "elevation", &|_| foot);
        let ridges = part("ridges", "step", &|island| RIDGE_STEP * spacing(island).unwrap_or(Rivers::default().spacing));
        let rivers = part("rivers", "", &|_| 0.0);
        let lakes = object.get("lakes").cloned();
        if ground == Ground::Massif && lakes.is_some() {
            checks.add(&format!("{at}/lakes"), "a massif has no water: leave it out");
            return None;
        }
        if let Some(unknown) = object.keys().find(|key| !["landmass", "rivers", "lakes", "ridges"].contains(&key.as_str())) {
            let detail = format!("unknown field `{unknown}`, expected one of `generate`, `seed`, `landmass`, `rivers`, `lakes`, `ridges`");
            checks.add(&format!("{at}/{unknown}"), detail);
            return None;
        }
        let landmass = read_value(landmass, &format!("{at}/landmass"), checks);
        let rivers = read_value(rivers, &format!("{at}/rivers"), checks);
        let ridges = read_value(ridges, &format!("{at}/ridges"), checks);
        let lakes = lakes.map(|lakes| read_value(lakes, &format!("{at}/lakes"), checks));
        let lakes = if let Some(lakes) = lakes { Some(lakes?) } else { None };
        Some(Generator::Island(Island { landmass: landmass?, rivers: rivers?, lakes, ridges: ridges?, ground }))
    }

    /// The completed document.
    pub(super) fn to_json(&self) -> Value {
        let (name, parameters) = match &self.generator {
            Generator::Island(Island { landmass, rivers, lakes, ridges, ground }) => {
                let mut all = json!({"landmass": landmass, "rivers": rivers, "ridges": ridges});
                if let (Some(lakes), Value::Object(all)) = (lakes, &mut all) {
                    all.insert("lakes".to_owned(), json!(lakes));
                }
                (if *ground == Ground::Island { "island" } else { "massif" }, all)
            }
            Generator::Landmass(landmass) => ("landmass", json!(landmass)),
            Generator::Rivers(rivers, lakes) => {
                let mut all = json!(rivers);
                if let (Some(lakes), Value::Object(all)) = (lakes, &mut all) {
                    all.insert("lakes".to_owned(), json!(lakes));
                }
                ("rivers", all)
            }
            Generator::Ridges(ridges) => ("ridges", json!(ridges)),
        };
        let mut all = json!({"generate": name, "seed": self.seed});
        if let (Value::Object(all), Value::Object(parameters)) = (&mut all, parameters) {
            all.extend(parameters);
            all.extend(self.seeds.to_json());
            if !self.styles.is_empty() {
                all.insert("styles".to_owned(), json!(self.styles));
            }
        }
        all
    }

    /// Styles with the document's own sets of attributes.
    fn styled(&self, mut styles: Styles, sets: &Sets) -> Result<Styles, GenerateError> {
        let Styles { land, rivers, lakes, ridges } = &mut styles;
        for (name, style) in STYLES.iter().zip([land, rivers, lakes, ridges]) {
            if let Some(set) = self.styles.get(*name) {
                let unknown = || AttributeError { name: set.clone(), message: "no set of attributes has this name".to_owned() };
                style.attributes = Arc::clone(sets.get(set).ok_or_else(unknown)?);
            }
        }
        Ok(styles)
    }

    /// Adds its features to those that were made before.
    pub(super) fn make(&self, made: &mut Made, sets: &Sets, setting: &Setting) -> Result<(), GenerateError> {
        let seed = noise::key(setting.seed, self.seed);
        let styles = |spacing: f64| self.styled(Styles::for_sea(spacing, seed, setting.sea_level)?, sets);
        match &self.generator {
            Generator::Island(island) => made.others.extend(island.features(seed, &self.styled(island.styles(seed, setting.sea_level)?, sets)?)?),
            Generator::Landmass(landmass) => {
                let spacing = made.spacing.unwrap_or(landmass.radius / 20.0).max(1.0);
                made.land.extend(landmass.features(seed, &styles(spacing)?.land)?);
            }
            Generator::Rivers(rivers, lakes) => {
                made.spacing = Some(rivers.spacing);
                let styles = styles(rivers.spacing)?;
                let lakes = lakes.as_ref().map(|lakes| (lakes, &styles.lakes));
                let land = if self.seeds.land.is_empty() { &made.land } else { &self.seeds.land };
                made.waters.extend(rivers.features(land, &self.seeds.drawn, lakes, seed, &styles.rivers)?);
            }
            Generator::Ridges(ridges) => {
                let spacing = made.spacing.unwrap_or(ridges.step / RIDGE_STEP);
                made.clearance = Some(ridges.step);
                let land = if self.seeds.land.is_empty() { &made.land } else { &self.seeds.land };
                let waters = [&made.waters[..], &self.seeds.waters].concat();
                made.others.extend(ridges.features(land, &waters, seed, &styles(spacing)?.ridges)?);
                made.given.extend(self.seeds.waters.iter().cloned());
            }
        }
        Ok(())
    }
}

impl Made {
    /// All features, those cut that ridges would cross.
    pub(super) fn features(self) -> Result<Vec<Feature>, GenerateError> {
        let all = [self.land, self.waters, self.others].concat();
        let Some(clearance) = self.clearance else { return Ok(all) };
        let given = self.given.into_iter().map(|mut feature| {
            feature.precedence = GIVEN;
            feature
        });
        let kept = resolve(&given.chain(all).collect::<Vec<_>>(), Conflict::Cut { clearance })?;
        Ok(kept.into_iter().filter(|feature| feature.precedence != GIVEN).collect())
    }
}

/// Adds the problem of a generator that stands alone at a pointer.
pub(in crate::world) fn generator_problem(error: &GenerateError, at: &str, checks: &mut Checks) {
    problem(error, at, false, checks);
}

/// Adds the problem of a generator that stands at a pointer; `nested` if its parameters stand in objects of their generators' names.
pub(super) fn problem(error: &GenerateError, at: &str, nested: bool, checks: &mut Checks) {
    let text = error.to_string();
    let (place, detail) = text.split_once(": ").unwrap_or(("", &text));
    let (generator, parameter) = place.split_once('.').unwrap_or((place, ""));
    let parameter = parameter.replace(['.', '['], "/").replace(']', "");
    let pointer = match (nested, parameter.as_str()) {
        (_, "") => at.to_owned(),
        (true, parameter) => format!("{at}/{generator}/{parameter}"),
        (false, parameter) => format!("{at}/{parameter}"),
    };
    checks.add(&pointer, detail);
}
