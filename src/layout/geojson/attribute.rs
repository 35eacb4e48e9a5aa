//! One attribute, in and out.

use super::{
    members::{Members, near, number, shown},
    number::Plain,
    problem::Problems,
};
use crate::{
    layout::{Attribute, AttributeSet, Expression, Role, Side, TerrainValue, Value, Weight},
    programme::{Frame, ParseError, Programme},
};
use serde::{Serialize, Serializer, ser::SerializeMap};
use serde_json::{Value as Json, json};
use std::sync::Arc;

const SIDES: [(&str, Side); 3] = [("inside", Side::Inside), ("outside", Side::Outside), ("edge", Side::Edge)];
const WEIGHTS: [&str; 4] = ["linear", "sharp", "smooth", "custom"];
const VALUES: [&str; 4] = ["profile", "expression", "programme", "name"];

/// Reads a list of attributes; what is wrong is added to the problems.
pub(super) fn read_set(value: Json, pointer: &str, problems: &mut Problems) -> Option<AttributeSet> {
    let Json::Array(list) = value else {
        problems.add(pointer, format!("must be a list of attributes, got {}", shown(&value)));
        return None;
    };
    let read = |(i, value): (usize, Json)| read(value, &format!("{pointer}/{i}"), problems);
    // All are read before any is missed, so that the problems of all are found.
    let attributes: Vec<Option<Attribute>> = list.into_iter().enumerate().map(read).collect();
    let attributes: Option<Vec<Attribute>> = attributes.into_iter().collect();
    match AttributeSet::new(attributes?) {
        Ok(set) => Some(set),
        Err(error) => {
            problems.add(pointer, error.to_string());
            None
        }
    }
}

fn read(value: Json, pointer: &str, problems: &mut Problems) -> Option<Attribute> {
    let mut members = Members::of(value, pointer, "an attribute such as {\"name\": \"elevation\", \"value\": \"shape\", \"range\": 200}", problems)?;
    let before = problems.count();
    let name = members.need("name", "elevation, water_depth, material or a name of your own", problems);
    let name = name.and_then(|name| text(&name, &members.at("name"), problems));
    let value = members.need("value", "\"shape\", a number, a list of numbers, a name, or an object with profile, expression or programme", problems);
    let value = value.and_then(|value| read_value(value, &members.at("value"), problems));
    let weight = members.take("weight").map_or(Some(Weight::Linear), |weight| read_weight(weight, &members.at("weight"), problems));
    let range = members.need("range", "metres, or \"infinite\"", problems);
    let range = range.and_then(|range| if range == "infinite" { Some(f64::INFINITY) } else { number(&range, &members.at("range"), problems) });
    let side = members.choice("side", &SIDES, problems).unwrap_or_default();
    let fade = members.number("fade", problems);
    let priority = members.whole("priority", u64::from(u8::MAX), problems).unwrap_or_default() as u8;
    let role = members.take("channel").map_or(Some(Role::Level), |channel| read_channel(channel, &members.at("channel"), problems));
    members.done(problems);
    let attribute = Attribute { name: name?.into(), value: value?, weight: weight?, range: range?, side, fade, priority, role: role? };
    if problems.count() == before
        && let Err(error) = AttributeSet::new(vec![attribute.clone()])
    {
        problems.add(pointer, error.to_string());
    }
    (problems.count() == before).then_some(attribute)
}

fn text(value: &Json, pointer: &str, problems: &mut Problems) -> Option<String> {
    let text = value.as_str().map(str::to_owned);
    if text.is_none() {
        problems.add(pointer, format!("must be text, got {}", shown(value)));
    }
    text
}

fn read_channel(value: Json, pointer: &str, problems: &mut Problems) -> Option<Role> {
    let mut members = Members::of(value, pointer, "an object with half_width in metres", problems)?;
    let half_width = members.number("half_width", problems).unwrap_or_default();
    members.done(problems);
    Some(Role::Channel { half_width })
}

/// The one member of an object that says which of some kinds it is.
fn kind(members: &Members, value: &Json, kinds: &[&'static str], problems: &mut Problems) -> Option<&'static str> {
    let found = kinds.iter().find(|kind| value.get(**kind).is_some());
    if found.is_none() {
        let written = value.as_object().and_then(|object| object.keys().next());
        let near = written.and_then(|written| near(written, kinds)).unwrap_or_default();
        problems.add(&members.pointer, format!("must be an object with one of {}{near}", kinds.join(", ")));
    }
    found.copied()
}

fn read_weight(value: Json, pointer: &str, problems: &mut Problems) -> Option<Weight> {
    if let Json::String(name) = &value {
        match &**name {
            "linear" => return Some(Weight::Linear),
            "sharp" => return Some(Weight::sharp()),
            other => {
                let near = near(other, &WEIGHTS).unwrap_or_default();
                let right = r#""linear", "sharp", {"sharp": {"width": 1, "nearest": 0.001}}, {"smooth": {"width": 30}} or {"custom": "an expression in d"}"#;
                problems.add(pointer, format!("must be {right}, got {}{near}", shown(&value)));
                return None;
            }
        }
    }
    let whole = value.clone();
    let mut members = Members::of(value, pointer, "the name of a weight or an object with one of linear, sharp, smooth, custom", problems)?;
    let kind = kind(&members, &whole, &WEIGHTS, problems)?;
    let at = members.at(kind);
    let inner = members.take(kind).unwrap_or_else(|| json!({}));
    members.done(problems);
    if kind == "custom" {
        return expression(&inner, &at, problems).map(Weight::Custom);
    }
    let mut inner = Members::of(inner, &at, "an object with the measures of the weight", problems)?;
    let weight = match kind {
        "sharp" => {
            let (width, nearest) = (inner.number("width", problems), inner.number("nearest", problems));
            Some(Weight::Sharp { width: width.unwrap_or(1.0), nearest: nearest.unwrap_or(0.001) })
        }
        "smooth" => {
            let width = inner.need("width", "metres at which the weight of an infinite range is one half", problems);
            width.and_then(|width| number(&width, &inner.at("width"), problems)).map(|width| Weight::Smooth { width })
        }
        _ => Some(Weight::Linear),
    };
    inner.done(problems);
    weight
}

fn read_value(value: Json, pointer: &str, problems: &mut Problems) -> Option<Value> {
    match value {
        Json::Number(_) => number(&value, pointer, problems).map(Value::Number),
        Json::String(name) if name == "shape" => Some(Value::Shape),
        Json::String(name) => Some(Value::Name(name.into())),
        Json::Array(numbers) => {
            let numbers: Vec<_> = numbers.iter().enumerate().map(|(i, value)| number(value, &format!("{pointer}/{i}"), problems)).collect();
            numbers.into_iter().collect::<Option<Box<[f64]>>>().map(Value::Vector)
        }
        object => read_object(object, pointer, problems),
    }
}

fn read_object(value: Json, pointer: &str, problems: &mut Problems) -> Option<Value> {
    let whole = value.clone();
    let mut members = Members::of(value, pointer, "\"shape\", a number, a list of numbers, a name, or an object", problems)?;
    let kind = kind(&members, &whole, &VALUES, problems)?;
    let at = members.at(kind);
    let inner = members.take(kind).unwrap_or_default();
    let value = match kind {
        "profile" => read_profile(&inner, &at, problems).map(Value::Profile),
        "expression" => expression(&inner, &at, problems).map(Value::Expression),
        "name" => text(&inner, &at, problems).map(|name| Value::Name(name.into())),
        _ => read_terrain(&inner, &mut members, problems).map(|terrain| Value::Terrain(Arc::new(terrain))),
    };
    members.done(problems);
    value
}

fn read_profile(value: &Json, pointer: &str, problems: &mut Problems) -> Option<Box<[[f64; 2]]>> {
    let pair = |pair: &Json| {
        let [a, b] = pair.as_array()?.as_slice() else { return None };
        Some([a.as_f64()?, b.as_f64()?])
    };
    let pairs = value.as_array().and_then(|pairs| pairs.iter().map(pair).collect());
    if pairs.is_none() {
        problems.add(pointer, "must be a list of pairs [distance, value], distances ascending");
    }
    pairs
}

/// Every programme that users write has a budget.
fn within_budget(programme: Result<Programme, ParseError>, pointer: &str, problems: &mut Problems) -> Option<Programme> {
    match programme.and_then(|programme| programme.check_cost().map(|()| programme)) {
        Ok(programme) => Some(programme),
        Err(error) => {
            problems.add(pointer, error.to_string());
            None
        }
    }
}

fn expression(value: &Json, pointer: &str, problems: &mut Problems) -> Option<Expression> {
    match Expression::parse(&text(value, pointer, problems)?) {
        Ok(expression) => {
            within_budget(Programme::parse(&expression.canonical()), pointer, problems)?;
            Some(expression)
        }
        Err(error) => {
            problems.add(pointer, error.to_string());
            None
        }
    }
}

fn read_terrain(programme: &Json, members: &mut Members, problems: &mut Problems) -> Option<TerrainValue> {
    let programme = within_budget(Programme::parse_json(&programme.to_string()), &members.at("programme"), problems);
    let scale = members.need("scale", "metres per programme unit", problems);
    let scale = scale.and_then(|scale| number(&scale, &members.at("scale"), problems));
    let origin = members.take("origin").unwrap_or_else(|| json!([0, 0]));
    let origin = match origin.as_array().map(Vec::as_slice) {
        Some([x, y]) => x.as_f64().zip(y.as_f64()).map(|(x, y)| [x, y]),
        _ => None,
    };
    if origin.is_none() {
        problems.add(members.at("origin"), "must be two numbers of metres, [x, y]");
    }
    let amplitude = members.number("amplitude", problems).unwrap_or(1.0);
    let datum = members.number("datum", problems).unwrap_or_default();
    let seed = members.whole("seed", u64::MAX, problems).unwrap_or_default();
    let over_shape = members.take("over_shape").unwrap_or(Json::Bool(false));
    let flag = over_shape.as_bool();
    if flag.is_none() {
        problems.add(members.at("over_shape"), format!("must be true or false, got {}", shown(&over_shape)));
    }
    let frame = Frame { seed, scale: scale?, origin: origin? };
    Some(TerrainValue { programme: programme?, frame, amplitude, datum, over_shape: flag? })
}

/// An attribute as it is written; what has its default is left out.
pub(super) struct Written<'a>(pub &'a Attribute);

impl Serialize for Written<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Attribute { name, value, weight, range, side, fade, priority, role } = self.0;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("name", name)?;
        map.serialize_entry("value", &value_json(value))?;
        map.serialize_entry("weight", &weight_json(weight))?;
        if range.is_finite() {
            map.serialize_entry("range", &Plain(*range))?;
        } else {
            map.serialize_entry("range", "infinite")?;
        }
        if let Some((name, _)) = SIDES.iter().find(|(_, known)| known == side && *known != Side::Inside) {
            map.serialize_entry("side", name)?;
        }
        if let Some(fade) = fade {
            map.serialize_entry("fade", &Plain(*fade))?;
        }
        if *priority != 0 {
            map.serialize_entry("priority", priority)?;
        }
        if let Role::Channel { half_width } = role {
            map.serialize_entry("channel", &json!({"half_width": Plain(*half_width)}))?;
        }
        map.end()
    }
}

fn weight_json(weight: &Weight) -> Json {
    match weight {
        Weight::Linear => json!("linear"),
        Weight::Sharp { width, nearest } => json!({"sharp": {"width": Plain(*width), "nearest": Plain(*nearest)}}),
        Weight::Smooth { width } => json!({"smooth": {"width": Plain(*width)}}),
        Weight::Custom(expression) => json!({"custom": expression.text()}),
    }
}

fn value_json(value: &Value) -> Json {
    match value {
        Value::Shape => json!("shape"),
        Value::Number(number) => json!(Plain(*number)),
        Value::Vector(numbers) => numbers.iter().map(|number| json!(Plain(*number))).collect(),
        // The one name that stands for something else.
        Value::Name(name) if &**name == "shape" => json!({"name": name}),
        Value::Name(name) => json!(name),
        Value::Profile(pairs) => json!({"profile": pairs.iter().map(|pair| pair.map(Plain)).collect::<Vec<_>>()}),
        Value::Expression(expression) => json!({"expression": expression.text()}),
        Value::Terrain(terrain) => {
            let TerrainValue { programme, frame, amplitude, datum, over_shape } = &**terrain;
            json!({
                "programme": programme.text().map_or_else(|| programme.to_json(), |text| json!(text)),
                "scale": Plain(frame.scale), "origin": frame.origin.map(Plain), "seed": frame.seed,
                "amplitude": Plain(*amplitude), "datum": Plain(*datum), "over_shape": over_shape,
            })
        }
    }
}
