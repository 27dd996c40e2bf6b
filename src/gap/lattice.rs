//! A gap in every cell of a grid.
//!
//! A gap of many parts is restricted to those that matter, block by block, so that the whole takes of the order of n log n in their
//! number.

use super::Gap;
use crate::grid::Grid;

/// Cells along a side of the smallest block.
const SMALLEST: usize = 8;

/// The gap at the centre of each cell, x fastest.
pub(crate) fn values(gap: &dyn Gap, grid: &Grid) -> Vec<f64> {
    in_cells(gap, grid, &|gap, i, j| {
        let [x, y] = grid.centre(i, j);
        gap.gap(x, y)
    })
}

/// Its mean over each cell, x fastest.
pub(crate) fn means(gap: &dyn Gap, grid: &Grid) -> Vec<f64> {
    in_cells(gap, grid, &|gap, i, j| gap.mean(&grid.cell(i, j)))
}

fn in_cells(gap: &dyn Gap, grid: &Grid, of: &dyn Fn(&dyn Gap, usize, usize) -> f64) -> Vec<f64> {
    let mut values = vec![f64::INFINITY; grid.len()];
    if !grid.is_empty() {
        Block { from: [0; 2], to: grid.shape }.fill(gap, grid, of, &mut values);
    }
    values
}

/// Cells from a corner to another, the second one beyond the last.
#[derive(Clone, Copy)]
struct Block {
    from: [usize; 2],
    to: [usize; 2],
}

impl Block {
    fn fill(&self, gap: &dyn Gap, grid: &Grid, of: &dyn Fn(&dyn Gap, usize, usize) -> f64, values: &mut [f64]) {
        let Self { from, to } = *self;
        let axis = usize::from(to[1] - from[1] > to[0] - from[0]);
        let composed = gap.is_composed();
        let rect = || grid.cell(from[0], from[1]).union(&grid.cell(to[0] - 1, to[1] - 1));
        let simpler = if composed { gap.restricted(&rect()) } else { None };
        let gap = simpler.as_ref().map_or(gap, |simpler| simpler);
        if composed && to[axis] - from[axis] > SMALLEST {
            let middle = from[axis].midpoint(to[axis]);
            let (mut low, mut high) = (*self, *self);
            (low.to[axis], high.from[axis]) = (middle, middle);
            low.fill(gap, grid, of, values);
            high.fill(gap, grid, of, values);
            return;
        }
        for j in from[1]..to[1] {
            for i in from[0]..to[0] {
                values[j * grid.shape[0] + i] = of(gap, i, j);
            }
        }
    }
}
