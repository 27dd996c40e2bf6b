//! The contact at one depth on one grid: box, cells, solver, stiffness.

use super::expansion::expanded;
use crate::clock::Deadline;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::energy::Trial;
use crate::grid::{Grid, Kernel, shape};
use crate::matrix_free;
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;
use crate::problem::{Method, Settings};
use crate::solution::{Unsolved, Verdict};

/// Times a box may grow before the contact is taken to have no end.
const MOST_GROWTHS: usize = 12;

/// A solved grid, in the units of the scaled.
#[derive(Debug, Clone)]
pub(crate) struct GridState {
    pub method: Method,
    pub problem: Discrete,
    pub solution: DiscreteSolution,
    /// Iterations and products of all levels and boxes.
    pub iterations: usize,
    pub operator_products: usize,
    pub left_out: Vec<String>,
    pub remarks: Vec<String>,
}

impl GridState {
    /// A solution of a problem, as it comes from the solver.
    pub fn of(method: Method, problem: Discrete, solution: DiscreteSolution) -> Self {
        let (iterations, operator_products) = (solution.iterations, solution.operator_products);
        Self { method, problem, solution, iterations, operator_products, left_out: Vec::new(), remarks: Vec::new() }
    }

    pub fn force(&self) -> f64 {
        self.solution.pressure.iter().sum::<f64>() * self.problem.grid.cell_area()
    }

    /// How many times as many cells, along a side, it has as another in the same place.
    pub fn times_as_fine_as(&self, other: &Self) -> f64 {
        (other.problem.grid.cell_area() / self.problem.grid.cell_area()).sqrt()
    }

    /// Where the resultant of the pressure acts.
    pub fn centre(&self) -> [f64; 2] {
        let (grid, pressure) = (&self.problem.grid, &self.solution.pressure);
        let total: f64 = pressure.iter().sum();
        let sums = pressure.iter().enumerate().fold([0.0; 2], |[sx, sy], (k, p)| {
            let [x, y] = grid.centre_of(k);
            [sx + p * x, sy + p * y]
        });
        sums.map(|s| s / total)
    }

    /// The pressure as a trial of the energy; with its displacement where that is the one of means over cells. That of the quadratic
    /// programme comes from a dense matrix, and is worked out anew.
    pub fn trial(&self) -> Trial<'_> {
        let Self { method, problem, solution, .. } = self;
        let known = problem.kernel == Kernel::Galerkin && *method == Method::Fft;
        let displacement = known.then_some(solution.displacement.as_slice());
        Trial { grid: &problem.grid, pressure: &solution.pressure, displacement }
    }

    /// U = -J = integral of p f - p u/2: the largest there is, so that what a pressure misses counts by its square alone.
    pub fn energy(&self) -> f64 {
        let DiscreteSolution { pressure, displacement, .. } = &self.solution;
        let product = |((p, f), u): ((&f64, &f64), &f64)| if *p > 0.0 { p * (f - 0.5 * u) } else { 0.0 };
        pressure.iter().zip(&self.problem.overlap).zip(displacement).map(product).sum::<f64>()
            * self.problem.grid.cell_area()
    }
}

/// How a grid is to be solved.
#[derive(Clone, Copy)]
pub(crate) struct GridOptions<'a> {
    pub method: Method,
    pub kernel: Kernel,
    pub threads: usize,
    pub deadline: Deadline,
    /// Largest error of the gap, relative to the depth.
    pub tolerance: f64,
    /// A solved grid to start from, when its cells are twice as large.
    pub coarser: Option<&'a GridState>,
}

impl GridOptions<'_> {
    /// To eight digits, from nothing.
    pub fn precise(settings: &Settings, method: Method) -> Self {
        let tolerance = matrix_free::Settings::default().tolerance;
        let Settings { kernel, threads, deadline, .. } = *settings;
        Self { method, kernel, threads, deadline, tolerance, coarser: None }
    }
}

/// The contact at one depth with `cells` cells along the longer side of a box that holds it.
pub(crate) fn at_resolution(
    scaled: &Scaled,
    window: &mut Rect,
    cells: usize,
    settings: &Settings,
    method: Method,
) -> Result<GridState, Unsolved> {
    laid(scaled, window, |window| Grid::over(window, shape(window, cells)), GridOptions::precise(settings, method))
}

/// The contact at one depth on the grid that belongs to a box that holds it.
pub(crate) fn laid(
    scaled: &Scaled,
    window: &mut Rect,
    lay: impl Fn(&Rect) -> Grid,
    options: GridOptions,
) -> Result<GridState, Unsolved> {
    let mut spent = (0, 0);
    for _ in 0..MOST_GROWTHS {
        options.deadline.check()?;
        let grid = lay(window);
        let problem = Discrete::sample_before(&scaled.gap, scaled.depth, grid, options.kernel, options.deadline)?;
        let state = solve(scaled, problem, options)?;
        spent = (spent.0 + state.iterations, spent.1 + state.operator_products);
        match expanded(scaled, window, &state.problem.grid, &state.solution.pressure) {
            None => return Ok(GridState { iterations: spent.0, operator_products: spent.1, ..state }),
            Some(larger) => *window = larger,
        }
    }
    let reason = format!(
        "the box around the contact was enlarged {MOST_GROWTHS} times and the contact still reached its border"
    );
    Err(Unsolved::new(Verdict::Unbounded, reason))
}

/// The force on the same grid by the other kernel.
pub(crate) fn other_kernel(scaled: &Scaled, state: &GridState) -> Result<f64, Unsolved> {
    Ok(by_other_kernel(scaled, state)?.iter().sum::<f64>() * state.problem.grid.cell_area())
}

fn by_other_kernel(scaled: &Scaled, state: &GridState) -> Result<Vec<f64>, Unsolved> {
    let problem = Discrete::sample(&scaled.gap, scaled.depth, state.problem.grid, state.problem.kernel.other());
    let settings = matrix_free::Settings { tolerance: 1e-5, ..matrix_free::Settings::default() };
    Ok(matrix_free::solve(&problem, Some(&state.solution.pressure), &settings)?.pressure)
}

/// By how much the load differs on the same grid by the other kernel: the force, or its moments about where it acts over the size of the
/// contact, which may differ where the force by chance does not.
pub(crate) fn load_by_other_kernel(scaled: &Scaled, state: &GridState) -> Result<f64, Unsolved> {
    let (grid, own) = (&state.problem.grid, &state.solution.pressure);
    let other = by_other_kernel(scaled, state)?;
    let centre = state.centre();
    let mut off = [0.0; 3];
    for (k, more) in other.iter().zip(own).map(|(a, b)| a - b).enumerate() {
        let [x, y] = grid.centre_of(k);
        off = [off[0] + more, off[1] + more * (x - centre[0]), off[2] + more * (y - centre[1])];
    }
    let loaded = own.iter().filter(|p| **p > 0.0).count() as f64;
    let size = (loaded * grid.cell_area() / std::f64::consts::PI).sqrt();
    Ok(off[0].abs().max(off[1].hypot(off[2]) / size) * grid.cell_area())
}

/// One grid by one method.
fn solve(scaled: &Scaled, problem: Discrete, options: GridOptions) -> Result<GridState, Unsolved> {
    let cells = problem.grid.len();
    let pruned = problem.overlap.iter().filter(|&&f| f <= 0.0).count();
    let pruned = (pruned > 0).then(|| format!("{pruned} of {cells} cells: the undeformed bodies do not overlap there"));
    let mut left_out = Vec::from_iter(pruned);
    let mut remarks = Vec::new();
    let GridOptions { method, threads, deadline, tolerance, .. } = options;
    let solution = match method {
        Method::Qp => programme::solve(scaled, &problem, deadline, &mut left_out, &mut remarks)?,
        _ => {
            let settings = matrix_free::Settings { threads, tolerance, deadline, ..matrix_free::Settings::default() };
            match options.coarser.and_then(|coarser| start(coarser, &problem.grid)) {
                Some(start) => matrix_free::solve(&problem, Some(&start), &settings)?,
                None => matrix_free::solve_nested(&problem, &settings)?,
            }
        }
    };
    Ok(GridState { left_out, remarks, ..GridState::of(method, problem, solution) })
}

/// The pressure of a grid on another of half its cells' sides; `None` when that is not what it is.
fn start(coarser: &GridState, grid: &Grid) -> Option<Vec<f64>> {
    let coarse = &coarser.problem.grid;
    let same = coarse.extent() == grid.extent() && coarse.shape.map(|n| 2 * n) == grid.shape;
    (same && coarser.force() > 0.0).then(|| matrix_free::halved(coarse.shape, &coarser.solution.pressure))
}

/// In place of the quadratic programme, when it was not built.
#[cfg(not(feature = "qp"))]
mod programme {
    use super::{Deadline, Discrete, DiscreteSolution, Scaled, Unsolved, Verdict};

    /// The verdict that says so.
    pub fn solve(
        _: &Scaled,
        _: &Discrete,
        _: Deadline,
        _: &mut Vec<String>,
        _: &mut Vec<String>,
    ) -> Result<DiscreteSolution, Unsolved> {
        Err(Unsolved::new(Verdict::NotApplicable, "this build has no quadratic programme (feature qp)"))
    }
}

/// The quadratic programme on the cells that can touch.
#[cfg(feature = "qp")]
mod programme {
    use super::{Deadline, Discrete, DiscreteSolution, Grid, Scaled, Unsolved};
    use crate::qp::{self, QpSolution};

    /// Cells along the longer side below which no coarser grid is asked.
    const FEWEST: usize = 32;

    /// Solves, and says what was left out on the way.
    pub fn solve(
        scaled: &Scaled,
        problem: &Discrete,
        deadline: Deadline,
        left_out: &mut Vec<String>,
        remarks: &mut Vec<String>,
    ) -> Result<DiscreteSolution, Unsolved> {
        let known = candidates(scaled, problem, deadline)?;
        let QpSolution { solution, polished, symmetry } = qp::solve_before(problem, known.as_deref(), deadline)?;
        if let Some(known) = known {
            let far = known.iter().zip(&problem.overlap).filter(|&(&k, &f)| !k && f > 0.0).count();
            left_out.push(format!(
                "{far} cells away from the contact of a coarser grid; verified: none of them penetrates"
            ));
        }
        if symmetry.order() > 1 {
            let unknowns = solution.unknowns;
            left_out.push(format!("all but {unknowns} unknowns, by symmetry of gap and grid: {}", symmetry.words()));
        }
        if !polished {
            remarks.push("the active set did not close: the pressures are those of the interior point".to_owned());
        }
        Ok(solution)
    }

    /// The cells that can touch, from a solve on cells twice as large: its contact and one of its cells around.
    fn candidates(scaled: &Scaled, problem: &Discrete, deadline: Deadline) -> Result<Option<Vec<bool>>, Unsolved> {
        let fine = &problem.grid;
        if fine.shape[0].max(fine.shape[1]) < FEWEST {
            return Ok(None);
        }
        let coarse = Grid::over(&fine.extent(), fine.shape.map(|n| n.div_ceil(2)));
        let halved = Discrete::sample(&scaled.gap, scaled.depth, coarse, problem.kernel);
        let known = candidates(scaled, &halved, deadline)?;
        deadline.check()?;
        let touching = qp::solve_by_active_set(&halved, known.as_deref())?.solution.pressure;
        let near = |[i, j]: [usize; 2]| {
            let around = |n: usize, k: usize| n.saturating_sub(1)..(n + 2).min(coarse.shape[k]);
            around(j, 1).any(|j| around(i, 0).any(|i| touching[j * coarse.shape[0] + i] > 0.0))
        };
        let below = |n: usize, k: usize| (n * coarse.shape[k] / fine.shape[k]).min(coarse.shape[k] - 1);
        Ok(Some((0..fine.len()).map(|k| near([below(k % fine.shape[0], 0), below(k / fine.shape[0], 1)])).collect()))
    }
}

/// Residual of the pressures that grow, and error of their sum where that alone is asked for.
pub(super) const OF_GROWTH: f64 = 1e-8;

/// dP/dd of the discrete problem: the force of a flat punch on the cells in contact.
pub(crate) fn stiffness(state: &GridState) -> Result<f64, Unsolved> {
    Ok(flat_punch(state)?.iter().sum::<f64>() * state.problem.grid.cell_area())
}

/// Pressure of a flat punch on the cells in contact, as close as its sum needs it.
pub(crate) fn flat_punch(state: &GridState) -> Result<Vec<f64>, Unsolved> {
    growth_by(matrix_free::growth_in_sum, state, &vec![1.0; state.problem.grid.len()], OF_GROWTH)
}

/// Derivatives of (P, int p x, int p y) by (d, ax, ay), with x and y the lever arms of each cell.
pub(crate) fn stiffness_matrix(
    state: &GridState,
    arm: impl Fn([f64; 2]) -> [f64; 2],
) -> Result<[[f64; 3]; 3], Unsolved> {
    let grid = &state.problem.grid;
    let arms: Vec<[f64; 2]> = grid.centres().map(arm).collect();
    let rates = [vec![1.0; grid.len()], arms.iter().map(|a| a[0]).collect(), arms.iter().map(|a| a[1]).collect()];
    let mut matrix = [[0.0; 3]; 3];
    for (column, rate) in rates.iter().enumerate() {
        let growing = growth(state, rate)?;
        for (row, weight) in rates.iter().enumerate() {
            matrix[row][column] = growing.iter().zip(weight).map(|(m, w)| m * w).sum::<f64>() * grid.cell_area();
        }
    }
    // Symmetric by reciprocity; what differs is what the solver left.
    let mean = |i: usize, j: usize| 0.5 * (matrix[i][j] + matrix[j][i]);
    Ok([0, 1, 2].map(|i| [0, 1, 2].map(|j| mean(i, j))))
}

/// Pressure that grows on the cells in contact when their overlap grows at the given rates; see [`matrix_free::growth`].
pub(crate) fn growth(state: &GridState, rates: &[f64]) -> Result<Vec<f64>, Unsolved> {
    growth_within(OF_GROWTH, state, rates)
}

/// The same to another residual, in the largest of the rates.
pub(crate) fn growth_within(tolerance: f64, state: &GridState, rates: &[f64]) -> Result<Vec<f64>, Unsolved> {
    growth_by(matrix_free::growth, state, rates, tolerance)
}

/// How pressures that grow are found without a matrix.
type Growth = fn(&Discrete, &[f64], &[f64], &matrix_free::Settings) -> Result<Vec<f64>, Unsolved>;

fn growth_by(found: Growth, state: &GridState, rates: &[f64], tolerance: f64) -> Result<Vec<f64>, Unsolved> {
    #[cfg(feature = "qp")]
    if state.method == Method::Qp {
        return crate::qp::growth(&state.problem, &state.solution.pressure, rates);
    }
    let settings = matrix_free::Settings { tolerance, ..matrix_free::Settings::default() };
    found(&state.problem, &state.solution.pressure, rates, &settings)
}
