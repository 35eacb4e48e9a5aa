//! Lattice noise and elementary functions, each with one plain definition and a fast form over rows of samples that gives the same bits.
//!
//! A [`Field`] is one noise or fractal: [`Field::at`] is its meaning at a point, [`Rows`] evaluates it along the rows of a window. Every arithmetic step is a
//! single IEEE operation (no fused multiply-add, no platform libm), so both agree with each other and with every other machine.

mod basis;
mod cells;
mod cellular;
pub mod elementary;
mod field;
mod gradient;
mod hash;
#[expect(unsafe_code, reason = "calling a function compiled for more than the baseline")]
mod isa;
mod metric;
mod moments;
mod stub;
mod valleys;

pub use basis::Basis;
pub use cellular::{Feature, Metric};
pub use field::{Field, FieldShape, Rows};
pub use hash::{key, mix};
pub use isa::{Isa, Kernel};
pub use moments::Moments;
pub use valleys::{Erosion, Terrain, Valleys};
