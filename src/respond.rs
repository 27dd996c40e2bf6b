//! The state at a prescribed depth and tilt, by the method that the settings ask for.

use crate::contact::Contact;
use crate::error::{Unsolved, Verdict};
use crate::gap::AnyGap;
use crate::settings::{Method, Settings};
use crate::solution::Solution;
use crate::{by_approximation, by_formula, by_grid};

/// The state; `with_matrix`: its stiffness against tilts too.
///
/// # Errors
/// The verdicts of the methods.
pub(crate) fn respond(
    contact: &Contact,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let grid = |gap: &AnyGap| by_grid::solution(contact, gap, depth, tilt, settings, with_matrix);
    let gap = contact.tilted_gap(tilt);
    match settings.method {
        Method::ClosedForm => by_formula::solution(contact, &gap, depth, tilt, settings),
        Method::Qp | Method::Fft => grid(&gap),
        // A prescribed grid, or a gap field, is asked for by who wants a grid.
        Method::Auto if settings.cells.is_some() || settings.outputs.gap => grid(&gap),
        Method::Auto => match by_formula::solution(contact, &gap, depth, tilt, settings) {
            Err(e) if e.verdict == Verdict::NoClosedForm => grid(&gap),
            answered => answered,
        },
        Method::Ritz | Method::Fabrikant => {
            by_approximation::solution(contact, &gap, depth, tilt, settings, with_matrix)
        }
    }
}
