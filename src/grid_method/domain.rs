//! The scaled and the domain: units in which a state of loading is solved, and a box that holds its contact without the
//! user's help.
//!
//! The box starts as that of {f > 0}, outside of which no cell is ever loaded. A coarse solve on overlaps that are never
//! too small shrinks it to the contact and a margin; the solver then verifies it ([`crate::grid_method::expansion`]).

use crate::discrete::symmetry::Symmetry;
use crate::discrete::{Discrete, DiscreteSolution};
use crate::gap::{Degree, Gap, lattice};
use crate::grid::{Grid, Kernel, shape};
use crate::matrix_free;
use crate::numeric::geometry::Rect;
use crate::overlap::Scaled;
use crate::solution::Unsolved;

/// Cells along the longer side of the coarse grids.
const COARSE: usize = 16;

/// A box that a coarse solve would shrink by less than this is kept.
const SNUG: f64 = 0.8;

/// How a box is looked for.
struct Look {
    /// Coarse cells from the centre of the outermost loaded one to the border of the box.
    margin: f64,
    /// Error of the gap, relative to the depth.
    tolerance: f64,
    /// Whether coarse cells are square where they can be.
    square: bool,
}

/// Shrinkings before the box is taken as it is: from a box 1e12 contacts wide down to one.
const MOST_SHRINKINGS: usize = 40;

/// Cells along the longer side of the first grid, from the homogeneity that gives the force from the energy: energies of
/// contacts without sharp edges tell the most on so few.
pub(crate) fn coarsest(degree: Option<Degree>) -> usize {
    if matches!(degree, Some(Degree::Power(_))) { 10 } else { 16 }
}

/// The box made wide enough for square cells, `longest` along its longer side: their influence coefficients are known, and both
/// directions are resolved alike. A box that may be fitted to edges of the material stays as it is.
pub(crate) fn squared(scaled: &Scaled, window: &Rect, longest: usize) -> Rect {
    let size = window.size();
    let longer = usize::from(size[1] > size[0]);
    let shorter = 1 - longer;
    // So slender a box has half as many cells across, whatever their sides.
    if 2.0 * size[shorter] < size[longer] {
        return *window;
    }
    let wanted = shape(window, longest)[shorter] as f64 / longest as f64 * size[longer];
    let mut half = [0.5 * size[0], 0.5 * size[1]];
    half[shorter] = 0.5 * wanted;
    let square = Rect::around(window.centre(), half);
    let all_material = square.corners().iter().all(|c| scaled.gap.gap(c[0], c[1]) < f64::INFINITY);
    if all_material { square } else { *window }
}

/// The box of the contact with a margin, from coarse solves.
pub(crate) fn locate(scaled: &Scaled) -> Result<Rect, Unsolved> {
    located(scaled, &Look { margin: 1.5, tolerance: 1e-3, square: false })
}

/// A closer box, sooner found: for grids that begin anew should they outgrow it.
pub(crate) fn locate_closely(scaled: &Scaled) -> Result<Rect, Unsolved> {
    located(scaled, &Look { margin: 1.25, tolerance: 1e-2, square: true })
}

fn located(scaled: &Scaled, look: &Look) -> Result<Rect, Unsolved> {
    scaled.units.resolve()?;
    let mut window = scaled.reach;
    for _ in 0..MOST_SHRINKINGS {
        let mut longest = COARSE;
        let (problem, pressure) = loop {
            let wide = if look.square { squared(scaled, &window, longest) } else { window };
            let problem = optimistic(scaled, Grid::over(&wide, shape(&wide, longest)));
            if problem.deepest() > 0.25 || longest >= 8 * COARSE {
                let settings = matrix_free::Settings { tolerance: look.tolerance, ..matrix_free::Settings::default() };
                let solved = matrix_free::solve_nested(&problem, &settings)?;
                break (problem, solved.pressure);
            }
            // The contact is thinner than the lattice sees.
            longest *= 2;
        };
        let grid = problem.grid;
        let [hx, hy] = grid.spacing;
        let loaded = grid.loaded(&pressure).map(|(at, _)| at);
        let Some(contact) = Rect::holding(loaded) else { return Ok(window) };
        // The centre of the outermost cell, half a cell to its border, and more for what the coarse grid cannot see.
        let margin = Rect {
            min: [contact.min[0] - look.margin * hx, contact.min[1] - look.margin * hy],
            max: [contact.max[0] + look.margin * hx, contact.max[1] + look.margin * hy],
        };
        let tight = symmetrised(&margin, &window, &Symmetry::of(&problem)).intersection(&window).unwrap_or(window);
        let ([w, h], [w0, h0]) = (tight.size(), window.size());
        let snug = w >= SNUG * w0 && h >= SNUG * h0;
        window = tight;
        if snug {
            break;
        }
    }
    Ok(window)
}

/// A loose solve: it only has to show the way.
pub(crate) fn coarse(problem: &Discrete) -> Result<DiscreteSolution, Unsolved> {
    matrix_free::solve_nested(problem, &matrix_free::Settings { tolerance: 1e-3, ..matrix_free::Settings::default() })
}

/// The overlap of each cell as its largest at nine points: no cell that touches is missed where the gap is smooth.
fn optimistic(scaled: &Scaled, grid: Grid) -> Discrete {
    let ([hx, hy], [nx, ny]) = (grid.spacing, grid.shape);
    let wide = 2 * nx + 1;
    // Half a cell apart; those on a border belong to the cells on both sides of it.
    let spacing = [0.5 * hx, 0.5 * hy];
    let corners =
        Grid { origin: [0, 1].map(|m| grid.origin[m] - 0.5 * spacing[m]), spacing, shape: [wide, 2 * ny + 1] };
    let points = lattice::values(&scaled.gap, &corners);
    let overlap = (0..grid.len()).map(|k| {
        let first = 2 * (k / nx) * wide + 2 * (k % nx);
        let rows = [first, first + wide, first + 2 * wide];
        let least = rows.iter().flat_map(|&row| &points[row..row + 3]).fold(f64::INFINITY, |m, &g| m.min(g));
        scaled.depth - least
    });
    Discrete { grid, kernel: Kernel::Collocation, overlap: overlap.collect() }
}

/// The box made to share the symmetries of the problem about the middle of `frame`.
fn symmetrised(inner: &Rect, frame: &Rect, symmetry: &Symmetry) -> Rect {
    let c = frame.centre();
    let mut result = *inner;
    let mut mirror = |axis: usize| {
        let half = (inner.max[axis] - c[axis]).max(c[axis] - inner.min[axis]);
        (result.min[axis], result.max[axis]) = (c[axis] - half, c[axis] + half);
    };
    if symmetry.mirrors_x() {
        mirror(0);
    }
    if symmetry.mirrors_y() {
        mirror(1);
    }
    if symmetry.exchanges() && symmetry.mirrors_x() {
        let half = 0.5 * result.longer_side();
        result = Rect::around(c, [half; 2]);
    }
    result
}
