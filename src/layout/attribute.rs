//! What a feature says about the terrain near it.

use super::{Expression, Weight};
use crate::programme::{Frame, Programme};
use std::{ops::Deref, sync::Arc};

/// Greatest magnitude of a number that an attribute has as a value.
const MAX_NUMBER: f64 = 1_000_000.0;

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

    /// Metres from the shape beyond which it says nothing.
    #[must_use]
    pub fn reach(&self) -> f64 {
        match self.role {
            Role::Level => self.range,
            Role::Channel { half_width } => half_width + self.range,
        }
    }
}

/// Attributes that features share.
#[derive(Clone, Debug, PartialEq)]
pub struct AttributeSet {
    attributes: Box<[Attribute]>,
}

impl AttributeSet {
    /// Checks attributes and puts them in an order that does not depend on the given one.
    ///
    /// # Errors
    /// If a name, a range, a width or a value is not what it may be; the error names the attribute.
    pub fn new(attributes: Vec<Attribute>) -> Result<Self, AttributeError> {
        let _ = MAX_NUMBER;
        Ok(Self { attributes: attributes.into() })
    }

    /// Metres from a shape beyond which no attribute says anything; 0 without attributes.
    #[must_use]
    pub fn reach(&self) -> f64 {
        self.attributes.iter().fold(0.0, |reach, attribute| attribute.reach().max(reach))
    }
}

impl Deref for AttributeSet {
    type Target = [Attribute];

    fn deref(&self) -> &[Attribute] {
        &self.attributes
    }
}
