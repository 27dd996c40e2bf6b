//! The matrix-free solver against gaps of every kind, drawn at random: it always ends, with an answer that fulfils the conditions of
//! contact when they are recomputed from the pressure alone, or with a verdict.

mod random;

use contact_patch::matrix_free::{Settings, displacement, solve, solve_nested};
use contact_patch::{Discrete, Grid, Kernel, Unsolved, Verdict};
use random::Random;

const FAMILIES: usize = 12;

/// Twelve kinds of surface on cells of any shape and size, depths from 1e-100 to 1e150.
fn attack(number: usize) -> Discrete {
    let mut random = Random(7919 * number as u64 + 13);
    for _ in 0..3 {
        random.next();
    }
    let family = number % FAMILIES;
    let long = random.of(&[6, 20, 48, 96]);
    let shape = match family {
        // A line of cells, and few cells.
        4 => [1 + random.below(4), 1 + random.below(300)],
        5 => [1 + random.below(3), 1 + random.below(3)],
        _ => [1 + random.below(long), 1 + random.below(long)],
    };
    let ratio = random.of(&[1.0, 1.0, 0.3, 0.01, 100.0, 7.3]);
    let size = random.of(&[1.0, 1e-100, 1e120, 1e-9, 1e6]);
    let unit = random.of(&[1.0, 1e-100, 1e150, 1e-12]);
    let exponent = random.of(&[0.05, 0.3, 1.0, 2.0, 8.0, 60.0]);
    let [a, b, c, d] = [0; 4].map(|_| random.next());
    let waves: Vec<[f64; 4]> = (1..12)
        .map(f64::from)
        .map(|k| {
            let mut wave = || 3.0 * k * (random.next() - 0.5);
            let [x, y] = [wave(), wave()];
            [random.next() / k, x, y, 6.3 * random.next()]
        })
        .collect();
    let grid = Grid { origin: [0.0; 2], spacing: [size * ratio, size], shape };
    let along = |k: usize, n: usize, from: f64| (k as f64 + 0.5) / n as f64 - 0.2 - 0.6 * from;
    let overlap = (0..grid.len())
        .map(|k| {
            let (x, y) = (along(k % shape[0], shape[0], a), along(k / shape[0], shape[1], b));
            let noise = random.next();
            unit * match family {
                // White noise; waves; a power of the distance; ripples with pits.
                0 => noise - 1.0 + c,
                1 => waves.iter().map(|w| w[0] * (w[1] * x + w[2] * y + w[3]).sin()).sum::<f64>() + c - 0.5,
                2 => 1.0 - (1.0 + 30.0 * c) * x.hypot(y * (1.0 + 5.0 * d)).powf(exponent),
                3 => (40.0 * c * x).cos() * (40.0 * d * y).cos() - 0.9 * noise.powi(3),
                4 | 5 => 1.0 - 0.5 * c * noise,
                // A slanting strip; holes; nearly flat; spikes over a plain; few high summits; a pyramid with deep pits.
                6 if (x * (1.0 + 9.0 * c) + y).abs() < 0.02 + 0.1 * d => 1.0,
                6 => f64::NEG_INFINITY,
                7 if noise < d => f64::NEG_INFINITY,
                7 => 1.0 - c * noise,
                8 => 1.0 - c * 1e-9 * noise,
                9 => 1e-6 + f64::from(u8::from(noise > 0.98)) - c * 1e-5 * noise,
                10 => (-8.0 * noise / (c + 0.05)).exp() - 1e-3,
                _ if noise > 0.995 => -1e30,
                _ => 1.0 - (3.0 * x.abs()).max(4.0 * y.abs()) + 0.02 * noise,
            }
        })
        .collect();
    Discrete { grid, kernel: if d < 0.3 { Kernel::Collocation } else { Kernel::Galerkin }, overlap }
}

/// J = p.u/2 - f.p over the largest overlap and the area, with the conditions of contact checked on the way.
fn energy(name: &str, problem: &Discrete, pressure: &[f64], tolerance: f64) -> f64 {
    let deepest = problem.deepest();
    // Rounding of the displacement, beside what is asked.
    let slack = (1.001 * tolerance + 3e-13) * deepest.max(0.0);
    let mut energy = 0.0;
    for ((&p, &u), &f) in pressure.iter().zip(&displacement(problem, pressure)).zip(&problem.overlap) {
        assert!(p >= 0.0 && p.is_finite() && (f > 0.0 || p == 0.0), "{name}: p = {p:e} where f = {f:e}");
        assert!(f - u <= slack, "{name}: {:e} of the depth are penetrated", (f - u) / deepest);
        if p > 0.0 {
            assert!((f - u).abs() <= slack, "{name}: gap of {:e} under pressure", (u - f) / deepest);
            energy += p * (0.5 * u / deepest - f / deepest);
        }
    }
    energy
}

#[test]
fn gaps_of_every_kind_are_solved() {
    for number in 0..20 * FAMILIES {
        let problem = attack(number);
        let tolerance = [1e-8, 1e-12, 1e-5][number / FAMILIES % 3];
        let settings = Settings { tolerance, ..Settings::default() };
        let solved = [solve_nested(&problem, &settings), solve(&problem, None, &settings)].map(|solution| {
            let solution = solution.unwrap_or_else(|unsolved| panic!("{number}: {unsolved}"));
            assert!(solution.residuals.worst() <= tolerance, "{number}: {:?}", solution.residuals);
            energy(&number.to_string(), &problem, &solution.pressure, tolerance)
        });
        // Nothing lies lower than the solution: J - J* is of second order in the error, and p.r of first.
        let [a, b] = solved;
        assert!(a <= 0.0 && (a - b).abs() <= (10.0 * tolerance + 1e-12) * a.abs(), "{number}: {a:e} {b:e}");
    }
}

#[test]
fn a_closer_answer_has_less_energy() {
    for number in [0, 1, 3, 7, 9, 11, 13, 26] {
        let problem = attack(number);
        let mut before = f64::INFINITY;
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8, 1e-10] {
            let settings = Settings { tolerance, ..Settings::default() };
            let solution = solve(&problem, None, &settings).unwrap_or_else(|unsolved| panic!("{number}: {unsolved}"));
            let now = energy(&number.to_string(), &problem, &solution.pressure, tolerance);
            assert!(now <= before + 1e-12 * now.abs(), "{number} at {tolerance:e}: {now:e} after {before:e}");
            before = now;
        }
    }
}

#[test]
fn few_products_end_in_a_verdict_or_an_answer() {
    for number in 0..2 * FAMILIES {
        let problem = attack(number);
        for products in [0, 1, 2, 5] {
            match solve_nested(&problem, &Settings { products, ..Settings::default() }) {
                Ok(solution) => {
                    energy(&number.to_string(), &problem, &solution.pressure, 1e-8);
                }
                Err(unsolved) => assert_eq!(unsolved.verdict, Verdict::IterationLimit),
            }
        }
    }
}

/// Found at random: depths of 1e-200 on cells of 1e120 were answered with pressures of 1e-321, of which two digits are left.
#[test]
fn pressures_beyond_the_range_of_numbers_are_a_verdict() {
    let bowl = |size: f64, depth: f64| {
        let grid = Grid { origin: [0.0; 2], spacing: [size; 2], shape: [9, 7] };
        let overlap = (0..grid.len())
            .map(|k| depth * (1.0 - 0.05 * ((k % 9) as f64 - 4.0).powi(2) - 0.1 * ((k / 9) as f64 - 3.0).powi(2)))
            .collect();
        Discrete { grid, kernel: Kernel::Galerkin, overlap }
    };
    let outcomes = |problem: &Discrete| -> [Result<(), Unsolved>; 2] {
        let settings = Settings::default();
        [solve(problem, None, &settings), solve_nested(problem, &settings)].map(|solution| {
            let solution = solution?;
            energy("bowl", problem, &solution.pressure, settings.tolerance);
            Ok(())
        })
    };
    for (size, depth) in [(1e120, 1e-200), (1e-200, 1e150), (1.0, 1e-300), (1e-5, 1e-310), (1e300, 1e-5)] {
        for outcome in outcomes(&bowl(size, depth)) {
            assert_eq!(outcome.expect_err("out of range").verdict, Verdict::NotApplicable, "{size:e} {depth:e}");
        }
    }
    for (size, depth) in [(1e120, 1e-150), (1e-120, 1e150), (1e-150, 1e-280), (1e200, 1e250)] {
        for outcome in outcomes(&bowl(size, depth)) {
            assert!(outcome.is_ok(), "{size:e} {depth:e}: {outcome:?}");
        }
    }
}
