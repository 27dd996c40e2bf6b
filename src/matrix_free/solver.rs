//! One problem after another: load steps, a punch that moves, the time steps of a multibody code.

use super::region::Region;
use super::window::Window;
use super::{Operators, SYMMETRIC, Scratch, Settings, no_contact, operator, solve_nested};
use crate::discrete::{Discrete, DiscreteSolution};
use crate::grid::{Grid, Kernel};
use crate::influence::InfluenceTable;
use crate::solution::Unsolved;

/// Share of the last load that must lie where the bodies now overlap for the last pressure to be a start.
const SHARED: f64 = 0.5;

/// Largest change of the depth, as a factor, from which the last pressure is a start.
const DEEPER: f64 = 1.5;

/// A box that is kept may have this many times the cells that are needed.
const ROOMY: usize = 3;

/// A solver that keeps what the next problem can use: influence coefficients, transforms, memory, and the last pressure.
///
/// The answer is that of [`solve_nested`], to the tolerance; only the work differs. What is kept fits as long as cells and kernel
/// stay the same and the overlap does not outgrow its box; else it is made anew. From the third problem on the start is the line
/// through the last two pressures, over the depth or, where that stays, over equal steps: it is then cheap to go on. A first
/// problem, one of another depth altogether and one whose contact is elsewhere start from a coarse grid.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, geometry::Rect, matrix_free};
///
/// let grid = Grid::over(&Rect { min: [-1.6, -1.6], max: [1.6, 1.6] }, [64, 64]);
/// // A wheel that rolls along: the punch moves by a tenth of a cell a step, the depth changes by 1 %.
/// let at = |step: f64| {
///     let gap = move |x: f64, y: f64| 0.5 * ((x - 0.005 * step).powi(2) + y * y);
///     Discrete::sample(&gap, 1.0 + 0.01 * step, grid, Kernel::Galerkin)
/// };
/// let settings = matrix_free::Settings { tolerance: 1e-6, ..Default::default() };
/// let mut solver = matrix_free::Solver::new(settings);
/// solver.solve(&at(0.0))?;
/// solver.solve(&at(1.0))?;
/// let third = solver.solve(&at(2.0))?;
/// let alone = matrix_free::solve_nested(&at(2.0), &settings)?;
/// assert!(third.operator_products < alone.operator_products);
/// let force = |pressure: &[f64]| pressure.iter().sum::<f64>() * grid.cell_area();
/// assert!((force(&third.pressure) / force(&alone.pressure) - 1.0).abs() < 1e-5);
/// # Ok::<(), contact_patch::Unsolved>(())
/// ```
#[derive(Debug)]
pub struct Solver {
    settings: Settings,
    scratch: Scratch,
    kept: Option<Kept>,
    last: Option<Last>,
}

/// Steps as long as the last one, as far as the pressure is continued along a line.
const FARTHEST: f64 = 2.0;

/// The answer before, and the one before that where it was on the same cells.
#[derive(Debug)]
struct Last {
    grid: Grid,
    pressure: Vec<f64>,
    deepest: f64,
    /// p . f, which is p . A p.
    work: f64,
    earlier: Option<(Vec<f64>, f64)>,
}

/// What a box is solved with.
#[derive(Debug)]
struct Kept {
    kernel: Kernel,
    spacing: [f64; 2],
    /// Its box; where it lies does not matter.
    window: Window,
    table: InfluenceTable,
    operators: Operators,
}

impl Kept {
    fn new(problem: &Discrete, window: &Window) -> Self {
        // Room to grow, and lengths whose transforms are fast.
        let wide = [0, 1].map(|k| {
            let extent = window.extent[k] + window.extent[k] / 16 + 2;
            let half = operator::good_length(extent.div_ceil(2));
            // Of the parity that was there: the middle stays where it is.
            2 * half - window.extent[k] % 2
        });
        let window = window.widened(wide);
        let table = window.table(problem);
        let operators = Operators::new(
            &table,
            window.shape(),
            Region::whole(window.shape()),
            window.mirrored,
            true,
            &Scratch::new(),
        );
        Self { kernel: problem.kernel, spacing: problem.grid.spacing, window, table, operators }
    }

    /// The box of this size around the overlap; `None` when it does not fit.
    fn around(&self, problem: &Discrete, mut window: Window) -> Option<Window> {
        let mine = &self.window;
        if !mine.mirrored {
            window.unfold();
        }
        let fits = self.kernel == problem.kernel
            && self.spacing == problem.grid.spacing
            && (mine.mirrored, mine.transposed) == (window.mirrored, window.transposed)
            && (0..2).all(|k| window.extent[k] <= mine.extent[k])
            && mine.extent[0] * mine.extent[1] <= ROOMY * (window.extent[0] + 8) * (window.extent[1] + 8);
        fits.then(|| window.widened(mine.extent))
    }
}

impl Solver {
    /// A solver that knows nothing yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self { settings, scratch: Scratch::new(), kept: None, last: None }
    }

    /// Forgets the last pressure: the next problem starts from a coarse grid.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Solves from the last answer where that is a good start.
    ///
    /// # Errors
    /// [`crate::Verdict::IterationLimit`] when the tolerance is not reached within the products allowed. The last pressure
    /// is then forgotten.
    pub fn solve(&mut self, problem: &Discrete) -> Result<DiscreteSolution, Unsolved> {
        let Some(window) = Window::of(problem, SYMMETRIC * self.settings.tolerance) else {
            return Ok(no_contact(problem));
        };
        let last = self.last.take();
        let start = last.as_ref().and_then(|last| last.on(problem, window.deepest));
        let solution = match start {
            Some(start) => self.from(problem, window, &start)?,
            None => {
                let solution = solve_nested(problem, &self.settings)?;
                self.keep(problem, window);
                solution
            }
        };
        let pressure = solution.pressure.clone();
        let earlier = last.filter(|last| last.grid == problem.grid).map(|last| (last.pressure, last.deepest));
        let work = work(&pressure, problem);
        self.last = Some(Last { grid: problem.grid, pressure, deepest: window.deepest, work, earlier });
        Ok(solution)
    }

    /// The box to solve in, what is kept made anew where it does not fit.
    fn keep(&mut self, problem: &Discrete, window: Window) -> (Window, &Kept) {
        let around = self.kept.as_ref().and_then(|kept| kept.around(problem, window));
        match around {
            None => {
                let kept = self.kept.insert(Kept::new(problem, &window));
                (kept.window, kept)
            }
            Some(around) => (around, self.kept.get_or_insert_with(|| Kept::new(problem, &window))),
        }
    }

    fn from(&mut self, problem: &Discrete, window: Window, start: &[f64]) -> Result<DiscreteSolution, Unsolved> {
        let settings = self.settings;
        let mut scratch = std::mem::take(&mut self.scratch);
        let (window, kept) = self.keep(problem, window);
        let solution = super::threaded(settings.threads, window.shape(), &mut scratch, |scratch| {
            let start = window.start(problem, &kept.table, Some(start));
            window.solve(problem, &kept.table, &kept.operators, start, &settings, scratch)
        });
        self.scratch = scratch;
        solution
    }
}

/// p . f where there is pressure.
fn work(pressure: &[f64], problem: &Discrete) -> f64 {
    pressure.iter().zip(&problem.overlap).filter(|(p, _)| **p > 0.0).map(|(p, f)| p * f.max(0.0)).sum()
}

impl Last {
    /// On the same cells, along the line through the last two pressures; of one alone the multiple of least energy.
    fn continued(&self, problem: &Discrete, deepest: f64) -> Vec<f64> {
        let Some((earlier, depth)) = &self.earlier else {
            let times = work(&self.pressure, problem) / self.work;
            let times = if times.is_finite() { times.clamp(1.0 / DEEPER, DEEPER) } else { 1.0 };
            return self.pressure.iter().map(|p| times * p).collect();
        };
        let (step, last) = (deepest - self.deepest, self.deepest - depth);
        let far = if step == last { 1.0 } else { step / last };
        if !(far.abs() <= FARTHEST) {
            return self.pressure.clone();
        }
        self.pressure
            .iter()
            .zip(earlier)
            .map(|(p, q)| if *p > 0.0 { (p + far * (p - q)).max(0.0) } else { 0.0 })
            .collect()
    }

    /// The pressure on the cells of this problem, from the cell that lay where each is now; `None` where it is no start.
    fn on(&self, problem: &Discrete, deepest: f64) -> Option<Vec<f64>> {
        let [now, then] = [&problem.grid, &self.grid];
        if !(deepest < DEEPER * self.deepest && self.deepest < DEEPER * deepest) {
            return None;
        }
        let total = self.pressure.iter().sum::<f64>() * then.cell_area();
        let start = if now == then {
            self.continued(problem, deepest)
        } else {
            let place = |k: usize, axis: usize| {
                let n = (now.centre_of(k)[axis] - then.origin[axis]) / then.spacing[axis];
                (n >= 0.0 && n < then.shape[axis] as f64).then_some(n as usize)
            };
            let cell = |k| Some(place(k, 1)? * then.shape[0] + place(k, 0)?);
            (0..now.len()).map(|k| cell(k).map_or(0.0, |cell| self.pressure[cell])).collect()
        };
        let pressed = start.iter().zip(&problem.overlap).filter(|(_, f)| **f > 0.0);
        let shared = pressed.map(|(p, _)| p).sum::<f64>() * now.cell_area();
        (shared > SHARED * total && shared < total / SHARED).then_some(start)
    }
}
