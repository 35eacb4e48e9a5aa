//! What a layout says something about: the attributes of all its features by name.

use super::{Attribute, Feature, LayoutError, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Attributes of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The name.
    pub name: Box<str>,
    /// What its values are.
    pub kind: FieldKind,
}

/// What the values of a field are.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldKind {
    /// So many numbers.
    Numbers(usize),
    /// One of these names, in lexical order.
    Names(Box<[Box<str>]>),
}

impl FieldKind {
    /// Numbers a value has; 1 for names.
    #[must_use]
    pub fn components(&self) -> usize {
        match self {
            Self::Numbers(count) => *count,
            Self::Names(_) => 1,
        }
    }
}

/// All fields of features, `elevation` and `water_depth` among them, in lexical order.
pub(super) fn fields(features: &[Feature]) -> Result<Box<[Field]>, LayoutError> {
    let mut found: BTreeMap<&str, (usize, BTreeSet<&str>)> = BTreeMap::from([("elevation", (1, BTreeSet::new())), ("water_depth", (1, BTreeSet::new()))]);
    let mut last = None;
    for feature in features {
        // Features that follow one another mostly share their attributes.
        let set = feature.attributes();
        if last.replace(set.hash()) == Some(set.hash()) {
            continue;
        }
        for attribute in set.iter() {
            let components = components(attribute);
            let (known, names) = found.entry(&attribute.name).or_insert_with(|| (components, BTreeSet::new()));
            if *known != components {
                return Err(LayoutError::Kinds(attribute.name.to_string()));
            }
            if let Value::Name(name) = &attribute.value {
                names.insert(name);
            }
        }
    }
    let field = |(name, (components, names)): (&str, (usize, BTreeSet<&str>))| {
        let kind = if components == 0 { FieldKind::Names(names.into_iter().map(Into::into).collect()) } else { FieldKind::Numbers(components) };
        Field { name: name.into(), kind }
    };
    Ok(found.into_iter().map(field).collect())
}

/// Numbers of an attribute's value, 0 for a name.
fn components(attribute: &Attribute) -> usize {
    match &attribute.value {
        Value::Vector(numbers) => numbers.len(),
        Value::Name(_) => 0,
        _ => 1,
    }
}
