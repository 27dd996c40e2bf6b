//! The centre of the rays, which the flat-punch pressure wants at the centroid of the region.

use nalgebra::Vector2;

use super::ray_fan::RayFan;
use super::sweeps::{Found, LOW};
use crate::solution::{Unsolved, Verdict};

/// Moves of the centre on one layout of rays: where they do not suffice, what is left is the error of the layout.
const MOST_MOVES: usize = 24;
/// Moves in a row at which the largest G_a is too low on some ray, before it is taken to be so wherever the centre is.
const MOST_LOW: usize = 12;

impl RayFan<'_> {
    /// Moves the centre to the centroid of the converged region until the two agree (Broyden's method; the step that the
    /// plain iteration takes is right to a fifth for a paraboloid, whose region moves back by 3 pi/8 of the shift).
    /// Returns what was found, the number of moves, and how far the two are apart relative to the region's size.
    pub(crate) fn centre(
        &mut self,
        allowed: f64,
        mut settle: impl FnMut(&mut Self, f64) -> Result<Found, Unsolved>,
    ) -> Result<(Found, usize, f64), Unsolved> {
        let mut inverse = self.recentring;
        let mut last: Option<(Vector2<f64>, Vector2<f64>)> = None;
        // What a loose boundary leaves in the centroid would be noise to the moves; where none is needed it does no harm.
        let mut residual = if self.moved { 0.01 * allowed } else { f64::INFINITY };
        let mut low = 0;
        for moves in 0..MOST_MOVES {
            let found = settle(self, residual)?;
            low = if found.tightest.1 < -LOW { low + 1 } else { 0 };
            let (off, area) = self.centroid_and_area();
            let off = Vector2::from(off);
            let size = area.sqrt();
            let diverging = low == MOST_LOW || (low > 0 && self.out_of_budget().is_some());
            let at_last = moves + 1 == MOST_MOVES;
            if off.norm() <= allowed * size || diverging || at_last {
                return Ok((found, moves, off.norm() / size));
            }
            if residual > 0.01 * allowed {
                residual = 0.01 * allowed;
                continue;
            }
            if let Some((step, previous)) = last {
                // Good Broyden on off(c) = 0, where the update is well conditioned.
                let change = previous - off;
                let image = inverse * change;
                let scale = step.dot(&image);
                if scale.abs() > 0.05 * step.norm_squared() {
                    inverse += (step - image) * (step.transpose() * inverse) / scale;
                    self.recentring = inverse;
                }
            }
            let mut step = inverse * off;
            if step.norm() > 0.5 * size {
                step *= 0.5 * size / step.norm();
            }
            last = Some((step, off));
            self.moved = true;
            let centre = Vector2::from(self.centre) + step;
            self.move_to(centre.into());
            if !(self.f0 > 0.0) {
                return Err(Unsolved::new(
                    Verdict::NotStarShaped,
                    "the centroid of the region lies where the bodies do not overlap: the contact is not one star-shaped patch",
                ));
            }
        }
        Err(Unsolved::new(Verdict::IterationLimit, "the centre did not reach the centroid"))
    }
}
