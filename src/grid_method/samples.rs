//! What the samples of a measured gap leave open of a contact on a grid.
//!
//! Let the gap be off by no more than e >= 0, from place to place. With q(B) the pressure of a flat punch of unit depth on B, A the contact
//! and g what the displaced bodies leave between them, S q(A) = 1 on A, and P(f) >= <q(B), f> for any B ([`crate::approximate`]):
//!
//! ```text
//! P(f - e) >= <q(A), f - e> = P(f) - <q(A), e>
//! P(f + e)  = <q(A'), f + e> <= P(f) + <q(A'), e - g>,   A' within A and {g < e}
//! ```
//!
//! since S p = f + g gives <q(A'), f + g> <= P(f), and more overlap takes nothing off the pressure anywhere. A' is taken as all of A and
//! {g < e}. Of the energy, <p, e> and what the forces grow by times e. The e of a cell is an estimate ([`crate::gap::Gap::left_open`]).

use std::f64::consts::PI;

use super::domain;
use super::single_grid::GridState;
use crate::discrete::Discrete;
use crate::gap::{AnyGap, Gap, LeftOpen};
use crate::grid::{Grid, Kernel, shape};
use crate::matrix_free;
use crate::numeric::geometry::{Rect, distance};
use crate::overlap::{Overlap, Scaled};
use crate::problem::Method;
use crate::solution::Samples;

/// Residual of the flat punch: its sum errs by the square.
const OF_PUNCH: f64 = 1e-6;

/// In the units of the scaled; `None` where nothing is measured, and where no flat punch is found.
pub(super) fn left_open(scaled: &Scaled, state: &GridState) -> Option<Samples> {
    if !scaled.gap.is_measured() {
        return None;
    }
    let GridState { problem, solution, .. } = state;
    let (grid, pressure) = (&problem.grid, &solution.pressure);
    let cells: Vec<_> = grid.cells().collect();
    let open = scaled.gap.left_open(&cells);
    let displaced = matrix_free::displacement(problem, pressure);
    // What is left between the bodies.
    let left = |k: usize| if pressure[k] > 0.0 { 0.0 } else { displaced[k] - problem.overlap[k] };
    let more: Vec<f64> = (0..grid.len()).map(|k| (open[k].size() - left(k)).max(0.0)).collect();
    let touching: Vec<f64> =
        pressure.iter().zip(&more).map(|(&p, &more)| if p > 0.0 || more > 0.0 { 1.0 } else { 0.0 }).collect();
    let off = more.iter().copied().fold(0.0, f64::max);
    if !(off > 0.0) {
        return None;
    }
    let settings = matrix_free::Settings { tolerance: OF_PUNCH, ..matrix_free::Settings::default() };
    let punch = matrix_free::growth_in_sum(problem, &touching, &touching, &settings).ok()?;
    let area = grid.cell_area();
    // How what coarser samples miss falls is told by all of them together.
    let within = |weights: &[f64]| {
        let weighted = |k: usize| open[k] * (weights[k].max(0.0) * area * (more[k] / open[k].size()));
        let counts = |k: &usize| weights[*k] > 0.0 && more[*k] > 0.0;
        (0..grid.len()).filter(counts).map(weighted).fold(LeftOpen::default(), |sum, one| sum + one).size()
    };
    let force = within(&punch);
    Some(Samples { off, force, work: within(pressure) + force * off })
}

/// Whether the samples leave so much open that contacts within these rectangles, with these loads at E* = 1, may not be all there are: more
/// somewhere between them than the undeformed gap and what they displace. A load is as far away as it can be in its rectangle.
pub(super) fn may_touch_between(gap: &AnyGap, depth: f64, contacts: &[(Rect, f64)]) -> bool {
    let Some(all) = contacts.iter().map(|(within, _)| *within).reduce(|a, b| a.union(&b)).filter(|_| gap.is_measured())
    else {
        return false;
    };
    let grid = Grid::over(&all, shape(&all, BETWEEN));
    let between: Vec<Rect> =
        grid.cells().filter(|cell| !contacts.iter().any(|(within, _)| within.contains(cell.centre()))).collect();
    let left = |[x, y]: [f64; 2]| {
        let away = |within: &Rect| within.corners().iter().map(|c| distance([x, y], *c)).fold(0.0, f64::max);
        let displaced = contacts.iter().map(|(within, force)| force / (PI * away(within))).sum::<f64>();
        gap.gap(x, y) - depth + displaced
    };
    gap.left_open(&between).iter().zip(&between).any(|(open, cell)| open.size() > left(cell.centre()))
}

/// Cells along the longer side for that.
const BETWEEN: usize = 256;

/// What they will leave open of the force, relative to it: on few cells, which only have to show the way.
pub(super) fn expected(overlap: &Overlap) -> f64 {
    let on_few_cells = || {
        let scaled = overlap.scaled();
        let window = domain::locate(&scaled).ok()?;
        let problem =
            Discrete::sample(&scaled.gap, scaled.depth, Grid::over(&window, shape(&window, CELLS)), Kernel::Galerkin);
        let solution = domain::coarse(&problem).ok()?;
        let state = GridState::of(Method::Fft, problem, solution);
        let share = left_open(&scaled, &state)?.force / state.force();
        Some(share).filter(|share| share.is_finite())
    };
    on_few_cells().unwrap_or_else(|| where_they_overlap(overlap))
}

/// The same where few cells find no contact: what samples leave open of the gap where the undeformed bodies overlap, the deeper the more it
/// counts; P is convex, and so is of degree one at least.
fn where_they_overlap(overlap: &Overlap) -> f64 {
    let reach = &overlap.reach;
    let grid = Grid::over(reach, shape(reach, CELLS));
    let places: Vec<_> = grid.cells().collect();
    let depth = |at: [f64; 2]| (overlap.depth - overlap.gap.gap(at[0], at[1])).max(0.0);
    let weights: Vec<f64> = grid.centres().map(depth).collect();
    let open = overlap.gap.left_open(&places);
    let sum = open.into_iter().zip(&weights).fold(LeftOpen::default(), |sum, (open, weight)| sum + open * *weight);
    let whole: f64 = weights.iter().sum();
    let off = if whole > 0.0 { (sum * (1.0 / whole)).size() } else { overlap.gap.sampling_error(reach) };
    off / overlap.deepest
}

/// Cells along the longer side for that.
const CELLS: usize = 64;
