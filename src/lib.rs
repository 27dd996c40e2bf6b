//! Contact patch, force, stiffness and pressure of two bodies pressed together.

mod discrete;
mod error;
pub mod gap;
pub mod geometry;
mod grid;
pub mod influence;
mod material;
pub mod matrix_free;

pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use influence::InfluenceTable;
pub use material::{Body, EffectiveModulus};
