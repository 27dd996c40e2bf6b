//! The non-linear spring: what a curve says of itself, against forces that it did not see; and what is written of it.
#![cfg(feature = "cli")]

mod random;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use contact_patch::closed_form::RoundedCone;
use contact_patch::curve::{About, Beyond, Pose, TiltRange, TiltTable, TiltedForce, WarmContact};
use contact_patch::gap::{AnyGap, Cone, Flat, Gap, Outline, Paraboloid, Polyhedron, Revolved, Sum};
use contact_patch::{Contact, Curve, CurveRange, EffectiveModulus, Load, Loading, Method, Settings, Unsolved, solve};
use random::Random;
use serde_json::Value;

fn contact(gap: impl Gap + 'static, loading: Loading) -> Contact {
    Contact::new(EffectiveModulus::from_e_star(1.0).unwrap(), gap, loading).unwrap()
}

fn blunt() -> Polyhedron {
    Polyhedron::truncated_pyramid(4, 45f64.to_radians(), 1.0).unwrap()
}

fn fft(cells: usize) -> Settings {
    Settings { method: Method::Fft, cells: Some(cells), ..Settings::default() }
}

/// Depths between the ends, of equal ratio, none of them a state of the curve.
fn between(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from * (to / from).powf((k as f64 + 0.37) / count as f64))
}

/// The largest relative error of a curve against forces known otherwise.
fn error(curve: &Curve, depths: impl Iterator<Item = f64>, truth: impl Fn(f64) -> f64) -> f64 {
    depths.map(|d| (curve.force(d).unwrap() / truth(d) - 1.0).abs()).fold(0.0, f64::max)
}

fn solved(gap: &AnyGap, settings: Settings) -> impl Fn(f64) -> f64 {
    move |depth| {
        solve(&contact(gap.clone(), Loading::depth(depth)), &settings)
            .remove(0)
            .or_else(Unsolved::accept_best)
            .unwrap()
            .force
    }
}

/// Force and stiffness by a method.
fn both(gap: &AnyGap, settings: Settings) -> impl Fn(f64) -> [f64; 2] {
    move |depth| {
        let state = solve(&contact(gap.clone(), Loading::depth(depth)), &settings).remove(0).unwrap();
        [state.force, state.stiffness]
    }
}

#[test]
fn a_spring_of_a_truncated_pyramid_takes_few_solves() {
    // Flat at first (P ~ d), pyramid at the end (P ~ d^2).
    let gap = AnyGap::new(blunt());
    let settings = Settings { method: Method::Fft, ..Settings::default() };
    let range = CurveRange { from: 0.2, to: 4.0, accuracy: 1e-4 };
    let curve = Curve::new(&contact(gap.clone(), Loading::depth(1.0)), &settings, range).unwrap();
    let missed = error(&curve, between(0.2, 4.0, 50), solved(&gap, fft(256)));
    println!("solves {}, estimate {:e}, missed {missed:e}", curve.solves(), curve.interpolation_error());
    assert!(curve.solves() <= 20, "{}", curve.solves());
    // The grids of the comparison are themselves off by up to 4e-5.
    assert!(missed <= 1e-4 && missed <= curve.interpolation_error() + 4e-5, "{missed:e}");
    assert!(curve.interpolation_error() <= 1.5e-4, "{:e}", curve.interpolation_error());
    let mut before = [0.0; 2];
    for k in 1..=200 {
        let depth = 0.02 * f64::from(k);
        let here = [curve.force(depth).unwrap(), curve.stiffness(depth).unwrap()];
        assert!(here[0] > before[0] && here[1] >= before[1] * (1.0 - 1e-9), "not convex at {depth}");
        assert!((curve.depth(here[0]).unwrap() / depth - 1.0).abs() < 1e-10);
        before = here;
    }
}

#[test]
fn a_curve_from_grids_is_no_worse_than_it_says() {
    let grids = Settings { method: Method::Fft, ..Settings::default() };
    let check = |name: &str, gap: AnyGap, truth: &dyn Fn(f64) -> [f64; 2]| {
        let range = CurveRange { from: 0.05, to: 2.0, accuracy: 2e-4 };
        let curve = Curve::new(&contact(gap, Loading::depth(1.0)), &grids, range).unwrap();
        let [mut worst, mut slopes] = [0.0f64; 2];
        for depth in between(0.05, 2.0, 50) {
            let ([force, stiffness], said) = (truth(depth), curve.errors_at(depth).unwrap());
            let missed = [curve.force(depth).unwrap() / force - 1.0, curve.stiffness(depth).unwrap() / stiffness - 1.0];
            (worst, slopes) = (worst.max(missed[0].abs()), slopes.max(missed[1].abs()));
            assert!(
                missed[0].abs() <= said[0] && missed[1].abs() <= said[1],
                "{name} at {depth}: {missed:?} against {said:?}"
            );
        }
        let said = [curve.interpolation_error(), curve.stiffness_error()];
        println!("{name}: solves {}, estimates {said:?}, missed {worst:e}, {slopes:e}", curve.solves());
        // Where a profile has a kink the stiffness has one, too, and is known less well.
        assert!(said[0] <= 3e-4 && said[1] <= 6e-3, "{name}: {said:?}");
    };
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    // A sphere of radius 1/2 that goes over into a cone of slope 1.
    let tip = RoundedCone::new(modulus, 0.5, 1.0).unwrap();
    let rounded = |x: f64, y: f64| {
        let r = x.hypot(y);
        if r < 0.5 { r * r } else { r - 0.25 }
    };
    check("rounded cone", AnyGap::new(rounded), &|d| {
        let state = |d: f64| tip.at_depth(d).unwrap();
        let e = 1e-5 * d;
        [state(d).force, (state(d + e).force - state(d - e).force) / (2.0 * e)]
    });
    let sum = || {
        let (a, b) = (Paraboloid::new([1.0, 1.0]).unwrap(), Cone::with_slope(0.3).unwrap());
        AnyGap::new(Sum::new(vec![AnyGap::new(a), AnyGap::new(b)]).unwrap())
    };
    let formula = Settings { method: Method::ClosedForm, ..Settings::default() };
    check("paraboloid and cone", sum(), &both(&sum(), formula));
    let revolved = || AnyGap::new(Revolved::new(vec![[0.0, 0.0], [1.0, 0.4], [20.0, 14.0]]).unwrap());
    check("revolved", revolved(), &both(&revolved(), formula));
}

#[test]
fn a_curve_through_a_second_tip_is_no_worse_than_it_says() {
    let gap = AnyGap::new(|x: f64, y: f64| ((x - 1.0).powi(2) + y * y).min(0.3 + (x + 1.5).powi(2) + y * y));
    let range = CurveRange { from: 0.1, to: 1.5, accuracy: 2e-4 };
    let curve = Curve::new(&contact(gap.clone(), Loading::depth(1.0)), &Settings::default(), range).unwrap();
    let fine = Settings { tolerance: 3e-5, ..Settings::default() };
    let missed = error(&curve, between(0.1, 1.5, 12), solved(&gap, fine));
    println!("solves {}, estimate {:e}, missed {missed:e}", curve.solves(), curve.interpolation_error());
    assert!(missed <= curve.interpolation_error(), "{missed:e} against {:e}", curve.interpolation_error());
}

#[test]
fn a_curve_on_prescribed_cells_of_a_rough_surface_is_no_worse_than_it_says() {
    let gap = AnyGap::new(|x: f64, y: f64| {
        let waves = (9.0 * x + 1.0).sin() * (7.0 * y).cos() + (5.0 * x - 3.0 * y).cos();
        0.05 * (x * x + y * y) + 0.02 * (2.0 - waves)
    });
    let range = CurveRange { from: 0.01, to: 0.3, accuracy: 1e-3 };
    let curve = Curve::new(&contact(gap.clone(), Loading::depth(1.0)), &fft(64), range).unwrap();
    let depths = between(0.01, 0.3, 20).map(|s| curve.first_touch() + s);
    let missed = error(&curve, depths, solved(&gap, fft(64)));
    println!("solves {}, estimate {:e}, missed {missed:e}", curve.solves(), curve.interpolation_error());
    assert!(missed <= curve.interpolation_error(), "{missed:e} against {:e}", curve.interpolation_error());
}

#[test]
fn curves_by_the_approximate_methods() {
    let (a, b) = (Paraboloid::new([1.0, 1.5]).unwrap(), Polyhedron::pyramid(4, 0.3).unwrap());
    let gap = AnyGap::new(Sum::new(vec![AnyGap::new(a), AnyGap::new(b)]).unwrap());
    for method in [Method::Fabrikant, Method::Ritz] {
        let settings = Settings { method, ..Settings::default() };
        let range = CurveRange { from: 0.1, to: 4.0, accuracy: 1e-4 };
        let curve = Curve::new(&contact(gap.clone(), Loading::depth(1.0)), &settings, range).unwrap();
        let missed = error(&curve, between(0.1, 4.0, 50), solved(&gap, settings));
        println!(
            "{method:?}: solves {}, estimate {:e}, missed {missed:e}",
            curve.solves(),
            curve.interpolation_error()
        );
        assert!(curve.solves() <= 20 && missed <= curve.interpolation_error() && missed <= 1e-4, "{missed:e}");
    }
}

#[test]
fn a_homogeneous_gap_takes_one_solve() {
    let contact = contact(Cone::with_slope(1.0).unwrap(), Loading::depth(1.0));
    let curve = Curve::new(&contact, &fft(32), CurveRange { from: 0.01, to: 1.0, accuracy: 1e-6 }).unwrap();
    assert_eq!(curve.solves(), 1);
    let law = curve.power_law();
    assert!((law.exponent - 2.0).abs() < 1e-6 && law.error < 1e-5, "{law:?}");
}

/// Builds a program and returns what it prints.
fn compiled(folder: &Path, compiler: &str, options: &[&str], source: &str) -> String {
    let binary = folder.join("program");
    let mut command = Command::new(compiler);
    command.args([
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Wshadow",
        "-Wundef",
        "-Wcomment",
        "-Wtrigraphs",
        "-Werror",
        "-O1",
    ]);
    command.args(["-fsanitize=undefined", "-fno-sanitize-recover=all"]);
    let built = command.args(options).arg("-o").arg(&binary).arg(folder.join(source)).arg("-lm").output().unwrap();
    assert!(built.status.success(), "{options:?}: {}", String::from_utf8_lossy(&built.stderr));
    let ran = Command::new(&binary).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

#[test]
fn the_c_evaluator_is_the_library() {
    // The centre of pressure wanders: a second tip comes into contact.
    let gap = |x: f64, y: f64| ((x - 1.0).powi(2) + y * y).min(0.3 + (x + 1.5).powi(2) + y * y);
    let contact = contact(AnyGap::new(gap), Loading::depth(1.0));
    let range = CurveRange { from: 0.05, to: 1.1, accuracy: 1e-3 };
    let refusing = Curve::new(&contact, &Settings { tolerance: 1e-3, ..Settings::default() }, range).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let program = r#"#include <stdio.h>
#include "spring.h"
#include "spring.h"
int main(void) {
    int k;
    for (k = -5; k <= 330; k++) {
        double d = 0.005 * k, force, stiffness, slope, x, y;
        my_spring_evaluate(d, &force, &stiffness, &slope);
        my_spring_centre(d, &x, &y);
        printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", d, my_spring_force(d), my_spring_stiffness(d), slope,
               my_spring_area(d), x, y, my_spring_moving_force(d, -0.3, 2.0));
    }
    return 0;
}
"#;
    fs::write(folder.path().join("main.c"), program).unwrap();
    fs::write(folder.path().join("main.cpp"), program).unwrap();
    let languages = [
        ("cc", "-std=c89", "main.c"),
        ("cc", "-std=c99", "main.c"),
        ("cc", "-std=c11", "main.c"),
        ("c++", "-std=c++98", "main.cpp"),
        ("c++", "-std=c++17", "main.cpp"),
    ];
    for beyond in [Beyond::Power, Beyond::Tangent, Beyond::Refuse] {
        let curve = refusing.clone().continued(beyond);
        let about = About { scene: Some("two tips */ in \\ one ??/"), units: None };
        fs::write(folder.path().join("spring.h"), curve.c_header_about(about, "my spring")).unwrap();
        for (compiler, standard, source) in languages {
            let printed = compiled(folder.path(), compiler, &[standard], source);
            assert_eq!(printed.lines().count(), 336);
            for line in printed.lines() {
                let v: Vec<f64> = line.split(' ').map(|t| t.parse().unwrap()).collect();
                let Some([force, stiffness, slope]) = curve.derivatives(v[0]) else {
                    assert!(beyond == Beyond::Refuse && v[0] > 1.1 && v[1].is_nan() && v[2].is_nan(), "{line}");
                    continue;
                };
                let [x, y] = curve.centre(v[0]).unwrap();
                let moving = (force - 0.6 * force).max(0.0);
                let own = [force, stiffness, slope, curve.area(v[0]).unwrap(), x, y, moving];
                for (given, own) in v[1..].iter().zip(own) {
                    assert!((given - own).abs() <= 1e-11 * own.abs() + 1e-15, "{standard} {line}: {own}");
                }
            }
        }
    }
    // The area is that of the states, the stiffness the derivative of the force across the end of the range.
    let curve = refusing.continued(Beyond::Power);
    for state in curve.samples() {
        assert!((curve.area(state.depth).unwrap() / state.area - 1.0).abs() < 1e-12);
    }
    let end = curve.deepest();
    let step = |from: f64, to: f64| (curve.force(to).unwrap() - curve.force(from).unwrap()) / (to - from);
    assert!((step(end - 1e-6, end) / step(end, end + 1e-6) - 1.0).abs() < 1e-5);
}

#[test]
fn six_decades_of_a_truncated_pyramid() {
    // Flat at first, pyramid at the end; truth by grids of their own at depths that the curve did not see.
    let gap = AnyGap::new(blunt());
    let settings = Settings { seconds: 0.0, ..Settings::default() };
    let range = CurveRange { from: 1e-5, to: 10.0, accuracy: 1e-4 };
    let curve = Curve::new(&contact(gap.clone(), Loading::depth(1.0)), &settings, range).unwrap();
    let fine = Settings { tolerance: 1e-4, ..settings };
    let [mut worst, mut slopes] = [0.0f64; 2];
    for depth in between(1e-5, 10.0, SIX_DECADES) {
        let state = solve(&contact(gap.clone(), Loading::depth(depth)), &fine)
            .remove(0)
            .or_else(Unsolved::accept_best)
            .unwrap();
        worst = worst.max((curve.force(depth).unwrap() / state.force - 1.0).abs() - state.force_error.unwrap());
        slopes = slopes
            .max((curve.stiffness(depth).unwrap() / state.stiffness - 1.0).abs() - state.stiffness_error.unwrap());
    }
    let said = [curve.interpolation_error(), curve.stiffness_error()];
    println!("solves {}, estimates {said:?}, missed {worst:e} {slopes:e}", curve.solves());
    assert!(worst <= 1e-3 && worst <= said[0], "{worst:e}");
    assert!(slopes <= 1e-3 && slopes <= said[1], "{slopes:e}");
    // The values tell the slopes better than the grids do: 54 states where they are not asked.
    assert!(curve.solves() <= 40, "{}", curve.solves());
}

/// Depths at which the curve over six decades is checked.
const SIX_DECADES: usize = 8;

/// States of several kinds, whose errors leave no convex curve between them at once: the accuracy that was asked for is met.
#[test]
fn a_curve_has_the_accuracy_that_was_asked_for() {
    let pyramid = || Polyhedron::truncated_pyramid(4, 20f64.to_radians(), 1.0).unwrap();
    let settings = Settings { seconds: 0.0, ..Settings::default() };
    let range = CurveRange { from: 1e-6, to: 0.1, accuracy: 1e-3 };
    let curve = Curve::new(&contact(pyramid(), Loading::depth(1.0)), &settings, range).unwrap();
    assert!(curve.interpolation_error() <= range.accuracy, "{:e}", curve.interpolation_error());
    for state in curve.samples() {
        assert!((curve.force(state.depth).unwrap() / state.force - 1.0).abs() <= range.accuracy);
    }
}

#[test]
fn files_of_a_spring() {
    let contact = contact(Paraboloid::new([1.0, 1.0]).unwrap(), Loading::depth(1.0));
    let curve = Curve::new(&contact, &Settings::default(), CurveRange { from: 0.05, to: 1.0, accuracy: 1e-4 }).unwrap();
    assert_eq!(curve.csv(50).lines().count(), 51);
    assert!(curve.adams(50, 7).lines().all(|l| l.len() <= 80));
    let json: serde_json::Value = serde_json::from_str(&curve.json()).unwrap();
    assert_eq!(json["knots"].as_array().unwrap().len(), curve.knots().len());
    for line in curve.two_columns(50).lines() {
        let row: Vec<f64> = line.split(' ').map(|t| t.parse().unwrap()).collect();
        assert_eq!(curve.force(row[0]), Some(row[1]));
    }
}

#[test]
fn threads_and_the_start_of_a_curve() {
    let scene = r#"{"effective_modulus": 1.0, "gap": {"kind": "pyramid", "faces": 4, "inclination": 45.0, "flat": 0.5},
        "loading": {"depth": 0.5}, "solve": {"method": "fft"}}"#;
    let folder = folder(&[("blunt.json", scene)]);
    let run = |more: &[&str]| {
        let output =
            command(&[&["blunt.json", "--accuracy", "2e-3", "--format", "json"], more].concat(), folder.path());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), said.lines().count()), (Some(0), 1), "{said}");
        (serde_json::from_slice::<Value>(&output.stdout).unwrap(), said)
    };
    let (one, said) = run(&["--threads", "1", "--from", "0.01"]);
    assert_eq!(run(&["--threads", "2", "--from", "0.01"]).0, one, "the answer does not depend on the threads");
    assert!((one["states"][0]["depth"].as_f64().unwrap() - 0.01).abs() < 1e-15);
    let states = one["states"].as_array().unwrap().len();
    assert!(said.starts_with(&format!("{states} states solved from depth 1.000e-2 to 5.000e-1")), "{said}");
    assert!(
        said.contains("error of the force") && said.contains("of the stiffness") && said.contains("overlap^"),
        "{said}"
    );
    let (default, _) = run(&[]);
    assert!((default["states"][0]["depth"].as_f64().unwrap() - 0.0025).abs() < 1e-12);
}

#[test]
fn no_state_is_solved_where_a_map_is_all_noise() {
    // A ball of radius 1, with noise of 1e-3 in its heights.
    let (n, h) = (33, 0.05);
    let mut random = Random(1);
    let mut noise = || random.between(-1e-3, 1e-3);
    let row = |j: usize, noise: &mut dyn FnMut() -> f64| -> String {
        let height = |i: usize| 0.5 * h * h * ((i as f64 - 16.0).powi(2) + (j as f64 - 16.0).powi(2));
        (0..n).map(|i| format!("{:e} ", height(i) + noise())).collect::<String>() + "\n"
    };
    let map: String = (0..n).map(|j| row(j, &mut noise)).collect();
    let scene = r#"{"effective_modulus": 1.0, "gap": {"kind": "height_map", "file": "ball.txt", "spacing": [0.05, 0.05], "surface": "upper"},
        "loading": {"depth": 0.1}}"#;
    let folder = folder(&[("ball.json", scene), ("ball.txt", &map)]);
    let output = command(&["ball.json", "--accuracy", "1e-3", "--format", "json"], folder.path());
    let (json, said): (Value, _) =
        (serde_json::from_slice(&output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    let open = json["map_error"].as_f64().unwrap();
    assert!(open > 1e-3 && said.contains("samples of the gap leave another"), "{said}");
    // More than the two-hundredth of the range, and no more than a quarter.
    let (first, touch) = (json["states"][0]["depth"].as_f64().unwrap(), json["first_touch"].as_f64().unwrap());
    assert!(first - touch > 0.02 * (0.1 - touch) && first - touch <= 0.2501 * (0.1 - touch), "{first}");
}

fn command(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_contact-patch")).arg("curve").args(arguments).current_dir(folder).output().unwrap()
}

/// A folder with these scenes in it.
fn folder(scenes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes {
        fs::write(folder.path().join(name), scene).unwrap();
    }
    folder
}

const OVAL: &str = r#"{"effective_modulus": 2.0, "gap": {"kind": "paraboloid", "radii": [1.0, 3.0]}, "loading": "#;

#[test]
fn the_command_writes_every_form() {
    let scene = format!("{OVAL} {{\"depths\": [0.1, 0.5, 0.3]}}}}");
    let folder = folder(&[("oval.json", &scene)]);
    let text = |format: &str, file: &str| {
        let output = command(&["oval.json", "--format", format, "--output", file, "--steps", "50"], folder.path());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(output.stdout.is_empty());
        fs::read_to_string(folder.path().join(file)).unwrap()
    };
    let gap = Paraboloid::new([1.0, 3.0]).unwrap();
    let pressed = Contact::new(EffectiveModulus::from_e_star(2.0).unwrap(), gap, Loading::depth(0.5)).unwrap();
    let state = solve(&pressed, &Settings::default()).remove(0).unwrap();
    let near = |text: &str, value: f64| (text.trim().parse::<f64>().unwrap() / value - 1.0).abs() < 1e-9;

    let csv = text("csv", "oval.csv");
    assert_eq!(
        csv.lines().next(),
        Some(
            "depth,force,stiffness,area,pressure_max,centre_x,centre_y,force_error,stiffness_error,contact_depth,pressure_mean,beta,\
             semi_axis_major,semi_axis_minor"
        )
    );
    assert_eq!(csv.lines().count(), 51);
    let last: Vec<&str> = csv.lines().last().unwrap().split(',').collect();
    assert!(near(last[0], 0.5) && near(last[1], state.force) && near(last[2], state.stiffness), "{last:?}");
    assert!(near(last[3], state.patch.area) && near(last[4], state.pressure.max.unwrap()), "{last:?}");

    // The contact depth of a paraboloid is half its depth; the patch is no disc, so that beta is a little more than 1.
    let axes = state.patch.semi_axes.unwrap();
    assert!(near(last[9], 0.25) && near(last[10], state.pressure.mean.unwrap()), "{last:?}");
    assert!(
        (1.0..1.05).contains(&last[11].parse::<f64>().unwrap()) && near(last[12], axes[0]) && near(last[13], axes[1]),
        "{last:?}"
    );

    let json: Value = serde_json::from_str(&text("json", "oval.out")).unwrap();
    // Homogeneous: P ~ d^(3/2), one solve.
    assert_eq!(json["solves"], 1);
    assert!((json["power_law"]["exponent"].as_f64().unwrap() - 1.5).abs() < 1e-6);
    assert!(json["power_law"]["error"].as_f64().unwrap() < 1e-5);
    let law = json["power_law"]["coefficient"].as_f64().unwrap() * 0.5f64.powf(1.5);
    assert!((law / state.force - 1.0).abs() < 1e-5);

    assert!(
        json["stiffness_error"].as_f64().unwrap() < 1e-3
            && json["beyond"] == "power"
            && json["effective_modulus"] == 2.0
    );
    assert_eq!(json["map_error"], Value::Null);

    let columns = text("text", "oval.txt");
    assert!(columns.lines().count() == 51 && columns.lines().all(|l| l.split(' ').count() == 2));
    let last = columns.lines().last().unwrap().split(' ').collect::<Vec<_>>();
    assert!(near(last[0], 0.5) && near(last[1], state.force));

    let adams = text("adams", "oval.adm");
    assert!(adams.contains("SPLINE/1") && adams.lines().all(|l| l.len() <= 80));
    let numbers = adams
        .lines()
        .filter(|l| !l.starts_with('!'))
        .flat_map(|l| l.split(|c: char| c == ',' || c == '=' || c.is_whitespace()))
        .filter(|t| t.contains('e'));
    assert_eq!(numbers.filter(|t| t.parse::<f64>().is_ok()).count(), 2 * 51);

    let header = text("c", "oval.h");
    assert!(header.contains("double contact_force(double depth)"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 6, "nothing else is left");
}

#[test]
fn the_command_follows_forces_and_refuses_what_it_cannot_do() {
    let of = |loading: &str| format!("{OVAL} {loading}}}");
    let folder = folder(&[
        ("forces.json", &of(r#"{"forces": [0.01, 0.2]}"#)),
        ("moment.json", &of(r#"{"force": 0.2, "moment": [0.001, 0.0]}"#)),
        ("apart.json", &of(r#"{"depth": -0.1}"#)),
        ("wrong.json", &of(r#"{"depth": "deep"}"#)),
        (
            "endless.json",
            r#"{"effective_modulus": 1.0, "gap": {"kind": "paraboloid", "radii": [1.0, "flat"]}, "loading": {"depth": 1.0}}"#,
        ),
    ]);
    let output = command(&["forces.json", "--steps", "10"], folder.path());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let csv = String::from_utf8(output.stdout).unwrap();
    let force: f64 = csv.lines().last().unwrap().split(',').nth(1).unwrap().parse().unwrap();
    assert!((force / 0.2 - 1.0).abs() < 1e-9, "{force}");
    for (code, arguments) in [
        (2, &["moment.json"][..]),
        (2, &["apart.json"]),
        (2, &["wrong.json"]),
        (2, &["missing.json"]),
        (2, &["forces.json", "--accuracy", "-1"]),
        (2, &["forces.json", "--from", "-1"]),
        (2, &["forces.json", "--from", "1e9"]),
        (2, &["forces.json", "--from", "nan"]),
        (2, &["forces.json", "--threads", "0"]),
        (2, &["forces.json", "--beyond", "sideways"]),
        (2, &["forces.json", "--steps", "1"]),
        (2, &["forces.json", "--format", "xls"]),
        (1, &["endless.json"]),
    ] {
        let output = command(&[arguments, &["--output", "out"]].concat(), folder.path());
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        assert!(!output.stderr.is_empty() && output.stdout.is_empty(), "{arguments:?}");
        assert!(!folder.path().join("out").exists(), "{arguments:?} left a file");
    }
}

/// A slender body at an angle takes the grid of an upright one, and answers as that one does.
#[test]
fn a_warm_contact_lies_along_the_body() {
    let angle = 0.65_f64;
    let (sin, cos) = angle.sin_cos();
    let outward = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
    let upright = AnyGap::new(Paraboloid::new([40.0, 0.5]).unwrap());
    let at_an_angle = upright.placed([0.0; 2], angle).unwrap();
    let settings = Settings { tolerance: 2e-3, ..Settings::default() };
    let warm = |gap: AnyGap| WarmContact::new(&contact(gap, Loading::depth(1.0)), &settings);
    let (mut one, mut other) = (warm(upright), warm(at_an_angle));
    for k in 0..12 {
        let t = 0.3 * f64::from(k);
        let pose =
            Pose { depth: 0.01 * (1.0 + 0.2 * t.sin()), tilt: [1e-3 * t.cos(), 2e-3 * t.sin()], at: [0.1 * t, -0.05] };
        let turned = Pose { tilt: outward(pose.tilt), at: outward(pose.at), ..pose };
        let (a, b) = (one.reaction(pose).unwrap(), other.reaction(turned).unwrap());
        let off = |a: f64, b: f64, unit: f64| assert!((a - b).abs() <= 1e-6 * unit, "{k}: {a} {b}");
        off(a.force, b.force, a.force);
        off(a.area, b.area, a.area);
        (0..2).for_each(|n| off(outward(a.moment)[n], b.moment[n], a.force));
        // Along the body, as the upright one has it.
        let along = |v: [f64; 2]| {
            let k = |i: usize, j: usize| b.stiffness[i + 1][j + 1];
            (0..2).map(|i| (0..2).map(|j| v[i] * k(i, j) * v[j]).sum::<f64>()).sum::<f64>()
        };
        off(a.stiffness[0][0], b.stiffness[0][0], a.stiffness[0][0]);
        off(a.stiffness[1][1], along([cos, sin]), a.stiffness[1][1]);
    }
    assert_eq!(one.cost(), other.cost());
}

#[test]
fn a_warm_contact_is_the_contact_and_tells_its_error() {
    let gap = AnyGap::new(Paraboloid::new([1.0, 3.0]).unwrap());
    let settings = Settings { tolerance: 2e-3, ..Settings::default() };
    let mut warm = WarmContact::new(&contact(gap.clone(), Loading::depth(1.0)), &settings);
    let exact = |pose: &Pose| {
        // The body where it is: moved by hand.
        let load =
            Load::Tilted { depth: pose.depth + pose.tilt[0] * pose.at[0] + pose.tilt[1] * pose.at[1], tilt: pose.tilt };
        solve(&contact(gap.clone(), Loading::Single(load)), &Settings::default()).remove(0).unwrap()
    };
    for k in 0..30 {
        let t = 0.2 * f64::from(k);
        let pose =
            Pose { depth: 0.01 * (1.0 + 0.2 * t.sin()), tilt: [0.02 * t.cos(), 0.01 * t.sin()], at: [0.1 * t, -0.05] };
        let (found, truth) = (warm.reaction(pose).unwrap(), exact(&pose));
        assert!(
            (found.force / truth.force - 1.0).abs() <= found.error && found.error <= 4e-3,
            "{k}: {found:?} {}",
            truth.force
        );
        let [mx, my] = truth.moment.unwrap();
        let moment = [mx + truth.force * pose.at[1], my - truth.force * pose.at[0]];
        for n in 0..2 {
            assert!(
                (found.moment[n] - moment[n]).abs() <= 4e-3 * truth.force * (0.2 + pose.at[0]),
                "{k}: {found:?} {moment:?}"
            );
        }
    }
    let [steps, grids] = warm.cost();
    assert!(steps == 30 && grids <= 10, "{grids} grids");
    // The stiffness is the derivative of force and moments.
    let pose = Pose { depth: 0.01, tilt: [0.01, -0.02], at: [0.2, 0.1] };
    let here = warm.reaction(pose).unwrap();
    let sums = |pose: Pose, warm: &mut WarmContact| {
        let found = warm.force(pose).unwrap();
        [found.force, -found.moment[1], found.moment[0]]
    };
    for column in 0..3 {
        let moved = |by: f64| {
            let step = |n: usize| if n == column { by } else { 0.0 };
            Pose { depth: pose.depth + step(0), tilt: [pose.tilt[0] + step(1), pose.tilt[1] + step(2)], ..pose }
        };
        let e = [1e-4, 2e-4, 2e-4][column];
        let (low, high) = (sums(moved(-e), &mut warm), sums(moved(e), &mut warm));
        for row in 0..3 {
            let slope = (high[row] - low[row]) / (2.0 * e);
            let unit = (here.stiffness[row][row] * here.stiffness[column][column]).sqrt();
            assert!(
                (slope - here.stiffness[row][column]).abs() < 0.03 * unit,
                "{row} {column}: {slope} {:?}",
                here.stiffness
            );
        }
    }
    assert_eq!(warm.force(Pose { depth: -1.0, ..Pose::default() }).unwrap().force, 0.0);
    assert!(warm.force(Pose { depth: f64::NAN, ..Pose::default() }).is_err());
}

#[test]
fn a_warm_flat_punch_says_how_far_off_its_grid_is() {
    let disc = Flat::new(Outline::disc(1.0).unwrap());
    let mut warm = WarmContact::new(&contact(disc, Loading::depth(1.0)), &Settings::default());
    let found = warm.force(Pose { depth: 0.1, ..Pose::default() }).unwrap();
    // P = 2 E* a d; one grid misses it by more than the tolerance, and says so.
    let missed = (found.force / 0.2 - 1.0).abs();
    println!("missed {missed:e}, said {:e}", found.error);
    assert!(missed <= found.error && found.error < 0.1, "{missed:e} {:e}", found.error);
}

#[test]
fn a_table_of_a_crowned_roller_over_depth_and_tilt() {
    // A crown of the fourth degree: tilted, the contact moves and is no similar one.
    let gap = |x: f64, y: f64| 0.5 * y * y + 0.1 * x * x + 0.05 * x.powi(4);
    let roller = contact(AnyGap::new(gap), Loading::depth(1.0));
    let settings = Settings { threads: 2, ..Settings::default() };
    let range = TiltRange { overlap: [0.01, 0.1], tilt: [-0.05, 0.2], direction: 0.0, accuracy: 2e-3 };
    let table = TiltTable::new(&roller, &settings, range).unwrap();
    println!("{} states, error {:e}", table.solves(), table.error());
    assert!(table.error() <= 3e-3, "{:e}", table.error());
    for (s, tilt) in [(0.013, -0.03), (0.03, 0.011), (0.05, 0.07), (0.09, 0.123), (0.02, 0.19)] {
        // A depth with about this overlap.
        let depth = s - 1.2 * tilt * tilt;
        let load = Load::Tilted { depth, tilt: [tilt, 0.0] };
        let truth = solve(&contact(AnyGap::new(gap), Loading::Single(load)), &settings).remove(0).unwrap();
        let found = table.at(depth, tilt).unwrap();
        let patch = truth.patch.extent().unwrap();
        let (allowed, size) = (table.error() + truth.force_error.unwrap(), 0.5 * (patch[1][0] - patch[0][0]));
        assert!((found.force / truth.force - 1.0).abs() <= allowed, "{depth} {tilt}: {found:?} {}", truth.force);
        let moment = -truth.moment.unwrap()[1];
        assert!((found.moment - moment).abs() <= allowed * truth.force * size, "{depth} {tilt}: {found:?} {moment}");
        // One energy: force and moment are its derivatives, the stiffness theirs.
        let e = 1e-5 * s;
        let at = |d: f64, a: f64| table.at(depth + d, tilt + a).unwrap();
        let slopes = |of: &dyn Fn(TiltedForce) -> f64| {
            [(of(at(e, 0.0)) - of(at(-e, 0.0))) / (2.0 * e), (of(at(0.0, e)) - of(at(0.0, -e))) / (2.0 * e)]
        };
        let [[k, across], [other, own]] = found.stiffness;
        let scale = [k, (k * own.abs()).sqrt()];
        let near = |a: f64, b: f64, unit: f64| assert!((a - b).abs() < 1e-5 * unit.abs(), "{a} {b}");
        let by = slopes(&|f| f.energy);
        near(by[0], found.force, found.force);
        near(by[1], found.moment, found.force);
        let by = slopes(&|f| f.force);
        near(by[0], k, scale[0]);
        near(by[1], across, scale[1].max(across.abs()));
        let by = slopes(&|f| f.moment);
        near(by[0], other, scale[1].max(across.abs()));
        near(by[1], own, own);
    }
    assert!(table.at(0.05, 0.3).is_none());
    assert_eq!(table.at(-1.0, 0.0), Some(TiltedForce::default()));
}

/// A roller with sharp ends, off the origin and turned: cells along the user's axes took 60 s and told its force to 130 %.
#[test]
#[cfg(all(feature = "scene", feature = "formula"))]
fn a_turned_roller_has_the_curve_of_a_straight_one() {
    let curve = |degrees: f64| {
        let gap = serde_json::json!({
            "kind": "formula", "expression": "(x - 0.3)^2/2.8", "rotate": degrees,
            "region": {"polygon": [[-1.0, -1.0], [1.6, -1.0], [1.6, 0.6], [-1.0, 0.6]]}
        });
        let scene = serde_json::json!({"effective_modulus": 1.0, "gap": gap, "loading": {"depth": 1e-3}});
        let scene = contact_patch::Scene::from_json(scene.to_string().as_bytes()).unwrap();
        let range = CurveRange { from: 5e-6, to: 1e-3, accuracy: 1e-3 };
        Curve::new(&scene.contact, &Settings::default(), range).unwrap()
    };
    let (straight, turned) = (curve(0.0), curve(240.0));
    assert_eq!(turned.solves(), straight.solves());
    for depth in between(5e-6, 1e-3, 7) {
        let [a, b] = [&turned, &straight].map(|curve| curve.force(depth).unwrap());
        assert!((a / b - 1.0).abs() < 1e-6, "{depth}: {a} {b}");
        let [[x, y], [u, v]] = [&turned, &straight].map(|curve| curve.centre(depth).unwrap());
        let (sin, cos) = 240f64.to_radians().sin_cos();
        assert!((x - cos * u + sin * v).hypot(y - sin * u - cos * v) < 1e-6, "{depth}: {x} {y}");
    }
    assert!(turned.interpolation_error() < 1e-3);
}
