//! The force of a homogeneous gap from bounds of its energy: P (d - g0) = (2 + 1/k) U.

use super::bracket::{Trial, energy_bracket};
use super::of_gap::GapOverlap;
use crate::gap::Degree;
use crate::overlap::Scaled;

/// Cells that a grid is enlarged by on each side where its contact ends too close to its border to be sure of what lies beyond: one
/// for so many of the longer side.
const PADDING: [usize; 2] = [8, 3];

/// Means of the gap are found to this share of the depth and of the error that is asked for: together they cost no more than twice it.
const OPEN: f64 = 0.02;

/// What units and a few products change a bound by.
const ROUNDING: f64 = 1e-13;

/// Bounds of the force (E* = 1) by a pressure on a grid; `None` where none can be had. For a gap of this degree; wide by a share of
/// `tolerance` at least.
pub(crate) fn force_bounds(scaled: &Scaled, degree: Degree, trial: &Trial, tolerance: f64) -> Option<[f64; 2]> {
    let overlap = GapOverlap::of(scaled, OPEN * tolerance);
    let longer = trial.grid.shape[0].max(trial.grid.shape[1]);
    let around = PADDING.iter().map(|part| energy_bracket(&overlap, &trial.padded(longer.div_ceil(*part)).trial()));
    let mut found = std::iter::once(energy_bracket(&overlap, trial)).chain(around);
    let [lower, upper] = found.find_map(|bracket| Some(bracket.bounds()).filter(|[_, upper]| upper.is_finite()))?;
    let per_energy = (2.0 + degree.inverse()) / scaled.above_lowest();
    let [lower, upper] = [lower * per_energy * (1.0 - ROUNDING), upper * per_energy * (1.0 + ROUNDING)];
    (lower > 0.0 && upper < f64::INFINITY).then_some([lower, upper])
}
