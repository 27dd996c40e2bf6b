//! The non-linear spring: what a curve says of itself, against forces that it did not see; and what is written of it.
#![cfg(feature = "cli")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use contact_patch::closed_form::RoundedCone;
use contact_patch::gap::{AnyGap, Cone, Gap, Paraboloid, Polyhedron, Revolved, Sum};
use contact_patch::{Contact, Curve, CurveRange, EffectiveModulus, Loading, Method, Settings, Unsolved, solve};
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
    let check = |name: &str, gap: AnyGap, truth: &dyn Fn(f64) -> f64| {
        let range = CurveRange { from: 0.05, to: 2.0, accuracy: 2e-4 };
        let curve = Curve::new(&contact(gap, Loading::depth(1.0)), &grids, range).unwrap();
        let (missed, said) = (error(&curve, between(0.05, 2.0, 50), truth), curve.interpolation_error());
        println!("{name}: solves {}, estimate {said:e}, missed {missed:e}", curve.solves());
        assert!(missed <= said && said <= 3e-4, "{name}: {missed:e} against {said:e}");
    };
    let modulus = EffectiveModulus::from_e_star(1.0).unwrap();
    // A sphere of radius 1/2 that goes over into a cone of slope 1.
    let tip = RoundedCone::new(modulus, 0.5, 1.0).unwrap();
    let rounded = |x: f64, y: f64| {
        let r = x.hypot(y);
        if r < 0.5 { r * r } else { r - 0.25 }
    };
    check("rounded cone", AnyGap::new(rounded), &|d| tip.at_depth(d).unwrap().force);
    let sum = || {
        let (a, b) = (Paraboloid::new([1.0, 1.0]).unwrap(), Cone::with_slope(0.3).unwrap());
        AnyGap::new(Sum::new(vec![AnyGap::new(a), AnyGap::new(b)]).unwrap())
    };
    let formula = Settings { method: Method::ClosedForm, ..Settings::default() };
    check("paraboloid and cone", sum(), &solved(&sum(), formula));
    let revolved = || AnyGap::new(Revolved::new(vec![[0.0, 0.0], [1.0, 0.4], [20.0, 14.0]]).unwrap());
    check("revolved", revolved(), &solved(&revolved(), formula));
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

#[test]
fn the_c_evaluator_is_the_library() {
    let contact = contact(Paraboloid::new([1.0, 2.0]).unwrap(), Loading::depth(1.0));
    let curve = Curve::new(&contact, &Settings::default(), CurveRange { from: 0.05, to: 1.0, accuracy: 1e-4 }).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("spring.h"), curve.c_header("my spring")).unwrap();
    let program = r#"#include <stdio.h>
#include "spring.h"
int main(void) {
    for (int k = -5; k <= 205; k++) {
        double d = 0.005 * k;
        printf("%.17g %.17g %.17g\n", d, my_spring_force(d), my_spring_stiffness(d));
    }
    return 0;
}
"#;
    std::fs::write(folder.path().join("main.c"), program).unwrap();
    let (source, binary) = (folder.path().join("main.c"), folder.path().join("main"));
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Werror", "-O2", "-o"]).arg(&binary).arg(&source).arg("-lm");
    let built = compiler.output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let printed = String::from_utf8(Command::new(&binary).output().unwrap().stdout).unwrap();
    assert_eq!(printed.lines().count(), 211);
    for line in printed.lines() {
        let v: Vec<f64> = line.split(' ').map(|t| t.parse().unwrap()).collect();
        for (given, own) in [(v[1], curve.force(v[0])), (v[2], curve.stiffness(v[0]))] {
            match own {
                Some(own) => assert!((given - own).abs() <= 1e-12 * own, "{line}: {own}"),
                None => assert!(given.is_nan()),
            }
        }
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
    assert_eq!(csv.lines().next(), Some("depth,force,stiffness,area,pressure_max,centre_x,centre_y"));
    assert_eq!(csv.lines().count(), 51);
    let last: Vec<&str> = csv.lines().last().unwrap().split(',').collect();
    assert!(near(last[0], 0.5) && near(last[1], state.force) && near(last[2], state.stiffness), "{last:?}");
    assert!(near(last[3], state.patch.area) && near(last[4], state.pressure.max.unwrap()), "{last:?}");

    let json: Value = serde_json::from_str(&text("json", "oval.out")).unwrap();
    // Homogeneous: P ~ d^(3/2), one solve.
    assert_eq!(json["solves"], 1);
    assert!((json["power_law"]["exponent"].as_f64().unwrap() - 1.5).abs() < 1e-6);
    assert!(json["power_law"]["error"].as_f64().unwrap() < 1e-5);
    let law = json["power_law"]["coefficient"].as_f64().unwrap() * 0.5f64.powf(1.5);
    assert!((law / state.force - 1.0).abs() < 1e-5);

    let columns = text("text", "oval.txt");
    assert!(columns.lines().count() == 51 && columns.lines().all(|l| l.split(' ').count() == 2));
    let last = columns.lines().last().unwrap().split(' ').collect::<Vec<_>>();
    assert!(near(last[0], 0.5) && near(last[1], state.force));

    let adams = text("adams", "oval.adm");
    assert!(adams.contains("SPLINE/1") && adams.lines().all(|l| l.len() <= 80));
    let numbers = adams.split(|c: char| c == ',' || c == '=' || c.is_whitespace()).filter(|t| t.contains('e'));
    assert_eq!(numbers.filter(|t| t.parse::<f64>().is_ok()).count(), 2 * 51);

    let header = text("c", "oval.h");
    assert!(header.contains("static inline double contact_force(double depth)"));
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
