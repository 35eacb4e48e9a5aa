//! From what was written to nodes: names, arity, ranges.

use super::{
    MAX_DEPTH, MAX_NODES,
    error::{ParseError, shortened, suggestion},
    node::{Node, Value},
    operation::{Choice, MAX_SEED, Operation, Parameter, Signature},
    syntax::{Call, Kind, Syntax},
};
use std::ops::Range;

pub(super) fn resolve(syntax: &Syntax) -> Result<Node, ParseError> {
    let root = expression(syntax, "")?;
    let error = |message| Err(ParseError::new("", syntax.span.clone(), message));
    match (root.size(), root.depth()) {
        (size, _) if size > MAX_NODES => error(format!("{size} nodes are more than the {MAX_NODES} allowed")),
        (_, depth) if depth > MAX_DEPTH => error(format!("nested deeper than {MAX_DEPTH} nodes")),
        _ => Ok(root),
    }
}

fn expression(syntax: &Syntax, at: &str) -> Result<Node, ParseError> {
    match &syntax.kind {
        Kind::Number(number) => constant(*number, syntax, at),
        Kind::Call(call) => node(call, syntax, at),
    }
}

fn constant(number: f64, syntax: &Syntax, at: &str) -> Result<Node, ParseError> {
    if number.abs() > f64::from(f32::MAX) {
        return Err(ParseError::new(at, syntax.span.clone(), format!("{number:e} is too large: values are f32, at most ±3.4e38")));
    }
    Ok(Node { operation: Operation::Constant, value: Value { parameters: vec![number], choices: Vec::new(), seed: None }, children: Vec::new() })
}

/// `const(0.3)`, the long form of `0.3`.
fn written_constant(call: &Call, syntax: &Syntax, at: &str) -> Result<Node, ParseError> {
    match (&call.positional[..], &call.named[..]) {
        ([Syntax { kind: Kind::Number(number), .. }], []) => constant(*number, syntax, at),
        _ => Err(ParseError::new(at, syntax.span.clone(), "const takes one number: const(0.3), or 0.3 alone")),
    }
}

fn node(call: &Call, syntax: &Syntax, at: &str) -> Result<Node, ParseError> {
    if call.name == "const" {
        return written_constant(call, syntax, at);
    }
    let signature = Signature::named(&call.name).ok_or_else(|| unknown(call, at))?;
    let arguments = Arguments::new(call, signature, at, syntax.span.clone());
    arguments.check_positional_count()?;
    arguments.check_names()?;
    let subtree = |i: usize, name: &&str| {
        let (argument, place) = arguments.find(Some(i), name).ok_or_else(|| arguments.lacks(name))?;
        expression(argument, &place)
    };
    let children = signature.subtrees.iter().enumerate().map(|(i, name)| subtree(i, name)).collect::<Result<_, _>>()?;
    let parameters = signature.parameters.iter().enumerate().map(|(i, parameter)| arguments.parameter(i, parameter)).collect::<Result<_, _>>()?;
    let choices = signature.choices.iter().enumerate().map(|(i, choice)| arguments.choice(i, choice)).collect::<Result<_, _>>()?;
    let seed = arguments.seed()?;
    Ok(Node { operation: signature.operation, value: Value { parameters, choices, seed }, children })
}

fn unknown(call: &Call, at: &str) -> ParseError {
    let kind = if call.positional.is_empty() && call.named.is_empty() { "name" } else { "function" };
    let near = if call.name.contains('(') {
        ": a string in a tree is the name of a terminal, a call is {\"op\": …, \"args\": […]}".to_owned()
    } else {
        suggestion(&call.name, Signature::all().iter().map(|signature| signature.name))
    };
    ParseError::new(at, call.name_span.clone(), format!("unknown {kind} \"{}\"{near}", shortened(&call.name)))
}

/// The arguments of a call beside what its signature wants.
struct Arguments<'a> {
    call: &'a Call,
    signature: &'static Signature,
    at: &'a str,
    span: Option<Range<usize>>,
    /// Positions of the arguments that stand for the parameters, in their order.
    parameters: Vec<usize>,
    /// Positions of the arguments that stand for the choices, in their order.
    choices: Vec<usize>,
}

impl<'a> Arguments<'a> {
    /// After the subtrees, an argument that is a value of the next choice stands for that choice and any other for the next parameter.
    fn new(call: &'a Call, signature: &'static Signature, at: &'a str, span: Option<Range<usize>>) -> Self {
        let (mut parameters, mut choices) = (Vec::new(), Vec::new());
        for (i, argument) in call.positional.iter().enumerate().skip(signature.subtrees.len()) {
            let chosen = signature.choices.get(choices.len()).is_some_and(|choice| symbol(argument).is_some_and(|symbol| choice.values.contains(&symbol)));
            if chosen { choices.push(i) } else { parameters.push(i) }
        }
        Self { call, signature, at, span, parameters, choices }
    }

    fn error(&self, message: String) -> ParseError {
        ParseError::new(self.at, self.span.clone(), message)
    }

    fn check_positional_count(&self) -> Result<(), ParseError> {
        let wanted = self.signature.subtrees.len() + self.signature.parameters.len();
        let given = self.call.positional.len() - self.choices.len();
        if given <= wanted {
            return Ok(());
        }
        let plural = if wanted == 1 { "argument" } else { "arguments" };
        Err(self.error(format!("{} takes {wanted} {plural}, got {given}: {}", self.signature.name, self.signature.usage())))
    }

    fn names(&self) -> impl Iterator<Item = &'static str> {
        let signature = self.signature;
        let parameters = signature.parameters.iter().map(|p| p.name).chain(signature.choices.iter().map(|c| c.name));
        signature.subtrees.iter().copied().chain(parameters).chain(signature.noise.then_some("seed"))
    }

    fn check_names(&self) -> Result<(), ParseError> {
        for (i, named) in self.call.named.iter().enumerate() {
            let place = format!("{}/{}", self.at, named.name);
            let Some(position) = self.names().position(|name| name == named.name) else {
                let near = suggestion(&named.name, self.names());
                let message = format!("{} has no argument \"{}\"{near}: {}", self.signature.name, shortened(&named.name), self.signature.usage());
                return Err(ParseError::new(place, named.name_span.clone(), message));
            };
            if self.is_positional(position) || self.call.named[..i].iter().any(|other| other.name == named.name) {
                return Err(ParseError::new(place, named.name_span.clone(), format!("\"{}\" is given twice", named.name)));
            }
        }
        Ok(())
    }

    /// Whether the argument of that place in [`Arguments::names`] was given by its position.
    fn is_positional(&self, name: usize) -> bool {
        let (subtrees, parameters) = (self.signature.subtrees.len(), self.signature.parameters.len());
        if name < subtrees {
            name < self.call.positional.len()
        } else if name < subtrees + parameters {
            name - subtrees < self.parameters.len()
        } else {
            name - subtrees - parameters < self.choices.len()
        }
    }

    /// The positional argument at `position` or else the one of a name, and its place.
    fn find(&self, position: Option<usize>, name: &str) -> Option<(&'a Syntax, String)> {
        if let Some((i, argument)) = position.and_then(|i| self.call.positional.get(i).map(|argument| (i, argument))) {
            return Some((argument, format!("{}/args/{i}", self.at)));
        }
        let named = self.call.named.iter().find(|named| named.name == name)?;
        Some((&named.value, format!("{}/{name}", self.at)))
    }

    fn lacks(&self, name: &str) -> ParseError {
        self.error(format!("{} lacks its argument \"{name}\": {}", self.signature.name, self.signature.usage()))
    }

    fn parameter(&self, i: usize, parameter: &Parameter) -> Result<f64, ParseError> {
        match (self.find(self.parameters.get(i).copied(), parameter.name), parameter.default) {
            (Some((argument, place)), _) => number(argument, &place, parameter.name, parameter.min, parameter.max),
            (None, Some(default)) => Ok(default),
            (None, None) => Err(self.lacks(parameter.name)),
        }
    }

    fn choice(&self, i: usize, choice: &Choice) -> Result<usize, ParseError> {
        let Some((argument, place)) = self.find(self.choices.get(i).copied(), choice.name) else { return Ok(0) };
        let written = match &argument.kind {
            Kind::Number(number) => number.to_string(),
            Kind::Call(call) => symbol(argument).map_or_else(|| format!("{}(…)", call.name), str::to_owned),
        };
        choice.values.iter().position(|value| *value == written).ok_or_else(|| {
            let near = suggestion(&written, choice.values.iter().copied());
            let message = format!("{} must be one of {}, got \"{}\"{near}", choice.name, choice.values.join(", "), shortened(&written));
            ParseError::new(place, argument.span.clone(), message)
        })
    }

    fn seed(&self) -> Result<Option<u32>, ParseError> {
        let Some((argument, place)) = self.find(None, "seed") else { return Ok(None) };
        let seed = number(argument, &place, "seed", 0.0, MAX_SEED)?;
        if seed.fract() != 0.0 {
            return Err(ParseError::new(place, argument.span.clone(), format!("seed must be a whole number, got {seed}")));
        }
        Ok(Some(seed as u32))
    }
}

/// A name without arguments.
fn symbol(argument: &Syntax) -> Option<&str> {
    match &argument.kind {
        Kind::Call(call) if call.positional.is_empty() && call.named.is_empty() => Some(&call.name),
        _ => None,
    }
}

fn number(argument: &Syntax, place: &str, name: &str, min: f64, max: f64) -> Result<f64, ParseError> {
    let error = |message: String| Err(ParseError::new(place, argument.span.clone(), message));
    match &argument.kind {
        Kind::Number(number) if (min..=max).contains(number) => Ok(*number),
        Kind::Number(number) => error(format!("{name} must be {min} … {max}, got {number}")),
        Kind::Call(call) => error(format!("{name} must be a number ({min} … {max}), not \"{}\": parameters are plain numbers", call.name)),
    }
}
