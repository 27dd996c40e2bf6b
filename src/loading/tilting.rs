//! A punch free to tilt: balanced on grids that become finer until the force is good enough.

use super::engine::{CellsOfTilts, Engine};
use super::equilibrium::{self, Respond};
use crate::gap::{AnyGap, Gap, Reach};
use crate::grid_method::SharedGrid;
use crate::grid_method::extrapolation::{self, Intercept};
use crate::grid_method::sharp_edges::{self, Edge};
use crate::numeric::geometry::Rect;
use crate::overlap::least;
use crate::problem::{Contact, Method, Settings};
use crate::solution::{Origin, Solution, Unsolved, Verdict};

/// Several times the rounding of a depth.
const DIGITS: f64 = 32.0 * f64::EPSILON;

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
    let material = material(contact.gap(), untilted.depth);
    if let Some(material) = material.filter(|material| !material.contains(through)) {
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
    engine.shared.material = material;
    let close = |state: &Solution| match state.method {
        // Depth and tilts cancel where the force acts, up to what overlaps there.
        Method::ClosedForm => {
            let terms = state.depth.abs() + (state.tilt[0] * through[0]).abs() + (state.tilt[1] * through[1]).abs();
            equilibrium::CLOSED.max(DIGITS * terms * state.stiffness / state.force)
        }
        // Fitted anew at every tilt, with a noise that no step gets below.
        Method::EdgeFitted => 0.1 * settings.tolerance,
        _ => 0.01 * settings.tolerance,
    };
    let mut guess = lowest_at(contact.gap(), through, &untilted, size);
    let mut balance = |engine: &mut Engine, start: Solution| {
        let found = equilibrium::under_moment(engine, force, moment, start, guess.take(), size, close);
        found.map(|state| with_lawful_energy(contact, state))
    };
    let start = untilted.clone();
    let mut answered = match balance(&mut engine, untilted) {
        // Formulas, and cells that are fitted anew at every tilt, tell their own errors, which no other grid changes.
        Ok(state) if matches!(state.origin, Origin::EdgeFitted | Origin::ClosedForm) => return Ok(state),
        Err(short) if engine.cells_of_tilts == CellsOfTilts::Fitted && short.verdict != Verdict::TimeLimit => {
            engine.cells_of_tilts = CellsOfTilts::Grid;
            balance(&mut engine, start.clone())
        }
        answered => answered,
    };
    // Cells that miss the contact say nothing about the load.
    let mut least = 0;
    while matches!(&answered, Err(e) if e.verdict == Verdict::NoEquilibrium) && misses_contact(&mut engine, &start)? {
        if settings.cells.is_some() || engine.cells >= FINEST {
            let reason = format!(
                "no grid of up to {} cells along the longer side is fine enough to see the contact",
                engine.cells
            );
            return Err(Unsolved::new(Verdict::ToleranceNotReached, reason));
        }
        engine.cells *= 2;
        least = engine.cells;
        answered = balance(&mut engine, start.clone());
    }
    let mut state = answered?;
    // What one grid tells of its error at sharp edges, whose cells err by the first power, may be small by chance.
    match (settings.cells, engine.shared.edge) {
        (Some(cells), Some(_)) => return as_given(&mut engine, cells, state, &mut balance),
        (None, Some(Edge::End)) => return at_sharp_edges(&mut engine, least, state, settings, &mut balance),
        _ => {}
    }
    let mut found = vec![numbers(&state)];
    // One grid alone tells too little of what it has not resolved.
    let mut error = f64::INFINITY;
    while settings.cells.is_none() && error > settings.tolerance {
        if engine.cells >= FINEST {
            let most = sharp_edges::most(engine.cells);
            return Err(Unsolved::short_of(settings.tolerance, error, &most).with_best(state));
        }
        engine.cells *= 2;
        state = or_coarser(balance(&mut engine, state.clone()), &state)?;
        found.push(numbers(&state));
        state = with_errors_of(&found, state, engine.shared);
        error = state.force_error.unwrap_or(f64::INFINITY);
    }
    Ok(state)
}

/// Share of the force of an untilted state that cells may miss.
const MISSED: f64 = 0.3;

/// Whether the cells that all tilts share are too few for the contact without tilt.
fn misses_contact(engine: &mut Engine, untilted: &Solution) -> Result<bool, Unsolved> {
    if engine.cells_of_tilts != CellsOfTilts::Grid {
        return Ok(false);
    }
    let found = match engine.respond(untilted.depth, [0.0; 2], false) {
        Err(e) if e.verdict != Verdict::TimeLimit => return Ok(false),
        found => found?,
    };
    Ok((found.force / untilted.force - 1.0).abs() > MISSED)
}

/// Depth and tilt with which the gap is lowest where the line of action meets it and overlaps as much as without tilt, where that is not in
/// the contact: for a paraboloid they balance the load.
fn lowest_at(gap: &AnyGap, through: [f64; 2], untilted: &Solution, size: f64) -> Option<(f64, [f64; 2])> {
    let [mx, my] = untilted.moment?;
    let [x, y] = [-my / untilted.force - through[0], mx / untilted.force - through[1]];
    let tilt = gap.gradient(through[0], through[1]).filter(|tilt| x.hypot(y) > size && *tilt != [0.0; 2])?;
    let overlap = untilted.depth - least(gap).1;
    let depth = overlap + gap.gap(through[0], through[1]) - tilt[0] * through[0] - tilt[1] * through[1];
    depth.is_finite().then_some((depth, tilt))
}

/// U = P (d - g0)/(2 + 1/k) where the tilted gap follows a law: the balance needed the energy of the cells, which is further off.
fn with_lawful_energy(contact: &Contact, state: Solution) -> Solution {
    let law = contact.tilted_gap(state.tilt).known().law;
    let energy = law.map(|law| law.energy(state.force, state.depth - law.lowest));
    Solution { energy: energy.or(state.energy), ..state }
}

/// A punch balanced on a prescribed grid that ends at edges: coarser ones tell its error.
fn as_given(engine: &mut Engine, cells: usize, state: Solution, balance: &mut Balance) -> Result<Solution, Unsolved> {
    let left_out = engine.shared.measure[1];
    let mut found = Vec::new();
    for coarser in [cells.div_ceil(4), cells.div_ceil(2)].into_iter().filter(|&n| n >= 6) {
        engine.cells = coarser;
        match balance(engine, state.clone()) {
            Ok(coarse) => found.push(numbers(&coarse)),
            Err(e) if e.verdict == Verdict::TimeLimit => return Err(e.with_best(state)),
            // A grid on which nothing is in balance tells nothing.
            Err(_) => {}
        }
    }
    found.push(numbers(&state));
    let own = state.force_error;
    let mut state = with_errors_of(&found, state, engine.shared);
    if found.len() < 2 {
        state.force_error = own.map(|error| AS_GIVEN * error);
    }
    let cut = (left_out / state.patch.area).abs();
    state.force_error = state.force_error.map(|error| error.max(cut));
    state.area_error = state.area_error.map(|error| error.max(cut));
    Ok(state)
}

/// The finest of some states with no less error than what changes from one to the next leaves. At edges that is as much again as the last
/// step, the first power of the cells, and cells that fall differently upon them may make it look like less.
fn with_errors_of(found: &[Vec<f64>], mut state: Solution, SharedGrid { edge, rim, .. }: SharedGrid) -> Solution {
    let left = |of: Number| {
        let values: Vec<f64> = found.iter().map(|values| of(values)).collect();
        let elsewhere = extrapolation::of_forces(&values).map_or(f64::INFINITY, |estimate| estimate.error);
        edge.map_or(elsewhere, |_| elsewhere.max(AS_GIVEN * extrapolation::left_by_first_order(&values)))
    };
    let known = |error: f64| Some(error).filter(|error| error.is_finite());
    // What rests on where the contact ends between cells jumps from grid to grid.
    let share = |n: usize, jumps: f64| {
        let values: Vec<f64> = found.iter().map(|values| values[n]).collect();
        let change = extrapolation::left_by_first_order(&values).max(left(&|values| values[n]));
        known((change / values[values.len() - 1]).abs().max(jumps))
    };
    state.force_error = known(off_load(&state, &left).max(state.force_error.unwrap_or(0.0)));
    (state.energy_error, state.area_error, state.stiffness_error) = (share(3, 0.0), share(4, rim), share(5, rim));
    state
}

/// What is left may be more than two grids tell by this, as for a depth (`grid_method/refinement/error`).
const AS_GIVEN: f64 = 2.0;

/// A state balanced anew on a grid of as many cells as the engine is at, from another.
type Balance<'a> = dyn FnMut(&mut Engine, Solution) -> Result<Solution, Unsolved> + 'a;

/// A state on a finer grid; when the time is used up before there is one, the verdict carries the coarser.
fn or_coarser(finer: Result<Solution, Unsolved>, coarser: &Solution) -> Result<Solution, Unsolved> {
    finer.map_err(|e| {
        let out_of_time = e.verdict == Verdict::TimeLimit && e.best.is_none();
        if out_of_time { e.with_best(coarser.clone()) } else { e }
    })
}

/// A punch balanced on many grids, and the limit of what they give; see [`sharp_edges`]. `least`: cells of the coarsest one.
fn at_sharp_edges(
    engine: &mut Engine,
    least: usize,
    mut state: Solution,
    settings: &Settings,
    balance: &mut Balance,
) -> Result<Solution, Unsolved> {
    // The grids tell the error together.
    engine.shared.needs_error = false;
    let (mut grids, mut found) = (Vec::new(), Vec::new());
    let mut limited: Option<Solution> = None;
    // A grid alone says nothing of its error.
    let untold = |state: &Solution| Solution { force_error: None, ..state.clone() };
    let enough = (0..).map(sharp_edges::cells).skip_while(|&n| n < least).take_while(|&n| n <= FINEST / 2);
    for cells in enough {
        engine.cells = cells;
        state = match balance(engine, state.clone()) {
            Ok(balanced) => balanced,
            Err(e) if e.verdict == Verdict::TimeLimit => {
                return Err(e.with_best(limited.unwrap_or_else(|| untold(&state))));
            }
            // A grid on which nothing is in balance tells nothing.
            Err(e) if e.verdict == Verdict::NoEquilibrium => continue,
            Err(e) => return Err(e),
        };
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

/// A number that is made of those of a state.
type Number<'a> = &'a dyn Fn(&[f64]) -> f64;

/// By what share the load is off where depth and tilts are: to first order at any depth and tilts, the force, or its moments about where it
/// acts over the size of the contact. `error`: that of a number that is made of those of the states.
fn off_load(state: &Solution, error: &dyn Fn(Number) -> f64) -> f64 {
    let matrix = state.stiffness_matrix.unwrap_or([[f64::NAN; 3]; 3]);
    let [mx, my] = state.moment.unwrap_or([f64::NAN; 2]);
    let arm = [0.0, -my / state.force, mx / state.force];
    let off = |n: usize| {
        let row = [0, 1, 2].map(|j| matrix[n][j] - arm[n] * matrix[0][j]);
        error(&|values| row[0] * values[0] + row[1] * values[1] + row[2] * values[2]) / state.force
    };
    let size = (state.patch.area / std::f64::consts::PI).sqrt();
    off(0).max(off(1).hypot(off(2)) / size)
}

/// The state of the finest grid with its numbers at the limit of the line through all grids, and what that leaves open.
fn at_limit(line: &Intercept, found: &[Vec<f64>], mut state: Solution) -> Solution {
    let limit = |of: Number| line.of(&found.iter().map(|values| of(values)).collect::<Vec<_>>());
    let reached = off_load(&state, &|of| limit(of).error);
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
