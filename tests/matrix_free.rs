//! The matrix-free solver against a dense active set, and the laws it must keep whatever the gap.

mod random;

use contact_patch::closed_form::Hertz;
use contact_patch::gap::Paraboloid;
use contact_patch::matrix_free::{Settings, Solver, solve, solve_nested, solve_under_force};
use contact_patch::{
    Contact, Discrete, DiscreteSolution, EffectiveModulus, Grid, InfluenceTable, Kernel, Loading, Method, Outputs,
    Verdict,
};
use nalgebra::{DMatrix, DVector};
use random::Random;

fn cells(shape: [usize; 2], spacing: [f64; 2]) -> Grid {
    Grid { origin: [0.0, 0.0], spacing, shape }
}

/// One of eight families: smooth, ridged, white noise, correlated noise, flat, several patches, tilted, holes.
fn random_problem(number: usize) -> Discrete {
    let mut random = Random(number as u64 + 1);
    let shape = [6 + (random.next() * 16.0) as usize, 6 + (random.next() * 16.0) as usize];
    let grid = cells(shape, [1.0 / shape[0] as f64, (0.5 + random.next()) / shape[1] as f64]);
    let [a, b, c] = [0; 3].map(|_| random.next());
    let waves: Vec<[f64; 4]> = (1..7)
        .map(|k| [0.3 / f64::from(k) * random.next(), 9.0 * random.next(), 9.0 * random.next(), 6.3 * random.next()])
        .collect();
    let overlap = (0..grid.len())
        .map(|k| {
            let [x, y] = grid.centre_of(k);
            let (x, y) = (x - 0.3 - 0.4 * a, y - 0.3 - 0.4 * b);
            let noise = random.next();
            match number % 8 {
                0 => 1.0 - (1.0 + 9.0 * c) * x * x - 6.0 * y * y,
                1 => 1.0 - (3.0 * x + c * y).abs().max(4.0 * y.abs()),
                2 => noise - 0.7 + 0.6 * c,
                3 => waves.iter().map(|w| w[0] * (w[1] * x + w[2] * y + w[3]).sin()).sum::<f64>() + 0.1 * c,
                4 if x.hypot(y) < 0.2 + 0.3 * c => 1.0,
                4 => f64::NEG_INFINITY,
                5 => 0.4 * (12.0 * x).cos() * (9.0 * y + c).cos(),
                6 => 0.5 + 0.5 * x + 0.3 * c * y,
                _ if noise < 0.2 => f64::NEG_INFINITY,
                _ => 1.0 - 5.0 * (x * x + y * y),
            }
        })
        .collect();
    let kernel = if number.is_multiple_of(3) { Kernel::Collocation } else { Kernel::Galerkin };
    Discrete { grid, kernel, overlap }
}

/// Active set with a dense Cholesky factor: drop tension, add penetration, until nothing changes.
fn dense(problem: &Discrete) -> Vec<f64> {
    let [nx, ny] = problem.grid.shape;
    let table = InfluenceTable::new(problem.kernel, problem.grid.spacing, [nx, ny]);
    let a = |k: usize, l: usize| table.get((k % nx).abs_diff(l % nx), (k / nx).abs_diff(l / nx));
    let candidates: Vec<usize> = (0..nx * ny).filter(|&k| problem.overlap[k] > 0.0).collect();
    let mut active = candidates.clone();
    let mut p = vec![0.0; nx * ny];
    for _ in 0..50 {
        let matrix = DMatrix::from_fn(active.len(), active.len(), |k, l| a(active[k], active[l]));
        let f = DVector::from_iterator(active.len(), active.iter().map(|&k| problem.overlap[k]));
        let solved = matrix.cholesky().expect("positive definite").solve(&f);
        p.fill(0.0);
        for (&k, &v) in active.iter().zip(&solved) {
            p[k] = v;
        }
        let next: Vec<usize> = candidates
            .iter()
            .copied()
            .filter(|&k| match active.binary_search(&k) {
                Ok(_) => p[k] > 0.0,
                Err(_) => active.iter().map(|&l| a(k, l) * p[l]).sum::<f64>() < problem.overlap[k] * (1.0 - 1e-13),
            })
            .collect();
        if next == active {
            return p;
        }
        active = next;
    }
    panic!("the active set did not settle");
}

fn force(p: &[f64], grid: &Grid) -> f64 {
    p.iter().sum::<f64>() * grid.cell_area()
}

/// What every answer must fulfil, recomputed here.
fn check(problem: &Discrete, solution: &DiscreteSolution, tolerance: f64) {
    let deepest = problem.deepest();
    assert!(solution.residuals.worst() <= tolerance, "{:?}", solution.residuals);
    for ((&p, &u), &f) in solution.pressure.iter().zip(&solution.displacement).zip(&problem.overlap) {
        assert!(p >= 0.0 && (f > 0.0 || p == 0.0));
        assert!(f - u <= tolerance * deepest);
        assert!(p == 0.0 || (f - u).abs() <= tolerance * deepest);
    }
}

#[test]
fn a_hundred_random_gaps_agree_with_a_dense_factorisation() {
    // Error of the gap 1e-12: the pressure follows with the condition of the matrix, below 1e3 on these grids.
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let mut touching = 0;
    for number in 0..100 {
        let problem = random_problem(number);
        let exact = dense(&problem);
        let strongest = exact.iter().copied().fold(0.0, f64::max);
        touching += usize::from(strongest > 0.0);
        for nested in [false, true] {
            let solution = if nested { solve_nested(&problem, &settings) } else { solve(&problem, None, &settings) };
            let solution = solution.unwrap_or_else(|unsolved| panic!("{number} {nested}: {unsolved}"));
            check(&problem, &solution, 1e-12);
            let (found, wanted) = (force(&solution.pressure, &problem.grid), force(&exact, &problem.grid));
            assert!((found - wanted).abs() <= 1e-9 * wanted, "{number}: {found} {wanted}");
            for (p, q) in solution.pressure.iter().zip(&exact) {
                assert!((p - q).abs() <= 1e-7 * strongest, "{number}: {p} {q}");
            }
        }
    }
    assert!(touching > 90);
}

#[test]
fn rough_surfaces_of_many_cells_always_end() {
    let cases =
        [(1, [64, 64], 0.5), (2, [100, 30], 0.05), (3, [64, 64], 0.99), (4, [1, 200], 0.5), (5, [128, 128], 0.3)];
    for (seed, shape, share) in cases {
        let mut random = Random(seed);
        let grid = cells(shape, [1.0, 1.0]);
        let overlap = (0..grid.len()).map(|_| random.next() - 1.0 + share).collect();
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap };
        let solution = solve_nested(&problem, &Settings::default()).unwrap_or_else(|unsolved| panic!("{unsolved}"));
        check(&problem, &solution, 1e-8);
    }
}

#[test]
fn few_cells_thin_lines_and_nothing() {
    for shape in [[1, 1], [2, 1], [1, 3], [5, 1], [2, 2], [1, 400], [300, 2]] {
        for spacing in [[1.0, 1.0], [1.0, 0.01]] {
            let grid = cells(shape, spacing);
            let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: vec![1.0; grid.len()] };
            let solution = solve_nested(&problem, &Settings::default());
            check(&problem, &solution.unwrap_or_else(|unsolved| panic!("{shape:?} {unsolved}")), 1e-8);
        }
    }
    let grid = cells([40, 40], [1.0, 1.0]);
    for f in [0.0, -1.0, f64::NEG_INFINITY] {
        let problem = Discrete { grid, kernel: Kernel::Collocation, overlap: vec![f; grid.len()] };
        let solution = solve_nested(&problem, &Settings::default()).expect("no contact is an answer");
        assert!(solution.pressure.iter().all(|&p| p == 0.0));
        assert_eq!(solution.operator_products, 0);
    }
    let mut one = vec![-1.0; 1600];
    one[777] = 0.5;
    let problem = Discrete { grid, kernel: Kernel::Collocation, overlap: one };
    check(&problem, &solve_nested(&problem, &Settings::default()).expect("one cell"), 1e-8);
}

#[test]
fn limit_of_products_is_a_verdict() {
    let problem = random_problem(0);
    let unsolved =
        solve(&problem, None, &Settings { products: 3, ..Settings::default() }).expect_err("three are too few");
    assert_eq!(unsolved.verdict, Verdict::IterationLimit);
}

#[test]
fn any_start_gives_the_same_answer_and_a_good_one_saves_work() {
    let grid = cells([60, 50], [1.0 / 60.0, 1.0 / 50.0]);
    let overlap = |depth: f64| {
        (0..grid.len())
            .map(|k| {
                let [x, y] = grid.centre_of(k);
                depth - (4.0 * (x - 0.5).abs()).max(3.0 * (y - 0.5).abs())
            })
            .collect::<Vec<_>>()
    };
    let settings = Settings { tolerance: 1e-11, ..Settings::default() };
    let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap: overlap(1.0) };
    let cold = solve(&problem, None, &settings).expect("solved");
    let before = Discrete { overlap: overlap(0.999), ..problem.clone() };
    let warm_start = solve(&before, None, &settings).expect("solved").pressure;
    let warm = solve(&problem, Some(&warm_start), &settings).expect("solved");
    let odd: Vec<f64> =
        (0..grid.len()).map(|k| if k % 3 == 0 { f64::NAN } else { 50.0 * (k % 7) as f64 - 60.0 }).collect();
    let odd = solve(&problem, Some(&odd), &settings).expect("solved");
    let same = solve(&problem, Some(&cold.pressure), &settings).expect("solved");
    for other in [&warm, &odd, &same, &solve_nested(&problem, &settings).expect("solved")] {
        let difference = (force(&other.pressure, &grid) / force(&cold.pressure, &grid) - 1.0).abs();
        assert!(difference < 1e-9, "{difference:e}");
    }
    assert!(same.operator_products <= 2, "{}", same.operator_products);
    assert!(warm.operator_products < cold.operator_products);
}

#[test]
fn pressure_scales_with_the_depth_and_with_the_size() {
    let problem = random_problem(8);
    let settings = Settings { tolerance: 1e-11, ..Settings::default() };
    let base = solve_nested(&problem, &settings).expect("solved");
    for (depth, size) in [(1e-9, 1.0), (1e7, 1e-3), (1.0, 1e6)] {
        let mut other = problem.clone();
        other.overlap.iter_mut().for_each(|f| *f *= depth);
        other.grid.spacing = other.grid.spacing.map(|h| h * size);
        let scaled = solve_nested(&other, &settings).expect("solved");
        let ratio = force(&scaled.pressure, &other.grid) / force(&base.pressure, &problem.grid) / (depth * size);
        assert!((ratio - 1.0).abs() < 1e-10, "{ratio}");
    }
}

#[cfg(feature = "parallel")]
#[test]
fn threads_do_not_change_the_answer() {
    let problem = random_problem(16);
    let one = solve_nested(&problem, &Settings::default()).expect("solved");
    for threads in [2, 3, 8] {
        let many = solve_nested(&problem, &Settings { threads, ..Settings::default() }).expect("solved");
        assert_eq!(one, many);
    }
}

#[test]
fn a_mirror_in_the_gap_does_not_change_the_answer() {
    // The same punch on a grid that it lies on evenly, either way round, and with one cell more on one side.
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let on = |shape: [usize; 2], middle: [f64; 2], turned: bool| {
        let grid = cells(shape, [0.05, 0.05]);
        let overlap = (0..grid.len())
            .map(|k| {
                let [x, y] = grid.centre_of(k);
                let [u, v] = if turned { [y - middle[1], x - middle[0]] } else { [x - middle[0], y - middle[1]] };
                // Even in v, not in u.
                1.0 - u.max(-0.6 * u + 1.1 * v.abs())
            })
            .collect();
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap };
        force(&solve_nested(&problem, &settings).expect("solved").pressure, &grid)
    };
    let upright = on([50, 60], [1.5, 1.5], false);
    let turned = on([60, 50], [1.5, 1.5], true);
    // An overlap of one far cell breaks the mirror and nothing else.
    let grid = cells([50, 61], [0.05, 0.05]);
    let broken = {
        let overlap = (0..grid.len())
            .map(|k| {
                let [x, y] = grid.centre_of(k);
                let [u, v] = [x - 1.5, y - 1.5];
                if k == 60 * 50 { 1e-9 } else { 1.0 - u.max(-0.6 * u + 1.1 * v.abs()) }
            })
            .collect();
        let problem = Discrete { grid, kernel: Kernel::Galerkin, overlap };
        force(&solve_nested(&problem, &settings).expect("solved").pressure, &grid)
    };
    assert!((turned / upright - 1.0).abs() < 1e-10, "{turned} {upright}");
    assert!((broken / upright - 1.0).abs() < 1e-10, "{broken} {upright}");
}

/// A ridged punch at this place and depth over a window of the surface.
fn punch_at(corner: [f64; 2], shape: [usize; 2], at: [f64; 2], depth: f64) -> Discrete {
    let grid = Grid { origin: corner, spacing: [0.05, 0.04], shape };
    let overlap = (0..grid.len())
        .map(|k| {
            let [x, y] = grid.centre_of(k);
            let [u, v] = [x - at[0], y - at[1]];
            depth - u.max(-0.6 * u + 1.1 * v.abs())
        })
        .collect();
    Discrete { grid, kernel: Kernel::Galerkin, overlap }
}

#[test]
fn one_problem_after_another_has_the_answers_of_each_alone() {
    let settings = Settings { tolerance: 1e-10, ..Settings::default() };
    let mut solver = Solver::new(settings);
    let far = [f64::NEG_INFINITY; 100];
    let sequence = [
        // Load steps, deeper and back.
        (punch_at([-2.5, -2.0], [90, 100], [0.0, 0.0], 1.0), false),
        (punch_at([-2.5, -2.0], [90, 100], [0.0, 0.0], 1.01), true),
        (punch_at([-2.5, -2.0], [90, 100], [0.0, 0.0], 1.0), true),
        // The punch moves, then the window with it, by whole cells and by parts of one.
        (punch_at([-2.5, -2.0], [90, 100], [0.013, 0.007], 1.0), false),
        (punch_at([-2.45, -2.04], [90, 100], [0.013, 0.007], 1.0), true),
        (punch_at([-2.43, -1.99], [88, 97], [0.013, 0.007], 1.0), false),
        // The contact is elsewhere, of another size, gone, and back.
        (punch_at([-2.5, -2.0], [90, 100], [-1.5, -1.2], 0.3), false),
        (punch_at([-2.5, -2.0], [90, 100], [0.6, 0.9], 1.0), false),
        (Discrete { overlap: far.to_vec(), ..punch_at([0.0, 0.0], [10, 10], [0.0, 0.0], 1.0) }, false),
        (random_problem(3), false),
        (random_problem(12), false),
        (punch_at([-2.5, -2.0], [90, 100], [0.6, 0.9], 1.0), false),
    ];
    for (step, (problem, near)) in sequence.iter().enumerate() {
        let next = solver.solve(problem).unwrap_or_else(|unsolved| panic!("{step}: {unsolved}"));
        let alone = solve(problem, None, &settings).expect("solved");
        let strongest = alone.pressure.iter().copied().fold(0.0, f64::max);
        if strongest > 0.0 {
            check(problem, &next, 1e-10);
        }
        for (p, q) in next.pressure.iter().zip(&alone.pressure) {
            assert!((p - q).abs() <= 1e-6 * strongest, "{step}: {p} {q}");
        }
        if *near {
            let (next, alone) = (next.operator_products, alone.operator_products);
            assert!(next < alone, "{step}: {next} {alone}");
        }
    }
}

#[test]
fn hertz_a_hundred_times_longer_than_wide() {
    let modulus = EffectiveModulus::from_e_star(1.0).expect("positive");
    let radii = [2000.0, 1.0];
    let hertz = Hertz::new(modulus, radii).expect("two radii");
    assert!((100.0 * hertz.axis_ratio() - 1.0).abs() < 0.01, "{}", hertz.axis_ratio());
    let exact = hertz.at_depth(1.0).expect("a depth").force;
    let contact = Contact::new(modulus, Paraboloid::new(radii).expect("radii"), Loading::depth(1.0)).expect("a depth");
    for kernel in [Kernel::Galerkin, Kernel::Collocation] {
        let outputs = Outputs { pressure: true, ..Outputs::default() };
        let settings =
            contact_patch::Settings { method: Method::Fft, kernel, outputs, ..contact_patch::Settings::default() };
        let solution = contact_patch::solve(&contact, &settings).remove(0).expect("solved");
        assert!((solution.force / exact - 1.0).abs() < 1e-3, "{kernel:?}: {} {exact}", solution.force);
        let [hx, hy] = solution.pressure.field.expect("asked for").grid.spacing;
        assert!(hx > 20.0 * hy, "cells as slender as the contact asks for: {hx} {hy}");
    }
}

#[test]
fn under_a_force_the_answer_is_that_of_its_depth() {
    let settings = Settings::default();
    let mut loaded = 0;
    for number in 0..100 {
        let problem = random_problem(number);
        let at_depth = solve_nested(&problem, &settings).expect("solved");
        let wanted = force(&at_depth.pressure, &problem.grid);
        if wanted <= 0.0 || at_depth.unknowns < 20 {
            continue;
        }
        loaded += 1;
        let deepest = problem.deepest();
        for (guess, start) in [(-0.02, None), (0.3, None), (0.01, Some(&at_depth.pressure))] {
            let off = guess * deepest;
            let guessed = Discrete { overlap: problem.overlap.iter().map(|f| f + off).collect(), ..problem.clone() };
            let start = start.map(Vec::as_slice);
            let (deeper, solution) = solve_under_force(&guessed, wanted, start, &settings)
                .unwrap_or_else(|unsolved| panic!("{number} {guess}: {unsolved}"));
            assert!((deeper + off).abs() < 1e-6 * deepest, "{number} {guess}: {deeper} {off}");
            let found = force(&solution.pressure, &problem.grid);
            assert!((found / wanted - 1.0).abs() < 1e-8, "{number} {guess}: {found} {wanted}");
            let there = Discrete { overlap: guessed.overlap.iter().map(|f| f + deeper).collect(), ..problem.clone() };
            check(&there, &solution, 1e-8);
        }
    }
    assert!(loaded > 60, "{loaded}");
}
