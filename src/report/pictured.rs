//! The state that a picture shows: that of the answer where it has a field of its own, else one on a grid.

use crate::grid_method::gap_left;
use crate::problem::{Contact, ErrorBar, Loading, Method, Outputs, Settings};
use crate::solution::{Singular, Solution, Unsolved};
use crate::solve::solve;

/// Cells along the longer side of the grid behind the pictures of an answer that has none, unless the scene says.
const PICTURE_CELLS: usize = 96;

/// The state with boundary and pressure, and the gap where the picture shows it. Cells that are fitted to sharp edges are few and large, formulas have none: both are drawn
/// from a grid at the same depth. The answer itself is not changed by what a picture needs.
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
    let own = || {
        let mut state = state.clone();
        if gap && state.pressure.gap.is_none() {
            state.pressure.gap = gap_left::by_field(&contact, &state, settings.kernel);
        }
        state
    };
    let has_own = state.pressure.field.is_some() && state.patch.boundary.is_some();
    let coarse = state.method == Method::EdgeFitted && state.pressure.singular == Some(Singular::Edge);
    if has_own && !coarse {
        return Ok(own());
    }
    let outputs = Outputs { patch: true, pressure: true, gap, ..Outputs::default() };
    let cells = Some(settings.cells.unwrap_or(PICTURE_CELLS));
    let on_grid = |method| {
        let settings = Settings { method, cells, outputs, evidence: ErrorBar::Estimate, ..*settings };
        // Whatever error the grid is left with: the answer stands beside it.
        solve(&contact, &settings).remove(0).or_else(Unsolved::accept_best)
    };
    // The method of the answer where it has a field.
    let by_formula = (state.method == Method::ClosedForm).then(|| on_grid(Method::ClosedForm));
    match by_formula {
        Some(Ok(drawn)) if drawn.pressure.field.is_some() => Ok(drawn),
        _ => on_grid(Method::Fft).or_else(|unsolved| if has_own { Ok(own()) } else { Err(unsolved) }),
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
