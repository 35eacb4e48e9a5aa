//! Programmes as JSON: `{"op":"fbm","args":[1.0, 1.97, 2],"basis":"o_perlin"}`, numbers bare, `"x"` for a bare terminal.

use super::{
    MAX_DEPTH, MAX_NODES,
    error::ParseError,
    node::Node,
    operation::Signature,
    syntax::{Call, Kind, MAX_ARGUMENTS, Named, Syntax},
};
use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value, json};
use std::{cell::RefCell, fmt};

/// A programme in JSON.
pub(super) enum Document {
    /// A string that holds programme text.
    Text(String),
    Tree(Syntax),
}

pub(super) fn parse(json: &str) -> Result<Document, ParseError> {
    if let Ok(text) = serde_json::from_str::<String>(json) {
        return Ok(Document::Text(text));
    }
    let reading = RefCell::new(Reading::default());
    let mut deserializer = serde_json::Deserializer::from_str(json);
    // Depth is bounded below, by the programme's own limit: a node takes two levels of JSON.
    deserializer.disable_recursion_limit();
    let tree = Tree(&reading).deserialize(&mut deserializer).and_then(|tree| deserializer.end().map(|()| tree));
    tree.map(Document::Tree).map_err(|error| {
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or(&message);
        ParseError::new(reading.into_inner().path.concat(), None, message)
    })
}

/// Where the reader is; after an error, where it stopped.
#[derive(Default)]
struct Reading {
    path: Vec<String>,
    nodes: usize,
}

#[derive(Clone, Copy)]
struct Tree<'a>(&'a RefCell<Reading>);

impl Tree<'_> {
    fn enter(self, step: String) {
        self.0.borrow_mut().path.push(step);
    }

    fn leave(self) {
        self.0.borrow_mut().path.pop();
    }

    fn count<E: Error>(self) -> Result<(), E> {
        let mut reading = self.0.borrow_mut();
        reading.nodes += 1;
        if reading.nodes > MAX_NODES {
            return Err(E::custom(format!("more than {MAX_NODES} nodes")));
        }
        if reading.path.len() >= MAX_DEPTH {
            return Err(E::custom(format!("nested deeper than {MAX_DEPTH} nodes")));
        }
        Ok(())
    }
}

fn bare(kind: Kind) -> Syntax {
    Syntax { kind, span: None }
}

fn name(name: &str) -> Syntax {
    bare(Kind::Call(Call { name: name.to_owned(), name_span: None, positional: Vec::new(), named: Vec::new() }))
}

impl<'de> DeserializeSeed<'de> for Tree<'_> {
    type Value = Syntax;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Syntax, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Tree<'_> {
    type Value = Syntax;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, the name of a terminal, or {\"op\": …, \"args\": […]}")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Syntax, E> {
        Ok(bare(Kind::Number(number + 0.0)))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Syntax, E> {
        self.visit_f64(number as f64)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Syntax, E> {
        self.visit_f64(number as f64)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Syntax, E> {
        Ok(name(if value { "true" } else { "false" }))
    }

    fn visit_str<E: Error>(self, written: &str) -> Result<Syntax, E> {
        self.count()?;
        Ok(name(written))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Syntax, A::Error> {
        self.count()?;
        let (mut op, mut positional, mut named) = (None::<String>, None, Vec::<Named>::new());
        while let Some(key) = map.next_key::<String>()? {
            self.enter(format!("/{key}"));
            match key.as_str() {
                "op" if op.is_none() => op = Some(map.next_value()?),
                "args" if positional.is_none() => {
                    self.leave();
                    positional = Some(map.next_value_seed(Arguments(self.0))?);
                    continue;
                }
                _ if matches!(key.as_str(), "op" | "args") || named.iter().any(|other| other.name == key) => {
                    return Err(A::Error::custom(format!("{key:?} is given twice")));
                }
                _ if named.len() >= MAX_ARGUMENTS => return Err(A::Error::custom(format!("more than {MAX_ARGUMENTS} arguments"))),
                _ => named.push(Named { name: key, name_span: None, value: map.next_value_seed(self)? }),
            }
            self.leave();
        }
        let name = op.ok_or_else(|| A::Error::custom("\"op\" is missing: a call is {\"op\": …, \"args\": […]}"))?;
        Ok(bare(Kind::Call(Call { name, name_span: None, positional: positional.unwrap_or_default(), named })))
    }
}

struct Arguments<'a>(&'a RefCell<Reading>);

impl<'de> DeserializeSeed<'de> for Arguments<'_> {
    type Value = Vec<Syntax>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<Syntax>, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Arguments<'_> {
    type Value = Vec<Syntax>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of arguments")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Vec<Syntax>, A::Error> {
        let (tree, mut all) = (Tree(self.0), Vec::new());
        tree.enter("/args/0".to_owned());
        while let Some(argument) = seq.next_element_seed(tree)? {
            all.push(argument);
            tree.leave();
            tree.enter(format!("/args/{}", all.len()));
            if all.len() > MAX_ARGUMENTS {
                return Err(A::Error::custom(format!("more than {MAX_ARGUMENTS} arguments")));
            }
        }
        tree.leave();
        Ok(all)
    }
}

/// The canonical JSON of a node: positional arguments in `args`, only what differs from a default beside it.
pub(super) fn to_value(node: &Node) -> Value {
    let Some(signature) = Signature::of(node.operation) else { return number(node.value.parameters[0]) };
    let mut args: Vec<Value> = node.children.iter().map(to_value).collect();
    let mut object = Map::new();
    for (parameter, &n) in signature.parameters.iter().zip(&node.value.parameters) {
        match parameter.default {
            None => args.push(number(n)),
            Some(default) if default != n => _ = object.insert(parameter.name.to_owned(), number(n)),
            Some(_) => {}
        }
    }
    for (choice, &chosen) in signature.choices.iter().zip(&node.value.choices) {
        if chosen != 0 {
            let value = choice.values[chosen];
            object.insert(choice.name.to_owned(), value.parse::<bool>().map_or_else(|_| json!(value), |flag| json!(flag)));
        }
    }
    if let Some(seed) = node.value.seed {
        object.insert("seed".to_owned(), json!(seed));
    }
    if args.is_empty() && object.is_empty() {
        return json!(signature.name);
    }
    object.insert("op".to_owned(), json!(signature.name));
    if !args.is_empty() {
        object.insert("args".to_owned(), Value::Array(args));
    }
    Value::Object(object)
}

/// Whole numbers without a point, as in the canonical text.
fn number(n: f64) -> Value {
    if n.fract() == 0.0 && n.abs() < 9_007_199_254_740_992.0 { json!(n as i64) } else { json!(n) }
}

#[cfg(test)]
mod tests {
    use crate::programme::{MAX_DEPTH, Programme};

    fn check(json: &str, expected: &str) {
        let got = Programme::parse_json(json).map_or_else(|error| error.to_string(), |programme| programme.to_string());
        assert_eq!(got, expected, "{json}");
    }

    #[test]
    fn trees_are_read_and_their_errors_placed() {
        check(r#"{"op":"fbm","args":[1.0, 1.97, 2],"basis":"o_perlin"}"#, "fbm(1, 1.97, 2)");
        check(r#""plus(x, 1)""#, "plus(x, 1)");
        check(r#"{"op":"plus","args":["x", {"op":"turbulence","args":[3,0.5,2],"hard":true}]}"#, "plus(x, turbulence(3, 0.5, 2, hard=true))");
        check(r#"{"op":"plus","args":["x", {"op":"fmb","args":[1]}]}"#, "at /args/1: unknown function \"fmb\" (did you mean \"fbm\"?)");
        check(r#"{"op":"plus","args":["x", {"args":[1]}]}"#, "at /args/1: \"op\" is missing: a call is {\"op\": …, \"args\": […]}");
        check(
            r#"{"op":"plus","args":["x", null]}"#,
            "at /args/1: invalid type: null, expected a number, the name of a terminal, or {\"op\": …, \"args\": […]}",
        );
        check(r#"{"op":"plus","args":["x", "y"],"op":"minus"}"#, "at /op: \"op\" is given twice");
        check(r#"{"op":"sin","args":"x"}"#, "invalid type: string \"x\", expected an array of arguments");
        check(r#"{"op":"plus","args":["x", "#, "at /args/1: EOF while parsing a value");
        check("7", "7");
    }

    #[test]
    fn depth_and_width_are_bounded() {
        let nested = |depth: usize| format!("{}\"x\"{}", r#"{"op":"abs","args":["#.repeat(depth), "]}".repeat(depth));
        assert!(Programme::parse_json(&nested(MAX_DEPTH - 1)).is_ok());
        let error = Programme::parse_json(&nested(100_000)).expect_err("too deep");
        assert_eq!(error.message, "nested deeper than 256 nodes");
        let arrays = "[".repeat(500_000);
        assert!(Programme::parse_json(&arrays).is_err());
    }
}
