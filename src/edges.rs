//! Punches with sharp edges: the limit of many grids.
//!
//! Where the pressure grows without bound towards an edge (the end of the material, or a step of the gap), forces converge with the first power of the cells, and jump with
//! where the edge falls between them. No three grids show an order. A line through the forces of ten or more, four to a
//! doubling, does: the area that each grid leaves out explains most of the jumps, the rest average out, and their size tells how well.

use crate::domain::Door;
use crate::error::{Unsolved, Verdict};
use crate::exact::{GridState, at_resolution};
use crate::extrapolate::{Estimate, Intercept};
use crate::gap::Gap;
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

/// Share of the depth by which the gap grows over two cells where it counts as a step.
const STEP: f64 = 0.25;

/// What a contact runs up to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edge {
    /// The end of the material.
    End,
    /// A step of the gap, or a flank so steep that these cells take it for one.
    Step,
}

/// The edge that the contact runs up to, if any: the end of the material before steps.
pub(crate) fn met(door: &Door, state: &GridState) -> Option<Edge> {
    let (grid, overlap) = (&state.problem.grid, &state.problem.overlap);
    let [nx, ny] = grid.shape;
    let step = STEP * state.problem.deepest();
    let mut found = None;
    for k in (0..overlap.len()).filter(|&k| state.solution.pressure[k] > 0.0) {
        let at = |along: [i64; 2], n: i64| {
            let [i, j] = [(k % nx) as i64 + n * along[0], (k / nx) as i64 + n * along[1]];
            let inside = (0..nx as i64).contains(&i) && (0..ny as i64).contains(&j);
            if inside {
                return overlap[j as usize * nx + i as usize];
            }
            let centre = |m: usize, n: i64| grid.origin[m] + (n as f64 + 0.5) * grid.spacing[m];
            door.depth - Gap::gap(&door.gap, centre(0, i), centre(1, j))
        };
        for along in [[1, 0], [-1, 0], [0, 1], [0, -1]] {
            if at(along, 1) == f64::NEG_INFINITY {
                return Some(Edge::End);
            }
            // A cell on the step itself may hold a mean of both sides: the one behind it tells.
            if at(along, 2) < 0.0 && overlap[k] - at(along, 2) > step {
                found = Some(Edge::Step);
            }
        }
    }
    found
}

/// Points a side at which a cell is looked at.
const POINTS: usize = 8;

/// Area of the material beside the contact that lies in cells which are not all material, and so are left out. Zero when the
/// edges lie along the cells.
pub(crate) fn left_out(door: &Door, state: &GridState) -> f64 {
    let (grid, overlap) = (&state.problem.grid, &state.problem.overlap);
    let [nx, ny] = grid.shape;
    let pressed = |i: usize, j: usize| state.solution.pressure[j * nx + i] > 0.0;
    let beside = |n: usize, end: usize| n.saturating_sub(1)..(n + 2).min(end);
    let share = |i: usize, j: usize| {
        let cell = grid.cell(i, j);
        let (size, at) = (cell.size(), |n: usize| (n as f64 + 0.5) / POINTS as f64);
        let holds = |k: usize| {
            let [x, y] = [cell.min[0] + at(k % POINTS) * size[0], cell.min[1] + at(k / POINTS) * size[1]];
            Gap::gap(&door.gap, x, y) < door.depth
        };
        (0..POINTS * POINTS).filter(|&k| holds(k)).count() as f64 / (POINTS * POINTS) as f64
    };
    let void = (0..grid.len()).filter(|&k| overlap[k] == f64::NEG_INFINITY).map(|k| (k % nx, k / nx));
    let near = void.filter(|&(i, j)| beside(j, ny).any(|j| beside(i, nx).any(|i| pressed(i, j))));
    near.map(|(i, j)| share(i, j)).sum::<f64>() * grid.cell_area()
}

/// The longer side of the cells, and what they leave out: what an [`Intercept`] asks of a grid.
pub(crate) fn measure(door: &Door, state: &GridState) -> [f64; 2] {
    let [hx, hy] = state.problem.grid.spacing;
    [hx.max(hy), left_out(door, state)]
}

/// The box with shares of a cell put to each side, others for each grid: edges along the cells would otherwise fall upon them, or
/// just beside, on every grid alike, and what is left out would tell nothing.
fn moved(window: &Rect, cells: usize, k: usize) -> Rect {
    // A sequence of the generalised golden ratio in four dimensions (Roberts 2018).
    let share = |n: i32| (0.5 + GOLDEN.powi(n) * k as f64).fract();
    let size = window.size();
    let h = size[0].max(size[1]) / cells as f64;
    Rect {
        min: [window.min[0] - share(1) * h, window.min[1] - share(2) * h],
        max: [window.max[0] + share(3) * h, window.max[1] + share(4) * h],
    }
}

/// 1/phi, phi^5 = phi + 1.
const GOLDEN: f64 = 0.856_674_883_854_502_9;

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

/// Grids up to `finest` cells along the longer side, moved against the edges unless those lie along the cells (`aligned`), until the force is known to the tolerance, or as well as they tell.
///
/// # Errors
/// As the solvers; `ToleranceNotReached` when no grid is fine enough to see the contact.
pub(crate) fn ladder(
    door: &Door,
    window: &mut Rect,
    aligned: bool,
    finest: usize,
    settings: &Settings,
    method: Method,
) -> Result<(Ladder, Estimate), Unsolved> {
    let (mut states, mut grids): (Vec<GridState>, Vec<[f64; 2]>) = Default::default();
    let mut best = None;
    for (k, cells) in (0..).map(cells).take_while(|&n| n <= finest.clamp(128, FINEST)).enumerate() {
        let (mut laid, cells) = if aligned { (*window, cells) } else { (moved(window, cells, k), cells + 1) };
        let first = laid;
        // Room for the shares of a cell.
        let roomy = Door { gap: door.gap, depth: door.depth, reach: door.reach.union(&laid) };
        let state = at_resolution(&roomy, &mut laid, cells, settings, method);
        if laid != first {
            *window = window.union(&laid);
        }
        let state = match state {
            Err(e) if e.verdict == Verdict::TooLarge && best.is_some() => break,
            other => other?,
        };
        if state.force() <= 0.0 {
            continue;
        }
        grids.push(measure(door, &state));
        states.push(state);
        let Some(line) = Intercept::new(&grids) else { continue };
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
