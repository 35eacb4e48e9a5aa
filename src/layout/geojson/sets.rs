//! Sets of attributes by name.

use super::{
    attribute::{Written, read_set},
    members::{Members, escaped, near},
    problem::{Problems, ReadError},
};
use crate::layout::AttributeSet;
use serde::{Serialize, Serializer};
use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Most characters of a name.
const LONGEST_NAME: usize = 63;

/// Most sets of one document.
const MOST_SETS: usize = 65_536;

/// Sets of attributes by name: 1 to 63 letters, digits, `-` and `_`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sets(BTreeMap<Box<str>, Arc<AttributeSet>>);

impl Sets {
    /// Reads an object of lists of attributes.
    ///
    /// # Errors
    /// If it is no JSON, or with every problem that could be found.
    pub fn parse(json: &str) -> Result<Self, ReadError> {
        let mut problems = Problems::default();
        let sets = match serde_json::from_str(json) {
            Ok(value) => Self::read(value, "", &mut problems),
            Err(error) => {
                problems.add("", format!("not JSON: {error}"));
                Self::default()
            }
        };
        problems.into_result(sets)
    }

    pub(super) fn read(value: Value, pointer: &str, problems: &mut Problems) -> Self {
        let Some(members) = Members::of(value, pointer, "an object of lists of attributes", problems) else { return Self::default() };
        let all = members.rest();
        if all.len() > MOST_SETS {
            problems.add(pointer, format!("{} sets are more than the {MOST_SETS} allowed", all.len()));
            return Self::default();
        }
        let mut sets = BTreeMap::new();
        for (name, list) in all {
            let at = format!("{pointer}/{}", escaped(&name));
            if name.is_empty() || name.len() > LONGEST_NAME || !name.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_')) {
                problems.add(&at, format!("the name of a set has 1 to {LONGEST_NAME} letters, digits, - and _"));
            }
            if let Some(set) = read_set(list, &at, problems) {
                sets.insert(name.into(), Arc::new(set));
            }
        }
        Self(sets)
    }

    /// The set of a name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Arc<AttributeSet>> {
        self.0.get(name)
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Arc<AttributeSet>)> + '_ {
        self.0.iter().map(|(name, set)| (&**name, set))
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Gives a set a name; what had it before is answered.
    pub fn insert(&mut self, name: &str, set: Arc<AttributeSet>) -> Option<Arc<AttributeSet>> {
        self.0.insert(name.into(), set)
    }

    /// Leaves only the sets whose names `keep` holds to.
    pub fn retain(&mut self, mut keep: impl FnMut(&str) -> bool) {
        self.0.retain(|name, _| keep(name));
    }

    /// What to say of a name that no set has.
    pub(super) fn unknown(&self, outer: &Self, name: &str) -> String {
        let names: BTreeSet<&str> = self.iter().chain(outer.iter()).map(|(name, _)| name).collect();
        let names: Vec<&str> = names.into_iter().collect();
        let near = near(name, &names).unwrap_or_default();
        let all = if names.is_empty() { "there are none".to_owned() } else { format!("there are {}", names[..names.len().min(20)].join(", ")) };
        format!("no set of attributes is named {name:?}; {all}{near}")
    }
}

impl Serialize for Sets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, set)| (name, set.iter().map(Written).collect::<Vec<_>>())))
    }
}
