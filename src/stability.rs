//! Stiff and extreme cases, each with a bound on its error: what `contact-patch stability` runs.
//!
//! The cases are data (`data/stability/`, with the script that made them) and part of the library, so that an installed
//! program can check itself. A case is a scene, the methods to run with the relative error allowed for each, and what to
//! hold them against: a force with its source, a verdict, or, where nothing exact is known, the force of the first run.
//!
//! ```no_run
//! for case in contact_patch::stability::cases()? {
//!     assert!(case.run().iter().all(|check| check.passed), "{}", case.name);
//! }
//! # Ok::<(), contact_patch::InputError>(())
//! ```

use serde::Deserialize;

use crate::error::{InputError, Unsolved};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::solution::Solution;
use crate::solve::solve;

/// Topic and text of each file of cases.
const FILES: [(&str, &str); 5] = [
    ("units", include_str!("../data/stability/units.json")),
    ("shapes", include_str!("../data/stability/shapes.json")),
    ("grids", include_str!("../data/stability/grids.json")),
    ("patches", include_str!("../data/stability/patches.json")),
    ("loads", include_str!("../data/stability/loads.json")),
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
    Ok(Case { name, scene, runs, reference, verdict: form.verdict })
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
    /// Whether error, residual and verdict are what they must be.
    pub passed: bool,
}

impl Case {
    /// Runs every method of the case.
    #[must_use]
    pub fn run(&self) -> Vec<Check> {
        let mut reference = self.reference.as_ref().map(|(force, _)| *force);
        let mut checks = Vec::new();
        for &(settings, bound) in &self.runs {
            let Some(outcome) = solve(&self.scene.contact, &settings).pop() else { continue };
            let error = outcome.as_ref().ok().map(|solution| {
                let force = solution.force;
                let against = *reference.get_or_insert(force);
                // A force of nothing has no relative error: any other is wrong by all of itself.
                let off = (force - against).abs() / against.abs().max(f64::MIN_POSITIVE);
                if force == against { 0.0 } else { off }
            });
            let residual = outcome
                .as_ref()
                .ok()
                .and_then(|s| s.residuals)
                .map(|r| [r.complementarity, r.tension, r.penetration].into_iter().fold(0.0, f64::max));
            let passed = match (&outcome, self.verdict.as_deref()) {
                (Ok(_), None | Some(SOLVED_OR_STOPPED)) => {
                    error.is_none_or(|e| e <= bound) && residual.is_none_or(|r| r <= MOST_RESIDUAL)
                }
                (Err(_), Some(SOLVED_OR_STOPPED)) => true,
                (Err(unsolved), Some(wanted)) => unsolved.verdict.word() == wanted,
                (Ok(_), Some(_)) | (Err(_), None) => false,
            };
            checks.push(Check { settings, bound, outcome, error, residual, passed });
        }
        checks
    }
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
            }
        };
        let exact = 2.0 / std::f64::consts::PI;
        assert!(case(exact, None).run()[0].passed);
        assert!(!case(exact * 1.001, None).run()[0].passed);
        assert!(!case(exact, Some("unbounded")).run()[0].passed);
    }
}
