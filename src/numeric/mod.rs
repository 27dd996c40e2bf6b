//! Numerical tools without physics: intervals, derivatives.

#[cfg(feature = "formula")]
pub(crate) mod derivatives;
pub mod interval;

pub use interval::Interval;
