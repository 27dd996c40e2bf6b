//! What the reader of a state should know: contacts at the end of the data, signs and units that look mistaken, limits of the theory.

use std::f64::consts::PI;

use super::validity::{mean_radius, radius};
use crate::gap::{AnyGap, DataEdge, Gap, Material, lattice};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;
use crate::problem::Contact;
use crate::solution::Solution;

/// What the reader of a state should know of where it may not hold.
pub(crate) fn remarks(contact: &Contact, state: &mut Solution) {
    if let Some(touched) = state.touches_edge {
        let [edge, question] = match touched.edge {
            DataEdge::Map if is_hollow(contact.gap(), state.patch.extent().map(|[min, max]| Rect { min, max })) => [
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
fn is_hollow(gap: &AnyGap, patch: Option<Rect>) -> bool {
    if let Some(parts) = gap.addends().or_else(|| gap.alternatives()) {
        return parts.iter().any(|part| is_hollow(part, patch));
    }
    let seen = match gap.known().material {
        Material::Within(material) => Some(material),
        // A measured line has no end along the body: a hollow touches at both ends of it.
        _ => patch,
    };
    let Some(seen) = seen.filter(|_| gap.is_measured()) else { return false };
    let heights = lattice::values(gap, &Grid::over(&seen, [LOOKS; 2]));
    let from_border =
        |k: usize| [k % LOOKS, k / LOOKS].map(|i| i.min(LOOKS - 1 - i)).into_iter().fold(LOOKS, usize::min);
    let known = || heights.iter().copied().enumerate().filter(|(_, height)| height.is_finite());
    let mean = |inwards: std::ops::Range<usize>| {
        let part = known().filter(|(k, _)| inwards.contains(&from_border(*k)));
        let (count, sum) = part.fold((0.0, 0.0), |(count, sum), (_, height)| (count + 1.0, sum + height));
        sum / count
    };
    let [low, high] = known().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, h)| [h.min(a), h.max(b)]);
    mean(LOOKS / 3..LOOKS) - mean(0..2) > DEEP * (high - low)
}

/// Radius of curvature, as [`radius`], at a point where the gap tells its second derivatives.
fn radius_at(gap: &AnyGap, [x, y]: [f64; 2], size: f64) -> Option<f64> {
    let rect = Rect::around([x, y], [1e-3 * size; 2]);
    mean_radius(gap.taylor(&rect)?.hessian.map(|h| 0.5 * (h.lo + h.hi)))
}

/// Moduli from which on units can hardly be others than pascals.
const PASCALS: f64 = 1e9;

/// Sizes of contacts, and mean radii of curvature, that are hardly in metres.
const METRES: f64 = 1.0;
const ROUND_METRES: f64 = 100.0;

/// Mean radii of curvature from which on a body is meant to be straight in a direction: a cylinder.
const STRAIGHT: f64 = 1e9;

/// A remark on moduli in pascals beside lengths that are no metres; `middle`: that of the patch.
pub(super) fn mixed_units(contact: &Contact, area: f64, middle: Option<[f64; 2]>) -> Option<String> {
    let (gap, e_star, size) = (contact.gap(), contact.modulus().e_star(), (area / PI).sqrt());
    if e_star < PASCALS {
        return None;
    }
    let round = || {
        radius(gap).or_else(|| radius_at(gap, middle?, size)).filter(|radius| (ROUND_METRES..STRAIGHT).contains(radius))
    };
    let what = if size > METRES {
        "the contact would be metres wide".to_owned()
    } else {
        format!("the radii of curvature would be {:.0} m", round()?)
    };
    Some(format!(
        "mixed units? E* is {e_star:.1e}, as in pascals, and {what}; with lengths in millimetres moduli are in megapascals"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::Paraboloid;
    use crate::{EffectiveModulus, Loading};

    #[test]
    fn radii_of_hundreds_of_metres_are_a_smell() {
        let modulus = EffectiveModulus::from_e_star(1.15e11).unwrap();
        let contact =
            |radii: [f64; 2]| Contact::new(modulus, Paraboloid::new(radii).unwrap(), Loading::depth(1.0)).unwrap();
        assert!(mixed_units(&contact([300.0, 460.0]), 1e-4, None).is_some());
        assert!(mixed_units(&contact([0.3, 0.46]), 1e-4, None).is_none());
        // A crowned roller.
        assert!(mixed_units(&contact([0.01, 2000.0]), 1e-4, None).is_none());
    }
}
