//! The exact contact at one depth: box, grid, solver, verification, refinement to the tolerance.

use crate::discrete::{Discrete, DiscreteSolution};
use crate::domain::{Door, locate, shape};
use crate::edges::{self, Edge, Ladder};
use crate::error::{Unsolved, Verdict};
use crate::extrapolate::{self, Estimate};
use crate::gap::Gap;
use crate::geometry::Rect;
use crate::grid::{Grid, Kernel};
use crate::homogeneity::Degree;
use crate::matrix_free;
use crate::settings::{Method, Settings};

/// Times a box may grow before the contact is taken to have no end.
const MOST_GROWTHS: usize = 12;

/// A solved grid, in the units of the door.
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

    /// U = 1/2 integral of p f = -J.
    pub fn energy(&self) -> f64 {
        let product = |(p, f): (&f64, &f64)| if *p > 0.0 { p * f } else { 0.0 };
        0.5 * self.solution.pressure.iter().zip(&self.problem.overlap).map(product).sum::<f64>()
            * self.problem.grid.cell_area()
    }
}

/// A loose solve; what the search for the box uses.
pub(crate) fn coarse(problem: &Discrete) -> Result<DiscreteSolution, Unsolved> {
    matrix_free::solve_nested(problem, &matrix_free::Settings { tolerance: 1e-3, ..matrix_free::Settings::default() })
}

/// The contact at one depth with `cells` cells along the longer side of a box that holds it.
pub(crate) fn at_resolution(
    door: &Door,
    window: &mut Rect,
    cells: usize,
    settings: &Settings,
    method: Method,
) -> Result<GridState, Unsolved> {
    let mut spent = (0, 0);
    for _ in 0..MOST_GROWTHS {
        let grid = Grid::over(window, shape(window, cells));
        let problem = Discrete::sample(&door.gap, door.depth, grid, settings.kernel);
        let state = solve(door, problem, method, settings.threads)?;
        spent = (spent.0 + state.iterations, spent.1 + state.operator_products);
        match outgrown(door, window, &state) {
            None => return Ok(GridState { iterations: spent.0, operator_products: spent.1, ..state }),
            Some(larger) => *window = larger,
        }
    }
    let reason = format!(
        "the box around the contact was enlarged {MOST_GROWTHS} times and the contact still reached its border"
    );
    Err(Unsolved::new(Verdict::Unbounded, reason))
}

/// A contact refined until the force is good enough.
#[derive(Debug, Clone)]
pub(crate) struct Refined {
    /// The finest grid.
    pub state: GridState,
    /// Best value of the force; that of the finest grid itself when the number of cells was prescribed.
    pub force: f64,
    /// Estimate of its error, absolute.
    pub error: f64,
    /// What kept the method from finer grids.
    pub stopped: Option<String>,
    /// The grids that it took where the contact ends at sharp edges; `state` is the finest.
    pub ladder: Option<Ladder>,
}

impl Refined {
    /// Best values of what is found in a state: of the finest grid, or the limits of all where the contact ends at sharp edges.
    ///
    /// # Errors
    /// Those of `values`.
    pub fn limits<const N: usize>(
        &self,
        values: impl Fn(&GridState) -> Result<[f64; N], Unsolved>,
    ) -> Result<[f64; N], Unsolved> {
        match &self.ladder {
            Some(ladder) => ladder.limits(values),
            None => values(&self.state),
        }
    }
}

/// The contact at one depth, on grids that double until the estimated error of the force is below the tolerance, or on
/// the prescribed number of cells and half of it.
pub(crate) fn refined(
    door: &Door,
    settings: &Settings,
    method: Method,
    degree: Option<Degree>,
) -> Result<Refined, Unsolved> {
    let best = as_far_as(FINEST, door, settings, method, degree)?;
    let reached = best.error / best.force;
    if settings.cells.is_some() || reached <= settings.tolerance {
        return Ok(best);
    }
    let reason = match best.stopped {
        Some(why) => format!("relative error {reached:.1e} reached; {why}"),
        None => format!(
            "relative error {reached:.1e} reached with {FINEST} cells along the longer side; the tolerance is {:.1e}",
            settings.tolerance
        ),
    };
    Err(Unsolved::new(Verdict::ToleranceNotReached, reason))
}

/// As [`refined`], with at most `finest` cells along the longer side where their number is not prescribed: the best that
/// can be had of them, whether or not that meets the tolerance.
///
/// The Galerkin energy of a homogeneous gap gives the force, P = (2 + 1/k) U/d, without the jitter of a sum over a
/// whole number of cells; it is that which is extrapolated.
pub(crate) fn as_far_as(
    finest: usize,
    door: &Door,
    settings: &Settings,
    method: Method,
    degree: Option<Degree>,
) -> Result<Refined, Unsolved> {
    let mut window = locate(door)?;
    let (mut forces, mut energies) = (Vec::new(), Vec::new());
    let mut spent = (0, 0);
    let ladder: Vec<usize> = match settings.cells {
        // Two coarser grids, for the estimate of the error; each costs a quarter of the next or less.
        Some(cells) => {
            [cells.div_ceil(4), cells.div_ceil(2), cells].into_iter().filter(|&n| n == cells || n >= 6).collect()
        }
        None => (0..).map(|level| COARSEST << level).take_while(|&n| n <= finest).collect(),
    };
    let mut best: Option<Refined> = None;
    for cells in ladder {
        let state = match at_resolution(door, &mut window, cells, settings, method) {
            // The grid before was the finest that this method can hold.
            Err(e) if e.verdict == Verdict::TooLarge && settings.cells.is_none() && best.is_some() => {
                best = best.map(|b| Refined { stopped: Some(e.reason), ..b });
                break;
            }
            other => other?,
        };
        spent = (spent.0 + state.iterations, spent.1 + state.operator_products);
        let state = GridState { iterations: spent.0, operator_products: spent.1, ..state };
        let force = state.force();
        if force <= 0.0 && settings.cells.is_none() {
            // No cell overlaps as a whole: the grid is too coarse to tell anything.
            continue;
        }
        forces.push(force);
        let from_energy = degree.filter(|_| settings.kernel == Kernel::Galerkin);
        let limit = if let Some(degree) = from_energy {
            energies.push((2.0 + degree.inverse()) * state.energy() / door.depth);
            extrapolate::of_energies(&energies)
        } else {
            extrapolate::of_forces(&forces)
        };
        let Estimate { value, mut error } = limit.unwrap_or(Estimate { value: force, error: force });
        // Energies of homogeneous gaps converge smoothly. Forces may seem to converge while an edge falls between two cells: a
        // grid is believed when means over cells and values at their centres agree on it.
        let last = settings.cells == Some(cells);
        if from_energy.is_none() && (last || (forces.len() >= 3 && error <= settings.tolerance * value)) {
            error = error.max((other_kernel(door, &state)? - force).abs());
        }
        if settings.cells.is_some() {
            // Who prescribes the grid wants the force of that grid.
            best = Some(Refined { state, force, error: error + (force - value).abs(), stopped: None, ladder: None });
            continue;
        }
        // Edges of flat punches converge with another order than smooth contacts: three grids show which.
        let clean = matches!(from_energy, Some(Degree::Power(_)));
        let close = error <= settings.tolerance * value && (clean || forces.len() >= 3);
        // Three grids may agree on a limit that is not the punch's while its edges lie between two rows of cells.
        let edge = if forces.len() >= 3 && !clean { edges::met(door, &state) } else { None };
        let ends = edge == Some(Edge::End);
        let aligned = ends && edges::left_out(door, &state) == 0.0;
        let good = close && (aligned || !ends);
        if !good && ends {
            return sharp(door, &mut window, aligned, finest, settings, method, spent);
        }
        if !good && edge == Some(Edge::Step) && cells == STEPPED {
            // A flank may be resolved yet: only if a line does better than that.
            let tried = sharp(door, &mut window, false, finest, settings, method, spent);
            if let Some(found) = tried.ok().filter(|found| found.error <= settings.tolerance * found.force) {
                return Ok(found);
            }
        }
        best = Some(Refined { state, force: value, error, stopped: None, ladder: None });
        if good {
            break;
        }
    }
    // The door opens only when the bodies overlap somewhere, so they do touch.
    best.filter(|b| b.force > 0.0).ok_or_else(|| {
        let reason = "the bodies overlap, but no cell does as a whole: the grid is too coarse to see the contact";
        Unsolved::new(Verdict::ToleranceNotReached, reason)
    })
}

/// The same where the contact ends at sharp edges; `spent` are iterations and products so far.
fn sharp(
    door: &Door,
    window: &mut Rect,
    aligned: bool,
    finest: usize,
    settings: &Settings,
    method: Method,
    spent: (usize, usize),
) -> Result<Refined, Unsolved> {
    let (ladder, Estimate { value, error }) = edges::ladder(door, window, aligned, finest, settings, method)?;
    let (iterations, operator_products) = ladder.spent();
    let mut state = ladder.last().clone();
    (state.iterations, state.operator_products) = (spent.0 + iterations, spent.1 + operator_products);
    state.remarks.push(format!("sharp edges: the limit of {} grids, by a line", ladder.grids()));
    let stopped =
        Some(format!("{} cells along the longer side are the most that are tried at sharp edges", edges::FINEST));
    Ok(Refined { state, force: value, error, stopped, ladder: Some(ladder) })
}

/// The force on the same grid by the other kernel.
pub(crate) fn other_kernel(door: &Door, state: &GridState) -> Result<f64, Unsolved> {
    let kernel = match state.problem.kernel {
        Kernel::Galerkin => Kernel::Collocation,
        Kernel::Collocation => Kernel::Galerkin,
    };
    let problem = Discrete::sample(&door.gap, door.depth, state.problem.grid, kernel);
    let settings = matrix_free::Settings { tolerance: 1e-5, ..matrix_free::Settings::default() };
    let solution = matrix_free::solve_nested(&problem, &settings)?;
    Ok(solution.pressure.iter().sum::<f64>() * problem.grid.cell_area())
}

/// Cells along the longer side at which a step of the gap is no longer hoped to be a flank.
const STEPPED: usize = 512;

/// Cells along the longer side of the first grid.
const COARSEST: usize = 16;

/// Cells along the longer side of the last grid that is tried.
const FINEST: usize = 2048;

/// One grid by one method.
fn solve(door: &Door, problem: Discrete, method: Method, threads: usize) -> Result<GridState, Unsolved> {
    let cells = problem.grid.len();
    let pruned = problem.overlap.iter().filter(|&&f| f <= 0.0).count();
    let mut left_out = vec![format!("{pruned} of {cells} cells: the undeformed bodies do not overlap there")];
    let mut remarks = Vec::new();
    let solution = match method {
        Method::Qp => programme::solve(door, &problem, &mut left_out, &mut remarks)?,
        _ => {
            matrix_free::solve_nested(&problem, &matrix_free::Settings { threads, ..matrix_free::Settings::default() })?
        }
    };
    Ok(GridState { left_out, remarks, ..GridState::of(method, problem, solution) })
}

/// In place of the quadratic programme, when it was not built.
#[cfg(not(feature = "qp"))]
mod programme {
    use super::{Discrete, DiscreteSolution, Door, Unsolved, Verdict};

    /// The verdict that says so.
    pub fn solve(
        _: &Door,
        _: &Discrete,
        _: &mut Vec<String>,
        _: &mut Vec<String>,
    ) -> Result<DiscreteSolution, Unsolved> {
        Err(Unsolved::new(Verdict::NotApplicable, "this build has no quadratic programme (feature qp)"))
    }
}

/// The quadratic programme on the cells that can touch.
#[cfg(feature = "qp")]
mod programme {
    use super::{COARSEST, Discrete, DiscreteSolution, Door, Grid, Unsolved};
    use crate::qp::{self, QpSolution};

    /// Solves, and says what was left out on the way.
    pub fn solve(
        door: &Door,
        problem: &Discrete,
        left_out: &mut Vec<String>,
        remarks: &mut Vec<String>,
    ) -> Result<DiscreteSolution, Unsolved> {
        let known = candidates(door, problem)?;
        let QpSolution { solution, polished, symmetry } = qp::solve(problem, known.as_deref())?;
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
    fn candidates(door: &Door, problem: &Discrete) -> Result<Option<Vec<bool>>, Unsolved> {
        let fine = &problem.grid;
        if fine.shape[0].max(fine.shape[1]) < 2 * COARSEST {
            return Ok(None);
        }
        let coarse = Grid::over(&fine.extent(), fine.shape.map(|n| n.div_ceil(2)));
        let halved = Discrete::sample(&door.gap, door.depth, coarse, problem.kernel);
        let known = candidates(door, &halved)?;
        let touching = qp::solve_by_active_set(&halved, known.as_deref())?.solution.pressure;
        let near = |[i, j]: [usize; 2]| {
            let around = |n: usize, k: usize| n.saturating_sub(1)..(n + 2).min(coarse.shape[k]);
            around(j, 1).any(|j| around(i, 0).any(|i| touching[j * coarse.shape[0] + i] > 0.0))
        };
        let below = |n: usize, k: usize| (n * coarse.shape[k] / fine.shape[k]).min(coarse.shape[k] - 1);
        Ok(Some((0..fine.len()).map(|k| near([below(k % fine.shape[0], 0), below(k / fine.shape[0], 1)])).collect()))
    }
}

/// dP/dd of the discrete problem: the force of a flat punch on the cells in contact.
pub(crate) fn stiffness(state: &GridState) -> Result<f64, Unsolved> {
    let rates = vec![1.0; state.problem.grid.len()];
    let flat = growth(state, &rates)?;
    Ok(flat.iter().sum::<f64>() * state.problem.grid.cell_area())
}

/// Derivatives of (P, int p x, int p y) by (d, ax, ay), with x and y the lever arms of each cell.
pub(crate) fn stiffness_matrix(
    state: &GridState,
    arm: impl Fn([f64; 2]) -> [f64; 2],
) -> Result<[[f64; 3]; 3], Unsolved> {
    let grid = &state.problem.grid;
    let arms: Vec<[f64; 2]> = (0..grid.len()).map(|k| arm(grid.centre_of(k))).collect();
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
    #[cfg(feature = "qp")]
    if state.method == Method::Qp {
        return crate::qp::growth(&state.problem, &state.solution.pressure, rates);
    }
    let settings = matrix_free::Settings { tolerance: 1e-9, ..matrix_free::Settings::default() };
    matrix_free::growth(&state.problem, &state.solution.pressure, rates, &settings)
}

/// The gap left in each cell after loading: zero in contact, infinite where there is no material.
pub(crate) fn gap_left(state: &GridState) -> Vec<f64> {
    let pressure = &state.solution.pressure;
    let displacement = matrix_free::displacement(&state.problem, pressure);
    let left = |((p, u), f): ((&f64, &f64), &f64)| if *p > 0.0 { 0.0 } else { u - f };
    pressure.iter().zip(&displacement).zip(&state.problem.overlap).map(left).collect()
}

/// A larger box, when contact touches a border with overlap beyond it, or a point outside penetrates.
pub(crate) fn outgrown(door: &Door, window: &Rect, state: &GridState) -> Option<Rect> {
    let grid = &state.problem.grid;
    let loaded =
        Rect::holding((0..grid.len()).filter(|&k| state.solution.pressure[k] > 0.0).map(|k| grid.centre_of(k)))?;
    let mut wanted = *window;
    for axis in 0..2 {
        let h = grid.spacing[axis];
        let grow = 0.2 * window.size()[axis];
        // A whole number of cells: the new grid is then no other sample of the gap than it has to be.
        if loaded.min[axis] < window.min[axis] + h && window.min[axis] > door.reach.min[axis] {
            wanted.min[axis] -= grow;
        }
        if loaded.max[axis] > window.max[axis] - h && window.max[axis] < door.reach.max[axis] {
            wanted.max[axis] += grow;
        }
    }
    for point in penetrating_outside(door, window, state) {
        wanted = wanted.union(&Rect::around(point, [2.0 * grid.spacing[0], 2.0 * grid.spacing[1]]));
    }
    let wanted = wanted.intersection(&door.reach).unwrap_or(wanted);
    (wanted != *window).then_some(wanted)
}

/// Lattice points between the box and the limit of {f > 0} where the loaded surfaces would overlap.
fn penetrating_outside(door: &Door, window: &Rect, state: &GridState) -> Vec<[f64; 2]> {
    let grid = &state.problem.grid;
    let [w, h] = door.reach.size();
    let count = |size: f64, spacing: f64| ((size / spacing).ceil() as usize).clamp(1, OUTSIDE);
    let lattice = Grid::over(&door.reach, [count(w, grid.spacing[0]), count(h, grid.spacing[1])]);
    let area = grid.cell_area();
    let loaded: Vec<([f64; 2], f64)> = (0..grid.len())
        .filter(|&k| state.solution.pressure[k] > 0.0)
        .map(|k| (grid.centre_of(k), state.solution.pressure[k] * area))
        .collect();
    let gathered = gathered(&loaded, window);
    let under = |loads: &[([f64; 2], f64)], [x, y]: [f64; 2]| {
        loads.iter().map(|([a, b], q)| q / (x - a).hypot(y - b)).sum::<f64>() / std::f64::consts::PI
    };
    let force: f64 = loaded.iter().map(|l| l.1).sum();
    let [px, py] = centre_of_load(&loaded);
    (0..lattice.len())
        .map(|k| lattice.centre_of(k))
        .filter(|p| !window.contains(*p))
        .filter(|&[x, y]| {
            let f = door.depth - door.gap.gap(x, y);
            // The whole load at its centre, at the farthest it can be: cheap, and enough nearly everywhere.
            let farthest = (x - px).hypot(y - py) + window.size()[0].hypot(window.size()[1]);
            if f <= force / (std::f64::consts::PI * farthest) {
                return false;
            }
            // Then block by block; every cell for itself only where that leaves it open.
            let u = under(&gathered, [x, y]);
            if f > 0.9 * u && f < 1.1 * u { f > under(&loaded, [x, y]) + 1e-9 } else { f > u + 1e-9 }
        })
        .collect()
}

/// The loads of a block of the box at their common centre: a sixteenth of the box a side, so that a point a block away
/// feels them to a few per cent.
fn gathered(loaded: &[([f64; 2], f64)], window: &Rect) -> Vec<([f64; 2], f64)> {
    let mut blocks = vec![Vec::new(); BLOCKS * BLOCKS];
    let size = window.size();
    for &(at, q) in loaded {
        let [i, j] =
            [0, 1].map(|m| ((at[m] - window.min[m]) / size[m] * BLOCKS as f64).clamp(0.0, BLOCKS as f64 - 1.0));
        blocks[i as usize * BLOCKS + j as usize].push((at, q));
    }
    let total = |block: &Vec<([f64; 2], f64)>| (centre_of_load(block), block.iter().map(|l| l.1).sum());
    blocks.iter().filter(|block| !block.is_empty()).map(total).collect()
}

fn centre_of_load(loads: &[([f64; 2], f64)]) -> [f64; 2] {
    let force: f64 = loads.iter().map(|l| l.1).sum();
    loads.iter().fold([0.0; 2], |m, (c, q)| [m[0] + c[0] * q / force, m[1] + c[1] * q / force])
}

/// Blocks of the box along a side.
const BLOCKS: usize = 16;

/// Most lattice points along a side outside the box.
const OUTSIDE: usize = 256;
