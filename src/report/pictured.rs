//! The state that a picture shows: that of the answer where it has a field of its own, else one on a grid.

use crate::closed_form::drawn::drawn;
use crate::grid_method::gap_left;
use crate::overlap::Overlap;
use crate::problem::{Contact, ErrorBar, Loading, Method, Outputs, Settings};
use crate::solution::{Singular, Solution, Unsolved};
use crate::solve::solve;

/// Cells along the longer side of the grid behind the pictures of an answer that has none, unless the scene says.
const PICTURE_CELLS: usize = 96;

/// The same where the pressure is known by a formula.
const FORMULA_CELLS: usize = 144;

/// The state with boundary and pressure, and the gap where the picture shows it. Cells that are fitted to sharp edges are few and large,
/// formulas have none: the ones are drawn from a grid at the same depth, the others from the formula. The answer itself is not changed
/// by what a picture needs.
///
/// # Errors
/// Those of the grid.
pub(crate) fn pictured(
    contact: &Contact,
    state: &Solution,
    settings: &Settings,
    gap: bool,
) -> Result<Solution, Unsolved> {
    let contact = contact.under(Loading::Single(state.load()));
    let with_gap = |mut state: Solution| {
        if gap && state.pressure.gap.is_none() {
            state.pressure.gap = gap_left::by_field(&contact, &state, settings.kernel);
        }
        state
    };
    let has_own = state.pressure.field.is_some() && state.patch.boundary.is_some();
    let coarse = state.method == Method::EdgeFitted && state.pressure.singular == Some(Singular::Edge);
    if has_own && !coarse {
        return Ok(with_gap(state.clone()));
    }
    // By the formula where that gives the pressure.
    let by_formula = || {
        let overlap = Overlap::of(&contact.tilted_gap(state.tilt), state.depth).ok()??;
        let deadline = settings.deadline.or_after(settings.seconds, settings.threads);
        let (field, boundary) =
            drawn(contact.modulus(), &overlap, settings.cells.unwrap_or(FORMULA_CELLS), deadline).ok()?;
        let mut shown = state.clone();
        (shown.grid, shown.pressure.field, shown.patch.boundary) =
            (Some(field.grid), Some(field), Some(vec![boundary]));
        Some(with_gap(shown))
    };
    if state.method == Method::ClosedForm
        && let Some(shown) = by_formula()
    {
        return Ok(shown);
    }
    let outputs = Outputs { patch: true, pressure: true, gap, ..Outputs::default() };
    let cells = Some(settings.cells.unwrap_or(PICTURE_CELLS));
    let settings = Settings { method: Method::Fft, cells, outputs, evidence: ErrorBar::Estimate, ..*settings };
    // Whatever error the grid is left with: the answer stands beside it.
    match solve(&contact, &settings).remove(0).or_else(Unsolved::accept_best) {
        Err(_) if has_own => Ok(with_gap(state.clone())),
        on_grid => on_grid,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::EffectiveModulus;

    #[test]
    fn the_answer_is_not_changed_by_what_a_picture_needs() {
        let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
        let square = crate::gap::Flat::new(
            crate::gap::Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap(),
        );
        let contact = Contact::new(modulus, square, Loading::depth(1e-6)).unwrap();
        let settings = Settings::default();
        let state = solve(&contact, &settings).remove(0).unwrap();
        let drawn = pictured(&contact, &state, &settings, true).unwrap();
        assert_eq!((state.method, drawn.method), (Method::EdgeFitted, Method::Fft));
        assert!((drawn.force / state.force - 1.0).abs() < 0.02 && drawn.pressure.gap.is_some());
    }
}
