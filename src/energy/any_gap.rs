//! The force of any gap from one pressure: without a law the energy alone does not tell it.
//!
//! What dilations and translations leave of a law, and flat punches on the contact, bound it from both sides ([`super::functional`]).
//!
//! **Without them.** P is convex in the depth and 0 up to the least gap g0: P (d - g0) >= 2 U. It grows with the contact:
//! P <= (d - g0) K(A'), K the force of a flat punch on all that may touch, A', at unit depth.

use super::bracket::{Trial, lower};
use super::expected::{NoBounds, Sought, expected, is_rough, seen_beyond_hope};
use super::functional::{Contact, Cut};
use super::of_gap::GapOverlap;
use super::on_cells::OnCells;
use super::parts::{Parts, in_parts};
use super::residual::{Halves, Residual};
use super::virial::Virial;

/// Why there are no bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Missing {
    /// What lies beyond the grid, or beyond the displacement that is known.
    Beyond,
    /// Nothing narrow enough to be worth its time, on a larger grid either.
    TooWide(NoBounds),
}

/// Bounds of the integrals of p (c_0 + c_1 x + c_2 y) (E* = 1) of any gap at this depth, by a pressure on a grid.
/// `above_least`: the depth above what the gap is nowhere less than.
pub(super) fn bounds<const N: usize>(
    overlap: &GapOverlap,
    above_least: f64,
    trial: &Trial,
    sought: Sought,
    wanted: [[f64; 3]; N],
) -> Result<[[f64; 2]; N], Missing> {
    let cells = OnCells::new(overlap, trial.grid);
    in_parts(overlap, &cells, trial.grid, |parts| {
        let mut sought = sought;
        if trial.displacement_reaches() {
            let found = by_field(&cells, trial, true, parts, above_least, sought, wanted);
            if found != Err(Missing::Beyond) {
                return found;
            }
            // What is expected of the bounds is the same.
            sought.is_judged = true;
        }
        by_field(&cells, trial, false, parts, above_least, sought, wanted)
    })
}

fn by_field<const N: usize>(
    cells: &OnCells,
    trial: &Trial,
    known: bool,
    parts: &Parts,
    above_least: f64,
    sought: Sought,
    wanted: [[f64; 3]; N],
) -> Result<[[f64; 2]; N], Missing> {
    let (field, halves) = trial.field(cells, known).ok_or(Missing::TooWide(NoBounds::NONE))?;
    let residual = &Residual { field: &field, overlap: cells, halves };
    // Where the displacement is known everywhere a larger grid tells no more of what has no bound.
    let unbounded = if known { Missing::Beyond } else { Missing::TooWide(NoBounds::NONE) };
    let enough = sought.enough;
    let pressed = &residual.pressed();
    if enough > 0.0 && !sought.is_judged {
        let rough = is_rough(residual, pressed).then_some(NoBounds::NONE);
        if let Some(expected) = rough.or_else(|| seen_beyond_hope(residual, pressed, parts, sought)) {
            return Err(Missing::TooWide(expected));
        }
    }
    let set = residual.admissible().ok_or(Missing::Beyond)?;
    let mut dips = vec![f64::INFINITY; field.grid.len()];
    let of_residual = residual.norms_and_dips(&set, Some(&mut dips)).energy();
    if !of_residual.is_finite() {
        return Err(unbounded);
    }
    // The contact alone, with all that may touch: where that is more than is under pressure, bounds are too wide for use.
    let loaded = pressed.count();
    let most = if enough > 0.0 { loaded } else { f64::INFINITY };
    let (touch, cells) = residual.may_touch(residual.deepest_dip(&dips), most).ok_or(Missing::Beyond)?;
    let (touch, ring) = (&touch[..], cells / loaded);
    let virials = wanted.map(|c| Virial::fitted(pressed, parts, c, touch));
    // What is expected of the others is not told.
    let left = virials.iter().map(|virial| virial.left).fold(0.0, f64::max);
    let expected = expected(pressed, left, [ring; 2], 0.5 * of_residual, sought);
    if cells > most {
        return Err(Missing::TooWide(expected.likely()));
    }
    if let Some(expected) = sought.beyond_hope(expected) {
        return Err(Missing::TooWide(expected));
    }
    // Means may be dear: not before they are known to be needed.
    let mut means = vec![[0.0; 2]; field.grid.len()];
    let [below, open] = lower(residual, |i, j, mean| {
        images([i, j], field.grid.shape, halves).for_each(|k| means[k] = mean);
    });
    let gamma = 0.5 * of_residual + open;
    if !(below > 0.0 && gamma.is_finite()) {
        return Err(unbounded);
    }
    let force = 2.5 * below / above_least;
    let cut = Cut::around(&field, touch, halves);
    let contact = Contact { residual, parts, pressed, means, cut, below, open, gamma, touch, ring };
    let mut bounds = [[0.0; 2]; N];
    // What is odd about a mirror is 0.
    for (virial, bounds) in virials.iter().zip(&mut bounds).filter(|(virial, _)| virial.eta != [0.0; 3]) {
        let found = contact.bounds(virial, above_least, enough * force);
        *bounds = found.filter(|[low, high]| low <= high).ok_or(unbounded)?;
    }
    Ok(bounds)
}

/// Places of a cell and its images.
fn images([i, j]: [usize; 2], [nx, ny]: [usize; 2], halves: Halves) -> impl Iterator<Item = usize> {
    let columns = [Some(i), halves[0].then_some(nx - 1 - i)];
    let rows = [Some(j), halves[1].then_some(ny - 1 - j)];
    rows.into_iter().flatten().flat_map(move |j| columns.into_iter().flatten().map(move |i| j * nx + i))
}

#[cfg(test)]
mod tests {
    use super::super::force::force_bracket;
    use crate::gap::{AnyGap, Formula};
    use crate::numeric::geometry::Rect;
    use crate::{Discrete, Grid, Kernel, matrix_free};

    use super::super::bracket::Trial;

    #[test]
    fn a_tip_that_is_no_cone_within_a_curved_body_is_bounded() {
        let gap = AnyGap::from(&Formula::new("0.5*hypot(x, 2*y) + (x^2 + y^2)/4 + 0.1*x").unwrap());
        let solved = |cells: usize| {
            let grid = Grid::over(&Rect::around([-0.02, 0.0], [0.48, 0.28]), [cells, cells]);
            let problem = Discrete::sample(&gap, 0.2, grid, Kernel::Galerkin);
            let solved = matrix_free::solve_nested(&problem, &matrix_free::Settings::default()).unwrap();
            let trial = Trial { grid: &grid, pressure: &solved.pressure, displacement: Some(&solved.displacement) };
            (solved.pressure.iter().sum::<f64>() * grid.cell_area(), force_bracket(&gap, 0.2, &trial))
        };
        let (finer, _) = solved(160);
        let (force, bounds) = solved(48);
        let [low, high] = bounds.expect("bounded");
        assert!(low < finer && finer < high && high - low < 0.1 * force, "{low} {finer} {high}");
    }
}
