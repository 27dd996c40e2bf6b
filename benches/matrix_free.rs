//! Cost of the matrix-free solver, in units that do not depend on the machine's clock: products on the finest grid, and
//! CPU time over the raw transforms of one product, measured in the same run.
//!
//!     cargo bench --bench matrix_free -- [smallest N] [largest N]     (128 and 1024 unless said)
//!
//! "raw": the one-dimensional transforms of one zero-padded product over the whole N by N box, on buffers that stay in
//! the cache: N real rows there and back, N + 1 complex columns there and back, all of length 2N.

mod timing;

use std::hint::black_box;
use std::time::Instant;

use contact_patch::gap::{Gap, Polyhedron};
use contact_patch::geometry::Rect;
use contact_patch::matrix_free::{Operator, Scratch, Settings, Solver, solve_nested};
use contact_patch::{Contact, Discrete, EffectiveModulus, Grid, InfluenceTable, Kernel, Loading, Method};
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use timing::seconds;

/// The transforms of one product.
fn raw(n: usize) -> impl FnMut() {
    let (mut real, mut complex) = (RealFftPlanner::<f64>::new(), FftPlanner::<f64>::new());
    let (there, back) = (real.plan_fft_forward(2 * n), real.plan_fft_inverse(2 * n));
    let (down, up) = (complex.plan_fft_forward(2 * n), complex.plan_fft_inverse(2 * n));
    let (mut row, mut spectrum) = (there.make_input_vec(), there.make_output_vec());
    let mut column = vec![Complex::new(0.0, 0.0); 2 * n];
    let mut scratch = vec![Complex::new(0.0, 0.0); 16 * n + 64];
    move || {
        for _ in 0..n {
            there.process_with_scratch(&mut row, &mut spectrum, &mut scratch).expect("lengths fit");
            back.process_with_scratch(&mut spectrum, &mut row, &mut scratch).expect("lengths fit");
        }
        for _ in 0..=n {
            down.process_with_scratch(&mut column, &mut scratch);
            up.process_with_scratch(&mut column, &mut scratch);
        }
        black_box((&row, &column));
    }
}

/// Median ratio of the times of two calls (wall clock), taken in turn: what else the machine does then lengthens both.
fn in_turn(mut first: impl FnMut(), mut second: impl FnMut()) -> f64 {
    let time = |call: &mut dyn FnMut()| {
        let clock = Instant::now();
        call();
        clock.elapsed().as_secs_f64()
    };
    let mut ratios: Vec<_> =
        (0..41).map(|_| (time(&mut first), time(&mut second))).map(|(first, second)| second / first).collect();
    ratios.sort_by(f64::total_cmp);
    ratios[ratios.len() / 2]
}

fn pyramid(faces: usize, turned: f64) -> impl Gap {
    move |x: f64, y: f64| {
        (0..faces)
            .map(|k| {
                let (s, c) = (turned + std::f64::consts::TAU * k as f64 / faces as f64).sin_cos();
                x * c + y * s
            })
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Gap and the box it is solved in; the depth is 1.
fn cases() -> [(&'static str, Box<dyn Gap>, Rect); 5] {
    let square = |half: f64| Rect::around([0.0; 2], [half; 2]);
    [
        ("3 faces", Box::new(pyramid(3, 0.0)), Rect { min: [-1.75, -1.4], max: [1.05, 1.4] }),
        // Not a mirror to be found.
        ("3, turned", Box::new(pyramid(3, 0.3)), Rect { min: [-1.7, -1.55], max: [1.5, 1.65] }),
        ("4 faces", Box::new(pyramid(4, 0.0)), square(1.1)),
        ("paraboloid", Box::new(|x: f64, y: f64| 0.5 * (x * x + y * y)), square(1.1)),
        ("ellipse", Box::new(|x: f64, y: f64| 0.5 * (x * x + 3.0 * y * y)), square(1.3)),
    ]
}

fn sampled(gap: &dyn Gap, extent: &Rect, n: usize) -> Discrete {
    let problem =
        Discrete::sample(&|x: f64, y: f64| gap.gap(x, y), 1.0, Grid::over(extent, [n, n]), Kernel::Collocation);
    // Values at centres are quick to sample; the matrix is that of cell means.
    Discrete { kernel: Kernel::Galerkin, ..problem }
}

fn main() {
    let sizes: Vec<usize> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let (first, last) = (sizes.first().copied().unwrap_or(128), sizes.last().copied().unwrap_or(1024));
    println!(
        "{:>5} {:>10} {:>6} {:>6} {:>8} {:>9} {:>9} {:>9} {:>8}",
        "N", "gap", "double", "single", "raw ms", "product/", "table/", "solve/", "CPU s"
    );
    let mut n = first;
    while n <= last {
        let table = seconds(3, 0.15, || drop(black_box(InfluenceTable::new(Kernel::Galerkin, [1.0, 1.0], [n, n]))));
        let operator =
            Operator::compliance(&InfluenceTable::new(Kernel::Galerkin, [1.0, 1.0], [n, n]), [1.0, 1.0], [n, n]);
        let (p, mut u, mut scratch) = (vec![1.0; n * n], vec![0.0; n * n], Scratch::new());
        let mut transforms = raw(n);
        let raw = seconds(3, 0.15, &mut transforms);
        let product = in_turn(transforms, || operator.apply(&p, 0..n, &mut u, 0..n, &mut scratch));
        for (name, gap, extent) in &cases() {
            let problem = sampled(&**gap, extent, n);
            let settings = Settings::default();
            let solution = match solve_nested(&problem, &settings) {
                Ok(solution) => solution,
                Err(unsolved) => {
                    println!("{n:>5} {name:>10} {unsolved}");
                    continue;
                }
            };
            let whole = seconds(3, 0.15, || drop(black_box(solve_nested(&problem, &settings))));
            println!(
                "{n:>5} {name:>10} {:>6} {:>6} {:>8.3} {:>9.2} {:>9.2} {:>9.1} {:>8.4}",
                solution.operator_products - solution.single_precision,
                solution.single_precision,
                1e3 * raw,
                product,
                table / raw,
                whole / raw,
                whole
            );
        }
        n *= 2;
    }
    threads(last);
    small();
    steps();
}

/// Wall-clock time by one thread and by two.
fn threads(largest: usize) {
    #[cfg(feature = "parallel")]
    for n in [1024, 2048].into_iter().filter(|n| *n <= largest) {
        let (_, gap, extent) = &cases()[1];
        let problem = sampled(&**gap, extent, n);
        let time = |threads| {
            let clock = Instant::now();
            drop(black_box(solve_nested(&problem, &Settings { threads, ..Settings::default() })));
            clock.elapsed().as_secs_f64()
        };
        println!("N = {n}, 3 turned: {:.3} s by one thread, {:.3} s by two (wall)", time(1), time(2));
    }
    let _ = largest;
}

/// The tetrahedral punch pressed 1 % deeper, step by step, on the cells that 0.1 % of the force asks for.
fn steps() {
    let punch = Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4).expect("three faces");
    let grid = Grid::over(&Rect { min: [-1.7, -1.5], max: [1.0, 1.5] }, [40, 40]);
    let steps: Vec<_> =
        (0..6).map(|k| Discrete::sample(&punch, 1.01_f64.powi(k - 5), grid, Kernel::Galerkin)).collect();
    let settings = Settings { tolerance: 1e-5, ..Settings::default() };
    let mut spent = [const { Vec::new() }; 6];
    let mut last = None;
    for _ in 0..200 {
        let mut solver = Solver::new(settings);
        for (step, spent) in steps.iter().zip(&mut spent) {
            let clock = Instant::now();
            let solution = solver.solve(step).expect("solved");
            spent.push(1e3 * clock.elapsed().as_secs_f64());
            last = Some(solution);
        }
    }
    let medians = spent.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    let solution = last.expect("six steps");
    println!(
        "depth steps of 1 %, 40 cells, ms: {medians:.3?}; force error {:.1e}, {} products in the last",
        solution.pressure.iter().sum::<f64>() * grid.cell_area() / 0.882_412_4 - 1.0,
        solution.operator_products
    );
}

/// The tetrahedral punch to 0.1 % through the front door.
fn small() {
    let modulus = EffectiveModulus::from_e_star(1.0).expect("positive");
    let punch = Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4).expect("three faces");
    let contact = Contact::new(modulus, punch, Loading::depth(1.0)).expect("a depth");
    let settings = contact_patch::Settings { method: Method::Fft, tolerance: 1e-3, ..Default::default() };
    let time = seconds(3, 0.15, || drop(black_box(contact_patch::solve(&contact, &settings))));
    let solution = contact_patch::solve(&contact, &settings).remove(0).expect("solved");
    println!(
        "tetrahedral punch to 1e-3, cold: {:.3} ms, error {:.1e}, {} products",
        1e3 * time,
        solution.force / 0.882_412_4 - 1.0,
        solution.cost.operator_products
    );
}
