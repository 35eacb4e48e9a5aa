//! Features: shapes with attributes.

use super::{AttributeSet, Value, content};
use crate::geometry::{Shape, ShapeError};
use std::sync::Arc;

/// Why a feature cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FeatureError {
    /// An attribute takes the shape's elevation, which the shape does not have.
    #[error("attribute {0:?} takes the elevation of the shape, which has none: give every vertex a third coordinate")]
    NoElevation(String),
    /// Its shape cannot have the detail that it should have.
    #[error(transparent)]
    Shape(#[from] ShapeError),
}

/// The name of a feature's content, from its shape and its attributes. Terms are added in its ascending order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContentHash(pub [u8; 16]);

/// A shape with attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// A name of the user's own; it has no influence on the terrain.
    pub id: Option<Box<str>>,
    /// Which of two features that are in conflict stays, the greater; it has no influence on the merge (see [`Attribute::priority`](super::Attribute::priority)).
    pub precedence: i32,
    shape: Shape,
    attributes: Arc<AttributeSet>,
    hash: ContentHash,
}

impl Feature {
    /// A feature without a name and of precedence 0.
    ///
    /// # Errors
    /// If an attribute takes the shape's elevation and the shape has none.
    pub fn new(shape: Shape, attributes: Arc<AttributeSet>) -> Result<Self, FeatureError> {
        if let Some(attribute) = attributes.iter().find(|attribute| takes_shape(&attribute.value) && !shape.has_elevation()) {
            return Err(FeatureError::NoElevation(attribute.name.to_string()));
        }
        let hash = content::of_feature(&shape, &attributes);
        Ok(Self { id: None, precedence: 0, shape, attributes, hash })
    }

    /// The shape.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The attributes, which features share.
    #[must_use]
    pub fn attributes(&self) -> &Arc<AttributeSet> {
        &self.attributes
    }

    /// The name of the content.
    #[must_use]
    pub fn hash(&self) -> ContentHash {
        self.hash
    }
}

/// Whether a value is or contains the shape's elevation.
fn takes_shape(value: &Value) -> bool {
    match value {
        Value::Shape => true,
        Value::Terrain(terrain) => terrain.over_shape,
        _ => false,
    }
}
