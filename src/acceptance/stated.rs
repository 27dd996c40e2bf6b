//! What a state says of the errors of its numbers.
//!
//! Solvers know the error e of the force at a depth. Where the depth was prescribed it is stated as it is. Where the force was, the
//! depth errs, and what depends on it. P(d) is convex and zero up to first touch d0, so that with the overlap s = d - d0
//!
//! ```text
//! any gap          |ds| <= s e/(1 - e)
//! homogeneous, k   ds/s + 1 in [(1 + e)^-q, (1 - e)^-q],  q = k/(k + 1);  S = (1 + 1/k) P/s,  U = P s/(2 + 1/k)
//! ```
//!
//! A prescribed number has the error 0.

use crate::bracket::DepthBracket;
use crate::gap::Law;
use crate::overlap::least;
use crate::problem::{Contact, Load};
use crate::solution::{ForceEvidence, Solution};

/// The errors of a state on its way out of [`crate::solve`].
pub(crate) fn errors(contact: &Contact, load: Load, state: &mut Solution) {
    state.depth_error = Some(0.0);
    match load {
        Load::Depth(_) | Load::Tilted { .. } => {}
        Load::Force(_) if state.force > 0.0 => under_force(contact, state),
        Load::ForceMoment { .. } if state.force > 0.0 => under_moment(contact, state),
        Load::Force(_) | Load::ForceMoment { .. } => {}
    }
}

/// Relative error of the overlap under a force, from that of the force at the overlap.
fn of_overlap(error: f64, law: Option<&Law>) -> Option<f64> {
    let power = law.map_or(1.0, |law| 1.0 / (1.0 + law.degree.inverse()));
    Some((1.0 - error).powf(-power) - 1.0).filter(|off| (0.0..1.0).contains(off))
}

fn under_force(contact: &Contact, state: &mut Solution) {
    let gap = contact.gap();
    let law = gap.known().law;
    let touch = law.map_or_else(|| least(gap).1, |law| law.lowest);
    let (overlap, evidence) = (state.depth - touch, state.evidence());
    if let (Some(bracket), None) = (&state.bracket, &state.depth_bracket) {
        state.depth_bracket = Some(DepthBracket::under(gap, state.depth, state.force, bracket));
    }
    let proved = match evidence {
        // Bounds of the force that cover its error bound the depth, too.
        ForceEvidence::Proved | ForceEvidence::Sampled => {
            let bounds = state.depth_bracket.as_ref().and_then(DepthBracket::ends);
            bounds.map(|[lower, upper]| (upper - state.depth).max(state.depth - lower) / overlap)
        }
        _ => None,
    };
    let off = proved.or_else(|| of_overlap(state.force_error?, law.as_ref()));
    state.force_error = Some(0.0);
    let known = |error: f64| Some(error).filter(|error| error.is_finite());
    state.depth_error = off.and_then(|off| known(off * (overlap / state.depth).abs()));
    match law {
        Some(law) => {
            state.stiffness_error = off.map(|off| off / (1.0 - off)).filter(|error| *error >= 0.0);
            state.energy_error = off;
            let larger = off.map(|off| 2.0 * law.degree.inverse() * (1.0 + off) * off);
            state.area_error = state.area_error.zip(larger).and_then(|(own, larger)| known(own + larger));
        }
        None => {
            let work = off.zip(state.energy).map(|(off, energy)| off * state.force * overlap / energy);
            err_with_overlap(state, off, work);
        }
    }
}

/// A punch free to tilt: the compliance takes the error of the force, wherever in the patch it acts, to the depth, which is that at the
/// origin, and to the overlap where the force acts: an estimate, where its depth has no bounds of its own.
fn under_moment(contact: &Contact, state: &mut Solution) {
    let error = state.force_error;
    state.force_error = Some(0.0);
    let deeper = || {
        let (matrix, [mx, my]) = (state.stiffness_matrix?, state.moment?);
        let [x, y] = [-my / state.force, mx / state.force];
        let size = (state.patch.area / std::f64::consts::PI).sqrt();
        let matrix = nalgebra::Matrix3::from_fn(|i, j| matrix[i][j]);
        // In units of the contact all three unknowns are of one size.
        let scale = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0 / size, 1.0 / size));
        let compliance = scale * (scale * matrix * scale).try_inverse()? * scale;
        let at = |[u, v]: [f64; 2]| {
            let load = nalgebra::Vector3::new(1.0, x + u * size, y + v * size) * (state.force * error?);
            let moved = compliance * load;
            Some([moved[0].abs(), (moved[0] + x * moved[1] + y * moved[2]).abs()])
        };
        let places = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        let most = |most: [f64; 2], place| {
            let own = at(place)?;
            Some([0, 1].map(|m| most[m].max(own[m])))
        };
        places.into_iter().try_fold([0.0_f64; 2], most)
    };
    let [at_origin, deeper] = match deeper().filter(|off| off.iter().all(|off| off.is_finite())) {
        Some(off) => off.map(Some),
        None => [None; 2],
    };
    let overlap = state.depth - least(&contact.tilted_gap(state.tilt)).1;
    let bounds = state.depth_bracket.as_ref().and_then(DepthBracket::ends);
    let proved = bounds.map(|[lower, upper]| (upper - state.depth).max(state.depth - lower));
    state.depth_error = proved.or(at_origin).map(|off| (off / state.depth).abs()).filter(|error| error.is_finite());
    let work = deeper.zip(state.energy).map(|(deeper, energy)| deeper * state.force / energy);
    err_with_overlap(state, deeper.map(|deeper| deeper / overlap), work);
}

/// Adds to the errors of stiffness and area what they change by with this share of the overlap, and to that of the energy this work, over
/// it; nothing is known of them where that is not. Of the order of the change: an estimate.
pub(super) fn err_with_overlap(state: &mut Solution, share: Option<f64>, work: Option<f64>) {
    let with = |own: Option<f64>, more: Option<f64>| Some(own? + more?).filter(|error| error.is_finite());
    state.stiffness_error = with(state.stiffness_error, share);
    state.area_error = with(state.area_error, share.map(|share| 2.0 * share));
    state.energy_error = with(state.energy_error, work);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::Degree;

    #[test]
    fn the_error_of_the_overlap_holds_what_the_force_errs_by() {
        for k in [0.5, 1.0, 2.0, 6.0] {
            let law = Law { degree: Degree::Power(k), lowest: 0.0 };
            for error in [1e-6, 1e-3, 0.1] {
                let off = of_overlap(error, Some(&law)).unwrap();
                // P ~ s^(1 + 1/k), the true one larger or smaller by the error: the overlap for the same force.
                for truth in [1.0 - error, 1.0 + error] {
                    let overlap: f64 = truth.powf(-1.0 / (1.0 + 1.0 / k));
                    assert!((overlap - 1.0).abs() <= off * (1.0 + 1e-9), "{k} {error}");
                }
                // Not known to be homogeneous: no less.
                assert!(of_overlap(error, None).unwrap() >= off);
            }
        }
        assert!(of_overlap(1.0, None).is_none() && of_overlap(0.7, None).is_none());
    }
}
