//! Contact patch, force, stiffness and pressure of two bodies pressed together.

mod contact;
mod discrete;
mod domain;
mod error;
mod exact;
mod extrapolate;
pub mod gap;
pub mod geometry;
mod grid;
mod homogeneity;
pub mod influence;
mod material;
pub mod patch;
#[cfg(feature = "qp")]
pub mod qp;
mod settings;
mod solution;
pub mod symmetry;

pub use contact::{Contact, Load, Loading};
pub use discrete::{Discrete, DiscreteSolution, Residuals};
pub use error::{InputError, Unsolved, Verdict};
pub use gap::Gap;
pub use grid::{Grid, Kernel, Pressure};
pub use material::{Body, EffectiveModulus};
pub use settings::{BoundaryFamily, Method, Outputs, Settings};
pub use solution::{Cost, Patch, PressureSummary, Solution};

/// probe
pub fn probe(gap: &dyn Gap, depth: f64, cells: usize, kernel: Kernel) {
    let t = std::time::Instant::now();
    let door = domain::Door::enter(gap, depth).unwrap().unwrap();
    let mut window = domain::locate(&door).unwrap();
    let t1 = t.elapsed();
    let s = exact::at_resolution(&door, &mut window, cells, kernel, Method::Qp).unwrap();
    let f = s.force() * door.gap.length * door.gap.depth;
    let p = patch::of(&s.problem, &s.solution, [0.0; 2]);
    println!(
        "{window:?} {:?} F {f} U {} n {} it {} res {:?} area {} {:?} {:?}",
        s.problem.grid.shape,
        s.energy() * door.gap.length * door.gap.depth.powi(2),
        s.solution.unknowns,
        s.iterations,
        s.solution.residuals,
        p.area * door.gap.length.powi(2),
        t1,
        t.elapsed()
    );
    println!("{:?}", s.left_out);
}
