//! The box around the cells that overlap, cut out of the grid of the problem.

use std::ops::Range;

use super::Cells;
use crate::discrete::Discrete;
use crate::influence::InfluenceTable;

/// The box around the cells that overlap. Where they have a mirror, half of it, laid with the mirror below its first row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Its first cell in the grid of the problem; cells before or behind the grid overlap nothing.
    corner: [isize; 2],
    /// Number of cells along the rows and across them, both halves of a mirrored window counted.
    pub(super) extent: [usize; 2],
    /// Rows of the window are columns of the problem.
    pub(super) transposed: bool,
    /// The upper half stands for both.
    pub(super) mirrored: bool,
    /// The largest overlap.
    pub(super) deepest: f64,
}

impl Window {
    /// `None` when no cell overlaps. Overlaps that differ by less than `same` of the largest are not told apart.
    pub(super) fn of(problem: &Discrete, same: f64) -> Option<Self> {
        let [nx, _] = problem.grid.shape;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let mut deepest = f64::NEG_INFINITY;
        for (j, row) in problem.overlap.chunks_exact(nx.max(1)).enumerate() {
            let Some(first) = row.iter().position(|&f| f > 0.0) else { continue };
            let last = row.iter().rposition(|&f| f > 0.0).unwrap_or(first);
            low = [low[0].min(first), low[1].min(j)];
            high = [high[0].max(last + 1), j + 1];
            deepest = row[first..=last].iter().fold(deepest, |m, f| if *f > m { *f } else { m });
        }
        if low[0] == usize::MAX {
            return None;
        }
        let extent = [high[0] - low[0], high[1] - low[1]];
        let corner = low.map(|n| n as isize);
        let mut window = Self { corner, extent, transposed: false, mirrored: false, deepest };
        let same = same * deepest;
        let f = &problem.overlap;
        let alike = |a: usize, b: usize| (f[a] - f[b]).abs() <= same || (f[a] <= 0.0 && f[b] <= 0.0);
        window.mirrored = extent[1].is_multiple_of(2) && window.symmetric(problem.grid.shape, alike);
        if !window.mirrored && extent[0].is_multiple_of(2) {
            let turned = Self { extent: [extent[1], extent[0]], transposed: true, mirrored: true, ..window };
            if turned.symmetric(problem.grid.shape, alike) {
                return Some(turned);
            }
        }
        Some(window)
    }

    /// Whether all cells are like their images in a mirror in the middle of the window.
    pub(super) fn symmetric(&self, shape: [usize; 2], alike: impl Fn(usize, usize) -> bool) -> bool {
        let [nx, ny] = self.extent;
        (0..ny / 2).all(|j| match [j, ny - 1 - j].map(|j| self.row(shape, j)) {
            [Some(row), Some(image)] => row.zip(image).all(|(cell, image)| alike(cell, image)),
            _ => (0..nx).all(|i| match [j, ny - 1 - j].map(|j| self.index(shape, i, j)) {
                [Some(cell), Some(image)] => alike(cell, image),
                _ => false,
            }),
        })
    }

    /// Both halves for themselves.
    pub(super) fn unfold(&mut self) {
        if self.transposed {
            self.extent.reverse();
        }
        (self.transposed, self.mirrored) = (false, false);
    }

    /// The same middle, `extent` cells: no fewer than there are, and of the same parity across a mirror.
    pub(super) fn widened(&self, extent: [usize; 2]) -> Self {
        let before = [0, 1].map(|k| ((extent[k] - self.extent[k]) / 2) as isize);
        let [x, y] = if self.transposed { [before[1], before[0]] } else { before };
        Self { corner: [self.corner[0] - x, self.corner[1] - y], extent, ..*self }
    }

    /// Place of cell i of row j of the window in a field on a grid of this shape.
    fn index(&self, [width, height]: [usize; 2], i: usize, j: usize) -> Option<usize> {
        let [i, j] = if self.transposed { [j, i] } else { [i, j] };
        let x = self.corner[0].checked_add_unsigned(i).and_then(|x| usize::try_from(x).ok()).filter(|&x| x < width)?;
        let y = self.corner[1].checked_add_unsigned(j).and_then(|y| usize::try_from(y).ok()).filter(|&y| y < height)?;
        Some(y * width + x)
    }

    /// Places of row j of the window, where they lie side by side in a field on a grid of this shape.
    fn row(&self, shape: [usize; 2], j: usize) -> Option<Range<usize>> {
        let ends =
            if self.transposed { None } else { self.index(shape, 0, j).zip(self.index(shape, self.extent[0] - 1, j)) };
        ends.map(|(first, last)| first..last + 1)
    }

    /// Cells that are solved for.
    pub(super) fn shape(&self) -> [usize; 2] {
        [self.extent[0], if self.mirrored { self.extent[1] / 2 } else { self.extent[1] }]
    }

    /// The part of a field on a grid of this shape that lies in the window, `outside` beyond the grid; of a mirrored one the mean
    /// of the halves.
    pub(super) fn cut(&self, shape: [usize; 2], field: &[f64], outside: f64) -> Vec<f64> {
        let ([nx, ny], height) = (self.shape(), self.extent[1]);
        let mut part = Vec::with_capacity(nx * ny);
        let at = |i: usize, j: usize| self.index(shape, i, j).map_or(outside, |k| field[k]);
        for upper in height - ny..height {
            let lower = height - 1 - upper;
            match [upper, lower].map(|j| self.row(shape, j)) {
                [Some(row), Some(image)] if self.mirrored => {
                    part.extend(field[row].iter().zip(&field[image]).map(|(a, b)| 0.5 * (a + b)));
                }
                [Some(row), _] if !self.mirrored => part.extend_from_slice(&field[row]),
                _ if self.mirrored => part.extend((0..nx).map(|i| 0.5 * (at(i, upper) + at(i, lower)))),
                _ => part.extend((0..nx).map(|i| at(i, upper))),
            }
        }
        part
    }

    /// The field on the whole grid, zero around the window.
    pub(super) fn paste(&self, shape: [usize; 2], part: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; shape[0] * shape[1]];
        let (nx, height) = (self.extent[0], self.extent[1]);
        let below = height - self.shape()[1];
        for j in 0..height {
            let row = if j >= below { j - below } else { below - 1 - j };
            let values = &part[row * nx..(row + 1) * nx];
            if let Some(places) = self.row(shape, j) {
                field[places].copy_from_slice(values);
                continue;
            }
            for (i, &value) in values.iter().enumerate() {
                if let Some(k) = self.index(shape, i, j) {
                    field[k] = value;
                }
            }
        }
        field
    }

    /// Influence coefficients for all offsets in the window.
    pub(super) fn table(&self, problem: &Discrete) -> InfluenceTable {
        let [hx, hy] = problem.grid.spacing;
        InfluenceTable::new(problem.kernel, if self.transposed { [hy, hx] } else { [hx, hy] }, self.extent)
    }

    /// The window as a grid to be solved on.
    pub(super) fn grid(&self, problem: &Discrete) -> Cells {
        let mut overlap = self.cut(problem.grid.shape, &problem.overlap, f64::NEG_INFINITY);
        // With finite numbers u = f - (f - u) is not lost.
        overlap.iter_mut().for_each(|f| *f = (*f / self.deepest).max(-1.0));
        Cells { shape: self.shape(), mirrored: self.mirrored, overlap, load: None }
    }
}
