//! Every method on one state of contact, against the tightest force known: what each costs and how wrong it is.

mod distance;
mod front;

use crate::bracket::{self, BracketSettings, ForceBracket};
use crate::problem::{Contact, Load, Loading, Method, Outputs, Settings};
use crate::solution::{Solution, Unsolved};
use crate::solve::solve;

/// Does the work and tells the most bytes of heap it held at once beyond those held before.
pub type HeapMeter = fn(&mut dyn FnMut()) -> usize;

/// What to run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Kernel, boundary family and threads of every run; method, cells, tolerance and outputs are the plan's own.
    pub settings: Settings,
    /// Cells along the longer side for `fft`.
    pub fft_cells: Vec<usize>,
    /// Cells along the longer side for `qp`, whose cost grows with the sixth power of them.
    pub qp_cells: Vec<usize>,
    /// Tolerances for `auto`.
    pub tolerances: Vec<f64>,
    /// Timed runs; the median stands. Runs of more than two seconds are not repeated.
    pub repeats: usize,
    /// Cells along the longer side of the grid that brackets the force; `None`: no bracket.
    pub bracket_cells: Option<usize>,
    /// How to measure memory: by an allocator that counts, which only the program that runs this can install.
    pub heap: Option<HeapMeter>,
}

impl Plan {
    /// The usual resolutions, three repeats, a bracket on 64 cells.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            fft_cells: vec![16, 32, 64, 128, 256, 512],
            qp_cells: vec![12, 24, 48],
            tolerances: vec![1e-2, 1e-3, 1e-4],
            repeats: 3,
            bracket_cells: Some(64),
            heap: None,
        }
    }

    /// Method, cells and tolerance of every run, in the order of the table.
    fn runs(&self) -> Vec<(Method, Option<usize>, Option<f64>)> {
        let mut runs =
            vec![(Method::ClosedForm, None, None), (Method::Ritz, None, None), (Method::Fabrikant, None, None)];
        if cfg!(feature = "qp") {
            runs.extend(self.qp_cells.iter().map(|&n| (Method::Qp, Some(n), None)));
        }
        runs.extend(self.fft_cells.iter().map(|&n| (Method::Fft, Some(n), None)));
        runs.extend(self.tolerances.iter().map(|&t| (Method::Auto, None, Some(t))));
        runs
    }
}

/// What the runs are measured against.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// The method that gave it.
    pub method: Method,
    /// Its force.
    pub force: f64,
    /// Estimate of the relative error of that force; infinite when no estimate could be made.
    pub uncertainty: f64,
    /// Bounds of that force with their evidence, from a grid; `None` when not asked for or not to be had.
    pub bracket: Option<ForceBracket>,
    /// Its patch area.
    pub area: f64,
    /// How it was made, in words.
    pub source: String,
}

/// One run that gave an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// What ran, where the method was `auto`.
    pub ran: Method,
    /// Normal force.
    pub force: f64,
    /// Force over reference force, less 1.
    pub error: f64,
    /// The run's own estimate of its relative error.
    pub estimate: Option<f64>,
    /// Patch area.
    pub area: f64,
    /// Patch area over that of the reference, less 1.
    pub area_error: f64,
    /// Area that belongs to one of the two patches but not to both, over that of the reference.
    pub patch_difference: Option<f64>,
    /// Integral of the difference of both pressures over the force, on the cells of the coarser grid.
    pub pressure_difference: Option<f64>,
    /// Unknowns of the largest system.
    pub unknowns: usize,
    /// Products with the compliance operator.
    pub products: usize,
    /// Median of the run times, seconds.
    pub seconds: f64,
    /// Most bytes of heap held at once, where it was measured.
    pub peak_bytes: Option<usize>,
    /// Run time over that of the quickest run that is as close to the reference (errors below the uncertainty count
    /// as equal to it); 1 on the Pareto front.
    pub behind: f64,
}

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The method that was asked for.
    pub method: Method,
    /// Cells along the longer side, where they were prescribed.
    pub cells: Option<usize>,
    /// Tolerance, where it was prescribed.
    pub tolerance: Option<f64>,
    /// What came of it.
    pub outcome: Result<Figures, Unsolved>,
}

/// All methods on one state of contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// What the runs are measured against; `None` when nothing could be solved.
    pub reference: Option<Reference>,
    /// Every run, the unsolved ones with their verdict.
    pub runs: Vec<Run>,
    /// What the reader should know, in words.
    pub remarks: Vec<String>,
}

/// Runs every method on the contact; of several states of loading, on the last.
///
/// ```
/// use contact_patch::{Contact, EffectiveModulus, Loading, Method, Settings, compare, gap::Polyhedron};
/// let punch = Polyhedron::pyramid(3, 45f64.to_radians())?;
/// let contact = Contact::new(EffectiveModulus::from_e_star(1.0)?, punch, Loading::depth(1.0))?;
/// let plan = compare::Plan { fft_cells: vec![32], qp_cells: vec![], repeats: 1,
///     ..compare::Plan::new(Settings::default()) };
/// let comparison = compare::compare(&contact, &plan);
/// let fabrikant = comparison.runs.iter().find(|r| r.method == Method::Fabrikant).unwrap();
/// // Barber & Billings 1990, table 1: 1.696 against 1.7648.
/// assert!((fabrikant.outcome.as_ref().unwrap().error + 0.039).abs() < 1e-3);
/// # Ok::<(), contact_patch::InputError>(())
/// ```
#[must_use]
pub fn compare(contact: &Contact, plan: &Plan) -> Comparison {
    let mut remarks = Vec::new();
    let loads = contact.loading().loads();
    if loads.len() > 1 {
        remarks.push(format!("the last of {} states of loading", loads.len()));
    }
    let last = loads.last().map_or(Loading::depth(0.0), |&load| Loading::Single(load));
    let contact = contact.under(last);
    let mut best = reference(&contact, plan);
    // Under a given force every method answers that force: what differs is the force at a given depth.
    let given = matches!(contact.loading().loads(), [Load::Force(_) | Load::ForceMoment { .. }]);
    let contact = match &best {
        Some((solution, _)) if given && solution.force > 0.0 => {
            remarks.push("a force is given: methods are compared at the depth and tilt that it leads to".to_owned());
            contact.under(Loading::Single(solution.load()))
        }
        _ => contact,
    };
    let mut solved = Vec::new();
    for (method, cells, tolerance) in plan.runs() {
        let settings = asked(plan, method, cells, tolerance);
        let outcome = timed(&contact, &settings, plan);
        if let (None, Ok(Timed { solution, .. })) = (&best, &outcome)
            && solution.force_error.is_some()
        {
            best = Some((solution.clone(), format!("{} with {} cells", method.name(), cells.unwrap_or(0))));
        }
        solved.push((method, cells, tolerance, outcome));
    }
    let Some((best, source)) = best else {
        let run = |(method, cells, tolerance, outcome): (_, _, _, Result<_, _>)| {
            outcome.err().map(|e| Run { method, cells, tolerance, outcome: Err(e) })
        };
        return Comparison { reference: None, runs: solved.into_iter().filter_map(run).collect(), remarks };
    };
    let reference = Reference {
        method: best.method,
        force: best.force,
        uncertainty: of_force(&best).unwrap_or(f64::INFINITY),
        bracket: plan.bracket_cells.and_then(|cells| bracket(&contact, &best, &plan.settings, cells)),
        area: best.patch.area,
        source,
    };
    let mut runs: Vec<Run> = solved
        .into_iter()
        .map(|(method, cells, tolerance, outcome)| {
            let outcome = outcome.map(|timed| figures(&timed, &best));
            Run { method, cells, tolerance, outcome }
        })
        .collect();
    front::rank(&mut runs, reference.uncertainty);
    remarks.extend(front::of_auto(&runs));
    Comparison { reference: Some(reference), runs, remarks }
}

/// Relative error of the force at the depth of a state: where the force was prescribed, what its depth errs by.
fn of_force(state: &Solution) -> Option<f64> {
    let error = state.force_error?;
    Some(error + (state.depth_error? * state.depth * state.stiffness / state.force).abs())
}

fn asked(plan: &Plan, method: Method, cells: Option<usize>, tolerance: Option<f64>) -> Settings {
    Settings {
        method,
        cells,
        tolerance: tolerance.unwrap_or(plan.settings.tolerance),
        outputs: Outputs::default(),
        ..plan.settings
    }
}

/// Cells along the longer side on which the pressure of a formula is sampled for comparison.
const FIELD_CELLS: usize = 96;

/// Unknowns of the solve to 1e-4 beyond which 1e-5 is not tried: the grid would be of millions of cells.
const MANY_UNKNOWNS: usize = 30_000;

/// The closed form; else the extrapolated force of grids refined to 1e-5, or 1e-4, or 1e-3.
fn reference(contact: &Contact, plan: &Plan) -> Option<(Solution, String)> {
    // The field of a formula is sampled on as many cells as are asked for.
    let outputs = COMPARED;
    let sampled = Settings { cells: Some(FIELD_CELLS), outputs, ..asked(plan, Method::ClosedForm, None, None) };
    if let Some(Ok(solution)) = solve(contact, &sampled).pop() {
        return Some((solution, "closed form".to_owned()));
    }
    let on_grids = |tolerance| {
        let settings = Settings { outputs: COMPARED, ..asked(plan, Method::Fft, None, Some(tolerance)) };
        solve(contact, &settings).pop()
    };
    let known_to =
        |solution, tolerance: f64| (solution, format!("fft, grids refined until the force is known to {tolerance:e}"));
    let by_grid = |tolerance| Some(known_to(on_grids(tolerance)?.ok()?, tolerance));
    let Some(good) = by_grid(1e-4) else {
        return match on_grids(1e-3)? {
            Ok(solution) => Some(known_to(solution, 1e-3)),
            // What the samples of a measured gap leave open no grid can know better.
            Err(unsolved) => Some((unsolved.accept_best().ok()?, "fft, as close as it comes".to_owned())),
        };
    };
    if good.0.cost.unknowns > MANY_UNKNOWNS {
        return Some(good);
    }
    by_grid(1e-5).or(Some(good))
}

/// Seconds of a run that is not worth repeating, for its time or for its patch.
const LONG: f64 = 2.0;

/// What is compared besides the force.
const COMPARED: Outputs =
    Outputs { patch: true, pressure: true, gap: false, bracket: false, curve: false, energy: false };

/// The answer with its boundary and field, and what it took without them.
struct Timed {
    solution: Solution,
    /// Median.
    seconds: f64,
    peak_bytes: Option<usize>,
}

fn timed(contact: &Contact, settings: &Settings, plan: &Plan) -> Result<Timed, Unsolved> {
    let once = |settings: &Settings| {
        let nothing = || Err(Unsolved::new(crate::Verdict::NotApplicable, "there is no state of loading"));
        let answer = solve(contact, settings).pop().unwrap_or_else(nothing);
        // A run on prescribed cells is shown with whatever error it is left with.
        if settings.cells.is_some() { answer.or_else(Unsolved::accept_best) } else { answer }
    };
    let mut first = None;
    let mut peak_bytes = plan.heap.map(|meter| meter(&mut || first = Some(once(settings))));
    let first = first.unwrap_or_else(|| once(settings))?;
    let mut times = vec![first.cost.seconds];
    while times.len() < plan.repeats && first.cost.seconds < LONG {
        times.push(once(settings)?.cost.seconds);
    }
    times.sort_by(f64::total_cmp);
    let seconds = times[times.len() / 2];
    // Formulas have no cells; sampling them for a field would be work of its own.
    let outputs = Outputs { pressure: first.residuals.is_some(), ..COMPARED };
    let solution = if seconds < LONG { once(&Settings { outputs, ..*settings })? } else { first };
    peak_bytes = peak_bytes.filter(|&bytes| bytes > 0);
    Ok(Timed { solution, seconds, peak_bytes })
}

/// Bounds of the force at the depth and tilt of the reference.
fn bracket(contact: &Contact, best: &Solution, settings: &Settings, cells: usize) -> Option<ForceBracket> {
    let outputs = Outputs { pressure: true, ..Outputs::default() };
    let settings = Settings { method: Method::Fft, cells: Some(cells), outputs, ..*settings };
    let field = solve(&contact.under(Loading::Single(best.load())), &settings)
        .pop()?
        .or_else(Unsolved::accept_best)
        .ok()?
        .pressure
        .field?;
    let gap = contact.tilted_gap(best.tilt);
    let look = BracketSettings { threads: settings.threads, ..BracketSettings::default() };
    bracket::sharp(&gap, contact.modulus(), best.depth, &field, &look).ok()
}

fn figures(timed: &Timed, reference: &Solution) -> Figures {
    let Timed { solution, seconds, peak_bytes } = timed;
    let relative = |value: f64, reference: f64| if value == reference { 0.0 } else { value / reference - 1.0 };
    let boundaries = solution.patch.boundary.as_deref().zip(reference.patch.boundary.as_deref());
    let fields = solution.pressure.field.as_ref().zip(reference.pressure.field.as_ref());
    Figures {
        ran: solution.method,
        force: solution.force,
        error: relative(solution.force, reference.force),
        estimate: solution.force_error,
        area: solution.patch.area,
        area_error: relative(solution.patch.area, reference.patch.area),
        patch_difference: boundaries.and_then(|(a, b)| distance::between_patches(a, b)),
        pressure_difference: fields.and_then(|(p, q)| distance::between_pressures(p, q)),
        unknowns: solution.cost.unknowns,
        products: solution.cost.operator_products,
        seconds: *seconds,
        peak_bytes: *peak_bytes,
        behind: 1.0,
    }
}
