//! The members of small JSON objects, taken out one by one so that all problems are found and none is overlooked.

use super::problem::Problems;
use serde_json::{Map, Value};

/// The members of an object that were not taken yet.
pub(super) struct Members {
    map: Map<String, Value>,
    pub(super) pointer: String,
    known: Vec<&'static str>,
}

impl Members {
    /// The members of an object; `what` it is goes into the problem if it is none.
    pub(super) fn of(value: Value, pointer: &str, what: &str, problems: &mut Problems) -> Option<Self> {
        match value {
            Value::Object(map) => Some(Self { map, pointer: pointer.to_owned(), known: Vec::new() }),
            other => {
                problems.add(pointer, format!("must be {what}, got {}", shown(&other)));
                None
            }
        }
    }

    /// Where a member stands.
    pub(super) fn at(&self, name: &str) -> String {
        format!("{}/{}", self.pointer, escaped(name))
    }

    /// A member, if it is there; `null` counts as not there.
    pub(super) fn take(&mut self, name: &'static str) -> Option<Value> {
        self.known.push(name);
        self.map.remove(name).filter(|value| !value.is_null())
    }

    /// A member that must be there.
    pub(super) fn need(&mut self, name: &'static str, what: &str, problems: &mut Problems) -> Option<Value> {
        let value = self.take(name);
        if value.is_none() {
            problems.add(self.at(name), format!("is missing: {what}"));
        }
        value
    }

    /// A number, if it is there.
    pub(super) fn number(&mut self, name: &'static str, problems: &mut Problems) -> Option<f64> {
        let value = self.take(name)?;
        value.as_f64().or_else(|| number(&value, &self.at(name), problems))
    }

    /// A whole number from 0 to `most`, if it is there.
    pub(super) fn whole(&mut self, name: &'static str, most: u64, problems: &mut Problems) -> Option<u64> {
        let value = self.take(name)?;
        let float = value.as_f64().filter(|f| f.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(f));
        let whole = value.as_u64().or(float.map(|f| f as u64)).filter(|whole| *whole <= most);
        if whole.is_none() {
            problems.add(self.at(name), format!("must be a whole number 0 … {most}, got {}", shown(&value)));
        }
        whole
    }

    /// One of some names, if it is there.
    pub(super) fn choice<T: Copy>(&mut self, name: &'static str, choices: &[(&str, T)], problems: &mut Problems) -> Option<T> {
        let value = self.take(name)?;
        let found = value.as_str().and_then(|text| choices.iter().find(|(name, _)| *name == text));
        if found.is_none() {
            let all: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
            let near = value.as_str().and_then(|text| near(text, &all)).unwrap_or_default();
            problems.add(self.at(name), format!("must be one of {}, got {}{near}", all.join(", "), shown(&value)));
        }
        found.map(|(_, choice)| *choice)
    }

    /// Says that nothing else belongs here.
    pub(super) fn done(self, problems: &mut Problems) {
        for name in self.map.keys() {
            let near = near(name, &self.known).unwrap_or_default();
            problems.add(self.at(name), format!("is no member that belongs here; there are {}{near}", self.known.join(", ")));
        }
    }

    /// What was not taken.
    pub(super) fn rest(self) -> Map<String, Value> {
        self.map
    }
}

/// A number.
pub(super) fn number(value: &Value, pointer: &str, problems: &mut Problems) -> Option<f64> {
    let number = value.as_f64();
    if number.is_none() {
        problems.add(pointer, format!("must be a number, got {}", shown(value)));
    }
    number
}

/// A value as a problem shows it.
pub(super) fn shown(value: &Value) -> String {
    match value {
        Value::Object(_) => "an object".to_owned(),
        Value::Array(_) => "a list".to_owned(),
        Value::String(text) if text.chars().count() > 64 => format!("{:?} …", text.chars().take(64).collect::<String>()),
        other => other.to_string(),
    }
}

/// " (did you mean …?)" if one of the names is nearly what was written.
pub(super) fn near(written: &str, names: &[&str]) -> Option<String> {
    if written.len() > 64 {
        return None;
    }
    let (distance, name) = names.iter().map(|name| (strsim::damerau_levenshtein(written, name), name)).min()?;
    (distance <= (written.len() / 3).max(1)).then(|| format!(" (did you mean {name:?}?)"))
}

/// A name as a step of a JSON pointer.
pub(super) fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}
