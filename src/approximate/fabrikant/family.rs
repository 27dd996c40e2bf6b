//! Boundaries of few parameters: a(theta) = sum q_j phi_j(theta), P(A) maximised over q (section 2.3 with the freedom of
//! the boundary cut down). Newton's method on int (G - D a), D = N/L, exactly as for the stationary boundary; the Hessian
//! int G_aa phi_j phi_k must be negative definite where it ends, or there is no number.

use nalgebra::{DMatrix, DVector};

use super::approximation::{Approximation, Error, Family, Settings};
use super::problem::several_parts;
use super::problem::{Problem, first_rule_level};
use super::ray_fan::{Ray, RayFan};
use super::sweeps::Found;
use crate::error::InputError;
use crate::gap::AnyGap;
use crate::numeric::scalar::{TO_THE_LAST_DIGIT, bisected};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// Newton steps before giving up.
const MOST_STEPS: usize = 60;
/// Highest order of a Fourier series.
const HIGHEST_ORDER: usize = 64;

/// The best boundary of a Fourier series or of the scaled plan-form.
pub(crate) fn best(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    family: Family,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let settings = settings.checked()?;
    if let Family::Fourier(order) = family
        && order > HIGHEST_ORDER
    {
        return Err(InputError::new("fourier", order, format!("an order of at most {HIGHEST_ORDER}")).into());
    }
    let problem = Problem::new(gap, modulus, depth)?.before(settings.deadline);
    let tolerance: f64 = settings.tolerance;
    let mut fan = RayFan::about(&problem.overlap, [0.0; 2], 0.5, first_rule_level(tolerance), 1);
    fan.checks_material = true;
    let mut q: Vec<f64> = Vec::new();
    let mut second = f64::NAN;
    let mut iterations = 0;
    let (found, errors) = loop {
        let (found, moves, _) = fan.centre((0.1 * tolerance).max(1e-13), |fan, at_most| {
            let allowed = (10.0 * tolerance).clamp(1e-12, 1e-3).min(at_most).max(1e-12);
            let (found, largest) = newton(fan, family, &mut q, allowed)?;
            second = largest;
            Ok(found)
        })?;
        iterations += 1 + moves;
        let errors = fan.errors(found.d);
        let done = errors[0] + errors[1] <= tolerance || iterations > 60;
        if done || !fan.refine(errors, tolerance, found.d, settings.most_rays) {
            break (found, errors);
        }
    };
    if let Some(angle) = fan.second_part(problem.reach, problem.searched) {
        return Err(several_parts(angle).into());
    }
    let length = problem.overlap.units.length;
    let (off, area) = fan.centroid_and_area();
    let centroid = problem.overlap.units.outward([fan.centre[0] + off[0], fan.centre[1] + off[1]]);
    let perimeter = fan.sum(|r| r.a);
    let mut outline = fan.outline();
    let mut phi = vec![0.0; q.len()];
    for k in 0..settings.boundary_points {
        let angle = std::f64::consts::TAU * k as f64 / settings.boundary_points as f64;
        let ray = fan.extra_ray(angle, 1.0);
        shapes(&fan, &ray, family, phi.iter_mut());
        outline.push([angle, phi.iter().zip(&q).map(|(p, q)| p * q).sum()]);
    }
    outline.sort_by(|p, q| p[0].total_cmp(&q[0]));
    outline.dedup_by(|b, a| b[0] - a[0] < 1e-12);
    Ok(Approximation {
        family,
        why: String::new(),
        force: problem.force_unit() * found.d,
        stiffness: 4.0 * modulus.e_star() * length * (area / perimeter),
        d: length * problem.overlap.units.height * found.d,
        second_variation: Some(second * problem.overlap.units.height),
        residual: found.residual,
        margin: None,
        boundary: problem.boundary(fan.centre, outline),
        area: area * length * length,
        centroid,
        quadrature_error: errors,
        rays: fan.rays.len(),
        iterations,
        lower_bound: None,
    })
}

/// Number of shapes phi_j.
fn parameters(family: Family) -> usize {
    match family {
        Family::Fourier(order) => 1 + 2 * order,
        Family::PlanForm | Family::Stationary | Family::Circle | Family::Ellipse => 1,
    }
}

/// phi_j at the angle of a ray, into `phi`.
fn shapes<'p>(fan: &RayFan, ray: &Ray, family: Family, phi: impl Iterator<Item = &'p mut f64>) {
    for (j, phi) in phi.enumerate() {
        let wave = j.div_ceil(2) as f64 * ray.node.angle;
        *phi = match family {
            Family::PlanForm => contour(fan, ray),
            _ if j == 0 => 1.0,
            _ if j % 2 == 1 => wave.cos(),
            _ => wave.sin(),
        };
    }
}

/// Distance along the ray at which the overlap ends.
fn contour(fan: &RayFan, ray: &Ray) -> f64 {
    let line = fan.line(ray);
    let inside = |r: f64| fan.overlap.at(line.at(r)) > 0.0;
    let (mut lo, mut hi) = (0.0, 0.5);
    while inside(hi) && hi < 1e15 {
        (lo, hi) = (hi, 2.0 * hi);
    }
    bisected(inside, [lo, hi], TO_THE_LAST_DIGIT)[0]
}

fn left(reason: impl Into<String>) -> Unsolved {
    Unsolved::new(Verdict::NoMaximum, reason)
}

/// int G_aa phi_j phi_k.
fn second_variation(fan: &RayFan, phi: &DMatrix<f64>) -> DMatrix<f64> {
    let mut hessian = DMatrix::zeros(phi.nrows(), phi.nrows());
    for (k, ray) in fan.rays.iter().enumerate() {
        hessian.ger(ray.node.fine * ray.along.g_aa, &phi.column(k), &phi.column(k), 1.0);
    }
    hessian
}

/// Newton's method about the present centre; returns what it found and the largest eigenvalue of the Hessian, for shapes
/// of unit mean square.
fn newton(fan: &mut RayFan, family: Family, q: &mut Vec<f64>, allowed: f64) -> Result<(Found, f64), Unsolved> {
    let rays = fan.rays.len();
    let n = parameters(family);
    let mut phi = DMatrix::zeros(n, rays);
    for k in 0..rays {
        shapes(fan, &fan.rays[k], family, phi.column_mut(k).iter_mut());
    }
    // Shapes of unit mean square over the angle, so that all parameters weigh alike.
    let norms: Vec<f64> =
        (0..n).map(|j| ((0..rays).map(|k| fan.rays[k].node.fine * phi[(j, k)].powi(2)).sum::<f64>()).sqrt()).collect();
    for (j, norm) in norms.iter().enumerate() {
        phi.row_mut(j).scale_mut(1.0 / norm);
    }
    let mut x = DVector::zeros(n);
    if q.len() == n {
        x.iter_mut().zip(q.iter().zip(&norms)).for_each(|(x, (q, norm))| *x = q * norm);
    } else {
        x[0] = 0.5 * norms[0];
    }
    let apply = |fan: &mut RayFan, x: &DVector<f64>| -> bool {
        for k in 0..rays {
            let a = phi.column(k).dot(x);
            if !(a > 0.0) {
                return false;
            }
            fan.rays[k].a = a;
            fan.rays[k] = fan.measure(fan.rays[k]);
            if fan.rays[k].a < a {
                return false;
            }
        }
        true
    };
    if !apply(fan, &x) {
        return Err(left("the starting circle does not lie on the punch"));
    }
    let mut d = fan.quotient();
    // The circle first, the rest of the family from there.
    let mut alone = q.len() != n;
    for _ in 0..MOST_STEPS {
        if let Some(spent) = fan.out_of_budget() {
            return Err(left(format!("no maximum found in {spent} evaluations of the gap")));
        }
        let mut gradient = DVector::zeros(n);
        for k in 0..rays {
            let ray = &fan.rays[k];
            gradient.axpy(ray.node.fine * (ray.along.g_a - d), &phi.column(k), 1.0);
        }
        let hessian = second_variation(fan, &phi);
        let scale = d.abs() * fan.sum(|r| r.a) / x.norm();
        if alone && (gradient[0].abs() <= 1e-3 * scale || n == 1) {
            alone = false;
        }
        let residual = gradient.norm() / scale;
        let eigen = hessian.clone().symmetric_eigen();
        if residual <= allowed && d > 0.0 {
            let largest = eigen.eigenvalues.max();
            if !(largest < 0.0) {
                return Err(left(format!("where the force is stationary it is no maximum (eigenvalue {largest:.3e})")));
            }
            q.clear();
            q.extend(x.iter().zip(&norms).map(|(x, norm)| x / norm));
            return Ok((Found { d, residual, tightest: (0.0, f64::INFINITY) }, largest));
        }
        let mut step = if alone {
            let mut step = DVector::zeros(n);
            step[0] = gradient[0] / hessian[(0, 0)].abs();
            step
        } else {
            // Uphill along every eigenvector, by the Newton length.
            let along = eigen.eigenvectors.tr_mul(&gradient);
            let floor = 1e-3 * eigen.eigenvalues.amax();
            &eigen.eigenvectors * along.zip_map(&eigen.eigenvalues, |g, e| g / e.abs().max(floor))
        };
        let most = (0..rays).map(|k| phi.column(k).dot(&step).abs() / fan.rays[k].a).fold(0.0, f64::max);
        if most > 0.4 {
            step *= 0.4 / most;
        }
        let before = x.clone();
        let concave = eigen.eigenvalues.max() < 0.0;
        let mut accepted = false;
        for _ in 0..30 {
            x = &before + &step;
            if apply(fan, &x) {
                let next = fan.quotient();
                // More force, and still on the branch: from a maximum one must not step over into a rise without end.
                let on_branch = alone || !concave || second_variation(fan, &phi).symmetric_eigenvalues().max() < 0.0;
                if on_branch && next.is_finite() && next >= d - 1e-14 * d.abs() {
                    d = next;
                    accepted = true;
                    break;
                }
            }
            step *= 0.5;
        }
        if !accepted {
            return Err(left("the optimiser left the branch: no boundary of the family nearby has more force"));
        }
    }
    Err(left(format!("no maximum in {MOST_STEPS} steps: the boundary runs away from the branch")))
}
