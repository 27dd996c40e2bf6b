//! A pressure and the displacement by it at the centres of the cells, by one product.

use std::sync::Arc;

use super::kernel::RELATIVE_ERROR;
use super::polynomial::{NODES, Polynomial};
use super::spread::spread;
use super::tables::Tables;
use crate::grid::{Grid, Kernel};
use crate::influence::InfluenceTable;
use crate::matrix_free::{Operator, Scratch};

/// The product with the displacement of a grid and a few cells around it, and the tables of its cells.
pub(super) struct Surroundings {
    shape: [usize; 2],
    scale: f64,
    operator: Operator,
    scratch: Scratch,
    /// Euclidean norm of the coefficients of all offsets.
    norm: f64,
    pub tables: Arc<Tables>,
}

impl Surroundings {
    pub fn new(grid: &Grid, per_cell: usize) -> Self {
        let wide = grid.shape.map(|n| n + 2 * NODES);
        let table = InfluenceTable::new(Kernel::Collocation, grid.spacing, wide);
        let scale = InfluenceTable::scale(grid.spacing);
        let square = |j: usize| table.row(j).iter().map(|a| a * a).sum::<f64>();
        Self {
            shape: grid.shape,
            scale,
            operator: Operator::compliance(&table, grid.spacing, wide),
            scratch: Scratch::new(),
            norm: 2.0 * scale * (0..wide[1]).map(square).sum::<f64>().sqrt(),
            tables: Tables::of(grid.spacing, per_cell),
        }
    }
}

impl Surroundings {
    /// Number of cells along x and y.
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }
}

/// A pressure and its displacement.
pub(super) struct Field {
    pub shape: [usize; 2],
    pub scale: f64,
    pub tables: Arc<Tables>,
    /// Pressure with a margin of B's half sides around it.
    pub padded: Vec<f64>,
    pub most: f64,
    /// Largest difference from the pressure of a cell within B.
    pub spread: Vec<f64>,
    /// Displacement at the centres, with a margin of NODES cells around it.
    pub wide: Vec<f64>,
    /// Rounding of a displacement, absolute; its share beside it is [`SHARE`].
    pub rounding: f64,
}

/// Relative error of coefficients, of tables and of the sums with them.
const SHARE: f64 = 2.0 * Polynomial::GROWTH * RELATIVE_ERROR;

impl Field {
    pub fn new(around: &mut Surroundings, q: &[f64]) -> Self {
        let [nx, ny] = around.shape;
        let with_margin = |[a, b]: [usize; 2]| {
            let width = nx + 2 * a;
            let mut field = vec![0.0; width * (ny + 2 * b)];
            for (j, row) in q.chunks_exact(nx).enumerate() {
                field[(j + b) * width + a..][..nx].copy_from_slice(row);
            }
            field
        };
        let loaded = with_margin([NODES; 2]);
        let mut wide = vec![0.0; loaded.len()];
        let rows = NODES..NODES + ny;
        around.operator.apply(&loaded, rows, &mut wide, 0..ny + 2 * NODES, &mut around.scratch);
        // The error of a transform in the Euclidean norm is at most a few eps log2(M) of it (Higham 2002, theorem 24.2),
        // and three of them make a product.
        let size = around.operator.length().iter().map(|&m| m as f64).product::<f64>();
        let norm = q.iter().map(|q| q * q).sum::<f64>().sqrt();
        let padded = with_margin(around.tables.block);
        Self {
            shape: around.shape,
            scale: around.scale,
            tables: around.tables.clone(),
            spread: spread(&padded, around.shape, around.tables.block),
            padded,
            most: q.iter().copied().fold(0.0, f64::max),
            wide,
            rounding: Polynomial::GROWTH * 24.0 * f64::EPSILON * size.log2() * around.norm * norm,
        }
    }

    /// At the centre of a cell.
    pub fn at_centre(&self, i: usize, j: usize) -> f64 {
        self.wide[(j + NODES) * (self.shape[0] + 2 * NODES) + i + NODES]
    }

    /// Bound of the rounding of a displacement of this size.
    pub fn rounding(&self, u: f64) -> f64 {
        self.rounding + SHARE * u.abs()
    }

    /// The block of half sides `half` about cell (i, j), row by row.
    pub fn rows(&self, i: usize, j: usize, half: [usize; 2]) -> impl Iterator<Item = &[f64]> {
        let block = self.tables.block;
        let width = self.shape[0] + 2 * block[0];
        let first = (j + block[1] - half[1]) * width + i + block[0] - half[0];
        (0..=2 * half[1]).map(move |b| &self.padded[first + b * width..][..=2 * half[0]])
    }
}
