//! The closed form of whatever the gap turns out to be.

use std::f64::consts::{FRAC_PI_2, PI};

use super::inside_an_edge::holds;
use crate::clock::Deadline;
use crate::closed_form::{ClosedForm, Ellipse, FlatPunch, Hertz, Power, Quadratic, RoundedCone, Sneddon, Sphere};
use crate::gap::{self, AnyGap, Axis, Crown, Face, Gap, Generatrix};
use crate::grid::{Grid, Pressure};
use crate::numeric::geometry::{Rect, farthest};
use crate::numeric::scalar::{TO_THE_LAST_DIGIT, bisected};
use crate::overlap::Overlap;
use crate::problem::{Contact, EffectiveModulus, Method, Settings};
use crate::solution::{
    Cost, Origin, Patch, Piece, PressureSummary, Singular, Solution, TouchesEdge, Unsolved, Validity, Verdict,
};

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

/// The contact at this overlap.
///
/// # Errors
/// `NoClosedForm` when the gap is not known to be one of the shapes that have one, or its contact is not one of theirs;
/// `TimeLimit`.
pub(crate) fn of(overlap: &Overlap, modulus: EffectiveModulus, deadline: Deadline) -> Result<Formula, Unsolved> {
    let (known, depth) = (overlap.known(), overlap.depth);
    if let Some(form) = known.quadratic.and_then(|q| q.lowest().map(|lowest| q.about(lowest))) {
        return quadratic(&form, modulus, depth);
    }
    if let Some((face, semi_axes)) =
        known.face.as_ref().and_then(|face| face.outline.semi_axes().map(|axes| (face, axes)))
    {
        return flat_ellipse(face, semi_axes, modulus, depth);
    }
    if let Some(crown) = &known.crown
        && let Some(inside) = inside_an_edge(crown, modulus, depth)
    {
        return Ok(inside);
    }
    match known.axis {
        // Past the deadline integrals are not numbers, whatever verdict that leads to.
        Some(axis) => revolution(overlap, axis, modulus, deadline)
            .map_err(|e| deadline.check().map_or_else(Unsolved::from, |()| e)),
        None => {
            let reason = "the gap is not known to be quadratic, of revolution, or a flat ellipse";
            Err(Unsolved::new(Verdict::NoClosedForm, reason))
        }
    }
}

fn refused(error: impl std::fmt::Display) -> Unsolved {
    Unsolved::new(Verdict::NoClosedForm, error.to_string())
}

/// Roundings of a depth and of the lowest point of a gap.
const ROUNDINGS: f64 = 4.0 * f64::EPSILON;

/// A form counts depth from its own first touch; the user from the reference point of the gap. What that difference of large numbers
/// leaves of their digits enters the force by the exponent of the depth, d S/P.
fn formula(mut contact: ClosedForm, depth: f64, found: String, left_out: &str) -> Formula {
    let overlap = contact.depth;
    let exponent = contact.stiffness / contact.force * overlap;
    let lost = ROUNDINGS * (depth.abs() + (depth - overlap).abs()) / overlap;
    contact.error = contact.error.max(exponent * lost);
    contact.depth = depth;
    Formula { contact, found, left_out: vec![left_out.to_owned()] }
}

const NO_GRID: &str = "the grid: no cell is needed";

/// Hertz (1882) at any axis ratio; `form` is expanded about its lowest point.
fn quadratic(form: &gap::Quadratic, modulus: EffectiveModulus, depth: f64) -> Result<Formula, Unsolved> {
    let [xx, xy, yy] = form.hessian;
    // Principal curvatures. The determinant is shared by both: nothing is lost of the smaller one.
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let b = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    let a = ((xx * yy - xy * xy) / b).min(b);
    // The direction of the larger curvature is that of `turn`; the contact is longest across it.
    let rotation = if xy == 0.0 { if xx <= yy { 0.0 } else { FRAC_PI_2 } } else { turn + FRAC_PI_2 };
    let round = form.is_round() || (b - a).abs() <= 4.0 * f64::EPSILON * b;
    let hertz = if round {
        Hertz::of_quadratic(modulus, Quadratic { xx: 0.5 * xx, xy: 0.0, yy: 0.5 * xx })
    } else {
        // In principal axes the small curvature keeps its digits; the turn is put back afterwards.
        Hertz::new(modulus, [1.0 / a, 1.0 / b])
    };
    let contact = hertz.and_then(|h| h.at_depth(depth - form.value)).map_err(refused)?;
    let contact = contact.placed(form.about, if round { 0.0 } else { rotation });
    let found = format!("a quadratic form with curvatures {a:.6e} and {b:.6e} (Hertz)");
    Ok(formula(contact, depth, found, NO_GRID))
}

/// Hertz where the contact ends before the material does.
fn inside_an_edge(crown: &Crown, modulus: EffectiveModulus, depth: f64) -> Option<Formula> {
    let form = &crown.form;
    let found = quadratic(&form.about(form.lowest()?), modulus, depth).ok()?;
    holds(crown, &found.contact.patch).then_some(found)
}

fn flat_ellipse(face: &Face, semi_axes: [f64; 2], modulus: EffectiveModulus, depth: f64) -> Result<Formula, Unsolved> {
    let punch = FlatPunch::ellipse(modulus, semi_axes).map_err(refused)?;
    let ((sin, cos), slope) = (face.turn.sin_cos(), face.slope);
    let tilt = [-cos * slope[0] - sin * slope[1], sin * slope[0] - cos * slope[1]];
    let contact = punch.at_tilted_depth(depth - face.value, tilt).map_err(|e| refused(e.reason))?;
    let contact = contact.placed(face.at, face.turn);
    let found = format!("a flat ellipse with semi-axes {:.6e} and {:.6e}", semi_axes[0], semi_axes[1]);
    Ok(formula(contact, depth, found, NO_GRID))
}

fn revolution(
    overlap: &Overlap,
    axis: Axis,
    modulus: EffectiveModulus,
    deadline: Deadline,
) -> Result<Formula, Unsolved> {
    let (gap, depth, [x, y]) = (&overlap.gap, overlap.depth, axis.at);
    match axis.generatrix {
        Generatrix::Power { coefficient, exponent, lowest } => {
            let power = Power::new(modulus, coefficient, exponent).and_then(|p| p.at_depth(depth - lowest));
            let contact = power.map_err(refused)?.placed(axis.at, 0.0);
            let found = format!("a power law {coefficient:.6e} r^{exponent}");
            return Ok(formula(contact, depth, found, NO_GRID));
        }
        Generatrix::Sphere { radius, lowest } => {
            let sphere = Sphere::new(modulus, radius).and_then(|s| s.at_depth(depth - lowest)).map_err(refused)?;
            let found = format!("a sphere of radius {radius:.6e}");
            return Ok(formula(sphere.placed(axis.at, 0.0), depth, found, NO_GRID));
        }
        Generatrix::RoundedCone { radius, slope, lowest } => {
            let cone =
                RoundedCone::new(modulus, radius, slope).and_then(|c| c.at_depth(depth - lowest)).map_err(refused)?;
            let found = format!("a cone of slope {slope:.6e} with a tip of radius {radius:.6e}");
            return Ok(formula(cone.placed(axis.at, 0.0), depth, found, NO_GRID));
        }
        Generatrix::General => {}
    }
    // Drawn about its axis, radii keep their digits.
    let own = gap.about(axis.at);
    let lowest = own.gap(0.0, 0.0);
    if !(lowest < depth) {
        return Err(refused("the contact does not begin at the axis"));
    }
    let mut kinks = Vec::new();
    own.ray_kinks([0.0; 2], [1.0, 0.0], &mut kinks);
    kinks.retain(|&r| r.is_finite() && r > 0.0);
    // The rectangle holds a disc about the axis.
    let sides = [overlap.reach.min, overlap.reach.max];
    let farthest = sides.into_iter().flat_map(|c| [(c[0] - x).abs(), (c[1] - y).abs()]).fold(0.0, f64::max);
    let farthest = end_of_overlap(&own, depth, &mut kinks, farthest)?;
    let rim = end_of_material(&own, farthest);
    let has_slope = (1..8).all(|k| own.gradient(farthest * 0.1 * f64::from(k), 0.0).is_some());
    let sneddon = if has_slope {
        let slope = move |r: f64| own.gradient(r, 0.0).map_or(f64::NAN, |g| g[0]);
        Sneddon::new(modulus, slope, &kinks, rim)
    } else {
        Sneddon::of_gap(modulus, move |r: f64| own.gap(r, 0.0) - lowest, &kinks, rim)
    };
    let sneddon = sneddon.map_err(refused)?.overlapping_within(farthest).before(deadline);
    let contact = sneddon.at_depth(depth - lowest).map_err(|e| refused(e.reason))?;
    let found = "a gap of revolution whose contact is a disc (Sneddon 1965)".to_owned();
    let left_out = "the surface grid: two integrals along the radius are enough";
    Ok(formula(contact.placed(axis.at, 0.0), depth, found, left_out))
}

/// Halvings of a stretch of radii in which the gap may reach the depth.
const HALVINGS: u32 = 10;

/// How far from a kink, where the gap may jump, a stretch of radii ends, relative.
const BESIDE: f64 = 1e-12;

/// The radius up to which the bodies overlap around the axis, the origin.
///
/// # Errors
/// `NoClosedForm` where they may overlap again further out: whether they touch there no disc about the axis tells.
fn end_of_overlap(gap: &AnyGap, depth: f64, kinks: &mut [f64], farthest: f64) -> Result<f64, Unsolved> {
    kinks.sort_by(f64::total_cmp);
    let bounds = |[a, b]: [f64; 2]| {
        let along = Rect { min: [a, 0.0], max: [b, 0.0] };
        // Not enclosed: a look in the middle and at both ends.
        gap.bounds(&along, [0.0; 2]).unwrap_or_else(|| {
            let looks = [0.0, 0.5, 1.0].map(|share| gap.gap(a + share * (b - a), 0.0));
            [looks.into_iter().fold(f64::INFINITY, f64::min), looks.into_iter().fold(f64::NEG_INFINITY, f64::max)]
        })
    };
    let inner = kinks.iter().copied().filter(|r| *r < farthest);
    let ends: Vec<f64> = std::iter::once(0.0).chain(inner).chain([farthest]).collect();
    let mut end: Option<f64> = None;
    for pair in ends.windows(2) {
        let between = [pair[0] * (1.0 + BESIDE), pair[1] * (1.0 - BESIDE)];
        let mut left = if between[0] < between[1] { vec![(between, HALVINGS)] } else { Vec::new() };
        while let Some(([a, b], halvings)) = left.pop() {
            let [low, high] = bounds([a, b]);
            if low >= depth {
                end = end.or(Some(a));
            } else if high >= depth && halvings > 0 {
                let middle = 0.5 * (a + b);
                left.push(([middle, b], halvings - 1));
                left.push(([a, middle], halvings - 1));
            } else if end.is_some() {
                return Err(refused(format!(
                    "the bodies overlap again at r = {b:e}, beyond r = {:e}",
                    end.unwrap_or(a)
                )));
            }
        }
    }
    Ok(end.unwrap_or(farthest))
}

/// Radius around the origin at which the material ends, infinite when it does not within the reach.
fn end_of_material(gap: &AnyGap, farthest: f64) -> f64 {
    let solid = |r: f64| gap.gap(r, 0.0) < f64::INFINITY;
    let outside = 1.001 * farthest;
    if solid(outside) { f64::INFINITY } else { bisected(solid, [0.0, outside], TO_THE_LAST_DIGIT)[0] }
}

/// The state at an overlap under this tilt, in the user's units.
///
/// # Errors
/// As [`of`].
pub(crate) fn solution(
    contact: &Contact,
    overlap: &Overlap,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let depth = overlap.depth;
    let Formula { contact: form, found, mut left_out } = of(overlap, contact.modulus(), settings.deadline)?;
    let ellipse = form.patch;
    let outputs = settings.outputs;
    let reference = contact.gap().known().reference;
    let [a, b] = ellipse.semi_axes;
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
    let infinite = max.is_none() || max == Some(f64::INFINITY);
    let singular =
        infinite.then(|| if is_pointed(&overlap.gap, overlap, &ellipse) { Singular::Tip } else { Singular::Edge });
    // Without a tilt the slope of a quadratic form is largest at the end of an axis, and about an axis it is the same all round.
    let validity = Validity::of(contact, &[ellipse.boundary(8)], ellipse.area(), form.force);
    let mut solution = Solution {
        method: Method::ClosedForm,
        origin: Origin::ClosedForm,
        turned: None,
        grid: None,
        depth,
        tilt,
        force: form.force,
        force_error: Some(form.error),
        depth_error: Some(0.0),
        map_error: None,
        samples: None,
        stiffness_error: Some(form.error),
        energy_error: Some(form.error),
        area_error: Some(2.0 * form.error),
        bracket: None,
        depth_bracket: None,
        moment_bracket: None,
        tilt_bracket: None,
        stiffness: form.stiffness,
        stiffness_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| stiffness[(i, j)]))),
        moment: Some([form.force * y, -form.force * x]),
        energy: Some(form.energy()),
        patch: Patch {
            area: ellipse.area(),
            centroid: Some(ellipse.centre),
            regions: 1,
            max_radius: if ellipse.centre == reference {
                a.max(b)
            } else {
                farthest(&ellipse.boundary(BOUNDARY_POINTS), reference)
            },
            pieces: vec![Piece {
                area: ellipse.area(),
                force: form.force,
                centroid: ellipse.centre,
                extent: ellipse.extent(),
                max_pressure: max.filter(|p| p.is_finite()),
            }],
            semi_axes: Some(ellipse.semi_axes),
            angle: Some(if ellipse.is_disc() { 0.0 } else { axis_angle(&ellipse) }),
            boundary: outputs.patch.then(|| vec![ellipse.boundary(BOUNDARY_POINTS)]),
        },
        pressure: PressureSummary {
            max: max.filter(|p| p.is_finite()),
            max_error: max.filter(|p| p.is_finite()).map(|_| form.max_pressure_error()),
            singular,
            mean: Some(form.mean_pressure()),
            at: Some(if singular == Some(Singular::Edge) { highest_at(&form) } else { ellipse.centre }),
            field: None,
            gap: None,
        },
        residuals: None,
        touches_edge: touches_edge(&overlap.gap, &ellipse),
        validity,
        cost: Cost::default(),
        left_out,
        remarks: vec![format!("the gap is {found}")],
    };
    // Past the deadline a pressure is not a number.
    if max.is_some_and(f64::is_nan) {
        settings.deadline.check().map_err(|e| Unsolved::from(e).with_best(solution.clone()))?;
    }
    if outputs.pressure {
        match sampled(&form, cells, settings.deadline, ClosedForm::pressure) {
            Ok(field) => (solution.grid, solution.pressure.field) = (Some(field.grid), Some(field)),
            Err(out_of_time) => return Err(out_of_time.with_best(solution)),
        }
    }
    Ok(solution)
}

/// Whether the lowest point of a gap whose pressure is infinite is a tip: its slope does not fall towards it.
fn is_pointed(gap: &AnyGap, overlap: &Overlap, patch: &Ellipse) -> bool {
    let Some(axis) = overlap.known().axis else { return false };
    if let Generatrix::Power { exponent, .. } = axis.generatrix {
        return exponent <= 1.0;
    }
    let [x, y] = axis.at;
    let rise = |r: f64| (gap.gap(x + r, y) - gap.gap(x, y)) / r;
    let size = patch.semi_axes[0];
    rise(TIP * size) > 0.1 * rise(0.5 * size).abs()
}

/// Where a pressure that is infinite along a line is largest, as far as looks along a radius and around the rim tell.
fn highest_at(form: &ClosedForm) -> [f64; 2] {
    let patch = form.patch;
    let within = |p: &[f64; 2], share: f64| [0, 1].map(|m| patch.centre[m] + share * (p[m] - patch.centre[m]));
    let rim = patch.boundary(LOOKS);
    let along = (0..LOOKS).map(|k| within(&rim[0], k as f64 / LOOKS as f64));
    // On a disc all points of the rim are one.
    let points = if patch.is_disc() { 1 } else { rim.len() };
    let around = rim.iter().take(points).map(|p| within(p, 1.0 - 1e-9));
    let highest = along.chain(around).map(|p| (form.rough_pressure(p[0], p[1]), p)).filter(|(p, _)| !p.is_nan());
    highest.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(patch.centre, |(_, at)| at)
}

/// Looks along the radius, and around the rim.
const LOOKS: usize = 32;

/// Distance from the axis at which a tip shows, over the size of the contact.
const TIP: f64 = 1e-6;

/// The edge of data that the contact ends at.
fn touches_edge(gap: &AnyGap, patch: &Ellipse) -> Option<TouchesEdge> {
    let [cx, cy] = patch.centre;
    let beyond = |[x, y]: [f64; 2]| [cx + BEYOND * (x - cx), cy + BEYOND * (y - cy)];
    let edge = patch.boundary(16).into_iter().map(beyond).find_map(|[x, y]| gap.end_of_data(x, y))?;
    Some(TouchesEdge { edge, share: None })
}

/// How far outside of a boundary there may be no material for it to be an edge.
const BEYOND: f64 = 1.0 + 1e-9;

/// Angle of the longer axis in (-pi/2, pi/2].
fn axis_angle(patch: &Ellipse) -> f64 {
    let angle = patch.orientation.rem_euclid(PI);
    if angle > FRAC_PI_2 { angle - PI } else { angle }
}

/// Points of the boundary of a closed form.
pub(super) const BOUNDARY_POINTS: usize = 128;

/// Cells along the longer side of the field of a closed form.
const FIELD_CELLS: usize = 64;

/// The pressure of a formula at the centres of cells over its patch; where it is infinite, the mean of the neighbourhood
/// is not defined either and the largest finite value stands.
pub(super) fn sampled(
    form: &ClosedForm,
    cells: usize,
    deadline: Deadline,
    pressure: impl Fn(&ClosedForm, f64, f64) -> f64,
) -> Result<Pressure, Unsolved> {
    let outline = Rect::holding(form.patch.boundary(4 * BOUNDARY_POINTS)).expect("an ellipse has points");
    let grid = Grid::over(&outline, crate::grid::shape(&outline, cells));
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
            Ok(*known.entry(at).or_insert_with(|| pressure(form, x, y)))
        })
        .collect();
    let mut values = values?;
    let highest = values.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
    values.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = highest);
    Ok(Pressure { grid, values })
}
