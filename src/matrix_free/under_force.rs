//! A force in place of the depth: pressure and depth at once.
//!
//! Among the pressures of one sum the stored energy has a least one, and the depth is the multiplier of that sum (Polonsky & Keer,
//! Wear 231 (1999) 206; Rey, Anciaux & Molinari, Comput. Mech. 60 (2017) 69). On a face, with M the approximate inverse of A and
//! m = M 1, nearly the pressure of a flat punch, the steps of [`super::faces`] keep the sum, d - (sum d/sum m) m, and the depth follows
//! such that m . r = 0: preconditioned conjugate gradients of the constrained problem. A step takes one product, as at a depth.

use super::level::Limit;
use super::nested::from_coarse;
use super::window::Window;
use super::{Cells, Operators, SYMMETRIC, Settings, with_threads};
use crate::discrete::{Discrete, DiscreteSolution};
use crate::solution::{Unsolved, Verdict};

/// Share of the depth that it may change by within one box of cells, and on the coarse grids before, whose depths are their own.
const ROOM: f64 = 0.04;
const ROOM_ON_COARSE: f64 = 0.3;

/// Boxes that are tried.
const MOST_BOXES: usize = 8;

/// The change of the depth from one box to the next, in depths.
const STEP: [f64; 2] = [-0.6, 2.0];

/// The contact under a force: what the depth of `problem`, a guess, is to be larger by, and the solution there. From `start`, the
/// pressure at a depth close by, or from coarse grids.
///
/// # Errors
/// [`Verdict::IterationLimit`] when the tolerance is not reached within the products allowed or the guess is too far off;
/// [`Verdict::TimeLimit`] when it is not reached before the deadline.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, geometry::Rect, matrix_free};
///
/// let grid = Grid::over(&Rect { min: [-1.2, -1.2], max: [1.2, 1.2] }, [96, 96]);
/// let guess = Discrete::sample(&|x: f64, y: f64| 0.5 * (x * x + y * y), 0.8, grid, Kernel::Galerkin);
/// let settings = matrix_free::Settings::default();
/// let (deeper, solution) = matrix_free::solve_under_force(&guess, 4.0 / 3.0, None, &settings)?;
/// // Hertz: P = 4/3 E* sqrt(R) d^(3/2).
/// assert!((0.8 + deeper - 1.0).abs() < 1e-3);
/// let force = solution.pressure.iter().sum::<f64>() * grid.cell_area();
/// assert!((force / (4.0 / 3.0) - 1.0).abs() < 1e-8);
/// # Ok::<(), contact_patch::Unsolved>(())
/// ```
pub fn solve_under_force(
    problem: &Discrete,
    force: f64,
    start: Option<&[f64]>,
    settings: &Settings,
) -> Result<(f64, DiscreteSolution), Unsolved> {
    let grid = problem.grid;
    let mut start = start.filter(|p| p.len() == grid.len()).map(<[f64]>::to_vec);
    // Relative to the depth that is found.
    let held = Settings { tolerance: (1.0 - 2.0 * ROOM) * settings.tolerance, ..*settings };
    let limit = Limit { products: settings.products, deadline: settings.deadline };
    with_threads(settings.threads, grid.shape, |scratch| {
        let mut deeper = 0.0;
        for _ in 0..MOST_BOXES {
            settings.deadline.check()?;
            let here = problem.deeper(deeper);
            let deepest = here.deepest();
            let room = ROOM * deepest;
            let Some(window) = Window::of(&problem.deeper(deeper + room), SYMMETRIC * settings.tolerance) else {
                break;
            };
            let table = window.table(problem);
            let unit = window.deepest / table.get(0, 0);
            let halves = if window.mirrored { 2.0 } else { 1.0 };
            let load = Some(force / (halves * grid.cell_area() * unit));
            let cells = Cells { load, ..window.grid(&here) };
            let overlap = cells.overlap.clone();
            let within = |by: f64| (by * window.deepest).abs() <= room;
            let mut left = match start.take() {
                Some(start) => {
                    let start = window.start(problem, &table, Some(&start));
                    let region = window.region(start.as_deref());
                    let operators = Operators::new(&table, window.shape(), region, window.mirrored, true, scratch);
                    cells.solve(&table, &operators, start, held.tolerance, limit, scratch)
                }
                None => from_coarse(cells, &table, &held, scratch, |by| by.abs() <= ROOM_ON_COARSE),
            };
            let by = left.state.deeper;
            if within(by) {
                deeper += by * window.deepest;
                let found = problem.deeper(deeper);
                // Far below, overlaps count by their sign alone.
                let now = window.grid(&found).overlap;
                for ((r, now), before) in left.state.r.iter_mut().zip(now).zip(overlap) {
                    *r += now - (before + by);
                }
                return Ok((deeper, window.finish(&found, &table, left, settings, scratch)?));
            }
            if !by.is_finite() {
                break;
            }
            deeper += (by * window.deepest).clamp(STEP[0] * deepest, STEP[1] * deepest);
            if left.solved {
                left.state.p.iter_mut().for_each(|p| *p *= unit);
                start = Some(window.paste(grid.shape, &left.state.p));
            }
        }
        Err(Unsolved::new(Verdict::IterationLimit, format!("the depth for the force {force:e} was not found")))
    })
}
