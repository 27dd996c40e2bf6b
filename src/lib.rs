//! Contact patch, force, stiffness and pressure of two bodies pressed together.

mod by_approximation;
mod by_formula;
mod by_grid;
#[cfg(feature = "cli")]
pub mod cli;
pub mod closed_form;
pub mod compare;
mod contact;
mod discrete;
mod domain;
mod equilibrium;
mod error;
mod exact;
mod extrapolate;
pub mod fabrikant;
pub mod gap;
pub mod geometry;
mod grid;
mod homogeneity;
pub mod influence;
mod material;
pub mod matrix_free;
pub mod patch;
#[cfg(feature = "plot")]
pub mod plot;
#[cfg(feature = "qp")]
pub mod qp;
pub mod quadrature;
pub mod recognise;
#[cfg(feature = "scene")]
pub mod report;
pub mod ritz;
pub mod scalar;
#[cfg(feature = "scene")]
pub mod scene;
mod settings;
mod solution;
mod solve;
#[cfg(all(feature = "scene", feature = "qp", feature = "formula"))]
pub mod stability;
pub mod symmetry;

pub use contact::{Contact, Load, Loading};
pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use influence::InfluenceTable;
pub use material::{Body, EffectiveModulus};
#[cfg(feature = "scene")]
pub use scene::Scene;
pub use settings::{BoundaryFamily, Method, Outputs, Settings};
pub use solution::{Cost, Patch, PressureSummary, Solution};
pub use solve::solve;
