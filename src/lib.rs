//! Contact patch, force, stiffness and pressure of two bodies pressed together.

pub mod bracket;
mod contact;
mod discrete;
mod domain;
mod error;
mod exact;
mod extrapolate;
pub mod gap;
pub mod geometry;
mod grid;
mod homogeneity;
pub mod influence;
mod material;
pub mod matrix_free;
pub mod patch;
#[cfg(feature = "qp")]
pub mod qp;
mod settings;
mod solution;
mod solve;
pub mod symmetry;

pub use contact::{Contact, Load, Loading};
pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use influence::InfluenceTable;
pub use material::{Body, EffectiveModulus};
pub use settings::{BoundaryFamily, Method, Outputs, Settings};
pub use solution::{Cost, Patch, PressureSummary, Solution};
pub use solve::solve;
