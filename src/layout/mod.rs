//! Feature layouts (Benjaminsen, "Multi-attribute features in procedural terrain", 2021): terrain as the weighted merge of features, each a shape with attributes.

mod attribute;
mod expression;
mod feature;
mod weight;

pub use attribute::{Attribute, AttributeError, AttributeSet, Role, Side, TerrainValue, Value};
pub use expression::{Expression, ExpressionError};
pub use feature::{ContentHash, Feature, FeatureError};
pub use weight::Weight;
