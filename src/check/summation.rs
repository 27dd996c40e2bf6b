//! Displacement by direct summation: no transform, no lattice, no closed form of Love's.
//!
//! Near a point every cell counts by itself, as a polygon integrated edge by edge (Wilton et al., IEEE Trans. Antennas Propag. 32
//! (1984) 276). Further out blocks of cells count by their moments: in the plane, with points as complex numbers,
//!
//! ```text
//! 1/|w - z| = |w|^-1 sum over k, j of c_k c_j (z/w)^k conj(z/w)^j,   c_k = (2k choose k)/4^k
//! ```

use std::f64::consts::FRAC_1_PI;

use rustfft::num_complex::Complex64;

use super::one_cell::{mean_over_cell, of_cell};
use crate::grid::Grid;
use crate::threads::each_here;

/// Largest k + j.
const ORDER: usize = 6;

/// Terms with k >= j; the others are their conjugates.
const TERMS: usize = 16;

/// Size of a block over its distance, up to which its moments serve: what is left out is below 1e-6 of its share.
const OPENING: f64 = 0.24;

/// Cells along the smallest block.
const BLOCK: usize = 8;

/// Where in each cell the displacement is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Receiver {
    /// At this share of its sides, from the lower left corner.
    Point([f64; 2]),
    /// As mean over the cell.
    Mean,
}

/// Pressure (E* = 1) on a grid, ready to be summed.
pub(super) struct Summation<'a> {
    grid: &'a Grid,
    pressure: &'a [f64],
    /// The longer side of the grid: the unit of length here.
    unit: f64,
    h: [f64; 2],
}

/// Displacement by unit pressure on the cells around one, for any pressure on a grid.
pub(super) struct Near {
    receiver: Receiver,
    /// Offsets up to these, in cells.
    half: [usize; 2],
    table: Vec<f64>,
}

struct Block {
    centre: [f64; 2],
    radius: f64,
    moments: [Complex64; TERMS],
}

/// Blocks of one size, x fastest; `None` without load.
struct Level {
    cells: usize,
    shape: [usize; 2],
    blocks: Vec<Option<Block>>,
}

impl<'a> Summation<'a> {
    pub fn new(grid: &'a Grid, pressure: &'a [f64]) -> Self {
        let [w, h] = grid.extent().size();
        let unit = w.max(h);
        Self { grid, pressure, unit, h: grid.spacing.map(|h| h / unit) }
    }

    /// What every pressure on this grid has in common.
    pub fn near(&self, receiver: Receiver) -> Near {
        let [nx, ny] = self.grid.shape;
        let leaf = 0.5 * BLOCK as f64 * self.h[0].hypot(self.h[1]);
        let near = self.h.map(|h| ((leaf / OPENING / h).ceil() as usize).saturating_add(2 * BLOCK));
        let half = [near[0].min(nx), near[1].min(ny)];
        Near { receiver, half, table: self.table(receiver, half) }
    }

    /// Displacement in every wanted cell, in the unit of the grid; zero in the others.
    pub fn in_cells(&self, receiver: Receiver, wanted: &[bool]) -> Vec<f64> {
        self.in_cells_with(&self.near(receiver), wanted)
    }

    /// The same with what is known of the grid.
    pub fn in_cells_with(&self, near: &Near, wanted: &[bool]) -> Vec<f64> {
        let &Near { receiver, half, ref table } = near;
        let levels = self.levels(receiver);
        let [nx, ny] = self.grid.shape;
        let width = 2 * half[0] + 1;
        let shift = match receiver {
            Receiver::Point(at) => at,
            Receiver::Mean => [0.5; 2],
        };
        // The rows of one row of blocks.
        let strip = |&bj: &usize| {
            let rows = bj..(bj + BLOCK).min(ny);
            let mut u = vec![0.0; nx * rows.len()];
            for bi in (0..nx).step_by(BLOCK) {
                let columns = bi..(bi + BLOCK).min(nx);
                if !rows.clone().any(|j| columns.clone().any(|i| wanted[j * nx + i])) {
                    continue;
                }
                let low = [bi as f64 * self.h[0], bj as f64 * self.h[1]];
                let high = [columns.end as f64 * self.h[0], rows.end as f64 * self.h[1]];
                let (mut far, mut close) = (Vec::new(), Vec::new());
                sort(&levels, low, high, &mut far, &mut close);
                for j in rows.clone() {
                    for i in columns.clone().filter(|i| wanted[j * nx + i]) {
                        let at = [(i as f64 + shift[0]) * self.h[0], (j as f64 + shift[1]) * self.h[1]];
                        let mut sum: f64 = far.iter().map(|block| block.at(at)).sum();
                        for &[ci, cj] in &close {
                            let end = (ci + BLOCK).min(nx);
                            for b in cj..(cj + BLOCK).min(ny) {
                                let row = &self.pressure[b * nx + ci..b * nx + end];
                                // Offsets fall as the column rises.
                                let first = (j + half[1] - b) * width + i + half[0] - ci;
                                let weights = table[first + 1 - row.len()..=first].iter().rev();
                                sum += row.iter().zip(weights).map(|(p, w)| p * w).sum::<f64>();
                            }
                        }
                        u[(j - bj) * nx + i] = sum * self.unit;
                    }
                }
            }
            u
        };
        let starts: Vec<usize> = (0..ny).step_by(BLOCK).collect();
        each_here(&starts, strip).concat()
    }

    /// Displacement at some points, anywhere.
    pub fn at(&self, points: &[[f64; 2]]) -> Vec<f64> {
        let levels = self.levels(Receiver::Point([0.5; 2]));
        let [nx, ny] = self.grid.shape;
        let displacement = |point: &[f64; 2]| {
            let at = [0, 1].map(|m| (point[m] - self.grid.origin[m]) / self.unit);
            let (mut far, mut close) = (Vec::new(), Vec::new());
            sort(&levels, at, at, &mut far, &mut close);
            let mut sum: f64 = far.iter().map(|block| block.at(at)).sum();
            for [ci, cj] in close {
                for b in cj..(cj + BLOCK).min(ny) {
                    for a in (ci..(ci + BLOCK).min(nx)).filter(|a| self.pressure[b * nx + a] != 0.0) {
                        let from = [at[0] - (a as f64 + 0.5) * self.h[0], at[1] - (b as f64 + 0.5) * self.h[1]];
                        sum += self.pressure[b * nx + a] * of_cell(self.h, from);
                    }
                }
            }
            sum * self.unit
        };
        points.iter().map(displacement).collect()
    }

    /// Displacement by unit pressure on the cell at every offset (receiver less source), x fastest.
    fn table(&self, receiver: Receiver, half: [usize; 2]) -> Vec<f64> {
        let [x, y] = half.map(|n| n as i64);
        let mut table = Vec::with_capacity(((2 * x + 1) * (2 * y + 1)) as usize);
        for j in -y..=y {
            for i in -x..=x {
                let middle = [i as f64 * self.h[0], j as f64 * self.h[1]];
                table.push(match receiver {
                    Receiver::Point(at) => of_cell(self.h, [0, 1].map(|m| middle[m] + (at[m] - 0.5) * self.h[m])),
                    Receiver::Mean if i < 0 || j < 0 => 0.0,
                    Receiver::Mean => mean_over_cell(self.h, middle),
                });
            }
        }
        if receiver == Receiver::Mean {
            // The mean is even in both offsets.
            let width = 2 * x + 1;
            let place = |i: i64, j: i64| ((j + y) * width + i + x) as usize;
            for j in -y..=y {
                for i in -x..=x {
                    table[place(i, j)] = table[place(i.abs(), j.abs())];
                }
            }
        }
        table
    }

    fn levels(&self, receiver: Receiver) -> Vec<Level> {
        let [nx, ny] = self.grid.shape;
        // Two points a side with the second moment of the cell; of a cell seen from a cell twice that.
        let apart = match receiver {
            Receiver::Point(_) => 1.0 / 12f64.sqrt(),
            Receiver::Mean => 1.0 / 6f64.sqrt(),
        };
        let share = 0.25 * self.h[0] * self.h[1];
        let mut levels = Vec::new();
        let mut cells = BLOCK;
        loop {
            let shape = [nx.div_ceil(cells), ny.div_ceil(cells)];
            let mut blocks = Vec::with_capacity(shape[0] * shape[1]);
            for bj in 0..shape[1] {
                for bi in 0..shape[0] {
                    let (rows, columns) =
                        (bj * cells..((bj + 1) * cells).min(ny), bi * cells..((bi + 1) * cells).min(nx));
                    let middle = [columns.start + columns.end, rows.start + rows.end];
                    let centre = [0, 1].map(|m| 0.5 * middle[m] as f64 * self.h[m]);
                    let radius = 0.5 * (columns.len() as f64 * self.h[0]).hypot(rows.len() as f64 * self.h[1]);
                    let mut moments = [Complex64::default(); TERMS];
                    let mut loaded = false;
                    for j in rows {
                        for i in columns.clone().filter(|i| self.pressure[j * nx + i] != 0.0) {
                            loaded = true;
                            for (s, t) in [(-apart, -apart), (apart, -apart), (-apart, apart), (apart, apart)] {
                                let x = (i as f64 + 0.5 + s) * self.h[0] - centre[0];
                                let y = (j as f64 + 0.5 + t) * self.h[1] - centre[1];
                                gather(&mut moments, Complex64::new(x, y), share * self.pressure[j * nx + i]);
                            }
                        }
                    }
                    blocks.push(loaded.then(|| Block { centre, radius, moments: weighted(moments) }));
                }
            }
            levels.push(Level { cells, shape, blocks });
            if shape[0].max(shape[1]) <= 4 {
                return levels;
            }
            cells *= 2;
        }
    }
}

/// The terms (k, j), k >= j, k + j <= ORDER.
fn terms() -> impl Iterator<Item = (usize, usize)> {
    (0..=ORDER).flat_map(|n| (0..=n / 2).map(move |j| (n - j, j)))
}

fn gather(moments: &mut [Complex64; TERMS], z: Complex64, load: f64) {
    let mut powers = [Complex64::new(load, 0.0); ORDER + 1];
    for k in 1..=ORDER {
        powers[k] = powers[k - 1] * z;
    }
    let square = z.norm_sqr();
    let mut squares = [1.0; ORDER / 2 + 1];
    for k in 1..squares.len() {
        squares[k] = squares[k - 1] * square;
    }
    // z^k conj(z)^j = |z|^2j z^(k - j).
    for (moment, (k, j)) in moments.iter_mut().zip(terms()) {
        *moment += powers[k - j] * squares[j];
    }
}

/// c_k c_j, twice where the conjugate term has no place of its own.
fn weighted(mut moments: [Complex64; TERMS]) -> [Complex64; TERMS] {
    let mut c = [1.0; ORDER + 1];
    for k in 1..=ORDER {
        c[k] = c[k - 1] * (2 * k - 1) as f64 / (2 * k) as f64;
    }
    for (moment, (k, j)) in moments.iter_mut().zip(terms()) {
        *moment *= c[k] * c[j] * if k == j { 1.0 } else { 2.0 };
    }
    moments
}

impl Block {
    fn at(&self, point: [f64; 2]) -> f64 {
        let w = Complex64::new(point[0] - self.centre[0], point[1] - self.centre[1]).inv();
        let mut powers = [Complex64::new(1.0, 0.0); ORDER + 1];
        for k in 1..=ORDER {
            powers[k] = powers[k - 1] * w;
        }
        let square = w.norm_sqr();
        let squares = [1.0, square, square * square, square * square * square];
        let mut sum = 0.0;
        let mut at = 0;
        for n in 0..=ORDER {
            for j in 0..=n / 2 {
                let (m, p) = (self.moments[at], powers[n - 2 * j]);
                sum += (m.re * p.re - m.im * p.im) * squares[j];
                at += 1;
            }
        }
        FRAC_1_PI * sum * square.sqrt()
    }
}

/// Blocks far enough from a rectangle to count by their moments, and the first cells of the smallest ones that are not.
fn sort<'l>(levels: &'l [Level], low: [f64; 2], high: [f64; 2], far: &mut Vec<&'l Block>, close: &mut Vec<[usize; 2]>) {
    let top = levels.len() - 1;
    let [nx, ny] = levels[top].shape;
    let mut left: Vec<(usize, usize, usize)> = (0..nx * ny).map(|k| (top, k % nx, k / nx)).collect();
    while let Some((level, i, j)) = left.pop() {
        let Level { cells, shape, blocks } = &levels[level];
        let Some(block) = &blocks[j * shape[0] + i] else { continue };
        let away = [0, 1].map(|m| (low[m] - block.centre[m]).max(block.centre[m] - high[m]).max(0.0));
        if block.radius <= OPENING * away[0].hypot(away[1]) {
            far.push(block);
        } else if level == 0 {
            close.push([i * cells, j * cells]);
        } else {
            let [nx, ny] = levels[level - 1].shape;
            for (a, b) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                if 2 * i + a < nx && 2 * j + b < ny {
                    left.push((level - 1, 2 * i + a, 2 * j + b));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_agree_with_the_sum_over_all_cells() {
        for (shape, spacing) in [([70, 90], [0.01, 0.01]), ([40, 120], [0.09, 0.01])] {
            let grid = Grid { origin: [-3.0, 2.0], spacing, shape };
            let p: Vec<f64> = (0..grid.len()).map(|k| ((k * 37 % 101) as f64 / 50.0 - 0.8).max(0.0)).collect();
            let summation = Summation::new(&grid, &p);
            let all = vec![true; grid.len()];
            let point = [0.31, 0.77];
            let (u, mean) =
                (summation.in_cells(Receiver::Point(point), &all), summation.in_cells(Receiver::Mean, &all));
            for k in [0, 17, 1234, 3000, grid.len() - 1] {
                let (i, j) = (k % shape[0], k / shape[0]);
                let at = [0, 1].map(|m| grid.origin[m] + ([i, j][m] as f64 + point[m]) * spacing[m]);
                let sum = |f: &dyn Fn([f64; 2]) -> f64| {
                    (0..grid.len()).map(|c| (grid.centre_of(c), p[c])).map(|(c, p)| p * f(c)).sum::<f64>()
                };
                let direct = sum(&|c| of_cell(spacing, [at[0] - c[0], at[1] - c[1]]));
                assert!((u[k] / direct - 1.0).abs() < 2e-7, "{k}: {} {direct}", u[k]);
                assert!((summation.at(&[at])[0] / direct - 1.0).abs() < 1e-6);
                let c0 = grid.centre_of(k);
                let direct = sum(&|c| mean_over_cell(spacing, [c0[0] - c[0], c0[1] - c[1]]));
                assert!((mean[k] / direct - 1.0).abs() < 2e-7, "{k}: {} {direct}", mean[k]);
            }
        }
    }
}
