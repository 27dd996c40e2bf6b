//! The commands that show evidence: `compare`, `stability`, and pictures.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn run(arguments: &[&str], directory: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_contact-patch")).args(arguments).current_dir(directory).output().unwrap()
}

fn scene(directory: &Path, gap: &str, loading: &str) {
    let text = format!(r#"{{"name": "a test", "effective_modulus": 1.0, "gap": {gap}, "loading": {loading}}}"#);
    fs::write(directory.join("scene.json"), text).unwrap();
}

const CONE: &str = r#"{"kind": "cone", "inclination": 45.0}"#;
const PUNCH: &str = r#"{"kind": "pyramid", "faces": 3, "inclination": 45.0}"#;
const FEW: [&str; 8] = ["compare", "scene.json", "--cells", "16,32", "--qp-cells", "12", "--repeats", "1"];

fn compared(directory: &Path) -> Value {
    let output = run(&[&FEW[..], &["--json", "-"]].concat(), directory);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn of<'a>(comparison: &'a Value, method: &str) -> Vec<&'a Value> {
    comparison["runs"].as_array().unwrap().iter().filter(|r| r["method"] == method).collect()
}

#[test]
fn a_formula_is_the_reference_where_there_is_one() {
    let directory = tempfile::tempdir().unwrap();
    scene(directory.path(), CONE, r#"{"depth": 1.0}"#);
    let comparison = compared(directory.path());
    assert_eq!(comparison["reference"]["method"], "closed_form");
    let force = comparison["reference"]["force"].as_f64().unwrap();
    assert!((force - 2.0 / std::f64::consts::PI).abs() < 1e-12);
    for run in comparison["runs"].as_array().unwrap() {
        assert_eq!(run["verdict"], "solved");
        let (own, error) = (run["force"].as_f64().unwrap(), run["error"].as_f64().unwrap());
        assert!((own / force - 1.0 - error).abs() < 1e-12);
        // A cone's discrete force on 16 cells is good to a few per cent; on more it is better.
        assert!(error.abs() < 0.05, "{run}");
    }
    let [coarse, fine] = of(&comparison, "fft")[..] else { panic!("two runs") };
    assert!(fine["error"].as_f64().unwrap().abs() < coarse["error"].as_f64().unwrap().abs());
    // Without error only the formula itself and those that call it can be on the front at their end.
    assert!(of(&comparison, "closed_form")[0]["error"] == 0.0);
}

#[test]
fn verdicts_stand_where_forces_cannot() {
    let directory = tempfile::tempdir().unwrap();
    scene(directory.path(), PUNCH, r#"{"depths": [0.5, 1.0]}"#);
    let comparison = compared(directory.path());
    assert_eq!(of(&comparison, "closed_form")[0]["verdict"], "no_closed_form");
    assert!(of(&comparison, "closed_form")[0].get("force").is_none());
    // The last depth; converged to 1e-6 by boundary elements.
    let reference = &comparison["reference"];
    let uncertainty = reference["uncertainty"].as_f64().unwrap();
    assert!(uncertainty < 1e-4);
    assert!((reference["force"].as_f64().unwrap() / 0.882_412 - 1.0).abs() < uncertainty + 3e-6);
    // Table 1 of Barber & Billings: 1.6960382 against 1.764824.
    assert!((of(&comparison, "fabrikant")[0]["error"].as_f64().unwrap() + 0.038_976).abs() < 1e-4);
    assert!(comparison["remarks"][0].as_str().unwrap().contains("last of 2"));
    // Some run is on the front, and no run is ahead of it.
    let behind: Vec<f64> = comparison["runs"].as_array().unwrap().iter().filter_map(|r| r["behind"].as_f64()).collect();
    assert!(behind.contains(&1.0) && behind.iter().all(|b| *b >= 1.0));
}

#[test]
fn unbounded_contact_is_not_compared() {
    let directory = tempfile::tempdir().unwrap();
    scene(directory.path(), r#"{"kind": "pyramid", "faces": 2, "inclination": 45.0}"#, r#"{"depth": 1.0}"#);
    let output = run(&[&FEW[..], &["--json", "-", "--plot", "p.svg"]].concat(), directory.path());
    assert_eq!(output.status.code(), Some(1));
    let comparison: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(comparison["reference"].is_null());
    assert!(of(&comparison, "fft").iter().all(|r| r["verdict"] == "unbounded"));
    assert!(!directory.path().join("p.svg").exists());
}

#[test]
fn tables_and_pictures_are_written() {
    let directory = tempfile::tempdir().unwrap();
    scene(directory.path(), PUNCH, r#"{"depth": 1.0}"#);
    let output = run(&[&FEW[..], &["--csv", "c.csv", "--plot", "c.svg"]].concat(), directory.path());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("fabrikant") && table.contains("no_closed_form") && table.contains("reference: fft"));
    let csv = fs::read_to_string(directory.path().join("c.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().filter(|l| l.contains("solved")).all(|l| l.split(',').count() == columns));
    let picture = fs::read_to_string(directory.path().join("c.svg")).unwrap();
    for words in ["relative error of the force", "run time, s", "Pareto front", "a test", "fabrikant"] {
        assert!(picture.contains(words), "{words}");
    }
}

#[test]
fn solve_draws_pressure_and_curve() {
    let directory = tempfile::tempdir().unwrap();
    scene(directory.path(), PUNCH, r#"{"depth": 1.0}"#);
    let output = run(&["solve", "scene.json", "--plot", "p.svg", "--json", "-"], directory.path());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = fs::read_to_string(directory.path().join("p.svg")).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("pressure") && picture.contains("polyline"));
    // What the picture needs does not leak into a result that was not asked for it.
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(result["patch"].get("boundary").is_none() && result["pressure"].get("field").is_none());
    let output = run(&["solve", "scene.json", "--plot", "p.png"], directory.path());
    assert_eq!(output.status.code(), Some(0));
    assert!(fs::read(directory.path().join("p.png")).unwrap().starts_with(b"\x89PNG"));
    scene(directory.path(), PUNCH, r#"{"depth_range": {"to": 1.0, "steps": 4}}"#);
    assert_eq!(run(&["solve", "scene.json", "--plot", "q.svg"], directory.path()).status.code(), Some(0));
    assert!(fs::read_to_string(directory.path().join("q.svg")).unwrap().contains("depth"));
    let output = run(&["solve", "scene.json", "--plot", "q.pdf"], directory.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--plot"));
    assert!(!directory.path().join("q.pdf").exists());
}

#[test]
fn stiff_cases_keep_their_bounds() {
    // The whole set takes a minute and is a command of its own; here one topic from the binary as it is installed.
    let directory = tempfile::tempdir().unwrap();
    let output = run(&["stability", "--only", "E* ="], directory.path());
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{table}");
    assert!(table.contains("25 runs, 0 missed"), "{table}");
}
