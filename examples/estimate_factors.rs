//! What grids leave of the energy, in their last step: how the factors of estimated errors were found.
//!
//! `cargo run --release --example estimate_factors [draws a family, 8] [seed, 1]`
//!
//! Contacts are drawn with their place, turn, aspect and coarsest grid; each is solved on three or four grids whose cells double. Of the
//! exact energy U and the energies U_n of the grids, (U - U_n)/(U_n - U_(n-1)) is what is left in steps. The middle and half the range
//! over many draws are the share and the spread of `contact_patch::grid_method::extrapolation::of_energies`.

use contact_patch::closed_form::Hertz;
use contact_patch::gap::{AnyGap, Cone, Flat, Gap, Outline, Paraboloid, Polyhedron, Power, Reach};
use contact_patch::geometry::Rect;
use contact_patch::{Contact, Discrete, EffectiveModulus, Grid, Kernel, Loading, Method, Settings, matrix_free, solve};

#[path = "../tests/random/mod.rs"]
mod random;

use random::Random;

type Failure = Box<dyn std::error::Error>;

/// A gap with its depth, and its exact energy where a formula has it.
struct Drawn {
    gap: AnyGap,
    depth: f64,
    energy: Option<f64>,
    /// What is left is printed in units of this.
    unit: f64,
}

/// One family: its name, its draw, and the factor by which steps shrink.
struct Family {
    name: &'static str,
    draw: fn(&mut Random) -> Result<Drawn, Failure>,
    /// Energies of the finest grid leave this share of their step where no formula has the energy.
    left: f64,
}

const FAMILIES: [Family; 6] = [
    Family { name: "paraboloids, aspect to 200", draw: paraboloid, left: 0.17 },
    Family { name: "cones and powers 0.7 to 8", draw: power, left: 0.17 },
    Family { name: "powers 0.05 to 0.7", draw: tip, left: 1.0 },
    Family { name: "regular pyramids", draw: pyramid, left: 0.315 },
    Family { name: "irregular pyramids", draw: irregular, left: 0.315 },
    Family { name: "flat rectangles", draw: flat, left: 1.0 },
];

fn unit() -> Result<EffectiveModulus, Failure> {
    Ok(EffectiveModulus::from_e_star(1.0)?)
}

fn paraboloid(draws: &mut Random) -> Result<Drawn, Failure> {
    let radii = [1.0, 10f64.powf(draws.between(0.0, 2.3))];
    let energy = 0.4 * Hertz::new(unit()?, radii)?.at_depth(1.0)?.force;
    Ok(Drawn { gap: AnyGap::new(Paraboloid::new(radii)?), depth: 1.0, energy: Some(energy), unit: 1.0 })
}

fn power(draws: &mut Random) -> Result<Drawn, Failure> {
    let degree = if draws.between(0.0, 1.0) < 0.3 { 1.0 } else { draws.between(0.7, 8.0) };
    of_degree(degree)
}

/// In units of 1/(2^(1 + 2 k) - 1), what a geometric series leaves whose steps fall as they do at the tip.
fn tip(draws: &mut Random) -> Result<Drawn, Failure> {
    let degree = draws.between(0.05, 0.7);
    Ok(Drawn { unit: 1.0 / ((1.0 + 2.0 * degree).exp2() - 1.0), ..of_degree(degree)? })
}

fn of_degree(degree: f64) -> Result<Drawn, Failure> {
    let gap = if degree == 1.0 { AnyGap::new(Cone::with_slope(1.0)?) } else { AnyGap::new(Power::new(1.0, degree)?) };
    let contact = Contact::new(unit()?, gap.clone(), Loading::depth(1.0))?;
    let state = solve(&contact, &Settings { method: Method::ClosedForm, ..Settings::default() }).remove(0)?;
    Ok(Drawn { gap, depth: 1.0, energy: Some(state.force / (2.0 + 1.0 / degree)), unit: 1.0 })
}

fn pyramid(draws: &mut Random) -> Result<Drawn, Failure> {
    let gap = AnyGap::new(Polyhedron::pyramid(3 + draws.below(6), std::f64::consts::FRAC_PI_4)?);
    Ok(Drawn { gap, depth: 1.0, energy: None, unit: 1.0 })
}

fn irregular(draws: &mut Random) -> Result<Drawn, Failure> {
    let (faces, aspect) = (3 + draws.below(4), 10f64.powf(draws.between(0.0, 0.7)));
    let planes = (0..faces).map(|k| {
        let angle = std::f64::consts::TAU * (k as f64 + draws.between(-0.25, 0.25)) / faces as f64;
        let slope = draws.between(0.7, 1.4);
        [slope * angle.cos(), slope * aspect * angle.sin(), 0.0]
    });
    Ok(Drawn { gap: AnyGap::new(Polyhedron::new(planes.collect())?), depth: 1.0, energy: None, unit: 1.0 })
}

fn flat(draws: &mut Random) -> Result<Drawn, Failure> {
    let half = [1.0, draws.between(0.3, 1.0)];
    let corners = Rect::around([0.0; 2], half).corners();
    let gap = AnyGap::new(Flat::new(Outline::polygon(&corners)?));
    let contact = Contact::new(unit()?, gap.clone(), Loading::depth(1.0))?;
    // Cells graded to the edges know its force to 1e-5 where a uniform grid knows a hundredth.
    let state = solve(&contact, &Settings { tolerance: 1e-5, ..Settings::default() }).remove(0)?;
    Ok(Drawn { gap, depth: 1.0, energy: Some(0.5 * state.force), unit: 1.0 })
}

/// Energies of `count` grids whose cells double, from `cells` along the longer side of the box of the overlap.
fn energies(gap: &AnyGap, depth: f64, cells: usize, count: usize) -> Result<Vec<f64>, Failure> {
    let Reach::Within(reach) = gap.reach(depth) else { return Err("the overlap has no end".into()) };
    let size = reach.size();
    let longer = size[0].max(size[1]);
    let coarsest = size.map(|side| (side / longer * cells as f64).ceil());
    let half = coarsest.map(|n| 0.5 * n / cells as f64 * longer);
    let settings = matrix_free::Settings { tolerance: 1e-6, ..Default::default() };
    let energy = |level: usize| -> Result<f64, Failure> {
        let grid = Grid::over(&Rect::around(reach.centre(), half), coarsest.map(|n| (n as usize) << level));
        let problem = Discrete::sample(gap, depth, grid, Kernel::Galerkin);
        let solved = matrix_free::solve_nested(&problem, &settings)?;
        let each = solved.pressure.iter().zip(&problem.overlap).zip(&solved.displacement);
        Ok(grid.cell_area() * each.filter(|((p, _), _)| **p > 0.0).map(|((p, f), u)| p * (f - 0.5 * u)).sum::<f64>())
    };
    (0..count).map(energy).collect()
}

fn main() -> Result<(), Failure> {
    let mut numbers = std::env::args().skip(1).map(|n| n.parse::<u64>());
    let (draws, seed) = (numbers.next().unwrap_or(Ok(8))?, numbers.next().unwrap_or(Ok(1))?);
    println!("family                      grids  draws    least     5 %  median    95 %  largest");
    for family in FAMILIES {
        let mut random = Random(seed);
        let mut left: [Vec<f64>; 3] = Default::default();
        for _ in 0..draws {
            let Drawn { gap, depth, energy, unit } = (family.draw)(&mut random)?;
            let at = [random.between(-0.5, 0.5), random.between(-0.5, 0.5)];
            let gap = gap.placed(at, random.between(0.0, std::f64::consts::TAU))?;
            let cells = 10 + random.below(9);
            let grids = energies(&gap, depth, cells, if energy.is_some() { 4 } else { 5 })?;
            let last = grids.len() - 1;
            let exact = energy.unwrap_or(grids[last] + family.left * (grids[last] - grids[last - 1]));
            for (n, left) in left.iter_mut().enumerate() {
                left.push((exact - grids[n + 1]) / (grids[n + 1] - grids[n]) / unit);
            }
        }
        for (n, mut left) in left.into_iter().enumerate() {
            left.sort_by(f64::total_cmp);
            let at = |share: f64| left[(share * (left.len() - 1) as f64).round() as usize];
            println!(
                "{:27} {:5} {:6} {:8.3}{:8.3}{:8.3}{:8.3} {:8.3}",
                family.name,
                n + 2,
                left.len(),
                at(0.0),
                at(0.05),
                at(0.5),
                at(0.95),
                at(1.0)
            );
        }
    }
    Ok(())
}
