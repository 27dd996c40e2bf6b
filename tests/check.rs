//! `contact-patch check`: what is honest is accepted, what is altered is not.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

fn run(arguments: &[&str], directory: &Path) -> (i32, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_contact-patch")).args(arguments).current_dir(directory).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code().unwrap(), text)
}

fn scene(gap: Value, loading: Value, solve: Value, output: Value) -> Value {
    json!({"effective_modulus": 2.0e11, "gap": gap, "loading": loading, "solve": solve, "output": output})
}

/// The result of a scene, both written to files of this directory.
fn solve(scene: &Value, directory: &Path) -> Value {
    std::fs::write(directory.join("scene.json"), scene.to_string()).unwrap();
    let (code, text) = run(&["solve", "scene.json", "--json", "result.json", "--threads", "1"], directory);
    assert_eq!(code, 0, "{text}");
    serde_json::from_slice(&std::fs::read(directory.join("result.json")).unwrap()).unwrap()
}

fn check(result: &Value, directory: &Path) -> (i32, String) {
    std::fs::write(directory.join("result.json"), result.to_string()).unwrap();
    run(&["check", "scene.json", "result.json"], directory)
}

fn pyramid() -> Value {
    json!({"kind": "pyramid", "faces": 3, "inclination": 30.0, "at": [1e-6, -2e-6], "rotate": 17.0})
}

#[test]
fn honest_results_are_accepted() {
    let directory = tempfile::tempdir().unwrap();
    let both = json!(["pressure", "bracket"]);
    let superellipse = json!({"kind": "formula", "expression": "300*x^2 + 1e11*y^4 + 3*abs(x)"});
    for (gap, loading, settings, output) in [
        (pyramid(), json!({"depth": 1e-6}), json!({"method": "fft", "cells": 40, "tolerance": 0.2}), both.clone()),
        (pyramid(), json!({"depth": 1e-6}), json!({"method": "fft", "tolerance": 0.02}), json!(["pressure"])),
        (
            pyramid(),
            json!({"depth": 1e-6}),
            json!({"method": "qp", "cells": 24, "kernel": "collocation", "tolerance": 0.2}),
            both.clone(),
        ),
        (pyramid(), json!({"force": 0.2}), json!({"method": "fft", "cells": 32, "tolerance": 0.2}), both.clone()),
        (
            pyramid(),
            json!({"depths": [-1e-6, 5e-7, 1e-6]}),
            json!({"method": "qp", "cells": 24, "tolerance": 0.2}),
            both.clone(),
        ),
        (
            superellipse,
            json!({"depth": 1e-6, "tilt": [1e-3, -5e-4]}),
            json!({"method": "fft", "cells": 32, "tolerance": 0.2}),
            both.clone(),
        ),
        (
            json!({"kind": "cone", "inclination": 20.0}),
            json!({"depth": 1e-6}),
            json!({"cells": 48, "tolerance": 0.2}),
            both.clone(),
        ),
        (json!({"kind": "sphere", "radius": 1e-3}), json!({"force": 2.0}), json!({"tolerance": 0.02}), both.clone()),
        (
            json!({"kind": "flat", "outline": {"ellipse": [2e-3, 1e-3]}}),
            json!({"depth": 1e-6}),
            json!({"cells": 32, "tolerance": 0.3}),
            both,
        ),
        // Sharp edges between the cells: force and moments are the limit of many grids.
        (
            json!({"kind": "flat", "outline": {"polygon": [[0.0, 0.0], [2e-3, 0.0], [1e-3, 1e-3]]}, "rotate": 20.0}),
            json!({"depth": 1e-6}),
            json!({"method": "fft", "tolerance": 5e-3}),
            json!(["pressure"]),
        ),
        // Under a kink of the profile the pressure is a logarithm.
        (
            json!({"kind": "revolved", "points": [[0.0, 0.0], [1.77e-6, 1.13e-6], [3.72e-6, 3.64e-6], [6.41e-6, 7.35e-6]]}),
            json!({"depth": 4e-6}),
            json!({"method": "closed_form"}),
            json!(["pressure"]),
        ),
        // The edge of a flat tip two cells and a bit from a row of cells, close to that of the contact.
        (
            json!({"kind": "revolved", "points": [[0.0, 0.0], [3.509e-5, 0.0], [1.348e-4, 9.955e-5]]}),
            json!({"depth": 1.1215e-5}),
            json!({}),
            json!(["pressure"]),
        ),
        // Pieces that carry the same, in whatever order.
        (
            json!({"kind": "formula", "expression": "x^2/0.02 + y^2/0.02 + 5e-7*(1 - cos(x/2e-5)*cos(y/2e-5))"}),
            json!({"depth": 1e-6}),
            json!({}),
            json!(["pressure", "energy", "patch"]),
        ),
        // A measured gap, on one grid: its bounds are sampled.
        (
            json!({"kind": "profile", "along": "x", "radius": 0.05,
                   "points": (-10..=10).map(|k| f64::from(k) * 1e-4).map(|y| json!([y, y * y / 0.06])).collect::<Vec<_>>()}),
            json!({"depth": 1e-6}),
            json!({"cells": 64, "tolerance": 0.1}),
            json!(["pressure", "energy", "patch"]),
        ),
        // A roller with sharp ends.
        (
            json!({"kind": "formula", "expression": "x^2/0.02 + y^2/3",
                   "region": {"polygon": [[-1e-3, -2e-3], [1e-3, -2e-3], [1e-3, 2e-3], [-1e-3, 2e-3]]}, "rotate": 20.0}),
            json!({"force": 1000.0}),
            json!({}),
            json!(["pressure", "energy", "patch"]),
        ),
        // Cells along turned axes, whose field is a mean over upright ones: one grid, and the limit of several.
        (
            json!({"kind": "formula", "expression": "x^2/0.02 + 1e9*abs(y)^4",
                   "region": {"polygon": [[-1e-3, -2e-3], [1e-3, -2e-3], [1e-3, 2e-3], [-1e-3, 2e-3]]}, "rotate": 20.0}),
            json!({"force": 30.0}),
            json!({}),
            json!(["pressure", "energy", "patch"]),
        ),
        (
            json!({"kind": "formula", "expression": "x^2/0.02 - 1.59155e-5*log(1 - (2*y/4.04e-3)^2)",
                   "region": {"polygon": [[-1e-3, -2e-3], [1e-3, -2e-3], [1e-3, 2e-3], [-1e-3, 2e-3]]}, "rotate": -19.0}),
            json!({"force": 900.0}),
            json!({}),
            json!(["pressure", "patch"]),
        ),
        // Contacts far apart, each on its own grid.
        (
            json!({"kind": "min", "of": [{"kind": "cone", "inclination": 2.0},
                                         {"kind": "cone", "inclination": 3.0, "at": [2e-3, 0.0]}]}),
            json!({"depth": 1e-6}),
            json!({}),
            json!(["pressure", "patch"]),
        ),
        // The limit of several grids of a gap without a law.
        (
            json!({"kind": "sum", "of": [{"kind": "pyramid", "faces": 4, "inclination": 5.0}, {"kind": "sphere", "radius": 1e-4}]}),
            json!({"depth": 1e-6}),
            json!({"method": "fft", "tolerance": 1e-2}),
            json!(["pressure"]),
        ),
        (pyramid(), json!({"depth": 1e-6}), json!({"method": "ritz"}), json!(["bracket"])),
        (pyramid(), json!({"depth": 1e-6}), json!({"method": "fabrikant"}), json!(["bracket"])),
    ] {
        let scene = scene(gap, loading, settings, output);
        let result = solve(&scene, directory.path());
        let (code, text) = check(&result, directory.path());
        assert_eq!(code, 0, "{scene}\n{text}");
    }
}

#[test]
fn altered_results_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(
        pyramid(),
        json!({"depth": 1e-6}),
        json!({"method": "fft", "cells": 40, "tolerance": 0.2, "evidence": "estimate"}),
        json!(["pressure", "bracket"]),
    );
    let honest = solve(&scene, directory.path());
    assert_eq!(check(&honest, directory.path()).0, 0);
    let times = |result: &mut Value, path: &str, by: f64| {
        let place = result.pointer_mut(path).unwrap_or_else(|| panic!("{path}"));
        *place = json!(place.as_f64().unwrap() * by);
    };
    let loaded_in = |values: &str| -> Vec<usize> {
        let values = honest.pointer(values).unwrap().as_array().unwrap();
        (0..values.len()).filter(|&k| values[k].as_f64().unwrap() > 0.0).collect()
    };
    let loaded = loaded_in("/pressure/field/values");
    // A proof has a grid of its own.
    let proving = loaded_in("/bracket/below/field/values");
    let refused = |what: &str, alter: &dyn Fn(&mut Value)| {
        let mut result = honest.clone();
        alter(&mut result);
        let (code, text) = check(&result, directory.path());
        assert_eq!(code, 1, "{what}\n{text}");
        assert!(text.contains("NO  ") && text.ends_with("refused\n"), "{what}\n{text}");
    };
    refused("force", &|r| times(r, "/force", 1.001));
    refused("force and mean", &|r| ["/force", "/pressure/mean"].iter().for_each(|p| times(r, p, 1.2)));
    refused("depth", &|r| times(r, "/depth", 1.01));
    refused("upper bound", &|r| times(r, "/bracket/upper", 0.9999));
    refused("lower bound", &|r| times(r, "/bracket/lower", 1.0001));
    refused("both bounds shifted", &|r| ["/bracket/lower", "/bracket/upper"].iter().for_each(|p| times(r, p, 1.05)));
    for k in [loaded[0], loaded[loaded.len() / 2], loaded[loaded.len() - 1]] {
        refused("one value", &|r| times(r, &format!("/pressure/field/values/{k}"), 1.1));
        let middle = proving[proving.len() / 2];
        refused("one value of a proof", &|r| times(r, &format!("/bracket/below/field/values/{middle}"), 1.5));
    }
    refused("a patch removed", &|r| {
        for &k in loaded.iter().filter(|k| *k % 40 > 20) {
            r["pressure"]["field"]["values"][k] = json!(0.0);
        }
    });
    refused("tension", &|r| times(r, &format!("/pressure/field/values/{}", loaded[5]), -1.0));
    refused("a bracket without proof", &|r| {
        r["bracket"] =
            json!({"lower": 0.999 * r["force"].as_f64().unwrap(), "upper": 1.001 * r["force"].as_f64().unwrap()});
    });
    for word in ["exact", "certain", "proved"] {
        refused(word, &|r| r["evidence"] = json!(word));
        refused(word, &|r| r["bracket"]["evidence"] = json!(format!("{word} beyond doubt")));
    }
    refused("a field that is gone", &|r| {
        r["pressure"].as_object_mut().unwrap().remove("field");
    });
    refused("another scene", &|r| r["scene"]["gap"]["inclination"] = json!(31.0));
    // The echo altered with it: the pressure itself is of another gap, one that is less deep, so that the upper bound stands.
    let mut other = scene.clone();
    other["gap"]["inclination"] = json!(31.0);
    std::fs::write(directory.path().join("scene.json"), other.to_string()).unwrap();
    let mut result = honest.clone();
    result["scene"] = other;
    let (code, text) = check(&result, directory.path());
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("NO  contact conditions") && text.contains("NO  lower bound"), "{text}");
}

#[test]
fn proved_forces_of_gaps_without_a_law_are_accepted_and_altered_ones_refused() {
    let directory = tempfile::tempdir().unwrap();
    let formula = |expression: &str| json!({"kind": "formula", "expression": expression});
    let cone_and_ball = json!({"kind": "sum", "of": [{"kind": "cone", "inclination": 17.0}, {"kind": "paraboloid", "radii": [1.0, 1.0]}]});
    for (gap, depth) in [
        (formula("x^2/2 + 0.1*abs(y)^3"), 1e-2),
        (formula("x^2/2 + y^2/4 + 0.3*(x^2 + y^2)^2"), 0.1),
        (formula("cosh(x) + cosh(2*y) - 2"), 0.1),
        (json!({"kind": "sphere", "radius": 2.0, "rotate": 17.0, "at": [0.3, -0.1]}), 0.3),
        (cone_and_ball, 0.2),
    ] {
        for tolerance in [1e-3, 3e-4] {
            let scene = scene(
                gap.clone(),
                json!({"depth": depth}),
                json!({"method": "fft", "tolerance": tolerance}),
                json!(["pressure"]),
            );
            let honest = solve(&scene, directory.path());
            assert_eq!(honest["evidence"], "proved", "{gap}");
            let (code, text) = check(&honest, directory.path());
            assert_eq!(code, 0, "{gap} {tolerance}\n{text}");
            let refused = |what: &str, alter: &dyn Fn(&mut Value)| {
                let mut result = honest.clone();
                alter(&mut result);
                let (code, text) = check(&result, directory.path());
                assert_eq!(code, 1, "{gap} {what}\n{text}");
                assert!(text.contains("NO  ") && text.ends_with("refused\n"), "{gap} {what}\n{text}");
            };
            let times = |result: &mut Value, path: &str, by: f64| {
                let place = result.pointer_mut(path).unwrap_or_else(|| panic!("{path}"));
                *place = json!(place.as_f64().unwrap() * by);
            };
            refused("stiffness", &|r| times(r, "/stiffness", 1.0 + 1e-4));
            refused("force and mean", &|r| {
                ["/force", "/pressure/mean"].iter().for_each(|p| times(r, p, 1.0 + 3.0 * tolerance));
            });
            let width =
                honest["bracket"]["upper"].as_f64().unwrap() / honest["bracket"]["lower"].as_f64().unwrap() - 1.0;
            refused("upper bound", &|r| times(r, "/bracket/upper", 1.0 - 0.3 * width));
            refused("lower bound", &|r| times(r, "/bracket/lower", 1.0 + 0.3 * width));
        }
    }
}

/// Bounds of moments and tilts: of fitted cells they are found again, of one grid by the field, of several on these.
#[test]
fn bounds_of_moments_and_tilts_are_accepted_and_altered_ones_refused() {
    let directory = tempfile::tempdir().unwrap();
    let rectangle = json!({"kind": "flat", "outline": {"polygon": [[0, 0], [3, 0], [3, 2], [0, 2]]}, "rotate": 20.0});
    let ball = json!({"kind": "sphere", "radius": 2.0, "at": [0.3, -0.1]});
    let pyramid = json!({"kind": "pyramid", "faces": 4, "inclination": 10.0, "rotate": 17.0});
    for (gap, loading, key) in [
        (rectangle.clone(), json!({"depth": 0.1, "tilt": [1e-2, 5e-3]}), "moment"),
        (rectangle, json!({"force": 1.0, "through": [1.0, 1.5]}), "tilt"),
        (ball, json!({"depth": 0.1, "tilt": [0.03, 0.05]}), "moment"),
        (pyramid, json!({"depth": 0.1, "tilt": [0.02, -0.01]}), "moment"),
    ] {
        let scene = scene(gap.clone(), loading, json!({"tolerance": 3e-3}), json!(["pressure", "bracket"]));
        let honest = solve(&scene, directory.path());
        let (code, text) = check(&honest, directory.path());
        assert!(code == 0 && !text.contains(&format!("not checked: bracket.{key}")), "{gap}\n{text}");
        let bounds = |side: &str, m: usize| honest["bracket"][key][side][m].as_f64().unwrap();
        for m in 0..2 {
            let (low, high) = (bounds("lower", m), bounds("upper", m));
            assert!(low < high, "{gap}");
            for (side, value) in [("lower", low + 0.3 * (high - low)), ("upper", high - 0.3 * (high - low))] {
                let mut result = honest.clone();
                result["bracket"][key][side][m] = json!(value);
                let (code, text) = check(&result, directory.path());
                assert!(code == 1 && text.contains(&format!("NO  bracket.{key}")), "{gap} {side} {m}\n{text}");
            }
        }
    }
}

/// A ridge of three faces lies along a row of cells: bounds then turn on the last digit of where those are.
#[test]
fn proved_depths_of_pyramids_are_accepted() {
    let directory = tempfile::tempdir().unwrap();
    for step in 0..12 {
        let scene = scene(
            json!({"kind": "pyramid", "faces": 3, "inclination": 20.0}),
            json!({"force": 6e8 * 1.13_f64.powi(step)}),
            json!({"method": "fft"}),
            json!(["pressure"]),
        );
        let (code, text) = check(&solve(&scene, directory.path()), directory.path());
        assert_eq!(code, 0, "{step}\n{text}");
    }
}

/// What needs no proof when it is solved is found again without one, whatever the scene says.
#[test]
fn estimates_asked_for_by_the_command_are_accepted() {
    let directory = tempfile::tempdir().unwrap();
    let ring = json!({"kind": "formula", "expression": "4.506e-5*(1 - r^2/2.0305e-3)", "region": {"disc": 0.045061}});
    let worn = json!({"kind": "vickers", "flat": 1.0285e-5});
    let level = json!({"kind": "flat", "outline": {"polygon": [[0.0, 0.0], [0.03, 0.0], [0.03, 0.01], [0.01, 0.01], [0.01, 0.04], [0.0, 0.04]]}});
    for (gap, loading) in [
        (ring.clone(), json!({"force": 4600.0})),
        (ring, json!({"depth": 6.77e-7})),
        (worn, json!({"depth": 1.23e-6})),
        (level.clone(), json!({"depth": 1e-6})),
        (level, json!({"force": 20.0})),
    ] {
        let scene = scene(gap, loading, json!({}), json!(["patch", "pressure"]));
        std::fs::write(directory.path().join("scene.json"), scene.to_string()).unwrap();
        let arguments = ["solve", "scene.json", "--evidence", "estimate", "--json", "result.json"];
        let (code, text) = run(&arguments, directory.path());
        assert_eq!(code, 0, "{text}");
        let (code, text) = run(&["check", "scene.json", "result.json"], directory.path());
        assert_eq!(code, 0, "{scene}\n{text}");
    }
}

/// A bracket may come beside an estimate that is better.
#[test]
fn brackets_wider_than_the_stated_error_are_accepted() {
    let directory = tempfile::tempdir().unwrap();
    let gap = json!({"kind": "vickers", "flat": 3.751e-3, "rotate": 106.08});
    let scene = scene(gap, json!({"depth": 1.1956e-4}), json!({"method": "fft"}), json!(["pressure"]));
    let mut result = solve(&scene, directory.path());
    assert_eq!(result["evidence"], "estimated");
    assert!(result["bracket"]["lower"].is_number(), "{}", result["bracket"]);
    let (code, text) = check(&result, directory.path());
    assert_eq!(code, 0, "{text}");
    result["bracket"]["upper"] =
        json!(0.5 * (result["bracket"]["upper"].as_f64().unwrap() + result["force"].as_f64().unwrap()));
    let (code, text) = check(&result, directory.path());
    assert_eq!(code, 1, "{text}");
}

/// What options of `solve` said in place of the scene the result tells, and `check` goes by it; so it does by options of its own.
#[test]
fn results_of_other_settings_are_checked_with_these() {
    let directory = tempfile::tempdir().unwrap();
    let flat = json!({"kind": "flat", "outline": {"polygon": [[-1e-3, -2e-3], [2e-3, 0.0], [0.0, 1e-3]]}});
    let worn = json!({"kind": "vickers", "flat": 1.0285e-5});
    for (gap, depth, options, told) in [
        (
            worn,
            1.23e-6,
            &["--tolerance", "1e-2", "--evidence", "estimate"][..],
            json!({"tolerance": 1e-2, "evidence": "estimate"}),
        ),
        (flat, 1e-6, &["--tolerance", "5e-3", "--method", "auto"], json!({"tolerance": 5e-3})),
        (
            pyramid(),
            1e-6,
            &["--method", "fft", "--cells", "40", "--tolerance", "0.2"],
            json!({"method": "fft", "cells": 40, "tolerance": 0.2}),
        ),
    ] {
        let scene = scene(gap, json!({"depth": depth}), json!({}), json!(["patch", "pressure"]));
        std::fs::write(directory.path().join("scene.json"), scene.to_string()).unwrap();
        let (code, text) =
            run(&[&["solve", "scene.json", "--json", "result.json"], options].concat(), directory.path());
        assert_eq!(code, 0, "{text}");
        let mut result: Value =
            serde_json::from_slice(&std::fs::read(directory.path().join("result.json")).unwrap()).unwrap();
        assert_eq!(result["options"], told);
        for options in [&[][..], options] {
            let (code, text) = run(&[&["check", "scene.json", "result.json"], options].concat(), directory.path());
            assert_eq!(code, 0, "{scene}\n{text}");
        }
        let force = result["force"].as_f64().unwrap();
        result["force"] = json!(force * 1.1);
        assert_eq!(check(&result, directory.path()).0, 1, "{scene}");
        result["options"]["tolerance"] = json!(-1.0);
        let (code, text) = check(&result, directory.path());
        assert!(code == 2 && text.contains("options.tolerance"), "{text}");
    }
    let plain = scene(pyramid(), json!({"depth": 1e-6}), json!({"method": "fft", "cells": 40}), json!([]));
    assert_eq!(solve(&plain, directory.path()).get("options"), None);
    let (code, text) = run(&["check", "scene.json", "result.json", "--tolerance", "-1"], directory.path());
    assert!(code == 2 && text.contains("--tolerance"), "{text}");
}

#[test]
fn what_is_no_result_is_an_error_with_its_path() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(
        pyramid(),
        json!({"depth": 1e-6}),
        json!({"method": "qp", "cells": 16, "tolerance": 0.2}),
        json!(["pressure"]),
    );
    let honest = solve(&scene, directory.path());
    for (path, value, says) in [
        ("/patch", Value::Null, "patch: given nothing"),
        ("/force", json!("many"), "force: given \"many\""),
        ("/pressure/field/shape", json!([3, 3]), "pressure.field.shape"),
        ("/pressure/field/values/3", json!("x"), "pressure.field.values[3]"),
        ("/verdict", json!(7), "verdict"),
    ] {
        let mut result = honest.clone();
        *result.pointer_mut(path).unwrap() = value;
        let (code, text) = check(&result, directory.path());
        assert_eq!(code, 2, "{path}: {text}");
        assert!(text.contains(says), "{path}: {text}");
    }
    std::fs::write(directory.path().join("result.json"), "{").unwrap();
    assert_eq!(run(&["check", "scene.json", "result.json"], directory.path()).0, 2);
    assert_eq!(run(&["check", "scene.json", "nothing.json"], directory.path()).0, 2);
    assert_eq!(run(&["check", "nothing.json", "result.json"], directory.path()).0, 2);
}

#[test]
fn a_list_of_states_is_a_list_in_every_key() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(pyramid(), json!({"depths": [5e-7, 1e-6]}), json!({"method": "ritz"}), json!([]));
    let honest = solve(&scene, directory.path());
    let (code, text) = check(&honest, directory.path());
    assert!(code == 0 && text.contains("state 2:"), "{text}");
    let all = "a list of 2, one entry a state of loading";
    for (value, path, given, allowed) in [
        (json!([1.0]), "force", "a list of 1", all),
        (json!(1.0), "force", "1.0", all),
        (json!([null, 1.0]), "force", "nothing", "a number"),
        (json!([1.0, "x"]), "force", "\"x\"", "a number"),
    ] {
        let mut result = honest.clone();
        result[path] = value;
        let (code, text) = check(&result, directory.path());
        assert_eq!(code, 2, "{text}");
        assert!(text.contains(&format!("{path}: given {given}; allowed: {allowed}")), "{text}");
    }
    // What no result has is named.
    let mut result = honest.clone();
    result["extra"] = json!([{"number": 1.0}, {}]);
    let (code, text) = check(&result, directory.path());
    assert!(code == 0 && text.contains("extra.number"), "{text}");
}

#[test]
fn the_field_may_come_from_an_array() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(
        pyramid(),
        json!({"depth": 1e-6}),
        json!({"method": "qp", "cells": 16, "tolerance": 0.2}),
        json!(["pressure"]),
    );
    let result = solve(&scene, directory.path());
    let (code, text) = run(&["solve", "scene.json", "--field", "p.npy", "--json", "other.json"], directory.path());
    assert_eq!(code, 0, "{text}");
    let (code, text) = run(&["check", "scene.json", "other.json", "--field", "p.npy"], directory.path());
    assert_eq!(code, 0, "{text}");
    let mut bytes = std::fs::read(directory.path().join("p.npy")).unwrap();
    let k = result["pressure"]["field"]["values"].as_array().unwrap().iter().position(|p| *p != 0.0).unwrap();
    let start = bytes.len() - 8 * result["pressure"]["field"]["values"].as_array().unwrap().len() + 8 * k;
    let value = f64::from_le_bytes(bytes[start..start + 8].try_into().unwrap());
    bytes[start..start + 8].copy_from_slice(&(1.2 * value).to_le_bytes());
    std::fs::write(directory.path().join("p.npy"), bytes).unwrap();
    let (code, text) = run(&["check", "scene.json", "other.json", "--field", "p.npy"], directory.path());
    assert_eq!(code, 1, "{text}");
}

#[test]
fn a_field_beside_the_result_is_found() {
    let directory = tempfile::tempdir().unwrap();
    let scene =
        scene(pyramid(), json!({"depth": 1e-6}), json!({"method": "fft", "cells": 32, "tolerance": 0.2}), json!([]));
    std::fs::write(directory.path().join("scene.json"), scene.to_string()).unwrap();
    let (code, text) = run(&["solve", "scene.json", "--field", "p.npy", "--json", "result.json"], directory.path());
    assert_eq!(code, 0, "{text}");
    let bytes = std::fs::read(directory.path().join("result.json")).unwrap();
    assert!(bytes.len() < 4000, "{}", bytes.len());
    let result: Value = serde_json::from_slice(&bytes).unwrap();
    let field = &result["pressure"]["field"];
    assert!(field["values"].is_null() && field["file"] == "p.npy", "{field}");
    let (code, text) = run(&["check", "scene.json", "result.json"], directory.path());
    assert_eq!(code, 0, "{text}");
    std::fs::remove_file(directory.path().join("p.npy")).unwrap();
    let (code, text) = run(&["check", "scene.json", "result.json"], directory.path());
    assert!(code == 2 && text.contains("p.npy (no such file)"), "{code} {text}");
}

/// What the bodies do not reach is no part of what is checked: a region beyond the contact leaves a law, a proof by it, a formula.
#[test]
fn results_with_an_end_of_the_material_beyond_the_contact_are_accepted() {
    let directory = tempfile::tempdir().unwrap();
    let square = json!({"polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]});
    for expression in ["x^2/2 + y^2/8", "max(abs(x), 2*abs(y))", "x^4 + y^4", "0.3*r"] {
        for load in [json!({"depth": 0.05}), json!({"force": 1e7})] {
            let gap =
                json!({"kind": "formula", "expression": expression, "region": square, "at": [0.5, 0.2], "rotate": 20});
            let scene = scene(gap, load, json!({}), json!(["pressure", "bracket"]));
            let result = solve(&scene, directory.path());
            let (code, text) = check(&result, directory.path());
            assert_eq!(code, 0, "{scene}\n{text}");
        }
    }
}
