//! The state that a picture shows: that of the answer where it has a field of its own, else one on a grid.

use crate::energy::{GapOverlap, Trial, energy_bracket};
use crate::grid::Pressure;
use crate::grid_method::gap_left;
use crate::problem::{Contact, ErrorBar, Load, Loading, Method, Outputs, Settings};
use crate::solution::{Singular, Solution, Unsolved};
use crate::solve::solve;

/// Cells along the longer side of the grid behind the pictures of an answer that has none, unless the scene says.
const PICTURE_CELLS: usize = 96;

/// The load of a state, whatever it was found under: its depth, and its tilt.
pub(crate) fn load_of(state: &Solution) -> Load {
    match state.tilt {
        [0.0, 0.0] => Load::Depth(state.depth),
        tilt => Load::Tilted { depth: state.depth, tilt },
    }
}

/// The state with boundary, pressure and gap. Cells that are fitted to sharp edges are few and large, formulas have none: both are drawn
/// from a grid at the same depth. The answer itself is not changed by what a picture needs.
///
/// # Errors
/// Those of the grid.
pub(crate) fn pictured(contact: &Contact, state: &Solution, settings: &Settings) -> Result<Solution, Unsolved> {
    let contact = contact.under(Loading::Single(load_of(state)));
    let own = || {
        let mut state = state.clone();
        let left = gap_left::by_field(&contact, &state, settings.kernel);
        state.pressure.gap = state.pressure.gap.take().or(left);
        state
    };
    let has_own = state.pressure.field.is_some() && state.patch.boundary.is_some();
    let coarse = state.method == Method::EdgeFitted && state.pressure.singular == Some(Singular::Edge);
    if has_own && !coarse {
        return Ok(own());
    }
    let outputs = Outputs { patch: true, pressure: true, gap: true, ..Outputs::default() };
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

/// Cells that a grid is enlarged by on each side where nothing can be shown of what lies beyond: one for so many of the longer side.
const PADDING: [usize; 2] = [8, 3];

/// Where the error of a field sits: the share of each cell in the width of the bounds of the energy, over the energy. `None` without a
/// field, and where the bounds do not reach: a gap of which no bounds are known, or that jumps within the contact, cells more slender than
/// 2:1.
pub(crate) fn error_by_cells(contact: &Contact, state: &Solution) -> Option<Pressure> {
    let field = state.pressure.field.as_ref()?;
    let gap = contact.tilted_gap(state.tilt);
    let overlap = GapOverlap::new(&gap, state.depth);
    let e_star = contact.modulus().e_star();
    let pressure: Vec<f64> = field.values.iter().map(|p| p / e_star).collect();
    let trial = Trial { grid: &field.grid, pressure: &pressure, displacement: None };
    let shown = |trial: &Trial| {
        let bracket = energy_bracket(&overlap, trial);
        let known = bracket.width.is_finite() && bracket.lower > 0.0;
        let values = || bracket.shares.iter().map(|share| share / bracket.lower).collect();
        known.then(|| Pressure { grid: *trial.grid, values: values() })
    };
    let longer = field.grid.shape[0].max(field.grid.shape[1]);
    let padded = PADDING.iter().find_map(|part| shown(&trial.padded(longer.div_ceil(*part)).trial()));
    shown(&trial).or(padded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::{AnyGap, Paraboloid, Polyhedron};
    use crate::problem::EffectiveModulus;

    fn by_cells(gap: AnyGap, depth: f64) -> (Pressure, Solution) {
        let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
        let contact = Contact::new(modulus, gap, Loading::depth(depth)).unwrap();
        let settings = Settings { method: Method::Fft, cells: Some(64), tolerance: 0.5, ..Settings::default() };
        let state = solve(&contact, &settings).remove(0).unwrap();
        let drawn = pictured(&contact, &state, &settings).unwrap();
        (error_by_cells(&contact, &drawn).unwrap(), state)
    }

    #[test]
    fn errors_sit_at_the_rim_of_hertz_and_at_the_tip_of_a_pyramid() {
        let (hertz, _) = by_cells(AnyGap::new(Paraboloid::new([0.02; 2]).unwrap()), 1e-6);
        let (pyramid, _) = by_cells(AnyGap::new(Polyhedron::pyramid(4, 0.2).unwrap()), 1e-6);
        let sum = |field: &Pressure| field.values.iter().sum::<f64>();
        // The widths of the bounds on 64 cells.
        assert!((1e-6..1e-3).contains(&sum(&hertz)) && (1e-5..5e-3).contains(&sum(&pyramid)));
        let strongest = |field: &Pressure| {
            let k = (0..field.values.len()).max_by(|a, b| field.values[*a].total_cmp(&field.values[*b])).unwrap();
            let [x, y] = field.grid.centre_of(k);
            x.hypot(y) / field.grid.spacing[0]
        };
        assert!(strongest(&hertz) > 15.0 && strongest(&pyramid) < 5.0, "{} {}", strongest(&hertz), strongest(&pyramid));
    }

    #[test]
    fn the_answer_is_not_changed_by_what_a_picture_needs() {
        let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
        let square = crate::gap::Flat::new(
            crate::gap::Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap(),
        );
        let contact = Contact::new(modulus, square, Loading::depth(1e-6)).unwrap();
        let settings = Settings::default();
        let state = solve(&contact, &settings).remove(0).unwrap();
        let drawn = pictured(&contact, &state, &settings).unwrap();
        assert_eq!((state.method, drawn.method), (Method::EdgeFitted, Method::Fft));
        assert!((drawn.force / state.force - 1.0).abs() < 0.02 && drawn.pressure.gap.is_some());
    }
}
