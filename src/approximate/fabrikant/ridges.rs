//! Ridges as they are seen from the centre of a star.

use super::ray::ScaledOverlap;
use crate::gap::Gap;

/// The directions in which the gap is not smooth, seen from `centre`.
pub(super) fn ridge_directions(overlap: &ScaledOverlap, centre: [f64; 2], directions: &mut Vec<f64>) {
    overlap.gap.kink_directions(centre, directions);
    let Some(ridges) = overlap.gap.ridges().filter(|_| overlap.has_planes() && centre != [0.0; 2]) else { return };
    // Ridges without end, about where the boundary crosses them.
    for ridge in &ridges.all {
        for (end, sense) in ridge.ends.iter().zip([-1.0, 1.0]) {
            if end.is_none() {
                let [x, y] = [0, 1].map(|m| ridge.point[m] + sense * ridge.direction[m] - centre[m]);
                directions.push(y.atan2(x));
            }
        }
    }
}
