//! Where the error of a field sits, cell by cell.

use crate::energy::{GapOverlap, Trial, energy_bracket};
use crate::grid::Pressure;
use crate::problem::Contact;
use crate::solution::Solution;

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
    trial.first_that(&overlap, shown)
}

#[cfg(test)]
mod tests {
    use super::super::pictured::pictured;
    use super::*;
    use crate::gap::{AnyGap, Paraboloid, Polyhedron};
    use crate::problem::{EffectiveModulus, Loading, Method, Settings};
    use crate::solve::solve;

    fn by_cells(gap: AnyGap, depth: f64) -> (Pressure, Solution) {
        let modulus = EffectiveModulus::from_e_star(2e11).unwrap();
        let contact = Contact::new(modulus, gap, Loading::depth(depth)).unwrap();
        let settings = Settings { method: Method::Fft, cells: Some(64), tolerance: 0.5, ..Settings::default() };
        let state = solve(&contact, &settings).remove(0).unwrap();
        let drawn = pictured(&contact, &state, &settings, false).unwrap();
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
}
