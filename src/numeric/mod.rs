//! Numerical tools without physics: intervals, derivatives, functions of one variable, quadrature, plane geometry.

pub(crate) mod cubic;
#[cfg(feature = "formula")]
pub(crate) mod derivatives;
pub mod geometry;
pub mod interval;
pub mod quadrature;
#[cfg(feature = "formula")]
pub(crate) mod real;
pub mod scalar;
pub(crate) mod simd;

pub use interval::Interval;
