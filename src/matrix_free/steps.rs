//! One state of loading after the other on one grid.

use super::{SYMMETRIC, Settings, Window, no_contact, with_threads};
use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::Unsolved;
use crate::influence::InfluenceTable;

/// A sequence of contacts on one grid, each close to the one before: load steps, a punch that moves, the time steps of a
/// multibody code. Keeps the last pressure, which starts the next solve, and the table of influence coefficients.
///
/// A step in depth saves products. A punch that has moved by more than a cell gives a poor start: the answer is the same,
/// the products may be as many as without one.
///
/// ```
/// use contact_patch::{Discrete, Grid, Kernel, geometry::Rect, matrix_free};
///
/// let grid = Grid::over(&Rect { min: [-1.2, -1.2], max: [1.2, 1.2] }, [48, 48]);
/// let mut steps = matrix_free::Steps::new(matrix_free::Settings::default());
/// let mut products = Vec::new();
/// for depth in [1.0, 1.01, 1.02] {
///     let problem = Discrete::sample(&|x: f64, y: f64| 0.5 * (x * x + y * y), depth, grid, Kernel::Galerkin);
///     let solution = steps.solve(&problem)?;
///     // Hertz: P = 4/3 E* sqrt(R) d^(3/2).
///     let force = solution.pressure.iter().sum::<f64>() * grid.cell_area();
///     assert!((force / (4.0 / 3.0 * depth.powf(1.5)) - 1.0).abs() < 2e-3);
///     products.push(solution.operator_products);
/// }
/// assert!(products[1] < products[0] && products[2] < products[0]);
/// # Ok::<(), contact_patch::Unsolved>(())
/// ```
#[derive(Debug, Clone)]
pub struct Steps {
    settings: Settings,
    table: Option<InfluenceTable>,
    /// Pressure and largest overlap of the last contact that was solved.
    last: Option<(Vec<f64>, f64)>,
}

impl Steps {
    /// Before the first step.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self { settings, table: None, last: None }
    }

    /// The next state. The first one, one on another number of cells and one after the bodies were apart are solved from coarse grids
    /// up ([`super::solve_nested`]); the others start from the last pressure, scaled to the new depth.
    ///
    /// # Errors
    /// [`crate::Verdict::IterationLimit`] when the tolerance is not reached within the products allowed; the next step then
    /// starts from the last one that was solved.
    pub fn solve(&mut self, problem: &Discrete) -> Result<DiscreteSolution, Unsolved> {
        let settings = self.settings;
        let deepest = problem.deepest();
        let start = self.last.as_ref().filter(|(p, _)| p.len() == problem.grid.len());
        let solution = match (start, Window::of(problem, SYMMETRIC * settings.tolerance)) {
            (_, None) => no_contact(problem),
            (None, _) => super::solve_nested(problem, &settings)?,
            (Some((p, before)), Some(window)) => {
                let fits = |t: &InfluenceTable| window.served_by(t, problem);
                let table = self.table.take().filter(fits).unwrap_or_else(|| window.table(problem));
                let scale = deepest / before;
                let start: Vec<f64> = p.iter().map(|p| p * scale).collect();
                let solved = with_threads(settings.threads, |scratch| {
                    window.solve(problem, &table, Some(&start), &settings, scratch)
                });
                self.table = Some(table);
                solved?
            }
        };
        let touching = solution.pressure.iter().any(|p| *p > 0.0);
        self.last = touching.then(|| (solution.pressure.clone(), deepest));
        Ok(solution)
    }
}
