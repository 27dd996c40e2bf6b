//! Contact patch, force, stiffness and pressure of two bodies pressed together.

mod contact;
mod discrete;
mod error;
pub mod gap;
pub mod geometry;
mod grid;
mod material;
mod settings;
mod solution;

pub use contact::{Contact, Load, Loading};
pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use material::{Body, EffectiveModulus};
pub use settings::{BoundaryFamily, Method, Outputs, Settings};
pub use solution::{Cost, Patch, PressureSummary, Solution};
