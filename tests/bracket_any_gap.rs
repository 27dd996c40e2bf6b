//! Bounds of the force of any gap from one pressure hold the force that closed forms give, wherever and however the gap is put, on any
//! grid and from any pressure.

#[path = "random/mod.rs"]
mod random;

use std::f64::consts::PI;

use contact_patch::closed_form::{self, Hertz};
use contact_patch::energy::{Trial, force_bracket};
use contact_patch::gap::{
    AnyGap, Cone, Formula, Gap, HeightMap, Heights, Minimum, Paraboloid, Polyhedron, Power, Reach, Sphere, Sum,
    Surface, Zero,
};
use contact_patch::matrix_free::{self, solve_nested};
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, geometry::Rect};
use random::Random;

fn unit() -> EffectiveModulus {
    EffectiveModulus::from_e_star(1.0).unwrap()
}

/// A gap about the origin, a depth, its force there (E* = 1), and what that is good to.
struct Known {
    name: &'static str,
    gap: AnyGap,
    depth: f64,
    force: f64,
    good_to: f64,
}

/// Integral of sin^m from 0 to pi/2.
fn wallis(m: usize) -> f64 {
    match m {
        0 => PI / 2.0,
        1 => 1.0,
        _ => (m - 1) as f64 / m as f64 * wallis(m - 2),
    }
}

/// Depth and force of g = sum of c r^n for a contact of radius a (Sneddon 1965).
fn revolved(terms: &[(f64, usize)], a: f64) -> [f64; 2] {
    let depth = terms.iter().map(|(c, n)| c * *n as f64 * a.powi(*n as i32) * wallis(n - 1)).sum();
    let force = terms.iter().map(|(c, n)| 2.0 * c * *n as f64 * a.powi(*n as i32 + 1) * wallis(n + 1)).sum();
    [depth, force]
}

/// The same gap with a higher one beside it that it keeps from touching: no law is known of both.
fn hidden(gap: &AnyGap, random: &mut Random) -> AnyGap {
    let higher = gap.clone().placed([0.0; 2], random.next()).unwrap();
    let raised = Formula::new("1").unwrap();
    let higher = AnyGap::new(Sum::new(vec![higher, AnyGap::from(&raised)]).unwrap());
    AnyGap::new(Minimum::new(vec![gap.clone(), higher]).unwrap())
}

fn drawn(random: &mut Random) -> Known {
    let a = random.between(0.4, 1.0);
    let hertz = |radii: [f64; 2], depth: f64| Hertz::new(unit(), radii).unwrap().at_depth(depth).unwrap().force;
    match random.below(10) {
        0 => {
            let terms = [(random.between(0.2, 1.0), 2), (random.between(0.0, 1.0), 4)];
            let [depth, force] = revolved(&terms, a);
            let text = format!("{}*r^2+{}*r^4", terms[0].0, terms[1].0);
            let gap = AnyGap::from(&Formula::new(&text).unwrap());
            Known { name: "formula", gap, depth, force, good_to: 1e-12 }
        }
        1 => {
            let terms = [(random.between(0.2, 1.0), 2), (random.between(0.1, 1.0), 3), (random.between(0.0, 0.5), 6)];
            let [depth, force] = revolved(&terms, a);
            let parts = terms.iter().map(|(c, n)| AnyGap::from(&Power::new(*c, *n as f64).unwrap())).collect();
            Known { name: "sum of powers", gap: AnyGap::new(Sum::new(parts).unwrap()), depth, force, good_to: 1e-12 }
        }
        2 => {
            let terms = [(random.between(0.2, 1.0), 1), (random.between(0.2, 1.0), 2)];
            let [depth, force] = revolved(&terms, a);
            let cone = AnyGap::from(&Cone::with_slope(terms[0].0).unwrap());
            let round = AnyGap::from(&Paraboloid::new([0.5 / terms[1].0; 2]).unwrap());
            let gap = AnyGap::new(Sum::new(vec![cone, round]).unwrap());
            Known { name: "cone and paraboloid", gap, depth, force, good_to: 1e-12 }
        }
        3 => {
            let (radius, depth) = (random.between(1.5, 30.0), random.between(0.05, 0.4));
            let force = closed_form::Sphere::new(unit(), radius).unwrap().at_depth(depth).unwrap().force;
            Known { name: "ball", gap: AnyGap::from(&Sphere::new(radius).unwrap()), depth, force, good_to: 1e-10 }
        }
        4 => {
            let radii = [random.between(0.5, 1.0), random.between(0.5, 3.0)];
            let gap = hidden(&AnyGap::from(&Paraboloid::new(radii).unwrap()), random);
            let depth = random.between(0.2, 0.9);
            Known { name: "paraboloid", gap, depth, force: hertz(radii, depth), good_to: 1e-10 }
        }
        5 => {
            // Tilted it is the same one pressed deeper elsewhere.
            let radii = [random.between(0.5, 1.0), random.between(0.5, 2.0)];
            let tilt = [random.between(-0.3, 0.3), random.between(-0.3, 0.3)];
            let gap = hidden(&AnyGap::from(&Paraboloid::new(radii).unwrap()), random).tilted(tilt);
            let (depth, more) = (random.between(0.2, 0.6), [0, 1].map(|m| 0.5 * radii[m] * tilt[m] * tilt[m]));
            Known { name: "tilted", gap, depth, force: hertz(radii, depth + more[0] + more[1]), good_to: 1e-10 }
        }
        6 => {
            let slope = random.between(0.4, 2.0);
            let gap = hidden(&AnyGap::from(&Cone::with_slope(slope).unwrap()), random);
            let depth = random.between(0.2, 0.8);
            Known { name: "cone", gap, depth, force: 2.0 / PI * depth * depth / slope, good_to: 1e-12 }
        }
        7 => {
            let faces = if random.next() < 0.5 { 3 } else { 4 };
            let gap = hidden(&AnyGap::from(&Polyhedron::pyramid(faces, PI / 4.0).unwrap()), random);
            let depth = random.between(0.2, 0.8);
            // Boundary elements, extrapolated to 1e-7.
            let force = if faces == 3 { 0.882_412_2 } else { 0.737_616_4 } * depth * depth;
            Known { name: "pyramid", gap, depth, force, good_to: 3e-7 }
        }
        8 => {
            // |x| + |y| between the nodes of a map: a pyramid of four faces of slope sqrt 2.
            let (half, step) = (12, random.between(0.08, 0.12));
            let n = 2 * half + 1;
            let at = |k: usize| (k as f64 - half as f64) * step;
            let values = (0..n * n).map(|k| -(at(k % n).abs() + at(k / n).abs())).collect();
            let heights = Heights::new(values, [n, n], [step; 2]).unwrap().at([at(0); 2]).unwrap();
            let gap = AnyGap::from(&HeightMap::new(&heights, Surface::Lower, Zero::FirstTouch).unwrap());
            let depth = random.between(0.2, 0.8);
            Known { name: "map", gap, depth, force: 0.737_616_4 / 2f64.sqrt() * depth * depth, good_to: 3e-7 }
        }
        _ => {
            // One or the other of two balls about one point, and a third that is out of reach.
            let (radius, depth) = (random.between(1.5, 6.0), random.between(0.05, 0.3));
            let force = closed_form::Sphere::new(unit(), radius).unwrap().at_depth(depth).unwrap().force;
            let ball = |r: f64| AnyGap::from(&Sphere::new(r).unwrap());
            let gap = AnyGap::new(Minimum::new(vec![ball(radius), ball(0.7 * radius)]).unwrap());
            Known { name: "two balls", gap, depth, force, good_to: 1e-10 }
        }
    }
}

/// A grid around what can touch, now and then too small for it.
fn around(reach: &Rect, random: &mut Random) -> Grid {
    let size = reach.size();
    let cut = random.next() < 0.05;
    let mut wide = || if cut { random.between(0.3, 0.6) } else { random.between(1.0, 1.3) };
    let half = [0.5 * size[0] * wide(), 0.5 * size[1] * wide()];
    let off = [0, 1].map(|m| (random.next() - 0.5) * 0.02 * size[m]);
    let centre = [reach.centre()[0] + off[0], reach.centre()[1] + off[1]];
    let rect = Rect { min: [0, 1].map(|m| centre[m] - half[m]), max: [0, 1].map(|m| centre[m] + half[m]) };
    let (cells, longer) = (random.between(16.0, 30.0), half[0].max(half[1]));
    let slender = random.between(0.7, 1.4);
    let shape = [half[0] / longer * cells * slender, half[1] / longer * cells].map(|n| (n.round() as usize).max(8));
    Grid::over(&rect, shape)
}

struct Outcome {
    spoilt: bool,
    /// Width, and error of the sum of the pressures, relative; `None` without bounds.
    found: Option<[f64; 2]>,
}

fn tried(seed: u64) -> Outcome {
    let mut random = Random(seed);
    let Known { name, gap, depth, force, good_to } = drawn(&mut random);
    // Units, place and turn.
    let length = 10f64.powf(random.between(-6.0, 3.0));
    let place = [random.between(-3.0, 3.0) * length, random.between(-3.0, 3.0) * length];
    let gap = gap.scaled([0.0; 2], 1.0 / length, 1.0 / length).placed(place, random.between(0.0, 6.3)).unwrap();
    let (depth, force) = (depth * length, force * length * length);
    let Reach::Within(reach) = gap.reach(depth) else { panic!("{name}: no reach") };
    let grid = around(&reach, &mut random);
    let problem = Discrete::sample(&gap, depth, grid, Kernel::Galerkin);
    let solved = solve_nested(&problem, &matrix_free::Settings::default()).unwrap();
    let spoilt = random.next() < 0.15;
    let mut pressure = solved.pressure;
    if spoilt {
        pressure.iter_mut().for_each(|p| *p *= random.between(0.95, 1.05));
    }
    let trial =
        Trial { grid: &grid, pressure: &pressure, displacement: (!spoilt).then_some(solved.displacement.as_slice()) };
    let sum = pressure.iter().sum::<f64>() * grid.cell_area();
    let found = force_bracket(&gap, depth, &trial).map(|[lower, upper]| {
        let room = good_to * force;
        assert!(
            lower <= force + room && force - room <= upper,
            "{name}, seed {seed}: {force:e} is not in [{:+e}, {:+e}] of it",
            lower / force - 1.0,
            upper / force - 1.0
        );
        [(upper - lower) / force, (sum / force - 1.0).abs()]
    });
    Outcome { spoilt, found }
}

/// 300 of them; a thread each takes half.
#[test]
fn the_force_lies_in_its_bounds() {
    held(20_261_123);
}

#[test]
fn the_force_of_others_lies_in_theirs() {
    held(20_262_123);
}

fn held(first: u64) {
    let outcomes: Vec<Outcome> = (0..150).map(|n| tried(first + n)).collect();
    let good: Vec<&Outcome> = outcomes.iter().filter(|o| !o.spoilt).collect();
    let bounded: Vec<f64> = good.iter().filter_map(|o| Some(o.found?[0])).collect();
    let narrow = bounded.iter().filter(|w| **w < 0.1).count();
    assert!(10 * bounded.len() > 8 * good.len(), "{} of {} bounded", bounded.len(), good.len());
    assert!(2 * narrow > bounded.len(), "{narrow} of {} narrower than 10 %", bounded.len());
}

#[test]
fn a_closure_proves_nothing() {
    let gap = AnyGap::new(|x: f64, y: f64| x * x + y * y);
    let grid = Grid::over(&Rect::around([0.0; 2], [1.1; 2]), [32, 32]);
    let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
    let solved = solve_nested(&problem, &matrix_free::Settings::default()).unwrap();
    let trial = Trial { grid: &grid, pressure: &solved.pressure, displacement: Some(&solved.displacement) };
    assert!(force_bracket(&gap, 1.0, &trial).is_none());
    // Nor does a pressure that pulls, or none.
    let known = AnyGap::from(&Sphere::new(3.0).unwrap());
    for pressure in [vec![0.0; grid.len()], vec![-1.0; grid.len()], vec![f64::NAN; grid.len()]] {
        assert!(force_bracket(&known, 1.0, &Trial { grid: &grid, pressure: &pressure, displacement: None }).is_none());
    }
}

/// `cargo test --release --test bracket_any_gap -- --ignored --nocapture`: width over true error of 5000.
#[test]
#[ignore = "takes minutes"]
fn as_many_as_five_thousand() {
    let outcomes: Vec<Outcome> = (0..5000).map(|n| tried(9_000_000 + n)).collect();
    let bounded: Vec<[f64; 2]> = outcomes.iter().filter(|o| !o.spoilt).filter_map(|o| o.found).collect();
    let mut widths: Vec<f64> = bounded.iter().map(|f| f[0]).collect();
    let mut ratios: Vec<f64> = bounded.iter().map(|f| f[0] / f[1]).collect();
    for (what, list) in [("width", &mut widths), ("width over true error", &mut ratios)] {
        list.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| list[((list.len() - 1) as f64 * share) as usize];
        let quantiles = [0.05, 0.25, 0.5, 0.75, 0.95].map(at);
        println!("{what}: 5, 25, 50, 75, 95 % below {}", quantiles.map(|q| format!("{q:.1e}")).join(" "));
    }
    println!("{} of {} without noise bounded", bounded.len(), outcomes.iter().filter(|o| !o.spoilt).count());
}
