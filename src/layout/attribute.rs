//! What a feature says about the terrain near it.

use super::{ContentHash, Expression, Weight, content};
use crate::{
    geometry::PLANE_LIMIT,
    programme::{Frame, Programme},
};
use std::{ops::Deref, sync::Arc};

/// Greatest magnitude of a number that an attribute has as a value.
const MAX_NUMBER: f64 = 1_000_000.0;

/// Most numbers of a vector.
const MAX_COMPONENTS: usize = 16;

/// Why a set of attributes cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("attribute {name:?}: {message}")]
pub struct AttributeError {
    /// Name of the attribute.
    pub name: String,
    /// What is wrong and what would be right.
    pub message: String,
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The elevation of the shape's nearest place.
    Shape,
    /// One number.
    Number(f64),
    /// Several numbers, such as a colour, merged one by one.
    Vector(Box<[f64]>),
    /// One name out of a set, such as a material.
    Name(Box<str>),
    /// Straight lines through pairs of signed distance (ascending, metres; negative inside polygons and circles) and value, constant beyond the ends: the depth of water.
    Profile(Box<[[f64; 2]]>),
    /// An expression in the signed distance.
    Expression(Expression),
    /// A terrain programme.
    Terrain(Arc<TerrainValue>),
}

/// A terrain programme with its measures: `datum + amplitude · programme`.
#[derive(Clone, Debug, PartialEq)]
pub struct TerrainValue {
    /// The programme.
    pub programme: Programme,
    /// How its coordinates lie in the plane.
    pub frame: Frame,
    /// Value a unit of the programme's value.
    pub amplitude: f64,
    /// Value where the programme is 0.
    pub datum: f64,
    /// Whether the elevation of the shape's nearest place is added: rough mountains over a ridge.
    pub over_shape: bool,
}

/// Which side of a shape an attribute's distance counts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// 0 inside a polygon: max(0, signed distance).
    #[default]
    Inside,
    /// 0 outside: max(0, -signed distance), the sea beyond a coast.
    Outside,
    /// 0 on the boundary alone.
    Edge,
}

/// How an attribute enters the merge.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Role {
    /// By its weight in the average of its level.
    #[default]
    Level,
    /// After all levels and exactly: rivers and lakes. Where the distance is at most the half width (metres) the channel alone decides.
    Channel {
        /// Half the width of the bed in metres.
        half_width: f64,
    },
}

/// One attribute.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// `elevation`, `water_depth`, `material` or a name of the user's own: `[a-z][a-z0-9_]{0,62}`.
    pub name: Box<str>,
    /// Its value.
    pub value: Value,
    /// Its weight over distance.
    pub weight: Weight,
    /// Metres beyond which the weight is zero; infinity is allowed.
    pub range: f64,
    /// Which side the distance counts from.
    pub side: Side,
    /// Metres over which the coverage falls to 0 before the range; a quarter of the range if not given.
    pub fade: Option<f64>,
    /// Level of the merge. Level 0 lies over the world's base, each higher one over what is below; among channels, lakes stand above rivers. Names have no levels.
    pub priority: u8,
    /// How it enters the merge.
    pub role: Role,
}

impl Attribute {
    /// An attribute of level 0 that counts from inside.
    #[must_use]
    pub fn new(name: &str, value: Value, weight: Weight, range: f64) -> Self {
        Self { name: name.into(), value, weight, range, side: Side::Inside, fade: None, priority: 0, role: Role::Level }
    }

    /// The elevation of the shape.
    #[must_use]
    pub fn elevation(weight: Weight, range: f64) -> Self {
        Self::new("elevation", Value::Shape, weight, range)
    }

    /// A depth of water over signed distance: pairs of distance and depth in metres.
    #[must_use]
    pub fn water_depth(profile: &[[f64; 2]], weight: Weight, range: f64) -> Self {
        Self::new("water_depth", Value::Profile(profile.into()), weight, range)
    }

    /// A material of the ground.
    #[must_use]
    pub fn material(name: &str, weight: Weight, range: f64) -> Self {
        Self::new("material", Value::Name(name.into()), weight, range)
    }

    /// On another side.
    #[must_use]
    pub fn on(self, side: Side) -> Self {
        Self { side, ..self }
    }

    /// On another level.
    #[must_use]
    pub fn with_priority(self, priority: u8) -> Self {
        Self { priority, ..self }
    }

    /// As a channel of a half width in metres.
    #[must_use]
    pub fn as_channel(self, half_width: f64) -> Self {
        Self { role: Role::Channel { half_width }, ..self }
    }

    /// Metres of the side's own distance beyond which it says nothing.
    #[must_use]
    pub fn reach(&self) -> f64 {
        match self.role {
            Role::Level => self.range,
            Role::Channel { half_width } => half_width + self.range,
        }
    }
}

/// Whether a number is finite and of a size that sums of a million such numbers stay exact enough.
fn is_number(value: f64) -> bool {
    value.abs() <= MAX_NUMBER
}

/// Whether a number of metres can be a size.
fn is_size(value: f64) -> bool {
    value > 0.0 && value <= PLANE_LIMIT
}

impl Attribute {
    /// What is wrong and what would be right.
    fn check(&self) -> Result<(), String> {
        let mut letters = self.name.chars();
        let good = letters.next().is_some_and(|c| c.is_ascii_lowercase()) && letters.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        if !good || self.name.len() > 63 {
            return Err("a name is a lower-case letter and up to 62 lower-case letters, digits and underscores".to_owned());
        }
        if !(is_size(self.range) || self.range == f64::INFINITY) {
            return Err(format!("a range is a positive number of metres or infinite, got {}", self.range));
        }
        if let Some(fade) = self.fade.filter(|&fade| !(fade > 0.0 && fade <= self.range && fade.is_finite())) {
            return Err(format!("a fade is more than 0 and at most the range of {} m, got {fade}", self.range));
        }
        match self.weight {
            Weight::Sharp { width, nearest } if !(is_size(width) && is_size(nearest)) => Err("the width and the nearest distance must be positive".to_owned()),
            Weight::Smooth { width } if !is_size(width) => Err(format!("the width must be a positive number of metres, got {width}")),
            _ => Ok(()),
        }?;
        self.check_role()?;
        self.check_value()
    }

    fn check_role(&self) -> Result<(), String> {
        match (self.role, &self.value) {
            (Role::Channel { .. }, Value::Name(_)) => Err("names are not averaged, so they cannot be channels".to_owned()),
            (Role::Channel { half_width }, _) if half_width != 0.0 && !is_size(half_width) => {
                Err(format!("the half width of a channel is a number of metres from 0 on, got {half_width}"))
            }
            _ => Ok(()),
        }
    }

    fn check_value(&self) -> Result<(), String> {
        if matches!(&*self.name, "elevation" | "water_depth") && matches!(self.value, Value::Vector(_) | Value::Name(_)) {
            return Err("its value is one number of metres".to_owned());
        }
        match &self.value {
            Value::Number(value) if !is_number(*value) => Err(format!("a value lies within ±{MAX_NUMBER}, got {value}")),
            Value::Vector(values) if values.is_empty() || values.len() > MAX_COMPONENTS || !values.iter().all(|&value| is_number(value)) => {
                Err(format!("a vector has 1 to {MAX_COMPONENTS} numbers within ±{MAX_NUMBER}"))
            }
            Value::Name(name) if name.is_empty() || name.len() > 63 => Err("a name has 1 to 63 characters".to_owned()),
            Value::Profile(pairs) => {
                let numbers = pairs.iter().flatten().all(|&number| is_number(number));
                let ascending = pairs.windows(2).all(|pair| pair[0][0] < pair[1][0]);
                if numbers && ascending && !pairs.is_empty() {
                    return Ok(());
                }
                Err(format!("a profile is a list of pairs of distance and value, the distances ascending, all within ±{MAX_NUMBER}"))
            }
            Value::Terrain(terrain) => {
                let frame = &terrain.frame;
                let good =
                    is_size(frame.scale) && frame.origin.iter().all(|c| c.abs() <= PLANE_LIMIT) && is_number(terrain.amplitude) && is_number(terrain.datum);
                if good {
                    Ok(())
                } else {
                    Err(format!("scale, origin, amplitude and datum must be numbers, the scale positive, amplitude and datum within ±{MAX_NUMBER}"))
                }
            }
            _ => Ok(()),
        }
    }
}

/// Attributes that features share.
#[derive(Clone, Debug, PartialEq)]
pub struct AttributeSet {
    attributes: Box<[Attribute]>,
    content: ContentHash,
}

impl AttributeSet {
    /// Checks attributes and puts them in an order that does not depend on the given one.
    ///
    /// # Errors
    /// If a name, a range, a width or a value is not what it may be; the error names the attribute.
    pub fn new(mut attributes: Vec<Attribute>) -> Result<Self, AttributeError> {
        for attribute in &attributes {
            attribute.check().map_err(|message| AttributeError { name: attribute.name.to_string(), message })?;
        }
        attributes.sort_by_cached_key(content::of_attribute);
        let content = content::of_set(&attributes);
        Ok(Self { attributes: attributes.into(), content })
    }

    /// The name of the content.
    #[must_use]
    pub fn hash(&self) -> ContentHash {
        self.content
    }

    /// Metres from a shape beyond which no attribute says anything; 0 without attributes, infinite if one counts from outside.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let reach = |attribute: &Attribute| if attribute.side == Side::Outside { f64::INFINITY } else { attribute.reach() };
        self.attributes.iter().map(reach).fold(0.0, f64::max)
    }
}

impl Deref for AttributeSet {
    type Target = [Attribute];

    fn deref(&self) -> &[Attribute] {
        &self.attributes
    }
}
