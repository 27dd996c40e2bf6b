//! From coarse grids to fine ones: each starts from the pressure of the one before.
//!
//! A coarse cell is two by two fine ones and its overlap the mean of theirs: for cell means (Galerkin) that is the coarse
//! problem itself, for values at centres it is close, and a start is all that is wanted of it. One table of influence
//! coefficients serves all grids.

use super::level::Limit;
use super::window::Window;
use super::{Cells, Left, Operators, SYMMETRIC, Scratch, Settings, are_many, no_contact, region_around, with_threads};
use crate::discrete::{Discrete, DiscreteSolution};
use crate::influence::InfluenceTable;
use crate::solution::Unsolved;

/// Error of the gap on the grids before the last, relative to the depth: well below their distance from the next grid. What is
/// left on a coarse grid is smooth, and dear on the fine one: at 5e-4 a paraboloid on 1024 cells takes 6 products more. At 3e-5 the
/// coarse grids cost more than they save.
const COARSE_TOLERANCE: f64 = 1e-4;

/// Cells along the longer side of the coarsest grid.
const COARSEST: usize = 12;

/// Solves from a coarse grid up: the call for a problem without a good start.
///
/// # Errors
/// [`crate::Verdict::IterationLimit`] when the tolerance is not reached on the last grid within the products allowed,
/// [`crate::Verdict::TimeLimit`] when it is not reached before the deadline.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, geometry::Rect, matrix_free};
///
/// // A cone, d = tan(alpha) = 1: P = 2/pi E* d^2/tan(alpha) (Sneddon 1965).
/// let grid = Grid::over(&Rect { min: [-1.0, -1.0], max: [1.0, 1.0] }, [200, 200]);
/// let problem = Discrete::sample(&|x: f64, y: f64| x.hypot(y), 1.0, grid, Kernel::Galerkin);
/// let solution = matrix_free::solve_nested(&problem, &matrix_free::Settings::default())?;
/// let force = solution.pressure.iter().sum::<f64>() * grid.cell_area();
/// assert!((force * std::f64::consts::FRAC_PI_2 - 1.0).abs() < 1e-4);
/// # Ok::<(), contact_patch::Unsolved>(())
/// ```
pub fn solve_nested(problem: &Discrete, settings: &Settings) -> Result<DiscreteSolution, Unsolved> {
    let Some(window) = Window::of(problem, SYMMETRIC * settings.tolerance) else { return Ok(no_contact(problem)) };
    let table = window.table(problem);
    with_threads(settings.threads, window.shape(), |scratch| {
        let left = from_coarse(window.grid(problem), &table, settings, scratch, |_| true);
        window.finish(problem, &table, left, settings, scratch)
    })
}

/// Solves a grid from coarser ones of it, as long as what they are deeper by will do; that of the grid is counted from its overlap.
pub(super) fn from_coarse(
    grid: Cells,
    table: &InfluenceTable,
    settings: &Settings,
    scratch: &mut Scratch,
    will_do: impl Fn(f64) -> bool,
) -> Left {
    let mut grids = vec![grid];
    while let Some(coarser) = grids.last().and_then(|grid| coarser(grid, scratch)) {
        grids.push(coarser);
    }
    let mut start: Option<Vec<f64>> = None;
    let mut deeper = 0.0;
    let shared = scratch.is_shared();
    loop {
        let level = grids.len() - 1;
        let Some(mut grid) = grids.pop() else { unreachable!("the finest grid returns") };
        scratch.shared(shared && are_many(grid.shape));
        let (tolerance, products) = match level {
            0 => (settings.tolerance, settings.products),
            _ => (COARSE_TOLERANCE.max(settings.tolerance), 60),
        };
        let limit = Limit { products, deadline: settings.deadline };
        let region = region_around(grid.shape, grid.mirrored, start.as_deref());
        let operators = Operators::new(table, grid.shape, region, grid.mirrored, level == 0, scratch);
        grid.overlap.iter_mut().for_each(|f| *f += deeper);
        let mut left = grid.solve(table, &operators, start.take(), tolerance, limit, scratch);
        deeper += left.state.deeper;
        let Some(next) = grids.last().filter(|_| will_do(deeper)) else {
            left.state.deeper = deeper;
            left.solved &= level == 0;
            scratch.shared(shared);
            return left;
        };
        start = Some(finer(&grid, &left.state.p, next.shape, scratch));
    }
}

/// Two by two cells made one. `None` when the grid is coarse enough or nothing overlaps on the next.
fn coarser(fine: &Cells, scratch: &Scratch) -> Option<Cells> {
    let [nx, ny] = fine.shape;
    let height = if fine.mirrored { 2 * ny } else { ny };
    if nx.max(height) < 2 * COARSEST || nx.min(height) < 4 {
        return None;
    }
    let shape = [nx.div_ceil(2), ny.div_ceil(2)];
    let mut overlap = vec![-1.0; shape[0] * shape[1]];
    let rows = overlap.chunks_exact_mut(shape[0]).zip(fine.overlap.chunks(2 * nx));
    let deepest = scratch.each(rows, |(means, fine)| {
        for (i, mean) in means.iter_mut().enumerate() {
            let (mut sum, mut cells) = (0.0, 0);
            for row in fine.chunks_exact(nx) {
                for f in row[2 * i..].iter().take(2).filter(|f| **f > -1.0) {
                    sum += f;
                    cells += 1;
                }
            }
            // Where half of the cell has no material the other half decides.
            if cells >= 2 {
                *mean = sum / f64::from(cells);
            }
        }
        means.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    });
    let deepest = deepest.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // The pressure that moves a cell by the depth is half as large, the cells are a quarter.
    let load = fine.load.map(|load| 0.5 * load);
    (deepest > 0.0).then_some(Cells { shape, mirrored: fine.mirrored, overlap, load })
}

/// The pressure on the cells of `coarse` as a start on cells of half their sides.
///
/// ```
/// use contact_patch::matrix_free::halved;
/// // Every cell keeps its load.
/// let fine = halved([2, 1], &[4.0, 0.0]);
/// assert_eq!(fine.len(), 8);
/// assert!((fine.iter().sum::<f64>() / 4.0 - 4.0).abs() < 1e-14);
/// ```
#[must_use]
pub fn halved(coarse: [usize; 2], pressure: &[f64]) -> Vec<f64> {
    shared_out(coarse, false, pressure, coarse.map(|n| 2 * n), &Scratch::new())
}

/// Halved: the pressure that moves a cell by the depth is twice as large on cells of half the side.
fn finer(coarse: &Cells, p: &[f64], shape: [usize; 2], scratch: &Scratch) -> Vec<f64> {
    let mut fine = shared_out(coarse.shape, coarse.mirrored, p, shape, scratch);
    fine.iter_mut().for_each(|p| *p *= 0.5);
    fine
}

/// The pressure of coarse cells shared out among their quarters. Each keeps its load; within it the pressure is linear, with the
/// slope of its neighbours (exact for means of quadratics), or like the root of the distance at the edge of the contact.
fn shared_out([cx, cy]: [usize; 2], mirrored: bool, p: &[f64], [nx, ny]: [usize; 2], scratch: &Scratch) -> Vec<f64> {
    let mut fine = vec![0.0; nx * ny];
    scratch.each(fine.chunks_mut(2 * nx).take(cy).enumerate(), |(j, fine)| {
        for i in 0..cx {
            let here = p[j * cx + i];
            if here <= 0.0 {
                continue;
            }
            let at = |inside: bool, k: usize| if inside { p[k] } else { 0.0 };
            let k = j * cx + i;
            let west = at(i > 0, k.wrapping_sub(1));
            let east = at(i + 1 < cx, k + 1);
            let south = if j == 0 && mirrored { here } else { at(j > 0, k.wrapping_sub(cx)) };
            let north = at(j + 1 < cy, k + cx);
            let (along, across) = (halves(west, here, east), halves(south, here, north));
            for (t, v) in across.into_iter().enumerate() {
                for (s, u) in along.into_iter().enumerate() {
                    let x = 2 * i + s;
                    if x < nx && (t + 1) * nx <= fine.len() {
                        fine[t * nx + x] = here * u * v;
                    }
                }
            }
        }
    });
    fine
}

/// Shares of the two halves of a cell between two others; their mean is 1.
fn halves(before: f64, here: f64, after: f64) -> [f64; 2] {
    let rise = |step: f64| {
        let root = |share: f64| share.max(0.0).sqrt();
        let (a, b) = (root(1.0 - step), root(1.0 + step));
        let mean = 0.5 * (a + b);
        [a / mean, b / mean]
    };
    match (before > 0.0, after > 0.0) {
        (true, true) => {
            let step = ((after - before) / (8.0 * here)).clamp(-1.0, 1.0);
            [1.0 - step, 1.0 + step]
        }
        // p^2 is linear.
        (false, true) => rise(0.25 * ((after / here).powi(2) - 1.0).min(4.0)),
        (true, false) => rise(-0.25 * ((before / here).powi(2) - 1.0).min(4.0)),
        (false, false) => [1.0, 1.0],
    }
}
