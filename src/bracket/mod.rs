//! A certified bracket on the force: lower <= P <= upper, whatever solver the pressure came from.
//!
//! The force is the value of a linear programme, and any admissible point of either side bounds it. With S p the
//! displacement by a pressure p and f = depth - gap the overlap of the undeformed bodies:
//!
//! - q >= 0 and S q >= f where f > 0: then P <= integral of q.
//! - q >= 0 and S q <= f where q > 0: then integral of q <= P (domination).
//!
//! A computed pressure is neither, but nearly so. [`certify`] finds by how much it fails, over the whole plane and not at the
//! nodes alone, and repairs it; [`sharp`] solves again with a right-hand side raised (or lowered) cell by cell by what it
//! failed by, which costs the weighted mean of the failure where the repair costs its maximum.
//!
//! What was proved and what was only sampled is part of the answer: [`Evidence`].

mod approximate;
mod away;
mod cell;
mod comparison;
mod depth;
mod evaluate;
mod exterior;
mod field;
mod gap_bounds;
pub(crate) mod kernel;
mod measure;
mod mirrors;
mod polynomial;
mod problem;
pub(crate) mod refined;
mod repair;
mod sharp;
mod source;
mod spread;
mod suprema;
mod tables;
mod trend;
mod violation;

use crate::clock::{Deadline, Stopwatch};
use crate::gap::AnyGap;
use crate::grid::Pressure;
use crate::problem::EffectiveModulus;
use crate::solution::Unsolved;
use field::Surroundings;
use gap_bounds::GapBounds;
use mirrors::Mirrors;
use suprema::{BoundState, suprema};

pub use crate::solution::{BracketCost, DepthBracket, Evidence, ForceBracket, PairBracket, Repair, Side, Theorem};
pub use approximate::approximate;
pub use sharp::sharp;

/// How to look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BracketSettings {
    /// Lattice points along each side of a cell, at least 1; 4 unless said.
    pub per_cell: usize,
    /// Whether to bound what lies between lattice points where the gap allows it ([`crate::gap::Gap::bounds`]); yes unless said.
    pub prove: bool,
    /// Most rounds of [`sharp`] on either side; 4 unless said.
    pub rounds: usize,
    /// Threads for the solves of [`sharp`]; 1 unless said.
    pub threads: usize,
    /// When no further round of [`sharp`] is begun; never unless said. What is found until then is a bracket all the same.
    pub deadline: Deadline,
}

impl Default for BracketSettings {
    fn default() -> Self {
        Self { per_cell: 4, prove: true, rounds: 4, threads: 1, deadline: Deadline::NEVER }
    }
}

/// Bracket on the force of `gap` at `depth` from any pressure on any grid. Negative pressures count as none; a poor pressure
/// gives a wide bracket, never a wrong one.
///
/// Units: any consistent set; `pressure` in the units of E*, on a grid in the units of the gap.
///
/// # Errors
/// [`crate::Verdict::Unbounded`] when the gap stays below the depth without end, [`crate::Verdict::NotApplicable`] when a number of the
/// pressure or of its grid is not finite.
///
/// ```
/// use contact_patch::bracket::{self, BracketSettings, Evidence};
/// use contact_patch::{EffectiveModulus, Grid, Pressure, gap::Paraboloid, geometry::Rect};
/// // Hertz's pressure, sampled on 64 x 64 cells: p = 2/pi sqrt(1 - r^2) for R = 1, d = 1, E* = 1.
/// let grid = Grid::over(&Rect::around([0.0; 2], [1.05; 2]), [64, 64]);
/// let hertz = |[x, y]: [f64; 2]| 2.0 / std::f64::consts::PI * (1.0 - x * x - y * y).max(0.0).sqrt();
/// let pressure = Pressure { grid, values: (0..grid.len()).map(|k| hertz(grid.centre_of(k))).collect() };
/// let gap = Paraboloid::new([1.0, 1.0])?;
/// let modulus = EffectiveModulus::from_e_star(1.0)?;
/// let bracket = bracket::certify(&gap, modulus, 1.0, &pressure, &BracketSettings::default())?;
/// assert!(bracket.contains(4.0 / 3.0) && bracket.relative_width() < 0.1);
/// assert_eq!(bracket.evidence(), Evidence::Proved);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn certify(
    gap: impl Into<AnyGap>,
    modulus: EffectiveModulus,
    depth: f64,
    pressure: &Pressure,
    settings: &BracketSettings,
) -> Result<ForceBracket, Unsolved> {
    let gap = &gap.into();
    problem::within(gap, modulus, depth, pressure, |problem, mut q| {
        let started = Stopwatch::start();
        let mirrors = Mirrors::found(&mut q, problem);
        let mut around = Surroundings::new(&problem.grid, settings.per_cell.max(1));
        let known = GapBounds::new(q.len(), false);
        let closely = vec![evaluate::WHOLE; q.len()];
        let mut state = BoundState { known, closely, mirrors, prove: settings.prove };
        let (_, found, evidence) = suprema(problem, &mut around, &q, violation::Side::Both, &mut state);
        let exterior = exterior::uncovered(problem, &q);
        let (upper, lower) = (repair::upper(problem, &q, &found, &exterior), repair::lower(problem, &q, &found));
        let cost = BracketCost { seconds: started.seconds(), products: 1, solves: 0 };
        ForceBracket { lower: lower.side(problem, &q, evidence), upper: upper.side(problem, &q, evidence), cost }
    })
}
