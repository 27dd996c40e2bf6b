//! Two-sided bounds of the energy.

mod basis;
mod bracket;
mod cut;
mod extension;
mod field;
mod force;
mod lanes;
mod of_gap;
mod outside;
mod overlap;
mod potential;
mod quarter;
mod residual;
mod tables;
mod whole;

pub use bracket::{EnergyBracket, Padded, Trial, energy_bracket};
pub(crate) use force::force_bounds;
pub use overlap::{Interval, Jet, OverlapBounds, Plane};
