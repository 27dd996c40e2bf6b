//! One call for every method and every loading.

use std::time::Instant;

use crate::by_formula::{Formula, at_depth as formula};
use crate::closed_form::ClosedForm;
use crate::contact::{Contact, Load};
use crate::domain::Door;
use crate::equilibrium::{self, Respond};
use crate::error::{Unsolved, Verdict};
use crate::exact::{self, GridState, Refined};
use crate::gap::{AnyGap, Gap, Reach, Tilted, extent, lowest};
use crate::geometry::Rect;
use crate::grid::{Grid, Pressure};
use crate::homogeneity::{self, Degree};
use crate::patch;
use crate::settings::{Method, Outputs, Settings};
use crate::solution::{Cost, Patch, PressureSummary, Solution};

/// Solves every state of the loading, in order.
///
/// ```
/// use contact_patch::{Contact, EffectiveModulus, Loading, Settings, gap::Cone, solve};
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let contact = Contact::new(modulus, Cone::with_slope(1.0)?, Loading::depth(1.0))?;
/// let solution = solve(&contact, &Settings::default()).remove(0)?;
/// // Love 1939: P = 2 E* d^2/(pi tan(alpha)).
/// assert!((solution.force - 2.0 / std::f64::consts::PI).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solve(contact: &Contact, settings: &Settings) -> Vec<Result<Solution, Unsolved>> {
    let mut similar = None;
    contact.loading().loads().iter().map(|&load| at(contact, load, settings, &mut similar)).collect()
}

/// A solved state of a homogeneous gap, from which every other follows.
struct Similar {
    state: Solution,
    inverse_degree: f64,
}

impl Similar {
    /// The depth at which the force is this.
    fn depth_for(&self, force: f64) -> f64 {
        self.state.depth * (force / self.state.force).powf(1.0 / (1.0 + self.inverse_degree))
    }

    /// The state at this depth, when the gap is homogeneous as far as its contact there can reach.
    fn at(&self, gap: &AnyGap, depth: f64) -> Option<Solution> {
        let Reach::Within(reach) = extent(gap, depth) else { return None };
        let degree = homogeneity::degree(gap, &reach)?;
        (degree.inverse() == self.inverse_degree).then(|| {
            let mut state = self.state.at_other_depth(depth, gap.centre(), self.inverse_degree);
            state.left_out.push(format!(
                "another solve: the gap is homogeneous, and the state at depth {:e} serves all",
                self.state.depth
            ));
            state
        })
    }
}

fn at(contact: &Contact, load: Load, settings: &Settings, similar: &mut Option<Similar>) -> Result<Solution, Unsolved> {
    let started = Instant::now();
    let mut solution = match load {
        Load::Depth(depth) => at_depth(contact, depth, settings, similar)?,
        Load::Tilted { depth, tilt } => respond(contact, depth, tilt, settings, true)?,
        Load::Force(force) => at_force(contact, force, settings, similar)?,
        Load::ForceMoment { force, moment } => at_moment(contact, force, moment, settings)?,
    };
    solution.cost.seconds = started.elapsed().as_secs_f64();
    Ok(solution)
}

fn at_depth(
    contact: &Contact,
    depth: f64,
    settings: &Settings,
    similar: &mut Option<Similar>,
) -> Result<Solution, Unsolved> {
    if let Some(scaled) = similar.as_ref().and_then(|s| s.at(contact.gap(), depth)).filter(|_| depth > 0.0) {
        return Ok(scaled);
    }
    let state = respond(contact, depth, [0.0; 2], settings, false)?;
    if let Some(inverse_degree) = inverse_degree(contact.gap(), depth).filter(|_| state.force > 0.0) {
        *similar = Some(Similar { state: state.clone(), inverse_degree });
    }
    Ok(state)
}

/// 1/k of a gap that is homogeneous as far as the contact at this depth can reach.
fn inverse_degree(gap: &AnyGap, depth: f64) -> Option<f64> {
    match extent(gap, depth) {
        Reach::Within(reach) => homogeneity::degree(gap, &reach).map(Degree::inverse),
        _ => None,
    }
}

/// A contact and settings, as the search for equilibrium sees them.
struct Engine<'a> {
    contact: &'a Contact,
    settings: &'a Settings,
    with_matrix: bool,
}

impl Respond for Engine<'_> {
    fn respond(&mut self, depth: f64, tilt: [f64; 2], quick: bool) -> Result<Solution, Unsolved> {
        if !quick {
            return respond(self.contact, depth, tilt, self.settings, self.with_matrix);
        }
        let rough = Settings { tolerance: 0.02, cells: None, outputs: Outputs::default(), ..*self.settings };
        respond(self.contact, depth, tilt, &rough, false)
    }
}

fn at_force(
    contact: &Contact,
    force: f64,
    settings: &Settings,
    similar: &mut Option<Similar>,
) -> Result<Solution, Unsolved> {
    let gap = contact.gap();
    let [x, y] = lowest(&**gap, gap.centre());
    let least = gap.gap(x, y);
    if force < 0.0 {
        return Err(Unsolved::new(
            Verdict::NoEquilibrium,
            format!("the force {force:e} pulls; a contact can only push"),
        ));
    }
    if force == 0.0 {
        return Ok(apart(settings.method, least, [0.0; 2]));
    }
    if let Some(scaled) = similar.as_ref().and_then(|s| s.at(gap, s.depth_for(force))) {
        return Ok(Solution { force, ..scaled });
    }
    let mut engine = Engine { contact, settings, with_matrix: false };
    // Forces are of the size E* times length squared: begin with that length as overlap.
    let scale = (force / contact.modulus().e_star()).sqrt();
    let first = equilibrium::under_force(&mut engine, force, least, scale, close(settings))?;
    if let Some(inverse_degree) = inverse_degree(gap, first.depth).filter(|_| least == 0.0) {
        // The law is exact: take the force of the state that was solved and scale the rest of the way.
        let solved = respond(contact, first.depth, [0.0; 2], settings, false)?;
        let all = Similar { state: solved, inverse_degree };
        let depth = all.depth_for(force);
        let scaled = all.state.at_other_depth(depth, gap.centre(), inverse_degree);
        *similar = Some(all);
        return Ok(Solution { force, ..scaled });
    }
    Ok(first)
}

/// Relative miss of the load that is left to the last linear step.
fn close(settings: &Settings) -> f64 {
    match settings.method {
        Method::ClosedForm => 1e-12,
        _ => 0.05 * settings.tolerance,
    }
}

fn at_moment(contact: &Contact, force: f64, moment: [f64; 2], settings: &Settings) -> Result<Solution, Unsolved> {
    let upright = at_force(contact, force, settings, &mut None)?;
    if force == 0.0 {
        return if moment == [0.0; 2] {
            Ok(upright)
        } else {
            Err(Unsolved::new(Verdict::NoEquilibrium, "a moment without a force"))
        };
    }
    let size = (upright.patch.area / std::f64::consts::PI).sqrt();
    // The last linear step of a force-driven solve has no place here: the state is solved anew at every tilt.
    let mut engine = Engine { contact, settings, with_matrix: true };
    equilibrium::under_moment(&mut engine, force, moment, upright, size, 0.1 * settings.tolerance)
}

/// The state at a prescribed depth and tilt, by the method that the settings ask for.
pub(crate) fn respond(
    contact: &Contact,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let grid = |gap: &AnyGap| by_grid(contact, gap, depth, tilt, settings, with_matrix);
    let gap = match tilt {
        [0.0, 0.0] => contact.gap().clone(),
        tilt => AnyGap::new(Tilted::new(contact.gap().clone(), tilt)),
    };
    match settings.method {
        Method::ClosedForm => by_formula(contact, &gap, depth, tilt, settings),
        Method::Qp | Method::Fft => grid(&gap),
        // A prescribed grid, or a gap field, is asked for by who wants a grid.
        Method::Auto if settings.cells.is_some() || settings.outputs.gap => grid(&gap),
        Method::Auto => match by_formula(contact, &gap, depth, tilt, settings) {
            Err(e) if e.verdict == Verdict::NoClosedForm => grid(&gap),
            answered => answered,
        },
        Method::Ritz | Method::Fabrikant => todo!(),
    }
}

fn by_formula(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let Some(Formula { contact: form, found, mut left_out }) = formula(gap, contact.modulus(), depth)? else {
        return Ok(apart(Method::ClosedForm, depth, tilt));
    };
    let ellipse = form.patch;
    let outputs = settings.outputs;
    let reference = contact.gap().centre();
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
    Ok(Solution {
        method: Method::ClosedForm,
        depth,
        tilt,
        force: form.force,
        force_error: Some(form.error),
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
            max: form.max_pressure().filter(|p| p.is_finite()),
            mean: Some(form.mean_pressure()),
            at: Some(ellipse.centre),
            field: outputs.pressure.then(|| sampled(&form, settings.cells.unwrap_or(FIELD_CELLS))),
            gap: None,
        },
        residuals: None,
        cost: Cost::default(),
        left_out,
        remarks: vec![format!("the gap is {found}")],
    })
}

/// Points of the boundary of a closed form.
const BOUNDARY_POINTS: usize = 128;

/// Cells along the longer side of the field of a closed form.
const FIELD_CELLS: usize = 64;

/// The pressure of a formula at the centres of cells over its patch; where it is infinite, the mean of the neighbourhood
/// is not defined either and the largest finite value stands.
fn sampled(form: &ClosedForm, cells: usize) -> Pressure {
    let outline = Rect::holding(form.patch.boundary(4 * BOUNDARY_POINTS)).expect("an ellipse has points");
    let grid = Grid::over(&outline, crate::domain::shape(&outline, cells));
    let mut values: Vec<f64> = (0..grid.len())
        .map(|k| {
            let [x, y] = grid.centre_of(k);
            form.pressure(x, y)
        })
        .collect();
    let highest = values.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
    values.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = highest);
    Pressure { grid, values }
}

fn by_grid(
    contact: &Contact,
    gap: &AnyGap,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let method = if settings.method == Method::Qp { Method::Qp } else { Method::Fft };
    let Some(door) = Door::enter(gap, depth)? else {
        return Ok(apart(method, depth, tilt));
    };
    let degree = match extent(gap, depth) {
        Reach::Within(rect) => homogeneity::degree(gap, &rect),
        _ => None,
    };
    let refined = exact::refined(&door, settings, method, degree)?;
    let mut solution = dimensional(contact, &door, &refined, degree, depth, tilt, settings)?;
    if with_matrix {
        let unit = contact.modulus().e_star() * door.gap.length;
        let matrix = exact::stiffness_matrix(&refined.state, |p| door.gap.outward(p))?;
        solution.stiffness_matrix = Some(matrix.map(|row| row.map(|k| k * unit)));
    }
    Ok(solution)
}

/// The bodies do not touch.
fn apart(method: Method, depth: f64, tilt: [f64; 2]) -> Solution {
    Solution {
        method,
        depth,
        tilt,
        force: 0.0,
        force_error: Some(0.0),
        stiffness: 0.0,
        stiffness_matrix: Some([[0.0; 3]; 3]),
        moment: Some([0.0; 2]),
        energy: Some(0.0),
        patch: Patch::default(),
        pressure: PressureSummary { max: Some(0.0), ..PressureSummary::default() },
        residuals: None,
        cost: Cost::default(),
        left_out: vec!["everything: the bodies do not touch at this depth".to_owned()],
        remarks: Vec::new(),
    }
}

/// A solved grid in the user's units.
pub(crate) fn dimensional(
    contact: &Contact,
    door: &Door,
    refined: &Refined,
    degree: Option<Degree>,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
) -> Result<Solution, Unsolved> {
    let Refined { state, force, error } = refined;
    let (length, height, e_star) = (door.gap.length, door.gap.depth, contact.modulus().e_star());
    let unit_force = e_star * height * length;
    let stiffness = match degree {
        // P ~ d^(1 + 1/k).
        Some(degree) => (1.0 + degree.inverse()) * force / door.depth,
        None => exact::stiffness(state)?,
    };
    let grid = state.problem.grid;
    let values = &state.solution.pressure;
    let mut patch = patch::of(&state.problem, &state.solution, door.gap.inward(contact.gap().centre()));
    patch.area *= length * length;
    patch.max_radius *= length;
    patch.centroid = patch.centroid.map(|c| door.gap.outward(c));
    patch.boundary = if settings.outputs.patch {
        patch
            .boundary
            .map(|loops| loops.into_iter().map(|l| l.into_iter().map(|p| door.gap.outward(p)).collect()).collect())
    } else {
        None
    };
    let strongest = (0..grid.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    let unit_pressure = e_star * height / length;
    let outward_grid =
        Grid { origin: door.gap.outward(grid.origin), spacing: grid.spacing.map(|h| h * length), shape: grid.shape };
    let moment = moments(state, door).map(|m| m * unit_force);
    let pressure = PressureSummary {
        max: Some(values[strongest] * unit_pressure),
        mean: (patch.area > 0.0).then(|| force * unit_force / patch.area),
        at: Some(outward_grid.centre_of(strongest)),
        field: settings
            .outputs
            .pressure
            .then(|| Pressure { grid: outward_grid, values: values.iter().map(|p| p * unit_pressure).collect() }),
        gap: settings.outputs.gap.then(|| exact::gap_left(state).into_iter().map(|g| g * height).collect()),
    };
    Ok(Solution {
        method: state.method,
        depth,
        tilt,
        force: force * unit_force,
        force_error: Some(error / force),
        stiffness: stiffness * e_star * length,
        stiffness_matrix: None,
        moment: Some(moment),
        energy: Some(state.energy() * unit_force * height),
        patch,
        pressure,
        residuals: Some(state.solution.residuals),
        cost: Cost {
            seconds: 0.0,
            unknowns: state.solution.unknowns,
            iterations: state.iterations,
            operator_products: state.operator_products,
        },
        left_out: state.left_out.clone(),
        remarks: state.remarks.clone(),
    })
}

/// Mx = integral of p y, My = - integral of p x about the scene's origin, in units of force times the user's length.
fn moments(state: &GridState, door: &Door) -> [f64; 2] {
    let grid = &state.problem.grid;
    let area = grid.cell_area();
    state.solution.pressure.iter().enumerate().fold([0.0; 2], |[mx, my], (k, p)| {
        let [x, y] = door.gap.outward(grid.centre_of(k));
        [mx + p * area * y, my - p * area * x]
    })
}
