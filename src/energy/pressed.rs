//! The cells of a grid under pressure, those that are worked out where there are mirrors.

use super::residual::{Halves, Quarter};
use crate::grid::Grid;
use crate::numeric::geometry::Rect;

/// Cells under pressure, and those that may be besides.
pub(super) struct Pressed {
    pub grid: Grid,
    pub halves: Halves,
    /// i, j and the pressure.
    pub cells: Vec<(isize, isize, f64)>,
}

/// The cell (i, j), counted from the first of the grid.
pub(super) fn rect(grid: &Grid, i: isize, j: isize) -> Rect {
    let at = |n: isize, m: usize| grid.origin[m] + n as f64 * grid.spacing[m];
    Rect { min: [at(i, 0), at(j, 1)], max: [at(i + 1, 0), at(j + 1, 1)] }
}

/// How many cells a cell stands for.
pub(super) fn images(grid: &Grid, halves: Halves, i: isize, j: isize) -> f64 {
    let twice = |m: usize, k: isize| halves[m] && 2 * k + 1 != grid.shape[m] as isize;
    let count = |m: usize, k: isize| if twice(m, k) { 2.0 } else { 1.0 };
    count(0, i) * count(1, j)
}

impl Pressed {
    pub fn new(grid: &Grid, halves: Halves, pressure: impl Fn(usize, usize) -> f64) -> Self {
        let [nx, ny] = grid.shape;
        let first = [0, 1].map(|m| if halves[m] { grid.shape[m] / 2 } else { 0 });
        let all = (first[1]..ny).flat_map(|j| (first[0]..nx).map(move |i| (i, j)));
        let cells = all.map(|(i, j)| (i as isize, j as isize, pressure(i, j))).filter(|(_, _, p)| *p > 0.0).collect();
        Self { grid: *grid, halves, cells }
    }

    pub fn rect(&self, i: isize, j: isize) -> Rect {
        rect(&self.grid, i, j)
    }

    pub fn images(&self, i: isize, j: isize) -> f64 {
        images(&self.grid, self.halves, i, j)
    }

    /// How many there are with their images.
    pub fn count(&self) -> f64 {
        self.cells.iter().map(|(i, j, _)| self.images(*i, *j)).sum()
    }

    /// The sum of their pressures.
    pub fn force(&self) -> f64 {
        self.cells.iter().map(|(i, j, p)| p * self.images(*i, *j)).sum::<f64>() * self.grid.cell_area()
    }

    /// Force of a flat punch that is a disc of their area, at unit depth.
    pub fn disc(&self) -> f64 {
        2.0 * (self.count() * self.grid.cell_area() / std::f64::consts::PI).sqrt()
    }

    /// Cells under pressure, and every one of `touch` once: there the pressure is 0.
    pub fn with<'a>(&'a self, touch: &'a [Quarter]) -> impl Iterator<Item = (isize, isize, f64)> + 'a {
        let new = |n: usize| n == 0 || touch[n - 1].0 != touch[n].0 || touch[n - 1].1 != touch[n].1;
        let beyond = (0..touch.len()).filter(move |n| new(*n)).map(|n| (touch[n].0, touch[n].1, 0.0));
        self.cells.iter().copied().chain(beyond)
    }
}
