//! The minimum principle of Kalker & van Randen (1972) as a quadratic programme in the cell pressures:
//! minimise 1/2 p'A p - f'p over p >= 0, on the cells that can carry pressure at all.
//!
//! Clarabel gives the pressures to eight digits and with them the contact cells; the active set makes the
//! complementarity exact to rounding.

mod active_set;
mod interior_point;
mod reduced;

use crate::clock::Deadline;
use crate::discrete::symmetry::Symmetry;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::solution::{Unsolved, Verdict};
use reduced::Reduced;

/// Most unknowns that a dense matrix is made for: 4000 take 130 MB for the matrix and about a minute.
pub const MOST_UNKNOWNS: usize = 4000;

/// A solution of the programme and how it was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct QpSolution {
    /// Pressure, displacement, residuals, cost.
    pub solution: DiscreteSolution,
    /// Whether the active set closed. If not, the pressures are those of the interior point.
    pub polished: bool,
    /// The symmetries that were used.
    pub symmetry: Symmetry,
}

/// Solves by Clarabel, then polishes.
///
/// `candidates` marks the cells that may carry pressure, when something is known; cells with f <= 0 are dropped in any
/// case, and cells that turn out to penetrate are taken in.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, gap::Cone, geometry::Rect, qp};
/// let grid = Grid::over(&Rect::around([0.0; 2], [0.7; 2]), [24, 24]);
/// let problem = Discrete::sample(&Cone::with_slope(1.0)?, 1.0, grid, Kernel::Galerkin);
/// let solved = qp::solve(&problem, None)?;
/// // Love 1939: P = 2 E* d^2/(pi tan(alpha)).
/// let force = solved.solution.pressure.iter().sum::<f64>() * grid.cell_area();
/// assert!((force / (2.0 / std::f64::consts::PI) - 1.0).abs() < 3e-3);
/// assert!(solved.polished && solved.solution.residuals.worst() < 1e-12);
/// assert_eq!(solved.symmetry.order(), 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// `TooLarge` beyond [`MOST_UNKNOWNS`] unknowns; `IterationLimit` when Clarabel does not reach an answer that the
/// recomputed residuals confirm.
pub fn solve(problem: &Discrete, candidates: Option<&[bool]>) -> Result<QpSolution, Unsolved> {
    solve_before(problem, candidates, Deadline::NEVER)
}

/// As [`solve`], stopped at the deadline: it is asked for between factorisations, of which the longest (4000 unknowns) takes
/// about ten seconds.
///
/// # Errors
/// As [`solve`]; `TimeLimit` when the time is used up.
pub fn solve_before(
    problem: &Discrete,
    candidates: Option<&[bool]>,
    deadline: Deadline,
) -> Result<QpSolution, Unsolved> {
    run(problem, candidates, true, deadline)
}

/// Solves by the active set alone, from all candidates: block pivoting with dense Cholesky factors.
///
/// # Errors
/// As [`solve`]; `IterationLimit` when the pivoting does not end.
pub fn solve_by_active_set(problem: &Discrete, candidates: Option<&[bool]>) -> Result<QpSolution, Unsolved> {
    run(problem, candidates, false, Deadline::NEVER)
}

fn run(
    problem: &Discrete,
    candidates: Option<&[bool]>,
    interior: bool,
    deadline: Deadline,
) -> Result<QpSolution, Unsolved> {
    let symmetry = Symmetry::of(problem);
    let admissible: Vec<bool> = problem.overlap.iter().map(|&f| f > 0.0).collect();
    let mut wanted = match candidates {
        Some(known) => known.iter().zip(&admissible).map(|(&k, &a)| k && a).collect(),
        None => admissible.clone(),
    };
    if !wanted.contains(&true) {
        wanted = admissible;
    }
    let (mut iterations, mut products) = (0, 0);
    loop {
        deadline.check()?;
        let orbits = symmetry.orbits(&wanted, problem.grid.shape);
        let unknowns = orbits.members.len();
        if unknowns > MOST_UNKNOWNS {
            let reason = format!(
                "{unknowns} unknowns; a dense matrix is made for at most {MOST_UNKNOWNS}: use fewer cells or the fft method"
            );
            return Err(Unsolved::new(Verdict::TooLarge, reason));
        }
        let reduced = Reduced::assemble(problem, orbits);
        let outcome = if unknowns == 0 {
            active_set::Outcome { pressure: Vec::new(), closed: true, factorisations: 0 }
        } else if interior {
            let start = interior_point::solve(&reduced, deadline)?;
            iterations += start.iterations;
            active_set::polish(&reduced, &start.pressure, deadline)
        } else {
            active_set::solve(&reduced, deadline)
        };
        iterations += outcome.factorisations;
        let (pressure, displacement) = reduced.spread(problem, &outcome.pressure);
        products += 1;
        let residuals = problem.residuals(&pressure, &displacement);
        // Cells that were left out and penetrate come in; the theorem behind pruning needs f <= 0.
        let allowed = PENETRATION * problem.deepest();
        let mut missed = false;
        for (k, wanted) in wanted.iter_mut().enumerate() {
            if !*wanted && problem.overlap[k] - displacement[k] > allowed {
                (*wanted, missed) = (true, true);
            }
        }
        if missed {
            continue;
        }
        if !outcome.closed {
            deadline.check()?;
        }
        if !outcome.closed && !(interior && residuals.worst() < UNPOLISHED) {
            let reason = format!("the active set did not close and residuals of {:.1e} are left", residuals.worst());
            return Err(Unsolved::new(Verdict::IterationLimit, reason));
        }
        let solution = DiscreteSolution {
            pressure,
            displacement,
            residuals,
            unknowns,
            iterations,
            operator_products: products,
            single_precision: 0,
        };
        return Ok(QpSolution { solution, polished: outcome.closed, symmetry });
    }
}

/// The rate at which the pressure of a solved problem grows when the overlap grows at the rates in `rates` on the cells
/// in contact: A m = rate there, m = 0 elsewhere. With the rate 1 this is the pressure of a flat punch of the
/// present plan-form, and its force the stiffness dP/dd.
///
/// # Errors
/// `TooLarge` beyond [`MOST_UNKNOWNS`] unknowns.
pub fn growth(problem: &Discrete, pressure: &[f64], rates: &[f64]) -> Result<Vec<f64>, Unsolved> {
    let contact: Vec<bool> = pressure.iter().map(|&p| p > 0.0).collect();
    let overlap = contact.iter().zip(rates).map(|(&c, &r)| if c { r } else { f64::NEG_INFINITY }).collect();
    let linear = Discrete { grid: problem.grid, kernel: problem.kernel, overlap };
    // Tilts grow with opposite signs on opposite sides: only the uniform rate shares the symmetries of the contact.
    let uniform = rates.iter().all(|&r| r == rates[0]);
    let symmetry = if uniform { Symmetry::of(&linear) } else { Symmetry::default() };
    let orbits = symmetry.orbits(&contact, problem.grid.shape);
    if orbits.members.len() > MOST_UNKNOWNS {
        let reason = format!("{} unknowns; a dense matrix is made for at most {MOST_UNKNOWNS}", orbits.members.len());
        return Err(Unsolved::new(Verdict::TooLarge, reason));
    }
    let reduced = Reduced::assemble(&linear, orbits);
    let set: Vec<usize> = (0..reduced.len()).collect();
    let y = active_set::on_set(&reduced, &set)
        .ok_or_else(|| Unsolved::new(Verdict::IterationLimit, "the compliance matrix of the contact is singular"))?;
    Ok(reduced.pressure_of(&linear, &y))
}

/// Penetration, relative to the largest overlap, that counts as rounding.
const PENETRATION: f64 = 1e-12;

/// Residual that an interior-point answer may leave when it could not be polished.
const UNPOLISHED: f64 = 1e-3;
