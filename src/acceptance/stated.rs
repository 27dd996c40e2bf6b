//! What a state says of the errors of its numbers, and what its reader should know.
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

use super::validity::mixed_units;
use crate::bracket::DepthBracket;
use crate::gap::{AnyGap, DataEdge, Gap, Law, Material, lattice};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
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
            let bounds = state.depth_bracket.as_ref().and_then(|b| Some([b.lower(), b.upper()?]));
            bounds.map(|[lower, upper]| (upper - state.depth).max(state.depth - lower) / overlap)
        }
        _ => None,
    };
    let off = proved.or_else(|| of_overlap(state.force_error?, law.as_ref()));
    state.force_error = Some(0.0);
    let known = |error: f64| Some(error).filter(|error| error.is_finite());
    state.depth_error = off.and_then(|off| known(off * (overlap / state.depth).abs()));
    let with = |own: Option<f64>, times: f64| Some(own? + times * off?).and_then(known);
    match law {
        Some(law) => {
            state.stiffness_error = off.map(|off| off / (1.0 - off)).filter(|error| *error >= 0.0);
            state.energy_error = off;
            state.area_error = with(state.area_error, 2.0 * law.degree.inverse() * (1.0 + off.unwrap_or(0.0)));
        }
        // Of the order of what they change by with the overlap: an estimate.
        None => {
            let work = state.energy.map_or(f64::NAN, |energy| state.force * overlap / energy);
            state.stiffness_error = with(state.stiffness_error, 1.0);
            state.energy_error = with(state.energy_error, work);
            state.area_error = with(state.area_error, 2.0);
        }
    }
}

/// A punch free to tilt: the compliance takes the error of the force, wherever in the patch it acts, to the depth. An estimate.
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
            Some((compliance * load)[0].abs())
        };
        let places = [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        places.into_iter().try_fold(0.0_f64, |most, place| Some(most.max(at(place)?)))
    };
    let deeper = deeper().filter(|deeper| deeper.is_finite());
    let overlap = state.depth - least(&contact.tilted_gap(state.tilt)).1;
    state.depth_error = deeper.map(|deeper| (deeper / state.depth).abs()).filter(|error| error.is_finite());
    let with = |own: Option<f64>, times: f64| Some(own? + times * deeper?).filter(|error| error.is_finite());
    state.stiffness_error = with(state.stiffness_error, 1.0 / overlap);
    state.area_error = with(state.area_error, 2.0 / overlap);
    state.energy_error = with(state.energy_error, state.energy.map_or(f64::NAN, |energy| state.force / energy));
}

/// What the reader of a state should know of where it may not hold.
pub(crate) fn remarks(contact: &Contact, state: &mut Solution) {
    if let Some(touched) = state.touches_edge {
        let [edge, question] = match touched.edge {
            DataEdge::Map if is_hollow(contact.gap(), state.patch.extent()) => [
                "the border of the measured data",
                "its middle is the farthest from the other body; with the other value of \"surface\" it would be the nearest",
            ],
            DataEdge::Map => ["the border of the measured data", "does the measurement go far enough?"],
            DataEdge::Hole => ["a hole of the measured data", "there may be a surface that was not measured"],
            DataEdge::Region => ["the border of the region", "the material is taken to end there"],
        };
        state.remarks.push(format!("the contact reaches {edge}: {question}"));
    }
    if let Some(validity) = &state.validity {
        state.remarks.extend(validity.remarks());
    }
    state.remarks.extend(mixed_units(contact, state.patch.area, state.patch.centroid));
}

/// Samples a side, and the share of the range by which the middle of a hollow lies above its border.
const LOOKS: usize = 24;
const DEEP: f64 = 0.45;

/// Whether a measured part of the gap looks like one whose sign was taken wrongly: higher in the middle than along its border.
fn is_hollow(gap: &AnyGap, patch: Option<[[f64; 2]; 2]>) -> bool {
    if let Some(parts) = gap.addends().or_else(|| gap.alternatives()) {
        return parts.iter().any(|part| is_hollow(part, patch));
    }
    // A measured line has no end along the body: a hollow touches at both ends of it.
    let touched = patch.map(|[min, max]| Rect { min, max });
    let Some(material) = (match gap.known().material {
        Material::Within(rect) => Some(rect),
        _ => touched,
    }) else {
        return false;
    };
    if !gap.is_measured() {
        return false;
    }
    let grid = Grid::over(&material, [LOOKS; 2]);
    let heights = lattice::values(gap, &grid);
    let off = |k: usize| [k % LOOKS, k / LOOKS].map(|i| i.min(LOOKS - 1 - i)).into_iter().min().unwrap_or(0);
    let mean = |range: std::ops::Range<usize>| {
        let own: Vec<f64> = (0..heights.len())
            .filter(|&k| range.contains(&off(k)) && heights[k].is_finite())
            .map(|k| heights[k])
            .collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    let finite = || heights.iter().copied().filter(|h| h.is_finite());
    let range = finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min);
    mean(LOOKS / 3..LOOKS) - mean(0..2) > DEEP * range
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
