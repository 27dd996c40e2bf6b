//! The best ellipse of a smooth gap: Hertz's step, then BFGS (log P need not be concave); and the check that it is a maximum.

use nalgebra::{DMatrix, Matrix2, SMatrix};

use super::coordinates::{Ellipse, Step, eigen, mean_and_share};
use super::disc::{Disc, Means};
use super::diverged;
use crate::numeric::scalar::root;
use crate::solution::Unsolved;

/// Steps before giving up.
const MOST_STEPS: usize = 100;

/// Steps in a row that better neither force nor gradient: rounding, or the quadrature.
const MOST_IDLE: usize = 3;

/// Hertz's ellipse for the paraboloid that has these means over the present ellipse.
pub(super) fn hertz(e: &Ellipse, means: &Means, circles: bool) -> Option<Ellipse> {
    let q = (means.moment + means.moment.transpose()) * 1.5;
    let inverse = q.try_inverse()?;
    let depth = means.f + 0.5 * means.moment.trace() + 0.5 * means.slope.dot(&(inverse * means.slope));
    let out = e.m.try_inverse()?;
    let (curvatures, directions) = eigen(&(out.transpose() * q * out));
    if !(curvatures[0] > 0.0 && depth > 0.0) {
        return None;
    }
    let c = e.c - e.m * (inverse * means.slope);
    if circles {
        let mean = 0.5 * (curvatures[0] + curvatures[1]);
        return Some(Ellipse { c, m: Matrix2::identity() * (depth / mean).sqrt() });
    }
    // A/B = k^2 share/(1 - share), which lies between k and k^2: log against log is almost straight.
    let target = (curvatures[0] / curvatures[1]).ln();
    let off = |log_k: f64| {
        let (_, share) = mean_and_share(1.0, log_k.exp());
        2.0 * log_k + (share / (1.0 - share)).ln() - target
    };
    let k = root(off, target, 0.0).map_or(1.0, |found| found.at.exp());
    let (_, share) = mean_and_share(1.0, k);
    let b = (2.0 * depth * (1.0 - share) / curvatures[1]).sqrt();
    let axes = Matrix2::new(b / k, 0.0, 0.0, b);
    Some(Ellipse { c, m: directions * axes })
}

/// Hertz steps while they help much, then BFGS. Returns the ellipse, the gradient left, and the steps.
pub(super) fn maximise(
    disc: &mut Disc,
    start: Ellipse,
    circles: bool,
    allowed: f64,
) -> Result<(Ellipse, f64, usize), Unsolved> {
    let mut e = start;
    let (mut force, mut gradient, mut means) = shrink_until_loaded(disc, &mut e, circles)?;
    let mut inverse = SMatrix::<f64, 5, 5>::identity() / 1.5;
    let mut idle = 0;
    for steps in 0..MOST_STEPS {
        if gradient.norm() <= allowed || disc.out_of_budget() || idle == MOST_IDLE {
            return Ok((e, gradient.norm(), steps));
        }
        if steps < 3
            && let Some(next) = hertz(&e, &means, circles)
            && let Some((f, g, m)) = disc.force_and_gradient(&next, circles)
            && f > force
        {
            (e, force, gradient, means) = (next, f, g, m);
            continue;
        }
        let mut step = inverse * gradient;
        if !(step.dot(&gradient) > 0.0) {
            inverse = SMatrix::identity() / 1.5;
            step = inverse * gradient;
        }
        if step.norm() > 0.7 {
            step *= 0.7 / step.norm();
        }
        let mut accepted = false;
        for _ in 0..40 {
            if disc.out_of_budget() {
                break;
            }
            let next = e.moved(&step);
            if let Some((f, g, m)) = disc.force_and_gradient(&next, circles)
                && f >= force * (1.0 - 4e-16)
            {
                let y = gradient - g;
                let sy = step.dot(&y);
                if sy > 1e-12 * step.norm() * y.norm() {
                    let rho = 1.0 / sy;
                    let left = SMatrix::<f64, 5, 5>::identity() - step * y.transpose() * rho;
                    inverse = left * inverse * left.transpose() + step * step.transpose() * rho;
                }
                let better = f > force * (1.0 + 1e-15) || g.norm() < 0.9 * gradient.norm();
                idle = if better { 0 } else { idle + 1 };
                (e, force, gradient, means) = (next, f, g, m);
                accepted = true;
                break;
            }
            step *= 0.5;
        }
        let ([a, b], ..) = e.axes();
        if !(a < 1e12 && b > 1e-12) {
            return Err(diverged("the ellipse grows or shrinks without end"));
        }
        if !accepted {
            // Rounding, or the quadrature: as stationary as it can be seen to be with these nodes.
            break;
        }
    }
    Ok((e, gradient.norm(), MOST_STEPS))
}

/// The force and gradient of the ellipse, halved until it carries load.
pub(super) fn shrink_until_loaded(
    disc: &mut Disc,
    e: &mut Ellipse,
    circles: bool,
) -> Result<(f64, Step, Means), Unsolved> {
    for _ in 0..200 {
        if let Some(found) = disc.force_and_gradient(e, circles) {
            return Ok(found);
        }
        disc.overlap.deadline.check()?;
        // The means of a smooth gap give a step even where the force is negative.
        let means = disc.means(e, disc.rule());
        match hertz(e, &means, circles) {
            Some(better) if better.m.iter().all(|m| m.is_finite()) && better.axes().0[0] < e.axes().0[0] * 1e6 => {
                if disc.force_and_gradient(&better, circles).is_some() {
                    *e = better;
                    continue;
                }
                e.m *= 0.5;
            }
            _ => e.m *= 0.5,
        }
    }
    Err(diverged("no ellipse carries load"))
}

/// Largest eigenvalue of the Hessian of log P, by differences of the gradient: negative at a strict local maximum.
pub(super) fn curvature(disc: &mut Disc, e: &Ellipse, circles: bool) -> Option<f64> {
    // Wide: a centre moved off an apex by little leaves thin layers in the angle that the rays do not resolve.
    const H: f64 = 0.1;
    let directions: &[Step] = &if circles {
        vec![Step::x(), Step::y(), Step::new(0.0, 0.0, 1.0, 1.0, 0.0) / std::f64::consts::SQRT_2]
    } else {
        (0..5).map(|k| Step::ith(k, 1.0)).collect()
    };
    let (_, here, _) = disc.force_and_gradient(e, circles)?;
    let n = directions.len();
    let mut hessian = DMatrix::zeros(n, n);
    for (j, direction) in directions.iter().enumerate() {
        let (_, there, _) = disc.force_and_gradient(&e.moved(&(direction * H)), circles)?;
        for (i, other) in directions.iter().enumerate() {
            hessian[(i, j)] = other.dot(&(there - here)) / H;
        }
    }
    Some((&hessian + hessian.transpose()).symmetric_eigen().eigenvalues.max() / 2.0)
}
