//! Worlds: the document that is the whole truth about a terrain, and its evaluation.

mod base;
mod document;
mod evaluate;
mod examples;
mod features;
mod fingerprint;
mod layer;
mod name;
mod number;
mod object;
mod parts;
mod preset;
mod problem;
mod raster;
mod revision;
mod roads;
mod shader;
mod survey;
mod weights;
mod work;

pub use base::{Base, ElevationRange};
pub use document::{Document, GENERATOR};
pub use evaluate::World;
pub use examples::{EXAMPLES, Example, PRESETS};
pub use features::LayerFeatures;
pub use fingerprint::Fingerprint;
pub use layer::{Blend, Layer, Mask};
pub use name::check_name;
pub use object::Object;
pub use parts::{PartNames, Parts};
pub use preset::Preset;
#[cfg(feature = "server")]
pub(crate) use problem::read as read_document;
pub use problem::{DocumentError, Problem};
pub use raster::{RasterError, RasterHead, StoredRaster};
pub use revision::Revision;
pub use survey::Survey;
pub use work::{Checkpoint, Course, Share, Turn, Work, WorkKind};
