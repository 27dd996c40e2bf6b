//! The best ellipse (section 2.2): a rigorous lower bound of the force.
//!
//! The flat elliptical punch is known exactly: stiffness 2 E* agm(a, b), pressure ~ (1 - rho^2)^(-1/2). By reciprocity
//!
//! ```text
//! P = 2 E* agm(a, b) mean(f),   mean(f) = 1/(2 pi) int dpsi int_0^{pi/2} f(c + M u) sin t dt,  u = sin t (cos psi, sin psi)
//! ```
//!
//! for the ellipse that M makes of the unit disc. No ellipse gives more than the true force, so the largest P is a lower
//! bound. It is exact for paraboloids: there one step leads from any ellipse to Hertz's, since the step solves Hertz's
//! problem for the paraboloid with the same mean, mean gradient and mean gradient moment. Other gaps need a few steps of
//! the BFGS method, in coordinates that turn the present ellipse into the unit disc, so that slender ones cost no digits.

// Comparisons are written so that NaN takes the branch of failure.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use nalgebra::{DMatrix, Matrix2, SMatrix, SVector, Vector2};

use crate::error::{Unsolved, Verdict};
use crate::fabrikant::{
    Approximation, DIFFERENCE_STEP, Error, Family, LowerBound, Overlap, Problem, RadialRule, Sectors, Settings, Spoke,
    THIRD, first_rung,
};
use crate::gap::Gap;
use crate::material::EffectiveModulus;

/// Rays of the first look.
const ROUGH_RAYS: usize = 24;
/// Steps before giving up.
const MOST_STEPS: usize = 100;

/// Largest force over all ellipses: centre, semi-axes and orientation.
///
/// ```
/// use contact_patch::{EffectiveModulus, gap::Paraboloid, ritz, fabrikant::Settings};
/// let gap = Paraboloid::new([1.0, 0.5])?; // A = 1/2, B = 1
/// let found = ritz::ellipse(&gap, EffectiveModulus::from_e_star(1.0)?, 1.0, &Settings::default())?;
/// assert!((found.force - 1.1323996556884069).abs() < 1e-12); // Hertz
/// assert!(found.lower_bound.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `NoMaximum` when the ellipse grows or shrinks without end, or ends where the force is not a maximum.
pub fn ellipse(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    best(gap, modulus, depth, Family::Ellipse, settings)
}

/// Largest force over all circles: centre and radius (equations 21 to 23).
///
/// # Errors
/// As [`ellipse`].
pub fn circle(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    best(gap, modulus, depth, Family::Circle, settings)
}

/// Centre (2) and logarithmic strain of the ellipse (3: along 1, along 2, shear times sqrt 2), in its own coordinates.
type Step = SVector<f64, 5>;

/// An ellipse: c + M u, |u| < 1.
#[derive(Debug, Clone, Copy)]
struct Ellipse {
    c: Vector2<f64>,
    m: Matrix2<f64>,
}

impl Ellipse {
    /// The ellipse one step away.
    fn moved(&self, step: &Step) -> Self {
        let shear = step[4] / std::f64::consts::SQRT_2;
        let s = Matrix2::new(step[2], shear, shear, step[3]);
        let exp = Matrix2::identity() + s + s * s / 2.0 + s * s * s / 6.0;
        Self { c: self.c + self.m * Vector2::new(step[0], step[1]), m: self.m * exp }
    }

    /// Semi-axes a >= b, direction of a (a unit vector), and the same direction before M.
    fn axes(&self) -> ([f64; 2], Vector2<f64>, Vector2<f64>) {
        let (values, vectors) = eigen(&(self.m * self.m.transpose()));
        let (_, before) = eigen(&(self.m.transpose() * self.m));
        let a = values[1].sqrt();
        ([a, self.m.determinant().abs() / a], vectors.column(1).into(), before.column(1).into())
    }
}

/// Eigenvalues (ascending) and vectors of a symmetric matrix by one Jacobi rotation, which keeps the digits of the small one.
fn eigen(q: &Matrix2<f64>) -> ([f64; 2], Matrix2<f64>) {
    let (q11, q12, q22) = (q[(0, 0)], 0.5 * (q[(0, 1)] + q[(1, 0)]), q[(1, 1)]);
    let t = if q12 == 0.0 {
        0.0
    } else {
        let theta = (q22 - q11) / (2.0 * q12);
        theta.signum() / (theta.abs() + theta.hypot(1.0))
    };
    let cos = 1.0 / t.hypot(1.0);
    let sin = t * cos;
    let (low, high) = (q11 - t * q12, q22 + t * q12);
    if low <= high {
        ([low, high], Matrix2::new(cos, sin, -sin, cos))
    } else {
        ([high, low], Matrix2::new(sin, cos, cos, -sin))
    }
}

/// agm(a, b) and its logarithmic derivative with respect to log a, a >= b: (K - E)/(e^2 K), from the differences of the
/// arithmetic-geometric mean, where nothing cancels.
fn mean_and_share(a: f64, b: f64) -> (f64, f64) {
    let k = b / a;
    let (mut x, mut y) = (0.5 * (1.0 + k), k.sqrt());
    // c_n^2/e^2 and the running sum of 2^(n-1) c_n^2/e^2.
    let mut c = 0.5 * (1.0 - k);
    let mut ratio = (1.0 - k) / (4.0 * (1.0 + k));
    let mut share = 0.5 + ratio;
    let mut power = 2.0;
    while c > 1e-17 {
        let next = 0.5 * (x + y);
        let factor = c / (4.0 * next);
        ratio *= factor * factor;
        c *= factor;
        share += power * ratio;
        power *= 2.0;
        (x, y) = (next, (x * y).sqrt());
    }
    (a * x, share)
}

/// Means of the overlap and of the gradient of the gap under the flat-punch pressure, in the ellipse's own coordinates.
struct Means {
    f: f64,
    slope: Vector2<f64>,
    moment: Matrix2<f64>,
}

/// The quadrature, with its buffers.
struct Disc<'a> {
    overlap: &'a Overlap<'a>,
    sectors: Sectors,
    rung: usize,
    spokes: Vec<Spoke>,
    values: Vec<f64>,
    directions: Vec<f64>,
    kinks: Vec<f64>,
    /// Whether the sectors follow the ridges of the gap, and the rays are split at its kinks.
    follow_ridges: bool,
}

impl<'a> Disc<'a> {
    fn new(overlap: &'a Overlap<'a>, sectors: Sectors, rung: usize) -> Self {
        let (spokes, values, directions, kinks) = Default::default();
        Self { overlap, sectors, rung, spokes, values, directions, kinks, follow_ridges: true }
    }

    fn lay(&mut self, e: &Ellipse) {
        if !self.follow_ridges {
            if self.spokes.is_empty() {
                self.sectors.spokes(&mut self.spokes);
                self.values.resize(self.spokes.len(), 0.0);
            }
            return;
        }
        self.directions.clear();
        self.overlap.gap.kink_directions(e.c.into(), &mut self.directions);
        if let Some(inverse) = e.m.try_inverse() {
            for angle in &mut self.directions {
                let (sin, cos) = angle.sin_cos();
                let back = inverse * Vector2::new(cos, sin);
                *angle = back.y.atan2(back.x);
            }
        }
        self.sectors.move_to(&self.directions);
        self.sectors.spokes(&mut self.spokes);
        self.values.resize(self.spokes.len(), 0.0);
    }

    fn means(&mut self, e: &Ellipse, rule: &RadialRule) -> Means {
        self.lay(e);
        let has_gradient = self.overlap.has_gradient();
        let f0 = self.overlap.at(e.c.into());
        let mut means = Means { f: 0.0, slope: Vector2::zeros(), moment: Matrix2::zeros() };
        for (spoke, value) in self.spokes.iter().zip(&mut self.values) {
            let (sin, cos) = spoke.angle.sin_cos();
            let direction = Vector2::new(cos, sin);
            let ray = e.m * direction;
            let length = ray.norm();
            self.kinks.clear();
            if self.follow_ridges {
                self.overlap.gap.ray_kinks(e.c.into(), (ray / length).into(), &mut self.kinks);
                self.kinks.iter_mut().for_each(|r| *r /= length);
                self.kinks.sort_by(f64::total_cmp);
            }
            let (mut f, mut slope, mut moment) = (0.0, Vector2::zeros(), Vector2::zeros());
            rule.visit(&self.kinks, 1.0, |node| {
                let x = e.c + ray * node.sin;
                let g = if has_gradient {
                    e.m.tr_mul(&Vector2::from(self.overlap.slope(x.into(), 0.0)))
                } else {
                    let across = |u: Vector2<f64>| {
                        let h = e.m * u * DIFFERENCE_STEP;
                        (self.overlap.at((x - h).into()) - self.overlap.at((x + h).into())) / (2.0 * DIFFERENCE_STEP)
                    };
                    Vector2::new(across(Vector2::x()), across(Vector2::y()))
                };
                // int f sin t dt = f(c) - int (dg/dr) cos^2 t dt.
                f += if has_gradient {
                    -node.weight * node.cos * node.cos * g.dot(&direction)
                } else {
                    node.weight * node.sin * self.overlap.at(x.into())
                };
                slope += g * (node.weight * node.sin);
                moment += g * (node.weight * node.sin * node.sin);
            });
            *value = if has_gradient { f0 + f } else { f };
            let share = spoke.fine / std::f64::consts::TAU;
            means.f += share * *value;
            means.slope += slope * share;
            means.moment += moment * direction.transpose() * share;
        }
        // What symmetry makes zero comes out as rounding; a centre moved by rounding would lose the symmetry of the rays.
        let noise = 1e-14 * (means.f.abs() + means.moment.amax());
        means.slope.apply(|s| *s = if s.abs() < noise { 0.0 } else { *s });
        means
    }

    fn rule(&self) -> &'static RadialRule {
        &RadialRule::ladder()[self.rung]
    }

    /// Force (in units of 2E*), its logarithmic gradient, and the means.
    fn climb(&mut self, e: &Ellipse, circles: bool) -> Option<(f64, Step, Means)> {
        let means = self.means(e, self.rule());
        let ([a, b], _, before) = e.axes();
        let (agm, share) = mean_and_share(a, b);
        let force = agm * means.f;
        if !(force > 0.0 && force.is_finite() && means.moment.iter().all(|m| m.is_finite())) {
            return None;
        }
        // d log agm = share along the long axis, 1 - share along the short one.
        let stiffer = Matrix2::identity() * (1.0 - share) + before * before.transpose() * (2.0 * share - 1.0);
        let s = stiffer - (means.moment + means.moment.transpose()) / (2.0 * means.f);
        let v = -means.slope / means.f;
        let step = if circles {
            let scale = 0.5 * s.trace();
            Step::new(v.x, v.y, scale, scale, 0.0)
        } else {
            Step::new(v.x, v.y, s[(0, 0)], s[(1, 1)], std::f64::consts::SQRT_2 * s[(0, 1)])
        };
        Some((force, step, means))
    }
}

/// Hertz's ellipse for the paraboloid that has these means over the present ellipse.
fn hertz(e: &Ellipse, means: &Means, circles: bool) -> Option<Ellipse> {
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
    // A/B = k^2 share/(1 - share); log against log is almost straight (DLMF 19.16 forms it from R_D), so secants do.
    let target = (curvatures[0] / curvatures[1]).ln();
    let off = |log_k: f64| {
        let (_, share) = mean_and_share(1.0, log_k.exp());
        2.0 * log_k + (share / (1.0 - share)).ln() - target
    };
    let (mut x0, mut x1) = (0.6 * target, (0.6 * target + 0.05).min(0.0));
    if x0 == x1 {
        x0 = -0.05;
    }
    let (mut y0, mut y1) = (off(x0), off(x1));
    for _ in 0..60 {
        if y1 == y0 || y1.abs() < 1e-15 {
            break;
        }
        let x2 = (x1 - y1 * (x1 - x0) / (y1 - y0)).min(0.0);
        (x0, y0, x1) = (x1, y1, x2);
        if x1 == x0 {
            break;
        }
        y1 = off(x1);
    }
    let (_, share) = mean_and_share(1.0, x1.exp());
    let b = (2.0 * depth * (1.0 - share) / curvatures[1]).sqrt();
    let axes = Matrix2::new(b / x1.exp(), 0.0, 0.0, b);
    Some(Ellipse { c, m: directions * axes })
}

fn best(
    gap: &dyn Gap,
    modulus: EffectiveModulus,
    depth: f64,
    family: Family,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let settings = settings.checked()?;
    let circles = family == Family::Circle;
    let problem = Problem::new(gap, modulus, depth)?;
    let tolerance: f64 = settings.tolerance;
    let mut directions = Vec::new();
    problem.overlap.gap.kink_directions([0.0; 2], &mut directions);
    let mut disc = Disc::new(&problem.overlap, Sectors::between(&directions, THIRD), first_rung(tolerance));
    // A first look with few rays that ignore the ridges.
    let mut rough = Disc::new(&problem.overlap, Sectors::equal(ROUGH_RAYS), 0);
    rough.follow_ridges = false;
    let mut e = Ellipse { c: Vector2::zeros(), m: Matrix2::identity() * 0.5 };
    if let Ok((near, ..)) = maximise(&mut rough, e, circles, 1e-2)
        && disc.climb(&near, circles).is_some()
    {
        e = near;
    }
    let mut iterations = 0;
    // The force needs the square root of its tolerance only; the boundary is wanted better when there is time for it.
    let gradient_allowed = if tolerance < 1e-6 { (0.01 * tolerance).max(1e-13) } else { 10.0 * tolerance };
    loop {
        let (peak, residual, steps) = maximise(&mut disc, e, circles, gradient_allowed)?;
        e = peak;
        iterations += steps;
        let means = disc.means(&e, disc.rule());
        let total = std::f64::consts::TAU * means.f;
        let angular = disc.sectors.error(&disc.spokes, &disc.values) / total;
        let values = disc.values.clone();
        let finer = disc.means(&e, &RadialRule::ladder()[disc.rung + 1]);
        let errors = [angular, ((finer.f - means.f) / means.f).abs()];
        let mut refined = false;
        if errors[1] > 0.5 * tolerance && disc.rung + 2 < RadialRule::ladder().len() {
            disc.rung += 1;
            refined = true;
        }
        if errors[0] > 0.5 * tolerance {
            let allowed = 0.5 * tolerance * total;
            refined |= disc.sectors.refine(&disc.spokes.clone(), &values, allowed, settings.most_rays);
        }
        if refined && errors[0] + errors[1] > tolerance {
            continue;
        }
        if residual > 1e-3 {
            return Err(runaway("no maximum of the force over ellipses was found").into());
        }
        let largest = curvature(&mut disc, &e, circles)
            .filter(|&largest| largest < 0.0)
            .ok_or_else(|| runaway("where the force is stationary it is not a maximum"))?;
        return Ok(report(
            &problem,
            modulus,
            family,
            &settings,
            Peak { e, errors, residual, largest, iterations, rays: values.len(), f: means.f },
        ));
    }
}

/// Where the search ended.
struct Peak {
    e: Ellipse,
    errors: [f64; 2],
    residual: f64,
    largest: f64,
    iterations: usize,
    rays: usize,
    f: f64,
}

fn report(
    problem: &Problem,
    modulus: EffectiveModulus,
    family: Family,
    settings: &Settings,
    peak: Peak,
) -> Approximation {
    let scaled = &problem.overlap.gap;
    let ([a, b], along, _) = peak.e.axes();
    let (agm, _) = mean_and_share(a, b);
    let force = problem.force_unit() * agm * peak.f;
    let points = settings.boundary_points.max(4);
    // Points at equal steps of the ellipse's own angle, which follow slender ends; as polar angles about the centre.
    let mut outline: Vec<[f64; 2]> = (0..points)
        .map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / points as f64).sin_cos();
            let p = along * (a * cos) + Vector2::new(-along.y, along.x) * (b * sin);
            [p.y.atan2(p.x).rem_euclid(std::f64::consts::TAU), p.norm()]
        })
        .collect();
    outline.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let boundary = problem.boundary(peak.e.c.into(), outline);
    Approximation {
        family,
        why: String::new(),
        force,
        stiffness: 2.0 * modulus.e_star() * scaled.length * agm,
        d: force / (2.0 * modulus.e_star()),
        second_variation: Some(peak.largest * agm * peak.f * scaled.depth * scaled.length / scaled.length),
        residual: peak.residual,
        margin: None,
        centroid: boundary.centre,
        boundary,
        area: std::f64::consts::PI * (a * scaled.length) * (b * scaled.length),
        quadrature_error: peak.errors,
        rays: peak.rays,
        iterations: peak.iterations,
        lower_bound: Some(LowerBound(force * (1.0 - peak.errors[0] - peak.errors[1] - 1e-14))),
    }
}

fn runaway(reason: &str) -> Unsolved {
    Unsolved::new(Verdict::NoMaximum, reason)
}

/// Hertz steps while they help much, then BFGS. Returns the ellipse, the gradient left, and the steps.
fn maximise(disc: &mut Disc, start: Ellipse, circles: bool, allowed: f64) -> Result<(Ellipse, f64, usize), Unsolved> {
    let mut e = start;
    let (mut force, mut gradient, mut means) = shrink_until_loaded(disc, &mut e, circles)?;
    let mut inverse = SMatrix::<f64, 5, 5>::identity() / 1.5;
    for steps in 0..MOST_STEPS {
        if gradient.norm() <= allowed {
            return Ok((e, gradient.norm(), steps));
        }
        if steps < 3
            && let Some(next) = hertz(&e, &means, circles)
            && let Some((f, g, m)) = disc.climb(&next, circles)
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
            let next = e.moved(&step);
            if let Some((f, g, m)) = disc.climb(&next, circles)
                && f >= force * (1.0 - 4e-16)
            {
                let y = gradient - g;
                let sy = step.dot(&y);
                if sy > 1e-12 * step.norm() * y.norm() {
                    let rho = 1.0 / sy;
                    let left = SMatrix::<f64, 5, 5>::identity() - step * y.transpose() * rho;
                    inverse = left * inverse * left.transpose() + step * step.transpose() * rho;
                }
                (e, force, gradient, means) = (next, f, g, m);
                accepted = true;
                break;
            }
            step *= 0.5;
        }
        let ([a, b], ..) = e.axes();
        if !(a < 1e12 && b > 1e-12) {
            return Err(runaway("the ellipse grows or shrinks without end"));
        }
        if !accepted {
            // Rounding, or the quadrature: as stationary as it can be seen to be with these nodes.
            break;
        }
    }
    Ok((e, gradient.norm(), MOST_STEPS))
}

/// The force and gradient of the ellipse, halved until it carries load.
fn shrink_until_loaded(disc: &mut Disc, e: &mut Ellipse, circles: bool) -> Result<(f64, Step, Means), Unsolved> {
    for _ in 0..200 {
        if let Some(found) = disc.climb(e, circles) {
            return Ok(found);
        }
        // The means of a smooth gap tell the way even where the force is negative.
        let means = disc.means(e, disc.rule());
        match hertz(e, &means, circles) {
            Some(better) if better.m.iter().all(|m| m.is_finite()) && better.axes().0[0] < e.axes().0[0] * 1e6 => {
                if disc.climb(&better, circles).is_some() {
                    *e = better;
                    continue;
                }
                e.m *= 0.5;
            }
            _ => e.m *= 0.5,
        }
    }
    Err(runaway("no ellipse carries load"))
}

/// Largest eigenvalue of the Hessian of log P, by differences of the gradient: negative at a strict local maximum.
fn curvature(disc: &mut Disc, e: &Ellipse, circles: bool) -> Option<f64> {
    // Wide: a centre moved off an apex by little leaves thin layers in the angle that the rays do not resolve.
    const H: f64 = 0.1;
    let directions: &[Step] = &if circles {
        vec![Step::x(), Step::y(), Step::new(0.0, 0.0, 1.0, 1.0, 0.0) / std::f64::consts::SQRT_2]
    } else {
        (0..5).map(|k| Step::ith(k, 1.0)).collect()
    };
    let (_, here, _) = disc.climb(e, circles)?;
    let n = directions.len();
    let mut hessian = DMatrix::zeros(n, n);
    for (j, direction) in directions.iter().enumerate() {
        let (_, there, _) = disc.climb(&e.moved(&(direction * H)), circles)?;
        for (i, other) in directions.iter().enumerate() {
            hessian[(i, j)] = other.dot(&(there - here)) / H;
        }
    }
    Some((&hessian + hessian.transpose()).symmetric_eigen().eigenvalues.max() / 2.0)
}
