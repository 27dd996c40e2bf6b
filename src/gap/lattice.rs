//! A gap in every cell of a grid.
//!
//! A gap of many parts is restricted to those that matter, block by block, so that the whole takes of the order of n log n in their
//! number.

use std::convert::Infallible;

use super::Gap;
use crate::grid::Grid;

/// Cells along a side of the smallest block.
const SMALLEST: usize = 8;

/// The gap at the centre of each cell, x fastest.
pub(crate) fn values(gap: &dyn Gap, grid: &Grid) -> Vec<f64> {
    centres(gap, grid, &|| Ok(())).unwrap_or_else(|never: Infallible| match never {})
}

/// As [`values`]; `before` is asked before each row of a block and may end it.
pub(crate) fn centres<E>(gap: &dyn Gap, grid: &Grid, before: &dyn Fn() -> Result<(), E>) -> Result<Vec<f64>, E> {
    let of = |gap: &dyn Gap, i, j| {
        let [x, y] = grid.centre(i, j);
        gap.gap(x, y)
    };
    in_cells(gap, grid, &of, before)
}

/// The mean of the gap over each cell, x fastest; `before` as in [`centres`].
pub(crate) fn means<E>(gap: &dyn Gap, grid: &Grid, before: &dyn Fn() -> Result<(), E>) -> Result<Vec<f64>, E> {
    in_cells(gap, grid, &|gap, i, j| gap.mean(&grid.cell(i, j)), before)
}

/// A number of one cell of a gap.
type OfCell<'a> = dyn Fn(&dyn Gap, usize, usize) -> f64 + 'a;

fn in_cells<E>(gap: &dyn Gap, grid: &Grid, of: &OfCell, before: &dyn Fn() -> Result<(), E>) -> Result<Vec<f64>, E> {
    let mut values = vec![f64::INFINITY; grid.len()];
    if grid.is_empty() {
        return Ok(values);
    }
    let ([nx, ny], mirrored) = (grid.shape, mirrored(gap, grid));
    let from = [0, 1].map(|m| if mirrored[m] { grid.shape[m] / 2 } else { 0 });
    Block { from, to: grid.shape }.fill(gap, grid, of, before, &mut values)?;
    if mirrored[0] {
        for row in values.chunks_exact_mut(nx) {
            (0..nx / 2).for_each(|i| row[i] = row[nx - 1 - i]);
        }
    }
    if mirrored[1] {
        (0..ny / 2).for_each(|j| values.copy_within((ny - 1 - j) * nx..(ny - j) * nx, j * nx));
    }
    Ok(values)
}

/// Along which axes the gap is its own image in the middle of the grid.
fn mirrored(gap: &dyn Gap, grid: &Grid) -> [bool; 2] {
    let known = gap.describe();
    [0, 1].map(|m| known.mirrors[m] && grid.is_centred_on(m, known.centre[m]))
}

/// Cells from a corner to another, the second one beyond the last.
#[derive(Clone, Copy)]
struct Block {
    from: [usize; 2],
    to: [usize; 2],
}

impl Block {
    fn fill<E>(
        &self,
        gap: &dyn Gap,
        grid: &Grid,
        of: &OfCell,
        before: &dyn Fn() -> Result<(), E>,
        values: &mut [f64],
    ) -> Result<(), E> {
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
            low.fill(gap, grid, of, before, values)?;
            return high.fill(gap, grid, of, before, values);
        }
        for j in from[1]..to[1] {
            before()?;
            for i in from[0]..to[0] {
                values[j * grid.shape[0] + i] = of(gap, i, j);
            }
        }
        Ok(())
    }
}
