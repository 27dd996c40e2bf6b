//! Everything a report shows of a scene, computed: the answers, every method on one of its states, brackets, the curve.

use super::{Step, numbers};
use crate::bracket::{self, BracketSettings, ForceBracket};
use crate::clock::Stopwatch;
use crate::compare::{self, Comparison};
use crate::curve::Curve;
use crate::plan::{Plan, plan};
use crate::plot::Section;
use crate::problem::{Contact, Load, Loading, Method, Outputs, Settings};
use crate::scene::Scene;
use crate::solution::{Solution, Unsolved};
use crate::solve::solve;

/// Cells along the longer side of the grid behind the pictures, unless the scene says.
const PICTURE_CELLS: usize = 128;

/// Cells along the longer side of the grids that bracket the force, as far as the runs go too.
const BRACKET_CELLS: [usize; 4] = [16, 32, 64, 128];

/// Seconds a bracket may take for the next one, about five times as long, to be tried.
const PATIENCE: f64 = 1.0;

/// Relative error of interpolation of the curve: less than can be seen.
const CURVE_ACCURACY: f64 = 3e-3;

/// A bracket and the grid it is from.
pub(super) struct Bracketing {
    pub cells: usize,
    /// Force of the grid itself.
    pub force: f64,
    pub bracket: ForceBracket,
    pub seconds: f64,
}

/// One state in all detail.
pub(super) struct Detail {
    /// Which of the states, from 0.
    pub index: usize,
    /// The solved state on a grid, with boundary and field.
    pub grid: Result<Solution, Unsolved>,
    pub section: Option<Section>,
    /// The boundary that each method gives.
    pub boundaries: Vec<(Method, Vec<Vec<[f64; 2]>>)>,
    pub comparison: Comparison,
    pub brackets: Vec<Bracketing>,
}

/// What a report is made from.
pub(super) struct Evidence {
    pub plan: Result<Plan, Unsolved>,
    pub steps: Vec<Step>,
    /// The last state that was solved and touches.
    pub detail: Option<Detail>,
    /// The curve up to the deepest state, or why there is none.
    pub curve: Result<Curve, String>,
    /// Parts of the work and the seconds each took.
    pub seconds: Vec<(&'static str, f64)>,
}

impl Evidence {
    /// Runs everything; `say` hears what is going on.
    pub fn gather(scene: &Scene, runs: &compare::Plan, say: &mut dyn FnMut(&str)) -> Self {
        let mut clock = Clock { seconds: Vec::new(), say };
        let plan = plan(&scene.contact, &scene.settings);
        let outputs = Outputs { patch: true, curve: false, ..scene.settings.outputs };
        let settings = Settings { outputs, ..scene.settings };
        let steps = clock.time("the answer", || solve(&scene.contact, &settings));
        let touching = |(_, step): &(usize, &Step)| numbers(step).is_some_and(|s| s.force > 0.0);
        let last = steps.iter().enumerate().rfind(touching);
        let detail =
            last.and_then(|(index, step)| numbers(step).map(|state| detail(scene, index, state, runs, &mut clock)));
        let curve = clock.time("the force-depth curve", || curve(scene, &steps));
        Self { plan, detail, curve, seconds: clock.seconds, steps }
    }
}

struct Clock<'s> {
    seconds: Vec<(&'static str, f64)>,
    say: &'s mut dyn FnMut(&str),
}

impl Clock<'_> {
    fn time<T>(&mut self, what: &'static str, work: impl FnOnce() -> T) -> T {
        (self.say)(what);
        let started = Stopwatch::start();
        let done = work();
        self.seconds.push((what, started.seconds()));
        done
    }
}

fn detail(scene: &Scene, index: usize, state: &Solution, runs: &compare::Plan, clock: &mut Clock) -> Detail {
    // The depth of the answer, whatever the load was: all that follows is about this one state.
    let load = match state.tilt {
        [0.0, 0.0] => Load::Depth(state.depth),
        tilt => Load::Tilted { depth: state.depth, tilt },
    };
    let contact = scene.contact.under(Loading::Single(load));
    let gap = contact.tilted_gap(state.tilt);
    // Whatever error the grids are left with: it is shown beside them.
    let run = |method, cells, outputs| {
        let settings = Settings { method, cells, outputs, ..scene.settings };
        solve(&contact, &settings).pop().map(|step| step.or_else(Unsolved::accept_best))
    };
    let both = Outputs { patch: true, pressure: true, ..Outputs::default() };
    let patch = Outputs { patch: true, ..Outputs::default() };
    let cells = scene.settings.cells.unwrap_or(PICTURE_CELLS);
    let grid = clock.time("the state on a grid, for the pictures", || run(Method::Fft, Some(cells), both));
    let grid =
        grid.unwrap_or_else(|| Err(Unsolved::new(crate::Verdict::NotApplicable, "there is no state of loading")));
    let section = grid.as_ref().ok().and_then(|s| Section::through(&contact, s));
    let mut boundaries: Vec<(Method, Vec<Vec<[f64; 2]>>)> = Vec::new();
    boundaries.extend(grid.as_ref().ok().and_then(|s| Some((Method::Fft, s.patch.boundary.clone()?))));
    clock.time("the boundaries of other methods", || {
        for method in [Method::ClosedForm, Method::Fabrikant, Method::Ritz] {
            if let Some(Ok(solution)) = run(method, None, patch) {
                boundaries.extend(solution.patch.boundary.map(|boundary| (method, boundary)));
            }
        }
    });
    let comparison = clock.time("every method, at several resolutions", || compare::compare(&contact, runs));
    let mut brackets: Vec<Bracketing> = Vec::new();
    clock.time("brackets", || {
        let look = BracketSettings { threads: scene.settings.threads, ..BracketSettings::default() };
        let finest = runs.fft_cells.iter().copied().max().unwrap_or(0);
        for cells in BRACKET_CELLS.into_iter().filter(|&cells| cells <= finest) {
            if brackets.last().is_some_and(|b| b.seconds > PATIENCE) {
                break;
            }
            let started = Stopwatch::start();
            let Some(Ok(solution)) = run(Method::Fft, Some(cells), both) else { continue };
            let Some(field) = &solution.pressure.field else { continue };
            if let Ok(bracket) = bracket::sharp(&gap, contact.modulus(), state.depth, field, &look) {
                let seconds = started.seconds();
                brackets.push(Bracketing { cells, force: solution.force, bracket, seconds });
            }
        }
    });
    Detail { index, grid, section, boundaries, comparison, brackets }
}

/// The curve up to the deepest state of a punch that does not tilt.
fn curve(scene: &Scene, steps: &[Step]) -> Result<Curve, String> {
    let upright = scene.contact.loading().loads().iter().all(|load| matches!(load, Load::Depth(_) | Load::Force(_)));
    if !upright {
        return Err("A curve is for a punch that does not tilt.".to_owned());
    }
    let touching = steps.iter().filter_map(numbers).filter(|s| s.force > 0.0);
    let deepest = touching.map(|s| s.depth).reduce(f64::max).ok_or("No state was solved that touches.")?;
    let contact: &Contact = &scene.contact;
    let settings = Settings { outputs: Outputs::default(), ..scene.settings };
    Curve::up_to(contact, &settings, deepest, CURVE_ACCURACY).map_err(|e| e.to_string())
}
