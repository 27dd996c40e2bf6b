//! Punches with sharp edges: the limit of many grids.
//!
//! Where the pressure grows without bound towards an edge (the end of the material, or a step of the gap), forces converge with
//! the first power of the cells, and jump with where the edge falls between them. No three grids show an order. A line through
//! the forces of seven or more, four to a doubling, does: the area by which each grid misses the material explains most of the
//! jumps, the rest average out, and their size tells how well.

use super::ROUGHEST;
use super::extrapolation::{Estimate, Intercept};
use super::single_grid::{GridState, at_resolution};
use crate::gap::{AnyGap, Gap};
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;
use crate::patch::peak::{STEP, steepest_beside};
use crate::problem::{Method, Settings};
use crate::solution::{Unsolved, Verdict};

/// Cells along the longer side of the first grid.
const COARSEST: f64 = 32.0;

/// Grids to a doubling of the cells.
const STEPS: f64 = 4.0;

/// Cells along the longer side of the last grid that is tried: the 22nd.
pub(crate) const FINEST: usize = 1218;

/// The same of a measured gap whose samples leave so much open that [`ROUGHEST`] is asked for: the 18th.
const FINEST_ROUGH: usize = 609;

/// The same where no more than `allowed` are wanted: enough for a line in any case.
pub(crate) fn finest(allowed: usize, gap: &AnyGap, tolerance: f64) -> usize {
    let rough = gap.is_measured() && tolerance >= ROUGHEST;
    allowed.clamp(128, if rough { FINEST_ROUGH } else { FINEST })
}

/// Why no finer grid than one of `cells` is tried.
pub(crate) fn most(cells: usize) -> String {
    format!("{cells} cells along the longer side are the most that are tried here")
}

/// What a result says that comes from a line.
pub(crate) fn remark(grids: usize) -> String {
    format!("{REMARK} the limit of {grids} grids, by a line")
}

/// How that begins.
pub(crate) const REMARK: &str = "sharp edges:";

/// Cells along the longer side of the k-th grid.
pub(crate) fn cells(k: usize) -> usize {
    (COARSEST * (k as f64 / STEPS).exp2()).round() as usize
}

/// The way to the cells beside one.
const BESIDE: [[i64; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// What a contact runs up to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Edge {
    /// The end of the material.
    End,
    /// A step of the gap, or a flank so steep that these cells take it for one.
    Step,
}

/// The edge that the contact runs up to, if any: the end of the material before steps.
pub(crate) fn boundary_type(scaled: &Scaled, state: &GridState) -> Option<Edge> {
    let (grid, overlap) = (&state.problem.grid, &state.problem.overlap);
    let [nx, ny] = grid.shape;
    let step = STEP * state.problem.deepest();
    let mut found = None;
    for k in (0..overlap.len()).filter(|&k| state.solution.pressure[k] > 0.0) {
        let cell = |along: [i64; 2], n: i64| [(k % nx) as i64 + n * along[0], (k / nx) as i64 + n * along[1]];
        let on_grid = |[i, j]: [i64; 2]| {
            let inside = (0..nx as i64).contains(&i) && (0..ny as i64).contains(&j);
            inside.then(|| j as usize * nx + i as usize)
        };
        let at = |cell: [i64; 2]| {
            let centre = |m: usize| grid.origin[m] + (cell[m] as f64 + 0.5) * grid.spacing[m];
            on_grid(cell).map_or_else(|| scaled.depth - Gap::gap(&scaled.gap, centre(0), centre(1)), |k| overlap[k])
        };
        let pressed = |cell: [i64; 2]| on_grid(cell).is_some_and(|k| state.solution.pressure[k] > 0.0);
        for along in BESIDE {
            if at(cell(along, 1)) == f64::NEG_INFINITY {
                return Some(Edge::End);
            }
            // A cell on the step itself may hold a mean of both sides: the one behind it tells.
            let behind = cell(along, 2);
            if !pressed(behind) && overlap[k] - at(behind) > step {
                found = Some(Edge::Step);
            }
        }
    }
    found
}

/// Share of the force that may rest on flanks which these cells take for steps: P grows with the root of the area, and the flanks may bear as
/// flat parts do, or not at all.
pub(crate) fn on_flanks(scaled: &Scaled, state: &GridState) -> f64 {
    let (problem, pressure) = (&state.problem, &state.solution.pressure);
    let (grid, step) = (&problem.grid, STEP * problem.deepest());
    let (mut area, mut flanks) = (0.0, 0.0);
    for k in (0..grid.len()).filter(|&k| pressure[k] > 0.0) {
        area += grid.cell_area();
        for along in BESIDE {
            let Some(slope) = steepest_beside(&scaled.gap, problem, pressure, k, along, step) else { continue };
            let [x, y] = grid.centre_of(k);
            // All of the overlap would fall over this width; 0 at a jump.
            flanks += (scaled.depth - Gap::gap(&scaled.gap, x, y)) / slope * grid.spacing[usize::from(along[0] != 0)];
        }
    }
    0.5 * flanks / area
}

/// Points a side at which a cell is looked at.
const POINTS: usize = 8;

/// How far from its corners the first and last of them lie, in cells: an edge along the cells passes by, but for rounding.
const INSET: f64 = 1e-7;

/// How the cells meet the end of the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CutCells {
    /// Whether every cell there is all material or none.
    pub aligned: bool,
    /// Area of the material in cells that count as none, less that of what is not material in cells that count as such.
    pub left_out: f64,
}

impl CutCells {
    pub fn of(scaled: &Scaled, state: &GridState) -> Self {
        let (grid, overlap) = (&state.problem.grid, &state.problem.overlap);
        let [nx, ny] = grid.shape;
        let near = |k: usize, holds: &dyn Fn(usize) -> bool| {
            let beside = |n: usize, end: usize| n.saturating_sub(1)..(n + 2).min(end);
            beside(k / nx, ny).any(|j| beside(k % nx, nx).any(|i| holds(j * nx + i)))
        };
        let outermost = |k: usize| [k % nx, nx - 1 - k % nx, k / nx, ny - 1 - k / nx].contains(&0);
        let void = |k: usize| overlap[k] == f64::NEG_INFINITY;
        let pressed = |k: usize| state.solution.pressure[k] > 0.0;
        let mut border = Self { aligned: true, left_out: 0.0 };
        for k in 0..grid.len() {
            let whole = if void(k) && near(k, &pressed) {
                0.0
            } else if pressed(k) && (outermost(k) || near(k, &void)) {
                1.0
            } else {
                continue;
            };
            let [material, share] = shares_of_material(scaled, &grid.cell(k % nx, k / nx));
            border.aligned &= material == whole;
            border.left_out += (share - whole) * grid.cell_area();
        }
        border
    }
}

/// Shares of a cell in which there is material, and in which the depth reaches it.
fn shares_of_material(scaled: &Scaled, cell: &Rect) -> [f64; 2] {
    let size = cell.size();
    let at = |n: usize| INSET + (1.0 - 2.0 * INSET) * n as f64 / (POINTS - 1) as f64;
    // The trapezium rule: points on the rim stand for half a cell of the lattice each way.
    let weight = |n: usize| if n == 0 || n == POINTS - 1 { 0.5 } else { 1.0 };
    let (mut material, mut reached, mut all) = (0.0, 0.0, 0.0);
    for (i, j) in (0..POINTS * POINTS).map(|k| (k % POINTS, k / POINTS)) {
        all += weight(i) * weight(j);
        let gap = Gap::gap(&scaled.gap, cell.min[0] + at(i) * size[0], cell.min[1] + at(j) * size[1]);
        if gap < f64::INFINITY {
            material += weight(i) * weight(j);
        }
        if gap < scaled.depth {
            reached += weight(i) * weight(j);
        }
    }
    [material / all, reached / all]
}

/// The longer side of the cells, and the area they leave out: what an [`Intercept`] asks of a grid.
pub(crate) fn measure(scaled: &Scaled, state: &GridState) -> [f64; 2] {
    let [hx, hy] = state.problem.grid.spacing;
    [hx.max(hy), CutCells::of(scaled, state).left_out]
}

/// The box with shares of a cell put to each side, others for each grid: edges along the cells would otherwise fall upon
/// them, or just beside, on every grid alike, and what is left out would tell nothing.
fn shifted(window: &Rect, cells: usize, k: usize) -> Rect {
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
pub(crate) struct GridSequence {
    states: Vec<GridState>,
    line: Intercept,
}

impl GridSequence {
    /// The finest.
    pub fn last(&self) -> &GridState {
        &self.states[self.states.len() - 1]
    }

    /// How many they are.
    pub fn grids(&self) -> usize {
        self.states.len()
    }

    /// Sums of the pressures of the finest and of those with half, a quarter of its cells and so on, coarse to fine.
    pub fn sums(&self) -> Vec<f64> {
        let mut sums: Vec<f64> = self.states.iter().rev().step_by(STEPS as usize).map(GridState::force).collect();
        sums.reverse();
        sums
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
    ) -> Result<[Estimate; N], Unsolved> {
        let all = self.states.iter().map(values).collect::<Result<Vec<_>, _>>()?;
        Ok(std::array::from_fn(|n| self.line.of(&all.iter().map(|v| v[n]).collect::<Vec<_>>())))
    }
}

/// Grids up to [`finest`] cells along the longer side, moved against the edges unless those lie along the cells
/// (`aligned`), until the force is known to the tolerance, or as well as they tell; with what kept it from finer ones.
///
/// # Errors
/// As the solvers; `ToleranceNotReached` when no grid is fine enough to see the contact.
pub(crate) fn sequence(
    scaled: &Scaled,
    window: &mut Rect,
    aligned: bool,
    allowed: usize,
    settings: &Settings,
    method: Method,
) -> Result<(GridSequence, Estimate, Option<Unsolved>), Unsolved> {
    let mut stopped = None;
    let (mut states, mut grids): (Vec<GridState>, Vec<[f64; 2]>) = Default::default();
    let mut best = None;
    let finest = finest(allowed, &scaled.gap, settings.tolerance);
    for (k, cells) in (0..).map(cells).take_while(|&n| n <= finest).enumerate() {
        let (mut laid, cells) = if aligned { (*window, cells) } else { (shifted(window, cells, k), cells + 1) };
        let first = laid;
        // Room for the shares of a cell.
        let roomy = Scaled { reach: scaled.reach.union(&laid), ..scaled.clone() };
        let state = at_resolution(&roomy, &mut laid, cells, settings, method);
        if laid != first {
            *window = window.union(&laid);
        }
        let state = match state {
            Err(e) if matches!(e.verdict, Verdict::TooLarge | Verdict::TimeLimit) && best.is_some() => {
                stopped = Some(e);
                break;
            }
            other => other?,
        };
        if state.force() <= 0.0 {
            continue;
        }
        grids.push(measure(scaled, &state));
        states.push(state);
        let (Some(line), Some(finest)) = (Intercept::new(&grids), states.last()) else { continue };
        // Beside the edges there may be flanks that no cell resolves yet: a line knows nothing of them.
        let flanks = on_flanks(scaled, finest);
        let Estimate { value, error } = line.of(&states.iter().map(GridState::force).collect::<Vec<_>>());
        let estimate = Estimate { value, error: error + flanks * value };
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
    Ok((GridSequence { states, line }, estimate, stopped))
}
