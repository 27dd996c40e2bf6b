//! A pressure on a grid and the cell means of its displacement, with a frame around both.

use std::sync::Arc;

use super::basis::NODES;
use super::lane::LANES;
use super::pressed;
use super::tables::Tables;
use crate::grid::{Grid, Kernel};
use crate::influence::InfluenceTable;
use crate::matrix_free::{Operator, Scratch};
use crate::numeric::geometry::Rect;

/// Cells around the grid that are looked at like those of the grid.
pub(super) const RING: usize = 1;

/// What lanes read beyond the frame of the last cell of a row.
const BEYOND: usize = 2 * LANES;

/// Relative error of influence coefficients that every bound allows for: ten times what is stated for them.
pub(super) const COEFFICIENTS: f64 = 1e-11;

/// Pressures p and displacements u = S p; lengths in longer sides of a cell, E* = 1.
#[derive(Debug, Clone)]
pub(super) struct Field {
    pub tables: Arc<Tables>,
    pub grid: Grid,
    /// The first cell of the grid that this one is a part of, and which cell of that its own first is: cells have one place, to the last digit.
    lattice: ([f64; 2], [isize; 2]),
    /// The longer side of a cell.
    pub scale: f64,
    /// Pressures with a frame, and its width.
    p: Vec<f64>,
    p_frame: [usize; 2],
    /// Cell means of u with a frame; NaN where they are not known.
    u: Vec<f64>,
    u_frame: [usize; 2],
    /// Bound of the error of each of them.
    pub rounding: f64,
    /// Roots of the sums of squares of the differences of neighbours along x and along y.
    pub differences: [f64; 2],
    /// Largest |p|.
    pub strongest: f64,
}

/// Rows as wide as `width`, with a frame that also holds what lanes read beyond the last cell.
fn framed(
    field: &[f64],
    shape: [usize; 2],
    from: [isize; 2],
    frame: [usize; 2],
    grid: [usize; 2],
    fill: f64,
) -> Vec<f64> {
    let (width, height) = (grid[0] + 2 * frame[0] + BEYOND, grid[1] + 2 * frame[1]);
    let mut to = vec![fill; width * height];
    for (y, row) in field.chunks_exact(shape[0]).enumerate() {
        let first = (y as isize + from[1] + frame[1] as isize) as usize * width;
        let first = first + (from[0] + frame[0] as isize) as usize;
        to[first..first + shape[0]].copy_from_slice(row);
    }
    to
}

impl Field {
    /// With the displacement worked out; `None` for cells that are too slender ([`super::tables::MOST_SLENDER`]).
    pub fn new(grid: &Grid, p: &[f64]) -> Option<Self> {
        let mut field = Self::without_displacement(grid, p)?;
        let [a, b] = field.u_frame;
        let wide = [grid.shape[0] + 2 * a, grid.shape[1] + 2 * b];
        let table = InfluenceTable::new(Kernel::Galerkin, grid.spacing, wide);
        let mut loaded = vec![0.0; wide[0] * wide[1]];
        for (j, row) in p.chunks_exact(grid.shape[0]).enumerate() {
            loaded[(j + b) * wide[0] + a..][..grid.shape[0]].copy_from_slice(row);
        }
        let mut u = vec![0.0; loaded.len()];
        let operator = Operator::compliance(&table, grid.spacing, wide);
        operator.apply(&loaded, b..b + grid.shape[1], &mut u, 0..wide[1], &mut Scratch::new());
        u.iter_mut().for_each(|u| *u /= field.scale);
        field.u = framed(&u, wide, [-(a as isize), -(b as isize)], field.u_frame, grid.shape, f64::NAN);
        field.estimate_rounding(p);
        Some(field)
    }

    /// With the displacement as a solver returned it: the cell means of S p by one product in double precision, and 0 where they
    /// are not known.
    pub fn known(grid: &Grid, p: &[f64], displacement: &[f64]) -> Option<Self> {
        let mut field = Self::without_displacement(grid, p)?;
        let u: Vec<f64> = displacement.iter().map(|u| if *u == 0.0 { f64::NAN } else { u / field.scale }).collect();
        field.u = framed(&u, grid.shape, [0; 2], field.u_frame, grid.shape, f64::NAN);
        field.estimate_rounding(p);
        Some(field)
    }

    fn without_displacement(grid: &Grid, p: &[f64]) -> Option<Self> {
        let tables = Tables::of(grid.spacing)?;
        let p_frame = tables.near.map(|n| n + RING);
        let [nx, ny] = grid.shape;
        let mut differences = [0.0; 2];
        for j in 0..ny {
            let row = &p[j * nx..(j + 1) * nx];
            let steps = row.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
            differences[0] += steps + row[0] * row[0] + row[nx - 1] * row[nx - 1];
        }
        let ends = p[..nx].iter().chain(&p[(ny - 1) * nx..]).map(|p| p * p).sum::<f64>();
        differences[1] = ends + p.iter().zip(&p[nx..]).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
        Some(Self {
            grid: *grid,
            lattice: (grid.origin, [0; 2]),
            scale: grid.spacing[0].max(grid.spacing[1]),
            p: framed(p, grid.shape, [0; 2], p_frame, grid.shape, 0.0),
            p_frame,
            u: Vec::new(),
            u_frame: [NODES + RING; 2],
            rounding: 0.0,
            differences: differences.map(|d| d.sqrt() * (1.0 + 1e-12)),
            strongest: p.iter().fold(0.0, |m, p| p.abs().max(m)),
            tables,
        })
    }

    /// On a part of the grid of another one, whose cell `first` is its own first.
    pub fn part_of(self, whole: &Self, first: [isize; 2]) -> Self {
        let (origin, before) = whole.lattice;
        Self { lattice: (origin, [0, 1].map(|m| before[m] + first[m])), ..self }
    }

    /// The cell (i, j), counted from the first.
    pub fn rect(&self, i: isize, j: isize) -> Rect {
        let (origin, first) = self.lattice;
        pressed::rect(&Grid { origin, ..self.grid }, first[0] + i, first[1] + j)
    }

    /// The error of a transform in the Euclidean norm is at most 7 eps log2(M) of it (Higham 2002, theorem 24.2), and three of them make
    /// a product: less than 24 eps log2(M) (|K|_1 |p|_2 + |K|_2 |p|_1), with the coefficients K of all offsets. A cell acts on all
    /// others together like no less than on those of a disc about it: |K|_1 <= 4 sqrt(w h/pi) over a box of sides w, h.
    fn estimate_rounding(&mut self, p: &[f64]) {
        let [w, h] = [0, 1].map(|m| (self.grid.shape[m] + 2 * self.u_frame[m]) as f64 * self.tables.h[m]);
        let one = 4.0 * (w * h / std::f64::consts::PI).sqrt();
        let two = (1.2 * one).sqrt();
        let norms = [p.iter().map(|p| p.abs()).sum::<f64>(), p.iter().map(|p| p * p).sum::<f64>().sqrt()];
        let points = 16.0 * (self.grid.len() as f64 + 256.0);
        let transforms = 24.0 * f64::EPSILON * points.log2() * (one * norms[1] + two * norms[0]);
        self.rounding = transforms + COEFFICIENTS * one * self.strongest;
    }

    /// The pressures of a row of cells from cell `i` on, `i` and `j` counted from the first cell of the grid.
    #[inline(always)]
    pub fn pressures(&self, i: isize, j: isize) -> &[f64] {
        let width = self.grid.shape[0] + 2 * self.p_frame[0] + BEYOND;
        let row = (j + self.p_frame[1] as isize) as usize * width;
        &self.p[row + (i + self.p_frame[0] as isize) as usize..row + width]
    }

    /// The same of the displacements.
    #[inline(always)]
    pub fn displacements(&self, i: isize, j: isize) -> &[f64] {
        let width = self.grid.shape[0] + 2 * self.u_frame[0] + BEYOND;
        let row = (j + self.u_frame[1] as isize) as usize * width;
        &self.u[row + (i + self.u_frame[0] as isize) as usize..row + width]
    }

    /// Pressure of a cell; 0 outside the grid.
    pub fn pressure(&self, i: isize, j: isize) -> f64 {
        let inside = i >= 0 && j >= 0 && i < self.grid.shape[0] as isize && j < self.grid.shape[1] as isize;
        if inside { self.pressures(i, j)[0] } else { 0.0 }
    }
}
