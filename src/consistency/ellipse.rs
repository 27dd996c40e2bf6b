//! The force of the flat punch on the ellipse of the patch: a bound from below (Barber 1974).

use std::f64::consts::TAU;

use super::{Claim, ROOM, broken};
use crate::approximate::fabrikant::agm;
use crate::discrete::Discrete;
use crate::gap::Gap;
use crate::numeric::quadrature::GaussLegendre;
use crate::overlap::Scaled;
use crate::solution::Unsolved;

/// # Errors
/// `Inconsistent`, when the flat punch on the ellipse of the patch alone carries more.
pub(crate) fn above_ellipse(
    scaled: &Scaled,
    problem: &Discrete,
    pressure: &[f64],
    Claim { force, error }: Claim,
) -> Result<(), Unsolved> {
    let ellipse = Ellipse::of(problem, pressure);
    let Some(least) = ellipse.and_then(|ellipse| ellipse.force(scaled, problem)) else { return Ok(()) };
    let least = least * (1.0 - ROOM);
    if force + error >= least {
        return Ok(());
    }
    broken(format!(
        "the force {force:e}, stated to {error:.1e}, is below {least:e}, that of a flat punch on an ellipse of the size of the patch"
    ))
}

/// The ellipse with the area and the second moments of a patch.
struct Ellipse {
    centre: [f64; 2],
    semi_axes: [f64; 2],
    turn: f64,
}

impl Ellipse {
    fn of(problem: &Discrete, pressure: &[f64]) -> Option<Self> {
        let grid = &problem.grid;
        let pressed = || (0..grid.len()).filter(|&k| pressure[k] > 0.0).map(|k| grid.centre_of(k));
        let count = pressed().count();
        if count < 16 {
            return None;
        }
        let mean = |of: &dyn Fn([f64; 2]) -> f64| pressed().map(of).sum::<f64>() / count as f64;
        let centre = [mean(&|p| p[0]), mean(&|p| p[1])];
        let about = |i: usize, j: usize| mean(&|p| (p[i] - centre[i]) * (p[j] - centre[j]));
        let (xx, xy, yy) = (about(0, 0), about(0, 1), about(1, 1));
        let (half, radius) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        // A uniform ellipse has second moments of a quarter of its squared semi-axes.
        let semi_axes = [2.0 * (half + radius).sqrt(), 2.0 * (half - radius).max(0.0).sqrt()];
        let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
        (semi_axes[1] > 0.0).then_some(Self { centre, semi_axes, turn })
    }

    /// P(A) = S * mean of the overlap under the pressure of the flat punch A, S its stiffness (Barber & Billings 1990, eq. 5, exact on
    /// an ellipse), less what two rules differ by. `None` where there is no material on part of it.
    fn force(&self, scaled: &Scaled, problem: &Discrete) -> Option<f64> {
        let (sin, cos) = self.turn.sin_cos();
        let [a, b] = self.semi_axes;
        let grid = &problem.grid;
        let own = |[x, y]: [f64; 2]| {
            let (x, y) = (x - self.centre[0], y - self.centre[1]);
            [(cos * x + sin * y) / a, (cos * y - sin * x) / b]
        };
        // Cells that the ellipse meets.
        let near = 1.0 + grid.spacing[0].max(grid.spacing[1]) / b;
        let meets = |k: &usize| {
            let [x, y] = own(grid.centre_of(*k));
            x.hypot(y) <= near
        };
        if (0..grid.len()).filter(meets).any(|k| !problem.overlap[k].is_finite()) {
            return None;
        }
        let mean = |radii: usize, angles: usize| {
            // With rho = sqrt(1 - t^2) the weight rho/sqrt(1 - rho^2) d rho is dt.
            GaussLegendre::new(radii)
                .nodes()
                .iter()
                .map(|(t, weight)| {
                    let rho = (1.0 - (0.5 + 0.5 * t).powi(2)).sqrt();
                    let around = |k: usize| {
                        let (s, c) = (TAU * (k as f64 + 0.5) / angles as f64).sin_cos();
                        let (x, y) = (a * rho * c, b * rho * s);
                        let point = [self.centre[0] + cos * x - sin * y, self.centre[1] + sin * x + cos * y];
                        scaled.depth - Gap::gap(&scaled.gap, point[0], point[1])
                    };
                    0.5 * weight * (0..angles).map(around).sum::<f64>() / angles as f64
                })
                .sum::<f64>()
        };
        // dP/dd of the flat punch, E* = 1: pi a/K(e) = 2 agm(a, b).
        let stiffness = 2.0 * agm(a, b);
        let (fine, coarse) = (stiffness * mean(16, 48), stiffness * mean(9, 28));
        let least = fine - 2.0 * (fine - coarse).abs();
        least.is_finite().then_some(least)
    }
}
