//! Width and cost of the certified bracket against the number of cells, by one thread.
//!
//!     cargo bench --bench bracket -- [smallest N] [largest N] [punch]     (32 and 1024 unless said; all five)
//!
//! Widths in % of the force, plain and sharp, sampled at 4 x 4 points a cell and proved over the plane; costs in solves, a
//! solve being a cold one of the same problem by the fastest way there is (sampling of the gap, nested grids, to 1e-8). Below
//! each line the observed orders: log2 of the width before over the width now.

mod timing;

use std::hint::black_box;

use contact_patch::bracket::{self, BracketSettings, ForceBracket};
use contact_patch::gap::{AnyGap, Cone, Paraboloid, Polyhedron};
use contact_patch::geometry::Rect;
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, matrix_free};
use timing::seconds;

/// Gap, the box it is solved in, and the force; E* = depth = slope = curvature = 1.
fn cases() -> [(&'static str, AnyGap, Rect, f64); 5] {
    let quarter = std::f64::consts::FRAC_PI_4;
    let around = |half: f64| Rect::around([0.0; 2], [half; 2]);
    let three = Rect { min: [-1.7, -1.5], max: [0.9, 1.5] };
    let turned = Rect { min: [-1.7, -1.55], max: [1.5, 1.65] };
    let pyramid = |faces| AnyGap::new(Polyhedron::pyramid(faces, quarter).expect("a pyramid"));
    [
        ("paraboloid", AnyGap::new(Paraboloid::new([1.0, 1.0]).expect("radii")), around(1.1), 4.0 / 3.0),
        ("cone", AnyGap::new(Cone::with_slope(1.0).expect("a slope")), around(0.72), std::f64::consts::FRAC_2_PI),
        ("3 faces", pyramid(3), three, 0.882_412),
        ("3, turned", AnyGap::new(pyramid(3).placed([0.0; 2], 0.3).expect("an angle")), turned, 0.882_412),
        ("4 faces", pyramid(4), around(0.95), 0.737_616),
    ]
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let sizes: Vec<usize> = words.iter().filter_map(|a| a.parse().ok()).collect();
    let (first, last) = (sizes.first().copied().unwrap_or(32), sizes.get(1).copied().unwrap_or(1024));
    let only = words.iter().find(|w| w.parse::<usize>().is_err());
    let modulus = EffectiveModulus::from_e_star(1.0).expect("a modulus");
    println!(
        "{:<11}{:>6}{:>10} | width, %: plain, sharp sampled; plain, sharp proved | solves of the same",
        "gap", "cells", "solve, s"
    );
    for (name, gap, window, force) in cases() {
        if only.is_some_and(|only| !name.contains(only.as_str())) {
            continue;
        }
        let mut cells = first;
        let mut before: Option<[f64; 4]> = None;
        while cells <= last {
            let grid = Grid::over(&window, [cells; 2]);
            let solved = || {
                let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
                matrix_free::solve_nested(&problem, &matrix_free::Settings::default()).expect("solved").pressure
            };
            let pressure = Pressure { grid, values: solved() };
            let solve = seconds(2, 0.05, || drop(black_box(solved())));
            let proved = BracketSettings::default();
            let sampled = BracketSettings { prove: false, ..proved };
            let way = |sharp: bool, settings: &BracketSettings| -> ForceBracket {
                let way = if sharp { bracket::sharp } else { bracket::certify };
                way(&gap, modulus, 1.0, &pressure, settings).expect("a bracket")
            };
            let four = [(false, &sampled), (true, &sampled), (false, &proved), (true, &proved)];
            let brackets = four.map(|(sharp, settings)| way(sharp, settings));
            let costs =
                four.map(|(sharp, settings)| seconds(2, 0.05, || drop(black_box(way(sharp, settings)))) / solve);
            let widths = brackets.each_ref().map(|b| 100.0 * b.relative_width());
            let holds = brackets.iter().all(|b| b.lower() <= force * (1.0 + 3e-6) && force * (1.0 - 3e-6) <= b.upper());
            println!(
                "{name:<11}{cells:>6}{solve:>10.5} |{:>8.3}{:>8.4}{:>8.3}{:>8.4} |{:>7.2}{:>7.2}{:>7.2}{:>7.2}{}  solves {} {}",
                widths[0],
                widths[1],
                widths[2],
                widths[3],
                costs[0],
                costs[1],
                costs[2],
                costs[3],
                if holds { "" } else { "  DOES NOT HOLD" },
                brackets[1].cost().solves,
                brackets[3].cost().solves
            );
            if let Some(before) = before {
                let [a, b, c, d] = [0, 1, 2, 3].map(|k| (before[k] / widths[k]).log2());
                println!("{:<27} |{a:>8.2}{b:>8.2}{c:>8.2}{d:>8.2} |", "  order");
            }
            before = Some(widths);
            cells *= 2;
        }
    }
}
