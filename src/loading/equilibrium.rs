//! The depth, and the tilt of a punch free to tilt, that balance a given load.
//!
//! P(d) is convex and increasing, and nearly a power of the overlap: Newton's method on log P against log of the
//! overlap, with the exact stiffness, needs two or three steps from any distance. For a tilting punch the stored energy U is a
//! convex function of (d, ax, ay) whose gradient is (P, int p x, int p y) and whose Hessian the stiffness of a flat punch on the
//! contact: Newton's method on U less the work of the load.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::clock::Deadline;
use crate::edge_fitted::width_of_line_contact;
use crate::gap::{AnyGap, Reach};
use crate::overlap::{least, reach_of};
use crate::problem::Method;
use crate::solution::{Origin, Solution, Unsolved, Verdict};

/// Steps of the quick search before the load is taken to have no depth.
const MOST_STEPS: usize = 60;

/// How well the quick search meets the force before the full solves begin.
const QUICK: f64 = 0.15;

/// Change of its logarithm with which the overlap to begin with is as good as it can be.
const NEAR: f64 = 0.03;

/// Of an overlap, one at which only what is flat has a size; and a share of a size that may be that of a ring.
const AT_ONCE: f64 = 1e-6;
const OF_RINGS: f64 = 0.95;

/// Full solves after the quick search.
const MOST_FULL_STEPS: usize = 8;

/// Full solves that may go into a state closer than need be.
const PATIENT_STEPS: usize = 3;

/// Steps after which the balance of a tilting punch may be off by what a force may be, and by about as much as was asked for.
const PATIENCE: usize = 8;
const LAST_PATIENCE: usize = 20;

/// A state at a depth, quickly or to the full tolerance.
pub(crate) trait Respond {
    /// The state at this depth and tilt; `quick`: a few percent are enough.
    fn respond(&mut self, depth: f64, tilt: [f64; 2], quick: bool) -> Result<Solution, Unsolved>;

    /// A depth nearer to that under the force than a quick search finds, where a coarser grid than the full one tells.
    fn nearer(&mut self, _depth: f64, _force: f64) -> Option<f64> {
        None
    }

    /// The full state under the force itself, from the last full one; `None` where depths have to be tried.
    fn loaded(&mut self, _force: f64) -> Result<Option<Solution>, Unsolved> {
        Ok(None)
    }
}

/// A state that the search can go on from, with what it lacks: one whose error is larger than asked for serves as well.
fn usable(answer: Result<Solution, Unsolved>) -> Result<(Solution, Option<Unsolved>), Unsolved> {
    match answer {
        Ok(state) => Ok((state, None)),
        Err(Unsolved { verdict: Verdict::ToleranceNotReached, best: Some(state), reason, hint }) => {
            let short = Unsolved { verdict: Verdict::ToleranceNotReached, reason, hint, best: None };
            Ok((*state, Some(short)))
        }
        Err(e) => Err(e),
    }
}

/// P/(E* d) of an overlap within a rectangle of this size, roughly: as a line contact along it has it, pi a (b/w)^2 with a half the length,
/// less what ellipses have less, 2^(3/2)/3 a for a sphere; more where a share of it is flat, up to 2 a.
fn of_size([x, y]: [f64; 2], flat: f64) -> f64 {
    const OF_ELLIPSES: f64 = 0.3;
    let (a, w) = (0.5 * x.max(y), 0.5 * x.min(y));
    let more = 1.0 + flat * (std::f64::consts::SQRT_2 * 1.5 - 1.0);
    PI * a * width_of_line_contact([a; 2], w).powi(2) * (1.0 - OF_ELLIPSES * (w / a).powi(2)) * more
}

/// An overlap whose force is of this size; rougher where there is no time for more.
pub(crate) fn overlap_of_size(gap: &AnyGap, e_star: f64, force: f64, deadline: Deadline) -> f64 {
    let (_, least) = least(gap);
    // Forces are of the size E* times length squared: begin with that length.
    let mut overlap = (force.abs() / e_star).sqrt();
    for _ in 0..24 {
        if deadline.has_passed() {
            break;
        }
        match reach_of(gap, least + overlap) {
            Reach::Within(reach) => {
                let size = reach.size();
                // What overlaps at any depth is flat, or all but the width of a ring.
                let flat = match reach_of(gap, least + AT_ONCE * overlap) {
                    Reach::Within(tip) => (0..2).map(|k| tip.size()[k] / size[k]).fold(1.0, f64::min),
                    _ => 0.0,
                };
                let flat = if flat < OF_RINGS { flat } else { 0.0 };
                let next = (overlap * force.abs() / (e_star * of_size(size, flat))).sqrt();
                if !(next > 0.0 && next.is_finite()) {
                    break;
                }
                let close = (next / overlap).ln().abs() < NEAR;
                overlap = next;
                if close {
                    break;
                }
            }
            Reach::Nowhere => overlap *= 10.0,
            Reach::Unbounded { .. } | Reach::Unknown => overlap *= 1e-3,
        }
    }
    overlap
}

/// The state under a force without tilt. `lowest` is the least gap, `scale` an overlap to begin with, `close` the relative
/// errors of the force that may be left to the last, linear step, by the method that ran: the one that is sought, and the one
/// that will do once steps from grid to grid no longer bring the state closer; `tolerance`: of the force.
pub(crate) fn under_force(
    engine: &mut dyn Respond,
    force: f64,
    lowest: f64,
    scale: f64,
    close: impl Fn(Method) -> [f64; 2],
    tolerance: f64,
) -> Result<Solution, Unsolved> {
    let mut overlap = scale;
    // Overlaps with too little force and with too much, as far as they are known.
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut quick = true;
    let mut full_steps = 0;
    // The state nearest to the load, and how far it misses it.
    let mut nearest: Option<(f64, Solution)> = None;
    for _ in 0..MOST_STEPS {
        let answer = match if full_steps > 0 { engine.loaded(force) } else { Ok(None) } {
            Ok(Some(loaded)) => {
                overlap = loaded.depth - lowest;
                Ok(loaded)
            }
            Ok(None) => engine.respond(lowest + overlap, [0.0; 2], quick),
            Err(unsolved) => Err(unsolved),
        };
        let (state, short) = match usable(answer) {
            Ok(found) => found,
            // Deeper than the contact has an end: look above.
            Err(e) if e.verdict == Verdict::Unbounded => {
                high = overlap;
                let known = nearest.as_ref().map(|(_, state)| state.depth - lowest).filter(|known| *known < high);
                let below = if low > 0.0 { Some(low) } else { known };
                overlap = below.map_or(1e-3 * overlap, |below| (below * high).sqrt());
                if overlap < f64::MIN_POSITIVE || high / below.unwrap_or(0.0) < 1.0 + 1e-9 {
                    return Err(e);
                }
                continue;
            }
            Err(e) if e.verdict == Verdict::TimeLimit => {
                let known = e.best.as_deref().map(|state| (miss_of(state, force), state.clone()));
                let best = [nearest, known].into_iter().flatten().min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
                let e = Unsolved { best: None, ..e };
                return Err(match best {
                    Some((miss, state)) if miss.is_finite() => e.with_best(off_by(miss, last_step(state, force))),
                    _ => e,
                });
            }
            Err(e) => return Err(e),
        };
        if state.force <= 0.0 || state.stiffness <= 0.0 {
            low = overlap;
            overlap = if high.is_finite() { (low * high).sqrt() } else { 1e3 * overlap };
            if !(overlap > low && overlap < high) {
                break;
            }
            continue;
        }
        let miss = miss_of(&state, force);
        if !quick {
            full_steps += 1;
            let [sought, enough] = close(state.method);
            let near = miss.abs() <= if full_steps >= PATIENT_STEPS { enough } else { sought };
            let done = near || is_linear(&state, miss.abs(), tolerance);
            if done || full_steps == MOST_FULL_STEPS {
                let stepped = last_step(state, force);
                let state = if done { stepped } else { off_by(miss, stepped) };
                return match short {
                    None => Ok(state),
                    Some(short) => Err(short.with_best(state)),
                };
            }
        }
        if nearest.as_ref().is_none_or(|(least, _)| miss.abs() < least.abs()) {
            nearest = Some((miss, state.clone()));
        }
        if miss > 0.0 {
            low = low.max(overlap)
        } else {
            high = high.min(overlap)
        }
        // d log P/d log overlap, at least 1 since P is convex and starts at 0.
        let exponent = (state.stiffness * overlap / state.force).max(1.0);
        let next = overlap * (miss / exponent).clamp(-40.0, 40.0).exp();
        let inside = next > low && next < high;
        overlap = if inside || high.is_infinite() || low == 0.0 { next } else { (low * high).sqrt() };
        if quick && miss.abs() < QUICK {
            // From here on the two resolutions disagree about the bracket.
            (quick, low, high) = (false, 0.0, f64::INFINITY);
            overlap = engine.nearer(lowest + overlap, force).map_or(overlap, |depth| depth - lowest);
        }
    }
    let reason = format!(
        "no depth found for the force {force:e} in {MOST_STEPS} steps; tried down to overlap {low:e}, up to {high:e}"
    );
    Err(Unsolved::new(Verdict::NoEquilibrium, reason))
}

/// Share of a state's errors of stiffness and area that a step of fitted cells may add to them, and what it may leave of the force: fields,
/// which are those of the depth beside it, take steps to 1e-7, and no number is to change where they are asked for.
const OF_ERRORS: f64 = 0.25;
const LEFT: f64 = 1e-6;

/// Whether one linear step by the stiffness of fitted cells leaves the force within the tolerance and little of all else: states nearer to
/// the load cost as much as this one.
fn is_linear(state: &Solution, share: f64, tolerance: f64) -> bool {
    let little = |error: Option<f64>, more: f64| error.is_some_and(|error| more <= OF_ERRORS * error);
    let left = left_by_a_step(state, share);
    let no_field = state.pressure.field.is_none() && state.pressure.gap.is_none();
    state.origin == Origin::EdgeFitted
        && state.bracket.is_none()
        && no_field
        && left <= LEFT
        && state.force_error.is_some_and(|error| error + left <= tolerance)
        && little(state.stiffness_error, share)
        && little(state.area_error, 2.0 * share)
}

/// What a linear step leaves of a force that it changes by this share: of its square (n - 1)/(2 n) where P ~ s^n, and what the stiffness is
/// off by.
fn left_by_a_step(state: &Solution, share: f64) -> f64 {
    share * (share + state.stiffness_error.unwrap_or(0.0))
}

/// ln of the load over the force of a state.
fn miss_of(state: &Solution, force: f64) -> f64 {
    (force / state.force).ln()
}

/// A state that a linear step led to from one which missed the load by this: the step leaves at most as much.
fn off_by(miss: f64, mut state: Solution) -> Solution {
    state.force_error = state.force_error.map(|error| error + miss.abs()).filter(|error| error.is_finite());
    state
}

/// What is left of the force after a close state, by the stiffness.
fn last_step(mut state: Solution, force: f64) -> Solution {
    let more = force - state.force;
    state.depth += more / state.stiffness;
    // Stiffness, area and the largest pressure stay those of the depth before.
    let share = (more / state.force).abs();
    let add = |error: &mut Option<f64>, more: f64| *error = error.map(|error| error + more);
    let left = left_by_a_step(&state, share);
    add(&mut state.force_error, left);
    add(&mut state.energy_error, left);
    add(&mut state.stiffness_error, share);
    add(&mut state.area_error, 2.0 * share);
    add(&mut state.pressure.max_error, share);
    // Bounds are those of the depth before the step.
    state.bracket = state.bracket.filter(|_| more == 0.0);
    if let (Some(energy), true) = (state.energy.as_mut(), more != 0.0) {
        *energy += state.force * (more / state.stiffness);
    }
    if let Some(moment) = state.moment.as_mut() {
        *moment = moment.map(|m| m * (force / state.force));
    }
    if let Some(mean) = state.pressure.mean.as_mut() {
        *mean *= force / state.force;
    }
    state.patch.pieces.iter_mut().for_each(|piece| piece.force *= force / state.force);
    state.force = force;
    state
}

/// A state under the load itself: what is left of it after a close state goes into one linear step of depth and tilts, unless a
/// field is to be written, which is that of the depth beside it.
fn balanced(mut state: Solution, change: Option<Vector3<f64>>, force: f64, moment: [f64; 2]) -> Solution {
    let no_field = state.pressure.field.is_none() && state.pressure.gap.is_none();
    if let (Some(change), Some([mx, my])) = (change.filter(|_| no_field), state.moment) {
        if let Some(energy) = state.energy.as_mut() {
            *energy += change.dot(&Vector3::new(state.force, -my, mx));
        }
        state.depth += change[0];
        state.tilt = [state.tilt[0] + change[1], state.tilt[1] + change[2]];
    }
    if let Some(mean) = state.pressure.mean.as_mut() {
        *mean *= force / state.force;
    }
    state.patch.pieces.iter_mut().for_each(|piece| piece.force *= force / state.force);
    (state.force, state.moment, state.moment_bracket) = (force, Some(moment), None);
    state
}

/// What the load of a formula may be off by where nothing cancels: rounding in the force of a deep state is what is left.
pub(super) const CLOSED: f64 = 1e-11;

/// The state of a punch free to tilt under a force and moments (Mx, My) about the origin. `start` is the state under the
/// force alone, `size` a length of the contact; `guess`: a depth and a tilt that may be closer.
pub(crate) fn under_moment(
    engine: &mut dyn Respond,
    force: f64,
    moment_wanted: [f64; 2],
    start: Solution,
    guess: Option<(f64, [f64; 2])>,
    size: f64,
    close: impl Fn(&Solution) -> f64,
) -> Result<Solution, Unsolved> {
    // About the point t in which the line of action meets the surface, which may be many contacts away from the origin:
    // d' = d + a t, forces and moments (P, int p (x - tx), int p (y - ty)) = B (P, int p x, int p y).
    let through = [-moment_wanted[1] / force, moment_wanted[0] / force];
    let moved = Matrix3::new(1.0, 0.0, 0.0, -through[0], 1.0, 0.0, -through[1], 0.0, 1.0);
    let at_line = |s: &Solution| s.depth + s.tilt[0] * through[0] + s.tilt[1] * through[1];
    let nowhere = |steps: usize, state: &Solution| {
        let reason = format!(
            "no state balances the force {force:e} through ({:e}, {:e}) after {steps} steps, tilt ({:e}, {:e}): \
             the line of action passes outside of what can touch",
            through[0], through[1], state.tilt[0], state.tilt[1]
        );
        Unsolved::new(Verdict::NoEquilibrium, reason)
    };
    // The load that is missing, and its units.
    let unit = Vector3::new(force, force * size, force * size);
    let missing = |s: &Solution, [mx, my]: [f64; 2]| {
        Vector3::new(force - s.force, my + through[0] * s.force, -mx + through[1] * s.force)
    };
    let (mut state, mut short) = usable(engine.respond(start.depth, start.tilt, false))?;
    let potential = |s: &Solution| s.energy.unwrap_or(f64::NAN) - force * at_line(s);
    if let Some((depth, tilt)) = guess
        && let Ok((guessed, lacks)) = usable(engine.respond(depth, tilt, false))
        && guessed.force > 0.0
        && potential(&guessed) < potential(&state)
    {
        (state, short) = (guessed, lacks);
    }
    for step in 0..MOST_STEPS {
        let (Some(moment), Some(stiffness)) = (state.moment, state.stiffness_matrix) else {
            return Err(Unsolved::new(Verdict::NotApplicable, "the method gives no moments of the pressure here"));
        };
        let missing = missing(&state, moment);
        let error = missing.component_div(&unit).amax();
        // Grids that are laid anew at every step leave a noise that no step gets below.
        let enough = match step {
            0..PATIENCE => 1.0,
            PATIENCE..LAST_PATIENCE => 30.0,
            _ => 60.0,
        };
        let matrix = moved * Matrix3::from_fn(|i, j| stiffness[i][j]) * moved.transpose();
        // In units of the contact: the three unknowns are of one size.
        let scale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0 / size, 1.0 / size));
        let scaled = scale * matrix * scale;
        let ridge = 1e-9 * scaled[(0, 0)].max(f64::MIN_POSITIVE);
        let factor = (scaled + Matrix3::identity() * ridge).cholesky();
        let change = factor.map(|factor| moved.transpose() * scale * factor.solve(&(scale * missing)));
        if error <= enough * close(&state) {
            let state = balanced(state, change, force, moment_wanted);
            let formula = state.method == Method::ClosedForm && error > CLOSED;
            let state = if enough > 1.0 || formula { off_by(error, state) } else { state };
            return match short {
                None => Ok(state),
                Some(short) => Err(short.with_best(state)),
            };
        }
        let Some(change) = change else { return Err(nowhere(step, &state)) };
        // Convexity: the potential falls along the step; halve it until it does, within what the grid can tell.
        let before = potential(&state);
        // Cells that are fitted anew at every tilt tell it no nearer than they state.
        let told = state.energy_error.filter(|_| state.origin == Origin::EdgeFitted).unwrap_or(0.0);
        let allowed = told.max(1e-7) * state.energy.unwrap_or(0.0).abs();
        let mut length = 1.0;
        let (next, lacks) = loop {
            let depth = state.depth + length * change[0];
            let tilt = [state.tilt[0] + length * change[1], state.tilt[1] + length * change[2]];
            match usable(engine.respond(depth, tilt, false)) {
                Ok((trial, lacks)) if trial.force > 0.0 && potential(&trial) <= before + allowed => {
                    break (trial, lacks);
                }
                Ok((trial, lacks)) if trial.force > 0.0 && length < 0.02 => break (trial, lacks),
                Err(e) if e.verdict == Verdict::TimeLimit => {
                    let best = off_by(error, balanced(state, None, force, moment_wanted));
                    return Err(e.with_best(best));
                }
                // What the method cannot solve says nothing about the load.
                Err(e) if length < 1e-4 && !matches!(e.verdict, Verdict::Unbounded | Verdict::NoEquilibrium) => {
                    let reason = format!("at depth {depth:e}, tilt ({:e}, {:e}): {}", tilt[0], tilt[1], e.reason);
                    return Err(Unsolved { reason, ..e });
                }
                _ if length < 1e-4 => return Err(nowhere(step, &state)),
                _ => length *= 0.5,
            }
        };
        // The residual may rise for a while; without end it means that there is nothing to converge to.
        let steep = next.tilt[0].hypot(next.tilt[1]) * size > 1e4 * next.depth.abs().max(start.depth.abs());
        if steep || !next.depth.is_finite() {
            return Err(nowhere(step, &next));
        }
        (state, short) = (next, lacks);
    }
    let missing = state.moment.map_or(f64::INFINITY, |m| missing(&state, m).component_div(&unit).amax());
    let reason = format!("force and moments are balanced to {missing:.1e} of the force after {MOST_STEPS} steps");
    Err(Unsolved::new(Verdict::IterationLimit, reason)
        .with_best(off_by(missing, balanced(state, None, force, moment_wanted))))
}
