//! Contact patch, force, stiffness and pressure of two bodies pressed together.
//!
//! ```
//! use contact_patch::{Body, Contact, EffectiveModulus, Loading, Settings, gap::Polyhedron, solve};
//!
//! let modulus = EffectiveModulus::of_pair(Body::elastic(2.1e11, 0.3)?, Body::RIGID)?;
//! let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
//! let contact = Contact::new(modulus, punch, Loading::depth(1e-6))?;
//! let solution = solve(&contact, &Settings::default()).remove(0)?;
//! let group = solution.force / (modulus.e_star() * 1e-12);
//! assert!((group / 0.882412 - 1.0).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The way of the data
//!
//! ```text
//! scene file -> Contact (gap, effective modulus, loading; checked) -> plan (what this scene needs)
//!   -> closed_form | cells fitted to edges | fabrikant, ritz | grids of qp, matrix_free  -> Solution -> bounds, laws -> report
//! ```
//!
//! [`gap`] knows geometry only; [`Contact`] knows nothing of files; the solvers see a problem without units ([`Discrete`], E* = 1)
//! and nothing of how it was loaded; loads are balanced by one Newton method that drives any of them; [`Solution`] is what all
//! of them return, in the user's units, and an [`Unsolved`] is what they return instead when they have no answer.
//!
//! | question | where |
//! |---|---|
//! | influence coefficients (Love 1929) | [`influence`] |
//! | the quadratic programme | `qp` (feature `qp`) |
//! | the same on millions of cells | [`matrix_free`] |
//! | equations (10) to (25) of Barber & Billings | [`fabrikant`], [`ritz`] |
//! | Hertz, Sneddon and other formulas | [`closed_form`] |
//! | what is known of a gap from the way it is written | [`gap::Known`] |
//!
#![doc = include_str!("theory.md")]

/// Error against run time of every method, scene by scene.
#[cfg(doc)]
#[doc = include_str!("../docs/methods.md")]
pub mod methods {}

mod acceptance;
pub mod approximate;
pub mod bracket;
mod by_edges;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
mod clock;
pub mod closed_form;
pub mod compare;
mod consistency;
pub mod curve;
mod discrete;
mod edge_fitted;
pub mod energy;
mod error;
mod files;
pub mod gap;
mod grid;
mod grid_method;
pub mod influence;
mod loading;
pub mod matrix_free;
pub mod numeric;
pub mod overlap;
pub mod patch;
mod plan;
#[cfg(feature = "plot")]
pub mod plot;
mod problem;
#[cfg(feature = "qp")]
pub mod qp;
#[cfg(feature = "scene")]
pub mod report;
#[cfg(feature = "scene")]
mod result;
#[cfg(feature = "scene")]
pub mod scene;
mod solution;
mod solve;
#[cfg(all(feature = "scene", feature = "qp", feature = "formula"))]
pub mod stability;
#[cfg(feature = "scene")]
pub mod table;
mod threads;
mod units;

pub use approximate::{fabrikant, ritz};
pub use clock::{Deadline, Interrupt, OutOfTime};
pub use curve::{Curve, CurveRange};
pub use discrete::{Discrete, DiscreteSolution, symmetry};
pub use error::InputError;
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use influence::InfluenceTable;
pub use numeric::{geometry, quadrature, scalar};
pub use plan::{Plan, plan};
pub use problem::{Body, Contact, EffectiveModulus, Load, Loading};
pub use problem::{BoundaryFamily, ErrorBar, Method, Outputs, Settings};
#[cfg(feature = "scene")]
pub use scene::Scene;
pub use solution::{
    Cost, ForceEvidence, Origin, Patch, Piece, PressureSummary, Residuals, Singular, Solution, TouchesEdge, Unsolved,
    Validity, Verdict,
};
pub use solve::solve;
pub use units::UnitLabels;
