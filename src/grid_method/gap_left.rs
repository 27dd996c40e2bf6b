//! The gap that is left around a contact.

use crate::discrete::Discrete;
use crate::grid::{Grid, Kernel};
use crate::matrix_free;
use crate::problem::{Contact, Outputs};
use crate::solution::Solution;

/// In each cell, E* = 1: 0 under pressure, elsewhere what the displacement leaves of the gap, infinite where there is no material.
pub(super) fn of(problem: &Discrete, pressure: &[f64]) -> Vec<f64> {
    let displacement = matrix_free::displacement(problem, pressure);
    let left = |((p, u), f): ((&f64, &f64), &f64)| if *p > 0.0 { 0.0 } else { u - f };
    pressure.iter().zip(&displacement).zip(&problem.overlap).map(left).collect()
}

/// The same on the grid of the pressure field of a state; `None` without one.
pub(crate) fn by_field(contact: &Contact, state: &Solution, kernel: Kernel) -> Option<(Grid, Vec<f64>)> {
    let field = state.pressure.field.as_ref()?;
    let gap = contact.tilted_gap(state.tilt);
    let problem = Discrete::sample(&gap, state.depth, field.grid, kernel);
    let e_star = contact.modulus().e_star();
    let pressure: Vec<f64> = field.values.iter().map(|p| p / e_star).collect();
    Some((field.grid, of(&problem, &pressure)))
}

/// The state with the gap, where it is asked for, and without a field that is not.
pub(super) fn with_gap(contact: &Contact, mut state: Solution, asked: Outputs, kernel: Kernel) -> Solution {
    if asked.gap {
        state.pressure.gap = by_field(contact, &state, kernel);
    }
    if !asked.pressure {
        state.pressure.field = None;
    }
    state
}
