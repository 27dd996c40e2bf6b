//! The closed form of whatever the gap turns out to be.

use crate::Contact;
use crate::clock::Deadline;
use crate::closed_form::{ClosedForm, FlatPunch, Hertz, Power, Quadratic, Sneddon, Sphere};
use crate::error::{InputError, Unsolved, Verdict};
use crate::gap::{AnyGap, Gap, Reach, extent};
use crate::geometry::Rect;
use crate::grid::{Grid, Pressure};
use crate::homogeneity::{self, Degree};
use crate::material::EffectiveModulus;
use crate::recognise::{Recognised, recognise};
use crate::settings::{Method, Settings};
use crate::solution::{Cost, Origin, Patch, PressureSummary, Solution};

/// A closed form and what it stands for.
#[derive(Debug, Clone)]
pub struct Formula {
    /// Force, stiffness, patch, pressure in the user's frame.
    pub contact: ClosedForm,
    /// What the gap was recognised as, in words.
    pub found: String,
    /// What that made unnecessary, in words.
    pub left_out: Vec<String>,
}

/// The contact at this depth (and tilt: pass a [`crate::gap::Tilted`] gap); `Ok(None)` when the bodies do not touch.
///
/// # Errors
/// `NoClosedForm` when the gap is none of the known shapes or its contact not one of theirs; `Unbounded` when it has no end.
pub fn at_depth(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    deadline: Deadline,
) -> Result<Option<Formula>, Unsolved> {
    let reach = match extent(gap, depth) {
        Reach::Within(reach) => reach,
        Reach::Nowhere => return Ok(None),
        Reach::Unbounded | Reach::Unknown => {
            return Err(Unsolved::new(Verdict::Unbounded, "the gap stays below the depth however far one looks"));
        }
    };
    let refused = |e: InputError| Unsolved::new(Verdict::NoClosedForm, e.to_string());
    let no_grid = "the grid: no cell is needed".to_owned();
    match recognise(gap, depth, &reach) {
        Recognised::Quadratic { centre, lowest, curvatures: [a, b], rotation } => {
            let (sin, cos) = rotation.sin_cos();
            let form = Quadratic {
                xx: 0.5 * (a * cos * cos + b * sin * sin),
                xy: (a - b) * sin * cos,
                yy: 0.5 * (a * sin * sin + b * cos * cos),
            };
            let round = (a - b).abs() <= 1e-12 * b;
            // In principal axes the small curvature keeps its digits; the turn is put back afterwards.
            let hertz =
                if round { Hertz::of_quadratic(modulus, form) } else { Hertz::new(modulus, [1.0 / a, 1.0 / b]) };
            let contact = hertz.and_then(|h| h.at_depth(depth - lowest)).map_err(refused)?;
            let contact = contact.placed(centre, if round { 0.0 } else { rotation });
            let found = format!("a quadratic form with curvatures {a:.6e} and {b:.6e} (Hertz)");
            Ok(Some(Formula { contact: at(contact, depth), found, left_out: vec![no_grid] }))
        }
        Recognised::FlatEllipse { centre, lowest, slope, semi_axes, rotation } => {
            let punch = FlatPunch::ellipse(modulus, semi_axes).map_err(refused)?;
            let (sin, cos) = rotation.sin_cos();
            let tilt = [-cos * slope[0] - sin * slope[1], sin * slope[0] - cos * slope[1]];
            let contact = punch.at_tilted_depth(depth - lowest, tilt)?.placed(centre, rotation);
            let found = format!("a flat ellipse with semi-axes {:.6e} and {:.6e}", semi_axes[0], semi_axes[1]);
            Ok(Some(Formula { contact: at(contact, depth), found, left_out: vec![no_grid] }))
        }
        Recognised::Revolution { centre } => {
            // Past the deadline integrals are not numbers, whatever verdict that leads to.
            let found = revolution(gap, modulus, depth, centre, &reach, deadline);
            found.map(Some).map_err(|e| deadline.check().err().unwrap_or(e))
        }
        Recognised::General => {
            let reason = "the gap is neither quadratic, nor of revolution, nor a flat ellipse";
            Err(Unsolved::new(Verdict::NoClosedForm, reason))
        }
    }
}

/// A form counts depth from its own first touch; the user from the reference point of the gap.
fn at(mut contact: ClosedForm, depth: f64) -> ClosedForm {
    contact.depth = depth;
    contact
}

fn revolution(
    gap: &AnyGap,
    modulus: EffectiveModulus,
    depth: f64,
    centre: [f64; 2],
    reach: &Rect,
    deadline: Deadline,
) -> Result<Formula, Unsolved> {
    let refused = |e: InputError| Unsolved::new(Verdict::NoClosedForm, e.to_string());
    let lowest = gap.gap(centre[0], centre[1]);
    if let Some(Degree::Power(n)) = homogeneity::degree(gap, reach).filter(|_| gap.centre() == centre) {
        let r = 0.5 * reach.size()[0];
        let coefficient = gap.gap(centre[0] + r, centre[1]) / r.powf(n);
        if let Ok(power) = Power::new(modulus, coefficient, n) {
            let contact = power.at_depth(depth).map_err(refused)?.placed(centre, 0.0);
            let found = format!("a power law {coefficient:.6e} r^{n}");
            let left_out = vec!["the grid: no cell is needed".to_owned()];
            return Ok(Formula { contact: at(contact, depth), found, left_out });
        }
    }
    if let Some(radius) = sphere_radius(gap, centre, lowest, 0.5 * reach.size()[0], depth - lowest) {
        let contact = Sphere::new(modulus, radius).and_then(|s| s.at_depth(depth - lowest)).map_err(refused)?;
        let found = format!("a sphere of radius {radius:.6e}");
        let left_out = vec!["the grid: no cell is needed".to_owned()];
        return Ok(Formula { contact: at(contact.placed(centre, 0.0), depth), found, left_out });
    }
    let mut kinks = Vec::new();
    gap.ray_kinks(centre, [1.0, 0.0], &mut kinks);
    kinks.retain(|&r| r.is_finite() && r > 0.0);
    let farthest = reach.corners().map(|[x, y]| (x - centre[0]).hypot(y - centre[1])).into_iter().fold(0.0, f64::max);
    let rim = end_of_material(gap, centre, farthest);
    let (own, [x, y]) = (gap.clone(), centre);
    let has_slope = (1..8).all(|k| gap.gradient(x + farthest * 0.1 * f64::from(k), y).is_some());
    let sneddon = if has_slope {
        let slope = move |r: f64| own.gradient(x + r, y).map_or(f64::NAN, |g| g[0]);
        Sneddon::new(modulus, slope, &kinks, rim)
    } else {
        Sneddon::of_gap(modulus, move |r: f64| own.gap(x + r, y) - lowest, &kinks, rim)
    };
    let contact = sneddon.map_err(refused)?.before(deadline).at_depth(depth - lowest)?.placed(centre, 0.0);
    Ok(Formula {
        contact: at(contact, depth),
        found: "a gap of revolution whose contact is a disc (Sneddon 1965)".to_owned(),
        left_out: vec!["the surface grid: two integrals along the radius are enough".to_owned()],
    })
}

/// R of a gap of revolution that is R - sqrt(R^2 - r^2), as far as the contact can reach.
fn sphere_radius(gap: &dyn Gap, [x, y]: [f64; 2], lowest: f64, reach: f64, overlap: f64) -> Option<f64> {
    let profile = |r: f64| gap.gap(x + r, y) - lowest;
    // (R - g)^2 = R^2 - r^2.
    let g = profile(0.5 * reach);
    let radius = 0.5 * (0.25 * reach * reach / g + g);
    let off = |k: i32| {
        let rho = reach * f64::from(k) / 64.0 / radius;
        let sphere = radius * rho * rho / (1.0 + ((1.0 - rho) * (1.0 + rho)).max(0.0).sqrt());
        (profile(reach * f64::from(k) / 64.0) - sphere).abs()
    };
    // The rim of a whole ball, where the slope has no end, is left to rounding.
    let round = reach <= radius * (1.0 + 1e-12) && (0..64).all(|k| off(k) <= 1e-12 * overlap);
    (radius.is_finite() && round).then_some(radius)
}

/// Radius at which the material ends, infinite when it does not within the reach.
fn end_of_material(gap: &dyn Gap, [x, y]: [f64; 2], farthest: f64) -> f64 {
    let solid = |r: f64| gap.gap(x + r, y) < f64::INFINITY;
    let (mut inside, mut outside) = (0.0, 2.0 * farthest);
    if solid(outside) {
        return f64::INFINITY;
    }
    loop {
        let middle = 0.5 * (inside + outside);
        if middle <= inside || middle >= outside {
            return inside;
        }
        if solid(middle) { inside = middle } else { outside = middle }
    }
}

/// The state at a depth and tilt (`gap` is the contact's gap under that tilt), in the user's units.
///
/// # Errors
/// As [`at_depth`].
pub(crate) fn solution(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let Some(Formula { contact: form, found, mut left_out }) =
        at_depth(gap, contact.modulus(), depth, settings.deadline)?
    else {
        return Ok(Solution::apart(Method::ClosedForm, depth, tilt));
    };
    let ellipse = form.patch;
    let outputs = settings.outputs;
    let reference = contact.gap().reference();
    let [a, b] = ellipse.semi_axes;
    let boundary = ellipse.boundary(BOUNDARY_POINTS);
    let farthest = boundary.iter().map(|p| (p[0] - reference[0]).hypot(p[1] - reference[1])).fold(0.0, f64::max);
    if !outputs.patch {
        left_out.push("the boundary as a polyline".to_owned());
    }
    if !outputs.pressure {
        left_out.push("the pressure field".to_owned());
    }
    let [x, y] = form.line_of_action();
    let stiffness = form.stiffness_with_tilt();
    let cells = settings.cells.unwrap_or(FIELD_CELLS);
    let max = form.max_pressure();
    let mut solution = Solution {
        method: Method::ClosedForm,
        origin: Origin::ClosedForm,
        grid: None,
        depth,
        tilt,
        force: form.force,
        force_error: Some(form.error),
        bracket: None,
        depth_bracket: None,
        stiffness: form.stiffness,
        stiffness_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| stiffness[(i, j)]))),
        moment: Some([form.force * y, -form.force * x]),
        energy: Some(form.energy()),
        patch: Patch {
            area: ellipse.area(),
            centroid: Some(ellipse.centre),
            regions: 1,
            max_radius: if ellipse.centre == reference { a.max(b) } else { farthest },
            boundary: outputs.patch.then(|| vec![boundary]),
        },
        pressure: PressureSummary {
            max: max.filter(|p| p.is_finite()),
            mean: Some(form.mean_pressure()),
            at: Some(ellipse.centre),
            field: None,
            gap: None,
        },
        residuals: None,
        cost: Cost::default(),
        left_out,
        remarks: vec![format!("the gap is {found}")],
    };
    // Past the deadline a pressure is not a number.
    if max.is_some_and(f64::is_nan) {
        settings.deadline.check().map_err(|e| e.with_best(solution.clone()))?;
    }
    if outputs.pressure {
        match sampled(&form, cells, settings.deadline) {
            Ok(field) => (solution.grid, solution.pressure.field) = (Some(field.grid), Some(field)),
            Err(out_of_time) => return Err(out_of_time.with_best(solution)),
        }
    }
    Ok(solution)
}

/// Points of the boundary of a closed form.
const BOUNDARY_POINTS: usize = 128;

/// Cells along the longer side of the field of a closed form.
const FIELD_CELLS: usize = 64;

/// The pressure of a formula at the centres of cells over its patch; where it is infinite, the mean of the neighbourhood
/// is not defined either and the largest finite value stands.
fn sampled(form: &ClosedForm, cells: usize, deadline: Deadline) -> Result<Pressure, Unsolved> {
    let outline = Rect::holding(form.patch.boundary(4 * BOUNDARY_POINTS)).expect("an ellipse has points");
    let grid = Grid::over(&outline, crate::domain::shape(&outline, cells));
    // On a disc, cells at the same distance share one integral: whole numbers of half cells from the middle, in order.
    let round = form.patch.semi_axes[0] == form.patch.semi_axes[1] && grid.shape[0] == grid.shape[1];
    let from_middle = |i: usize| (2 * i + 1).abs_diff(grid.shape[0]);
    let mut known = std::collections::HashMap::new();
    let values: Result<Vec<f64>, Unsolved> = (0..grid.len())
        .map(|k| {
            deadline.check()?;
            let [x, y] = grid.centre_of(k);
            let [i, j] = [k % grid.shape[0], k / grid.shape[0]].map(from_middle);
            let at = if round { (i.max(j), i.min(j)) } else { (k, 0) };
            Ok(*known.entry(at).or_insert_with(|| form.pressure(x, y)))
        })
        .collect();
    let mut values = values?;
    let highest = values.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
    values.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = highest);
    Ok(Pressure { grid, values })
}
