//! The directions of ridges, and rotational symmetry: the turns about the centre that leave the gap as it is. A twelve-faced
//! pyramid takes a twelfth of the rays, and a third of the instructions of its scene.

use std::f64::consts::TAU;

use super::ray::ScaledOverlap;
use crate::gap::Gap;

/// Relative difference of lengths and slopes that is rounding.
const SAME: f64 = 1e-13;

/// The directions in which the gap is not smooth, seen from `centre`.
pub(super) fn ridge_directions(overlap: &ScaledOverlap, centre: [f64; 2], directions: &mut Vec<f64>) {
    overlap.gap.kink_directions(centre, directions);
    let Some(ridges) = overlap.gap.ridges().filter(|_| overlap.has_planes() && centre != [0.0; 2]) else { return };
    // Ridges without end, about where the boundary crosses them: no faster, but the largest radius comes out ten times closer.
    for ridge in &ridges.all {
        for (end, sense) in ridge.ends.iter().zip([-1.0, 1.0]) {
            if end.is_none() {
                let [x, y] = [0, 1].map(|m| ridge.point[m] + sense * ridge.direction[m] - centre[m]);
                directions.push(y.atan2(x));
            }
        }
    }
}

/// How many turns about the origin leave the gap as it is, by what is known of it.
pub(super) fn turns(overlap: &ScaledOverlap) -> usize {
    let known = overlap.gap.known();
    if known.centre != [0.0; 2] {
        return 1;
    }
    if known.axis.is_some_and(|axis| axis.at == [0.0; 2]) {
        return TURNS_OF_ROUND;
    }
    let both_mirrors = if known.mirrors == [true; 2] { 2 } else { 1 };
    turns_of_fan(overlap).unwrap_or(both_mirrors)
}

/// A gap of revolution may be turned by any angle; four periods leave few rays each.
const TURNS_OF_ROUND: usize = 4;

/// The number of faces of a regular pyramid, pointed or blunt: each turn takes every ridge to the next of its kind, and a slope to
/// the next slope.
fn turns_of_fan(overlap: &ScaledOverlap) -> Option<usize> {
    let ridges = overlap.gap.ridges().filter(|_| overlap.has_planes())?;
    let n = ridges.all.iter().filter(|ridge| ridge.ends[1].is_none()).count();
    if n < 3 || !ridges.all.len().is_multiple_of(n) {
        return None;
    }
    let (sin, cos) = (TAU / n as f64).sin_cos();
    let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    let same = |[a, b]: [f64; 2], [x, y]: [f64; 2]| (x - a).hypot(y - b) <= SAME * (x.hypot(y) + a.hypot(b));
    let next = ridges.all.iter().cycle().skip(ridges.all.len() / n);
    let regular = ridges.all.iter().zip(next).all(|(here, there)| {
        same(turned(here.point), there.point)
            && same(turned(here.direction), there.direction)
            && same(turned(here.jump), there.jump)
    });
    // Further out than any corner, off the ridges.
    let far = ridges.corners.iter().map(|c| c[0].hypot(c[1])).fold(1.0, f64::max) * 4.0;
    let [x, y] = ridges.all.iter().find(|ridge| ridge.ends[1].is_none())?.direction;
    let (sin, cos) = (0.5 * TAU / n as f64).sin_cos();
    let place = [far * (cos * x - sin * y), far * (sin * x + cos * y)];
    let slope = |p| overlap.slope(p, 0.0);
    (regular && same(turned(slope(place)), slope(turned(place)))).then_some(n)
}
