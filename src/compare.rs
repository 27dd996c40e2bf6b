//! Every method on one state of contact, against the tightest force known: what each costs and how wrong it is.

use crate::contact::{Contact, Loading};
use crate::error::Unsolved;
use crate::geometry::Rect;
use crate::settings::{Method, Outputs, Settings};
use crate::solution::Solution;
use crate::solve::solve;

/// What to run.
#[derive(Debug, Clone, PartialEq)]
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
}

impl Plan {
    /// The usual resolutions, three repeats.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            fft_cells: vec![16, 32, 64, 128, 256, 512],
            qp_cells: vec![12, 24, 48],
            tolerances: vec![1e-2, 1e-3, 1e-4],
            repeats: 3,
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
    /// Unknowns of the largest system.
    pub unknowns: usize,
    /// Products with the compliance operator.
    pub products: usize,
    /// Median of the run times, seconds.
    pub seconds: f64,
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
/// let plan = compare::Plan { fft_cells: vec![32], qp_cells: vec![], repeats: 1, ..compare::Plan::new(Settings::default()) };
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
    let contact = match Contact::new(contact.modulus(), contact.gap().clone(), last) {
        Ok(contact) => contact,
        Err(e) => return Comparison { reference: None, runs: Vec::new(), remarks: vec![e.to_string()] },
    };
    let mut best = reference(&contact, plan);
    let mut solved = Vec::new();
    for (method, cells, tolerance) in plan.runs() {
        let settings = asked(plan, method, cells, tolerance);
        let outcome = timed(&contact, &settings, plan.repeats);
        if let (None, Ok((solution, _))) = (&best, &outcome)
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
        uncertainty: best.force_error.unwrap_or(f64::INFINITY),
        area: best.patch.area,
        source,
    };
    let mut runs: Vec<Run> = solved
        .into_iter()
        .map(|(method, cells, tolerance, outcome)| {
            let outcome = outcome.map(|(solution, seconds)| figures(&solution, seconds, &best));
            Run { method, cells, tolerance, outcome }
        })
        .collect();
    rank(&mut runs, reference.uncertainty);
    Comparison { reference: Some(reference), runs, remarks }
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

/// Unknowns of the solve to 1e-4 beyond which 1e-5 is not tried: the grid would be of millions of cells.
const MANY_UNKNOWNS: usize = 30_000;

/// The closed form; else the extrapolated force of grids refined to 1e-5, or 1e-4, or 1e-3.
fn reference(contact: &Contact, plan: &Plan) -> Option<(Solution, String)> {
    let with_patch = |method, tolerance| {
        let outputs = Outputs { patch: true, ..Outputs::default() };
        let settings = Settings { outputs, ..asked(plan, method, None, tolerance) };
        solve(contact, &settings).pop()?.ok()
    };
    if let Some(solution) = with_patch(Method::ClosedForm, None) {
        return Some((solution, "closed form".to_owned()));
    }
    let by_grid = |tolerance: f64| {
        let solution = with_patch(Method::Fft, Some(tolerance))?;
        Some((solution, format!("fft, grids refined until the force is known to {tolerance:e}")))
    };
    let Some(good) = by_grid(1e-4) else {
        return by_grid(1e-3);
    };
    if good.0.cost.unknowns > MANY_UNKNOWNS {
        return Some(good);
    }
    by_grid(1e-5).or(Some(good))
}

/// Seconds of a run that is not worth repeating for its time.
const LONG: f64 = 2.0;

/// The answer with its boundary, and the median run time without it.
fn timed(contact: &Contact, settings: &Settings, repeats: usize) -> Result<(Solution, f64), Unsolved> {
    let once = |settings: &Settings| {
        solve(contact, settings)
            .pop()
            .unwrap_or_else(|| Err(Unsolved::new(crate::Verdict::NotApplicable, "there is no state of loading")))
    };
    let first = once(settings)?;
    let mut times = vec![first.cost.seconds];
    while times.len() < repeats && first.cost.seconds < LONG {
        times.push(once(settings)?.cost.seconds);
    }
    times.sort_by(f64::total_cmp);
    let seconds = times[times.len() / 2];
    let solution = if seconds < LONG {
        once(&Settings { outputs: Outputs { patch: true, ..Outputs::default() }, ..*settings })?
    } else {
        first
    };
    Ok((solution, seconds))
}

fn figures(solution: &Solution, seconds: f64, reference: &Solution) -> Figures {
    let relative = |value: f64, reference: f64| if value == reference { 0.0 } else { value / reference - 1.0 };
    let boundaries = solution.patch.boundary.as_deref().zip(reference.patch.boundary.as_deref());
    Figures {
        ran: solution.method,
        force: solution.force,
        error: relative(solution.force, reference.force),
        estimate: solution.force_error,
        area: solution.patch.area,
        area_error: relative(solution.patch.area, reference.patch.area),
        patch_difference: boundaries.and_then(|(a, b)| symmetric_difference(a, b)),
        unknowns: solution.cost.unknowns,
        products: solution.cost.operator_products,
        seconds,
        behind: 1.0,
    }
}

/// Fills in how far behind the Pareto front of error and run time each run lies.
fn rank(runs: &mut [Run], uncertainty: f64) {
    let size = |f: &Figures| f.error.abs().max(uncertainty);
    let points: Vec<(f64, f64)> = runs.iter().flat_map(|r| &r.outcome).map(|f| (size(f), f.seconds)).collect();
    for figures in runs.iter_mut().flat_map(|r| &mut r.outcome) {
        let error = size(figures);
        let as_close = points.iter().filter(|p| p.0 <= error).map(|p| p.1);
        let quickest = as_close.fold(figures.seconds, f64::min);
        // A run too short for the clock is on the front.
        figures.behind = if quickest > 0.0 { figures.seconds / quickest } else { 1.0 };
    }
}

/// Lines across both patches, on which lengths are exact: the area between two boundaries is good to about 1e-3 of it.
const SCAN_LINES: usize = 1000;

/// Area inside one set of closed polylines but not the other, over the area inside the second (even-odd rule).
fn symmetric_difference(a: &[Vec<[f64; 2]>], b: &[Vec<[f64; 2]>]) -> Option<f64> {
    let points = a.iter().chain(b).flatten().copied();
    let extent = Rect::holding(points)?;
    let height = extent.size()[1] / SCAN_LINES as f64;
    let (mut between, mut within) = (0.0, 0.0);
    for k in 0..SCAN_LINES {
        let y = extent.min[1] + (k as f64 + 0.5) * height;
        let (own, other) = (crossings(a, y), crossings(b, y));
        within += other.chunks_exact(2).map(|pair| pair[1] - pair[0]).sum::<f64>();
        // A point is in exactly one of the two where it has passed an odd number of crossings of both together.
        let mut all = [own, other].concat();
        all.sort_by(f64::total_cmp);
        between += all.chunks_exact(2).map(|pair| pair[1] - pair[0]).sum::<f64>();
    }
    (within > 0.0).then(|| between / within)
}

/// Where the line at this height crosses closed polylines, ascending.
fn crossings(loops: &[Vec<[f64; 2]>], y: f64) -> Vec<f64> {
    let mut at = Vec::new();
    for points in loops {
        for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
            if (p[1] > y) != (q[1] > y) {
                at.push(p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
            }
        }
    }
    at.sort_by(f64::total_cmp);
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, side: f64) -> Vec<Vec<[f64; 2]>> {
        vec![vec![[x, 0.0], [x + side, 0.0], [x + side, side], [x, side]]]
    }

    #[test]
    fn area_between_two_boundaries() {
        // Shifted by a quarter: two strips of a quarter each.
        assert!((symmetric_difference(&square(0.25, 1.0), &square(0.0, 1.0)).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(symmetric_difference(&square(0.0, 1.0), &square(0.0, 1.0)), Some(0.0));
        // Half the side inside: three quarters missing; the scan lines are 1/1000 apart.
        assert!((symmetric_difference(&square(0.0, 0.5), &square(0.0, 1.0)).unwrap() - 0.75).abs() < 1e-3);
    }

    #[test]
    fn behind_the_front() {
        let run = |error, seconds| Run {
            method: Method::Fft,
            cells: None,
            tolerance: None,
            outcome: Ok(Figures {
                ran: Method::Fft,
                force: 1.0,
                error,
                estimate: None,
                area: 1.0,
                area_error: 0.0,
                patch_difference: None,
                unknowns: 1,
                products: 1,
                seconds,
                behind: 0.0,
            }),
        };
        let mut runs = [run(1e-2, 1.0), run(-1e-3, 2.0), run(2e-3, 3.0), run(1e-7, 8.0), run(1e-9, 9.0)];
        rank(&mut runs, 1e-6);
        let behind: Vec<f64> = runs.iter().map(|r| r.outcome.as_ref().unwrap().behind).collect();
        assert_eq!(behind, [1.0, 1.0, 1.5, 1.0, 9.0 / 8.0]);
    }
}
