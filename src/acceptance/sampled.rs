//! What a measured gap leaves open, on top of the error of its contact.
//!
//! On a grid it is found from cell to cell ([`crate::grid_method`]). Without one: if the gap is nowhere farther than e from that of the
//! bodies, over all that can touch, then their force lies between those at the depths d - e and d + e: pressures of the one are admissible
//! for the other ([`crate::bracket`]). P is convex, so that P - P' e is below; above, P' grows no faster than that of a degree-1 gap,
//! P' (1 + e/(d - d0)) e; U grows by the mean of the forces at both depths, times e, at most. That e is an estimate from the samples
//! ([`crate::gap::Gap::sampling_error`]), and makes the evidence one.

use std::f64::consts::PI;

use super::stated::err_with_overlap;
use crate::bracket::DepthBracket;
use crate::gap::Gap;
use crate::overlap::Overlap;
use crate::problem::{Contact, Load, Settings};
use crate::solution::{Piece, Samples, Solution, Unsolved, Verdict, rounded_up};

/// The answer with the error of the measured gap in its error and its bracket.
///
/// # Errors
/// Those of the answer; `ToleranceNotReached` with the state where the samples leave more open than the tolerance.
pub(crate) fn with_samples(
    contact: &Contact,
    load: Load,
    settings: &Settings,
    answer: Result<Solution, Unsolved>,
) -> Result<Solution, Unsolved> {
    match answer {
        Ok(mut state) => {
            let own = state.force_error;
            let Some(off) = widen(contact, load, &mut state) else { return Ok(state) };
            let total = state.force_error.unwrap_or(f64::INFINITY);
            if total <= settings.tolerance || own.is_none_or(|own| own > settings.tolerance.max(off)) {
                return Ok(state);
            }
            let reason = format!(
                "the samples of the gap leave {off:.1e} of the force open, the solve itself {:.1e}; the tolerance is {:.1e}",
                own.unwrap_or_default(),
                settings.tolerance
            );
            let hint = format!(
                "a tolerance of {} or more, a finer measurement, \"smooth\" where it is noise, or \"interpolation\": \"linear\" \
                 where the facets are the surface",
                rounded_up(total)
            );
            Err(Unsolved::new(Verdict::ToleranceNotReached, reason).with_best(state).with_hint(hint))
        }
        Err(mut unsolved) => {
            unsolved.best.iter_mut().for_each(|state| _ = widen(contact, load, state));
            Err(unsolved)
        }
    }
}

/// The share of the force that the samples of a measured gap leave open; `None` where it is not measured.
pub(crate) fn share(contact: &Contact, state: &Solution) -> Option<f64> {
    open(contact, state).map(|(open, _)| open.force / state.force).filter(|share| share.is_finite())
}

/// That, and the depth of the state below the lowest gap.
fn open(contact: &Contact, state: &Solution) -> Option<(Samples, f64)> {
    if !(state.force > 0.0) {
        return None;
    }
    let gap = contact.tilted_gap(state.tilt);
    if !gap.is_measured() {
        return None;
    }
    let overlap = state.depth - gap.known().floor.max(f64::MIN);
    if let Some(samples) = state.samples {
        return Some((samples, overlap));
    }
    let reach = Overlap::of(&gap, state.depth).ok().flatten()?.reach;
    let rect = state.grid.and_then(|grid| grid.extent().intersection(&reach)).unwrap_or(reach);
    let off = gap.sampling_error(&rect);
    if !(off > 0.0) {
        return None;
    }
    let force = state.stiffness * off * (1.0 + (off / overlap).clamp(0.0, 1.0));
    Some((Samples { off, force, work: (state.force + force) * off }, overlap))
}

/// Adds what the samples leave open; its share of the force, `None` where the gap is not measured.
fn widen(contact: &Contact, load: Load, state: &mut Solution) -> Option<f64> {
    let (Samples { off, force: more, work }, overlap) = open(contact, state)?;
    let gap = contact.tilted_gap(state.tilt);
    let share = more / state.force;
    // An error that is no number any more is none that could be stated.
    state.map_error = Some(share).filter(|share| share.is_finite());
    state.force_error = state.force_error.map(|error| error + share).filter(|error| error.is_finite());
    state.bracket = state.bracket.take().map(|bracket| bracket.widened(more));
    if let (Load::Force(force), Some(bracket), Some(_)) = (load, &state.bracket, &state.depth_bracket) {
        state.depth_bracket = Some(DepthBracket::under(&gap, state.depth, force, bracket));
    }
    // Under a force they follow from the error of the depth.
    if matches!(load, Load::Depth(_) | Load::Tilted { .. }) {
        let work = state.energy.map(|energy| work / energy);
        err_with_overlap(state, Some(share), work);
    }
    state.pressure.max_error = state.pressure.max_error.and_then(|own| Some(own + ripple(contact, state, off)?));
    if state.force_error.is_some_and(|error| share < TOLD * error) {
        return Some(share);
    }
    state.remarks.push(format!(
        "{share:.1e} of the stated error is that of the measured gap: between its samples it may be off by {off:.1e}, as coarser \
         samples of it show"
    ));
    if state.patch.regions > 1 && off > BROKEN * overlap {
        state.remarks.push(format!(
            "the patch is in {} pieces, and the gap is not known to better than {off:.1e} between its samples: where that is noise, \
             \"smooth\" takes it out",
            state.patch.regions
        ));
    }
    Some(share)
}

/// What the largest pressure may be off by, relative: a ripple of the gap of this amplitude over a wavelength of the shorter side of the
/// patch, E* pi e/w (Johnson 1985, equation (13.9)). An estimate.
fn ripple(contact: &Contact, state: &Solution, off: f64) -> Option<f64> {
    let max = state.pressure.max?;
    let peak = |a: &&Piece, b: &&Piece| a.max_pressure.unwrap_or(0.0).total_cmp(&b.max_pressure.unwrap_or(0.0));
    let [low, high] = state.patch.pieces.iter().max_by(peak)?.extent;
    let width = (high[0] - low[0]).min(high[1] - low[1]);
    Some(contact.modulus().e_star() * PI * off / width / max).filter(|error| error.is_finite())
}

/// A smaller share of the stated error is not worth a remark.
const TOLD: f64 = 0.01;

/// Noise of this share of the overlap can break a patch into pieces.
const BROKEN: f64 = 0.01;
