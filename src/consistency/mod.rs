//! Laws that every frictionless contact obeys, held against an answer by ways that did not lead to it. An answer that breaks one of
//! them is no answer, whatever error it states: the verdict is `inconsistent`, with the law and the numbers.
//!
//! | law | what breaks it |
//! |---|---|
//! | a limit of grids lies no further from the finest than half an order of convergence leaves room for | a law of similarity that the gap does not follow |
//! | P >= P(A), the force of the flat punch A under the overlap (Barber 1974), A the ellipse of the patch, or the flat part of the gap | a force that is too low |
//! | where the bodies overlap and no cell is, the pressure elsewhere has pushed the surface away | contacts that were lost |
//! | the overlap ends: no value near its end is beyond the range of numbers | an overflow taken for the end of the material |
//! | P is convex in the depth d above first touch: P <= S d, P^2/(2 S) <= U <= P d/2; for a gap of degree k, U = P d/(2 + 1/k) | energy, stiffness and force of different contacts |
//! | a proved bracket holds part of what the error allows | an error that is too small |

mod ellipse;
mod uncovered;

use crate::gap::Degree;
use crate::solution::{Unsolved, Verdict};

pub(crate) use ellipse::above_ellipse;
pub(crate) use uncovered::{nothing_left_out, too_few_cells};

/// The force of a contact at a depth, and its error, absolute.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Claim {
    pub force: f64,
    pub error: f64,
}

/// The least order of convergence; of a homogeneous gap whose degree is less, that: its pressure is singular at the tip.
const LEAST_ORDER: f64 = 0.5;

/// What a rule of quadrature, the cells of a patch, or a stiffness on them may be off by.
const ROOM: f64 = 5e-3;

/// The same of a stiffness: that of a patch whose edge is known to a cell.
const ROOM_OF_STIFFNESS: f64 = 0.1;

/// # Errors
/// `Inconsistent`, when the limit of three grids or more is not that of their sums of pressures, coarse to fine.
pub(crate) fn limit_of(sums: &[f64], degree: Option<Degree>, claim: Claim) -> Result<(), Unsolved> {
    // Two grids may agree by chance.
    let Some(&finest) = sums.last().filter(|_| sums.len() > 2) else { return Ok(()) };
    let steps = sums.iter().rev().take(3).map(|s| (s - finest).abs()).fold(0.0, f64::max);
    let order = degree.map_or(LEAST_ORDER, |k| LEAST_ORDER.min(1.0 / k.inverse()));
    // From the finer of two grids, one of twice the cells, the limit lies so many steps between the two.
    let steps_left = 1.0 / (order.exp2() - 1.0);
    let room = steps_left * steps + claim.error + 1e-9 * finest;
    if (claim.force - finest).abs() <= room {
        return Ok(());
    }
    let Claim { force, error } = claim;
    broken(format!(
        "the force {force:e}, stated to {error:.1e}, is not the limit of grids: the pressures of the finest add up to {finest:e}"
    ))
}

/// # Errors
/// `Inconsistent`, when the force lies outside of bounds by more than its error.
pub(crate) fn within([lower, upper]: [f64; 2], Claim { force, error }: Claim, whose: &str) -> Result<(), Unsolved> {
    let room = error + 1e-12 * force;
    if force + room >= lower && force - room <= upper {
        return Ok(());
    }
    broken(format!(
        "the force {force:e}, stated to {error:.1e}, does not lie between {lower:e} and {upper:e}, the bounds by {whose}"
    ))
}

/// Force, energy and stiffness of one state in any units, and the depth above first touch, or above a bound of all gaps where that is not
/// known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Response {
    pub claim: Claim,
    pub energy: Option<f64>,
    pub stiffness: f64,
    pub depth: f64,
    pub degree: Option<Degree>,
}

impl Response {
    /// # Errors
    /// `Inconsistent`, when force, energy and stiffness cannot belong to one contact.
    pub fn of_one_contact(&self) -> Result<(), Unsolved> {
        let Self { claim: Claim { force, error }, energy, stiffness, depth, degree } = *self;
        let error = error / force + 1e-9;
        // P/S and U/P, lengths: products may be beyond the range of numbers.
        let straight = force / stiffness;
        if !(straight <= depth * (1.0 + error + ROOM_OF_STIFFNESS)) {
            return broken(format!("the force {force:e} is more than stiffness {stiffness:e} times depth {depth:e}"));
        }
        let Some(energy) = energy else { return Ok(()) };
        let mean = energy / force;
        if let Some(degree) = degree {
            let law = depth / (2.0 + degree.inverse());
            if !((mean - law).abs() <= error * law) {
                return broken(format!(
                    "the energy {energy:e} is {mean:e} times the force {force:e}; by the law of the gap it is {law:e}"
                ));
            }
        }
        let (low, high) = (0.5 * straight, 0.5 * depth);
        if low * (1.0 - error - ROOM_OF_STIFFNESS) <= mean && mean <= high * (1.0 + error + ROOM) {
            return Ok(());
        }
        broken(format!(
            "the energy {energy:e} is {mean:e} times the force {force:e}, not from {low:e} (by the stiffness) to {high:e}"
        ))
    }
}

fn broken(reason: String) -> Result<(), Unsolved> {
    let hint = "this should not happen: another method (`contact-patch compare`) or a prescribed number of cells may answer; please report it";
    Err(Unsolved::new(Verdict::Inconsistent, reason).with_hint(hint))
}

#[cfg(test)]
mod tests {
    //! Causes that no caller can put back: estimates on too few cells, and grids where a flat part is known.
    use super::*;
    use crate::by_edges;
    #[cfg(feature = "formula")]
    use crate::energy::{Trial, Wanted, force_bounds};
    use crate::gap::{AnyGap, Gap, Polyhedron};
    #[cfg(feature = "formula")]
    use crate::grid_method::refinement::as_far_as;
    use crate::overlap::Overlap;
    use crate::problem::Settings;
    #[cfg(feature = "formula")]
    use crate::problem::{ErrorBar, Method};

    fn assert_stopped(answer: Result<(), Unsolved>) {
        match answer {
            Err(unsolved) => assert_eq!(unsolved.verdict, Verdict::Inconsistent, "{unsolved}"),
            Ok(()) => panic!("not stopped"),
        }
    }

    fn overlap(gap: AnyGap, depth: f64) -> Overlap {
        Overlap::of(&gap, depth).unwrap().unwrap()
    }

    /// A slender homogeneous gap on few cells across the contact: a force off by 2.1, 3.4 and 5.6 times what it stated was printed once.
    #[cfg(feature = "formula")]
    #[test]
    fn an_estimate_from_too_few_cells_is_stopped_by_the_proof() {
        let gap = crate::gap::Formula::new("x^4 + 16*y^4").unwrap();
        let scaled = overlap(gap.into_any(), 0.158).scaled();
        let law = scaled.gap.known().law.unwrap();
        let settings = Settings { evidence: ErrorBar::Estimate, tolerance: 1e-5, ..Settings::default() };
        let found = as_far_as(200, &scaled, &settings, Method::Fft, Some(law)).unwrap();
        let (problem, solution) = (&found.state.problem, &found.state.solution);
        let trial =
            Trial { grid: &problem.grid, pressure: &solution.pressure, displacement: Some(&solution.displacement) };
        let wanted = Wanted::within(settings.tolerance, f64::INFINITY);
        let bounds = force_bounds(&scaled, Some(law.degree), &trial, wanted, settings.deadline).unwrap();
        let stated = 1e-3 * found.force;
        within(bounds, Claim { force: found.force, error: found.error }, "the energy").unwrap();
        for off in [2.1, 3.4, 5.6] {
            assert_stopped(within(bounds, Claim { force: found.force - off * stated, error: stated }, "the energy"));
            assert_stopped(within(bounds, Claim { force: found.force + off * stated, error: stated }, "the energy"));
        }
    }

    /// A truncated pyramid on a grid: 2.5 stated errors below the punch that its flat is.
    #[test]
    fn a_force_below_that_of_the_flat_is_stopped() {
        let settings = Settings::default();
        let pyramid = Polyhedron::truncated_pyramid(4, 45f64.to_radians(), 0.5).unwrap();
        let overlap = overlap(pyramid.into_any(), 5e-5);
        let [lower, upper] = by_edges::force_bounds(&overlap, &settings).unwrap();
        let stated = 1e-3 * lower;
        let claim = |force: f64| Claim { force, error: stated };
        within([lower, upper], claim(lower), "").unwrap();
        assert_stopped(within([lower, upper], claim(lower - 2.5 * stated), ""));
    }
}
