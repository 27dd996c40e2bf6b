//! A contact that is asked again and again, each time a little further on: what an integrator of motion calls in its inner loop.
//!
//! The bodies keep their shapes and move as a whole: by (x, y) along the surface, by tilts, by depth. On one grid that moves along, force
//! and moments are then the exact derivatives of one convex energy, and each step starts from the pressure of the last one
//! ([`matrix_free::Solver`]); it lies along the axes that the gap was drawn along. The stiffness against depth and tilts is that of a flat
//! punch on the patch, as for [`crate::solve`].

use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::{InputError, finite};
use crate::gap::{AnyGap, Reach};
use crate::grid::{Grid, Kernel, shape};
use crate::loading::axes::Axes;
use crate::matrix_free::{self, Solver};
use crate::numeric::geometry::Rect;
use crate::overlap::{Overlap, Units, reach_of};
use crate::problem::{Contact, Settings};
use crate::solution::{Unsolved, Verdict};

/// Cells along the longer side of the first grid that is tried.
const COARSEST: usize = 24;

/// Cells along the longer side of the last.
const FINEST: usize = 384;

/// Share by which the depth may grow before a larger grid is laid.
const DEEPER: f64 = 0.25;

/// Share of the first patch, in cells, below which a finer grid is laid.
const SMALLEST: f64 = 0.5;

/// Share of the tolerance that the first state on a grid may use up: the rest is for patches of fewer cells.
const AT_FIRST: f64 = 0.5;

/// Where the body is, for one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Approach of the bodies at the origin.
    pub depth: f64,
    /// Tilts (ax, ay), radians: the overlap is depth + ax x + ay y - gap.
    pub tilt: [f64; 2],
    /// How far the body has moved along the surface.
    pub at: [f64; 2],
}

/// What the contact answers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// Normal force.
    pub force: f64,
    /// Moments (Mx, My) about the origin, Mx = integral of p y, My = -integral of p x.
    pub moment: [f64; 2],
    /// Second derivatives of the stored energy by (depth, ax, ay): of the force and of the integrals of p x and p y.
    pub stiffness: [[f64; 3]; 3],
    /// Area of the patch: cells under pressure.
    pub area: f64,
    /// Estimate of the relative error of the force.
    pub error: f64,
    /// Whether a grid was laid for it.
    pub laid: bool,
}

/// A contact with what the last steps left behind.
///
/// ```
/// use contact_patch::{Contact, EffectiveModulus, Loading, Settings, curve::{Pose, WarmContact}, gap::Paraboloid};
/// let contact = Contact::new(EffectiveModulus::from_e_star(1.0)?, Paraboloid::new([1.0, 1.0])?, Loading::depth(1.0))?;
/// let mut sphere = WarmContact::new(&contact, &Settings { tolerance: 2e-3, ..Settings::default() });
/// for step in 0..5 {
///     let depth = 1.0 + 0.01 * f64::from(step);
///     let answer = sphere.reaction(Pose { depth, at: [0.3, 0.0], ..Pose::default() })?;
///     // Hertz, and a force that acts where the sphere is.
///     assert!((answer.force / (4.0 / 3.0 * depth.powf(1.5)) - 1.0).abs() < 2e-3);
///     assert!((answer.moment[1] + 0.3 * answer.force).abs() < 1e-6 && answer.laid == (step == 0));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct WarmContact {
    /// Where they are not the user's, the axes of all that is held here.
    axes: Option<Axes>,
    gap: AnyGap,
    e_star: f64,
    tolerance: f64,
    kernel: Kernel,
    threads: usize,
    seconds: f64,
    laid: Option<Laid>,
    solves: usize,
    grids: usize,
}

/// A grid that moves with the body.
#[derive(Debug)]
struct Laid {
    units: Units,
    grid: Grid,
    /// -gap of each cell, in these units.
    minus_gap: Vec<f64>,
    solver: Solver,
    /// Depth and tilt up to which nothing overlaps outside of the grid.
    covered: (f64, [f64; 2]),
    /// Cells under pressure in the first state on it, and relative error of that.
    first: (usize, f64),
}

impl WarmContact {
    /// The contact of these bodies; its loading is not used, of the settings tolerance, kernel, threads and seconds are. Nothing is solved yet.
    #[must_use]
    pub fn new(contact: &Contact, settings: &Settings) -> Self {
        let gap = contact.gap();
        let axes = Axes::along(gap).filter(|_| gap.known().axis.is_none());
        Self {
            gap: axes.map_or_else(|| gap.clone(), |axes| axes.gap_inward(gap)),
            axes,
            e_star: contact.modulus().e_star(),
            tolerance: settings.tolerance,
            kernel: settings.kernel,
            threads: settings.threads,
            seconds: settings.seconds,
            laid: None,
            solves: 0,
            grids: 0,
        }
    }

    /// Steps so far, and grids that were laid for them.
    #[must_use]
    pub fn cost(&self) -> [usize; 2] {
        [self.solves, self.grids]
    }

    /// Force, moments and stiffness in a pose; zero where the bodies are apart.
    ///
    /// # Errors
    /// `NotApplicable` when a number of the pose is not finite; `Unbounded` when the contact has no end; `IterationLimit`, `TimeLimit`.
    pub fn reaction(&mut self, pose: Pose) -> Result<Reaction, Unsolved> {
        self.step(pose, true)
    }

    /// The same without the stiffness, which is left at zero: for integrators that ask for none.
    ///
    /// # Errors
    /// As [`WarmContact::reaction`].
    pub fn force(&mut self, pose: Pose) -> Result<Reaction, Unsolved> {
        self.step(pose, false)
    }

    fn step(&mut self, pose: Pose, with_stiffness: bool) -> Result<Reaction, Unsolved> {
        pose.checked().map_err(|e| Unsolved::new(Verdict::NotApplicable, e.to_string()))?;
        self.solves += 1;
        match self.axes {
            None => self.step_along(pose, with_stiffness),
            Some(axes) => {
                let [tilt, at] = [pose.tilt, pose.at].map(|v| axes.vector_inward(v));
                let reaction = self.step_along(Pose { tilt, at, ..pose }, with_stiffness)?;
                let moment = axes.vector_outward(reaction.moment);
                Ok(Reaction { moment, stiffness: axes.matrix_outward(reaction.stiffness), ..reaction })
            }
        }
    }

    /// A step in a pose of the own axes.
    fn step_along(&mut self, pose: Pose, with_stiffness: bool) -> Result<Reaction, Unsolved> {
        // The depth where the body is now: f = depth + a (X + r) - gap(r) at r from it.
        let [x, y] = pose.at;
        let depth = pose.depth + pose.tilt[0] * x + pose.tilt[1] * y;
        if let Some(mut laid) = self.laid.take()
            && laid.covers(&self.gap, depth, pose.tilt)
        {
            let (problem, solution) = laid.solved(depth, pose.tilt, self.kernel)?;
            let pressed = solution.pressure.iter().filter(|&&p| p > 0.0).count();
            if pressed as f64 >= SMALLEST * laid.first.0 as f64 {
                let answer = self.answer(&laid, &problem, &solution, pose, with_stiffness, false);
                self.laid = Some(laid);
                return answer;
            }
        }
        self.grids += 1;
        let Some((mut laid, problem, solution)) = self.lay(depth, pose.tilt)? else { return Ok(Reaction::apart()) };
        laid.first.0 = solution.pressure.iter().filter(|&&p| p > 0.0).count();
        let answer = self.answer(&laid, &problem, &solution, pose, with_stiffness, true);
        self.laid = Some(laid);
        answer
    }

    /// A grid fine enough for the tolerance, with the state on it; `None` when the bodies do not touch.
    fn lay(&self, depth: f64, tilt: [f64; 2]) -> Result<Option<(Laid, Discrete, DiscreteSolution)>, Unsolved> {
        let deadline = crate::clock::Deadline::after(self.seconds, self.threads);
        let gap = self.gap.tilted(tilt);
        let Some(overlap) = Overlap::of(&gap, depth)? else { return Ok(None) };
        let units = overlap.scaled().units;
        let cover = depth + DEEPER * overlap.deepest;
        let reach = match reach_of(&gap, cover) {
            Reach::Within(reach) => reach,
            _ => overlap.reach,
        };
        let cover = if reach == overlap.reach { depth } else { cover };
        let window = units.rect_inward(&reach);
        let own = self.gap.scaled(units.origin, units.length, units.height);
        let tolerance = (0.01 * self.tolerance).clamp(1e-8, 1e-4);
        let settings = matrix_free::Settings { tolerance, threads: self.threads, deadline, ..Default::default() };
        let (mut cells, mut before) = (COARSEST, None);
        loop {
            let grid = Grid::over(&window, shape(&window, cells));
            let minus_gap = Discrete::sample_before(&own, 0.0, grid, self.kernel, deadline)?.overlap;
            // No limit of time is left behind in the solver: it counts from step to step.
            let own_settings = matrix_free::Settings { deadline: crate::clock::Deadline::NEVER, ..settings };
            let mut laid = Laid {
                units,
                grid,
                minus_gap,
                solver: Solver::new(own_settings),
                covered: (cover, tilt),
                first: (0, f64::INFINITY),
            };
            let (problem, solution) = laid.solved(depth, tilt, self.kernel)?;
            let force = solution.pressure.iter().sum::<f64>() * grid.cell_area();
            if force > 0.0
                && let Some(before) = before
            {
                let change = f64::abs(force - before);
                // Two grids may agree by chance: the other kernel tells.
                let difference = if change <= AT_FIRST * self.tolerance * force {
                    self.other_kernel(&problem, &solution, &settings)? - force
                } else {
                    0.0
                };
                laid.first.1 = change.max(difference.abs()) / force;
            }
            if laid.first.1 <= AT_FIRST * self.tolerance || 2 * cells > FINEST {
                return Ok(Some((laid, problem, solution)));
            }
            (before, cells) = ((force > 0.0).then_some(force), 2 * cells);
        }
    }

    /// The force on the same grid by the other kernel.
    fn other_kernel(
        &self,
        problem: &Discrete,
        solution: &DiscreteSolution,
        settings: &matrix_free::Settings,
    ) -> Result<f64, Unsolved> {
        // Of a smooth gap, centres and means differ by less than the kernels do.
        let other = Discrete { kernel: self.kernel.other(), ..problem.clone() };
        let solution = matrix_free::solve(&other, Some(&solution.pressure), settings)?;
        Ok(solution.pressure.iter().sum::<f64>() * problem.grid.cell_area())
    }

    fn answer(
        &self,
        laid: &Laid,
        problem: &Discrete,
        solution: &DiscreteSolution,
        pose: Pose,
        with_stiffness: bool,
        fresh: bool,
    ) -> Result<Reaction, Unsolved> {
        let Laid { units, grid, .. } = laid;
        let cell = grid.cell_area();
        let arms: Vec<[f64; 2]> =
            grid.centres().map(|c| units.outward(c)).map(|[x, y]| [x + pose.at[0], y + pose.at[1]]).collect();
        let sums = |field: &[f64]| {
            let sum =
                field.iter().zip(&arms).fold([0.0; 3], |[s, sx, sy], (p, [x, y])| [s + p, sx + p * x, sy + p * y]);
            sum.map(|s| s * cell)
        };
        let pressed = solution.pressure.iter().filter(|&&p| p > 0.0).count();
        let unit_force = self.e_star * units.height * units.length;
        let [force, px, py] = sums(&solution.pressure).map(|s| s * unit_force);
        let mut stiffness = [[0.0; 3]; 3];
        if with_stiffness && pressed > 0 {
            let settings = matrix_free::Settings { tolerance: 1e-2 * self.tolerance.min(1e-2), ..Default::default() };
            let rates =
                [vec![1.0; grid.len()], arms.iter().map(|a| a[0]).collect(), arms.iter().map(|a| a[1]).collect()];
            for (column, rate) in rates.iter().enumerate() {
                let growing = matrix_free::growth(problem, &solution.pressure, rate, &settings)?;
                for (row, sum) in sums(&growing).into_iter().enumerate() {
                    stiffness[row][column] = sum * self.e_star * units.length;
                }
            }
            // Symmetric by reciprocity; what differs is what the solver left.
            stiffness = [0, 1, 2].map(|i| [0, 1, 2].map(|j| 0.5 * (stiffness[i][j] + stiffness[j][i])));
        }
        // Errors of a grid go as the cell over the radius of the patch, squared at best: as one over the cells.
        let fewer = (laid.first.0 as f64 / pressed.max(1) as f64).max(1.0);
        Ok(Reaction {
            force,
            moment: [py, -px],
            stiffness,
            area: pressed as f64 * cell * units.length * units.length,
            error: if force > 0.0 { laid.first.1 * fewer } else { 0.0 },
            laid: fresh,
        })
    }
}

impl Laid {
    /// Whether nothing overlaps outside of the grid at this depth and tilt.
    fn covers(&self, gap: &AnyGap, depth: f64, tilt: [f64; 2]) -> bool {
        let (deepest, covered) = self.covered;
        if tilt == covered {
            return depth <= deepest;
        }
        let slack = 1e-9 * self.units.length;
        match reach_of(&gap.tilted(tilt), depth) {
            Reach::Nowhere => true,
            Reach::Within(reach) => {
                let extent = self.units.rect_outward(&self.grid.extent());
                let room = Rect { min: extent.min.map(|x| x - slack), max: extent.max.map(|x| x + slack) };
                room.union(&reach) == room
            }
            _ => false,
        }
    }

    fn solved(&mut self, depth: f64, tilt: [f64; 2], kernel: Kernel) -> Result<(Discrete, DiscreteSolution), Unsolved> {
        let Units { height, .. } = self.units;
        let at = |[x, y]: [f64; 2]| (depth + tilt[0] * x + tilt[1] * y) / height;
        let overlap = self.grid.centres().zip(&self.minus_gap).map(|(c, g)| at(self.units.outward(c)) + g).collect();
        let problem = Discrete { grid: self.grid, kernel, overlap };
        let solution = self.solver.solve(&problem)?;
        Ok((problem, solution))
    }
}

impl Reaction {
    fn apart() -> Self {
        Self { force: 0.0, moment: [0.0; 2], stiffness: [[0.0; 3]; 3], area: 0.0, error: 0.0, laid: false }
    }
}

impl Pose {
    fn checked(&self) -> Result<(), InputError> {
        finite("depth", self.depth)?;
        finite("tilt[0]", self.tilt[0])?;
        finite("tilt[1]", self.tilt[1])?;
        finite("at[0]", self.at[0])?;
        finite("at[1]", self.at[1])?;
        Ok(())
    }
}
