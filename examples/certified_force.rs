//! Width of the certified bracket against the number of cells: plain and sharp, sampled and proved, and their cost in solves.
//!
//! `cargo run --release --example certified_force [largest number of cells, 256]`

use std::fmt::Write;
use std::time::Instant;

use contact_patch::bracket::{self, BracketSettings, ForceBracket};
use contact_patch::gap::{AnyGap, Cone, Paraboloid, Polyhedron};
use contact_patch::geometry::Rect;
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, Pressure, matrix_free};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let most: usize = std::env::args().nth(1).map_or(Ok(256), |n| n.parse())?;
    print!("{}", text(most)?);
    Ok(())
}

/// What is printed, up to this number of cells.
pub fn text(most: usize) -> Result<String, Box<dyn std::error::Error>> {
    let mut out = String::new();
    let quarter = std::f64::consts::FRAC_PI_4;
    let modulus = EffectiveModulus::from_e_star(1.0)?;
    // Boxes that hold the contact; E* = depth = slope = curvature = 1.
    let around = |half: f64| Rect::around([0.0; 2], [half; 2]);
    let three = Rect { min: [-1.7, -1.5], max: [0.9, 1.5] };
    let cases: [(&str, AnyGap, Rect, f64); 4] = [
        ("paraboloid", AnyGap::new(Paraboloid::new([1.0, 1.0])?), around(1.1), 4.0 / 3.0),
        ("cone", AnyGap::new(Cone::with_slope(1.0)?), around(0.72), std::f64::consts::FRAC_2_PI),
        ("3 faces", AnyGap::new(Polyhedron::pyramid(3, quarter)?), three, 0.882412),
        ("4 faces", AnyGap::new(Polyhedron::pyramid(4, quarter)?), around(0.95), 0.737616),
    ];
    writeln!(out, "{:<17} | {:^46} | {:^46} |", "", "width, % of the force", "time, solves")?;
    writeln!(
        out,
        "{:<11}{:>6} | {:>11}{:>11}{:>12}{:>12} | {:>11}{:>11}{:>12}{:>12} | bracket (sharp, sampled)",
        "gap", "cells", "plain", "sharp", "plain", "sharp", "plain", "sharp", "plain", "sharp"
    )?;
    for (name, gap, window, force) in cases {
        let mut cells = 32;
        let mut before: Option<[f64; 4]> = None;
        while cells <= most {
            let grid = Grid::over(&window, [cells; 2]);
            let started = Instant::now();
            let problem = Discrete::sample(&gap, 1.0, grid, Kernel::Galerkin);
            let values = matrix_free::solve_nested(&problem, &matrix_free::Settings::default())?.pressure;
            let solve = started.elapsed().as_secs_f64();
            let pressure = Pressure { grid, values };
            let sampled = BracketSettings { prove: false, ..BracketSettings::default() };
            let proved = BracketSettings::default();
            let brackets: [ForceBracket; 4] = [
                bracket::certify(&gap, modulus, 1.0, &pressure, &sampled)?,
                bracket::sharp(&gap, modulus, 1.0, &pressure, &sampled)?,
                bracket::certify(&gap, modulus, 1.0, &pressure, &proved)?,
                bracket::sharp(&gap, modulus, 1.0, &pressure, &proved)?,
            ];
            let [a, b, c, d] = brackets.each_ref().map(|b| 100.0 * b.relative_width());
            let [s, t, u, v] = brackets.each_ref().map(|b| b.cost().seconds / solve);
            write!(
                out,
                "{name:<11}{cells:>6} | {a:>11.3}{b:>11.3}{c:>11.3}p{d:>11.3}p | {s:>11.1}{t:>11.1}{u:>11.1}p{v:>11.1}p"
            )?;
            writeln!(out, " | [{:.6}, {:.6}]", brackets[1].lower(), brackets[1].upper())?;
            if let Some(before) = before {
                let order = |k: usize, width: f64| (before[k] / width).log2();
                let (a, b, c, d) = (order(0, a), order(1, b), order(2, c), order(3, d));
                writeln!(out, "{:<11}{:>6} | {a:>11.1}{b:>11.1}{c:>11.1} {d:>11.1}  |", "", "order")?;
            }
            before = Some([a, b, c, d]);
            for bracket in &brackets {
                assert!(bracket.contains(force), "{force} is not in [{}, {}]", bracket.lower(), bracket.upper());
            }
            cells *= 2;
        }
    }
    writeln!(out, "p: proved over the whole plane; otherwise sampled at 4 x 4 points a cell.")?;
    Ok(out)
}
