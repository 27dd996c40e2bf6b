//! A solved grid that goes on from one depth to the next on the same cells: what a search for a depth asks for.

use super::dimensional::{area_at_least, at_least, in_users_units, stiffness_of, strongest};
use super::domain;
use super::expansion::expanded;
use super::refined::Refined;
use super::refinement::{self, AS_THEY_ARE};
use super::single_grid::{self, GridState};
use super::unresolved;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::grid::{Grid, shape};
use crate::matrix_free;
use crate::overlap::{Overlap, Scaled, touches_alike};
use crate::patch;
use crate::problem::{Contact, ErrorBar, Method, Settings};
use crate::solution::{Solution, Unsolved};

/// Cells along the longer side of the grid that only has to show the way.
const ROUGH_CELLS: usize = 32;

/// A solved grid with what it takes to go on from it to another depth.
pub(crate) struct WarmStart {
    scaled: Scaled,
    refined: Refined,
    /// Pressure that grows with the depth on the cells in contact; `None` where the state is the limit of many grids.
    growing: Option<Vec<f64>>,
    /// Estimates of relative errors by the grids of the first state.
    errors: Errors,
    /// Force of that state, E* = 1.
    estimated_at: f64,
}

/// Forces over that at which errors were estimated for which they still hold: those of a smaller contact, on the same cells, are larger.
const SAME_ERRORS: std::ops::Range<f64> = 0.8..1.5;

/// Relative errors that a state takes over from another on the same cells.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    stiffness: Option<f64>,
    energy: Option<f64>,
    area: Option<f64>,
    peak: Option<f64>,
}

impl Errors {
    /// By the grid before; `stiffness` is that of the finest.
    fn of(refined: &Refined, stiffness: f64) -> Result<Self, Unsolved> {
        if refined.sequence.is_some() || refined.coarser.is_none() {
            return Ok(Self::default());
        }
        let numbers = |state: &GridState, stiffness: f64| {
            let highest = state.solution.pressure.iter().copied().fold(0.0, f64::max);
            let patch = patch::of(&state.problem, &state.solution, [0.0; 2]);
            [stiffness, state.energy(), patch.area, highest]
        };
        let finest = numbers(&refined.state, stiffness);
        let coarser = |state: &GridState| Ok(numbers(state, single_grid::stiffness(state)?));
        let [(_, stiffness), (_, energy), (_, area), (_, peak)] = refined.estimated_beside(Some(finest), coarser)?;
        let stiffness = stiffness.map(|change| at_least(refined, change));
        let area = area.map(|change| area_at_least(refined, change));
        let (grid, values) = (&refined.state.problem.grid, &refined.state.solution.pressure);
        let strongest = strongest(values);
        Ok(Self { stiffness, energy, area, peak: peak.map(|p| p.max(unresolved::peak(grid, values, strongest))) })
    }
}

impl WarmStart {
    /// The state at an overlap of the untilted contact; `None` where it takes several grids.
    ///
    /// # Errors
    /// As [`crate::grid_method::solution`].
    pub fn at(overlap: &Overlap, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let scaled = overlap.scaled();
        // Bounds are for the depth that is found.
        let estimate = Settings { evidence: ErrorBar::Estimate, ..super::within_samples(overlap, settings) };
        let refined = refinement::refined(&scaled, &estimate, super::method(settings), None)?;
        if super::misses_a_contact(overlap, settings, &scaled, &refined) {
            return Ok(None);
        }
        let held = Self::grown(scaled, refined)?;
        let errors = held.stiffness().map_or(Ok(Errors::default()), |own| Errors::of(&held.refined, own))?;
        Ok(Some(Self { errors, ..held }))
    }

    /// A state good to a few percent: one coarse grid.
    pub fn coarse_solve(contact: &Contact, depth: f64, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let Some(overlap) = Overlap::of(contact.gap(), depth)? else { return Ok(None) };
        let scaled = overlap.scaled();
        let window = domain::locate(&scaled)?;
        let grid = Grid::over(&window, shape(&window, ROUGH_CELLS));
        let problem = Discrete::sample(&scaled.gap, scaled.depth, grid, settings.kernel);
        let solution = domain::coarse(&problem)?;
        let state = GridState::of(Method::Fft, problem, solution);
        Ok(Some(Self::grown(scaled, Refined::of(state, f64::INFINITY))?))
    }

    /// The depth under a force on a grid of this many cells, from a depth near it.
    ///
    /// # Errors
    /// `IterationLimit`.
    pub fn depth_under(
        contact: &Contact,
        near: f64,
        force: f64,
        cells: usize,
        settings: &Settings,
    ) -> Result<Option<f64>, Unsolved> {
        let Some(overlap) = Overlap::of(contact.gap(), near)? else { return Ok(None) };
        let scaled = overlap.scaled();
        let units = &scaled.units;
        let window = domain::locate(&scaled)?;
        let grid = Grid::over(&window, shape(&window, cells));
        let problem = Discrete::sample_before(&scaled.gap, scaled.depth, grid, settings.kernel, settings.deadline)?;
        let force = force / (contact.modulus().e_star() * units.height * units.length);
        let deadline = settings.deadline;
        let held = matrix_free::Settings { tolerance: 1e-4, deadline, ..matrix_free::Settings::default() };
        let (deeper, _) = matrix_free::solve_under_force(&problem, force, None, &held)?;
        Ok(Some((scaled.depth + deeper) * units.height))
    }

    /// The state at another depth on the same cells, from here; `None` when they do not hold its contact, or when it takes
    /// the limit of many grids.
    ///
    /// # Errors
    /// `IterationLimit`.
    pub fn continued_to(&self, contact: &Contact, depth: f64, settings: &Settings) -> Result<Option<Self>, Unsolved> {
        let deeper = depth / self.scaled.units.height - self.scaled.depth;
        self.continued(contact, deeper, settings, |problem, start, settings| {
            Ok((0.0, matrix_free::solve(problem, Some(start), settings)?))
        })
    }

    /// The state under a force on the same cells, as [`Self::continued_to`].
    ///
    /// # Errors
    /// `IterationLimit`.
    pub fn continued_under(
        &self,
        contact: &Contact,
        force: f64,
        settings: &Settings,
    ) -> Result<Option<Self>, Unsolved> {
        let units = self.scaled.units;
        let force = force / (contact.modulus().e_star() * units.height * units.length);
        let Some(stiffness) = self.stiffness() else { return Ok(None) };
        let deeper = (force - self.refined.state.force()) / stiffness;
        self.continued(contact, deeper, settings, |problem, start, settings| {
            matrix_free::solve_under_force(problem, force, Some(start), settings)
        })
    }

    /// On the same cells, deeper by about as much: `solve` says what the depth is larger by in the end.
    fn continued(
        &self,
        contact: &Contact,
        mut deeper: f64,
        settings: &Settings,
        solve: impl Fn(&Discrete, &[f64], &matrix_free::Settings) -> Result<(f64, DiscreteSolution), Unsolved>,
    ) -> Result<Option<Self>, Unsolved> {
        let Some(growing) = &self.growing else { return Ok(None) };
        let Refined { state: before, error, force, .. } = &self.refined;
        let units = self.scaled.units;
        let mut problem = before.problem.deeper(deeper);
        // To first order in the change, exactly.
        let start: Vec<f64> = before.solution.pressure.iter().zip(growing).map(|(p, m)| p + deeper * m).collect();
        let (threads, deadline) = (settings.threads, settings.deadline);
        let (more, solution) =
            solve(&problem, &start, &matrix_free::Settings { threads, deadline, ..matrix_free::Settings::default() })?;
        if more != 0.0 {
            problem = problem.deeper(more);
            deeper += more;
        }
        let depth = (self.scaled.depth + deeper) * units.height;
        let Some(overlap) = Overlap::of(contact.gap(), depth)? else { return Ok(None) };
        // Tips, and ends of the material, that were left out may be reached.
        if !touches_alike(contact.gap(), [self.scaled.depth * units.height, depth]) {
            return Ok(None);
        }
        // A smaller reach takes no cell away.
        let reach = units.rect_inward(&overlap.reach).union(&self.scaled.reach);
        let certain = overlap.certain && self.scaled.certain;
        let scaled = Scaled { depth: depth / units.height, reach, certain, ..self.scaled.clone() };
        if expanded(&scaled, &problem.grid.extent(), &problem.grid, &solution.pressure).is_some() {
            return Ok(None);
        }
        let state = GridState {
            iterations: solution.iterations,
            operator_products: solution.operator_products,
            problem,
            solution,
            ..before.clone()
        };
        let error = error / force * state.force();
        let grown = Self::grown(scaled, Refined::of(state, error))?;
        Ok(Some(Self { errors: self.errors, estimated_at: self.estimated_at, ..grown }))
    }

    /// Proved bounds of the force at a depth close by; `None` where none can be had.
    pub fn bounds_at(&self, contact: &Contact, depth: f64, settings: &Settings) -> Option<[f64; 2]> {
        let near = self.continued_to(contact, depth, settings).ok()??;
        let trial = near.refined.state.trial();
        let unit = contact.modulus().e_star() * near.scaled.units.height * near.scaled.units.length;
        let law = near.scaled.gap.known().law.map(|law| law.degree);
        let bounds = refinement::claimed(&near.scaled, law, &trial, settings, AS_THEY_ARE).ok()?;
        Some(bounds.map(|force| force * unit))
    }

    fn grown(scaled: Scaled, refined: Refined) -> Result<Self, Unsolved> {
        let growing = if refined.sequence.is_none() { Some(single_grid::flat_punch(&refined.state)?) } else { None };
        let estimated_at = refined.state.force();
        Ok(Self { scaled, refined, growing, errors: Errors::default(), estimated_at })
    }

    /// Whether errors that were estimated at another depth are those of this one.
    pub fn keeps_its_errors(&self) -> bool {
        SAME_ERRORS.contains(&(self.refined.state.force() / self.estimated_at))
    }

    /// The overlap of this state.
    ///
    /// # Errors
    /// `Unbounded`.
    pub fn overlap(&self, contact: &Contact) -> Result<Option<Overlap>, Unsolved> {
        Overlap::of(contact.gap(), self.scaled.depth * self.scaled.units.height)
    }

    /// dP/dd of the cells in contact.
    fn stiffness(&self) -> Option<f64> {
        let area = self.refined.state.problem.grid.cell_area();
        self.growing.as_ref().map(|growing| growing.iter().sum::<f64>() * area)
    }

    /// In the user's units.
    ///
    /// # Errors
    /// Those of the stiffness, where it is the limit of many grids; `ToleranceNotReached` and `TimeLimit` with the state.
    pub fn solution(&self, contact: &Contact, settings: &Settings) -> Result<Solution, Unsolved> {
        let Errors { stiffness, energy, area, peak } = self.errors;
        let stiffness = match self.stiffness() {
            Some(own) => (own, stiffness),
            None => stiffness_of(&self.scaled, &self.refined)?,
        };
        let depth = self.scaled.depth * self.scaled.units.height;
        let mut solution = in_users_units(contact, &self.scaled, &self.refined, stiffness, depth, [0.0; 2], settings)?;
        solution.energy_error = solution.energy_error.or(energy);
        solution.area_error = solution.area_error.or(area);
        if solution.pressure.singular.is_none() && solution.touches_edge.is_none() {
            solution.pressure.max_error = solution.pressure.max_error.or(peak);
        }
        match self.refined.shortfall(settings) {
            None => Ok(solution),
            Some(short) => Err(short.with_best(solution)),
        }
    }
}
