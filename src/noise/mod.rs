//! Lattice noise and elementary functions, each with one plain definition and a fast form over rows of samples that gives the same bits.
//!
//! A [`Field`] is one noise or fractal: [`Field::at`] is its meaning at a point, [`Rows`] evaluates it along the rows of a window. Every arithmetic step is a
//! single IEEE operation (no fused multiply-add, no platform libm), so both agree with each other and with every other machine.

mod aligned;
mod basis;
mod bounds;
mod cells;
mod cellular;
mod draws;
pub mod elementary;
mod field;
mod fractal;
mod gradient;
mod gradient_lanes;
mod gradient_rows;
mod hash;
#[cfg_attr(target_arch = "x86_64", expect(unsafe_code, reason = "calling a function compiled for more than the baseline"))]
mod isa;
mod lanes;
mod metric;
mod moments;
mod nodes;
mod number;
mod opening;
mod points;
mod rows;
mod scatter;
mod shape;
mod sheet;
mod twice;
mod valleys;
#[cfg(target_arch = "x86_64")]
#[expect(unsafe_code, reason = "calling intrinsics, reading and writing vectors")]
mod x86;

pub use basis::Basis;
pub use cellular::{Feature, Metric};
pub use draws::Draws;
pub(crate) use draws::{SIDE, wave_draws};
pub use field::Field;
pub use hash::{key, mix};
pub use isa::{Isa, Kernel};
pub use lanes::Lanes;
pub use moments::Moments;
pub use rows::Rows;
pub use shape::FieldShape;
pub use valleys::{Erosion, Fading, Lattice, Networks, Stead, Terrain, Valleys};

#[cfg(test)]
pub(crate) mod tests;
