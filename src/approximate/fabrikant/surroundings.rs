//! What a star sees around its centre: the ridges, and parts of the contact that it does not hold.

use std::f64::consts::TAU;

use super::ray::{RayLine, ScaledOverlap};
use super::star::Star;
use crate::gap::Gap;

/// The directions in which the gap is not smooth, seen from `centre`.
pub(super) fn look_around(overlap: &ScaledOverlap, centre: [f64; 2], directions: &mut Vec<f64>) {
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

impl Star<'_> {
    /// Whether the overlap comes back, along a ray, after having been lost: a second tip that the star does not hold.
    /// Sampled out to `reach`: 12 points in 16 directions, or 48 in 64 when little is known of the gap.
    pub fn second_part(&self, reach: f64, thorough: bool) -> Option<f64> {
        let (directions, points) = if thorough { (64, 48) } else { (16, 12) };
        (0..directions).map(|k| TAU * f64::from(k) / f64::from(directions)).find(|angle| {
            let (sin, cos) = angle.sin_cos();
            let line = RayLine { centre: self.centre, direction: [cos, sin], kinks: &[], planes: None };
            let mut lost = false;
            (1..=points).any(|k| {
                let f = self.overlap.at(line.at(reach * f64::from(k) / f64::from(points)));
                let back = lost && f > 0.0;
                lost |= f <= 0.0;
                back
            })
        })
    }
}
