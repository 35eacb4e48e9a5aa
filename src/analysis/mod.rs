//! What a surface is like.

mod accessibility;
mod slope;
mod statistics;

pub use accessibility::{Accessibility, accessibility};
pub use slope::gradient;
pub use statistics::{QUANTILES, Quantiles, Statistics};
