//! Features and sets of attributes as `GeoJSON` (RFC 7946), with world metres in the place of longitude and latitude and the third coordinate as elevation.
//!
//! [`Collection::read`] takes a Feature, a `FeatureCollection` or one Feature a line, in one pass and with no more memory than the features need, and tells every
//! problem up to [`MOST_PROBLEMS`]. What it gives are [`Drawn`] features: they are written back as they came, and [`Collection::features`] makes of them the
//! features of a layout. A `FeatureCollection` may carry the member `attributes` with sets of attributes by name; features share them.
//!
//! ```
//! use terrane::layout::geojson::{Collection, Sets};
//! let json = r#"{
//!   "type": "FeatureCollection",
//!   "attributes": {"crest": [{"name": "elevation", "value": "shape", "weight": "sharp", "range": 300}]},
//!   "features": [{
//!     "type": "Feature", "id": "north",
//!     "geometry": {"type": "LineString", "coordinates": [[0, 0, 900], [500, 200, 1100]]},
//!     "properties": {"attributes": "crest", "detail": {"iterations": 6, "displacement": 0.1}, "name": "North Ridge"}
//!   }]
//! }"#;
//! let collection = Collection::parse(json)?;
//! let features = collection.features(&Sets::default())?;
//! let again = Collection::parse(&serde_json::to_string(&collection)?)?.features(&Sets::default())?;
//! assert_eq!(features[0].hash(), again[0].hash());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod attribute;
mod collection;
mod coordinates;
mod drawn;
mod geometry;
mod lines;
mod members;
mod number;
mod problem;
mod properties;
mod read;
mod sets;
mod stored;

pub use collection::{Collection, MOST_FEATURES};
pub use coordinates::MOST_VERTICES;
pub use drawn::{Drawn, Id};
pub use problem::{MOST_PROBLEMS, Problem, ReadError};
pub use sets::Sets;
pub use stored::{FeatureSet, StoredSet, name_of_feature};

#[cfg(test)]
mod tests;
