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
//!
//! A gap made of planes has means in closed form (`polyhedral_means.rs`), and log P is then concave: Newton's method finds the one
//! maximum, however blunt the tip (`concave.rs`).

// Comparisons are written so that NaN takes the branch of failure.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

mod concave;
mod coordinates;
mod disc;
mod edge_constraint;
mod polyhedral_means;
mod smooth;

use nalgebra::{Matrix2, Vector2};

use crate::approximate::fabrikant::{
    Approximation, Error, Family, LowerBound, Problem, RadialRule, Sectors, Settings, THIRD, first_rule_level,
};
use crate::gap::{AnyGap, Gap};
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};
use concave::Concave;
use coordinates::{Ellipse, mean_and_share};
use disc::Disc;
use edge_constraint::EdgeConstraint;
use polyhedral_means::PolyhedralMeans;
use smooth::{curvature, maximise};

/// Rays of the first search.
const ROUGH_RAYS: usize = 24;
/// Share of all that can touch that the second start covers, along each axis.
const ALMOST: f64 = 0.8;
/// Ridges that are followed one by one.
const MOST_RIDGES: usize = 24;
/// Kinks on a ray at which it is split; where there are more, each is faint.
const MOST_KINKS: usize = 16;

/// Gradient of log P that may be left when the search is cut short: what it can still gain counts as an error.
const CUT_SHORT: f64 = 1e-2;

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
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let gap = &gap.into();
    best(gap, modulus, depth, Family::Ellipse, settings, None)
}

/// Largest force over all circles: centre and radius (equations 21 to 23).
///
/// # Errors
/// As [`ellipse`].
pub fn circle(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let gap = &gap.into();
    best(gap, modulus, depth, Family::Circle, settings, None)
}

/// The same, looked for from the circle about the centroid of this boundary that has its area.
pub(crate) fn circle_near(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
    near: &Approximation,
) -> Result<Approximation, Error> {
    let start = (near.centroid, (near.area / std::f64::consts::PI).sqrt());
    best(gap, modulus, depth, Family::Circle, settings, Some(start))
}

/// `start`: centre and radius of a circle to start from, else the one half as large as the overlap about its centre.
fn best(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    family: Family,
    settings: &Settings,
    start: Option<([f64; 2], f64)>,
) -> Result<Approximation, Error> {
    let settings = settings.checked()?;
    let circles = family == Family::Circle;
    let problem = Problem::new(gap, modulus, depth)?.before(settings.deadline);
    settings.deadline.check().map_err(Unsolved::from)?;
    let tolerance: f64 = settings.tolerance;
    let units = problem.overlap.units;
    let (c, radius) = start.map_or(([0.0; 2], 0.5), |(c, radius)| (units.inward(c), radius / units.length));
    let start = Ellipse { c: c.into(), m: Matrix2::identity() * radius };
    if let Some(mut polyhedral) = PolyhedralMeans::of(&problem.overlap) {
        let peak = maximise_concave(&mut polyhedral, start, circles, tolerance)?;
        return Ok(report(&problem, modulus, family, &settings, peak));
    }
    let mut directions = Vec::new();
    problem.overlap.gap.kink_directions([0.0; 2], &mut directions);
    // The ridges of very many faces are too faint to be worth a sector each.
    let ridged = directions.len() <= MOST_RIDGES;
    let mut kinks = Vec::new();
    problem.overlap.gap.ray_kinks([0.1, 0.07], [0.6, 0.8], &mut kinks);
    let fresh = || {
        let sectors = if ridged { Sectors::between(&directions, THIRD) } else { Sectors::equal(4 * ROUGH_RAYS) };
        let mut disc = Disc::new(&problem.overlap, sectors, first_rule_level(tolerance));
        (disc.follow_ridges, disc.follow_kinks) = (ridged, kinks.len() <= MOST_KINKS);
        disc
    };
    let mut disc = fresh();
    // A first search with few rays that ignore the ridges.
    let mut rough = Disc::new(&problem.overlap, Sectors::equal(ROUGH_RAYS), 0);
    (rough.follow_ridges, rough.follow_kinks) = (false, false);
    // A gap that is not convex may have several maxima: from the apex, and from an ellipse over all that can touch.
    let [a, b] = if circles { [problem.half[0].min(problem.half[1]); 2] } else { problem.half };
    let all = Ellipse { c: problem.middle.into(), m: Matrix2::new(a, 0.0, 0.0, b) * ALMOST };
    let mut best = (0.0, start);
    for start in [start, all] {
        if let Ok((near, ..)) = maximise(&mut rough, start, circles, 1e-2)
            && let Some((force, ..)) = disc.force_and_gradient(&near, circles)
            && force > best.0 * (1.0 + 1e-6)
        {
            best = (force, near);
        }
    }
    let e = best.1;
    // From the first search; failing that from the circle about the apex, whose symmetry the first search may have lost.
    let free = maximise_inside(&mut disc, e, circles, &settings).or_else(|refused| match refused.verdict {
        Verdict::IterationLimit => Err(refused),
        _ => maximise_inside(&mut fresh(), start, circles, &settings),
    });
    let peak = match free {
        Ok(peak) => peak,
        Err(free) => {
            // No maximum inside: it may lie where the ellipse meets an edge of the punch.
            let mut edges = EdgeConstraint::of(&problem.overlap, problem.reach).ok_or(free)?;
            let mut disc = fresh();
            let (e, residual, iterations) = edges.maximise(&mut disc, circles, tolerance)?;
            let (errors, f, rays) = measure(&mut disc, &e, &settings);
            Optimum { e, errors, residual, largest: None, iterations, rays, f }
        }
    };
    Ok(report(&problem, modulus, family, &settings, peak))
}

/// How well the gradient of log P is to be zero: the force needs the square root of its tolerance only; the boundary is
/// wanted better when there is time for it.
fn gradient_allowed(tolerance: f64) -> f64 {
    if tolerance < 1e-6 { (0.01 * tolerance).max(1e-13) } else { 10.0 * tolerance }
}

/// The only maximum over a convex gap made of planes.
fn maximise_concave(
    polyhedral: &mut PolyhedralMeans,
    start: Ellipse,
    circles: bool,
    tolerance: f64,
) -> Result<Optimum, Unsolved> {
    let top = Concave { polyhedral, circles }.maximise(start, gradient_allowed(tolerance))?;
    Ok(Optimum {
        e: top.e,
        errors: [0.0, 4.0 * polyhedral.rounding / top.mean],
        residual: top.decrement,
        largest: Some(top.largest),
        iterations: top.steps,
        rays: polyhedral.ridges.all.len(),
        f: top.mean,
    })
}

/// The maximum inside the punch, with the quadrature made finer until it satisfies.
fn maximise_inside(disc: &mut Disc, start: Ellipse, circles: bool, settings: &Settings) -> Result<Optimum, Unsolved> {
    let (tolerance, gradient_allowed) = (settings.tolerance, gradient_allowed(settings.tolerance));
    let (mut e, mut iterations) = (start, 0);
    let off = |found: &Optimum| found.errors[0] + found.errors[1] + found.residual;
    let mut best: Option<Optimum> = None;
    loop {
        let (peak, residual, steps) = maximise(disc, e, circles, gradient_allowed)?;
        e = peak;
        iterations += steps;
        let (errors, f, refined) = look(disc, &e, settings);
        let here = Optimum { e, errors, residual, largest: None, iterations, rays: disc.values.len(), f };
        // The last layout need not be the best: panels are worse than many equal rays where kinks are not known.
        let found = best.filter(|best| !(off(&here) < off(best))).unwrap_or(here);
        best = Some(found);
        if refined && errors[0] + errors[1] > tolerance && !disc.out_of_budget() {
            continue;
        }
        let Optimum { e, mut errors, residual, rays, mut f, .. } = found;
        disc.overlap.deadline.check()?;
        if disc.out_of_budget() {
            if residual > CUT_SHORT {
                let reason = format!(
                    "the search for the best ellipse was cut short after {} evaluations of the gap: the gradient of log P \
                     left is {residual:.1e}, the error of the quadrature {:.1e}",
                    disc.work,
                    errors[0] + errors[1]
                );
                return Err(Unsolved::new(Verdict::IterationLimit, reason));
            }
            // What the gradient can still gain where the second variation is about -1.
            errors[0] += residual * residual;
            // The maximum may be one of the errors of a rule that does not follow the kinks: the finest rule shows them.
            let finest = disc.means(&e, RadialRule::finest()).f;
            errors[1] = errors[1].max(((finest - f) / f).abs());
            f = finest;
        } else if residual > 1e-3 {
            // A peak of the gap off the centre, say, that the rays do not resolve: the ellipse does not diverge, so there may be a maximum.
            let reason = format!(
                "the search for the best ellipse came to a stop where the gradient of log P is still {residual:.1e}; the error of \
                 the quadrature is {:.1e}",
                errors[0] + errors[1]
            );
            return Err(Unsolved::new(Verdict::IterationLimit, reason));
        }
        let largest = curvature(disc, &e, circles)
            .filter(|&largest| largest < 0.0)
            .ok_or_else(|| diverged("where the force is stationary it is not a maximum"))?;
        return Ok(Optimum { e, errors, residual, largest: Some(largest), iterations, rays, f });
    }
}

/// Errors of the quadrature over this ellipse, the mean overlap, and whether the rule was made finer for the next look.
fn look(disc: &mut Disc, e: &Ellipse, settings: &Settings) -> ([f64; 2], f64, bool) {
    let tolerance: f64 = settings.tolerance;
    let means = disc.means(e, disc.rule());
    let total = std::f64::consts::TAU * means.f;
    let angular = disc.sectors.error(&disc.nodes, &disc.values) / total;
    let values = disc.values.clone();
    let finer = disc.means(e, RadialRule::level(disc.rule_level + 1).unwrap_or_else(RadialRule::finest));
    let errors = [angular, ((finer.f - means.f) / means.f).abs()];
    let mut refined = false;
    if !disc.may_refine() {
        return (errors, means.f, false);
    }
    if errors[1] > 0.5 * tolerance && RadialRule::can_refine(disc.rule_level) {
        disc.rule_level += 1;
        refined = true;
    }
    if errors[0] > 0.5 * tolerance {
        let allowed = 0.5 * tolerance * total;
        let nodes = disc.nodes.clone();
        if disc.sectors.refine(&nodes, &values, allowed, settings.most_rays) {
            disc.nodes.clear();
            refined = true;
        }
    }
    (errors, means.f, refined)
}

/// The same for an ellipse that stays: errors, mean overlap and rays.
fn measure(disc: &mut Disc, e: &Ellipse, settings: &Settings) -> ([f64; 2], f64, usize) {
    loop {
        let (errors, f, refined) = look(disc, e, settings);
        if !refined || errors[0] + errors[1] <= settings.tolerance {
            return (errors, f, disc.values.len());
        }
    }
}

/// Where the search ended.
#[derive(Clone, Copy)]
struct Optimum {
    e: Ellipse,
    errors: [f64; 2],
    residual: f64,
    /// Largest eigenvalue of the second variation of log P; `None` at an edge of the punch, where nothing is free.
    largest: Option<f64>,
    iterations: usize,
    rays: usize,
    f: f64,
}

fn report(
    problem: &Problem,
    modulus: EffectiveModulus,
    family: Family,
    settings: &Settings,
    peak: Optimum,
) -> Approximation {
    let units = problem.overlap.units;
    let ([a, b], along, _) = peak.e.axes();
    let (agm, _) = mean_and_share(a, b);
    let force = problem.force_unit() * agm * peak.f;
    // Both ends of both axes among them.
    let points = settings.boundary_points.max(4).next_multiple_of(4);
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
        stiffness: 2.0 * modulus.e_star() * units.length * agm,
        d: force / (2.0 * modulus.e_star()),
        second_variation: peak.largest.map(|largest| largest * agm * peak.f * units.height),
        residual: peak.residual,
        margin: None,
        centroid: boundary.centre,
        boundary,
        area: std::f64::consts::PI * (a * units.length) * (b * units.length),
        quadrature_error: peak.errors,
        rays: peak.rays,
        iterations: peak.iterations,
        lower_bound: Some(LowerBound(force * (1.0 - peak.errors[0] - peak.errors[1] - 1e-14))),
    }
}

/// A/B of the paraboloid A x^2 + B y^2 whose contact ellipse has semi-axes 1 along x and `ratio` along y (Hertz).
pub(crate) fn curvature_ratio(ratio: f64) -> f64 {
    let (_, share) = mean_and_share(1.0, ratio);
    ratio * ratio * share / (1.0 - share)
}

fn diverged(reason: &str) -> Unsolved {
    Unsolved::new(Verdict::NoMaximum, reason)
}
