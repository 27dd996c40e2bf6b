//! Proved bounds of the force by the energy of one pressure: width, and what they cost, against the number of cells.
//!
//! `cargo run --release --example proved_bounds [largest number of cells, 256]`
//!
//! Five gaps that follow a law and three that do not, straight, turned by 17 degrees, and placed off the grid.

use std::time::Instant;

use contact_patch::closed_form::{Hertz, Sphere as Ball};
use contact_patch::energy::{Trial, force_bracket};
use contact_patch::gap::{AnyGap, Cone, Gap, Paraboloid, Polyhedron, Reach, Sphere, Sum};
use contact_patch::{Discrete, EffectiveModulus, Grid, Kernel, geometry::Rect, matrix_free};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let most: usize = std::env::args().nth(1).map_or(Ok(256), |n| n.parse())?;
    let unit = EffectiveModulus::from_e_star(1.0)?;
    let quarter = std::f64::consts::FRAC_PI_4;
    let cone = AnyGap::from(&Cone::with_slope(0.5)?);
    let round = AnyGap::from(&Paraboloid::new([0.5, 0.5])?);
    // Sneddon: g = r/2 + r^2 at a contact of radius 1/2.
    let (depth, force) = (0.125 * std::f64::consts::PI + 0.5, 0.0625 * std::f64::consts::PI + 1.0 / 3.0);
    let scenes: [(&str, AnyGap, f64, f64); 7] = [
        ("Hertz 1:1", Paraboloid::new([1.0, 1.0])?.into_any(), 1.0, 4.0 / 3.0),
        ("Hertz 2:7", Paraboloid::new([1.0, 3.5])?.into_any(), 1.0, Hertz::new(unit, [1.0, 3.5])?.at_depth(1.0)?.force),
        ("cone", Cone::with_slope(1.0)?.into_any(), 1.0, std::f64::consts::FRAC_2_PI),
        ("4 faces", Polyhedron::pyramid(4, quarter)?.into_any(), 1.0, 0.737_616_4),
        ("3 faces", Polyhedron::pyramid(3, quarter)?.into_any(), 1.0, 0.882_412_2),
        ("ball", Sphere::new(5.0)?.into_any(), 0.25, Ball::new(unit, 5.0)?.at_depth(0.25)?.force),
        ("cone, paraboloid", Sum::new(vec![cone, round])?.into_any(), depth, force),
    ];
    println!("gap                placed     cells  below/P - 1  above/P - 1  held  solve, ms  bounds, ms");
    for (name, gap, depth, force) in scenes {
        for (place, at, turn) in
            [("straight", [0.0; 2], 0.0), ("turned", [0.0; 2], 17.0), ("off grid", [0.0123, -0.0231], 0.0)]
        {
            let gap = gap.placed(at, f64::to_radians(turn))?;
            let Reach::Within(reach) = gap.reach(depth) else { continue };
            let centre = [reach.centre()[0] - at[0], reach.centre()[1] - at[1]];
            let half = reach.size().map(|side| 0.53 * side);
            let mut cells = 32;
            while cells <= most {
                let longer = half[0].max(half[1]);
                let shape = half.map(|side| (side / longer * cells as f64).ceil() as usize);
                let half = shape.map(|n| n as f64 / cells as f64 * longer);
                let grid = Grid::over(&Rect::around(centre, half), shape);
                let started = Instant::now();
                let problem = Discrete::sample(&gap, depth, grid, Kernel::Galerkin);
                let solved = matrix_free::solve_nested(
                    &problem,
                    &matrix_free::Settings { tolerance: 1e-5, ..Default::default() },
                )?;
                let solve = started.elapsed().as_secs_f64();
                let trial = Trial { grid: &grid, pressure: &solved.pressure, displacement: Some(&solved.displacement) };
                // The first call makes tables for cells of this shape, which are kept.
                let _ = force_bracket(&gap, depth, &trial);
                let started = Instant::now();
                let bounds = force_bracket(&gap, depth, &trial);
                let prove = started.elapsed().as_secs_f64();
                if let Some([lower, upper]) = bounds {
                    let [low, high] = [lower / force - 1.0, upper / force - 1.0];
                    let held = if low <= 3e-7 && high >= -3e-7 { "yes" } else { "no" };
                    println!(
                        "{name:18} {place:9} {cells:6} {low:12.1e} {high:12.1e}  {held:4} {:10.1} {:11.1}",
                        1e3 * solve,
                        1e3 * prove
                    );
                } else {
                    println!("{name:18} {place:9} {cells:6}   none");
                }
                cells *= 2;
            }
        }
    }
    Ok(())
}
