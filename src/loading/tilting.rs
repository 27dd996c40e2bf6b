//! A punch free to tilt: balanced on grids that become finer until the force is good enough.

use super::engine::Engine;
use super::equilibrium;
use crate::gap::{AnyGap, Gap, Reach};
use crate::grid_method::extrapolation::Intercept;
use crate::grid_method::sharp_edges;
use crate::numeric::geometry::Rect;
use crate::overlap::least;
use crate::problem::{Contact, Method, Settings};
use crate::solution::{Origin, Solution, Unsolved, Verdict};

/// A box around everything that can touch at any tilt: where the gap is less than a depth beyond all measure.
fn material(gap: &AnyGap, depth: f64) -> Option<Rect> {
    let (_, least) = least(gap);
    match gap.reach(least + 1e12 * (depth - least)) {
        Reach::Within(rect) => Some(rect),
        _ => None,
    }
}

/// The state under a force and moments (Mx, My) about the origin; `untilted` is that under the force without tilt.
///
/// # Errors
/// `NoEquilibrium` when the line of action passes outside of what can touch; `ToleranceNotReached`; the verdicts of the method.
pub(crate) fn under_moment(
    contact: &Contact,
    untilted: Solution,
    force: f64,
    moment: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    if force == 0.0 {
        return if moment == [0.0; 2] {
            Ok(untilted)
        } else {
            Err(Unsolved::new(Verdict::NoEquilibrium, "a moment without a force"))
        };
    }
    let through = [-moment[1] / force, moment[0] / force];
    if let Some(material) = material(contact.gap(), untilted.depth)
        && !material.contains(through)
    {
        let (a, b) = (material.min, material.max);
        let reason = format!(
            "the line of action meets the surface at ({:e}, {:e}), outside of all material, [{:e}, {:e}] x [{:e}, {:e}]",
            through[0], through[1], a[0], b[0], a[1], b[1]
        );
        return Err(Unsolved::new(Verdict::NoEquilibrium, reason));
    }
    let size = (untilted.patch.area / std::f64::consts::PI).sqrt();
    // The last linear step of a force-driven solve has no place here: the state is solved anew at every tilt.
    let mut engine = Engine::new(contact, settings, true);
    let close = |method: Method| match method {
        // Rounding in the force of a deep state is what is left.
        Method::ClosedForm => 1e-11,
        _ => 0.01 * settings.tolerance,
    };
    let balance =
        |engine: &mut Engine, start: Solution| equilibrium::under_moment(engine, force, moment, start, size, close);
    let mut state = balance(&mut engine, untilted)?;
    let short =
        |state: &Solution| state.force_error.filter(|&error| settings.cells.is_none() && error > settings.tolerance);
    // What one grid tells of its error at sharp edges, whose cells err by the first power, may be small by chance.
    if settings.cells.is_none() && engine.shared.sharp {
        return at_sharp_edges(&mut engine, state, settings, &balance);
    }
    while let Some(error) = short(&state) {
        if engine.cells >= FINEST {
            return Err(
                Unsolved::short_of(settings.tolerance, error, &sharp_edges::most(engine.cells)).with_best(state)
            );
        }
        engine.cells *= 2;
        state = or_coarser(balance(&mut engine, state.clone()), &state)?;
    }
    Ok(state)
}

/// A state on a finer grid; when the time is used up before there is one, the verdict carries the coarser.
fn or_coarser(finer: Result<Solution, Unsolved>, coarser: &Solution) -> Result<Solution, Unsolved> {
    finer.map_err(|e| {
        let out_of_time = e.verdict == Verdict::TimeLimit && e.best.is_none();
        if out_of_time { e.with_best(coarser.clone()) } else { e }
    })
}

/// A punch balanced on many grids, and the limit of what they give; see [`sharp_edges`].
fn at_sharp_edges(
    engine: &mut Engine,
    mut state: Solution,
    settings: &Settings,
    balance: &dyn Fn(&mut Engine, Solution) -> Result<Solution, Unsolved>,
) -> Result<Solution, Unsolved> {
    // The grids tell the error together.
    engine.shared.needs_error = false;
    let (mut grids, mut found) = (Vec::new(), Vec::new());
    let mut limited: Option<Solution> = None;
    // A grid alone says nothing of its error.
    let untold = |state: &Solution| Solution { force_error: None, ..state.clone() };
    for cells in (0..).map(sharp_edges::cells).take_while(|&n| n <= sharp_edges::FINEST / 2) {
        engine.cells = cells;
        state = balance(engine, state.clone()).map_err(|e| match e.verdict {
            Verdict::TimeLimit => e.with_best(limited.take().unwrap_or_else(|| untold(&state))),
            _ => e,
        })?;
        grids.push(engine.shared.measure);
        found.push(numbers(&state));
        let Some(line) = Intercept::new(&grids) else { continue };
        let limit = at_limit(&line, &found, state.clone());
        if limit.force_error.is_some_and(|reached| reached <= settings.tolerance) {
            return Ok(limit);
        }
        limited = Some(limit);
    }
    let reason = sharp_edges::most(engine.cells);
    let best = limited.unwrap_or_else(|| untold(&state));
    let reached = best.force_error.unwrap_or(f64::INFINITY);
    Err(Unsolved::short_of(settings.tolerance, reached, &reason).with_best(best))
}

/// What is taken to the limit: depth, tilts, energy, area and the stiffness matrix.
fn numbers(state: &Solution) -> Vec<f64> {
    let matrix = state.stiffness_matrix.unwrap_or([[f64::NAN; 3]; 3]);
    let scalars = [state.depth, state.tilt[0], state.tilt[1], state.energy.unwrap_or(f64::NAN), state.patch.area];
    scalars.into_iter().chain(matrix.into_iter().flatten()).collect()
}

/// The state of the finest grid with its numbers at the limit of the line through all grids, and what that leaves open.
fn at_limit(line: &Intercept, found: &[Vec<f64>], mut state: Solution) -> Solution {
    let limit = |of: &dyn Fn(&[f64]) -> f64| line.of(&found.iter().map(|values| of(values)).collect::<Vec<_>>());
    // To first order, the load at any depth and tilts is off by as much as this is: the force, and its moments about where it acts over the
    // size of the contact.
    let matrix = state.stiffness_matrix.unwrap_or([[f64::NAN; 3]; 3]);
    let [mx, my] = state.moment.unwrap_or([f64::NAN; 2]);
    let arm = [0.0, -my / state.force, mx / state.force];
    let off = |n: usize| {
        let row = [0, 1, 2].map(|j| matrix[n][j] - arm[n] * matrix[0][j]);
        limit(&|values| row[0] * values[0] + row[1] * values[1] + row[2] * values[2]).error / state.force
    };
    let size = (state.patch.area / std::f64::consts::PI).sqrt();
    let reached = off(0).max(off(1).hypot(off(2)) / size);
    let at = |n: usize| limit(&|values| values[n]).value;
    (state.depth, state.tilt, state.energy) = (at(0), [at(1), at(2)], Some(at(3)));
    let wider = at(4) / state.patch.area;
    state.patch.pieces.iter_mut().for_each(|piece| piece.area *= wider);
    state.patch.area = at(4);
    let share = |n: usize| {
        let limit = limit(&|values| values[n]);
        Some((limit.error / limit.value).abs()).filter(|error| error.is_finite())
    };
    (state.energy_error, state.area_error, state.stiffness_error) = (share(3), share(4), share(5));
    state.pressure.mean = Some(state.force / state.patch.area);
    let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| at(5 + 3 * i + j)));
    (state.stiffness, state.stiffness_matrix) = (matrix[0][0], Some(matrix));
    state.force_error = Some(reached).filter(|reached| reached.is_finite());
    state.origin = Origin::ManyGrids { grids: found.len() };
    state.remarks.push(sharp_edges::remark(found.len()));
    state
}

/// Cells along the longer side of the last grid that is tried for a tilting punch.
const FINEST: usize = 1024;
