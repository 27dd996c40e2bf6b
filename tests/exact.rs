//! The grid methods against closed forms, converged values and the laws of the problem.
#![cfg(feature = "qp")]

use std::f64::consts::PI;

use approx::assert_relative_eq;
use contact_patch::gap::{Cone, Gap, Paraboloid, Place, Polyhedron, Power};
use contact_patch::geometry::Rect;
use contact_patch::{
    Body, Contact, Discrete, EffectiveModulus, Grid, Kernel, Loading, Method, Settings, Solution, Unsolved, qp, solve,
};

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).unwrap()
}

fn solved(modulus: EffectiveModulus, gap: impl Gap + 'static, depth: f64, settings: &Settings) -> Solution {
    let contact = Contact::new(modulus, gap, Loading::depth(depth)).unwrap();
    solve(&contact, settings).remove(0).or_else(Unsolved::accept_best).unwrap()
}

fn programme(cells: usize, kernel: Kernel) -> Settings {
    Settings { method: Method::Qp, cells: Some(cells), kernel, ..Settings::default() }
}

/// (1 - nu) P tan(alpha)/(mu d^2), the group of the paper: twice P tan(alpha)/(E* d^2).
fn papers_group(faces: usize, settings: &Settings) -> f64 {
    let punch = Polyhedron::pyramid(faces, PI / 4.0).unwrap();
    2.0 * solved(unit(), punch, 1.0, settings).force
}

#[test]
fn hartnetts_grid_gives_the_papers_force() {
    // Equation (24) prints 1.7725; grids of 49 x 49 over boxes of different size give 1.7674 to 1.7760.
    assert!((papers_group(3, &programme(49, Kernel::Collocation)) - 1.7725).abs() < 0.006);
}

#[test]
fn default_settings_reach_the_converged_pyramids() {
    // Converged by extrapolated Galerkin energies, h = 1/512: 1.764824(4) and 1.475232(4).
    let settings = Settings { method: Method::Qp, ..Settings::default() };
    assert_relative_eq!(papers_group(3, &settings), 1.764824, max_relative = 1e-3);
    assert_relative_eq!(papers_group(4, &settings), 1.475232, max_relative = 1e-3);
}

#[test]
fn error_falls_with_the_cells_for_both_kernels() {
    // Largest relative error of the force allowed at 25 and 49 cells: second order, with its jitter.
    for (kernel, allowed) in [(Kernel::Collocation, [6e-3, 2e-3]), (Kernel::Galerkin, [2e-3, 8e-4])] {
        for (cells, allowed) in [25, 49].into_iter().zip(allowed) {
            let settings = programme(cells, kernel);
            let sphere = solved(unit(), Paraboloid::new([1.0, 1.0]).unwrap(), 1.0, &settings);
            assert_relative_eq!(sphere.force, 4.0 / 3.0, max_relative = allowed);
            let cone = solved(unit(), Cone::with_slope(1.0).unwrap(), 1.0, &settings);
            assert_relative_eq!(cone.force, 2.0 / PI, max_relative = allowed);
        }
    }
}

#[test]
fn units_do_not_matter() {
    let group = |e: f64, nu: f64, depth: f64, degrees: f64| {
        let modulus = EffectiveModulus::of_pair(Body::elastic(e, nu).unwrap(), Body::RIGID).unwrap();
        let punch = Polyhedron::pyramid(3, degrees.to_radians()).unwrap();
        let force = solved(modulus, punch, depth, &programme(25, Kernel::Galerkin)).force;
        force * degrees.to_radians().tan() / (modulus.e_star() * depth * depth)
    };
    let reference = group(1.0, 0.0, 1.0, 45.0);
    assert_relative_eq!(group(2.1e11, 0.3, 1e-9, 45.0), reference, max_relative = 1e-10);
    assert_relative_eq!(group(1e-3, 0.5, 1e3, 1e-4), reference, max_relative = 1e-10);
    assert_relative_eq!(group(1e15, -0.99, 1e6, 89.9), reference, max_relative = 1e-10);
    assert_relative_eq!(group(1e-12, 0.4999999, 1e-12, 1e-6), reference, max_relative = 1e-10);
}

#[test]
fn residuals_are_rounding() {
    for cells in [25, 49] {
        let punch = Polyhedron::pyramid(3, 0.1).unwrap();
        let residuals = solved(unit(), punch, 1e-6, &programme(cells, Kernel::Galerkin)).residuals.unwrap();
        assert!(residuals.worst() < 1e-12, "{residuals:?}");
    }
}

#[test]
fn a_punch_moved_and_turned_by_quarters_feels_the_same_force() {
    let still = Polyhedron::new(vec![[1.0, 0.2, 0.0], [-0.7, 0.9, 0.0], [-0.3, -1.4, 0.0]]).unwrap();
    let settings = programme(25, Kernel::Galerkin);
    let reference = solved(unit(), still.clone(), 1.0, &settings);
    for quarter in 1..4 {
        let moved = still.clone().placed([30.0, -7.0], f64::from(quarter) * PI / 2.0).unwrap();
        let there = solved(unit(), moved, 1.0, &settings);
        assert_relative_eq!(there.force, reference.force, max_relative = 1e-10);
        // The line of action moves with the punch.
        let [mx, my] = reference.moment.unwrap();
        let (x, y) = (-my / reference.force, mx / reference.force);
        let (sin, cos) = (f64::from(quarter) * PI / 2.0).sin_cos();
        let [tx, ty] = there.moment.unwrap();
        assert_relative_eq!(-ty / there.force, 30.0 + cos * x - sin * y, max_relative = 1e-9);
        assert_relative_eq!(tx / there.force, -7.0 + sin * x + cos * y, max_relative = 1e-9);
    }
}

#[test]
fn negative_depth_is_no_contact() {
    let apart = solved(unit(), Cone::new(0.5).unwrap(), -1.0, &Settings::default());
    assert_eq!((apart.force, apart.stiffness, apart.patch.area), (0.0, 0.0, 0.0));
}

#[test]
fn a_larger_gap_means_a_smaller_force() {
    let settings = programme(24, Kernel::Galerkin);
    let force = |n: f64| solved(unit(), Power::new(1.0, n).unwrap(), 1.0, &settings).force;
    // Within r < 1 the gap r^n falls with n, and no contact reaches further.
    let forces: Vec<f64> = [0.5, 1.0, 2.0, 4.0, 10.0, 50.0].into_iter().map(force).collect();
    assert!(forces.windows(2).all(|pair| pair[0] < pair[1]), "{forces:?}");
}

#[test]
fn patch_and_stiffness_of_a_paraboloid() {
    let settings = programme(48, Kernel::Galerkin);
    let sphere = solved(unit(), Paraboloid::new([1.0, 1.0]).unwrap(), 1.0, &settings);
    // a^2 = R d, dP/dd = 2 E* a, U = 8/15 E* sqrt(R) d^(5/2).
    assert_relative_eq!(sphere.patch.area, PI, max_relative = 5e-3);
    assert_relative_eq!(sphere.patch.max_radius, 1.0, max_relative = 2e-2);
    assert_relative_eq!(sphere.stiffness, 2.0, max_relative = 1e-3);
    assert_relative_eq!(sphere.energy.unwrap(), 8.0 / 15.0, max_relative = 1e-3);
    assert_relative_eq!(sphere.pressure.max.unwrap(), 2.0 / PI, max_relative = 1e-2);
}

#[test]
fn a_contact_far_from_square_fits_its_box() {
    // Hertz with A/B = 1e-4 (Carlson forms, 17 digits): P = 28.153806191870622 E* d^2 B^(-1/2)... at E* = d = B = 1.
    let ellipse = solved(unit(), Paraboloid::new([0.5e4, 0.5]).unwrap(), 1.0, &programme(49, Kernel::Galerkin));
    assert_relative_eq!(ellipse.force, 28.153806191870622, max_relative = 1e-3);
    assert_relative_eq!(ellipse.patch.max_radius, 92.44432494624735, max_relative = 2e-2);
}

#[test]
fn clarabel_and_the_active_set_agree_without_a_mirror() {
    let (sin, cos) = 0.3_f64.sin_cos();
    let punch = Polyhedron::pyramid(3, PI / 4.0).unwrap();
    let turned = move |x: f64, y: f64| punch.gap(cos * x + sin * y, cos * y - sin * x);
    let grid = Grid::over(&Rect { min: [-1.7, -1.55], max: [1.5, 1.65] }, [78; 2]);
    let problem = Discrete::sample(&turned, 1.0, grid, Kernel::Galerkin);
    let [interior, pivots] = [qp::solve(&problem, None), qp::solve_by_active_set(&problem, None)].map(Result::unwrap);
    assert!(interior.symmetry.order() == 1 && interior.solution.unknowns > 3000, "{}", interior.solution.unknowns);
    let pressures = [&interior, &pivots].map(|found| &found.solution.pressure);
    let strongest = pressures[0].iter().copied().fold(0.0, f64::max);
    assert!(pressures[0].iter().zip(pressures[1]).all(|(p, q)| (p - q).abs() <= 1e-8 * strongest));
    assert!(pivots.solution.residuals.worst() < 1e-10);
}
