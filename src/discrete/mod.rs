//! The contact problem on a grid: one overlap a cell, and the residuals that any pressure leaves.

pub mod symmetry;

use std::convert::Infallible;

use crate::clock::{Deadline, OutOfTime};
use crate::gap::{Gap, lattice};
use crate::grid::{Grid, Kernel};
use crate::solution::Residuals;

/// Find p >= 0 with A p >= f, p (A p - f) = 0 on the cells of a grid (E* = 1). What every grid solver solves.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete {
    /// The cells.
    pub grid: Grid,
    /// Whether f and A are means over cells or values at their centres.
    pub kernel: Kernel,
    /// f = depth - gap in each cell. Cells with f <= 0 (minus infinity where there is no material) never carry
    /// pressure, whatever the load: A p > 0 everywhere as soon as any p is positive.
    pub overlap: Vec<f64>,
}

impl Discrete {
    /// The overlap of `gap` at this depth, cell by cell.
    #[must_use]
    pub fn sample(gap: &dyn Gap, depth: f64, grid: Grid, kernel: Kernel) -> Self {
        Self::sampled(gap, depth, grid, kernel, || Ok(())).unwrap_or_else(|never: Infallible| match never {})
    }

    /// As [`Discrete::sample`], stopped at the deadline: a gap may be dear.
    ///
    /// # Errors
    /// [`OutOfTime`].
    pub fn sample_before(
        gap: &dyn Gap,
        depth: f64,
        grid: Grid,
        kernel: Kernel,
        deadline: Deadline,
    ) -> Result<Self, OutOfTime> {
        Self::sampled(gap, depth, grid, kernel, || deadline.check())
    }

    /// `before` is asked before each row of a block.
    fn sampled<E>(
        gap: &dyn Gap,
        depth: f64,
        grid: Grid,
        kernel: Kernel,
        before: impl Fn() -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut overlap = match kernel {
            Kernel::Galerkin => lattice::means(gap, &grid, &before)?,
            Kernel::Collocation => lattice::centres(gap, &grid, &before)?,
        };
        overlap.iter_mut().for_each(|gap| *gap = depth - *gap);
        Ok(Self { grid, kernel, overlap })
    }

    /// The same, deeper by `by`.
    #[must_use]
    pub fn deeper(&self, by: f64) -> Self {
        Self { overlap: self.overlap.iter().map(|f| f + by).collect(), ..*self }
    }

    /// The largest overlap; what gaps and penetrations are measured against. Not positive: there is no contact.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        self.overlap.iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Residuals of the pressure `p` whose displacement is `u`.
    #[must_use]
    pub fn residuals(&self, p: &[f64], u: &[f64]) -> Residuals {
        let (deepest, strongest) = (self.deepest(), p.iter().copied().fold(0.0, f64::max));
        let mut worst = Residuals { complementarity: 0.0, tension: 0.0, penetration: 0.0 };
        if deepest <= 0.0 {
            return worst;
        }
        for ((&p, &u), &f) in p.iter().zip(u).zip(&self.overlap) {
            let penetration = (f - u) / deepest;
            worst.penetration = worst.penetration.max(penetration);
            if strongest > 0.0 && p != 0.0 {
                worst.tension = worst.tension.max(-p / strongest);
                worst.complementarity = worst.complementarity.max((p / strongest * penetration).abs());
            }
        }
        worst
    }
}

/// What a grid solver returns: the pressure, the residuals it leaves, and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteSolution {
    /// Pressure in each cell of the grid.
    pub pressure: Vec<f64>,
    /// Displacement A p in each cell of the grid.
    pub displacement: Vec<f64>,
    /// Recomputed from pressure and displacement.
    pub residuals: Residuals,
    /// Cells that carried an unknown.
    pub unknowns: usize,
    /// Iterations of the solver on this grid.
    pub iterations: usize,
    /// Products with the compliance operator on this grid.
    pub operator_products: usize,
    /// How many of them were in single precision.
    pub single_precision: usize,
}
