//! Feature layouts (Benjaminsen, "Multi-attribute features in procedural terrain", 2021): terrain as the weighted merge of features, each a shape with attributes.
//!
//! A [`Layout`] is made from features once and evaluated over windows; [`Layout::at`] is its plain meaning at a point. Both agree to the bit, whatever the order
//! of the features, the partition of the window, the instruction set and the number of threads.
//!
//! ```
//! use std::sync::Arc;
//! use terrane::{
//!     geometry::{Elevation, Filter, Shape, Window},
//!     layout::{Attribute, AttributeSet, Feature, Layout, Options, Weight},
//! };
//! let ridge = Arc::new(AttributeSet::new(vec![Attribute::elevation(Weight::Linear, 400.0)])?);
//! let line = Shape::line(vec![[0.0, 0.0], [1000.0, 0.0]], Elevation::Vertices([500.0, 700.0].into()))?;
//! let layout = Layout::new(vec![Feature::new(line, ridge)?], Options::default())?;
//! let window = Window::area([0.0, -500.0, 1000.0, 500.0], 10.0, Filter::Exact, 1 << 20)?;
//! let base = vec![100.0; window.samples()];
//! let surface = layout.sample(&window, Some(&base), &layout.everything());
//! assert_eq!(surface.elevation[0], 100.0, "500 m north of the ridge there is the base");
//! assert!((surface.elevation[50 * 100 + 50] - 601.0).abs() < 0.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attribute;
mod block;
mod content;
mod detail;
mod distance;
mod evaluate;
mod expression;
mod feature;
mod field;
pub mod generate;
pub mod geojson;
mod index;
mod kernels;
mod parity;
mod path;
mod reference;
mod runs;
mod scatter;
mod search;
mod surface;
mod term;
mod weight;

pub use attribute::{Attribute, AttributeError, AttributeSet, Role, Side, TerrainValue, Value};
pub use detail::DetailMode;
pub use expression::{Expression, ExpressionError};
pub use feature::{ContentHash, Feature, FeatureError};
pub use field::{Field, FieldKind};
pub use index::{Layout, LayoutError, Mix, Options};
pub use scatter::{Scatter, ScatterOptions};
pub use surface::{FieldSurface, LayoutSurface, Selection};
pub use weight::Weight;

#[cfg(test)]
mod tests;
