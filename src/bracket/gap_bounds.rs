//! What is known of the gap from one look to the next: it does not change while the pressure does.

use super::mirrors::Image;
use super::polynomial::{LATTICE, QUARTERS};
use super::problem::BracketProblem;
use crate::gap::Gap;
use crate::numeric::geometry::Rect;

/// Rounding of f and of the last sums, relative to the depth.
pub(super) const ROUNDING: f64 = 1e-13;

/// Share of a residual by which the bounds of a quarter may be too wide when they are taken from another slope.
const WIDER: f64 = 0.05;

/// Bounds of the gap and a plane together over a quarter of a cell, and the slopes of the plane per side of the cell.
#[derive(Debug, Clone, Copy)]
struct Quarter {
    slopes: [f64; 2],
    bounds: [f64; 2],
}

/// Overlap in the cells of a grid, computed when it is asked for. What one look alone would ask for is not kept.
pub(super) struct GapBounds {
    keeps: bool,
    /// Supremum of f, or the largest value seen; NaN where it was not asked for.
    highest: Vec<f64>,
    /// Where the cells stand in the lists below, plus one.
    place: Vec<u32>,
    quarters: Vec<[Quarter; 4]>,
    lattices: Vec<(Image, [f64; 16])>,
}

impl GapBounds {
    pub fn new(cells: usize, keeps: bool) -> Self {
        let (highest, place) = if keeps { (vec![f64::NAN; cells], vec![0; cells]) } else { Default::default() };
        Self { keeps, highest, place, quarters: Vec::new(), lattices: Vec::new() }
    }

    /// Nothing, as at the start.
    pub fn forget(&mut self) {
        self.highest.fill(f64::NAN);
        self.place.fill(0);
        (self.quarters, self.lattices) = Default::default();
    }

    /// Supremum of f over a cell; `None` when the gap proves none.
    pub fn supremum(&mut self, problem: &BracketProblem, cell: usize) -> Option<f64> {
        if self.keeps && !self.highest[cell].is_nan() {
            return Some(self.highest[cell]);
        }
        let nx = problem.grid.shape[0];
        let low = problem.gap.bounds(&problem.grid.cell(cell % nx, cell / nx), [0.0; 2])?[0];
        let highest = problem.depth * (1.0 + ROUNDING) - low;
        if self.keeps {
            self.highest[cell] = highest;
        }
        Some(highest)
    }

    /// f at the points of [`LATTICE`] along both sides of the cell that it is an image of.
    pub fn lattice(&mut self, problem: &BracketProblem, image: &Image) -> [f64; 16] {
        let cell = image.cell;
        let kept = if self.keeps { self.place[cell] as usize } else { 0 };
        if kept > 0 && self.lattices[kept - 1].0 == *image {
            return self.lattices[kept - 1].1;
        }
        let values = std::array::from_fn(|k| problem.overlap(cell, image.turn([LATTICE[k % 4], LATTICE[k / 4]])));
        if kept > 0 {
            self.lattices[kept - 1] = (*image, values);
        } else if self.keeps {
            self.lattices.push((*image, values));
            self.place[cell] = self.lattices.len() as u32;
        }
        values
    }

    /// Bounds of the gap and planes with these slopes together over the quarters of a cell; `None` when the gap proves none.
    pub fn quarters(&mut self, problem: &BracketProblem, cell: usize, planes: &[[f64; 3]; 4]) -> Option<[[f64; 2]; 4]> {
        let kept = if self.keeps { self.place[cell] as usize } else { 0 };
        let mut bounds = [[0.0; 2]; 4];
        if kept == 0 {
            let mut found = [Quarter { slopes: [0.0; 2], bounds: [0.0; 2] }; 4];
            for (k, quarter) in found.iter_mut().enumerate() {
                let slopes = [planes[k][1], planes[k][2]];
                *quarter = Quarter { slopes, bounds: range(problem, cell, QUARTERS[k], 0.25, slopes)? };
                bounds[k] = quarter.bounds;
            }
            if self.keeps {
                self.quarters.push(found);
                self.place[cell] = self.quarters.len() as u32;
            }
            return Some(bounds);
        }
        for (k, quarter) in self.quarters[kept - 1].iter_mut().enumerate() {
            let [value, s, t] = planes[k];
            // The planes differ by no more than this within the quarter.
            let off = 0.25 * (1.0 + 1e-9) * ((s - quarter.slopes[0]).abs() + (t - quarter.slopes[1]).abs());
            let [low, high] = quarter.bounds;
            let residual = (problem.depth - value - low).abs().max((problem.depth - value - high).abs());
            bounds[k] = if off <= WIDER * residual {
                [low - off, high + off]
            } else {
                *quarter = Quarter { slopes: [s, t], bounds: range(problem, cell, QUARTERS[k], 0.25, [s, t])? };
                quarter.bounds
            };
        }
        Some(bounds)
    }
}

/// Bounds of the gap and a plane together over a square about `at`, half a side and slopes in sides of the cell: g + u, where
/// the plane is that of u.
pub(super) fn range(
    problem: &BracketProblem,
    cell: usize,
    at: [f64; 2],
    half: f64,
    slopes: [f64; 2],
) -> Option<[f64; 2]> {
    let spacing = problem.grid.spacing;
    // A hair larger, so that the squares cover the cell however the sums are rounded.
    let square = Rect::around(problem.place(cell, at), spacing.map(|h| h * half * (1.0 + 1e-9)));
    problem.gap.bounds(&square, [-slopes[0] / spacing[0], -slopes[1] / spacing[1]])
}
