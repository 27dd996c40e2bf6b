//! The state at a prescribed depth and tilt, by the method that the settings ask for.

pub(crate) mod axes;
pub(crate) mod engine;
pub(crate) mod equilibrium;
pub(crate) mod shared;
pub(crate) mod tilting;

use crate::approximate;
use crate::by_edges;
use crate::closed_form::select;
use crate::gap::AnyGap;
use crate::grid_method;
use crate::overlap::Overlap;
use crate::problem::{Contact, Method, Settings};
use crate::solution::{Solution, Unsolved, Verdict};

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
    let gap = contact.tilted_gap(tilt);
    // A prescribed grid, or a gap field, is asked for by who wants a grid.
    let asked_for = settings.cells.is_some() || settings.outputs.gap;
    let apart = match settings.method {
        Method::Ritz | Method::Fabrikant => {
            return approximate::solution(contact, &gap, depth, tilt, settings, with_matrix);
        }
        Method::Auto if asked_for => Method::Fft,
        Method::Auto => Method::ClosedForm,
        prescribed => prescribed,
    };
    let Some(overlap) = Overlap::of(&gap, depth)? else { return Ok(Solution::apart(apart, depth, tilt)) };
    let grid = || grid_method::solution(contact, &overlap, tilt, settings, with_matrix);
    match settings.method {
        Method::ClosedForm => select::solution(contact, &overlap, tilt, settings),
        Method::EdgeFitted => {
            let fitted = by_edges::solution(contact, &overlap, tilt, settings, with_matrix);
            fitted.unwrap_or_else(|| Err(by_edges::not_applicable()))
        }
        Method::Auto if !asked_for => match without_grid_at(contact, &overlap, tilt, settings, with_matrix) {
            None => grid(),
            Some(Err(short)) if short.verdict == Verdict::ToleranceNotReached => better(grid(), short),
            Some(answered) => answered,
        },
        _ => grid(),
    }
}

/// The state without a grid: by a formula, else by cells fitted to edges; `None` where it takes a grid.
pub(crate) fn without_grid(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Option<Result<Solution, Unsolved>> {
    let solved = |overlap: &Overlap| without_grid_at(contact, overlap, tilt, settings, with_matrix);
    where_they_overlap(gap, depth, tilt, solved)
}

/// The state by a formula, where one holds.
pub(crate) fn by_formula(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Option<Result<Solution, Unsolved>> {
    where_they_overlap(gap, depth, tilt, |overlap| by_formula_at(contact, overlap, tilt, settings))
}

fn where_they_overlap(
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    solved: impl FnOnce(&Overlap) -> Option<Result<Solution, Unsolved>>,
) -> Option<Result<Solution, Unsolved>> {
    match Overlap::of(gap, depth) {
        Ok(Some(overlap)) => solved(&overlap),
        Ok(None) => Some(Ok(Solution::apart(Method::ClosedForm, depth, tilt))),
        Err(unsolved) => Some(Err(unsolved)),
    }
}

/// As [`without_grid`], where the overlap is known.
fn without_grid_at(
    contact: &Contact,
    overlap: &Overlap,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Option<Result<Solution, Unsolved>> {
    let on_cells = || {
        let tilts = with_matrix || tilt != [0.0; 2];
        by_edges::chosen_by(settings).then(|| by_edges::solution(contact, overlap, tilt, settings, tilts)).flatten()
    };
    by_formula_at(contact, overlap, tilt, settings).or_else(on_cells)
}

/// As [`by_formula`], where the overlap is known.
fn by_formula_at(
    contact: &Contact,
    overlap: &Overlap,
    tilt: [f64; 2],
    settings: &Settings,
) -> Option<Result<Solution, Unsolved>> {
    let answered = select::solution(contact, overlap, tilt, settings);
    Some(answered).filter(|answered| !answered.as_ref().is_err_and(|e| e.verdict == Verdict::NoClosedForm))
}

/// The state of the grid, where it is as good as asked for and within the bounds of the one that falls short.
fn better(grid: Result<Solution, Unsolved>, short: Unsolved) -> Result<Solution, Unsolved> {
    let within = |state: &Solution| {
        let bounds = short.best.as_ref().and_then(|best| Some((best.force, best.force * best.force_error?)));
        bounds.is_none_or(|(force, error)| (state.force - force).abs() <= error)
    };
    match grid {
        Ok(state) if within(&state) => Ok(state),
        _ => Err(short),
    }
}
