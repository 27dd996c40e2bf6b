//! Contact on grids of millions of cells, without a matrix.
//!
//! The problem is [`Discrete`]: p >= 0, A p >= f, p (A p - f) = 0. A product with A is a convolution ([`Operator`]); the
//! solver is conjugate gradients on a changing guess of the contact (`faces`), started from a coarser grid (`nested`),
//! with a slower method that cannot fail behind it (`monotone`). The box is cut to the cells that overlap: no other cell
//! can carry pressure.
//!
//! The error of an answer is the largest |f - A p| under pressure and the largest f - A p elsewhere, over the largest
//! overlap. It is recomputed from the pressure, which is not negative anywhere, before an answer is given.

mod faces;
mod monotone;
mod nested;
mod operator;

use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::{Unsolved, Verdict};
use crate::influence::InfluenceTable;

pub use nested::solve_nested;
pub use operator::{Operator, Scratch};

use faces::{Level, State};

/// What a solve is held to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest error of the gap, relative to the largest overlap; 1e-8 unless said. Below 1e-13 rounding is in the way.
    pub tolerance: f64,
    /// Products with A on one grid before the verdict [`Verdict::IterationLimit`]; 2000 unless said.
    pub products: usize,
    /// Threads; 1 unless said. More need the feature `parallel`; 0 is one per core. The result is the same.
    pub threads: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-8, products: 2000, threads: 1 }
    }
}

/// Solves on one grid, from `start` where it is given (a pressure on the same cells, such as that of the last load
/// step; anything finite will do) and from nothing otherwise. [`solve_nested`] is faster without a good start.
///
/// # Errors
/// [`Verdict::IterationLimit`] when the tolerance is not reached within the products allowed.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, geometry::Rect, matrix_free};
///
/// let grid = Grid::over(&Rect { min: [-1.2, -1.2], max: [1.2, 1.2] }, [48, 48]);
/// let at = |depth| Discrete::sample(&|x: f64, y: f64| 0.5 * (x * x + y * y), depth, grid, Kernel::Galerkin);
/// let settings = matrix_free::Settings::default();
/// let first = matrix_free::solve(&at(1.0), None, &settings)?;
/// // Hertz: P = 4/3 E* sqrt(R) d^(3/2).
/// let force = first.pressure.iter().sum::<f64>() * grid.cell_area();
/// assert!((force / (4.0 / 3.0) - 1.0).abs() < 2e-3);
/// // One load step on: the last pressure is the start.
/// let next = matrix_free::solve(&at(1.01), Some(&first.pressure), &settings)?;
/// assert!(next.operator_products < first.operator_products);
/// # Ok::<(), contact_patch::Unsolved>(())
/// ```
pub fn solve(problem: &Discrete, start: Option<&[f64]>, settings: &Settings) -> Result<DiscreteSolution, Unsolved> {
    with_threads(settings.threads, |scratch| {
        let Some(mut window) = Window::of(problem) else { return Ok(no_contact(problem)) };
        window.bound();
        let table = InfluenceTable::new(problem.kernel, problem.grid.spacing, window.shape);
        let start = start.filter(|p| p.len() == problem.grid.len()).map(|p| window.cut(problem.grid.shape[0], p));
        let level = window.solve(&table, problem.grid.spacing, start, settings.tolerance, settings.products, scratch);
        window.finish(problem, level, settings)
    })
}

/// Calls `work` with room for as many threads as are asked for.
fn with_threads<T: Send>(threads: usize, work: impl FnOnce(&mut Scratch) -> T + Send) -> T {
    #[cfg(feature = "parallel")]
    if threads != 1 {
        if let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
            return pool.install(|| work(&mut Scratch::parallel()));
        }
    }
    let _ = threads;
    work(&mut Scratch::new())
}

/// The box around the cells that overlap, and f in it.
struct Window {
    /// Its first cell.
    corner: [usize; 2],
    shape: [usize; 2],
    overlap: Vec<f64>,
    deepest: f64,
}

/// How a grid was left.
struct Left {
    state: State,
    solved: bool,
}

impl Window {
    /// `None` when no cell overlaps.
    fn of(problem: &Discrete) -> Option<Self> {
        let [nx, _] = problem.grid.shape;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        for (j, row) in problem.overlap.chunks_exact(nx.max(1)).enumerate() {
            let Some(first) = row.iter().position(|&f| f > 0.0) else { continue };
            let last = row.iter().rposition(|&f| f > 0.0).unwrap_or(first);
            low = [low[0].min(first), low[1].min(j)];
            high = [high[0].max(last + 1), j + 1];
        }
        if low[0] == usize::MAX {
            return None;
        }
        let mut window =
            Self { corner: low, shape: [high[0] - low[0], high[1] - low[1]], overlap: Vec::new(), deepest: 0.0 };
        window.overlap = window.cut(nx, &problem.overlap);
        window.deepest = problem.deepest();
        Some(window)
    }

    /// Takes overlaps far below zero, minus infinity among them, to -deepest: they matter by their sign alone, and with
    /// finite numbers u = f - (f - u) is not lost.
    fn bound(&mut self) {
        for f in &mut self.overlap {
            *f = f.max(-self.deepest);
        }
    }

    /// The part of a field on `width` columns that lies in the window.
    fn cut(&self, width: usize, field: &[f64]) -> Vec<f64> {
        let [i, j] = self.corner;
        (j..j + self.shape[1]).flat_map(|j| &field[j * width + i..][..self.shape[0]]).copied().collect()
    }

    /// The field on the whole grid, zero around the window.
    fn paste(&self, shape: [usize; 2], part: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; shape[0] * shape[1]];
        for (j, row) in part.chunks_exact(self.shape[0]).enumerate() {
            field[(self.corner[1] + j) * shape[0] + self.corner[0]..][..self.shape[0]].copy_from_slice(row);
        }
        field
    }

    /// Relaxes on this grid from `start`.
    fn solve(
        &self,
        table: &InfluenceTable,
        spacing: [f64; 2],
        start: Option<Vec<f64>>,
        tolerance: f64,
        limit: usize,
        scratch: &mut Scratch,
    ) -> Left {
        let n = self.overlap.len();
        let compliance = Operator::compliance(table, spacing, self.shape);
        let preconditioner = Operator::preconditioner(table, spacing, self.shape);
        let level = Level {
            f: &self.overlap,
            compliance: &compliance,
            preconditioner: &preconditioner,
            tolerance: tolerance * self.deepest,
            limit,
        };
        let mut p = start.unwrap_or_else(|| vec![0.0; n]);
        for (p, f) in p.iter_mut().zip(&self.overlap) {
            *p = if *f > 0.0 && p.is_finite() { p.max(0.0) } else { 0.0 };
        }
        let mut state = State { p, r: vec![0.0; n], iterations: 0, products: 0 };
        level.refresh(&mut state, scratch);
        let solved = faces::relax(&level, &mut state, scratch) || monotone::minimise(&level, &mut state, scratch);
        Left { state, solved }
    }

    /// The solution on the grid of the problem, its residuals from scratch.
    fn finish(&self, problem: &Discrete, left: Left, settings: &Settings) -> Result<DiscreteSolution, Unsolved> {
        let Left { state, solved } = left;
        if !solved {
            let error =
                state.p.iter().zip(&state.r).fold(0.0_f64, |e, (&p, &r)| e.max(if p > 0.0 { r.abs() } else { r }));
            return Err(Unsolved::new(
                Verdict::IterationLimit,
                format!(
                    "the error of the gap is {:.1e} of the depth after {} products, not {:.1e}",
                    error / self.deepest,
                    state.products,
                    settings.tolerance
                ),
            ));
        }
        let u: Vec<f64> = self.overlap.iter().zip(&state.r).map(|(f, r)| f - r).collect();
        let pressure = self.paste(problem.grid.shape, &state.p);
        let displacement = self.paste(problem.grid.shape, &u);
        let residuals = problem.residuals(&pressure, &displacement);
        Ok(DiscreteSolution {
            pressure,
            displacement,
            residuals,
            unknowns: self.overlap.iter().filter(|&&f| f > 0.0).count(),
            iterations: state.iterations,
            operator_products: state.products,
        })
    }
}

fn no_contact(problem: &Discrete) -> DiscreteSolution {
    let zero = vec![0.0; problem.grid.len()];
    let residuals = problem.residuals(&zero, &zero);
    let displacement = zero.clone();
    DiscreteSolution { pressure: zero, displacement, residuals, unknowns: 0, iterations: 0, operator_products: 0 }
}
