//! What a picture shows of a closed form.

use super::select::{BOUNDARY_POINTS, of, sampled};
use super::{ClosedForm, Distribution};
use crate::clock::Deadline;
use crate::grid::Pressure;
use crate::overlap::Overlap;
use crate::problem::EffectiveModulus;
use crate::solution::Unsolved;

/// Pressure and boundary for a picture: to a few digits, which is as much as can be seen.
///
/// # Errors
/// As [`of`]; `TimeLimit`.
pub(crate) fn drawn(
    modulus: EffectiveModulus,
    overlap: &Overlap,
    cells: usize,
    deadline: Deadline,
) -> Result<(Pressure, Vec<[f64; 2]>), Unsolved> {
    let form = of(overlap, modulus, deadline)?.contact;
    let boundary = form.patch.boundary(BOUNDARY_POINTS);
    if !matches!(form.pressure, Distribution::Revolution(_)) {
        return Ok((sampled(&form, cells, deadline, ClosedForm::pressure)?, boundary));
    }
    // Known in the radius alone, by integrals: p sqrt(1 - rho^2), which has no edge, between a few radii.
    let ([x, y], a) = (form.patch.centre, form.patch.semi_axes[0]);
    let width = |rho: f64| ((1.0 - rho) * (1.0 + rho)).max(0.0).sqrt();
    let at = |k: usize| {
        let rho = (k as f64 + 0.5) / RADII as f64;
        form.rough_pressure(x + rho * a, y) * width(rho)
    };
    let along: Vec<f64> = (0..RADII).map(at).collect();
    let between = |form: &ClosedForm, u: f64, v: f64| {
        let rho = (u - x).hypot(v - y) / a;
        if rho >= 1.0 {
            return form.pressure(u, v);
        }
        let place = (rho * RADII as f64 - 0.5).clamp(0.0, RADII as f64 - 1.0);
        let k = (place as usize).min(RADII - 2);
        let share = place - k as f64;
        (along[k] + share * (along[k + 1] - along[k])) / width(rho)
    };
    Ok((sampled(&form, cells, deadline, between)?, boundary))
}

/// Radii at which a picture has its pressure.
const RADII: usize = 96;
