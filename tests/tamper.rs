//! A result with one number changed is accepted only where nothing that it claims is false.
#![cfg(feature = "cli")]

use contact_patch::check::{State, Verification};
use contact_patch::scene::Json;
use contact_patch::{Kernel, Loading, Scene, Settings, report, solve};
use serde_json::{Value, json};

/// What a number is multiplied by.
const FACTORS: [f64; 6] = [0.0, -1.0, 0.9, 1.05, 1e8, 1e-30];

/// Entries of a long list that are changed: the first, the largest, and some between.
const ENTRIES: usize = 6;

fn results() -> Vec<(&'static str, Value, f64)> {
    let scene = |gap: Value, loading: Value, solve: Value, output: Value| json!({"effective_modulus": 2.0e11, "gap": gap, "loading": loading, "solve": solve, "output": output});
    let punch = || json!({"kind": "pyramid", "faces": 3, "inclination": 30.0, "at": [1e-6, -2e-6], "rotate": 17.0});
    // P tan(alpha)/(E* d^2) = 0.882412 (converged by two extrapolated sequences, 2e-6).
    let tetrahedral = 0.882412 * 2.0e11 * 1e-12 / 30f64.to_radians().tan();
    vec![
        (
            "prescribed cells",
            scene(
                punch(),
                json!({"depth": 1e-6}),
                json!({"method": "fft", "cells": 20, "tolerance": 0.1}),
                json!(["pressure", "patch", "gap", "bracket"]),
            ),
            tetrahedral,
        ),
        (
            "a force and a moment on values at centres",
            scene(
                json!({"kind": "formula", "expression": "300*x^2 + 1e11*y^4 + 3*abs(x)"}),
                json!({"force": 3.0, "through": [1e-8, -5e-7]}),
                json!({"method": "fft", "cells": 16, "kernel": "collocation", "tolerance": 0.2}),
                json!(["pressure", "patch"]),
            ),
            3.0,
        ),
        (
            "the limit of several grids",
            scene(
                punch(),
                json!({"depth": 1e-6}),
                json!({"method": "fft", "tolerance": 0.02}),
                json!(["pressure", "patch"]),
            ),
            tetrahedral,
        ),
        (
            "a closed form",
            scene(
                json!({"kind": "sphere", "radius": 1e-3}),
                json!({"depth": 1e-6}),
                json!({"method": "closed_form", "cells": 16}),
                json!(["pressure", "patch"]),
            ),
            f64::NAN,
        ),
        (
            "an approximation with its bracket",
            scene(punch(), json!({"depth": 1e-6}), json!({"method": "ritz"}), json!(["bracket", "patch"])),
            f64::NAN,
        ),
        ("nothing", scene(punch(), json!({"depth": -1e-6}), json!({}), json!([])), 0.0),
    ]
}

fn checked(scene: &Scene, result: &str) -> Option<Verification> {
    let result = Json::parse(result.as_bytes()).ok()?;
    let load = scene.contact.loading().loads()[0];
    // What has no meaning is an error: as good as a refusal.
    State::read(&result, None).and_then(|state| state.check(scene, load)).ok()
}

/// Paths of all numbers below a value; of long lists a few.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Array(items) => {
            let largest = (0..items.len()).max_by(|&a, &b| {
                let of = |k: usize| items[k].as_f64().unwrap_or(f64::NEG_INFINITY);
                of(a).total_cmp(&of(b))
            });
            let step = (items.len() / (ENTRIES - 2)).max(1);
            let mut chosen: Vec<usize> = (0..items.len()).step_by(step).chain(largest).collect();
            chosen.dedup();
            chosen.into_iter().for_each(|k| numbers(&items[k], &format!("{path}/{k}"), found));
        }
        Value::Object(entries) => {
            entries.iter().for_each(|(key, value)| numbers(value, &format!("{path}/{key}"), found));
        }
        _ => {}
    }
}

/// What an error or a bracket may be said to be, weakest first.
const STRENGTH: [&str; 4] = ["estimated", "sampled", "proved", "exact"];

/// Paths of all such words, but for those of the scene.
fn claims(value: &Value, path: &str, found: &mut Vec<String>) {
    let Value::Object(entries) = value else { return };
    for (key, value) in entries.iter().filter(|(key, _)| *key != "scene" && *key != "options") {
        let path = format!("{path}/{key}");
        if key == "evidence" && value.is_string() { found.push(path) } else { claims(value, &path, found) }
    }
}

/// The accuracy to which a check can tell a number: a change below it makes no claim false that anybody could see.
fn accuracy(path: &str, honest: &Value) -> f64 {
    let number = |path: &str| honest.pointer(path).and_then(Value::as_f64).unwrap_or(0.0);
    let cell = number("/grid/spacing/0").max(number("/grid/spacing/1"));
    let (force, radius) = (number("/force"), number("/patch/max_radius"));
    match path {
        p if p.starts_with("/checks/") => 2e-6,
        p if p.starts_with("/patch/boundary") || p.starts_with("/patch/centroid") => (0.02 * cell).max(1e-6 * radius),
        p if p.starts_with("/patch/pieces") && (p.contains("/centroid") || p.contains("/extent")) => {
            (0.02 * cell).max(1e-6 * radius)
        }
        p if p.starts_with("/pressure/at") => 1e-6 * cell.max(radius),
        p if p.starts_with("/pressure/field/values") => 2e-6 * number("/pressure/max"),
        p if p.starts_with("/gap/field/values") => 4e-6 * number("/depth"),
        p if p.starts_with("/moment") => 1e-5 * force * radius,
        p if p.starts_with("/centre_of_pressure") => 1e-9 * radius,
        p if p.starts_with("/stiffness_matrix") => 1e-6 * number("/stiffness") * radius * radius.max(1.0),
        _ => 0.0,
    }
}

#[test]
fn a_changed_number_is_accepted_only_where_nothing_claimed_is_false() {
    for (name, scene, truth) in results() {
        let scene = Scene::from_json(scene.to_string().as_bytes()).unwrap();
        let steps = solve(&scene.contact, &scene.settings);
        assert!(matches!(scene.contact.loading(), Loading::Single(_)));
        let honest = serde_json::to_value(report::json(&scene, &steps)).unwrap();
        assert_eq!(honest["verdict"], "solved", "{name}: {}", honest["reason"]);
        let verified = checked(&scene, &honest.to_string()).unwrap();
        assert!(verified.accepted(), "{name}: {:#?}", verified.objections);
        let mut paths = Vec::new();
        for (key, value) in honest.as_object().unwrap().iter().filter(|(key, _)| *key != "scene") {
            numbers(value, &format!("/{key}"), &mut paths);
        }
        let unchecked = |path: &str| {
            let dotted = path[1..].replace('/', ".");
            verified.unchecked.iter().any(|key| dotted == *key || dotted.starts_with(&format!("{key}.")))
        };
        // The depth under a force, on sixteen times the cells.
        let true_depth = || {
            let settings = Settings { cells: Some(64), kernel: Kernel::Galerkin, ..scene.settings };
            solve(&scene.contact, &settings).remove(0).unwrap().depth
        };
        let (mut tried, mut refused, mut named) = (0, 0, 0);
        let mut wrong = Vec::new();
        for path in &paths {
            for factor in FACTORS {
                let old = honest.pointer(path).unwrap().as_f64().unwrap();
                let new = old * factor;
                if (new - old).abs() <= accuracy(path, &honest) {
                    continue;
                }
                if unchecked(path) {
                    named += 1;
                    continue;
                }
                tried += 1;
                let mut changed = honest.clone();
                let place = changed.pointer_mut(path).unwrap();
                *place =
                    if place.is_u64() && new.fract() == 0.0 && new >= 0.0 { json!(new as u64) } else { json!(new) };
                let accepted = checked(&scene, &changed.to_string()).is_some_and(|found| found.accepted());
                if !accepted {
                    refused += 1;
                    continue;
                }
                // Another error may be stated where the truth lies within it, and no less than is shown.
                let force = honest["force"].as_f64().unwrap();
                let holds = match path.as_str() {
                    "/force_error" => truth.is_nan() && factor > 1.0 || (force - truth).abs() <= new * force,
                    "/depth_error" => {
                        (honest["depth"].as_f64().unwrap() - true_depth()).abs() <= new * true_depth().abs()
                    }
                    // Less is claimed.
                    "/stiffness_error" | "/energy_error" | "/area_error" | "/pressure/max_error" => new >= old,
                    // A wider bracket holds too.
                    "/bracket/lower" => new <= old,
                    "/bracket/upper" => new >= old,
                    _ => false,
                };
                if !holds {
                    wrong.push(format!("{path}: {old:e} times {factor:e}"));
                }
            }
        }
        let mut words = Vec::new();
        claims(&honest, "", &mut words);
        for path in words {
            let old = honest.pointer(&path).and_then(Value::as_str).unwrap();
            let rank = |word: &str| STRENGTH.iter().position(|known| *known == word).unwrap();
            for new in &STRENGTH[rank(old) + 1..] {
                tried += 1;
                let mut changed = honest.clone();
                *changed.pointer_mut(&path).unwrap() = json!(new);
                if checked(&scene, &changed.to_string()).is_some_and(|found| found.accepted()) {
                    wrong.push(format!("{path}: {old} called {new}"));
                } else {
                    refused += 1;
                }
            }
        }
        println!(
            "{name}: {tried} changes, {refused} refused, {named} of numbers that are named as not checked: {:?}",
            verified.unchecked
        );
        assert!(wrong.is_empty(), "{name}: accepted\n{}", wrong.join("\n"));
        assert!(refused * 10 > tried * 9, "{name}");
    }
}
