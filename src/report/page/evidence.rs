//! Everything a report shows of a scene, computed: the answers, every method on one of its states, brackets, the curve.

use crate::bracket::{self, BracketSettings, ForceBracket};
use crate::clock::{CpuTime, Deadline, Stopwatch};
use crate::compare::{self, Comparison};
use crate::curve::Curve;
use crate::plan::{Plan, plan};
use crate::plot::Section;
use crate::problem::{Contact, ErrorBar, Load, Loading, Method, Outputs, Settings};
use crate::report::pictured::pictured;
use crate::report::{Step, numbers};
use crate::scene::Scene;
use crate::solution::{Solution, Unsolved};
use crate::solve::solve;

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
    pub comparison: Option<Comparison>,
    pub brackets: Vec<Bracketing>,
}

/// Parts of a report beside the answer and its pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Parts {
    /// The patch by every method that gives its boundary.
    pub boundaries: bool,
    /// Force against depth, up to the deepest state.
    pub curve: bool,
    /// Every method side by side, at several resolutions.
    pub methods: bool,
    /// Bounds of the force on several grids.
    pub bounds: bool,
}

impl Parts {
    /// All of them.
    pub const ALL: Self = Self { boundaries: true, curve: true, methods: true, bounds: true };
}

/// CPU seconds within which a report is, unless the answer alone takes longer.
const LONGEST: f64 = 5.0;

/// What a report may take, as a multiple of its answer.
const TIMES: f64 = 3.0;

/// Seconds that a report may take beside an answer that took next to none.
const LEAST: f64 = 0.1;

/// What a report is made from.
pub(super) struct Evidence {
    pub plan: Result<Plan, Unsolved>,
    pub steps: Vec<Step>,
    /// The last state that was solved and touches.
    pub detail: Option<Detail>,
    /// The curve up to the deepest state, or why there is none.
    pub curve: Option<Result<Curve, String>>,
    /// What is not in the report, and the option that brings it.
    pub skipped: Vec<String>,
    /// Parts of the work and the CPU seconds each took.
    pub seconds: Vec<(&'static str, f64)>,
}

impl Evidence {
    /// The answer with its pictures, and these parts, whatever they take; of boundaries and curve also what fits into three times the
    /// answer. `say` is called with what is being done.
    pub fn gather(scene: &Scene, runs: &compare::Plan, parts: Parts, say: &mut dyn FnMut(&str)) -> Self {
        let mut clock = Clock { seconds: Vec::new(), threads: scene.settings.threads, say };
        let plan = plan(&scene.contact, &scene.settings);
        let single = matches!(scene.contact.loading(), Loading::Single(_));
        // On a grid the fields are there anyway.
        let gridded =
            matches!(plan.as_ref().ok().and_then(|p| p.method), Some(Method::Fft | Method::Qp | Method::EdgeFitted));
        let fields = single && gridded;
        let asked = scene.settings.outputs;
        let outputs = Outputs { patch: true, curve: false, pressure: asked.pressure || fields, ..asked };
        let settings = Settings { outputs, ..scene.settings };
        let steps = clock.time("the answer", || solve(&scene.contact, &settings));
        let answer = clock.spent();
        let budget = Budget {
            until: (TIMES * answer).clamp(LEAST + answer, LONGEST.max(LEAST + answer)),
            settings: scene.settings,
        };
        let touching = |(_, step): &(usize, &Step)| numbers(step).is_some_and(|s| s.force > 0.0);
        let last = steps.iter().enumerate().rfind(touching);
        let mut skipped = Vec::new();
        let detail = last.and_then(|(index, step)| {
            numbers(step).map(|state| detail(scene, index, state, runs, parts, &budget, &mut clock, &mut skipped))
        });
        let left = budget.left(&clock);
        let curve = if detail.is_none() {
            None
        } else if parts.curve {
            Some(clock.time("the force-depth curve", || curve(scene, &steps, &scene.settings)))
        } else {
            let limited = budget.settings(left);
            let curve = clock.time("the force-depth curve", || curve(scene, &steps, &limited));
            let out_of_time = limited.deadline.has_passed();
            match curve {
                Err(_) if out_of_time => {
                    skipped.push(format!("the force-depth curve, which takes longer than {left:.1} s: --with curve"));
                    None
                }
                other => Some(other),
            }
        };
        if detail.is_some() {
            if !parts.methods {
                skipped.push("every method side by side, with its error and run time: --with methods".to_owned());
            }
            if !parts.bounds {
                skipped.push("bounds of the force on several grids: --with bounds".to_owned());
            }
        }
        Self { plan, detail, curve, skipped, seconds: clock.seconds, steps }
    }
}

/// What the parts that are not asked for may take.
struct Budget {
    /// Seconds from the beginning.
    until: f64,
    settings: Settings,
}

impl Budget {
    fn left(&self, clock: &Clock) -> f64 {
        (self.until - clock.spent()).max(1e-3)
    }

    /// Settings under which all work ends after so many seconds.
    fn settings(&self, seconds: f64) -> Settings {
        let deadline = Deadline::after(seconds, self.settings.threads);
        Settings { evidence: ErrorBar::Estimate, seconds, deadline, ..self.settings }
    }
}

struct Clock<'s> {
    /// CPU seconds of each part.
    seconds: Vec<(&'static str, f64)>,
    threads: usize,
    say: &'s mut dyn FnMut(&str),
}

impl Clock<'_> {
    /// Seconds of all work so far.
    fn spent(&self) -> f64 {
        self.seconds.iter().map(|(_, s)| s).sum()
    }

    fn time<T>(&mut self, what: &'static str, work: impl FnOnce() -> T) -> T {
        (self.say)(what);
        let started = CpuTime::start(self.threads);
        let done = work();
        self.seconds.push((what, started.seconds()));
        done
    }
}

#[allow(clippy::too_many_arguments)]
fn detail(
    scene: &Scene,
    index: usize,
    state: &Solution,
    runs: &compare::Plan,
    parts: Parts,
    budget: &Budget,
    clock: &mut Clock,
    skipped: &mut Vec<String>,
) -> Detail {
    // The depth of the answer, whatever the load was: all that follows is about this one state.
    let contact = scene.contact.under(Loading::Single(state.load()));
    let gap = contact.tilted_gap(state.tilt);
    // Whatever error the grids are left with: it is shown beside them.
    let run = |settings: Settings| solve(&contact, &settings).pop().map(|step| step.or_else(Unsolved::accept_best));
    let both = Outputs { patch: true, pressure: true, gap: true, ..Outputs::default() };
    let patch = Outputs { patch: true, ..Outputs::default() };
    let grid =
        clock.time("the state on a grid, for the pictures", || pictured(&scene.contact, state, &scene.settings, true));
    let section = grid.as_ref().ok().and_then(|s| Section::through(&contact, s));
    let mut boundaries: Vec<(Method, Vec<Vec<[f64; 2]>>)> = Vec::new();
    boundaries.extend(grid.as_ref().ok().and_then(|s| Some((s.method, s.patch.boundary.clone()?))));
    let left = budget.left(clock);
    let limited = if parts.boundaries { scene.settings } else { budget.settings(left) };
    let mut missed = Vec::new();
    clock.time("the boundaries of other methods", || {
        for method in [Method::ClosedForm, Method::Fabrikant, Method::Ritz] {
            if boundaries.iter().any(|(known, _)| *known == method) {
                continue;
            }
            if !parts.boundaries && limited.deadline.has_passed() {
                missed.push(method);
            } else if let Some(Ok(solution)) = run(Settings { method, cells: None, outputs: patch, ..limited }) {
                boundaries.extend(solution.patch.boundary.map(|boundary| (method, boundary)));
            } else if !parts.boundaries && limited.deadline.has_passed() {
                missed.push(method);
            }
        }
    });
    if !missed.is_empty() {
        let names: Vec<&str> = missed.into_iter().map(Method::name).collect();
        let names = names.join(", ");
        skipped.push(format!("the patch by {names}, which takes longer than {left:.1} s: --with boundaries"));
    }
    if !parts.methods && !parts.bounds {
        return Detail { index, grid, section, boundaries, comparison: None, brackets: Vec::new() };
    }
    let run = |method, cells, outputs| run(Settings { method, cells, outputs, ..scene.settings });
    let comparison =
        parts.methods.then(|| clock.time("every method, at several resolutions", || compare::compare(&contact, runs)));
    let mut brackets: Vec<Bracketing> = Vec::new();
    let mut bounds = || {
        let bracketing = BracketSettings { threads: scene.settings.threads, ..BracketSettings::default() };
        let finest = runs.fft_cells.iter().copied().max().unwrap_or(0);
        for cells in BRACKET_CELLS.into_iter().filter(|&cells| cells <= finest) {
            if brackets.last().is_some_and(|b| b.seconds > PATIENCE) {
                break;
            }
            let started = Stopwatch::start();
            let Some(Ok(solution)) = run(Method::Fft, Some(cells), both) else { continue };
            let Some(field) = &solution.pressure.field else { continue };
            if let Ok(bracket) = bracket::sharp(&gap, contact.modulus(), state.depth, field, &bracketing) {
                let seconds = started.seconds();
                brackets.push(Bracketing { cells, force: solution.force, bracket, seconds });
            }
        }
    };
    if parts.bounds {
        clock.time("brackets", &mut bounds);
    }
    Detail { index, grid, section, boundaries, comparison, brackets }
}

/// The curve up to the deepest state of a punch that does not tilt.
fn curve(scene: &Scene, steps: &[Step], settings: &Settings) -> Result<Curve, String> {
    let upright = scene.contact.loading().loads().iter().all(|load| matches!(load, Load::Depth(_) | Load::Force(_)));
    if !upright {
        return Err("A curve is for a punch that does not tilt.".to_owned());
    }
    let touching = steps.iter().filter_map(numbers).filter(|s| s.force > 0.0);
    let deepest = touching.map(|s| s.depth).reduce(f64::max).ok_or("No state was solved that touches.")?;
    let contact: &Contact = &scene.contact;
    let settings = Settings { outputs: Outputs::default(), ..*settings };
    Curve::up_to(contact, &settings, deepest, CURVE_ACCURACY).map_err(|e| e.to_string())
}
