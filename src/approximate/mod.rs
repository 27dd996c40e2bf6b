//! A state of contact from the approximate methods.

mod choice;
pub(crate) mod energy;
pub mod fabrikant;
pub mod ritz;

pub use choice::{at_force, auto, solve};

use self::fabrikant::{Approximation, Error, Family};
use crate::gap::AnyGap;
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, least};
use crate::problem::{BoundaryFamily, Contact, Method, Settings};
use crate::solution::{Cost, Origin, Patch, Piece, PressureSummary, Solution, Unsolved, Validity, Verdict};

/// The state at a depth and tilt (`gap` is the contact's gap under that tilt), in the user's units. `with_matrix`: energy, moments
/// and the stiffness against tilts too, whether or not they take further solves.
///
/// # Errors
/// The verdicts of [`solve`]; nothing is passed off as a solution when the method does not apply.
pub(crate) fn solution(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    if depth <= least(gap).1 {
        return Ok(Solution::apart(settings.method, depth, tilt));
    }
    let fine = fabrikant::Settings {
        tolerance: 1e-3 * settings.tolerance,
        deadline: settings.deadline,
        boundary_points: if settings.outputs.patch || with_matrix { 180 } else { 0 },
        ..fabrikant::Settings::default()
    };
    let (found, apart) = boundary(contact, gap, depth, settings, &fine)?;
    let work = {
        let rough = fabrikant::Settings { boundary_points: 0, ..fine };
        let at = |gap: &AnyGap, depth: f64| boundary(contact, gap, depth, settings, &rough).map(|(found, _)| found);
        let sought = energy::EnergyProblem { gap, depth, found: &found, tolerance: settings.tolerance, at: &at };
        if with_matrix {
            Ok(sought.with_matrix(contact.modulus().e_star())?)
        } else if settings.outputs.energy {
            sought.by_integration().map_err(|e| e.reason)
        } else {
            sought.by_homogeneity().ok_or_else(|| "further solves, not asked for".to_owned())
        }
    };
    let mut solution = dimensional(contact, depth, tilt, settings, found);
    if apart > 1 {
        solution.remarks.push(format!("the bodies overlap in {apart} separate places; the ellipse covers one"));
    }
    match work {
        Ok(work) => {
            solution.energy = Some(work.energy);
            solution.moment = work.first_moment.map(|[x, y]| [y, -x]);
            solution.stiffness = work.stiffness;
            solution.stiffness_matrix = work.matrix;
            solution.cost.steps = work.states;
            solution.remarks.extend(work.remark);
        }
        Err(why) => solution.left_out.push(format!("energy and moments: {why}")),
    }
    Ok(solution)
}

/// The boundary that the settings ask for, and the number of separate places of overlap.
fn boundary(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    settings: &Settings,
    fine: &fabrikant::Settings,
) -> Result<(Approximation, usize), Unsolved> {
    let modulus = contact.modulus();
    let apart = Overlap::of(gap, depth)?.map_or(1, |overlap| overlap.components().len());
    if apart > 1 && settings.method == Method::Fabrikant {
        let reason = format!("the bodies overlap in {apart} separate places: one boundary cannot hold them");
        return Err(Unsolved::new(Verdict::NotStarShaped, reason));
    }
    let found = match (settings.method, settings.boundary) {
        (Method::Ritz, _) => solve(gap, modulus, depth, Family::Ellipse, fine),
        (_, BoundaryFamily::Auto) => auto(gap, modulus, depth, fine),
        (_, family) => solve(gap, modulus, depth, family_of(family), fine),
    };
    let found = found.map_err(verdict)?;
    let off = found.quadrature_error.iter().sum::<f64>();
    if !(off <= settings.tolerance) {
        let reason =
            format!("relative error {off:.1e} of the quadrature reached; the tolerance is {:.1e}", settings.tolerance);
        return Err(Unsolved::new(Verdict::ToleranceNotReached, reason));
    }
    if found.family == Family::Stationary {
        // The pressure under a disc is exact, so that its force is too low: a stationary boundary with less, by more than may
        // be wrong with either, is the wrong one.
        let rough = fabrikant::Settings { tolerance: 1e-4, boundary_points: 0, ..*fine };
        if let Ok(disc) = ritz::circle_near(gap, modulus, depth, &rough, &found)
            && disc.force * (1.0 - disc.quadrature_error.iter().sum::<f64>())
                > found.force * (1.0 + off + settings.tolerance)
        {
            let reason = format!(
                "the stationary boundary found has the force {:e}, but a disc alone holds {:e}: it is not the largest",
                found.force, disc.force
            );
            return Err(Unsolved::new(Verdict::NoStationaryBoundary, reason));
        }
    }
    Ok((found, apart))
}

fn verdict(error: Error) -> Unsolved {
    match error {
        Error::Unsolved(unsolved) => unsolved,
        Error::Input(input) => Unsolved::new(Verdict::NotApplicable, input.to_string()),
    }
}

fn family_of(boundary: BoundaryFamily) -> Family {
    match boundary {
        BoundaryFamily::Stationary | BoundaryFamily::Auto => Family::Stationary,
        BoundaryFamily::Ellipse => Family::Ellipse,
        BoundaryFamily::Circle => Family::Circle,
        BoundaryFamily::PlanForm => Family::PlanForm,
        BoundaryFamily::Fourier(order) => Family::Fourier(order),
    }
}

fn dimensional(contact: &Contact, depth: f64, tilt: [f64; 2], settings: &Settings, found: Approximation) -> Solution {
    let reference = contact.gap().known().reference;
    let polyline = found.boundary.polyline();
    let max_radius = polyline.iter().map(|p| (p[0] - reference[0]).hypot(p[1] - reference[1])).fold(0.0, f64::max);
    let mut remarks = vec![format!("boundary: {:?}", found.family)];
    if !found.why.is_empty() {
        remarks.push(found.why.clone());
    }
    match found.lower_bound {
        Some(bound) => {
            remarks.push(format!("the force is at least {:e}: the pressure under the ellipse is exact", bound.force()))
        }
        None => remarks.push("the force is an estimate, neither an upper nor a lower bound".to_owned()),
    }
    let [over_angle, along_rays] = found.quadrature_error;
    remarks.push(format!("relative error of the quadrature: {:.1e}", over_angle + along_rays));
    let mut left_out =
        vec!["the surface grid and the pressure on it: the method gives the force and the patch".to_owned()];
    if !settings.outputs.patch {
        left_out.push("the boundary as a polyline".to_owned());
    }
    let extent = Rect::holding(polyline.iter().copied()).map(|rect| [rect.min, rect.max]);
    let piece =
        |extent| Piece { area: found.area, force: found.force, centroid: found.centroid, extent, max_pressure: None };
    // The few points of a boundary that is not asked for do not bound it.
    let pieces = extent.filter(|_| settings.outputs.patch).map(piece).into_iter().collect();
    let validity = Validity::of(contact, std::slice::from_ref(&polyline), found.area, found.force);
    Solution {
        method: settings.method,
        origin: Origin::Approximate,
        turned: None,
        grid: None,
        depth,
        tilt,
        force: found.force,
        force_error: None,
        depth_error: Some(0.0),
        map_error: None,
        samples: None,
        stiffness_error: None,
        energy_error: None,
        area_error: None,
        bracket: None,
        depth_bracket: None,
        moment_bracket: None,
        tilt_bracket: None,
        stiffness: found.stiffness,
        stiffness_matrix: None,
        moment: None,
        energy: None,
        patch: Patch {
            area: found.area,
            centroid: Some(found.centroid),
            regions: 1,
            max_radius,
            pieces,
            semi_axes: None,
            angle: None,
            boundary: settings.outputs.patch.then(|| vec![polyline]),
        },
        pressure: PressureSummary { mean: Some(found.force / found.area), ..PressureSummary::default() },
        residuals: None,
        touches_edge: None,
        validity,
        cost: Cost { unknowns: found.rays, iterations: found.iterations, ..Cost::default() },
        left_out,
        remarks,
    }
}
