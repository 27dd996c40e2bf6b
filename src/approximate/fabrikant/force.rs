//! P(A) of any boundary, equation (12).

use super::approximation::{Error, Settings};
use super::problem::{Problem, first_rule_level};
use super::radial::RadialPosition;
use super::ray_fan::RayFan;
use super::sectors::{SIXTH, Sectors};
use crate::error::InputError;
use crate::gap::{AnyGap, Gap};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// P(A) of a given boundary, and what goes with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Force {
    /// P(A), units of force. Negative when the region reaches far beyond the overlap.
    pub force: f64,
    /// dP/dd at fixed A, 4 E* A/L.
    pub stiffness: f64,
    /// Area of the region.
    pub area: f64,
    /// Centroid of the region. Equation (10) wants it at the centre.
    pub centroid: [f64; 2],
    /// Estimated relative error by quadrature: over the angle, and along the rays.
    pub quadrature_error: [f64; 2],
    /// Rays used.
    pub rays: usize,
}

/// Equation (12) for the region r < a(theta) about `centre`; `corners` are the angles (radians) where a(theta) is not
/// smooth. Two elastic bodies enter by their common effective modulus and the sum of their gaps.
///
/// ```
/// use contact_patch::{EffectiveModulus, fabrikant, gap::Cone};
/// let (cone, modulus) = (Cone::with_slope(1.0)?, EffectiveModulus::from_e_star(1.0)?);
/// let a = std::f64::consts::FRAC_2_PI; // Love's radius for depth 1
/// let p = fabrikant::force(&cone, modulus, 1.0, [0.0; 2], &|_| a, &[], &fabrikant::Settings::default())?;
/// assert!((p.force - std::f64::consts::FRAC_2_PI).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `NotStarShaped` where a(theta) is not a positive number; an input error for a region outside the material.
pub fn force(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    centre: [f64; 2],
    a: &dyn Fn(f64) -> f64,
    corners: &[f64],
    settings: &Settings,
) -> Result<Force, Error> {
    let gap = &gap.into();
    let settings = settings.checked()?;
    let problem = Problem::new(gap, modulus, depth)?;
    let (overlap, length) = (&problem.overlap, problem.overlap.units.length);
    let centre = overlap.units.inward(centre);
    let mut fan = RayFan::about(overlap, centre, 1.0, first_rule_level(settings.tolerance), 1);
    let mut directions = corners.to_vec();
    overlap.gap.kink_directions(centre, &mut directions);
    fan.sectors = Sectors::between(&directions, SIXTH);
    fan.lay(&[[0.0, 1.0]]);
    for _ in 0..60 {
        for k in 0..fan.rays.len() {
            let mut ray = fan.rays[k];
            ray.a = a(ray.node.angle) / length;
            if !(ray.a > 0.0 && ray.a.is_finite()) {
                let degrees = ray.node.angle.to_degrees();
                let reason = format!("a(theta) = {} at {degrees:.4} degrees", ray.a * length);
                return Err(Unsolved::new(Verdict::NotStarShaped, reason).into());
            }
            ray.position = RadialPosition::at(fan.line(&ray).kinks, ray.a);
            ray.along.g = fan.line(&ray).g(overlap, fan.f0, &ray.position, fan.rule());
            fan.rays[k] = ray;
        }
        let quotient = fan.quotient();
        if !quotient.is_finite() {
            return Err(InputError::new("boundary", "a region beyond the punch", "a region that has material").into());
        }
        let quadrature_error = fan.errors(quotient);
        let done = quadrature_error[0] + quadrature_error[1] <= settings.tolerance;
        if done || !fan.refine(quadrature_error, settings.tolerance, quotient, settings.most_rays) {
            let (off, area) = fan.centroid_and_area();
            return Ok(Force {
                force: problem.force_unit() * quotient,
                stiffness: 4.0 * modulus.e_star() * length * area / fan.sum(|r| r.a),
                area: area * length * length,
                centroid: overlap.units.outward([centre[0] + off[0], centre[1] + off[1]]),
                quadrature_error,
                rays: fan.rays.len(),
            });
        }
    }
    Err(Unsolved::new(Verdict::ToleranceNotReached, "the quadrature of equation (12) did not settle").into())
}
