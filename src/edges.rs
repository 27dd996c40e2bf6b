//! Punches with sharp edges: the limit of many grids.
//!
//! Where the pressure grows without bound towards an edge, forces converge with the first power of the cells, and jump with
//! where the edge falls between them. No three grids show an order. A line through the forces of ten or more, four to a
//! doubling, does: the jumps average out, and their size tells how well.

use crate::domain::Door;
use crate::error::{Unsolved, Verdict};
use crate::exact::{GridState, at_resolution};
use crate::extrapolate::{Estimate, Intercept};
use crate::geometry::Rect;
use crate::settings::{Method, Settings};

/// Cells along the longer side of the first grid.
const COARSEST: f64 = 32.0;

/// Grids to a doubling of the cells.
const STEPS: f64 = 4.0;

/// Cells along the longer side of the last grid that is tried.
pub(crate) const FINEST: usize = 1024;

/// Cells along the longer side of the k-th grid.
pub(crate) fn cells(k: usize) -> usize {
    (COARSEST * (k as f64 / STEPS).exp2()).round() as usize
}

/// Whether the contact runs up to where the material ends.
pub(crate) fn met(state: &GridState) -> bool {
    let ([nx, ny], overlap) = (state.problem.grid.shape, &state.problem.overlap);
    let void = |i: usize, j: usize| overlap[j * nx + i] == f64::NEG_INFINITY;
    state.solution.pressure.iter().enumerate().filter(|(_, p)| **p > 0.0).any(|(k, _)| {
        let (i, j) = (k % nx, k / nx);
        i == 0
            || j == 0
            || i + 1 == nx
            || j + 1 == ny
            || void(i - 1, j)
            || void(i + 1, j)
            || void(i, j - 1)
            || void(i, j + 1)
    })
}

/// States on grids four to a doubling, coarse to fine.
#[derive(Debug, Clone)]
pub(crate) struct Ladder {
    states: Vec<GridState>,
    line: Intercept,
}

impl Ladder {
    /// The finest.
    pub fn last(&self) -> &GridState {
        &self.states[self.states.len() - 1]
    }

    /// How many they are.
    pub fn grids(&self) -> usize {
        self.states.len()
    }

    /// Iterations and products with the operator on all of them.
    pub fn spent(&self) -> (usize, usize) {
        self.states.iter().fold((0, 0), |(i, p), s| (i + s.iterations, p + s.operator_products))
    }

    /// The limits of what is found in each state.
    ///
    /// # Errors
    /// Those of `values`.
    pub fn limits<const N: usize>(
        &self,
        values: impl Fn(&GridState) -> Result<[f64; N], Unsolved>,
    ) -> Result<[f64; N], Unsolved> {
        Ok(self.line_through(&self.states.iter().map(values).collect::<Result<Vec<_>, _>>()?))
    }

    /// The same of what needs no solve.
    pub fn found<const N: usize>(&self, values: impl Fn(&GridState) -> [f64; N]) -> [f64; N] {
        self.line_through(&self.states.iter().map(values).collect::<Vec<_>>())
    }

    fn line_through<const N: usize>(&self, all: &[[f64; N]]) -> [f64; N] {
        std::array::from_fn(|n| self.line.of(&all.iter().map(|v| v[n]).collect::<Vec<_>>()).value)
    }
}

/// Grids up to `finest` cells along the longer side until the force is known to the tolerance, or as well as they tell.
///
/// # Errors
/// As the solvers; `ToleranceNotReached` when no grid is fine enough to see the contact.
pub(crate) fn ladder(
    door: &Door,
    window: &mut Rect,
    finest: usize,
    settings: &Settings,
    method: Method,
) -> Result<(Ladder, Estimate), Unsolved> {
    let mut states: Vec<GridState> = Vec::new();
    let mut best = None;
    for cells in (0..).map(cells).take_while(|&n| n <= finest.clamp(128, FINEST)) {
        let state = match at_resolution(door, window, cells, settings, method) {
            Err(e) if e.verdict == Verdict::TooLarge && best.is_some() => break,
            other => other?,
        };
        if state.force() <= 0.0 {
            continue;
        }
        states.push(state);
        let spacing = |state: &GridState| state.problem.grid.spacing[0].max(state.problem.grid.spacing[1]);
        let Some(line) = Intercept::new(&states.iter().map(spacing).collect::<Vec<_>>()) else { continue };
        let estimate = line.of(&states.iter().map(GridState::force).collect::<Vec<_>>());
        let good = estimate.error <= settings.tolerance * estimate.value;
        best = Some((line, estimate));
        if good {
            break;
        }
    }
    let (line, estimate) = best.ok_or_else(|| {
        let reason = "the bodies overlap, but no grid shows their edges well enough";
        Unsolved::new(Verdict::ToleranceNotReached, reason)
    })?;
    Ok((Ladder { states, line }, estimate))
}
