//! Cost of the approximate method, one thread: `cargo bench --bench fabrikant`.
//! Before the timings, a table of quadrature error against cost for the three-faced punch.
#![allow(missing_docs)]

use std::hint::black_box;
use std::time::Instant;

use contact_patch::fabrikant::{self, RegularPolyhedron, Settings};
use contact_patch::gap::{Paraboloid, Polyhedron, RoundedTip};
use contact_patch::{EffectiveModulus, ritz};
use criterion::{Criterion, criterion_group, criterion_main};

/// Median time of one call, in microseconds.
fn microseconds(mut call: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..201)
        .map(|_| {
            let start = Instant::now();
            call();
            start.elapsed().as_secs_f64() * 1e6
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn error_against_cost(punch: &Polyhedron, modulus: EffectiveModulus) {
    let Ok(exact) = RegularPolyhedron::new(3) else { return };
    println!("three-faced punch, general path: quadrature error against cost");
    println!("tolerance   error estimate   error        rays    microseconds");
    for exponent in 2..=11 {
        let settings = Settings::with_tolerance(10f64.powi(-exponent));
        let Ok(found) = fabrikant::stationary(punch, modulus, 1.0, &settings) else { continue };
        let time = microseconds(|| {
            let _ = black_box(fabrikant::stationary(black_box(punch), modulus, 1.0, &settings));
        });
        let estimate = found.quadrature_error[0] + found.quadrature_error[1];
        let error = (found.force / exact.force - 1.0).abs();
        println!("1e-{exponent:<9} {estimate:<16.1e} {error:<12.1e} {:<7} {time:.1}", found.rays);
    }
}

fn bench(c: &mut Criterion) {
    let (Ok(modulus), Ok(punch)) =
        (EffectiveModulus::from_e_star(1.0), Polyhedron::pyramid(3, std::f64::consts::FRAC_PI_4))
    else {
        return;
    };
    let Ok(slender) = Paraboloid::new([1e4, 1.0]) else { return };
    error_against_cost(&punch, modulus);
    let coarse = Settings::with_tolerance(1e-4);
    c.bench_function("three faces, general path, 1e-4", |b| {
        b.iter(|| fabrikant::stationary(black_box(&punch), modulus, 1.0, &coarse));
    });
    let (Ok(twelve), Ok(irregular), Ok(oblong), Ok(rounded)) = (
        Polyhedron::pyramid(12, 0.35),
        Polyhedron::new(vec![
            [0.5, 0.0, 0.0],
            [0.1, 0.4, -0.02],
            [-0.4, 0.3, 0.0],
            [-0.3, -0.4, -0.01],
            [0.2, -0.4, 0.0],
        ]),
        Paraboloid::new([1.0, 2.0]),
        RoundedTip::pyramid(4, 0.35, 0.5),
    ) else {
        return;
    };
    let fine = Settings::with_tolerance(1e-6);
    c.bench_function("twelve faces, symmetry known, 1e-6", |b| {
        b.iter(|| fabrikant::stationary(black_box(&twelve), modulus, 1.0, &fine));
    });
    c.bench_function("five irregular faces, 1e-6", |b| {
        b.iter(|| fabrikant::stationary(black_box(&irregular), modulus, 1.0, &fine));
    });
    c.bench_function("paraboloid 2:1, 1e-6", |b| {
        b.iter(|| fabrikant::stationary(black_box(&oblong), modulus, 1.0, &fine));
    });
    c.bench_function("four rounded faces, Ritz ellipse, 1e-6", |b| {
        b.iter(|| ritz::ellipse(black_box(&rounded), modulus, 1.0, &fine));
    });
    c.bench_function("three faces, closed form", |b| b.iter(|| RegularPolyhedron::new(black_box(3))));
    c.bench_function("three faces, Ritz ellipse, 1e-4", |b| {
        b.iter(|| ritz::ellipse(black_box(&punch), modulus, 1.0, &coarse));
    });
    c.bench_function("paraboloid 1e4:1, Ritz ellipse, 1e-9", |b| {
        b.iter(|| ritz::ellipse(black_box(&slender), modulus, 1.0, &Settings::with_tolerance(1e-9)));
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
