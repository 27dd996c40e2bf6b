//! What a sequence of grids has found: the finest, the best value of the force, and its error.

use super::extrapolation::Estimate;
use super::sharp_edges::{self, GridSequence};
use super::single_grid::GridState;
use crate::consistency::{self, Claim};
use crate::gap::Degree;
use crate::overlap::Scaled;
use crate::problem::Settings;
use crate::solution::{Unsolved, Verdict};

/// A contact refined until the force is good enough.
#[derive(Debug, Clone)]
pub(crate) struct Refined {
    /// The finest grid.
    pub state: GridState,
    /// The grid before it, where there is one: by how much a number of the finest still changes.
    pub coarser: Option<Box<GridState>>,
    /// Best value of the force; that of the finest grid itself when the number of cells was prescribed.
    pub force: f64,
    /// Estimate of its error, absolute.
    pub error: f64,
    /// Grids whose values make the force.
    pub grids: usize,
    /// What kept the method from finer grids.
    pub stopped: Option<Unsolved>,
    /// The grids that it took where the contact ends at sharp edges; `state` is the finest.
    pub sequence: Option<GridSequence>,
    /// Proved bounds of the force, from the pressure of `state`.
    pub proved: Option<[f64; 2]>,
    /// Sums of the pressures of the grids, coarse to fine.
    pub sums: Vec<f64>,
}

/// What the error of a force may be less than the tolerance.
const ROUNDING: f64 = 1e-9;

/// Times as many cells, along a side, below which a grid is compared with the one before the last.
const SHORT_STEP: f64 = 1.5;

/// Several times what the way to another depth of a homogeneous gap adds to an error.
const OTHER_DEPTH: f64 = 1e-12;

/// |error|/|value| where that is a number.
fn relative(error: f64, value: f64) -> Option<f64> {
    Some((error / value).abs()).filter(|share| share.is_finite())
}

impl Refined {
    /// One grid whose force is the best there is.
    pub fn of(state: GridState, error: f64) -> Self {
        let force = state.force();
        Self {
            force,
            error,
            grids: 1,
            state,
            coarser: None,
            stopped: None,
            sequence: None,
            proved: None,
            sums: vec![force],
        }
    }

    /// Best values of what is found in a state: of the finest grid, or the limits of all where the contact ends at sharp edges.
    ///
    /// # Errors
    /// Those of `values`.
    pub fn limits<const N: usize>(
        &self,
        values: impl Fn(&GridState) -> Result<[f64; N], Unsolved>,
    ) -> Result<[f64; N], Unsolved> {
        match &self.sequence {
            Some(sequence) => Ok(sequence.limits(values)?.map(|limit| limit.value)),
            None => values(&self.state),
        }
    }

    /// The same with an estimate of the relative error of each: what is left of the limits, or what has changed since the grid
    /// before.
    ///
    /// # Errors
    /// Those of `values`.
    pub fn estimated<const N: usize>(
        &self,
        values: impl Fn(&GridState) -> Result<[f64; N], Unsolved>,
    ) -> Result<[(f64, Option<f64>); N], Unsolved> {
        let finest = if self.sequence.is_some() { None } else { Some(values(&self.state)?) };
        self.estimated_beside(finest, values)
    }

    /// The same where those of the finest grid are known already.
    ///
    /// # Errors
    /// Those of `values`.
    pub fn estimated_beside<const N: usize>(
        &self,
        finest: Option<[f64; N]>,
        values: impl Fn(&GridState) -> Result<[f64; N], Unsolved>,
    ) -> Result<[(f64, Option<f64>); N], Unsolved> {
        if let Some(sequence) = &self.sequence {
            return Ok(sequence.limits(values)?.map(|Estimate { value, error }| (value, relative(error, value))));
        }
        let found = finest.map_or_else(|| values(&self.state), Ok)?;
        // What the coarser grid cannot tell leaves the error unknown, no more.
        let before =
            self.coarser.as_ref().and_then(|coarser| Some((values(coarser).ok()?, self.left_of_step(coarser))));
        Ok(std::array::from_fn(|n| {
            let step = before.as_ref().map(|(before, left)| left * (found[n] - before[n]));
            (found[n], step.and_then(|step| relative(step, found[n])))
        }))
    }

    /// What is left of a number that changed by 1 from a coarser grid, to first order in the cells; no less than 1.
    fn left_of_step(&self, coarser: &GridState) -> f64 {
        (1.0 / (self.state.times_as_fine_as(coarser) - 1.0).max(0.0)).max(1.0)
    }

    /// With the bounds: their distance is the error, and the force lies between them; where the middle is within the tolerance of both, not so
    /// close to either that the other is not.
    pub(super) fn within(self, [lower, upper]: [f64; 2], tolerance: f64) -> Self {
        let middle = 0.5 * (lower + upper);
        let aim = (tolerance * (1.0 - ROUNDING) - OTHER_DEPTH).max(0.0);
        let room = (aim * middle - 0.5 * (upper - lower)) / (1.0 + tolerance);
        let force = if room >= 0.0 { self.force.clamp(middle - room, middle + room) } else { self.force };
        let force = force.clamp(lower, upper);
        Self { force, error: (upper - force).max(force - lower), proved: Some([lower, upper]), ..self }
    }

    /// The same where bounds that are too wide leave the estimate: one that they have moved is worth no more than it was moved by.
    pub(super) fn bounded_by(self, bounds: [f64; 2], tolerance: f64) -> Self {
        let (force, error) = (self.force, self.error);
        let found = self.within(bounds, tolerance);
        if found.is_within(tolerance) {
            return found;
        }
        Self { error: found.error.min(error.max((found.force - force).abs())), ..found }
    }

    /// On a finer grid: with its force, or with the limit of energies where the gap follows a law.
    pub(super) fn on_finer(self, state: GridState, lawful: bool) -> Self {
        let own = state.force();
        let (force, error) =
            if lawful { (self.force, self.error) } else { (own, self.error.max((own - self.force).abs())) };
        let sums = self.sums.iter().copied().chain([own]).collect();
        // A step from a grid of hardly fewer cells tells little.
        let before = self.coarser.filter(|_| state.times_as_fine_as(&self.state) < SHORT_STEP);
        let coarser = before.unwrap_or_else(|| Box::new(self.state));
        Self { coarser: Some(coarser), state, force, error, sums, proved: None, ..self }
    }

    /// The nearest force within bounds that others have proved; what it was off by is part of the error. Who prescribes the grid wants the
    /// force of that grid.
    pub(super) fn moved_within(self, [lower, upper]: [f64; 2], prescribed: bool) -> Self {
        let force = self.force.max(lower).min(upper);
        let error = self.error.max((force - self.force).abs());
        Self { force: if prescribed { self.force } else { force }, error, ..self }
    }

    /// # Errors
    /// `Inconsistent`, when the force breaks a law that every contact obeys.
    pub(super) fn is_consistent(&self, scaled: &Scaled, degree: Option<Degree>) -> Result<(), Unsolved> {
        let claim = Claim { force: self.force, error: self.error };
        consistency::limit_of(&self.sums, degree, claim)?;
        consistency::above_ellipse(scaled, &self.state.problem, &self.state.solution.pressure, claim)?;
        self.proved.map_or(Ok(()), |bounds| consistency::within(bounds, claim, "the energy"))
    }

    pub(super) fn is_within(&self, tolerance: f64) -> bool {
        self.error <= tolerance * self.force
    }

    /// Why the error is larger than asked for; `None` when it is not, or when the number of cells was prescribed.
    pub fn shortfall(&self, settings: &Settings) -> Option<Unsolved> {
        let out_of_time = self.stopped.as_ref().filter(|e| e.verdict == Verdict::TimeLimit);
        if self.is_within(settings.tolerance) || (settings.cells.is_some() && out_of_time.is_none()) {
            return None;
        }
        let [nx, ny] = self.state.problem.grid.shape;
        let why = || self.stopped.as_ref().map_or_else(|| sharp_edges::most(nx.max(ny)), |e| e.reason.clone());
        let short = || Unsolved::short_of(settings.tolerance, self.error / self.force, &why());
        Some(out_of_time.cloned().unwrap_or_else(short))
    }
}
