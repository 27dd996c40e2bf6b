//! Parts of the contact beyond the one about the centre.

use std::f64::consts::TAU;

use super::ray::RayLine;
use super::ray_fan::RayFan;

impl RayFan<'_> {
    /// Whether the overlap comes back, along a ray, after having been lost: a second tip, beyond the boundary of the first.
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
