//! Cost of the matrix-free solver, in units that do not depend on the machine's clock: products on the finest grid, and
//! CPU time over the raw transforms of one product, measured in the same run.
//!
//!     cargo bench --bench matrix_free -- [largest N, 1024 unless said]
//!
//! "raw": the one-dimensional transforms of one zero-padded product over the whole N by N box, on buffers that stay in
//! the cache: N real rows there and back, N + 1 complex columns there and back, all of length 2N.

use std::hint::black_box;
use std::time::Instant;

use contact_patch::gap::Gap;
use contact_patch::geometry::Rect;
use contact_patch::matrix_free::{Operator, Scratch, Settings, solve, solve_nested};
use contact_patch::{Discrete, Grid, InfluenceTable, Kernel};
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// CPU seconds of this process so far; where they cannot be read, seconds.
fn cpu(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    match text.split_whitespace().next().and_then(|ns| ns.parse::<f64>().ok()) {
        Some(ns) => 1e-9 * ns,
        None => start.elapsed().as_secs_f64(),
    }
}

/// CPU seconds of a call: least mean of three batches of at least 0.15 s, after one call that warms up.
/// (The clock ticks in milliseconds: one call would be too short.)
fn seconds(mut call: impl FnMut()) -> f64 {
    call();
    let clock = Instant::now();
    let mut batch = || {
        let (before, mut calls) = (cpu(clock), 0.0);
        loop {
            call();
            calls += 1.0;
            let spent = cpu(clock) - before;
            if spent > 0.15 {
                return spent / calls;
            }
        }
    };
    batch().min(batch()).min(batch())
}

fn raw(n: usize) -> f64 {
    let (mut real, mut complex) = (RealFftPlanner::<f64>::new(), FftPlanner::<f64>::new());
    let (there, back) = (real.plan_fft_forward(2 * n), real.plan_fft_inverse(2 * n));
    let (down, up) = (complex.plan_fft_forward(2 * n), complex.plan_fft_inverse(2 * n));
    let (mut row, mut spectrum) = (there.make_input_vec(), there.make_output_vec());
    let mut column = vec![Complex::new(0.0, 0.0); 2 * n];
    let mut scratch = vec![Complex::new(0.0, 0.0); 16 * n + 64];
    seconds(|| {
        for _ in 0..n {
            there.process_with_scratch(&mut row, &mut spectrum, &mut scratch).expect("lengths fit");
            back.process_with_scratch(&mut spectrum, &mut row, &mut scratch).expect("lengths fit");
        }
        for _ in 0..=n {
            down.process_with_scratch(&mut column, &mut scratch);
            up.process_with_scratch(&mut column, &mut scratch);
        }
        black_box((&row, &column));
    })
}

fn pyramid(faces: usize) -> impl Gap {
    move |x: f64, y: f64| {
        (0..faces)
            .map(|k| {
                let (s, c) = (std::f64::consts::TAU * k as f64 / faces as f64).sin_cos();
                x * c + y * s
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

fn main() {
    let largest = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(1024);
    let boxes: [(&str, Box<dyn Gap>, Rect); 4] = [
        ("3 faces", Box::new(pyramid(3)), Rect { min: [-1.75, -1.4], max: [1.05, 1.4] }),
        ("4 faces", Box::new(pyramid(4)), Rect { min: [-1.1, -1.1], max: [1.1, 1.1] }),
        ("paraboloid", Box::new(|x: f64, y: f64| 0.5 * (x * x + y * y)), Rect { min: [-1.1, -1.1], max: [1.1, 1.1] }),
        (
            "ellipse",
            Box::new(|x: f64, y: f64| 0.5 * (x * x + 3.0 * y * y)),
            Rect { min: [-1.3, -1.3], max: [1.3, 1.3] },
        ),
    ];
    println!(
        "{:>5} {:>10} {:>9} {:>8} {:>9} {:>8} {:>8} {:>8} {:>9} {:>8}",
        "N", "gap", "products", "warm 1%", "raw ms", "product", "solve", "table", "CPU ms", "1e-3 ms"
    );
    let mut n = 32;
    while n <= largest {
        let raw = raw(n);
        let table = seconds(|| drop(black_box(InfluenceTable::new(Kernel::Galerkin, [1.0, 1.0], [n, n]))));
        let operator =
            Operator::compliance(&InfluenceTable::new(Kernel::Galerkin, [1.0, 1.0], [n, n]), [1.0, 1.0], [n, n]);
        let (p, mut u, mut scratch) = (vec![1.0; n * n], vec![0.0; n * n], Scratch::new());
        let product = seconds(|| operator.apply(&p, 0..n, &mut u, 0..n, &mut scratch));
        for (name, gap, extent) in &boxes {
            let grid = Grid::over(extent, [n, n]);
            let mut problem = Discrete::sample(&|x: f64, y: f64| gap.gap(x, y), 1.0, grid, Kernel::Collocation);
            problem.kernel = Kernel::Galerkin;
            let settings = Settings::default();
            let solution = match solve_nested(&problem, &settings) {
                Ok(solution) => solution,
                Err(unsolved) => {
                    println!("{n:>5} {name:>10} {unsolved}");
                    continue;
                }
            };
            let mut next = problem.clone();
            next.overlap.iter_mut().for_each(|f| *f += 0.01);
            let warm = solve(&next, Some(&solution.pressure), &settings).map_or(0, |s| s.operator_products);
            let whole = seconds(|| drop(black_box(solve_nested(&problem, &settings))));
            let rough = seconds(|| drop(black_box(solve_nested(&problem, &Settings { tolerance: 1e-3, ..settings }))));
            println!(
                "{n:>5} {name:>10} {:>9} {warm:>8} {:>9.3} {:>8.2} {:>8.1} {:>8.2} {:>9.3} {:>8.3}",
                solution.operator_products,
                1e3 * raw,
                product / raw,
                whole / raw,
                table / raw,
                1e3 * whole,
                1e3 * rough
            );
        }
        n *= 2;
    }
    #[cfg(feature = "parallel")]
    for n in [512, 1024] {
        if n > largest {
            break;
        }
        let grid = Grid::over(&boxes[0].2, [n, n]);
        let problem = Discrete::sample(&|x: f64, y: f64| boxes[0].1.gap(x, y), 1.0, grid, Kernel::Collocation);
        let time = |threads| {
            let clock = Instant::now();
            drop(black_box(solve_nested(&problem, &Settings { threads, ..Settings::default() })));
            clock.elapsed().as_secs_f64()
        };
        println!("N = {n}: {:.3} s by one thread, {:.3} s by two (wall)", time(1), time(2));
    }
}
