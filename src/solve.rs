//! One call for every method and every loading.

use std::time::Instant;

use crate::bracketed::with_bracket;
use crate::by_grid::{Frame, Held};
use crate::contact::{Contact, Load};
use crate::edges;
use crate::equilibrium::{self, Respond};
use crate::error::{Unsolved, Verdict};
use crate::extrapolate::Intercept;
use crate::gap::{AnyGap, Gap, Reach, Tilted, extent, least};
use crate::geometry::Rect;
use crate::homogeneity::{self, Degree};
use crate::settings::{Method, Outputs, Settings};
use crate::solution::{Cost, Solution};
use crate::{by_approximation, by_formula, by_grid};

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
    if settings.outputs.bracket {
        solution = with_bracket(contact, load, solution, settings)?;
    }
    solution.cost.seconds = started.elapsed().as_secs_f64();
    let lost = solution.force == 0.0 && solution.stiffness > 0.0;
    if lost || !solution.force.is_finite() || !solution.stiffness.is_finite() {
        let reason = "the force or the stiffness is beyond the range of numbers (1e-308 to 1e308): choose other units";
        return Err(Unsolved::new(Verdict::NotApplicable, reason));
    }
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
    // One state alone serves no other.
    let several = contact.loading().loads().len() > 1 && state.force > 0.0;
    if let Some(inverse_degree) = several.then(|| inverse_degree(contact.gap(), depth)).flatten() {
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
    /// The grid that all tilts share, and the cells along its longer side.
    frame: Frame,
    cells: usize,
    /// The last full grid of an untilted contact.
    held: Option<Held<'a>>,
    /// Of all states so far.
    spent: Cost,
}

impl<'a> Engine<'a> {
    fn new(contact: &'a Contact, settings: &'a Settings, with_matrix: bool) -> Self {
        let coarsest = (2.0 / settings.tolerance.sqrt()).clamp(32.0, 512.0) as usize;
        let cells = settings.cells.unwrap_or(coarsest);
        Self { contact, settings, with_matrix, frame: Frame::new(), cells, held: None, spent: Cost::default() }
    }

    /// The state by a method without a grid; `None` when it takes a grid.
    fn without_grid(&self, depth: f64, tilt: [f64; 2]) -> Option<Result<Solution, Unsolved>> {
        let settings = self.settings;
        match settings.method {
            Method::Ritz | Method::Fabrikant | Method::ClosedForm => {
                Some(respond(self.contact, depth, tilt, settings, self.with_matrix))
            }
            Method::Auto if settings.cells.is_none() && !settings.outputs.gap => {
                let formula = Settings { method: Method::ClosedForm, ..*settings };
                match respond(self.contact, depth, tilt, &formula, self.with_matrix) {
                    Err(e) if e.verdict == Verdict::NoClosedForm => None,
                    answered => Some(answered),
                }
            }
            _ => None,
        }
    }

    /// On a grid, without tilt: a coarse one when that is enough, the cells of the last full one when the contact stays on them.
    fn upright(&mut self, depth: f64, quick: bool) -> Result<Solution, Unsolved> {
        let apart = || Ok(Solution::apart(self.settings.method, depth, [0.0; 2]));
        let rough = Settings { outputs: Outputs::default(), ..*self.settings };
        if by_grid::on_several_grids(self.contact, depth, self.settings) {
            let rough = Settings { tolerance: ROUGH, ..rough };
            return respond(self.contact, depth, [0.0; 2], if quick { &rough } else { self.settings }, false);
        }
        if quick {
            let found = Held::roughly(self.contact, depth, &rough)?;
            return found.map_or_else(apart, |held| Ok(held.solution(self.contact, &rough)));
        }
        let moved = match &self.held {
            Some(held) if self.settings.method != Method::Qp => held.moved(self.contact, depth, self.settings)?,
            _ => None,
        };
        self.held = match moved {
            Some(moved) => Some(moved),
            None => Held::at_depth(self.contact, depth, self.settings)?,
        };
        self.held.as_ref().map_or_else(apart, |held| Ok(held.solution(self.contact, self.settings)))
    }
}

/// Relative error of the force that the search for equilibrium begins with.
const ROUGH: f64 = 0.02;

impl Respond for Engine<'_> {
    fn respond(&mut self, depth: f64, tilt: [f64; 2], quick: bool) -> Result<Solution, Unsolved> {
        let mut state = match self.without_grid(depth, tilt) {
            Some(answered) => answered?,
            None if !self.with_matrix => self.upright(depth, quick)?,
            None => {
                // One grid for all tilts: what differs from one to the next would be noise to Newton's method.
                let gap = tilted(self.contact, tilt);
                let frame = &mut self.frame;
                match by_grid::separately(self.contact, &gap, depth, tilt, self.settings)? {
                    Some(apart) => apart,
                    None => by_grid::in_frame(self.contact, &gap, depth, tilt, self.settings, self.cells, frame)?,
                }
            }
        };
        self.spent.iterations += state.cost.iterations;
        self.spent.operator_products += state.cost.operator_products;
        self.spent.steps += 1;
        state.cost = Cost { unknowns: state.cost.unknowns, ..self.spent };
        Ok(state)
    }
}

/// The gap of the contact under a tilt.
fn tilted(contact: &Contact, tilt: [f64; 2]) -> AnyGap {
    match tilt {
        [0.0, 0.0] => contact.gap().clone(),
        tilt => AnyGap::new(Tilted::new(contact.gap().clone(), tilt)),
    }
}

fn at_force(
    contact: &Contact,
    force: f64,
    settings: &Settings,
    similar: &mut Option<Similar>,
) -> Result<Solution, Unsolved> {
    let gap = contact.gap();
    let (_, least) = least(&**gap);
    if force < 0.0 {
        return Err(Unsolved::new(
            Verdict::NoEquilibrium,
            format!("the force {force:e} pulls; a contact can only push"),
        ));
    }
    if force == 0.0 {
        return Ok(Solution::apart(settings.method, least, [0.0; 2]));
    }
    if let Some(scaled) = similar.as_ref().and_then(|s| s.at(gap, s.depth_for(force))) {
        return Ok(Solution { force, ..scaled });
    }
    let guess = equilibrium::overlap_of_size(gap, contact.modulus().e_star(), force);
    // The law of a homogeneous gap is exact: one state serves every force.
    if similar.is_none()
        && let Some(inverse_degree) = inverse_degree(gap, least + guess)
    {
        let state = respond(contact, least + guess, [0.0; 2], settings, false)?;
        let all = Similar { state, inverse_degree };
        if let Some(scaled) = Some(&all).filter(|s| s.state.force > 0.0).and_then(|s| s.at(gap, s.depth_for(force))) {
            *similar = Some(all);
            return Ok(Solution { force, ..scaled });
        }
    }
    let mut engine = Engine::new(contact, settings, false);
    equilibrium::under_force(&mut engine, force, least, guess, |method| close(settings, method))
}

/// A box around everything that can touch at any tilt: where the gap is less than a depth beyond all measure.
fn material(gap: &AnyGap, depth: f64) -> Option<Rect> {
    let (_, least) = least(&**gap);
    match gap.reach(least + 1e12 * (depth - least)) {
        Reach::Within(rect) => Some(rect),
        _ => None,
    }
}

/// Relative miss of the load that is left to the last linear step; what a method without a grid answers is a law without noise.
fn close(settings: &Settings, method: Method) -> f64 {
    match method {
        Method::ClosedForm => 1e-12,
        Method::Ritz | Method::Fabrikant => 3e-3 * settings.tolerance,
        _ => 0.3 * settings.tolerance,
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
    let through = [-moment[1] / force, moment[0] / force];
    if let Some(material) = material(contact.gap(), upright.depth)
        && !material.contains(through)
    {
        let (a, b) = (material.min, material.max);
        let reason = format!(
            "the line of action meets the surface at ({:e}, {:e}), outside of all material, [{:e}, {:e}] x [{:e}, {:e}]",
            through[0], through[1], a[0], b[0], a[1], b[1]
        );
        return Err(Unsolved::new(Verdict::NoEquilibrium, reason));
    }
    let size = (upright.patch.area / std::f64::consts::PI).sqrt();
    // The last linear step of a force-driven solve has no place here: the state is solved anew at every tilt.
    let mut engine = Engine::new(contact, settings, true);
    let close = |method: Method| match method {
        // Rounding in the force of a deep state is what is left.
        Method::ClosedForm => 1e-11,
        _ => 0.01 * settings.tolerance,
    };
    let mut state = equilibrium::under_moment(&mut engine, force, moment, upright, size, close)?;
    let enough = |state: &Solution| state.force_error.is_none_or(|error| error <= settings.tolerance);
    if settings.cells.is_none() && engine.frame.sharp && !enough(&state) {
        let balance =
            |engine: &mut Engine, start: Solution| equilibrium::under_moment(engine, force, moment, start, size, close);
        return at_sharp_edges(&mut engine, state, settings, &balance);
    }
    while settings.cells.is_none() && state.force_error.is_some_and(|error| error > settings.tolerance) {
        if engine.cells >= FINEST {
            let reason = format!(
                "relative error {:.1e} reached with {} cells along the longer side; the tolerance is {:.1e}",
                state.force_error.unwrap_or(f64::NAN),
                engine.cells,
                settings.tolerance
            );
            return Err(Unsolved::new(Verdict::ToleranceNotReached, reason));
        }
        engine.cells *= 2;
        state = equilibrium::under_moment(&mut engine, force, moment, state, size, close)?;
    }
    Ok(state)
}

/// A punch balanced on many grids, and the limit of what they give; see [`edges`].
fn at_sharp_edges(
    engine: &mut Engine,
    mut state: Solution,
    settings: &Settings,
    balance: &dyn Fn(&mut Engine, Solution) -> Result<Solution, Unsolved>,
) -> Result<Solution, Unsolved> {
    // The grids tell the error together.
    engine.frame.alone = false;
    let (mut spacings, mut found) = (Vec::new(), Vec::new());
    let mut reached = f64::INFINITY;
    for cells in (0..).map(edges::cells).take_while(|&n| n <= edges::FINEST / 2) {
        engine.cells = cells;
        state = balance(engine, state)?;
        spacings.push(engine.frame.spacing);
        let matrix = state.stiffness_matrix.unwrap_or([[f64::NAN; 3]; 3]);
        let scalars = [state.depth, state.tilt[0], state.tilt[1], state.energy.unwrap_or(f64::NAN), state.patch.area];
        found.push(scalars.into_iter().chain(matrix.into_iter().flatten()).collect::<Vec<f64>>());
        let Some(line) = Intercept::new(&spacings) else { continue };
        let limit = |of: &dyn Fn(&[f64]) -> f64| line.of(&found.iter().map(|values| of(values)).collect::<Vec<_>>());
        // To first order, the force at any depth and tilts is off by as much as this is.
        let [k, kx, ky] = matrix[0];
        reached = limit(&|values| k * values[0] + kx * values[1] + ky * values[2]).error / state.force;
        if reached > settings.tolerance {
            continue;
        }
        let at = |n: usize| limit(&|values| values[n]).value;
        (state.depth, state.tilt, state.energy) = (at(0), [at(1), at(2)], Some(at(3)));
        state.patch.area = at(4);
        state.pressure.mean = Some(state.force / state.patch.area);
        let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| at(5 + 3 * i + j)));
        (state.stiffness, state.stiffness_matrix) = (matrix[0][0], Some(matrix));
        state.force_error = Some(reached);
        state.remarks.push(format!("sharp edges: the limit of {} grids, by a line", spacings.len()));
        return Ok(state);
    }
    let reason = format!(
        "relative error {reached:.1e} reached with {} cells along the longer side; the tolerance is {:.1e}",
        engine.cells, settings.tolerance
    );
    Err(Unsolved::new(Verdict::ToleranceNotReached, reason))
}

/// Cells along the longer side of the last grid that is tried for a tilting punch.
const FINEST: usize = 1024;

/// The state at a prescribed depth and tilt, by the method that the settings ask for.
pub(crate) fn respond(
    contact: &Contact,
    depth: f64,
    tilt: [f64; 2],
    settings: &Settings,
    with_matrix: bool,
) -> Result<Solution, Unsolved> {
    let grid = |gap: &AnyGap| by_grid::solution(contact, gap, depth, tilt, settings, with_matrix);
    let gap = tilted(contact, tilt);
    match settings.method {
        Method::ClosedForm => by_formula::solution(contact, &gap, depth, tilt, settings),
        Method::Qp | Method::Fft => grid(&gap),
        // A prescribed grid, or a gap field, is asked for by who wants a grid.
        Method::Auto if settings.cells.is_some() || settings.outputs.gap => grid(&gap),
        Method::Auto => match by_formula::solution(contact, &gap, depth, tilt, settings) {
            Err(e) if e.verdict == Verdict::NoClosedForm => grid(&gap),
            answered => answered,
        },
        Method::Ritz | Method::Fabrikant => {
            by_approximation::solution(contact, &gap, depth, tilt, settings, with_matrix)
        }
    }
}
