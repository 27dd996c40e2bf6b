//! Stiff and extreme cases, each with a bound on its error: what `contact-patch stability` runs.
//!
//! The cases are data (`data/stability/`, with the script that made them) and part of the library, so that an installed
//! program can check itself. A case is a scene, the methods to run with the relative error allowed for each, and what to
//! hold them against: a force with its source, a verdict, or, where nothing exact is known, the force of the first run.
//!
//! ```no_run
//! for case in contact_patch::stability::cases()? {
//!     assert!(case.run(1).iter().all(|check| check.passed), "{}", case.name);
//! }
//! # Ok::<(), contact_patch::InputError>(())
//! ```

use serde::Deserialize;

use crate::error::InputError;
use crate::grid::{Grid, Kernel, Pressure};
use crate::influence::InfluenceTable;
use crate::matrix_free::{Operator, Scratch};
use crate::problem::{Load, Method, Outputs, Settings};
use crate::scene::Scene;
use crate::solution::{Solution, Unsolved};
use crate::solve::solve;

/// Topic and text of each file of cases.
const FILES: [(&str, &str); 6] = [
    ("units", include_str!("../data/stability/units.json")),
    ("shapes", include_str!("../data/stability/shapes.json")),
    ("grids", include_str!("../data/stability/grids.json")),
    ("patches", include_str!("../data/stability/patches.json")),
    ("loads", include_str!("../data/stability/loads.json")),
    ("edges", include_str!("../data/stability/edges.json")),
];

/// Largest relative residual (complementarity, tension, penetration) of any solution from a grid.
pub const MOST_RESIDUAL: f64 = 1e-6;

/// The word that stands for "solved within the bound, or one of the verdicts that say why not".
const SOLVED_OR_STOPPED: &str = "solved or stopped";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseForm {
    name: String,
    scene: serde_json::Value,
    runs: Vec<RunForm>,
    force: Option<f64>,
    source: Option<String>,
    verdict: Option<String>,
    regions: Option<usize>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RunForm {
    method: String,
    within: f64,
    cells: Option<usize>,
    tolerance: Option<f64>,
}

/// A case, ready to run.
#[derive(Clone)]
pub struct Case {
    /// What is extreme about it, with its topic before it.
    pub name: String,
    /// The problem.
    pub scene: Scene,
    /// Settings of each run, and the relative error of the force allowed for it.
    pub runs: Vec<(Settings, f64)>,
    /// The force to be reached, and where it is from.
    pub reference: Option<(f64, String)>,
    /// The verdict that every run must give; "solved or stopped" allows any verdict.
    pub verdict: Option<String>,
    /// Separate patches that every run must find at least.
    pub regions: Option<usize>,
}

/// All cases.
///
/// # Errors
/// Names the case and the path in it; the cases that come with the library have no errors.
pub fn cases() -> Result<Vec<Case>, InputError> {
    let mut cases = Vec::new();
    for (topic, text) in FILES {
        let unreadable = |e: serde_json::Error| InputError::new(topic, e, "a list of cases");
        let forms: Vec<CaseForm> = serde_json::from_str(text).map_err(unreadable)?;
        for form in forms {
            cases.push(case(topic, form)?);
        }
    }
    Ok(cases)
}

fn case(topic: &str, form: CaseForm) -> Result<Case, InputError> {
    let name = format!("{topic}: {}", form.name);
    let within = |e: InputError| e.within(&name);
    let scene = Scene::from_json(form.scene.to_string().as_bytes()).map_err(within)?;
    let mut runs = Vec::new();
    for run in form.runs {
        // The words for methods are those of scenes; let the scene reader know them.
        let mut document = form.scene.clone();
        let mut asked = serde_json::Map::new();
        asked.insert("method".into(), run.method.into());
        if let Some(cells) = run.cells {
            asked.insert("cells".into(), cells.into());
        }
        if let Some(tolerance) = run.tolerance {
            asked.insert("tolerance".into(), tolerance.into());
        }
        if let Some(document) = document.as_object_mut() {
            document.insert("solve".into(), asked.into());
        }
        let settings = Scene::from_json(document.to_string().as_bytes()).map_err(within)?.settings;
        runs.push((settings, run.within));
    }
    let reference = form.force.map(|force| (force, form.source.unwrap_or_default()));
    Ok(Case { name, scene, runs, reference, verdict: form.verdict, regions: form.regions })
}

/// What one run of a case gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What was asked for.
    pub settings: Settings,
    /// Error of the force allowed, relative.
    pub bound: f64,
    /// The answer, or why there is none.
    pub outcome: Result<Solution, Unsolved>,
    /// Error of the force against the reference, or against the first run; `None` when there is nothing to compare.
    pub error: Option<f64>,
    /// Largest of the relative residuals, recomputed; `None` for methods without a grid.
    pub residual: Option<f64>,
    /// Estimate of the condition of the compliance matrix of the cells in contact; `None` unless `fft` or `qp` was asked for.
    pub condition: Option<f64>,
    /// Whether error, residual and verdict are what they must be.
    pub passed: bool,
}

impl Case {
    /// Runs every method of the case, each on so many threads.
    #[must_use]
    pub fn run(&self, threads: usize) -> Vec<Check> {
        let mut reference = self.reference.as_ref().map(|(force, _)| *force);
        let mut checks = Vec::new();
        for &(settings, bound) in &self.runs {
            let settings = Settings { threads, ..settings };
            // A formula would be sampled for its field at the price of many integrals.
            let on_a_grid = matches!(settings.method, Method::Qp | Method::Fft);
            let outputs = Outputs { pressure: on_a_grid, ..settings.outputs };
            let Some(mut outcome) = solve(&self.scene.contact, &Settings { outputs, ..settings }).pop() else {
                continue;
            };
            // The bound of a run on prescribed cells is its own, whatever error it states; a case may be that there is no answer.
            if settings.cells.is_some() && self.verdict.is_none() {
                outcome = outcome.or_else(Unsolved::accept_best);
            }
            let field = outcome.as_mut().ok().and_then(|solution| solution.pressure.field.take());
            let error = outcome.as_ref().ok().map(|solution| {
                let force = solution.force;
                let against = *reference.get_or_insert(force);
                // A force of nothing has no relative error: any other is wrong by all of itself.
                let off = (force - against).abs() / against.abs().max(f64::MIN_POSITIVE);
                let off = if force == against { 0.0 } else { off };
                off.max(self.moment_missed(solution))
            });
            let residual = outcome.as_ref().ok().and_then(|s| s.residuals).map(|r| r.worst());
            let condition = field.and_then(|field| condition(&field, settings.kernel));
            let regions = outcome.as_ref().map_or(0, |solution| solution.patch.regions);
            let passed = match (&outcome, self.verdict.as_deref()) {
                (Ok(_), None | Some(SOLVED_OR_STOPPED)) => {
                    error.is_none_or(|e| e <= bound)
                        && residual.is_none_or(|r| r <= MOST_RESIDUAL)
                        && self.regions.is_none_or(|least| regions >= least)
                }
                (Err(_), Some(SOLVED_OR_STOPPED)) => true,
                (Err(unsolved), Some(wanted)) => unsolved.verdict.word() == wanted,
                (Ok(_), Some(_)) | (Err(_), None) => false,
            };
            checks.push(Check { settings, bound, outcome, error, residual, condition, passed });
        }
        checks
    }

    /// By how much a prescribed moment is missed, over force times radius.
    fn moment_missed(&self, solution: &Solution) -> f64 {
        match (self.scene.contact.loading().loads(), solution.moment) {
            ([Load::ForceMoment { force, moment }], Some(found)) if *force > 0.0 => {
                (found[0] - moment[0]).hypot(found[1] - moment[1]) / (force * solution.patch.max_radius)
            }
            _ => 0.0,
        }
    }
}

/// Largest over smallest eigenvalue of the compliance of the loaded cells: an estimate from below. The largest by three
/// steps of the power method from the uniform pressure; the smallest by the Rayleigh quotient of the pressure that changes
/// its sign from cell to cell, as the spectrum of 1/r falls with the wave number.
fn condition(field: &Pressure, kernel: Kernel) -> Option<f64> {
    let Grid { spacing, shape, .. } = field.grid;
    let operator = Operator::compliance(&InfluenceTable::new(kernel, spacing, shape), spacing, shape);
    let loaded: Vec<bool> = field.values.iter().map(|&p| p > 0.0).collect();
    let (mut image, mut scratch) = (vec![0.0; loaded.len()], Scratch::new());
    let mut product = |p: &[f64]| {
        operator.apply(p, 0..shape[1], &mut image, 0..shape[1], &mut scratch);
        let masked: Vec<f64> = image.iter().zip(&loaded).map(|(u, &l)| if l { *u } else { 0.0 }).collect();
        masked
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut quotient = |p: &[f64]| {
        let u = product(p);
        (dot(p, &u) / dot(p, p), u)
    };
    let uniform: Vec<f64> = loaded.iter().map(|&l| f64::from(u8::from(l))).collect();
    let signs = |k: usize| if (k % shape[0] + k / shape[0]).is_multiple_of(2) { 1.0 } else { -1.0 };
    let alternating: Vec<f64> = uniform.iter().enumerate().map(|(k, l)| l * signs(k)).collect();
    let smallest = quotient(&alternating).0;
    let (mut largest, mut u) = quotient(&uniform);
    for _ in 0..2 {
        (largest, u) = quotient(&u);
    }
    Some(largest / smallest).filter(|c| c.is_finite() && *c > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_is_a_scene_with_something_to_hold_it_against() {
        let cases = cases().unwrap();
        for case in &cases {
            let comparable = case.reference.is_some() || case.verdict.is_some() || case.runs.len() > 1;
            assert!(comparable && !case.runs.is_empty(), "{}", case.name);
            assert!(case.reference.as_ref().is_none_or(|(_, source)| !source.is_empty()), "{}", case.name);
        }
        let mut names: Vec<&str> = cases.iter().map(|c| c.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), cases.len());
    }

    #[test]
    fn a_wrong_reference_fails_and_a_verdict_must_be_the_one_said() {
        let case = |force: f64, verdict: Option<&str>| {
            let text = br#"{"effective_modulus": 1.0, "gap": {"kind": "cone", "inclination": 45.0}, "loading": {"depth": 1.0}}"#;
            Case {
                name: String::new(),
                scene: Scene::from_json(text).unwrap(),
                runs: vec![(Settings::default(), 1e-6)],
                reference: Some((force, "Love 1939".into())),
                verdict: verdict.map(str::to_owned),
                regions: None,
            }
        };
        let exact = 2.0 / std::f64::consts::PI;
        assert!(case(exact, None).run(1)[0].passed);
        assert!(!case(exact * 1.001, None).run(1)[0].passed);
        assert!(!case(exact, Some("unbounded")).run(1)[0].passed);
    }

    #[test]
    fn condition_against_eigenvalues() {
        // Two cells at a distance: eigenvalues a + b and a - b, with the coefficients a (itself) and b (the other).
        let grid = Grid { origin: [0.0; 2], spacing: [1.0; 2], shape: [2, 1] };
        let table = InfluenceTable::new(Kernel::Galerkin, grid.spacing, grid.shape);
        let (a, b) = (table.get(0, 0), table.get(1, 0));
        let found = condition(&Pressure { grid, values: vec![1.0, 2.0] }, Kernel::Galerkin).unwrap();
        assert!((found / ((a + b) / (a - b)) - 1.0).abs() < 1e-12);
        // A square of n x n cells: the spectrum of 1/r makes it grow like n.
        let of = |n: usize| {
            let grid = Grid { origin: [0.0; 2], spacing: [1.0; 2], shape: [n, n] };
            condition(&Pressure { grid, values: vec![1.0; n * n] }, Kernel::Galerkin).unwrap()
        };
        assert!((of(64) / of(32) - 2.0).abs() < 0.1);
    }
}
