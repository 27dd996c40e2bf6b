//! The door and the domain: units in which a state of loading is solved, and a box that holds its contact without the
//! user's help.
//!
//! The box starts as that of {f > 0}, outside of which no cell is ever loaded. A coarse solve on overlaps that are never
//! too small shrinks it to the contact and a margin; the solver then verifies it ([`crate::outgrown`]).

use crate::discrete::{Discrete, DiscreteSolution};
use crate::error::{Unsolved, Verdict};
use crate::gap::{Gap, Reach, Scaled, extent};
use crate::geometry::Rect;
use crate::grid::{Grid, Kernel};
use crate::matrix_free;
use crate::symmetry::Symmetry;

/// Cells along the longer side of the coarse grids.
const COARSE: usize = 16;

/// A box that a coarse solve would shrink by less than this is kept.
const SNUG: f64 = 0.8;

/// Shrinkings before the box is taken as it is: from a box 1e12 contacts wide down to one.
const MOST_SHRINKINGS: usize = 40;

/// A state of loading in the units of the solvers.
#[derive(Clone, Copy)]
pub(crate) struct Door<'a> {
    /// The gap, in units of the largest overlap and of half the longer side of {f > 0}.
    pub gap: Scaled<'a>,
    /// The depth in the same units. Not 1 when the gap is not zero at its lowest point.
    pub depth: f64,
    /// A box around {f > 0}.
    pub reach: Rect,
}

impl<'a> Door<'a> {
    /// The state in units of its own; `None` when the bodies do not touch.
    pub fn enter(gap: &'a dyn Gap, depth: f64) -> Result<Option<Self>, Unsolved> {
        let reach = match extent(gap, depth) {
            Reach::Within(rect) => rect,
            Reach::Nowhere => return Ok(None),
            Reach::Unbounded | Reach::Unknown => {
                let reason =
                    format!("the gap stays below the depth {depth:e} however far one looks: the contact has no end");
                return Err(Unsolved::new(Verdict::Unbounded, reason));
            }
        };
        let overlap = depth - lowest(gap, &reach);
        let [w, h] = reach.size();
        let length = 0.5 * w.max(h);
        if !(overlap > 0.0 && length > 0.0) {
            return Ok(None);
        }
        let origin = reach.centre();
        let scaled = Scaled { gap, origin, length, depth: overlap };
        let reach = Rect { min: scaled.inward(reach.min), max: scaled.inward(reach.max) };
        Ok(Some(Self { gap: scaled, depth: depth / overlap, reach }))
    }
}

/// Least gap found on a lattice over the box and at the gap's own centre.
fn lowest(gap: &dyn Gap, within: &Rect) -> f64 {
    let [cx, cy] = gap.centre();
    let lattice = Grid::over(within, [33, 33]);
    (0..lattice.len()).map(|k| lattice.centre_of(k)).map(|[x, y]| gap.gap(x, y)).fold(gap.gap(cx, cy), f64::min)
}

/// Cells along both sides of a box: `longest` along the longer one, at least half as many along the other.
pub(crate) fn shape(window: &Rect, longest: usize) -> [usize; 2] {
    let [w, h] = window.size();
    let other = |ratio: f64| ((longest as f64 * ratio - 1e-9).ceil() as usize).clamp(longest.div_ceil(2), longest);
    if w >= h { [longest, other(h / w)] } else { [other(w / h), longest] }
}

/// The box of the contact with a margin, from coarse solves.
pub(crate) fn locate(door: &Door) -> Result<Rect, Unsolved> {
    let mut window = door.reach;
    for _ in 0..MOST_SHRINKINGS {
        let mut longest = COARSE;
        let (problem, pressure) = loop {
            let problem = optimistic(door, Grid::over(&window, shape(&window, longest)));
            if problem.deepest() > 0.25 || longest >= 8 * COARSE {
                let solved = coarse(&problem)?;
                break (problem, solved.pressure);
            }
            // The contact is thinner than the lattice sees.
            longest *= 2;
        };
        let grid = problem.grid;
        let [hx, hy] = grid.spacing;
        let loaded = (0..grid.len()).filter(|&k| pressure[k] > 0.0).map(|k| grid.centre_of(k));
        let Some(contact) = Rect::holding(loaded) else { return Ok(window) };
        // The centre of the outermost cell, half a cell to its border, and one cell for what the coarse grid cannot see.
        let margin = Rect {
            min: [contact.min[0] - 1.5 * hx, contact.min[1] - 1.5 * hy],
            max: [contact.max[0] + 1.5 * hx, contact.max[1] + 1.5 * hy],
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

/// A loose solve: it only has to show where the contact is.
pub(crate) fn coarse(problem: &Discrete) -> Result<DiscreteSolution, Unsolved> {
    matrix_free::solve_nested(problem, &matrix_free::Settings { tolerance: 1e-3, ..matrix_free::Settings::default() })
}

/// The overlap of each cell as its largest at nine points: no cell that touches is missed where the gap is smooth.
fn optimistic(door: &Door, grid: Grid) -> Discrete {
    let [hx, hy] = grid.spacing;
    let overlap = (0..grid.len())
        .map(|k| {
            let [x, y] = grid.centre_of(k);
            let mut least = f64::INFINITY;
            for s in [-0.5, 0.0, 0.5] {
                for t in [-0.5, 0.0, 0.5] {
                    least = least.min(door.gap.gap(x + s * hx, y + t * hy));
                }
            }
            door.depth - least
        })
        .collect();
    Discrete { grid, kernel: Kernel::Collocation, overlap }
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
        let half = 0.5 * result.size()[0].max(result.size()[1]);
        result = Rect::around(c, [half; 2]);
    }
    result
}
