//! Loads and the spring: forces, moments, stiffness against differences, curves and what is written of them.
#![cfg(feature = "qp")]

use std::process::Command;

use contact_patch::gap::{AnyGap, Cone, Flat, Gap, Outline, Paraboloid, Polyhedron};
use contact_patch::{
    Contact, Curve, CurveRange, EffectiveModulus, Load, Loading, Method, Settings, Solution, Unsolved, Verdict, solve,
};

fn contact(gap: impl Gap + 'static, loading: Loading) -> Contact {
    Contact::new(EffectiveModulus::from_e_star(1.0).unwrap(), gap, loading).unwrap()
}

fn one(gap: impl Gap + 'static, load: Load, settings: &Settings) -> Result<Solution, Unsolved> {
    solve(&contact(gap, Loading::Single(load)), settings).remove(0)
}

fn blunt() -> Polyhedron {
    Polyhedron::truncated_pyramid(4, 45f64.to_radians(), 1.0).unwrap()
}

fn fft(cells: usize) -> Settings {
    Settings { method: Method::Fft, cells: Some(cells), ..Settings::default() }
}

#[test]
fn forces_over_twelve_decades_follow_the_scaling_law() {
    let punch = Polyhedron::pyramid(3, 45f64.to_radians()).unwrap();
    let forces: Vec<f64> = (0..64).map(|k| 10f64.powf(-6.0 + 12.0 * f64::from(k) / 63.0)).collect();
    let loading = Loading::Steps(forces.iter().map(|&p| Load::Force(p)).collect());
    let states: Vec<Solution> = solve(&contact(punch, loading), &fft(48)).into_iter().map(Result::unwrap).collect();
    for (state, force) in states.iter().zip(&forces) {
        // P ~ d^2.
        let law = states[0].depth * (force / forces[0]).sqrt();
        assert!((state.depth / law - 1.0).abs() < 1e-10, "force {force:e}: depth {:e}, law {law:e}", state.depth);
    }
}

#[test]
fn a_force_gives_back_the_depth_it_came_from() {
    // The grid methods meet a force to a twentieth of the tolerance; boxes differ from depth to depth.
    let settings = fft(64);
    let pressed = one(blunt(), Load::Depth(0.5), &settings).unwrap();
    let under = one(blunt(), Load::Force(pressed.force), &settings).unwrap();
    assert!((under.depth / 0.5 - 1.0).abs() < 2e-3, "{}", under.depth);
    assert_eq!(one(blunt(), Load::Force(-1.0), &settings).unwrap_err().verdict, Verdict::NoEquilibrium);
    assert_eq!(one(blunt(), Load::Force(0.0), &settings).unwrap().force, 0.0);
}

#[test]
fn a_paraboloid_loaded_off_its_axis_moves_its_apex() {
    // ax x - x^2/(2 R) = ax^2 R/2 - (x - ax R)^2/(2 R): the same contact about x = ax R, deeper by ax^2 R/2.
    let radius = 2.0;
    let gap = || Paraboloid::new([radius, radius]).unwrap();
    let central = one(gap(), Load::Force(0.3), &Settings::default()).unwrap();
    let through = [0.02, -0.01];
    let Loading::Single(load) = Loading::force_through(0.3, through) else { unreachable!() };
    let state = one(gap(), load, &Settings::default()).unwrap();
    for (a, x) in state.tilt.into_iter().zip(through) {
        assert!((a * radius / x - 1.0).abs() < 1e-3, "{:?}", state.tilt);
    }
    let rise = (state.tilt[0].powi(2) + state.tilt[1].powi(2)) * radius / 2.0;
    assert!(((state.depth + rise) / central.depth - 1.0).abs() < 1e-3);
    let [x, y] = state.patch.centroid.unwrap();
    assert!((x - through[0]).hypot(y - through[1]) < 1e-4);
}

#[test]
fn stiffness_is_the_slope_of_the_force_and_the_force_that_of_the_energy() {
    let settings = Settings { method: Method::ClosedForm, ..Settings::default() };
    for gap in [AnyGap::new(Cone::with_slope(0.7).unwrap()), AnyGap::new(Paraboloid::new([1.0, 3.0]).unwrap())] {
        // h^2/6 of the third derivative against rounding/h: 1e-8 with h = 1e-5 leaves room for both.
        let h = 1e-5;
        let [below, at, above] = [1.0 - h, 1.0, 1.0 + h].map(|d| one(gap.clone(), Load::Depth(d), &settings).unwrap());
        assert!(((above.force - below.force) / (2.0 * h) / at.stiffness - 1.0).abs() < 1e-8);
        let work = (above.energy.unwrap() - below.energy.unwrap()) / (2.0 * h);
        assert!((work / at.force - 1.0).abs() < 1e-8);
    }
}

#[test]
fn a_spring_of_a_truncated_pyramid_takes_few_solves() {
    let contact = contact(blunt(), Loading::depth(2.0));
    let settings = fft(128);
    let range = CurveRange { from: 0.25, to: 2.0, accuracy: 1e-4 };
    let curve = Curve::new(&contact, &settings, range).unwrap();
    println!("solves {}, error {:e}, {:?}", curve.solves(), curve.interpolation_error(), curve.power_law());
    assert!(curve.solves() <= 20, "{}", curve.solves());
    let mut before = [0.0; 2];
    for k in 1..=200 {
        let depth = 0.01 * f64::from(k);
        let here = [curve.force(depth).unwrap(), curve.stiffness(depth).unwrap()];
        assert!(here[0] > before[0] && here[1] >= before[1] * (1.0 - 1e-9), "not convex at {depth}");
        assert!((curve.depth(here[0]).unwrap() / depth - 1.0).abs() < 1e-10);
        before = here;
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

#[test]
fn a_square_punch_has_a_symmetric_positive_stiffness() {
    let square = Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap();
    let load = Load::ForceMoment { force: 1.0, moment: [0.1, 0.0] };
    let state = one(Flat::new(square), load, &fft(32)).unwrap();
    let k = state.stiffness_matrix.unwrap();
    for i in 0..3 {
        for j in 0..3 {
            assert!((k[i][j] - k[j][i]).abs() < 1e-6 * k[0][0], "{k:?}");
        }
    }
    // Leading minors; by symmetry depth and the two tilts do not couple.
    assert!(k[0][0] > 0.0 && k[1][1] > 0.0 && k[2][2] > 0.0 && k[0][1].abs().max(k[0][2].abs()) < 1e-6 * k[0][0]);
    // Whole contact: linear, so ay = Mx/K.
    assert!((state.tilt[1] * k[2][2] / 0.1 - 1.0).abs() < 1e-3 && state.tilt[0].abs() < 1e-6, "{:?}", state.tilt);
    let beyond = Load::ForceMoment { force: 1.0, moment: [0.0, -1.2] };
    let square = Outline::polygon(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]).unwrap();
    assert_eq!(one(Flat::new(square), beyond, &fft(32)).unwrap_err().verdict, Verdict::NoEquilibrium);
}

#[test]
fn a_load_that_walks_to_the_rim_empties_the_other_side() {
    let mut before = f64::NEG_INFINITY;
    for x in [0.0, 0.2, 0.4, 0.6] {
        let Loading::Single(load) = Loading::force_through(0.5, [x, 0.0]) else { unreachable!() };
        let state = one(blunt(), load, &fft(48)).unwrap();
        let centre = -state.moment.unwrap()[1] / state.force;
        assert!((centre - x).abs() < 2e-3, "{centre} for {x}");
        let middle = state.patch.centroid.unwrap()[0];
        assert!(middle >= before - 1e-3, "{middle} after {before}");
        before = middle;
    }
    assert!(before > 0.1, "{before}");
}
