//! What a measured gap leaves open, beside the error of its contact: that of the surface through its samples.
//!
//! If the gap is nowhere farther than e from that of the bodies, over all that can touch, then their force lies between those at the depths
//! d - e and d + e: pressures of the one are admissible for the other ([`crate::bracket`]). P is convex, so that P - P' e is below; above,
//! P' grows no faster than that of a degree-1 gap, P' (1 + e/(d - d0)) e. That e is an estimate from the samples
//! ([`crate::gap::Gap::sampling_error`]); no solve makes it smaller, so that it decides no verdict.

use crate::contact::Contact;
use crate::gap::Gap;
use crate::overlap::Overlap;
use crate::solution::Solution;

/// States what the samples leave open of the force ([`Solution::map_error`]), in a remark where it is more than the contact's own error.
pub(crate) fn of_map(contact: &Contact, state: &mut Solution) {
    if !(state.force > 0.0) {
        return;
    }
    let gap = contact.tilted_gap(state.tilt);
    let Some(reach) = Overlap::of(&gap, state.depth).ok().flatten().map(|overlap| overlap.reach) else { return };
    let rect = state.grid.and_then(|grid| grid.extent().intersection(&reach)).unwrap_or(reach);
    let off = gap.sampling_error(&rect);
    if !(off > 0.0) {
        return;
    }
    let overlap = state.depth - gap.known().floor.max(f64::MIN);
    let share = state.stiffness * off * (1.0 + (off / overlap).clamp(0.0, 1.0)) / state.force;
    state.map_error = Some(share).filter(|share| share.is_finite());
    if share > state.error().unwrap_or(0.0) {
        state.remarks.push(format!(
            "the samples of the gap leave {share:.1e} of the force open, beside the stated error: between them it may be off by {off:.1e}, as \
             coarser samples show; a finer measurement, \"smooth\" where it is noise, or \"interpolation\": \"linear\" where the facets are \
             the surface"
        ));
    }
    if state.patch.regions > 1 && off > BROKEN * overlap {
        state.remarks.push(format!(
            "the patch is in {} pieces, and the gap is not known to better than {off:.1e} between its samples: where that is noise, \
             \"smooth\" takes it out",
            state.patch.regions
        ));
    }
}

/// Noise of this share of the overlap can break a patch into pieces.
const BROKEN: f64 = 0.01;
