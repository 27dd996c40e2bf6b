//! The coefficients of every offset of a grid.

use std::f64::consts::FRAC_1_PI;
use std::sync::OnceLock;

use super::love::Corners;
use super::{Series, coefficient_by, far, scaled};
use crate::grid::Kernel;

/// Offsets of square cells that the series does not reach.
const NEAR: usize = far::SERIES as usize;

/// What tables of square cells have in common.
struct Squares {
    series: Series,
    /// Coefficients of cells near each other, row by row: the dear ones.
    near: [[f64; NEAR]; NEAR],
}

/// Computed once.
fn squares(kernel: Kernel) -> &'static Squares {
    static KNOWN: [OnceLock<Squares>; 2] = [const { OnceLock::new() }; 2];
    KNOWN[usize::from(kernel == Kernel::Galerkin)].get_or_init(|| {
        let h = [1.0; 2];
        let series = Series::new(kernel, h);
        let mut corners = Corners::default();
        let mut of =
            |i: usize, j: usize| coefficient_by(&series, kernel, h, [i.max(j) as i64, i.min(j) as i64], &mut corners);
        let near = std::array::from_fn(|j| std::array::from_fn(|i| of(i, j)));
        Squares { series, near }
    })
}

/// Influence coefficients for offsets 0..nx, 0..ny; the rest follows from symmetry.
///
/// A coefficient depends on the offset in cells and on the aspect ratio of the cell, and is proportional to the size of
/// the cell: the table of the finest of a sequence of nested grids serves all of them, through [`InfluenceTable::scale`].
///
/// ```
/// use contact_patch::{InfluenceTable, Kernel};
///
/// let table = InfluenceTable::new(Kernel::Collocation, [0.5, 0.5], [8, 8]);
/// // Centre of a loaded unit square: 4 asinh(1)/pi (Love 1929); half of it for a square of half the side.
/// assert!((table.get(0, 0) - 2.0 * 1f64.asinh() / std::f64::consts::PI).abs() < 1e-15);
/// ```
#[derive(Debug, Clone)]
pub struct InfluenceTable {
    kernel: Kernel,
    spacing: [f64; 2],
    shape: [usize; 2],
    /// Coefficients for a cell whose longer side is 1, offset along x fastest.
    values: Vec<f64>,
}

impl InfluenceTable {
    /// Coefficients for cells of these sides (positive) at offsets below `shape`.
    #[must_use]
    pub fn new(kernel: Kernel, spacing: [f64; 2], shape: [usize; 2]) -> Self {
        let [nx, ny] = shape;
        let (h, _) = scaled(spacing);
        let mut values = vec![0.0; nx * ny];
        let mut corners = Corners::default();
        let square = h[0] == h[1];
        let known = square.then(|| squares(kernel));
        let series = known.map_or_else(|| Series::new(kernel, h), |known| known.series.clone());
        // The series holds outside a circle; inside, one offset at a time. Of a square cell one octant is enough.
        let inside = far::SERIES;
        for j in 0..ny {
            let y = j as f64 * h[1];
            let row = &mut values[j * nx..(j + 1) * nx];
            let near = if y >= inside { 0.0 } else { ((inside * inside - y * y).sqrt() / h[0]).ceil() };
            let near = (near as usize).min(nx);
            let octant = if square { j.min(nx) } else { 0 };
            for (i, value) in row.iter_mut().enumerate().take(near).skip(octant) {
                *value = match known {
                    Some(known) => known.near[j][i],
                    None => coefficient_by(&series, kernel, h, [i as i64, j as i64], &mut corners),
                };
            }
            series.row(h, y, near.max(octant), row, FRAC_1_PI);
        }
        if square {
            for j in 1..ny {
                for i in 0..j.min(nx) {
                    values[j * nx + i] = if j < nx && i < ny {
                        values[i * nx + j]
                    } else {
                        coefficient_by(&series, kernel, h, [i as i64, j as i64], &mut corners)
                    };
                }
            }
        }
        Self { kernel, spacing, shape, values }
    }

    /// The kernel.
    #[must_use]
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Sides of the cell that [`InfluenceTable::get`] speaks of.
    #[must_use]
    pub fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// Number of offsets along x and y.
    #[must_use]
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// Displacement per unit pressure, E* = 1, at an offset of (i, j) cells, both less than the shape.
    #[must_use]
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.values[j * self.shape[0] + i] * self.spacing[0].max(self.spacing[1])
    }

    /// The same for cells of the same aspect ratio: what a row of [`InfluenceTable::row`] is multiplied by.
    #[must_use]
    pub fn scale(spacing: [f64; 2]) -> f64 {
        spacing[0].max(spacing[1])
    }

    /// The coefficients at offset j along y for a cell whose longer side is 1.
    #[must_use]
    pub fn row(&self, j: usize) -> &[f64] {
        &self.values[j * self.shape[0]..(j + 1) * self.shape[0]]
    }
}
