//! Contact patch, force, stiffness and pressure of two bodies pressed together.

mod discrete;
mod error;
pub mod fabrikant;
pub mod gap;
pub mod geometry;
mod grid;
mod material;
pub mod ritz;

pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use material::{Body, EffectiveModulus};
