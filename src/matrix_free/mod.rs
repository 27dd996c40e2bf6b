//! Contact on grids of millions of cells, without a matrix.
//!
//! The problem is [`Discrete`]: p >= 0, A p >= f, p (A p - f) = 0. A product with A is a convolution ([`Operator`]); the
//! solver is conjugate gradients on a changing guess of the contact (`faces`, with the help of `fixed`), started from a
//! coarser grid (`nested`) or from the last answers ([`Solver`]), with a slower method that cannot fail behind it
//! (`monotone`). The box is cut to the cells that overlap (`window`): no other cell can carry pressure.
//!
//! The error of an answer is the largest |f - A p| under pressure and the largest f - A p elsewhere, over the largest
//! overlap. It is recomputed from the pressure, which is not negative anywhere, before an answer is given. The displacement
//! is returned for the box of the overlapping cells and is zero around it, where nothing can penetrate.

mod columns;
mod convolution;
mod faces;
mod fields;
mod growth;
mod lanes;
mod level;
mod monotone;
mod nested;
mod operator;
mod real;
mod region;
mod solver;
mod split;
mod symbol;
mod transforms;
mod under_force;
mod window;

use crate::clock::Deadline;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::influence::InfluenceTable;
use crate::solution::{Unsolved, Verdict};

pub(crate) use growth::growth_in_sum;
pub use growth::{displacement, growth};
pub use nested::{halved, solve_nested};
pub use operator::{Operator, Scratch};
pub use solver::Solver;
pub use under_force::solve_under_force;

use convolution::{Convolution, FEW, Sums};
use fields::{Near, PIECE};
use level::{Level, Limit, NEAR, State};
use region::Region;
use split::Split;
use symbol::Symbol;
use window::Window;

/// What a solve is held to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Largest error of the gap, relative to the largest overlap; 1e-8 unless said. Below 1e-13 rounding is in the way.
    pub tolerance: f64,
    /// Products with A on one grid before the verdict [`Verdict::IterationLimit`]; 2000 unless said.
    pub products: usize,
    /// Threads; 1 unless said. More need the feature `parallel`; 0 is one per core. The result is the same.
    pub threads: usize,
    /// When to stop with the verdict [`Verdict::TimeLimit`]; never unless said. Asked for between products.
    pub deadline: Deadline,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-8, products: 2000, threads: 1, deadline: Deadline::NEVER }
    }
}

/// Solves on one grid, from `start` where it is given (a pressure on the same cells, such as that of the last load
/// step; anything finite will do) and from nothing otherwise. [`solve_nested`] is faster without a good start, and a [`Solver`] for
/// many problems in a row.
///
/// # Errors
/// [`Verdict::IterationLimit`] when the tolerance is not reached within the products allowed; [`Verdict::TimeLimit`] when it is
/// not reached before the deadline; [`Verdict::NotApplicable`] when pressures are beyond the range of numbers.
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
    let Some(window) = Window::of(problem, SYMMETRIC * settings.tolerance) else { return Ok(no_contact(problem)) };
    let table = window.table(problem);
    with_threads(settings.threads, window.shape(), |scratch| {
        let start = window.start(problem, &table, start);
        let operators =
            Operators::new(&table, window.shape(), window.region(start.as_deref()), window.mirrored, true, scratch);
        window.solve(problem, &table, &operators, start, settings, scratch)
    })
}

/// Calls `work` with room for as many threads as are asked for, or for one where so few cells are no work for more.
fn with_threads<T: Send>(threads: usize, cells: [usize; 2], work: impl FnOnce(&mut Scratch) -> T + Send) -> T {
    threaded(threads, cells, &mut Scratch::new(), work)
}

/// The same with the room of the caller.
fn threaded<T: Send>(
    threads: usize,
    cells: [usize; 2],
    scratch: &mut Scratch,
    work: impl FnOnce(&mut Scratch) -> T + Send,
) -> T {
    #[cfg(feature = "parallel")]
    if threads != 1
        && are_many(cells)
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build()
    {
        return pool.install(|| work(scratch.shared(true)));
    }
    let _ = (threads, cells);
    work(scratch.shared(false))
}

/// Whether so many cells are work for several threads: a product with fewer takes less time than threads take to meet. With two of
/// them, 128 x 128 cells take 1.3 times the wall time and 1.5 times the CPU time of one, 256 x 256 as long and 1.2 times.
fn are_many(cells: [usize; 2]) -> bool {
    const MANY: usize = 1 << 16;
    cells.iter().product::<usize>() >= MANY
}

/// Two overlaps that differ by less than this share of the tolerance count as one.
const SYMMETRIC: f64 = 1e-3;

/// The least depth or pressure: what is left of it to the last digit of the largest is still a normal number.
const LEAST: f64 = 1e-290;

/// A grid to be solved on, in units of its own: the largest overlap, and the pressure that moves a cell by it.
struct Cells {
    shape: [usize; 2],
    mirrored: bool,
    /// Overlap; where it is below -1, minus infinity for one, it counts by its sign alone.
    overlap: Vec<f64>,
    /// The sum of the pressures, where that is given in place of the depth: the overlap may then become larger or smaller
    /// everywhere.
    load: Option<f64>,
}

/// How a grid was left.
struct Left {
    state: State,
    solved: bool,
}

impl Window {
    /// A pressure on the grid of the problem as a start in the window, in its units.
    fn start(&self, problem: &Discrete, table: &InfluenceTable, start: Option<&[f64]>) -> Option<Vec<f64>> {
        let unit = self.deepest / table.get(0, 0);
        start.filter(|p| p.len() == problem.grid.len()).map(|p| {
            let mut start = self.cut(problem.grid.shape, p, 0.0);
            start.iter_mut().for_each(|p| *p /= unit);
            start
        })
    }

    /// The region to look for contact in from a start.
    fn region(&self, start: Option<&[f64]>) -> Region {
        region_around(self.shape(), self.mirrored, start)
    }

    /// Solves in the window from `start`.
    fn solve(
        &self,
        problem: &Discrete,
        table: &InfluenceTable,
        operators: &Operators,
        start: Option<Vec<f64>>,
        settings: &Settings,
        scratch: &mut Scratch,
    ) -> Result<DiscreteSolution, Unsolved> {
        let limit = Limit { products: settings.products, deadline: settings.deadline };
        let left = self.grid(problem).solve(table, operators, start, settings.tolerance, limit, scratch);
        self.finish(problem, table, left, settings, scratch)
    }

    /// The solution on the grid of the problem, its residuals from scratch.
    fn finish(
        &self,
        problem: &Discrete,
        table: &InfluenceTable,
        left: Left,
        settings: &Settings,
        scratch: &Scratch,
    ) -> Result<DiscreteSolution, Unsolved> {
        let Left { mut state, solved } = left;
        if !solved {
            settings.deadline.check()?;
            let error = error(&state.p, &state.r);
            return Err(Unsolved::new(
                Verdict::IterationLimit,
                format!(
                    "the error of the gap is {error:.1e} of the depth after {} products, not {:.1e}",
                    state.all_products(),
                    settings.tolerance
                ),
            ));
        }
        let unit = self.deepest / table.get(0, 0);
        let strongest = state.p.iter().copied().fold(0.0, f64::max);
        if !(self.deepest.min(unit) >= LEAST && (strongest * unit).is_finite()) {
            let reason =
                format!("depths of {:e} and pressures of {unit:e} are beyond the range of numbers", self.deepest);
            return Err(Unsolved::new(Verdict::NotApplicable, reason));
        }
        let shape = problem.grid.shape;
        // u = f - r.
        let mut u = self.cut(shape, &problem.overlap, f64::NEG_INFINITY);
        let deepest = self.deepest;
        let pieces = u.chunks_mut(PIECE).zip(state.r.chunks(PIECE)).zip(state.p.chunks_mut(PIECE));
        scratch.each(
            pieces,
            #[inline(always)]
            |((u, r), p)| {
                u.iter_mut().zip(r).for_each(|(u, r)| *u = u.max(-deepest) - deepest * r);
                p.iter_mut().for_each(|p| *p *= unit);
            },
        );
        let pressure = self.paste(shape, &state.p);
        let displacement = self.paste(shape, &u);
        let residuals = problem.residuals(&pressure, &displacement);
        Ok(DiscreteSolution {
            pressure,
            displacement,
            residuals,
            unknowns: problem.overlap.iter().filter(|&&f| f > 0.0).count(),
            iterations: state.iterations,
            operator_products: state.all_products(),
            single_precision: state.single_products,
        })
    }
}

/// The region around a start in a grid of this shape; all of it where there is none, or little to leave out.
fn region_around(shape: [usize; 2], mirrored: bool, start: Option<&[f64]>) -> Region {
    let whole = Region::whole(shape);
    let found = start.and_then(|p| Region::holding(shape, |k| p[k] > 0.0)).map(|r| r.widened(shape, mirrored));
    let cells = |region: &Region| region.shape().iter().product::<usize>();
    found.filter(|found| cells(&whole) > FEW && cells(found) as f64 <= WORTH * cells(&whole) as f64).unwrap_or(whole)
}

/// Share of a grid from which on it is not worth to leave the rest out.
const WORTH: f64 = 0.9;

impl Cells {
    /// Relaxes from `start` to the tolerance; in single precision alone where the operators are.
    fn solve(
        &self,
        table: &InfluenceTable,
        operators: &Operators,
        start: Option<Vec<f64>>,
        tolerance: f64,
        limit: Limit,
        scratch: &mut Scratch,
    ) -> Left {
        let mut near = [[0.0; NEAR]; NEAR];
        for (j, row) in near.iter_mut().enumerate().take(table.shape()[1]) {
            for (value, coefficient) in row.iter_mut().zip(table.row(j)) {
                *value = (coefficient / table.row(0)[0]) as f32;
            }
        }
        let Self { shape, mirrored, ref overlap, load } = *self;
        let level = Level { shape, f: overlap, load, table, near: &near, mirrored, tolerance, limit };
        let mut p = start.unwrap_or_else(|| vec![0.0; overlap.len()]);
        for (p, f) in p.iter_mut().zip(overlap) {
            *p = if *f > 0.0 && p.is_finite() { p.max(0.0) } else { 0.0 };
        }
        let mut state = State::from(p);
        let mut solved = faces::relax(&level, operators, &mut state, scratch);
        if !solved && operators.compliance.is_some() && load.is_none() && !level.is_exhausted(&state) {
            let whole = Region::whole(shape);
            let everywhere =
                (operators.region != whole).then(|| Operators::new(table, shape, whole, mirrored, true, scratch));
            solved = monotone::minimise(&level, everywhere.as_ref().unwrap_or(operators), &mut state, scratch);
        }
        Left { state, solved }
    }
}

/// What a grid is solved with, in its units: A = 1 from a cell to itself.
#[derive(Debug)]
struct Operators {
    /// The part of the grid in which there is pressure.
    region: Region,
    /// From there to all of the grid; none where a start for the next grid is all that is wanted.
    compliance: Option<Convolution<f64>>,
    /// Within the region.
    near: Near,
    /// 2-norm of the compliance, or a bound of it; zero where there is none.
    norm: f64,
}

impl Operators {
    fn new(
        table: &InfluenceTable,
        shape: [usize; 2],
        region: Region,
        mirrored: bool,
        double: bool,
        scratch: &Scratch,
    ) -> Self {
        let scale = InfluenceTable::scale(table.spacing()) / table.get(0, 0);
        let whole = region.shape() == shape;
        if whole && shape[0] * shape[1] <= FEW {
            return Self::few(table, scale, shape, mirrored, double, scratch);
        }
        let within = region.shape();
        let split = Split::new(table, scale, within, mirrored, scratch);
        let shared = (double || whole && split.is_none())
            .then(|| operator::compliance(table, scale, shape, &region, mirrored, scratch));
        let norm = shared.as_ref().map_or(0.0, Symbol::norm);
        let compliance = shared.as_ref().filter(|_| double).map(|symbol| Convolution::new(shape, symbol));
        let single = match (split, &shared) {
            (Some(split), _) => Convolution::Split(Box::new(split)),
            (None, Some(symbol)) if whole => Convolution::new(shape, symbol),
            _ => Convolution::new(
                within,
                &operator::compliance(table, scale, within, &Region::whole(within), mirrored, scratch),
            ),
        };
        drop(shared);
        let preconditioner =
            Convolution::new(within, &operator::preconditioner(table, scale, within, mirrored, scratch));
        Self { region, compliance, near: Near { single, preconditioner }, norm }
    }

    /// By sums.
    fn few(
        table: &InfluenceTable,
        scale: f64,
        shape: [usize; 2],
        mirrored: bool,
        double: bool,
        scratch: &Scratch,
    ) -> Self {
        let kernel = |i: usize, j: usize| scale * table.row(j)[i];
        let rows = 0..if mirrored { 2 * shape[1] } else { shape[1] };
        let norm = 4.0 * rows.map(|j| (0..shape[0]).map(|i| kernel(i, j)).sum::<f64>()).sum::<f64>();
        let compliance = double.then(|| Convolution::Sums(Sums::new(shape, mirrored, kernel)));
        let single = Convolution::Sums(Sums::new(shape, mirrored, kernel));
        let inverse = operator::preconditioner(table, scale, shape, mirrored, scratch).kernel();
        let preconditioner = Convolution::Sums(Sums::new(shape, mirrored, |i, j| inverse.at(i, j)));
        Self { region: Region::whole(shape), compliance, near: Near { single, preconditioner }, norm }
    }
}

/// Largest |r| where there is pressure and largest r elsewhere.
fn error(p: &[f64], r: &[f64]) -> f64 {
    p.iter().zip(r).fold(0.0, |e: f64, (&p, &r)| e.max(if p > 0.0 { r.abs() } else { r }))
}

fn no_contact(problem: &Discrete) -> DiscreteSolution {
    let zero = vec![0.0; problem.grid.len()];
    DiscreteSolution {
        residuals: problem.residuals(&zero, &zero),
        displacement: zero.clone(),
        pressure: zero,
        unknowns: 0,
        iterations: 0,
        operator_products: 0,
        single_precision: 0,
    }
}
