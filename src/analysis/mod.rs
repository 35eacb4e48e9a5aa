//! What a surface is like.

mod slope;

pub use slope::gradient;
