//! Numerical tools without physics: intervals, derivatives.

pub(crate) mod derivatives;
pub mod interval;

pub use interval::Interval;
