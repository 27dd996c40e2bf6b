//! Cost of one grid in units that every other program has: pairs of padded transforms, there and back, of 2N by 2N real
//! numbers in double precision, measured in the same run.
//!
//!     cargo bench --bench peers -- [smallest N] [largest N] [name]     (256 and 1024 unless said; all gaps)
//!
//! Cold, to 1e-8, at a depth and under the force of that depth. Products on the finest grid, CPU seconds by one thread, pairs,
//! bytes a cell; then elapsed time by two threads over that by one, and the exponents of the cost in N.

#[path = "../tests/random/mod.rs"]
mod random;
mod timing;

use std::hint::black_box;

use contact_patch::gap::{Gap, Paraboloid, Polyhedron};
use contact_patch::geometry::Rect;
use contact_patch::matrix_free::{Settings, solve_nested, solve_under_force};
use contact_patch::{Discrete, DiscreteSolution, Grid, Kernel};
use random::Random;
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use timing::seconds;

#[cfg(feature = "cli")]
mod heap {
    use peakmem_alloc::{INSTRUMENTED_SYSTEM, PeakMemAlloc, PeakMemAllocTrait};

    #[global_allocator]
    static HEAP: &PeakMemAlloc<std::alloc::System> = &INSTRUMENTED_SYSTEM;

    /// The most bytes that a call holds at a time.
    pub fn of(call: impl FnOnce()) -> f64 {
        HEAP.reset_peak_memory();
        call();
        HEAP.get_peak_memory() as f64
    }
}
#[cfg(not(feature = "cli"))]
mod heap {
    pub fn of(_: impl FnOnce()) -> f64 {
        f64::NAN
    }
}

/// Columns transformed together: their numbers then share cache lines.
const TOGETHER: usize = 16;

/// Forward and inverse transform of 2N by 2N real numbers.
fn pair(n: usize) -> impl FnMut() {
    let n = 2 * n;
    let (mut real, mut complex) = (RealFftPlanner::<f64>::new(), FftPlanner::<f64>::new());
    let (there, back) = (real.plan_fft_forward(n), real.plan_fft_inverse(n));
    let (down, up) = (complex.plan_fft_forward(n), complex.plan_fft_inverse(n));
    let width = n / 2 + 1;
    let mut field = vec![0.0; n * n];
    let mut spectrum = vec![Complex::new(0.0, 0.0); n * width];
    let mut scratch = vec![Complex::new(0.0, 0.0); 8 * n + 64];
    let mut columns = vec![Complex::new(0.0, 0.0); TOGETHER * n];
    move || {
        for (row, to) in field.chunks_exact_mut(n).zip(spectrum.chunks_exact_mut(width)) {
            there.process_with_scratch(row, to, &mut scratch).expect("lengths fit");
        }
        for turn in [&down, &up] {
            for first in (0..width).step_by(TOGETHER) {
                let count = TOGETHER.min(width - first);
                for (j, row) in spectrum.chunks_exact(width).enumerate() {
                    (0..count).for_each(|c| columns[c * n + j] = row[first + c]);
                }
                turn.process_with_scratch(&mut columns[..count * n], &mut scratch);
                for (j, row) in spectrum.chunks_exact_mut(width).enumerate() {
                    (0..count).for_each(|c| row[first + c] = columns[c * n + j]);
                }
            }
        }
        for (row, from) in field.chunks_exact_mut(n).zip(spectrum.chunks_exact_mut(width)) {
            (from[0].im, from[width - 1].im) = (0.0, 0.0);
            back.process_with_scratch(from, row, &mut scratch).expect("lengths fit");
        }
        black_box(&field);
    }
}

/// Heights of a self-affine surface on n by n cells, rms 1: waves of 1/4 to 1/64 of the box, Hurst exponent 0.8.
fn rough(n: usize) -> Vec<f64> {
    let mut random = Random(19);
    let mut heights = vec![Complex::new(0.0, 0.0); n * n];
    let (least, most) = (4.0_f64, 64_isize);
    for j in -most..=most {
        for i in 0..=most {
            let (size, turn) = ((i as f64).hypot(j as f64), std::f64::consts::TAU * random.next());
            if size >= least && size <= most as f64 && (i > 0 || j > 0) {
                let at = j.rem_euclid(n as isize) as usize * n + i as usize;
                heights[at] = Complex::from_polar(size.powf(-1.8), turn);
            }
        }
    }
    let inverse = FftPlanner::<f64>::new().plan_fft_inverse(n);
    for _ in 0..2 {
        heights.chunks_exact_mut(n).for_each(|row| inverse.process(row));
        heights = (0..n * n).map(|k| heights[(k % n) * n + k / n]).collect();
    }
    let rms = (heights.iter().map(|h| h.re * h.re).sum::<f64>() / (n * n) as f64).sqrt();
    heights.iter().map(|h| h.re / rms).collect()
}

/// A gap in a box of n by n cells, pressed by 1.
struct Case {
    name: &'static str,
    problem: Box<dyn Fn(usize) -> Discrete>,
}

fn cases() -> [Case; 4] {
    let quarter = std::f64::consts::FRAC_PI_4;
    let pyramid = |faces| Polyhedron::pyramid(faces, quarter).expect("a pyramid");
    // Values at centres are quick to sample; the matrix is that of cell means.
    let sampled = |gap: Box<dyn Gap>, extent: Rect| {
        Box::new(move |n| {
            let grid = Grid::over(&extent, [n, n]);
            let gap = |x: f64, y: f64| gap.gap(x, y);
            Discrete { kernel: Kernel::Galerkin, ..Discrete::sample(&gap, 1.0, grid, Kernel::Collocation) }
        })
    };
    let square = |half: f64| Rect::around([0.0; 2], [half; 2]);
    let (sin, cos) = 0.3_f64.sin_cos();
    let four = pyramid(4);
    let turned = move |x: f64, y: f64| four.gap(cos * x + sin * y, cos * y - sin * x);
    // Axes 1 : 3 by Hertz.
    let ellipse = Paraboloid::new([1.0, 1.0 / 5.6]).expect("radii");
    let rough_sphere = |n: usize| {
        let grid = Grid::over(&Rect::around([0.0; 2], [1.5; 2]), [n, n]);
        let heights = rough(n);
        let overlap = (0..grid.len()).map(|k| {
            let [x, y] = grid.centre_of(k);
            1.0 - 0.5 * (x * x + y * y) + 0.1 * heights[k]
        });
        Discrete { grid, kernel: Kernel::Galerkin, overlap: overlap.collect() }
    };
    [
        Case {
            name: "tetrahedral punch",
            problem: sampled(Box::new(pyramid(3)), Rect { min: [-1.75, -1.4], max: [1.05, 1.4] }),
        },
        Case { name: "4 faces, turned", problem: sampled(Box::new(turned), square(0.95)) },
        Case { name: "ellipse 1:3", problem: sampled(Box::new(ellipse), square(1.3)) },
        Case { name: "rough sphere", problem: Box::new(rough_sphere) },
    ]
}

fn force(solution: &DiscreteSolution, problem: &Discrete) -> f64 {
    solution.pressure.iter().sum::<f64>() * problem.grid.cell_area()
}

/// Solved: products on the finest grid in double and in single precision, and the force.
type Solved = ([usize; 2], f64);

fn at_depth(problem: &Discrete, settings: &Settings) -> Solved {
    let solution = solve_nested(problem, settings).expect("solved");
    let single = solution.single_precision;
    ([solution.operator_products - single, single], force(&solution, problem))
}

/// From a depth that is known to a few percent, as after a search on few cells.
fn under_force(problem: &Discrete, wanted: f64, settings: &Settings) -> Solved {
    let guess = problem.deeper(-0.02);
    let (deeper, solution) = solve_under_force(&guess, wanted, None, settings).expect("solved");
    assert!((deeper - 0.02).abs() < 1e-7, "{deeper}");
    let single = solution.single_precision;
    ([solution.operator_products - single, single], force(&solution, problem))
}

/// A dense case without a mirror, Clarabel against the active set.
fn dense() {
    #[cfg(feature = "qp")]
    for n in [49, 78] {
        let (sin, cos) = 0.3_f64.sin_cos();
        let punch = Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4).expect("a pyramid");
        let turned = move |x: f64, y: f64| punch.gap(cos * x + sin * y, cos * y - sin * x);
        let grid = Grid::over(&Rect { min: [-1.7, -1.55], max: [1.5, 1.65] }, [n; 2]);
        let problem = Discrete::sample(&turned, 1.0, grid, Kernel::Galerkin);
        let timed = |solve: &dyn Fn() -> contact_patch::qp::QpSolution| {
            let clock = std::time::Instant::now();
            (solve().solution, clock.elapsed().as_secs_f64())
        };
        let (interior, first) = timed(&|| contact_patch::qp::solve(&problem, None).expect("solved"));
        let (pivots, second) = timed(&|| contact_patch::qp::solve_by_active_set(&problem, None).expect("solved"));
        let strongest = interior.pressure.iter().copied().fold(0.0, f64::max);
        let off = interior.pressure.iter().zip(&pivots.pressure).fold(0.0_f64, |m, (p, q)| m.max((p - q).abs()));
        println!(
            "dense, {} unknowns: Clarabel {first:.2} s, active set {second:.2} s elapsed; pressures differ by {:.1e}",
            interior.unknowns,
            off / strongest
        );
    }
}

/// Slope of log y over log x, by least squares.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
    let up = mean(&|p| (p.0.ln() - x) * (p.1.ln() - y));
    up / mean(&|p| (p.0.ln() - x).powi(2))
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let sizes: Vec<usize> = words.iter().filter_map(|a| a.parse().ok()).collect();
    let (first, last) = (sizes.first().copied().unwrap_or(256), sizes.get(1).copied().unwrap_or(1024));
    let only = words.iter().find(|w| w.parse::<usize>().is_err());
    let chosen = |name: &str| only.is_none_or(|only| name.contains(only.as_str()));
    let settings = Settings::default();
    println!(
        "{:>5} {:<18} {:<6} {:>6} {:>6} {:>9} {:>9} {:>7} {:>7}",
        "N", "gap", "given", "double", "single", "CPU s", "pair ms", "pairs", "bytes"
    );
    let mut growth = Vec::new();
    for Case { name, problem } in cases().into_iter().filter(|case| chosen(case.name)) {
        let mut costs = [const { Vec::new() }; 2];
        let mut n = first;
        while n <= last {
            let problem = problem(n);
            let (_, wanted) = at_depth(&problem, &settings);
            for (k, given) in ["depth", "force"].into_iter().enumerate() {
                let solve =
                    || if k == 0 { at_depth(&problem, &settings) } else { under_force(&problem, wanted, &settings) };
                let bytes = heap::of(|| {
                    black_box(solve());
                }) / (n * n) as f64;
                let ([double, single], reached) = solve();
                assert!((reached / wanted - 1.0).abs() < 1e-7, "{reached} for {wanted}");
                let pair = seconds(2, 0.1, pair(n));
                let spent = seconds(if n <= 512 { 3 } else { 2 }, 0.1, || {
                    black_box(solve());
                });
                costs[k].push((n as f64, spent));
                println!(
                    "{n:>5} {name:<18} {given:<6} {double:>6} {single:>6} {spent:>9.4} {:>9.2} {:>7.1} {bytes:>7.0}",
                    1e3 * pair,
                    spent / pair
                );
            }
            n *= 2;
        }
        growth.push((name, costs));
    }
    #[cfg(feature = "parallel")]
    threads(&chosen, last);
    if chosen("dense") {
        dense();
    }
    for (name, costs) in growth.iter().filter(|(_, costs)| costs[0].len() > 1) {
        println!("{name}: CPU s ~ N^{:.2} at depth, N^{:.2} under a force", exponent(&costs[0]), exponent(&costs[1]));
    }
}

/// Elapsed time by one thread over that by two, in turn.
#[cfg(feature = "parallel")]
fn threads(chosen: &dyn Fn(&str) -> bool, last: usize) {
    for n in [1024, 2048].into_iter().filter(|n| *n <= last) {
        for Case { name, problem } in cases().into_iter().filter(|case| chosen(case.name)) {
            let problem = problem(n);
            let time = |threads| {
                let clock = std::time::Instant::now();
                drop(black_box(solve_nested(&problem, &Settings { threads, ..Settings::default() })));
                clock.elapsed().as_secs_f64()
            };
            let mut times: Vec<[f64; 2]> = (0..5).map(|_| [time(1), time(2)]).collect();
            times.sort_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
            let [one, two] = times[times.len() / 2];
            println!("{n:>5} {name:<18} one thread {one:.3} s, two {two:.3} s elapsed: {:.2} times", one / two);
        }
    }
}
