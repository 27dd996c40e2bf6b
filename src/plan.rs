//! What a scene needs: the method, why, and what is left out, before anything is solved.

use std::fmt;

use crate::by_edges::{self, Route};
use crate::clock::Deadline;
use crate::closed_form::select;
use crate::discrete::Discrete;
use crate::discrete::symmetry::Symmetry;
use crate::gap::Degree;
use crate::grid::{Grid, Kernel, shape};
use crate::grid_method::domain::coarsest;
use crate::loading::axes::Axes;
use crate::loading::equilibrium::overlap_of_size;
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, Scaled, least};
use crate::problem::{Contact, Load, Method, Settings};
use crate::solution::{Unsolved, Verdict};

/// The decision and its reasons.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What would run; `None` when the bodies do not touch.
    pub method: Option<Method>,
    /// What would be done and why, in order.
    pub steps: Vec<String>,
    /// What the scene does not need.
    pub left_out: Vec<String>,
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "method: {}", self.method.map_or("none", Method::name))?;
        for step in &self.steps {
            writeln!(f, "  {step}")?;
        }
        for what in &self.left_out {
            writeln!(f, "left out: {what}")?;
        }
        Ok(())
    }
}

/// Plans a solve, by the detection that the solve itself would use.
///
/// ```
/// use contact_patch::gap::{AnyGap, Paraboloid, Place, Sum};
/// use contact_patch::{Contact, EffectiveModulus, Loading, Method, Settings, plan};
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// // Two crossed cylinders: their sum is known to be a quadratic form, so Hertz.
/// let cylinder = |radius| Paraboloid::new([radius, f64::INFINITY]);
/// let gap = Sum::new(vec![AnyGap::new(cylinder(0.02)?), cylinder(0.05)?.placed([0.0; 2], std::f64::consts::FRAC_PI_2)?])?;
/// let contact = Contact::new(modulus, gap, Loading::depth(1e-6))?;
/// assert_eq!(plan(&contact, &Settings::default())?.method, Some(Method::ClosedForm));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `Unbounded` when the overlap has no end.
pub fn plan(contact: &Contact, settings: &Settings) -> Result<Plan, Unsolved> {
    let Some(axes) = Axes::of(contact, settings) else { return along(contact, settings, Vec::new()) };
    let turned = along(&axes.inward(contact), settings, vec![axes.found()])?;
    // A closed form has axes of its own.
    if turned.method == Some(Method::ClosedForm) { along(contact, settings, Vec::new()) } else { Ok(turned) }
}

/// The plan along the axes of the contact, after these steps.
fn along(contact: &Contact, settings: &Settings, mut steps: Vec<String>) -> Result<Plan, Unsolved> {
    let loads = contact.loading().loads();
    let (depth, tilt) = probe(contact, loads, &mut steps);
    let gap = contact.tilted_gap(tilt);
    let Some(overlap) = Overlap::of(&gap, depth)? else {
        steps.push(format!("at depth {depth:e} the bodies do not touch: force 0"));
        return Ok(Plan { method: None, steps, left_out: vec!["everything".to_owned()] });
    };
    // The formula itself decides, as in the solve.
    let mut closed = select::of(&overlap, contact.modulus(), Deadline::NEVER);
    if by_edges::lifts_off(&gap, loads[0]) {
        closed = Err(Unsolved::new(Verdict::NoClosedForm, "a part of the edge of the flat ellipse lifts off"));
    }
    match &closed {
        Ok(form) => steps.push(format!("the gap is {}", form.found)),
        Err(why) => steps.push(format!("no closed form: {}", why.reason)),
    }
    if !overlap.certain {
        steps.push("the gap is known by its values alone: where it overlaps was searched".to_owned());
    }
    let (law, closed) = (gap.known().law, closed.is_ok());
    let upright = matches!(loads[0], Load::Depth(_) | Load::Force(_));
    let formula_first = closed && settings.method == Method::Auto;
    let route =
        if by_edges::is_asked_for(settings) && !formula_first { Route::of(&overlap, settings, !upright) } else { None };
    if let Some(route) = &route {
        steps.push(format!("the gap is {}", route.found()));
    }
    let degree = law.map(|law| law.degree);
    let mut left_out = Vec::new();
    match degree {
        Some(Degree::Power(k)) => {
            steps.push(format!("it is homogeneous of degree {k}: force ~ depth^{:.6}", 1.0 + 1.0 / k));
            if loads.len() > 1 {
                left_out.push(format!(
                    "{} of {} solves: one serves every depth and force",
                    loads.len() - 1,
                    loads.len()
                ));
            }
        }
        Some(Degree::Flat) => steps.push("its contact cannot grow: force ~ depth".to_owned()),
        None => {}
    }
    let method = chosen(settings, closed, route.as_ref(), &mut steps);
    match method {
        Method::ClosedForm | Method::EdgeFitted => left_out.push("the surface grid".to_owned()),
        Method::Ritz | Method::Fabrikant => {
            left_out.push(
                "the surface grid, the pressure field, moments: this method gives force, stiffness and patch"
                    .to_owned(),
            );
        }
        _ => grid_steps(&overlap.scaled(), settings, method, degree, &mut steps, &mut left_out),
    }
    let outputs = settings.outputs;
    let wanted = [
        (outputs.patch, "the boundary of the patch"),
        (outputs.pressure, "the pressure field"),
        (outputs.gap, "the gap field"),
        (outputs.bracket, "the bracket of the force"),
        (outputs.curve, "the force-depth curve"),
    ];
    left_out.extend(wanted.iter().filter(|(asked, _)| !asked).map(|(_, what)| format!("{what}: not asked for")));
    Ok(Plan { method: Some(method), steps, left_out })
}

/// A depth at which to look at the gap, and what the loading asks for.
fn probe(contact: &Contact, loads: &[Load], steps: &mut Vec<String>) -> (f64, [f64; 2]) {
    let count = if loads.len() > 1 {
        format!("{} states of loading; looked at the first: ", loads.len())
    } else {
        String::new()
    };
    match loads[0] {
        Load::Depth(depth) => {
            steps.push(format!("{count}depth {depth:e} is given"));
            (depth, [0.0; 2])
        }
        Load::Tilted { depth, tilt } => {
            steps.push(format!("{count}depth {depth:e} and tilt ({:e}, {:e}) are given", tilt[0], tilt[1]));
            (depth, tilt)
        }
        Load::Force(force) | Load::ForceMoment { force, .. } => {
            let what = if matches!(loads[0], Load::Force(_)) { "depth" } else { "depth and two tilts" };
            steps
                .push(format!("{count}force {force:e} is given: Newton's method for {what}, with the exact stiffness"));
            let gap = contact.gap();
            let overlap = overlap_of_size(gap, contact.modulus().e_star(), force, Deadline::NEVER);
            (least(gap).1 + overlap, [0.0; 2])
        }
    }
}

fn chosen(settings: &Settings, closed: bool, fitted: Option<&Route>, steps: &mut Vec<String>) -> Method {
    match (settings.method, fitted) {
        (Method::Auto, _) if settings.cells.is_some() => {
            steps.push("fft: the number of cells is prescribed, so a grid is wanted".to_owned());
            Method::Fft
        }
        (Method::Auto, _) if settings.outputs.gap => {
            steps.push("fft: the gap field is asked for, and formulas do not give it".to_owned());
            Method::Fft
        }
        (Method::Auto, _) if closed => {
            steps.push("closed form: exact, and the cheapest".to_owned());
            Method::ClosedForm
        }
        (Method::Auto, Some(route)) => {
            steps.push(format!("edge_fitted: {}", route.evidence()));
            Method::EdgeFitted
        }
        (Method::Auto, None) => {
            steps.push(
                "fft: no closed form, and faster than the quadratic programme at every number of cells".to_owned(),
            );
            Method::Fft
        }
        (prescribed, _) => {
            steps.push(format!("{}: prescribed", prescribed.name()));
            prescribed
        }
    }
}

fn grid_steps(
    scaled: &Scaled,
    settings: &Settings,
    method: Method,
    degree: Option<Degree>,
    steps: &mut Vec<String>,
    left_out: &mut Vec<String>,
) {
    let box_of = |rect: &Rect| {
        let (a, b) = (scaled.units.outward(rect.min), scaled.units.outward(rect.max));
        format!("[{:.6e}, {:.6e}] x [{:.6e}, {:.6e}]", a[0], b[0], a[1], b[1])
    };
    steps.push(format!(
        "box of overlap {}; coarse solves shrink it to the contact, the answer verifies it",
        box_of(&scaled.reach)
    ));
    match settings.cells {
        Some(cells) => steps
            .push(format!("{cells} cells along the longer side, prescribed; two coarser grids for the error estimate")),
        None => {
            // Means over cells alone give an energy that converges smoothly.
            let degree = degree.filter(|_| settings.kernel == Kernel::Galerkin);
            let how = match degree {
                Some(_) => "the energy of the grids, extrapolated",
                None => "the force of the last three grids",
            };
            steps.push(format!(
                "cells doubled from {} until the error of the force is below {:e}, by {how}; at sharp edges a line through many grids",
                coarsest(degree),
                settings.tolerance
            ));
        }
    }
    let grid = Grid::over(&scaled.reach, shape(&scaled.reach, 24));
    let problem = Discrete::sample(&scaled.gap, scaled.depth, grid, settings.kernel);
    let free = problem.overlap.iter().filter(|&&f| f <= 0.0).count();
    if free > 0 {
        left_out.push(format!("{:.0} % of the box: no overlap, no pressure", 100.0 * free as f64 / grid.len() as f64));
    }
    let symmetry = Symmetry::of(&problem);
    if symmetry.order() > 1 {
        steps.push(format!("symmetries of gap and grid: {}", symmetry.words()));
        if method == Method::Qp {
            left_out.push(format!("{} of {} unknowns, by symmetry", symmetry.order() - 1, symmetry.order()));
        }
    }
}
