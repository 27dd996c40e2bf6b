//! The stationary boundary: G_a(a(theta), theta) = D for every theta (equation 15).
//!
//! D need not be searched for. At a stationary point of P(A) = 2E* N/L, with N the integral of G and L that of a, the
//! constant is the quotient itself, D = N/L = P/(2E*). That makes the method Dinkelbach's algorithm for a quotient: given
//! D, solve for a(theta) ray by ray; set D to N/L; it converges quadratically, from below.
//!
//! Of the roots of G_a = D the one wanted has G_aa < 0 and is connected to the axisymmetric solution: the outer side of
//! the largest G_a along the ray. The second variation of P is (2E*/L) int G_aa (da)^2, so there it is a strict local
//! maximum. (The global maximum is meaningless: a sliver along one direction.) When D exceeds the largest G_a on some
//! ray there is no stationary boundary; since N/L of any boundary on the branch is at most the D sought, that is a proof
//! up to the quadrature, and the verdict names the ray.
//!
//! Departures from the paper: D by the quotient, not by a search for the largest P; the centre, which the flat-punch
//! pressure wants at the centroid of the region, is moved until it is.

use super::approximation::{Approximation, Error, Family, Settings};
use super::plan_form::flat;
use super::problem::{Problem, first_rule_level, several_parts};
use super::ray_fan::{Ray, RayFan};
use super::sweeps::LOW;
use super::symmetry::turns;
use crate::gap::AnyGap;
use crate::problem::EffectiveModulus;
use crate::solution::{Unsolved, Verdict};

/// How often the rays are laid anew along the crossings of the boundary with the ridges.
const MOST_LOOKS: usize = 8;

/// How far kinks are searched for, in reaches of the overlap.
const SEARCHED: f64 = 1.1;

/// Layouts of rays and moves of the centre before giving up.
const MOST_ITERATIONS: usize = 200;

/// The stationary boundary, equation (15).
///
/// ```
/// use contact_patch::{EffectiveModulus, fabrikant, gap::Polyhedron};
/// let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
/// let modulus = EffectiveModulus::from_e_star(0.5)?; // mu/(1 - nu) = E*/2: force in the paper's group is P/(2 E*) * 4
/// let found = fabrikant::stationary(&punch, modulus, 1.0, &fabrikant::Settings::default())?;
/// assert!((found.force / 0.25 - 1.6960382).abs() < 1e-7); // (1 - nu) P tan(alpha)/(mu d^2), equation (20)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `NoStationaryBoundary` when D exceeds the largest G_a in some direction (elongated contacts), `NotStarShaped` when
/// the contact is in several parts, `Unbounded`, `IterationLimit`; an input error for a depth that is not finite.
pub fn stationary(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    settings: &Settings,
) -> Result<Approximation, Error> {
    let gap = &gap.into();
    let settings = settings.checked()?;
    if let Some(answered) = flat(gap, modulus, depth, &settings) {
        return answered;
    }
    let problem = Problem::new(gap, modulus, depth)?.before(settings.deadline);
    let first = about(&problem, modulus, &settings, None);
    // A boundary that does not converge, or not well enough, is a sign of kinks that the gap does not name: search them. (Without the
    // search 0.5 r^2 + 0.2 |x - 0.1| written as a formula has no answer.)
    let lacking = |answer: &Result<Approximation, Error>| match answer {
        Ok(found) => found.quadrature_error[0] + found.quadrature_error[1],
        Err(Error::Unsolved(u)) if u.verdict == Verdict::ToleranceNotReached => 1.0,
        Err(Error::Unsolved(u)) if u.verdict == Verdict::IterationLimit => f64::INFINITY,
        Err(_) => 0.0,
    };
    if lacking(&first) <= settings.tolerance || problem.overlap.has_planes() {
        return first;
    }
    let second = about(&problem, modulus, &settings, Some(SEARCHED * problem.reach));
    if lacking(&second) < lacking(&first) { second } else { first }
}

/// From a circle about the origin; `search`: how far kinks are searched for.
fn about(
    problem: &Problem,
    modulus: EffectiveModulus,
    settings: &Settings,
    search: Option<f64>,
) -> Result<Approximation, Error> {
    let tolerance: f64 = settings.tolerance;
    let residual_allowed = (10.0 * tolerance).max(1e-13);
    let mut fan = RayFan::about(&problem.overlap, [0.0; 2], 0.5, first_rule_level(tolerance), turns(&problem.overlap));
    if search.is_some() {
        fan.search = search;
        fan.budget *= 8;
        fan.lay_sectors();
    }
    let (mut iterations, mut looks) = (0, 0);
    // A coarse layout needs no better centre than itself; the last one does.
    let centred = (0.1 * tolerance).max(1e-13);
    let mut off_allowed = centred.max(1e-4);
    let mut reached = None;
    let (found, errors, off) = loop {
        let settled = fan.centre(off_allowed, |fan, at_most| fan.iterate(residual_allowed.min(at_most).max(1e-13)));
        let (found, moves, off) = settled.map_err(|unsolved| not_converged(unsolved, reached))?;
        iterations += 1 + moves;
        // The rules see a misplaced kink of the boundary as the square of its distance.
        if looks < MOST_LOOKS
            && (fan.take_better_roots(found.d) || fan.follow_crossings(found.d, (0.1 * tolerance).sqrt()))
        {
            looks += 1;
            continue;
        }
        let errors = fan.errors(found.d);
        let error = errors[0] + errors[1];
        reached = Some(error);
        let lacking = found.tightest.1 < -10.0 * error.max(1e-12);
        let enough = error <= tolerance || iterations > 60 || fan.out_of_budget().is_some();
        let mut refined = !lacking && !enough && fan.refine(errors, tolerance, found.d, settings.most_rays);
        if off > off_allowed && !lacking && !refined {
            // The centroid depends on the centre no more smoothly than the quadrature.
            refined = fan.refine([f64::INFINITY, 0.0], 0.01 * errors[0], found.d, settings.most_rays);
        }
        let exhausted = fan.out_of_budget().is_some() || iterations > MOST_ITERATIONS;
        if exhausted || (!refined && (lacking || off <= centred)) {
            break (found, errors, off);
        }
        off_allowed = if refined { centred.max(0.01 * error).min(off_allowed) } else { centred };
    };
    let (mut angle, mut margin) = fan.tightest(found.d);
    if found.tightest.1 < margin {
        (angle, margin) = found.tightest;
    }
    // A ray on which G_a = D holds has its root: only a margin below the residual counts, or one that no search along a ray removes.
    if found.tightest.1 < -LOW || margin < -(2.0 * found.residual).max(1e-10) {
        return Err(no_boundary(angle, margin, off).into());
    }
    if off > off_allowed {
        let reason = format!(
            "the centroid is still {off:.1e} of the size of the region off the centre after {iterations} moves"
        );
        return Err(not_converged(Unsolved::new(Verdict::IterationLimit, reason), reached).into());
    }
    // The overlap with the highest of planes is convex.
    if !problem.overlap.has_planes()
        && let Some(angle) = fan.second_part(problem.reach, problem.searched)
    {
        return Err(several_parts(angle).into());
    }
    let unit = problem.force_unit();
    let length = problem.overlap.units.length;
    let free = |r: &&Ray| !(r.at_edge() && r.along.g_a >= found.d);
    let second = fan.rays.iter().filter(free).map(|r| r.along.g_aa).reduce(f64::max);
    let (off, area) = fan.centroid_and_area();
    let centroid = problem.overlap.units.outward([fan.centre[0] + off[0], fan.centre[1] + off[1]]);
    let perimeter = fan.sum(|r| r.a);
    let rays = fan.rays.len();
    let centre = fan.centre;
    let outline = fan.trace(settings.boundary_points, found.d);
    Ok(Approximation {
        family: Family::Stationary,
        why: String::new(),
        force: unit * found.d,
        stiffness: 4.0 * modulus.e_star() * length * (area / perimeter),
        d: length * problem.overlap.units.height * found.d,
        second_variation: second.map(|s| s * problem.overlap.units.height),
        residual: found.residual,
        margin: Some((angle, margin)),
        boundary: problem.boundary(centre, outline),
        area: area * length * length,
        centroid,
        quadrature_error: errors,
        rays,
        iterations,
        lower_bound: None,
    })
}

/// The verdict when a finer layout of rays does not converge: the error that the last one had.
fn not_converged(unsolved: Unsolved, reached: Option<f64>) -> Unsolved {
    match reached {
        Some(error) if unsolved.verdict == Verdict::IterationLimit => Unsolved::new(
            Verdict::ToleranceNotReached,
            format!(
                "a relative error {error:.1e} of the quadrature was reached; on finer layouts of rays, {}",
                unsolved.reason
            ),
        ),
        _ => unsolved,
    }
}

fn no_boundary(angle: f64, margin: f64, off: f64) -> Unsolved {
    let wandering = if off > 1e-3 { ", wherever the centre was moved on its way to the centroid" } else { "" };
    Unsolved::new(
        Verdict::NoStationaryBoundary,
        format!(
            "in the direction of {:.4} degrees G_a (equation 15) never exceeds D: its top is {:.4} % below{wandering}",
            angle.to_degrees().rem_euclid(360.0),
            -100.0 * margin
        ),
    )
}
