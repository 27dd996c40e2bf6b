//! One call for every method and every loading.

use std::time::Instant;

use crate::bracketed::with_bracket;
use crate::contact::{Contact, Load};
use crate::equilibrium::{self, Respond};
use crate::error::{Unsolved, Verdict};
use crate::gap::{AnyGap, Gap, Reach, Tilted, extent, lowest};
use crate::geometry::Rect;
use crate::homogeneity::{self, Degree};
use crate::settings::{Method, Outputs, Settings};
use crate::solution::Solution;
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
    /// The box of the grid that all tilts share.
    frame: Option<Rect>,
}

impl Respond for Engine<'_> {
    fn respond(&mut self, depth: f64, tilt: [f64; 2], quick: bool) -> Result<Solution, Unsolved> {
        if quick {
            let rough = Settings { tolerance: 0.02, cells: None, outputs: Outputs::default(), ..*self.settings };
            return respond(self.contact, depth, tilt, &rough, false);
        }
        if !self.with_matrix {
            return respond(self.contact, depth, tilt, self.settings, false);
        }
        let method = self.settings.method;
        if matches!(method, Method::Ritz | Method::Fabrikant | Method::ClosedForm) {
            return respond(self.contact, depth, tilt, self.settings, true);
        }
        if method == Method::Auto && self.settings.cells.is_none() {
            let formula = Settings { method: Method::ClosedForm, ..*self.settings };
            match respond(self.contact, depth, tilt, &formula, true) {
                Err(e) if e.verdict == Verdict::NoClosedForm => {}
                answered => return answered,
            }
        }
        // One grid for all tilts: what differs from one to the next would be noise to Newton's method.
        let cells = self.settings.cells.unwrap_or((2.0 / self.settings.tolerance.sqrt()).clamp(32.0, 512.0) as usize);
        let gap = tilted(self.contact, tilt);
        by_grid::in_frame(self.contact, &gap, depth, tilt, self.settings, cells, &mut self.frame)
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
    let [x, y] = lowest(&**gap, gap.centre());
    let least = gap.gap(x, y);
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
    let mut engine = Engine { contact, settings, with_matrix: false, frame: None };
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

/// A box around everything that can touch at any tilt: where the gap is less than a depth beyond all measure.
fn material(gap: &AnyGap, depth: f64) -> Option<Rect> {
    let [x, y] = lowest(&**gap, gap.centre());
    let least = gap.gap(x, y);
    match gap.reach(least + 1e12 * (depth - least)) {
        Reach::Within(rect) => Some(rect),
        _ => None,
    }
}

/// Relative miss of the load that is left to the last linear step.
fn close(settings: &Settings) -> f64 {
    match settings.method {
        Method::ClosedForm => 1e-12,
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
    let mut engine = Engine { contact, settings, with_matrix: true, frame: None };
    equilibrium::under_moment(&mut engine, force, moment, upright, size, 0.01 * settings.tolerance)
}

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
        Method::Ritz | Method::Fabrikant => by_approximation::solution(contact, &gap, depth, tilt, settings),
    }
}
