//! What a state must show before it is called solved. Every state passes here, once, on its way out of [`crate::solve`].
//!
//! | condition | verdict where it fails |
//! |---|---|
//! | every number is finite, and none that must be positive has lost digits to underflow | `incomplete` |
//! | a force has an area, a centroid, a mean pressure, a stiffness; no force: the bodies do not overlap | `incomplete` |
//! | what was prescribed comes back as it was given | `incomplete` |
//! | force, energy and stiffness are those of one contact, within the bounds that were proved ([`crate::consistency`]) | `inconsistent` |
//! | the error of the force is stated, and not larger than the tolerance | `tolerance_not_reached`, with the state |

pub(crate) mod remarks;
pub(crate) mod sampled;
pub(crate) mod stated;
pub(crate) mod validity;

use crate::bracket::Evidence;
use crate::consistency::{Claim, Response, nothing_left_out, too_few_cells, within};
use crate::gap::Gap;
use crate::overlap::least;
use crate::problem::{Contact, Load, Settings};
use crate::solution::{Origin, Solution, Unsolved, Verdict, rounded_up};

/// The answer as it leaves the library: a state that fails a condition becomes a verdict, and a verdict keeps its best state
/// only when that is complete.
///
/// # Errors
/// Those of the answer; `Incomplete`; `ToleranceNotReached` with the state.
pub(crate) fn accepted(
    contact: &Contact,
    load: Load,
    settings: &Settings,
    answer: Result<Solution, Unsolved>,
) -> Result<Solution, Unsolved> {
    match answer {
        Ok(state) => match (complete(contact, load, settings, &state), short(settings, &state)) {
            (Ok(()), None) => Ok(state),
            (Ok(()), Some(reason)) => {
                let hint = finer(settings, &state);
                Err(Unsolved::new(Verdict::ToleranceNotReached, reason).with_best(state).with_hint(hint))
            }
            (Err(broken), Some(reason)) if broken.verdict == Verdict::Inconsistent => {
                let hint = finer(settings, &state);
                let short = Unsolved::new(Verdict::ToleranceNotReached, reason).with_hint(hint);
                Err(short.without_numbers(&broken))
            }
            (Err(broken), _) => Err(broken),
        },
        Err(mut unsolved) => {
            match unsolved.best.as_ref().map_or(Ok(()), |state| complete(contact, load, settings, state)) {
                Err(broken) if broken.verdict == Verdict::Inconsistent => unsolved = unsolved.without_numbers(&broken),
                Err(_) => unsolved.best = None,
                Ok(()) => {}
            }
            if unsolved.hint.is_none() {
                unsolved.hint = match (unsolved.verdict, &unsolved.best) {
                    (Verdict::TimeLimit, _) => Some(LONGER.to_owned()),
                    (Verdict::ToleranceNotReached, Some(state)) => Some(finer(settings, state)),
                    _ => None,
                };
            }
            Err(unsolved)
        }
    }
}

/// Numbers that the fields of all states of a scene may hold together: 1 GiB.
const MOST_VALUES: usize = 1 << 27;

/// Numbers that a piece of a patch holds.
const A_PIECE: usize = 9;

/// Pieces that a state keeps where there is no room for all.
const MOST_PIECES: usize = 5;

/// The answer without its fields where those of the states before, `held` numbers, leave no room for them.
pub(crate) fn within_memory(answer: Result<Solution, Unsolved>, held: &mut usize) -> Result<Solution, Unsolved> {
    let mut answer = answer;
    let Some(state) = answer.as_mut().map_or_else(|e| e.best.as_deref_mut(), Some) else { return answer };
    let pressure = &mut state.pressure;
    let values = pressure.field.as_ref().map_or(0, |field| field.values.len())
        + pressure.gap.as_ref().map_or(0, |(_, gaps)| gaps.len())
        + 2 * state.patch.boundary.iter().flatten().map(Vec::len).sum::<usize>()
        + A_PIECE * state.patch.pieces.len();
    if *held == 0 || *held + values <= MOST_VALUES {
        *held += values;
        return answer;
    }
    (pressure.field, pressure.gap, state.patch.boundary) = (None, None, None);
    state.patch.pieces.truncate(MOST_PIECES);
    let reason = format!("the fields of all states of loading hold more than {MOST_VALUES} numbers");
    let unsolved = Unsolved::new(Verdict::TooLarge, reason).with_hint("fewer states, or fewer cells");
    Err(answer.map_or_else(|e| e, |state| unsolved.with_best(state)))
}

/// What helps when the time is used up.
const LONGER: &str = "more \"seconds\" in \"solve\" (batch: --seconds), a larger tolerance, or fewer cells";

/// What helps when the error is larger than the tolerance.
fn finer(settings: &Settings, state: &Solution) -> String {
    let enough =
        state.force_error.map_or(String::new(), |error| format!("a tolerance of {} or more; ", rounded_up(error)));
    let other = match (state.origin, settings.cells) {
        (Origin::ClosedForm, _) => "rounding is all that is left of the error",
        (_, Some(_)) => "more cells, or no \"cells\" at all: they are then chosen by the tolerance",
        (_, None) => "another method may do better: see `contact-patch compare`",
    };
    format!("{enough}{other}")
}

/// # Errors
/// `Incomplete`, with the parts that are missing or beyond the range of numbers.
fn complete(contact: &Contact, load: Load, settings: &Settings, state: &Solution) -> Result<(), Unsolved> {
    let lost = lost(state);
    if !lost.is_empty() {
        // Integrals that time was too short for are no numbers.
        settings.deadline.check()?;
        let reason = format!("beyond the range of numbers (1e-308 to 1e308): {}", lost.join(", "));
        let hint = "units in which lengths, forces and moduli are closer to 1";
        return Err(Unsolved::new(Verdict::Incomplete, reason).with_hint(hint));
    }
    let missing = missing(contact, state);
    if !missing.is_empty() {
        return Err(Unsolved::new(Verdict::Incomplete, missing.join("; ")));
    }
    if !as_prescribed(load, state) {
        let reason =
            format!("the answer, depth {:e} and force {:e}, is not that of the load", state.depth, state.force);
        return Err(Unsolved::new(Verdict::Incomplete, reason));
    }
    consistent(contact, settings, state)
}

/// # Errors
/// `Inconsistent`, with the law that is broken.
fn consistent(contact: &Contact, settings: &Settings, state: &Solution) -> Result<(), Unsolved> {
    // Approximate methods answer what they define; without a stated error nothing is claimed of the force.
    let Some(error) = state.force_error.filter(|error| *error < 1.0 && state.origin != Origin::Approximate) else {
        return Ok(());
    };
    if state.force == 0.0 {
        return Ok(());
    }
    let claim = Claim { force: state.force, error: error * state.force };
    if let Some(bracket) = state.bracket.as_ref().filter(|bracket| bracket.evidence() == Evidence::Proved) {
        within([bracket.lower(), bracket.upper()], claim, "the proof")?;
    }
    let gap = contact.tilted_gap(state.tilt);
    let load = state.force / contact.modulus().e_star();
    // Of contacts far apart the grid is that of one; they were held against the grids of all.
    let apart = matches!(state.origin, Origin::SeparateContacts { .. });
    if let Some(grid) = state.grid.filter(|_| load.is_normal() && !apart) {
        nothing_left_out(&gap, state.depth, &[grid.extent()], load)
            .map_err(|broken| if settings.cells.is_some() { too_few_cells(&broken) } else { broken })?;
    }
    let known = gap.known();
    let depth = state.depth - known.law.map_or(known.floor, |law| law.lowest);
    let degree = known.law.map(|law| law.degree);
    Response { claim, energy: state.energy, stiffness: state.stiffness, depth, degree }.of_one_contact()
}

/// Numbers that are not finite, and positive ones that are too small to hold all their digits.
fn lost(state: &Solution) -> Vec<&'static str> {
    let pressure = &state.pressure;
    let values = |field: &[f64]| field.iter().all(|v| v.is_finite());
    let positive = |x: f64| x == 0.0 || x >= f64::MIN_POSITIVE && x.is_finite();
    let point = |p: &[f64; 2]| p.iter().all(|x| x.is_finite());
    let holds = [
        ("depth", state.depth.is_finite()),
        ("tilt", point(&state.tilt)),
        ("force", positive(state.force)),
        ("force_error", state.force_error.is_none_or(|error| error.is_finite() && error >= 0.0)),
        ("stiffness", positive(state.stiffness)),
        ("stiffness_matrix", state.stiffness_matrix.iter().flatten().flatten().all(|k| k.is_finite())),
        ("moment", state.moment.is_none_or(|moment| point(&moment))),
        ("energy", state.energy.is_none_or(|u| positive(u) && (u > 0.0 || state.force == 0.0))),
        ("patch.area", positive(state.patch.area)),
        ("patch.centroid", state.patch.centroid.is_none_or(|centroid| point(&centroid))),
        ("patch.max_radius", positive(state.patch.max_radius)),
        ("patch.boundary", state.patch.boundary.iter().flatten().flatten().all(point)),
        ("pressure.max", pressure.max.is_none_or(positive)),
        ("pressure.mean", pressure.mean.is_none_or(positive)),
        ("pressure.at", pressure.at.is_none_or(|at| point(&at))),
        ("pressure.field", pressure.field.as_ref().is_none_or(|field| values(&field.values))),
        // Infinite where there is no material.
        ("gap.field", pressure.gap.iter().flat_map(|(_, gaps)| gaps).all(|gap| *gap > f64::NEG_INFINITY)),
        ("grid", state.grid.is_none_or(|grid| point(&grid.origin) && grid.spacing.iter().all(|h| *h > 0.0))),
        ("checks", state.residuals.is_none_or(|r| values(&[r.complementarity, r.tension, r.penetration]))),
    ];
    holds.into_iter().filter(|(_, holds)| !holds).map(|(what, _)| what).collect()
}

/// Parts that the others ask for.
fn missing(contact: &Contact, state: &Solution) -> Vec<&'static str> {
    if state.force == 0.0 {
        let gap = contact.tilted_gap(state.tilt);
        let overlap = |[x, y]: [f64; 2]| gap.gap(x, y) < state.depth;
        let apart = !overlap(gap.known().centre) && !overlap(least(&gap).0);
        let holds = [
            ("no force, where the undeformed bodies overlap", apart),
            ("an area without a force", state.patch.area == 0.0),
            ("a stiffness without a force", state.stiffness == 0.0),
        ];
        return holds.into_iter().filter(|(_, holds)| !holds).map(|(what, _)| what).collect();
    }
    let on_grid = matches!(state.origin, Origin::OneGrid | Origin::ManyGrids { .. } | Origin::SeparateContacts { .. });
    let holds = [
        ("a force without an area", state.patch.area > 0.0),
        ("a force without a centroid of its patch", state.patch.centroid.is_some()),
        ("a force without a region", state.patch.regions > 0),
        ("a force without a radius of its patch", state.patch.max_radius > 0.0),
        ("a force without a mean pressure", state.pressure.mean.is_some_and(|mean| mean > 0.0)),
        ("a force without a stiffness", state.stiffness > 0.0),
        ("a grid without its checks", !on_grid || state.residuals.is_some()),
        ("a grid without its cells", !on_grid || state.grid.is_some()),
    ];
    holds.into_iter().filter(|(_, holds)| !holds).map(|(what, _)| what).collect()
}

fn as_prescribed(load: Load, state: &Solution) -> bool {
    match load {
        Load::Depth(depth) => state.depth == depth && state.tilt == [0.0; 2],
        Load::Tilted { depth, tilt } => state.depth == depth && state.tilt == tilt,
        Load::Force(force) => state.force == force && state.tilt == [0.0; 2],
        Load::ForceMoment { force, moment } => state.force == force && (force == 0.0 || state.moment == Some(moment)),
    }
}

/// What the state falls short by; `None` when it is as good as asked for. Approximate methods state no error: they answer what
/// they define.
fn short(settings: &Settings, state: &Solution) -> Option<String> {
    match state.force_error {
        Some(error) if error <= settings.tolerance => None,
        Some(error) => {
            let tolerance = settings.tolerance;
            Some(format!("relative error {error:.1e} of the force reached; the tolerance is {tolerance:.1e}"))
        }
        None if state.origin == Origin::Approximate => None,
        None => Some("no estimate of the error of the force could be made".to_owned()),
    }
}
