//! Contact on grids of millions of cells, without a matrix.
//!
//! The problem is [`Discrete`]: p >= 0, A p >= f, p (A p - f) = 0. A product with A is a convolution ([`Operator`]); the
//! solver is conjugate gradients on a changing guess of the contact (`faces`), started from a coarser grid (`nested`),
//! with a slower method that cannot fail behind it (`monotone`). The box is cut to the cells that overlap: no other cell
//! can carry pressure.
//!
//! The error of an answer is the largest |f - A p| under pressure and the largest f - A p elsewhere, over the largest
//! overlap. It is recomputed from the pressure, which is not negative anywhere, before an answer is given. The displacement
//! is returned for the box of the overlapping cells and is zero around it, where nothing can penetrate.

mod convolution;
mod faces;
mod growth;
mod monotone;
mod nested;
mod operator;

use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::{Unsolved, Verdict};
use crate::influence::InfluenceTable;

pub use growth::{displacement, growth};
pub use nested::solve_nested;
pub use operator::{Operator, Scratch};

use convolution::Convolution;
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
        let Some(window) = Window::of(problem, SYMMETRIC * settings.tolerance) else { return Ok(no_contact(problem)) };
        window.solve(problem, &window.table(problem), start, settings, scratch)
    })
}

/// Calls `work` with room for as many threads as are asked for.
fn with_threads<T: Send>(threads: usize, work: impl FnOnce(&mut Scratch) -> T + Send) -> T {
    #[cfg(feature = "parallel")]
    if threads != 1
        && let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build()
    {
        return pool.install(|| work(&mut Scratch::parallel()));
    }
    let _ = threads;
    work(&mut Scratch::new())
}

/// Two overlaps that differ by less than this share of the tolerance count as one.
const SYMMETRIC: f64 = 1e-3;

/// The box around the cells that overlap. Where they have a mirror, half of it, laid with the mirror below its first row.
struct Window {
    /// Its first cell in the grid of the problem.
    corner: [usize; 2],
    /// Number of cells along the rows and across them, both halves of a mirrored window counted.
    extent: [usize; 2],
    /// Rows of the window are columns of the problem.
    transposed: bool,
    /// The upper half stands for both.
    mirrored: bool,
    deepest: f64,
}

/// A grid to be solved on, in units of its own: the largest overlap, and the pressure that moves a cell by it.
struct Cells {
    shape: [usize; 2],
    mirrored: bool,
    /// Overlap; where it is below -1, minus infinity for one, it counts by its sign alone.
    overlap: Vec<f64>,
}

/// How a grid was left.
struct Left {
    state: State,
    solved: bool,
}

impl Window {
    /// `None` when no cell overlaps. Overlaps that differ by less than `same` of the largest are not told apart.
    fn of(problem: &Discrete, same: f64) -> Option<Self> {
        let [nx, _] = problem.grid.shape;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let mut deepest = f64::NEG_INFINITY;
        for (j, row) in problem.overlap.chunks_exact(nx.max(1)).enumerate() {
            let Some(first) = row.iter().position(|&f| f > 0.0) else { continue };
            let last = row.iter().rposition(|&f| f > 0.0).unwrap_or(first);
            low = [low[0].min(first), low[1].min(j)];
            high = [high[0].max(last + 1), j + 1];
            deepest = row[first..=last].iter().fold(deepest, |m, f| if *f > m { *f } else { m });
        }
        if low[0] == usize::MAX {
            return None;
        }
        let extent = [high[0] - low[0], high[1] - low[1]];
        let mut window = Self { corner: low, extent, transposed: false, mirrored: false, deepest };
        let same = same * deepest;
        let f = &problem.overlap;
        let alike = |a: usize, b: usize| (f[a] - f[b]).abs() <= same || (f[a] <= 0.0 && f[b] <= 0.0);
        window.mirrored = extent[1].is_multiple_of(2) && window.symmetric(nx, alike);
        if !window.mirrored && extent[0].is_multiple_of(2) {
            let turned = Self { extent: [extent[1], extent[0]], transposed: true, mirrored: true, ..window };
            if turned.symmetric(nx, alike) {
                return Some(turned);
            }
        }
        Some(window)
    }

    /// Whether all cells are like their images in a mirror in the middle of the window.
    fn symmetric(&self, width: usize, alike: impl Fn(usize, usize) -> bool) -> bool {
        let [nx, ny] = self.extent;
        (0..ny / 2).all(|j| (0..nx).all(|i| alike(self.index(width, i, j), self.index(width, i, ny - 1 - j))))
    }

    /// Both halves for themselves.
    fn unfold(&mut self) {
        if self.transposed {
            self.extent.reverse();
        }
        (self.transposed, self.mirrored) = (false, false);
    }

    /// Place of cell i of row j of the window in a field on `width` columns.
    fn index(&self, width: usize, i: usize, j: usize) -> usize {
        let [i, j] = if self.transposed { [j, i] } else { [i, j] };
        (self.corner[1] + j) * width + self.corner[0] + i
    }

    /// Cells that are solved for.
    fn shape(&self) -> [usize; 2] {
        [self.extent[0], if self.mirrored { self.extent[1] / 2 } else { self.extent[1] }]
    }

    /// The part of a field on `width` columns that lies in the window; of a mirrored one the mean of the halves.
    fn cut(&self, width: usize, field: &[f64]) -> Vec<f64> {
        let ([nx, ny], height) = (self.shape(), self.extent[1]);
        let mut part = Vec::with_capacity(nx * ny);
        for j in 0..ny {
            let upper = height - ny + j;
            if self.mirrored {
                let lower = height - 1 - upper;
                let mean = |i| 0.5 * (field[self.index(width, i, upper)] + field[self.index(width, i, lower)]);
                part.extend((0..nx).map(mean));
            } else if self.transposed {
                part.extend((0..nx).map(|i| field[self.index(width, i, upper)]));
            } else {
                part.extend_from_slice(&field[self.index(width, 0, upper)..][..nx]);
            }
        }
        part
    }

    /// The field on the whole grid, zero around the window.
    fn paste(&self, shape: [usize; 2], part: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; shape[0] * shape[1]];
        let (nx, height) = (self.extent[0], self.extent[1]);
        let below = height - self.shape()[1];
        for j in 0..height {
            let row = if j >= below { j - below } else { below - 1 - j };
            for (i, &value) in part[row * nx..(row + 1) * nx].iter().enumerate() {
                field[self.index(shape[0], i, j)] = value;
            }
        }
        field
    }

    /// Influence coefficients for all offsets in the window.
    fn table(&self, problem: &Discrete) -> InfluenceTable {
        let [hx, hy] = problem.grid.spacing;
        InfluenceTable::new(problem.kernel, if self.transposed { [hy, hx] } else { [hx, hy] }, self.extent)
    }

    /// Solves in the window from `start`, a pressure on the grid of the problem.
    fn solve(
        &self,
        problem: &Discrete,
        table: &InfluenceTable,
        start: Option<&[f64]>,
        settings: &Settings,
        scratch: &mut Scratch,
    ) -> Result<DiscreteSolution, Unsolved> {
        let unit = self.deepest / table.get(0, 0);
        let start = start.filter(|p| p.len() == problem.grid.len()).map(|p| {
            let mut start = self.cut(problem.grid.shape[0], p);
            start.iter_mut().for_each(|p| *p /= unit);
            start
        });
        let left = self.grid(problem).solve(table, start, settings.tolerance, settings.products, true, scratch);
        self.finish(problem, table, left, settings)
    }

    /// The window as a grid to be solved on.
    fn grid(&self, problem: &Discrete) -> Cells {
        let mut overlap = self.cut(problem.grid.shape[0], &problem.overlap);
        // With finite numbers u = f - (f - u) is not lost.
        overlap.iter_mut().for_each(|f| *f = (*f / self.deepest).max(-1.0));
        Cells { shape: self.shape(), mirrored: self.mirrored, overlap }
    }

    /// The solution on the grid of the problem, its residuals from scratch.
    fn finish(
        &self,
        problem: &Discrete,
        table: &InfluenceTable,
        left: Left,
        settings: &Settings,
    ) -> Result<DiscreteSolution, Unsolved> {
        let Left { mut state, solved } = left;
        if !solved {
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
        let shape = problem.grid.shape;
        // u = f - r.
        let mut u = self.cut(shape[0], &problem.overlap);
        for (u, r) in u.iter_mut().zip(&state.r) {
            *u = u.max(-self.deepest) - self.deepest * r;
        }
        let unit = self.deepest / table.get(0, 0);
        state.p.iter_mut().for_each(|p| *p *= unit);
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

impl Cells {
    /// Relaxes from `start`: to the tolerance where the answer is wanted, in single precision where a start is.
    fn solve(
        &self,
        table: &InfluenceTable,
        start: Option<Vec<f64>>,
        tolerance: f64,
        limit: usize,
        answer: bool,
        scratch: &mut Scratch,
    ) -> Left {
        let operators = Operators::new(table, self.shape, self.mirrored, answer);
        let mut near = [[0.0; faces::NEAR]; faces::NEAR];
        for (j, row) in near.iter_mut().enumerate().take(table.shape()[1]) {
            for (value, coefficient) in row.iter_mut().zip(table.row(j)) {
                *value = (coefficient / table.row(0)[0]) as f32;
            }
        }
        let level = Level {
            f: &self.overlap,
            compliance: operators.compliance.as_ref(),
            single: &operators.single,
            preconditioner: &operators.preconditioner,
            near: &near,
            mirrored: self.mirrored,
            tolerance,
            limit,
        };
        let mut p = start.unwrap_or_else(|| vec![0.0; self.overlap.len()]);
        for (p, f) in p.iter_mut().zip(&self.overlap) {
            *p = if *f > 0.0 && p.is_finite() { p.max(0.0) } else { 0.0 };
        }
        let mut state = State::from(p);
        let solved = faces::relax(&level, &mut state, scratch)
            || (answer && monotone::minimise(&level, operators.norm, &mut state, scratch));
        Left { state, solved }
    }
}

/// What a grid is solved with, in its units: A = 1 from a cell to itself.
struct Operators {
    compliance: Option<Convolution<f64>>,
    single: Convolution<f32>,
    preconditioner: Convolution<f32>,
    /// 2-norm of the compliance, or a bound of it.
    norm: f64,
}

impl Operators {
    fn new(table: &InfluenceTable, shape: [usize; 2], mirrored: bool, double: bool) -> Self {
        let scale = InfluenceTable::scale(table.spacing()) / table.get(0, 0);
        let symbol = operator::compliance(table, scale, shape, mirrored);
        let compliance = double.then(|| Convolution::new(shape, &symbol, mirrored));
        let (single, norm) = (Convolution::new(shape, &symbol, mirrored), symbol.norm());
        drop(symbol);
        let symbol = operator::preconditioner(table, scale, shape, mirrored);
        Self { compliance, single, preconditioner: Convolution::new(shape, &symbol, mirrored), norm }
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
