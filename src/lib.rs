//! Contact patch, force, stiffness and pressure of two bodies pressed together.

pub mod closed_form;
mod discrete;
mod error;
pub mod gap;
pub mod geometry;
mod grid;
mod material;
pub mod quadrature;
pub mod scalar;

pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use material::{Body, EffectiveModulus};
