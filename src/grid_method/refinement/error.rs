//! The error of a force: estimated from grids, proved from an energy.

use super::super::extrapolation::{self, Estimate};
use super::super::sharp_edges::{self, CutCells, Edge};
use super::super::single_grid::{GridState, other_kernel};
use super::super::unresolved;
use super::Refinement;
use crate::energy::{NoBounds, Trial, Wanted, force_bounds};
use crate::gap::Degree;
use crate::grid::Kernel;
use crate::overlap::Scaled;
use crate::problem::{ErrorBar, Settings};
use crate::solution::Unsolved;

/// The same on a prescribed grid, fine enough or not, where it ends at steps or at edges of the material (by up to 1.5 times more
/// than three grids tell, measured on 300 grids of minima like these and of flat punches).
const AT_EDGES_AS_GIVEN: f64 = 2.0;

/// Cells along the longer side up to which grids are refined for narrower bounds, once the estimate is good enough.
pub(super) const FINEST_PROVED: usize = 512;

/// Share of their distance by which bounds of any gap are claimed wider than they were found: whoever works them out again solves the flat
/// punches to other digits.
pub(crate) const REPEATABLE: f64 = 5e-3;

/// How many times as wide as the tolerance bounds may be expected to be that are of use as they are: expectations are rough.
pub(crate) const AS_THEY_ARE: f64 = 1.2;

/// The same of bounds that are stated as a bracket, however wide.
pub(crate) const AS_A_BRACKET: f64 = 10.0;

/// Bounds of the force by the pressure of a grid, as they are stated; none where they are expected to be `hope` times as wide as the tolerance.
///
/// # Errors
/// How far from the tolerance they are expected to be.
pub(crate) fn claimed(
    scaled: &Scaled,
    degree: Option<Degree>,
    trial: &Trial,
    settings: &Settings,
    hope: f64,
) -> Result<[f64; 2], NoBounds> {
    let wanted = Wanted::within(settings.tolerance, hope);
    let [lower, upper] = force_bounds(scaled, degree, trial, wanted, settings.deadline)?;
    let room = if degree.is_none() { REPEATABLE * (upper - lower) } else { 0.0 };
    Ok([lower - room, upper + room])
}

impl Refinement<'_> {
    /// The error of the force of a grid itself, by what it and those before it estimate.
    pub(super) fn error_as_given(
        &self,
        state: &GridState,
        Estimate { value, mut error }: Estimate,
    ) -> Result<f64, Unsolved> {
        let force = state.force();
        if self.law.is_none() {
            error = error.max(self.kernel_difference(state)?);
        }
        let edge = sharp_edges::boundary_type(self.scaled, state);
        if self.law.is_none() && edge.is_some() {
            error = (AT_EDGES_AS_GIVEN * error).max(extrapolation::left_by_first_order(&self.forces));
        }
        if edge == Some(Edge::End) {
            // P grows with the size of a patch: half as much as the area, and as much again for the edges themselves.
            let pressed = state.solution.pressure.iter().filter(|&&p| p > 0.0).count();
            let area = pressed as f64 * state.problem.grid.cell_area();
            error = error.max(force * (CutCells::of(self.scaled, state).left_out / area).abs());
        }
        // Who prescribes the grid wants the force of that grid.
        Ok(error + (force - value).abs())
    }

    /// The limit of the grids so far, this one included.
    ///
    /// The Galerkin energy of a homogeneous gap gives the force, P = (2 + 1/k) U/d, without the jitter of a sum over a
    /// whole number of cells; it is that which is extrapolated.
    pub(super) fn limit(&mut self, state: &GridState) -> Estimate {
        let force = state.force();
        self.forces.push(force);
        let limit = if let Some((degree, ends)) = self.law {
            self.energies.push((2.0 + degree.inverse()) * state.energy() / self.scaled.above_lowest());
            extrapolation::of_energies(&self.energies, ends)
        } else {
            extrapolation::of_forces(&self.forces)
        };
        let estimate = limit.unwrap_or(Estimate { value: force, error: force });
        if self.law.is_some() || self.forces.len() > 2 {
            return estimate;
        }
        // Two coarse grids may agree by chance.
        let left = unresolved::boundary(&state.problem.grid, &state.solution.pressure);
        Estimate { error: estimate.error.max(left * force), ..estimate }
    }

    /// The degree of a homogeneous gap whose force has a proof that is asked for, or that it is any other gap.
    pub(super) fn provable(&self) -> Option<Option<Degree>> {
        let degree = self.law.map(|(degree, _)| degree);
        let wanted = self.settings.evidence == ErrorBar::Proof && self.settings.kernel == Kernel::Galerkin;
        let possible = degree.is_some() || self.scaled.certain;
        (wanted && degree != Some(Degree::Flat) && possible).then_some(degree)
    }

    /// Proved bounds of the force from the energy of a grid ([`force_bounds`]); `None` where they are not asked for, or there is no time;
    /// `hope` as in [`claimed`].
    pub(super) fn proved(&self, state: &GridState, hope: f64) -> Option<Result<[f64; 2], NoBounds>> {
        let degree = self.provable()?;
        let [nx, ny] = state.problem.grid.shape;
        if degree.is_none() && (nx.max(ny) > FINEST_PROVED || self.settings.deadline.check().is_err()) {
            return None;
        }
        Some(claimed(self.scaled, degree, &state.trial(), self.settings, hope))
    }

    /// How far off the other kernel makes the force on the same grid. Values at centres err by up to 1.6 times that
    /// (measured on 1000 closed forms), means by less.
    pub(super) fn kernel_difference(&self, state: &GridState) -> Result<f64, Unsolved> {
        let times = if self.settings.kernel == Kernel::Collocation { 2.0 } else { 1.0 };
        Ok(times * (other_kernel(self.scaled, state)? - state.force()).abs())
    }
}
